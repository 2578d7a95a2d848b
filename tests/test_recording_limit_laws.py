"""Readers at the edges of their limits, and the files that they hold open."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat
from tests.test_recording_rosbags import bag1, bag2

from varishold import FormatError, InputError
from varishold import open as open_recording
from varishold.recording import Pad, Recording, read, write
from varishold.recording.formats import mat5, numbers
from varishold.recording.mcap.container import Channel
from varishold.recording.mcap.understood import Understood

FRAMES = np.arange(5 * 3 * 4, dtype=np.uint16).reshape(5, 3, 4)


# Open files


def ours(path: Path) -> None:
    write(Recording({"pad": Pad(FRAMES)}), path)


def zarr_zip(path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    store = zarr.storage.ZipStore(str(path), mode="w")
    zarr.open_group(store, mode="w").create_array("pressure", data=FRAMES, chunks=(2, 3, 4))
    store.close()


def tiff(path: Path) -> None:
    from PIL import Image

    first, *others = (Image.fromarray(frame) for frame in FRAMES)
    first.save(path, save_all=True, append_images=others)


MADE: dict[str, Any] = {
    **{f"a.{ending}": ours for ending in ("npz", "mcap", "h5", "mat", "parquet")},
    "scipy.mat": lambda path: savemat(path, {"frames": FRAMES}),
    "a.csv": lambda path: np.savetxt(path, FRAMES.reshape(5, 12), delimiter=",", fmt="%d"),
    "a.zarr.zip": zarr_zip,
    "a.tif": tiff,
    "a.bag": bag1,
    "b": bag2,
}  # fmt: skip


def held_open(folder: Path) -> list[str]:
    """Return the files of a folder that this process has open."""
    found = []
    for number in os.listdir("/proc/self/fd"):
        try:
            target = os.readlink(f"/proc/self/fd/{number}")
        except OSError:
            continue
        if target.startswith(str(folder)):
            found.append(target)
    return found


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="the system does not tell which files are open")
@pytest.mark.parametrize("name", MADE)
def test_what_was_closed_is_not_held_open_though_somebody_keeps_it(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    MADE[name](path)
    assert held_open(tmp_path) == []
    shape = (3, 4) if name == "a.csv" else None
    opened = open_recording(path, shape=shape)
    with opened:
        assert sum(block.n_frames for block in opened.blocks(2)) == opened.n_frames > 0
    assert held_open(tmp_path) == []
    kept = read(path, shape=shape)
    assert held_open(tmp_path) == [] or isinstance(next(iter(kept.pads.values())).frames, np.memmap)


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="the system does not tell which files are open")
@pytest.mark.parametrize("name", [name for name in MADE if name != "b"])
@pytest.mark.parametrize("share", [0.3, 0.7, 0.97])
def test_what_is_refused_is_not_held_open_either(tmp_path: Path, name: str, share: float) -> None:
    path = tmp_path / name
    MADE[name](path)
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])
    error: BaseException | None = None
    try:
        kept = read(path, shape=(3, 4) if name == "a.csv" else None)
    except InputError as refused:
        # Its traceback keeps all that was at hand.
        error = refused
    else:
        assert kept.n_frames <= 5
    assert held_open(tmp_path) == []
    assert error is None or "\n" not in str(error)


# MATLAB


@pytest.mark.parametrize("packed", [False, True])
def test_so_many_variables_and_fields_are_read_and_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, packed: bool
) -> None:
    monkeypatch.setattr(mat5, "_MOST", 3)
    path = tmp_path / "a.mat"
    three = {"frames": FRAMES, "b": np.arange(2), "c": np.arange(2)}
    # The end is met by looking for one more.
    savemat(path, dict(list(three.items())[:2]), do_compression=packed)
    np.testing.assert_array_equal(read(path).pads["pad"].frames, FRAMES)
    savemat(path, three | {"d": np.arange(2)}, do_compression=packed)
    with pytest.raises(FormatError, match="holds more than 3 variables"):
        read(path)
    savemat(path, {"s": {"frames": FRAMES, "b": [1, 2], "c": [1, 2]}}, do_compression=packed)
    np.testing.assert_array_equal(next(iter(read(path).pads.values())).frames, FRAMES)
    savemat(path, {"s": {"frames": FRAMES, "b": [1, 2], "c": [1, 2], "d": [1, 2]}}, do_compression=packed)
    with pytest.raises(FormatError, match=r"a struct has \d+ letters of names"):
        read(path)


@pytest.mark.parametrize("depth", [1, 2, 3, 4, 5, 6])
def test_structs_are_looked_into_as_deep_packed_as_plain(tmp_path: Path, depth: int) -> None:
    inner: Any = FRAMES
    for level in range(depth):
        inner = {f"s{level}": inner}
    said = []
    for packed in (False, True):
        savemat(tmp_path / "a.mat", inner | {"beside": np.zeros(3)}, do_compression=packed)
        try:
            said.append(read(tmp_path / "a.mat").pads.keys())
        except FormatError as error:
            said.append(re.sub(r"^.*?: ", "", str(error)))
    assert said[0] == said[1]
    # A variable's fields, and those of these, four times.
    assert isinstance(said[0], str) == (depth > 5), said


# Numbers


def test_a_text_may_hold_so_many_bytes_of_numbers_and_not_a_row_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numbers, "LARGEST_BYTES", 10 * 12 * 8)
    rows = np.arange(11 * 12).reshape(11, 12)
    np.savetxt(tmp_path / "a.csv", rows[:10], delimiter=",", fmt="%d")
    assert read(tmp_path / "a.csv", shape=(3, 4)).n_frames == 10
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", fmt="%d")
    with pytest.raises(FormatError, match="has more than 960 bytes of numbers; store it as NPY"):
        read(tmp_path / "a.csv", shape=(3, 4))


# Messages


@pytest.mark.parametrize(
    ("number", "kept"),
    [(0, True), (127, True), (2**62, True), (2**63, False), (2**70, False), (-1, True)],
)
def test_a_message_s_number_is_kept_if_it_is_one_of_64_bits(number: int, kept: bool) -> None:
    channel = Channel("/skin", "skin/Frame", "json", "", "", {})
    messages = [json.dumps({"header": {"seq": given}, "data": [[1, 2], [3, 4]]}).encode() for given in (5, number)]
    (part,) = Understood(channel).read(messages)
    if kept:
        assert part.sequence is not None
        assert part.sequence.tolist() == [5, number]
    else:
        assert part.sequence is None
