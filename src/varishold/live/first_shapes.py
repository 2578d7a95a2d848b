"""The shape of each pad as a recording begins, which a stray first frame does not decide."""

from __future__ import annotations

from varishold.live.sample import Sample

__all__ = ["FirstShapes"]

# So many readings are held at most: of pads that come in turn, or of one whose shape never stays.
_MOST = 32


class FirstShapes:
    """Holds readings until the shape of each of their pads has come twice in a row.

    Examples
    --------
    >>> import numpy as np
    >>> first = FirstShapes()
    >>> readings = [Sample(0.0, None, None, {"pad": np.zeros(shape)}) for shape in ((5, 8), (8, 8), (8, 8))]
    >>> [len(first.take(each)) for each in readings], first.of("pad")
    ([0, 0, 3], (8, 8))
    """

    def __init__(self) -> None:
        self._seen: dict[str, tuple[int, ...]] = {}
        self._sure = set[str]()
        self._held: list[Sample] = []

    def __len__(self) -> int:
        """Return how many readings are held."""
        return len(self._held)

    def of(self, pad: str) -> tuple[int, ...]:
        """Return the shape of a pad that has come."""
        return self._seen[pad]

    def take(self, sample: Sample) -> list[Sample]:
        """Return the readings that are held no longer, in the order in which they came."""
        for name, values in sample.pads.items():
            if name not in self._sure:
                if self._seen.get(name) == values.shape:
                    self._sure.add(name)
                self._seen[name] = values.shape
        self._held.append(sample)
        known = all(name in self._sure for each in self._held for name in each.pads)
        return self.release() if known or len(self._held) >= _MOST else []

    def release(self) -> list[Sample]:
        """Return what is held; its pads keep the shape that came last."""
        held, self._held = self._held, []
        self._sure.update(name for each in held for name in each.pads)
        return held
