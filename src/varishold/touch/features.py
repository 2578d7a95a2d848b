"""A scikit-learn transformer: from frames to the named numbers of their sections."""

from __future__ import annotations

import math
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from varishold.errors import InputError
from varishold.frame import frame_noise
from varishold.frame.checks import as_floor, as_mask, squarest_grid
from varishold.frame.floor import FLOOR_SIGMAS
from varishold.levelset.contacts import find_contacts
from varishold.levelset.joined import join_sections
from varishold.levelset.profile import Profile

__all__ = ["SurfaceFeatures"]

_PER_SECTION = (
    "area",
    "perimeter",
    "x",
    "y",
    "variance_x",
    "covariance_xy",
    "variance_y",
    "length",
    "breadth",
)
# What is measured of a section as `join_sections` calls it, and what that is made of.
_JOINED = ("area", "perimeter", "x", "y", "xx", "xy", "yy", "length", "breadth")
_OF_CONTACTS = ("area", "perimeter", "centroid", "covariance")
_WHOLE = ("total", "peak", "touched_area", "x", "y", "contacts")
# The noise is one number of the sensor: the median over so many frames is steady enough.
_NOISE_FRAMES = 500


class SurfaceFeatures(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Turn frames into the areas, outlines, moments and growth of their sections.

    A frame is cut at absolute thresholds, learned from the training frames alone, and at fixed shares of its
    own peak. At each threshold the sections of all its contacts are taken together. Lengths are in taxels,
    positions (x, y) count from the pad's centre, and what is measured of an empty section is 0.

    Parameters
    ----------
    shape : (rows, cols) or (pads, rows, cols), optional
        What a flat sample holds. Default: the shape of the frames, if `fit` gets frames; for flat samples the
        squarest grid that holds them without a rest, not more rows than columns (12 values are 3 x 4, a prime
        number of values is one row).
    levels : int, default 10
        Number of absolute thresholds: quantiles of the taxels above the floor in training.
    relative_levels : int, default 6
        Number of thresholds between the floor and a frame's own peak, evenly at half steps.
    pairs : bool, default False
        Whether to add, for every two pads, the mean and the difference of each number: what the opposite
        fingers of a grip say together.
    field : array_like of shape (rows, cols) or (pads, rows, cols), bool, optional
        False where a pad has no taxel.
    floor : float, optional
        The standard plane delta. Default: four sigma of the noise, the median over training frames.

    Attributes
    ----------
    shape_ : tuple of int
        (rows, cols) or (pads, rows, cols).
    floor_ : float
        The standard plane, in the unit of the frames.
    levels_ : ndarray of shape (levels,), float64
        The absolute thresholds, falling: level 1 is the highest.
    relative_levels_ : ndarray of shape (relative_levels,), float64
        Shares of the way from the floor to the peak, falling.
    n_features_in_ : int
        Number of values of a flat sample.

    Notes
    -----
    Where two contacts of a frame meet at a saddle (see `find_contacts`), each one's section at a threshold
    below it is taken to be the one nearest above it.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.solids import Cone, Sphere, ideal_frame
    >>> frames = np.stack([ideal_frame(solid, (16, 16), 1.0) for solid in (Cone(10.0, 4.0), Sphere(10.0))])
    >>> features = SurfaceFeatures(levels=4, relative_levels=2).fit(frames)
    >>> features.transform(frames).shape
    (2, 64)
    >>> features.get_feature_names_out()[[0, 36, 54, 58]].tolist()
    ['area_above_level_1', 'area_above_0.75_of_peak', 'growth_from_level_1_to_2', 'total']
    """

    def __init__(
        self,
        shape: tuple[int, ...] | None = None,
        *,
        levels: int = 10,
        relative_levels: int = 6,
        pairs: bool = False,
        field: ArrayLike | None = None,
        floor: float | None = None,
    ) -> None:
        self.shape = shape
        self.levels = levels
        self.relative_levels = relative_levels
        self.pairs = pairs
        self.field = field
        self.floor = floor

    def fit(self, X: Any, y: Any = None) -> SurfaceFeatures:
        """Learn the floor and the absolute thresholds.

        Parameters
        ----------
        X : array_like of shape (n, rows, cols), (n, pads, rows, cols) or (n, n_values)
            Frames, or flat samples.
        y : None
            Not used.

        Returns
        -------
        SurfaceFeatures
            Itself.

        Raises
        ------
        InputError
            If a parameter is out of range or does not fit the frames.
        """
        for name, least in (("levels", 0), ("relative_levels", 0)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
                raise InputError(f"{name} must be a whole number, at least {least}, got {value!r}")
        if self.levels + self.relative_levels == 0:
            raise InputError("levels and relative_levels are both 0: no section to measure")
        frame_shape, X = _flat(X)
        X = validate_data(self, X, dtype=np.float64, order="C")
        self.shape_ = self._fitting_shape(frame_shape, X.shape[1])
        self._field_ = self._fitting_field()
        frames = X.reshape(-1, *self.shape_[-2:])
        self.floor_ = self._fitting_floor(frames)
        inside = np.broadcast_to(self._field_, (len(X), *self._field_.shape)).reshape(frames.shape)
        above = frames[(frames > self.floor_) & inside]
        shares = (np.arange(self.levels, 0, -1) - 0.5) / max(self.levels, 1)
        self.levels_ = np.quantile(above, shares) if above.size else self.floor_ + shares
        self.relative_levels_ = (np.arange(self.relative_levels, 0, -1) - 0.5) / max(self.relative_levels, 1)
        return self

    def transform(self, X: Any) -> NDArray[np.float64]:
        """Measure frames.

        Parameters
        ----------
        X : array_like of shape (n, rows, cols), (n, pads, rows, cols) or (n, n_values)
            Frames of the shape that `fit` saw, or flat samples.

        Returns
        -------
        ndarray of shape (n, n_features), float64
            In the order of `get_feature_names_out`.

        Raises
        ------
        InputError
            If the frames have another shape than those of `fit`.
        """
        check_is_fitted(self)
        frame_shape, X = _flat(X)
        if frame_shape is not None and frame_shape != self.shape_:
            raise InputError(f"frames must have the shape that fit saw, {self.shape_}, got {frame_shape}")
        X = validate_data(self, X, dtype=np.float64, order="C", reset=False)
        rows, cols = self.shape_[-2:]
        frames = X.reshape(len(X), -1, rows, cols)
        pads = [self._measured(frames[:, k], self._field_[k]) for k in range(frames.shape[1])]
        if self.pairs:
            for a, b in combinations(range(frames.shape[1]), 2):
                pads += [0.5 * (pads[a] + pads[b]), pads[a] - pads[b]]
        return np.concatenate(pads, axis=1)

    def get_feature_names_out(self, input_features: Any = None) -> NDArray[np.object_]:
        """Return the name of every number that `transform` gives.

        Parameters
        ----------
        input_features : array_like of str, optional
            Not used but for its length, which must be `n_features_in_`.

        Returns
        -------
        ndarray of shape (n_features,), object
        """
        check_is_fitted(self)
        if input_features is not None and len(input_features) != self.n_features_in_:
            raise InputError(
                f"input_features should have length equal to number of features ({self.n_features_in_}), "
                f"got {len(input_features)}"
            )
        levels = [f"level_{i + 1}" for i in range(self.levels)]
        shares = [f"{share:.3g}_of_peak" for share in self.relative_levels_]
        names = [f"{measure}_above_{level}" for measure in _PER_SECTION for level in levels]
        names += [f"{measure}_above_{share}" for measure in _PER_SECTION for share in shares]
        for some in (levels, shares):
            names += [
                f"growth_from_{a.removesuffix('_of_peak')}_to_{b.removeprefix('level_')}" for a, b in pairwise(some)
            ]
        names += _WHOLE
        if len(self.shape_) == 3:
            n_pads = self.shape_[0]
            heads = [f"pad_{k}" for k in range(n_pads)]
            if self.pairs:
                for a, b in combinations(range(n_pads), 2):
                    heads += [f"mean_of_pads_{a}_and_{b}", f"difference_of_pads_{a}_and_{b}"]
            names = [f"{head}_{name}" for head in heads for name in names]
        return np.array(names, dtype=object)

    def _fitting_shape(self, frame_shape: tuple[int, ...] | None, n_values: int) -> tuple[int, ...]:
        if self.shape is None:
            return frame_shape or squarest_grid(n_values)
        shape = tuple(int(n) for n in self.shape)
        if len(shape) not in (2, 3) or min(shape) < 1:
            raise InputError(f"shape must be (rows, cols) or (pads, rows, cols), got {self.shape!r}")
        if frame_shape is not None and frame_shape != shape:
            raise InputError(f"frames must have shape {shape}, as `shape` says, got {frame_shape}")
        if math.prod(shape) != n_values:
            raise InputError(f"shape {shape} needs {math.prod(shape)} values a sample, got {n_values}")
        return shape

    def _fitting_field(self) -> NDArray[np.bool_]:
        pads = (1, *self.shape_)[-3:]
        if self.field is None:
            return np.ones(pads, np.bool_)
        shape = self.shape_ if np.ndim(self.field) == len(self.shape_) else self.shape_[-2:]
        return np.ascontiguousarray(np.broadcast_to(as_mask(self.field, shape, "field"), pads))

    def _fitting_floor(self, frames: NDArray[np.float64]) -> float:
        if self.floor is not None:
            return as_floor(self.floor)
        some = np.unique(np.linspace(0, len(frames) - 1, _NOISE_FRAMES).round().astype(int))
        fields = self._field_
        return FLOOR_SIGMAS * float(np.median([frame_noise(frames[i], fields[i % len(fields)]) for i in some]))

    def _measured(self, frames: NDArray[np.float64], field: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Return one pad's numbers, shape (n, n_features)."""
        n, n_levels, n_relative = len(frames), self.levels, self.relative_levels
        peaks = np.where(field, frames, -np.inf).max(axis=(1, 2)) if field.any() else np.full(n, self.floor_)
        span = np.maximum(peaks - self.floor_, 0.0)
        thresholds = np.concatenate(
            [np.broadcast_to(self.levels_, (n, n_levels)), self.floor_ + span[:, None] * self.relative_levels_], axis=1
        )
        order = np.argsort(-thresholds, axis=1, kind="stable")
        falling = np.take_along_axis(thresholds, order, axis=1)
        mask = None if field.all() else field
        owner, profiles = [], []
        for i in range(n):
            if span[i] > 0:
                contacts = find_contacts(frames[i], falling[i], field=mask, floor=self.floor_)
                owner += [i] * len(contacts)
                profiles += [contact.profile for contact in contacts]
        back = np.argsort(order, axis=1)
        sections = np.zeros((n, n_levels + n_relative, len(_PER_SECTION)))
        if profiles:
            sections = _joined(owner, profiles, n)
        sections = np.take_along_axis(sections, back[:, :, None], axis=1)
        absolute, relative = sections[:, :n_levels], sections[:, n_levels:]
        return np.concatenate(
            [
                absolute.transpose(0, 2, 1).reshape(n, -1),
                relative.transpose(0, 2, 1).reshape(n, -1),
                _growth(absolute[:, :, 0]),
                _growth(relative[:, :, 0]),
                _whole(np.where(field, frames, 0.0), self.floor_, np.bincount(owner, minlength=n)),
            ],
            axis=1,
        )


def _flat(X: Any) -> tuple[tuple[int, ...] | None, Any]:
    """Return the shape of one frame (None for flat samples) and the flat samples."""
    if isinstance(X, (list, tuple)) and X and np.ndim(X[0]) > 1:
        X = np.asarray(X)
    if getattr(X, "ndim", 2) in (3, 4):
        return tuple(X.shape[1:]), np.asarray(X).reshape(len(X), math.prod(X.shape[1:]))
    return None, X


def _joined(owner: list[int], profiles: list[Profile], n: int) -> NDArray[np.float64]:
    """Return what is measured of the sections of each frame's contacts together, shape (n, n_levels, 9)."""
    of = [np.stack([getattr(profile, name) for profile in profiles]) for name in _OF_CONTACTS]
    joined = join_sections(np.array(owner), n, *of)
    return np.stack([joined[name] for name in _JOINED], axis=-1)


def _growth(area: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each section's area as a share of the next lower one's, 0 where that is empty."""
    lower = area[:, 1:]
    return np.where(lower > 0, area[:, :-1] / np.where(lower > 0, lower, 1.0), 0.0)


def _whole(frames: NDArray[np.float64], floor: float, contacts: NDArray[np.int64]) -> NDArray[np.float64]:
    rows, cols = frames.shape[1:]
    height = np.maximum(frames - floor, 0.0)
    total = height.sum(axis=(1, 2))
    safe = np.where(total > 0, total, np.inf)
    x = (height.sum(axis=1) @ (np.arange(cols) - 0.5 * (cols - 1))) / safe
    y = (height.sum(axis=2) @ (np.arange(rows) - 0.5 * (rows - 1))) / safe
    peak, touched = height.max(axis=(1, 2)), (height > 0).sum(axis=(1, 2))
    return np.stack([total, peak, touched, x, y, contacts], axis=1).astype(np.float64)
