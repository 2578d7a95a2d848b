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
def test_a_frame_at_full_scale_everywhere_is_a_plane(shape: tuple[int, int]) -> None:
    (contact,) = find_contacts(np.full(shape, 255.0))
    surface = recognize(contact)
    assert surface.name == "plane"
    assert surface.probability > 0.999
    assert recognize(contact, among=["cone", "cylinder"]).name in ("cone", "cylinder")


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
    assert len(find_contacts(frame * 2.0**100)) == 1


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
