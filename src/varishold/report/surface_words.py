"""A touched surface in words: what each touch did and told, and what is known at the end."""

from __future__ import annotations

import math

from varishold._counted import counted
from varishold.exploration import SurfaceExploration, SurfaceTouch

__all__ = ["surface_in_words", "surface_touch_in_words"]


def surface_touch_in_words(touch: SurfaceTouch, points: int, sigma_m: float) -> str:
    """Return what a touch for the surface's sake did, how many points it told, and what is unknown after it."""
    side = f"from {math.degrees(touch.turn_rad):.0f}°"
    done = {
        "search": "searched and gripped it",
        "grip": f"gripped it {side}, palm {1e3 * touch.height_m:.0f} mm over its zero".replace("-", "−"),
        "fingertip": f"came down with a fingertip {side}",
    }[touch.kind]
    known = "no surface yet" if math.isnan(sigma_m) else f"known to {1e3 * sigma_m:.1f} mm on the mean"
    return f"{done}: {counted(points, 'point')}; {known}"


def surface_in_words(felt: SurfaceExploration) -> str:
    """Return what is known of a surface after all touches."""
    place, sigma_m = felt.surface.least_known(felt.mesh)
    x, y, z = (1e3 * place).tolist()
    text = (
        f"The surface after {counted(len(felt.touches), 'touch')}: {1e6 * felt.mesh.volume_m3:.0f} cm³ within, "
        f"known to "
        f"{1e3 * felt.history_m[-1]:.1f} mm on the mean, worst to {1e3 * sigma_m:.1f} mm "
        f"at ({x:.0f}, {y:.0f}, {z:.0f}) mm"
    )
    return text.replace("-", "−")
