"""What could be watched now: the kinds of sources, what is missing for each, and what is in reach."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec

from varishold._lazy import missing_extra
from varishold.errors import VarisholdError
from varishold.live.sources import KINDS, source_kind

__all__ = ["ReachableKind", "reachable_kinds"]


@dataclass(frozen=True)
class ReachableKind:
    """A kind of sources, and what of it is in reach.

    Parameters
    ----------
    names : tuple of str
        What stands before the colon.
    title, example : str
    missing : str
        What has to be installed for it, or keeps it from being looked for, in one line; empty where nothing does.
    found : tuple of (str, str)
        Address and words of each that is in reach.
    """

    names: tuple[str, ...]
    title: str
    example: str
    missing: str
    found: tuple[tuple[str, str], ...]


def reachable_kinds() -> list[ReachableKind]:
    """Return every kind of sources in the order of the registry; all are looked for at once."""
    named: dict[str, list[str]] = {}
    for name, file in KINDS.items():
        named.setdefault(file, []).append(name)
    with ThreadPoolExecutor(len(named)) as pool:
        return list(pool.map(_reached, (tuple(names) for names in named.values())))


def _reached(names: tuple[str, ...]) -> ReachableKind:
    kind = source_kind(names[0])
    missing = next((module for module in kind.needs if find_spec(module) is None), None)
    if missing is not None:
        words = str(missing_extra(ModuleNotFoundError(f"No module named {missing!r}", name=missing)))
        return ReachableKind(names, kind.title, kind.example, words, ())
    try:
        found = () if kind.found is None else tuple(kind.found())
    except (VarisholdError, ModuleNotFoundError) as error:
        told = missing_extra(error) if isinstance(error, ModuleNotFoundError) else error
        return ReachableKind(names, kind.title, kind.example, str(told), ())
    return ReachableKind(names, kind.title, kind.example, "", found)
