"""Sections against their chords: what the corrected inequality says of forms."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.solids import Cylinder, RectangularPillar, SquarePillar, ideal_frame
from varishold.touch import find_contacts, inequality, recognize


def form(name: str, n: int = 241) -> np.ndarray:
    y, x = np.mgrid[-1 : 1 : n * 1j, -1 : 1 : n * 1j] * 1.25
    r, square = np.hypot(x, y), np.maximum(abs(x), abs(y))
    # The oblong forms are 2 x 1.
    length, breadth = abs(x), 2 * abs(y)
    heights = {
        "cone": 1 - r,
        "pyramid": 1 - square,
        "frustum": np.minimum((1 - square) / 0.6, 1),
        "ridge": np.where(length < 1, 1 - breadth, 0),
        "hip": np.minimum(1 - breadth, 2 * (1 - length)),
        "cap": np.sqrt(np.maximum(2.11**2 - r**2 * (2.11**2 - 1.11**2), 0)) - 1.11,
        "hertz": np.sqrt(np.maximum(1 - r**2, 0)),
        "lying cylinder": np.where(length < 1, 1 - y**2, 0),
        "stacked discs": 1 - np.sqrt(r),
    }
    return np.maximum(heights[name], 0)


# Measured half way between apex and base, less the mean of the two, as a share of the base; and what
# the apex has of the base's sqrt(area) and perimeter.
HALF_WAY = {
    "cone": ((0.0, 0.0), (0.0, 0.0)),
    "pyramid": ((0.0, 0.0), (0.0, 0.0)),
    "frustum": ((0.0, 0.0), (0.4, 0.4)),
    "ridge": ((0.21, 0.0), (0.0, 4 / 6)),
    "hip": ((0.11, 0.0), (0.0, 2 / 6)),
    "cap": ((0.26, 0.26), (0.0, 0.0)),
    "hertz": ((0.37, 0.37), (0.0, 0.0)),
    "lying cylinder": ((0.34, 0.10), (0.0, 0.5)),
    "stacked discs": ((-0.25, -0.25), (0.0, 0.0)),
}


@pytest.mark.parametrize("name", HALF_WAY)
def test_sections_against_their_chords(name):
    (contact,) = find_contacts(form(name), 200, floor=1e-3)
    result = inequality(contact.profile)
    wanted, apex = HALF_WAY[name]
    half = np.argmin(abs(result.threshold - 0.5))
    # Along a steep side the lowest outline is a staircase: the base's measures are taken from the form.
    breadth = {"pyramid": 2, "frustum": 2, "lying cylinder": 2, "ridge": 1, "hip": 1}.get(name)
    bases = (np.sqrt(np.pi), 2 * np.pi) if breadth is None else (np.sqrt(2 * breadth), 4 + 2 * breadth)
    for j, want, top, base in zip((result.sqrt_area / 96, result.perimeter / 96), wanted, apex, bases, strict=True):
        assert j[half] / base - 0.5 * (1 + top) == pytest.approx(want, abs=0.012)
    sqrt_area, perimeter = wanted
    assert (result.bulge_sqrt_area > 0.05) == (sqrt_area > 0)
    assert (result.bulge_perimeter > 0.05) == (perimeter > 0)
    assert (result.defect_sqrt_area > 0.05) == (sqrt_area < 0)
    assert (result.defect_perimeter > 0.05) == (perimeter < 0)


def test_few_usable_sections_say_nothing():
    frame = np.zeros((5, 5))
    frame[2, 2] = 1.0
    (contact,) = find_contacts(frame, 8, floor=0.1)
    assert np.isnan(inequality(contact.profile).bulge_sqrt_area)


@pytest.mark.parametrize("noise", [0.005, 0.02, 0.05])
@pytest.mark.parametrize("solid", [Cylinder(14.0, 3.0), SquarePillar(16.0, 3.0), RectangularPillar(20.0, 10.0, 3.0)])
def test_a_noisy_flat_top_is_not_concave(solid, noise):
    for seed in range(5):
        frame = ideal_frame(solid, (32, 32), 1.0)
        frame += np.random.default_rng(seed).normal(0, noise * frame.max(), frame.shape)
        (contact, *_) = find_contacts(frame)
        surface = recognize(contact)
        assert surface.inequality.defect_perimeter < 0.05


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.01])
def test_a_hollow_flank_is_concave_with_noise_and_without(noise):
    y, x = np.mgrid[-24:25, -24:25]
    frame = np.maximum(1 - np.sqrt(np.hypot(x, y) / 22), 0)
    frame += np.random.default_rng(0).normal(0, max(noise, 1e-9), frame.shape)
    clean = 0.17
    assert recognize(find_contacts(frame)[0]).inequality.defect_perimeter == pytest.approx(clean, abs=0.06)
