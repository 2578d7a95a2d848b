"""The runner of the benchmarks: figures as fields, options of one, and a status of the worst."""

from __future__ import annotations

import json
import math

import pytest

from benchmarks import __main__ as runner
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
