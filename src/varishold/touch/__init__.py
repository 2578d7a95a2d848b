"""Touch: from a frame to contacts, from a contact's sections to the name of its surface.

`find_contacts` cuts a frame by a falling threshold, `recognize` says what each contact is, and
`recognize_recording` does both for a whole recording. `ContactTracker` follows contacts through time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "FORMS",
    "KINDS",
    "NAMES",
    "SECTIONS",
    "SIGNATURE_GROUPS",
    "SIGNATURE_NAMES",
    "SURFACES",
    "Answer",
    "Contact",
    "ContactPose",
    "ContactState",
    "ContactTracker",
    "Event",
    "LoadingFeatures",
    "PadSurface",
    "Surface",
    "SurfaceFeatures",
    "Track",
    "contact_pose",
    "contact_signature",
    "feel_surface",
    "find_contacts",
    "find_contacts_batch",
    "inequality",
    "loading_features",
    "next_threshold",
    "recognize",
    "recognize_exact",
    "recognize_falling",
    "recognize_recording",
]

if TYPE_CHECKING:
    from varishold.levelset.contact import Contact
    from varishold.levelset.contact_state import ContactState
    from varishold.touch.answer import Answer
    from varishold.touch.chords import inequality
    from varishold.touch.course import loading_features
    from varishold.touch.course.features import LoadingFeatures
    from varishold.touch.exact import recognize_exact
    from varishold.touch.falling import recognize_falling
    from varishold.touch.features import SurfaceFeatures
    from varishold.touch.names import FORMS, KINDS, NAMES, SECTIONS
    from varishold.touch.pads import SURFACES, PadSurface, feel_surface
    from varishold.touch.pose import ContactPose, contact_pose
    from varishold.touch.recognizer import contact_signature, recognize
    from varishold.touch.recordings import recognize_recording
    from varishold.touch.scheduling import next_threshold
    from varishold.touch.sensing import find_contacts, find_contacts_batch
    from varishold.touch.signature import SIGNATURE_GROUPS, SIGNATURE_NAMES
    from varishold.touch.surface import Surface
    from varishold.touch.tracking.event import Event
    from varishold.touch.tracking.track import Track
    from varishold.touch.tracking.tracker import ContactTracker
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
