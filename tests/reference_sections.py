"""Contacts and sections in plain Python and numpy, slowly: what the kernel's are compared with.

Contacts come from a list of links: between neighbours in a row or column, and across a cell whose mean joins its two
high corners; a flat face that presses hardest at its rim is not split. Sections are cut one level at a time, cell by
cell, as polygons. Frames have no gaps, and no two values of them are equal.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

__all__ = ["Section", "contacts_of", "section_of"]

SPLIT_RATIO = 0.5
Links = list[tuple[float, tuple[int, int], tuple[int, int]]]


@dataclass(frozen=True)
class Section:
    """A section: its area, centroid and second moments about it, its outline's length and its widths."""

    area: float
    centroid: NDArray[np.float64]
    covariance: NDArray[np.float64]
    perimeter: float
    extent: NDArray[np.float64]
    parts: int
    holes: int


def links_of(frame: NDArray[np.float64]) -> Links:
    """Return what hangs together, and below which threshold."""
    rows, cols = frame.shape
    links: Links = []
    for r in range(rows):
        for c in range(cols):
            for other in ((r, c + 1), (r + 1, c)):
                if other[0] < rows and other[1] < cols:
                    links.append((min(frame[r, c], frame[other]), (r, c), other))
    for r in range(rows - 1):
        for c in range(cols - 1):
            mean = ((frame[r, c] + frame[r, c + 1]) + (frame[r + 1, c] + frame[r + 1, c + 1])) / 4
            for one, other in (((r, c), (r + 1, c + 1)), ((r, c + 1), (r + 1, c))):
                links.append((min(frame[one], frame[other], mean), one, other))
    return sorted(links, key=lambda link: -link[0])


def contacts_of(
    frame: NDArray[np.float64], floor: float, noise: float = 0.0
) -> tuple[NDArray[np.int64], list[tuple[float, float]]]:
    """Return each taxel's contact (-1 for none) and each contact's peak and end, numbered as their peaks' indices."""
    label, peaks = _contacts(frame, floor, noise, np.zeros(frame.shape, np.bool_))
    whole = faces_of(frame, floor, [peak for peak, end in peaks if end > floor])
    return _contacts(frame, floor, noise, whole) if whole.any() else (label, peaks)


def faces_of(frame: NDArray[np.float64], floor: float, peaks: list[float]) -> NDArray[np.bool_]:
    """Return where flat faces are that press hardest at their rims, of what holds a peak that was split off."""
    parts, n = ndimage.label(frame > floor, np.ones((3, 3)))
    faces = np.zeros(frame.shape, np.bool_)
    for part in range(1, n + 1):
        inside = parts == part
        if np.isin(frame[inside], peaks).any() and inside.sum() >= 20 and is_face(frame, inside):
            faces |= inside
    return faces


def is_face(frame: NDArray[np.float64], inside: NDArray[np.bool_]) -> bool:
    """Tell whether a part has no bays, and stands higher all along its rim than in its middle."""
    at, off = np.argwhere(inside), np.argwhere(~inside)
    if len(off) == 0 or len(at) < 0.925001 * 4 * np.pi * np.sqrt(np.linalg.det(np.cov(at.T, bias=True))):
        return False
    depth = np.abs(at[:, None] - off[None]).max(axis=2).min(axis=1)
    value, highest = frame[inside], ndimage.maximum_filter(frame, 3, mode="nearest")[inside]
    inner, rim = (2 * depth > depth.max()) & (depth > 1), depth == 1
    if inner.sum() < 2:
        return False
    higher = np.mean(highest[rim] >= 1.200001 * value[inner].mean())
    return bool(higher >= 0.900001 and value[inner].max() <= 0.799999 * highest[rim].mean())


def _contacts(
    frame: NDArray[np.float64], floor: float, noise: float, whole: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], list[tuple[float, float]]]:
    peak_of = {at: at for at in np.ndindex(frame.shape)}
    owner: dict[tuple[int, int], tuple[int, int] | None] = {at: at for at in peak_of}
    state, ends = dict.fromkeys(peak_of, "whole"), dict.fromkeys(peak_of, floor)

    def top(at: tuple[int, int]) -> tuple[int, int]:
        while peak_of[at] != at:
            at = peak_of[at]
        return at

    def is_split(peak: tuple[int, int], saddle: float) -> bool:
        return saddle < SPLIT_RATIO * frame[peak] and frame[peak] - saddle > noise and not whole[peak]

    for value, links in groupby(links_of(frame), key=itemgetter(0)):
        if not value > floor:
            break
        met = {top(at) for link in links for at in link[1:]}
        # Whole ones first, then higher ones first; a taxel that has just come in is no peak.
        first, *others = sorted(
            (at for at in met if frame[at] > value), key=lambda at: (state[at] != "whole", -frame[at])
        )
        for other in others:
            high, low = sorted((first, other), key=lambda at: -frame[at])
            peak_of[low] = first = high
            if state[high] == state[low] == "whole":
                if is_split(low, value):
                    ends[high] = ends[low] = value
                    state[high], state[low] = "split", "finished"
                else:
                    owner[low] = high
            elif "whole" in (state[high], state[low]):
                only = high if state[high] == "whole" else low
                if is_split(only, value):
                    ends[only] = value
                else:
                    owner[only] = None
                state[only], state[high] = "finished", "split"
        for at in met:
            if frame[at] == value:
                peak_of[at] = owner[at] = first

    label = np.full(frame.shape, -1)
    peaks = [at for at in np.ndindex(frame.shape) if frame[at] > floor and owner[at] == at]
    for at in np.ndindex(frame.shape):
        peak: tuple[int, int] | None = at
        while peak is not None and owner[peak] != peak:
            peak = owner[peak]
        if peak in peaks and frame[at] > floor and frame[at] > ends[peak]:
            label[at] = peaks.index(peak)
    return label, [(float(frame[at]), ends[at]) for at in peaks]


