"""Random contacts: a solid, its pose and its depth, drawn so that the contact has a wanted size.

The same draw serves ideal frames and presses into a skin. How a solid is drawn is said by its own class.
"""

from __future__ import annotations

import numpy as np

from varishold.solids.chance import Chance
from varishold.solids.registry import known_solid
from varishold.solids.solid import Drawn

__all__ = ["draw_contact"]


def draw_contact(
    rng: np.random.Generator,
    name: str,
    *,
    field_m: tuple[float, float],
    size_m: tuple[float, float],
    slope: tuple[float, float] = (0.05, 0.4),
    aspect: tuple[float, float] = (1.4, 2.8),
    top: tuple[float, float] = (0.3, 0.6),
    depth_m: float | None = None,
) -> Drawn:
    """Draw a random contact of the solid called `name`.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of every random choice.
    name : str
        A key of `SOLIDS`.
    field_m : (float, float)
        Height (along y) and width (along x) of the pad, metres. The whole contact lies in it, but for plane,
        edge, wedge and lying cylinder.
    size_m : (float, float)
        Range of the contact's diameter or breadth (the longer one where there are two), metres.
    slope : (float, float)
        Range of depth over contact breadth; drawn evenly on a logarithmic scale.
    aspect : (float, float)
        Range of long over short side of what is longer than broad.
    top : (float, float)
        Range of a frustum's top over its base at the contact line.
    depth_m : float, optional
        Depth to use instead of the one that the slope gives.

    Returns
    -------
    Drawn

    Raises
    ------
    InputError
        If there is no such solid, or its class does not say how it is drawn.
    """
    solid = known_solid(name)
    chance = Chance(
        rng,
        field_m,
        size_m=float(rng.uniform(*size_m)),
        aspect=float(rng.uniform(*aspect)),
        slope=float(np.exp(rng.uniform(*np.log(slope)))),
        top=float(rng.uniform(*top)),
        yaw_rad=float(rng.uniform(-np.pi / 2, np.pi / 2)),
        wanted_depth_m=depth_m,
    )
    return solid.drawn(chance)
