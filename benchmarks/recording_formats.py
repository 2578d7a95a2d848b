"""Formats: frames that are read a second, and the memory that a long file takes when it is taken in blocks.

Each file is of 16 x 16 uint16, made once in each length, and read by a process of its own: CPU time of one thread, and
the most memory that it took beyond what it had when all was imported.

    python -m benchmarks.recording_formats [--frames N] [--large-gb G]
"""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
import zarr
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from benchmarks._figures import figure
from varishold.recording import Pad, Recording, write

SEED, SIDE, MOST_MB, FEWEST = 41, 16, 300, 45_000
# What other libraries write in the longer length too. Pictures of a folder.
LONG = ("TIFF of pages", "Zarr 2", "Zarr 3")
PICTURES = 10_000
WRITTEN = {"NPY": "npy", "MCAP": "mcap", "HDF5": "h5", "MATLAB 7.3": "mat", "Parquet": "parquet", "LeRobot": "lerobot"}
# How fast each must be; MCAP faster than the others, a folder as fast as its files are opened.
GOALS = {"MCAP": 60_000, "folder of PNG": 0}
READ = """
import sys, time
from varishold import open, read
import varishold.recording.formats.mcap_stored
path, other, how = sys.argv[1:]
def memory(key):
    with __builtins__.open("/proc/self/status") as told:
        return next(int(line.split()[1]) for line in told if line.startswith(key)) / 1000
# What is imported when the first file is read counts as imported.
with open(other) as opened:
    next(opened.blocks(64))
read(other)
before = memory("VmRSS")
begun, n = time.process_time(), 0
if how == "read":
    n = read(path).n_frames
else:
    with open(path) as opened:
        for block in opened.blocks():
            n += block.n_frames
print(n / (time.process_time() - begun), memory("VmHWM") - before)
"""


def frames_of(folder: Path, n: int) -> Path:
    """Write frames of a resting skin that is pressed now and then, as NPY, in bounded memory; return the file."""
    rng = np.random.default_rng(SEED)
    block = np.rint(200 + rng.normal(0, 2, (4096, SIDE, SIDE)))
    block[1000:1400, 4:9, 5:11] += rng.integers(0, 3000, (400, 1, 1))
    out = np.lib.format.open_memmap(folder / "a.npy", "w+", np.uint16, (n, SIDE, SIDE))
    for start in range(0, n, len(block)):
        out[start : start + len(block)] = block[: n - start]
    out.flush()
    return folder / "a.npy"


def bag_of_ros_1(path: Path, frames: np.ndarray) -> None:
    """Write a bag of images."""
    store, kind = get_typestore(Stores.ROS1_NOETIC), "sensor_msgs/msg/Image"
    types = store.types
    with Writer1(path) as writer:
        skin = writer.add_connection("/skin", kind, typestore=store)
        for k, frame in enumerate(frames):
            stamp = types["builtin_interfaces/msg/Time"](*divmod(k * 10**7, 10**9))
            header = types["std_msgs/msg/Header"](k, stamp, "skin")
            image = types[kind](header, SIDE, SIDE, "16UC1", 0, 2 * SIDE, frame.view(np.uint8).ravel())
            writer.write(skin, k * 10**7, store.serialize_ros1(image, kind))


def bag_of_ros_2(path: Path, frames: np.ndarray) -> None:
    """Write a folder with a database of images."""
    store, kind = get_typestore(Stores.LATEST), "sensor_msgs/msg/Image"
    types = store.types
    with Writer2(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        skin = writer.add_connection("/skin", kind, typestore=store)
        for k, frame in enumerate(frames):
            header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](*divmod(k * 10**7, 10**9)), "s")
            image = types[kind](header, SIDE, SIDE, "16UC1", 0, 2 * SIDE, frame.view(np.uint8).ravel())
            writer.write(skin, k * 10**7, store.serialize_cdr(image, kind))


def tiff_of_pages(path: Path, frames: np.ndarray) -> None:
    """Write a TIFF of a page a frame, each with its entries behind its numbers."""
    entries = ((256, 3, SIDE), (257, 3, SIDE), (258, 3, 16), (259, 3, 1), (262, 3, 1), (273, 4, 0), (279, 4, 0))
    size = 2 + 12 * len(entries) + 4
    with path.open("wb") as file:
        at = 8 + 2 * SIDE * SIDE
        file.write(struct.pack("<2sHI", b"II", 42, at))
        for k, frame in enumerate(frames):
            places = {273: at - frame.nbytes, 279: frame.nbytes}
            body = b"".join(struct.pack("<HHII", tag, kind, 1, places.get(tag, n)) for tag, kind, n in entries)
            after = at + size + frame.nbytes
            file.write(frame.tobytes() + struct.pack("<H", len(entries)) + body)
            file.write(struct.pack("<I", after if k + 1 < len(frames) else 0))
            at = after


