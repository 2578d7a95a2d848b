"""How one pad is loaded, slowly and each number by itself: what `loading_features` is compared with."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

__all__ = ["loading_of", "onset_of"]

SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)


def _reached(series, time, level):
    """Return when a series first reaches a level, by a straight line from the highest before; the end if never."""
    before = None
    for value, now in zip(series, time, strict=True):
        if value >= level:
            if before is None or value <= before[0]:
                return now
            return before[1] + (level - before[0]) / (value - before[0]) * (now - before[1])
        # From a frame that lies below one before, the line begins at that one's height.
        before = (value if before is None else max(value, before[0]), now)
    return time[-1]


def onset_of(height, time):
    load = [frame.sum() for frame in height]
    return _reached(load, time, 0.02 * max(load))


def _at(moment, time, series):
    return float(np.interp(moment, time, series))


def _centres(height):
    """Return x, y and their spreads in each frame; between loaded frames they go evenly."""
    found = {}
    rows, cols = height.shape[1:]
    for k, frame in enumerate(height):
        if frame.sum() > 0:
            x = [c - (cols - 1) / 2 for c in range(cols)]
            y = [r - (rows - 1) / 2 for r in range(rows)]
            share = frame / frame.sum()
            mx = sum(share[r, c] * x[c] for r in range(rows) for c in range(cols))
            my = sum(share[r, c] * y[r] for r in range(rows) for c in range(cols))
            vx = sum(share[r, c] * (x[c] - mx) ** 2 for r in range(rows) for c in range(cols))
            vy = sum(share[r, c] * (y[r] - my) ** 2 for r in range(rows) for c in range(cols))
            found[k] = (mx, my, math.sqrt(vx), math.sqrt(vy))
    known = sorted(found)
    return [[_at(k, known, [found[i][j] for i in known]) for k in range(len(height))] for j in range(4)]


def loading_of(height, time, start, moments, bands):
    """Return every number of one pad by its name, from its height above the standard plane."""
    load = [float(frame.sum()) for frame in height]
    most = max(load)
    onset = onset_of(height, time)
    top = load.index(most)
    area = [float((frame > 0).sum()) for frame in height]
    peak = [float(frame.max()) for frame in height]
    x, y, sx, sy = _centres(height)
    out = {"touched": 1.0, "onset_lag": onset - start, "largest_load": most}

    late = [k for k in range(top + 1) if time[k] >= time[top] - 1 / 3 * (time[top] - onset)]
    t, v = np.array([time[k] for k in late]), np.array([load[k] for k in late])
    out["creep"] = float(np.polyfit(t - t.mean(), v, 1)[0]) / most if np.ptp(t) > 0 else 0.0
    since = [load[k] for k in range(top + 1) if time[k] >= onset]
    steps = [b - a for a, b in pairwise(since)]
    turns = [abs(b - a) for a, b in pairwise(steps)]
    out["unsteadiness"] = sum(turns) / len(turns) / most if turns else 0.0
    out["largest_drop"] = max([0.0, *(-step for step in steps)]) / most
    gone = [k for k in range(top, len(load)) if load[k] < 0.5 * most]
    out |= {"let_go": float(bool(gone)), "dwell": 0.0, "fall_time": 0.0, "hysteresis_of_area": 0.0}
    if gone:
        after = gone[0]
        held = max(k for k in range(top, after) if load[k] >= 0.9 * most)
        out["dwell"] = time[held] - _reached(load, time, 0.9 * most)
        part = (load[after - 1] - 0.5 * most) / (load[after - 1] - load[after])
        out["fall_time"] = time[after - 1] + part * (time[after] - time[after - 1]) - time[held]
        falling = area[after - 1] + part * (area[after] - area[after - 1])
        out["hysteresis_of_area"] = falling - _at(_reached(load, time, 0.5 * most), time, area)
    for way, axis in (("rows", 1), ("columns", 2)):
        n = height.shape[axis]
        for k in range(bands):
            first = min(k * n // bands, n)
            last = max(min((k + 1) * n // bands, n), first + 1)
            band = np.take(height, range(first, last), axis=axis)
            out[f"{way}_{k}_onset_lag"] = _reached([b.sum() for b in band], time, 0.02 * most) - onset
    for share in SHARES:
        at = _reached(load, time, share * most)
        said = f"{share:g}_of_load"
        out[f"time_to_{said}"] = at - onset
        out[f"area_at_{said}"] = _at(at, time, area)
        out[f"moved_x_at_{said}"] = _at(at, time, x) - x[top]
        out[f"moved_y_at_{said}"] = _at(at, time, y) - y[top]
        out[f"spread_x_at_{said}"] = _at(at, time, sx)
        out[f"spread_y_at_{said}"] = _at(at, time, sy)
    series = {"load": load, "share_of_load": [v / most for v in load], "area": area, "peak": peak}
    for name, values in (series | {"x": x, "y": y, "spread_x": sx, "spread_y": sy}).items():
        for k, moment in enumerate(moments):
            out[f"{name}_at_time_{k}"] = _at(onset + moment, time, values)
    return out
