"""Odd but legal frames end in an honest answer, and impossible ones in one line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from varishold.errors import FormatError, InputError
from varishold.recording import Pad, Recording
from varishold.skin import PressDraw, Skin, collect_presses, press, read_skin
from varishold.solids import Pose, Sphere
from varishold.touch import find_contacts, recognize, recognize_recording

SKIN = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)


@pytest.mark.parametrize("shape", [(1, 1), (1, 20), (3, 3), (8, 8), (16, 16), (5, 40)])
@pytest.mark.parametrize("top", [1e-3, 255.0, 4095.0])
def test_a_frame_at_full_scale_everywhere_may_be_a_plane(shape: tuple[int, int], top: float) -> None:
    (contact,) = find_contacts(np.full(shape, top))
    surface = recognize(contact)
    assert surface.name == "plane"
    assert surface.probability == pytest.approx(0.55 if min(shape) < 4 else 0.85)
    assert any("show nothing of a form" in reason for reason in surface.reasons)
    assert recognize(contact, among=["cone", "cylinder"]).name in ("cone", "cylinder")


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 2), (2, 3), (1, 8), (4, 2)])
def test_a_pad_of_a_few_taxels_is_sure_of_nothing(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        contacts = find_contacts(100 * rng.uniform(0.5, 1.0, shape))
        assert all(recognize(contact).probability < 0.8 for contact in contacts)
        assert all(recognize(contact).names["plane"] <= 0.551 for contact in contacts)


@pytest.mark.parametrize("free", [0, 1, 10, 100])
def test_what_saturates_most_of_a_pad_is_not_surely_a_plane(free: int) -> None:
    rng = np.random.default_rng(free)
    frame = np.full(256, 255.0)
    frame[rng.choice(256, free, replace=False)] = rng.uniform(200, 254, free)
    assert recognize(find_contacts(frame.reshape(16, 16))[0]).names["plane"] <= 0.851
    rows, cols = np.mgrid[:16, :16] - 7.5
    ball = np.minimum(400 - 1.6 * (rows**2 + cols**2), 255)
    assert (ball == 255).mean() > 0.5
    assert recognize(find_contacts(ball)[0]).probability < 0.86


@pytest.mark.parametrize("shape", [(5, 5), (8, 8), (16, 16), (32, 32)])
def test_a_plane_that_shows_its_noise_stays_a_sure_one(shape: tuple[int, int]) -> None:
    frame = 100 + np.random.default_rng(0).normal(0, 1, shape)
    surface = recognize(find_contacts(frame)[0])
    assert (surface.name, surface.probability > 0.9) == ("plane", True)
    assert not any("nothing of a form" in reason for reason in surface.reasons)


def test_of_a_press_that_saturates_everything_the_answer_is_as_unsure() -> None:
    frames = np.zeros((20, 16, 16), np.uint8)
    frames[8:14] = 255
    for how in ("peak", "press"):
        (answer,) = recognize_recording(Recording({"pad": Pad(frames)}), frames=how)
        assert answer.surface.probability < 0.86


@pytest.mark.parametrize("exact", [False, True])
def test_a_frame_at_full_scale_is_a_plane_through_a_skin_too(exact: bool) -> None:
    recording = Recording({"pad": Pad(np.full((1, 16, 16), 255, np.uint8), pitch_m=1e-3)})
    (answer,) = recognize_recording(recording, skin=SKIN, exact=exact)
    assert answer.surface.name == "plane"
    json.dumps(answer.to_dict(), allow_nan=False)


def test_one_frame_of_a_press_is_pooled_with_itself_wherever_its_peak_lies() -> None:
    # The taxel of the peak lies farther from the contact's centroid than the root of its area.
    rows, cols = np.mgrid[:16, :16]
    frame = ((rows - 7.6) ** 2 + (cols - 7.3) ** 2 < 20).astype(np.float64)
    (answer,) = recognize_recording(Recording({"pad": Pad(frame[None], pitch_m=(1e-6, 1.0))}), frames="press")
    assert np.isfinite(answer.surface.probability)
    json.dumps(answer.to_dict(), allow_nan=False)


def test_values_with_no_room_for_thresholds_are_no_contact() -> None:
    frame = np.zeros((8, 8))
    frame[2:6, 2:6] = 5e-324
    assert find_contacts(frame) == []
    assert find_contacts(frame * 2.0**400) == []
    assert len(find_contacts(frame * 2.0**700)) == 1


@pytest.mark.parametrize("pitch", [1e-300, 1e300, 1e-31])
def test_a_pitch_beyond_all_pads_is_refused(pitch: float) -> None:
    with pytest.raises(InputError, match=r"pitch must be one spacing in metres .* from 1e-09 to 1000"):
        find_contacts(np.eye(4), pitch=pitch)
    with pytest.raises(InputError, match=r"pitch_m must be one spacing .* from 1e-09 to 1000"):
        Pad(np.zeros((1, 4, 4)), pitch_m=pitch)


def test_a_pad_too_small_for_its_skin_is_named() -> None:
    recording = Recording({"tip": Pad(np.ones((1, 1, 20)), pitch_m=1e-3)})
    with pytest.raises(InputError, match="pad 'tip' has only 1 x 20 taxels"):
        next(recognize_recording(recording, skin=SKIN))


def test_times_far_apart_are_compared_without_a_warning() -> None:
    recording = Recording({"pad": Pad(np.ones((2, 3, 3)))}, time_s=np.array([1e308, -1e308]))
    assert "time goes back at frame 1" in recording.remarks


@pytest.mark.parametrize("thickness", ["1e300", "9" * 400, "1e-300", "1e4"])
def test_a_skin_of_impossible_thickness_is_refused(tmp_path: Path, thickness: str) -> None:
    path = tmp_path / "skin.toml"
    path.write_text(f'[skin]\nkind = "layer"\npoisson = 0.45\nthickness_m = {thickness}\n')
    with pytest.raises(FormatError, match=r"skin.toml: \[skin\] thickness_m of a skin must"):
        read_skin(path)


def test_a_pose_and_a_size_are_numbers() -> None:
    with pytest.raises(InputError, match="tip_x of a pose must be finite"):
        Pose(tip_x=float("inf"))
    with pytest.raises(InputError, match="diameter_m of a sphere must be at most 1e\\+100"):
        Sphere(1e300)


@pytest.mark.parametrize("pitch", [1e-300, 1e300])
def test_a_press_on_an_impossible_pitch_is_refused(pitch: float) -> None:
    with pytest.raises(InputError, match=r"pitch_m must be one spacing .* from 1e-09 to 1000"):
        press(Sphere(0.01), SKIN, depth=1e-3, shape=(8, 8), pitch_m=pitch)


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder in which nobody can write")
def test_presses_that_cannot_be_written_are_refused_before_any_is_pressed() -> None:
    with pytest.raises(InputError, match=r"/proc/x\.npz: cannot write here"):
        collect_presses("/proc/x.npz", PressDraw(skin=SKIN), 2)


@pytest.mark.parametrize("seed", range(4))
def test_a_press_that_saturates_is_named_by_the_frames_that_show_its_form(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows, cols = np.mgrid[:16, :16] - 7.5
    ball = np.clip(1 - (rows**2 + cols**2) / rng.uniform(14, 30), 0, None)
    ramp = np.concatenate([np.zeros(20), np.linspace(0, 1, 12), np.ones(15), np.linspace(1, 0, 12), np.zeros(20)])
    frames = 600 * ramp[:, None, None] * ball + rng.normal(0, 1, (len(ramp), 16, 16))
    pad = Pad(np.clip(frames, -128, 127).round().astype(np.int8))
    (answer,) = recognize_recording(Recording({"pad": pad}), frames="press")
    assert answer.surface.contact.state.saturated > 10
    assert answer.surface.name == "sphere"


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("flat", [False, True])
def test_a_flat_top_of_a_frame_that_is_saturated_is_not_sure(seed: int, flat: bool) -> None:
    rng = np.random.default_rng(seed)
    rows, cols = np.mgrid[:16, :16] - 7.5
    square = (rows**2 + cols**2) / rng.uniform(14, 30)
    form = (square < 1) if flat else np.clip(1 - square, 0, None)
    load = np.concatenate([np.zeros(20), np.linspace(0, 1, 8), np.ones(10)])[:, None, None]
    frames = 700 * load * form + rng.normal(0, 1, (len(load), 16, 16))
    pad = Pad(np.clip(frames, -128, 127).round().astype(np.int8))
    (answer,) = recognize_recording(Recording({"pad": pad}), frames="peak")
    surface = answer.surface
    assert surface.probability <= 0.56
    assert sum(surface.names.values()) == pytest.approx(1.0)
    assert next(iter(surface.names)) == surface.name
    assert surface.name != "cylinder" or any("may be the sensor's" in note for note in answer.frame_notes)
    if flat:
        assert surface.names["cylinder"] > 0.3
