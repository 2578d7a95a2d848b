"""The score of a function that names frames."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError, Interrupted, require_a
from varishold.evaluation.figures import Figure, share_figure
from varishold.evaluation.scores import SURE, calibration_error
from varishold.evaluation.yardstick.answers import Told, outline_of, read_answer
from varishold.evaluation.yardstick.forms import KINDS, Change
from varishold.evaluation.yardstick.loading import exits_raised, what_was_raised
from varishold.evaluation.yardstick.media import clean_frames
from varishold.evaluation.yardstick.rows import NOISE, ROWS, Row, distorted

__all__ = [
    "FRAMES",
    "SEED",
    "SHAPES",
    "VERSION",
    "RowScore",
    "ShapeScore",
    "YardstickScore",
    "score_function",
    "score_functions",
]

Floats = NDArray[np.float64]
Function = Callable[[Floats], object]

#: Other frames, rows, truths or scores are another version.
VERSION = 1
#: With these, published figures are made: the seed, and frames of each form on each medium in every row.
SEED, FRAMES = 1972, 40
SHAPES = ((16, 16), (32, 32))
#: Height maps, and faces pressed into a thin elastic cover.
SCORED_MEDIA = ("ideal", "cover")


@dataclass(frozen=True)
class RowScore:
    """Shares of the frames of one row.

    Parameters
    ----------
    name : str
        The fault or pose, and its strength.
    counted : bool
        Whether it enters the score.
    frames : int
    right : float
        Named by a name that is true.
    outline : float
        Told by an outline that is true.
    unknown : float
        Called unknown, which no form is.
    sure_wrong : float
        Given a wrong name, not unknown, with p > .9.
    """

    name: str
    counted: bool
    frames: int
    right: float
    outline: float
    unknown: float
    sure_wrong: float


@dataclass(frozen=True)
class ShapeScore:
    """The rows of pads of one shape, and their score: means over the counted rows.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of taxels.
    noise : float
        Standard deviation of the white noise, in shares of the peak.
    rows : tuple of RowScore
    right : Figure
        With its 95 % interval, over the objects that are pressed; each is in every row.
    outline, unknown, sure_wrong : float
    calibration_error : float
        Mean distance of the stated probability and the share right over ten bins, of all answers of the counted rows.
    """

    shape: tuple[int, int]
    noise: float
    rows: tuple[RowScore, ...]
    right: Figure
    outline: float
    unknown: float
    sure_wrong: float
    calibration_error: float

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        low, high = self.right.low, self.right.high
        rows = [{"name": row.name, "counted": row.counted, "frames": row.frames} | _shares(row) for row in self.rows]
        score = _shares(self) | {
            "right_low": None if low is None else round(low, 6),
            "right_high": None if high is None else round(high, 6),
            "calibration_error": round(self.calibration_error, 6),
            "counted_rows": sum(row.counted for row in self.rows),
        }
        return {"shape": list(self.shape), "noise": self.noise, "rows": rows, "score": score}


@dataclass(frozen=True)
class YardstickScore:
    """What a function's answers to the yardstick's frames were worth.

    Parameters
    ----------
    tested : str
        The function.
    frames : int
        Frames of each form on each medium in a row.
    seed : int
    shapes : tuple of ShapeScore
    version : int
    """

    tested: str
    frames: int
    seed: int
    shapes: tuple[ShapeScore, ...]
    version: int = VERSION

    @property
    def standard(self) -> bool:
        """Whether the frames are those of published figures."""
        return (self.frames, self.seed) == (FRAMES, SEED)

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        return {
            "yardstick": "distortions",
            "version": self.version,
            "tested": self.tested,
            "standard": self.standard,
            "seed": self.seed,
            "frames_of_each_form": self.frames,
            "shapes": [one.to_dict() for one in self.shapes],
        }


def score_function(
    function: Callable[[Floats], Any],
    *,
    shapes: Sequence[tuple[int, int]] = SHAPES,
    frames: int = FRAMES,
    seed: int = SEED,
    batch: bool = False,
    tested: str = "function",
    tick: Callable[..., object] = lambda **_: None,
) -> YardstickScore:
    """Let a function name the yardstick's frames, and tell what its answers are worth.

    Parameters
    ----------
    function : callable
        Takes a frame, an ndarray of shape (rows, cols), float64, its peak about 1, and answers what `read_answer`
        takes: a name, or the probability of each name.
    shapes : sequence of (int, int)
        Some of `SHAPES`.
    frames : int
        Frames of each of 13 forms on each of two media in a row. Published figures are made with `FRAMES`.
    seed : int
        Published figures are made with `SEED`; take another while you work on a function.
    batch : bool
        Whether the function takes an ndarray of shape (n, rows, cols) instead, and answers a sequence of n answers.
    tested : str
        What messages and the result call the function.
    tick : callable
        Called with ``total=`` once, then with ``advance=`` as the work goes on.

    Raises
    ------
    InputError
        If the function raises, or answers something else: the message names the frame.
    """
    options: dict[str, Any] = {"shapes": shapes, "frames": frames, "seed": seed, "batch": batch, "tick": tick}
    return score_functions({tested: function}, **options)[0]


def score_functions(
    functions: Mapping[str, Callable[[Floats], Any]],
    *,
    shapes: Sequence[tuple[int, int]] = SHAPES,
    frames: int = FRAMES,
    seed: int = SEED,
    batch: bool = False,
    tick: Callable[..., object] = lambda **_: None,
) -> list[YardstickScore]:
    """Let several functions name the same frames, which are drawn once; all else is as for `score_function`.

    Parameters
    ----------
    functions : mapping of str to callable
        By what messages and the results call them.
    shapes, frames, seed, batch, tick
        As for `score_function`.

    Returns
    -------
    list of YardstickScore
        Of each function.

    Raises
    ------
    InputError
        As for `score_function`.
    """
    require_a(Mapping, functions, "functions", "each by what it is called")
    if not functions:
        raise InputError("functions must hold one function at least")
    for name, function in functions.items():
        if not callable(function):
            raise InputError(f"{name}: is no function but {type(function).__name__}")
    wanted = [tuple(each) if isinstance(each, Sequence) else each for each in shapes]
    if not wanted or any(each not in SHAPES for each in wanted):
        raise InputError(f"shapes must be some of {SHAPES}, got {tuple(wanted)}", parameter="shape")
    if not isinstance(frames, int | np.integer) or frames < 1:
        raise InputError(f"frames must be a whole number, 1 at least, got {frames!r}", parameter="frames")
    if not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed must be a whole number, 0 at least, got {seed!r}", parameter="seed")
    changes = tuple(dict.fromkeys(row.change for row in ROWS))
    each = len(changes) + len(functions) * len(ROWS)
    tick(total=len(shapes) * len(SCORED_MEDIA) * each * len(KINDS) * frames)
    asked = [_Asked(function, batch, name, frames, tick) for name, function in functions.items()]
    by_shape = [_shape_scores(asked, side, changes, frames, seed) for side, _ in shapes]
    return [
        YardstickScore(one.name, frames, seed, found)
        for one, found in zip(asked, zip(*by_shape, strict=True), strict=True)
    ]


@dataclass(frozen=True)
class _Asked:
    """A function, and how it is asked."""

    function: Function
    batch: bool
    name: str
    frames: int
    tick: Callable[..., object]

    def answers(self, read: Floats, where: str) -> list[Told]:
        """Return the answers to the frames of one row on one medium."""
        if self.batch:
            given = self._called(read.copy(), where)
            if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != len(read):
                raise InputError(f"{self.name}: must answer a list of {counted(len(read), 'answer')} to {where}")
        told = []
        for k, frame in enumerate(read):
            place = f"frame {k} of {where}"
            answer = given[k] if self.batch else self._called(frame.copy(), place)
            try:
                told.append(read_answer(answer))
            except InputError as error:
                raise InputError(f"{self.name}: {error}; it is the answer to {place}") from None
            except Exception as error:
                # An answer may be anything, and do anything when it is looked at.
                kind = type(answer).__name__
                raise InputError(
                    f"{self.name}: the answer to {place}, of type {kind}, cannot be read: {what_was_raised(error)}"
                ) from error
            if (k + 1) % self.frames == 0:
                self.tick(advance=self.frames)
        return told

    def _called(self, frames: Floats, place: str) -> Any:
        try:
            with exits_raised():
                return self.function(frames)
        except (KeyboardInterrupt, Interrupted):
            raise
        except BaseException as error:
            # Whatever somebody's code throws: it may even end the program.
            raise InputError(f"{self.name}: {what_was_raised(error)} at {place}") from error


def _shape_scores(
    asked: Sequence[_Asked], side: int, changes: Sequence[Change], frames: int, seed: int
) -> list[ShapeScore]:
    """Draw every row, let each function answer, and return what that was worth."""
    told: list[dict[str, list[Told]]] = [{row.name: [] for row in ROWS} for _ in asked]
    truths: dict[str, list[tuple[str, ...]]] = {row.name: [] for row in ROWS}
    tick = asked[0].tick
    for change in changes:
        for medium in SCORED_MEDIA:
            drawn = clean_frames(medium, side, change, frames, seed, tick=lambda: tick(advance=frames))
            for row in (row for row in ROWS if row.change == change):
                read, true = distorted(row, *drawn, medium, seed)
                truths[row.name] += true
                for one, answers in zip(asked, told, strict=True):
                    answers[row.name] += one.answers(read, f"row '{row.name}', {medium}, {side} x {side}")
    return [_shape_score(side, answers, truths) for answers in told]


def _shape_score(
    side: int, told: Mapping[str, Sequence[Told]], truths: Mapping[str, Sequence[tuple[str, ...]]]
) -> ShapeScore:
    rows = tuple(_row_score(row, told[row.name], truths[row.name]) for row in ROWS)
    counted = [row for row in rows if row.counted]
    right = np.array(
        [[one.name in true for one, true in zip(told[r.name], truths[r.name], strict=True)] for r in counted]
    )
    stated = np.array([[one.probability for one in told[row.name]] for row in counted])
    objects = np.tile(np.arange(right.shape[1]), len(counted))
    return ShapeScore(
        shape=(side, side),
        noise=NOISE[side],
        rows=rows,
        right=share_figure(right.ravel(), objects),
        outline=float(np.mean([row.outline for row in counted])),
        unknown=float(np.mean([row.unknown for row in counted])),
        sure_wrong=float(np.mean([row.sure_wrong for row in counted])),
        calibration_error=calibration_error(stated.ravel(), right.ravel()),
    )


def _row_score(row: Row, told: Sequence[Told], truths: Sequence[tuple[str, ...]]) -> RowScore:
    both = list(zip(told, truths, strict=True))
    return RowScore(
        name=row.name,
        counted=row.counted,
        frames=len(both),
        right=float(np.mean([one.name in true for one, true in both])),
        outline=float(np.mean([one.outline in outline_of(true) for one, true in both])),
        unknown=float(np.mean([one.name == "unknown" for one in told])),
        sure_wrong=float(
            np.mean([one.name not in (*true, "unknown") and one.probability > SURE for one, true in both])
        ),
    )


def _shares(one: RowScore | ShapeScore) -> dict[str, float]:
    """Return the shares that rows and scores have alike."""
    right = one.right if isinstance(one, RowScore) else one.right.value
    found = {"right": right, "outline": one.outline, "unknown": one.unknown, "sure_wrong": one.sure_wrong}
    return {name: round(value, 6) for name, value in found.items()}
