"""What benchmarks printed before, by version and class of machine: kept in `benchmarks/history/`, compared with now."""

from __future__ import annotations

import json
import os
import platform
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from varishold.files import atomic_write, read_json

__all__ = ["FOLDER", "History", "changes", "machine_class", "untimed", "version"]

FOLDER = Path(__file__).with_name("history")
#: Seconds of all benchmarks of a quick run together.
QUICK_S = 120.0
# Changes that are told, as shares: times are noisy.
_TOLD, _TOLD_TIME = 0.02, 0.2
_TIMES = ("s", "ms", "us", "us CPU", "ns")
# Units of speed besides, and how those of rates end.
_SPEEDS, _RATES = ("times", "s of CPU"), ("/s", "CPU s")


def machine_class() -> str:
    """Return what figures of speed depend on, in a word."""
    return f"{platform.machine().lower()}-{os.cpu_count()}"


def version() -> str:
    """Return the version of the checkout."""
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text("utf-8"))
    return str(project["project"]["version"])


class History:
    """The newest results of every benchmark, of this version and class of machine or of those before.

    Parameters
    ----------
    folder : Path, optional
        Default: that of the checkout.
    machine : str, optional
        Default: the class of this one.
    """

    def __init__(self, folder: Path | None = None, machine: str | None = None) -> None:
        folder = FOLDER if folder is None else folder
        machine = machine_class() if machine is None else machine
        self._path = folder / f"{version()}-{machine}.json"
        # Of other versions the newest stands last.
        others = sorted(folder.glob(f"*-{machine}.json"), key=_numbers)
        self._before: dict[str, Any] = {}
        for path in [*(each for each in others if each != self._path), self._path]:
            if path.is_file():
                self._before |= read_json(path)

    def before(self, benchmark: str) -> dict[str, Any] | None:
        """Return what a benchmark printed last, with its seconds; None where nothing is kept."""
        kept: dict[str, Any] | None = self._before.get(benchmark)
        return kept

    def keep(self, told: Mapping[str, Any]) -> None:
        """Keep what a benchmark printed now."""
        kept = read_json(self._path) if self._path.is_file() else {}
        kept[told["benchmark"]] = {key: told[key] for key in ("figures", "status", "seconds")}
        self._path.parent.mkdir(exist_ok=True)
        with atomic_write(self._path, "w") as file:
            file.write(json.dumps(dict(sorted(kept.items())), indent=1) + "\n")

    def quick(self) -> list[str]:
        """Return the benchmarks that take no longer than `QUICK_S` together, the shortest first."""
        chosen, spent = [], 0.0
        for name, kept in sorted(self._before.items(), key=lambda item: item[1]["seconds"]):
            spent += kept["seconds"]
            if spent > QUICK_S:
                break
            chosen.append(name)
        return chosen


def untimed(figures: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the figures that are not of speed."""
    return [each for each in figures if each["unit"] not in _TIMES + _SPEEDS and not each["unit"].endswith(_RATES)]


def _numbers(path: Path) -> list[int]:
    return [int(part) for part in re.findall(r"\d+", path.name.partition("-")[0])]


def changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line for each figure that is another than before: whether it got worse, where that can be said.

    Parameters
    ----------
    before, now : mapping
        With the key "figures", as `benchmarks._figures.taken` gives them.
    """
    old = {each["name"]: each for each in before["figures"]}
    for each in now["figures"]:
        was, value = old.get(each["name"], {}).get("value"), each["value"]
        if was is None or value is None or was == value:
            continue
        is_time = each["unit"] in _TIMES
        if abs(value - was) <= (_TOLD_TIME if is_time else _TOLD) * max(abs(was), abs(value)):
            continue
        better_up = _better_up(each["bar"], is_time=is_time)
        word = "other" if better_up is None else "better" if (value > was) == better_up else "WORSE"
        unit = f" {each['unit']}" if each["unit"] else ""
        yield f"{word}: {each['name']}: {was:.4g} -> {value:.4g}{unit}"


def _better_up(bar: str, *, is_time: bool) -> bool | None:
    """Return whether more is better; None where nobody says."""
    if bar.startswith(">"):
        return True
    if bar.startswith("<") or is_time:
        return False
    return None
