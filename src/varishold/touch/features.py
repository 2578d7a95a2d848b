"""A scikit-learn transformer: from frames, or presses, to the named numbers of their sections."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import combinations, product
from typing import Any, Literal

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from varishold._counted import counted
from varishold.errors import InputError
from varishold.frame import frame_noise
from varishold.frame.checks import as_floor, as_mask, squarest_grid
from varishold.frame.floor import FLOOR_SIGMAS
from varishold.levelset.table import MeasureTable
from varishold.touch.course.held import HeldFrames, one_size, press_floor
from varishold.touch.course.presses import Press, as_presses, flat_presses, is_flat
from varishold.touch.section_numbers import Cuts

__all__ = ["SurfaceFeatures"]

# The noise is one number of the sensor: the median over so many frames is steady enough.
_NOISE_FRAMES = 500
# So many taxels are one piece of work, which a processor's cache holds.
_TAXELS_AT_ONCE = 1 << 18


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
    per : {"frame", "press"}, default "frame"
        What a sample is. A press is zeroed on its rest, and what is measured is the mean over the frames that hold most
        of its load, at most six, as for `TactileClassifier`.
    levels : int, default 10
        Number of absolute thresholds: quantiles of the taxels above the floor in training.
    relative_levels : int, default 6
        Number of thresholds between the floor and a frame's own peak, evenly at half steps.
    pairs : bool, default False
        Whether to add, for every two pads, the mean and the difference of each number: what the opposite
        fingers of a grip say together.
    field : array_like of shape (rows, cols) or (pads, rows, cols), bool, optional
        False where a pad has no taxel. Default: what recordings say, and otherwise taxels everywhere.
    floor : float, optional
        The standard plane delta. Default: four sigma of the noise, the median over training frames or presses.
    n_jobs : int, optional
        Threads, as elsewhere in scikit-learn: -1 is one a processor. The numbers do not depend on it.

    Attributes
    ----------
    shape_ : tuple of int
        (rows, cols) or (pads, rows, cols).
    pads_ : tuple of str
        What the pads are called in the names of features: 0, 1 and so on, or as in the recordings.
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
    >>> features.table(frames)["contacts"].tolist()
    [1.0, 1.0]
    """

    def __init__(
        self,
        shape: tuple[int, ...] | None = None,
        *,
        per: Literal["frame", "press"] = "frame",
        levels: int = 10,
        relative_levels: int = 6,
        pairs: bool = False,
        field: ArrayLike | None = None,
        floor: float | None = None,
        n_jobs: int | None = None,
    ) -> None:
        self.shape = shape
        self.per = per
        self.levels = levels
        self.relative_levels = relative_levels
        self.pairs = pairs
        self.field = field
        self.floor = floor
        self.n_jobs = n_jobs

    def fit(self, X: Any, y: Any = None) -> SurfaceFeatures:
        """Learn the floor and the absolute thresholds.

        Parameters
        ----------
        X : array_like of shape (n, rows, cols), (n, pads, rows, cols) or (n, n_values); or presses
            Frames, or flat samples. Presses as `TactileClassifier` takes them: a sequence of recordings, of frames
            (n_frames, rows, cols) or (n_frames, pads, rows, cols), or of (frames, time_s); or an array of such frames.
        y : None
            Not used.

        Returns
        -------
        SurfaceFeatures
            Itself.

        Raises
        ------
        InputError
            If a parameter is out of range or does not fit the frames, or pads are of several sizes.
        """
        if self.per not in ("frame", "press"):
            raise InputError(f"per must be 'frame' or 'press', got {self.per!r}")
        for name in ("levels", "relative_levels"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 0:
                raise InputError(f"{name} must be a whole number, at least 0, got {value!r}")
        if self.levels + self.relative_levels == 0:
            raise InputError("levels and relative_levels are both 0: no section to measure")
        floor = None if self.floor is None else as_floor(self.floor)
        if self.per == "press":
            presses = self._presses(X, fitting=True)
            self.floor_ = press_floor(presses) if floor is None else floor
            frames = HeldFrames.of(presses, self._pads_, self.floor_).frames
        else:
            frames = self._frames(X, fitting=True)
            self.floor_ = self._noise_floor(frames) if floor is None else floor
        above = frames[(frames > self.floor_) & self._field_]
        quantiles, self.relative_levels_ = (
            (np.arange(n, 0, -1) - 0.5) / max(n, 1) for n in (self.levels, self.relative_levels)
        )
        self.levels_ = np.quantile(above, quantiles) if above.size else self.floor_ + quantiles
        return self

    def transform(self, X: Any) -> NDArray[np.float64]:
        """Measure frames, or presses.

        Parameters
        ----------
        X : array_like of shape (n, rows, cols), (n, pads, rows, cols) or (n, n_values); or presses
            As for `fit`, and of the shape and the pads that it saw.

        Returns
        -------
        ndarray of shape (n, n_features), float64
            In the order of `get_feature_names_out`.

        Raises
        ------
        InputError
            If frames have another shape, or presses other pads, than those of `fit`.
        """
        check_is_fitted(self)
        if self.per == "frame":
            return self._measured(self._frames(X))
        held = HeldFrames.of(self._presses(X), self._pads_, self.floor_)
        return held.mean(self._measured(held.frames))

    def table(self, X: Any) -> MeasureTable:
        """Return what `transform` gives as columns by name, to be written as CSV or turned into a DataFrame."""
        return MeasureTable(zip(self.get_feature_names_out().tolist(), np.asarray(self.transform(X)).T, strict=True))

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
        names = self._cuts.names()
        if len(self.shape_) == 3:
            heads = [f"pad_{name}" for name in self.pads_]
            if self.pairs:
                for a, b in combinations(self.pads_, 2):
                    heads += [f"mean_of_pads_{a}_and_{b}", f"difference_of_pads_{a}_and_{b}"]
            names = [f"{head}_{name}" for head in heads for name in names]
        return np.array(names, dtype=object)

    @property
    def pads_(self) -> tuple[str, ...]:
        """What the pads are called in the names of features."""
        return tuple(name.removeprefix("pad_") for name in self._pads_)

    @property
    def _cuts(self) -> Cuts:
        return Cuts(self.floor_, self.levels_, self.relative_levels_)

    def _frames(self, X: Any, *, fitting: bool = False) -> NDArray[np.float64]:
        """Return frames, shape (n, pads, rows, cols)."""
        frame_shape, X = _flat(X)
        if not fitting and frame_shape is not None and frame_shape != self.shape_:
            raise InputError(f"frames must have the shape that fit saw, {self.shape_}, got {frame_shape}")
        X = validate_data(self, X, dtype=np.float64, order="C", reset=fitting)
        if fitting:
            self._set_shape(frame_shape, X.shape[1])
        return np.asarray(X.reshape(len(X), *(1, *self.shape_)[-3:]))

    def _presses(self, X: Any, *, fitting: bool = False) -> list[Press]:
        """Return presses; `HeldFrames` sees to it that they have the pads of those that were learned from."""
        if is_flat(X):
            X = validate_data(self, X, dtype=np.float64, reset=fitting)
            if fitting:
                self._set_shape(None, X.shape[1])
            return flat_presses(X, self.shape_)
        presses = as_presses(X)
        if not presses:
            raise InputError("there is no press: give at least one")
        if fitting:
            shape = (len(presses[0].pads), *one_size(presses[0].shapes))
            self._set_shape(shape[1:] if shape[0] == 1 else shape, math.prod(shape), presses[0])
            self.n_features_in_ = math.prod(shape)
        return presses

    def _set_shape(self, given: tuple[int, ...] | None, n_values: int, press: Press | None = None) -> None:
        """Set what is known of the pads by the shape that samples have, None for flat ones."""
        self.shape_ = self._fitting_shape(given, n_values)
        n_pads, *size = (1, *self.shape_)[-3:]
        self._pads_ = {f"pad_{k}": (size[0], size[1]) for k in range(n_pads)} if press is None else press.shapes
        known = self.field
        if press is not None and known is None:
            known = np.array(list(press.fields.values())).reshape(self.shape_)
        self._field_ = np.ones((n_pads, *size), np.bool_)
        if known is not None:
            shape = self.shape_ if np.ndim(known) == len(self.shape_) else self.shape_[-2:]
            self._field_ &= as_mask(known, shape, "field")

    def _fitting_shape(self, frame_shape: tuple[int, ...] | None, n_values: int) -> tuple[int, ...]:
        if self.shape is None:
            return frame_shape or squarest_grid(n_values)
        given: Any = self.shape
        sizes = () if isinstance(given, str) or not isinstance(given, Iterable) else tuple(given)
        whole = all(isinstance(n, int | np.integer) and n > 0 for n in sizes)
        if len(sizes) not in (2, 3) or not whole:
            raise InputError(f"shape must be (rows, cols) or (pads, rows, cols), got {self.shape!r}")
        shape = tuple(map(int, sizes))
        if frame_shape is not None and frame_shape != shape:
            raise InputError(f"frames must have shape {shape}, as `shape` says, got {frame_shape}")
        if math.prod(shape) != n_values:
            raise InputError(f"shape {shape} needs {counted(math.prod(shape), 'value')} a sample, got {n_values}")
        return shape

    def _noise_floor(self, frames: NDArray[np.float64]) -> float:
        flat = frames.reshape(-1, *frames.shape[2:])
        some = np.unique(np.linspace(0, len(flat) - 1, _NOISE_FRAMES).round().astype(int))
        fields = self._field_
        return FLOOR_SIGMAS * float(np.median([frame_noise(flat[i], fields[i % len(fields)]) for i in some]))

    def _measured(self, frames: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the numbers of frames of shape (n, pads, rows, cols), shape (n, n_features)."""
        n, n_pads, rows, cols = frames.shape
        some = max(_TAXELS_AT_ONCE // (rows * cols), 1)
        found = Parallel(n_jobs=self.n_jobs, prefer="threads")(
            delayed(self._cuts.measure)(frames[start : start + some, pad], self._field_[pad])
            for pad, start in product(range(n_pads), range(0, n, some))
        )
        each = len(found) // n_pads
        pads = [np.concatenate(found[k * each : (k + 1) * each]) for k in range(n_pads)]
        if self.pairs:
            for a, b in combinations(range(n_pads), 2):
                pads += [0.5 * (pads[a] + pads[b]), pads[a] - pads[b]]
        return np.concatenate(pads, axis=1)


def _flat(X: Any) -> tuple[tuple[int, ...] | None, Any]:
    """Return the shape of one frame (None for flat samples) and the flat samples."""
    if isinstance(X, (list, tuple)) and X and np.ndim(X[0]) > 1:
        X = np.asarray(X)
    if getattr(X, "ndim", 2) in (3, 4):
        return tuple(X.shape[1:]), np.asarray(X).reshape(len(X), math.prod(X.shape[1:]))
    return None, X
