"""LeRobot data sets: nothing is lost, folders laid out as its library has them are understood, bad ones are told.

What the library itself writes and reads is compared by ``python -m hostile.lerobot_library``.
"""

# ruff: noqa: E501

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from hypothesis import assume, given, settings
from tests.test_recording_hdf5 import writable
from tests.test_recording_mcap import recordings, same

from varishold import FormatError, InputError
from varishold import open as open_recording
from varishold.cli.app import app
from varishold.cli.recordings import recording_files
from varishold.recording import Mark, Pad, Recording, Signals, read, write
from varishold.recording.formats import is_folder

FRAMES = np.arange(9 * 3 * 4, dtype=np.float32).reshape(9, 3, 4)
EPISODES = np.array([0, 0, 0, 0, 1, 1, 2, 2, 2])
TICKS = np.array([0, 1, 2, 3, 0, 1, 0, 1, 2])


@settings(deadline=None, max_examples=100)
@given(recordings())
def test_writing_a_data_set_loses_nothing(tmp_path_factory: pytest.TempPathFactory, recording: Recording) -> None:
    assume(writable(recording))
    folder = tmp_path_factory.mktemp("lerobot")
    write(recording, folder / "a.lerobot")
    again = read(folder / "a.lerobot")
    same(recording, again)
    assert again.notes == ()


def data_set(
    path: Path,
    columns: dict[str, Any],
    features: dict[str, tuple[str, list[int], Any]],
    *,
    cuts: tuple[int, ...] = (),
    tasks: tuple[str, ...] = ("push", "pull"),
    **more: Any,
) -> Path:
    """Write a data set as the library lays it out, its rows cut into several files."""
    columns = {
        **columns,
        "timestamp": pa.array(TICKS / 10, pa.float32()),
        "frame_index": TICKS,
        "episode_index": EPISODES,
        "index": np.arange(9),
        "task_index": EPISODES % 2,
    }
    table = pa.table(columns)
    for k, (a, b) in enumerate(zip((0, *cuts), (*cuts, len(table)), strict=True)):
        file = path / "data" / "chunk-000" / f"file-{k:03d}.parquet"
        file.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(table.slice(a, b - a), file)
    told = {name: {"dtype": dtype, "shape": shape, "names": names} for name, (dtype, shape, names) in features.items()}
    info = {"codebase_version": "v3.0", "fps": 10, "total_frames": len(table), "features": told, **more}
    (path / "meta").mkdir(parents=True, exist_ok=True)
    (path / "meta" / "info.json").write_text(json.dumps(info))
    pq.write_table(pa.table({"task_index": range(len(tasks)), "__index_level_0__": tasks}), path / "meta/tasks.parquet")
    return path


def lists(array: np.ndarray, kind: pa.DataType) -> pa.Array:
    return pa.array(array.tolist(), kind)


GRID = pa.list_(pa.list_(pa.float32()))
PALM = {"observation.tactile.palm": lists(FRAMES, GRID)}
OF_PALM: dict[str, tuple[str, list[int], Any]] = {"observation.tactile.palm": ("float32", [3, 4], ["rows", "cols"])}


@pytest.mark.parametrize("cuts", [(), (4,), (1, 2, 7)])
def test_as_the_library_lays_it_out(tmp_path: Path, cuts: tuple[int, ...]) -> None:
    state = np.arange(18, dtype=np.float32).reshape(9, 2)
    path = data_set(
        tmp_path / "set",
        {
            **PALM,
            "observation.tactile.tip": lists(FRAMES[:, :2].astype(np.uint16), pa.list_(pa.list_(pa.uint16()))),
            "observation.state": lists(state, pa.list_(pa.float32(), 2)),
            "action": pa.array(np.arange(9, dtype=np.float32)),
        },
        {
            **OF_PALM,
            "observation.tactile.tip": ("uint16", [2, 4], None),
            "observation.state": ("float32", [2], {"motors": ["lift", "turn"]}),
            "action": ("float32", [1], None),
            "observation.images.top": ("video", [480, 640, 3], ["height", "width", "channels"]),
        },
        cuts=cuts,
        robot_type="arm",
    )
    assert is_folder(path)
    recording = read(path)
    assert {name: pad.frames.dtype for name, pad in recording.pads.items()} == {"palm": np.float32, "tip": np.uint16}
    assert np.array_equal(recording.pads["palm"].frames, FRAMES)
    assert np.array_equal(recording.pads["tip"].frames, FRAMES[:, :2])
    assert np.array_equal(recording.signals["state"].values, state)
    assert recording.signals["state"].names == ("lift", "turn")
    assert recording.signals["action"].values.tolist() == [[k] for k in range(9)]
    assert recording.sensor == "arm"
    assert recording.press is not None
    assert recording.press.tolist() == EPISODES.tolist()
    assert recording.presses.columns["label"].tolist() == ["push", "pull", "push"]
    assert recording.presses.columns["episode"].tolist() == [0, 1, 2]
    assert recording.time_s is not None
    assert recording.time_s.tolist() == pytest.approx([k / 10 for k in range(9)])
    assert recording.notes == (
        "taken for frames, by shape and name: observation.tactile.palm, observation.tactile.tip",
        "each of 3 episodes is a press, labelled by its task",
        "the clock begins anew with each episode; time goes on from where the one before ended",
        "passed over: observation.images.top",
    )
    with open_recording(path) as opened:
        for first, last in ((5, 9), (0, 1), (3, 6), (0, 9)):
            block = opened.frames[first:last]
            assert np.array_equal(block.pads["palm"].frames, FRAMES[first:last])
            assert block.time_s is not None
            assert block.time_s.tolist() == pytest.approx(recording.time_s[first:last].tolist())


