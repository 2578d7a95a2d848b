"""Laws of a rest that each taxel leaves in its own way: it is followed where nothing presses, and taken off."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.test_drifting import ALL, COURSE, NAMES, PRESSES, TIME, N, pressed

from varishold import Pad, Recording, recognize_recording
from varishold.recording import presses
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.own_drift import may_drift, own_drift
from varishold.recording.stored import stored_of

OWN = np.random.default_rng(3).normal(0.0, 1.0, ALL.shape)
OTHER = np.random.default_rng(4).normal(0.0, 1.0, ALL.shape)
STEPS = np.random.default_rng(5).normal(0.0, 1.0, (N, *ALL.shape))
WAYS = {
    "evenly": 200.0 * TIME[:, None, None] * OWN,
    "far": 500.0 * TIME[:, None, None] * OWN,
    "to and fro": 150.0 * np.sin(7.0 * TIME[:, None, None] + OWN),
    "a walk": np.cumsum(STEPS, axis=0) * 250.0 / np.sqrt(N),
    "a jump between presses": 150.0 * (TIME > 3 / len(PRESSES))[:, None, None] * OWN,
    "one way, then another": 200.0
    * (np.minimum(TIME, 0.5)[:, None, None] * OWN + np.maximum(TIME - 0.5, 0.0)[:, None, None] * OTHER),
}


def names_of(recording: Recording) -> list[str]:
    return [answer.surface.name for answer in recognize_recording(recording, frames="press")]


@pytest.mark.parametrize("way", WAYS)
def test_presses_are_named_as_on_a_rest_that_stays(way: str) -> None:
    recording = Recording({"pad": Pad(pressed() + WAYS[way])})
    mended = without_faults(recording).pads["pad"]
    assert "drifts of its own" in mended.notes[-1]
    assert names_of(recording) == NAMES
    left = mended.frames - pressed()
    off = np.median(np.abs(left - np.median(left[:12], axis=0)), axis=(1, 2))
    # Where it jumps or turns nobody knows when; behind the last rest it is taken to stay.
    assert np.median(off) < 35.0
    assert off.max() < 150.0


def test_nothing_but_the_rest_is_taken_off() -> None:
    clean = pressed(noise=0.0)
    recording = Recording({"pad": Pad(clean + WAYS["evenly"])})
    drift = own_drift(recording, presses(recording))["pad"]
    left = drift.mended(0, N) - clean
    # Before the first rest and behind the last one it is taken to stay.
    assert np.abs(left - left[7])[7:205].max() < 1e-9


@pytest.mark.parametrize(("every", "missed"), [(7, 50), (9, 50), (9, 5)])
def test_spans_that_are_long_because_a_press_was_missed_are_no_drift(every: int, missed: int) -> None:
    rng = np.random.default_rng(6)
    y, x = np.mgrid[-3.5:4, -3.5:4]
    starts = np.arange(4, 1400, every)
    loads = np.where(np.arange(len(starts)) % missed == 1, 8.0, 100.0)
    frames = rng.normal(0.0, 1.0, (1404, 8, 8))
    for start, load in zip(starts, loads, strict=True):
        frames[start - 1 : start + 4] += load * np.exp(-((x - rng.normal()) ** 2 + (y - rng.normal()) ** 2) / 8)
    seen = [range(int(start), int(start) + 3) for start, load in zip(starts, loads, strict=True) if load > 50.0]
    assert not own_drift(Recording({"pad": Pad(frames)}), seen)
    drift = np.linspace(0.0, 1.0, len(frames))[:, None, None] * rng.normal(0.0, 60.0, (8, 8))
    (found,) = own_drift(Recording({"pad": Pad(frames + drift)}), seen).values()
    assert np.std(found.off_at(np.array([1060.0])) - drift[1060]) < 0.1 * np.std(drift[1060])


@pytest.mark.parametrize("noise", [0.0, 0.5, 10.0, 60.0])
@pytest.mark.parametrize("whole", [False, True])
def test_a_rest_that_stays_is_left_as_it_is(noise: float, whole: bool) -> None:
    for seed in range(10):
        frames = pressed(seed, noise)
        if whole:
            frames = np.clip(np.rint(frames), 0, 4095).astype(np.uint16)
        assert without_faults(Recording({"pad": Pad(frames)})).pads["pad"].notes == ()


def test_neither_few_frames_nor_few_taxels_tell() -> None:
    frames = pressed() + WAYS["far"]
    assert may_drift(frames, ALL)
    assert not may_drift(frames[:20], ALL)
    assert not may_drift(frames[:, :3, :5], ALL[:3, :5])
    assert own_drift(Recording({"pad": Pad(frames)}), [range(3, N)]) == {}
    assert own_drift(Recording({"pad": Pad(frames)}), []) != {}


def test_pads_drift_each_for_itself() -> None:
    frames = pressed(1)
    mended = without_faults(Recording({"one": Pad(frames + WAYS["evenly"]), "other": Pad(frames)}))
    assert len(mended.pads["one"].notes) == 1
    assert mended.pads["other"].notes == ()
    assert mended.pads["other"].frames is frames or np.array_equal(mended.pads["other"].frames, frames)


def test_blocks_are_mended_as_the_whole_in_whole_numbers() -> None:
    frames = np.clip(np.rint(pressed() + WAYS["evenly"]), 0, 65535).astype(np.uint16)
    recording = Recording({"pad": Pad(frames)})
    whole = without_faults(recording).pads["pad"].frames
    assert whole.dtype == frames.dtype
    mended = stored_without_faults(stored_of(recording))
    for bounds in ([0, N], [0, 1, 17, N // 2, N - 1, N]):
        parts = [mended.part(first, last).pads["pad"].frames for first, last in pairwise(bounds)]
        assert np.array_equal(np.concatenate(parts), whole)


def test_full_scale_and_what_is_no_taxel_stay() -> None:
    field = ALL.copy()
    field[:3, :3] = False
    frames = np.minimum(pressed() + WAYS["evenly"], 1100.0)
    frames[:, ~field] = np.nan
    mended = without_faults(Recording({"pad": Pad(frames, field=field)})).pads["pad"].frames
    assert np.isnan(mended[:, ~field]).all()
    assert np.array_equal(mended[frames == 1100.0], frames[frames == 1100.0])


def test_a_press_that_is_held_is_no_drift() -> None:
    course = np.r_[np.zeros(20), np.linspace(0.1, 1.0, 8), np.ones(300), np.linspace(0.9, 0.1, 6), np.zeros(20)]
    frames = (
        300.0
        + 1000.0 * course[:, None, None] * PRESSES[0]
        + np.random.default_rng(0).normal(0, 10.0, (len(course), *ALL.shape))
    )
    assert without_faults(Recording({"pad": Pad(frames)})).pads["pad"].notes == ()
    assert COURSE.max() == 1.0
