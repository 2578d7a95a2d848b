"""Recognition while the threshold falls."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.levelset import even
from varishold.solids import Cone, Cylinder, PyramidFrustum, Solid, Sphere, ideal_frame
from varishold.touch import find_contacts, next_threshold, recognize, recognize_falling


@pytest.mark.parametrize("solid", [Cylinder(14.0, 4.0), Sphere(40.0), Cone(20.0, 4.0), PyramidFrustum(20.0, 9.0, 4.0)])
def test_an_early_answer_exists_and_the_last_one_is_right(solid: Solid) -> None:
    frame = ideal_frame(solid, (32, 32), 1.0, depth_m=4.0)
    frame += np.random.default_rng(0).normal(0, 0.02, frame.shape)
    answers = list(recognize_falling([frame] * 16, even(frame.max(), 0.2, 16)))
    assert len(answers) == 16
    felt = [answer for answer in answers if answer is not None]
    assert len(felt) >= 12
    assert felt[-1].name == solid.name
    assert felt[-1].probability >= felt[0].names[solid.name]


def test_the_top_of_a_frustum_is_first_a_pillar() -> None:
    frame = ideal_frame(PyramidFrustum(24.0, 12.0, 4.0), (32, 32), 1.0)
    frame += np.random.default_rng(0).normal(0, 0.02, frame.shape)
    answers = list(recognize_falling([frame] * 16, even(frame.max(), 0.2, 16)))
    first = next(answer for answer in answers if answer is not None)
    assert first.names["square pillar"] > answers[-1].names["square pillar"]


def test_it_ends_with_the_shorter_of_frames_and_thresholds() -> None:
    frame = ideal_frame(Cylinder(10.0, 1.0), (16, 16), 1.0)
    assert len(list(recognize_falling([frame] * 3, even(1.0, 0.1, 9)))) == 3
    assert len(list(recognize_falling([frame] * 9, even(1.0, 0.1, 3)))) == 3


def test_thresholds_must_fall() -> None:
    with pytest.raises(InputError, match="thresholds must be finite and fall"):
        next(recognize_falling([np.eye(4)], [1.0, 2.0]))


@settings(max_examples=20)
@given(st.lists(st.floats(0.02, 0.98), min_size=1, max_size=12), st.sampled_from([Cone(20.0, 4.0), Sphere(40.0)]))
def test_the_next_threshold_lies_in_a_gap(shares: list[float], solid: Solid) -> None:
    surface = recognize(find_contacts(ideal_frame(solid, (32, 32), 1.0, depth_m=4.0))[0])
    contact = surface.contact
    cuts = [contact.floor + share * (contact.peak - contact.floor) for share in shares]
    chosen = next_threshold(surface, cuts)
    assert contact.floor < chosen < contact.peak
    assert chosen not in cuts
