"""What a press bears: its largest load, and how much of that stands on broken taxels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.touch.course.presses import Press

__all__ = ["filled_share", "largest_load", "least_load"]


def largest_load(press: Press, floor: float) -> float:
    """Return the largest load of a press above a floor, all pads together, in the unit of the frames."""
    return float(_loads(press, floor).max())


def filled_share(press: Press, floor: float) -> float:
    """Return which share of the largest load above a floor stands on broken taxels."""
    if not press.filled:
        return 0.0
    loads = _loads(press, floor)
    top = int(np.argmax(loads))
    filled = sum(
        float(np.maximum(press.pads[name][top][broken] - floor, 0.0).sum()) for name, broken in press.filled.items()
    )
    return min(filled / float(loads[top]), 1.0) if loads[top] > 0 else 0.0


def least_load(presses: Sequence[Press], floor: float) -> float:
    """Return the largest load of the press that bears least above a floor."""
    return min(largest_load(press, floor) for press in presses)


def _loads(press: Press, floor: float) -> NDArray[np.float64]:
    """Return the load above a floor of each frame, shape (n_frames,)."""
    of_pads = [np.maximum(frames - floor, 0.0).sum(axis=(1, 2)) for frames in press.pads.values()]
    return np.asarray(np.sum(of_pads, axis=0))
