"""The files of the program import each other in one direction; those of most rooms for types alone too."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import varishold

SOURCE = Path(varishold.__file__).parent
ROOMS = (
    "calibration",
    "cli",
    "exploration",
    "files",
    "frame",
    "grasp",
    "hand",
    "perceive",
    "recording",
    "report",
    "skin",
    "solids",
)


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def statements(node: ast.AST, *, types: bool) -> Iterator[ast.AST]:
    """Yield all statements, which stand in no expression; those for types alone where `types`."""
    alone = not types and isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    for part in ("body", "handlers", "orelse", "finalbody", "cases"):
        for each in getattr(node, part, []) if part != "body" or not alone else []:
            yield each
            yield from statements(each, types=types)


def imports(path: Path, modules: dict[str, Path], *, types: bool = True) -> set[str]:
    """Return the modules of ours that a file imports anywhere in it, for types alone where `types`."""
    found = set()
    for node in statements(parsed(path), types=types):
        if isinstance(node, ast.ImportFrom) and node.module in modules:
            names = (f"{node.module}.{alias.name}" for alias in node.names)
            found |= {name if name in modules else str(node.module) for name in names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name in modules}
    return found - {name for name, file in modules.items() if file == path}


def named(path: Path) -> str:
    parts = ("varishold", *path.relative_to(SOURCE).with_suffix("").parts)
    return ".".join(parts).removesuffix(".__init__")


@pytest.mark.parametrize("room", ROOMS)
def test_no_circle_of_files(room: str) -> None:
    modules = {named(path): path for path in (SOURCE / room).rglob("*.py")}
    try:
        TopologicalSorter({name: imports(path, modules) for name, path in modules.items()}).prepare()
    except CycleError as error:
        pytest.fail(f"these files import each other in a circle: {' <- '.join(error.args[1])}")


def test_no_circle_of_files_in_the_whole_program() -> None:
    modules = {named(path): path for path in SOURCE.rglob("*.py")}
    try:
        TopologicalSorter({name: imports(path, modules, types=False) for name, path in modules.items()}).prepare()
    except CycleError as error:
        pytest.fail(f"these files import each other in a circle: {' <- '.join(error.args[1])}")


def test_a_circle_would_be_found(tmp_path: Path) -> None:
    for name, other in (("a", "b"), ("b", "a")):
        (tmp_path / f"{name}.py").write_text(f"def f():\n    from {other} import f\n")
    modules = {name: tmp_path / f"{name}.py" for name in "ab"}
    with pytest.raises(CycleError):
        TopologicalSorter({name: imports(path, modules) for name, path in modules.items()}).prepare()
