"""A contact: a part of a frame, and its sections at all thresholds."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold._cached import cached_property
from varishold.frame.noise import frame_noise
from varishold.kernel import address
from varishold.levelset.columns import (
    BORDERS,
    BOTTOM,
    END,
    LEFT,
    N_COLUMNS,
    N_PLACES,
    N_TAXELS,
    PEAK,
    PEAK_COL,
    PEAK_ROW,
    RIGHT,
    TOP,
)
from varishold.levelset.contact_state import ContactState, Losses
from varishold.levelset.outline import Outlines, outlines_at, outlines_in
from varishold.levelset.profile import Profile

__all__ = ["Borders", "Contact", "Frame", "pieces", "with_losses"]

_NOTHING = Losses()
# struct vh_contact of varishold.h.
_PACKED = struct.Struct("@5P4i5d")


def pieces(room: int, n_levels: int) -> tuple[int, int, int, int]:
    """Return where the measures, counts and places of so many contacts begin, behind their values, and where all ends.

    Of an array of 8 bytes a number that holds them one after the other.
    """
    measures = 2 * room
    counts = measures + N_COLUMNS * n_levels * room
    places = counts + 2 * n_levels * room
    return measures, counts, places, places + N_PLACES * room


class Borders(NamedTuple):
    """The borders of the field that a contact reaches."""

    left: bool
    right: bool
    top: bool
    bottom: bool


# Not frozen: that would take longer to make than to measure a small contact.
@dataclass(eq=False)
class Frame:
    """What the contacts of one frame share; each contact is a view into it. It is not to be changed.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns.
    n_levels, n_contacts : int
    room : int
        So many contacts `measured` has room for.
    taxels : ndarray, float64
        `padded`, `label` and `dead`, one after the other, as the kernel writes them.
    measured : ndarray, float64
        `values`, `measures`, `counts` and `places`, each with its room, the same.
    start : int
        Where in it they begin.
    sigma : float
        Standard deviation of the frame's noise; NaN where it has not been asked for.
    pitch : (float, float) or None
        Row and column spacing, metres.
    rest : (float, float, float)
        The rest that was taken off: at the first taxel, its rise by column and by row; zeros where none was. Of one
        that curves the plane that is nearest to it.
    losses : Losses
        What the sensor lost.
    has_gaps : bool
        Whether there is a place without a taxel.
    even : bool
        Whether the levels lie evenly between each contact's peak and its end; thresholds that were given may not.
    """

    shape: tuple[int, int]
    n_levels: int
    n_contacts: int
    room: int
    taxels: NDArray[np.float64]
    measured: NDArray[np.float64]
    start: int
    sigma: float
    pitch: tuple[float, float] | None
    rest: tuple[float, float, float]
    losses: Losses = _NOTHING
    has_gaps: bool = False
    even: bool = True

    @cached_property
    def found(self) -> NDArray[np.float64]:
        """`values`, `measures`, `counts` and `places`, one after the other."""
        return self.measured[self.start :]

    @cached_property
    def padded(self) -> NDArray[np.float64]:
        """The frame with broken taxels filled and one taxel of rim; -inf where there is no taxel."""
        rows, cols = self.shape
        return self.taxels[: (rows + 2) * (cols + 2)].reshape(rows + 2, cols + 2)

    @cached_property
    def label(self) -> NDArray[np.int32]:
        """The index of each taxel's contact, -1 for none; shape (rows + 2, cols + 2)."""
        size = self.padded.size
        return self.taxels[size:].view(np.int32)[:size].reshape(self.padded.shape)

    @cached_property
    def dead(self) -> NDArray[np.bool_]:
        """The taxels found dead (at rest amid pressed ones) or hot (stuck high), all filled; shape (rows, cols)."""
        rows, cols = self.shape
        start = 4 * self.padded.size
        return self.taxels[self.padded.size :].view(np.bool_)[start : start + rows * cols].reshape(rows, cols)

    @cached_property
    def values(self) -> NDArray[np.float64]:
        """Each contact's peak and end, as `columns` names their places; shape (n_contacts, 2)."""
        return self.found[: 2 * self.n_contacts].reshape(-1, 2)

    @cached_property
    def measures(self) -> NDArray[np.float64]:
        """Each contact's measures, as `columns` names their places; shape (n_contacts, 25 * n_levels)."""
        start, size = pieces(self.room, self.n_levels)[0], N_COLUMNS * self.n_levels
        return self.found[start : start + self.n_contacts * size].reshape(self.n_contacts, size)

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """Each contact's parts and holes at each level; shape (n_contacts, 2, n_levels)."""
        n, levels = self.n_contacts, self.n_levels
        start = pieces(self.room, levels)[1]
        return self.found[start : start + 2 * n * levels].view(np.int64).reshape(n, 2, levels)

    @cached_property
    def places(self) -> NDArray[np.int64]:
        """Where each contact is in the padded frame, as `columns` names it; shape (n_contacts, 9)."""
        start, size = pieces(self.room, self.n_levels)[2], N_PLACES * self.n_contacts
        return self.found[start : start + size].view(np.int64).reshape(-1, N_PLACES)

    @cached_property
    def field(self) -> NDArray[np.bool_]:
        """Where there are taxels; shape (rows, cols)."""
        return self.padded[1:-1, 1:-1] > -np.inf


