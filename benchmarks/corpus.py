"""Corpora: frames a CPU second serially, on processes and on dask, a killed worker, a killed run, memory, and a plan.

Drawn recordings of 16 x 16 taxels, pressed half of the time. Serial, two processes and a dask cluster of two answer the
same corpus by turns, each the whole command in processes of its own, its start counted; of each the best round counts.

    python -m benchmarks.corpus [--recordings N] [--frames N] [--rounds N] [--large-gb G]
"""

from __future__ import annotations

import argparse
import hashlib
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from benchmarks._figures import figure
from varishold.corpus import AskTouch
from varishold.corpus.joining import join_parts
from varishold.recording import Pad, Recording, write

SEED, SIDE, WORKERS, MOST_MB = 71, 16, 2, 300
PROGRAM = (sys.executable, "-c", "from varishold.cli import main; main()")
WAYS = {
    "serial": ("--workers", "1"),
    "pool": ("--workers", str(WORKERS)),
    "dask": ("--cluster", "local", "--workers", str(WORKERS)),
}
# A process that answers a file, and the most memory that it took beyond what it had after it had answered a small one.
MEMORY = """
import sys
from varishold.corpus import AskTouch, run_corpus
path, small, output, frames = sys.argv[1:]
def memory(key):
    with open("/proc/self/status") as told:
        return next(int(line.split()[1]) for line in told if line.startswith(key)) / 1000
run_corpus([small], AskTouch(), output)
before = memory("VmRSS")
run_corpus([path], AskTouch(frames), output)
print(memory("VmHWM") - before)
"""


def pressed_frames(seed: int, n: int) -> np.ndarray:
    """Return frames of a skin that rests at 200 with noise, and is pressed in every second hundred."""
    rng = np.random.default_rng([SEED, seed])
    y, x = np.mgrid[:SIDE, :SIDE]
    frames = 200 + rng.normal(0, 2, (n, SIDE, SIDE))
    for begun in range(100, n, 200):
        row, col, radius, height = (*rng.uniform(5, 10, 2), rng.uniform(3, 5), rng.uniform(500, 3000))
        away = np.hypot(y - row, x - col) if rng.random() < 0.5 else np.maximum(abs(y - row), abs(x - col))
        form = [np.clip(1 - away / radius, 0, 1), 1.0 * (away < radius), np.clip(2 - 2 * away / radius, 0, 1)]
        course = np.sin(np.arange(100) / 100 * np.pi)[: n - begun]
        frames[begun : begun + 100] += height * course[:, None, None] * form[rng.integers(3)]
    return np.rint(frames).clip(0, 4095).astype(np.uint16)


def made_corpus(folder: Path, n_recordings: int, n_frames: int) -> list[str]:
    """Write recordings, MCAP and HDF5 by turns; return their names."""
    files = []
    for k in range(n_recordings):
        pad = Pad(pressed_frames(k, n_frames), pitch_m=(0.002, 0.002))
        files.append(str(folder / f"r{k:02d}.{('mcap', 'h5')[k % 2]}"))
        write(Recording({"pad": pad}, time_s=np.arange(n_frames) / 100, unit="kPa"), files[-1])
    return files


def command(files: list[str], table: Path, *how: str) -> list[str]:
    return [*PROGRAM, "touch", *files, "-o", str(table), *how]


