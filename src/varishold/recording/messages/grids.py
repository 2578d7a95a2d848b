"""Values that came in one row, put on the grid that a person named."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.recording.messages.reading import Asked, MessagePad

__all__ = ["axis_names", "grid_pads", "native", "normal_and_shear", "signal_pad"]

#: No pad has more values than this.
MOST_VALUES = 1 << 24


def native(values: NDArray[Any]) -> NDArray[Any]:
    """Return values in this machine's byte order, their rows one after another."""
    return np.ascontiguousarray(values, values.dtype.newbyteorder("="))


def grid_pads(values: NDArray[Any], asked: Asked, **said: Any) -> dict[str, MessagePad]:
    """Return the pads that values make, of any dimensions up to three.

    One row of values takes the shape that was asked for, or several pads of that shape; (rows, cols) stay, and three
    dimensions are several pads. `said` goes to each `MessagePad`.

    Raises
    ------
    InputError
        If the shape does not fit, or there are more dimensions.
    """
    if values.size == 0:
        return {}
    if values.ndim == 1 and asked.shape is not None:
        rows, cols = asked.shape
        if values.size % (rows * cols):
            raise InputError(
                f"{values.size} values came, which are no {rows} x {cols}, as was said, nor several",
                parameter="shape",
            )
        values = values.reshape(-1, rows, cols)
    if values.ndim > 3:
        raise InputError(f"values of {values.ndim} dimensions came; a pad has rows and columns")
    if values.ndim < 3:
        return {"": MessagePad(native(values), **said)}
    if len(values) == 1:
        return {"": MessagePad(native(values[0]), **said)}
    return {str(number): MessagePad(native(grid), **said) for number, grid in enumerate(values)}


def normal_and_shear(
    axes: NDArray[Any], shape: tuple[int, ...] | None, *, unit: str = "raw", sensor: str = ""
) -> dict[str, MessagePad]:
    """Return the normal pressure of taxels with three axes, and their shear beside it: x and y of each in turn.

    Parameters
    ----------
    axes : ndarray of shape (n, 3)
        x, y, z of each taxel.
    shape : tuple of int or None
        (rows, cols) of the grid; None, or one that does not fit, leaves them on none.
    """
    if len(axes) == 0:
        return {}
    grid = shape if shape is not None and np.prod(shape) == len(axes) else (len(axes),)
    return {
        "": MessagePad(native(axes[:, 2].reshape(grid)), unit=unit, sensor=sensor),
        "shear.": signal_pad(axes[:, :2].ravel(), axis_names("xy", len(axes)), unit),
    }


@lru_cache(64)
def axis_names(axes: str, n_taxels: int) -> tuple[str, ...]:
    """Return what the signals of taxels with several axes are called, taxel by taxel.

    Examples
    --------
    >>> axis_names("xy", 2)
    ('x0', 'y0', 'x1', 'y1')
    """
    return tuple(f"{axis}{number}" for number in range(n_taxels) for axis in axes)


def signal_pad(values: NDArray[Any], names: tuple[str, ...] = (), unit: str = "raw") -> MessagePad:
    """Return a pad of signals from one row of values."""
    return MessagePad(native(values), "signals", unit, names=names)
