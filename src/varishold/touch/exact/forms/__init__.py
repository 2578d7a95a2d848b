"""The fitted forms, one family a file; `FITTED` is their registry by the key of `varishold.touch.names.KINDS`."""

from __future__ import annotations

from varishold.touch.exact.form import Form
from varishold.touch.exact.forms.crests import Arch, EndlessArch, EndlessGable, Gable, Hipped
from varishold.touch.exact.forms.flat import Border, Disc, Everywhere, Rectangle, Square
from varishold.touch.exact.forms.peaks import Cap, RoundFrustum, RoundTip, SquareFrustum, SquareTip, SteepCap

__all__ = ["FITTED"]

#: Every way to fit a kind; where a kind has several, the better fit counts.
FITTED: dict[str, tuple[Form, ...]] = {
    "cylinder": (Disc(),),
    "square-pillar": (Square(),),
    "rectangular-pillar": (Rectangle(),),
    "cone-frustum": (RoundFrustum(),),
    "pyramid-frustum": (SquareFrustum(),),
    "sphere": (Cap(), SteepCap()),
    "cone": (RoundTip(),),
    "pyramid": (SquareTip(),),
    "ridge": (Gable(),),
    "hip": (Hipped(),),
    "lying-cylinder": (Arch(), EndlessArch()),
    "edge": (Border(),),
    "wedge": (EndlessGable(),),
    "plane": (Everywhere(),),
}
