"""Print every figure: ``python -m benchmarks [--json] [NAME ... [OPTION ...]]`` runs all of them, or those named.

With ``--json`` each benchmark is one JSON object a line: its name and title, its figures (name, value, unit, bar), its
exit status and how long it took. Options are those of one benchmark, as in ``perceive_size --seed 3``; ``NAME --help``
lists them.
"""

from __future__ import annotations

import contextlib
import inspect
import io
import json
import pkgutil
import sys
import time
from collections.abc import Sequence
from importlib import import_module
from types import ModuleType

import benchmarks
from benchmarks._figures import taken


def main(words: Sequence[str]) -> int:
    """Run the benchmarks named, or all; return an exit status."""
    known = sorted(
        m.name for m in pkgutil.iter_modules(benchmarks.__path__) if not m.name.startswith("_") and not m.ispkg
    )
    as_json = "--json" in words
    words = [word for word in words if word != "--json"]
    n_names = next((i for i, word in enumerate(words) if word.startswith("-")), len(words))
    names, options = words[:n_names], words[n_names:]
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"no benchmark called {unknown[0]!r}; known are {', '.join(known)}", file=sys.stderr)
        return 2
    if options and len(names) != 1:
        print(f"{options[0]}: options are those of one benchmark: name it before them", file=sys.stderr)
        return 2
    status = 0
    for name in names or known:
        module = import_module(f"benchmarks.{name}")
        if not hasattr(module, "main"):
            continue
        title = (module.__doc__ or "").strip().splitlines()[0]
        begun = time.monotonic()
        if as_json:
            with contextlib.redirect_stdout(io.StringIO()):
                failed = _status(module, options)
            told = {"benchmark": name, "title": title, "figures": taken(), "status": failed}
            print(json.dumps({**told, "seconds": round(time.monotonic() - begun, 1)}), flush=True)
        else:
            print(f"\n== {name}: {title}", flush=True)
            failed = _status(module, options)
            taken()
            print(f"({time.monotonic() - begun:.0f} s)", flush=True)
        status = max(status, failed)
    return status


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
