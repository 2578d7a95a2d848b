"""Names given to frames of faulty sensors and awkward poses: a row a fault or pose, by a generator of its own.

The generator shares no drawing, no solver and no sensor code with training, solids, skin or sensor: faces stand in
`_distort_forms`, media in `_distort_media`, faults in `_distort_faults`, and each says what its words mean. 13 kinds,
as many frames each, in every row; ridge and hip count as one name. White noise of 1 % of the peak on pads of
32 x 32, 2 % on 16 x 16, in every row. Names are those of the largest contact; no contact is "unknown". After a memory
of the last press the largest contact may be what is left of it; the share named right of the contacts that stand
highest is printed behind the row ("highest").

Seeds: the default is for the last word and is not to be looked at while learning; `--seed 1` is.

What is true. The solid keeps its name whatever the sensor does to it, but for these, where two names give the
same frame:
- a tilted plane that leaves no taxel unloaded: plane or edge; where part of the field is free: edge;
- saturated at half, unknown: a cone is a frustum of a cone and the other way round, and so for pyramids;
- rounded by half of the breadth, a cylinder is a ball: either.
Where that matters the share with the solid's own name alone is printed behind the row ("own name").

Columns: right name; outline right (round, square, oblong, edge, plane, unknown); unknown; named wrong with p > .9
(unknown is not a name here); how often the 90 % answer set holds the truth, and its mean size. Bars stand behind
a slash. A row with a star is printed and not counted in the mean; "known" rows are given the sensor file, the gains of
"bad mix, known" being those of one sensor. A file says dead band before gain where the fault is the other way round.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks import _distort_faults as faults
from benchmarks._distort_faults import Fault
from benchmarks._distort_forms import Change
from benchmarks._distort_media import frames
from benchmarks._figures import figure, share
from varishold.sensor import Logarithmic, Sensor
from varishold.touch import Contact, find_contacts, recognize

FINAL_SEED = 1972
DEVELOPMENT_SEED = 1
PER_KIND = 40
QUICK_PER_KIND = 10
NOISE = {32: 0.01, 16: 0.02}
SIDES = (32, 16)
SURE = 0.9
OUTLINE = {
    "cylinder": "round",
    "frustum of a cone": "round",
    "sphere": "round",
    "cone": "round",
    "square pillar": "square",
    "frustum of a pyramid": "square",
    "pyramid": "square",
    "rectangular pillar": "oblong",
    "ridge": "oblong",
    "lying cylinder": "oblong",
    "edge": "edge",
    "plane": "plane",
    "unknown": "unknown",
}
_CUT_OFF = {
    "cone": ("frustum of a cone",),
    "frustum of a cone": ("cone",),
    "pyramid": ("frustum of a pyramid",),
    "frustum of a pyramid": ("pyramid",),
}
_UPRIGHT = Change()


@dataclass(frozen=True)
class Row:
    """One fault or pose.

    Parameters
    ----------
    name : str
    before, after : tuple of Fault
        What happens before and after the white noise.
    change : Change
        What is done to the form and its place.
    bars : (float, float) or None
        Shares of right names that are wanted at 32 x 32 and 16 x 16.
    counted : bool
        Whether it enters the mean.
    wrong_bar : float
        Most that may be named wrong with p > .9.
    also : dict
        Other names that are as true, by the solid's name.
    sensor : callable, optional
        The sensor file that recognition is given, by the taxels a side.
    """

    name: str
    before: tuple[Fault, ...] = ()
    after: tuple[Fault, ...] = ()
    change: Change = _UPRIGHT
    bars: tuple[float, float] | None = None
    counted: bool = True
    wrong_bar: float = 0.01
    also: dict[str, tuple[str, ...]] = field(default_factory=dict)
    sensor: Callable[[int], Sensor] | None = None


def _row(name: str, *before: Fault, bars: tuple[float, float] | None = None, **options: Any) -> Row:
    return Row(name, before, bars=bars, **options)


def _bad_sensor(side: int) -> Sensor:
    """Return the sensor of the bad mix, as far as a sensor file can say it."""
    # The share of a taxel's own stress that reaches each neighbour, where the sum is kept.
    leak = 0.12 / (1 + 4 * 0.12)
    gains = faults.gain_map(side, 0.10)
    response = Logarithmic(5.0)
    return Sensor(shape=(side, side), span=1.0, crosstalk=leak, gains=gains, dead_band=0.10, response=response)


_F = faults
ROWS = (
    _row("clean", bars=(0.99, 0.95)),
    _row("gain spread 5 %", partial(_F.gains, spread=0.05)),
    _row("gain spread 10 %", partial(_F.gains, spread=0.10), bars=(0.96, 0.89)),
    _row("gain spread 20 %", partial(_F.gains, spread=0.20), bars=(0.90, 0.80)),
    _row("offsets 6 %", partial(_F.offsets, spread=0.06), bars=(0.98, 0.90)),
    _row("sloping rest 15 %", partial(_F.slope, rise=0.15), bars=(0.99, 0.97)),
    _row("ghosts 15 %", partial(_F.ghosts, share=0.15), bars=(0.97, 0.94)),
    _row("memory of a quarter", partial(_F.memory, share=0.25), bars=(0.96, 0.92)),
    _row("dead taxels 2 %", partial(_F.dead, share=0.02)),
    _row("dead taxels 5 %", partial(_F.dead, share=0.05), bars=(0.98, 0.93)),
    _row("dead line", _F.dead_line, bars=(0.98, 0.88)),
    _row("logarithmic a = 5", partial(_F.logarithm, a=5.0), bars=(0.88, 0.78), wrong_bar=0.02),
    _row("power .5", partial(_F.power, exponent=0.5)),
    _row("power 2", partial(_F.power, exponent=2.0)),
    Row("saturated at 80 %", (), (partial(_F.saturated, at=0.8),), bars=(0.88, 0.79)),
    Row("saturated at half", (), (partial(_F.saturated, at=0.5),), bars=(0.83, 0.70), also=_CUT_OFF),
    _row("dead zone 10 %", partial(_F.dead_zone, below=0.10)),
    _row("dead zone 30 %", partial(_F.dead_zone, below=0.30), bars=(0.98, 0.93)),
    _row("tilt 5 degrees", change=Change(tilt=5.0), bars=(0.96, 0.91)),
    _row("tilt 10 degrees", change=Change(tilt=10.0), bars=(0.90, 0.82)),
    _row("rounded by a quarter", change=Change(rounding=0.25), bars=(0.89, 0.82), wrong_bar=0.05),
    _row(
        "rounded by half",
        change=Change(rounding=0.5),
        bars=(0.62, 0.52),
        wrong_bar=0.12,
        also={"cylinder": ("sphere",)},
    ),
    _row("cut by the border 15 %", change=Change(cut=0.15), bars=(0.96, 0.90)),
    _row("cut by the border 30 %", change=Change(cut=0.30), bars=(0.94, 0.90)),
    _row("cut by the border 50 %", change=Change(cut=0.50), bars=(0.95, 0.80)),
    Row("six counts", (), (partial(_F.counts, n=6),), bars=(0.97, 0.90)),
    Row("15 counts", (), (partial(_F.counts, n=15),)),
    _row("crosstalk 12 %", partial(_F.crosstalk, share=0.12)),
    _row("pink 5 %", partial(_F.pink, spread=0.05)),
    Row(
        "plausible mix",
        (partial(_F.crosstalk, share=0.12), partial(_F.gains, spread=0.05), partial(_F.pink, spread=0.05)),
        (partial(_F.counts, n=255),),
        bars=(0.98, 0.93),
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
        bars=(0.82, 0.73),
    ),
    _row(
        "logarithm, known",
        partial(_F.logarithm, a=5.0),
        bars=(0.98, 0.95),
        counted=False,
        sensor=lambda _: Sensor(response=Logarithmic(5.0), span=1.0),
    ),
    Row(
        "saturated at 80 %, known",
        (),
        (partial(_F.saturated, at=0.8),),
        bars=(0.98, 0.94),
        counted=False,
        sensor=lambda _: Sensor(saturation=0.8, span=1.0),
    ),
    Row(
        "saturated at half, known",
        (),
        (partial(_F.saturated, at=0.5),),
        counted=False,
        also=_CUT_OFF,
        sensor=lambda _: Sensor(saturation=0.5, span=1.0),
    ),
    Row(
        "bad mix, known",
        (
            partial(_F.crosstalk, share=0.12),
            partial(_F.known_gains, spread=0.10),
            partial(_F.dead_zone, below=0.10),
            partial(_F.logarithm, a=5.0),
        ),
        (partial(_F.counts, n=60),),
        bars=(0.97, 0.88),
        counted=False,
        sensor=_bad_sensor,
    ),
    _row("stretch 1.25", partial(_F.stretch, ratio=1.25), counted=False),
    _row("blur 1 taxel", partial(_F.blur, taxels=1.0), counted=False),
    _row("blur 2 taxels", partial(_F.blur, taxels=2.0), counted=False),
    _row("gain spread 30 %", partial(_F.gains, spread=0.30), counted=False),
)
MEAN_BARS = {"pooled": (0.95, 0.90), "half-space": (None, None)}
OUTLINE_BARS = (0.985, 0.975)
SET_BARS = (1.4, 1.9)


@dataclass
class Tally:
    """Answers given to frames of one row."""

    own: list[bool] = field(default_factory=list)
    highest: list[bool] = field(default_factory=list)
    right: list[bool] = field(default_factory=list)
    outlined: list[bool] = field(default_factory=list)
    outline_probability: list[float] = field(default_factory=list)
    unknown: list[bool] = field(default_factory=list)
    probability: list[float] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)
    set_size: list[int] = field(default_factory=list)
    confused: dict[str, int] = field(default_factory=dict)

    def add(self, truth: tuple[str, ...], answer: Answer) -> None:
        """Add one answer; the first of `truth` is the solid's own name."""
        self.own.append(answer.name == truth[0])
        self.right.append(answer.name in truth)
        self.highest.append(answer.highest in truth)
        self.outlined.append(answer.outline in {OUTLINE[name] for name in truth})
        self.outline_probability.append(answer.outline_probability)
        self.unknown.append(answer.name == "unknown")
        self.probability.append(answer.probability)
        self.held.append(any(name in answer.answer_set for name in truth))
        self.set_size.append(len(answer.answer_set))
        if answer.name not in truth:
            pair = f"{truth[0]} as {answer.name}"
            self.confused[pair] = self.confused.get(pair, 0) + 1

    def figures(self) -> dict[str, Any]:
        """Return the shares."""
        p = np.array(self.probability)
        named_wrong = ~np.array(self.right) & ~np.array(self.unknown)
        return {
            "frames": len(p),
            "right": float(np.mean(self.right)),
            "own_name": float(np.mean(self.own)),
            "highest": float(np.mean(self.highest)),
            "outline": float(np.mean(self.outlined)),
            "unknown": float(np.mean(self.unknown)),
            "wrong_sure": float(np.mean(named_wrong & (p > SURE))),
            "set_holds": float(np.mean(self.held)),
            "set_size": float(np.mean(self.set_size)),
            "confused": dict(sorted(self.confused.items(), key=lambda item: -item[1])[:5]),
        }


