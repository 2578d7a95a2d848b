"""Every number of a press against a slow reference that looks at each press, frame, level and contact by itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reference_loading import loading_of, onset_of

from varishold.frame import recording_noise
from varishold.levelset import find_contacts
from varishold.touch.course.measures import MeasureSettings, learn_settings, measure_names, measure_presses
from varishold.touch.course.presses import Press

LEVELS = (0.95, 0.85, 0.75, 0.65, 0.55, 0.45, 0.35, 0.25, 0.15, 0.08)
LOADS = (0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0)
SHAPES = ("area", "perimeter", "spread_x", "spread_y", "covariance", "length", "breadth", "x", "y")


def sections(frame: np.ndarray, field: np.ndarray) -> dict[str, list[float]]:
    """What is measured of a frame's sections at each level, all contacts together."""
    out: dict[str, list[float]] = {name: [] for name in (*SHAPES, "contacts")}
    peak = frame.max()
    share = frame / (peak if peak > 0 else 1.0)
    contacts = find_contacts(share, LEVELS, field=field, floor=0.999 * 0.08)
    for level in range(len(LEVELS)):
        parts = []
        for contact in contacts:
            p = contact.profile
            # Below its end a contact keeps the last section that was its own.
            own = [k for k in range(level + 1) if not math.isnan(p.area[k])]
            if own:
                parts.append((p.area[own[-1]], p.perimeter[own[-1]], p.centroid[own[-1]], p.covariance[own[-1]]))
        area = sum(part[0] for part in parts)
        out["area"].append(math.sqrt(area))
        out["perimeter"].append(sum(part[1] for part in parts))
        middle, second = np.zeros(2), np.zeros((2, 2))
        if area > 0:
            middle = sum(part[0] * part[2] for part in parts if part[0] > 0) / area
            for a, _, c, cov in parts:
                if a == 0:
                    continue
                second += a * (cov + np.outer(c - middle, c - middle)) / area
        values = np.sqrt(np.maximum(np.linalg.eigvalsh(second), 0))
        out["spread_x"].append(math.sqrt(max(second[0, 0], 0.0)))
        out["spread_y"].append(math.sqrt(max(second[1, 1], 0.0)))
        out["covariance"].append(abs(second[0, 1]))
        out["length"].append(4 * values[1])
        out["breadth"].append(4 * values[0])
        out["x"].append(middle[0])
        out["y"].append(middle[1])
        out["contacts"].append(float(len(contacts)))
    return out


def moment_of(total: np.ndarray, level: float) -> tuple[int, int, float]:
    """Between which frames a load is first reached, and which part of the way."""
    after = next(k for k in range(len(total)) if total[k] >= level)
    before = max(after - 1, 0)
    rise = total[after] - total[before]
    return before, after, min(max((level - total[before]) / rise, 0.0), 1.0) if rise > 0 else 1.0


