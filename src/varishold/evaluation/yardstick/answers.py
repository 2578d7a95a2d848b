"""What a scored function answers: a name, or names with their probabilities."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.evaluation.yardstick.rows import as_one
from varishold.touch import NAMES, find_contacts, recognize
from varishold.touch.names import OUTLINE_OF, OUTLINES

__all__ = ["Told", "outline_of", "read_answer", "shipped_names"]

# What rounding may add to a sum of probabilities.
_ROUNDING = 1e-6
_OUTLINE_OF: Mapping[str, str] = OUTLINE_OF


@dataclass(frozen=True)
class Told:
    """What an answer says: its likeliest name, ridge and hip as one, the probability of that, and the outline."""

    name: str
    probability: float
    outline: str


def read_answer(answer: object) -> Told:
    """Return what the answer to one frame says.

    Parameters
    ----------
    answer : str, mapping of str to float, or a pair of one of these and a str
        A name of `varishold.touch.NAMES`, which has the probability 1, or the probability of each name; names left out
        have none. Of equally likely names the first of the table counts. The second of a pair is the outline: round,
        square, oblong, edge, plane or unknown; without it, it is the outline that the names together make likeliest.

    Raises
    ------
    InputError
        If it is anything else, or the probabilities are none.

    Examples
    --------
    >>> read_answer({"ridge": 0.3, "hip": 0.3, "sphere": 0.4})
    Told(name='ridge', probability=0.6, outline='oblong')
    >>> read_answer("cone")
    Told(name='cone', probability=1.0, outline='round')
    """
    outline = None
    if isinstance(answer, tuple) and len(answer) == 2:
        answer, outline = answer
        if outline not in OUTLINES:
            raise InputError(f"{_short(outline)} is no outline; known are: {', '.join(OUTLINES)}")
    p = _probabilities(answer)
    name = max(p, key=p.__getitem__)
    return Told(name, p[name], str(outline) if outline is not None else _likeliest_outline(p))


def outline_of(names: tuple[str, ...]) -> set[str]:
    """Return the outlines of names."""
    return {_OUTLINE_OF[name] for name in names}


def shipped_names(frame: NDArray[np.float64]) -> dict[str, float]:
    """Return the names that the shipped tables give the largest contact of a frame; unknown where there is none.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64

    Returns
    -------
    dict of str to float
        Every name of `varishold.touch.NAMES` with its probability.
    """
    contacts = find_contacts(frame)
    return recognize(contacts[0]).names if contacts else {"unknown": 1.0}


def _probabilities(answer: Any) -> dict[str, float]:
    """Return the probability of each name, in the order of the table, ridge and hip as one."""
    if isinstance(answer, str):
        answer = {answer: 1.0}
    if not isinstance(answer, Mapping):
        raise InputError(
            f"an answer must be a name, or a mapping of names to probabilities, got {type(answer).__name__}"
        )
    if not answer:
        raise InputError("the answer names nothing; where nothing can be told the name is 'unknown'")
    for name, p in answer.items():
        if name not in NAMES:
            raise InputError(f"{_short(name)} is no name of the table; known are: {', '.join(NAMES)}")
        if isinstance(p, bool) or not isinstance(p, Real) or not 0 <= p <= 1:  # type: ignore[operator]
            raise InputError(f"the probability of {name!r} must be a number from 0 to 1, got {_short(p)}")
    total = math.fsum(float(p) for p in answer.values())
    if total > 1 + _ROUNDING:
        raise InputError(f"probabilities must sum to 1 at most, got {total:g}")
    merged: dict[str, float] = {}
    for name in (known for known in NAMES if known in answer):
        merged[as_one(name)] = merged.get(as_one(name), 0.0) + float(answer[name])
    return merged


def _likeliest_outline(p: Mapping[str, float]) -> str:
    shares = dict.fromkeys(OUTLINES, 0.0)
    for name, share in p.items():
        shares[OUTLINE_OF[name]] += share
    return max(shares, key=shares.__getitem__)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
