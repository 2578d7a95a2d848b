"""The kernel's call: a frame made fit, its contacts found and all their sections measured."""

from __future__ import annotations

import ctypes
import struct
import threading
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold.kernel import address, bind, work_space
from varishold.levelset.columns import N_COLUMNS, N_PLACES
from varishold.levelset.contact import Frame, pieces

__all__ = [
    "ALL_BROKEN",
    "FINE",
    "INFINITE",
    "UNORDERED",
    "Options",
    "Rows",
    "measure_frame",
    "measure_frames",
    "measure_whole",
]

#: What may be wrong with a frame or its thresholds, which must fall or rise and be finite.
FINE, INFINITE, ALL_BROKEN, UNORDERED = range(4)

# struct vh_frame of varishold.h in its three parts: what is asked and the room to find contacts in; the room to measure
# them in; what is found. One call writes many numbers at once, where a ctypes structure takes one call for each.
_ASKED, _ROOM, _FOUND = struct.Struct("@4P4d4i4P"), struct.Struct("@5P"), struct.Struct("@5d4i")
_TASK = _ASKED.size + _ROOM.size + _FOUND.size
# Contacts that there is room for before they are counted: nearly all frames have no more.
_FEW = 2
# Where what is found begins, and all that is read of it with the order of a few contacts.
_BEFORE, _AFTER = _ASKED.size + _ROOM.size, struct.Struct(f"@5d4i{_FEW}i")
# struct vh_batch.
_BATCH = struct.Struct("@3P2q2P2i")
# So many frames a call: between two of them Python may stop.
_FRAMES_A_CALL = 1024


class _Task:
    """A thread's ``struct vh_frame``, in which what is asked stays written while it is the same from frame to frame."""

    __slots__ = ("at", "bytes", "n_bytes", "n_levels", "n_numbers", "n_taxels", "options", "shape")

    def __init__(self) -> None:
        # Behind it is room for the order of as many contacts as are looked for at first.
        room = np.zeros(_TASK + 4 * _FEW, np.uint8)
        self.bytes, self.at = room.data, address(room)
        # What stands in it; options keep the masks whose addresses it holds.
        self.shape, self.n_levels = (0, 0), 0
        self.options: Options | None = None
        # Bytes of work space, 8-byte numbers of a frame's taxels, and these with those of a few contacts.
        self.n_bytes = self.n_taxels = self.n_numbers = 0

    def ask(self, shape: tuple[int, int], n_levels: int, options: Options) -> None:
        """Write what is asked of frames, but for the frame and its thresholds."""
        rows, cols = shape
        numbers = (*(options.pitch or (1.0, 1.0)), options.floor, options.timed_sigma, rows, cols, n_levels, 0)
        masks = [address(mask) if mask.size else 0 for mask in (options.field, options.valid)]
        _ASKED.pack_into(self.bytes, 0, 0, *masks, 0, *numbers, 0, 0, 0, 0)
        _ROOM.pack_into(self.bytes, _ASKED.size, 0, 0, 0, 0, self.at + _TASK)
        size = (rows + 2) * (cols + 2)
        # The frame and its labels and dead taxels, of 8, 4 and 1 bytes.
        self.n_taxels = size + (4 * size + rows * cols + 7) // 8
        self.n_numbers = self.n_taxels + pieces(_FEW, n_levels)[-1]
        self.n_bytes = _work(rows, cols, n_levels)
        self.shape, self.n_levels, self.options = shape, n_levels, options


class _Tasks(threading.local):
    def __init__(self) -> None:
        self.mine = _Task()


_tasks = _Tasks()
_first_byte: Any = ctypes.c_char.from_buffer
_address_of: Any = ctypes.addressof
_contacts = bind("vh_contacts", "ppppip", "i")
_measure = bind("vh_measure_contacts", "p")
_whole = bind("vh_measure_whole", "p")
_many = bind("vh_measure_frames", "p", "q")
_work = bind("vh_contacts_work", "iii", "z")


