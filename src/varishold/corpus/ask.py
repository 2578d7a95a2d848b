"""What is asked of every recording of a corpus."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.corpus.columns import Column
from varishold.recording import Recording

if TYPE_CHECKING:
    from varishold.sensor import Sensor

__all__ = ["Ask", "Looked"]


@dataclass(frozen=True, eq=False)
class Looked:
    """What a look through a whole recording tells those who answer a block of it.

    Parameters
    ----------
    groups : ndarray of shape (n, 2), int64, or None
        First frame and end of each group that has answers of its own; None where every frame has.
    facts : mapping of str to plain values
        As JSON holds them.
    arrays : mapping of str to ndarray
    """

    groups: NDArray[np.int64] | None
    facts: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]]


class Ask(Protocol):
    """A question; a dataclass of plain values, from which its digest is made and which other processes are sent."""

    @property
    def title(self) -> str:
        """The command that asks it."""

    @property
    def counted(self) -> str:
        """What a row is."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """Of its table, without the first, which names the file."""

    def look(self, whole: Recording, sensor: Sensor | None) -> Looked:
        """Look once through a recording, upright.

        Raises
        ------
        InputError
            If it cannot be answered.
        """

    def rows(
        self, block: Recording, first: int, groups: Sequence[range], looked: Looked, sensor: Sensor | None
    ) -> Mapping[str, Any]:
        """Answer some groups of frames: the columns of the table, by name; None and NaN are null.

        A frame's answer may not depend on the block in which it comes.

        Parameters
        ----------
        block : Recording
            Upright; its first frame is number `first` of the whole.
        groups : sequence of range
            By the whole's numbers.
        """
