"""Groups of an episode each: joined in the order of their numbers, each a press."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import varishold
from varishold.recording import Pad, Recording, read

h5py = pytest.importorskip("h5py")


def frames(n: int, first: int = 0, shape: tuple[int, int] = (6, 5)) -> np.ndarray:
    return first + np.arange(n * shape[0] * shape[1], dtype=np.float32).reshape(n, *shape)


def demonstrations(path: Path, lengths: dict[str, int], **more: Any) -> Path:
    """Write a group a demonstration, as robomimic does; `more` changes one of them."""
    with h5py.File(path, "w") as file:
        for k, (name, n) in enumerate(lengths.items()):
            group = file.create_group(f"data/{name}")
            group.attrs["num_samples"] = n
            group.attrs["model_file"] = "<xml>" * 100
            group["label"] = f"thing {k}"
            group["obs/tactile"] = frames(n, 1000 * k)
            group["obs/time"] = 0.1 * np.arange(n)
            group["actions"] = np.zeros((n, 7))
        file["mask/train"] = np.array([name.encode() for name in lengths])
        for place, value in more.items():
            if place in file:
                del file[place]
            file[place] = value
    return path


def test_demonstrations_are_presses_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    path = demonstrations(tmp_path / "d.hdf5", {"demo_10": 4, "demo_2": 7, "demo_0": 5})
    recording = read(path)
    expected = np.concatenate([frames(5, 2000), frames(7, 1000), frames(4, 0)])
    np.testing.assert_array_equal(recording.pads["pad"].frames, expected)
    assert recording.press is not None
    assert recording.press.tolist() == [0] * 5 + [1] * 7 + [2] * 4
    assert recording.press_columns["episode"].tolist() == [0, 2, 10]
    assert recording.press_columns["label"].tolist() == ["thing 2", "thing 1", "thing 0"]
    assert recording.press_columns["num_samples"].tolist() == [5, 7, 4]
    # A scene's text is no word about an episode.
    assert "model_file" not in recording.press_columns
    assert "each of 3 episodes is a press" in recording.notes


def test_the_clock_of_episodes_goes_on(tmp_path: Path) -> None:
    path = demonstrations(tmp_path / "d.hdf5", {"demo_0": 5, "demo_1": 3, "demo_2": 1})
    recording = read(path)
    np.testing.assert_allclose(recording.time_s, 0.1 * np.arange(9))
    assert any("the clock begins anew" in note for note in recording.notes)
    with varishold.open(path) as opened:
        np.testing.assert_allclose(np.concatenate([b.time_s for b in opened.blocks(2)]), recording.time_s)
    later = {f"data/demo_{k}/obs/time": 10.0 * k + np.arange(n) for k, n in enumerate((5, 3, 1))}
    recording = read(demonstrations(tmp_path / "on.hdf5", {"demo_0": 5, "demo_1": 3, "demo_2": 1}, **later))
    np.testing.assert_array_equal(recording.time_s, np.concatenate([*later.values()]))
    assert not any("anew" in note for note in recording.notes)


def test_a_part_is_read_across_the_ends_of_episodes(tmp_path: Path) -> None:
    path = demonstrations(tmp_path / "d.hdf5", {f"demo_{k}": n for k, n in enumerate((3, 0, 4, 2))})
    whole = read(path)
    with varishold.open(path) as opened:
        assert opened.n_frames == 9
        for first in range(9):
            for last in range(first + 1, 10):
                part = opened.frames[first:last]
                np.testing.assert_array_equal(part.pads["pad"].frames, whole.pads["pad"].frames[first:last])
                np.testing.assert_array_equal(part.press, whole.press[first:last])


@pytest.mark.parametrize(
    ("lengths", "more"),
    [
        # Two of one number; a single one; fingers, which are pads.
        ({"demo_1": 5, "demo_01": 5}, {}),
        ({"demo_0": 5}, {}),
        ({"finger_0": 5, "finger_1": 5}, {}),
        # Other taxels are another pad.
        ({"demo_0": 5, "demo_1": 5}, {"data/demo_1/obs/tactile": frames(5, 0, (3, 4))}),
    ],
)
def test_what_is_not_a_row_of_episodes_stays_as_it_is(lengths: dict, more: dict, tmp_path: Path) -> None:
    recording = read(demonstrations(tmp_path / "d.hdf5", lengths, **more))
    assert recording.n_frames == 5
    assert recording.press is None
    assert len(recording.pads) == len(lengths)


def test_pads_of_our_own_files_are_no_episodes(tmp_path: Path) -> None:
    recording = Recording({name: Pad(frames(4)) for name in ("demo_0", "demo_1")})
    varishold.write(recording, tmp_path / "own.h5")
    assert set(read(tmp_path / "own.h5").pads) == {"demo_0", "demo_1"}


def test_attributes_of_the_first_episode_hold_for_all(tmp_path: Path) -> None:
    path = tmp_path / "d.h5"
    with h5py.File(path, "w") as file:
        for k in range(2):
            held = file.create_dataset(f"episode{k}/finger/pressure", data=frames(3, k))
            held.attrs["pitch_m"] = 2e-3
            held.attrs["unit"] = "kPa"
    recording = read(path)
    assert recording.unit == "kPa"
    assert recording.pads["finger"].pitch_m == (2e-3, 2e-3)
    assert recording.press is not None
    assert recording.press.tolist() == [0, 0, 0, 1, 1, 1]
