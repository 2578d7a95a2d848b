"""Print every figure: ``python -m benchmarks [NAME ...]`` runs all of them, or those named."""

from __future__ import annotations

import pkgutil
import sys
import time
from importlib import import_module

import benchmarks


def main(names: list[str]) -> int:
    """Run the benchmarks named, or all; return an exit status."""
    known = sorted(
        m.name for m in pkgutil.iter_modules(benchmarks.__path__) if not m.name.startswith("_") and not m.ispkg
    )
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"no benchmark called {unknown[0]!r}; known are {', '.join(known)}", file=sys.stderr)
        return 2
    status = 0
    for name in names or known:
        module = import_module(f"benchmarks.{name}")
        if not hasattr(module, "main"):
            continue
        print(f"\n== {name}: {(module.__doc__ or '').strip().splitlines()[0]}", flush=True)
        begun = time.monotonic()
        try:
            module.main()
        except SystemExit as end:
            # The others are still to be run.
            status = max(status, int(bool(end.code)))
        print(f"({time.monotonic() - begun:.0f} s)", flush=True)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
