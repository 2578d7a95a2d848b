"""Whether what is felt is outside of what is known: beyond all that a library's examples have shown of a number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.perceive.metric import Metric
from varishold.perceive.name_evidence import NameEvidence
from varishold.trust import Ranges, conformal_p_value, held_out_beyond, learn_ranges, least_error, merged_p_value

__all__ = ["Beyond", "Look", "SeenRange", "answers_look", "range_look", "seen_range"]

Floats = NDArray[np.float64]

# Standard units are compared in such steps, as a library's file keeps them.
_PER_UNIT = 20
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Beyond:
    """The number of a touch that lies farthest beyond all examples.

    Parameters
    ----------
    name : str
    parts : float
        By how many parts of the number's range; 0 where every number lies within its own.
    """

    name: str
    parts: float


@dataclass(frozen=True, eq=False)
class SeenRange:
    """The ranges of a touch's numbers over a library's examples.

    Parameters
    ----------
    metric : Metric
    ranges : Ranges
        Of its standard units.
    known : ndarray of shape (n,)
        How far each example lies beyond all others, in parts of the range; NaN where the touch was not made.
    """

    metric: Metric
    ranges: Ranges
    known: Floats

    def beyond(self, values: Floats) -> Beyond:
        """Return which of the numbers, shape (d,) and NaN where unknown, lies farthest beyond its range."""
        (parts,) = self.ranges.beyond(_steps(self.metric, values)[None])
        k = int(parts.argmax())
        return Beyond(self.metric.names[k], float(parts[k]))


def seen_range(metric: Metric, values: Floats) -> SeenRange:
    """Learn what examples have shown, shape (n, d); a row of NaN: the touch was not made."""
    steps, made = _steps(metric, values), np.isfinite(values).any(axis=1)
    known = np.full(len(values), np.nan)
    known[made] = held_out_beyond(steps[made]).max(axis=1)
    return SeenRange(metric, learn_ranges(steps), known)


@dataclass(frozen=True)
class Look:
    """One way of asking whether something known would feel as strange.

    Parameters
    ----------
    p_value : float
    limit : float
        At a p-value of at most this it is outside of what is known.
    """

    p_value: float
    limit: float

    @property
    def inside(self) -> float:
        """The p-value in parts of its limit: 1 or less is outside."""
        return self.p_value / self.limit


def range_look(touches: Sequence[tuple[SeenRange, Beyond]], error: float) -> Look:
    """Ask how rare it is that an example lies as far beyond all others in the same touches.

    Parameters
    ----------
    touches : sequence of (SeenRange, Beyond)
        What the library has seen of each touch that was made, and what lay beyond it.
    error : float
        The share of examples that may lie outside, where there are enough for it.

    Returns
    -------
    Look
        The conformal p-value; 1 where nothing lies beyond, or no example knows these touches.
    """
    known = np.fmax.reduce([seen.known for seen, _ in touches]) if touches else np.array([])
    known = known[np.isfinite(known)]
    farthest, limit = max((off.parts for _, off in touches), default=0.0), least_error(error, known.size)
    if not known.size:
        return Look(1.0, limit)
    return Look(conformal_p_value([farthest - _ROUNDING], known).item(), limit)


def answers_look(answers: Sequence[NameEvidence], objects: Sequence[str]) -> Look | None:
    """Ask how rare it is that other recognizers say so little of these objects; None where none was asked."""
    if not answers:
        return None
    said = merged_p_value([answer.p_of_these(objects) for answer in answers])
    return Look(said, min(answer.error for answer in answers))


def _steps(metric: Metric, values: Floats) -> Floats:
    return np.asarray(np.round(metric.standardized(values) * _PER_UNIT))
