"""The kernel's call: a frame made fit, its contacts found and all their sections measured."""

from __future__ import annotations

import ctypes
import threading

import numpy as np
from numpy.typing import NDArray

from varishold.kernel import address, bind, work_space
from varishold.levelset.columns import N_COLUMNS, N_PLACES
from varishold.levelset.contact import Frame

__all__ = ["ALL_BROKEN", "FINE", "INFINITE", "UNORDERED", "measure_frame", "measure_whole"]

#: What may be wrong with a frame or its thresholds, which must fall or rise and be finite.
FINE, INFINITE, ALL_BROKEN, UNORDERED = range(4)

_POINTERS = ("frame", "field", "valid", "thresholds")
_NUMBERS = ("row_pitch", "col_pitch", "floor", "timed_sigma")
_SIZES = ("rows", "cols", "n_levels", "reserved")
_ROOM = ("padded", "label", "dead", "work", "places", "values", "measures", "counts", "order")


class _Task(ctypes.Structure):
    """``vh_contacts`` of ``varishold.h``."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in _POINTERS),
        *((name, ctypes.c_double) for name in _NUMBERS),
        *((name, ctypes.c_int32) for name in _SIZES),
        *((name, ctypes.c_void_p) for name in _ROOM),
        ("sigma", ctypes.c_double),
        ("reach", ctypes.c_double),
        ("rest", ctypes.c_double * 3),
        *((name, ctypes.c_int32) for name in ("n_contacts", "n_ordered", "n_events", "has_gaps")),
    )


class _Prepared(threading.local):
    """A thread's task: what stays the same from frame to frame is written once."""

    def __init__(self) -> None:
        self.task = _Task()
        self.at = ctypes.addressof(self.task)
        self.sizes: tuple[int, int, int] = (0, 0, 0)
        self.n_bytes = 0


_prepared = _Prepared()
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
    rows, cols = values.shape
    n_levels = n_even or thresholds.size
    task = _prepared.task
    if _prepared.sizes != (rows, cols, n_levels):
        task.rows, task.cols, task.n_levels = _prepared.sizes = (rows, cols, n_levels)
        _prepared.n_bytes = _work(rows, cols, n_levels)
    size = (rows + 2) * (cols + 2)
    taxels = np.empty(size + (4 * size + rows * cols + 14) // 8)
    at = address(taxels)
    task.frame = address(values)
    task.field = address(field) if field.size else None
    task.valid = address(valid) if valid.size else None
    task.thresholds = None if n_even else address(thresholds)
    task.row_pitch, task.col_pitch = pitch or (1.0, 1.0)
    task.floor, task.timed_sigma = floor, timed_sigma
    task.padded, task.label, task.dead = at, at + 8 * size, at + 12 * size
    task.work = work_space(_prepared.n_bytes)
    fault: int = _find(_prepared.at)
    if fault != FINE:
        return fault, None, []
    n = task.n_contacts
    found, order = np.empty(n * (2 + (N_COLUMNS + 2) * n_levels + N_PLACES)), np.empty(n, np.int32)
    if n:
        at = address(found)
        task.values, task.measures = at, at + 16 * n
        task.counts = task.measures + 8 * n * N_COLUMNS * n_levels
        task.places = task.counts + 16 * n * n_levels
        task.order = address(order)
        _measure(_prepared.at)
    shared = Frame((rows, cols), n_levels, n, taxels, found, task.sigma, pitch, tuple(task.rest))
    return FINE, shared, order[: task.n_ordered].tolist()


def measure_whole(
    values: NDArray[np.float64], level: float, pitch: tuple[float, float] | None
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Measure the section {V > level} of a whole frame: its measures and counts, as `Profile` takes them."""
    rows, cols = values.shape
    size = (rows + 2) * (cols + 2)
    thresholds, padded, label = np.array([level]), np.empty(size), np.empty(size, np.int32)
    measures, counts = np.empty(N_COLUMNS), np.empty((2, 1), np.int64)
    task = _Task(rows=rows, cols=cols, n_levels=1)
    task.row_pitch, task.col_pitch = pitch or (1.0, 1.0)
    task.frame, task.thresholds = address(values), address(thresholds)
    task.padded, task.label = address(padded), address(label)
    task.measures, task.counts = address(measures), address(counts)
    task.work = work_space(_work(rows, cols, 1))
    _whole(ctypes.addressof(task))
    return measures, counts
