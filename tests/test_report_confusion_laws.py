"""The confusion matrix read back: a square for every count, names that have room, the largest confusions in words."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.reading_svg import box_of, drawn, of_class

from varishold.report.confusion_map import MOST_SHOWN, confusion_map, confusions, shown_things


@pytest.mark.parametrize("letters", [3, 24, 25, 40])
@pytest.mark.parametrize(("n", "many"), [(1, 3.0), (3, 0.3), (6, 3.0), (16, 0.3), (17, 3.0), (30, 0.3), (45, 0.3)])
def test_a_matrix_has_a_square_for_every_count_in_its_row_and_column(n: int, many: float, letters: int) -> None:
    counts = np.random.default_rng((n, letters)).poisson(many, (n, n))
    names = [f"{k}".ljust(letters, "x") for k in range(n)]
    shown = shown_things(counts).tolist()
    there = [k for k in range(n) if counts[k].sum() + counts[:, k].sum() > 0]
    wrong = [counts[k].sum() + counts[:, k].sum() - 2 * counts[k, k] for k in range(n)]
    assert shown == sorted(shown)
    assert set(shown) <= set(there)
    assert len(shown) == min(len(there), MOST_SHOWN)
    assert min((wrong[k] for k in shown), default=0) >= max((wrong[k] for k in there if k not in shown), default=0)
    root = drawn(confusion_map(counts, names))
    _, _, wide, high = map(float, root.get("viewBox", "").split())
    assert root.get("style") == f"width: {wide:.0f}px"
    beside = [t for t in root.iter("text") if t.get("text-anchor") == "end"]
    above = [t for t in root.iter("text") if t.get("transform")]
    short = [names[k] if letters <= 24 else f"{names[k][:23]}…" for k in shown]
    assert ["".join(t.itertext()) for t in beside] == ["".join(t.itertext()) for t in above] == short
    rules = [box_of(root, each) for each in of_class(root, "rule")]
    assert len(rules) == len(shown) + 1
    if not shown:
        return
    left, top = rules[0][:2]
    cell = (rules[-1][1] - top) / len(shown)
    assert cell == pytest.approx(np.clip(760 / len(shown), 19, 44), abs=0.11)
    assert [r[1] for r in rules] == pytest.approx([top + k * cell for k in range(len(rules))], abs=0.11)
    assert [r[2] - r[0] for r in rules] == pytest.approx([cell * len(shown)] * len(rules), abs=0.2)
    for k, (row, column) in enumerate(zip(beside, above, strict=True)):
        assert float(row.get("y", 0)) == pytest.approx(top + (k + 0.5) * cell + 4, abs=0.3)
        assert float(row.get("x", 0)) == pytest.approx(left - 8, abs=0.1)
        x, y = float(column.get("x", 0)), float(column.get("y", 0))
        assert (x, y) == pytest.approx((left + (k + 0.5) * cell, top - 6), abs=1.5)
        assert column.get("transform") == f"rotate(-45 {x:.1f} {y:.1f})"
    # A letter is 6.6 units wide: names have the room that they need to the left, and on their slope above and beyond.
    length = 6.6 * min(letters, 24)
    assert 0 < left - 8 - length < 8
    assert 0 < top - 6 - length / math.sqrt(2) < 14
    assert 0 < wide - rules[0][2] - length / math.sqrt(2) < 14
    assert 0 < high - rules[-1][1] < 8
    cells = list(root.iter("rect"))
    numbers = of_class(root, "count")
    assert len(numbers) == (len(cells) if len(shown) <= 16 else 0)
    pairs = [(a, b) for a in shown for b in shown if counts[a, b]]
    for i, ((a, b), rect) in enumerate(zip(pairs, cells, strict=True)):
        share = counts[a, b] / counts[a].sum()
        x0, y0, x1, y1 = box_of(root, rect)
        at = (left + (shown.index(b) + 0.5) * cell, top + (shown.index(a) + 0.5) * cell)
        assert ((x0 + x1) / 2, (y0 + y1) / 2) == pytest.approx(at, abs=0.6)
        assert (x1 - x0, y1 - y0) == pytest.approx((cell - 2, cell - 2), abs=0.3)
        assert rect.get("class") == ("right" if a == b else "wrong")
        assert float(rect.get("fill-opacity", 0)) == pytest.approx(0.12 + 0.88 * share, abs=0.006)
        told = "told" if a == b else f"called {names[b]}"
        assert rect.find("title") is not None
        assert rect.findtext("title") == f"{names[a]} {told}: {counts[a, b]} of {counts[a].sum()}"
        if numbers:
            assert "".join(numbers[i].itertext()) == str(counts[a, b])
            # Light print on what is dark.
            assert ("light" in numbers[i].get("class", "").split()) == (share > 0.55)
            x, y = float(numbers[i].get("x", 0)), float(numbers[i].get("y", 0)) - 4
            assert (x, y) == pytest.approx(((x0 + x1) / 2, (y0 + y1) / 2), abs=0.11)
    assert f"Confusion matrix of {len(shown)} things" in root.get("aria-label", "")
    largest = sorted(((counts[a, b], a, b) for a in range(n) for b in range(n) if a != b and counts[a, b]),
                     key=lambda each: (-each[0], each[1], each[2]))  # fmt: skip
    for most in (1, 10):
        assert confusions(counts, names, most) == [
            (names[a], names[b], count, counts[a].sum()) for count, a, b in largest[:most]
        ]