@dataclass(frozen=True)
class Answer:
    """What recognition says of a frame's largest contact, ridge and hip as one; the number of contacts, and the name of
    the one that stands highest."""

    name: str
    probability: float
    outline: str
    outline_probability: float
    answer_set: tuple[str, ...]
    contacts: int
    highest: str


def answer_of(frame: np.ndarray, **options: Any) -> Answer:
    """Return the answer for the largest contact; unknown where there is none."""
    contacts = find_contacts(frame, **options)
    if not contacts:
        return Answer("unknown", 1.0, "unknown", 1.0, ("unknown",), 0, "unknown")
    answer, highest = answer_to(contacts[0], len(contacts)), max(contacts, key=lambda contact: contact.peak)
    return answer if highest is contacts[0] else replace(answer, highest=answer_to(highest).name)


def answer_to(contact: Contact, contacts: int = 1) -> Answer:
    """Return the answer for a contact of a frame that has so many."""
    surface = recognize(contact)
    names: dict[str, float] = {}
    for name, p in surface.names.items():
        names[as_one(name)] = names.get(as_one(name), 0.0) + p
    outline, outline_p = _outline(surface, names)
    answer_set = _answer_set(surface, names)
    name = as_one(surface.name)
    return Answer(name, surface.probability, outline, outline_p, answer_set, contacts, name)


