"""What a surface can be called: one table from (form, section, exponent) to names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["FORMS", "KINDS", "NAMES", "OUTLINES", "OUTLINE_OF", "SECTIONS", "Form", "Kind", "Outline", "Section"]

Form = Literal["pillar", "frustum", "pyramidal", "spherical", "ridge", "edge", "plane", "unknown"]
Section = Literal["circle", "ellipse", "square", "rectangle", "triangle", "hexagon", "segment", "field", "unknown"]
Outline = Literal["round", "square", "oblong", "edge", "plane", "unknown"]


@dataclass(frozen=True)
class Kind:
    """One kind of surface that recognition weighs.

    Parameters
    ----------
    key : str
        Its own name in the table of parameters.
    form : Form
        The paper's group (eq. [9]-[13]), with edge and unknown.
    section : Section
        Outline of its sections.
    exponent : float or None
        Apex exponent k of A ~ (theta_1 - theta)^k on a height map; None where it has none.
    name : str
        What a person calls it. Several kinds may share a name.
    """

    key: str
    form: Form
    section: Section
    exponent: float | None
    name: str


#: Every kind, in the order of the shipped parameters' outputs.
KINDS: tuple[Kind, ...] = (
    Kind("cylinder", "pillar", "circle", 0.0, "cylinder"),
    Kind("square-pillar", "pillar", "square", 0.0, "square pillar"),
    Kind("rectangular-pillar", "pillar", "rectangle", 0.0, "rectangular pillar"),
    Kind("cone-frustum", "frustum", "circle", None, "frustum of a cone"),
    Kind("pyramid-frustum", "frustum", "square", None, "frustum of a pyramid"),
    Kind("sphere", "spherical", "circle", 1.0, "sphere"),
    Kind("cone", "pyramidal", "circle", 2.0, "cone"),
    Kind("pyramid", "pyramidal", "square", 2.0, "pyramid"),
    Kind("ridge", "ridge", "rectangle", 1.0, "ridge"),
    Kind("hip", "ridge", "rectangle", 1.3, "hip"),
    Kind("lying-cylinder", "ridge", "rectangle", 0.5, "lying cylinder"),
    Kind("edge", "edge", "field", 0.0, "edge"),
    Kind("wedge", "edge", "segment", 1.0, "edge"),
    Kind("plane", "plane", "field", 0.0, "plane"),
    Kind("triangular-pillar", "pillar", "triangle", 0.0, "unknown"),
    Kind("hexagonal-pillar", "pillar", "hexagon", 0.0, "unknown"),
    Kind("elliptic-pillar", "pillar", "ellipse", 0.0, "unknown"),
    Kind("stranger", "unknown", "unknown", None, "unknown"),
)

#: Every name that a surface can get.
NAMES: tuple[str, ...] = tuple(dict.fromkeys(kind.name for kind in KINDS))
#: How sections grow: what the names of one form have in common.
FORMS: tuple[str, ...] = tuple(dict.fromkeys(kind.form for kind in KINDS))
#: What the outlines of sections can be.
SECTIONS: tuple[str, ...] = (*dict.fromkeys(kind.section for kind in KINDS),)

#: The outline that each name has: what is left to tell where taxels cannot tell the profile.
OUTLINE_OF: dict[str, Outline] = {
    "cylinder": "round",
    "square pillar": "square",
    "rectangular pillar": "oblong",
    "frustum of a cone": "round",
    "frustum of a pyramid": "square",
    "sphere": "round",
    "cone": "round",
    "pyramid": "square",
    "ridge": "oblong",
    "hip": "oblong",
    "lying cylinder": "oblong",
    "edge": "edge",
    "plane": "plane",
    "unknown": "unknown",
}
OUTLINES: tuple[Outline, ...] = tuple(dict.fromkeys(OUTLINE_OF.values()))
