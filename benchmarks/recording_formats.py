"""Formats: frames that are read a second, and the memory that a long file takes when it is taken in blocks.

Each file is of 16 x 16 uint16, made once in each length, and read by a process of its own: CPU time of one thread, and
the most memory that it took beyond what it had when all was imported. The longer files are made, read and removed one
after the other; `--side 64` gives them 64 x 64 taxels, for no TIFF of more than a million pages is read.

    python -m benchmarks.recording_formats [--frames N] [--large-gb G] [--side N] [--only FORMAT ...]
"""

from __future__ import annotations

import argparse
import shutil
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
# Of a folder.
PICTURES = 10_000
WRITTEN = {"MCAP": "mcap", "HDF5": "h5", "MATLAB 7.3": "mat", "Parquet": "parquet", "LeRobot": "lerobot"}
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


def frames_of(folder: Path, n: int, side: int = SIDE) -> np.ndarray:
    """Write frames of a resting skin that is pressed now and then, as NPY, in bounded memory; return them mapped."""
    folder.mkdir(exist_ok=True)
    rng = np.random.default_rng(SEED)
    block = np.rint(200 + rng.normal(0, 2, (4096, side, side)))
    block[1000:1400, 4:9, 5:11] += rng.integers(0, 3000, (400, 1, 1))
    out = np.lib.format.open_memmap(folder / "a.npy", "w+", np.uint16, (n, side, side))
    for start in range(0, n, len(block)):
        out[start : start + len(block)] = block[: n - start]
    out.flush()
    return np.load(folder / "a.npy", mmap_mode="r")


def bag_of_ros_1(path: Path, frames: np.ndarray) -> None:
    """Write a bag of images."""
    store, kind = get_typestore(Stores.ROS1_NOETIC), "sensor_msgs/msg/Image"
    types = store.types
    with Writer1(path) as writer:
        skin = writer.add_connection("/skin", kind, typestore=store)
        for k, frame in enumerate(frames):
            stamp = types["builtin_interfaces/msg/Time"](*divmod(k * 10**7, 10**9))
            header = types["std_msgs/msg/Header"](k, stamp, "skin")
            image = types[kind](header, *frame.shape, "16UC1", 0, frame.strides[0], frame.view(np.uint8).ravel())
            writer.write(skin, k * 10**7, store.serialize_ros1(image, kind))


def bag_of_ros_2(path: Path, frames: np.ndarray) -> None:
    """Write a folder with a database of images."""
    store, kind = get_typestore(Stores.LATEST), "sensor_msgs/msg/Image"
    types = store.types
    with Writer2(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        skin = writer.add_connection("/skin", kind, typestore=store)
        for k, frame in enumerate(frames):
            header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](*divmod(k * 10**7, 10**9)), "s")
            image = types[kind](header, *frame.shape, "16UC1", 0, frame.strides[0], frame.view(np.uint8).ravel())
            writer.write(skin, k * 10**7, store.serialize_cdr(image, kind))


def tiff_of_pages(path: Path, frames: np.ndarray) -> None:
    """Write a TIFF of a page a frame, each with its entries behind its numbers; a big one where it must be."""
    rows, cols = frames.shape[1:]
    entries = ((256, 3, cols), (257, 3, rows), (258, 3, 16), (259, 3, 1), (262, 3, 1), (273, 4, 0), (279, 4, 0))
    big = frames.nbytes > 3 << 30
    head, count, entry, after = ("<2sHHHQ", "<Q", "<HHQQ", "<Q") if big else ("<2sHI", "<H", "<HHII", "<I")
    begins = (b"II", 43, 8, 0) if big else (b"II", 42)
    size = struct.calcsize(count) + len(entries) * struct.calcsize(entry) + struct.calcsize(after)
    with path.open("wb") as file:
        at = struct.calcsize(head) + frames[0].nbytes
        file.write(struct.pack(head, *begins, at))
        for k, frame in enumerate(frames):
            places = {273: at - frame.nbytes, 279: frame.nbytes}
            body = b"".join(struct.pack(entry, tag, kind, 1, places.get(tag, n)) for tag, kind, n in entries)
            file.write(frame.tobytes() + struct.pack(count, len(entries)) + body)
            at += size + frame.nbytes
            file.write(struct.pack(after, at if k + 1 < len(frames) else 0))