def as_one(name: str) -> str:
    return "ridge" if name == "hip" else name


def _outline(surface: Any, names: dict[str, float]) -> tuple[str, float]:
    """Return the answer's outline, or the one that its names make."""
    if hasattr(surface, "outline"):
        return surface.outline, surface.outline_probability
    shares = {outline: sum(p for n, p in names.items() if OUTLINE[n] == outline) for outline in set(OUTLINE.values())}
    best = max(sorted(shares), key=shares.__getitem__)
    return best, shares[best]


def _answer_set(surface: Any, names: dict[str, float]) -> tuple[str, ...]:
    """Return the answer's 90 % set, or the fewest of its names that hold as much."""
    if hasattr(surface, "answer_set"):
        return tuple(dict.fromkeys(as_one(name) for name in surface.answer_set))
    ordered = sorted(names.items(), key=lambda item: -item[1])
    held = np.cumsum([p for _, p in ordered])
    return tuple(name for name, _ in ordered[: int(np.searchsorted(held, 0.9)) + 1])


def readings(row: Row, medium: str, side: int, per_kind: int, seed: int) -> tuple[np.ndarray, list[tuple[str, ...]]]:
    """Return the frames of one row and what is true of each, the solid's own name first."""
    clean, kinds = frames(medium, side, row.change, per_kind, seed)
    rng = np.random.default_rng([seed, side, len(medium), *row.name.encode()])
    read = clean
    for fault in (*row.before, partial(faults.noise, spread=NOISE[side]), *row.after):
        read = fault(read, rng)
    return read, [_truth(row, as_one(kind), frame) for kind, frame in zip(kinds.tolist(), clean, strict=True)]


