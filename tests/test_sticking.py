"""Laws of what sticks: what stays off its rest while others come and go is filled, and nothing else is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.pressed_things import told

from varishold import Pad, Recording, recognize_recording, write
from varishold.frame.running_sticking import RunningSticking
from varishold.frame.sticking import sticking_taxels
from varishold.live.pad_watcher import PadWatcher
from varishold.live.sample import PadLayout
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

Frames = NDArray[np.float64]
PRESS = np.r_[np.linspace(0.1, 1.0, 8), np.ones(6), np.linspace(0.9, 0.1, 6)]
COURSE = np.r_[np.zeros(20), PRESS, np.zeros(15), PRESS, np.zeros(15)]
N = len(COURSE)
ALL = np.ones((12, 12), np.bool_)


def pressed(seed: int = 0, noise: float = 5.0, rest: float = 0.0) -> Frames:
    """Return the frames of a ball that is pressed twice."""
    rng = np.random.default_rng(seed)
    row, col = np.indices(ALL.shape) - 5.5
    ball = np.sqrt(np.maximum(1.0 - (row**2 + col**2) / 16.0, 0.0))
    frames: Frames = rest + 1000.0 * COURSE[:, None, None] * ball + rng.normal(0.0, noise, (N, *ALL.shape))
    return frames


def recorded(frames: NDArray[np.generic]) -> Recording:
    return Recording({"pad": Pad(frames)})


@pytest.mark.parametrize("noise", [0.0, 5.0, 30.0])
def test_nothing_sticks_in_presses_as_they_are(noise: float) -> None:
    for seed in range(10):
        frames = pressed(seed, noise)
        # Whole, held to the end, begun pressed, and a drift of all.
        for some in (frames, frames[:70], frames[24:], frames + np.linspace(0, 300, N)[:, None, None]):
            assert sticking_taxels(some, ALL) is None


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.uint16])
@pytest.mark.parametrize("since", [12, 24, 45])
@pytest.mark.parametrize(("row", "col"), [(1, 1), (5, 6), (0, 11), (3, slice(None)), (slice(None), 7)])
def test_what_sticks_high_is_filled_from_where_it_does(
    dtype: type, since: int, row: int | slice, col: int | slice
) -> None:
    clean = np.maximum(pressed(noise=3.0), 0.0).astype(dtype)
    stuck = clean.copy()
    stuck[since:, row, col] = 900
    if since == 24:
        stuck[since:, row, col] += np.random.default_rng(1).integers(0, 9, stuck[since:, row, col].shape).astype(dtype)
    mended = without_faults(recorded(stuck)).pads["pad"]
    assert mended.frames.dtype == clean.dtype
    where = np.zeros_like(ALL)
    where[row, col] = True
    assert np.array_equal(mended.frames[:, ~where], clean[:, ~where])
    assert np.array_equal(mended.frames[: since - 4], clean[: since - 4])
    # From the frame on in which it would have been as high by itself, which may be a little earlier.
    assert np.abs(mended.frames.astype(float) - clean)[since:].max() < 450.0
    assert all("sticks from frame" in note for note in mended.notes)
    assert mended.notes


@pytest.mark.parametrize(("row", "col"), [(2, 3), (4, slice(None))])
def test_what_falls_silent_on_a_rest_is_filled(row: int, col: int | slice) -> None:
    stuck = pressed(rest=500.0)
    stuck[30:, row, col] = 0.0
    rule = sticking_taxels(stuck, ALL)
    assert rule is not None
    assert (rule.since < N).sum() == (12 if isinstance(col, slice) else 1)
    assert rule.mended(0, N).min() > 400.0


def test_what_is_put_down_or_taken_off_does_not_stick() -> None:
    for seed in range(5):
        frames = pressed(seed)
        # Something broad is put down.
        put = frames.copy()
        put[15:, :3, :3] += 400.0
        assert sticking_taxels(put, ALL) is None
        # One taxel was pressed at the start and is let go; of readings that have noise, and of such that have none.
        taken = frames.copy()
        taken[:15, 1, 1] += 400.0
        assert sticking_taxels(taken, ALL) is None
        assert sticking_taxels(np.maximum(taken - 30.0, 0.0), ALL) is None


def test_one_taxel_pressed_to_the_end_does_not_stick() -> None:
    frames = np.random.default_rng(0).normal(0.0, 5.0, (N, 12, 12))
    frames[30:, 4, 4] += 800.0
    assert sticking_taxels(frames, ALL) is None
    # Nor is it where something else was pressed before it, or is pressed still.
    assert sticking_taxels(np.concatenate([pressed()[:50], frames]), ALL) is None
    late = pressed()
    late[12:, 0, 0] += 800.0
    assert sticking_taxels(late[:65], ALL) is None


def test_names_and_numbers_of_presses_are_those_without_it() -> None:
    for seed in range(5):
        stuck = pressed(seed)
        stuck[16:, 2, 5] = 1500.0
        answers = list(recognize_recording(recorded(stuck), frames="press"))
        assert [answer.surface.name for answer in answers] == ["sphere", "sphere"]
        assert any("taxel (2, 5) sticks" in note for note in answers[0].frame_notes)


def test_blocks_are_mended_as_the_whole() -> None:
    stuck = pressed()
    stuck[16:, 2, 5] = 1500.0
    stuck[33, 8, 1] = 2000.0
    whole = without_faults(recorded(stuck)).pads["pad"].frames
    assert whole[33, 8, 1] < 100.0
    mended = stored_without_faults(stored_of(recorded(stuck)))
    for many in (1, 7, 40):
        bounds = [*range(0, N, many), N]
        parts = [mended.part(first, last).pads["pad"].frames for first, last in pairwise(bounds)]
        assert np.array_equal(np.concatenate(parts), whole)


def test_a_command_tells_of_it(tmp_path: object) -> None:
    stuck = pressed()
    stuck[16:, 2, 5] = 1500.0
    file = f"{tmp_path}/stuck.npz"
    write(recorded(stuck), file)
    assert "taxel (2, 5) sticks from frame 16 on: filled from those beside" in told("touch", file).output


def stuck_at(frames: Frames, rate_hz: float = 20.0) -> list[list[list[int]]]:
    """Return what a stream's frames are found to have stuck, frame by frame."""
    watched, found = RunningSticking(ALL), []
    for k, frame in enumerate(frames):
        watched.update(k / rate_hz, frame, 5.0)
        found.append([] if watched.stuck is None else np.argwhere(watched.stuck).tolist())
    return found


