"""Taxels and lines that flicker in a stream are found and mended; presses, taps and trembling loads are none."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold.frame.running_flicker import RunningFlicker
from varishold.live.pad_watcher import PadWatcher
from varishold.live.sample import PadLayout

Floats = NDArray[np.float64]
SHAPE = (9, 11)

FLICKERS: dict[str, Callable[[np.random.Generator, Floats], Floats]] = {
    "any value": lambda rng, at_s: 200.0 * rng.random(at_s.shape),
    "on and off": lambda rng, at_s: 90.0 * (np.floor(at_s * 20) % 2),
    "one reading in six": lambda rng, at_s: 90.0 * (np.arange(at_s.size) % 6 == 0),
}
NONE: dict[str, Callable[[Floats], Floats]] = {
    "taps four times a second": lambda at_s: 90.0 * (np.floor(at_s * 8) % 2),
    "a load that trembles": lambda at_s: (at_s > 1) * (90.0 + 15.0 * np.sin(60.0 * at_s)),
    "one press": lambda at_s: 90.0 * (at_s > 2),
}


def watched(frames: Floats, rate_hz: float, rest: float = 0.0) -> tuple[list[NDArray[np.bool_] | None], Floats]:
    watcher = RunningFlicker(np.ones(frames.shape[1:], np.bool_))
    found, mended = [], []
    for k, frame in enumerate(frames):
        mended.append(watcher.update(k / rate_hz, frame, np.full(frame.shape, rest), 1.0))
        found.append(watcher.flickering)
    return found, np.array(mended)


@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from(sorted(FLICKERS)),
    st.sampled_from([25.0, 100.0, 400.0]),
    st.tuples(st.integers(0, SHAPE[0] - 1), st.integers(0, SHAPE[1] - 1)),
)
@settings(max_examples=30, deadline=None)
def test_what_flickers_is_found_mended_and_forgotten(
    seed: int, how: str, rate_hz: float, place: tuple[int, int]
) -> None:
    rng = np.random.default_rng(seed)
    n, stops = int(14 * rate_hz), int(6 * rate_hz)
    frames = 300.0 + rng.normal(0.0, 1.0, (n, *SHAPE))
    # Something presses for a second, over what flickers or beside it.
    frames[int(4 * rate_hz) : int(5 * rate_hz), 2:6, 2:7] += 100.0
    true = frames.copy()
    frames[(slice(None, stops), *place)] += FLICKERS[how](rng, np.arange(stops) / rate_hz)
    if how == "one reading in six" and rate_hz < 100.0:
        # Eight jumps a second may be somebody who taps.
        return
    found, mended = watched(frames, rate_hz, 300.0)
    begins = next(k for k, where in enumerate(found) if where is not None)
    assert begins < 3.5 * rate_hz
    for where in found[begins:stops]:
        assert where is not None
        assert np.argwhere(where).tolist() == [list(place)]
    assert found[-1] is None
    assert np.abs(mended - true)[int(5 * rate_hz) : stops].max() < 10.0
    others = np.ones(SHAPE, np.bool_)
    others[place] = False
    np.testing.assert_array_equal(mended[:, others], frames[:, others])


@given(st.integers(0, 2**32 - 1), st.sampled_from(sorted(NONE)), st.sampled_from([25.0, 100.0, 400.0]))
@settings(max_examples=30, deadline=None)
def test_what_presses_on_one_taxel_does_not_flicker(seed: int, how: str, rate_hz: float) -> None:
    rng = np.random.default_rng(seed)
    at_s = np.arange(int(8 * rate_hz)) / rate_hz
    frames = rng.normal(0.0, 1.0, (at_s.size, *SHAPE))
    frames[:, 4, 5] += NONE[how](at_s)
    found, mended = watched(frames, rate_hz)
    assert not any(where is not None for where in found)
    np.testing.assert_array_equal(mended, frames)


def test_what_flickers_is_known_while_something_moves_beside_it() -> None:
    rng = np.random.default_rng(0)
    frames = rng.normal(0.0, 1.0, (2400, *SHAPE))
    frames[:, 1, 1] += 90.0 * rng.random(2400)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    for k in range(400, 2400):
        frames[k] += 80.0 * np.exp(-((y - 6) ** 2 + (x - 6 - 3 * np.sin(k / 6)) ** 2) / 4)
    found, _ = watched(frames, 100.0)
    for where in found[400:]:
        assert where is not None
        assert np.argwhere(where).tolist() == [[1, 1]]


@pytest.mark.parametrize("line", [(slice(None), 4), (7,), (0,), (slice(None), 10)])
def test_whole_lines_flicker_beside_what_moves_too(line: tuple[int | slice, ...]) -> None:
    rng = np.random.default_rng(0)
    frames = rng.normal(0.0, 1.0, (900, *SHAPE))
    frames[(slice(None), *line)] += (90.0 * (np.arange(900) // 4 % 2))[:, None]
    frames[300:, 3:5, 6:8] += (60.0 + 20.0 * np.sin(np.arange(600) / 3))[:, None, None]
    expected = np.zeros(SHAPE, np.bool_)
    expected[line] = True
    found, mended = watched(frames, 100.0)
    for where in found[200:]:
        assert where is not None
        np.testing.assert_array_equal(where, expected)
    assert np.abs(mended[200:300]).max() < 8


def test_lines_of_wide_pads_flicker_too() -> None:
    # Of so many taxels more may flicker at once than a line has.
    frames = np.random.default_rng(0).normal(0.0, 1.0, (300, 64, 64))
    frames[:, 40] += (90.0 * (np.arange(300) // 4 % 2))[:, None]
    where = watched(frames, 100.0)[0][-1]
    assert where is not None
    assert np.unique(np.argwhere(where)[:, 0]).tolist() == [40]
    assert where[40].all()


def test_whole_pads_patches_and_pads_of_few_taxels_do_not_flicker() -> None:
    rng = np.random.default_rng(0)
    on_off = 90.0 * (np.arange(800) // 3 % 2)
    for where, shape in (((), SHAPE), ((slice(3, 6), slice(3, 6)), SHAPE), ((slice(3, 5),), SHAPE), ((0, 0), (2, 4))):
        frames = rng.normal(0.0, 1.0, (800, *shape))
        frames[(slice(None), *where)] += on_off.reshape(-1, *(1,) * (frames[(0, *where)].ndim))
        assert not any(found is not None for found in watched(frames, 100.0)[0])


def test_what_is_no_number_flickers_nowhere_and_is_left() -> None:
    frames = np.random.default_rng(0).normal(0.0, 1.0, (400, *SHAPE))
    frames[::3, 2, 2] = np.nan
    frames[::5, 3, 8] = np.inf
    found, mended = watched(frames, 100.0)
    assert not any(where is not None for where in found)
    np.testing.assert_array_equal(mended, frames)


@pytest.mark.parametrize("whole", [False, True])
def test_a_watched_pad_goes_on_without_what_flickers(whole: bool) -> None:
    watcher = PadWatcher("pad", PadLayout(shape=(16, 16)), whole=whole)
    rng, heap = np.random.default_rng(0), np.zeros((16, 16))
    heap[5:10, 5:10] = 100.0
    events: list[str] = []
    for k in range(3000):
        frame = 300.0 + rng.normal(0, 1, (16, 16)) + heap * (600 <= k % 800 < 700)
        frame[1, 1] += 200.0 * rng.random()
        read = np.rint(frame).astype(np.uint16) if whole else frame
        seen = watcher.see(k / 100, read)
        if k >= 500:
            events += [event.kind for event in seen.events]
    assert (events.count("touched"), events.count("released")) == (3, 3)
    assert any("taxel (1, 1) flickers" in remark for remark in seen.remarks)
    assert seen.works is not None
    assert np.argwhere(~seen.works).tolist() == [[1, 1]]
    assert [(taxel.row, taxel.col) for taxel in watcher.how_it_is().bad if taxel.word == "flickers"] == [(1, 1)]
