"""What laws of circuits are tried on."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

few = settings(max_examples=40)
seeds = st.integers(0, 2**32 - 1)
#: The largest whole number of a circuit.
MOST = 2**31 - 1


def all_bits(n: int) -> np.ndarray:
    """Return all patterns of n bits, in the order of numbers."""
    return np.array(list(itertools.product((0, 1), repeat=n)), np.uint8).reshape(-1, n)
