"""Readings of a pad that is pressed, made by hand: what touches when is known."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from varishold.live import Sample
from varishold.solids import Cone, SquarePillar, ideal_frame

FORMS = {
    "cone": 100 * ideal_frame(Cone(8.0, 4.0), (16, 16), 1.0),
    "pillar": 100 * ideal_frame(SquarePillar(7.0, 4.0), (16, 16), 1.0),
}
RATE_HZ = 100.0


def pressed(*forms: str, rest: float = 50.0, free: int = 130, held: int = 30, seed: int = 0) -> Iterator[Sample]:
    """Yield readings at 100 a second: a rest before each form and after the last, each form held for so many."""
    noise = np.random.default_rng(seed)
    number = 0
    for form in (*forms, ""):
        for share in [0.0] * free + ([0.3, 0.6, *([1.0] * held), 0.5] if form else []):
            frame = rest + noise.normal(0, 1, (16, 16)) + (share * FORMS[form] if share else 0.0)
            yield Sample(number / RATE_HZ, 1000.0 + number / RATE_HZ, number, {"pad": frame})
            number += 1
