"""The simulated skin: the same seed gives the same bytes, and what it says of itself is so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.live import samples_of, source_at
from varishold.live.simulated_skin import SimulatedSkin, SkinTraits
from varishold.solids import SOLIDS
from varishold.touch import find_contacts, recognize

FORMS = [
    "cylinder",
    "square-pillar",
    "rectangular-pillar",
    "cone-frustum",
    "pyramid-frustum",
    "sphere",
    "cone",
    "pyramid",
    "ridge",
    "hip",
    "lying-cylinder",
    "edge",
]


def _frames(text: str) -> np.ndarray:
    return np.array([sample.pads["pad"] for sample in samples_of(source_at(text))])


@given(seed=st.integers(0, 2**31), form=st.sampled_from(sorted(SOLIDS)))
@settings(max_examples=20)
def test_a_seed_fixes_every_byte(seed: int, form: str) -> None:
    text = f"sim:{form}?seed={seed}&speed=0&duration_s=1&rest_s=0.2&shape=8x12"
    first = list(samples_of(source_at(text)))
    again = list(samples_of(source_at(text)))
    assert len(first) == 100
    for one, other in zip(first, again, strict=True):
        assert (one.sequence, one.device_time_s) == (other.sequence, other.device_time_s)
        assert one.pads["pad"].dtype == np.uint16
        assert one.pads["pad"].shape == (8, 12)
        assert one.pads["pad"].tobytes() == other.pads["pad"].tobytes()


def test_other_seeds_give_other_frames() -> None:
    assert not np.array_equal(_frames("sim:cone?speed=0&duration_s=1"), _frames("sim:cone?speed=0&duration_s=1&seed=1"))


def test_speed_does_not_change_what_is_read() -> None:
    text = "sim:ridge?duration_s=2&seed=3&speed="
    assert np.array_equal(_frames(text + "0"), _frames(text + "50"))


@pytest.mark.parametrize("form", FORMS)
def test_the_form_that_presses_is_recognized(form: str) -> None:
    skin = SimulatedSkin(SkinTraits((form,), drift=0, creep=0, noise=0), rate_hz=100, seed=5)
    right = total = 0
    last = None
    while total < 10:
        held = skin.press.start_s + 0.15 < skin.time_s < skin.press.end_s - 0.15
        frame = skin.next_frame().astype(float) - 200
        if held and skin.press is not last:
            last, total = skin.press, total + 1
            right += recognize(find_contacts(frame, pitch=2e-3)[0]).name == SOLIDS[form].name
    assert right >= 8


def test_a_held_load_creeps_and_warmth_drifts() -> None:
    creeping = _frames("sim:cylinder?speed=0&drift=0&noise=0&hold_s=60&rest_s=1&duration_s=55&rate_hz=20&moves=0")
    total = creeping.astype(float).sum((1, 2)) - 200 * creeping[0].size
    assert total[-1] / total[30] == pytest.approx(1.12, abs=0.01)
    drifting = _frames("sim:cylinder?speed=0&noise=0&creep=0&rest_s=100000&duration_s=1200&rate_hz=1&drift=58")
    assert np.ptp(drifting.astype(float).mean((1, 2))) > 40


def test_a_press_moves_where_it_says() -> None:
    skin = SimulatedSkin(SkinTraits(("sphere",), moves=1.0), rate_hz=100, seed=1)
    press = skin.press
    (x0, y0), (x1, y1) = press.place_at(press.start_s), press.place_at(press.end_s)
    assert (x1 - x0, y1 - y0) == pytest.approx(press.motion_m)
    assert np.hypot(*press.motion_m) >= 2e-3
    assert press.depth_at(press.start_s) == press.depth_at(press.end_s) == 0
    assert press.depth_at(press.start_s + press.hold_s) == pytest.approx(press.drawn.depth_m)


def test_several_pads_are_pressed_apart() -> None:
    source = source_at("sim:all?pads=2&speed=0&duration_s=3")
    assert list(source.pads) == ["pad1", "pad2"]
    assert source.pads["pad1"].pitch_m == (2e-3, 2e-3)
    last = list(samples_of(source))[-1]
    assert not np.array_equal(last.pads["pad1"], last.pads["pad2"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sim:blob", "no form is called 'blob'; known are all, cylinder"),
        ("sim:sphere?seed=x", "seed must be a number from 0 to"),
        ("sim:sphere?seed=1.5", "seed must be a whole number, got '1.5'"),
        ("sim:sphere?seed=-1", "seed must be a number from 0 to"),
        ("sim:sphere?rate_hz=0", "rate_hz must be a number from 0.1 to"),
        ("sim:sphere?speed=nan", "speed must be a number from 0 to"),
        ("sim:sphere?shape=16", "shape must be rows x columns, as in 16x16, got '16'"),
        ("sim:sphere?shape=2x2", "a simulated skin has 4x4 to 256x256 taxels, got 2x2"),
        ("sim:sphere?colour=red", "sim has no option 'colour'; known are seed, rate_hz"),
        ("sim:sphere?seed=1&seed=2", "an option is given twice"),
        ("sim:sphere?seed", "must be name=value"),
        ("simulated", "is no address of a source; write what it is first"),
        ("smi:sphere", "no source is called 'smi'; known are serial, "),
    ],
)
def test_what_cannot_be_is_told(text: str, words: str) -> None:
    with pytest.raises(InputError) as told:
        source_at(text)
    assert words in str(told.value)
    assert "\n" not in str(told.value)
