"""The sizes that a hand holds at all."""

from __future__ import annotations

__all__ = ["LEAST_SIZE_M", "MOST_SIZE_M"]

#: Nothing that a hand holds is smaller or larger. Metres.
LEAST_SIZE_M, MOST_SIZE_M = 0.001, 2.0
