"""Laws of readings below zero that were stored without a sign: they get it back, and nothing else is touched."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.pressed_things import told

from varishold import Pad, Recording, recognize_recording, write
from varishold.frame.running_sign import RunningSign
from varishold.frame.wrapped import wrapped_readings
from varishold.live.pad_watcher import PadWatcher
from varishold.live.sample import PadLayout
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

COURSE = np.r_[np.zeros(20), np.linspace(0.1, 1.0, 8), np.ones(6), np.linspace(0.9, 0.1, 6), np.zeros(20)]
ALL = np.ones((12, 12), np.bool_)
ROW, COL = np.indices(ALL.shape) - 5.5
BALL = np.sqrt(np.maximum(1.0 - (ROW**2 + COL**2) / 16.0, 0.0))
TYPES = {8: np.uint8, 10: np.uint16, 12: np.uint16, 16: np.uint16, 24: np.uint32, 32: np.uint32}


def pressed(seed: int = 0, noise: float = 3.0, peak: float = 120.0) -> NDArray[np.int64]:
    frames = peak * COURSE[:, None, None] * BALL + np.random.default_rng(seed).normal(0.0, noise, (60, 12, 12))
    return np.rint(frames).astype(np.int64)


@pytest.mark.parametrize("bits", TYPES)
@given(seed=st.integers(0, 1000), noise=st.floats(0.7, 5.0))
def test_what_came_round_gets_its_sign_back(bits: int, seed: int, noise: float) -> None:
    signed = pressed(seed, noise)
    stored = (signed % 2**bits).astype(TYPES[bits])
    for given_as in (stored, stored.astype(np.float64)):
        found = wrapped_readings(given_as, ALL)
        assert found is not None
        assert found.bits == bits
        assert found.below == np.count_nonzero(signed < 0)
        assert np.array_equal(found.mended(0, 60), signed)


@pytest.mark.parametrize("peak", [200.0, 4095.0, 9000.0])
@pytest.mark.parametrize("bits", [8, 12, 16])
@pytest.mark.parametrize("noise", [0.0, 2.0])
def test_what_is_pressed_saturated_or_on_and_off_stays(peak: float, bits: int, noise: float) -> None:
    top = 2**bits - 1
    for seed in range(4):
        analog = pressed(seed, noise, peak)
        flickers = analog + np.random.default_rng(seed).normal(0.0, 0.3 * peak, analog.shape)
        for readings in (np.clip(analog, 0, top), top * (analog > peak / 2), top * (flickers > peak / 2)):
            assert wrapped_readings(readings.astype(TYPES[bits]), ALL) is None
    assert wrapped_readings(pressed(), ALL) is None
    assert wrapped_readings(pressed()[:3].astype(np.uint16), ALL) is None
    assert wrapped_readings(np.full((20, 12, 12), 2**40, dtype=np.int64), ALL) is None


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32, np.float32])
def test_a_press_is_named_as_if_it_had_been_stored_with_signs(kind: type) -> None:
    stored = (pressed() % (256 if kind is np.uint8 else 65536)).astype(kind)
    (right,) = recognize_recording(Recording({"pad": Pad(pressed())}), frames="press")
    (answer,) = recognize_recording(Recording({"pad": Pad(stored)}), frames="press")
    assert answer.surface.name == right.surface.name == "sphere"
    assert answer.surface.probability == pytest.approx(right.surface.probability)


def test_blocks_are_mended_as_the_whole_and_other_faults_after_it() -> None:
    signed = pressed()
    signed[30, 3, 4] = 4000
    recording = Recording({"pad": Pad((signed % 65536).astype(np.uint16))})
    whole = without_faults(recording).pads["pad"]
    assert np.abs(whole.frames[30, 3, 4]) < 130
    assert [note.split(":")[0] for note in whole.notes] == [
        f"{np.count_nonzero(signed < 0)} readings below zero were stored without their sign, as 16-bit numbers",
        "1 reading stands alone in time and place",
    ]
    mended = stored_without_faults(stored_of(recording))
    assert mended.pads["pad"].frames.dtype == whole.frames.dtype
    for many in (1, 7, 40):
        bounds = [*range(0, 60, many), 60]
        parts = [mended.part(first, last).pads["pad"].frames for first, last in pairwise(bounds)]
        assert np.array_equal(np.concatenate(parts), whole.frames)


def test_what_is_no_taxel_may_read_anything() -> None:
    field = ALL.copy()
    field[:3, :2] = False
    stored = (pressed() % 65536).astype(np.uint16)
    stored[:, ~field] = 30_000
    mended = without_faults(Recording({"pad": Pad(stored, field=field)})).pads["pad"].frames
    assert np.array_equal(mended[:, field], pressed()[:, field])


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float64])
def test_in_a_stream_signs_come_back_and_presses_are_felt(kind: type) -> None:
    frames = np.concatenate([pressed(seed, peak=peak) for seed, peak in enumerate((0.0, 0.0, 0.0, 120.0, 120.0))])
    stored = (frames % (256 if kind is np.uint8 else 65536)).astype(kind)
    watcher = PadWatcher("pad", PadLayout(shape=(12, 12)), whole=True)
    seen = [watcher.see(k / 50, frame) for k, frame in enumerate(stored)]
    kinds = [event.kind for one in seen for event in one.events]
    assert (kinds.count("touched"), kinds.count("released")) == (2, 2)
    assert any("come without their sign" in note for note in seen[-1].notes)
    assert np.abs(seen[-1].zeroed).max() < 30.0


def test_a_stream_of_positive_readings_is_left_as_it_is() -> None:
    sign = RunningSign(ALL)
    for frame in np.abs(pressed()).astype(np.uint16):
        assert sign.update(frame) is frame
    assert sign.words() == ()


def test_a_command_tells_of_it(tmp_path: object) -> None:
    file = f"{tmp_path}/wrapped.npz"
    write(Recording({"pad": Pad((pressed() % 65536).astype(np.uint16))}), file)
    words = " ".join(told("touch", file).output.split())
    assert "saturated, or readings below zero are stored without their sign" in words
    assert "readings below zero were stored without their sign, as 16-bit numbers: taken as below zero" in words
