"""LeRobot's own library against ours: it loads what is written here, and what it writes is read here, number by number.

The library brings torch, and so it is installed in an environment of its own. ``--keep`` takes one that is there.

    python -m hostile.lerobot_library [--venv FOLDER] [--keep]
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from varishold.recording import Pad, Recording, Signals, read, write

__all__ = ["main"]

_ROOT = Path(__file__).parents[1]
# In the environment: a data set is loaded and its frames are kept as they come; another is recorded frame by frame.
_LOAD = """
import sys
import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
held = LeRobotDataset("local/ours", root=sys.argv[1])
rows = [held[k] for k in range(len(held))]
names = [name for name in held.features if not name.startswith("index")]
found = {name.replace("/", "|"): np.stack([np.asarray(row[name]) for row in rows]) for name in names}
np.savez(sys.argv[2], task=np.array([row["task"] for row in rows]), fps=held.fps, n=held.num_episodes, **found)
"""
_RECORD = """
import sys
import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
given = np.load(sys.argv[1])
kinds = {name: given[name] for name in given.files if name != "episode"}
features = {
    name: {"dtype": each.dtype.name, "shape": each.shape[1:], "names": None} for name, each in kinds.items()
}
held = LeRobotDataset.create("local/theirs", 20, features, root=sys.argv[2], use_videos=False)
for episode in np.unique(given["episode"]):
    for k in np.flatnonzero(given["episode"] == episode):
        held.add_frame({**{name: each[k] for name, each in kinds.items()}, "task": f"press {episode % 2}"})
    held.save_episode()
held.finalize()
"""


def _ours(rng: np.random.Generator) -> Recording:
    """A recording with pads of every type of number, presses, labels and signals."""
    n = 60
    pads = {}
    for k, dtype in enumerate((np.uint8, np.int16, np.uint16, np.int32, np.int64, np.float32, np.float64)):
        frames = rng.random((n, 2 + k, 3)) if np.issubdtype(dtype, np.floating) else rng.integers(0, 99, (n, 2 + k, 3))
        pads[np.dtype(dtype).name] = Pad(frames.astype(dtype))
    press = np.repeat([-1, 0, 2, 1], n // 4)
    columns = {"label": np.array(["cone", "a cube, on edge", "cone"])}
    signals = {"joints": Signals(rng.random((n, 4)).astype(np.float32), ("a", "b", "c", "d"))}
    return Recording(pads, np.arange(n) / 50 + 3.5, "kPa", "hand", press=press, press_columns=columns, signals=signals)


def _run(python: Path, code: str, *arguments: Path) -> None:
    offline = {"HF_HUB_OFFLINE": "1", "HF_HOME": str(arguments[0].parent / "cache")}
    subprocess.run([python, "-c", code, *map(str, arguments)], check=True, env={**os.environ, **offline})


def _check(what: str, same: bool) -> None:
    print(f"{what}: {'the same' if same else 'NOT the same'}")
    if not same:
        raise SystemExit(1)


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--venv", type=Path, default=_ROOT / ".venv-lerobot")
    parser.add_argument("--keep", action="store_true", help="take the environment as it is")
    given = parser.parse_args()
    python = given.venv / "bin" / "python"
    if not given.keep:
        subprocess.run([sys.executable, "-m", "venv", "--clear", given.venv], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "lerobot>=0.4"], check=True)
    rng = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as folder:
        _written_here(Path(folder), python, rng)
        _written_there(Path(folder), python, rng)


def _written_here(folder: Path, python: Path, rng: np.random.Generator) -> None:
    recording = _ours(rng)
    write(recording, folder / "ours.lerobot")
    _run(python, _LOAD, folder / "ours.lerobot", folder / "loaded.npz")
    loaded = np.load(folder / "loaded.npz")
    for name, pad in recording.pads.items():
        there = loaded[f"observation.tactile.{name}"]
        # The library makes tensors of float32 of all floats.
        _check(f"written here, loaded there: {name}", np.array_equal(there, pad.frames.astype(there.dtype)))
    joints = loaded["observation.signals.joints"]
    _check("written here, loaded there: signals", np.array_equal(joints, recording.signals["joints"].values))
    tasks = np.repeat(["touch", "cone", "cone", "a cube, on edge"], recording.n_frames // 4)
    _check("written here, loaded there: tasks", bool((loaded["task"] == tasks).all()))
    _check("written here, loaded there: episodes and rate", (int(loaded["n"]), int(loaded["fps"])) == (4, 50))


def _written_there(folder: Path, python: Path, rng: np.random.Generator) -> None:
    episode = np.repeat([0, 1, 2], [5, 8, 3])
    frames = {
        "observation.tactile.palm": rng.random((16, 4, 5)).astype(np.float32),
        "observation.tactile.tip": rng.integers(0, 4000, (16, 3, 4)).astype(np.uint16),
        "observation.state": rng.random((16, 6)).astype(np.float32),
    }
    np.savez(folder / "given.npz", episode=episode, **frames)
    _run(python, _RECORD, folder / "given.npz", folder / "theirs")
    recording = read(folder / "theirs")
    for name in ("palm", "tip"):
        same = np.array_equal(recording.pads[name].frames, frames[f"observation.tactile.{name}"])
        _check(f"recorded there, read here: {name}", same)
    state = recording.signals["state"].values
    _check("recorded there, read here: signals", np.array_equal(state, frames["observation.state"]))
    labels = recording.presses.columns["label"].tolist()
    _check("recorded there, read here: tasks", labels == ["press 0", "press 1", "press 0"])
    assert recording.press is not None
    _check("recorded there, read here: episodes", recording.press.tolist() == episode.tolist())
    assert recording.time_s is not None
    _check("recorded there, read here: time", bool(np.allclose(recording.time_s, np.arange(16) / 20, atol=1e-6)))


if __name__ == "__main__":
    main()
