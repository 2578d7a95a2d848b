"""Readings of a pad that is pressed, made by hand: what touches when is known."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from tests.live_scripted import Scripted, wait_until

from varishold.live import PadLayout, Sample
from varishold.live.session import Session
from varishold.perceive import Perceiver
from varishold.solids import Cone, SquarePillar, ideal_frame

FORMS = {
    "cone": 100 * ideal_frame(Cone(8.0, 4.0), (16, 16), 1.0),
    "pillar": 100 * ideal_frame(SquarePillar(7.0, 4.0), (16, 16), 1.0),
}
RATE_HZ = 100.0
LAYOUT = {"pad": PadLayout((16, 16), pitch_m=(0.002, 0.002))}


def pressed(*forms: str, rest: float = 50.0, free: int = 130, held: int = 30, seed: int = 0) -> Iterator[Sample]:
    """Yield readings at 100 a second: a rest before each form and after the last, each form held for so many."""
    noise = np.random.default_rng(seed)
    number = 0
    for form in (*forms, ""):
        for share in [0.0] * free + ([0.3, 0.6, *([1.0] * held), 0.5] if form else []):
            frame = rest + noise.normal(0, 1, (16, 16)) + (share * FORMS[form] if share else 0.0)
            yield Sample(number / RATE_HZ, 1000.0 + number / RATE_HZ, number, {"pad": frame})
            number += 1


class Pressing:
    """A session on presses that are made when they are wanted."""

    def __init__(self, folder: Path | None = None, *, model: Perceiver | None = None) -> None:
        self.source = Scripted()
        self.source.pads = LAYOUT
        self.session = Session(self.source, folder=folder, model=model)
        self._number = 0

    def press(self, *forms: str, seed: int = 0) -> None:
        """Press, and wait until all of it has been seen."""
        for sample in pressed(*forms, free=120 if self._number == 0 else 40, seed=seed):
            number = self._number
            self.source.script.put(sample._replace(device_time_s=number / 100, sequence=number))
            self._number += 1
            # A session that falls behind leaves readings out.
            if number % 20 == 0:
                self._wait(number)
        self._wait(self._number - 1)

    def _wait(self, number: int) -> None:
        wait_until(lambda: self.session.newest is not None and self.session.newest.number >= number)