def test_in_a_stream_nothing_sticks_in_presses_as_they_are() -> None:
    for seed in range(5):
        alone = np.random.default_rng(seed).normal(0.0, 5.0, (N, 12, 12))
        # One taxel is pressed for long, and comes and goes while others do.
        alone[10:80, 4, 4] += 800.0
        beside = pressed(seed)
        beside[5:22, 0, 0] += 800.0
        beside[60:, 0, 11] += 800.0
        for frames in (pressed(seed), alone, beside):
            assert not any(stuck_at(np.concatenate([frames, frames])))


def test_in_a_stream_what_sticks_is_found_and_is_forgotten_when_it_comes_back() -> None:
    stuck = np.concatenate([pressed(0), pressed(1)])
    stuck[10:150, 1, 10] += 900.0
    found = stuck_at(stuck)
    # Alone for .3 s, others pressed, alone again for .3 s.
    first = next(k for k, places in enumerate(found) if places)
    assert first == pytest.approx(20 + len(PRESS) + 0.3 * 20, abs=3)
    assert all(places == [[1, 10]] for places in found[first:150])
    assert not any(found[151:])


def test_a_watched_pad_goes_on_without_what_sticks() -> None:
    frames = np.concatenate([np.zeros((60, 12, 12)), *(pressed(seed, noise=0.0) for seed in range(3))]) + 200.0
    frames += np.random.default_rng(0).normal(0.0, 5.0, frames.shape)
    frames[65:, 5, 11] = 1100.0
    watcher = PadWatcher("pad", PadLayout(shape=(12, 12)))
    seen = [watcher.see(k / 50, frame) for k, frame in enumerate(frames)]
    assert any("taxel (5, 11) sticks" in note for note in seen[-1].notes)
    assert [(taxel.row, taxel.col) for taxel in watcher.how_it_is().bad if taxel.word == "sticks"] == [(5, 11)]
    assert not seen[-1].tracks
    events = [event.kind for one in seen[150:] for event in one.events]
    # What stuck was a touch until then.
    assert (events.count("touched"), events.count("released")) == (4, 5)


@pytest.mark.parametrize("shape", [(12, 1), (1, 12), (2, 1), (1, 1)])
def test_a_pad_of_one_line_that_is_pressed_and_stays_so_sticks_nowhere(shape: tuple[int, int]) -> None:
    frames = 100.0 * (np.arange(60) > 30)[:, None, None] + np.random.default_rng(0).normal(0.0, 1.0, (60, *shape))
    assert sticking_taxels(frames, np.ones(shape, np.bool_)) is None
