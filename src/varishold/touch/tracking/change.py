"""What changed since a contact rested: its load, where it lies, or where its load lies within it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.felt import Felt

__all__ = ["Change", "Rest"]

Floats = NDArray[np.float64]
Point = tuple[float, float]

# Taxels around the contact that are looked at too.
_MARGIN = 2
# Modes that differ from the others by less than this share are none of their own.
_LEAST_OWN = 1e-3
# A taxel has this second moment in itself, in taxels squared.
_LEAST_SECOND = 1 / 12
# The modes are made anew once so much of the mean is new.
_STALE = 0.2
# Where the pressure is steep, so much of a taxel's step is unsure; no taxel is surer than this share of the peak.
_BENEATH, _ABOVE, _LEAST_SIGMA = 0.1, 0.03, 0.01


@dataclass(frozen=True)
class Change:
    """What changed.

    Parameters
    ----------
    load : float
        By which factor.
    shift : (float, float)
        How far the contact moved, (x, y) in taxels, if it moved.
    lean : (float, float)
        How far the centre of load moved within the outline, (x, y) in taxels, if the contact stayed and tipped.
    by_shift, by_lean : float
        How much of the change each explains beside the load, in squares of the frame's unit.
    shift_sigma, lean_sigma : float
        How far noise alone lets both scatter, in taxels.
    variance : (float, float, float)
        Of the load about its centre, (xx, xy, yy), in taxels squared.
    """

    load: float
    shift: Point
    lean: Point
    by_shift: float
    by_lean: float
    shift_sigma: float
    lean_sigma: float
    variance: tuple[float, float, float]

    def breadth(self, along: Point) -> float:
        """Return how far the load scatters about its centre along a direction, in taxels."""
        x, y = along
        xx, xy, yy = self.variance
        return math.sqrt(max(xx * x * x + 2 * xy * x * y + yy * y * y, 0.0) / max(x * x + y * y, 1e-300))


class Rest:
    """A contact at rest: the mean of its frames, with which later frames are compared.

    A change of load multiplies the pressure, or adds the same everywhere. What is left of a change is explained by a
    shift, which moves the slopes of the pressure, or by a lean, which adds pressure on one side and takes it from the
    other: by whichever explains more. On a ball both do the same.

    Parameters
    ----------
    felt : Felt
        The contact, in a frame in which it rests.
    """

    def __init__(self, felt: Felt) -> None:
        contact = felt.contact
        self._region = _widened(felt)
        label = contact.frame.label[1:-1, 1:-1][self._region]
        values = contact.frame.padded[1:-1, 1:-1][self._region]
        self._own = label == contact.index
        self._used = ((label < 0) | self._own) & (values > -np.inf)
        self._mean = np.where(self._used, values, 0.0)
        self._floor = contact.floor
        self._sigma = felt.sigma
        self._modes: _Modes | None = None
        self._age = 0.0
        #: How many frames it is the mean of, at most as many as count.
        self.frames = 1
        #: Mean centre of load, in taxels.
        self.position = felt.position

    def add(self, felt: Felt, frame: Floats, share: float) -> None:
        """Take one more frame into the mean, with a share."""
        self._mean += share * (np.where(self._used, frame[self._region], 0.0) - self._mean)
        (x, y), (new_x, new_y) = self.position, felt.position
        self.position = x + share * (new_x - x), y + share * (new_y - y)
        self.frames += 1
        self._age += share
        if self._age > _STALE:
            self._modes = None

    def change(self, frame: Floats, sigma: float) -> Change:
        """Return what changed up to a later frame, of shape (rows, cols)."""
        if self._modes is None:
            self._age = 0.0
            self._modes = _Modes(self._mean, self._own, self._used, self._sigma)
        later = np.where(self._used, frame[self._region], 0.0)
        return self._modes.explain(later - self._mean, sigma * math.sqrt(1 + 1 / self.frames))


class _Modes:
    """The ways in which a contact's pressure changes, each without what the load alone does.

    Where the pressure is steep, how a taxel changes in a small shift depends on where within it the border lies, which
    nobody knows: such taxels count less.
    """

    def __init__(self, mean: Floats, own: NDArray[np.bool_], used: NDArray[np.bool_], sigma: float) -> None:
        rows, cols = mean.shape
        height = np.where(_with_ring(own), np.maximum(mean, 0.0), 0.0)
        total = float(height.sum())
        x, y = np.arange(cols, dtype=np.float64), np.arange(rows, dtype=np.float64)[:, None]
        x -= float(height.sum(axis=0) @ x) / total
        y -= float(height.sum(axis=1) @ y[:, 0]) / total
        by_col, by_row = height.sum(axis=0), height.sum(axis=1)
        xx, yy = float(by_col @ (x * x)) / total, float(by_row @ (y * y)[:, 0]) / total
        self._variance = xx, float((x @ height.T) @ y[:, 0]) / total, yy
        padded = np.pad(height, 1)
        to_left, to_right = height - padded[1:-1, :-2], padded[1:-1, 2:] - height
        to_top, to_bottom = height - padded[:-2, 1:-1], padded[2:, 1:-1] - height
        # At an upright border a taxel is covered by as much as it stands beside the highest around it.
        covered = height / np.maximum(_highest_around(padded), 1e-300)
        # The centre of load moves by one taxel where the pressure of every taxel changes by so much.
        second = np.array([[float((covered * a * b).sum()) for a in (x, y)] for b in (x, y)])
        turn = total * np.linalg.inv(second + _LEAST_SECOND * float(covered.sum()) * np.eye(2))
        lean_x, lean_y = covered * (turn[0, 0] * x + turn[0, 1] * y), covered * (turn[1, 0] * x + turn[1, 1] * y)
        modes = np.stack([height, covered, -(to_left + to_right) / 2, -(to_top + to_bottom) / 2, lean_x, lean_y])
        # A taxel beside a much higher one may be covered in part; one beside a much lower one is covered, or nearly.
        beneath = np.maximum.reduce([-to_left, to_right, -to_top, to_bottom, np.zeros_like(height)])
        above = np.maximum.reduce([to_left, -to_right, to_top, -to_bottom, np.zeros_like(height)])
        least = max(sigma, _LEAST_SIGMA * float(height.max()), 1e-300)
        # Not by squares, which vanish where the whole contact is faint.
        unsure = np.hypot(_BENEATH * beneath, _ABOVE * above)
        weight = np.where(used, least / np.hypot(least, unsure), 0.0)
        flat = (modes * weight).reshape(6, -1)
        self._weight = weight.ravel()
        self._height = flat[0] / max(float(flat[0] @ flat[0]), 1e-300)
        base = _orthonormal(flat[:2])
        self._shift, self._shift_of, self._shift_scatter = _apart(flat[2:4], base, self._weight)
        self._lean, self._lean_of, self._lean_scatter = _apart(flat[4:], base, self._weight)

    def explain(self, change: Floats, sigma: float) -> Change:
        """Return what a change is."""
        flat = change.ravel() * self._weight
        along_shift, along_lean = self._shift @ flat, self._lean @ flat
        shift, lean = self._shift_of @ along_shift, self._lean_of @ along_lean
        return Change(
            1 + float(self._height @ flat),
            (float(shift[0]), float(shift[1])),
            (float(lean[0]), float(lean[1])),
            float(along_shift @ shift),
            float(along_lean @ lean),
            sigma * self._shift_scatter,
            sigma * self._lean_scatter,
            self._variance,
        )


def _with_ring(own: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return taxels and their four neighbours."""
    wide = np.pad(own, 1)
    return wide[1:-1, 1:-1] | wide[:-2, 1:-1] | wide[2:, 1:-1] | wide[1:-1, :-2] | wide[1:-1, 2:]