class Options(NamedTuple):
    """The options of `find_contacts`, as `varishold.frame.checks` returns them. The same ones are asked for fastest."""

    pitch: tuple[float, float] | None
    valid: NDArray[np.bool_]
    field: NDArray[np.bool_]
    floor: float
    timed_sigma: float


def measure_frame(
    values: NDArray[np.float64], n_even: int, thresholds: NDArray[np.float64], options: Options
) -> tuple[int, Frame | None, Sequence[int]]:
    """Do all of `find_contacts` with one frame, at so many even levels or, where they are 0, at thresholds.

    Returns
    -------
    fault : int
        `FINE`, or what is wrong.
    frame : Frame or None
        None unless it is fine.
    order : sequence of int
        The contacts by falling area of their lowest section, then by falling number of taxels; without those that
        noise alone makes.
    """
    task, shape = _tasks.mine, values.shape
    n_levels = n_even or thresholds.size
    if task.options is not options or task.shape != shape or task.n_levels != n_levels:
        task.ask(shape, n_levels, options)
    numbers, room = np.empty(task.n_numbers), _FEW
    # As `address` does it, without one more call each.
    at, cut = _address_of(_first_byte(values)), 0 if n_even else _address_of(_first_byte(thresholds))
    into = _address_of(_first_byte(numbers))
    fault: int = _contacts(task.at, at, cut, into, room, work_space(task.n_bytes))
    if fault != FINE:
        return fault, None, []
    sigma, _, rest, by_col, by_row, n, n_ordered, _, has_gaps, first, second = _AFTER.unpack_from(task.bytes, _BEFORE)
    order: Sequence[int] = (first, second)[:n_ordered]
    found, start = numbers, task.n_taxels
    if n > room:
        found, order = _measured(task, n, n_levels)
        room, start = n, 0
    plane = (rest, by_col, by_row)
    known = (sigma, options.pitch, plane)
    frame = Frame(shape, n_levels, n, room, numbers, found, start, *known, has_gaps=bool(has_gaps), even=n_even > 0)
    return FINE, frame, order


def _measured(task: _Task, n: int, n_levels: int) -> tuple[NDArray[np.float64], Sequence[int]]:
    """Return what is measured of the contacts that were found, where they are more than a few, and their order."""
    more, ranks = pieces(n, n_levels), np.empty(n, np.int32)
    found = np.empty(more[-1])
    _ROOM.pack_into(task.bytes, _ASKED.size, *_room(address(found), more), address(ranks))
    _measure(task.at)
    # The order stands elsewhere now.
    task.options = None
    n_ordered = _FOUND.unpack_from(task.bytes, _BEFORE)[-3]
    return found, tuple(ranks[:n_ordered].tolist())


def _room(at: int, where: tuple[int, int, int, int]) -> tuple[int, int, int, int]:
    """Return the addresses of the places, values, measures and counts in an array with these `pieces`."""
    measures, counts, places, _ = where
    return at + 8 * places, at, at + 8 * measures, at + 8 * counts


class Rows(NamedTuple):
    """What is measured of many contacts, a row a contact, as `varishold.levelset.columns` names the places."""

    places: NDArray[np.int64]
    values: NDArray[np.float64]
    measures: NDArray[np.float64]
    counts: NDArray[np.int64]

    @classmethod
    def empty(cls, n: int, n_levels: int) -> Rows:
        """Return room for so many contacts."""
        return cls(
            np.empty((n, N_PLACES), np.int64),
            np.empty((n, 2)),
            np.empty((n, N_COLUMNS * n_levels)),
            np.empty((n, 2, n_levels), np.int64),
        )

    def first(self, n: int) -> Rows:
        """Return the first n rows."""
        return Rows(self.places[:n], self.values[:n], self.measures[:n], self.counts[:n])


