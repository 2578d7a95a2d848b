"""Tactile pattern recognition by a variable threshold.

Touch: a pressure array's frame is cut by a falling threshold, and the way its sections nest and grow
tells the form of the surface. Grasp: the on-off switches of a hand give binary patterns, which
hyperplanes and a small logic circuit tell apart. Importing this package loads numpy and nothing heavier;
each subpackage is loaded when it is first used.

References
----------
G. Kinoshita, S. Aida and M. Mori, "Pattern recognition by an artificial tactile sense", 1971.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from varishold.errors import FormatError, InputError, MissingExtraError, NotConvergedError, VarisholdError

if TYPE_CHECKING:
    from varishold.recording import Pad, Recording, open, read, write

__version__ = "0.1.0"

_ROOMS = (
    "calibration",
    "circuit",
    "grasp",
    "hand",
    "levelset",
    "paper",
    "perceive",
    "recording",
    "report",
    "sensor",
    "skin",
    "solids",
    "touch",
)
_FROM_RECORDING = ("Pad", "Recording", "open", "read", "write")

__all__ = [
    "FormatError",
    "InputError",
    "MissingExtraError",
    "NotConvergedError",
    "Pad",
    "Recording",
    "VarisholdError",
    "open",
    "read",
    "write",
]


def __getattr__(name: str) -> Any:
    if name in _FROM_RECORDING:
        return getattr(importlib.import_module("varishold.recording"), name)
    if name in _ROOMS:
        return importlib.import_module(f"varishold.{name}")
    raise AttributeError(f"module 'varishold' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_FROM_RECORDING, *_ROOMS])