def measured(press: Press, s: MeasureSettings) -> dict[str, float]:
    """Every number of one press, by the name that the program gives it."""
    heights = {name: np.maximum(frames - s.floor, 0) for name, frames in press.pads.items()}
    total = sum(height.sum(axis=(1, 2)) for height in heights.values())
    top = int(np.argmax(total))
    time = np.arange(len(total), dtype=float) if press.time_s is None else press.time_s
    moments = [moment_of(total[: top + 1], share * total[top]) for share in LOADS]

    def at(series: np.ndarray) -> list[Any]:
        return [series[a] + part * (series[b] - series[a]) for a, b, part in moments]

    out = {}
    times, whole = at(time), [max(value, 1e-300) for value in at(total)]
    for share, moment in zip(LOADS[1:], times[1:], strict=True):
        out[f"time_to_{share:g}_of_load"] = math.log((moment - times[0]) / s.rise + 0.03)
    if s.absolute:
        out["load"] = math.log(whole[-1] / s.load + 1e-3)
    holding = [k for k in range(len(total)) if total[k] >= 0.8 * total[top]]
    held = sorted({holding[round(j)] for j in np.linspace(0, len(holding) - 1, 6)})
    rising = {name: height[: top + 1] for name, height in heights.items()}
    courses = detail(rising, time[: top + 1], s)
    for pad in s.shapes:
        names = measure_names(s)
        mine = {}
        if pad not in heights:
            out |= {name: math.nan for name in names if name.startswith(f"{pad}_")}
            continue
        height, field = heights[pad], press.fields[pad]
        looked = [sections(height[k], field) for k in held]
        for name in (*SHAPES, "contacts"):
            for level, share in enumerate(LEVELS):
                mine[f"{name}_at_{share:g}_of_peak"] = float(np.mean([one[name][level] for one in looked]))
        mine["contacts"] = mine["contacts_at_0.95_of_peak"]
        frames = [sections(frame, field) for frame in at(height)]
        load = at(height.sum(axis=(1, 2)))
        peak = [frame.max() for frame in at(height)]
        for k, share in enumerate(LOADS):
            if k < len(LOADS) - 1:
                mine[f"area_at_{share:g}_of_load"] = frames[k]["area"][7]
                for axis in "xy":
                    moved = frames[k][axis][7] - frames[-1][axis][7]
                    mine[f"moved_{axis}_at_{share:g}_of_load"] = moved if s.position else abs(moved)
            mine[f"peak_over_load_at_{share:g}_of_load"] = math.log(peak[k] / load[k]) if load[k] > 0 else 0.0
            mine[f"share_at_{share:g}_of_load"] = load[k] / whole[k]
        if not s.position:
            for axis in "xy":
                middle = mine[f"{axis}_at_0.25_of_peak"]
                for share in LEVELS:
                    name = f"{axis}_at_{share:g}_of_peak"
                    mine[name] = abs(mine[name] - middle)
        mine |= image_of(height[held].mean(axis=0))
        mine |= {f"course_{name}": value for name, value in evened(courses[pad], s).items()}
        if load[-1] < 0.02 * whole[-1]:
            mine = dict.fromkeys(mine, 0.0)
        out |= {f"{pad}_{name}": value for name, value in mine.items()}
    if len(s.shapes) > 1:
        every = list(courses.values())
        means = {name: float(np.mean([one[name] for one in every])) for name in every[0]}
        out |= {f"mean_of_pads_{name}": value for name, value in evened(means, s).items()}
    return out


