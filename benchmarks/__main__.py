"""Print every figure: ``python -m benchmarks [FLAGS] [NAME ... [OPTION ...]]`` runs all of them, or those named.

With ``--json`` each benchmark is one JSON object a line: its name and title, its figures (name, value, unit, bar), its
exit status and how long it took. Options are those of one benchmark, as in ``perceive_size --seed 3``; ``NAME --help``
lists them.

With ``--compare`` each figure that is another than last time on such a machine is told, and the status is 1 where one
got worse; with ``--record`` the new ones are kept too, in ``benchmarks/history``; with ``--busy`` none of speed among
them, for the machine does other things too. ``--quick`` runs those that took no more than two minutes together.
"""

from __future__ import annotations

import contextlib
import inspect
import io
import json
import pkgutil
import sys
import time
from collections.abc import Mapping, Sequence
from importlib import import_module
from types import ModuleType
from typing import Any

import benchmarks
from benchmarks._figures import taken
from benchmarks._history import History, changes, untimed

_FLAGS = ("--json", "--record", "--compare", "--quick", "--busy")


def main(words: Sequence[str]) -> int:
    """Run the benchmarks named, or all; return an exit status."""
    known = sorted(
        m.name for m in pkgutil.iter_modules(benchmarks.__path__) if not m.name.startswith("_") and not m.ispkg
    )
    flags = {word for word in words if word in _FLAGS}
    words = [word for word in words if word not in _FLAGS]
    history = History() if flags & {"--record", "--compare", "--quick"} else None
    n_names = next((i for i, word in enumerate(words) if word.startswith("-")), len(words))
    names, options = words[:n_names], words[n_names:]
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"no benchmark called {unknown[0]!r}; known are {', '.join(known)}", file=sys.stderr)
        return 2
    if options and len(names) != 1:
        print(f"{options[0]}: options are those of one benchmark: name it before them", file=sys.stderr)
        return 2
    if history is not None and options:
        print(f"{options[0]}: what is kept is of no options", file=sys.stderr)
        return 2
    if history is not None and "--quick" in flags and not names:
        names = history.quick()
        if not names:
            print("nothing is kept of such a machine yet: run with --record", file=sys.stderr)
            return 2
    status = 0
    for name in names or known:
        module = import_module(f"benchmarks.{name}")
        if not hasattr(module, "main"):
            continue
        title = (module.__doc__ or "").strip().splitlines()[0]
        begun = time.monotonic()
        as_json = "--json" in flags
        if not as_json:
            print(f"\n== {name}: {title}", flush=True)
        with contextlib.redirect_stdout(io.StringIO()) if as_json else contextlib.nullcontext():
            failed = _status(module, options)
        seconds = round(time.monotonic() - begun, 1)
        figures = untimed(taken()) if "--busy" in flags else taken()
        told = {"benchmark": name, "title": title, "figures": figures, "status": failed, "seconds": seconds}
        print(json.dumps(told) if as_json else f"({seconds:.0f} s)", flush=True)
        if history is not None:
            failed = max(failed, _compared(history, told, keep="--record" in flags))
        status = max(status, failed)
    return status


def _compared(history: History, told: Mapping[str, Any], *, keep: bool) -> int:
    """Tell what is another than last time, and keep what is now; return 1 where something got worse."""
    before = history.before(told["benchmark"])
    lines = [] if before is None else list(changes(before, told))
    print(*(f"  {line}" for line in lines), sep="\n", end="\n" if lines else "", file=sys.stderr, flush=True)
    # What ended badly is no figure to compare with.
    if keep and not told["status"] and told["figures"]:
        history.keep(told)
    return int(any(line.startswith("WORSE") for line in lines))


def _status(module: ModuleType, options: Sequence[str]) -> int:
    """Run a benchmark; return its exit status. The others are still to be run."""
    takes_options = bool(inspect.signature(module.main).parameters)
    if options and not takes_options:
        print(f"{module.__name__.removeprefix('benchmarks.')} takes no options", file=sys.stderr)
        return 2
    try:
        if takes_options:
            module.main(options)
        else:
            module.main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
