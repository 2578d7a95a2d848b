"""The page of an evaluation: every figure with what spoils it, readable with many things, safe with any name."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.evaluation_made import made

from varishold.evaluation import Figure, Leak
from varishold.report import render_evaluation_report, write_evaluation_report
from varishold.report.confusion_map import MOST_SHOWN, confusion_map, confusions, shown_things
from varishold.report.evaluation_words import figure_lines, headline, interval, points
from varishold.report.share_chart import Point, Series, share_chart

LEAK = Leak("untouched taxels", "taxels that nothing touches tell it")


def rows(page: str) -> list[str]:
    return re.findall(r"<tr[^>]*>(?:(?!</tr>).)*<td.*?</tr>", page, re.DOTALL)


def test_every_row_with_a_figure_names_what_spoils_it() -> None:
    page = render_evaluation_report(made(leaks=(LEAK,)), title="t")
    assert len(rows(page)) > 10
    assert all("flatters: untouched taxels" in row for row in rows(page))
    assert len(re.findall(r"<h2[^>]*>.*?flatters: untouched taxels", page)) == 4
    assert "Taxels that nothing touches tell it." in page
    assert "flatters" not in re.sub("what flatters a figure", "", render_evaluation_report(made(), title="t"))


def test_what_is_missing_is_left_out() -> None:
    plain = replace(made(), tested="model", split="none", peers=(), shots=(), strangers=None, error=None, groups=())
    page = render_evaluation_report(plain, title="t")
    assert "Beside plain peers" not in page
    assert "How many presses" not in page
    assert "right by the model that was given" in page
    assert "none given" in page


def test_pictures_are_well_formed_and_names_cannot_break_out(tmp_path: Path) -> None:
    found = made(names=("<script>alert(1)</script>", 'a "b" & c', "x" * 90))
    write_evaluation_report(tmp_path / "page.html", found, title="<b>t</b>")
    page = (tmp_path / "page.html").read_text()
    assert "<script>alert" not in page
    assert "<b>t</b>" not in page
    drawn = re.findall(r'<svg class="growth.*?</svg>', page, re.DOTALL)
    assert len(drawn) == 4
    for one in drawn:
        ElementTree.fromstring(one)
    assert "src=" not in page
    assert page == render_evaluation_report(found, title="<b>t</b>")


def test_the_matrix_of_few_things_has_numbers_and_of_many_those_with_most_errors() -> None:
    few = confusion_map(np.array([[8, 2], [0, 10]]), ["cup", "can"])
    assert re.findall(r'class="count[^>]*>(\d+)<', few) == ["8", "2", "10"]
    assert "cup called can: 2 of 10" in few
    counts = np.diag(np.full(60, 10))
    counts[50, 51] = 3
    shown = shown_things(counts)
    assert len(shown) == MOST_SHOWN
    assert {50, 51} <= set(shown.tolist())
    many = confusion_map(counts, [f"thing {k}" for k in range(60)])
    assert 'class="count' not in many
    sizes = [float(size) for size in re.findall(r'<rect class="right"[^>]*width="([\d.]+)"', many)]
    assert min(sizes) > 16


def test_things_that_were_neither_pressed_nor_said_are_not_drawn() -> None:
    counts = np.zeros((4, 4), int)
    counts[1, 2] = 3
    assert shown_things(counts).tolist() == [1, 2]
    assert confusions(counts, list("abcd")) == [("b", "c", 3, 3)]
    assert confusions(np.diag([1, 2]), ["a", "b"]) == []


def test_a_point_stands_where_its_share_says() -> None:
    chart = share_chart(
        [Series("ours", [Point(0.0, 0.0), Point(1.0, 0.5, 0.25, 1.0)])], x_ticks=[(0, "0")], x_name="x", label="l"
    )
    (x0, y0), (x1, y1) = re.findall(r'cx="([\d.]+)" cy="([\d.]+)"', chart)
    top, bottom = 12.0, 228.0
    assert (float(x0), float(y0)) == (46.0, bottom)
    assert (float(x1), float(y1)) == (346.0, (top + bottom) / 2)
    assert re.search(r'class="ends" d="M346.0 174.0V12.0"', chart)
    assert re.search(r'class="line" d="M46.0 228.0L346.0 120.0"', chart)


def test_words() -> None:
    found = made()
    names = [line.name for line in figure_lines(found)]
    assert names[0] == "right"
    assert "strangers refused, at equal refusals" in names
    curve = ((0.0, 0.4), (0.1, 0.3), (0.26, 0.2), (0.5, 0.0), (0.9, 0.0))
    some = replace(found, scores=replace(found.scores, refusals=curve))
    (left,) = (line.value for line in figure_lines(some) if line.name == "errors left")
    assert left == "30\u202f% / 20\u202f% / 0\u202f%"
    assert headline(found).endswith("right in groups that nothing was learned from")
    assert headline(replace(found, split="neighbours")).endswith("in sessions that were learned from")
    assert interval(Figure(0.5, 0.25, 0.75, "presses", 9, 0)) == "25\u202f% to 75\u202f%, over 9 presses"
    assert interval(Figure(0.5, None, None, None, 1, 0)).startswith("no interval from one press")
    assert interval(Figure(0.0, -0.1, 0.2, "groups", 9, 3), signed=True) == "−10 to +20, over 3 groups"


@pytest.mark.parametrize(("share", "told"), [(0.123, "+12.3"), (-0.0004, "0"), (-0.5, "−50")])
def test_points_have_a_sign(share: float, told: str) -> None:
    assert points(share) == told
