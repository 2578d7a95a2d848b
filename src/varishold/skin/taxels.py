"""What a pad's taxels make of the stress that reaches them."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError, require_a
from varishold.frame.checks import MOST_READ, as_given, is_number
from varishold.skin.media import Cells
from varishold.skin.pressing import PressedSolid
from varishold.skin.transmission import transmission_of

__all__ = ["Taxels", "sense", "taxel_stress"]

Floats = NDArray[np.float64]

# In parts of the peak, or of a gain: beyond it nothing is left of what was pressed.
_MOST_SPREAD = 1e3


@dataclass(frozen=True)
class Taxels:
    """How a pad's taxels depart from ideal ones; every departure is off by default.

    Parameters
    ----------
    noise : float
        Standard deviation of white noise, as a share of the peak of each frame's stress.
    crosstalk : float
        Share of a taxel's reading that leaks into each of its four neighbours, in [0, .25).
    gain_spread : float
        Standard deviation of the taxels' gains around 1.
    bits : int, optional
        Readings are rounded to 2^bits even steps of the full scale.
    full_scale : float, optional
        Reading at which a taxel saturates, in the unit of stress. `bits` without it takes each
        recording's own peak.
    hysteresis : float
        By how much a reading at half the highest stress so far is too large on the way down, as a share
        of that highest stress.
    dead, stuck : float
        Share of taxels that read 0, and that always read one arbitrary value.

    Raises
    ------
    InputError
        If a value is not within its range.
    """

    noise: float = 0.0
    crosstalk: float = 0.0
    gain_spread: float = 0.0
    bits: int | None = None
    full_scale: float | None = None
    hysteresis: float = 0.0
    dead: float = 0.0
    stuck: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None and field.default is None:
                continue
            if not is_number(value) or not 0 <= value < np.inf:
                raise InputError(f"{field.name} of taxels must be finite and not negative, got {value!r}")
            if field.name in ("noise", "gain_spread", "hysteresis") and value > _MOST_SPREAD:
                raise InputError(f"{field.name} of taxels must be at most {_MOST_SPREAD:g}, got {value!r}")
        if self.crosstalk >= 0.25:
            raise InputError(f"crosstalk of taxels must be below .25 for each of 4 neighbours, got {self.crosstalk!r}")
        if self.bits is not None and not 1 <= self.bits <= 32:
            raise InputError(f"bits of taxels must lie in 1 .. 32, got {self.bits!r}")
        if self.full_scale == 0:
            raise InputError("full_scale of taxels must be positive, got 0")
        if self.dead + self.stuck > 1:
            raise InputError(f"dead and stuck taxels must not exceed 1 together, got {self.dead + self.stuck!r}")

    def read(self, stress: ArrayLike, *, seed: int = 0) -> Floats:
        """Return what the taxels report of a stress history.

        Parameters
        ----------
        stress : array_like of shape (n, rows, cols) or (rows, cols)
            True mean stress over each taxel.
        seed : int
            Fixes the pad (gains, dead and stuck taxels) and its noise.

        Returns
        -------
        ndarray of the same shape, float64
        """
        must = "stress must have shape (rows, cols) or (n, rows, cols)"
        given = as_given(stress, must)
        if given.ndim not in (2, 3) or not given.size or given.dtype.kind not in "biuf":
            raise InputError(f"{must}, got {given.dtype} of shape {given.shape}")
        given = given.astype(np.float64)
        if not np.abs(given).max() <= MOST_READ:
            raise InputError(f"stress must be numbers within +-{MOST_READ:g}")
        out = given if given.ndim == 3 else given[None]
        peak = np.abs(out).max(axis=(1, 2), keepdims=True)
        pad = np.random.default_rng([seed, 0])
        gains = 1.0 + self.gain_spread * pad.standard_normal(out.shape[1:])
        fate = pad.permutation(out[0].size).reshape(out.shape[1:])
        level = pad.random(out.shape[1:])
        out = out * gains
        if self.crosstalk:
            out = _leak(out, self.crosstalk)
        if self.hysteresis:
            highest = np.maximum.accumulate(np.maximum(out, 0.0), axis=0)
            loop = out * (highest - out) / np.where(highest > 0, highest, 1.0)
            out = out + 4.0 * self.hysteresis * loop
        if self.noise:
            out = out + self.noise * peak * np.random.default_rng([seed, 1]).standard_normal(out.shape)
        scale = float(peak.max()) if self.full_scale is None else self.full_scale
        dead = round(self.dead * fate.size)
        stuck = round(self.stuck * fate.size)
        out = np.where((fate >= dead) & (fate < dead + stuck), level * scale, out)
        out = np.where(fate < dead, 0.0, out)
        if self.full_scale is not None:
            out = np.minimum(out, self.full_scale)
        if self.bits is not None and scale > 0:
            step = scale / (2**self.bits - 1)
            out = np.round(out / step) * step
        return out.reshape(given.shape)


def _leak(frames: Floats, share: float) -> Floats:
    padded = np.pad(frames, ((0, 0), (1, 1), (1, 1)))
    around = padded[:, :-2, 1:-1] + padded[:, 2:, 1:-1] + padded[:, 1:-1, :-2] + padded[:, 1:-1, 2:]
    return (1.0 - 4.0 * share) * frames + share * around


def taxel_stress(press: PressedSolid) -> Floats:
    """Return the true mean stress over each taxel at the skin's sensing depth, shape `press.shape`.

    Raises
    ------
    InputError
        If the press was solved on a grid too coarse for the sensing depth.
    """
    rows, cols = press.pressure.shape
    per_taxel = rows // press.shape[0]
    cells = Cells(rows, cols, press.pitch_m[0] / per_taxel, press.pitch_m[1] / per_taxel)
    frame = transmission_of(press.skin, cells, per_taxel).forward(press.pressure)
    return np.asarray(frame, dtype=np.float64)


def sense(press: PressedSolid, taxels: Taxels | None = None, *, seed: int = 0) -> Floats:
    """Return the frame that a pad under the skin reports of a press.

    Parameters
    ----------
    press : PressedSolid
        The press; it knows the skin, the pad's shape and its pitch.
    taxels : Taxels, optional
        How the taxels depart from ideal ones; default: not at all.
    seed : int
        Seed of the pad and its noise.

    Returns
    -------
    ndarray of shape `press.shape`, float64
        In the unit of `press.pressure`.

    Examples
    --------
    >>> from varishold.skin import Skin, press
    >>> from varishold.solids import Sphere
    >>> skin = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)
    >>> frame = sense(press(Sphere(20e-3), skin, depth=1e-3), Taxels(noise=0.01), seed=1)
    >>> frame.shape
    (32, 32)
    """
    require_a(PressedSolid, press, "press", "as press(solid, skin) gives it")
    stress = taxel_stress(press)
    return stress if taxels is None else taxels.read(stress, seed=seed)
