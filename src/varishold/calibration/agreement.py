"""Whether two halves of the presses agree on the taxels' gains."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted

__all__ = ["LEAST_SPREAD", "Agreement", "agreement_of", "hardly_pressed"]

Floats = NDArray[np.float64]

#: Spread of the gains below which a correction does as much harm as good.
LEAST_SPREAD = 0.03
# Share of the gains' variance that two halves of the presses must agree on.
_AGREEMENT = 0.5


class Agreement(NamedTuple):
    """How far two halves of the presses find the same gains.

    Parameters
    ----------
    spread : float
        How far the gains spread that they find alike.
    share : float
        Which share of the gains' variance that is.
    differ : float
        Standard error of a gain by all presses, as the halves differ.
    """

    spread: float
    share: float
    differ: float

    @property
    def worth(self) -> bool:
        """Whether it is worth while to even the gains out."""
        return self.spread >= LEAST_SPREAD and self.share >= _AGREEMENT

    @property
    def refusal(self) -> str:
        """Why these gains were not applied."""
        return (
            f"the gains were not applied: they spread by {100 * self.spread:.2g} %, of which two halves of the presses "
            f"agree on {100 * self.share:.0f} %; below {100 * LEAST_SPREAD:.0f} %, or without agreement, nothing is won"
        )


def agreement_of(one: Floats, other: Floats) -> Agreement:
    """Return how far two halves' log gains, about 0 on the mean and of the same taxels, agree."""
    if not one.size:
        return Agreement(0.0, 0.0, 0.0)
    spread = float(np.sqrt(max(float(np.mean(one * other)), 0.0)))
    share = spread**2 / max(float(np.mean((one**2 + other**2) / 2)), 1e-300)
    # Half of the difference of two halves is what noise leaves of all of them.
    return Agreement(spread, share, float(np.std(one - other)) / 2)


def hardly_pressed(silent: NDArray[np.bool_]) -> list[str]:
    """Say how many taxels have no gain of their own."""
    if not silent.any():
        return []
    words = counted(np.count_nonzero(silent), "taxel was hardly pressed: its", "taxels were hardly pressed: their")
    return [f"{words} gain is taken as 1; press there too"]
