"""Why an answer was given: which measures decided, and the training press that is most like it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.learning.discriminant import distances
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
        kinds = _kinds(names[name])
        kind_names = list(dict.fromkeys(kinds.tolist()))
        usual = source.landmarks[learned.landmark_codes == second].mean(axis=0)
        member = (kinds[:, None] == np.array(kind_names)).astype(np.float64)
        odds = np.zeros(1 + len(kind_names))
        for view in source.views:
            power = view.discriminant.power
            apart = _apart_without_each(scaled[name][0], usual, source.landmarks, member, power)
            said = view.discriminant.judge(apart)[0] / view.temperature
            odds += learned.trust.weights[view_name(name, power)] * (said[:, first] - said[:, second])
        plain += float(odds[0])
        found += [(kind, float(odds[0] - odds[k + 1])) for k, kind in enumerate(kind_names)]
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
        for kind, far in zip(_kinds(names[name]).tolist(), off.tolist(), strict=True):
            beyond[kind] = max(beyond.get(kind, 0.0), far)
    told = sorted((kind for kind, far in beyond.items() if far > _WITHIN), key=lambda kind: -beyond[kind])
    return tuple(told[:most])


def _kinds(names: Sequence[str]) -> NDArray[np.str_]:
    """Return of which kind each measure is: without where it is taken."""
    return np.array([re.sub(r"_(at|to)_.*", "", one) for one in names])


def _apart_without_each(scaled: Floats, usual: Floats, landmarks: Floats, member: Floats, power: int) -> Floats:
    """Return `distances` of a press, and of it with each kind of measure as is usual, shape (1 + n_kinds, n_landmarks).

    `member` of shape (n_measures, n_kinds) tells which measure is of which kind.
    """
    mine, other = (np.abs(landmarks - of) ** power for of in (scaled, usual))
    changed = (mine.sum(axis=1) + ((other - mine) @ member).T) / len(scaled)
    return np.concatenate([mine.mean(axis=1)[None], changed])
