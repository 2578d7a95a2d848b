"""The page of `varishold evaluate`: the figure, what flatters it, peers, confusions, and what probabilities say."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass

from markupsafe import Markup

from varishold._counted import counted
from varishold.evaluation import Evaluation
from varishold.report.confusion_map import confusion_map, confusions, shown_things
from varishold.report.evaluation_words import between, figure_lines, flatters, headline, interval, over, points
from varishold.report.page import render_page, write_page
from varishold.report.quantities import percent
from varishold.report.share_chart import Point, Series, share_chart
from varishold.report.wording import sentences

__all__ = ["render_evaluation_report", "write_evaluation_report"]

_QUARTERS = tuple((k / 4, f"{25 * k}\u202f%") for k in range(5))
_SPLITS = {
    "groups": "each group held out once",
    "neighbours": "blocks of neighbours in time",
    "none": "nothing was learned",
}
_TESTED = {"learned here": "what was learned here", "model": "a model", "shipped": "the shipped names"}


@dataclass(frozen=True)
class Pane:
    """A chart with a heading, what to read from it, and whose its lines are: a CSS class and a name each."""

    heading: str
    picture: Markup
    words: str
    keys: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Row:
    """A row of the table of peers."""

    name: str
    share: float
    text: str
    interval: str
    ahead: str
    ours: bool


def write_evaluation_report(path: str | os.PathLike[str], evaluation: Evaluation, *, title: str) -> None:
    """Write a self-contained page about an evaluation.

    Parameters
    ----------
    path : str or path-like
        The HTML file to write.
    evaluation : Evaluation
    title : str
        Heading.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_page(path, render_evaluation_report(evaluation, title=title))


def render_evaluation_report(evaluation: Evaluation, *, title: str) -> str:
    """Return the page that `write_evaluation_report` writes."""
    counts, things = evaluation.scores.confusion, evaluation.things
    shown = shown_things(counts)
    return render_page(
        "evaluation.html",
        title=title,
        headline=headline(evaluation),
        between=interval(evaluation.scores.right),
        over=over(evaluation.scores.right),
        spoilt=flatters(evaluation),
        facts=_facts(evaluation),
        warnings=sentences(leak.says for leak in evaluation.leaks),
        remarks=sentences(evaluation.remarks),
        lines=figure_lines(evaluation),
        peers=_peers(evaluation),
        matrix=confusion_map(counts, things),
        numbered=len(shown) < int((counts + counts.T).any(axis=1).sum()),
        n_shown=len(shown),
        confusions=confusions(counts, things),
        panes=[_reliability(evaluation), *_shots(evaluation), _refusals(evaluation)],
    )


def _facts(evaluation: Evaluation) -> list[tuple[str, str]]:
    groups = evaluation.groups
    named = ", ".join(groups) if len(groups) <= 6 else f"{len(groups)}, as {', '.join(groups[:3])}"
    return [
        ("tested", _TESTED[evaluation.tested]),
        ("presses", str(evaluation.n_presses)),
        ("things", str(len(evaluation.things))),
        ("groups", named or "none given"),
        ("held out", _SPLITS[evaluation.split]),
        ("seed", str(evaluation.seed)),
    ]


def _peers(evaluation: Evaluation) -> list[Row]:
    """Return ours among the peers, by their shares."""
    if not evaluation.peers:
        return []
    mine = evaluation.scores.right
    rows = [Row("ours", mine.value, percent(mine.value), between(mine), "", True)]
    for peer in evaluation.peers:
        ahead = f"{points(peer.ahead.value)} points ({between(peer.ahead, signed=True)})"
        right = peer.right
        rows.append(Row(peer.name, right.value, percent(right.value), between(right), ahead, False))
    return sorted(rows, key=lambda row: -row.share)


def _reliability(evaluation: Evaluation) -> Pane:
    bins = evaluation.scores.reliability
    most = max(one.n for one in bins)
    dots = [
        Point(
            one.probability,
            one.right,
            one.low,
            one.high,
            2.5 + 5 * math.sqrt(one.n / most),
            f"{counted(one.n, 'answer')}: stated {percent(one.probability)}, right {percent(one.right)}",
        )
        for one in bins
    ]
    chart = share_chart(
        [Series("ours", dots, line=False)],
        x_ticks=_QUARTERS,
        x_name="stated probability →",
        label="Share right over stated probability",
        diagonal=True,
    )
    return Pane(
        "Do probabilities keep their word?",
        chart,
        "Height: share right, with its interval; larger dots are more answers. On the dashed line stated probabilities "
        "are true; dots below it promise too much, above it too little.",
    )


def _shots(evaluation: Evaluation) -> list[Pane]:
    """Return the shots curve, where there is one."""
    if not evaluation.shots:
        return []
    steps = [one.presses for one in evaluation.shots]
    first, last = math.log(steps[0]), math.log(steps[-1])

    def at(presses: int) -> float:
        return 0.5 if last == first else 0.06 + 0.88 * (math.log(presses) - first) / (last - first)

    mine = [
        Point(at(one.presses), one.right.value, one.right.low, one.right.high, says=f"{percent(one.right.value)}")
        for one in evaluation.shots
        if one.right is not None
    ]
    best = [
        Point(at(one.presses), one.peer.value, says=percent(one.peer.value))
        for one in evaluation.shots
        if one.peer is not None
    ]
    chart = share_chart(
        [Series("ours", mine), Series("peer", best)],
        x_ticks=[(at(presses), str(presses)) for presses in steps],
        x_name="presses of each thing that were learned from →",
        label="Share right over the number of presses learned from",
    )
    words = "Height: share right. Where the curve still rises at its end, more presses will help."
    keys = (("ours", "ours"), *((("peer", "best peer"),) if best else ()))
    return [Pane("How many presses does it take?", chart, words, keys)]


def _refusals(evaluation: Evaluation) -> Pane:
    curve = evaluation.scores.refusals
    top = max(0.05, math.ceil(20 * max(errors for _, errors in curve)) / 20)
    chart = share_chart(
        [Series("ours", [Point(refused, errors, radius=2.2) for refused, errors in curve])],
        x_ticks=_QUARTERS,
        y_top=top,
        x_name="least sure answers refused →",
        label="Errors left over the share of answers refused",
    )
    return Pane(
        "What does refusing buy?",
        chart,
        "Height: errors among the answers that are left when the least sure ones are refused. Where the curve falls at "
        "once, probabilities know which answers are wrong.",
    )
