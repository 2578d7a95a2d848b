"""Analog readings to switches: thermometer bits at chosen thresholds, the variable threshold once more."""

from __future__ import annotations

from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.circuit import Comparator, Netlist
from varishold.errors import InputError, require
from varishold.frame.checks import as_given
from varishold.grasp.estimator import BaseEstimator, TransformerMixin, check_is_fitted, feature_names, validate_data
from varishold.trust import learn_ranges

__all__ = ["MOST_CUT", "MOST_LEVELS", "ThresholdEncoder", "with_encoder"]

#: A channel of real numbers is counted in steps of about this part of its range: a 16-bit converter.
_COUNTS = 1 << 16
#: Counts beyond this do not fit the circuit's integers.
_LARGEST_COUNT = 2**31 - 1
#: Thresholds a channel, at most.
MOST_LEVELS = 1024
#: Differences of larger values, and single precision within a decision tree, could overflow.
MOST_CUT = 1e30


class ThresholdEncoder(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Turn taxels, joint angles or forces into on-off switches by comparing them with thresholds.

    Bit k of a channel is on iff ``value >= threshold k``; the thresholds of a channel rise, so that its
    bits fill up like a thermometer. Thresholds are whole counts of the channel's resolution, which is 1
    for whole numbers and a power of two otherwise, so that a circuit of integers compares exactly alike.

    Parameters
    ----------
    strategy : {"quantile", "even", "supervised"}, default "quantile"
        Where thresholds lie: at equal shares of the training values above the channel's lowest (a single one right
        above it where it is the commonest, else in the middle of all), at equal steps of its range, or where they tell
        most about the classes (needs y).
    levels : int, default 4
        Most thresholds a channel; one that varies less gets fewer, a constant one a single threshold.
    shared : bool, default False
        One set of thresholds for all channels, chosen from all their values: a plane that falls over a whole
        array. For channels of one kind; shifted copies (`shift_variants`) then keep their meaning.

    Attributes
    ----------
    thresholds_ : list of ndarray
        Rising thresholds of every channel, in the channel's unit.
    resolution_ : ndarray of shape (n_channels,)
        Size of one count of every channel.
    ranges_ : Ranges
        The least and the largest training value of every channel.

    Examples
    --------
    >>> ThresholdEncoder("even", levels=2).fit_transform([[0], [10], [20], [30]]).astype(int)
    array([[0, 0],
           [1, 0],
           [1, 1],
           [1, 1]])
    """

    def __init__(
        self,
        strategy: Literal["quantile", "even", "supervised"] = "quantile",
        levels: int = 4,
        *,
        shared: bool = False,
    ) -> None:
        self.strategy = strategy
        self.levels = levels
        self.shared = shared

    def fit(self, X: ArrayLike, y: ArrayLike | None = None) -> Self:
        """Choose thresholds.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_channels)
        y : array-like of shape (n_samples,), optional
            Classes, for ``strategy="supervised"``.

        Raises
        ------
        InputError
            Where an option is not one of those offered.
        """
        known = isinstance(self.strategy, str) and self.strategy in ("quantile", "even", "supervised")
        require(known, f"strategy must be quantile, even or supervised, got {self.strategy!r}")
        whole = isinstance(self.levels, int | np.integer) and 1 <= self.levels <= MOST_LEVELS
        require(whole, f"levels must lie between 1 and {MOST_LEVELS}, got {self.levels!r}")
        if self.strategy == "supervised":
            require(y is not None, "strategy 'supervised' requires y to be passed, but the target y is None")
            X, y = validate_data(self, X, y, dtype=np.float64)
        else:
            X = validate_data(self, X, dtype=np.float64)
        values = np.asarray(X, dtype=np.float64)
        beyond = np.argwhere(np.abs(values) > MOST_CUT)
        if len(beyond):
            row, channel = beyond[0]
            raise InputError(
                f"values to cut must lie within {MOST_CUT:g} of zero, got {values[row, channel]:g} "
                f"in row {row}, channel {channel} (counted from 0)"
            )
        classes = None if y is None else np.unique(np.asarray(y), return_inverse=True)[1].ravel()
        self.ranges_ = learn_ranges(values)
        if self.shared:
            step = _resolution(values.ravel())
            labels = None if classes is None else np.repeat(classes, values.shape[1])
            same = self._thresholds(values.ravel(), step, labels)
            self.resolution_ = np.full(values.shape[1], step)
            self.thresholds_ = [same] * values.shape[1]
            return self
        self.resolution_ = np.array([_resolution(column) for column in values.T])
        self.thresholds_ = [
            self._thresholds(column, step, classes) for column, step in zip(values.T, self.resolution_, strict=True)
        ]
        return self

    def transform(self, X: ArrayLike) -> NDArray[np.bool_]:
        """Compare, shape (n_samples, n_bits), bool: the bits of the first channel, then of the next."""
        check_is_fitted(self)
        values = np.asarray(validate_data(self, X, dtype=np.float64, reset=False))
        counts = [len(t) for t in self.thresholds_]
        channels = np.repeat(np.arange(len(counts)), counts)
        out = np.empty((len(values), len(channels)), dtype=np.bool_)
        step = max(1, 8_000_000 // len(channels))
        for start in range(0, len(values), step):
            rows = slice(start, start + step)
            np.greater_equal(values[rows][:, channels], np.concatenate(self.thresholds_), out=out[rows])
        return out

    def beyond(self, X: ArrayLike) -> NDArray[np.float64]:
        """Return how far every value lies beyond its channel's training values, shape (n_samples, n_channels).

        In switches, as if thresholds went on as close as within the range; 0 within it and where a value is no number.
        What never varied counts one range where it differs.
        """
        check_is_fitted(self)
        must = f"values must be numbers of shape (n_samples, {self.n_features_in_})"
        values = as_given(X, must)
        fits = values.ndim == 2 and values.shape[1] == self.n_features_in_ and values.dtype.kind in "biufO"
        require(fits, f"{must}, got {values.dtype} of shape {values.shape}")
        try:
            return self.levels * self.ranges_.beyond(values)
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"{must}, got {error}") from error

    def get_feature_names_out(self, input_features: ArrayLike | None = None) -> NDArray[np.object_]:
        """Name of every bit, like ``thumb>=12``."""
        check_is_fitted(self)
        names = feature_names(self, input_features)
        return np.array(
            [f"{name}>={t:g}" for name, row in zip(names, self.thresholds_, strict=True) for t in row],
            dtype=object,
        )

    @property
    def bits_per_channel_(self) -> NDArray[np.int64]:
        """How many bits each channel gives, shape (n_channels,)."""
        check_is_fitted(self)
        return np.array([len(t) for t in self.thresholds_], dtype=np.int64)

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.required = self.strategy == "supervised"
        tags.transformer_tags.preserves_dtype = []
        return tags

    def _thresholds(
        self, column: NDArray[np.float64], step: float, classes: NDArray[np.int64] | None
    ) -> NDArray[np.float64]:
        low, high = float(column.min()), float(column.max())
        if low == high:
            wanted = np.array([low])
        elif self.strategy == "even":
            wanted = low + (high - low) * np.arange(1, self.levels + 1) / (self.levels + 1)
        elif self.strategy == "quantile":
            # A resting sensor repeats its lowest value; thresholds belong where it says something.
            above = column[column > low]
            wanted = np.quantile(above, np.arange(self.levels) / self.levels)
            if self.levels == 1 and not _rests(column):
                # The lowest but one would part the lowest alone from all others.
                wanted = np.maximum(wanted, np.median(column))
        else:
            assert classes is not None
            wanted = _telling(column, classes, self.levels)
        return np.unique(_whole_counts(column, wanted, step)) * step


def _rests(column: NDArray[np.float64]) -> bool:
    """Tell whether the lowest value is the commonest."""
    _, times = np.unique(column, return_counts=True)
    return bool((times[0] > times[1:]).all())


def _whole_counts(column: NDArray[np.float64], wanted: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return thresholds in whole counts that part the training values as those that are wanted do."""
    values = np.sort(column)
    first = np.minimum(np.searchsorted(values, wanted), len(values) - 1)
    reaching, below = values[first], np.where(first > 0, values[first - 1], -np.inf)
    up, down = np.ceil(wanted / step), np.floor(reaching / step)
    # A value between counts, on which a threshold lies, would not reach the count above it.
    return np.where((up * step > reaching) & (down * step > below), down, up)