def test_windows_of_readings_that_are_faster_than_rows(tmp_path: Path) -> None:
    fast = np.arange(9 * 4 * 6, dtype=np.float32).reshape(9, 4, 2, 3)
    slow = np.arange(9 * 2 * 6, dtype=np.float32).reshape(9, 2, 2, 3)
    cube = pa.list_(GRID)
    path = data_set(
        tmp_path / "set",
        {
            "observation.tactile.fast": lists(fast, cube),
            "observation.tactile.slow": lists(slow, cube),
            **PALM,
            "x": EPISODES,
        },
        {
            "observation.tactile.fast": ("float32", [4, 2, 3], ["time", "rows", "cols"]),
            "observation.tactile.slow": ("float32", [2, 2, 3], ["time", "rows", "cols"]),
            **OF_PALM,
            "x": ("int64", [1], None),
        },
    )
    recording = read(path)
    assert np.array_equal(recording.pads["fast"].frames, fast.reshape(36, 2, 3))
    assert np.array_equal(recording.pads["slow"].frames, np.repeat(slow.reshape(18, 2, 3), 2, axis=0))
    assert np.array_equal(recording.pads["palm"].frames, np.repeat(FRAMES, 4, axis=0))
    assert recording.signals["x"].values[:, 0].tolist() == np.repeat(EPISODES, 4).tolist()
    assert recording.time_s is not None
    assert recording.time_s == pytest.approx(np.arange(36) / 40 - 0.075)
    assert "4 readings stand in a row; the last is taken to be of the row's time" in recording.notes
    with open_recording(path) as opened:
        for first, last in ((5, 7), (0, 36), (3, 17), (35, 36)):
            assert np.array_equal(
                opened.frames[first:last].pads["fast"].frames, recording.pads["fast"].frames[first:last]
            )


def test_components_and_what_nobody_can_know(tmp_path: Path) -> None:
    forces = np.stack([FRAMES * 0, -FRAMES, FRAMES + 1], axis=-1)
    cube = pa.list_(GRID)
    path = data_set(
        tmp_path / "set",
        {"tactile.force": lists(forces, cube), "tactile.colours": lists(forces.transpose(0, 3, 1, 2), cube)},
        {"tactile.force": ("float32", [3, 4, 3], None), "tactile.colours": ("float32", [3, 3, 4], None)},
    )
    recording = read(path)
    assert {name: pad.frames.tolist() for name, pad in recording.pads.items()} == {"force": (FRAMES + 1).tolist()}
    assert "tactile.force: x, y, z of each taxel; z is taken as pressure" in recording.notes
    assert "passed over: tactile.colours" in recording.notes


def test_flat_taxels_want_their_shape(tmp_path: Path) -> None:
    flat = {"observation.tactile": lists(FRAMES.reshape(9, 12), pa.list_(pa.float32(), 12))}
    path = data_set(tmp_path / "set", flat, {"observation.tactile": ("float32", [12], None)})
    assert np.array_equal(read(path, shape=(3, 4)).pads["tactile"].frames, FRAMES)
    with pytest.raises(FormatError, match="say the shape of a frame if each row is one") as error:
        read(path)
    assert error.value.parameter == "shape"


