"""The rows of the yardstick: one fault or awkward pose at one strength, its frames and what is true of them.

A row holds as many frames of each of 13 kinds of form on each medium; faces stand in `forms`, media in `media`, faults
in `faults`, and each says what its words mean. White noise of 1 % of the peak on pads of 32 x 32, 2 % on 16 x 16, is
in every row. Nothing is shared with what draws the training frames.

What is true. Ridge and hip are one name, "ridge". The solid keeps its name whatever the sensor does to it, but for
these, where two names give the same frame:

- a tilted plane that leaves no taxel unloaded: plane or edge; where part of the field is free: edge;
- saturated at half, unknown: a cone is a frustum of a cone and the other way round, and so for pyramids;
- rounded by half of the breadth, a cylinder is a ball: either.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from varishold.evaluation.yardstick import faults as _F
from varishold.evaluation.yardstick.faults import Fault
from varishold.evaluation.yardstick.forms import Change

__all__ = ["NOISE", "ROWS", "Row", "as_one", "distorted"]

Floats = NDArray[np.float64]

#: Standard deviation of the white noise, in shares of the peak, by the taxels a side.
NOISE: Mapping[int, float] = {32: 0.01, 16: 0.02}
_UPRIGHT = Change()
_CUT_OFF = {
    "cone": ("frustum of a cone",),
    "frustum of a cone": ("cone",),
    "pyramid": ("frustum of a pyramid",),
    "frustum of a pyramid": ("pyramid",),
}


@dataclass(frozen=True)
class Row:
    """One fault or pose at one strength.

    Parameters
    ----------
    name : str
        Faults are drawn from a seed that holds it.
    before, after : tuple of Fault
        What happens before and after the white noise.
    change : Change
        What is done to the form and its place.
    counted : bool
        Whether it enters the score.
    also : mapping
        Other names that are as true, by the solid's name.
    """

    name: str
    before: tuple[Fault, ...] = ()
    after: tuple[Fault, ...] = ()
    change: Change = _UPRIGHT
    counted: bool = True
    also: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def _row(name: str, *before: Fault, change: Change = _UPRIGHT, counted: bool = True) -> Row:
    return Row(name, before, change=change, counted=counted)


#: The rows of version 1. Order and names are part of it.
ROWS = (
    _row("clean"),
    _row("gain spread 5 %", partial(_F.gains, spread=0.05)),
    _row("gain spread 10 %", partial(_F.gains, spread=0.10)),
    _row("gain spread 20 %", partial(_F.gains, spread=0.20)),
    _row("offsets 6 %", partial(_F.offsets, spread=0.06)),
    _row("sloping rest 15 %", partial(_F.slope, rise=0.15)),
    _row("ghosts 15 %", partial(_F.ghosts, share=0.15)),
    _row("memory of a quarter", partial(_F.memory, share=0.25)),
    _row("dead taxels 2 %", partial(_F.dead, share=0.02)),
    _row("dead taxels 5 %", partial(_F.dead, share=0.05)),
    _row("dead line", _F.dead_line),
    _row("logarithmic a = 5", partial(_F.logarithm, a=5.0)),
    _row("power .5", partial(_F.power, exponent=0.5)),
    _row("power 2", partial(_F.power, exponent=2.0)),
    Row("saturated at 80 %", (), (partial(_F.saturated, at=0.8),)),
    Row("saturated at half", (), (partial(_F.saturated, at=0.5),), also=_CUT_OFF),
    _row("dead zone 10 %", partial(_F.dead_zone, below=0.10)),
    _row("dead zone 30 %", partial(_F.dead_zone, below=0.30)),
    _row("tilt 5 degrees", change=Change(tilt=5.0)),
    _row("tilt 10 degrees", change=Change(tilt=10.0)),
    _row("rounded by a quarter", change=Change(rounding=0.25)),
    Row("rounded by half", change=Change(rounding=0.5), also={"cylinder": ("sphere",)}),
    _row("cut by the border 15 %", change=Change(cut=0.15)),
    _row("cut by the border 30 %", change=Change(cut=0.30)),
    _row("cut by the border 50 %", change=Change(cut=0.50)),
    Row("six counts", (), (partial(_F.counts, n=6),)),
    Row("15 counts", (), (partial(_F.counts, n=15),)),
    _row("crosstalk 12 %", partial(_F.crosstalk, share=0.12)),
    _row("pink 5 %", partial(_F.pink, spread=0.05)),
    Row(
        "plausible mix",
        (partial(_F.crosstalk, share=0.12), partial(_F.gains, spread=0.05), partial(_F.pink, spread=0.05)),
        (partial(_F.counts, n=255),),
    ),
    Row(
        "bad mix",
        (
            partial(_F.crosstalk, share=0.12),
            partial(_F.gains, spread=0.10),
            partial(_F.dead_zone, below=0.10),
            partial(_F.logarithm, a=5.0),
        ),
        (partial(_F.counts, n=60),),
    ),
    _row("stretch 1.25", partial(_F.stretch, ratio=1.25), counted=False),
    _row("blur 1 taxel", partial(_F.blur, taxels=1.0), counted=False),
    _row("blur 2 taxels", partial(_F.blur, taxels=2.0), counted=False),
    _row("gain spread 30 %", partial(_F.gains, spread=0.30), counted=False),
)


def as_one(name: str) -> str:
    """Return a form's name, ridge and hip as one."""
    return "ridge" if name == "hip" else name


def distorted(
    row: Row, clean: Floats, kinds: NDArray[np.str_], medium: str, seed: int
) -> tuple[Floats, list[tuple[str, ...]]]:
    """Return the readings of one row on one medium, and what is true of each.

    Parameters
    ----------
    row : Row
    clean : ndarray of shape (n, side, side), float64
        Frames of `clean_frames` with the row's change.
    kinds : ndarray of shape (n,), str
    medium : str
    seed : int

    Returns
    -------
    readings : ndarray of shape (n, side, side), float64
        Their peak is about 1.
    truths : list of tuple of str
        The names that are right, the solid's own first.
    """
    side = clean.shape[1]
    rng = np.random.default_rng([seed, side, len(medium), *row.name.encode()])
    read = clean
    white: Fault = partial(_F.noise, spread=NOISE[side])
    for fault in (*row.before, white, *row.after):
        read = fault(read, rng)
    return read, [_truth(row, as_one(kind), frame) for kind, frame in zip(kinds.tolist(), clean, strict=True)]


def _truth(row: Row, kind: str, clean: Floats) -> tuple[str, ...]:
    if kind == "plane" and row.change.tilt > 0:
        return ("plane", "edge") if clean.min() > 0 else ("edge",)
    return (kind, *row.also.get(kind, ()))
