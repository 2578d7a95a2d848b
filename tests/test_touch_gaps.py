"""Small gaps in a pad: a contact over them has its name, and its measures are those of what is there."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording
from varishold.sensor import Sensor
from varishold.solids import Cone, SquarePillar, draw_contact, ideal_frame
from varishold.touch import find_contacts, recognize, recognize_recording
from varishold.touch.cut import ends_crookedly
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
    field[4, 4] = field[8:10, 8:10] = field[0, 7] = field[12:16, 2:4] = field[5, 11:14] = False
    expected = np.zeros((16, 16), np.bool_)
    expected[4, 4] = expected[8:10, 8:10] = expected[5, 11:14] = True
    assert np.array_equal(small_gaps(field), expected)
    assert not small_gaps(np.ones((8, 8), np.bool_)).any()
    many = np.ones((16, 16), np.bool_)
    many[1:15, 1:15:2] = False
    assert not small_gaps(many).any()
    large = np.ones((16, 16), np.bool_)
    large[3:12, 3:12] = False
    assert not small_gaps(large).any()


@pytest.mark.parametrize("lost", ["field", "valid"])
@pytest.mark.parametrize("broad", [3, 4, 5])
def test_what_lies_in_a_hole_is_not_sure(lost: str, broad: int) -> None:
    for key in ("cone", "sphere", "square-pillar", "cylinder"):
        for seed in range(6):
            frame = frame_of(key, 16, seed)
            row, col = np.argwhere(frame > 0.9).mean(axis=0).round().astype(int) - broad // 2
            there = np.ones(frame.shape, np.bool_)
            there[row : row + broad, col : col + broad] = False
            surface = recognize(find_contacts(frame, **{lost: there})[0])
            assert surface.name == KINDS[key] or surface.probability <= 0.9, (key, seed)


def test_a_hole_in_a_broad_top_takes_nothing() -> None:
    frame = ideal_frame(SquarePillar(0.02, 0.002), (32, 32), 0.001)
    frame += np.random.default_rng(0).normal(0, 0.01 * frame.max(), frame.shape)
    there = np.ones(frame.shape, np.bool_)
    there[15:18, 15:18] = False
    surface = recognize(find_contacts(frame, valid=there)[0])
    assert surface.name == "square pillar"
    assert surface.probability > 0.9
    cone = ideal_frame(Cone(0.02, 0.006), (32, 32), 0.001)
    doubtful = recognize(find_contacts(cone, valid=there)[0])
    assert doubtful.probability < 0.6
    assert any("fills the hole" in reason for reason in doubtful.reasons)


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


def test_a_few_taxels_on_no_grid_name_no_form_surely() -> None:
    rng = np.random.default_rng(0)
    for seed in range(8):
        positions = np.random.default_rng(seed).uniform(-0.015, 0.015, (40, 2))
        height = np.maximum(0.01 - np.hypot(*positions.T), 0.0) + rng.normal(0, 1e-4, 40)
        for contact in find_contacts(height, sensor=Sensor(positions_m=positions)):
            surface = recognize(contact)
            assert surface.name == "unknown" or surface.probability <= 0.75
            assert any("on no grid" in reason for reason in surface.reasons)


def test_what_the_border_of_a_round_pad_makes_of_a_form_is_not_sure() -> None:
    """A face that ends at a border that is not straight has its outline from there; at a straight one it is known."""
    side = 16
    row, col = np.indices((side, side)) - (side - 1) / 2
    pads = {"round": np.hypot(row, col) < 8.3, "oblong": np.abs(row) < 6}
    for name, field in pads.items():
        for seed in range(40):
            rng = np.random.default_rng(seed)
            turn, off = rng.uniform(0, 2 * np.pi), rng.uniform(-3, 3)
            face = np.clip(col * np.cos(turn) + row * np.sin(turn) - off, 0.0, 1.0)
            frame = face + rng.normal(0, 0.01, face.shape)
            contact = find_contacts(np.where(field, frame, np.nan), pitch=2e-3)[0]
            surface = recognize(contact)
            crooked = any("not straight" in reason for reason in surface.reasons)
            assert crooked == ends_crookedly(contact) == (name == "round"), seed
            assert surface.probability < 0.551 if crooked else surface.name == "edge", (seed, surface)
    # What keeps off the border, and what presses all of the pad, is as sure as elsewhere.
    for key in ("cone", "cylinder"):
        frame = np.where(pads["round"], frame_of(key, side, 1), np.nan)
        contact = find_contacts(frame)[0]
        assert not ends_crookedly(contact)
        assert recognize(contact).probability > 0.9
    all_of_it = np.where(pads["round"], 1.0 + np.random.default_rng(0).normal(0, 0.01, row.shape), np.nan)
    surface = recognize(find_contacts(all_of_it)[0])
    assert surface.name == "plane"
    assert surface.probability > 0.55
