"""How often which size occurred: small bars over a logarithmic axis, all names over the same one."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

__all__ = ["size_bars"]

_WIDTH, _HEIGHT = 120, 26


def size_bars(counts: NDArray[np.int64], *, label: str) -> Markup:
    """Draw counts as bars.

    Parameters
    ----------
    counts : ndarray of shape (n_steps,), int64
        Those before the first and after the last that is not zero are left out, but for one on each side.
    label : str
        Description for those who cannot see it.
    """
    there = np.flatnonzero(counts)
    if not there.size:
        return Markup("")
    shown = counts[max(0, there[0] - 1) : there[-1] + 2]
    wide = _WIDTH / max(len(shown), 12)
    left = (_WIDTH - wide * len(shown)) / 2
    bars = []
    for step, count in enumerate(shown.tolist()):
        if count:
            # What is there at all is seen.
            high = max(1.5, _HEIGHT * count / int(shown.max()))
            bars.append(f"M{left + (step + 0.1) * wide:.1f} {_HEIGHT}v{-high:.1f}h{0.8 * wide:.1f}V{_HEIGHT}z")
    return Markup('<svg class="sizes" viewBox="0 0 {} {}" role="img" aria-label="{}"><path d="{}"/></svg>').format(
        _WIDTH, _HEIGHT, escape(label), Markup("".join(bars))
    )
