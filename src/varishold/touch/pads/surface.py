"""The surface under one touched pad: flat, curved, an edge or a point, as likelihoods."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import FormatError, InputError
from varishold.files import open_archive
from varishold.frame import fill_invalid, frame_noise
from varishold.frame.checks import as_floats, as_pitch, as_usable
from varishold.frame.floor import FLOOR_SIGMAS
from varishold.frame.repair import repair
from varishold.skin import Skin
from varishold.touch.network import KernelNetwork
from varishold.touch.pads.measures import MEASURES, Footprint, measure_pad
from varishold.touch.scale import small_gaps

__all__ = ["SURFACES", "PadSurface", "SurfaceName", "feel_surface"]

Floats = NDArray[np.float64]
SurfaceName = Literal["flat", "curved", "edge", "point"]

#: What a pad can lie on, in the order of every likelihood.
SURFACES: tuple[SurfaceName, ...] = ("flat", "curved", "edge", "point")

_PARAMETERS = Path(__file__).with_name("parameters.npz")
# A radius is told where a curved surface is at least so probable among equals.
_LEAST_CURVED = 0.05
# Pads are apart by at least this and at most that. Metres.
_LEAST_PITCH_M, _GREATEST_PITCH_M = 1e-4, 0.05
_FEWEST_TAXELS = 3
#: Logarithm of the least and the greatest spread that the learned tables may give, so that nothing grows without bound.
LOG_SPREAD = (-4.0, 1.0)


@dataclass(frozen=True)
class PadSurface:
    """What presses one pad.

    Parameters
    ----------
    log_likelihood : ndarray of shape (4,), float64
        log p(measures | surface) in the order of `SURFACES`, up to a constant common to all four.
    curvature_1_m : (float, float)
        Curvature along the pad's columns and along its rows, convex positive, 0 where flat. 1/m.
    curvature_sigma_1_m : (float, float)
        Standard deviations of the two. 1/m.
    radius_m : float or None
        Least radius of curvature if the surface is a curved one; None where that is out of the question.
    radius_interval_m : (float, float) or None
        Holds the radius of a curved surface with a probability of .95.
    measures : ndarray of shape (n_measures,), float64
        What was measured, in the order of `MEASURES`.
    centre_m : (float, float)
        Centre of pressure (x, y) from the pad's centre. Metres.
    force_n : float
        Sum of the frame over the pad's area; newtons where the frame is in pascal.
    area_share : float
        Part of the pad that is pressed.
    borders : (bool, bool, bool, bool)
        Which borders of the pad (left, right, top, bottom) cut the contact.
    reasons : tuple of str
        What speaks for the name, in words.
    """

    log_likelihood: Floats
    curvature_1_m: tuple[float, float]
    curvature_sigma_1_m: tuple[float, float]
    radius_m: float | None
    radius_interval_m: tuple[float, float] | None
    measures: Floats
    centre_m: tuple[float, float]
    force_n: float
    area_share: float
    borders: tuple[bool, bool, bool, bool]
    reasons: tuple[str, ...]

    def posterior(self, prior: ArrayLike | None = None) -> Floats:
        """Probability of each of `SURFACES`.

        Parameters
        ----------
        prior : array_like of shape (4,), optional
            Before the touch; need not sum to 1. Default: all alike.

        Returns
        -------
        ndarray of shape (4,), float64

        Raises
        ------
        InputError
            If the prior is not four finite numbers that are not negative, one of them positive.
        """
        weight = np.ones(len(SURFACES)) if prior is None else np.asarray(prior, dtype=np.float64)
        if weight.shape != (len(SURFACES),) or not np.isfinite(weight).all() or weight.min() < 0 or weight.max() <= 0:
            raise InputError(f"prior must be {len(SURFACES)} weights of {', '.join(SURFACES)}, got {prior!r}")
        p = weight * np.exp(self.log_likelihood - self.log_likelihood.max())
        out: Floats = p / p.sum()
        return out

    @property
    def by_name(self) -> dict[SurfaceName, float]:
        """`log_likelihood` of each surface."""
        return dict(zip(SURFACES, self.log_likelihood.tolist(), strict=True))

    @property
    def name(self) -> SurfaceName:
        """The likeliest surface."""
        return max(SURFACES, key=self.by_name.__getitem__)

    @property
    def probability(self) -> float:
        """Probability of `name` where all surfaces were alike before the touch."""
        return float(self.posterior().max())


def feel_surface(
    frame: ArrayLike,
    skin: Skin | None,
    *,
    pitch_m: float | tuple[float, float],
    field: ArrayLike | None = None,
    valid: ArrayLike | None = None,
) -> PadSurface | None:
    """Say what surface presses a pad.

    Parameters
    ----------
    frame : array_like of shape (rows, cols)
        Stress over each taxel; pascal where a skin of known modulus is given.
    skin : Skin or None
        The pad's skin, through which the surface is seen. Without one, or without its modulus, pressure itself is
        looked at, which says less.
    pitch_m : float or (float, float)
        Taxel spacing, one for both ways or (row, column). Metres.
    field : array_like of shape (rows, cols), bool, optional
        False where there is no taxel.
    valid : array_like of shape (rows, cols), bool, optional
        False where a taxel is broken; it is filled from its neighbours.

    Returns
    -------
    PadSurface or None
        None where nothing presses.

    Raises
    ------
    InputError
        If the frame is not finite with 3 x 3 taxels or more, a mask has another shape, no taxel works, or the pitch
        is impossible.

    Examples
    --------
    >>> from varishold.skin import Taxels, press, sense
    >>> skin = Skin("layer", thickness_m=4e-3, poisson=0.45, sensing_depth_m=1e-3, youngs_modulus_pa=1.5e5)
    >>> x = (np.arange(40) + 0.5 - 20) * 1e-3
    >>> bar = np.broadcast_to(-(x**2) / (2 * 0.04), (16, 40))  # a bar of 40 mm radius across the pad
    >>> frame = sense(press(bar, skin, force=3.0, shape=(8, 20), pitch_m=2e-3), Taxels(noise=0.01), seed=1)
    >>> felt = feel_surface(frame, skin, pitch_m=2e-3)
    >>> felt.name, felt.radius_interval_m[0] < 0.04 < felt.radius_interval_m[1]
    ('curved', True)
    """
    if skin is not None and not isinstance(skin, Skin):
        raise InputError(f"skin must be a Skin or None, got {skin!r}")
    spacing = _spacing(pitch_m)
    given = _filled(frame, field, valid)
    peak = float(given.max())
    sigma = float(frame_noise(given)) if peak > 0 else 0.0
    if peak <= 0 or peak <= FLOOR_SIGMAS * sigma:
        return None
    seen_through = skin is not None and skin.youngs_modulus_pa is not None
    foot = measure_pad(given, skin if seen_through else None, spacing, sigma)
    network, table = _load("seen" if seen_through else "bare")
    white = np.clip((foot.measures - table["shift"]) * table["scale"], -table["clip"], table["clip"])
    likelihood, bend, log_spread = np.split(network.outputs(white), (len(SURFACES), len(SURFACES) + 3))
    likelihood -= likelihood.max()
    spread = np.exp(np.clip(log_spread, *LOG_SPREAD))
    curvature = np.sinh(bend[:2]) / table["bend_m"]
    curvature_sigma = np.cosh(bend[:2]) * spread[:2] / table["bend_m"]
    curved = float(np.exp(likelihood[1]) / np.exp(likelihood).sum())
    radius, interval = None, None
    if curved >= _LEAST_CURVED:
        reach = float(spread[2] * table["reach"])
        radius = float(np.exp(-bend[2]))
        interval = float(np.exp(-bend[2] - reach)), float(np.exp(-bend[2] + reach))
    return PadSurface(
        log_likelihood=likelihood,
        curvature_1_m=(float(curvature[0]), float(curvature[1])),
        curvature_sigma_1_m=(float(curvature_sigma[0]), float(curvature_sigma[1])),
        radius_m=radius,
        radius_interval_m=interval,
        measures=foot.measures,
        centre_m=foot.centre_m,
        force_n=float(given.sum()) * spacing[0] * spacing[1],
        area_share=foot.area_share,
        borders=foot.borders,
        reasons=_reasons(foot, likelihood, curvature, curvature_sigma, radius),
    )


def _spacing(pitch_m: float | tuple[float, float]) -> tuple[float, float]:
    spacing = as_pitch(pitch_m)
    if not _LEAST_PITCH_M <= min(spacing) <= max(spacing) <= _GREATEST_PITCH_M:
        raise InputError(
            f"pitch_m must lie in [{_LEAST_PITCH_M:g}, {_GREATEST_PITCH_M:g}] metres, got {pitch_m!r}; "
            "is it in millimetres?"
        )
    return spacing


def _filled(frame: ArrayLike, field: ArrayLike | None, valid: ArrayLike | None) -> Floats:
    """The frame, broken taxels and small gaps filled, what is found dead too, and nothing where there is no taxel."""
    given = as_floats(frame, 2, "a pad's frame", masked=True)
    if min(given.shape) < _FEWEST_TAXELS:
        raise InputError(f"a pad's frame must have 3 x 3 taxels or more, got an array of shape {given.shape}")
    there, works = as_usable(given, given.shape, field), as_usable(frame, given.shape, None, valid)
    if not there.all():
        gaps = small_gaps(there)
        there, works = there | gaps, works & ~gaps
    strange = ~np.isfinite(given) & there & works
    if strange.any():
        row, col = np.argwhere(strange)[0]
        raise InputError(
            f"a pad's frame must be finite, got {given[row, col]} at (row, col) = ({row}, {col}); "
            "mark broken taxels in valid"
        )
    return repair(
        given if (there & works).all() else np.where(there, fill_invalid(given, works, there), 0.0), there
    ).values


@cache
def _load(variant: str) -> tuple[KernelNetwork, dict[str, Floats]]:
    """One network for likelihoods, curvatures and their spread, and the learned tables of one way of looking; once."""
    if not _PARAMETERS.is_file():
        raise FormatError(f"{_PARAMETERS}: no such table of parameters; make it by 'python -m training.pad_surfaces'")
    with open_archive(_PARAMETERS) as file:
        if tuple(file.array("measures").tolist()) != MEASURES or tuple(file.array("surfaces").tolist()) != SURFACES:
            raise FormatError(
                f"{_PARAMETERS}: made for other measures; make it again by 'python -m training.pad_surfaces'"
            )
        prefix = f"{variant}_"
        table = {
            key.removeprefix(prefix): np.asarray(file.array(key), dtype=np.float64)
            for key in file.names
            if key.startswith(prefix)
        }
    return _side_by_side(table), table


def _side_by_side(table: dict[str, Floats]) -> KernelNetwork:
    """Three networks that have nothing in common but their inputs as one, of one hidden layer."""
    parts = ("surface", "bend", "spread")
    first, bias_1, bias_2 = (
        np.concatenate([table[f"{part}_{key}"] for part in parts], axis=-1, dtype=np.float32)
        for key in ("weight_1", "bias_1", "bias_2")
    )
    inner = [table[f"{part}_weight_2"].astype(np.float32) for part in parts]
    second = np.block(
        [[of if of is to else np.zeros((len(of), to.shape[1]), np.float32) for to in inner] for of in inner]
    )
    shift, scale, clip = table["shift"], table["scale"], float(table["clip"])
    return KernelNetwork((first, second), (bias_1, bias_2), shift=shift, scale=scale, clip=clip, smooth=True)


def _reasons(
    foot: Footprint, likelihood: Floats, curvature: Floats, sigma: Floats, radius: float | None
) -> tuple[str, ...]:
    measure = dict(zip(MEASURES, foot.measures.tolist(), strict=True))
    order = np.argsort(-likelihood)
    odds = float(np.exp(min(likelihood[order[0]] - likelihood[order[1]], 20.0)))
    out = [f"{SURFACES[order[0]]} is {odds:.3g} times as likely as {SURFACES[order[1]]}"]
    out.append(
        f"it bends {curvature[0]:.0f} +- {sigma[0]:.0f} 1/m along the columns, "
        f"{curvature[1]:.0f} +- {sigma[1]:.0f} 1/m along the rows"
    )
    if radius is not None and order[0] == 1:
        out.append(f"its radius is about {1e3 * radius:.0f} mm")
    gain = measure["kink_gain"]
    out.append(f"a {'kink' if gain > 0 else 'bend'} fits its form better than a {'bend' if gain > 0 else 'kink'}")
    cut = [name for name, reached in zip(("left", "right", "top", "bottom"), foot.borders, strict=True) if reached]
    if cut:
        out.append(
            f"the pad's {' and '.join(cut)} border{'s' if len(cut) > 1 else ''} cut{'' if len(cut) > 1 else 's'} it"
        )
    return tuple(out)
