"""A row or column that comes off while a stream runs and stands high: it is found, and a bar is none."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.frame.running_open_line import RunningOpenLine

REST = np.full((8, 10), 100.0)


def watched(frames: int, change: object) -> tuple[RunningOpenLine, np.ndarray, list[bool]]:
    """Show 20 frames a second; return what was watched, the last frame mended, and when a line was open."""
    noise, line, opens = np.random.default_rng(0), RunningOpenLine(np.ones(REST.shape, bool)), []
    for k in range(frames):
        frame = REST + noise.normal(0, 1, REST.shape)
        change(k, frame)  # type: ignore[operator]
        mended = line.update(k / 20, frame, REST, 1.0)
        opens.append(line.open is not None)
    return line, mended, opens


@pytest.mark.parametrize("where", [np.s_[3], np.s_[0], np.s_[:, 4], np.s_[:, 9]])
def test_an_open_line_is_found_after_ten_seconds_and_rises_as_those_beside_it(where: object) -> None:
    def come_off(k: int, frame: np.ndarray) -> None:
        frame[:] += 50.0 * (k >= 380)
        if k >= 100:
            frame[where] = 1023.0

    line, mended, opens = watched(400, come_off)
    assert not any(opens[:300])
    assert all(opens[315:])
    open_there = np.zeros(REST.shape, bool)
    open_there[where] = True
    np.testing.assert_array_equal(line.open, open_there)
    assert np.abs(mended[where] - 150).max() < 5
    assert "stands high and never changes, an open line" in line.words()[0]


def test_a_line_that_comes_back_is_believed_again() -> None:
    def for_some_time(k: int, frame: np.ndarray) -> None:
        if 100 <= k < 350:
            frame[3] = 1023.0

    line, _, opens = watched(400, for_some_time)
    assert opens[349]
    assert not any(opens[350:])
    assert line.words() == ()


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_bar_is_no_open_line(noise: float) -> None:
    """It flickers, or it is felt beside its line, or nothing of the pad flickers."""

    def press(k: int, frame: np.ndarray) -> None:
        if noise == 0.0:
            frame[:] = REST
        if k >= 100:
            frame[3] += 300.0
            frame[2::2] += 60.0 * (noise > 0.0)

    assert not any(watched(500, press)[2])


def test_a_saturated_bar_that_is_felt_beside_its_line_is_no_open_line() -> None:
    def press(k: int, frame: np.ndarray) -> None:
        if k >= 100:
            frame[3] = 1023.0
            frame[2, 2:8] += 60.0

    assert not any(watched(500, press)[2])
