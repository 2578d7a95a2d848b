"""What commands print is what was answered: every column, note and mark read back."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.test_report_touch import answers_of, dome, recording_of, surface_of

from varishold.cli import printing
from varishold.cli.hand import _jobs, _print_grasp, _steps
from varishold.cli.printing import parse_shape, print_answers, printable
from varishold.errors import InputError
from varishold.hand import TABLE_5_OBJECTS, HandSetting
from varishold.hand.objects import OBJECTS


@pytest.fixture
def wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")


def printed(answers, recording, capsys, **options):
    print_answers(answers, recording, json=False, **options)
    return capsys.readouterr().out.splitlines()


FRAMES = [dome(centre=(8.0 + k, 10.0 + 2 * k), radius=5.0 + 0.3 * k) for k in range(3)]


@pytest.mark.parametrize("pitch", [None, (0.003, 0.002)])
def test_each_contact_has_a_row_under_its_headings(wide, capsys, pitch):
    recording = recording_of(FRAMES, **({} if pitch is None else {"pitch_m": pitch}), unit="Pa")
    answers = [
        replace(answer, surface=surface_of(answer.surface.contact, key, share))
        for answer, key, share in zip(
            answers_of(recording), ("sphere", "ridge", "cone"), (0.97, 0.99, 0.93), strict=True
        )
    ]
    lines = [line for line in printed(answers, recording, capsys) if not line.startswith("note")]
    head, *rows = lines
    at = {word: head.index(word) for word in ("frame", "name", "p", "else", "at (x, y)", "size", "why")}
    assert list(at.values()) == sorted(at.values())
    assert len(rows) == len(answers)
    for row, answer in zip(rows, answers, strict=True):
        surface = answer.surface
        assert row[: at["frame"] + 5] == str(answer.frame).rjust(5)
        assert row[at["name"] :].startswith(surface.name)
        assert row[at["else"] - 6 : at["else"] - 2] == f"{surface.probability:.2f}"
        other = next(iter(surface.alternatives.items()), None)
        told = "" if other is None else f"{other[0]} {other[1]:.2f}"
        assert row[at["else"] : at["at (x, y)"]].strip() == told
        scale = 1e3 if pitch else 1.0
        x, y = (float(n) for n in row[at["at (x, y)"] : at["size"]].split(","))
        assert (x, y) == pytest.approx([v * scale for v in surface.position], abs=0.0501)
        size = row[at["size"] : at["why"]].strip()
        numbers = [float(n) for n in re.findall(r"\d+\.\d", size)]
        same = math.isclose(*surface.size)
        assert numbers == pytest.approx([v * scale for v in surface.size[: 1 if same else 2]], abs=0.0501)
        assert size.endswith("mm" if pitch else "taxels")
        assert row[at["why"] :] == surface.reasons[0]


def test_pads_are_named_where_there_are_several(wide, capsys):
    recording = recording_of(FRAMES[:1], name="left")
    pads = {**recording.pads, "right": recording.pads["left"]}
    both = type(recording)(pads, time_s=recording.time_s)
    lines = printed(answers_of(both), both, capsys)
    head = next(line for line in lines if line.lstrip().startswith("frame"))
    assert head.split()[:3] == ["frame", "pad", "name"]
    rows = [line for line in lines if re.match(r" +0  (left|right)", line)]
    assert [row.split()[1] for row in rows] == ["left", "right"]
    alone = printed(answers_of(recording), recording, capsys)
    assert not any(" pad " in line for line in alone)


def test_a_narrow_window_leaves_the_reason_out(monkeypatch, capsys):
    recording = recording_of(FRAMES[:1])
    answer = replace(answers_of(recording)[0])
    monkeypatch.setenv("COLUMNS", "300")
    row = next(line for line in printed([answer], recording, capsys) if "sphere" in line)
    without = len(row) - len(answer.surface.reasons[0])
    for columns, told in ((without + 40, True), (without + 39, False), (20, False)):
        monkeypatch.setenv("COLUMNS", str(columns))
        lines = printed([answer], recording, capsys)
        row = next(line for line in lines if line.startswith("    0"))
        assert ("sections" in row) == told
        assert len(row) <= columns
        assert (row[-1] == "…") == (columns == 20 or (told and len(row) == columns))


def test_what_is_unsure_or_cut_is_told_below_the_row(wide, capsys):
    recording = recording_of([dome(centre=(9.0, 0.0), radius=7.0)])
    (answer,) = answers_of(recording)
    for share in (0.97, 0.4):
        unsure = replace(answer, surface=surface_of(answer.surface.contact, "sphere", share))
        lines = printed([unsure], recording, capsys)
        below = lines[next(k for k, line in enumerate(lines) if line.startswith("    0")) + 1]
        assert below.endswith("cut at the pad's left")
        assert ("90 %:" in below) == (share == 0.4)
        # It stands under the name, two columns beyond the frame's.
        assert re.match(r" {7}\S", below)
    surface = unsure.surface
    names = ", ".join(surface.answer_set[:4])
    more = len(surface.answer_set) - 4
    assert f"outline {surface.outline} {surface.outline_probability:.2f}; 90 %: {names} and {more} more;" in below
    inside = recording_of([dome()])
    sure = [replace(a, surface=surface_of(a.surface.contact, "sphere", 0.97)) for a in answers_of(inside)]
    assert not any("outline" in line or "cut" in line for line in printed(sure, inside, capsys))


def test_no_contact_and_notes_are_told(wide, capsys):
    recording = recording_of(np.zeros((2, 4, 4)), notes=("it was cold",))
    lines = printed([], recording, capsys)
    assert "no contact above the noise" in lines
    assert any("it was cold" in line for line in lines)
    recording = recording_of(FRAMES)
    one, *others = answers_of(recording)
    answers = [
        replace(one, frame_notes=("zeroed", "filled", "filled")),
        *(replace(a, frame_notes=("zeroed",)) for a in others),
    ]
    lines = printed(answers, recording, capsys)
    assert lines[-2:] == ["note: zeroed", "note: filled (1 of 3 contacts)"]
    assert printing._frame_notes(printing.Counter({f"n{k}": 1 for k in range(8)}), 1) == [f"n{k}" for k in range(8)]
    nine = printing._frame_notes(printing.Counter({f"n{k}": 1 for k in range(9)}), 1)
    assert nine == [*(f"n{k}" for k in range(8)), "1 more notes on frames; --json has them"]


def test_a_table_of_many_blocks_prints_every_row_once(wide, capsys, monkeypatch):
    monkeypatch.setattr(printing, "_ROWS_A_BLOCK", 2)
    recording = recording_of(FRAMES)
    answers = [replace(answer, frame=k) for k, answer in enumerate(answers_of(recording) * 3)]
    lines = printed(iter(answers), recording, capsys)
    assert [int(line.split()[0]) for line in lines if re.match(r" +\d", line)] == list(range(9))
    assert sum(line.lstrip().startswith("frame") for line in lines) == 1


@given(st.text())
def test_nothing_printed_steers_a_terminal(text):
    safe = printable(text)
    assert all(sign.isprintable() or sign in "\n\t" for sign in safe)
    if all(sign.isprintable() for sign in text):
        assert safe == text


@pytest.mark.parametrize(("text", "shape"), [("16x16", (16, 16)), (" 3 X 40 ", (3, 40)), ("7×1", (7, 1)), (None, None)])
def test_a_shape_is_read(text, shape):
    assert parse_shape(text) == shape


@pytest.mark.parametrize("text", ["0x4", "4x0", "16", "x", "4x4x4", "-1x4", "1234567x2", "a4x4"])
def test_what_is_no_shape_is_refused(text):
    with pytest.raises(InputError, match="--shape must be ROWSxCOLS"):
        parse_shape(text)


# ---- the hand's commands


def test_jobs_are_every_object_in_every_size_with_seeds_of_its_own():
    told = [(job.name, job.size_m, job.seed) for job in _jobs(["cone, box:0.06", "sphere"], [0.05, 0.08], 2, 7)]
    wanted = [("cone", 0.05), ("cone", 0.08), ("box", 0.06), ("sphere", 0.05), ("sphere", 0.08)]
    assert told == [(name, size, 7 + k) for name, size in wanted for k in range(2)]
    assert [(job.name, job.size_m) for job in _jobs(["table5"], [0.07], 1, 0)] == list(TABLE_5_OBJECTS)
    assert all(name in OBJECTS for name, _ in TABLE_5_OBJECTS)
    with pytest.raises(InputError, match=r"NAME:SIZE_M as in cylinder:0\.09, got 'box:wide'"):
        _jobs(["box:wide"], [0.07], 1, 0)


def test_steps_are_numbers_or_all():
    assert _steps(" all ", HandSetting()) == (1, 2, 3, 4, 5)
    assert _steps("5,3,3", HandSetting()) == (3, 5)
    with pytest.raises(InputError, match="numbers between commas"):
        _steps("last", HandSetting())


def test_a_grasp_is_printed_step_by_step(wide, capsys):
    setting = HandSetting()
    names = setting.layout.names

    def step(number, closed, felt):
        sensed = SimpleNamespace(switches=[name in closed for name in names])
        return SimpleNamespace(number=number, name=f"act {number}", sensed=sensed, felt=felt)

    missed = SimpleNamespace(
        search=SimpleNamespace(found=False, touches=3, shift_m=-0.012), steps=[step(1, (), False)], outcome="missed"
    )
    held = SimpleNamespace(
        search=None, steps=[step(1, ("index_distal",), True), step(2, ("palm_centre",), True)], outcome="held"
    )
    done = SimpleNamespace(attempts=[missed, held], held=True, name="cone", size_m=0.0625)
    _print_grasp(done, setting)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "search: not found, felt from both sides 3 times, moved aside -12 mm"
    assert "attempt 1: missed; again" in [line.strip() for line in lines]
    assert not any(line.startswith("attempt 2") for line in lines)
    assert lines[-1] == "the cone of 62.5 mm hangs in the hand"
    head = next(line for line in lines if "index" in line)
    rows = [line for line in lines if "act " in line]
    assert [line.count("●") for line in rows] == [0, 1, 1]
    assert all(line.count("●") + line.count("·") == 22 for line in rows)
    assert rows[1].index("●") == head.index("index") + 2
    assert rows[2].index("●") == head.index("palm") + 3
    assert [line.split()[-1] for line in rows] == ["nothing", "held", "held"]
    done = SimpleNamespace(attempts=[missed], held=False, name="cone", size_m=0.06)
    _print_grasp(done, setting)
    lines = capsys.readouterr().out.splitlines()
    assert "attempt 1: missed" in [line.strip() for line in lines]
    assert lines[-1] == "the cone of 60 mm is not in the hand"
