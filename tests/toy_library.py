"""A library of three objects that two touches tell apart by one number; the other number is noise."""

from __future__ import annotations

from functools import cache

import numpy as np

from varishold.perceive import Evidence, Library

OBJECTS = {"ball": 0.0, "box": 4.0, "cone": 8.0}


def touches(middle: float, rng: np.random.Generator, **more: float) -> list[Evidence]:
    return [
        Evidence(touch, {"form": middle + rng.normal(0, 0.5), "load": rng.normal(0, 1.0), **more})
        for touch in ("grasp", "higher")
    ]


@cache
def library(n: int = 40, others: int = 0) -> Library:
    rng = np.random.default_rng(0)
    return Library.from_examples(
        {name: [touches(middle, rng) for _ in range(n)] for name, middle in OBJECTS.items()},
        others=[touches(rng.uniform(-20, 20), rng) for _ in range(others)],
    )
