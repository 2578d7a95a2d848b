"""Print every figure: ``python -m benchmarks [--json] [NAME ...]`` runs all of them, or those named.

With ``--json`` each benchmark is one JSON object a line: its name and title, the lines that it printed, its exit
status and how long it took.
"""

from __future__ import annotations

import contextlib
import io
import json
import pkgutil
import sys
import time
from importlib import import_module
from types import ModuleType

import benchmarks


def main(names: list[str]) -> int:
    """Run the benchmarks named, or all; return an exit status."""
    known = sorted(
        m.name for m in pkgutil.iter_modules(benchmarks.__path__) if not m.name.startswith("_") and not m.ispkg
    )
    as_json = "--json" in names
    names = [name for name in names if name != "--json"]
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"no benchmark called {unknown[0]!r}; known are {', '.join(known)}", file=sys.stderr)
        return 2
    status = 0
    for name in names or known:
        module = import_module(f"benchmarks.{name}")
        if not hasattr(module, "main"):
            continue
        title = (module.__doc__ or "").strip().splitlines()[0]
        begun = time.monotonic()
        if as_json:
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                failed = _failed(module)
            seconds = round(time.monotonic() - begun, 1)
            told = {"benchmark": name, "title": title, "lines": printed.getvalue().splitlines()}
            print(json.dumps({**told, "status": int(failed), "seconds": seconds}), flush=True)
        else:
            print(f"\n== {name}: {title}", flush=True)
            failed = _failed(module)
            print(f"({time.monotonic() - begun:.0f} s)", flush=True)
        status = max(status, int(failed))
    return status


def _failed(module: ModuleType) -> bool:
    """Run a benchmark; tell whether it ended with a failure. The others are still to be run."""
    try:
        module.main()
    except SystemExit as end:
        return bool(end.code)
    return False


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
