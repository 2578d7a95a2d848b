"""Why an answer was given: which measures decided, and the training press that is most like it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold.learning.discriminant import blocks, differences, distances
from varishold.learning.sources import Learned, Source, view_name

__all__ = ["deciding_measures", "nearest_landmark", "outside_measures"]

Floats = NDArray[np.float64]

# Standard deviations beyond the training presses that are still within them.
_WITHIN = 1.0


def nearest_landmark(source: Source, scaled: Floats) -> int:
    """Return which landmark a press is nearest to where classes lie apart.

    Parameters
    ----------
    source : Source
    scaled : ndarray of shape (1, n_measures), float64
        Its standardized measures.
    """
    squared = np.zeros(len(source.landmarks))
    for view in source.views:
        power = view.discriminant.power
        at = view.discriminant.coordinates(distances(scaled, source.landmarks, power))
        squared += ((source.places[power] - at) ** 2).sum(axis=1) / view.temperature
    return int(np.argmin(squared))


def deciding_measures(
    learned: Learned, scaled: Mapping[str, Floats], names: Mapping[str, Sequence[str]], first: int, second: int
) -> list[tuple[str, float]]:
    """Return by how many nats each kind of measure speaks for the first class rather than the second, falling.

    That is what the odds lose where these measures are set to what is usual for the second class. Where fusing bounds
    the odds, for no view may contradict the others without end, each kind has its share of what is left.

    Parameters
    ----------
    learned : Learned
    scaled : mapping of str to ndarray of shape (1, n_measures), float64
        Standardized measures of each source.
    names : mapping of str to sequence of str
        The name of each measure; what differs only in where it is taken (``_at_...``, ``_to_...``) is of one kind.
    first, second : int
        Classes.
    """
    found, plain = [], 0.0
    for name, source in learned.sources.items():
        if np.isnan(scaled[name]).any():
            continue
        kinds = _kinds(tuple(names[name]))
        usual = source.landmarks[learned.landmark_codes == second].mean(axis=0)
        odds = np.zeros(1 + len(kinds.names))
        for view in source.views:
            power = view.discriminant.power
            apart = _apart_without_each(scaled[name][0], usual, source.landmarks, kinds, power)
            said = view.discriminant.judge(apart)[0] / view.temperature
            odds += learned.trust.weights[view_name(name, power)] * (said[:, first] - said[:, second])
        plain += float(odds[0])
        found += [(kind, float(odds[0] - odds[k + 1])) for k, kind in enumerate(kinds.names)]
    said, _ = learned.judge(scaled)
    fused = float(said[0, first] - said[0, second])
    bounded = fused / plain if 0 < fused < plain else 1.0
    return sorted(((kind, nats * bounded) for kind, nats in found), key=lambda one: -one[1])


def outside_measures(
    learned: Learned, scaled: Mapping[str, Floats], names: Mapping[str, Sequence[str]], most: int
) -> tuple[str, ...]:
    """Return which kinds of measures of a press lie beyond those of all landmarks, the farthest first.

    Parameters
    ----------
    learned, scaled, names
        As in `deciding_measures`.
    most : int
        So many at most.
    """
    beyond: dict[str, float] = {}
    for name, source in learned.sources.items():
        low, high = source.landmarks.min(axis=0), source.landmarks.max(axis=0)
        off = np.nan_to_num(np.maximum(low - scaled[name][0], scaled[name][0] - high))
        kinds = _kinds(tuple(names[name]))
        for kind, far in zip(kinds.of_run.tolist(), np.maximum.reduceat(off, kinds.starts).tolist(), strict=True):
            beyond[kinds.names[kind]] = max(beyond.get(kinds.names[kind], 0.0), far)
    told = sorted((kind for kind, far in beyond.items() if far > _WITHIN), key=lambda kind: -beyond[kind])
    return tuple(told[:most])


class _Kinds(NamedTuple):
    """Which measures are of one kind: they stand in runs. Where each begins, of which kind it is, the kinds' names."""

    starts: NDArray[np.intp]
    of_run: NDArray[np.intp]
    names: tuple[str, ...]


@lru_cache(maxsize=16)
def _kinds(names: tuple[str, ...]) -> _Kinds:
    """Return of which kind measures are: what their names say before they say where it is taken."""
    kinds = [re.sub(r"_(at|to)_.*", "", one) for one in names]
    starts = [k for k, kind in enumerate(kinds) if k == 0 or kinds[k - 1] != kind]
    different = tuple(dict.fromkeys(kinds))
    numbers = {kind: k for k, kind in enumerate(different)}
    return _Kinds(np.array(starts), np.array([numbers[kinds[k]] for k in starts]), different)


def _apart_without_each(scaled: Floats, usual: Floats, landmarks: Floats, kinds: _Kinds, power: int) -> Floats:
    """Return `distances` of a press, and of it with one kind of measure after another as is usual.

    Shape (1 + n_kinds, n_landmarks).
    """
    apart = np.empty((1 + len(kinds.names), len(landmarks)))
    member = (kinds.of_run[:, None] == np.arange(len(kinds.names))).astype(np.float64)
    for rows in blocks(landmarks.shape):
        mine, other = (differences(landmarks[rows], of, power) for of in (scaled, usual))
        apart[0, rows] = mine.sum(axis=1)
        other -= mine
        apart[1:, rows] = apart[0, rows] + (np.add.reduceat(other, kinds.starts, axis=1) @ member).T
    return apart / len(scaled)
