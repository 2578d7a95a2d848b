"""The switch tables: which on-off switches a hand has and where; one file a layout.

`LAYOUTS` is the registry, by the name that commands use.
"""

from __future__ import annotations

from varishold.hand.layouts.paper_22 import PAPER_22
from varishold.hand.layouts.switch import Layout, Switch

__all__ = ["LAYOUTS", "PAPER_22", "Layout", "Switch"]

#: Layouts of switches by their names.
LAYOUTS: dict[str, Layout] = {PAPER_22.name: PAPER_22}
