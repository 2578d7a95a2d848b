"""Laws of what all taxels do together: hum goes, and what presses stays as it is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.pressed_things import told

from varishold import Pad, Recording, recognize_recording, write
from varishold.frame.common_mode import common_mode
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

Frames = NDArray[np.float64]
PRESS = np.r_[np.linspace(0.1, 1.0, 8), np.ones(6), np.linspace(0.9, 0.1, 6)]
COURSE = np.r_[np.zeros(20), PRESS, np.zeros(15), PRESS, np.zeros(15)]
N = len(COURSE)
ALL = np.ones((12, 12), np.bool_)
ROW, COL = np.indices(ALL.shape) - 5.5
BALL = np.sqrt(np.maximum(1.0 - (ROW**2 + COL**2) / 16.0, 0.0))


def pressed(form: NDArray[np.float64] = BALL, seed: int = 0, noise: float = 10.0) -> Frames:
    rng = np.random.default_rng(seed)
    frames: Frames = 1000.0 * COURSE[:, None, None] * form + rng.normal(0.0, noise, (N, *ALL.shape))
    return frames


def hum(size: float, pace: float = 2.3) -> Frames:
    return np.asarray(size * np.sin(pace * np.arange(N) + 0.4))[:, None, None]


@pytest.mark.parametrize("noise", [0.0, 1.0, 10.0, 60.0])
def test_presses_without_hum_are_left_as_they_are(noise: float) -> None:
    near = np.exp(-(ROW**2 + COL**2) / 8.0)
    forms = {
        "a ball": BALL,
        "what reaches everywhere": 0.9 * BALL + 0.1 * np.exp(-np.hypot(ROW, COL) / 8.0),
        "a plane": np.ones(ALL.shape),
        "a slope": 1.0 + 0.05 * COL,
        "an edge": (COL > 0).astype(float),
        "all but a few": 1.0 - near,
    }
    for name, form in forms.items():
        for seed in range(5):
            assert common_mode(pressed(form, seed, noise), ALL) is None, name
            # A load that never rests. One that all taxels bear alike lasts longer than a frame, or it is hum.
            lasts = 10 if name in ("a plane", "a slope") else 1
            loads = np.repeat(np.random.default_rng(seed).uniform(0.2, 1.0, N // lasts), lasts)[:, None, None]
            noisy = pressed(0.0 * BALL, seed, noise)[: len(loads)]
            assert common_mode(1000.0 * loads * form + noisy, ALL) is None, name


@pytest.mark.parametrize("pace", [0.95, 1.6, 2.3, 2.9])
def test_hum_alone_is_no_press(pace: float) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        share = rng.uniform(0.8, 1.2, ALL.shape)
        jumps = rng.normal(0.0, 40.0, N)[:, None, None]
        for alike in (hum(50.0, pace) * share, jumps * share):
            frames = 300.0 + alike + rng.normal(0.0, 2.0, (N, *ALL.shape))
            recording = without_faults(Recording({"pad": Pad(frames)}))
            assert list(recording.presses.frames) == []
            assert recording.pads["pad"].frames.std() < 4.0
            # Presses that have names are presses, whatever they look like.
            named = Recording({"pad": Pad(frames)}, press=np.arange(N))
            assert without_faults(named) is named


@pytest.mark.parametrize("pace", [1 / 2, 1 / 3, 1 / 4, 1 / 5, 2 / 5, 3 / 8])
@pytest.mark.parametrize("whole", [False, True])
def test_hum_at_a_simple_part_of_the_frame_rate_is_no_press(pace: float, whole: bool) -> None:
    """As at 100 frames a second, where mains go up and down once in two of them."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        goes = 40.0 * np.sin(2 * np.pi * (pace * np.arange(300) + rng.random()))
        frames = 300.0 + goes[:, None, None] + rng.normal(0.0, 1.5, (300, 16, 16))
        frames = np.rint(frames) if whole else frames
        mended = without_faults(Recording({"pad": Pad(frames.astype(np.uint16) if whole else frames)}))
        # Nothing of it is left in the mean, whole numbers or not.
        assert np.std(mended.pads["pad"].frames.mean(axis=(1, 2))) < 1.5 * 1.5 / 16
        assert list(mended.presses.frames) == []


def test_what_one_row_does_for_itself_is_not_taken_for_what_all_do() -> None:
    """A row that flickers is the calmest quarter of a small pad where it flickers least."""
    y, x = np.indices((6, 10)) - np.array([2.5, 4.5])[:, None, None]
    for seed in range(12):
        rng = np.random.default_rng(seed)
        frames = 300.0 + rng.normal(0.0, 8.0, (300, 6, 1)) + rng.normal(0.0, 1.0, (300, 6, 10))
        frames[100:160] += 60.0 * (np.hypot(y, x) < 2.3)
        assert common_mode(frames, np.ones((6, 10), np.bool_)) is None


