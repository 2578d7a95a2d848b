"""By which marks formats are known, and where sizes, names and files are cut."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.test_recording_messages import cloud

from varishold.errors import InputError
from varishold.recording import FORMATS, Pad, Recording, read, write
from varishold.recording.formats.lerobot_plan import FILE_MB, plan_of
from varishold.recording.formats.matlab_arrays import place_of
from varishold.recording.messages import clouds, read_message

TEKSCAN = ("ROWS 3", "COLS 4", "DATA_TYPE MOVIE")


@pytest.mark.parametrize(
    ("name", "head", "known"),
    [
        ("tekscan", "\n".join(TEKSCAN), True),
        ("tekscan", "\n".join((*TEKSCAN, "UNITS kPa")), True),
        *(("tekscan", "\n".join(line for line in TEKSCAN if line != each), False) for each in TEKSCAN),
        ("tekscan", "whatever\nASCII_DATA @@", True),
        ("icub-grasp", "-10000\n1 2 3\n", True),
        ("icub-grasp", "-10000\n", False),
        ("icub-grasp", "-10000\n1\n", False),
        ("icub-grasp", "-1000\n1 2 3\n", False),
    ],
)
def test_a_text_is_known_by_the_fewest_marks_that_tell_it(tmp_path: Path, name: str, head: str, known: bool) -> None:
    assert FORMATS[name].recognizes(tmp_path / "a.csv", head.encode()) is known


@pytest.mark.parametrize(
    ("name", "mark"),
    [
        ("mcap", b"\x89MCAP0\r\n"),
        ("npy", b"\x93NUMPY"),
        ("npz", b"PK\x03\x04"),
        ("npz", b"PK\x05\x06"),
        ("parquet", b"PAR1"),
        ("rosbag1", b"#ROSBAG V"),
        ("hdf5", b"\x89HDF\r\n\x1a\n"),
        ("hdf5", bytes(512) + b"\x89HDF\r\n\x1a\n"),
        ("hdf5", bytes(1024) + b"\x89HDF\r\n\x1a\n"),
        ("picture", b"\x89PNG"),
        ("picture", b"II*\0"),
        ("picture", b"MM\0*"),
    ],
)
def test_a_binary_file_is_known_by_its_first_bytes_and_all_of_them(tmp_path: Path, name: str, mark: bytes) -> None:
    known = FORMATS[name].recognizes
    assert known(tmp_path / "a", mark + b"more")
    assert not known(tmp_path / "a", mark[:-1])
    assert not known(tmp_path / "a", b"x" + mark)


@pytest.mark.parametrize(("rows", "cols"), [(1, 12), (3, 4), (12, 1), (2, 6)])
def test_a_cloud_may_have_so_many_points_and_not_one_more(
    monkeypatch: pytest.MonkeyPatch, rows: int, cols: int
) -> None:
    points = np.zeros(rows * cols, [("pressure", "f4")])
    points["pressure"] = np.arange(rows * cols)
    message = cloud(points, rows)
    monkeypatch.setattr(clouds, "MOST_VALUES", rows * cols)
    said = read_message(message)
    np.testing.assert_array_equal(next(iter(said.pads.values())).values.ravel(), np.arange(rows * cols))
    monkeypatch.setattr(clouds, "MOST_VALUES", rows * cols - 1)
    with pytest.raises(InputError, match=rf"a cloud of {rows} x {cols} points of \d+ bytes, \d+ a row, came"):
        read_message(message)


def test_pads_whose_names_become_the_same_keep_their_fields_and_get_structs_of_their_own() -> None:
    taken: set[tuple[str, ...]] = set()
    pads = ["left 1", "left_1", "left-1", "left.1"]
    places = {(pad, kind): place_of(f"{kind}.{pad}", taken) for pad in pads for kind in ("pressure", "valid")}
    assert {place[1] for (_, kind), place in places.items() if kind == "valid"} == {"valid"}
    assert {place[1] for (_, kind), place in places.items() if kind == "pressure"} == {"pressure"}
    structs = [places[pad, "pressure"][0] for pad in pads]
    assert len(set(structs)) == len(pads)
    assert structs == [places[pad, "valid"][0] for pad in pads]
    # In the presses it is the column that gets another name.
    columns = [place_of(f"press.{name}", taken) for name in ("a b", "a_b", "a-b")]
    assert {place[0] for place in columns} == {"presses"}
    assert len(set(columns)) == 3
    # A plain variable, too.
    assert place_of("time_s", taken) == ("time_s",)
    assert place_of("time_s", taken) == ("time_s_2",)


def test_such_pads_come_back(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    pads = {name: Pad(rng.random((3, 2, 2)), valid=rng.random((2, 2)) < 0.8) for name in ("left 1", "left_1", "left-1")}
    write(Recording(pads), tmp_path / "a.mat")
    again = read(tmp_path / "a.mat")
    assert list(again.pads) == list(pads)
    for name, pad in pads.items():
        np.testing.assert_array_equal(again.pads[name].frames, pad.frames)
        np.testing.assert_array_equal(again.pads[name].usable, pad.usable)


@pytest.mark.parametrize(
    ("mb", "files"), [(33, [0, 0, 0]), (34, [0, 0, 1]), (50, [0, 1, 1]), (99, [0, 1, 2]), (100, [0, 1, 2])]
)
def test_a_lerobot_set_begins_a_file_after_a_hundred_megabytes_and_says_so(
    tmp_path: Path, mb: int, files: list[int]
) -> None:
    press = np.repeat([0, 1, 2], 4)
    recording = Recording({"pad": Pad(np.ones((12, 2, 2)))}, press=press)
    # The size up to an episode's end, in whole hundreds of megabytes, tells its file; those are numbered without gaps.
    plain = [(4 * (k + 1) * mb * 2**18) // (100 * 2**20) for k in range(3)]
    assert plan_of(recording, mb * 2**18).file_of == np.unique(plain, return_inverse=True)[1].tolist() == files
    write(recording, tmp_path / "a.lerobot")
    told: dict[str, Any] = json.loads((tmp_path / "a.lerobot" / "meta" / "info.json").read_text("utf-8"))
    assert (told["data_files_size_in_mb"], told["video_files_size_in_mb"]) == (100, 200) == (FILE_MB, 2 * FILE_MB)
