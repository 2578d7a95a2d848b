"""What a contact's sections say, gathered in bands of relative depth; the kernel's `bands.c` measures it.

Relative depth is q = (theta_1 - theta) / (theta_1 - delta), so that any schedule of thresholds gives the same
numbers. Every length is measured against the lowest section, so that neither the pitch nor the unit matters.
"""

from __future__ import annotations

__all__ = ["BANDS", "PER_BAND"]

#: Bands of relative depth, the first nearest the top.
BANDS = 8

#: Group and name of every number of a section, in the order in which the kernel writes them.
PER_BAND = (
    ("growth", "root_area"),
    ("growth", "minor"),
    ("growth", "major"),
    ("growth", "perimeter"),
    ("outline", "compactness"),
    ("elongation", "aspect"),
    ("outline", "fullness"),
    ("outline", "box_fill"),
    ("elongation", "second_harmonic"),
    ("outline", "fourth_harmonic"),
    ("outline", "fourth_phase"),
    ("outline", "sixth_harmonic"),
    ("drift", "drift"),
    ("holes and parts", "holes"),
    ("holes and parts", "parts"),
)
