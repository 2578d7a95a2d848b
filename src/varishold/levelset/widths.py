"""The directions in which the widths of sections are taken."""

from __future__ import annotations

import math

import numpy as np

__all__ = ["DIRECTIONS", "N_DIRECTIONS"]

N_DIRECTIONS = 16

#: Angles of the directions in which widths are taken, radians from +x toward +y.
DIRECTIONS = np.arange(N_DIRECTIONS) * (math.pi / N_DIRECTIONS)
