"""What is changed at random is one thing, that runs, and nothing else."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from mutants.changes import changed, changes, sample
from mutants.child import run
from mutants.judge import Room

SOURCE = '''"""Nearest."""
__all__ = ["nearest"]
WIDTH: int = 3


def nearest(x: int, y: int = 2, *, far: bool = False) -> int | None:
    """Say 1 and not 2."""
    if x < y and not far:
        raise ValueError(f"{x + 1} is near", 5)
    for k in range(
        x,
        y,
    ):
        if k == 2:
            break
    print(min(x, y), end="")
    return x - y
'''


def test_every_change_is_a_program_that_differs_and_keeps_its_lines() -> None:
    path = Path(__file__).parents[1] / "src" / "varishold" / "circuit" / "minimization.py"
    for source in (SOURCE, path.read_text("utf-8")):
        found, tree = changes(source), ast.dump(ast.parse(source))
        assert len({(c.start, c.end, c.now) for c in found}) == len(found)
        for change in found:
            new = changed(source, change)
            assert ast.dump(ast.parse(new)) != tree
            assert len(new.splitlines()) == len(source.splitlines())


def test_what_runs_is_changed_and_what_is_only_read_is_not() -> None:
    made = {(c.was, c.now) for c in changes(SOURCE)}
    assert {
        ("x < y", "x <= y"),
        ("x < y and (not far)", "x < y or not far"),
        ("not far", "far"),
        ("range(x, y)", "range(y, x)"),
        ("k == 2", "k != 2"),
        ("break", "continue"),
        ("min(x, y)", "max(x, y)"),
        ("print(min(x, y), end='')", "pass"),
        ("return x - y", "return None"),
        ("x - y", "x + y"),
        ("3", "4"),
        ("False", "True"),
    } <= made
    assert not any("near" in was or was in ("1", "5", "int | None") for was, _ in made)


def test_a_draw_does_not_depend_on_where_the_code_stands() -> None:
    moved = "\n\n# More.\n" + SOURCE
    drawn = [
        [(c.was, c.now) for _, c in sample({name: changes(text)}, 9, 4)] for name, text in (("a", SOURCE), ("b", moved))
    ]
    assert drawn[0] == drawn[1]
    assert len(set(drawn[0])) == 9
    assert drawn[0] != [(c.was, c.now) for _, c in sample({"a": changes(SOURCE)}, 9, 5)]


@pytest.mark.parametrize("kind", ["statement", "loop"])
def test_statements_are_changed_in_place(kind: str) -> None:
    for change in changes(SOURCE):
        if change.kind == kind:
            assert change.now in [ast.unparse(node) for node in ast.walk(ast.parse(changed(SOURCE, change)))]


def test_a_file_with_examples_is_loaded_once_whatever_comes_first(tmp_path: Path) -> None:
    """Of a class that were two, no object could be sent elsewhere."""
    files = {
        "pytest.ini": "[pytest]\naddopts = --doctest-modules --import-mode=importlib\n",
        "src/toy/__init__.py": "from toy.one import One as One\n",
        "src/toy/one.py": 'class One:\n    """A thing.\n\n    >>> One() is None\n    False\n    """\n',
        "tests/test_toy.py": "import pickle\nimport toy\n\n\ndef test_sent():\n    pickle.dumps(toy.One())\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    done = run(tmp_path, ["src/toy/one.py", "tests/test_toy.py"])
    assert {name: told["passed"] for name, told in done.tests.items()} == {
        "src/toy/one.py::toy.one.One": True,
        "tests/test_toy.py::test_sent": True,
    }


def toy(folder: Path, test: str) -> None:
    files = {
        "pytest.ini": "[pytest]\n",
        "src/toy.py": "# Numbers.\n\n\ndef one():\n    return 1\n\n\ndef two():\n    return one()\n",
        "tests/test_toy.py": f"import threading, time\nimport toy\n\n\n{test}",
    }
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def test_what_a_thread_calls_its_test_calls(tmp_path: Path) -> None:
    toy(
        tmp_path,
        "def test_here():\n    assert True\n\n\n"
        "def test_there():\n    thread = threading.Thread(target=toy.two)\n    thread.start()\n    thread.join()\n",
    )
    done = run(tmp_path, ["tests/test_toy.py"], note_calls=True)
    called = {name.split("::")[1]: told["calls"] for name, told in done.tests.items()}
    assert called["test_there"] == [["toy.py", 1], ["toy.py", 4], ["toy.py", 8]]
    assert called["test_here"] == [["toy.py", 1]]


def test_a_test_that_waits_for_what_never_comes_is_ended_and_named(tmp_path: Path) -> None:
    toy(
        tmp_path,
        "def test_ends():\n    time.sleep(0.01)\n\n\n"
        "def test_waits():\n    while toy.one() == 1:\n        time.sleep(0.01)\n",
    )
    names = ["tests/test_toy.py::test_ends", "tests/test_toy.py::test_waits"]
    done = run(tmp_path, ["tests/test_toy.py"], only=names, patience_s=5.0)
    assert done.caught_by == f"time: {names[1]}"


def test_a_module_s_own_values_are_shown_to_all_tests_and_a_function_to_those_that_call_it() -> None:
    room = Room.__new__(Room)
    calls = {
        "tests/test_b.py::one": ["pad.py", "width"],
        "tests/test_b.py::two": ["pad.py", "height"],
        "tests/test_a.py::three": ["other.py", "depth"],
    }
    room._tests = {name: {"scopes": [told], "seconds": 0.1, "clock_s": 0.1} for name, told in calls.items()}
    assert room._order("src/pad.py", "width") == ["tests/test_b.py::one"]
    # Those that use the file come first.
    assert room._order("src/pad.py", "") == ["tests/test_b.py::one", "tests/test_b.py::two", "tests/test_a.py::three"]
    assert room._order("src/pad.py", "thread") == ["tests/test_b.py::one", "tests/test_b.py::two"]
    assert room._order("src/moved.py", "depth") == ["tests/test_a.py::three"]
    assert set(room._order("src/new.py", "new")) == set(calls)
