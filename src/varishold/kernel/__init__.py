"""The arithmetic that is written in C (`native/`), and how Python calls it.

`bind` makes a Python function of one in C, `address` tells it where an array's numbers stand, and `work_space` lends
it room. A call lets other threads run.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = ["address", "bind", "sources", "work_space"]

if TYPE_CHECKING:
    from varishold.kernel.library import address, bind, sources
    from varishold.kernel.work import work_space
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