def image_of(frame: np.ndarray) -> dict[str, float]:
    """The cells of a frame, moved so that its middle is that of the window: each the mean of its points."""
    n_rows, n_cols = frame.shape
    side = -(-max(n_rows, n_cols) // 12)
    rows, cols = -(-n_rows // side), -(-n_cols // side)
    names = [f"image_at_row_{i}_col_{j}" for i in range(rows) for j in range(cols)]
    if frame.max() <= 0:
        return dict.fromkeys(names, 0.0)

    def reading(i: int, j: int) -> float:
        return float(frame[i, j]) if 0 <= i < n_rows and 0 <= j < n_cols else 0.0

    def between(y: float, x: float) -> float:
        i, j = math.floor(y), math.floor(x)
        upper = (1 - x + j) * reading(i, j) + (x - j) * reading(i, j + 1)
        lower = (1 - x + j) * reading(i + 1, j) + (x - j) * reading(i + 1, j + 1)
        return (1 - y + i) * upper + (y - i) * lower

    y, x = ((frame * at).sum() / frame.sum() for at in np.indices(frame.shape))
    top, left = y - (rows * side - 1) / 2, x - (cols * side - 1) / 2
    cells = [
        np.mean([between(top + i * side + a, left + j * side + b) for a in range(side) for b in range(side)])
        for i in range(rows)
        for j in range(cols)
    ]
    return {name: math.sqrt(cell / max(cells)) for name, cell in zip(names, cells, strict=True)}


def detail(rising: dict[str, np.ndarray], time: np.ndarray, s: MeasureSettings) -> dict[str, dict[str, float]]:
    """The course of each pad up to the largest load, by the reference of loading."""
    moments = [s.rise / 25 * (1.25 * 25) ** (k / 9) for k in range(10)]
    largest = {name: height.sum(axis=(1, 2)).max() for name, height in rising.items()}
    touched = {name: most > 0 and most >= 0.02 * max(largest.values()) for name, most in largest.items()}
    start = min((onset_of(rising[name], time) for name in rising if touched[name]), default=time[-1])
    found = {name: loading_of(rising[name], time, start, moments, 4) for name in rising if touched[name]}
    names = next(iter(found.values()), {})
    return {name: found.get(name) or dict.fromkeys(names, 0.0) for name in rising}


def evened(course: dict[str, float], s: MeasureSettings) -> dict[str, float]:
    """The course without units, large numbers drawn together; only what is learned of it."""
    if not s.absolute:
        return {}
    out = {}
    for name, value in course.items():
        if name.startswith(("touched", "let_go", "dwell", "fall_time", "hysteresis")):
            continue
        if not s.position and name.startswith(("x_at", "y_at", "moved", "rows", "columns")):
            continue
        unit = 1.0
        if name.startswith("time_to") or name.endswith("onset_lag"):
            unit = s.rise
        elif name.startswith(("largest_load", "load_at", "peak_at")):
            unit = s.load
        elif name == "creep":
            unit = 1 / s.rise
        out[name] = math.copysign(math.sqrt(abs(value / unit)), value)
    return out


def drawn(seed: int, n: int, pads: dict[str, tuple[int, int]], *, timed: bool = True, gaps: bool = False) -> Press:
    rng = np.random.default_rng(seed)
    force = np.minimum(np.linspace(0, 1.6, n), 1.0) + rng.normal(0, 0.04, n)
    force[-2:] *= 0.6
    frames, fields = {}, {}
    for k, (name, (rows, cols)) in enumerate(pads.items()):
        y, x = np.mgrid[:rows, :cols]
        shape = np.zeros((n, rows, cols))
        for _ in range(1 + int(rng.random() < 0.4)):
            cx, cy = rng.uniform(0.2, 0.8) * cols, rng.uniform(0.2, 0.8) * rows
            drift = rng.uniform(-1, 1, 2)
            for i in range(n):
                u, v = x - cx - drift[0] * i / n, y - cy - drift[1] * i / n
                shape[i] += np.exp(-(u * u / rng.uniform(2, 5) + v * v / rng.uniform(2, 5)))
        late = np.maximum(force - (0.1 * k), 0)
        frames[name] = late[:, None, None] * shape * rng.uniform(2, 5) + rng.normal(0, 0.01, shape.shape)
        fields[name] = rng.random((rows, cols)) > 0.08 if gaps else np.ones((rows, cols), bool)
        frames[name] = np.where(fields[name], frames[name], 0.0)
    return Press(frames, fields, np.cumsum(rng.uniform(0.01, 0.04, n)) if timed else None)


PADS = {"thumb": (7, 9), "index": (6, 6)}


@given(st.integers(0, 2**31), st.booleans(), st.booleans(), st.booleans(), st.booleans())
@settings(max_examples=16)
def test_every_number_is_that_of_the_reference(
    seed: int, position: bool, absolute: bool, several: bool, gaps: bool
) -> None:
    pads = PADS if several else {"palm": (8, 7)}
    presses = [drawn(seed + k, 9 + 4 * k, pads, gaps=gaps) for k in range(3)]
    for press in presses[1:]:
        press.fields.update(presses[0].fields)  # type: ignore[attr-defined]
        for name, field in press.fields.items():
            press.pads[name][:, ~field] = 0.0
    if several:
        # A pad that hardly bears anything, and one that is not there.
        presses[1].pads["index"][:] *= 0.004
        presses[2] = Press({"thumb": presses[2].pads["thumb"]}, presses[2].fields, presses[2].time_s)
    s = MeasureSettings(dict(pads), 0.05, 0.12, "seconds", 60.0, position, absolute)
    names, made = measure_names(s), measure_presses(presses, s)
    assert made.shape == (3, len(names))
    assert len(set(names)) == len(names)
    for row, press in zip(made, presses, strict=True):
        told = measured(press, s)
        for name, value in zip(names, row, strict=True):
            assert value == pytest.approx(told[name], rel=1e-6, abs=1e-6, nan_ok=True), name


def test_a_pad_without_load_has_zeros_and_a_still_press_does_not_fail() -> None:
    s = MeasureSettings({"a": (4, 5), "b": (4, 5)}, 0.1, 1.0, "frames", 1.0, False, True)
    field = np.ones((4, 5), bool)
    spot = np.zeros((3, 4, 5))
    spot[1:, 1:3, 1:4] = 2.0
    press = Press({"a": spot, "b": np.zeros((3, 4, 5))}, {"a": field, "b": field})
    names, (row,) = measure_names(s), measure_presses([press], s)
    told = dict(zip(names, row, strict=True))
    assert all(value == 0 for name, value in told.items() if name.startswith("b_"))
    assert told["a_share_at_1_of_load"] == 1.0
    assert told["a_contacts"] == 1.0
    nothing = Press({"a": np.zeros((1, 4, 5)), "b": np.zeros((1, 4, 5))}, {"a": field, "b": field})
    assert np.isfinite(measure_presses([nothing], s)).all()


@pytest.mark.parametrize("timed", [True, False])
def test_settings_are_medians_over_the_presses(timed: bool) -> None:
    presses = [drawn(k, 12 + k, PADS, timed=timed) for k in range(7)]
    s = learn_settings(presses, position=True, absolute=False)
    assert (dict(s.shapes), s.clock, s.position, s.absolute) == (PADS, "seconds" if timed else "frames", True, False)
    noise = [recording_noise(f, p.fields[name]) for p in presses for name, f in p.pads.items()]
    assert s.floor == pytest.approx(4 * np.median(noise))
    rises, loads = [], []
    for press in presses:
        total = sum(np.maximum(f - s.floor, 0).sum(axis=(1, 2)) for f in press.pads.values())
        top = int(np.argmax(total))
        time = np.arange(len(total)) if press.time_s is None else press.time_s
        ends = [
            time[a] + part * (time[b] - time[a])
            for a, b, part in (moment_of(total[: top + 1], share * total[top]) for share in (0.1, 1.0))
        ]
        rises.append(ends[1] - ends[0])
        loads.append(total[top])
    assert s.rise == pytest.approx(np.median(rises))
    assert s.load == pytest.approx(np.median(loads))
    # One press without a time, and all are counted in frames.
    if timed:
        mixed = [*presses, drawn(8, 12, PADS, timed=False)]
        assert learn_settings(mixed, position=False, absolute=True).clock == "frames"


def test_settings_of_many_presses_are_told_from_a_hundred_spread_over_them() -> None:
    presses = []
    for k in range(250):
        spot = np.zeros((2, 3, 3))
        spot[1, 1, 1] = 1.0 if k in np.linspace(0, 249, 100).astype(int) else 50.0
        presses.append(Press({"a": spot}, {"a": np.ones((3, 3), bool)}))
    s = learn_settings(presses, position=False, absolute=False)
    assert s.load == pytest.approx(1.0 - s.floor)
    # Where nothing rises, the units are 1.
    flat = [Press({"a": np.zeros((1, 3, 3))}, {"a": np.ones((3, 3), bool)})] * 2
    s = learn_settings(flat, position=False, absolute=False)
    assert (s.rise, s.load) == (1.0, 1.0)
