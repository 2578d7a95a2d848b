"""A source: whatever sends readings, one by one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from varishold.live.sample import PadLayout, Sample

__all__ = ["Source", "damage_of", "damaged_of", "overrun_of"]


class Source(Protocol):
    """Whatever sends readings; one file of `varishold.live.sources` a kind.

    One thread opens, reads and closes it. Nobody else touches it. It may count as `damaged` how often something came
    that could not be used, say as `damage` what was wrong with it last, and count as `overrun` what came faster than it
    was read and is lost.
    """

    @property
    def address(self) -> str:
        """Where it is, as a person wrote it."""
        ...

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pads that are known so far; a source that tells its pads with its readings may know none at first."""
        ...

    def open(self) -> None:
        """Connect, anew where it was connected before.

        Raises
        ------
        LostSourceError
            If it is not there; trying again may help.
        InputError
            If it can never be read as it was asked for.
        """
        ...

    def read(self, timeout_s: float) -> list[Sample]:
        """Return the readings that came, in their order; an empty list if none came within the timeout.

        Raises
        ------
        LostSourceError
            If it is gone.
        EndOfSourceError
            If it has no more.
        """
        ...

    def close(self) -> None:
        """Let it go. Never raises, and may be called twice."""
        ...


def damaged_of(source: object) -> int:
    """Return how often something came that could not be used, as far as the source counts that."""
    return int(getattr(source, "damaged", 0))


def damage_of(source: object) -> str:
    """Return what was wrong with the newest of that, as far as the source says so."""
    return str(getattr(source, "damage", ""))


def overrun_of(source: object) -> int:
    """Return how many messages were lost because they came faster than they were read, as far as the source knows."""
    return int(getattr(source, "overrun", 0))
