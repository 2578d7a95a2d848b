"""A recording in blocks: some frames at a time, each block a recording of its own."""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from varishold.errors import InputError
from varishold.files import let_go
from varishold.frame.checks import as_whole
from varishold.recording.formats import open_stored
from varishold.recording.recording import Recording
from varishold.recording.stored import Stored, stored_of

__all__ = ["Blocks", "open"]

# Times that are looked through together.
_TIMES = 1 << 16


class Blocks:
    """A recording that is taken some frames at a time; what is in a file stays there until it is asked for.

    Parameters
    ----------
    source : Recording or Stored
        All of it; `open` gives the one in a file. As a context manager it lets the file go at its end.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.recording import Pad
    >>> opened = Blocks(Recording({"pad": Pad(np.arange(20).reshape(5, 2, 2))}, time_s=np.arange(5) / 10))
    >>> opened.n_frames, [block.n_frames for block in opened.blocks(2)]
    (5, [2, 2, 1])
    >>> opened.frames[3:].pads["pad"].frames.tolist()
    [[[12, 13], [14, 15]], [[16, 17], [18, 19]]]
    >>> opened.frame_at(0.25)
    3
    """

    def __init__(self, source: Recording | Stored) -> None:
        self._stored = source if isinstance(source, Stored) else stored_of(source)
        self._closing = weakref.finalize(self, self._stored.close)

    @property
    def n_frames(self) -> int:
        return self._stored.n_frames

    @property
    def whole(self) -> Recording:
        """All of it; what would take much memory is mapped from a temporary file."""
        return self._stored.whole()

    @property
    def frames(self) -> _Frames:
        """What gives frames a to b - 1 as a recording when it is asked for ``frames[a:b]``."""
        return _Frames(self._stored)

    def blocks(self, n_frames: int = 4096) -> Iterator[Recording]:
        """Yield consecutive recordings of at most `n_frames` frames.

        Raises
        ------
        InputError
            If `n_frames` is no whole number from 1.
        FormatError
            If the file turns out to be damaged; the blocks before are good.
        """
        n_frames = as_whole(n_frames, "n_frames")
        for start in range(0, self.n_frames, n_frames):
            yield self.frames[start : start + n_frames]

    def frame_at(self, time_s: float) -> int:
        """Return the first frame whose time is not before a time; the number of frames where there is none.

        Parameters
        ----------
        time_s : float
            By the recording's clock, seconds. Where that goes back, the first frame that was reached counts.

        Raises
        ------
        InputError
            If the recording has no times, or the time is no number.
        """
        if isinstance(time_s, bool) or not isinstance(time_s, int | float | np.number) or np.isnan(time_s):
            raise InputError(f"time_s must be a number of seconds, got {time_s!r}", parameter="time_s")
        times = self._stored.time_s
        if times is None:
            raise InputError("a recording without times has no frame at a time; take frames by their numbers")
        for start in range(0, self.n_frames, _TIMES):
            reached = np.flatnonzero(np.asarray(times[start : start + _TIMES]) >= time_s)
            if reached.size:
                return start + int(reached[0])
        return self.n_frames

    def close(self) -> None:
        """Let the file go. May be called again."""
        self._closing()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@dataclass(frozen=True)
class _Frames:
    stored: Stored

    def __len__(self) -> int:
        return self.stored.n_frames

    def __getitem__(self, wanted: slice) -> Recording:
        if not isinstance(wanted, slice) or wanted.step not in (None, 1):
            raise InputError(f"frames are taken as frames[a:b], got frames[{wanted!r}]")
        first, last, _ = wanted.indices(len(self))
        if first >= last:
            raise InputError(f"there are no frames {first} to {last}: they are numbered 0 to {len(self) - 1}")
        part = self.stored.part(first, last)
        for pad in part.pads.values():
            let_go(pad.frames)
        return part


def open(
    path: str | os.PathLike[str],
    *,
    shape: tuple[int, int] | None = None,
    pitch_m: ArrayLike | None = None,
    polarity: Literal["up", "down"] = "up",
) -> Blocks:
    """Open a recording to take it in blocks; arguments and errors as in `read`, of which this is the larger brother.

    What is read of the file is what is asked for, so that a file may be larger than memory; formats of text and
    archives are read at once. `docs/formats.md` says which is which.
    """
    return Blocks(open_stored(path, shape=shape, pitch_m=pitch_m, polarity=polarity))