def zarr_of(version: Literal[2, 3]) -> Callable[[Path, np.ndarray], None]:
    """Return what writes a Zarr data set as its library does unasked, a thousand frames a piece."""

    def write_it(path: Path, frames: np.ndarray) -> None:
        root = zarr.open_group(str(path), mode="w", zarr_format=version)
        made = root.create_array("pressure", shape=frames.shape, chunks=(1000, SIDE, SIDE), dtype=frames.dtype)
        for start in range(0, len(frames), 100_000):
            made[start : start + 100_000] = frames[start : start + 100_000]

    return write_it


def folder_of_pictures(path: Path, frames: np.ndarray) -> None:
    """Write a folder of a PNG file a frame."""
    path.mkdir()
    for k, frame in enumerate(frames[:PICTURES]):
        cv2.imwrite(str(path / f"{k}.png"), frame)


def measured(path: Path, other: Path, how: str) -> tuple[float, float]:
    """Return the frames a CPU second and the memory in MB of a process that reads a file."""
    call = [sys.executable, "-c", READ, str(path), str(other), how]
    done = subprocess.run(call, capture_output=True, text=True, check=True)
    rate, most = map(float, done.stdout.split())
    return rate, most


def files_of(folder: Path, n: int) -> dict[str, Path]:
    """Write so many frames in every format; return the files."""
    folder.mkdir()
    source = frames_of(folder, n)
    frames = np.load(source, mmap_mode="r")
    recording = Recording({"pad": Pad(frames, pitch_m=0.002)}, time_s=np.arange(n) / 100, unit="kPa")
    files = {"NPY": source}
    for title, ending in WRITTEN.items():
        if title != "NPY":
            files[title] = folder / f"a.{ending}"
            write(recording, files[title])
    return files


def main(argv: Sequence[str] = ()) -> None:
    """Print how fast every format is read, and in how much memory."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--frames", type=int, default=100_000, help="frames of the shorter file")
    parser.add_argument("--large-gb", type=float, default=0.5, help="bytes of the longer file's frames")
    given = parser.parse_args(list(argv))
    large = int(given.large_gb * 1e9 / (2 * SIDE * SIDE))
    with tempfile.TemporaryDirectory() as name:
        few = files_of(Path(name, "few"), 256)
        short = files_of(Path(name, "short"), given.frames)
        frames = np.load(short["NPY"], mmap_mode="r")
        others = {"bag of ROS 1": bag_of_ros_1, "bag of ROS 2": bag_of_ros_2}
        others |= {"TIFF of pages": tiff_of_pages, "folder of PNG": folder_of_pictures}
        others |= {"Zarr 2": zarr_of(2), "Zarr 3": zarr_of(3)}
        for title, make in others.items():
            few[title], short[title] = Path(name, "few", title), Path(name, "short", title)
            make(few[title], frames[:256])
            make(short[title], frames)
        for title, path in short.items():
            goal = GOALS.get(title, FEWEST)
            bar = f">= {goal}" if goal else ""
            rates = {how: max(measured(path, few[title], how)[0] for _ in range(3)) for how in ("read", "blocks")}
            read = figure(f"{title}: read", rates["read"], ".0f", "frames/s", bar=bar)
            print(f"{title}: {read}, {figure(f'{title}: in blocks', rates['blocks'], '.0f', 'frames/s', bar=bar)}")
        long = files_of(Path(name, "long"), large)
        frames = np.load(long["NPY"], mmap_mode="r")
        for title in LONG:
            long[title] = Path(name, "long", title)
            others[title](long[title], frames)
        for title, path in long.items():
            memory = [measured(each, few[title], "blocks")[1] for each in (short[title], path)]
            said = [
                figure(f"{title}: memory of {n} frames in blocks", mb, ".0f", "MB", bar=f"<= {MOST_MB}")
                for n, mb in zip((given.frames, large), memory, strict=True)
            ]
            size = sum(each.stat().st_size for each in (path, *path.rglob("*"))) >> 20
            print(f"{title}: {said[0]} for {given.frames} frames, {said[1]} for {large}, {size} MiB")


if __name__ == "__main__":
    main(sys.argv[1:])
