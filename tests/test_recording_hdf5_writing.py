"""HDF5 on a disk that is full, and under signals: an error in one line, and nothing is left."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from varishold.recording import Pad, Recording, read, write
from varishold.recording.formats.hdf5_writing import write_hdf5

pytest.importorskip("h5py")
resource = pytest.importorskip("resource")

# A limit of the size of files is a disk that is full, without one; a crash of HDF5 would end the process.
_LIMITED = """
import resource, sys
from varishold.recording import read
from varishold.recording.conversion import convert

recording = read(sys.argv[1])
for limit in map(int, sys.argv[3:]):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        convert(recording, sys.argv[2])
        print("written")
    except Exception as error:
        print(type(error).__name__, error)
"""


def _recording(n_pads: int, n_frames: int) -> Recording:
    rng = np.random.default_rng(0)
    return Recording(
        {f"pad{k}": Pad(rng.integers(0, 200, (n_frames, 16, 16)).astype(np.uint16)) for k in range(n_pads)}
    )


# Of many pads HDF5 reads again what it has written before.
@pytest.mark.parametrize("ending", ["h5", "mat"])
@pytest.mark.parametrize(("n_pads", "n_frames"), [(1, 1500), (200, 2)])
def test_a_full_disk_is_one_line_and_nothing_is_left(tmp_path: Path, ending: str, n_pads: int, n_frames: int) -> None:
    source, target = tmp_path / "a.npz", tmp_path / f"b.{ending}"
    write(_recording(n_pads, n_frames), source)
    limits = [1, 600, 5_000, 60_000, 300_000]
    words = [sys.executable, "-c", _LIMITED, str(source), str(target), *map(str, limits)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [f"InputError {target}: cannot write here: file too large"] * len(limits)
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="takes a timer")
def test_what_interrupts_is_no_failing_write(tmp_path: Path) -> None:
    target = tmp_path / "b.h5"
    write(_recording(1, 2), target)
    before = target.read_bytes()
    frames = np.random.default_rng(0).integers(0, 200, (2000, 16, 16)).astype(np.uint16)

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    def endlessly() -> None:
        while True:
            write(Recording({"pad": Pad(frames)}), tmp_path / "c.h5")

    heard = signal.signal(signal.SIGALRM, interrupt)
    try:
        for part in range(1, 9):
            signal.setitimer(signal.ITIMER_REAL, 0.004 * part)
            with pytest.raises(KeyboardInterrupt):
                endlessly()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, heard)
    assert target.read_bytes() == before
    assert {path.name for path in tmp_path.iterdir()} <= {"b.h5", "c.h5"}


def test_what_fails_while_it_is_filled_is_told_as_it_is(tmp_path: Path) -> None:
    def fill(file: object, pieces: object) -> None:
        raise ValueError("no frames")

    with pytest.raises(ValueError, match="no frames"):
        write_hdf5(tmp_path / "a.h5", fill)
    assert not [*tmp_path.iterdir()]


def test_many_pads_come_back(tmp_path: Path) -> None:
    for name in ("a.h5", "a.mat"):
        write(_recording(200, 2), tmp_path / name)
        assert len(read(tmp_path / name).pads) == 200
