"""The page of an evaluation read back: charts, matrix, tables and words against the figures that they tell."""

from __future__ import annotations

import html
import math
import re
from dataclasses import replace
from itertools import pairwise
from xml.etree.ElementTree import Element

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.evaluation_made import made
from tests.reading_svg import box_of, drawn, of_class, paths_of, said

from varishold.evaluation import Evaluation, Figure
from varishold.evaluation.result import StrangerScore
from varishold.evaluation.shots import Shots
from varishold.report import render_evaluation_report
from varishold.report.confusion_map import MOST_SHOWN
from varishold.report.evaluation_words import between, figure_lines, interval, over, points
from varishold.report.quantities import number, percent
from varishold.report.share_chart import Point, Series, share_chart

# ---- charts of shares


class Axes:
    """The axes of a chart, by what is written beside them."""

    def __init__(self, root: Element) -> None:
        ticks = [t for t in root.iter("text") if t.get("text-anchor") == "end"]
        self.shares = [float("".join(t.itertext()).removesuffix("\u202f%")) / 100 for t in ticks]
        self.heights = [float(t.get("y", 0)) - 3.5 for t in ticks]
        rules = [box_of(root, each) for each in (*of_class(root, "base"), *of_class(root, "rule"))]
        assert [box[1] for box in rules] == pytest.approx(self.heights, abs=0.06)
        assert len(of_class(root, "base")) == 1
        self.left, self.right = rules[0][0], rules[0][2]

    def x(self, at: float) -> float:
        return (at - self.left) / (self.right - self.left)

    def y(self, at: float) -> float:
        (low, y0), (high, y1) = ((self.shares[k], self.heights[k]) for k in (0, -1))
        return low + (high - low) * (at - y0) / (y1 - y0)


def spots(root: Element) -> list[tuple[float, float, float]]:
    return [(float(s.get("cx", 0)), float(s.get("cy", 0)), float(s.get("r", 0))) for s in of_class(root, "spot")]


SHARES = st.floats(0, 1)


@given(st.lists(st.tuples(SHARES, SHARES, SHARES, SHARES), min_size=1, max_size=5), st.booleans(), st.integers(1, 20))
@settings(max_examples=40)
def test_points_intervals_and_lines_stand_where_the_axes_say(
    rows: list[tuple[float, float, float, float]], line: bool, twentieths: int
) -> None:
    top = twentieths / 20
    mine = [Point(x, y * top, min(a, b) * top, max(a, b), 2 + x, f"<{k}>") for k, (x, y, a, b) in enumerate(rows)]
    other = [Point(x, y * top) for x, y, *_ in rows]
    root = drawn(
        share_chart(
            [Series("ours", mine, line=line), Series("peer", other)],
            x_ticks=[(0.0, "none"), (0.5, "half"), (1.0, "all")],
            y_top=top,
            x_name="way & place",
            label="a <label>",
            diagonal=line,
        )
    )
    axes = Axes(root)
    _, _, wide, high = map(float, root.get("viewBox", "").split())
    # The smallest of the round steps that needs no more than five of them, from nothing on.
    step = next(s for s in (0.01, 0.02, 0.05, 0.1, 0.2, 0.25) if top / s <= 5 + 1e-12)
    assert axes.shares == pytest.approx([k * step for k in range(len(axes.shares))])
    assert 0 <= top - axes.shares[-1] < step - 1e-9
    assert axes.heights[0] > axes.heights[-1] > 0
    assert axes.y(12) == pytest.approx(top, abs=0.002)
    groups = list(root.iter("g"))
    # What is ours is painted last, over the others.
    assert [g.get("class") for g in groups] == ["peer", "ours"]
    for group, given_points, joined in zip(groups, (other, mine), (True, line), strict=True):
        found = spots(group)
        assert [axes.x(x) for x, _, _ in found] == pytest.approx([p.x for p in given_points], abs=0.001)
        assert [axes.y(y) for _, y, _ in found] == pytest.approx([p.y for p in given_points], abs=0.001)
        assert [r for _, _, r in found] == pytest.approx([p.radius for p in given_points], abs=0.06)
        told = [title.text for title in group.iter("title")]
        assert told == [p.says for p in given_points if p.says]
        lines = of_class(group, "line")
        assert len(lines) == (joined and len(given_points) > 1)
        for one in lines:
            np.testing.assert_allclose(paths_of(one.get("d"))[0], [(x, y) for x, y, _ in found], atol=0.01)
        ends = [box_of(root, each) for each in of_class(group, "ends")]
        known = [p for p in given_points if p.low is not None]
        for box, point in zip(ends, known, strict=True):
            assert axes.x(box[0]) == axes.x(box[2]) == pytest.approx(point.x, abs=0.001)
            assert axes.y(box[3]) == pytest.approx(point.low, abs=0.001)
            assert axes.y(box[1]) == pytest.approx(min(point.high, top), abs=0.001)
    chords = of_class(root, "chord")
    assert len(chords) == line
    for chord in chords:
        ((x0, y0), (x1, y1)) = paths_of(chord.get("d"))[0]
        assert (axes.x(x0), axes.y(y0), axes.x(x1), axes.y(y1)) == pytest.approx((0, 0, 1, 1), abs=0.003)
    below = [t for t in root.iter("text") if t.get("text-anchor") == "middle"]
    assert ["".join(t.itertext()) for t in below] == ["none", "half", "all", "way & place"]
    assert [axes.x(float(t.get("x", 0))) for t in below] == pytest.approx([0, 0.5, 1, 0.5], abs=0.001)
    heights = [float(t.get("y", 0)) for t in below]
    assert heights[0] == heights[1] == heights[2]
    assert axes.heights[0] + 9 < heights[0] < heights[3] - 9
    assert heights[3] <= high - 4
    assert 0 < axes.left < axes.right < wide
    assert root.get("aria-label") == "a <label>"


