"""Every command that writes, killed at random moments: no file lost or half-written, no process left, no litter.

Each kill hits the command's first process alone, as the kernel does when memory runs out: every other one at any moment
of the command, the rest while a file is being written. Before it stand the whole files of an earlier run; afterwards
there must be those or the new ones, whole, and soon no process of the command.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from hostile.meshes import meshes
from varishold.circuit.interchange import read_netlist
from varishold.errors import VarisholdError
from varishold.files import open_archive
from varishold.grasp import read_model
from varishold.learning import read_model as read_learned
from varishold.perceive import read_library
from varishold.recording import GraspTable, Pad, Recording, read, read_grasp_table, write, write_grasp_table
from varishold.sensor import read_sensor

__all__ = ["main", "run"]

_PROGRAM = (sys.executable, "-c", "from varishold.cli import main; main()")
# Time that a process whose parent was killed has to notice it, seconds.
_NOTICE_S = 10.0


# A file that is being written is there for some milliseconds; this is how long a kill may wait after it was seen.
_WRITING_S = 0.02


@dataclass(frozen=True)
class _Command:
    """Words of a command, and what tells that each file which it writes is whole."""

    words: Sequence[str]
    outputs: Mapping[str, Callable[[Path], object]]


def _archive(path: Path) -> None:
    with open_archive(path):
        pass


def _ends(ending: bytes) -> Callable[[Path], None]:
    def check(path: Path) -> None:
        if not path.read_bytes().rstrip(b"\n").endswith(ending):
            raise VarisholdError(f"{path}: is cut off")

    return check


_page, _picture = _ends(b"</html>"), _ends(b"IEND\xaeB`\x82")


def _source(path: Path) -> None:
    if not path.read_bytes().endswith(b"\n"):
        raise VarisholdError(f"{path}: is cut off")


def _commands() -> tuple[_Command, ...]:
    words: dict[str, dict[str, Callable[[Path], object]]] = {
        "touch in.npz --report page.html": {"page.html": _page},
        "grasp fit in.csv --label object -o model.json": {"model.json": read_model},
        "grasp export kept.json --to c -o c": {"c/kept.c": _source, "c/kept.h": _source},
        "grasp export kept.json --to verilog -o v": {"v/kept.v": _source},
        "grasp export kept.json --to json -o j": {"j/kept.json": read_netlist},
        "skin press sphere --size-m 0.01 -o press.npz --picture press.png": {
            "press.npz": _archive,
            "press.png": _picture,
        },
        "skin collect --count 64 --processes 2 --shape 12x12 -o presses.npz": {"presses.npz": _archive},
        "convert in.npz other.h5": {"other.h5": read},
        "convert in.npz other.mcap": {"other.mcap": read},
        "measure in.npz -o measures.parquet": {"measures.parquet": _ends(b"PAR1")},
        "learn in.pressed.npz --label thing -o things.npz": {"things.npz": read_learned},
        "touch export --to c --shape 8x8 -o firmware": {"firmware/varishold.h": _source},
        "sensor calibrate even.npz --kind even -o mat.toml --report mat.html": {
            "mat.toml": read_sensor,
            "mat.html": _page,
        },
    }
    hand: dict[str, dict[str, Callable[[Path], object]]] = {
        "hand collect --objects cylinder:0.09 --grasps 2 --processes 2 -o grasps.csv": {"grasps.csv": read_grasp_table},
        "hand grasp cylinder --size-m 0.09 --place-known --pads pads.npz": {"pads.npz": _archive},
        "perceive sphere --size-m 0.07 --most-touches 1 --report seen.html": {"seen.html": _page},
        "objects taxels noise=.02 -o poor.npz": {"poor.npz": read_library},
    }
    # It takes a name once: each time it is called otherwise.
    things = {"objects add in.ply --library things.of.mine.npz --examples 1": {"things.of.mine.npz": read_library}}
    every = words | (hand if find_spec("mujoco") else {}) | (things if find_spec("coacd") else {})
    return tuple(_Command(text.split(), outputs) for text, outputs in every.items())


def _inputs(folder: Path) -> None:
    rng = np.random.default_rng(0)
    write(
        Recording({"pad": Pad(rng.random((3, 12, 12)) + np.hanning(12)[:, None] * 9, pitch_m=1e-3)}), folder / "in.npz"
    )
    presses = Recording(
        {"pad": Pad(rng.random((60, 8, 8)) * np.tile([1, 9], 30)[:, None, None])},
        press=np.repeat(np.arange(12), 5),
        press_columns={"thing": np.tile(["ball", "cube"], 6)},
    )
    write(presses, folder / "in.pressed.npz")
    load = np.repeat([0.0, 9.0], 8)[:, None, None] * rng.normal(1.0, 0.1, (12, 12))
    even = load + 0.01 * rng.normal(size=load.shape)
    write(Recording({"pad": Pad(even, pitch_m=1e-3)}), folder / "even.npz")
    (folder / "in.ply").write_bytes(meshes()["packed.ply"])
    switches = {f"switch.{k}": rng.random(40) < 0.5 for k in range(8)}
    write_grasp_table(GraspTable({"object": np.repeat(["cone", "cube"], 20), **switches}), folder / "in.csv")
    _whole(["grasp", "fit", "in.csv", "--label", "object", "-o", "kept.json"], folder)


def _whole(words: Sequence[str], folder: Path) -> float:
    """Run a command to its end; return how long it took."""
    begun = time.monotonic()
    done = subprocess.run([*_PROGRAM, *words], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)}: {done.stderr}")
    return time.monotonic() - begun


def _left(group: int) -> list[int]:
    """Processes of a group that still live."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, _, own = (entry / "stat").read_text().rpartition(")")[2].split()[:3]
            except OSError:
                continue
            if int(own) == group and state != "Z":
                found.append(int(entry.name))
    return found