def section_of(
    frame: NDArray[np.float64], member: NDArray[np.bool_], level: float, pitch: tuple[float, float]
) -> Section:
    """Cut {V > level} around the taxels that are members.

    Lengths are taken from the highest of them: of a small section far from the pad's centre no digits are lost.
    """
    xs, ys = (
        np.r_[-0.5 * n, np.arange(n) - 0.5 * (n - 1), 0.5 * n] * p
        for n, p in zip(frame.shape[::-1], pitch[::-1], strict=True)
    )
    v, inside = np.pad(frame, 1, mode="edge"), np.pad(member & (frame > level), 1, mode="edge")
    centre = np.zeros(2)
    if inside.any():
        row, col = np.unravel_index(np.argmax(np.where(inside, v, -np.inf)), v.shape)
        centre = np.array([xs[col], ys[row]])
    x, y = np.meshgrid(xs - centre[0], ys - centre[1])
    total, length, corners = np.zeros(6), 0.0, []
    for polygon, cuts in _polygons(v, inside, x, y, level):
        total += _integrals(*np.array(polygon).T)
        corners += polygon
        length += sum(np.hypot(b[0] - a[0], b[1] - a[1]) for a, b in cuts)
    angles = np.arange(32) * np.pi / 16
    points = np.array(corners).reshape(-1, 2)
    reach = points @ np.stack([np.cos(angles), np.sin(angles)])
    support = reach.max(axis=0) if len(points) else np.zeros(32)
    parts, holes = _count(frame, member & (frame > level), level)
    area = float(total[0])
    x1, y1, xx, xy, yy = total[1:] / area if area > 0 else np.full(5, np.nan)
    covariance = np.array([[xx - x1 * x1, xy - x1 * y1], [xy - x1 * y1, yy - y1 * y1]])
    return Section(area, np.add(centre, (x1, y1)), covariance, length, support[:16] + support[16:], parts, holes)


def _polygons(v, inside, x, y, level):  # type: ignore[no-untyped-def]
    """Yield each cell's polygons above the level, and the lines that cut them."""
    for r, c in zip(*np.nonzero(_any_corner(inside)), strict=True):
        at = [(r, c), (r, c + 1), (r + 1, c + 1), (r + 1, c)]
        walk = []
        for j in range(4):
            a, b = at[j], at[(j + 1) % 4]
            if inside[a]:
                walk.append(((x[a], y[a]), None))
            if inside[a] != inside[b]:
                f = (v[a] - level) / (v[a] - v[b])
                walk.append(((x[a] + f * (x[b] - x[a]), y[a] + f * (y[b] - y[a])), bool(inside[a])))
        saddle = [bool(inside[a]) for a in at] in ([True, False, True, False], [False, True, False, True])
        apart = saddle and not 4 * level < (v[at[0]] + v[at[1]]) + (v[at[3]] + v[at[2]])
        first = next((i for i, (_, leaves) in enumerate(walk) if leaves is False), 0)
        walk = walk[first:] + walk[:first]
        pieces = [walk[:3], walk[3:]] if apart else [walk]
        for piece in pieces:
            points = [point for point, _ in piece]
            n = len(piece)
            cuts = [
                (points[i], points[(i + 1) % n])
                for i in range(n)
                if piece[i][1] is True and piece[(i + 1) % n][1] is False
            ]
            yield points, cuts


def _any_corner(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return inside[:-1, :-1] | inside[:-1, 1:] | inside[1:, :-1] | inside[1:, 1:]


def _integrals(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the integrals of 1, x, y, x^2, x y and y^2 over a polygon."""
    x1, y1 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y1 - x1 * y
    return np.array(
        [
            cross.sum() / 2,
            ((x + x1) * cross).sum() / 6,
            ((y + y1) * cross).sum() / 6,
            ((x * x + x * x1 + x1 * x1) * cross).sum() / 12,
            ((x * y1 + 2 * x * y + 2 * x1 * y1 + x1 * y) * cross).sum() / 24,
            ((y * y + y * y1 + y1 * y1) * cross).sum() / 12,
        ]
    )


def _count(frame: NDArray[np.float64], inside: NDArray[np.bool_], level: float) -> tuple[int, int]:
    """Return the numbers of parts and of holes: the parts less the Euler number."""
    taxels = [tuple(at) for at in np.argwhere(inside).tolist()]
    links = [(one, other) for value, one, other in links_of(frame) if value > level and inside[one] and inside[other]]
    group = {at: at for at in taxels}

    def root(at):  # type: ignore[no-untyped-def]
        while group[at] != at:
            at = group[at]
        return at

    # A diagonal is a link of its own only where the cell's other corners are out.
    edges = 0
    for one, other in links:
        straight = one[0] == other[0] or one[1] == other[1]
        if straight or not (inside[one[0], other[1]] or inside[other[0], one[1]]):
            edges += 1
            group[root(one)] = root(other)
    cells = np.count_nonzero(inside[:-1, :-1] & inside[:-1, 1:] & inside[1:, :-1] & inside[1:, 1:])
    parts = len({root(at) for at in taxels})
    return parts, parts - (len(taxels) - edges + int(cells))
