"""What the taxels tell of the sensor, where the pad cuts a contact, and the answer's coarser levels."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.solids import Cone, Cylinder, Plane, Pose, Sphere, SquarePillar, ideal_frame
from varishold.touch import contact_signature, find_contacts, recognize
from varishold.touch.names import NAMES, OUTLINE_OF, OUTLINES
from varishold.touch.signature import SIGNATURE_GROUPS, SIGNATURE_NAMES
from varishold.touch.state import STATE_GROUPS, STATE_NAMES


def state_of(frame: np.ndarray, **options: object) -> dict[str, float]:
    """Return the state under the frame's largest contact by name."""
    return dict(zip(SIGNATURE_NAMES, contact_signature(find_contacts(frame, **options)[0]).tolist(), strict=True))


def frame_of(solid: object, *, x: float = 0.0, y: float = 0.0, noise: float = 0.0) -> np.ndarray:
    frame = ideal_frame(solid, (32, 32), 1.0, pose=Pose(x, y, 0.3))
    return frame / frame.max() + np.random.default_rng(4).normal(0, noise, (32, 32))


def test_the_state_is_part_of_the_signature() -> None:
    assert SIGNATURE_NAMES[-len(STATE_NAMES) :] == STATE_NAMES
    assert SIGNATURE_GROUPS[-len(STATE_NAMES) :] == STATE_GROUPS
    assert len(set(SIGNATURE_NAMES)) == len(SIGNATURE_NAMES)


