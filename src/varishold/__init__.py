"""Tactile pattern recognition by a variable threshold.

Touch: a pressure array's frame is cut by a falling threshold, and the way its sections nest and grow
tells the form of the surface. Grasp: the on-off switches of a hand give binary patterns, which
hyperplanes and a small logic circuit tell apart. The names below are those that most users need; every room
(`varishold.touch`, `varishold.grasp` ...) has more. Importing this package loads numpy and nothing heavier; each
room is loaded when it is first used.

References
----------
G. Kinoshita, S. Aida and M. Mori, "Pattern recognition by an artificial tactile sense", 1971.
"""

from __future__ import annotations

from varishold._lazy import TYPE_CHECKING, lazy_names
from varishold.errors import (
    FormatError,
    InputError,
    MissingExtraError,
    MissingKernelError,
    NotConvergedError,
    VarisholdError,
)

__version__ = "0.1.0"

__all__ = [
    "FormatError",
    "HyperplaneClassifier",
    "InputError",
    "MissingExtraError",
    "MissingKernelError",
    "NotConvergedError",
    "Pad",
    "Perceiver",
    "Recording",
    "Skin",
    "Surface",
    "SurfaceFeatures",
    "TactileClassifier",
    "ThresholdEncoder",
    "VarisholdError",
    "evaluate",
    "find_contacts",
    "open",
    "read",
    "recognize",
    "recognize_recording",
    "write",
]

if TYPE_CHECKING:
    from varishold import calibration as calibration
    from varishold import circuit as circuit
    from varishold import corpus as corpus
    from varishold import evaluation as evaluation
    from varishold import exploration as exploration
    from varishold import files as files
    from varishold import frame as frame
    from varishold import grasp as grasp
    from varishold import hand as hand
    from varishold import kernel as kernel
    from varishold import learning as learning
    from varishold import levelset as levelset
    from varishold import live as live
    from varishold import paper as paper
    from varishold import perceive as perceive
    from varishold import recording as recording
    from varishold import report as report
    from varishold import sensor as sensor
    from varishold import skin as skin
    from varishold import solids as solids
    from varishold import touch as touch
    from varishold import trust as trust
    from varishold.evaluation import evaluate
    from varishold.grasp import HyperplaneClassifier, ThresholdEncoder
    from varishold.learning import TactileClassifier
    from varishold.perceive import Perceiver
    from varishold.recording import Pad, Recording, open, read, write
    from varishold.skin import Skin
    from varishold.touch import Surface, SurfaceFeatures, find_contacts, recognize, recognize_recording
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