def timed(files: list[str], table: Path, *how: str) -> tuple[float, float]:
    """Run the command; return CPU seconds of all its processes, and seconds by the clock."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command(files, table, *how), check=True, capture_output=True)
    took, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, took


def digest(table: Path) -> str:
    return hashlib.sha256(table.read_bytes()).hexdigest()


def parts(table: Path) -> list[Path]:
    return list(table.with_name(f".{table.name}.parts").glob("*-*.parquet"))


def children(pid: int) -> list[int]:
    """Return the processes that a process has started, those that have worked most first."""
    found = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            found[int(stat.parent.name)] = int(fields[11]) + int(fields[12])
    return sorted(found, key=lambda child: -found[child])


def killed(files: list[str], table: Path, many: int, *, run: bool) -> int:
    """Begin with two processes and, when so many parts are there, kill a worker, or the run; return the parts then."""
    process = subprocess.Popen(command(files, table, *WAYS["pool"]), stdout=subprocess.DEVNULL)
    while len(parts(table)) < many and process.poll() is None:
        time.sleep(0.02)
    os.kill(process.pid if run else children(process.pid)[0], signal.SIGKILL)
    kept = len(parts(table))
    status = process.wait()
    if not run and status != 0:
        raise SystemExit("a run whose worker was killed did not end well")
    return kept


def most_memory(folder: Path, gigabytes: float, frames: str) -> float:
    """Return the memory in MB that a recording of so many bytes takes, as NPY in pieces of the same presses."""
    small, large = folder / "small.npy", folder / "large.npy"
    block = pressed_frames(0, 4096)
    np.save(small, block)
    n = int(gigabytes * 1e9 / block[0].nbytes)
    out = np.lib.format.open_memmap(large, "w+", block.dtype, (n, SIDE, SIDE))
    for start in range(0, n, len(block)):
        out[start : start + len(block)] = block[: n - start]
    out.flush()
    del out
    call = [sys.executable, "-c", MEMORY, str(large), str(small), str(folder / "m.parquet"), frames]
    done = subprocess.run(call, check=True, capture_output=True, text=True)
    large.unlink()
    return float(done.stdout)


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--recordings", type=int, default=24)
    parser.add_argument("--frames", type=int, default=6000, help="of each recording")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--large-gb", type=float, default=0.5, help="bytes of the large recording")
    given = parser.parse_args(list(argv))
    n_frames = given.recordings * given.frames
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = made_corpus(folder, given.recordings, given.frames)
        tables = {way: folder / f"{way}.parquet" for way in WAYS}
        cpu: dict[str, list[float]] = {way: [] for way in WAYS}
        wall: dict[str, list[float]] = {way: [] for way in WAYS}
        for _ in range(given.rounds):
            for way, how in WAYS.items():
                used, took = timed(files, tables[way], *how)
                cpu[way].append(used)
                wall[way].append(took)
        same = {way: digest(table) for way, table in tables.items()}
        print(
            f"{given.recordings} recordings of {given.frames} frames, {SIDE} x {SIDE}; load {os.getloadavg()[0]:.1f}:"
        )
        for way in WAYS:
            rate = figure(f"{way}: frames a CPU second", n_frames / min(cpu[way]), ".0f", "frames/s")
            clock = figure(f"{way}: frames a second by the clock", n_frames / min(wall[way]), ".0f", "frames/s")
            share, gain = min(cpu["serial"]) / min(cpu[way]), min(wall["serial"]) / min(wall[way])
            said = figure(f"{way}: of serial, a CPU second", 100 * share, ".0f", "%", bar=">= 90")
            faster = figure(f"{way}: of serial, by the clock", gain, ".2f", "times", bar=">= 1.6")
            print(f"  {way:<8}{rate} ({said}), {clock}" + ("" if way == "serial" else f" ({faster})"))
        n_parts = given.recordings * -(-given.frames // 4096)
        for what, run in (("worker", False), ("run", True)):
            table = folder / f"killed_{what}.parquet"
            kept = killed(files, table, n_parts // 3, run=run)
            if run:
                figure("killed run: parts kept", kept, ".0f", "parts")
                print(f"  killed after {kept} of {n_parts} parts, run again")
                subprocess.run(command(files, table, *WAYS["pool"]), check=True, capture_output=True)
            same[f"killed {what}"] = digest(table)
        n_alike = sum(each == same["serial"] for each in same.values())
        print(f"  tables of the same bytes: {figure('same bytes', n_alike, '.0f', 'tables', bar=f'>= {len(same)}')} of "
              f"{len(same)} ({', '.join(same)})")  # fmt: skip
        plan(folder, files, tables["serial"], n_frames / min(cpu["serial"]), min(cpu["serial"]) / min(cpu["pool"]))
        for gigabytes, frames in ((0.02, "all"), (given.large_gb, "peak")):
            mb = figure(f"memory, {frames} of {gigabytes:g} GB", most_memory(folder, gigabytes, frames), ".0f", "MB",
                        bar=f"<= {MOST_MB}")  # fmt: skip
            asked = "every frame" if frames == "all" else "looked through, one frame"
            print(f"  most memory beyond imports and a small recording: {mb} ({gigabytes:g} GB, {asked})")


def plan(folder: Path, files: list[str], table: Path, rate: float, share: float) -> None:
    """Print what a thousand million frames take, by what was measured on two cores."""
    kept = folder / "kept.parquet"
    subprocess.run(command(files[:4], kept, *WAYS["pool"], "--keep-parts"), check=True, capture_output=True)
    named = [("r", part) for part in sorted(parts(kept))]
    begun = time.process_time()
    joined = join_parts(folder / "joined.parquet", named, AskTouch().columns, title="touch")
    rows_a_second = joined / (time.process_time() - begun)
    n_rows = pq.read_metadata(table).num_rows
    n_all = 1e9
    hours = n_all / rate / 3600
    rows = n_all * n_rows / sum(_frames_of(files))
    bytes_a_row = table.stat().st_size / n_rows
    said = {
        "hours": figure("plan: CPU hours", hours, ".0f", "h"),
        "minutes": figure("plan: minutes on 64 cores", 60 * hours / share / 64, ".0f", "min"),
        "tasks": figure("plan: tasks", n_all / 4096, ".0f"),
        "bytes": figure("bytes a contact", bytes_a_row, ".0f", "B"),
        "table": figure("plan: table", rows * bytes_a_row / 1e9, ".0f", "GB"),
        "join": figure("join: rows a CPU second", rows_a_second, ".0f", "rows/s"),
        "joining": figure("plan: minutes of joining", rows / rows_a_second / 60, ".0f", "min"),
    }
    print("a plan for 10^9 frames at this density, counted from two cores:")
    print(f"  {said['hours']} of one core; on 64 cores {said['minutes']}, if each is as fast; {said['tasks']} tasks")
    print(f"  {said['bytes']} a contact, {said['table']} of table, as much again of parts meanwhile")
    print(f"  beside them one thread joins {said['join']}: {said['joining']}")


def _frames_of(files: list[str]) -> list[int]:
    from varishold.recording import open as opened

    found = []
    for file in files:
        with opened(file) as recording:
            found.append(recording.n_frames)
    return found


if __name__ == "__main__":
    main(sys.argv[1:])
