"""The runner of the benchmarks: figures as fields, options of one, and a status of the worst."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from benchmarks import __main__ as runner
from benchmarks import _history as history
from benchmarks._figures import figure, share, taken


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
