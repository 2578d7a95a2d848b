"""``evaluate``: what is asked of the library, and what is printed of a figure."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.commands_said import said
from tests.evaluation_made import made as evaluation
from tests.test_report_evaluation import LEAK

from varishold.cli import distortions, evaluate, sensor
from varishold.cli.paper import table
from varishold.errors import InputError
from varishold.evaluation import SHOTS
from varishold.evaluation.shots import Shots
from varishold.report.evaluation_words import figure_lines, headline, interval, points
from varishold.report.quantities import percent

# Figures


def plain(text: str) -> str:
    return text.replace("\u202f", " ").replace("−", "-")


@pytest.mark.parametrize("spoilt", [False, True])
def test_every_figure_is_printed_with_what_spoils_it(spoilt: bool, capsys: pytest.CaptureFixture[str]) -> None:
    found = evaluation(leaks=(LEAK,) if spoilt else ())
    right = found.scores.right
    found = replace(found, shots=(Shots(1, None, right), Shots(2, right, right), Shots(5, right, None)))
    evaluate._print(found)
    head, first, *lines = capsys.readouterr().out.splitlines()
    mark = "  [flatters: untouched taxels]" if spoilt else ""
    assert head == "36 presses of 3 groups, 3 things"
    assert first == plain(headline(found)) + mark
    expected = []
    for line in figure_lines(found):
        where = f"({line.interval}) " if line.interval else ""
        expected.append(f"  {line.name:<36} {line.value:>12}  {where}{line.says}")
    for shots in found.shots:
        mine = "-" if shots.right is None else f"{percent(shots.right.value)} ({interval(shots.right)})"
        beside = "" if shots.peer is None else f"; best peer {percent(shots.peer.value)}"
        learned = f"learned from {shots.presses} {'press' if shots.presses == 1 else 'presses'} a thing"
        expected.append(f"  {learned:<36} {mine}{beside}")
    (peer,) = found.peers
    ahead = f"ours {points(peer.ahead.value)} points ({interval(peer.ahead, signed=True)})"
    expected.append(f"  peer: {peer.name:<30} {percent(peer.right.value):>12}  {ahead}")
    assert lines[: len(expected)] == [plain(line) + mark for line in expected]
    warned = ["warning: taxels that nothing touches tell it"] if spoilt else []
    assert lines[len(expected) :] == [*warned, "note: a remark"]


def test_without_groups_none_are_counted(capsys: pytest.CaptureFixture[str]) -> None:
    found = evaluation()
    evaluate._print(replace(found, groups=()))
    assert capsys.readouterr().out.startswith("36 presses, 3 things\n")


@pytest.mark.parametrize(
    ("text", "numbers"),
    [(None, None), ("0", ()), ("1", (1,)), ("5, 1,5,2", (1, 2, 5)), ("1000000", (1_000_000,))],
)
def test_shots_are_numbers_in_order_each_once(text: str | None, numbers: tuple[int, ...] | None) -> None:
    assert evaluate._numbers(text) == numbers


@pytest.mark.parametrize("text", ["", "a", "1,", "0,1", "-1", "1000001", "1,2.5"])
def test_what_are_no_shots_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--shots must be numbers of presses between commas"):
        evaluate._numbers(text)


def test_a_page_is_titled_by_its_recordings() -> None:
    assert evaluate._title(["in/a.npz"]) == "a.npz"
    assert evaluate._title(["in/a.npz", "b.npz"]) == "a.npz and 1 more"
    assert evaluate._title(["/"] * 4) == "/ and 3 more"


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """Note what is asked of the library, and answer with one evaluation."""
    noted: dict[str, Any] = {}
    monkeypatch.chdir(tmp_path)
    for name in ("a.npz", "b.npz", "m.npz"):
        Path(name).touch()

    def found(name: str) -> Callable[..., Any]:
        def answer(*what: Any, **how: Any) -> Any:
            how.pop("tick")(completed=1)
            noted.clear()
            noted.update(how, made=name, what=what)
            return evaluation()

        return answer

    def labelled(recordings: Any, *, label: str, group: str | None) -> Any:
        return SimpleNamespace(presses=list(recordings), labels=f"by {label}", groups=f"by {group}")

    class Upright:
        def __init__(self, recording: str, known: str) -> None:
            self.presses = [recording, known, "upright"][: 2 if recording.startswith("a") else 3]

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Upright) and self.presses == other.presses

        __hash__ = None  # type: ignore[assignment]

    class Known:
        def __init__(self, recordings: list[Any], **how: Any) -> None:
            noted_how = labelled(recordings, **how)
            self.presses, self.labels, self.groups = noted_how.presses, noted_how.labels, noted_how.groups

    monkeypatch.setattr("varishold.cli.recordings.read_with_sensor", lambda file, named: (file, f"sensor {named}"))
    monkeypatch.setattr("varishold.cli.recordings.odd_recordings", lambda *_: [])
    monkeypatch.setattr("varishold.sensor.recordings.upright_recording", Upright)
    monkeypatch.setattr("varishold.learning.labelled_presses", Known)
    monkeypatch.setattr("varishold.learning.read_model", lambda path: f"model {path}")
    for name in ("evaluate", "evaluate_model", "evaluate_shipped"):
        monkeypatch.setattr(f"varishold.evaluation.{name}", found(name))
    return noted


def test_what_is_learned_and_tested_is_as_the_options_say(
    asked: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluate, "classifier_of", lambda *how, portable: (*how, portable))
    monkeypatch.setattr(Path, "exists", lambda self: True)
    files = ("a.npz", "b.npz")
    usual = said("evaluate", *files, "--label", "thing")
    assert usual.splitlines()[0] == "36 presses of 3 groups, 3 things"
    assert (asked["made"], asked["classifier"]) == ("evaluate", (None, None, None, False))
    assert (asked["shots"], asked["peers"], asked["seed"]) == (SHOTS, True, 0)
    assert asked["what"][1:] == ("by thing", "by None")
    # Which recording each press is of.
    assert [len(one.presses) for one in asked["what"][0]] == [2, 3]
    assert asked["runs"].tolist() == [0, 0, 1, 1, 1]
    more = (
        "--group",
        "day",
        "--shots",
        "3,1",
        "--no-peers",
        "--seed",
        4,
        "--position",
        "--no-absolute",
        "--error",
        0.2,
    )
    said("evaluate", *files, "--label", "thing", *more, "--portable", "--sensor", "mat")
    assert (asked["classifier"], asked["shots"], asked["peers"], asked["seed"]) == (
        (True, False, 0.2, True), (1, 3), False, 4,
    )  # fmt: skip
    assert asked["what"][2] == "by day"
    assert asked["what"][0][0].presses == ["a.npz", "sensor mat"]
    said("evaluate", *files, "--label", "thing", "--peers", "--shots", "0")
    assert (asked["peers"], asked["shots"]) == (True, ())


def test_a_model_or_the_shipped_names_are_tested_as_they_are(asked: dict[str, Any]) -> None:
    said("evaluate", "a.npz", "b.npz", "--label", "thing", "--group", "day", "--with", "m.npz", "--seed", 3)
    assert (asked["made"], asked["what"][0], asked["seed"]) == ("evaluate_model", "model m.npz", 3)
    assert asked["what"][2:] == ("by thing", "by day")
    said("evaluate", "a.npz", "b.npz", "--label", "thing", "--with", "shipped", "--sensor", "mat")
    assert (asked["made"], asked["seed"]) == ("evaluate_shipped", 0)
    # As they were measured: the names take the sensor off themselves.
    assert asked["what"] == (["a.npz", "b.npz"], "by thing", "by None")
    assert asked["sensors"] == ["sensor mat"] * 2
    with pytest.raises(InputError, match="none: is neither 'shipped' nor a file"):
        said("evaluate", "a.npz", "--label", "thing", "--with", "none")
    for words in (("--shots", 1), ("--peers",), ("--no-position",), ("--absolute",), ("--error", 0.1), ("--portable",)):
        with pytest.raises(InputError, match=f"nothing is learned: leave out {words[0]}$"):
            said("evaluate", "a.npz", "--label", "thing", "--with", "shipped", *words)


def test_an_evaluation_is_a_page_an_object_or_lines(asked: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    pages: list[Any] = []
    monkeypatch.setattr(
        "varishold.report.write_evaluation_report", lambda page, found, title: pages.append((page, title))
    )
    words = ("evaluate", "a.npz", "b.npz", "--label", "thing")
    assert said(*words, "--report", "p.html").splitlines()[-1] == "report: p.html"
    assert pages == [(Path("p.html"), "a.npz and 1 more")]
    told = said(*words, "--report", "p.html", "--json")
    assert json.loads(told) == json.loads(json.dumps(evaluation().to_dict()))
    assert len(pages) == 2
    assert "report" not in said(*words)
    assert len(pages) == 2
    for option in ("--shape", "--frames"):
        with pytest.raises(InputError, match=f"{option} is for --distortions alone"):
            said(*words, option, 16)
    with pytest.raises(InputError, match="what names the things is not said"):
        said("evaluate", "a.npz")
    said("evaluate", status=2)


# The yardstick


@given(st.lists(st.floats(0, 1), min_size=4, max_size=4))
def test_a_row_of_the_yardstick_has_four_shares_under_their_names(shares: list[float]) -> None:
    one: Any = SimpleNamespace(outline=shares[1], unknown=shares[2], sure_wrong=shares[3])
    line = distortions._line("some row", one, shares[0])
    name, *cells = [cell for cell in line.split("  ") if cell.strip()]
    assert name.strip() == "some row"
    assert [cell.strip() for cell in cells] == [f"{100 * share:.1f} %" for share in shares]
    head = "  ".join([f"  {'row':24}", *(f"{name:>9}" for name in distortions._COLUMNS)])
    assert len(line) == len(head)


def test_an_interval_is_told_where_it_is_known() -> None:
    for low, high, told in ((0.8, 0.95, "90.0 % (80.0 to 95.0 %)"), (None, 0.9, "90.0 %"), (0.8, None, "90.0 %")):
        one: Any = SimpleNamespace(right=SimpleNamespace(value=0.9, low=low, high=high))
        assert distortions._interval(one) == told


def test_numbers_stand_between_commas() -> None:
    assert sensor._numbers("--x", None) is None
    assert sensor._numbers("--x", "1000, 2e3,.5") == [1000.0, 2000.0, 0.5]
    for text in ("", "1,", "a"):
        with pytest.raises(InputError, match="--x must be numbers between commas"):
            sensor._numbers("--x", text)


def test_a_table_s_number_is_told_to_the_paper(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    class Result:
        rows = ({"a": 1}, {"b": 2})

        def __str__(self) -> str:
            return "the table"

    asked: list[tuple[int, int]] = []
    monkeypatch.setattr("varishold.paper.paper_table", lambda number, *, seed: asked.append((number, seed)) or Result())
    table(3, seed=7)
    table(2, json=True)
    assert asked == [(3, 7), (2, 0)]
    assert capsys.readouterr().out == 'the table\n{"a": 1}\n{"b": 2}\n'
