"""The measures of a pad's frame, slowly and each by itself: what `measure_pad` is compared with."""

from __future__ import annotations

import math

import numpy as np

__all__ = ["measures_of", "pressed_piece", "window_of"]


def window_of(frame, sigma):
    """Return (first row, past last row, first column, past last column) of what is looked at."""
    rows, cols = frame.shape
    if rows * cols <= 320:
        return 0, rows, 0, cols
    felt = [(i, j) for i in range(rows) for j in range(cols) if frame[i, j] > max(0.08 * frame.max(), 4 * sigma)]
    out = []
    for places, size, most in (([i for i, _ in felt], rows, 16), ([j for _, j in felt], cols, 20)):
        low, high = max(min(places) - 2, 0), min(max(places) + 3, size)
        if size <= most:
            out += [0, size]
        elif high - low > most:
            return 0, rows, 0, cols
        else:
            # As much room on one side as on the other, as far as the pad has it.
            first = min(max((low + high - most) // 2, 0), size - most)
            out += [first, first + most]
    return tuple(out)


def pressed_piece(load):
    """Return the heaviest piece above a quarter of the peak; cells that touch at a corner belong together."""
    left = {(i, j) for i, j in np.argwhere(load > 0.25 * load.max()).tolist()}
    pieces = []
    while left:
        edge = [left.pop()]
        piece = []
        while edge:
            i, j = edge.pop()
            piece.append((i, j))
            for near in [(i + a, j + b) for a in (-1, 0, 1) for b in (-1, 0, 1)]:
                if near in left:
                    left.remove(near)
                    edge.append(near)
        pieces.append(piece)
    best = max(pieces, key=lambda piece: sum(load[i, j] for i, j in piece))
    mask = np.zeros(load.shape, bool)
    for i, j in best:
        mask[i, j] = True
    return mask


def _squares(design, values):
    """Least squares with the faint preference for small numbers that keeps a row of cells in bounds."""
    normal = design.T @ design
    normal = normal + np.eye(len(normal)) * 1e-5 * np.trace(normal) / len(normal)
    return np.linalg.inv(normal) @ (design.T @ values)


def _kurtosis(profile):
    share = [v / sum(profile) for v in profile]
    mean = sum(k * s for k, s in enumerate(share))
    second, fourth = (sum(s * (k - mean) ** n for k, s in enumerate(share)) for n in (2, 4))
    return math.log(fourth / max(second**2, 1e-6) + 0.1) if second > 1e-6 else 1.0


def _bend(line):
    """Minus the second derivative of the parabola through a profile's top, over its peak."""
    top = int(np.argmax(line))
    first = last = top
    while first > 0 and line[first - 1] > 0.4 * line[top]:
        first -= 1
    while last < len(line) - 1 and line[last + 1] > 0.4 * line[top]:
        last += 1
    if last - first < 2:
        first = min(max(top, 1), len(line) - 2) - 1
        last = first + 2
    s = np.arange(first, last + 1)
    return -2 * np.polyfit(s, line[first : last + 1], 2)[0] / line[top]


def measures_of(whole, level, load, mask, corner_m, cell, *, pitch, sigma, seen):
    """Return every measure by its name.

    `whole` is the pad's frame; `level`, `load` and `mask` are the surface, its pressure and the contact on cells of
    (height, width) `cell`, the first of which begins at (y, x) `corner_m`; `seen` says whether a skin is known.
    """
    rows, cols = whole.shape
    taxel = math.sqrt(pitch[0] * pitch[1])
    y = corner_m[0] + (np.arange(level.shape[0]) + 0.5) * cell[0]
    x = corner_m[1] + (np.arange(level.shape[1]) + 0.5) * cell[1]
    gx, gy = np.meshgrid(x, y)
    px, py, u = gx[mask], gy[mask], level[mask]
    mx, my = px.mean(), py.mean()
    unit = max(math.sqrt(((px - mx) ** 2 + (py - my) ** 2).mean()), *cell)
    a, b, v = (px - mx) / unit, (py - my) / unit, u - u.mean()
    one = np.ones_like(a)
    linear = np.column_stack([one, a, b])
    plane = _squares(linear, v)
    full = np.column_stack([one, a, b, a * a / 2, a * b, b * b / 2])
    quadratic = _squares(full, v)
    off_plane, off_quadratic = v - linear @ plane, v - full @ quadratic
    slope = plane[1:] / unit
    xx, xy, yy = -quadratic[3:] / unit**2
    bends, ways = np.linalg.eigh([[xx, xy], [xy, yy]])
    by_size = sorted(range(2), key=lambda k: -abs(bends[k]))

    def kink(way):
        s = a * way[0] + b * way[1]
        tried = []
        for share in (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6):
            hinge = np.column_stack([linear, np.abs(s - share * max(np.abs(s).max(), 1e-6))])
            normal = hinge.T @ hinge
            found = np.linalg.inv(normal + 1e-6 * np.trace(normal) * np.eye(4)) @ (hinge.T @ v)
            tried.append((((v - hinge @ found) ** 2).sum(), abs(share), found[3]))
        rss, place, turn = min(tried, key=lambda t: t[0])
        spread = (v**2).sum()
        gain = math.log(((off_quadratic**2).sum() + 1e-9 * spread + 1e-30) / (rss + 1e-9 * spread + 1e-30))
        return -2 * turn / unit, min(max(gain, -4.0), 4.0), place

    along, cross = (kink(ways[:, k]) for k in by_size)
    covariance = np.cov(px, py) if len(px) > 1 else np.zeros((2, 2))
    short, long = np.sqrt(12 * np.maximum(np.linalg.eigvalsh(covariance), 0))
    cut = [edge.mean() for edge in (mask[:, 0], mask[:, -1], mask[0], mask[-1])]
    inner = mask
    for _ in range(2 if seen else 1):
        # A cell stays where all four neighbours are in contact; beyond the pad's border the contact goes on.
        padded = np.pad(inner, 1, constant_values=True)
        inner = inner & padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    ring = mask & ~inner
    inside = load[mask]
    i, j = np.unravel_index(int(np.argmax(load)), load.shape)
    felt = np.where(whole > max(0.02 * whole.max(), 2 * sigma), whole, 0.0)
    log = lambda value: math.log(max(value, 0.0) + 1e-3)  # noqa: E731
    return {
        "curvature_along_cols": math.asinh(0.02 * xx / (1 + slope[0] ** 2) ** 1.5),
        "curvature_along_rows": math.asinh(0.02 * yy / (1 + slope[1] ** 2) ** 1.5),
        "curvature_greatest": math.asinh(0.02 * bends[by_size[0]]),
        "curvature_least": math.asinh(0.02 * bends[by_size[1]]),
        "quadratic_residual": log(math.sqrt((off_quadratic**2).mean()) / taxel),
        "plane_residual": log(math.sqrt((off_plane**2).mean()) / taxel),
        "kink_angle": math.asinh(3 * along[0]),
        "kink_gain": along[1],
        "kink_offset": along[2],
        "cross_kink_angle": math.asinh(3 * cross[0]),
        "cross_kink_gain": cross[1],
        "length": log(long / taxel),
        "breadth": log(short / taxel),
        "area_share": mask.sum() * cell[0] * cell[1] / (rows * cols * pitch[0] * pitch[1]),
        "cut_cols_most": max(cut[0], cut[1]),
        "cut_cols_least": min(cut[0], cut[1]),
        "cut_rows_most": max(cut[2], cut[3]),
        "cut_rows_least": min(cut[2], cut[3]),
        "rim_pressure": load[ring].mean() / inside.mean() if ring.any() else 1.0,
        "peak_pressure": math.log(inside.max() / inside.mean()),
        "peak_offset": math.hypot(x[j] - mx, y[i] - my) / (long + taxel),
        "tail_along_cols": _kurtosis(felt.sum(axis=0)),
        "tail_along_rows": _kurtosis(felt.sum(axis=1)),
        "profile_curvature_cols": math.asinh(10 * _bend(felt.mean(axis=0))),
        "profile_curvature_rows": math.asinh(10 * _bend(felt.mean(axis=1))),
        "tilt_along_cols": math.asinh(5 * abs(slope[0])),
        "tilt_along_rows": math.asinh(5 * abs(slope[1])),
        "depth": log(level.max() / 1e-3) if seen else 0.0,
        "force": log(whole.sum() * pitch[0] * pitch[1]) if seen else 0.0,
        "noise": log(sigma / whole.max()),
        "rows": math.log(rows),
        "cols": math.log(cols),
        "pitch": math.log(taxel / 0.002),
    }