def _truth(row: Row, kind: str, clean: np.ndarray) -> tuple[str, ...]:
    if kind == "plane" and row.change.tilt > 0:
        return ("plane", "edge") if clean.min() > 0 else ("edge",)
    return (kind, *row.also.get(kind, ()))


def measure(row: Row, media: Sequence[str], side: int, per_kind: int, seed: int) -> Tally:
    """Return the answers for one row's frames of some media."""
    tally = Tally()
    options = {} if row.sensor is None else {"sensor": row.sensor(side)}
    for medium in media:
        for frame, truth in zip(*readings(row, medium, side, per_kind, seed), strict=True):
            tally.add(truth, answer_of(frame, **options))
    return tally


def calibration_error(p: np.ndarray, right: np.ndarray) -> float:
    """Return the expected calibration error in ten even bins."""
    bins = np.minimum((p * 10).astype(int), 9)
    return float(sum(abs(right[bins == b].mean() - p[bins == b].mean()) * (bins == b).mean() for b in np.unique(bins)))


def table(
    rows: Sequence[Row], media: Sequence[str], side: int, per_kind: int, seed: int, title: str, mean_bar: float | None
) -> None:
    """Measure and print one table."""
    which = SIDES.index(side)
    print(
        f"\n{title}, {side} x {side}, noise {NOISE[side]:.0%}, {13 * per_kind * len(media)} frames a row, seed {seed}"
    )
    result: dict[str, Any] = {}
    p: list[float] = []
    right: list[bool] = []
    for row in rows:
        tally = measure(row, media, side, per_kind, seed)
        figures = result[row.name] = tally.figures() | {"counted": row.counted}
        bar = row.bars[which] if row.bars and mean_bar is not None else None
        name = row.name + ("" if row.counted else " *")
        _print_row(f"{title}, {side} x {side}", name, figures, bar, row.wrong_bar)
        if row.counted:
            p += tally.probability
            right += tally.right
    counted = [result[row.name] for row in rows if row.counted]
    if counted:
        keys = ("right", "own_name", "highest", "outline", "unknown", "wrong_sure", "set_holds", "set_size")
        mean = {key: float(np.mean([figures[key] for figures in counted])) for key in keys}
        error = calibration_error(np.array(p), np.array(right))
        said = figure(f"{title}, {side} x {side}: calibration error", error, ".3f", bar="<= .03")
        _print_row(f"{title}, {side} x {side}", "MEAN of counted rows", mean, mean_bar, 0.007)
        print(
            f"  calibration error over all counted rows {said}; "
            f"bars of the mean: outline {100 * OUTLINE_BARS[which]:.1f}, set holds 95, size {SET_BARS[which]}"
        )


