"""Mutated files over all readers: each is answered or refused in one line, within five seconds, and never by damage.

Case k is drawn from the generator of (seed, k), so that ``--first K --number 1`` makes it again.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hostile.mutations import mutated
from hostile.specimens import Specimen, specimens
from varishold.errors import VarisholdError

__all__ = ["main", "run", "try_case"]

_HANG_S = 5
_MOST_MEMORY = 8 << 30
# Cases that a process does at a stretch, and how often it is asked whether it lives.
_STRETCH, _ASKED_S = 500, 0.5


class _Hung(BaseException):
    pass


def try_case(seed: int, case: int, known: Sequence[Specimen], folder: Path) -> tuple[str, str]:
    """Read one mutated file; return "answered", "refused" or a fault, and what there is to say about it."""
    rng = np.random.default_rng([seed, case])
    specimen = known[int(rng.integers(len(known)))]
    content = mutated(rng, specimen.content, [each.content for each in known])
    path = folder / specimen.name
    path.write_bytes(content)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            specimen.read(path)
    except VarisholdError as error:
        told = str(error)
        if "\n" in told or str(path) not in told:
            return "badly told", f"{specimen.name}: {told!r}"
        return "refused", ""
    except _Hung:
        return "hung", specimen.name
    except BaseException:
        return "traceback", f"{specimen.name}: {traceback.format_exc()}"
    if specimen.content.startswith(b"PK") and content.startswith(b"PK") and _damaged(path):
        return "answered from a damaged archive", specimen.name
    return "answered", ""


def _damaged(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.testzip() is not None
    except Exception:
        return True


def _hang(*_: object) -> None:
    raise _Hung


def _work(seed: int, first: int, last: int, at: Any, results: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGALRM, _hang)
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
    count: Counter[str] = Counter()
    faults: list[tuple[int, str, str]] = []
    with tempfile.TemporaryDirectory() as folder:
        for case in range(first, last):
            at.value = case
            signal.setitimer(signal.ITIMER_REAL, _HANG_S)
            try:
                kind, what = try_case(seed, case, _KNOWN, Path(folder))
            except _Hung:
                kind, what = "hung", ""
            signal.setitimer(signal.ITIMER_REAL, 0)
            count[kind] += 1
            if kind not in ("answered", "refused"):
                faults.append((case, kind, what))
    results.send((count, faults))


_KNOWN: tuple[Specimen, ...] = ()


def run(
    number: int, *, seed: int = 0, first: int = 0, processes: int = 1, say: Any = None
) -> tuple[Counter[str], list[tuple[int, str, str]]]:
    """Try `number` cases; return how many ended how, and every fault as (case, kind, what)."""
    global _KNOWN
    _KNOWN = _KNOWN or specimens()
    context = multiprocessing.get_context("fork")
    todo = [(k, min(k + _STRETCH, first + number)) for k in range(first, first + number, _STRETCH)][::-1]
    total: Counter[str] = Counter()
    faults: list[tuple[int, str, str]] = []
    running: dict[Any, tuple[Any, Any, int, list[float]]] = {}
    while todo or running:
        while todo and len(running) < processes:
            begin, end = todo.pop()
            at = context.Value("q", begin, lock=False)
            mine, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_work, args=(seed, begin, end, at, theirs))
            process.start()
            theirs.close()
            running[process] = (mine, at, end, [begin, time.monotonic()])
        for process, (mine, at, end, seen) in list(running.items()):
            if mine.poll(_ASKED_S / processes):
                try:
                    count, found = mine.recv()
                except EOFError:
                    # It died, as by a fault of memory; the rest of its stretch is done by another.
                    count, found = Counter({"died": 1}), [(at.value, "died", f"exit status {process.exitcode}")]
                    todo.append((at.value + 1, end)) if at.value + 1 < end else None
                process.join()
                total += count
                faults += found
                del running[process]
                if say is not None:
                    say(total, faults)
            elif at.value != seen[0]:
                seen[:] = [at.value, time.monotonic()]
            elif time.monotonic() - seen[1] > 4 * _HANG_S:
                # It does not even hear its alarm: compiled code that never ends.
                process.kill()
    return total, faults


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--number", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    given = parser.parse_args()
    begun = time.monotonic()

    told = 0

    def say(total: Counter[str], faults: list[tuple[int, str, str]]) -> None:
        nonlocal told
        for case, kind, what in faults[told:]:
            print(f"case {case}: {kind}: {what}", flush=True)
        told = len(faults)
        rate = sum(total.values()) / (time.monotonic() - begun)
        print(f"\r{sum(total.values())} files, {rate:.0f} a second, {len(faults)} faults", end="", file=sys.stderr)

    total, faults = run(given.number, seed=given.seed, first=given.first, processes=given.processes, say=say)
    print(file=sys.stderr)
    print(f"{sum(total.values())} files: " + ", ".join(f"{n} {kind}" for kind, n in sorted(total.items())))
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