def measure_frames(
    values: NDArray[np.float64], n_even: int, thresholds: NDArray[np.float64], options: Options
) -> tuple[Rows, NDArray[np.int32], NDArray[np.float64]]:
    """Do all of `find_contacts` for the frames of shape (n_frames, rows, cols), thresholds falling.

    These may be each frame's own, of shape (n_frames, n_levels).

    Returns
    -------
    rows : Rows
        Of frame after frame; of each, its contacts in their order.
    n_found : ndarray of shape (n_done,), int32
        Contacts of each frame that was measured: of all up to the first that cannot be.
    sigma : ndarray of shape (n_done,), float64
    """
    n_frames, n_rows, n_cols = values.shape
    pitch, valid, field, floor, timed_sigma = options
    n_levels = n_even or thresholds.shape[-1]
    size, n_bytes = (n_rows + 2) * (n_cols + 2), _work(n_rows, n_cols, n_levels)
    frame_room, n_found, sigma = np.empty(2 * size), np.empty(n_frames, np.int32), np.empty(n_frames)
    dead, order = np.empty(n_rows * n_cols, np.uint8), np.empty(n_rows * n_cols, np.int32)
    task, batch = np.empty(_TASK, np.uint8), np.empty(_BATCH.size, np.uint8)
    room, done, n = Rows.empty(2 * min(n_frames, _FRAMES_A_CALL), n_levels), 0, 0
    asked = (
        address(field) if field.size else 0,
        address(valid) if valid.size else 0,
        address(thresholds) if thresholds.ndim == 1 and not n_even else 0,
        *(pitch or (1.0, 1.0)),
        floor,
        timed_sigma,
        *(n_rows, n_cols, n_levels, 0, address(frame_room), address(frame_room) + 8 * size, address(dead)),
    )
    while done < n_frames:
        free = len(room.values) - n
        at = [address(array) + n * (array.nbytes // len(array)) for array in room]
        # Other frames may have been measured by this thread in between.
        _ASKED.pack_into(task.data, 0, 0, *asked, work_space(n_bytes))
        _ROOM.pack_into(task.data, _ASKED.size, *at, address(order))
        some = min(n_frames - done, _FRAMES_A_CALL)
        into = (address(n_found) + 4 * done, address(sigma) + 8 * done)
        own = address(thresholds[done:]) if thresholds.ndim == 2 else 0
        _BATCH.pack_into(batch.data, 0, address(task), address(values[done:]), own, some, free, *into, 0, 0)
        finished = _many(address(batch))
        *_, fault, n_wanted = _BATCH.unpack_from(batch.data)
        n += int(n_found[done : done + finished].sum())
        done += finished
        if fault != FINE:
            break
        if finished < some:
            room = _grown(room, n, 2 * (n + n_wanted))
    return room.first(n), n_found[:done], sigma[:done]


def _grown(room: Rows, n: int, size: int) -> Rows:
    """Return more room, with the first n rows in it."""
    larger = Rows.empty(size, room.counts.shape[2])
    for new, old in zip(larger, room, strict=True):
        new[:n] = old[:n]
    return larger


def measure_whole(
    values: NDArray[np.float64], level: float, pitch: tuple[float, float] | None
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Measure the section {V > level} of a whole frame: its measures and counts, as `Profile` takes them."""
    task, (rows, cols) = _tasks.mine, values.shape
    size = (rows + 2) * (cols + 2)
    thresholds, padded, label = np.array([level]), np.empty(size), np.empty(size, np.int32)
    measures, counts = np.empty(N_COLUMNS), np.empty((2, 1), np.int64)
    room, task.options = work_space(_work(rows, cols, 1)), None
    _ASKED.pack_into(
        *(task.bytes, 0, address(values), 0, 0, address(thresholds), *(pitch or (1.0, 1.0)), -1.0, -1.0),
        *(rows, cols, 1, 0, address(padded), address(label), 0, room),
    )
    _ROOM.pack_into(task.bytes, _ASKED.size, 0, 0, address(measures), address(counts), 0)
    _whole(task.at)
    return measures, counts
