"""The shape of each pad, which a stray frame of another one does not change."""

from __future__ import annotations

__all__ = ["SteadyShapes"]

# So many frames of another shape, one right after the other, are no damage: the pad is another one now.
_TIMES = 5


class SteadyShapes:
    """Tells frames of a pad's own shape from stray ones.

    A pad's shape changes where another came as often in a row as frames were taken before, five times at most.

    Examples
    --------
    >>> shapes = SteadyShapes()
    >>> [shapes.takes("pad", shape) for shape in ((8, 8), (8, 8), (7, 8), (8, 8))]
    [True, True, False, True]
    >>> shapes.of("pad")
    (8, 8)
    """

    def __init__(self) -> None:
        self._own: dict[str, tuple[int, ...]] = {}
        self._taken: dict[str, int] = {}
        # The other shape that came last, and how often in a row.
        self._other: dict[str, tuple[tuple[int, ...], int]] = {}

    def of(self, pad: str) -> tuple[int, ...]:
        """Return the shape of a pad that has come."""
        return self._own[pad]

    def takes(self, pad: str, shape: tuple[int, ...]) -> bool:
        """Tell whether a frame of a pad is of the shape that the pad has, with what came before."""
        if shape != self._own.setdefault(pad, shape):
            other, times = self._other.get(pad, (shape, 0))
            times = times + 1 if other == shape else 1
            if times < min(self._taken[pad], _TIMES):
                self._other[pad] = shape, times
                return False
            self._own[pad] = shape
        self._other.pop(pad, None)
        self._taken[pad] = min(self._taken.get(pad, 0) + 1, _TIMES)
        return True
