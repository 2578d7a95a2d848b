"""Pads: a sensor's frames with masks, pitch and positions, checked once and for all."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.files import let_go
from varishold.frame.checks import as_given, as_mask, as_numbers, as_pitch, as_usable, as_valid
from varishold.frame.doubts import doubts_of
from varishold.frame.health import Extent, broken_taxels, extent_of, remarks_of
from varishold.frame.holes import hole_share
from varishold.frame.slow_drift import slow_drift
from varishold.frame.taxels_apart import spacing_of
from varishold.recording.kept import checked_notes, frozen

__all__ = ["UNNAMED_PAD", "Pad", "far_apart", "frame_of", "of_pad", "pad_remarks"]

#: The name of a pad that has none.
UNNAMED_PAD = "pad"

# Bytes of frames that are looked at together when a whole recording is gone through.
_BLOCK = 1 << 24
# No skin's taxels are farther apart.
_FARTHEST_M = 0.1


@dataclass(frozen=True, eq=False)
class Pad:
    """One pad's frames, where it has taxels, and which of them work.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), integer or float
        Larger is more pressure, in the recording's unit. The type is kept, a memory map stays one, and the
        array that the pad shows is read-only. Negative values are noise; NaN may stand only where `field` or
        `valid` is False. Truth values become uint8.
    field : ndarray of shape (rows, cols), bool, optional
        False where there is no taxel: outside the region R, never filled. Default: taxels everywhere.
    valid : ndarray of shape (rows, cols), bool, optional
        False where a taxel is broken. Default: all work.
    pitch_m : (float, float), optional
        Row spacing and column spacing, metres; a single number stands for both. Default: unknown.
    positions_m : ndarray of shape (n_taxels, 2), float64, optional
        (x, y) of each taxel where they stand on no grid; the frames are then one row of taxels.
    polarity : {"up", "down"}
        "down" where smaller is more pressure; such frames are to be turned by a sensor file before anything else.
    notes : tuple of str
        What was done to the frames, in words.

    Raises
    ------
    InputError
        If shapes, types or values do not fit, or the frames go up and are mostly negative.

    Examples
    --------
    >>> import numpy as np
    >>> pad = Pad(np.zeros((3, 2, 4), np.uint16), pitch_m=(0.002, 0.001))
    >>> pad.n_frames, pad.shape
    (3, (2, 4))
    """

    frames: NDArray[Any]
    field: NDArray[np.bool_] | None = None
    valid: NDArray[np.bool_] | None = None
    pitch_m: tuple[float, float] | None = None
    positions_m: NDArray[np.float64] | None = None
    polarity: Literal["up", "down"] = "up"
    notes: tuple[str, ...] = ()
    #: What is odd about the values, in words: dead, stuck and saturated taxels, no change at all.
    remarks: tuple[str, ...] = dataclasses.field(default=(), init=False, repr=False)
    extent: Extent = dataclasses.field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.polarity, str) or self.polarity not in ("up", "down"):
            raise InputError(f"polarity must be up or down, got {self.polarity!r}", parameter="polarity")
        frames = _checked_frames(self.frames)
        shape = frames.shape[1:]
        field = _kept(as_mask(self.field, shape, "field"))
        valid = _kept(as_valid(self.frames, self.valid, shape))
        usable = as_usable(frames, shape, field, valid)
        if not usable.any():
            raise InputError(f"no taxel of {shape[0]} x {shape[1]} is both in field and valid")
        extent = extent_of(_blocks(frames), usable, signed=self.polarity == "down")
        object.__setattr__(self, "frames", frames)
        object.__setattr__(self, "field", field)
        object.__setattr__(self, "valid", valid)
        object.__setattr__(self, "pitch_m", None if self.pitch_m is None else as_pitch(self.pitch_m))
        object.__setattr__(self, "positions_m", _checked_positions(self.positions_m, shape))
        object.__setattr__(self, "notes", checked_notes(self.notes))
        object.__setattr__(self, "extent", extent)
        object.__setattr__(self, "remarks", remarks_of(extent, usable, frames.dtype, frames.shape[0]))

    @property
    def n_frames(self) -> int:
        return int(self.frames.shape[0])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return int(self.frames.shape[1]), int(self.frames.shape[2])

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Where there is a taxel and it works: shape (rows, cols), bool."""
        return as_usable(self.frames, self.shape, self.field, self.valid)

    @property
    def broken(self) -> NDArray[np.bool_]:
        """Where a usable taxel shows by its values that it is dead or stuck: shape (rows, cols), bool."""
        return broken_taxels(self.extent, self.usable, self.frames.dtype, self.n_frames)

    def totals(self) -> NDArray[np.float64]:
        """Return each frame's sum over the usable taxels, shape (n_frames,), in the recording's unit."""
        usable = self.usable.ravel()
        totals = np.empty(self.n_frames)
        for start, block in _blocks(self.frames):
            flat = block.reshape(block.shape[0], -1)
            if not usable.all():
                flat = flat[:, usable]
            totals[start : start + block.shape[0]] = flat.sum(axis=1, dtype=np.float64)
        return totals


