"""What there is to learn from: presses, their copies as another day may bring them, and what is held out together."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.touch.course.presses import Press, drifted, first_of_same
from varishold.trust import group_folds, kept_together, same_partition

__all__ = ["COPIES", "Training", "copies_of", "copies_told", "deal_presses", "named_alike", "named_otherwise"]

#: Copies of every press that have drifted, each in its own way.
COPIES = 5
# What is learned without place or load lies up to so many taxels elsewhere there, and is pressed so much less, and up
# to so many times as fast or as slowly: how fast a hand closes belongs to how hard it grips.
_ELSEWHERE, _LIGHTER, _PACE = 2, 0.4, 1.5
# So many held-out presses times classes, each of which is judged by twenty settings, fill some gigabytes.
_MOST_SCORES = 40_000_000
# A remark names so many things, or pairs of them.
_MOST_TOLD = 3


@dataclass(frozen=True, eq=False)
class Training:
    """Presses to learn from, and what is held out together.

    Parameters
    ----------
    presses : list of Press
    codes, fold : ndarray of shape (n_presses,), int
        The class of each, and the fold in which it is held out.
    sessions : bool
        Whether whole sessions are held out.
    unheld : str
        Why no session is held out, where none is.
    n_copies : int
        So many times the presses are learned again as they might be on another day.
    remarks : tuple of str
        What is to be known of how the presses were taken.
    """

    presses: list[Press]
    codes: NDArray[np.intp]
    fold: NDArray[np.intp]
    sessions: bool
    unheld: str
    n_copies: int
    remarks: tuple[str, ...] = ()

    @property
    def all_codes(self) -> NDArray[np.intp]:
        """The class of each press, and of each copy after them."""
        return np.tile(self.codes, 1 + self.n_copies)

    @property
    def all_folds(self) -> NDArray[np.intp]:
        """The fold of each press, and of each copy after them."""
        return np.tile(self.fold, 1 + self.n_copies)

    @property
    def asked(self) -> NDArray[np.bool_]:
        """Which of these settings are chosen on: where sessions are known they show how things drift, else copies."""
        of_copies = np.arange(len(self.all_codes)) >= len(self.codes)
        return np.asarray(of_copies != (self.sessions or self.n_copies == 0))

    def copies(self, drift: float, *, elsewhere: bool, lighter: bool) -> list[Press]:
        """Return the copies: gains have drifted, and things may lie elsewhere, or be pressed less, at another pace."""
        return copies_of(self.presses, self.n_copies, drift, elsewhere=elsewhere, lighter=lighter)


def deal_presses(
    presses: list[Press], labels: NDArray[Any], sessions: NDArray[Any] | None, *, folds: int, n_copies: int
) -> tuple[NDArray[Any], Training]:
    """Return the classes, and presses in folds: a press that is there more than once under one label is kept once.

    Parameters
    ----------
    presses : list of Press
    labels : ndarray of shape (n_presses,)
    sessions : ndarray of shape (n_presses,), optional
        The session of each.
    folds : int
        The most folds.
    n_copies : int
        So many times the presses are to be learned again as they might be on another day.

    Raises
    ------
    InputError
        If fewer than two classes are left, or far too many, sessions are the labels, or a class has one press only.
    """
    first = first_of_same(presses)
    # A copy that is named otherwise stays: which name is right is not known.
    named = np.stack([first, np.unique(labels, return_inverse=True)[1]])
    kept = np.sort(np.unique(named, axis=1, return_index=True)[1])
    remarks = copies_told(len(presses) - len(kept)) + named_otherwise(presses, labels)
    of_kept = None if sessions is None else sessions[kept]
    classes, codes = np.unique(labels[kept], return_inverse=True)
    if len(classes) < 2:
        raise InputError(
            f"y must hold at least two classes to tell apart, got 1 class: {str(classes[0])!r}; "
            "give presses of something else too"
        )
    if of_kept is not None and same_partition(of_kept, codes):
        raise InputError(
            "groups are the labels themselves: nothing would be left to learn a held-out label from; name what "
            "changes from day to day, such as the session",
            parameter="group",
        )
    counts = np.bincount(codes)
    if counts.min() < 2 and len(kept) < len(first):
        few = str(classes[counts.argmin()])
        raise InputError(f"{few!r} has one press only, copies being one: give each class at least two that differ")
    fold = group_folds(labels[kept], of_kept, folds=folds)
    together = of_kept is not None and kept_together(fold, of_kept)
    remarks += named_alike(classes)
    unheld = "" if together else _why_unheld(classes, codes, of_kept)
    training = Training([presses[k] for k in kept], codes, fold, together, unheld, n_copies, remarks)
    if int(training.asked.sum()) * len(classes) > _MOST_SCORES:
        raise InputError(
            f"{len(classes)} things in {len(kept)} presses are too many to be learned at once, such as "
            f"{classes[0]} and {classes[1]}; give labels that name things, not presses",
            parameter="label",
        )
    return classes, training


def copies_of(presses: list[Press], n_copies: int, drift: float, *, elsewhere: bool, lighter: bool) -> list[Press]:
    """Return presses so many times as they might be on another day, each in its own way."""
    return [
        drifted(
            press,
            drift,
            (copy, k),
            elsewhere=_ELSEWHERE if elsewhere else 0,
            lighter=_LIGHTER if lighter else 0.0,
            pace=_PACE if lighter else 1.0,
        )
        for copy in range(n_copies)
        for k, press in enumerate(presses)
    ]


def copies_told(n_copies: int) -> tuple[str, ...]:
    """Return a remark on presses that are there more than once, where any are."""
    if not n_copies:
        return ()
    what = counted(n_copies, "press is a copy", "presses are copies")
    return (f"{what} of others, with identical frames: each is learned once; leave the copies out",)


def named_otherwise(presses: Sequence[Press], labels: NDArray[Any]) -> tuple[str, ...]:
    """Return a remark on presses that are copies of others with another label, where any are."""
    first = first_of_same(presses)
    otherwise = np.flatnonzero(labels[first] != labels)
    if not otherwise.size:
        return ()
    pair = [f"{presses[k].place or f'press {k}'} is {str(labels[k])!r}" for k in (first[otherwise[0]], otherwise[0])]
    what = counted(otherwise.size, "press is a copy", "presses are copies")
    return (f"{what} of others that have another label: {', '.join(pair)}; look which is right",)


def named_alike(classes: NDArray[Any]) -> tuple[str, ...]:
    """Return a remark on classes whose names are one number, or differ in case and between words alone."""
    alike: dict[str, list[str]] = {}
    for name in map(str, classes):
        alike.setdefault(_in_essence(name), []).append(name)
    pairs = [names for names in alike.values() if len(names) > 1]
    if not pairs:
        return ()
    told = "; ".join(", ".join(map(repr, names)) for names in pairs[:_MOST_TOLD])
    return (f"things with names that are nearly alike are told apart: {told}; if they are one, give them one name",)


def _in_essence(name: str) -> str:
    if re.fullmatch(r"[+-]?\d+(\.\d*)?", name, re.ASCII):
        return repr(float(name))
    return re.sub(r"[\s_-]+", " ", name.casefold())


def _why_unheld(classes: NDArray[Any], codes: NDArray[np.intp], sessions: NDArray[Any] | None) -> str:
    """Return why no session can be held out."""
    if sessions is None:
        return "no sessions are known"
    names, of = np.unique(sessions, return_inverse=True)
    if len(names) == 1:
        return f"all presses are of one session, {str(names[0])!r}"
    pairs = np.unique(np.stack([codes, of]), axis=1)
    alone = [repr(str(name)) for name in classes[np.bincount(pairs[0]) == 1]]
    if not alone:
        return "without any share of the sessions some thing would be unknown"
    more = f" and {len(alone) - _MOST_TOLD} more" if len(alone) > _MOST_TOLD else ""
    return f"{', '.join(alone[:_MOST_TOLD])}{more} {'was' if len(alone) == 1 else 'were'} felt in one session only"