def zarr_of(version: Literal[2, 3]) -> Callable[[Path, np.ndarray], None]:
    """Return what writes a Zarr data set as its library does unasked, a thousand frames a piece."""

    def write_it(path: Path, frames: np.ndarray) -> None:
        root = zarr.open_group(str(path), mode="w", zarr_format=version)
        made = root.create_array("pressure", shape=frames.shape, chunks=(1000, *frames.shape[1:]), dtype=frames.dtype)
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


def npy(path: Path, frames: np.ndarray) -> None:
    """Write NPY."""
    with path.open("wb") as file:
        np.save(file, frames)


def written(ending: str) -> Callable[[Path, np.ndarray], None]:
    """Return what writes a recording as we do."""

    def write_it(path: Path, frames: np.ndarray) -> None:
        times_s = np.arange(len(frames)) / 100
        write(Recording({"pad": Pad(frames, pitch_m=0.002)}, time_s=times_s, unit="kPa"), path.with_name(f"a.{ending}"))
        path.with_name(f"a.{ending}").rename(path)

    return write_it


MAKERS: dict[str, Callable[[Path, np.ndarray], None]] = {
    "NPY": npy,
    **{title: written(ending) for title, ending in WRITTEN.items()},
    "bag of ROS 1": bag_of_ros_1,
    "bag of ROS 2": bag_of_ros_2,
    "TIFF of pages": tiff_of_pages,
    "folder of PNG": folder_of_pictures,
    "Zarr 2": zarr_of(2),
    "Zarr 3": zarr_of(3),
}


def main(argv: Sequence[str] = ()) -> None:
    """Print how fast every format is read, and in how much memory."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--frames", type=int, default=100_000, help="frames of the shorter file")
    parser.add_argument("--large-gb", type=float, default=0.5, help="bytes of the longer file's frames")
    parser.add_argument("--side", type=int, default=SIDE, help="taxels a side of the longer file")
    parser.add_argument("--only", choices=list(MAKERS), action="append", help="only this format; may be repeated")
    given = parser.parse_args(list(argv))
    with tempfile.TemporaryDirectory() as name:
        few, short = Path(name, "few"), Path(name, "short")
        frames = frames_of(Path(name, "frames"), given.frames)
        long = frames_of(Path(name, "more"), int(given.large_gb * 1e9 / (2 * given.side**2)), given.side)
        for folder in (few, short):
            folder.mkdir()
        for title in given.only or MAKERS:
            make = MAKERS[title]
            make(few / title, frames[:256])
            make(short / title, frames)
            show_speed(title, short / title, few / title)
            if title != "folder of PNG":
                memory = [measured(short / title, few / title, "blocks")[1]]
                make(few / "long", long)
                memory.append(measured(few / "long", few / title, "blocks")[1])
                size = sum(each.stat().st_size for each in (few / "long", *(few / "long").rglob("*"))) >> 20
                said = [
                    figure(f"{title}: memory of {n} frames in blocks", mb, ".0f", "MB", bar=f"<= {MOST_MB}")
                    for n, mb in zip((len(frames), len(long)), memory, strict=True)
                ]
                print(f"    {said[0]} for {len(frames)} frames, {said[1]} for {len(long)}, {size} MiB", flush=True)
            for made in (short / title, few / "long"):
                if made.is_dir():
                    shutil.rmtree(made)
                else:
                    made.unlink(missing_ok=True)


def show_speed(title: str, path: Path, other: Path) -> None:
    """Print how many frames a second are read, whole and in blocks."""
    goal = GOALS.get(title, FEWEST)
    bar = f">= {goal}" if goal else ""
    rates = {how: max(measured(path, other, how)[0] for _ in range(3)) for how in ("read", "blocks")}
    read = figure(f"{title}: read", rates["read"], ".0f", "frames/s", bar=bar)
    print(f"{title}: {read}, {figure(f'{title}: in blocks', rates['blocks'], '.0f', 'frames/s', bar=bar)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