@pytest.mark.parametrize("scale", [1e-6, 3.0, 1e9])
def test_the_state_has_no_unit(scale: float) -> None:
    frame = frame_of(Cone(18.0, 6.0), noise=0.01)
    one, other = state_of(frame), state_of(scale * frame)
    for name in STATE_NAMES:
        assert other[name] == pytest.approx(one[name], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("turn", [np.rot90, np.flipud, np.transpose])
def test_turns_and_mirrors_change_no_state(turn) -> None:
    frame = frame_of(SquarePillar(12.0, 3.0), x=3.0, noise=0.01)
    one, other = state_of(frame), state_of(np.ascontiguousarray(turn(frame)))
    for name in STATE_NAMES:
        assert other[name] == pytest.approx(one[name], rel=1e-6, abs=1e-9), name


def test_faults_are_seen_where_they_are() -> None:
    frame = frame_of(Sphere(24.0), noise=0.01)
    clean = state_of(frame)
    rng = np.random.default_rng(1)
    saturated = state_of(np.minimum(frame, 0.6))
    assert saturated["near_top_share"] > clean["near_top_share"] + 0.2
    assert saturated["exact_top_share"] > clean["exact_top_share"] + 2
    assert state_of(np.round(8 * frame) / 8)["equal_share"] > 0.3
    assert state_of(frame * (1 + rng.normal(0, 0.2, frame.shape)))["roughness"] > clean["roughness"] + 1
    frame = frame_of(Cylinder(8.0, 3.0), noise=0.01)
    clean = state_of(frame)
    ghost = frame + 0.1 * (frame.mean(axis=0, keepdims=True) + frame.mean(axis=1, keepdims=True))
    assert state_of(ghost)["ghost"] > clean["ghost"] + 0.005


@pytest.mark.parametrize("side", ["left", "right", "top", "bottom"])
def test_a_circle_that_the_pad_cuts_is_completed(side: str) -> None:
    x, y = {"left": (-14.0, 0.0), "right": (14.0, 0.0), "top": (0.0, -14.0), "bottom": (0.0, 14.0)}[side]
    frame = ideal_frame(Cylinder(14.0, 3.0), (32, 32), 1.0, pose=Pose(x, y))
    surface = recognize(find_contacts(frame)[0], among=["cylinder"])
    assert surface.cut == (side,)
    assert surface.size == pytest.approx((14.0, 14.0), rel=0.03)
    assert surface.position == pytest.approx((x, y), abs=0.3)


def test_a_contact_inside_the_field_is_not_cut() -> None:
    for solid in (Cylinder(14.0, 3.0), Cone(18.0, 6.0)):
        assert recognize(find_contacts(frame_of(solid))[0]).cut == ()
    assert set(recognize(find_contacts(frame_of(Plane(1.0)))[0]).cut) == {"left", "right", "top", "bottom"}


def test_outline_and_answer_set_are_made_of_the_names() -> None:
    assert set(OUTLINE_OF) == set(NAMES)
    assert set(OUTLINES) == {"round", "square", "oblong", "edge", "plane", "unknown"}
    for solid in (Cylinder(14.0, 3.0), Cone(18.0, 6.0), SquarePillar(12.0, 3.0)):
        surface = recognize(find_contacts(frame_of(solid, noise=0.03))[0])
        assert sum(surface.outlines.values()) == pytest.approx(1.0)
        assert surface.outline_probability == max(surface.outlines.values())
        held = [surface.names[name] for name in surface.answer_set]
        assert surface.answer_set[0] == surface.name
        assert sum(held[:-1]) < 0.9 <= sum(held)


@pytest.mark.parametrize("far", [Cylinder(9.0, 4.0), SquarePillar(9.0, 4.0), Cone(9.0, 4.0)])
@pytest.mark.parametrize("high", [0.6, 1.0, 1.5])
@pytest.mark.parametrize(
    ("solid", "name"),
    [
        (Cone(9.0, 4.0), "cone"),
        (Sphere(9.0), "sphere"),
        (Cylinder(9.0, 4.0), "cylinder"),
        (SquarePillar(9.0, 4.0), "square pillar"),
    ],
)
def test_what_stands_elsewhere_makes_no_stranger_of_a_contact(
    solid: object, name: str, high: float, far: object
) -> None:
    """Two things may press one pad: each is named as it would be alone."""
    one = frame_of(solid, x=-8.0, noise=0.01)
    both = one + high * frame_of(far, x=8.0)
    for frame in (one, both):
        (contact,) = [each for each in find_contacts(frame) if each.peak_position[0] < 0]
        surface = recognize(contact)
        assert surface.name == name
        assert surface.probability > 0.8
    ours = [state_of(frame) for frame in (one, one + 0.5 * frame_of(far, x=8.0))]
    for number in ("others", "prominence"):
        assert ours[1][number] == pytest.approx(ours[0][number])


def test_what_stands_close_by_is_seen() -> None:
    """Feet that stand together may be those of one stranger."""
    feet = frame_of(Cylinder(12.0, 4.0), x=-6.5) + 0.8 * frame_of(Cylinder(12.0, 4.0), x=6.5)
    assert state_of(feet)["others"] > 0.0


def bar(rng: np.random.Generator, *, most: float = np.inf, noise: float = 0.02, counts: float = 0.0) -> np.ndarray:
    """Return a lying cylinder where readings end at `most`, else a bar with steep sides; of so many counts."""
    y, x = np.mgrid[-8:8, -8:8] + 0.5
    across = np.abs(x - rng.uniform(-1, 1)) / 4.0
    high = np.sqrt(np.maximum(1 - across**2, 0)) if np.isfinite(most) else np.clip(4 * (1.1 - across), 0, 1)
    frame = np.minimum(high * (np.abs(y) < 6.2) + rng.normal(0, noise, (16, 16)), most)
    return np.rint(counts * frame) if counts else frame


def test_a_bar_at_the_end_of_readings_is_not_sure() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        surface = recognize(find_contacts(bar(rng, most=0.7))[0])
        assert surface.name != "rectangular pillar" or surface.probability <= 0.88 + 1e-12
        assert surface.kind_probability.sum() == pytest.approx(1.0)
    # A flat top that noise makes uneven, and quiet counts that show none, are as before.
    for noise, counts in ((0.02, 0.0), (0.001, 100.0)):
        sure = [recognize(find_contacts(bar(rng, noise=noise, counts=counts))[0]) for _ in range(10)]
        assert any(surface.name == "rectangular pillar" and surface.probability > 0.9 for surface in sure)


def test_what_lies_across_a_pad_may_be_longer() -> None:
    rng = np.random.default_rng(1)
    for shape in ((4, 24), (5, 30), (24, 5)):
        _, x = np.mgrid[: min(shape), : max(shape)]
        across = 1.0 * (np.abs(x - 12) < 2.2)
        frame = (across if shape[0] < shape[1] else across.T) + rng.normal(0, 0.02, shape)
        surface = recognize(find_contacts(frame)[0])
        assert surface.name != "square pillar" or surface.probability <= 0.55 + 1e-12
        assert surface.names.get("square pillar", 0.0) + surface.names.get("rectangular pillar", 0.0) > 0.6
    inside = np.zeros((16, 16))
    inside[4:11, 5:12] = 1.0
    assert recognize(find_contacts(inside + rng.normal(0, 0.02, inside.shape))[0]).probability > 0.9