def _resolution(column: NDArray[np.float64]) -> float:
    """1 for whole numbers; else the power of two that divides the range into about 2**16 counts."""
    if np.all(column == np.trunc(column)) and np.abs(column).max() <= _LARGEST_COUNT:
        return 1.0
    largest = float(np.abs(column).max())
    span = float(column.max() - column.min()) or largest
    step = 2.0 ** np.floor(np.log2(max(span / _COUNTS, 2.0**-1000)))
    # Far from zero the counts themselves must still fit the circuit.
    smallest = 2.0 ** np.ceil(np.log2(max(largest, 1e-300) / (_LARGEST_COUNT // 4)))
    return float(max(step, smallest, 2.0**-1000))


def _telling(column: NDArray[np.float64], classes: NDArray[np.int64], levels: int) -> NDArray[np.float64]:
    """Thresholds that tell most about the classes: the splits of a small decision tree."""
    from sklearn.tree import DecisionTreeClassifier

    tree = DecisionTreeClassifier(max_leaf_nodes=levels + 1, criterion="entropy", random_state=0)
    # It reads in single precision, in which steps far from zero are none.
    low = float(column.min())
    tree.fit((column - low)[:, None], classes)
    splits = low + tree.tree_.threshold[tree.tree_.feature >= 0]
    return np.asarray(np.sort(splits) if len(splits) else [np.median(column)], dtype=np.float64)


def with_encoder(netlist: Netlist, encoder: ThresholdEncoder, channels: tuple[str, ...]) -> Netlist:
    """Put an encoder's comparators before a netlist over its bits: counts in, class out.

    A count is ``floor(value / resolution_)`` of its channel.
    """
    counts = [np.rint(t / s).astype(np.int64) for t, s in zip(encoder.thresholds_, encoder.resolution_, strict=True)]
    comparators = tuple(Comparator(k, int(t)) for k, row in enumerate(counts) for t in row)
    return Netlist(channels, comparators, netlist.units, netlist.terms, netlist.scores, netlist.classes)
