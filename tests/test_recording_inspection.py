"""What a recording holds and what is wrong with it, in Python and by ``varishold info`` and ``validate``."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from varishold.cli.app import app
from varishold.recording import Pad, Recording, write
from varishold.recording.inspection import faults_of, summarize

ROOT = Path(__file__).parents[1]
FRAMES = np.random.default_rng(0).integers(1, 200, (12, 4, 5))


def said(*words: object, status: int = 0) -> str:
    done = CliRunner().invoke(app, list(map(str, words)), catch_exceptions=False)
    assert done.exit_code == status, done.output
    return done.stdout


def recording(time_s: object = None, **more: object) -> Recording:
    return Recording({"pad": Pad(FRAMES, pitch_m=(0.002, 0.004))}, time_s=time_s, **more)


@given(st.integers(2, 40), st.floats(1e-3, 10), st.floats(-1e6, 1e6))
def test_an_even_clock_has_its_rate_and_no_gap(n: int, step_s: float, begin_s: float) -> None:
    time = summarize(Recording({"pad": Pad(np.ones((n, 2, 2)))}, time_s=begin_s + step_s * np.arange(n))).time
    assert time.rate_hz == pytest.approx(1 / step_s, rel=1e-5)
    assert time.duration_s == pytest.approx((n - 1) * step_s, rel=1e-5)
    assert (time.n_gaps, time.n_back, time.n_repeated, time.gaps) == (0, 0, 0, ())


@given(st.sets(st.integers(1, 98), max_size=40))
def test_as_many_frames_lack_as_were_taken_out(taken: set[int]) -> None:
    kept = [k for k in range(100) if k not in taken]
    time = summarize(Recording({"pad": Pad(np.ones((len(kept), 2, 2)))}, time_s=0.01 * np.array(kept))).time
    assert time.n_lacking == len(taken)
    assert time.n_gaps == int((np.diff(kept) > 1).sum())
    assert [lasts for _, lasts in time.gaps] == sorted((lasts for _, lasts in time.gaps), reverse=True)
    for frame, lasts in time.gaps:
        assert lasts == pytest.approx(0.01 * (kept[frame] - kept[frame - 1]))


def test_a_clock_that_goes_back_or_stands_still_or_lacks_frames_is_told() -> None:
    time_s = np.array([0, 1, 2, 1.5, 2.5, 2.5, 3.5, 4.5, 9.5, 10.5, 11.5, 12.5])
    assert faults_of(recording(time_s)) == (
        "time goes back once, first at frame 3",
        "time stands still once, first at frame 5",
        "about 4 frames lacking in one gap, the longest of 5 s before frame 8",
    )
    found = summarize(recording(time_s)).time
    assert found.rate_hz == 1
    assert found.jitter_s == 0


@given(st.integers(0, 18), st.sampled_from([2.0**32 * 1e-6, 0.05, 7.0]))
def test_a_clock_that_begins_anew_lasts_as_long_as_it_went_forward(at: int, back_s: float) -> None:
    time_s = 5000.0 + 0.01 * np.arange(20)
    time_s[at + 1 :] -= back_s
    found = summarize(Recording({"pad": Pad(np.ones((20, 1, 1)))}, time_s=time_s)).time
    assert (found.n_back, found.begin_s) == (1, 5000.0)
    assert found.duration_s == pytest.approx(0.18)


def test_a_recording_of_one_frame_has_no_rate() -> None:
    found = summarize(Recording({"pad": Pad(np.ones((1, 2, 2)))}, time_s=np.array([5.0]))).time
    assert (found.rate_hz, found.jitter_s, found.begin_s, found.duration_s) == (None, None, 5.0, 0.0)
    assert summarize(recording()).time is None


def test_every_pad_is_told_with_its_taxels_that_work() -> None:
    field, valid = np.ones((4, 5), bool), np.ones((4, 5), bool)
    field[0], valid[1, 1] = False, False
    frames = FRAMES.copy()
    frames[7] += 300
    frames[:, 3, 3] = 0
    frames[:, 1, 1] = 5000
    found = summarize(Recording({"left": Pad(frames, field=field, valid=valid), "right": Pad(FRAMES[:, :1])}))
    left, right = found.pads
    assert (left.name, left.shape, left.n_taxels, left.n_broken, left.peak_frame) == ("left", (4, 5), 15, 2, 7)
    assert left.high < 600
    assert (right.shape, right.n_taxels, right.n_broken, right.pitch_m) == ((1, 5), 5, 0, None)
    assert any(fault.startswith("pad left: ") for fault in found.faults)


def test_the_frame_of_most_pressure_is_the_lowest_where_smaller_is_more() -> None:
    frames = np.full((9, 3, 3), 200)
    frames[4, 1, 1] = 20
    frames[2, 1, 1] = 201
    assert summarize(Recording({"pad": Pad(frames, polarity="down")})).pads[0].peak_frame == 4


def test_it_is_printed_for_people_and_for_programs(tmp_path: Path) -> None:
    press = np.repeat([0, -1, 1], 4)
    made = recording(
        np.arange(12) / 50, unit="kPa", sensor="mat", press=press, press_columns={"thing": np.array(["a", "b"])}
    )
    file = tmp_path / "a.npz"
    write(made, file)
    lines = said("info", file).splitlines()
    assert lines[:5] == [
        "frames    12 in 0.22 s",
        "rate      50 Hz, jitter 0 ms",
        "unit      kPa",
        "sensor    mat",
        "presses   2, with thing",
    ]
    assert (
        lines[5]
        == f"pad       4 x 5 taxels, rows 2 mm, columns 4 mm apart; int64 from {FRAMES.min()} to {FRAMES.max()}"
    )
    assert len(lines) == 11
    assert {len(line) <= 10 for line in lines[-4:]} == {True}
    told = json.loads(said("info", file, "--json"))
    assert told["file"] == str(file)
    assert told["time"]["n_gaps"] == 0
    assert told["pads"][0]["pitch_m"] == [0.002, 0.004]


def test_large_frames_are_drawn_small(tmp_path: Path) -> None:
    write(Recording({"pad": Pad(np.random.default_rng(1).random((2, 300, 200)))}), tmp_path / "a.npz")
    picture = said("info", tmp_path / "a.npz").partition("of pad:\n")[2].splitlines()
    assert len(picture) <= 24
    assert max(map(len, picture)) <= 72


def test_every_fault_is_a_line_and_the_status_is_1(tmp_path: Path) -> None:
    bad, good, none = tmp_path / "bad.npz", tmp_path / "good.npz", tmp_path / "none.csv"
    write(recording(np.array([0, 1, 2, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 19.5])), bad)
    write(recording(), good)
    none.write_text("what\n")
    assert said("validate", good) == f"{good}: no fault found\n"
    assert said("validate", bad, good, none, status=1).splitlines() == [
        f"{bad}: time goes back once, first at frame 3",
        f"{bad}: about 10 frames lacking in one gap, the longest of 11 s before frame 11",
        f"{good}: no fault found",
        f"{none}: there is no line of numbers behind 'what'",
    ]
    told = [json.loads(line) for line in said("validate", bad, good, "--json", status=1).splitlines()]
    assert [line["file"] for line in told] == [str(bad)] * 2


def test_the_example_has_no_fault() -> None:
    assert "no fault found" in said("validate", ROOT / "examples" / "surfaces.npz")


@given(st.lists(st.sampled_from([0.0, 0.01, 0.01, 0.01, 0.011, 0.05, -0.02, 1.0]), max_size=40), st.integers(1, 9))
def test_a_clock_is_looked_at_in_pieces(steps: list[float], together: int) -> None:
    time_s = np.cumsum([100.0, *steps])
    recording = Recording({"pad": Pad(np.ones((len(time_s), 1, 1)))}, time_s=time_s)
    whole = summarize(recording)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("varishold.recording.inspection._TIMES", together)
        patch.setattr("varishold.frame.order_statistics._TOGETHER", together)
        assert summarize(recording) == whole
