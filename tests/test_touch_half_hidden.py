"""What a border may hide half of is not surely named."""

from __future__ import annotations

import numpy as np
import pytest

from varishold import find_contacts, recognize
from varishold.solids import Cylinder, Pose, SquarePillar, ideal_frame
from varishold.touch.cut import cut_sides, half_hidden

SIDE, BREADTH = 32, 14.0
HIDES = "the border of the pad may hide half of it or more: how far it goes on beyond is not seen"


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("solid", [SquarePillar(BREADTH, 4.0), Cylinder(BREADTH, 4.0)])
def test_of_what_is_less_than_half_seen_no_name_is_sure(solid: SquarePillar | Cylinder, turns: int) -> None:
    rng = np.random.default_rng(turns)
    for seen in (0.25, 0.35, 0.7, 0.9):
        # So much of its width stands on the pad.
        x = SIDE / 2 + BREADTH / 2 - seen * BREADTH
        frame = ideal_frame(solid, (SIDE, SIDE), 1.0, pose=Pose(x, rng.uniform(-5, 5)))
        contact = find_contacts(np.rot90(frame + rng.normal(0, 0.02, frame.shape), turns))[0]
        surface = recognize(contact)
        assert len(cut_sides(contact)) == 1
        assert contact.at_border
        hidden = half_hidden(contact)
        assert hidden == (seen < 0.5)
        assert (HIDES in surface.reasons) == hidden
        if hidden:
            assert surface.name == "unknown" or surface.probability <= 0.85 + 1e-9
            assert surface.answer_set[0] == surface.name
        else:
            assert surface.name == ("square pillar" if isinstance(solid, SquarePillar) else "cylinder")


def test_the_pitch_counts() -> None:
    frame = np.zeros((16, 16))
    frame[4:12, :5] = 1.0
    frame += np.random.default_rng(0).normal(0, 0.02, frame.shape)
    assert not half_hidden(find_contacts(frame)[0])
    assert half_hidden(find_contacts(frame, pitch=(1.0, 0.6))[0])
    # Nobody knows how far it goes on at a corner, or from border to border.
    frame[12:] = frame[11]
    assert not half_hidden(find_contacts(frame, pitch=(1.0, 0.6))[0])


def test_what_reaches_a_border_is_told_as_which_it_reaches() -> None:
    rng = np.random.default_rng(3)
    for _ in range(30):
        y, x = np.indices((12, 17)) - rng.uniform(0, 11, (2, 1, 1))
        frame = np.maximum(rng.uniform(2, 5) - np.hypot(y, x), 0.0) + rng.normal(0, 0.02, (12, 17))
        for contact in find_contacts(frame):
            assert contact.at_border == any(contact.borders)
