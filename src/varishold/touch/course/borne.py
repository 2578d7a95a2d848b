"""What a press bears: its largest load, and how much of that stands on broken taxels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from varishold.touch.course.presses import Press

__all__ = ["filled_share", "largest_load", "least_load"]


def largest_load(press: Press, floor: float) -> float:
    """Return the largest load of a press above a floor, all pads together, in the unit of the frames."""
    loads = [np.maximum(frames - floor, 0.0).sum(axis=(1, 2)) for frames in press.pads.values()]
    return float(np.sum(loads, axis=0).max())


def filled_share(press: Press, floor: float) -> float:
    """Return which share of the largest load above a floor stands on broken taxels."""
    if not press.filled:
        return 0.0
    above = {name: np.maximum(frames - floor, 0.0) for name, frames in press.pads.items()}
    loads = np.sum([of.sum(axis=(1, 2)) for of in above.values()], axis=0)
    top = int(np.argmax(loads))
    filled = sum(float(above[name][top][broken].sum()) for name, broken in press.filled.items())
    return min(filled / float(loads[top]), 1.0) if loads[top] > 0 else 0.0


def least_load(presses: Sequence[Press], floor: float) -> float:
    """Return the largest load of the press that bears least above a floor."""
    return min(largest_load(press, floor) for press in presses)