def _parts(folder: Path) -> set[Path]:
    """Files that are not complete yet."""
    return set(folder.rglob(".varishold-*.part"))


def _kill_once(command: _Command, folder: Path, after_s: float, *, writing: bool) -> str | None:
    """Kill a command after some time, which may begin when it writes; return what is wrong then."""
    before = {path: path.read_bytes() for path in folder.glob("in.*")}
    # What is left of an earlier kill is no sign that this one writes.
    left_before = _parts(folder)
    process = subprocess.Popen(
        [*_PROGRAM, *command.words],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        process_group=0,
    )
    while writing and process.poll() is None and _parts(folder) <= left_before:
        time.sleep(0.001)
    time.sleep(after_s)
    process.kill()
    process.wait()
    until = time.monotonic() + _NOTICE_S
    while (left := _left(process.pid)) and time.monotonic() < until:
        time.sleep(0.05)
    for pid in left:
        os.kill(pid, 9)
    if left:
        return f"{len(left)} processes are left"
    if any(path.read_bytes() != content for path, content in before.items()):
        return "an input is changed"
    for output, check in command.outputs.items():
        if not (folder / output).exists():
            return f"its earlier output {output} is lost"
        try:
            check(folder / output)
        except (VarisholdError, OSError, ValueError) as error:
            return f"its output is not whole: {error}"
    return None


def _again(words: Sequence[str], k: int) -> list[str]:
    """Return the words with which a command has something to do for the k-th time."""
    # A collection that is complete has nothing to do: it begins again with another seed.
    more = ["--seed", str(k), "--force"] if words[1] == "collect" else []
    return [*words, *more, *(["--name", f"thing {k}"] if words[1] == "add" else [])]


def run(number: int, *, seed: int = 0, only: Sequence[str] | None = None) -> list[str]:
    """Kill commands `number` times, each in its turn; return what was wrong."""
    rng = np.random.default_rng(seed)
    faults = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _inputs(folder)
        commands = [each for each in _commands() if only is None or each.words[0] in only]
        takes = [_whole(each.words, folder) for each in commands]
        begun = time.monotonic()
        for k in range(number):
            turn, at = divmod(k, len(commands))
            command = commands[at]
            command = _Command(_again(command.words, k), command.outputs)
            writing = turn % 2 == 1
            wrong = _kill_once(
                command, folder, float(rng.uniform(0, _WRITING_S if writing else takes[at])), writing=writing
            )
            if wrong is not None:
                faults.append(f"kill {k}: {' '.join(command.words)}: {wrong}")
                print(faults[-1], flush=True)
            rate = (time.monotonic() - begun) / (k + 1)
            print(f"\r{k + 1} kills, {rate:.1f} s each, {len(faults)} faults", end="", file=sys.stderr)
        print(file=sys.stderr)
        for command in commands:
            _whole([*_again(command.words, number), "--force"], folder)
        litter = [path.name for path in folder.rglob(".*")]
        if litter:
            faults.append(f"after a whole run of each command there are left {', '.join(litter)}")
    return faults


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--number", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    faults = run(given.number, seed=given.seed)
    print("\n".join(faults[-1:]))
    print(f"{given.number} kills: {len(faults)} faults")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
