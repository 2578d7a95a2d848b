"""Contacts are the same however the frame is turned, also where three pieces meet at one taxel."""

from __future__ import annotations

import numpy as np
import pytest

from hostile.sections import random_frame
from varishold.levelset import find_contacts


@pytest.mark.parametrize("number", [*range(30), 674, 795, 3588])
def test_a_frame_that_is_turned_or_mirrored_has_the_same_contacts(number: int) -> None:
    case = random_frame(np.random.default_rng((0, number)))

    def contacts(frame: np.ndarray) -> list[tuple[float, float, int]]:
        return sorted((c.peak, c.floor, c.n_taxels) for c in find_contacts(frame, case.levels, floor=case.floor))

    straight = contacts(case.frame)
    for turned in (case.frame[::-1], case.frame[:, ::-1], case.frame.T, np.rot90(case.frame)):
        assert contacts(np.ascontiguousarray(turned)) == straight
