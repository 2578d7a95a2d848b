"""What ``varishold touch`` asks: the surface of every contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from varishold.corpus.ask import Looked
from varishold.corpus.columns import Column
from varishold.corpus.pads_seen import looked_at, seen_in
from varishold.corpus.touch_columns import SAID
from varishold.recording import Recording, select_frames
from varishold.touch.pad_frames import pad_frames
from varishold.touch.recordings import answers_of, knowledge_of

if TYPE_CHECKING:
    from varishold.sensor import Sensor, Skin

__all__ = ["AskTouch"]


@dataclass(frozen=True)
class AskTouch:
    """What surface is every contact?

    Parameters
    ----------
    frames, levels, skin, exact
        As in `varishold.touch.recognize_recording`; every frame by default.
    """

    title: ClassVar[str] = "touch"
    counted: ClassVar[str] = "contact"

    frames: str = "all"
    levels: int = 32
    skin: Skin | None = None
    exact: bool = False

    @property
    def columns(self) -> tuple[Column, ...]:
        return tuple(said.column for said in SAID)

    def look(self, whole: Recording, sensor: Sensor | None) -> Looked:
        seen = pad_frames(whole)
        # What it refuses, it refuses before the first block.
        knowledge_of(whole, skin=self.skin, exact=self.exact, sensor=sensor, frames=seen)
        groups = None
        if self.frames != "all":
            chosen = select_frames(whole, self.frames)
            groups = np.array([(group.start, group.stop) for group in chosen], np.int64)
        return looked_at(seen, groups)

    def rows(
        self, block: Recording, first: int, groups: Sequence[range], looked: Looked, sensor: Sensor | None
    ) -> dict[str, list[Any]]:
        knows = knowledge_of(
            block,
            levels=self.levels,
            skin=self.skin,
            exact=self.exact,
            sensor=sensor,
            frames=seen_in(block, looked),
        )
        columns: dict[str, list[Any]] = {said.column.name: [] for said in SAID}
        for answer in answers_of(block, groups, knows, pooled=self.frames == "press", first=first):
            told = answer.to_dict()
            for said in SAID:
                columns[said.column.name].append(said.of(told))
        return columns