#: What is printed of a row, and in which words.
_SHOWN = {
    "right": "right",
    "own_name": "own name",
    "highest": "highest",
    "outline": "outline",
    "unknown": "unknown",
    "wrong_sure": "wrong with p > .9",
    "set_holds": "set holds",
}


def _print_row(of: str, name: str, f: dict[str, Any], bar: float | None, wrong_bar: float) -> None:
    bars = {"right": f">= {100 * bar:.0f}" if bar else "", "wrong_sure": f"<= {100 * wrong_bar:.1f}"}
    shown = dict(_SHOWN)
    if f["highest"] <= f["right"] + 0.005:
        del shown["highest"]
    if f["own_name"] >= f["right"] - 1e-9:
        del shown["own_name"]
    said = [
        f"{words} {share(f'{of}, {name}: {words}', f[key], '5.1f', bar=bars.get(key, ''))}"
        for key, words in shown.items()
    ]
    size = figure(f"{of}, {name}: set size", f["set_size"], ".2f", "names")
    print(f"  {name:24} {'  '.join(said)}  set of {size}")


def main(argv: Sequence[str] = ()) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=FINAL_SEED, help="default: the last word's; 1: for development")
    parser.add_argument("--quick", action="store_true", help="a quarter of the frames, no half-space")
    parser.add_argument("--side", type=int, choices=SIDES, action="append", help="only pads of this many taxels a side")
    parser.add_argument("--row", action="append", help="only rows whose name holds this")
    parser.add_argument("--no-half-space", action="store_true")
    asked = parser.parse_args(list(argv))
    per_kind = QUICK_PER_KIND if asked.quick else PER_KIND
    rows = [row for row in ROWS if not asked.row or any(part in row.name for part in asked.row)]
    for side in asked.side or SIDES:
        which = SIDES.index(side)
        table(
            rows,
            ("ideal", "cover"),
            side,
            per_kind,
            asked.seed,
            "Height maps and thin covers",
            MEAN_BARS["pooled"][which],
        )
        if not (asked.quick or asked.no_half_space):
            table(rows, ("half-space",), side, per_kind, asked.seed, "Half-space (bar of the clean row 96 / 94)", None)


if __name__ == "__main__":
    main(sys.argv[1:])
