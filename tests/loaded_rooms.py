"""Rooms that are loaded as a whole: a module that is loaded later would keep what a test puts in another's stead."""

from __future__ import annotations

from contextlib import suppress
from importlib import import_module
from pkgutil import walk_packages

__all__ = ["load"]


def load(*rooms: str) -> None:
    """Load every module of some rooms that can be loaded here."""
    for room in rooms:
        package = import_module(f"varishold.{room}")
        for found in walk_packages(package.__path__, f"{package.__name__}."):
            with suppress(ImportError):
                import_module(found.name)
