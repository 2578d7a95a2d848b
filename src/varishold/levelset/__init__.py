"""Level sets: the sections of a frame by a falling threshold, all at once and exactly.

V(x, y) is the frame, interpolated linearly between the taxels' centres (marching squares; a saddle cell's
two high corners are joined where the mean of its four values is above the threshold). Its section by the
threshold theta is X = {V > theta}: a taxel exactly at the threshold is out, as a receptor fires only above
its threshold. The pad R is the union of its taxels' rectangles, and V is constant across the outer half of a
border taxel, so that a plane has the pad's whole area; the pad's border is not perimeter. NaN is no taxel.

Positions are (x, y) with x along the columns, y along the rows, counted from the pad's centre.
"""

from __future__ import annotations

from varishold.levelset.profile import Profile
from varishold.levelset.widths import DIRECTIONS

__all__ = ["DIRECTIONS", "Profile"]
