"""What every file of a kind of sources offers, as ``KIND``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from varishold.live.address import Address
from varishold.live.source import Source

__all__ = ["SourceKind"]


@dataclass(frozen=True)
class SourceKind:
    """One way in which readings come.

    Parameters
    ----------
    title : str
        What a person calls it.
    example : str
        An address of it.
    make : callable
        Takes the address and returns the source, not yet opened; raises InputError where the address says what
        cannot be.
    found : callable, optional
        Returns (address, words) of what is in reach now, within a second; never raises but MissingExtraError.
    needs : tuple of str
        The modules that have to be installed for it, beyond what this package always has.
    """

    title: str
    example: str
    make: Callable[[Address], Source]
    found: Callable[[], list[tuple[str, str]]] | None = None
    needs: tuple[str, ...] = ()
