"""Grasps of an iCub hand: five fingertips and the joints as they are written; what is cut off is left out and told."""

from __future__ import annotations

import os
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from varishold import FormatError
from varishold.recording import Recording, read

_BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"
FINGERS = ["thumb", "index", "middle", "ring", "little"]
STEP = [
    "20.7273 81.0666 15.3808 0.543514 40.3876 66.6667 36.2748 55.5405 2.00816 ",
    "14.0 15.0 11.0 14.0 11.0",
    *[" ".join(f"{200 + 12 * finger + taxel}.0" for taxel in range(12)) for finger in range(5)],
]


def text_of(*steps: list[str], end: str = "\r\n") -> str:
    return end.join(["-10000", *(line for step in steps for line in step), ""])


def told(path: Path, text: str) -> Recording:
    path.write_bytes(text.encode())
    return read(path)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_fingers_joints_and_changes(tmp_path: Path, end: str) -> None:
    recording = told(tmp_path / "ball_3.txt", text_of(STEP, STEP, end=end))
    assert list(recording.pads) == FINGERS
    for finger, pad in enumerate(recording.pads.values()):
        assert pad.frames.dtype == np.int32
        assert pad.frames.tolist() == [[[200 + 12 * finger + taxel for taxel in range(12)]]] * 2
        assert (pad.polarity, pad.positions_m) == ("down", None)
    assert recording.signals["encoders"].values[1].tolist() == [float(word) for word in STEP[0].split()]
    assert recording.signals["encoders"].names == tuple(f"joint_{k}" for k in range(7, 16))
    assert recording.signals["maxima"].values.tolist() == [[14, 15, 11, 14, 11]] * 2
    assert recording.signals["maxima"].names == tuple(FINGERS)
    assert recording.time_s is None
    assert len(recording.notes) == 1


@given(
    hnp.arrays(np.float64, st.tuples(st.integers(1, 4), st.just(74)), elements=st.floats(0, 255)),
    st.sampled_from(["\n", "\r\n", "\n\n"]),
)
def test_every_number_comes_back(tmp_path_factory: pytest.TempPathFactory, values: np.ndarray, end: str) -> None:
    path = tmp_path_factory.mktemp("icub") / "a.txt"
    edges = [0, 9, 14, 26, 38, 50, 62, 74]
    steps = [[" ".join(map(repr, row[a:b].tolist())) for a, b in pairwise(edges)] for row in values]
    recording = told(path, text_of(*steps, end=end))
    taxels = np.concatenate([pad.frames[:, 0] for pad in recording.pads.values()], axis=1)
    parts = [recording.signals["encoders"].values, recording.signals["maxima"].values, taxels]
    assert np.array_equal(np.concatenate(parts, axis=1), values)


@pytest.mark.parametrize("cut", [2, 4, 6, 40, 300])
def test_a_step_that_is_cut_off_is_left_out_and_told(tmp_path: Path, cut: int) -> None:
    recording = told(tmp_path / "a.txt", text_of(STEP, STEP, STEP)[:-cut])
    assert recording.n_frames == 2
    assert recording.notes[1:] == ("is cut off: its last step, from line 16 on, is left out",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (text_of(STEP[:6]), "is cut off: no step of 7 lines is whole"),
        (text_of(STEP[1:], STEP), "line 2 must have 9 numbers, got 5; seven lines are a step"),
        (text_of(STEP, STEP[1:], STEP), "line 9 must have 9 numbers like line 2, got 5"),
        (text_of(STEP, [*STEP[:4], STEP[4][:-8], *STEP[5:]], STEP), "line 13 must have 12 numbers like line 4, got 11"),
        (text_of(STEP, STEP).replace("211.0", "x"), "line 4, column 12 must be a number, got 'x'"),
        (text_of(STEP, STEP).replace("211.0", "nan"), "line 4, column 12 must be finite, got 'nan'"),
    ],
)
def test_bad_lines_are_told_with_their_place(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        told(tmp_path / "a.txt", text)


def test_a_shape_that_is_not_theirs(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text(text_of(STEP))
    with pytest.raises(FormatError, match="has frames of 1 x 12, not 3 x 4; leave the shape out"):
        read(tmp_path / "a.txt", shape=(3, 4))


@pytest.mark.real_data
def test_the_grasps_as_they_were_published() -> None:
    folder = Path(os.environ.get("VARISHOLD_DATA", _BESIDE)) / "icub_grasp" / "iCubGraspDataset"
    if not folder.is_dir():
        pytest.skip("icub_grasp is not here; set VARISHOLD_DATA to the folder that holds the recordings")
    paths = sorted(folder.glob("*_1.txt"))
    assert len(paths) == 11
    for path in paths:
        recording, rows = read(path), [line.split() for line in path.read_text().splitlines()[1:]]
        assert recording.n_frames == len(rows) // 7
        for finger, pad in enumerate(recording.pads.values()):
            assert pad.frames[:, 0].tolist() == [[float(cell) for cell in row] for row in rows[2 + finger :: 7]]
