"""A scikit-learn transformer: from grasps of differing lengths to the named numbers of their loading."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from varishold.errors import InputError
from varishold.recording import Recording
from varishold.touch.course.loading import Loading, as_grasp, as_moments, grasp_floor, loading_features

__all__ = ["LoadingFeatures"]

# Moments looked at, as shares of the typical rise: close together at first, and some way into holding.
_FIRST_MOMENT, _LAST_MOMENT = 1 / 25, 1.25


class LoadingFeatures(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Turn grasps into the named numbers of how they are loaded in time.

    A grasp is a `Recording`, an array of frames, or a pair (frames, time_s); see `loading_features` for what is
    measured. From the training grasps alone it learns the standard plane and the moments after the onset at which
    the contacts are looked at.

    Parameters
    ----------
    field : array_like of shape (rows, cols) or (n_pads, rows, cols), bool, optional
        False where a pad has no taxel. Only for frames; a recording has its own.
    floor : float, optional
        The standard plane delta. Default: four sigma of the noise, the median over training grasps and pads.
    times : int or array_like of shape (n_times,), default 12
        So many moments, set by the median rise in training; or the moments themselves, in seconds (or frames).
    bands : int, default 4
        In how many bands of rows, and of columns, the onset travels over a pad; 0 leaves them out.
    pairs : bool, default True
        Whether to add, for every two pads, the mean and the difference of each number.
    span : float, optional
        Only so much time after the first pad's onset counts. Default: all of it.

    Attributes
    ----------
    floor_ : float
        The standard plane, in the unit of the frames.
    times_ : ndarray of shape (n_times,), float64
        The moments, in the unit of the clock.
    clock_ : {"seconds", "frames"}
        Frames where the training grasps had no time.
    names_ : tuple of str
        Name of each number.

    Examples
    --------
    >>> import numpy as np
    >>> force = np.clip(np.arange(12) - np.array([[2], [4]]), 0, 5)
    >>> frames = force.T[:, :, None, None] * np.ones((4, 4))
    >>> grasps = [(frames, 0.1 * np.arange(12)), (frames[:9], 0.05 * np.arange(9))]
    >>> LoadingFeatures(times=3).fit_transform(grasps).shape
    (2, 456)
    """

    def __init__(
        self,
        *,
        field: ArrayLike | None = None,
        floor: float | None = None,
        times: int | ArrayLike = 12,
        bands: int = 4,
        pairs: bool = True,
        span: float | None = None,
    ) -> None:
        self.field = field
        self.floor = floor
        self.times = times
        self.bands = bands
        self.pairs = pairs
        self.span = span

    def fit(self, X: Sequence[Any], y: Any = None) -> LoadingFeatures:
        """Learn the standard plane and the moments.

        Parameters
        ----------
        X : sequence of Recording, of frames, or of (frames, time_s)
            Grasps of any lengths, all of the same pads.
        y : None
            Not used.

        Returns
        -------
        LoadingFeatures
            Itself.

        Raises
        ------
        InputError
            If there is no grasp, one cannot be used, or they do not have the same pads and clock.
        """
        grasps = self._grasps(X)
        if not grasps:
            raise InputError("LoadingFeatures needs at least one grasp to learn from, got none")
        self.floor_ = (
            float(np.median([grasp_floor(list(grasp.pads.values())) for grasp in grasps]))
            if self.floor is None
            else self.floor
        )
        if isinstance(self.times, (int, np.integer)) and not isinstance(self.times, bool):
            if self.times < 0:
                raise InputError(f"times must be a whole number, at least 0, or the moments, got {self.times}")
            self.times_ = np.array([])
            rises = [self._typical_rise(self._measured(grasp, k)) for k, grasp in enumerate(grasps)]
            known = np.array([rise for rise in rises if rise > 0])
            rise = float(np.median(known)) if known.size else 1.0
            self.times_ = rise * np.geomspace(_FIRST_MOMENT, _LAST_MOMENT, self.times)
        else:
            self.times_ = as_moments(self.times)
        first = self._measured(grasps[0], 0)
        self.names_, self.clock_ = first.names, first.clock
        self._sizes_ = _sizes(grasps[0])
        for k, grasp in enumerate(grasps):
            self._compare(grasp, k)
        return self

    def transform(self, X: Sequence[Any]) -> NDArray[np.float64]:
        """Measure grasps.

        Parameters
        ----------
        X : sequence of Recording, of frames, or of (frames, time_s)
            Grasps of the pads that `fit` saw, of any lengths.

        Returns
        -------
        ndarray of shape (n_grasps, n_features), float64
            In the order of `get_feature_names_out`; always finite.

        Raises
        ------
        InputError
            If a grasp cannot be used or has other pads or another clock than those of `fit`.
        """
        check_is_fitted(self)
        grasps = self._grasps(X)
        for k, grasp in enumerate(grasps):
            self._compare(grasp, k)
        rows = [self._measured(grasp, k).values for k, grasp in enumerate(grasps)]
        return np.stack(rows) if rows else np.empty((0, len(self.names_)))

    def get_feature_names_out(self, input_features: Any = None) -> NDArray[np.object_]:
        """Return the name of every number that `transform` gives, shape (n_features,)."""
        check_is_fitted(self)
        return np.array(self.names_, dtype=object)

    def _grasps(self, X: Sequence[Any]) -> list[Recording]:
        if isinstance(X, Recording) or not isinstance(X, (Sequence, np.ndarray)):
            raise InputError(f"grasps must be a sequence of recordings, frames or (frames, time_s), got {type(X)}")
        grasps = []
        for k, given in enumerate(X):
            paired = isinstance(given, tuple) and len(given) == 2
            frames, time_s = given if paired else (given, None)
            try:
                grasps.append(as_grasp(frames, time_s, self.field))
            except InputError as error:
                raise InputError(f"grasp {k}: {error}") from error
        return grasps

    def _measured(self, grasp: Recording, k: int) -> Loading:
        try:
            return loading_features(
                grasp, floor=self.floor_, times=self.times_, bands=self.bands, pairs=self.pairs, span=self.span
            )
        except InputError as error:
            raise InputError(f"grasp {k}: {error}") from error

    def _typical_rise(self, loading: Loading) -> float:
        """Return the time to 95 % of the load, the median over touched pads; 0 where none is."""
        ends = [
            value
            for name, value in zip(loading.names, loading.values, strict=True)
            if name.endswith("_time_to_0.95_of_load") and not name.startswith(("mean_of_", "difference_of_"))
        ]
        return float(np.median([value for value in ends if value > 0] or [0.0]))

    def _compare(self, grasp: Recording, k: int) -> None:
        clock = "frames" if grasp.time_s is None else "seconds"
        if clock != self.clock_:
            raise InputError(f"grasp {k} has times in {clock}, the grasps of fit in {self.clock_}")
        pads, known = _sizes(grasp), self._sizes_
        if list(pads) != list(known):
            raise InputError(f"grasp {k} has the pads {', '.join(pads)}, those of fit were {', '.join(known)}")
        for name, size in pads.items():
            if size != known[name]:
                raise InputError(f"grasp {k}: its pad {name} has {size} taxels, that of fit had {known[name]}")


def _sizes(grasp: Recording) -> dict[str, str]:
    """How many taxels each pad has, by its name."""
    return {name: f"{pad.shape[0]} x {pad.shape[1]}" for name, pad in grasp.pads.items()}
