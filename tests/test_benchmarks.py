"""The runner of the benchmarks: figures as fields, options of one, and a status of the worst."""

from __future__ import annotations

import importlib
import json
import math
from pathlib import Path

import pytest

from benchmarks import __main__ as runner
from benchmarks import _history as history
from benchmarks._figures import figure, share, taken
from docs import fill_tables

_ROOT = Path(__file__).parents[1]
_COMMANDS = sorted(
    f"{folder}.{path.stem}"
    for folder in ("benchmarks", "hostile", "training")
    for path in (_ROOT / folder).glob("*.py")
    if not path.stem.startswith("__")
)


@pytest.mark.parametrize("name", _COMMANDS)
def test_what_prints_a_figure_finds_all_that_it_takes(name: str) -> None:
    """No other test may run it, and a name that it takes of the package can go."""
    importlib.import_module(name)


def test_a_figure_is_printed_with_unit_and_bar_and_kept() -> None:
    taken()
    assert figure("16 x  9: time", 12.34, ".1f", "us", bar="<= 40") == "12.3 us (bar <= 40)"
    assert share("right", 0.987) == "98.7 %"
    assert figure("nothing", math.nan, ".1f") == "nan"
    assert taken() == [
        {"name": "16 x 9: time", "value": 12.34, "unit": "us", "bar": "<= 40"},
        {"name": "right", "value": 98.7, "unit": "%", "bar": ""},
        {"name": "nothing", "value": None, "unit": "", "bar": ""},
    ]
    assert taken() == []


def test_a_benchmark_prints_its_figures_as_fields(capsys: pytest.CaptureFixture[str]) -> None:
    assert runner.main(["--json", "grasp_paper"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    told = json.loads(line)
    figures = {each["name"]: each["value"] for each in told["figures"]}
    assert figures["smallest separating sets"] == 1
    assert len(figures) == len(told["figures"])
    assert told["benchmark"] == "grasp_paper"
    assert told["status"] == 0


def test_options_are_those_of_one_benchmark(capsys: pytest.CaptureFixture[str]) -> None:
    assert runner.main(["skin_bits", "--presses", "1"]) == 0
    assert "14 presses" in capsys.readouterr().out
    for words, told in (
        (["grasp_paper", "--seed", "1"], "grasp_paper takes no options"),
        (["grasp_paper", "house", "--seed", "1"], "name it before them"),
        (["--seed", "1"], "name it before them"),
        (["skin_bit"], "no benchmark called 'skin_bit'"),
        (["skin_bits", "--pressed", "1"], "unrecognized arguments: --pressed"),
    ):
        assert runner.main(words) == 2
        assert told in capsys.readouterr().err


def test_what_got_worse_is_told_beside_what_was_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(history, "FOLDER", tmp_path)
    assert runner.main(["--quick"]) == 2
    assert "nothing is kept" in capsys.readouterr().err
    assert runner.main(["--record", "grasp_paper"]) == 0
    (path,) = tmp_path.iterdir()
    kept = json.loads(path.read_text("utf-8"))
    assert kept["grasp_paper"]["figures"]
    assert history.History().quick() == ["grasp_paper"]
    assert runner.main(["--compare", "grasp_paper"]) == 0
    assert capsys.readouterr().err == ""
    kept["grasp_paper"]["figures"][0]["value"] += 10
    path.write_text(json.dumps(kept), "utf-8")
    runner.main(["--compare", "grasp_paper"])
    assert kept["grasp_paper"]["figures"][0]["name"] in capsys.readouterr().err
    assert runner.main(["--compare", "skin_bits", "--presses", "1"]) == 2
    assert "no options" in capsys.readouterr().err


def test_nothing_of_speed_is_kept_of_a_busy_machine() -> None:
    taken()
    for name, unit in (("right", "%"), ("time", "ms"), ("rate", "frames/s"), ("gain", "times"), ("count", "")):
        figure(name, 1.0, unit=unit)
    assert [each["name"] for each in history.untimed(taken())] == ["right", "count"]


def test_of_several_versions_the_newest_is_compared_with(tmp_path: Path) -> None:
    for number in ("0.0.9", "0.0.10"):
        told = {"figures": [], "status": 0, "seconds": 1.0, "of": number}
        (tmp_path / f"{number}-m.json").write_text(json.dumps({"house": told}), "utf-8")
    kept = history.History(tmp_path, "m").before("house")
    assert kept is not None
    assert kept["of"] == "0.0.10"


def test_the_tables_of_the_pages_are_those_that_were_recorded(capsys: pytest.CaptureFixture[str]) -> None:
    assert fill_tables.main(["--check"]) == 0, capsys.readouterr().err


def test_a_table_is_filled_with_what_was_recorded_and_nothing_else(tmp_path: Path) -> None:
    figures = [
        {"name": "16 x 9: right", "value": 97.04},
        {"name": "wrong", "value": 0.31},
        {"name": "never", "value": 0},
    ]
    (tmp_path / "0.0.1-m.json").write_text(json.dumps({"house": {"figures": figures}}), "utf-8")
    kept = history.History(tmp_path, "m")
    table = "| {house: 16 x 9: right|.1f} / {house: wrong|.1f} %, {house: never|.0f} | 40 us |\n"
    assert fill_tables.filled(table, kept) == "| 97.0 / .3 %, 0 | 40 us |\n"
    for asked in ("{house: lost|.1f}", "{garden: wrong|.1f}"):
        with pytest.raises(KeyError, match="has no recorded figure"):
            fill_tables.filled(asked, kept)


def test_a_page_with_another_table_is_told_and_mended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    template, page = tmp_path / "template.md", tmp_path / "page.md"
    template.write_text("| new |\n", "utf-8")
    text = "before\n<!-- made by docs/fill_tables.py -->\n\n| {} |\n\n<!-- as far as here -->\nbehind\n"
    page.write_text(text.format("old"), "utf-8")
    monkeypatch.setattr(fill_tables, "PAGES", {template: page})
    assert fill_tables.main(["--check"]) == 1
    assert "page.md: its table is not that of" in capsys.readouterr().err
    assert page.read_text("utf-8") == text.format("old")
    assert fill_tables.main([]) == 0
    assert page.read_text("utf-8") == text.format("new")
    page.write_text("no place", "utf-8")
    assert fill_tables.main([]) == 1


@pytest.mark.parametrize(
    ("bar", "unit", "value", "word"),
    [
        (">= 97", "%", 90.0, "WORSE"),
        (">= 97", "%", 99.9, ""),
        ("<= 3", "", 110.0, "WORSE"),
        ("<= 3", "", 90.0, "better"),
        ("", "us", 115.0, ""),
        ("", "us", 130.0, "WORSE"),
        ("", "us", 70.0, "better"),
        ("", "%", 70.0, "other"),
    ],
)
def test_worse_is_what_the_bar_says_or_what_takes_longer(bar: str, unit: str, value: float, word: str) -> None:
    def told(value: float) -> dict[str, object]:
        return {"figures": [{"name": "it", "value": value, "unit": unit, "bar": bar}]}

    lines = list(history.changes(told(100.0), told(value)))
    assert [line.partition(":")[0] for line in lines] == ([word] if word else [])
