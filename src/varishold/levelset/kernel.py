"""The kernel's call: a frame made fit, its contacts found and all their sections measured."""

from __future__ import annotations

import struct
import threading

import numpy as np
from numpy.typing import NDArray

from varishold.kernel import address, bind, work_space
from varishold.levelset.columns import N_COLUMNS, N_PLACES
from varishold.levelset.contact import Frame

__all__ = ["ALL_BROKEN", "FINE", "INFINITE", "UNORDERED", "measure_frame", "measure_whole"]

#: What may be wrong with a frame or its thresholds, which must fall or rise and be finite.
FINE, INFINITE, ALL_BROKEN, UNORDERED = range(4)

# struct vh_frame of varishold.h in its three parts: what is asked and the room to find contacts in; the room to measure
# them in; what is found. One call writes many numbers at once, where a ctypes structure takes one call for each.
_ASKED, _ROOM, _FOUND = struct.Struct("@4P4d4i4P"), struct.Struct("@5P"), struct.Struct("@5d4i")


class _Task(threading.local):
    """A thread's ``struct vh_frame``."""

    def __init__(self) -> None:
        room = np.zeros(_ASKED.size + _ROOM.size + _FOUND.size, np.uint8)
        self.bytes, self.at = room.data, address(room)
        # Bytes of work space that frames of so many rows, columns and levels take.
        self.sizes, self.n_bytes = (0, 0, 0), 0


_task = _Task()
_find = bind("vh_find_contacts", "p", "i")
_measure = bind("vh_measure_contacts", "p")
_whole = bind("vh_measure_whole", "p")
_work = bind("vh_contacts_work", "iii", "z")


def measure_frame(
    values: NDArray[np.float64],
    n_even: int,
    thresholds: NDArray[np.float64],
    pitch: tuple[float, float] | None,
    valid: NDArray[np.bool_],
    field: NDArray[np.bool_],
    floor: float,
    timed_sigma: float,
) -> tuple[int, Frame | None, list[int]]:
    """Do all of `find_contacts` with arguments as `varishold.frame.checks` returns them.

    Returns
    -------
    fault : int
        `FINE`, or what is wrong.
    frame : Frame or None
        None unless it is fine.
    order : list of int
        The contacts by falling area of their lowest section, then by falling number of taxels; without those that
        noise alone makes.
    """
    task, (rows, cols) = _task, values.shape
    n_levels = n_even or thresholds.size
    if task.sizes != (rows, cols, n_levels):
        task.sizes, task.n_bytes = (rows, cols, n_levels), _work(rows, cols, n_levels)
    size = (rows + 2) * (cols + 2)
    taxels = np.empty(size + (4 * size + rows * cols + 14) // 8)
    at = address(taxels)
    _ASKED.pack_into(
        task.bytes,
        0,
        address(values),
        address(field) if field.size else 0,
        address(valid) if valid.size else 0,
        0 if n_even else address(thresholds),
        *(pitch or (1.0, 1.0)),
        floor,
        timed_sigma,
        rows,
        cols,
        n_levels,
        0,
        at,
        at + 8 * size,
        at + 12 * size,
        work_space(task.n_bytes),
    )
    fault: int = _find(task.at)
    if fault != FINE:
        return fault, None, []
    *_, n, _, _, _ = _FOUND.unpack_from(task.bytes, _ASKED.size + _ROOM.size)
    # Values, measures, counts and places of each contact, and their order.
    n_numbers = n * (2 + (N_COLUMNS + 2) * n_levels + N_PLACES)
    found = np.empty(n_numbers + (n + 1) // 2)
    if n:
        at = address(found)
        counts = at + 8 * n * (2 + N_COLUMNS * n_levels)
        places = counts + 16 * n * n_levels
        _ROOM.pack_into(task.bytes, _ASKED.size, places, at, at + 16 * n, counts, at + 8 * n_numbers)
        _measure(task.at)
    sigma, _, *rest, n, n_ordered, _, _ = _FOUND.unpack_from(task.bytes, _ASKED.size + _ROOM.size)
    shared = Frame((rows, cols), n_levels, n, taxels, found[:n_numbers], sigma, pitch, tuple(rest))
    return FINE, shared, found[n_numbers:].view(np.int32)[:n_ordered].tolist()


def measure_whole(
    values: NDArray[np.float64], level: float, pitch: tuple[float, float] | None
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Measure the section {V > level} of a whole frame: its measures and counts, as `Profile` takes them."""
    task, (rows, cols) = _task, values.shape
    size = (rows + 2) * (cols + 2)
    thresholds, padded, label = np.array([level]), np.empty(size), np.empty(size, np.int32)
    measures, counts = np.empty(N_COLUMNS), np.empty((2, 1), np.int64)
    room = work_space(_work(rows, cols, 1))
    _ASKED.pack_into(
        *(task.bytes, 0, address(values), 0, 0, address(thresholds), *(pitch or (1.0, 1.0)), -1.0, -1.0),
        *(rows, cols, 1, 0, address(padded), address(label), 0, room),
    )
    _ROOM.pack_into(task.bytes, _ASKED.size, 0, 0, address(measures), address(counts), 0)
    _whole(task.at)
    return measures, counts