def _highest_around(padded: Floats) -> Floats:
    """Return the highest of each taxel and its eight neighbours, of a patch with one taxel of rim."""
    beside = np.maximum(np.maximum(padded[:, :-2], padded[:, 2:]), padded[:, 1:-1])
    highest: Floats = np.maximum(np.maximum(beside[:-2], beside[2:]), beside[1:-1])
    return highest


def _orthonormal(rows: Floats) -> Floats:
    """Return rows of length 1, each without the ones before; a row that has nothing of its own is 0."""
    out = np.zeros_like(rows)
    for i, row in enumerate(rows):
        left = row - out[:i].T @ (out[:i] @ row)
        length = float(left @ left)
        if length > _LEAST_OWN * float(row @ row):
            out[i] = left / math.sqrt(length)
    return out


def _apart(rows: Floats, base: Floats, weight: Floats) -> tuple[Floats, Floats, float]:
    """Return two rows without the base, the inverse of their products, and how noise scatters what they explain."""
    left = rows - (rows @ base.T) @ base
    least = _LEAST_OWN * float(np.einsum("ij,ij->i", rows, rows).max()) + 1e-300
    inverse = np.asarray(np.linalg.inv(left @ left.T + least * np.eye(2)), dtype=np.float64)
    solve = (inverse @ left) * weight
    return left, inverse, math.sqrt(float(np.einsum("ij,ij->i", solve, solve).max()))


def _widened(felt: Felt) -> tuple[slice, slice]:
    rows, cols = felt.contact.window
    n_rows, n_cols = felt.contact.shape
    return (
        slice(max(rows.start - _MARGIN, 0), min(rows.stop + _MARGIN, n_rows)),
        slice(max(cols.start - _MARGIN, 0), min(cols.stop + _MARGIN, n_cols)),
    )
