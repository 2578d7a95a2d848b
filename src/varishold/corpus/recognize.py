"""What ``varishold recognize`` asks: which learned thing every press is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from varishold.corpus.ask import Looked
from varishold.corpus.columns import Column
from varishold.corpus.content import content_digest
from varishold.errors import InputError
from varishold.recording import Recording
from varishold.touch.course.presses import FoundPresses, find_presses

if TYPE_CHECKING:
    from varishold.learning import PressClassifier
    from varishold.learning.recognition import Recognition
    from varishold.sensor import Sensor

__all__ = ["AskRecognize"]

_ROW = (
    Column("press", "whole", "number of the press, from 0"),
    Column("frame_first", "whole", "its first frame, with its rest"),
    Column("frame_last", "whole", "its last frame"),
    Column("time_s", "number", "time of its first frame by the recording's clock"),
    Column("label", "text", "likeliest thing"),
    Column("probability", "number", "of that thing"),
    Column("probabilities", "shares", "of all things of .01 and more, the likeliest first"),
    Column("p_value", "number", "how rare it is that a press of a known thing is as strange"),
    Column("refused", "truth", "whether it looks like none of the things"),
    Column(
        "reasons", "texts", "measures that decided, with the nats for the label and against the next, strongest first"
    ),
    Column("nearest", "text", "most similar press that was learned from"),
    Column("nearest_label", "text", "which thing that was"),
)


@dataclass(frozen=True)
class AskRecognize:
    """Which learned thing is every press?

    Parameters
    ----------
    model : str
        The model's file, which every worker reads.
    digest : str
        Of its content, as `of_model` takes it: answers of another model are none.
    """

    title: ClassVar[str] = "recognize"
    counted: ClassVar[str] = "press"

    model: str
    digest: str

    @classmethod
    def of_model(cls, path: str) -> AskRecognize:
        """Return the question for a model.

        Raises
        ------
        InputError
            If it cannot be read, or is none.
        """
        found = cls(path, content_digest(path))
        _read(found)
        return found

    @property
    def columns(self) -> tuple[Column, ...]:
        return _ROW

    def look(self, whole: Recording, sensor: Sensor | None) -> Looked:
        found = find_presses(whole)
        facts = {"columns": list(found.columns), "pads": list(found.works)}
        arrays: dict[str, Any] = {f"column.{k}": values for k, values in enumerate(found.columns.values())}
        arrays |= {f"works.{k}": mask for k, mask in enumerate(found.works.values())}
        return Looked(np.array(found.spans, np.int64), facts, arrays)

    def rows(
        self, block: Recording, first: int, groups: Sequence[range], looked: Looked, sensor: Sensor | None
    ) -> Mapping[str, Any]:
        assert looked.groups is not None
        spans = [(begin, stop) for begin, stop in looked.groups.tolist()]
        found = FoundPresses(
            spans,
            {name: looked.arrays[f"column.{k}"] for k, name in enumerate(looked.facts["columns"])},
            {name: looked.arrays[f"works.{k}"] for k, name in enumerate(looked.facts["pads"])},
        )
        number_of = {begin: number for number, (begin, _) in enumerate(spans)}
        numbers = [number_of[group.start] for group in groups]
        answers = _read(self).explain([found.cut(number, block, first) for number in numbers])
        rows = [_row(each) for each in answers]
        begins = [None if block.time_s is None else float(block.time_s[group.start - first]) for group in groups]
        return {
            "press": numbers,
            "frame_first": [group.start for group in groups],
            "frame_last": [group.stop - 1 for group in groups],
            "time_s": begins,
            **{column.name: [row[column.name] for row in rows] for column in _ROW[4:]},
        }


def _row(found: Recognition) -> dict[str, Any]:
    told = found.to_dict()
    shares = {told["label"]: told["probability"], **told["alternatives"]}
    return {
        **{key: told[key] for key in ("label", "probability", "p_value", "refused")},
        "probabilities": [{"name": name, "probability": share} for name, share in shares.items()],
        "reasons": [f"{each['measure']} {each['nats']:+.3f}" for each in told["reasons"]],
        "nearest": told["nearest"]["press"],
        "nearest_label": told["nearest"]["label"],
    }


@lru_cache(maxsize=1)
def _read(asked: AskRecognize) -> PressClassifier:
    """Return the model; every process reads it once."""
    from varishold.learning import read_model

    if content_digest(asked.model) != asked.digest:
        raise InputError(f"{asked.model}: was changed while it was being asked; run again")
    return read_model(asked.model)
