"""What one pad's frame says of the surface under it, as a few physical numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from varishold.skin import Relief, Skin, reconstruct

__all__ = ["MEASURES", "Footprint", "measure_pad"]

Floats = NDArray[np.float64]

#: The measures' names. Curvatures are convex positive; lengths and slopes enter as their logarithms or bounded.
MEASURES = (
    "curvature_along_cols",
    "curvature_along_rows",
    "curvature_greatest",
    "curvature_least",
    "quadratic_residual",
    "plane_residual",
    "kink_angle",
    "kink_gain",
    "kink_offset",
    "cross_kink_angle",
    "cross_kink_gain",
    "length",
    "breadth",
    "area_share",
    "cut_cols_most",
    "cut_cols_least",
    "cut_rows_most",
    "cut_rows_least",
    "rim_pressure",
    "peak_pressure",
    "peak_offset",
    "tail_along_cols",
    "tail_along_rows",
    "profile_curvature_cols",
    "profile_curvature_rows",
    "tilt_along_cols",
    "tilt_along_rows",
    "depth",
    "force",
    "noise",
    "rows",
    "cols",
    "pitch",
)

# Contacts on larger pads are looked at through a window of so many taxels, up to which the inversion is quick; it
# leaves so many taxels around what is pressed by more than this share of the peak.
_WINDOW, _MARGIN, _SKIRT = (16, 20), 2, 0.08
# Less than this share of the peak, or twice the noise, does not count in a pad's profiles.
_FAINT = 0.02
# Where no skin is known, the contact is what is pressed by more than this share of the peak.
_CUT = 0.25
# Every frame is inverted as if it had this noise, a share of its peak: a hand has a dozen shapes of pads, and their
# operators for every noise would not stay at hand.
_NOISE = 0.015
# Places of a kink that are tried, as shares of the contact's half length.
_KINKS = np.linspace(-0.6, 0.6, 7)
# A length by which curvatures become numbers of about 1. Metres.
_BEND_M = 0.02
# Sums of squares below this share of the spread are rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Footprint:
    """Where a pad is pressed, and the measures of that contact.

    Parameters
    ----------
    measures : ndarray of shape (n_measures,), float64
        In the order of `MEASURES`.
    centre_m : (float, float)
        Centre of pressure (x, y) from the pad's centre. Metres.
    area_share : float
        Part of the pad that is pressed.
    borders : (bool, bool, bool, bool)
        The pad's borders (left, right, top, bottom) that cut the contact.
    curvature_1_m : (float, float)
        Of the quadratic that fits the seen surface best, along columns and rows. 1/m; NaN without a skin.
    """

    measures: Floats
    centre_m: tuple[float, float]
    area_share: float
    borders: tuple[bool, bool, bool, bool]
    curvature_1_m: tuple[float, float]


def measure_pad(frame: Floats, skin: Skin | None, pitch_m: tuple[float, float], sigma: float) -> Footprint:
    """Measure a pad's frame through its skin, or as it is.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols)
        Finite, something on it.
    skin : Skin or None
        A skin of known modulus; None where nothing is known of it, so that pressure itself is measured.
    pitch_m : (float, float)
        (row, column) spacing of the taxels. Metres.
    sigma : float
        Standard deviation of the frame's noise.

    Returns
    -------
    Footprint
    """
    peak = float(frame.max())
    whole, window = frame, _window(frame, sigma)
    felt = np.where(whole > max(_FAINT * peak, 2 * sigma), whole, 0.0)
    frame = frame[window]
    if skin is not None:
        relief: Relief = reconstruct(frame, skin, pitch=pitch_m, noise=_NOISE * peak)
        level, load, mask, cell = relief.displacement, relief.pressure, relief.mask, relief.pitch_m
        if not mask.any():
            mask = load >= load.max()
        depth = float(level.max())
    else:
        load = np.maximum(frame, 0.0)
        mask, cell = _pressed(load), pitch_m
        # Without a skin pressure stands in for depth: a contact as deep as a taxel is wide, for want of a scale.
        level, depth = load / peak * pitch_m[0], 0.0
    rows, cols = level.shape
    y = (np.arange(rows) + 0.5) * cell[0] + (window[0].start - whole.shape[0] / 2) * pitch_m[0]
    x = (np.arange(cols) + 0.5) * cell[1] + (window[1].start - whole.shape[1] / 2) * pitch_m[1]
    area_share = float(mask.sum()) * cell[0] * cell[1] / (whole.size * pitch_m[0] * pitch_m[1])
    fit = _Fit(level, mask, x, y)
    taxel = float(np.sqrt(pitch_m[0] * pitch_m[1]))
    weight = load / load.sum()
    centre = float(weight.sum(axis=0) @ x), float(weight.sum(axis=1) @ y)
    edges = mask[:, 0], mask[:, -1], mask[0], mask[-1]
    cut = [float(edge.mean()) for edge in edges]
    inside = load[mask]
    ring = mask & ~ndimage.binary_erosion(mask, border_value=1, iterations=2 if skin is not None else 1)
    rim = float(load[ring].mean() / inside.mean()) if ring.any() else 1.0
    i, j = np.unravel_index(int(load.argmax()), load.shape)
    middle_x, middle_y = fit.middle
    off = float(np.hypot(x[j] - middle_x, y[i] - middle_y)) / (fit.long + taxel)
    force = float(whole.sum()) * pitch_m[0] * pitch_m[1]
    (along_angle, along_gain, along_off), (cross_angle, cross_gain, _) = fit.kink(0), fit.kink(1)
    values = np.array(
        [
            _bounded(fit.along[0] * _BEND_M),
            _bounded(fit.along[1] * _BEND_M),
            _bounded(fit.principal[0] * _BEND_M),
            _bounded(fit.principal[1] * _BEND_M),
            _log(fit.quadratic_residual / taxel),
            _log(fit.plane_residual / taxel),
            _bounded(3 * along_angle),
            along_gain,
            along_off,
            _bounded(3 * cross_angle),
            cross_gain,
            _log(fit.long / taxel),
            _log(fit.short / taxel),
            area_share,
            # A pad's two ends are alike.
            max(cut[:2]),
            min(cut[:2]),
            max(cut[2:]),
            min(cut[2:]),
            rim,
            float(np.log(inside.max() / inside.mean())),
            off,
            _tail(felt.sum(axis=0)),
            _tail(felt.sum(axis=1)),
            _bounded(_profile_bend(felt.mean(axis=0)) * 10),
            _bounded(_profile_bend(felt.mean(axis=1)) * 10),
            _bounded(5 * abs(fit.slope[0])),
            _bounded(5 * abs(fit.slope[1])),
            _log(depth / 1e-3) if skin is not None else 0.0,
            _log(force) if skin is not None else 0.0,
            _log(sigma / peak),
            float(np.log(whole.shape[0])),
            float(np.log(whole.shape[1])),
            float(np.log(taxel / 0.002)),
        ]
    )
    curvature = fit.along if skin is not None else (np.nan, np.nan)
    return Footprint(values, centre, area_share, (cut[0] > 0, cut[1] > 0, cut[2] > 0, cut[3] > 0), curvature)


def _window(frame: Floats, sigma: float) -> tuple[slice, slice]:
    """The part of a pad around its contact: of one size for all large pads, or the pad itself."""
    felt = frame > max(_SKIRT * frame.max(), 4 * sigma)
    bounds = []
    for k in range(2):
        size, most = frame.shape[k], _WINDOW[k]
        hit = np.flatnonzero(felt.any(axis=1 - k))
        low, high = max(int(hit[0]) - _MARGIN, 0), min(int(hit[-1]) + 1 + _MARGIN, size)
        if size <= most:
            bounds.append(slice(0, size))
        elif high - low > most:
            return slice(0, frame.shape[0]), slice(0, frame.shape[1])
        else:
            first = min(max((low + high - most) // 2, 0), size - most)
            bounds.append(slice(first, first + most))
    if frame.size <= _WINDOW[0] * _WINDOW[1]:
        return slice(0, frame.shape[0]), slice(0, frame.shape[1])
    return bounds[0], bounds[1]


def _bounded(value: float) -> float:
    return float(np.arcsinh(value))


def _log(value: float) -> float:
    return float(np.log(max(value, 0.0) + 1e-3))


def _pressed(load: Floats) -> NDArray[np.bool_]:
    """The heaviest connected piece above a share of the peak."""
    pieces, count = ndimage.label(load > _CUT * load.max(), structure=np.ones((3, 3)))
    if count <= 1:
        return pieces > 0
    weight = np.bincount(pieces.ravel(), weights=load.ravel())
    weight[0] = 0.0
    heaviest: NDArray[np.bool_] = pieces == int(weight.argmax())
    return heaviest


def _tail(profile: Floats) -> float:
    """How far the load along one way reaches beside its bulk: its kurtosis, 1.8 for an even load."""
    load = profile / profile.sum()
    at = np.arange(load.size) - float(load @ np.arange(load.size))
    second = float(load @ at**2)
    return float(np.log(float(load @ at**4) / max(second**2, 1e-6) + 0.1)) if second > 1e-6 else 1.0


def _profile_bend(line: Floats, cut: float = 0.4) -> float:
    """Minus the second difference of a profile over its peak, about its top, in taxels: flat 0, a rim negative."""
    top = int(line.argmax())
    peak = float(line[top])
    first = last = top
    while first > 0 and line[first - 1] > cut * peak:
        first -= 1
    while last < line.size - 1 and line[last + 1] > cut * peak:
        last += 1
    if last - first < 2:
        middle = min(max(top, 1), line.size - 2)
        first, last = middle - 1, middle + 1
    s = np.arange(first, last + 1) - (first + last) / 2
    square = s * s - (s * s).mean()
    return -2 * float(square @ line[first : last + 1]) / float(square @ square) / peak


class _Fit:
    """Plane, quadratic and hinges fitted to a surface over its contact."""

    def __init__(self, level: Floats, mask: NDArray[np.bool_], x: Floats, y: Floats) -> None:
        i, j = np.nonzero(mask)
        px, py, u = x[j], y[i], level[mask]
        self.middle = float(px.mean()), float(py.mean())
        px, py, u = px - self.middle[0], py - self.middle[1], u - u.mean()
        # A contact of one row or column bends nowhere across it: half a cell of spread keeps the fit in bounds.
        self._scale = max(float(np.sqrt((px * px + py * py).mean())), x[1] - x[0], y[1] - y[0])
        self._x, self._y, self._u = px / self._scale, py / self._scale, u
        linear = np.stack([np.ones_like(u), self._x, self._y], axis=1)
        plane = _solve(linear, u)
        self.plane_residual = float(np.sqrt(np.mean((u - linear @ plane) ** 2)))
        full = np.concatenate([linear, np.stack([self._x**2 / 2, self._x * self._y, self._y**2 / 2], axis=1)], axis=1)
        q = _solve(full, u)
        self._rss = float(np.sum((u - full @ q) ** 2))
        self.quadratic_residual = float(np.sqrt(self._rss / u.size))
        p, r = plane[1] / self._scale, plane[2] / self._scale
        self.slope = float(p), float(r)
        second = -q[3:] / self._scale**2
        self.along = float(second[0] / (1 + p * p) ** 1.5), float(second[2] / (1 + r * r) ** 1.5)
        bend, ways = np.linalg.eigh(np.array([[second[0], second[1]], [second[1], second[2]]]))
        order = np.argsort(-np.abs(bend))
        self.principal = float(bend[order[0]]), float(bend[order[1]])
        self._ways = ways[:, order].T
        self._linear = linear
        spread = np.linalg.eigvalsh(np.cov(np.stack([px, py])) if u.size > 1 else np.zeros((2, 2)))
        self.short, self.long = (float(np.sqrt(max(v, 0.0)) * np.sqrt(12)) for v in spread)

    def kink(self, which: int) -> tuple[float, float, float]:
        """Slope lost over the best hinge across a principal way, its gain over the quadratic's fit, and where."""
        way = self._ways[which]
        s = self._x * way[0] + self._y * way[1]
        half = max(float(np.abs(s).max()), 1e-6)
        design = np.empty((_KINKS.size, s.size, 4))
        design[:, :, :3] = self._linear
        design[:, :, 3] = np.abs(s - half * _KINKS[:, None])
        normal = np.einsum("kni,knj->kij", design, design)
        normal += 1e-6 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(4)
        right = np.einsum("kni,n->ki", design, self._u)
        found = np.linalg.solve(normal, right[..., None])[..., 0]
        residual = self._u - np.einsum("kni,ki->kn", design, found)
        rss = (residual**2).sum(axis=1)
        best = int(rss.argmin())
        spread = float(np.sum(self._u**2))
        gain = np.log((self._rss + _ROUNDING * spread + 1e-30) / (rss[best] + _ROUNDING * spread + 1e-30))
        return -2 * float(found[best, 3]) / self._scale, float(np.clip(gain, -4, 4)), float(abs(_KINKS[best]))


def _solve(design: Floats, values: Floats) -> Floats:
    normal: Floats = design.T @ design
    normal[np.diag_indices(len(normal))] += 1e-5 * float(np.trace(normal)) / len(normal)
    return np.asarray(np.linalg.solve(normal, design.T @ values), dtype=np.float64)
