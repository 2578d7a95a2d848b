"""What a hand is likely to be: neither of no hand's size, nor with its fingers where opposed digits stand."""

from __future__ import annotations

import numpy as np

from varishold.errors import InputError
from varishold.hand.mjcf.hand import MjcfHand

__all__ = ["LARGEST_M", "check_likely"]

#: No hand is larger. Metres.
LARGEST_M = 1.0
# Nor smaller.
_SMALLEST_M = 0.02


def check_likely(hand: MjcfHand) -> None:
    """Refuse a hand of no hand's size, or whose fingers stand where opposed digits should."""
    path, place = hand.source.path, hand.phalanges(hand.opened())
    ends = np.concatenate([place.start_m, place.start_m + place.length_m[:, None] * place.along])
    far = float(np.abs(ends).max() + place.radius_m.max())
    across = float(np.ptp(np.vstack([ends, np.zeros((1, 3))]), axis=0).max() + 2 * place.radius_m.max())
    if max(far, across) > LARGEST_M:
        raise InputError(
            f"{path}: the hand is {max(far, across):.3g} m large, and none is larger than "
            f"{LARGEST_M:g} m; an MJCF's lengths are metres: are these millimetres?"
        )
    if across < _SMALLEST_M:
        raise InputError(
            f"{path}: the hand is {1e3 * across:.3g} mm large, and none is smaller than "
            f"{1e3 * _SMALLEST_M:g} mm; an MJCF's lengths are metres: was it scaled twice?"
        )
    y = place.middle_m[:, 1]
    last = np.array([part in {digit.parts[-1] for digit in hand.all_digits} for part in place.parts])
    gap = float(y[last & ~place.opposed].min() - y[last & place.opposed].max())
    if gap <= 0:
        swapped = float(y[last & place.opposed].min() - y[last & ~place.opposed].max()) > 0
        raise InputError(
            f"{path}: the open hand leaves no room between fingers and opposed digits; "
            + ("turn up of [palm] round, or mark the other digits as opposed" if swapped else "see out, up and open")
        )
