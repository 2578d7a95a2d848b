"""Random labelled presses: frames whose truth is known, for whoever has no sensor."""

from __future__ import annotations

import glob
import hashlib
import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, reason_of
from varishold.files import LARGEST_BYTES, only_writer, open_archive, spread, write_archive
from varishold.frame.checks import as_pitch
from varishold.frame.readings import as_shape
from varishold.sensor.cover import Skin
from varishold.skin.pressing import press
from varishold.skin.taxels import Taxels, sense
from varishold.solids import SOLIDS, Drawn, draw_contact

__all__ = ["LabelledPress", "PressDraw", "collect_presses", "draw_press"]

_IDEAL = Taxels()
# Presses a part file holds: what an interruption costs at most, per process.
_PART = 64
# Bytes that a press takes in the file beside its taxels, and those of one taxel.
_COLUMN_BYTES, _TAXEL_BYTES = 256, 4
# A further process pays when it has this many parts to do: it must first load what this one has.
_PARTS_WORTH_A_PROCESS = 4


@dataclass(frozen=True)
class PressDraw:
    """What random presses are drawn from.

    Parameters
    ----------
    skin : Skin
        The skin.
    shape, pitch_m
        The pad: rows and columns of taxels, and their spacing in metres.
    solids : tuple of str
        Solids to draw evenly from, keys of `SOLIDS`.
    size_taxels : (float, float)
        Range of the contact's diameter or breadth, in taxels.
    slope : (float, float)
        Range of depth over contact breadth, drawn evenly on a logarithmic scale.
    taxels : Taxels
        How the taxels depart from ideal ones.

    Raises
    ------
    InputError
        If a solid is unknown, a range is not one, or there is no such pad.
    """

    skin: Skin
    shape: tuple[int, int] = (32, 32)
    pitch_m: float = 1e-3
    solids: tuple[str, ...] = tuple(SOLIDS)
    size_taxels: tuple[float, float] = (8.0, 20.0)
    slope: tuple[float, float] = (0.05, 0.3)
    taxels: Taxels = _IDEAL

    def __post_init__(self) -> None:
        unknown = [name for name in self.solids if name not in SOLIDS]
        if unknown or not self.solids:
            raise InputError(f"solids must name one or more of {', '.join(SOLIDS)}, got {', '.join(unknown) or 'none'}")
        as_shape(self.shape)
        as_pitch(self.pitch_m)
        for name, (low, high) in (("size_taxels", self.size_taxels), ("slope", self.slope)):
            if not 0 < low <= high < np.inf:
                raise InputError(f"{name} must be a range (low, high) with 0 < low <= high, got ({low}, {high})")
        if self.size_taxels[1] > min(self.shape):
            raise InputError(
                f"size_taxels must not exceed the pad's {min(self.shape)} taxels, got {self.size_taxels[1]:g}"
            )


@dataclass(frozen=True)
class LabelledPress:
    """One random press and what is true of it.

    Parameters
    ----------
    solid : str
        Name of the solid in `SOLIDS`.
    name : str
        Name that recognition should give.
    frame : ndarray of shape (rows, cols), float64
        What the taxels read.
    drawn : Drawn
        The solid, its pose, its depth and the contact's size.
    force_n : float
        Total force, newton where the skin's modulus is known.
    area_m2 : float
        True contact area, square metres.
    """

    solid: str
    name: str
    frame: NDArray[np.float64]
    drawn: Drawn
    force_n: float
    area_m2: float


def draw_press(rng: np.random.Generator, draw: PressDraw, *, solid: str | None = None) -> LabelledPress:
    """Draw a random press.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of every random choice.
    draw : PressDraw
        What to draw from.
    solid : str, optional
        Take this solid instead of a random one.

    Returns
    -------
    LabelledPress

    Examples
    --------
    >>> import numpy as np
    >>> draw = PressDraw(Skin("layer", 6e-3, 0.45, 1e-3), taxels=Taxels(noise=0.01))
    >>> one = draw_press(np.random.default_rng(1), draw, solid="hip")
    >>> one.name, one.frame.shape
    ('hip', (32, 32))
    """
    solid = solid or draw.solids[int(rng.integers(len(draw.solids)))]
    rows, cols = draw.shape
    drawn = draw_contact(
        rng,
        solid,
        field_m=(rows * draw.pitch_m, cols * draw.pitch_m),
        size_m=(draw.size_taxels[0] * draw.pitch_m, draw.size_taxels[1] * draw.pitch_m),
        slope=draw.slope,
    )
    pressed = press(
        drawn.solid, draw.skin, depth=drawn.depth_m, shape=draw.shape, pitch_m=draw.pitch_m, pose=drawn.pose
    )
    frame = sense(pressed, draw.taxels, seed=int(rng.integers(2**31)))
    cell = (pressed.x_m[1] - pressed.x_m[0]) * (pressed.y_m[1] - pressed.y_m[0])
    area = float(np.count_nonzero(pressed.contact) * cell)
    return LabelledPress(solid, SOLIDS[solid].name, frame, drawn, pressed.force_n, area)


