"""Where everything stands in the kernel's arrays: one name for each place.

The measures of a contact are one row of numbers: each measure's columns one after the other, each column one number
a threshold, in one piece.
"""

from __future__ import annotations

from varishold.levelset.widths import N_DIRECTIONS

__all__ = [
    "AREA",
    "BORDERS",
    "BOTTOM",
    "BOUNDS",
    "CENTROID",
    "COVARIANCE",
    "END",
    "EXTENT",
    "HOLES",
    "LEFT",
    "N_COLUMNS",
    "N_MEASURED",
    "N_PLACES",
    "N_TAXELS",
    "PARTS",
    "PEAK",
    "PEAK_COL",
    "PEAK_ROW",
    "PERIMETER",
    "RIGHT",
    "THRESHOLD",
    "TOP",
]

#: The first column of each measure: a threshold, an area, a perimeter, a centroid (x, y), a covariance
#: (xx, xy, yx, yy), widths in 16 directions; and how many columns there are.
THRESHOLD, AREA, PERIMETER, CENTROID, COVARIANCE, EXTENT = 0, 1, 2, 3, 5, 9
N_COLUMNS = EXTENT + N_DIRECTIONS
#: Where the measures begin and end.
BOUNDS = (THRESHOLD, AREA, PERIMETER, CENTROID, COVARIANCE, EXTENT, N_COLUMNS)

#: Of a contact's counts at each threshold.
PARTS, HOLES = 0, 1

#: Of a contact's values: its highest taxel, and where its profile ends.
PEAK, END = 0, 1

#: Of a contact's places in the padded frame: its highest taxel; its first and last row and column; its number of
#: taxels; the borders that they reach (bits: left, right, top, bottom); the number of thresholds not below its end.
PEAK_ROW, PEAK_COL, TOP, BOTTOM, LEFT, RIGHT, N_TAXELS, BORDERS, N_MEASURED = range(9)
N_PLACES = 9
