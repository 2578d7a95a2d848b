"""Contacts: where the pad is touched, and each one's sections at all thresholds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.files.compiling import njit
from varishold.frame.checks import as_floats, as_floor, as_levels, as_mask, as_pitch, as_valid, falling
from varishold.frame.fill import fill_taxels
from varishold.frame.noise import frame_noise, noise_sigma
from varishold.levelset import Profile
from varishold.levelset.kernel import sections
from varishold.levelset.outline import outlines_in, positions

__all__ = ["FLOOR_OF_PEAK", "FLOOR_SIGMAS", "Borders", "Contact", "find_contacts", "find_contacts_batch"]

# The standard plane delta stands clear of the noise (one taxel in 30,000 exceeds 4 sigma by chance) and of the
# faint skirt that skins and cross-talk put around a contact.
FLOOR_SIGMAS = 4.0
FLOOR_OF_PEAK = 0.05
# Below it there are too few floating-point numbers to put thresholds between.
_LEAST_FLOOR = 2.2250738585072014e-308

_FINE, _INFINITE, _ALL_BROKEN, _UNORDERED = 0, 1, 2, 3


class Borders(NamedTuple):
    """The borders of the field that a contact reaches."""

    left: bool
    right: bool
    top: bool
    bottom: bool


@dataclass(frozen=True, eq=False)
class Frame:
    """What the contacts of one frame share; each contact is a view into it.

    Parameters
    ----------
    padded : ndarray of shape (rows + 2, cols + 2), float64
        The frame with broken taxels filled and one taxel of rim; -inf where there is no taxel.
    label : ndarray of shape (rows + 2, cols + 2), int32
        The index of each taxel's contact, -1 for none.
    places, values, measures, counts : ndarray
        As `varishold.levelset.kernel.sections` returns them.
    sigma : float
        Standard deviation of the frame's noise; NaN where it has not been asked for.
    pitch : (float, float) or None
        Row and column spacing, metres.
    """

    padded: NDArray[np.float64]
    label: NDArray[np.int32]
    places: NDArray[np.int64]
    values: NDArray[np.float64]
    measures: NDArray[np.float64]
    counts: NDArray[np.int64]
    sigma: float
    pitch: tuple[float, float] | None

    @cached_property
    def field(self) -> NDArray[np.bool_]:
        """Where there are taxels; shape (rows, cols)."""
        return self.padded[1:-1, 1:-1] > -np.inf


@dataclass(frozen=True, slots=True, eq=False)
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

    @property
    def peak(self) -> float:
        """The highest value, in the unit of the frame."""
        return float(self.frame.values[self.index, 0])

    @property
    def peak_taxel(self) -> tuple[int, int]:
        """Row and column of the highest taxel."""
        place = self.frame.places[self.index]
        return int(place[0]) - 1, int(place[1]) - 1

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
        return float(self.frame.values[self.index, 1])

    @property
    def sigma(self) -> float:
        """Standard deviation of the frame's noise, in the unit of the frame."""
        if not np.isnan(self.frame.sigma):
            return self.frame.sigma
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
        height, width = self.frame.label.shape
        return height - 2, width - 2

    @property
    def window(self) -> tuple[slice, slice]:
        """The smallest window (rows, cols) of the frame that holds all its taxels."""
        place = self.frame.places[self.index].tolist()
        return slice(place[2] - 1, place[3]), slice(place[4] - 1, place[5])

    @property
    def n_taxels(self) -> int:
        """Number of taxels above its floor."""
        return int(self.frame.places[self.index, 6])

    @property
    def borders(self) -> Borders:
        """The borders of the field that its taxels reach."""
        bits = int(self.frame.places[self.index, 7])
        return Borders(bool(bits & 1), bool(bits & 2), bool(bits & 4), bool(bits & 8))

    @property
    def origin(self) -> tuple[int, int]:
        """Row and column of the window's first taxel."""
        place = self.frame.places[self.index]
        return int(place[2]) - 1, int(place[4]) - 1

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Where in its window its taxels are; shape of the window."""
        mask: NDArray[np.bool_] = self.frame.label[1:-1, 1:-1][self.window] == self.index
        return mask

    @property
    def values(self) -> NDArray[np.float64]:
        """The frame in its window, broken taxels filled, 0 where there is no taxel; shape of the window."""
        values = np.ascontiguousarray(self.frame.padded[1:-1, 1:-1][self.window])
        if not self.frame.field.all():
            values[~self.frame.field[self.window]] = 0.0
        return values

    @property
    def field(self) -> NDArray[np.bool_]:
        """Where the whole frame has taxels; shape (rows, cols)."""
        return self.frame.field

    @property
    def profile(self) -> Profile:
        """Its sections, measured."""
        return Profile(self.frame.measures[self.index], self.frame.counts[self.index])

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
        rows, cols = self.shape
        row_pitch, col_pitch = self.spacing
        # Whether or not the field has gaps, V is constant over the outer half taxels of the pad.
        return outlines_in(
            np.pad(self.frame.padded[1:-1, 1:-1], 1, mode="edge"),
            np.pad(self.frame.label[1:-1, 1:-1], 1, mode="edge") == self.index,
            float(profile.threshold[i]),
            positions(cols, col_pitch),
            positions(rows, row_pitch),
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _prepare(frame, field, valid, floor, row_pitch, col_pitch):  # type: ignore[no-untyped-def]
    """Pad the frame, fill its broken taxels, estimate its noise and its floor.

    Empty masks are none; a negative floor is to be chosen here. Returns the padded frame (-inf where there is no
    taxel), the positions of its columns and rows, sigma (NaN if the floor was given), the floor, whether the
    field has gaps, and a fault.
    """
    rows, cols = frame.shape
    height, width = rows + 2, cols + 2
    padded = np.empty((height, width))
    xs, ys = np.empty(width), np.empty(height)
    for c in range(width):
        xs[c] = (c - 0.5 * (width - 1)) * col_pitch
        padded[0, c] = padded[height - 1, c] = -np.inf
    for r in range(height):
        ys[r] = (r - 0.5 * (height - 1)) * row_pitch
        padded[r, 0] = padded[r, width - 1] = -np.inf
    # The rim stands on the border of the pad.
    xs[0], xs[width - 1] = -0.5 * cols * col_pitch, 0.5 * cols * col_pitch
    ys[0], ys[height - 1] = -0.5 * rows * row_pitch, 0.5 * rows * row_pitch

    fault, n_inside, n_usable, peak = _FINE, 0, 0, 0.0
    inside, usable = np.empty((rows, cols), np.bool_), np.empty((rows, cols), np.bool_)
    for r in range(rows):
        for c in range(cols):
            value = frame[r, c]
            there = field.size == 0 or field[r, c]
            works = valid.size == 0 or valid[r, c]
            there = there and not (works and math.isnan(value))
            works = works and there
            inside[r, c], usable[r, c] = there, works
            n_inside += there
            n_usable += works
            if works:
                peak = max(peak, value)
                if math.isinf(value):
                    fault = _INFINITE
            padded[r + 1, c + 1] = value if there else -np.inf
    if fault == _FINE and n_inside > 0 and n_usable == 0:
        fault = _ALL_BROKEN
    sigma = np.nan
    if fault == _FINE and (n_usable < n_inside or floor < 0.0):
        if n_usable < n_inside:
            values = frame.copy()
            fill_taxels(values, usable, inside)
            for r in range(rows):
                for c in range(cols):
                    if inside[r, c]:
                        padded[r + 1, c + 1] = values[r, c]
        if floor < 0.0:
            sigma = noise_sigma(frame, usable, np.empty(rows * cols))
            floor = max(FLOOR_SIGMAS * sigma, FLOOR_OF_PEAK * peak, _LEAST_FLOOR)
    return padded, xs, ys, sigma, floor, n_inside < rows * cols, fault


@njit(cache=True, nogil=True, error_model="numpy")
def _fall(levels):  # type: ignore[no-untyped-def]
    """Return thresholds that rise or fall already as falling ones, and whether they were such, and finite."""
    n = levels.size
    falls, rises = True, True
    for i in range(n - 1):
        falls &= levels[i] >= levels[i + 1]
        rises &= levels[i] <= levels[i + 1]
    ordered = n == 0 or ((falls or rises) and math.isfinite(levels[0]) and math.isfinite(levels[n - 1]))
    return levels if falls else levels[::-1].copy(), ordered


@njit(cache=True, nogil=True, error_model="numpy")
def _measure(frame, n_even, levels, row_pitch, col_pitch, valid, field, floor):  # type: ignore[no-untyped-def]
    """Do all of `find_contacts`: one call, as each costs more than a small contact."""
    padded, xs, ys, sigma, delta, gaps, fault = _prepare(frame, field, valid, floor, row_pitch, col_pitch)
    thresholds, ordered = _fall(levels)
    if fault == _FINE and not ordered:
        fault = _UNORDERED
    if fault != _FINE:
        delta = np.inf
    height, width = padded.shape
    label, places, values, order, measures, counts = sections(
        padded.ravel(), width, height, delta, thresholds, n_even, xs, ys, gaps
    )
    return fault, padded, label.reshape(height, width), places, values, order, measures, counts, sigma


def find_contacts(
    frame: ArrayLike,
    levels: int | ArrayLike = 32,
    *,
    pitch: float | tuple[float, float] | None = None,
    valid: ArrayLike | None = None,
    field: ArrayLike | None = None,
    floor: float | None = None,
) -> list[Contact]:
    """Find the contacts of a frame and measure their sections at all thresholds in one pass.

    A contact is a part of {V > floor}. Two peaks of one part are two contacts only if the saddle between them
    lies below half of the lower peak (`varishold.levelset.merge_tree.SPLIT_RATIO`); the profiles of both
    then end at that saddle, and what lies below it belongs to neither, nor does a bump on their common skirt that
    is no contact of its own.

    A speck of noise above the floor is a contact like any other, of one or two taxels: look at
    `Contact.n_taxels`, or at the area, before believing its form.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        Pressure, or a height map. NaN is no taxel.
    levels : int or array_like of shape (n_levels,)
        So many thresholds per contact, evenly from its own peak to its floor at half steps; or the same
        thresholds for all, in the unit of the frame and in any order (the profile's are falling). Where such a
        threshold lies below a contact's floor, its profile is NaN.
    pitch : float or (float, float), optional
        Taxel spacing in metres, one for both ways or (row spacing, column spacing). Without it lengths are in
        taxels.
    valid : array_like of shape (rows, cols), bool, optional
        False where a taxel is broken; it is filled from its neighbours first.
    field : array_like of shape (rows, cols), bool, optional
        False where there is no taxel.
    floor : float, optional
        The standard plane delta, in the unit of the frame, not negative. Default: the larger of four sigma
        of the frame's noise and 5 % of its peak.

    Returns
    -------
    list of Contact
        By falling area of the lowest section; empty where nothing stands above the floor.

    Raises
    ------
    InputError
        If an argument has the wrong shape or type, a value is infinite, or every taxel is broken.

    Examples
    --------
    >>> import numpy as np
    >>> y, x = np.mgrid[-8:9, -8:9]
    >>> cone = np.maximum(6.0 - np.hypot(x, y), 0.0)
    >>> (contact,) = find_contacts(cone, 4, pitch=0.002, floor=1.0)
    >>> contact.profile.threshold.tolist()
    [5.375, 4.125, 2.875, 1.625]
    >>> (contact.profile.area * 1e6).round(1).tolist()
    [3.1, 41.5, 120.0, 237.9]
    """
    values = as_floats(frame, 2, "a frame", masked=True)
    return _find(
        values,
        *as_levels(levels),
        None if pitch is None else as_pitch(pitch, "pitch"),
        as_valid(frame, valid, values.shape),
        as_mask(field, values.shape, "field"),
        as_floor(floor),
    )


def find_contacts_batch(
    frames: ArrayLike,
    levels: int | ArrayLike = 32,
    *,
    pitch: float | tuple[float, float] | None = None,
    valid: ArrayLike | None = None,
    field: ArrayLike | None = None,
    floor: float | None = None,
) -> list[list[Contact]]:
    """Find the contacts of many frames of one pad.

    The same as `find_contacts` on each, with the options looked at once.

    Parameters
    ----------
    frames : array_like of shape (n_frames, rows, cols), float or integer
        The frames.
    levels, pitch, valid, field, floor
        As in `find_contacts`, for all frames.

    Returns
    -------
    list of list of Contact
        One list a frame.

    Raises
    ------
    InputError
        As `find_contacts`; the message names the frame.

    Examples
    --------
    >>> import numpy as np
    >>> [len(contacts) for contacts in find_contacts_batch(np.eye(3)[:, None, :])]
    [1, 1, 1]
    """
    values = as_floats(frames, 3, "frames", masked=True)
    shape = values.shape[1:]
    options = (
        *as_levels(levels),
        None if pitch is None else as_pitch(pitch, "pitch"),
        as_valid(frames, valid, shape),
        as_mask(field, shape, "field"),
        as_floor(floor),
    )
    found = []
    for i, frame in enumerate(values):
        try:
            found.append(_find(frame, *options))
        except InputError as error:
            raise InputError(f"frame {i}: {error}") from None
    return found


def _find(
    values: NDArray[np.float64],
    n_even: int,
    thresholds: NDArray[np.float64],
    pitch: tuple[float, float] | None,
    valid: NDArray[np.bool_],
    field: NDArray[np.bool_],
    floor: float,
) -> list[Contact]:
    row_pitch, col_pitch = pitch or (1.0, 1.0)
    fault, padded, label, places, peaks, order, measures, counts, sigma = _measure(
        values, n_even, thresholds, row_pitch, col_pitch, valid, field, floor
    )
    if fault == _UNORDERED:
        return _find(values, n_even, falling(thresholds), pitch, valid, field, floor)
    if fault == _INFINITE:
        row, col = np.argwhere(np.isinf(values))[0].tolist()
        raise InputError(
            f"a frame must be finite, got {values[row, col]} at (row, col) = ({row}, {col}); "
            "mark broken taxels in valid"
        )
    if fault == _ALL_BROKEN:
        raise InputError("every taxel of the frame is broken: nothing to fill from")
    shared = Frame(padded, label, places, peaks, measures, counts, sigma, pitch)
    return [Contact(shared, k) for k in order.tolist()]
