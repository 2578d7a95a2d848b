"""Laws of a pad that goes up and down as a whole: what never rests may be a rest that drifts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording, recognize_recording
from varishold.frame.swaying import SWAYS, sways

N = 200
ALL = np.ones((12, 12), np.bool_)
AT = np.arange(N)


def frames_of(way: NDArray[np.float64], seed: int = 0, spread: float = 0.2) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    share = 1.0 + spread * rng.uniform(-1.0, 1.0, ALL.shape)
    return np.asarray(300.0 + way[:, None, None] * share + rng.normal(0.0, 2.0, (len(way), *ALL.shape)))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "way",
    [0.8 * AT, 80.0 * np.sin(AT / 33.0), 50.0 * np.sqrt(AT), 100.0 * (1.0 - np.exp(-AT / 70.0))],
    ids=["even", "to and fro", "slower and slower", "warming up"],
)
def test_a_rest_that_drifts_is_not_surely_a_plane(way: NDArray[np.float64], seed: int) -> None:
    frames = frames_of(way, seed)
    assert sways(frames, ALL)
    answers = list(recognize_recording(Recording({"pad": Pad(frames)}), frames="press"))
    for answer in answers:
        assert answer.surface.probability < 0.56
        assert SWAYS in answer.frame_notes
    # Presses that have names are presses.
    named = Recording({"pad": Pad(frames)}, press=np.where(AT > 150, 0, -1))
    (answer,) = recognize_recording(named, frames="press")
    assert SWAYS not in answer.frame_notes


def test_presses_of_the_whole_pad_with_pauses_are_planes() -> None:
    press = np.r_[np.zeros(8), np.linspace(0, 100, 10), np.full(10, 100.0), np.linspace(100, 0, 10)]
    frames = frames_of(np.tile(press, 5))
    assert not sways(frames, ALL)
    answers = list(recognize_recording(Recording({"pad": Pad(frames)}), frames="press"))
    assert len(answers) == 5
    assert all(answer.surface.name == "plane" and answer.surface.probability > 0.9 for answer in answers)


def test_what_stands_out_shows_the_rest() -> None:
    frames = frames_of(0.8 * AT)
    frames[60:90, 4:8, 4:8] += 300.0
    assert not sways(frames, ALL)
    # Not so single readings.
    frames = frames_of(0.8 * AT)
    frames[AT[::20], 3, 3] += 500.0
    assert sways(frames, ALL)


def test_too_little_is_not_judged() -> None:
    frames = frames_of(0.8 * AT)
    assert not sways(frames[:20], ALL)
    assert not sways(frames, np.arange(144).reshape(12, 12) < 12)
    assert not sways(np.full((60, 12, 12), 7), ALL)


def test_the_unit_of_readings_does_not_matter() -> None:
    rng = np.random.default_rng(5)
    frames = 2.0 ** np.arange(40)[:, None, None] / 2**30 + rng.normal(0, 1e-3, (40, 8, 8))
    works = np.ones((8, 8), bool)
    for unit in (1.0, 2.0**-1000, 2.0**900):
        assert sways(unit * frames, works) == sways(frames, works)
