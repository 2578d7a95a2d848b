"""The examples run, and are learned from."""

from __future__ import annotations

import importlib
import importlib.util
import json
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from tests.pressed_things import told

from varishold import read

EXAMPLES = Path(__file__).parents[1] / "examples"
NUMBERED = sorted(EXAMPLES.glob("[0-9][0-9]_*.py"))
PRESSES = 4


def test_there_are_ten_of_them_each_short() -> None:
    assert [int(path.name[:2]) for path in NUMBERED] == list(range(1, 11))
    for path in NUMBERED:
        assert len(path.read_text("utf-8").splitlines()) < 60, path.name


@pytest.mark.usefixtures("compiled_once")
@pytest.mark.parametrize("path", NUMBERED, ids=lambda path: path.stem)
def test_a_numbered_example_runs_and_says_something(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", [str(path)])
    # As where a script lies, so are its neighbours.
    monkeypatch.syspath_prepend(EXAMPLES)
    plt.switch_backend("agg")
    # Fewer presses of the five things teach as well that it runs.
    monkeypatch.setattr(importlib.import_module("five_things"), "PRESSES", PRESSES)
    try:
        runpy.run_path(str(path), run_name="__main__")
    finally:
        plt.close("all")
    said = capsys.readouterr()
    assert said.out.strip()
    assert not re.search("Error|Warning", said.err), said.err


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_runs_from_its_first_cell_to_its_last(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    cells = json.loads(path.read_text("utf-8"))["cells"]
    for library in ("duckdb", "polars"):
        if any(f"import {library}" in "".join(cell["source"]) for cell in cells):
            pytest.importorskip(library)
    assert not any(cell.get("outputs") for cell in cells)
    monkeypatch.setattr(plt, "show", plt.close)
    monkeypatch.chdir(EXAMPLES)
    monkeypatch.syspath_prepend(EXAMPLES)
    namespace: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), path.name, "exec"), namespace)
    plt.close("all")
    assert capsys.readouterr().out.strip()


def test_the_bundled_recording_is_what_its_script_makes(tmp_path: Path) -> None:
    example = _loaded("make_surfaces")
    example.main(tmp_path / "made.npz")
    made, shipped = read(tmp_path / "made.npz"), read(EXAMPLES / "surfaces.npz")
    # The solver's last digits are not those of every machine.
    assert np.abs(made.pads["pad"].frames - shipped.pads["pad"].frames).max() <= 1


def _loaded(name: str):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    return example


def test_five_things_are_learned_on_two_days_and_told_on_a_third(tmp_path: Path) -> None:
    example = _loaded("five_things")
    example.PRESSES = PRESSES
    example.main(tmp_path)
    days = [tmp_path / f"{day}.npz" for day in example.DAYS]
    truth = read(days[2]).presses.columns["thing"]
    assert told("learn", *days[:2], "--label", "thing", "--group", "day", "-o", tmp_path / "model.npz").exit_code == 0
    answered = told("recognize", tmp_path / "model.npz", days[2])
    assert answered.exit_code == 0
    names = [line.split()[1] for line in answered.stdout.splitlines() if line.lstrip()[0].isdigit()]
    assert np.mean(np.array(names) == truth) >= 0.9
