"""The contacts of many frames: arrays of measures, and contacts for whoever asks for one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import MOST_LEVELS, falling
from varishold.levelset.columns import (
    BORDERS,
    BOTTOM,
    END,
    LEFT,
    N_MEASURED,
    N_TAXELS,
    PEAK,
    PEAK_COL,
    PEAK_ROW,
    RIGHT,
    TOP,
)
from varishold.levelset.contact import Contact
from varishold.levelset.kernel import Rows
from varishold.levelset.profile import Sections

__all__ = ["ContactBatch", "own_thresholds"]


@dataclass(frozen=True, eq=False)
class ContactBatch(Sections, Sequence[list[Contact]]):
    """The contacts of many frames of one pad.

    As a sequence it holds each frame's list of `Contact`, made when it is asked for. Its arrays hold all contacts,
    frame after frame, in the order of those lists: one row a contact, and what a `Profile` has, shape
    (n_contacts, n_levels, ...).

    Parameters
    ----------
    n_found : ndarray of shape (n_frames,), int
        Contacts of each frame.
    sigma : ndarray of shape (n_frames,), float64
        Standard deviation of each frame's noise; NaN where a floor was given.
    rows : Rows
        What the kernel wrote.
    contacts_of : callable
        Returns the contacts of the frame of an index.
    """

    n_found: NDArray[np.integer]
    sigma: NDArray[np.float64]
    rows: Rows = field(repr=False)
    contacts_of: Callable[[int], list[Contact]] = field(repr=False)

    def __len__(self) -> int:
        return len(self.n_found)

    @overload
    def __getitem__(self, index: int) -> list[Contact]: ...
    @overload
    def __getitem__(self, index: slice) -> list[list[Contact]]: ...
    def __getitem__(self, index: int | slice) -> list[Contact] | list[list[Contact]]:
        frames = range(len(self))[index]
        return [self.contacts_of(i) for i in frames] if isinstance(frames, range) else self.contacts_of(frames)

    @property
    def measures(self) -> NDArray[np.float64]:  # type: ignore[override]
        """As of a `Profile`; shape (n_contacts, 25 * n_levels)."""
        return self.rows.measures

    @property
    def counts(self) -> NDArray[np.int64]:  # type: ignore[override]
        """As of a `Profile`; shape (n_contacts, 2, n_levels)."""
        return self.rows.counts

    @property
    def frame(self) -> NDArray[np.int64]:
        """The frame of each contact; shape (n_contacts,)."""
        return np.repeat(np.arange(len(self)), self.n_found)

    @property
    def number(self) -> NDArray[np.int64]:
        """Each contact's number in its frame, 0 the largest; shape (n_contacts,)."""
        n_found = self.n_found.astype(np.int64)
        return np.arange(n_found.sum()) - np.repeat(np.cumsum(n_found) - n_found, n_found)

    @property
    def peak(self) -> NDArray[np.float64]:
        """The highest value; shape (n_contacts,)."""
        return self.rows.values[:, PEAK]

    @property
    def floor(self) -> NDArray[np.float64]:
        """Where the profile ends; shape (n_contacts,)."""
        return self.rows.values[:, END]

    @property
    def peak_taxel(self) -> NDArray[np.int64]:
        """Row and column of the highest taxel; shape (n_contacts, 2)."""
        return self.rows.places[:, [PEAK_ROW, PEAK_COL]] - 1

    @property
    def box(self) -> NDArray[np.int64]:
        """First and last row, first and last column; shape (n_contacts, 4)."""
        return self.rows.places[:, [TOP, BOTTOM, LEFT, RIGHT]] - 1

    @property
    def n_taxels(self) -> NDArray[np.int64]:
        """Number of taxels above the floor; shape (n_contacts,)."""
        return self.rows.places[:, N_TAXELS]

    @property
    def borders(self) -> NDArray[np.bool_]:
        """Whether its taxels reach the field's border left, right, at the top, at the bottom; shape (n_contacts, 4)."""
        return (self.rows.places[:, [BORDERS]] >> np.arange(4) & 1).astype(np.bool_)

    @property
    def n_measured(self) -> NDArray[np.int64]:
        """How many thresholds are not below the floor; shape (n_contacts,)."""
        return self.rows.places[:, N_MEASURED]


def own_thresholds(levels: ArrayLike, n_frames: int) -> NDArray[np.float64]:
    """Return each frame's own thresholds, shape (n_frames, n_levels), the highest first.

    Raises
    ------
    InputError
        If they are not finite numbers in one row a frame, or there are too many.
    """
    given = np.asarray(levels)
    if len(given) != n_frames or not 0 < given.shape[1] <= MOST_LEVELS or given.dtype.kind not in "iuf":
        raise InputError(
            f"each frame's own levels must be thresholds of shape ({n_frames}, n_levels), at most {MOST_LEVELS}, "
            f"got {given.dtype} of shape {given.shape}"
        )
    return falling(given.astype(np.float64))
