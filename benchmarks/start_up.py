"""How long the program takes to start, and how much is installed for it.

Wall-clock seconds of whole processes, medians, and how much of them is spent on a processor: other work on the machine
makes them longer. Bytecode is kept in a folder of its own. The first call after ``make`` finds that of what the library
requires, which pip writes, and none of the library itself; installed by what writes none, neither; Python's own is
there always. What is installed is what the files of the library and of all that it
requires take, no extras among them, with their bytecode.

    python -m benchmarks.start_up
"""

from __future__ import annotations

import marshal
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import varishold
from benchmarks._figures import figure

ROOT = Path(varishold.__file__).parent
PROJECT = ROOT.parent.parent
FIRST, LATER = 5, 9
PROGRAM = ("-c", "from varishold.cli import main; main()")
TOUCH = (*PROGRAM, "touch", str(PROJECT / "examples" / "surfaces.npz"))
#: Bars: seconds of the first call and of later ones, megabytes.
MOST_FIRST_S, MOST_LATER_S, MOST_MB = 1.0, 0.6, 110


class Interpreter:
    """Python, with its bytecode in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._env = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        self._env |= {"PYTHONPYCACHEPREFIX": str(folder), "PYTHONPATH": str(ROOT.parent)}

    def seconds(self, *words: str) -> tuple[float, float]:
        """Run it; return how long that took, and how much of it on a processor."""
        begun, before = time.perf_counter(), os.times()
        subprocess.run([sys.executable, *words], env=self._env, check=True, stdout=subprocess.DEVNULL)
        took, after = time.perf_counter() - begun, os.times()
        used = after.children_user + after.children_system - before.children_user - before.children_system
        return took, used

    def forget(self, *, required: bool) -> None:
        """Take away the bytecode of the library, and of what it requires where that is asked for."""
        others = self._folder.rglob("site-packages") if required else ()
        for written in (self._folder.joinpath(*ROOT.parts[1:]), *others):
            shutil.rmtree(written)


def required(lines: Iterable[str]) -> dict[str, list[Path]]:
    """Return the files of each distribution that is required, and of what that requires itself."""
    found: dict[str, list[Path]] = {}
    waiting = [*lines]
    while waiting:
        requirement = Requirement(waiting.pop())
        wanted = requirement.marker is None or requirement.marker.evaluate({"extra": ""})
        name = canonicalize_name(requirement.name)
        if wanted and name not in found:
            held = distribution(name)
            found[name] = [Path(str(file.locate())) for file in held.files or ()]
            waiting += held.requires or ()
    return found


def own_files() -> Iterator[Path]:
    """Yield the files of the library as they are installed."""
    for folder in (ROOT, PROJECT / "native", PROJECT / "examples"):
        yield from (path for path in folder.rglob("*") if path.is_file())


def megabytes(files: Iterable[Path]) -> float:
    """Return what files take, and the bytecode of those that have any."""
    held = 0
    for path in files:
        if path.suffix == ".pyc" or not path.is_file():
            continue
        held += path.stat().st_size
        if path.suffix == ".py":
            # A header of 16 bytes stands before the code.
            held += 16 + len(marshal.dumps(compile(path.read_bytes(), str(path), "exec", dont_inherit=True)))
    return held / 1e6


def tell(name: str, runs: Sequence[tuple[float, float]], bar: str) -> None:
    """Print the medians of how long some runs took."""
    took, used = (statistics.median(each) for each in zip(*runs, strict=True))
    on_processor = figure(f"{name}, on a processor", used, ".2f", "s of CPU")
    print(f"{name:<30}{figure(name, took, '.2f', 's', bar=bar)}, {on_processor}")


def main() -> None:
    with tempfile.TemporaryDirectory(prefix="varishold-") as folder:
        python = Interpreter(Path(folder))
        python.seconds(*TOUCH)
        for name, all_of_it, bar in (("first", False, f"<= {MOST_FIRST_S}"), ("no bytecode", True, "")):
            first = []
            for _ in range(FIRST):
                python.forget(required=all_of_it)
                first.append(python.seconds(*TOUCH))
            tell(f"varishold touch, {name}", first, bar)
        calls = {
            "varishold touch, later": (TOUCH, f"<= {MOST_LATER_S}"),
            "varishold --help": ((*PROGRAM, "--help"), ""),
            "import varishold": (("-c", "import varishold"), ""),
            "import numpy": (("-c", "import numpy"), ""),
            "python itself": (("-c", ""), ""),
        }
        for name, (words, bar) in calls.items():
            tell(name, [python.seconds(*words) for _ in range(LATER)], bar)
    asked = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    sizes = {"varishold": megabytes(own_files())}
    sizes |= {name: megabytes(files) for name, files in required(asked).items()}
    print(f"{'installed':<30}{figure('installed', sum(sizes.values()), '.1f', 'MB', bar=f'<= {MOST_MB}')}, of it")
    for name, size in sorted(sizes.items(), key=lambda item: -item[1]):
        print(f"  {name:<28}{figure(f'installed of {name}', size, '.1f', 'MB')}")


if __name__ == "__main__":
    main()
