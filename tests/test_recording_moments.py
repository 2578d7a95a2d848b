"""Readings that were written one by one come back one by one; what is told of a recording, beside plain loops."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold._counted import counted
from varishold.errors import InputError
from varishold.recording import Pad, Recording, blocks, read, write
from varishold.recording.inspection import summarize
from varishold.recording.mcap import Moments, PadFacts, TopicWriter
from varishold.recording.mcap.alignment import aligned

Written = list[tuple[dict[str, np.ndarray], int, int | None, int | None]]
NAMES = ("palm", "tip", "wrist")


@st.composite
def courses(draw: st.DrawFn) -> Written:
    """Draw readings of some pads, each a millisecond or more after the one before."""
    has_clock, has_number = draw(st.booleans()), draw(st.booleans())
    made: Written = []
    at = 10**18
    for k in range(draw(st.integers(1, 12))):
        at += draw(st.integers(1, 50)) * 10**6
        names = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=3, unique=True))
        pads = {name: np.full((2, 1 + NAMES.index(name)), 10 * k + NAMES.index(name), np.uint16) for name in names}
        device = draw(st.integers(0, 10**6)) * 10**6 if has_clock else None
        made.append((pads, at, device, draw(st.integers(0, 2**32 - 1)) if has_number else None))
    return made


@given(courses(), st.sets(st.integers(0, 11)))
@settings(max_examples=60)
def test_what_was_written_together_comes_back_together(
    tmp_path_factory: pytest.TempPathFactory, course: Written, flushed: set[int]
) -> None:
    path = tmp_path_factory.mktemp("moments") / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for name in NAMES:
            writer.describe(PadFacts(name, pitch_m=(0.001 * (1 + NAMES.index(name)), 0.002)))
        for k, (pads, log_ns, device_ns, sequence) in enumerate(course):
            writer.reading(pads, log_ns=log_ns, device_ns=device_ns, sequence=sequence)
            if k in flushed:
                writer.flush()
        writer.finish()
    with Moments(path) as moments:
        found = list(moments)
        assert {name: facts.pitch_m for name, facts in moments.facts.items()} == {
            name: (0.001 * (1 + NAMES.index(name)), 0.002) for name in NAMES
        }
        assert moments.early == ""
        # They can be read once.
        assert list(moments) == []
    assert len(found) == len(course)
    for moment, (pads, log_ns, device_ns, sequence) in zip(found, course, strict=True):
        assert moment.host_time_s == pytest.approx(log_ns / 1e9, abs=1e-6)
        assert moment.device_time_s == (None if device_ns is None else pytest.approx(device_ns / 1e9))
        assert moment.sequence == sequence
        assert sorted(moment.pads) == sorted(pads)
        for name, values in pads.items():
            assert moment.pads[name].dtype == np.uint16
            assert np.array_equal(moment.pads[name], values)


def test_a_file_that_breaks_off_says_so(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(20):
            writer.reading({"pad": np.full((2, 2), k, np.uint8)}, log_ns=10**18 + k)
            if k % 5 == 4:
                writer.flush()
        writer.finish()
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with Moments(path) as moments:
        found = [int(moment.pads["pad"][0, 0]) for moment in moments]
        assert moments.early
    assert found == [*range(len(found))]
    assert 0 < len(found) < 20


@given(
    st.lists(st.lists(st.integers(0, 60), min_size=1, max_size=12), min_size=1, max_size=3),
)
@settings(max_examples=200)
def test_each_frame_shows_the_newest_reading_of_every_pad(drawn: list[list[int]]) -> None:
    times = {name: np.array(sorted(each)) for name, each in zip(NAMES, drawn, strict=False)}
    if all(np.array_equal(each, times["palm"]) for each in times.values()):
        shown, remarks = aligned(times)
        assert remarks == ()
        assert all(each.tolist() == [*range(len(times["palm"]))] for each in shown.values())
        return
    leading = max(times, key=lambda name: len(times[name]))
    expected: list[dict[str, int]] = []
    for k, at in enumerate(times[leading].tolist()):
        newest = {name: sum(t <= at for t in each.tolist()) - 1 for name, each in times.items()}
        newest[leading] = k
        if min(newest.values()) >= 0:
            expected.append(newest)
    if not expected:
        with pytest.raises(InputError, match="is first read after the last reading of"):
            aligned(times)
        return
    shown, remarks = aligned(times)
    assert [dict(zip(shown, row, strict=True)) for row in zip(*(e.tolist() for e in shown.values()), strict=True)] == (
        expected
    )
    left_out = len(times[leading]) - len(expected)
    assert any(f"{counted(left_out, 'frame is', 'frames are')} left out" in remark for remark in remarks) == (
        left_out > 0
    )
    others = [name for name in times if len(times[name]) != len(times[leading])]
    assert sum("each frame shows its newest reading" in remark for remark in remarks) == len(others)


def test_only_the_pads_that_may_lead_do() -> None:
    times: Any = {"palm": np.arange(10), "tip": np.array([0, 5])}
    shown, _ = aligned(times, ["tip"])
    assert {name: each.tolist() for name, each in shown.items()} == {"palm": [0, 5], "tip": [0, 1]}


# What is told of a pad.


@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans(), st.sampled_from(["up", "down"]))
@settings(max_examples=60)
def test_a_summary_is_that_of_the_taxels_that_work(seed: int, gaps: bool, masked: bool, polarity: Any) -> None:
    rng = np.random.default_rng(seed)
    frames = rng.integers(100, 900, (12, 3, 4))
    dead = int(rng.integers(0, 12))
    frames[:, dead // 4, dead % 4] = 0
    field = rng.random((3, 4)) < 0.8 if gaps else None
    valid = rng.random((3, 4)) < 0.8 if masked else None
    there = np.ones((3, 4), np.bool_) if field is None else field
    usable = there if valid is None else there & valid
    if not usable.any():
        return
    pad = Pad(frames, field=field, valid=valid, polarity=polarity, pitch_m=(0.001, 0.002))
    (told,) = summarize(Recording({"pad": pad})).pads
    works = usable & ~pad.broken
    assert told.n_taxels == there.sum()
    assert told.n_broken == there.sum() - works.sum()
    shown = frames[:, works if works.any() else usable]
    assert (told.low, told.high) == (shown.min(), shown.max())
    totals = pad.totals()
    assert totals[told.peak_frame] == (totals.max() if polarity == "up" else totals.min())
    assert (told.shape, told.dtype, told.polarity, told.on_grid) == ((3, 4), str(frames.dtype), polarity, True)


def test_places_of_taxels_are_numbers_all_of_them() -> None:
    good = np.arange(6.0).reshape(3, 2)
    assert np.array_equal(Pad(np.ones((2, 1, 3)), positions_m=good).positions_m, good)  # type: ignore[arg-type]
    for at in range(6):
        bad = good.copy()
        bad.ravel()[at] = np.nan
        with pytest.raises(InputError, match="positions_m must be finite"):
            Pad(np.ones((2, 1, 3)), positions_m=bad)
    with pytest.raises(InputError, match="positions_m"):
        Pad(np.ones((2, 2, 3)), positions_m=good)
    with pytest.raises(InputError, match="positions_m"):
        Pad(np.ones((2, 1, 3)), positions_m=good[:2])


# Some frames at a time.


@given(
    st.lists(st.floats(-5, 20, allow_nan=False), min_size=1, max_size=40),
    st.floats(-6, 21),
    st.integers(1, 9),
    st.integers(1, 50),
)
@settings(max_examples=60)
def test_frames_are_found_by_their_time_and_given_in_blocks(
    tmp_path_factory: pytest.TempPathFactory, steps: list[float], time_s: float, chunk: int, n_frames: int
) -> None:
    times = np.cumsum(steps)
    frames = np.arange(len(times) * 6).reshape(-1, 2, 3)
    path = tmp_path_factory.mktemp("blocks") / "a.npz"
    write(Recording({"pad": Pad(frames)}, time_s=times), path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "_TIMES", chunk)
        with blocks.open(path) as opened:
            reached = [k for k, at in enumerate(times.tolist()) if at >= time_s]
            assert opened.frame_at(time_s) == (reached[0] if reached else len(times))
            parts = list(opened.blocks(n_frames))
            assert [part.n_frames for part in parts[:-1]] == [n_frames] * (len(parts) - 1)
            assert 0 < parts[-1].n_frames <= n_frames
            assert np.array_equal(np.concatenate([part.pads["pad"].frames for part in parts]), frames)
            assert np.array_equal(np.concatenate([part.time_s for part in parts]), times)
            with pytest.raises(InputError, match="n_frames must be a whole number from 1, got 0"):
                next(opened.blocks(0))


def test_one_frame_a_block_is_a_block(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    write(Recording({"pad": Pad(np.arange(18).reshape(3, 2, 3))}), path)
    with blocks.open(path) as opened:
        assert [part.n_frames for part in opened.blocks(1)] == [1, 1, 1]
        with pytest.raises(InputError, match="without times"):
            opened.frame_at(0.0)


@pytest.mark.parametrize("more", ["", "NOTES one\nSECONDS_PER_FRAME 0.01\n"])
def test_a_tekscan_export_is_known_by_its_header_alone(tmp_path: Path, more: str) -> None:
    """The data may begin far behind the first bytes, after any number of notes."""
    path = tmp_path / "a.txt"
    notes = "".join(f"COMMENT_LINE {k}\n" for k in range(2000))
    data = "ASCII_DATA @@\nFrame 1\n1,2,3\n4,5,6\n\nFrame 2\n0,0,1\n0,0,2\n\n@@\n"
    path.write_text(f"DATA_TYPE MOVIE\nROWS 2\nCOLS 3\n{more}{notes}{data}")
    recording = read(path)
    assert next(iter(recording.pads.values())).frames.tolist() == [[[1, 2, 3], [4, 5, 6]], [[0, 0, 1], [0, 0, 2]]]
