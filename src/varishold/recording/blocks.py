"""A recording in blocks: some frames at a time, each block a recording of its own."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from dataclasses import dataclass

from numpy.typing import ArrayLike

from varishold.errors import InputError
from varishold.recording.formats import read
from varishold.recording.press_table import Mark
from varishold.recording.recording import Recording

__all__ = ["Blocks", "open"]


@dataclass(frozen=True)
class Blocks:
    """A recording that is taken some frames at a time; what `read` maps and does not load stays on disk until then.

    Parameters
    ----------
    whole : Recording
        All of it.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.recording import Pad
    >>> opened = Blocks(Recording({"pad": Pad(np.arange(20).reshape(5, 2, 2))}))
    >>> opened.n_frames, [block.n_frames for block in opened.blocks(2)]
    (5, [2, 2, 1])
    >>> opened.frames[3:].pads["pad"].frames.tolist()
    [[[12, 13], [14, 15]], [[16, 17], [18, 19]]]
    """

    whole: Recording

    @property
    def n_frames(self) -> int:
        return self.whole.n_frames

    @property
    def frames(self) -> _Frames:
        """What gives frames a to b - 1 as a recording when it is asked for ``frames[a:b]``."""
        return _Frames(self.whole)

    def blocks(self, n_frames: int = 4096) -> Iterator[Recording]:
        """Yield consecutive recordings of at most `n_frames` frames.

        Raises
        ------
        InputError
            If `n_frames` is less than 1.
        """
        if n_frames < 1:
            raise InputError(f"n_frames must be 1 or more, got {n_frames}")
        for start in range(0, self.n_frames, n_frames):
            yield self.frames[start : start + n_frames]


@dataclass(frozen=True)
class _Frames:
    whole: Recording

    def __len__(self) -> int:
        return self.whole.n_frames

    def __getitem__(self, wanted: slice) -> Recording:
        if not isinstance(wanted, slice) or wanted.step not in (None, 1):
            raise InputError(f"frames are taken as frames[a:b], got frames[{wanted!r}]")
        first, last, _ = wanted.indices(self.whole.n_frames)
        if first >= last:
            raise InputError(f"there are no frames {first} to {last}: they are numbered 0 to {self.whole.n_frames - 1}")
        pads = {name: dataclasses.replace(pad, frames=pad.frames[first:last]) for name, pad in self.whole.pads.items()}
        time_s = None if self.whole.time_s is None else self.whole.time_s[first:last]
        press = None if self.whole.press is None else self.whole.press[first:last]
        signals = {
            name: dataclasses.replace(each, values=each.values[first:last]) for name, each in self.whole.signals.items()
        }
        # What was said last before the first frame still holds there.
        before = [Mark(0, mark.label) for mark in self.whole.marks if mark.frame <= first]
        after = [Mark(mark.frame - first, mark.label) for mark in self.whole.marks if first < mark.frame < last]
        marks = (*before[-1:], *after)
        return dataclasses.replace(self.whole, pads=pads, time_s=time_s, press=press, signals=signals, marks=marks)


def open(
    path: str | os.PathLike[str], *, shape: tuple[int, int] | None = None, pitch_m: ArrayLike | None = None
) -> Blocks:
    """Open a recording to take it in blocks; arguments and errors as in `read`.

    NPY files are mapped, so that they may be larger than memory.
    """
    return Blocks(read(path, shape=shape, pitch_m=pitch_m))