def test_a_light_press_amid_hum_is_found() -> None:
    rng = np.random.default_rng(3)
    frames = 300.0 + 50.0 * COURSE[:, None, None] * BALL + hum(50.0) + rng.normal(0.0, 2.0, (N, *ALL.shape))
    assert len(without_faults(Recording({"pad": Pad(frames)})).presses.frames) == 2


def test_quick_presses_of_the_whole_pad_stay() -> None:
    rng = np.random.default_rng(4)
    for loaded, free in ((1, 1), (2, 2), (1, 3)):
        taps = np.tile(np.r_[np.zeros(free), np.ones(loaded)], 80 // (loaded + free))
        frames = 100.0 * taps[:, None, None] * np.ones(ALL.shape) + rng.normal(0.0, 1.0, (len(taps), *ALL.shape))
        assert common_mode(frames, ALL) is None, (loaded, free)
    taps = np.tile([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0], 6)
    drifting = 100.0 * taps + np.arange(len(taps))
    frames = drifting[:, None, None] + rng.normal(0.0, 1.0, (len(taps), *ALL.shape))
    assert common_mode(frames, ALL) is None


def test_what_only_part_of_the_taxels_does_is_not_taken_off() -> None:
    frames = pressed(seed=1)
    frames[:, :6] += hum(60.0)
    found = common_mode(frames, ALL)
    # Either nothing is found, or each taxel has its own share.
    assert found is None or found.share[:6].min() > 0.5 > found.share[6:].max()


@pytest.mark.parametrize("size", [20.0, 60.0, 150.0])
@pytest.mark.parametrize("pace", [0.9, 2.3, 3.1])
def test_hum_is_taken_off(size: float, pace: float) -> None:
    clean = pressed() + 300.0
    mended = without_faults(Recording({"pad": Pad(clean + hum(size, pace))})).pads["pad"]
    assert mended.notes[-1].startswith("all taxels go up and down together by ")
    off = mended.frames - clean
    # Where zero lies, nobody knows.
    assert np.abs(off - np.median(off)).mean() < 3.0


def test_whole_numbers_stay_whole_and_full_scale_stays_full() -> None:
    clean = np.clip(np.rint(pressed() * 1.2 + 100.0), 0, 1023)
    read = np.clip(np.rint(pressed() * 1.2 + 100.0 + hum(50.0)), 0, 1023).astype(np.uint16)
    mended = without_faults(Recording({"pad": Pad(read)})).pads["pad"].frames
    assert mended.dtype == np.uint16
    assert (mended[read == 1023] == 1023).all()
    assert np.abs(mended.astype(float) - clean)[read < 1023].mean() < 5.0


def test_each_taxel_has_its_share_where_the_recording_tells() -> None:
    share = np.random.default_rng(5).uniform(0.6, 1.4, ALL.shape)
    found = common_mode(pressed() + share * hum(100.0), ALL)
    assert found is not None
    assert np.corrcoef(found.share.ravel(), share.ravel())[0, 1] > 0.95


def test_what_is_no_taxel_may_read_anything() -> None:
    frames, field = pressed() + hum(60.0), ALL.copy()
    field[:3, :2] = False
    frames[:, ~field] = np.nan
    mended = without_faults(Recording({"pad": Pad(frames, field=field)})).pads["pad"].frames
    assert np.isnan(mended[:, ~field]).all()
    assert np.abs(mended[:15, field]).mean() < 15.0


def test_a_press_under_hum_is_one_press_of_what_it_is() -> None:
    for seed in range(5):
        answers = list(recognize_recording(Recording({"pad": Pad(pressed(seed=seed) + hum(40.0))}), frames="press"))
        assert [answer.surface.name for answer in answers] == ["sphere", "sphere"]


def test_blocks_are_mended_as_the_whole() -> None:
    recording = Recording({"pad": Pad(pressed() + hum(60.0) + 300.0)})
    whole = without_faults(recording).pads["pad"].frames
    mended = stored_without_faults(stored_of(recording))
    for many in (1, 7, 40):
        bounds = [*range(0, N, many), N]
        parts = [mended.part(first, last).pads["pad"].frames for first, last in pairwise(bounds)]
        assert np.allclose(np.concatenate(parts), whole, rtol=0, atol=1e-9)


def test_a_command_tells_of_it(tmp_path: object) -> None:
    file = f"{tmp_path}/hum.npz"
    write(Recording({"pad": Pad(pressed() + hum(60.0))}), file)
    assert "as by mains hum: taken off" in told("touch", file).output


@pytest.mark.parametrize("shape", [(15, 12, 12), (90, 3, 5), (90, 1, 8)])
def test_too_little_to_tell(shape: tuple[int, int, int]) -> None:
    frames = np.random.default_rng(0).normal(0, 1, shape) + 9 * np.sin(2.3 * np.arange(shape[0]))[:, None, None]
    assert common_mode(frames, np.ones(shape[1:], np.bool_)) is None
