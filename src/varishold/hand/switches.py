"""On-off switches with hysteresis: the paper's threshold, on the force that presses a switch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_positive

__all__ = ["SwitchSetting", "switched"]


@dataclass(frozen=True)
class SwitchSetting:
    """When a switch closes and when it opens.

    Parameters
    ----------
    on_n : float
        A switch closes at this force. Newtons.
    off_fraction : float
        A closed switch opens below this part of the force at which it closes.
    """

    on_n: float = 0.25
    off_fraction: float = 0.5

    def __post_init__(self) -> None:
        as_positive(self.on_n, "on_n of a switch")
        if not 0 < self.off_fraction <= 1:
            raise InputError(f"off_fraction of a switch must lie in (0, 1], got {self.off_fraction!r}")


def switched(
    forces_n: NDArray[np.float64],
    closed: NDArray[np.bool_],
    on_n: NDArray[np.float64],
    off_n: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Return which switches are closed after these forces.

    Parameters
    ----------
    forces_n : ndarray of shape (n,)
        Force on each switch. Newtons.
    closed : ndarray of shape (n,), bool
        Which were closed before.
    on_n, off_n : ndarray of shape (n,)
        Forces at which each closes and below which it opens. Newtons.

    Examples
    --------
    >>> one = np.ones(1)
    >>> [bool(switched(f * one, np.array([c]), one, 0.5 * one)[0]) for f, c in [(0.7, False), (0.7, True)]]
    [False, True]
    """
    return (forces_n >= on_n) | (closed & (forces_n >= off_n))
