"""Small gaps in a pad: a contact over them has its name, and its measures are those of what is there."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording
from varishold.sensor import Sensor
from varishold.solids import draw_contact, ideal_frame
from varishold.touch import find_contacts, recognize, recognize_recording
from varishold.touch.scale import bridged, small_gaps
from varishold.touch.writers.pad import Export

KINDS = {"cylinder": "cylinder", "square-pillar": "square pillar", "cone": "cone", "sphere": "sphere"}


def frame_of(key: str, side: int, seed: int) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    drawn = draw_contact(rng, key, field_m=(side, side), size_m=(side / 2, 0.75 * side))
    frame = ideal_frame(drawn.solid, (side, side), 1.0, depth_m=drawn.depth_m, pose=drawn.pose)
    return np.asarray(frame / frame.max() + rng.normal(0, 0.01, frame.shape))


def holes(side: int, seed: int) -> NDArray[np.bool_]:
    field = np.ones((side, side), np.bool_)
    rng = np.random.default_rng(seed)
    for row, col in rng.integers(1, side - 2, (side // 2, 2)):
        field[row, col] = False
    return field


@pytest.mark.parametrize("side", [16, 32])
def test_names_are_those_of_the_pad_without_gaps(side: int) -> None:
    right = []
    for key, name in KINDS.items():
        for seed in range(10):
            field = holes(side, seed)
            frame = np.where(field, frame_of(key, side, seed), np.nan)
            right.append(recognize(find_contacts(frame)[0]).name == name)
            (answer,) = recognize_recording(Recording({"pad": Pad(frame[None], field=field)}), frames="peak")
            right.append(answer.surface.name == name)
    assert np.mean(right) >= 0.95


def test_measures_stay_those_of_what_is_there() -> None:
    field = holes(16, 3)
    frame = frame_of("cylinder", 16, 3)
    contact = find_contacts(np.where(field, frame, np.nan))[0]
    surface = recognize(contact)
    assert surface.contact is contact
    whole = bridged(contact)
    assert whole.profile.area[-1] > contact.profile.area[-1]
    assert whole.peak == contact.peak
    assert whole.floor == contact.floor
    # Without gaps, and beside them, nothing is done.
    assert bridged(find_contacts(frame)[0]) is not contact
    assert all(bridged(one) is one for one in find_contacts(frame))
    corner = np.ones((16, 16), np.bool_)
    corner[:3, :3] = False
    assert all(bridged(one) is one for one in find_contacts(np.where(corner, frame, np.nan)))


def test_only_small_gaps_that_taxels_surround_are_bridged() -> None:
    field = np.ones((16, 16), np.bool_)
    field[4, 4] = field[8:10, 8:10] = field[0, 7] = field[12:15, 2:4] = field[5, 11:14] = False
    expected = np.zeros((16, 16), np.bool_)
    expected[4, 4] = expected[8:10, 8:10] = expected[5, 11:14] = True
    assert np.array_equal(small_gaps(field), expected)
    assert not small_gaps(np.ones((8, 8), np.bool_)).any()
    many = np.ones((16, 16), np.bool_)
    many[1:15:2, 1:15:2] = False
    assert not small_gaps(many).any()


def test_an_export_has_broken_taxels_in_its_small_gaps() -> None:
    field = holes(16, 1)
    sensor = Export(sensor=Sensor(shape=(16, 16), field=field)).sensor
    assert sensor is not None
    assert sensor.field is not None
    assert sensor.field.all()
    assert sensor.broken is not None
    assert np.array_equal(sensor.broken, ~field)
    plain = Sensor(shape=(16, 16))
    assert Export(sensor=plain).sensor is plain
