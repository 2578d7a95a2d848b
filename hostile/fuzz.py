"""Mutated files over all readers: each is answered or refused in one line, within five seconds of work, and never
by damage.

Every reader's files come equally often. Case k is drawn from the generator of (seed, k), so that
``--first K --number 1`` makes it again. With ``--log FILE`` every stretch of cases that was done is a line of that
file, and the same call goes on where the last one ended.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import re
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from hostile.mutations import mutated
from hostile.specimens import Specimen, specimens
from varishold.errors import VarisholdError

__all__ = ["Done", "main", "run", "try_case"]

# A reader hangs that works for so long, or waits for so long; on a busy machine work takes longer than its own time.
_HANG_S, _WAITS_S = 5, 60
_MOST_MEMORY = 8 << 30
# Cases that a process does at a stretch, and how often it is asked whether it lives.
_STRETCH, _ASKED_S = 500, 0.5
# A disk takes longer to make a file than a reader to read it.
_MEMORY = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None


class _Hung(BaseException):
    pass


@dataclass
class Done:
    """What came of cases: how many ended how, of which file they were made, and every fault as [case, kind, what]."""

    ends: Counter[str] = field(default_factory=Counter)
    files: Counter[str] = field(default_factory=Counter)
    faults: list[list[Any]] = field(default_factory=list)

    def add(self, other: Done) -> None:
        self.ends += other.ends
        self.files += other.files
        self.faults += other.faults


def try_case(seed: int, case: int, known: Sequence[Specimen], folder: Path) -> tuple[str, str, str]:
    """Read one mutated file; return its name, "answered", "refused" or a fault, and what there is to say about it."""
    rng = np.random.default_rng([seed, case])
    specimen = known[int(rng.integers(len(known)))]
    content = mutated(rng, specimen.content, [each.content for each in known])
    path = folder / specimen.name
    path.write_bytes(content)
    return specimen.name, *_read(specimen, path, content)


def _read(specimen: Specimen, path: Path, content: bytes) -> tuple[str, str]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            specimen.read(path)
    except VarisholdError as error:
        told = str(error)
        return ("badly told", repr(told)) if "\n" in told or str(path.parent) not in told else ("refused", "")
    except _Hung:
        return "hung", ""
    except BaseException:
        return "traceback", traceback.format_exc()
    if specimen.content.startswith(b"PK") and content.startswith(b"PK") and _damaged(path):
        return "answered from a damaged archive", ""
    return "answered", ""


def _damaged(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.testzip() is not None
    except Exception:
        return True


def _hang(*_: object) -> None:
    raise _Hung


def _work(seed: int, first: int, last: int, known: Sequence[Specimen], at: Any, results: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGPROF, _hang)
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
    done = Done()
    with tempfile.TemporaryDirectory(dir=_MEMORY) as folder:
        for case in range(first, last):
            at.value = case
            name, kind, what = "", "hung", ""
            signal.setitimer(signal.ITIMER_PROF, _HANG_S)
            with suppress(_Hung):
                name, kind, what = try_case(seed, case, known, Path(folder))
            signal.setitimer(signal.ITIMER_PROF, 0)
            done.files[name] += 1
            done.ends[kind] += 1
            if kind not in ("answered", "refused"):
                done.faults.append([case, kind, f"{name}: {what}"])
    results.send(done)


def run(
    stretches: Sequence[tuple[int, int]],
    *,
    seed: int = 0,
    processes: int = 1,
    only: str = "",
    say: Callable[[int, int, Done], None] = lambda first, last, done: None,
) -> Done:
    """Try the cases from first to last - 1 of every stretch; `say` is told of each that is done.

    `only` is a pattern of the names of the files to be spoilt, as in ``h5$``.
    """
    known = [each for each in specimens() if re.search(only, each.name)]
    context = multiprocessing.get_context("fork")
    todo = list(stretches)[::-1]
    total = Done()
    running: dict[Any, tuple[Any, Any, tuple[int, int], list[float]]] = {}
    while todo or running:
        while todo and len(running) < processes:
            begin, end = todo.pop()
            at = context.Value("q", begin, lock=False)
            mine, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_work, args=(seed, begin, end, known, at, theirs))
            process.start()
            theirs.close()
            running[process] = (mine, at, (begin, end), [begin, time.monotonic()])
        for process, (mine, at, (begin, end), seen) in list(running.items()):
            if mine.poll(_ASKED_S / processes):
                try:
                    done = mine.recv()
                except EOFError:
                    # It died, as by a fault of memory: what stands before and after is done by others.
                    case = at.value
                    done = Done(Counter(died=1), Counter(), [[case, "died", f"exit status {process.exitcode}"]])
                    todo += [(a, b) for a, b in ((case + 1, end), (begin, case)) if a < b]
                    begin, end = case, case + 1
                process.join()
                total.add(done)
                del running[process]
                say(begin, end, done)
            elif at.value != seen[0]:
                seen[:] = [at.value, time.monotonic()]
            elif time.monotonic() - seen[1] > _WAITS_S:
                # It waits for something, or does not even hear its alarm: compiled code that never ends.
                process.kill()
    return total


def _stretches(first: int, number: int, logged: Sequence[dict[str, Any]]) -> list[tuple[int, int]]:
    """Return the stretches of so many cases that the log does not hold."""
    done = {case for line in logged for case in range(line["first"], line["last"])}
    left = [case for case in range(first, first + number) if case not in done]
    breaks = [0, *(k for k in range(1, len(left)) if left[k] != left[k - 1] + 1), len(left)]
    return [(left[k], left[min(k + _STRETCH, b) - 1] + 1) for a, b in pairwise(breaks) for k in range(a, b, _STRETCH)]


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--number", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", default="", metavar="PATTERN", help="spoil the files whose names match")
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--log", type=Path, help="what was done, a line a stretch; stretches in it are not done again")
    given = parser.parse_args()
    begun = time.monotonic()
    total, fresh = Done(), 0
    logged = (
        [json.loads(line) for line in given.log.read_text().splitlines()] if given.log and given.log.exists() else []
    )
    logged = [line for line in logged if line["seed"] == given.seed]
    for line in logged:
        total.add(Done(Counter(line["ends"]), Counter(line["files"]), line["faults"]))

    def say(first: int, last: int, done: Done) -> None:
        nonlocal fresh
        total.add(done)
        fresh += last - first
        for case, kind, what in done.faults:
            print(f"case {case}: {kind}: {what}", flush=True)
        if given.log:
            with given.log.open("a") as log:
                log.write(json.dumps({"seed": given.seed, "first": first, "last": last, **vars(done)}) + "\n")
        rate = fresh / (time.monotonic() - begun)
        print(f"\r{total.ends.total()} files, {rate:.0f} a second, {len(total.faults)} faults", end="", file=sys.stderr)

    stretches = _stretches(given.first, given.number, logged)
    run(stretches, seed=given.seed, processes=given.processes, only=given.only, say=say)
    print(file=sys.stderr)
    n = total.ends.total()
    print(f"{n} files: " + ", ".join(f"{count} {kind}" for kind, count in sorted(total.ends.items())))
    print("of these, made from " + ", ".join(f"{name} {count / n:.1%}" for name, count in sorted(total.files.items())))
    sys.exit(bool(total.faults))


if __name__ == "__main__":
    main()
