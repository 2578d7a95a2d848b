"""Arrays that know their derivatives by a form's parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Slopes", "parameters"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Slopes:
    """A value in each cell and its derivative by each parameter (forward differentiation).

    Parameters
    ----------
    value : ndarray of shape (n_cells,), or () for one number
    by : ndarray of shape (n_parameters, n_cells), or (n_parameters, 1)
        Derivatives.

    Examples
    --------
    >>> x, = parameters(np.array([3.0]))
    >>> y = x * x + 1.0
    >>> float(y.value), float(y.by[0, 0])
    (10.0, 6.0)
    """

    value: Floats
    by: Floats

    # An array on the left must leave the operation to this class.
    __array_ufunc__ = None

    def __add__(self, other: Slopes | Floats | float) -> Slopes:
        if isinstance(other, Slopes):
            return Slopes(self.value + other.value, self.by + other.by)
        return Slopes(self.value + other, self.by)

    def __neg__(self) -> Slopes:
        return Slopes(-self.value, -self.by)

    def __sub__(self, other: Slopes | Floats | float) -> Slopes:
        return self + (-other)

    def __rsub__(self, other: Floats | float) -> Slopes:
        return -self + other

    def __radd__(self, other: Floats | float) -> Slopes:
        return self + other

    def __mul__(self, other: Slopes | Floats | float) -> Slopes:
        if isinstance(other, Slopes):
            return Slopes(self.value * other.value, self.by * other.value + other.by * self.value)
        return Slopes(self.value * other, self.by * other)

    def __rmul__(self, other: Floats | float) -> Slopes:
        return self * other

    def __truediv__(self, other: Slopes | float) -> Slopes:
        if isinstance(other, Slopes):
            ratio = self.value / other.value
            return Slopes(ratio, (self.by - other.by * ratio) / other.value)
        return self * (1.0 / other)

    def through(self, value: Floats, slope: Floats) -> Slopes:
        """Return f of this, given f's value and slope here."""
        return Slopes(value, self.by * slope)

    def sqrt(self) -> Slopes:
        """Return the square root of positive values."""
        root = np.sqrt(self.value)
        return self.through(root, 0.5 / root)

    def sin(self) -> Slopes:
        """Return the sine."""
        return self.through(np.sin(self.value), np.cos(self.value))

    def cos(self) -> Slopes:
        """Return the cosine."""
        return self.through(np.cos(self.value), -np.sin(self.value))

    def magnitude(self, width: float) -> Slopes:
        """Return |x| averaged over `width` around x: what a cell sees of a crest."""
        x, half = self.value, width / 2
        near = np.abs(x) < half
        return self.through(
            np.where(near, x * x / width + width / 4, np.abs(x)), np.where(near, 2 * x / width, np.sign(x))
        )

    def above_zero(self, width: float) -> Slopes:
        """Return max(x, 0) averaged over `width` around x: what a cell sees of a shoulder."""
        return 0.5 * (self + self.magnitude(width))

    def greater(self, other: Slopes, width: float) -> Slopes:
        """Return the greater of two, averaged over `width` around where they meet."""
        return 0.5 * (self + other + (self - other).magnitude(width))


def parameters(q: Floats) -> tuple[Slopes, ...]:
    """Return each parameter as a value that knows it is itself."""
    eye = np.eye(len(q))[:, :, None]
    return tuple(Slopes(np.asarray(value), eye[i]) for i, value in enumerate(q))
