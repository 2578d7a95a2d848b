"""What changed between two frames of one contact: its load, where it lies, where its load lies within it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.contact import Contact

__all__ = ["Change", "Pattern"]

Floats = NDArray[np.float64]
Point = tuple[float, float]

# Taxels around the contact that are looked at too.
_MARGIN = 2
# What is expected before looking: each side moves by about a taxel, the load of a taxel at the rim changes by a third.
_SIDE, _LEAN, _LOAD = 1.0, 0.3, 1.0


@dataclass(frozen=True)
class Change:
    """What changed.

    Parameters
    ----------
    load : float
        By which factor.
    shift : (float, float)
        How far the contact moved, (x, y), in taxels: as far as its opposite sides moved together.
    lean : (float, float)
        How far the centre of load moved within the outline, (x, y), in taxels.
    shift_sigma, lean_sigma : (float, float)
        How far noise alone lets both scatter.
    misfit : float
        Share of the change that is neither.
    """

    load: float
    shift: Point
    lean: Point
    shift_sigma: Point
    lean_sigma: Point
    misfit: float


class Pattern:
    """A contact at one frame, with which later frames are compared.

    The change is written as a sum of seven: the load, each side moving, the load leaning in x and in y; their shares
    are found by least squares, once for all frames that are compared.

    Parameters
    ----------
    contact : Contact
    """

    def __init__(self, contact: Contact) -> None:
        self.region = _widened(contact)
        label = contact.frame.label[1:-1, 1:-1][self.region]
        others = (label != contact.index) & (label >= 0)
        values = contact.frame.padded[1:-1, 1:-1][self.region]
        self._used = ~others & (values > -np.inf)
        self._values = np.where(self._used, values, 0.0)
        own = label == contact.index
        height = np.where(own, self._values, 0.0)
        modes, self._arm = _modes(height)
        scale = np.array([_LOAD, _SIDE, _SIDE, _SIDE, _SIDE, _LEAN, _LEAN])
        design = (modes * self._used).reshape(len(scale), -1) * scale[:, None]
        gram = design @ design.T
        ridge = max(contact.sigma, 1e-3 * contact.peak) ** 2
        inverse = np.linalg.inv(gram + ridge * np.eye(len(scale)))
        self._solve = scale[:, None] * (inverse @ design)
        self._sigma = np.sqrt(np.einsum("ij,ij->i", self._solve, self._solve))

    def change(self, frame: Floats, sigma: float) -> Change:
        """Return what changed up to a later frame, of shape (rows, cols)."""
        later = np.where(self._used, frame[self.region], 0.0)
        by = self._solve @ (later - self._values).ravel()
        load, left, right, top, bottom, lean_x, lean_y = by.tolist()
        s = (2**0.5 * sigma * self._sigma).tolist()
        return Change(
            1 + load,
            (_together(left, right), _together(top, bottom)),
            (lean_x * self._arm[0], lean_y * self._arm[1]),
            (max(s[1], s[2]), max(s[3], s[4])),
            (s[5] * self._arm[0], s[6] * self._arm[1]),
            0.0,
        )


def _together(one: float, other: float) -> float:
    """Return how far two sides moved together."""
    if one * other <= 0:
        return 0.0
    return min(one, other, key=abs)


def _widened(contact: Contact) -> tuple[slice, slice]:
    rows, cols = contact.window
    n_rows, n_cols = contact.shape
    return (
        slice(max(rows.start - _MARGIN, 0), min(rows.stop + _MARGIN, n_rows)),
        slice(max(cols.start - _MARGIN, 0), min(cols.stop + _MARGIN, n_cols)),
    )


def _modes(height: Floats) -> tuple[Floats, Point]:
    """Return how the frame changes by a unit of each, shape (7, rows, cols), and the arm of the leaning."""
    rows, cols = height.shape
    total = float(height.sum())
    by_col, by_row = height.sum(axis=0), height.sum(axis=1)
    x, y = np.arange(cols, dtype=np.float64), np.arange(rows, dtype=np.float64)
    x -= float(by_col @ x) / total
    y -= float(by_row @ y) / total
    var_x, var_y = float(by_col @ (x * x)) / total, float(by_row @ (y * y)) / total
    arm_x, arm_y = max(var_x, 0.05) ** 0.5, max(var_y, 0.05) ** 0.5
    padded = np.pad(height, 1)
    along_x = (padded[1:-1, 2:] - padded[1:-1, :-2]) / 2
    along_y = (padded[2:, 1:-1] - padded[:-2, 1:-1]) / 2
    modes = np.stack(
        [
            height,
            *(-np.maximum(along_x, 0.0), -np.minimum(along_x, 0.0)),
            *(-np.maximum(along_y, 0.0), -np.minimum(along_y, 0.0)),
            *(height * (x / (2 * arm_x)), height * (y / (2 * arm_y))[:, None]),
        ]
    )
    # A lean of 1 changes the load by half at one standard deviation: the centre of load moves by half an arm.
    return modes, (arm_x / 2, arm_y / 2)
