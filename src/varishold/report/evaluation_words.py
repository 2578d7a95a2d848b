"""What an evaluation found, in words: a line a figure, each with the leaks that spoil it."""

from __future__ import annotations

from dataclasses import dataclass

from varishold._counted import counted
from varishold.evaluation import Evaluation, Figure
from varishold.report.quantities import number, percent

__all__ = ["Line", "between", "figure_lines", "flatters", "headline", "interval", "over", "points"]

_REFUSED = (0.1, 0.25, 0.5)


@dataclass(frozen=True)
class Line:
    """A figure as a person reads it.

    Parameters
    ----------
    name : str
        What it is.
    value : str
    interval : str
        Where it may lie; empty where that is not known.
    says : str
        What to read from it.
    """

    name: str
    value: str
    interval: str
    says: str


def flatters(evaluation: Evaluation) -> str:
    """Return what stands beside every figure that leaks spoil; empty where no leak was found."""
    names = ", ".join(leak.name for leak in evaluation.leaks)
    return f"flatters: {names}" if names else ""


def headline(evaluation: Evaluation) -> str:
    """Return the one sentence that a page begins with."""
    how = {
        "groups": "in groups that nothing was learned from",
        "neighbours": "of presses that were held out, in sessions that were learned from",
        "none": "by the model that was given" if evaluation.tested == "model" else "by the shipped names",
    }[evaluation.split]
    return f"{percent(evaluation.scores.right.value)} right {how}"


def between(figure: Figure, *, signed: bool = False) -> str:
    """Return the ends of a share's interval, or of a difference's in points.

    Examples
    --------
    >>> between(Figure(0.9, 0.8, 0.95, "groups", 100, 5))
    '80\u202f% to 95\u202f%'
    """
    if figure.low is None or figure.high is None:
        return "no interval from one press"
    shown = points if signed else percent
    return f"{shown(figure.low)} to {shown(figure.high)}"


def over(figure: Figure) -> str:
    """Return what an interval is taken over.

    Examples
    --------
    >>> over(Figure(0.9, 0.8, 0.95, "groups", 100, 5))
    'over 5 groups'
    """
    n, what = (figure.n_groups, "group") if figure.over == "groups" else (figure.n, "press")
    return f"over {counted(n, what)}"


def interval(figure: Figure, *, signed: bool = False) -> str:
    """Return the ends of an interval, and what it is taken over."""
    return f"{between(figure, signed=signed)}, {over(figure)}"


def points(difference: float) -> str:
    """Return a difference of shares in points of percent, with its sign.

    Examples
    --------
    >>> points(0.0512), points(-0.01), points(0.0)
    ('+5.1', '−1', '0')
    """
    value = round(100 * difference, 1)
    return f"+{value:g}" if value > 0 else f"−{-value:g}" if value < 0 else "0"


def figure_lines(evaluation: Evaluation) -> list[Line]:
    """Return every figure with what it says, the most important first."""
    s = evaluation.scores
    n_things = len(evaluation.things)
    lines = [
        _share("right", s.right, f"of all answers; guessing one of {n_things} things gets {percent(1 / n_things)}"),
        Line("right, mean over things", percent(s.macro_recall), "", "as above, every thing counted alike"),
        Line(
            "log loss",
            f"{number(s.log_loss.value, 2)} nats",
            _nats(s.log_loss),
            f"0 is sure and right; guessing gets {number(_guessing(n_things), 2)}",
        ),
        Line(
            "calibration error",
            f"{number(100 * s.calibration_error, 2)} points",
            "",
            "how far stated probability and share right are apart, over ten steps of probability",
        ),
        Line(
            "stated p less share right",
            f"{points(s.overstated.value)} points",
            interval(s.overstated, signed=True),
            "above 0 it promises too much, below 0 too little",
        ),
        _share("given with p > .9", s.sure, "of all answers"),
    ]
    if s.sure_right is not None:
        lines.append(_share("right of these", s.sure_right, "of answers with p > .9"))
    lines.append(_share("known things refused", s.refused, _asked(evaluation)))
    if s.kept_right is not None and s.refused.value:
        lines.append(_share("right where not refused", s.kept_right, "of answers that were not refused"))
    left = " / ".join(percent(_errors_left(evaluation, share)) for share in _REFUSED)
    lines.append(Line("errors left", left, "", "among the others, were the least sure tenth / quarter / half refused"))
    return [*lines, *_stranger_lines(evaluation)]


def _errors_left(evaluation: Evaluation, share: float) -> float:
    """Return the share of errors where about so many of the least sure answers are refused."""
    return min(evaluation.scores.refusals, key=lambda point: abs(point[0] - share))[1]


def _stranger_lines(evaluation: Evaluation) -> list[Line]:
    lines = []
    left_out = "things left out of learning" if evaluation.split != "none" else "things that it does not know"
    for name, found, what in (
        ("strangers refused", evaluation.strangers, left_out),
        ("things of one group refused", evaluation.unheard, "unknown where their only group is held out; no errors"),
    ):
        if found is None:
            continue
        lines.append(_share(name, found.refused, f"{what}: {len(found.things)}"))
        if found.refused_alike is not None and evaluation.error is not None:
            lines.append(
                Line(
                    f"{name}, at equal refusals",
                    percent(found.refused_alike),
                    "",
                    f"were as many known presses refused as asked for, {percent(evaluation.error)}",
                )
            )
    return lines


def _share(name: str, figure: Figure, says: str) -> Line:
    return Line(name, percent(figure.value), interval(figure), says)


def _asked(evaluation: Evaluation) -> str:
    return "called none of these" if evaluation.error is None else f"asked for were {percent(evaluation.error)}"


def _nats(figure: Figure) -> str:
    if figure.low is None or figure.high is None:
        return ""
    return f"{number(max(figure.low, 0.0), 2)} to {number(figure.high, 2)}, {over(figure)}"


def _guessing(n_things: int) -> float:
    from math import log

    return log(n_things)
