"""Digits and switches are data: a hand with other ones goes through hand, grasp and perceive like the usual one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.exploration import TOUCHES, Episode, grip_contacts, perceive
from varishold.grasp import HyperplaneClassifier
from varishold.hand import (
    PAPER_22,
    Digit,
    HandDesign,
    HandSetting,
    Layout,
    PadSetting,
    Switch,
    grasp_object,
    grasp_rows,
    grasp_table,
    set_up,
)
from varishold.perceive import Evidence, Library, Perceiver

#: Three fingers of other names, in another order of lengths, and a longer thumb.
DESIGN = HandDesign(
    fingers=(
        Digit("upper", 0.030),
        Digit("central", 0.004, relative_length=1.1),
        Digit("lower", -0.028, relative_length=0.95),
    ),
    thumb=Digit("opposer", 0.0, (0.044, 0.036, 0.030), radius_m=0.010, breadth_m=0.03, opposed=True),
    pointer="upper",
    supporter="lower",
)

#: Eleven switches in no order at all.
LAYOUT = Layout(
    "eleven",
    (
        Switch("p0", "palm", 0.0, 0.02),
        Switch("t2", "opposer.distal"),
        Switch("u2", "upper.distal"),
        Switch("c1", "central.middle"),
        Switch("t1", "opposer.middle"),
        Switch("p1", "palm", 0.014, 0.0),
        Switch("u1", "upper.middle"),
        Switch("l1", "lower.middle"),
        Switch("l2", "lower.distal"),
        Switch("c2", "central.distal"),
        Switch("p2", "palm", -0.014, 0.0),
    ),
)
SETTING = HandSetting(design=DESIGN, layout=LAYOUT)


@pytest.fixture(scope="module")
def table() -> tuple[np.ndarray, np.ndarray]:
    rows = []
    for name in ("cylinder", "square-pillar"):
        for seed in range(4):
            rows += grasp_rows(grasp_object(name, 0.09, seed=seed, setting=SETTING), SETTING)
    made = grasp_table(rows)
    assert {f"switch.{name}" for name in LAYOUT.names} <= set(made.columns)
    assert {f"angle_rad.{joint}" for joint in DESIGN.joints} <= set(made.columns)
    return np.column_stack([made.cells[f"switch.{name}"] for name in LAYOUT.names]), made.cells["object"]


def test_it_grasps_and_its_switches_teach_a_circuit(table: tuple[np.ndarray, np.ndarray]) -> None:
    switches, names = table
    assert switches.shape == (8, 11)
    assert switches.any(axis=1).all()
    fitted = HyperplaneClassifier("robust").fit(switches, names)
    assert set(fitted.predict(switches)) <= {"cylinder", "square-pillar"}


def test_it_touches_and_the_perceiver_names_the_object() -> None:
    setting = replace(SETTING, pads=PadSetting(), search=True)
    rng = np.random.default_rng(0)
    examples: dict[str, list[list[Evidence]]] = {}
    for name in ("cylinder", "square-pillar"):
        episode = Episode(*set_up(name, 0.08, seed=3, setting=setting), setting)
        felt = episode.touch(TOUCHES["squeeze"])
        assert felt is not None
        contacts = grip_contacts(felt.step.sensed, DESIGN, LAYOUT)
        assert set(contacts.parts) == {*DESIGN.joints, "palm.p0", "palm.p1", "palm.p2"}
        evidence, surfaces = felt.touch.evidence(felt, setting)
        assert set(surfaces) == set(DESIGN.parts)
        assert {f"switch.{name}" for name in LAYOUT.names} <= set(evidence.values)
        noisy = ({k: v + 0.02 * rng.normal() for k, v in evidence.values.items()} for _ in range(5))
        examples[name] = [[Evidence("squeeze", values)] for values in noisy]
    perceiver = Perceiver(Library.from_examples(examples), refuse=False, most_touches=1)
    done = perceive("square-pillar", 0.08, seed=3, perceiver=perceiver, setting=setting, order=("squeeze",))
    assert done.perception is not None
    assert done.perception.object == "square-pillar"


def test_its_fingertip_is_the_pointing_fingers() -> None:
    setting = replace(SETTING, layout=LAYOUT)
    bench, _ = set_up("cylinder", 0.09, seed=1, setting=setting)
    felt = TOUCHES["fingertip-middle"].make(bench, Episode(bench, np.random.default_rng(), setting).pose, setting)
    assert felt is not None
    assert felt.height_m == pytest.approx(bench.table_m + bench.solid.top_m, abs=0.006)


def test_the_usual_hand_feels_the_same_with_its_switches_in_another_order() -> None:
    shuffled = Layout("shuffled", tuple(PAPER_22.switches[k] for k in np.random.default_rng(1).permutation(22)))
    still = [HandSetting(layout=layout, still=True) for layout in (PAPER_22, shuffled)]
    usual, other = (grasp_object("cylinder", 0.09, seed=4, setting=setting).end.sensed for setting in still)
    named = [
        dict(zip(layout.names, sensed.switches.tolist(), strict=True))
        for layout, sensed in ((PAPER_22, usual), (shuffled, other))
    ]
    assert named[0] == named[1]
    # The palm's buttons stand in another order in the model, so that contacts are summed in another order.
    assert np.allclose(usual.angles_rad, other.angles_rad, atol=0.01)


def test_a_hand_says_which_digits_it_lacks() -> None:
    with pytest.raises(InputError, match="pointer and supporter must be among the fingers upper, central, lower"):
        replace(DESIGN, pointer="index")
    with pytest.raises(InputError, match="digits of a hand need names of their own"):
        replace(DESIGN, thumb=Digit("upper", 0.0, opposed=True))
    with pytest.raises(InputError, match="a digit needs 3 phalanges and a radius, positive and finite"):
        Digit("short", 0.0, (0.03, 0.0, 0.02))
