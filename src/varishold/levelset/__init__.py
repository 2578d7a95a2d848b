"""Level sets: the sections of a frame by a falling threshold, all at once and exactly.

V(x, y) is the frame, interpolated linearly between the taxels' centres (marching squares; a saddle cell's
two high corners are joined where the mean of its four values is above the threshold). These rules hold
everywhere:

- Ties. The section by the threshold theta is X = {V > theta}: a taxel exactly at the threshold is out, as a
  receptor fires only above its threshold. A plateau comes in all at once, just below its value.
- Border. The pad R is the union of its taxels' rectangles, and V is constant across the outer half of a border
  taxel, so that a plane has the pad's whole area. The pad's border is not perimeter.
- Gaps. NaN, or False in `field`, is no taxel: outside R, its border is the pad's. A gap of the field that a
  section covers all around is no hole of the section; it is one where a taxel beside the gap is uncovered.

Positions are (x, y), x along the columns and y along the rows, counted from the pad's centre.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "DIRECTIONS",
    "SCHEDULES",
    "Borders",
    "Contact",
    "ContactBatch",
    "ContactState",
    "Losses",
    "MeasureTable",
    "Profile",
    "VaryingThreshold",
    "cut",
    "even",
    "find_contacts",
    "find_contacts_batch",
    "geometric",
    "measure",
    "outlines",
    "quadratic",
    "reconstruct_from_sections",
]

if TYPE_CHECKING:
    from varishold.levelset.batch import ContactBatch
    from varishold.levelset.contact import Borders, Contact
    from varishold.levelset.contact_state import ContactState, Losses
    from varishold.levelset.contacts import find_contacts, find_contacts_batch
    from varishold.levelset.outline import outlines
    from varishold.levelset.profile import Profile
    from varishold.levelset.reconstruction import cut, reconstruct_from_sections
    from varishold.levelset.schedule import SCHEDULES, VaryingThreshold, even, geometric, quadratic
    from varishold.levelset.table import MeasureTable, measure
    from varishold.levelset.widths import DIRECTIONS
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
