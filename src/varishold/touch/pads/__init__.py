"""A pad of a hand: a small taxel array, and the surface under it: flat, curved, an edge or a point."""

from __future__ import annotations

from varishold.touch.pads.surface import SURFACES, PadSurface, SurfaceName, feel_surface

__all__ = ["SURFACES", "PadSurface", "SurfaceName", "feel_surface"]
