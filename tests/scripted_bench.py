"""A bench without physics: it notes what the hand is told; a world of the test's own answers with closed switches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from varishold.hand import PAPER_22, HandDesign
from varishold.hand.bench import Bench, Sensed
from varishold.hand.coordinates import phalanges
from varishold.hand.model import CARRIAGE
from varishold.hand.objects import graspable
from varishold.hand.randomization import Randomization

__all__ = ["ScriptedBench", "angles_at"]

DESIGN = HandDesign()


def angles_at(upper_m: float, lower_m: float) -> np.ndarray:
    """Joint angles at which the index finger's end stands at y = upper and the thumb's at y = lower."""
    angles = np.tile(DESIGN.open_rad, 5)
    for tip, wanted, sign in (("index.distal", upper_m, 1.0), ("thumb.distal", lower_m, -1.0)):
        k = DESIGN.joints.index(tip)
        low, high = -0.65, 1.6
        for _ in range(60):
            angles[k - 2] = (low + high) / 2
            far = sign * phalanges(angles, DESIGN).middle_m[k, 1] > sign * wanted
            low, high = (angles[k - 2], high) if far else (low, angles[k - 2])
    return angles


@dataclass
class ScriptedBench(Bench):
    """Notes every call; `world(bench)` says which switches are closed whenever time has passed."""

    solid: Any = field(default_factory=lambda: graspable("cylinder", 0.08))
    circumstances: Any = field(
        default_factory=lambda: Randomization().draw(np.random.default_rng(0), n_switches=22, still=True)
    )
    world: Callable[[ScriptedBench], tuple[str, ...]] = lambda bench: ()
    angles: np.ndarray = field(default_factory=lambda: np.tile(DESIGN.open_rad, 5))

    def __post_init__(self) -> None:
        self.target = dict.fromkeys(CARRIAGE, 0.0)
        self._parts = np.array([switch.part for switch in PAPER_22.switches])
        self._palm = self._parts == "palm"
        self.closed = np.zeros(22, bool)
        self.seen = np.zeros(22, bool)
        self.log: list[tuple[Any, ...]] = []
        self.closing: dict[str, float] = {}
        self.posed: dict[str, Any] = {}
        self.table_m = -0.085
        self.hangs = True

    def reset(self) -> None:
        self.log.append(("reset",))
        self.target = dict.fromkeys(CARRIAGE, 0.0)

    def place_object(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        self.log.append(("place", x_m, y_m, yaw_rad))

    def put_carriage(self, values: dict[str, float]) -> None:
        self.log.append(("put", dict(values)))
        self.target |= values

    def put_digits(self, *, closed_digits: Any = None, open_digits: Any = (), posed_digits: Any = None) -> None:
        self.log.append(("digits", dict(closed_digits or {}), tuple(open_digits), dict(posed_digits or {})))
        self.closing |= closed_digits or {}
        for digit in open_digits:
            self.closing.pop(digit, None)
        self.posed = dict(posed_digits or {})

    def advance(self, seconds: float, *, carriage: dict[str, float] | None = None) -> None:
        self.log.append(("go", seconds, {name: float(value) for name, value in (carriage or {}).items()}))
        self.target |= carriage or {}
        on = self.world(self)
        self.closed = np.array([name in on for name in PAPER_22.names])
        self.seen |= self.closed

    def sense(self) -> Sensed:
        at = np.array([self.target[name] for name in CARRIAGE])
        return Sensed(self.closed.copy(), self.closed.astype(float), self.angles.copy(), at)

    @property
    def held(self) -> bool:
        return self.hangs

    def moves(self) -> list[tuple[float, dict[str, float]]]:
        """Return what the carriage was told, as (seconds, changes)."""
        return [(entry[1], entry[2]) for entry in self.log if entry[0] == "go"]
