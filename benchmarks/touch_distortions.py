"""Names given to frames of faulty sensors and awkward poses: a row a fault or pose, by a generator of its own.

Frames are those of the public yardstick, `varishold.evaluation.yardstick`, which shares no drawing, no solver and no
sensor code with training, solids, skin or sensor; its `rows` say what is true of them. 13 kinds, as many frames each,
in every row; ridge and hip count as one name, whose probability is the sum of theirs, as in the yardstick's own score.
Names are those of the largest contact; no contact is "unknown". After a memory of the last press the largest contact
may be what is left of it; the share named right of the contacts that stand highest is printed behind the row
("highest").

Seeds: the default is for the last word and is not to be looked at while learning; `--seed 1` is.

Where two names are as true, the share with the solid's own name alone is printed behind the row ("own name").

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

from benchmarks._drawn_frames import frames
from benchmarks._figures import figure, share
from varishold.evaluation.yardstick import faults
from varishold.evaluation.yardstick.rows import NOISE, ROWS, Row, as_one, distorted
from varishold.sensor import Logarithmic, Sensor
from varishold.touch import Contact, find_contacts, recognize

FINAL_SEED = 1972
DEVELOPMENT_SEED = 1
PER_KIND = 40
QUICK_PER_KIND = 10
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
#: Shares of right names that are wanted of a row at 32 x 32 and 16 x 16.
BARS = {
    "clean": (0.99, 0.95),
    "gain spread 10 %": (0.96, 0.89),
    "gain spread 20 %": (0.90, 0.80),
    "offsets 6 %": (0.98, 0.90),
    "sloping rest 15 %": (0.99, 0.97),
    "ghosts 15 %": (0.97, 0.94),
    "memory of a quarter": (0.96, 0.92),
    "dead taxels 5 %": (0.98, 0.93),
    "dead line": (0.98, 0.88),
    "logarithmic a = 5": (0.88, 0.78),
    "saturated at 80 %": (0.88, 0.79),
    "saturated at half": (0.83, 0.70),
    "dead zone 30 %": (0.98, 0.93),
    "tilt 5 degrees": (0.96, 0.91),
    "tilt 10 degrees": (0.90, 0.82),
    "rounded by a quarter": (0.89, 0.82),
    "rounded by half": (0.62, 0.52),
    "cut by the border 15 %": (0.96, 0.90),
    "cut by the border 30 %": (0.94, 0.90),
    "cut by the border 50 %": (0.95, 0.80),
    "six counts": (0.97, 0.90),
    "plausible mix": (0.98, 0.93),
    "bad mix": (0.82, 0.73),
    "logarithm, known": (0.98, 0.95),
    "saturated at 80 %, known": (0.98, 0.94),
    "bad mix, known": (0.97, 0.88),
}
#: Most that may be named wrong with p > .9, where it is not 1 %.
WRONG_BARS = {"logarithmic a = 5": 0.02, "rounded by a quarter": 0.05, "rounded by half": 0.12}
_WRONG_BAR = 0.01


def _gain_map(side: int) -> np.ndarray:
    """Return the gains of one sensor, which somebody can know: a spread of 10 %."""
    return np.maximum(1 + 0.10 * np.random.default_rng(side).standard_normal((side, side)), 0.05)


def _known_gains(v: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Scale every taxel by its gain, the same in all frames."""
    del rng
    return v * _gain_map(v.shape[1])


def _bad_sensor(side: int) -> Sensor:
    """Return the sensor of the bad mix, as far as a sensor file can say it."""
    # The share of a taxel's own stress that reaches each neighbour, where the sum is kept.
    leak = 0.12 / (1 + 4 * 0.12)
    gains = _gain_map(side)
    response = Logarithmic(5.0)
    return Sensor(shape=(side, side), span=1.0, crosstalk=leak, gains=gains, dead_band=0.10, response=response)


_UNKNOWN = {row.name: row for row in ROWS}
_LOGARITHM = Logarithmic(5.0)
#: Rows whose sensor is known, with its file by the taxels a side; none is counted.
KNOWN: dict[str, tuple[Row, Callable[[int], Sensor]]] = {
    row.name: (row, sensor)
    for row, sensor in (
        (
            replace(_UNKNOWN["logarithmic a = 5"], name="logarithm, known", counted=False),
            lambda _: Sensor(response=_LOGARITHM, span=1.0),
        ),
        (
            replace(_UNKNOWN["saturated at 80 %"], name="saturated at 80 %, known", counted=False),
            lambda _: Sensor(saturation=0.8, span=1.0),
        ),
        (
            replace(_UNKNOWN["saturated at half"], name="saturated at half, known", counted=False),
            lambda _: Sensor(saturation=0.5, span=1.0),
        ),
        (
            Row(
                "bad mix, known",
                (
                    partial(faults.crosstalk, share=0.12),
                    _known_gains,
                    partial(faults.dead_zone, below=0.10),
                    partial(faults.logarithm, a=5.0),
                ),
                (partial(faults.counts, n=60),),
                counted=False,
            ),
            _bad_sensor,
        ),
    )
}
#: Every row in the order of the tables.
ALL_ROWS = (
    *(row for row in ROWS if row.counted),
    *(row for row, _ in KNOWN.values()),
    *(row for row in ROWS if not row.counted),
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
    name = max(names, key=names.__getitem__)
    return Answer(name, names[name], outline, outline_p, answer_set, contacts, name)


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
    return distorted(row, *frames(medium, side, row.change, per_kind, seed), medium, seed)


def measure(row: Row, media: Sequence[str], side: int, per_kind: int, seed: int) -> Tally:
    """Return the answers for one row's frames of some media."""
    tally = Tally()
    options = {"sensor": KNOWN[row.name][1](side)} if row.name in KNOWN else {}
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
        bar = BARS[row.name][which] if row.name in BARS and mean_bar is not None else None
        name = row.name + ("" if row.counted else " *")
        _print_row(f"{title}, {side} x {side}", name, figures, bar, WRONG_BARS.get(row.name, _WRONG_BAR))
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
    rows = [row for row in ALL_ROWS if not asked.row or any(part in row.name for part in asked.row)]
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
            clean = [row for row in rows if row is ROWS[0]]
            table(clean, ("surface",), side, per_kind, asked.seed, "Half-space read at its surface", None)


if __name__ == "__main__":
    main(sys.argv[1:])