def collect_presses(
    path: str | Path,
    draw: PressDraw,
    count: int,
    *,
    seed: int = 0,
    processes: int = 1,
    advance: Callable[[int], None] | None = None,
) -> int:
    """Write a labelled recording of random presses: the same file for the same seed, however many processes.

    Press i is drawn from the generator of (seed, i). Finished parts stand in a folder beside the file until
    all are there; after an interruption the same call goes on from them.

    Parameters
    ----------
    path : str or Path
        NPZ to write: a recording (`pressure`, `pitch_m`, `unit`, `sensor`) of a press a frame, whose columns are
        `label`, `solid`, `position_x_m`, `position_y_m`, `yaw_rad`, `size_long_m`, `size_short_m`, `depth_m`, `force_n`
        and `area_m2`.
    draw : PressDraw
        What to draw from.
    count : int
        Presses.
    seed : int
        Seed of all random choices.
    processes : int
        Processes to use.
    advance : callable, optional
        Called with the number of presses that were just finished, or found.

    Returns
    -------
    int
        Presses that were found from an earlier, interrupted call.

    Raises
    ------
    InputError
        If the count or the number of processes is below 1, so many presses are more than can be read again, or the file
        cannot be written.
    """
    rows, cols = draw.shape
    most = LARGEST_BYTES // (_TAXEL_BYTES * rows * cols + _COLUMN_BYTES)
    if count < 1:
        raise InputError(f"count must be 1 or more presses, got {count}")
    if count > most:
        raise InputError(
            f"count must be at most {most} presses of {rows} x {cols} taxels, which a file holds that can be read "
            f"again, got {count}; write several"
        )
    if processes < 1:
        raise InputError(f"processes must be 1 or more, got {processes}")
    path = Path(path)
    described = json.dumps([asdict(draw), count, seed], default=str, sort_keys=True)
    folder = path.with_name(f".{path.name}.{hashlib.sha256(described.encode()).hexdigest()[:12]}.parts")
    with only_writer(path), _folder(folder, path):
        parts = [(folder / f"{first:08d}.npz", first, min(first + _PART, count)) for first in range(0, count, _PART)]
        missing = [part for part in parts if not part[0].exists()]
        found = count - sum(last - first for _, first, last in missing)
        if found and advance is not None:
            advance(found)
        few = min(processes, len(missing) // _PARTS_WORTH_A_PROCESS)
        for done in spread(_Work(draw, seed), missing, processes=few):
            if advance is not None:
                advance(done)
        _join([part for part, _, _ in parts], path, draw)
        for left in path.parent.glob(f".{glob.escape(path.name)}.*.parts"):
            shutil.rmtree(left, ignore_errors=True)
    return found


@contextmanager
def _folder(folder: Path, path: Path) -> Iterator[None]:
    """Make a folder of parts, which goes again if nothing is in it."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot write here: {reason_of(error)}") from error
    try:
        yield
    finally:
        with suppress(OSError):
            folder.rmdir()


def _join(parts: list[Path], path: Path, draw: PressDraw) -> None:
    """Write the recording of all parts."""
    columns: dict[str, list[NDArray[Any]]] = {}
    for part in parts:
        with open_archive(part) as archive:
            for name in archive.names:
                columns.setdefault(name, []).append(archive.array(name))
    arrays = {name: np.concatenate(values) for name, values in columns.items()}
    arrays["press"] = np.arange(len(arrays["pressure"]))
    arrays["pitch_m"] = np.array(draw.pitch_m)
    arrays["unit"] = np.array("raw" if draw.skin.youngs_modulus_pa is None else "Pa")
    arrays["sensor"] = np.array(f"simulated {draw.skin.kind}")
    write_archive(arrays, path, kind="presses")


@dataclass(frozen=True)
class _Work:
    """What a process does with a part."""

    draw: PressDraw
    seed: int

    def __call__(self, part: tuple[Path, int, int]) -> int:
        return _write_part(part, self.draw, self.seed)


def _write_part(part: tuple[Path, int, int], draw: PressDraw, seed: int) -> int:
    path, first, last = part
    presses = [draw_press(np.random.default_rng([seed, i]), draw) for i in range(first, last)]
    frames = np.stack([p.frame for p in presses])
    largest = float(np.abs(frames).max())
    if not largest <= float(np.finfo(np.float32).max):
        raise InputError(
            f"frames of up to {largest:g} are beyond what a file of presses holds; give youngs_modulus_pa and "
            "full_scale in pascal"
        )
    # Single precision is finer than any sensor, and the file is half as large.
    arrays = {
        "pressure": frames.astype(np.float32),
        "press.label": np.array([p.name for p in presses]),
        "press.solid": np.array([p.solid for p in presses]),
        "press.position_x_m": np.array([p.drawn.pose.x_m for p in presses]),
        "press.position_y_m": np.array([p.drawn.pose.y_m for p in presses]),
        "press.yaw_rad": np.array([p.drawn.pose.yaw_rad for p in presses]),
        "press.size_long_m": np.array([p.drawn.size_m[0] for p in presses]),
        "press.size_short_m": np.array([p.drawn.size_m[1] for p in presses]),
        "press.depth_m": np.array([p.drawn.depth_m for p in presses]),
        "press.force_n": np.array([p.force_n for p in presses]),
        "press.area_m2": np.array([p.area_m2 for p in presses]),
    }
    write_archive(arrays, path)
    return last - first
