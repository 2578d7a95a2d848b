"""Laws of the package's door: what is reachable, by which names, and at what cost."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

import varishold

HEAVY = ("scipy", "sklearn", "matplotlib", "mujoco", "click", "rich", "jinja2")
SOURCE = Path(varishold.__file__).parent
ROOMS = sorted(found.name for found in pkgutil.iter_modules(varishold.__path__) if found.ispkg)


# A process for each room, which begins where the package alone is loaded.
LOADED = """
import os, sys
import varishold
print("", *sys.modules, flush=True)
for room in sys.argv[1:]:
    if not os.fork():
        getattr(varishold, room)
        print(room, *sys.modules, flush=True)
        os._exit(0)
    os.wait()
"""


@pytest.fixture(scope="module")
def modules_of() -> dict[str, set[str]]:
    """What is loaded after a room was asked for, in a process of its own; "": after the package was."""
    done = subprocess.run([sys.executable, "-c", LOADED, *ROOMS], capture_output=True, text=True, check=True)
    lines = [line.split(" ") for line in done.stdout.splitlines()]
    return {room: set(modules) for room, *modules in lines}


def test_the_package_alone_loads_nothing_heavy(modules_of: dict[str, set[str]]) -> None:
    loaded = modules_of[""]
    assert "varishold" in loaded
    assert "numpy" not in HEAVY
    assert not loaded.intersection(HEAVY)
    assert not {name for name in loaded if name.startswith("varishold.") and name.count(".") > 1}


@pytest.mark.parametrize("room", [room for room in ROOMS if room != "cli"])
def test_every_room_is_reached_by_an_attribute_and_loads_no_heavy_thing_by_itself(
    room: str, modules_of: dict[str, set[str]]
) -> None:
    assert room in dir(varishold)
    assert f"varishold.{room}" in modules_of[room]
    assert not modules_of[room].intersection(HEAVY)


@pytest.mark.parametrize("room", [room for room in ROOMS if room != "cli"])
def test_every_public_name_is_there_and_listed(room: str) -> None:
    module = getattr(varishold, room)
    assert module.__all__ == sorted(set(module.__all__), key=module.__all__.index)
    for name in module.__all__:
        assert getattr(module, name) is not None
        assert name in dir(module)
    with pytest.raises(AttributeError, match=f"module 'varishold.{room}' has no attribute 'no_such_name'"):
        module.no_such_name  # noqa: B018


def test_the_flat_names_are_those_of_the_rooms() -> None:
    for name in varishold.__all__:
        module = importlib.import_module(getattr(varishold, name).__module__)
        assert getattr(module, name) is getattr(varishold, name)
    assert len([name for name in varishold.__all__ if not name.endswith("Error")]) <= 16


def test_what_type_checkers_read_is_what_is_there() -> None:
    """Every room shows type checkers the names that it promises, and only those."""
    for room in ROOMS:
        tree = ast.parse((SOURCE / room / "__init__.py").read_text())
        shown = {
            alias.asname or alias.name
            for block in tree.body
            if isinstance(block, ast.If)
            for statement in block.body
            if isinstance(statement, ast.ImportFrom)
            for alias in statement.names
        }
        if room != "cli":
            assert shown == set(getattr(varishold, room).__all__), room


def test_no_module_behind_a_lazy_door_is_called_as_what_the_door_offers() -> None:
    """Once it is imported a module is its package's attribute, and would be handed out for the function."""
    doors = [path.parent for path in sorted(SOURCE.rglob("__init__.py")) if "lazy_names(" in path.read_text()]
    assert len(doors) > 10
    for door in doors:
        package = ".".join(("varishold", *door.relative_to(SOURCE).parts))
        inside = {found.name for found in pkgutil.iter_modules([str(door)]) if not found.ispkg}
        assert not inside.intersection(importlib.import_module(package).__all__), package


# Lengths, angles, forces: in SI, and the name says so.
QUANTITIES = re.compile(
    r"(.*_)?(angle|breadth|curvature|depth|diameter|force|length|pitch|radius|speed|thickness|torque|yaw)s?"
)
# What users know by these names, and what has no unit: a section of size 1, shares, whether to write over a file.
WITHOUT_UNIT = {
    ("find_contacts", "pitch"),
    ("find_contacts_batch", "pitch"),
    ("reconstruct", "pitch"),
    ("press", "depth"),
    ("press", "force"),
    ("Section", "radius"),
    ("Randomization", "torque"),
    ("Digit", "relative_length"),
    ("check_output", "force"),
}


@pytest.mark.parametrize("room", [room for room in ROOMS if room != "cli"])
def test_units_stand_in_the_names_of_parameters(room: str) -> None:
    found = set()
    module = getattr(varishold, room)
    for name in module.__all__:
        offered = getattr(module, name)
        members = vars(offered).items() if inspect.isclass(offered) else ()
        functions = [getattr(value, "__func__", value) for key, value in members if not key.startswith("_")]
        for one in (offered, *functions):
            # A class that is a dict has no signature of its own.
            if inspect.isfunction(one) or (inspect.isclass(one) and not issubclass(one, dict)):
                found |= {(name, p) for p in inspect.signature(one).parameters if QUANTITIES.fullmatch(p)}
    assert found <= WITHOUT_UNIT


def test_no_error_or_remark_of_the_library_speaks_of_a_command() -> None:
    option = re.compile(r"(?<![\w<!-])--[a-z]{2}")
    spoken = []
    for path in sorted(SOURCE.rglob("*.py")):
        if "cli" in path.relative_to(SOURCE).parts:
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and option.search(node.value):
                spoken.append(f"{path.name}:{node.lineno}: {node.value}")
    assert option.search("press (--kind even)")
    assert not option.search("<!-- a page -- of words -->")
    assert not spoken


def test_no_two_public_names_differ_by_case_alone() -> None:
    written: dict[str, set[str]] = defaultdict(set)
    for room in ROOMS:
        for name in getattr(getattr(varishold, room), "__all__", ()):
            written[name.lower()].add(name)
    assert not [names for names in written.values() if len(names) > 1]