def test_what_the_library_finds_in_what_is_written(tmp_path: Path) -> None:
    """Every file that it opens, with what it looks for in it."""
    press = np.array([-1, 0, 0, 2, 2, 2, -1, -1, 1])
    columns = {"thing": np.array(["cone", "", "cube"])}
    signals = {"shear": Signals(np.ones((9, 2), np.float32), ("x", "y"))}
    pads = {"palm": Pad(FRAMES), "tip/1": Pad(FRAMES[:, 0, :1, None])}
    path = tmp_path / "a.lerobot"
    write(Recording(pads, np.arange(9) / 50, "kPa", "hand", press=press, press_columns=columns, signals=signals), path)
    info = json.loads((path / "meta/info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_frames"], info["total_episodes"]) == ("v3.0", 50, 9, 5)
    assert info["features"]["observation.tactile.palm"] == {
        "dtype": "float32",
        "shape": [3, 4],
        "names": ["rows", "cols"],
    }
    table = pq.read_table(path / info["data_path"].format(chunk_index=0, file_index=0))
    assert set(table.column_names) == set(info["features"])
    assert table["observation.tactile.palm"].to_pylist() == FRAMES.tolist()
    assert table["observation.tactile.tip%2F1"].to_pylist() == FRAMES[:, :1, :1].tolist()
    assert table["episode_index"].to_pylist() == [0, 1, 1, 2, 2, 2, 3, 3, 4]
    assert table["frame_index"].to_pylist() == [0, 0, 1, 0, 1, 2, 0, 1, 0]
    assert table["timestamp"].to_pylist() == pytest.approx([0, 0, 0.02, 0, 0.02, 0.04, 0, 0.02, 0])
    tasks = pq.read_table(path / "meta/tasks.parquet").to_pydict()
    assert tasks == {"task_index": [0, 1, 2], "__index_level_0__": ["touch", "cone", "cube"]}
    assert table["task_index"].to_pylist() == [0, 1, 1, 2, 2, 2, 0, 0, 0]
    episodes = pq.read_table(path / "meta/episodes/chunk-000/file-000.parquet").to_pydict()
    assert episodes["dataset_from_index"] == [0, 1, 3, 6, 8]
    assert episodes["dataset_to_index"] == [1, 3, 6, 8, 9]
    assert episodes["tasks"] == [["touch"], ["cone"], ["cube"], ["touch"], ["touch"]]
    stats = json.loads((path / "meta/stats.json").read_text())["observation.tactile.palm"]
    assert np.allclose(stats["mean"], FRAMES.mean(axis=0))
    assert np.allclose(stats["std"], FRAMES.std(axis=0))
    assert np.array_equal(stats["max"], FRAMES.max(axis=0))
    # Other programs' readers get the same without what is ours.
    (path / "meta/varishold.json").unlink()
    assert np.array_equal(read(path).pads["palm"].frames, FRAMES)
    pandas = pytest.importorskip("pandas")
    assert pandas.read_parquet(path / "meta/tasks.parquet").iloc[1].name == "cone"


def test_marks_are_tasks(tmp_path: Path) -> None:
    recording = Recording({"palm": Pad(FRAMES)}, marks=(Mark(2, "cone"), Mark(5, "")))
    write(recording, tmp_path / "a.lerobot")
    same(recording, read(tmp_path / "a.lerobot"))
    (tmp_path / "a.lerobot/meta/varishold.json").unlink()
    assert read(tmp_path / "a.lerobot").presses.columns["label"].tolist() == ["touch | cone"]


def test_converting_into_a_folder(tmp_path: Path) -> None:
    write(Recording({"palm": Pad(FRAMES)}, np.arange(9.0)), tmp_path / "a.npz")
    done = CliRunner().invoke(app, ["convert", str(tmp_path / "a.npz"), str(tmp_path / "b.lerobot")])
    assert done.exit_code == 0, done.output
    assert "9 frames, read back and compared: the same" in done.stdout
    with pytest.raises(InputError, match=r"b.lerobot: is there already; name another folder"):
        write(read(tmp_path / "a.npz"), tmp_path / "b.lerobot")
    done = CliRunner().invoke(app, ["convert", str(tmp_path / "a.npz"), str(tmp_path / "b.lerobot")])
    assert done.exit_code == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz", "b.lerobot"]
    done = CliRunner().invoke(app, ["convert", str(tmp_path / "b.lerobot"), str(tmp_path / "c.npz")])
    assert done.exit_code == 0, done.output
    same(read(tmp_path / "a.npz"), read(tmp_path / "c.npz"))


