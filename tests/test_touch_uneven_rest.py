"""Where the rest of a height map is uneven, intervals say so; a ball is as deep as it is, however deep it goes in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from varishold import Pad, Recording, recognize_recording
from varishold.touch.answer import Answer

Floats = NDArray[np.float64]
SIDE, PITCH, ACROSS, HEIGHT = 160, 1e-4, 7e-3, 2e-3
Y, X = (np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2) * PITCH
CYLINDER = np.where(np.hypot(X, Y) < ACROSS / 2, HEIGHT, 0.0)
CONE = np.maximum(HEIGHT * (1 - np.hypot(X, Y) / (ACROSS / 2)), 0)


def cap(share: float, away: Floats) -> tuple[Floats, float]:
    """Return what is pressed of a ball or bar of 7 mm across, by this share of its radius, and how deep that is."""
    radius = ACROSS / 2 / math.sqrt(1 - (1 - share) ** 2)
    return np.maximum(np.sqrt(np.maximum(radius**2 - away**2, 0)) - (1 - share) * radius, 0), share * radius


def told(frame: Floats, noise: Floats) -> Answer:
    (answer,) = recognize_recording(Recording({"pad": Pad((frame + noise)[None], pitch_m=PITCH)}, unit="m"))
    return answer


def waves(seed: int) -> Floats:
    """Return what a rest of waves some ten taxels long is off, by 2 % of the height on the mean square."""
    rough = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal((SIDE, SIDE)), 3)
    return 0.02 * HEIGHT * rough / rough.std()


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("name", ["sphere", "lying cylinder"])
def test_a_ball_and_a_bar_are_as_deep_as_they_are(name: str, share: float) -> None:
    frame, deep = cap(share, np.hypot(X, Y) if name == "sphere" else Y)
    frame = np.where(abs(X) < ACROSS, frame, 0)
    answer = told(frame, 0.01 * deep * np.random.default_rng(0).standard_normal(frame.shape))
    assert answer.surface.name == name
    assert answer.depth_m == pytest.approx(deep, rel=0.015)
    low, high = answer.depth_interval_m
    assert low <= deep <= high


@pytest.mark.parametrize(("name", "frame"), [("cylinder", CYLINDER), ("cone", CONE)])
def test_intervals_hold_what_lies_on_an_uneven_rest(name: str, frame: Floats) -> None:
    held = []
    for seed in range(10):
        answer = told(frame, waves(seed))
        assert answer.surface.name == name
        low, high = answer.depth_interval_m
        held.append(low <= HEIGHT <= high)
    assert np.mean(held) >= 0.8


def test_noise_alone_makes_no_rest_uneven_and_waves_widen_the_intervals() -> None:
    noise = 0.01 * HEIGHT * np.random.default_rng(0).standard_normal(CONE.shape)
    even, uneven = told(CONE, noise), told(CONE, noise + waves(0))
    for key in ("depth_interval_m", "size_interval"):
        narrow, wide = (np.ptp(np.array(getattr(answer, key)), axis=-1) for answer in (even, uneven))
        assert np.all(wide > 1.3 * narrow)
    low, high = even.depth_interval_m
    assert high - low < 0.1 * HEIGHT
