"""The rest of a large frame that curves is taken off; what is even, small or a form stays to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold.frame.level import level
from varishold.kernel import address, bind, work_space
from varishold.levelset import find_contacts
from varishold.solids import SOLIDS, draw_contact, ideal_frame
from varishold.touch import recognize

unbend = bind("vh_unbend", "ppiidpp", "i")
unbend_work = bind("vh_unbend_work", "ii", "z")
Floats = NDArray[np.float64]


def unbent(frame: Floats, sigma: float, usable: NDArray[np.bool_] | None = None) -> tuple[Floats, list[float]]:
    """Return a frame without its curved rest, and the plane nearest to that."""
    values, rest = np.array(frame, np.float64), np.zeros(3)
    marks = np.ones(values.shape, np.bool_) if usable is None else usable.copy()
    rows, cols = values.shape
    unbend(address(values), address(marks), rows, cols, sigma, address(rest), work_space(unbend_work(rows, cols)))
    return values, rest.tolist()


def terms(shape: tuple[int, int]) -> Floats:
    """Return 1, x, y, xx, xy and yy over a field; shape (6, rows, cols)."""
    y, x = np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij")
    return np.stack([np.ones(shape), x, y, x * x, x * y, y * y])


def drawn(rng: np.random.Generator, key: str, side: int = 96) -> Floats:
    found = draw_contact(rng, key, field_m=(side, side), size_m=(side / 4, side / 2.5))
    frame = ideal_frame(found.solid, (side, side), 1.0, depth_m=found.depth_m, pose=found.pose)
    return np.asarray(frame / frame.max())


FORMS = [key for key in SOLIDS if key not in ("edge", "plane")]


def bend(rng: np.random.Generator) -> Floats:
    """Draw a rest of second degree that curves by a tenth of the range."""
    of = rng.uniform(-0.04, 0.04, 6)
    of += 0.3 * np.eye(6)[0] + rng.choice([-0.08, 0.08]) * (np.eye(6)[3] + np.eye(6)[5])
    return np.asarray(np.tensordot(of, terms((96, 96)), 1))


@pytest.mark.parametrize("key", FORMS)
def test_a_curved_rest_is_taken_off(key: str) -> None:
    rng = np.random.default_rng(11)
    for _ in range(4):
        frame, rest = drawn(rng, key), bend(rng)
        (contact,) = find_contacts(frame + rest + rng.normal(0, 0.01, frame.shape))
        assert np.abs(contact.frame.padded[1:-1, 1:-1] - frame)[frame == 0].mean() < 0.012
        plane = [contact.frame.rest[0] + 47.5 * (contact.frame.rest[1] + contact.frame.rest[2])]
        assert plane == pytest.approx([rest.mean()], abs=0.02)


def test_names_are_as_without_it() -> None:
    rng = np.random.default_rng(12)
    right = [0, 0]
    for key in FORMS:
        for _ in range(3):
            frame = drawn(rng, key) + rng.normal(0, 0.01, (96, 96))
            for k, rest in enumerate((0.0, bend(rng))):
                found = find_contacts(frame + rest)
                right[k] += recognize(found[0]).name == recognize(find_contacts(frame)[0]).name and len(found) == 1
    assert right[1] >= right[0] - 1


@pytest.mark.parametrize("key", SOLIDS)
def test_an_even_rest_stays(key: str) -> None:
    rng = np.random.default_rng(13)
    for noise in (0.0, 0.01):
        frame = drawn(rng, key) + rng.normal(0, noise, (96, 96))
        assert np.array_equal(unbent(frame, noise)[0], frame)


def test_noise_even_frames_and_small_ones_stay() -> None:
    rng = np.random.default_rng(14)
    small = bend(rng)[::2, ::2] + drawn(rng, "sphere")[::2, ::2]
    for frame in (rng.normal(0, 1, (96, 96)), np.zeros((96, 96)), np.ones((80, 90)), bend(rng), small):
        assert np.array_equal(unbent(frame, 0.0)[0], frame)


def test_a_face_over_half_of_the_pad_hides_how_the_rest_curves() -> None:
    rng = np.random.default_rng(15)
    frame = bend(rng) + rng.normal(0, 0.01, (96, 96))
    frame[:, 48:] += 1.0
    assert np.array_equal(unbent(frame, 0.01)[0], frame)


def fitted(frame: Floats, sigma: float) -> Floats:
    """Return the rest as plain numpy finds it, of all taxels: least squares within bands that shrink."""
    shape = terms(frame.shape).reshape(6, -1)
    value, of, band = frame.ravel(), np.zeros(6), 0.25 * np.ptp(frame)
    of[0] = np.sort(value)[int(0.3 * value.size)]
    for _ in range(16):
        off = value - of @ shape
        within = np.abs(off) <= band
        of = of + np.linalg.lstsq(shape[:, within].T, off[within], rcond=None)[0]
        off = value - of @ shape
        below = off[(off <= 0) & (off >= -band)]
        tighter = 3 * max(np.sqrt(np.mean(below**2)), sigma)
        if tighter >= 0.98 * band:
            break
        band = tighter
    return np.asarray((of @ shape).reshape(frame.shape))


def test_it_is_what_plain_numpy_finds() -> None:
    rng = np.random.default_rng(16)
    for key in FORMS:
        frame = drawn(rng, key)[:48, 24:72]
        frame = np.kron(frame, np.ones((2, 2))) + bend(rng) + rng.normal(0, 0.01, (96, 96))
        values, rest = unbent(frame, 0.01)
        if any(rest):
            # The kernel looks at every second taxel of every second row.
            assert np.abs(frame - values - fitted(frame, 0.01)).max() < 0.006


def test_broken_taxels_do_not_count() -> None:
    rng = np.random.default_rng(17)
    frame = drawn(rng, "sphere") + bend(rng) + rng.normal(0, 0.01, (96, 96))
    usable = rng.random(frame.shape) > 0.1
    values, rest = unbent(np.where(usable, frame, -5.0), 0.01, usable)
    assert any(rest)
    assert np.abs(frame - values - (frame - unbent(frame, 0.01)[0]))[usable].max() < 0.005


def test_a_plane_is_still_a_plane() -> None:
    rng = np.random.default_rng(18)
    frame = drawn(rng, "cone") + 0.1 + 0.2 * terms((96, 96))[1] + rng.normal(0, 0.01, (96, 96))
    (contact,) = find_contacts(frame)
    assert contact.frame.rest == level(frame).rest