def test_a_folder_among_others_is_one_recording(tmp_path: Path) -> None:
    """Its files are not looked at one by one, wherever it is found; pictures of anything are no recordings."""
    (tmp_path / "all/in").mkdir(parents=True)
    write(Recording({"palm": Pad(FRAMES)}), tmp_path / "all/in/a.lerobot")
    write(Recording({"palm": Pad(FRAMES)}), tmp_path / "all/b.npz")
    (tmp_path / "all/figures").mkdir()
    (tmp_path / "all/figures/curve.png").write_bytes(b"no picture")
    found = [str(tmp_path / "all" / name) for name in ("b.npz", "in/a.lerobot")]
    assert recording_files([str(tmp_path / "all")]) == found
    assert recording_files([str(tmp_path / "all/*/*.lerobot")]) == found[1:]
    assert recording_files([str(tmp_path / "all/in")]) == found[1:]


def said(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def spoil(path: Path) -> None:
        info = json.loads((path / "meta/info.json").read_text())
        change(info)
        (path / "meta/info.json").write_text(json.dumps(info))

    return spoil


def cut(name: str, keep: int = 200) -> Callable[[Path], object]:
    return lambda path: (path / name).write_bytes((path / name).read_bytes()[:keep])


BAD: dict[str, tuple[Callable[[Path], object], str]] = {
    "older": (said(lambda i: i.update(codebase_version="v2.1")), r"info.json: is a data set of version 'v2.1'; 3.0 is read"),
    "no version": (said(lambda i: i.pop("codebase_version")), "info.json: is damaged or cut off: 'codebase_version'"),
    "no features": (said(lambda i: i.pop("features")), "info.json: is damaged or cut off: 'features'"),
    "fps": (said(lambda i: i.update(fps=0)), "fps must be a positive number, got '0'"),
    "fps text": (said(lambda i: i.update(fps="ten")), "fps must be a positive number, got 'ten'"),
    "shape": (said(lambda i: i["features"]["observation.tactile.palm"].update(shape=[3, -4])), r"feature 'observation.tactile.palm' must have a shape of whole numbers, got '\[3, -4\]'"),
    "lying shape": (said(lambda i: i["features"]["observation.tactile.palm"].update(shape=[3, 5])), r"column observation.tactile.palm: has 12 numbers a row, \(3, 5\) of float32 are announced"),
    "not json": (cut("meta/info.json", 20), "info.json: is not complete JSON"),
    "cut data": (cut("data/chunk-000/file-001.parquet"), "file-001.parquet: is damaged or cut off"),
    "cut tasks": (cut("meta/tasks.parquet", 60), "tasks.parquet: is damaged or cut off"),
    "no data": (lambda p: [f.unlink() for f in p.glob("data/*/*")], r"data: holds no file \*/\*.parquet; was the data set loaded down whole"),
    "other columns": (lambda p: pq.write_table(pa.table({"x": [1]}), p / "data/chunk-000/file-001.parquet"), "file-001.parquet: has no column"),
    "other types": (lambda p: pq.write_table(pq.read_table(p / "data/chunk-000/file-001.parquet").set_column(0, "observation.tactile.palm", lists(FRAMES[4:].astype(int), pa.list_(pa.list_(pa.int16())))), p / "data/chunk-000/file-001.parquet"), r"file-001.parquet: column observation.tactile.palm: has int16 of shape \(3, 4\) a row, that of file-000.parquet float32"),
    "no index": (lambda p: pq.write_table(pq.read_table(p / "data/chunk-000/file-000.parquet").set_column(3, "episode_index", pa.array([0.5] * 4)), p / "data/chunk-000/file-000.parquet"), "episode_index: must be one whole number a row"),
    "ours": (lambda p: (p / "meta/varishold.json").write_text("{}"), "varishold.json: is damaged or cut off: 'columns'"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_data_sets_are_told_in_one_line(tmp_path: Path, case: str) -> None:
    path = data_set(tmp_path / "set", PALM, OF_PALM, cuts=(4,))
    spoil, message = BAD[case]
    spoil(path)
    with pytest.raises(FormatError, match=message) as error:
        read(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_what_is_odd_but_usable_is_told(tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", PALM, OF_PALM, tasks=("push",), total_frames=99)
    notes = read(path).notes
    assert "9 frames are there, info.json promises 99" in notes
    assert "tasks 1 have no name in meta/tasks.parquet" in notes
    assert read(path).presses.columns["label"].tolist() == ["push", "task 1", "push"]


def test_an_episode_in_two_places_is_told(tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", PALM, OF_PALM, cuts=(4,))
    first = path / "data/chunk-000/file-000.parquet"
    (path / "data/chunk-001").mkdir()
    (path / "data/chunk-001/file-000.parquet").write_bytes(first.read_bytes())
    recording = read(path)
    assert recording.presses.columns["episode"].tolist() == [0, 1, 2, 0]
    assert "episode 0 stands in two places, or more; each is a press" in recording.notes
