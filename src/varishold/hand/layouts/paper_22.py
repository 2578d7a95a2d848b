"""The paper's count of switches: 12 on the fingers, 3 on the thumb, 7 on the palm (its Fig. 4).

The figure's places cannot be read in the scan. Here the palm's buttons stand in columns of 2, 3 and 2, so that
a flat face meets all three columns and a cylinder, which meets the palm along a line, at most two neighbours.
"""

from __future__ import annotations

from varishold.hand.layouts.switch import Layout, Switch

__all__ = ["PAPER_22"]

#: The twenty-two switches of the paper's hand.
PAPER_22 = Layout(
    "paper-22",
    (
        Switch("index_proximal", "index.proximal"),
        Switch("index_middle", "index.middle"),
        Switch("index_distal", "index.distal"),
        Switch("middle_proximal", "middle.proximal"),
        Switch("middle_middle", "middle.middle"),
        Switch("middle_distal", "middle.distal"),
        Switch("ring_proximal", "ring.proximal"),
        Switch("ring_middle", "ring.middle"),
        Switch("ring_distal", "ring.distal"),
        Switch("little_proximal", "little.proximal"),
        Switch("little_middle", "little.middle"),
        Switch("little_distal", "little.distal"),
        Switch("thumb_proximal", "thumb.proximal"),
        Switch("thumb_middle", "thumb.middle"),
        Switch("thumb_distal", "thumb.distal"),
        Switch("palm_finger_upper", "palm", 0.015, 0.014),
        Switch("palm_finger_lower", "palm", 0.015, -0.014),
        Switch("palm_centre_upper", "palm", 0.0, 0.030),
        Switch("palm_centre", "palm", 0.0, 0.0),
        Switch("palm_centre_lower", "palm", 0.0, -0.030),
        Switch("palm_thumb_upper", "palm", -0.015, 0.014),
        Switch("palm_thumb_lower", "palm", -0.015, -0.014),
    ),
)
