"""Domain randomization: what differs from one grasp to the next, as one documented setting."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from varishold.errors import InputError

__all__ = ["Circumstances", "Randomization"]


@dataclass(frozen=True)
class Circumstances:
    """One draw of what differs from grasp to grasp.

    Parameters
    ----------
    friction, torque, density, softness, threshold : float
        Factors on the hand's friction, its torques, the object's usual density, the contacts' time constant and
        the switches' common threshold.
    switch_spread : tuple of floats
        A further factor on each single switch's threshold, in the layout's order.
    forward_m, sideways_m, yaw_rad : float
        The object's place: its gap from where the palm's approach ends, its offset toward the fingers' side, and
        its turn.
    """

    friction: float
    torque: float
    density: float
    softness: float
    threshold: float
    switch_spread: tuple[float, ...]
    forward_m: float
    sideways_m: float
    yaw_rad: float


@dataclass(frozen=True)
class Randomization:
    """Ranges from which each grasp's circumstances are drawn, independently and evenly (factors: in logarithm).

    Parameters
    ----------
    friction, torque, density, softness, threshold : float
        A factor lies between 1 / value and value; 1 means that nothing varies.
    switch_spread : float
        The same for each single switch.
    forward_m, sideways_m, yaw_rad : float
        Largest offset to either side from the given place when the place is known (no search).
    search_m, search_rad : float
        Largest offset along x and along y, and turn, when the hand must search.

    Examples
    --------
    >>> a, b = (Randomization().draw(np.random.default_rng(7), n_switches=22) for _ in range(2))
    >>> a == b
    True
    """

    friction: float = 1.25
    torque: float = 1.2
    density: float = 1.5
    softness: float = 1.5
    threshold: float = 1.6
    switch_spread: float = 1.25
    forward_m: float = 0.003
    sideways_m: float = 0.005
    yaw_rad: float = float(np.deg2rad(10))
    search_m: float = 0.030
    search_rad: float = float(np.deg2rad(20))

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            factor = not field.name.endswith(("_m", "_rad"))
            if not np.isfinite(value) or value < (1 if factor else 0):
                least = "1" if factor else "0"
                raise InputError(f"{field.name} of a randomization must be at least {least}, got {value!r}")

    def draw(
        self, rng: np.random.Generator, *, n_switches: int, search: bool = False, still: bool = False
    ) -> Circumstances:
        """Draw one grasp's circumstances.

        Parameters
        ----------
        rng : numpy.random.Generator
        n_switches : int
            Number of switches of the layout.
        search : bool
            Whether the place is unknown, so that it varies over the search's range.
        still : bool
            Vary the place alone and leave the physics as designed.
        """

        def factor(largest: float) -> float:
            drawn = float(np.exp(rng.uniform(-1, 1) * np.log(largest)))
            return 1.0 if still else drawn

        friction, torque = factor(self.friction), factor(self.torque)
        density, softness, threshold = factor(self.density), factor(self.softness), factor(self.threshold)
        spread = tuple(factor(self.switch_spread) for _ in range(n_switches))
        forward_m, sideways_m, yaw_rad = self.draw_place(rng, search=search)
        return Circumstances(
            friction=friction,
            torque=torque,
            density=density,
            softness=softness,
            threshold=threshold,
            switch_spread=spread,
            forward_m=forward_m,
            sideways_m=sideways_m,
            yaw_rad=yaw_rad,
        )

    def draw_place(self, rng: np.random.Generator, *, search: bool = False) -> tuple[float, float, float]:
        """Draw forward and sideways offset (metres) and turn (radians) of an object that is set up."""
        forward = self.search_m if search else self.forward_m
        sideways = self.search_m if search else self.sideways_m
        turn = self.search_rad if search else self.yaw_rad
        place = rng.uniform(-1, 1, 3) * (forward, sideways, turn)
        return float(place[0]), float(place[1]), float(place[2])
