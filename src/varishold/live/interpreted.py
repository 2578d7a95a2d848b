"""A source whose messages an interpreter understands."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Protocol

from varishold.errors import InputError, LostSourceError
from varishold.live.address import Address
from varishold.live.interpreter import Interpreter
from varishold.live.sample import PadLayout
from varishold.live.source import Source

__all__ = ["InterpretedSource", "topics_at"]


class InterpretedSource:
    """What sources of messages have in common: an address, and what its interpreter tells.

    Parameters
    ----------
    address : Address
        With the interpreter's options, and maybe more.
    """

    def __init__(self, address: Address) -> None:
        self._of = address
        self._interpreter = Interpreter(address)

    @property
    def address(self) -> str:
        """As it was written."""
        return self._of.text

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pads that are known so far."""
        return self._interpreter.pads

    @property
    def damaged(self) -> int:
        """How many messages could not be used."""
        return self._interpreter.damaged

    @property
    def damage(self) -> str:
        """What was wrong with the newest of them."""
        return self._interpreter.damage


class _Topics(Source, Protocol):
    @property
    def topics(self) -> dict[str, str]: ...


def topics_at(root: str, source: _Topics) -> list[tuple[str, str]]:
    """Return the address and type of each topic that a source tells of when it is opened and asks for none."""
    with suppress(LostSourceError, InputError):
        source.open()
    source.close()
    return [(f"{root}{topic}", kind) for topic, kind in sorted(source.topics.items())]
