"""Recognition by analysis by synthesis, for a skin that is known.

Elsewhere touch looks at what a frame is like; here each form is fitted to it through the skin's own
mechanics, and the one that makes the frame best is the answer. `forms` holds one family of fitted forms a
file, in one registry; a new one is one class with a start and a face.
"""

from __future__ import annotations

from varishold.touch.exact.fit import Fit
from varishold.touch.exact.forms import FITTED
from varishold.touch.exact.recognition import FittedSurface, recognize_exact

__all__ = ["FITTED", "Fit", "FittedSurface", "recognize_exact"]