def test_an_interval_with_one_end_is_not_drawn() -> None:
    half_known = [Point(0.5, 0.5, 0.2, None), Point(0.5, 0.5, None, 0.8)]
    root = drawn(share_chart([Series("ours", half_known)], x_ticks=[], x_name="", label=""))
    assert of_class(root, "ends") == []


# ---- the page's own charts


def panes(page: str) -> list[tuple[str, Element, str]]:
    """Return heading, chart and words of each pane."""
    found = re.findall(r"<h3>([^<]*)</h3>(<svg.*?</svg>)<figcaption><span>(.*?)</span></figcaption>", page, re.DOTALL)
    return [(heading, drawn(picture), words) for heading, picture, words in found]


@pytest.mark.parametrize("n_things", [2, 3, 9])
def test_the_pages_charts_hold_the_evaluations_figures(n_things: int) -> None:
    found = made(n_things)
    (trust, kept, _), (many, learned, keys), (buys, refused, _) = panes(render_evaluation_report(found, title="t"))
    assert (trust[:22], many[:8], buys[:9]) == ("Do probabilities keep ", "How many", "What does")
    axes, bins = Axes(kept), found.scores.reliability
    assert [axes.x(x) for x, _, _ in spots(kept)] == pytest.approx([b.probability for b in bins], abs=0.001)
    assert [axes.y(y) for _, y, _ in spots(kept)] == pytest.approx([b.right for b in bins], abs=0.001)
    ends = [box_of(kept, each) for each in of_class(kept, "ends")]
    assert [(axes.y(e[3]), axes.y(e[1])) for e in ends] == [pytest.approx((b.low, b.high), abs=0.001) for b in bins]
    # A dot's radius grows with the root of its answers; the largest has 7.5, and none is below 2.5.
    radii, most = [r for _, _, r in spots(kept)], max(b.n for b in bins)
    assert radii == pytest.approx([2.5 + 5 * math.sqrt(b.n / most) for b in bins], abs=0.06)
    assert [t.text for t in kept.iter("title")] == [
        f"{b.n} answer{'s' * (b.n != 1)}: stated {percent(b.probability)}, right {percent(b.right)}" for b in bins
    ]
    assert not of_class(kept, "line")
    assert len(of_class(kept, "chord")) == 1
    # Shots: doubling the presses is the same way everywhere.
    axes = Axes(learned)
    assert [text for text in said(learned) if text.isdigit()] == [str(one.presses) for one in found.shots]
    at = {
        int("".join(t.itertext())): axes.x(float(t.get("x", 0)))
        for t in learned.iter("text")
        if "".join(t.itertext()).isdigit()
    }
    places = [(math.log(one.presses), at[one.presses]) for one in found.shots]
    slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(places)]
    assert slopes == pytest.approx([slopes[0]] * len(slopes), abs=0.01)
    assert (places[0][1], places[-1][1]) == pytest.approx((0.06, 0.94), abs=0.001)
    for kind in ("ours", "peer"):
        (group,) = of_class(learned, kind)
        told = [(one.presses, one.right if kind == "ours" else one.peer) for one in found.shots]
        known = [(presses, figure) for presses, figure in told if figure is not None]
        assert [axes.x(x) for x, _, _ in spots(group)] == pytest.approx([at[p] for p, _ in known], abs=0.001)
        assert [axes.y(y) for _, y, _ in spots(group)] == pytest.approx([f.value for _, f in known], abs=0.001)
        assert [t.text for t in group.iter("title")] == [percent(f.value) for _, f in known]
        assert len(of_class(group, "ends")) == (len(known) if kind == "ours" else 0)
        assert len(of_class(group, "line")) == 1
    assert re.findall(r'key (\w+)"></i>([^<]*)<', keys) == [("ours", "ours"), ("peer", "best peer")]
    axes, curve = Axes(refused), found.scores.refusals
    assert [axes.x(x) for x, _, _ in spots(refused)] == pytest.approx([share for share, _ in curve], abs=0.001)
    assert [axes.y(y) for _, y, _ in spots(refused)] == pytest.approx([e for _, e in curve], abs=0.001)
    # The axis ends at the next twentieth above the highest point.
    top = axes.y(12)
    assert top == pytest.approx(max(1, math.ceil(20 * max(e for _, e in curve) - 1e-9)) / 20, abs=0.002)
    for chart in (kept, refused):
        middles = [t for t in chart.iter("text") if t.get("text-anchor") == "middle"][:5]
        assert ["".join(t.itertext()) for t in middles] == [f"{p}\u202f%" for p in (0, 25, 50, 75, 100)]
        assert [Axes(chart).x(float(t.get("x", 0))) for t in middles] == pytest.approx(
            [0, 0.25, 0.5, 0.75, 1], abs=0.001
        )