def pad_remarks(pad: Pad) -> Iterator[str]:
    """Yield what is odd about a pad: what its reader and its values say, then what all of its frames show."""
    yield from (*pad.notes, *pad.remarks)
    drift = slow_drift(pad.frames, pad.usable)
    if drift is not None:
        yield (
            f"the rest drifts by {drift[0]:.3g} in all, {drift[1]:.0%} of what is read: it is taken off "
            "where frames without a press show it; varishold live replay:FILE follows the rest of each taxel"
        )
    holes = hole_share(pad.frames, pad.usable) if pad.polarity == "down" else 0.0
    if holes:
        yield (
            f"{holes:.2g} of all readings are exactly 0, far below the others: where a camera sees "
            "nothing? fill them with what is near, or they are deep presses"
        )
    yield from far_apart(pad.pitch_m, pad.positions_m)
    yield from doubts_of(pad.frames, pad.usable)


def of_pad(name: str) -> str:
    """Return what stands before a fault of a pad: its name, where somebody gave it one.

    Examples
    --------
    >>> of_pad("left"), of_pad(UNNAMED_PAD)
    ('pad left: ', '')
    """
    return "" if name == UNNAMED_PAD else f"pad {name}: "


def far_apart(pitch_m: tuple[float, float] | None, positions_m: NDArray[np.float64] | None = None) -> list[str]:
    """Say where taxels, on a grid or at positions, are farther apart than those of any skin."""
    told = []
    if pitch_m is not None and max(pitch_m) > _FARTHEST_M:
        told.append(f"taxels are {max(pitch_m):g} m apart: is the pitch in millimetres?")
    if positions_m is not None and len(positions_m) > 1:
        spacing = spacing_of(positions_m)
        if spacing > _FARTHEST_M:
            told.append(f"taxels are {spacing:.3g} m apart: are positions_m in millimetres?")
    return told


def frame_of(pad: Pad, index: int) -> NDArray[np.float64]:
    """Return one frame of a pad as a new array of shape (rows, cols), float64.

    Raises
    ------
    InputError
        If there is no such frame.
    """
    if not 0 <= index < pad.n_frames:
        raise InputError(f"there is no frame {index}: frames are numbered 0 to {pad.n_frames - 1}")
    return np.array(pad.frames[index], dtype=np.float64, order="C")


def _checked_positions(positions: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.float64] | None:
    if positions is None:
        return None
    must = f"positions_m must be finite (x, y) of each of {shape[1]} taxels in one row, shape ({shape[1]}, 2)"
    array = as_given(positions, must)
    if array.dtype.kind not in "iuf" or array.shape != (shape[1], 2) or shape[0] != 1 or not np.isfinite(array).all():
        raise InputError(f"{must}, got {array.dtype} of shape {array.shape} beside frames of {shape[0]} x {shape[1]}")
    return frozen(array.astype(np.float64))


def _checked_frames(frames: ArrayLike) -> NDArray[Any]:
    array = as_numbers(frames, 3, "pressure", masked=True)
    if array.shape[0] == 0:
        raise InputError("a recording needs at least one frame, got none")
    return frozen(array.view())


def _kept(mask: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
    """Return a copy of a mask that nobody can write to; None for the mask of no taxels."""
    return frozen(mask.copy()) if mask.size else None


def _blocks(frames: NDArray[Any]) -> Iterator[tuple[int, NDArray[Any]]]:
    """Yield (number of the first frame, some frames), so that temporary arrays stay small."""
    many = max(1, _BLOCK // math.prod(frames.shape[1:]) // 8)
    for start in range(0, frames.shape[0], many):
        yield start, frames[start : start + many]
        let_go(frames)