# Not frozen, as its frame is not; it is not to be changed either.
@dataclass(slots=True, eq=False)
class Contact:
    """One contact of a frame: a part of {V > floor} that does not fall apart into peaks of their own.

    Parameters
    ----------
    frame : Frame
        What it shares with the frame's other contacts.
    index : int
        Its place in the frame's arrays (not its rank by area).
    """

    frame: Frame
    index: int

    def __repr__(self) -> str:
        row, col = self.peak_taxel
        return f"Contact(peak={self.peak:.4g} at ({row}, {col}), n_taxels={self.n_taxels}, levels={len(self.profile)})"

    @property
    def peak(self) -> float:
        """The highest value, in the unit of the frame."""
        return float(self.frame.values[self.index, PEAK])

    @property
    def peak_taxel(self) -> tuple[int, int]:
        """Row and column of the highest taxel."""
        place = self.frame.places[self.index]
        return int(place[PEAK_ROW]) - 1, int(place[PEAK_COL]) - 1

    @property
    def peak_position(self) -> tuple[float, float]:
        """(x, y) of the highest taxel's centre from the pad's centre; metres or taxels."""
        row, col = self.peak_taxel
        rows, cols = self.shape
        row_pitch, col_pitch = self.spacing
        return (col - (cols - 1) / 2) * col_pitch, (row - (rows - 1) / 2) * row_pitch

    @property
    def floor(self) -> float:
        """Where the profile ends: the frame's floor, or the saddle towards another contact."""
        return float(self.frame.values[self.index, END])

    @property
    def sigma(self) -> float:
        """Standard deviation of the frame's noise, in the unit of the frame."""
        sigma = self.frame.sigma
        if sigma == sigma:
            return sigma
        values = self.frame.padded[1:-1, 1:-1]
        return frame_noise(values, np.isfinite(values))

    @property
    def pitch(self) -> tuple[float, float] | None:
        """Row and column spacing in metres, or None."""
        return self.frame.pitch

    @property
    def spacing(self) -> tuple[float, float]:
        """Row and column spacing in the unit of the profile's lengths: metres, or (1, 1) taxels."""
        return self.frame.pitch or (1.0, 1.0)

    @property
    def taxel_area(self) -> float:
        """Area of a taxel in the unit of the profile's areas."""
        row_pitch, col_pitch = self.spacing
        return row_pitch * col_pitch

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the frame."""
        return self.frame.shape

    @property
    def window(self) -> tuple[slice, slice]:
        """The smallest window (rows, cols) of the frame that holds all its taxels."""
        place = self.frame.places[self.index].tolist()
        return slice(place[TOP] - 1, place[BOTTOM]), slice(place[LEFT] - 1, place[RIGHT])

    @property
    def n_taxels(self) -> int:
        """Number of taxels above its floor."""
        return int(self.frame.places[self.index, N_TAXELS])

    @property
    def at_border(self) -> bool:
        """Whether its taxels reach a border of the field; sooner told than which."""
        frame = self.frame
        # A whole number that is none is not zero as a float either.
        at = frame.start + pieces(frame.room, frame.n_levels)[2] + N_PLACES * self.index + BORDERS
        return frame.measured.item(at) != 0.0

    @property
    def borders(self) -> Borders:
        """The borders of the field that its taxels reach."""
        bits = int(self.frame.places[self.index, BORDERS])
        return Borders(bool(bits & 1), bool(bits & 2), bool(bits & 4), bool(bits & 8))

    @property
    def state(self) -> ContactState:
        """What the sensor lost of it, and what was done about it."""
        losses, repaired = self.frame.losses, self.frame.dead
        if losses.repaired is not None:
            repaired = repaired | losses.repaired
        return ContactState(self._count(repaired), self._count(losses.saturated), self.borders, losses.beneath)

    def _count(self, where: NDArray[np.bool_] | None) -> int:
        return 0 if where is None else int(np.count_nonzero(where[self.window] & self.mask))

    @property
    def origin(self) -> tuple[int, int]:
        """Row and column of the window's first taxel."""
        rows, cols = self.window
        return rows.start, cols.start

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Where in its window its taxels are; shape of the window."""
        mask: NDArray[np.bool_] = self.frame.label[1:-1, 1:-1][self.window] == self.index
        return mask

    @property
    def values(self) -> NDArray[np.float64]:
        """The frame in its window, broken taxels filled, 0 where there is no taxel; shape of the window."""
        return np.where(self.field[self.window], self.frame.padded[1:-1, 1:-1][self.window], 0.0)

    @property
    def field(self) -> NDArray[np.bool_]:
        """Where the whole frame has taxels; shape (rows, cols)."""
        return self.frame.field

    @property
    def profile(self) -> Profile:
        """Its sections, measured."""
        return Profile(self.frame.measures[self.index], self.frame.counts[self.index])

    @property
    def packed(self) -> bytes:
        """A ``struct vh_contact``, as the kernel takes it; good as long as the contact is kept."""
        frame, k = self.frame, self.index
        levels, (rows, cols) = frame.n_levels, frame.shape
        measures, counts, places, _ = pieces(frame.room, levels)
        taxels, found = address(frame.taxels), address(frame.measured) + 8 * frame.start
        row_pitch, col_pitch = frame.pitch or (1.0, 1.0)
        values = frame.start + 2 * k
        peak, floor = frame.measured[values : values + 2].tolist()
        return _PACKED.pack(
            taxels,
            taxels + 8 * (rows + 2) * (cols + 2),
            found + 8 * (places + N_PLACES * k),
            found + 8 * (measures + N_COLUMNS * levels * k),
            found + 8 * (counts + 2 * levels * k),
            rows + 2,
            cols + 2,
            k,
            levels,
            row_pitch,
            col_pitch,
            peak,
            floor,
            self.sigma,
        )

    def outlines(self, i: int) -> list[NDArray[np.float64]]:
        """Return the outlines X_Bi of its i-th section, as `varishold.levelset.outlines` does.

        Parameters
        ----------
        i : int
            Which threshold; 0 is nearest the top.

        Returns
        -------
        list of ndarray of shape (n, 2), float64
            Polylines (x, y) in the unit of the profile's lengths, the section on their left; empty above
            the peak and below the contact's floor.
        """
        profile = self.profile
        if not profile.measured[i]:
            return []
        # Whether or not the field has gaps, V is constant over the outer half taxels of the pad.
        inside = slice(1, -1)
        return outlines_in(
            self.frame.padded[inside, inside],
            self.frame.label[inside, inside],
            self.index,
            float(profile.threshold[i]),
            self.spacing,
        )

    def filled(self, levels: Sequence[float], spacing: tuple[float, float] | None = None) -> Outlines:
        """Return the outlines of its sections, closed along the pad's border and around gaps, to be filled.

        Parameters
        ----------
        levels : sequence of float
            Thresholds, none below its floor.
        spacing : (float, float), optional
            Row and column spacing; default: its own.

        Returns
        -------
        Outlines
            From the pad's centre.
        """
        rows, cols = self.shape
        high, wide = self.spacing if spacing is None else spacing
        # A taxel around its own tells where a section ends; the others do not count.
        (top, bottom), (left, right) = (
            (max(part.start - 1, 0), min(part.stop + 1, n)) for part, n in zip(self.window, self.shape, strict=True)
        )
        window = slice(top + 1, bottom + 1), slice(left + 1, right + 1)
        padded, label = self.frame.padded[window], self.frame.label[window]
        found = outlines_at(padded, label, self.index, levels, (high, wide), closed=True)
        middle = 0.5 * (left + right - cols) * wide, 0.5 * (top + bottom - rows) * high
        return found._replace(points=found.points + middle)


def with_losses(contacts: list[Contact], **changes: Any) -> list[Contact]:
    """Return a frame's contacts, knowing more of what the sensor lost of it.

    Parameters
    ----------
    contacts : list of Contact
        All of one frame.
    **changes
        What of `Losses` is known otherwise.
    """
    if not contacts:
        return contacts
    frame = contacts[0].frame
    shared = replace(frame, losses=replace(frame.losses, **changes))
    return [Contact(shared, contact.index) for contact in contacts]
