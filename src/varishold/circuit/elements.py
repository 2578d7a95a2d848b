"""What a netlist is made of: comparators, hyperplanes, product terms and class scores, all in integers."""

from __future__ import annotations

import itertools
import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from varishold.errors import InputError

__all__ = ["INT32_MAX", "Comparator", "Hyperplane", "Score", "Term", "shown"]

INT32_MAX: Final = 2**31 - 1


@dataclass(frozen=True, slots=True)
class Comparator:
    """One thermometer bit: ``value[channel] >= threshold``.

    Parameters
    ----------
    channel : int
        Index of the input channel.
    threshold : int
        In the counts of the channel, within 32 signed bits.
    """

    channel: int
    threshold: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "channel", _integer(self.channel, "channel of a comparator"))
        object.__setattr__(self, "threshold", _integer(self.threshold, "threshold of a comparator"))


@dataclass(frozen=True, slots=True)
class Hyperplane:
    """A unit: fires if and only if ``sum(weight * bit) > bias``, strictly.

    Parameters
    ----------
    weights : iterable of (int, int)
        Pairs (bit index, weight), in any order; kept sorted by index. No zeros, no index twice.
    bias : int
        A sum that equals the bias does not fire, as in eq. [25] of the paper.
    pair : (int, int), optional
        The training grasps (i, j) between which the hyperplane lies, oriented: it fires nearer to i.

    Examples
    --------
    >>> Hyperplane([(0, 1), (2, -1)], 0).weights
    ((0, 1), (2, -1))
    """

    weights: tuple[tuple[int, int], ...]
    bias: int
    pair: tuple[int, int] | None = None

    def __init__(self, weights: Iterable[tuple[int, int]], bias: int, pair: tuple[int, int] | None = None) -> None:
        object.__setattr__(self, "weights", _sparse(weights, "unit"))
        object.__setattr__(self, "bias", _integer(bias, "bias of a unit"))
        if pair is not None:
            first, second = pair
            pair = (_index(first, "pair of a unit"), _index(second, "pair of a unit"))
        object.__setattr__(self, "pair", pair)
        _check_reach(self.weights, self.bias, "unit")

    @classmethod
    def between(cls, first: Sequence[int], second: Sequence[int], pair: tuple[int, int] | None = None) -> Hyperplane:
        """Return the bisector of two binary patterns, which fires nearer to the first.

        It is a strict majority vote over the switches in which the two differ.

        Parameters
        ----------
        first, second : sequence of int, 0 or 1
            Two patterns of one length.
        pair : (int, int), optional
            Their indices among the training grasps.

        Examples
        --------
        >>> Hyperplane.between([1, 1, 0], [0, 1, 1])
        Hyperplane(weights=((0, 1), (2, -1)), bias=0, pair=None)
        """
        if len(first) != len(second) or not {*first, *second} <= {0, 1}:
            raise InputError(f"two patterns must be 0 and 1, of one length, got {shown(first)} and {shown(second)}")
        weights = [(k, 1 if a else -1) for k, (a, b) in enumerate(zip(first, second, strict=True)) if a != b]
        # sum w (2 x - 1) > 0 is sum w x > sum(w) / 2, and the left side is an integer
        return cls(weights, sum(weight for _, weight in weights) // 2, pair)


@dataclass(frozen=True, slots=True)
class Term:
    """A product term: true if and only if every literal holds; without literals always true.

    Parameters
    ----------
    literals : iterable of (int, int)
        Pairs (unit index, wanted value 0 or 1), in any order; kept sorted by index, no unit twice.
    """

    literals: tuple[tuple[int, int], ...]

    def __init__(self, literals: Iterable[tuple[int, int]]) -> None:
        pairs = sorted(_pairs(literals, "term"))
        for unit, wanted in pairs:
            if wanted not in (0, 1):
                raise InputError(f"a literal of a term must want 0 or 1, got {wanted} for unit {unit}")
        _check_distinct(pairs, "term", "unit")
        object.__setattr__(self, "literals", tuple(pairs))


@dataclass(frozen=True, slots=True)
class Score:
    """The score of one class: ``sum(weight * term) + bias``.

    Parameters
    ----------
    weights : iterable of (int, int)
        Pairs (term index, weight), in any order; kept sorted by index. No zeros, no index twice.
    bias : int
        The score where no term is true.
    """

    weights: tuple[tuple[int, int], ...]
    bias: int = 0

    def __init__(self, weights: Iterable[tuple[int, int]], bias: int = 0) -> None:
        object.__setattr__(self, "weights", _sparse(weights, "score"))
        object.__setattr__(self, "bias", _integer(bias, "bias of a score"))
        _check_reach(self.weights, self.bias, "score")


def _integer(value: object, what: str) -> int:
    if isinstance(value, bool):
        raise InputError(f"{what} must be an integer, got {value}")
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise InputError(f"{what} must be an integer, got {shown(value)}") from None
    if not -INT32_MAX <= number <= INT32_MAX:
        raise InputError(f"{what} must fit 32 signed bits, got {shown(number)}")
    return number


def _index(value: object, what: str) -> int:
    number = _integer(value, what)
    if number < 0:
        raise InputError(f"{what} must not be negative, got {number}")
    return number


def _pairs(pairs: Iterable[tuple[int, int]], what: str) -> list[tuple[int, int]]:
    out = []
    for item in pairs:
        try:
            index, value = item
        except (TypeError, ValueError):
            raise InputError(f"a {what} must hold pairs (index, integer), got {shown(item)}") from None
        out.append((_index(index, f"index in a {what}"), _integer(value, f"value in a {what}")))
    return out


def _sparse(pairs: Iterable[tuple[int, int]], what: str) -> tuple[tuple[int, int], ...]:
    out = sorted(_pairs(pairs, what))
    for index, weight in out:
        if weight == 0:
            raise InputError(f"weights of a {what} must not be zero, got 0 at index {index}; leave it out")
    _check_distinct(out, what, "index")
    return tuple(out)


def _check_distinct(pairs: list[tuple[int, int]], what: str, index: str) -> None:
    for (one, _), (other, _) in itertools.pairwise(pairs):
        if one == other:
            raise InputError(f"a {what} must name each {index} once, got {one} twice")


def _check_reach(weights: tuple[tuple[int, int], ...], bias: int, what: str) -> None:
    reach = sum(abs(weight) for _, weight in weights) + abs(bias)
    if reach > INT32_MAX // 2:
        # half of the range, so that the difference of two sums fits as well
        raise InputError(f"weights and bias of a {what} must sum to at most {INT32_MAX // 2} in magnitude, got {reach}")


def shown(value: object) -> str:
    """Return a one-line, bounded picture of a value for an error message."""
    if isinstance(value, int) and abs(value) > 10**30:
        return "an integer of more than 30 digits"
    text = ascii(value)
    return text if len(text) <= 40 else text[:37] + "..."
