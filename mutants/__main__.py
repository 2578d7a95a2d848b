"""``python -m mutants --room ROOM [--number N] [--seed S]``: make changes, say which the room's own tests catch."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from pathlib import Path

for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from mutants import rooms  # noqa: E402
from mutants.judge import Room, Verdict  # noqa: E402
from mutants.tree import copied  # noqa: E402

_GOAL = 0.85


def main() -> int:
    """Judge; return 1 where a room's tests catch less than 85 %."""
    root = Path(__file__).resolve().parents[1]
    known = rooms.rooms(root)
    parser = argparse.ArgumentParser(prog="python -m mutants", description=__doc__)
    parser.add_argument("--room", action="append", choices=[*known, "all"], required=True, help="may be repeated")
    parser.add_argument("--number", type=int, default=25, help="changes a room")
    parser.add_argument("--seed", type=int, default=0, help="which changes")
    parser.add_argument("--file", default="", help="only in files with this in their path")
    parser.add_argument("--slipped", action="store_true", help="print only what slipped through, and the table")
    parser.add_argument("--out", type=Path, default=root / "out" / "mutants", help="where results are kept")
    told = parser.parse_args()
    out = told.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    # Whoever ends this run ends the tests that it started.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    table = []
    for name in known if "all" in told.room else told.room:
        room = Room(name, copied(root, out / f"tree-{name}"), out)
        found = []
        for verdict in room.judge(told.number, told.seed, file=told.file):
            found.append(verdict)
            if not told.slipped or (verdict.caught_by is None and verdict.reason is None):
                print(f"{verdict.seconds:6.1f} s  {verdict}", flush=True)
        table.append((name, found))
    print(f"\nseed {told.seed}\n{'room':<12} {'changes':>8} {'caught':>8} {'same':>8} {'share':>8}")
    for name, found in table:
        same = sum(verdict.reason is not None for verdict in found)
        print(f"{name:<12} {len(found):>8} {_caught(found):>8} {same:>8} {_share(found):>8.0%}")
    return int(any(_share(found) < _GOAL for _, found in table))


def _caught(found: list[Verdict]) -> int:
    return sum(verdict.caught_by is not None for verdict in found)


def _share(found: list[Verdict]) -> float:
    counted = sum(verdict.reason is None for verdict in found)
    return _caught(found) / counted if counted else 1.0


if __name__ == "__main__":
    sys.exit(main())
