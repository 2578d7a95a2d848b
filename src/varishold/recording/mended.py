"""Recordings without the glitches of their sensor, and without what sticks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.files import let_go
from varishold.frame.checks import as_usable
from varishold.frame.glitches import GlitchRule, glitch_rule
from varishold.frame.sticking import Sticking, sticking_taxels
from varishold.recording.recording import Recording
from varishold.recording.stored import Column, Stored, stored_of

__all__ = ["stored_without_glitches", "without_glitches"]

# Readings that are looked through together.
_TOGETHER = 1 << 20


def without_glitches(recording: Recording) -> Recording:
    """Return a recording in which readings that stand alone in time and place are replaced; each pad's notes say so.

    What is replaced gets the median of what the taxel reads in the frames beside it. A taxel or a line that sticks from
    some frame on is filled from the taxels around it. A recording without either is returned as it is.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.recording import Pad
    >>> frames = np.random.default_rng(0).normal(0, 1, (20, 8, 8))
    >>> frames[5:, 2:6, 2:6] += 100.0
    >>> frames[10, 3, 0] = 200.0
    >>> without_glitches(Recording({"pad": Pad(frames)})).remarks
    ('1 reading stands alone in time and place: replaced by those beside it',)
    """
    stored, pads = stored_of(recording), {}
    for name, pad in recording.pads.items():
        sticking = sticking_taxels(pad.frames, pad.usable)
        frames: Column = pad.frames if sticking is None else _Mended(pad.frames, sticking)
        notes = [] if sticking is None else [*sticking.words]
        rule = glitch_rule(frames, pad.usable)
        n = 0 if rule is None else _n_glitches(rule, pad.frames)
        if rule is not None and n:
            frames = _Mended(frames, rule)
            notes.append(_words(n))
        if notes:
            pads[name] = replace(stored.pads[name], frames=frames, notes=(*pad.notes, *notes))
    return replace(stored, pads={**stored.pads, **pads}).whole() if pads else recording


def stored_without_glitches(stored: Stored) -> Stored:
    """Return a recording in its file as `without_glitches` would: each block is mended as it is read."""
    pads = {}
    for name, pad in stored.pads.items():
        shape = (pad.frames.shape[1], pad.frames.shape[2])
        usable = as_usable(np.zeros((1, *shape)), shape, pad.field, pad.valid)
        sticking = sticking_taxels(pad.frames, usable)
        frames = pad.frames if sticking is None else _Mended(pad.frames, sticking)
        rule = glitch_rule(frames, usable)
        pads[name] = replace(pad, frames=frames if rule is None else _Mended(frames, rule))
    return replace(stored, pads=pads)


def _n_glitches(rule: GlitchRule, frames: NDArray[Any]) -> int:
    n, many = 0, max(1, _TOGETHER // rule.usable.size)
    for first in range(0, len(frames), many):
        n += rule.mended(first, min(first + many, len(frames)))[1]
        let_go(frames)
    return n


def _words(n: int) -> str:
    what, them = ("1 reading stands", "it") if n == 1 else (f"{n} readings stand", "them")
    return f"{what} alone in time and place: replaced by those beside {them}"


@dataclass(frozen=True)
class _Mended:
    """A column of frames that are mended as they are read."""

    source: Column
    rule: GlitchRule | Sticking

    @property
    def shape(self) -> tuple[int, ...]:
        return self.source.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.source.dtype

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        first, last, _ = wanted.indices(self.shape[0])
        return self.rule.mended(first, last)[0] if first < last else np.asarray(self.source[first:last])
