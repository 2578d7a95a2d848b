"""Taxel pads on the phalanges and the palm."""

from __future__ import annotations

from dataclasses import dataclass

from varishold.hand.bench import Bench

__all__ = ["PadFrames", "press_pads"]


@dataclass(frozen=True)
class PadFrames:
    """Frames of the pads by name."""


def press_pads(bench: Bench) -> PadFrames:
    """Press the object's surface on each pad that it touches."""
    raise NotImplementedError
