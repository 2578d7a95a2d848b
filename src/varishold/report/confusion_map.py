"""The confusion matrix: what was pressed, down, and what was said, across."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

__all__ = ["MOST_SHOWN", "confusion_map", "confusions", "shown_things"]

#: Of more things than these only those with the most errors are drawn.
MOST_SHOWN = 40
# Up to so many things the numbers stand in the cells.
_NUMBERED = 16
_LARGEST_CELL, _SMALLEST_CELL, _WIDEST = 44, 19, 760
_LETTER, _LONGEST = 6.6, 24


def shown_things(counts: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return which things are drawn, in their order: all, or those with the most errors."""
    counted = counts + counts.T
    there = np.flatnonzero(counted.sum(axis=1) > 0)
    if len(there) <= MOST_SHOWN:
        return there
    wrong = counted.sum(axis=1) - np.diag(counted)
    return np.sort(np.argsort(-wrong, kind="stable")[:MOST_SHOWN])


def confusion_map(counts: NDArray[np.intp], names: Sequence[str]) -> Markup:
    """Draw a confusion matrix.

    Parameters
    ----------
    counts : ndarray of shape (n_things, n_things), int
        Rows are the truth, columns what was said.
    names : sequence of str
    """
    shown = shown_things(counts)
    n = len(shown)
    short = [_short(names[k]) for k in shown]
    cell = float(np.clip(_WIDEST / max(n, 1), _SMALLEST_CELL, _LARGEST_CELL))
    room = _LETTER * max((len(name) for name in short), default=0) + 14
    # Names across stand on a slope: they need some of their length above and beyond the last column.
    top, beyond = 0.72 * room + 6, 0.7 * room
    totals = np.maximum(counts.sum(axis=1), 1)
    body = []
    for r, row in enumerate(shown):
        y = top + r * cell
        body.append(f'<path class="rule" d="M{room:.0f} {y:.1f}h{n * cell:.1f}"/>')
        body.append(f'<text x="{room - 8:.0f}" y="{y + cell / 2 + 4:.1f}" text-anchor="end">{escape(short[r])}</text>')
        x = room + (r + 0.5) * cell
        turned = f"rotate(-45 {x:.1f} {top - 6:.1f})"
        body.append(f'<text x="{x:.1f}" y="{top - 6:.1f}" transform="{turned}">{escape(short[r])}</text>')
        for c, column in enumerate(shown):
            if counts[row, column]:
                body.append(
                    _cell(room + c * cell, y, cell, counts, totals, (row, column), names, numbered=n <= _NUMBERED)
                )
    body.append(f'<path class="rule" d="M{room:.0f} {top + n * cell:.1f}h{n * cell:.1f}"/>')
    width, height = room + n * cell + beyond, top + n * cell + 4
    label = f"Confusion matrix of {n} things; the largest confusions are told in words below"
    return Markup(
        f'<svg class="growth confusion" viewBox="0 0 {width:.0f} {height:.0f}" style="width: {width:.0f}px" '
        f'role="img" aria-label="{escape(label)}">{"".join(body)}</svg>'
    )


def _cell(
    x: float,
    y: float,
    cell: float,
    counts: NDArray[np.intp],
    totals: NDArray[np.intp],
    at: tuple[int, int],
    names: Sequence[str],
    *,
    numbered: bool,
) -> str:
    count, share = int(counts[at]), counts[at] / totals[at[0]]
    kind = "right" if at[0] == at[1] else "wrong"
    said = "told" if kind == "right" else f"called {names[at[1]]}"
    told = f"{names[at[0]]} {said}: {count} of {int(totals[at[0]])}"
    drawn = (
        f'<rect class="{kind}" x="{x + 1:.1f}" y="{y + 1:.1f}" width="{cell - 2:.1f}" height="{cell - 2:.1f}" rx="2" '
        f'fill-opacity="{0.12 + 0.88 * share:.2f}"><title>{escape(told)}</title></rect>'
    )
    if numbered:
        kind = " light" if share > 0.55 else ""
        middle = f'x="{x + cell / 2:.1f}" y="{y + cell / 2 + 4:.1f}" text-anchor="middle"'
        drawn += f'<text class="count{kind}" {middle}>{count}</text>'
    return drawn


def confusions(counts: NDArray[np.intp], names: Sequence[str], most: int = 10) -> list[tuple[str, str, int, int]]:
    """Return the largest confusions: the thing, what it was called, how many of its presses, and of how many.

    Examples
    --------
    >>> confusions(np.array([[8, 2], [0, 10]]), ["cup", "can"])
    [('cup', 'can', 2, 10)]
    """
    wrong = counts.copy()
    np.fill_diagonal(wrong, 0)
    order = np.argsort(-wrong, axis=None, kind="stable")[:most]
    rows, columns = np.unravel_index(order, wrong.shape)
    totals = counts.sum(axis=1)
    return [
        (names[r], names[c], int(wrong[r, c]), int(totals[r]))
        for r, c in zip(rows.tolist(), columns.tolist(), strict=True)
        if wrong[r, c]
    ]


def _short(name: str) -> str:
    return name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}…"
