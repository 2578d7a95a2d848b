"""The hand touches, the perceiver decides: the same seed, odd hands, odd objects, bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.errors import InputError
from varishold.exploration import TOUCHES, Exploration, MadeTouch, perceive
from varishold.hand import OBJECTS, HandDesign, HandSetting, PadSetting
from varishold.hand.pads import PadFrames
from varishold.perceive import NONE_OF_THESE, Belief, NameEvidence, Perceiver, library_file
from varishold.report import render_perceive_report
from varishold.report.senses import senses_in_words

pytestmark = pytest.mark.skipif(
    not library_file._SHIPPED.is_file(), reason="no library of objects is shipped; python -m training.objects makes it"
)
WITH_PADS, WITHOUT = HandSetting(pads=PadSetting()), HandSetting(pads=None)


@pytest.fixture(scope="module")
def sequence() -> Exploration:
    return perceive("cylinder", 0.07, seed=3, setting=WITH_PADS)


def sound(sequence: Exploration) -> None:
    """Check what every sequence must hold."""
    assert sequence.touches
    assert sequence.perception is not None
    assert sequence.perception.object in (*OBJECTS, NONE_OF_THESE)
    assert sequence.perception.trace == tuple(touch.update for touch in sequence.touches)
    for touch in sequence.touches:
        assert touch.evidence.touch == touch.felt.touch.name
        assert sum(touch.update.probability.values()) == pytest.approx(1)
        assert np.isfinite(list(touch.update.probability.values())).all()
    assert sequence.touches[-1].then is None


def test_a_sequence_ends_with_an_answer(sequence: Exploration) -> None:
    sound(sequence)
    assert (sequence.name, sequence.size_m, sequence.seed) == ("cylinder", 0.07, 3)
    assert sequence.touches[0].chosen_for is None
    made = [touch.felt.touch.name for touch in sequence.touches]
    assert len(set(made)) == len(made)
    assert sequence.perception is not None
    assert not sequence.perception.remarks


def test_the_same_seed_is_the_same_sequence_bit_by_bit(sequence: Exploration) -> None:
    seen: list[MadeTouch] = []
    again = perceive("cylinder", 0.07, seed=3, setting=WITH_PADS, on_touch=seen.append)
    assert again.perception == sequence.perception
    assert tuple(seen) == again.touches
    for one, other in zip(sequence.touches, again.touches, strict=True):
        assert other.evidence == one.evidence or repr(other.evidence) == repr(one.evidence)
        assert np.array_equal(other.felt.step.sensed.angles_rad, one.felt.step.sensed.angles_rad)
    assert perceive("cylinder", 0.07, seed=4, setting=WITHOUT).touches[0].evidence != sequence.touches[0].evidence


def test_a_perceiver_that_has_felt_begins_anew(sequence: Exploration) -> None:
    used = Perceiver()
    used.feel(sequence.touches[0].evidence)
    again = perceive("cylinder", 0.07, seed=3, setting=WITH_PADS, perceiver=used)
    assert again.perception == sequence.perception


@pytest.mark.parametrize("name", ["cylinder", "square-pillar"])
def test_a_hand_without_pads_answers(name: str) -> None:
    done = perceive(name, 0.07, seed=3, setting=WITHOUT)
    sound(done)
    assert done.perception is not None
    assert not done.touches[0].surfaces
    assert not any(value.startswith("pad.") for touch in done.touches for value in touch.evidence.values)


def test_a_hand_without_pads_says_so() -> None:
    done = perceive("cylinder", 0.07, seed=3, setting=WITHOUT)
    assert done.perception is not None
    assert any("pads" in remark for remark in done.perception.remarks)


def test_a_hand_without_pads_does_not_refuse_a_cylinder() -> None:
    for seed in (3, 4):
        done = perceive("cylinder", 0.07, seed=seed, setting=WITHOUT)
        assert done.perception is not None
        assert done.perception.object == "cylinder"


@pytest.mark.parametrize("name", ["torus", "l-block"])
def test_things_that_are_in_no_library_are_touched_all_the_same(name: str) -> None:
    sound(perceive(name, 0.08, seed=3, setting=WITH_PADS))


@pytest.mark.parametrize("finger_scale", [0.9, 1.2])
def test_other_hands_answer_too(finger_scale: float) -> None:
    sound(perceive("cylinder", 0.07, seed=3, setting=replace(WITH_PADS, design=HandDesign(finger_scale=finger_scale))))


def test_an_order_is_kept() -> None:
    order = ("grasp", "fingertip-middle", "regrasp-turned-45")
    unsure = Perceiver(error=1e-12, least_touches=3, most_touches=3)
    done = perceive("square-pillar", 0.08, seed=5, setting=WITHOUT, order=order, perceiver=unsure)
    sound(done)
    made = [touch.felt.touch.name for touch in done.touches]
    assert [name for name in made if name != "squeeze"] == [name for name in order if name in made]
    assert all(touch.chosen_for is None for touch in done.touches)


def test_a_dead_pad_says_nothing_and_is_remarked(sequence: Exploration) -> None:
    felt = sequence.touches[0].felt
    pads = felt.step.pads
    assert pads is not None
    for broken in ("thumb.distal", "palm"):
        frames = {name: np.full_like(f, np.nan) if name == broken else f for name, f in pads.frames.items()}
        evidence, surfaces = felt.touch.evidence(
            replace(felt, step=replace(felt.step, pads=PadFrames(frames, pads.pitch_m, pads.force_n))), WITH_PADS
        )
        assert broken not in surfaces
        assert not any(name.startswith(f"pad.{broken}.") for name in evidence.values)
        assert any(broken in remark for remark in evidence.remarks)
        update = Perceiver().feel(evidence)
        assert sum(update.probability.values()) == pytest.approx(1)


def test_the_hand_can_make_every_touch_of_the_shipped_library() -> None:
    assert set(Perceiver().library.touches) <= set(TOUCHES)
    assert set(Perceiver().library.objects) == set(OBJECTS)


@pytest.mark.parametrize(
    ("name", "size_m", "options", "message"),
    [
        ("cylinder", 0.07, {"order": ("grasp", "poke")}, "unknown touch 'poke'; known are grasp, squeeze"),
        ("cupid", 0.07, {}, "unknown object 'cupid'"),
        ("cylinder", 0.7, {}, "size of the cylinder must lie in"),
        ("cylinder", 0.07, {"seed": -3}, "seed must be a whole number from 0 on, got -3"),
    ],
)
def test_bad_requests_are_refused_in_one_line(name: str, size_m: float, options: dict, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        perceive(name, size_m, setting=WITHOUT, **({"seed": 1} | options))
    assert "\n" not in str(refused.value)


def test_what_each_sense_says_is_told_where_something_was_said_before() -> None:
    setting = HandSetting(pads=PadSetting())
    order = ("grasp", "fingertip-middle")
    said = {"cone": 0.6, "pyramid": 0.3, "sphere": 0.1}

    def made(prior: NameEvidence | None) -> Exploration:
        perceiver = Perceiver(error=1e-12, least_touches=2, prior=prior)
        return perceive("cone", 0.08, seed=2, perceiver=perceiver, setting=setting, order=order)

    blind, seen = made(None), made(NameEvidence("camera", said))
    assert blind.senses == ()
    (who, first), (touch, alone), (both, together) = seen.senses
    assert (who, touch, both) == ("camera", "touch", "together")
    assert first == pytest.approx(Perceiver(prior=NameEvidence("camera", said)).belief.probability)
    assert list(first) == list(alone) == list(together)
    assert together == seen.touches[-1].update.probability
    # Touch says without the camera what it says where there is none.
    belief = Belief.before(Perceiver().library)
    for made_touch in blind.touches:
        belief = belief.after(made_touch.evidence)
    assert alone == pytest.approx(belief.probability, rel=1e-6, abs=1e-9)
    before, touched = senses_in_words(seen)
    assert before.startswith("camera alone: cone 0.")
    assert touched.startswith("touch alone: ")
    assert senses_in_words(blind) == ()
    page = render_perceive_report(seen, setting=setting)
    assert "What each sense says" in page
    assert "Camera alone" in page
    assert "What each sense says" not in render_perceive_report(blind, setting=setting)