def test_one_number_of_shots_stands_in_the_middle_and_no_peer_has_no_key() -> None:
    found = made(3)
    one = replace(found, shots=(Shots(5, found.scores.right, None),))
    _, (_, chart, words), _ = panes(render_evaluation_report(one, title="t"))
    ((x, y, _),) = spots(chart)
    axes = Axes(chart)
    assert (axes.x(x), axes.y(y)) == pytest.approx((0.5, found.scores.right.value), abs=0.001)
    assert "best peer" not in words
    assert "ours" in words
    sure = replace(found, scores=replace(found.scores, refusals=((0.0, 0.0), (0.5, 0.0))))
    assert Axes(panes(render_evaluation_report(sure, title="t"))[-1][1]).y(12) == pytest.approx(0.05, abs=0.001)


# ---- tables and words


def table(page: str, label: str) -> list[list[str]]:
    body = page[page.index(f'aria-label="{label}"') :].split("</table>")[0].split("<tbody>")[1]
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", body, re.DOTALL)
    return [
        [html.unescape(re.sub(r"<[^>]*>", "", cell)) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        for row in rows
    ]


def shown(figure: Figure) -> str:
    return f"{percent(figure.low or 0)} to {percent(figure.high or 0)}, over {figure.n_groups} groups"


@pytest.mark.parametrize("n_things", [2, 3, 9])
def test_every_figure_is_told_with_its_interval(n_things: int) -> None:
    found = made(n_things)
    s = found.scores
    rows = {row[0]: row[1:] for row in table(render_evaluation_report(found, title="t"), "Figures")}
    for name, figure in (
        ("right", s.right),
        ("given with p > .9", s.sure),
        ("right of these", s.sure_right),
        ("known things refused", s.refused),
        ("right where not refused", s.kept_right),
        ("strangers refused", found.strangers.refused if found.strangers else None),
    ):
        assert figure is not None
        assert rows[name][:2] == [percent(figure.value), interval(figure)]
        assert (figure.over == "groups") == (interval(figure) == shown(figure))
    assert rows["right"][2].endswith(f"one of {n_things} things gets {percent(1 / n_things)}")
    assert rows["right, mean over things"][0] == percent(s.macro_recall)
    assert rows["log loss"][0] == f"{number(s.log_loss.value, 2)} nats"
    low, high = max(s.log_loss.low or 0, 0.0), s.log_loss.high or 0
    assert rows["log loss"][1] == f"{number(low, 2)} to {number(high, 2)}, {over(s.log_loss)}"
    assert rows["log loss"][2].endswith(f"guessing gets {number(math.log(n_things), 2)}")
    assert rows["calibration error"][0] == f"{number(100 * s.calibration_error, 2)} points"
    assert rows["stated p less share right"][:2] == [
        f"{points(s.overstated.value)} points",
        interval(s.overstated, signed=True),
    ]
    curve = s.refusals
    nearest = [min(curve, key=lambda point: abs(point[0] - share))[1] for share in (0.1, 0.25, 0.5)]
    assert rows["errors left"][0].split(" / ") == [percent(errors) for errors in nearest]
    assert rows["strangers refused, at equal refusals"][0] == percent(0.5)
    assert rows["strangers refused, at equal refusals"][2].endswith("asked for, 5\u202f%")
    assert rows["strangers refused"][2] == "things left out of learning: 1"
    assert rows["known things refused"][2] == "asked for were 5\u202f%"


def test_what_is_not_known_has_no_line() -> None:
    found = made(3)
    names = lambda evaluation: [line.name for line in figure_lines(evaluation)]  # noqa: E731
    whole = names(found)
    assert len(whole) == len(set(whole)) == 12
    without = replace(found, scores=replace(found.scores, sure_right=None, kept_right=None))
    assert [name for name in whole if name not in names(without)] == ["right of these", "right where not refused"]
    nobody = replace(found.scores, refused=replace(found.scores.refused, value=0.0))
    assert "right where not refused" not in names(replace(found, scores=nobody))
    plain = replace(found, error=None)
    assert "strangers refused, at equal refusals" not in names(plain)
    (asked,) = (line.says for line in figure_lines(plain) if line.name == "known things refused")
    assert asked == "called none of these"
    unlike = replace(found, strangers=StrangerScore(found.scores.right, None, ("a", "b")), unheard=found.strangers)
    told = {line.name: line.says for line in figure_lines(replace(unlike, split="none"))}
    assert told["strangers refused"] == "things that it does not know: 2"
    assert "strangers refused, at equal refusals" not in told
    assert told["things of one group refused"].endswith(": 1")
    assert "things of one group refused, at equal refusals" in told
    one_press = replace(found.scores, log_loss=Figure(0.3, None, None, None, 1, 0))
    (loss,) = (line for line in figure_lines(replace(found, scores=one_press)) if line.name == "log loss")
    assert loss.interval == ""
    for low, high in ((None, 0.5), (0.5, None)):
        half = Figure(0.5, low, high, "presses", 7, 0)
        assert between(half) == "no interval from one press"
        (loss,) = (
            line
            for line in figure_lines(replace(found, scores=replace(found.scores, log_loss=half)))
            if line.name == "log loss"
        )
        assert loss.interval == ""


def test_peers_stand_by_their_shares_ours_among_them() -> None:
    found = made(3)
    mine = replace(found.scores.right, value=0.75)
    found = replace(found, scores=replace(found.scores, right=mine))
    better = replace(found.peers[0], right=replace(found.scores.right, value=0.999), learner="oracle")
    worse = replace(found.peers[0], right=replace(found.scores.right, value=0.1), learner="die")
    page = render_evaluation_report(replace(found, peers=(worse, better)), title="t")
    rows = table(page, "Peers")
    assert [row[0] for row in rows] == ["moments, oracle", "ours", "moments, die"]
    for row, (figure, ahead) in zip(
        rows, ((better.right, better.ahead), (found.scores.right, None), (worse.right, worse.ahead)), strict=True
    ):
        assert row[1:3] == [percent(figure.value), between(figure)]
        ends = "" if ahead is None else f"{points(ahead.low or 0)} to {points(ahead.high or 0)}"
        assert row[3] == ("" if ahead is None else f"{points(ahead.value)} points ({ends})")
    shares = [float(p) for p in re.findall(r'class="bar" style="--p: ([\d.]+)"', page)]
    assert shares == pytest.approx([0.999, found.scores.right.value, 0.1], abs=1e-4)
    assert len(re.findall(r'<tr class="ours"><td>ours<', page)) == 1
    assert f"interval, {over(found.scores.right)}</th>" in page


def facts(evaluation: Evaluation) -> dict[str, str]:
    page = render_evaluation_report(evaluation, title="t")
    return dict(re.findall(r"<dt>([^<]*)</dt><dd>([^<]*)</dd>", page[: page.index("</header>")]))


def test_the_head_of_the_page_tells_how_it_was_done() -> None:
    found = made(3)
    assert facts(found) == {
        "tested": "what was learned here",
        "presses": "36",
        "things": "3",
        "groups": "mon, tue, wed",
        "held out": "each group held out once",
        "seed": "0",
    }
    for n, told in ((6, "0, 1, 2, 3, 4, 5"), (7, "7, as 0, 1, 2")):
        assert facts(replace(found, groups=tuple(str(k) for k in range(n))))["groups"] == told
    page = render_evaluation_report(found, title="t")
    assert f"interval {interval(found.scores.right)}</p>" in page


@pytest.mark.parametrize(("n", "numbered"), [(MOST_SHOWN, False), (MOST_SHOWN + 1, True)])
def test_a_matrix_of_some_things_alone_says_so(n: int, numbered: bool) -> None:
    page = render_evaluation_report(made(n), title="t")
    assert (f"the {MOST_SHOWN} with the most errors are drawn" in page) == numbered
    few = np.zeros((n, n), int)
    few[0, 0] = 1
    found = made(n)
    page = render_evaluation_report(replace(found, scores=replace(found.scores, confusion=few)), title="t")
    assert "with the most errors" not in page
    assert "Nothing was taken for anything else." in page
