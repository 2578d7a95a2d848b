"""What topics of messages say beside their readings: times, marks, what was left out or passed over."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError
from varishold.recording.mcap.topics import MARKS, PadFacts
from varishold.recording.press_table import Mark

if TYPE_CHECKING:
    from varishold.recording.mcap.gathering import Gathered

__all__ = ["TIMES", "exact_times", "left_out", "marks_of", "said_of", "signals_only", "time_words"]

#: The exact times of a recording's frames, where nanoseconds do not hold them.
TIMES = "time_s.float64"
# Topics that a remark names at most.
_TOLD = 8


def signals_only(path: Path, pads: Iterable[str]) -> FormatError:
    """Return the error to raise where no pad is one of pressure."""
    return FormatError(
        f"{path}: holds signals only ({', '.join(pads)}), and what touches is felt by pressure; "
        "varishold replay plays it"
    )


def left_out(facts: PadFacts, finite: NDArray[np.bool_]) -> tuple[NDArray[np.bool_] | None, tuple[str, ...]]:
    """Return which taxels work, without those that were ever no number, and what there is to say about it."""
    known = np.ones(finite.shape, bool)
    for mask in (facts.field, facts.valid):
        known &= mask if mask is not None and mask.shape == finite.shape else True
    wrong = known & ~finite
    if not wrong.any():
        return facts.valid, ()
    return known & finite, (
        f"pad {facts.name}: {counted(int(wrong.sum()), 'taxel is', 'taxels are')} left out, "
        "whose readings are no numbers",
    )


def exact_times(held: Gathered, n_readings: int) -> NDArray[np.float64] | None:
    """Return the times that stand beside the messages, because nanoseconds do not hold them."""
    if TIMES not in held.attachments:
        return None
    exact = held.attachments[TIMES][: 8 * n_readings]
    return np.frombuffer(exact, "<f8") if len(exact) == 8 * n_readings else None


def time_words(stamp: str) -> tuple[str, ...]:
    """Say whose clock the time is by where it is not the sensor's."""
    return ("time is that of the machine that recorded, for the sensor sends none",) if stamp == "host" else ()


def marks_of(held: Gathered, log_ns: NDArray[np.int64]) -> tuple[Mark, ...]:
    """Return what was said was felt, each from the first frame on that came after."""
    rising = np.maximum.accumulate(log_ns)
    marks: list[Mark] = []
    for note in held.notes:
        label = note.told.get("label")
        if note.topic != MARKS or not isinstance(label, str):
            continue
        frame = note.told.get("frame")
        if not isinstance(frame, int):
            frame = int(np.searchsorted(rising, note.log_ns))
        frame = max(frame, marks[-1].frame if marks else 0)
        if frame < len(log_ns):
            marks.append(Mark(frame, label))
    return tuple(marks)


def said_of(held: Gathered) -> Iterator[str]:
    """Say what else there is to know."""
    if held.early:
        yield held.early
    if held.passed:
        topics = [f"{topic} ({kind})" for topic, kind in held.passed.items()]
        yield f"passed over: {', '.join(topics[:_TOLD])}" + (", ..." if len(topics) > _TOLD else "")
