"""The elastic media, one file each; `MEDIA` is their registry by the `kind` of a skin."""

from __future__ import annotations

from collections.abc import Callable

from varishold.sensor.cover import Skin
from varishold.skin.media.half_space import HalfSpace
from varishold.skin.media.layer import Layer
from varishold.skin.media.medium import MOST_CELLS, Cells, Medium, cell_symbol, wave_numbers
from varishold.skin.media.winkler import Winkler

__all__ = [
    "MEDIA",
    "MOST_CELLS",
    "Cells",
    "HalfSpace",
    "Layer",
    "Medium",
    "Winkler",
    "cell_symbol",
    "medium_of",
    "wave_numbers",
]

#: What makes the medium of each kind of skin.
MEDIA: dict[str, Callable[[Skin], Medium]] = {
    "layer": lambda skin: Layer(skin.thickness_m or 0.0, skin.poisson),
    "half-space": lambda skin: HalfSpace(),
    "winkler": lambda skin: Winkler(skin.thickness_m or 0.0, skin.poisson),
}


def medium_of(skin: Skin) -> Medium:
    """Return the elastic medium of a skin."""
    return MEDIA[skin.kind](skin)
