"""Perceive: size from the grip, and the object from a sequence of touches.

A `Perceiver` takes `Evidence`, touch by touch, from any hand: how sections fit the grip (`grip_values` of
`GripContacts`), switches (`switch_values`), the surface under each pad (`pad_values`), or any other named numbers;
`evidence_of_row` and `evidence_of_recording` take them from grasp rows and pad recordings; and what another recognizer
says of the name (`NameEvidence`). It holds a `Belief` over
the objects of a `Library` and their sizes, says why, says what to touch next, and stops when it is sure.
`Library.from_examples` makes a library; `Library.with_object` adds an object to one.

No simulator is needed here, and none is imported.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "GRIP_SECTIONS",
    "NONE_OF_THESE",
    "Belief",
    "BeliefUpdate",
    "Evidence",
    "GripContacts",
    "GripSize",
    "ImplicitSurface",
    "Library",
    "Metric",
    "NameEvidence",
    "NextTouch",
    "Perceiver",
    "Perception",
    "Section",
    "SectionFit",
    "SizePrior",
    "SourceWeights",
    "SurfaceContacts",
    "SurfaceMesh",
    "TouchModel",
    "choose_weights",
    "evidence_of_recording",
    "evidence_of_row",
    "expected_information",
    "fit_ball_size",
    "fit_section",
    "for_pads",
    "form_values",
    "fuse",
    "grip_reasons",
    "grip_size",
    "grip_values",
    "merge_evidence",
    "pad_values",
    "read_library",
    "read_prior",
    "shipped_library",
    "switch_values",
    "write_library",
    "write_stl",
]

if TYPE_CHECKING:
    from varishold.perceive.belief import Belief
    from varishold.perceive.contour_mesh import SurfaceMesh, write_stl
    from varishold.perceive.evidence import Evidence, form_values, grip_reasons, grip_values, pad_values, switch_values
    from varishold.perceive.grip import (
        GRIP_SECTIONS,
        GripContacts,
        GripSize,
        Section,
        SectionFit,
        fit_ball_size,
        fit_section,
        grip_size,
    )
    from varishold.perceive.implicit_surface import ImplicitSurface
    from varishold.perceive.library import NONE_OF_THESE, Library
    from varishold.perceive.library_file import read_library, shipped_library, write_library
    from varishold.perceive.metric import Metric
    from varishold.perceive.name_evidence import NameEvidence, SizePrior
    from varishold.perceive.next_touch import NextTouch, expected_information
    from varishold.perceive.perceiver import BeliefUpdate, Perceiver, Perception
    from varishold.perceive.poor_pads import for_pads
    from varishold.perceive.prior_file import read_prior
    from varishold.perceive.rows import evidence_of_recording, evidence_of_row, merge_evidence
    from varishold.perceive.surface_points import SurfaceContacts
    from varishold.perceive.touch_model import TouchModel
    from varishold.trust.fusion import SourceWeights, choose_weights, fuse
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
