"""Laws of files that can be read in two ways, one of them wrong: the reader refuses, or says which way it took."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold import Pad, Recording, read
from varishold.errors import FormatError


def csv(path: Path, rows: np.ndarray, header: str = "") -> Path:
    lines = [",".join(f"{value:g}" for value in row) for row in rows]
    path.write_text("\n".join([header] * bool(header) + lines) + "\n")
    return path


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.booleans(), st.integers(60, 100))
def test_a_column_behind_the_taxels_is_not_read_as_the_time_before_them(
    tmp_path_factory: pytest.TempPathFactory, seed: int, titled: bool, n: int
) -> None:
    rng = np.random.default_rng(seed)
    rows = np.column_stack([rng.normal(0, 1, (n, 12)), np.full(n, 23.5)])
    header = ",".join([*(f"t{k}" for k in range(12)), "temperature"]) if titled else ""
    with pytest.raises(FormatError, match="is no time; leave out the column that is no taxel"):
        read(csv(tmp_path_factory.mktemp("odd") / "a.csv", rows, header), shape=(3, 4))


def test_a_corner_that_is_never_pressed_is_no_time(tmp_path: Path) -> None:
    rows = np.column_stack([np.zeros(9), np.ones((9, 12))])
    with pytest.raises(FormatError, match="never changes"):
        read(csv(tmp_path / "a.csv", rows), shape=(3, 4))
    assert read(csv(tmp_path / "b.csv", rows, "time_s," + ",".join("abcdefghijkl")), shape=(3, 4)).time_s is not None


@pytest.mark.parametrize("header", ["", "zeit" + ",t" * 12, "time_ms" + ",t" * 12, "frame" + ",t" * 12])
def test_a_first_column_that_runs_is_the_time_or_the_number(tmp_path: Path, header: str) -> None:
    rows = np.column_stack([np.arange(9) / 4, np.random.default_rng(0).normal(0, 1, (9, 12))])
    recording = read(csv(tmp_path / "a.csv", rows, header), shape=(3, 4))
    assert recording.pads["pad"].frames.shape == (9, 3, 4)
    assert (recording.time_s is None) == header.startswith("frame")
    rows[5, 0] = 0.0
    if not header.startswith("zeit"):
        assert read(csv(tmp_path / "b.csv", rows, header), shape=(3, 4)).n_frames == 9


def test_frames_that_may_be_the_last_axis_are_told(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).normal(0, 1, (16, 16, 17))
    np.save(tmp_path / "a.npy", frames)
    (note,) = read(tmp_path / "a.npy").notes
    assert "read as 16 frames of 16 x 17" in note
    assert "17 frames of 16 x 16" in note
    np.save(tmp_path / "b.npy", np.moveaxis(frames, -1, 0))
    assert read(tmp_path / "b.npy").notes == ()


def test_a_pitch_in_millimetres_is_asked_about() -> None:
    frames = np.random.default_rng(0).normal(0, 1, (5, 4, 4))
    remarks = Recording({"palm": Pad(frames, pitch_m=(4.0, 4.0))}).remarks
    assert remarks == ("pad palm: taxels are 4 m apart: is the pitch in millimetres?",)
    assert Recording({"palm": Pad(frames, pitch_m=(0.05, 0.004))}).remarks == ()
