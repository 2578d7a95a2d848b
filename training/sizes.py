"""How far sizes are off, by kind and by what the sensor's state says: what size intervals are made of."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from training.readings import SENSORS, Task, read_frames
from training.samples import clean_frames
from varishold.touch import KINDS, SIGNATURE_NAMES, find_contacts, recognize
from varishold.touch.recognizer import SMALL_PAD

Array = NDArray[np.float64]


class Whitened(Protocol):
    """What shifts and scales its inputs."""

    shift: NDArray[Any]
    scale: NDArray[Any]


#: Share of generated frames whose true size an interval holds.
COVERED = 0.9
# Errors below this (taxels) are as good as none.
_LEAST = 0.01
# Readings without which nothing is said of a kind, and without which all its sizes are as uncertain.
_FEWEST, _FEWEST_TOLD_APART = 60, 1000
_RIDGE = 30.0
# The most wear of a face on a height map: rounding over breadth, tilt over what the depth allows, curvature of the pad,
# share cut off, stretch.
_MILD = np.array([0.15, 0.6, 0.0, 0.0, 0.0])
_ROUNDS = 25
# Of so many readings one is kept to set how many an interval holds.
_KEPT_EVERY = 4


def at_floor(key: str, long: float, short: float, q: float) -> tuple[float, float]:
    """Return the lengths of the section that lies the share `q` of the height above the contact line."""
    if key in ("cone", "pyramid"):
        return long * (1 - q), short * (1 - q)
    if key == "sphere":
        return long * np.sqrt(1 - q), short * np.sqrt(1 - q)
    if key == "lying-cylinder":
        return long, short * np.sqrt(1 - q)
    if key == "ridge":
        return long, short * (1 - q)
    if key == "hip":
        return long - short * q, short * (1 - q)
    return long, short


def _errors(task: Task) -> Array:
    """Return a row of each right name: kind, whether it is a height map, whitened inputs, errors in taxels.

    The errors are those of the long side and of the short one, the true length less the measured one.
    """
    clean = clean_frames(task.making, task.seed, task.index, small=task.small)
    rows = []
    count = SENSORS["whole"][task.making] // 2
    for i, _, _, frame, sensor in read_frames(clean, (task.seed, task.index, 7), count, small=task.small):
        long, short = clean.size[i].tolist()
        contacts = find_contacts(frame)
        # Pads of a few taxels have a table of their own.
        if not np.isfinite(long) or not contacts or (min(frame.shape) < SMALL_PAD) != task.small:
            continue
        contact = contacts[0]
        long, short = at_floor(KINDS[clean.kind[i]].key, long, short, max(contact.floor / contact.peak, 0.0))
        # What leaves the field at both ends has a length that nobody can see.
        long = long if long <= max(frame.shape) else np.nan
        surface = recognize(contact)
        if KINDS[clean.kind[i]].name == surface.name:
            whole = np.nan if np.isnan(long) else max(long, short)
            off = [whole - surface.size[0], (short if np.isnan(long) else min(long, short)) - surface.size[1]]
            of_map = clean.skin[i][0] < 0 and not sensor.families and bool((clean.wear[i] <= _MILD).all())
            rows.append([clean.kind[i], of_map, *surface.inputs, *off])
    return np.array(rows, np.float32).reshape(len(rows), len(SIGNATURE_NAMES) + 4)


def size_spread(tasks: list[Task]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return where true sizes lie beside the measured ones, as linear functions of the whitened inputs.

    Returns
    -------
    spread : ndarray of shape (n_kinds, 2, 2, 1 + n_inputs), float32
        Of each kind's long and short side: the middle of the interval that holds 90 %, from the measured size, and the
        logarithm of its half-width, in taxels.
    of_maps : ndarray of shape (n_kinds, 2), float32
        The share of that half-width which holds 90 % on height maps: sensors with no fault but noise, faces that are
        not cut and hardly worn.
    """
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        rows = np.concatenate(list(pool.map(_errors, tasks))).astype(np.float64)
    spread = np.zeros((len(KINDS), 2, 2, rows.shape[1] - 3), np.float32)
    of_maps = np.ones((len(KINDS), 2), np.float32)
    design = np.column_stack([np.ones(len(rows)), rows[:, 2:-2]])
    for kind in range(len(KINDS)):
        for side in (0, 1):
            of = (rows[:, 0] == kind) & np.isfinite(rows[:, side - 2])
            if of.sum() < _FEWEST:
                continue
            a, error = design[of], rows[of, side - 2]
            if len(error) < _FEWEST_TOLD_APART:
                a = a[:, :1]
            kept = np.arange(len(error)) % _KEPT_EVERY == 0
            middle = _quantile(a[~kept], error[~kept], 0.5)
            far = np.log(np.abs(error - a @ middle) + _LEAST)
            half = _quantile(a[~kept], far[~kept], COVERED)
            half[0] += np.quantile((far - a @ half)[kept], COVERED)
            spread[kind, side, 0, : len(middle)], spread[kind, side, 1, : len(half)] = middle, half
            maps = rows[of, 1] > 0
            if maps.sum() >= _FEWEST:
                of_maps[kind, side] = np.exp(np.quantile((far - a @ half)[maps], COVERED))
            print(
                f"{KINDS[kind].key:20} side {side}: median half-width {np.exp(np.median(a @ half)):.2f} taxels, "
                f"holds {np.mean(far <= a @ half):.3f} of {of.sum()}, {of_maps[kind, side]:.2f} of it on height maps"
            )
    return spread, of_maps


def _quantile(a: Array, y: Array, share: float) -> Array:
    """Return the linear function below which `share` of `y` lies, given `a`, by weighted least squares in rounds."""
    penalty = _RIDGE * np.eye(a.shape[1])
    penalty[0, 0] = 0.0
    b = np.linalg.solve(a.T @ a + penalty, a.T @ y)
    scale = np.median(np.abs(y - a @ b))
    for _ in range(_ROUNDS):
        rest = y - a @ b
        weight = np.where(rest > 0, share, 1 - share) * scale / np.maximum(np.abs(rest), 0.05 * scale)
        b = np.linalg.solve((a.T * weight) @ a + penalty, a.T @ (weight * y))
    return np.asarray(b)


def moved_to(spread: NDArray[np.float32], of: Whitened, to: Whitened) -> NDArray[np.float32]:
    """Return the same spread as a function of another table's whitened inputs."""
    columns = slice(len(SIGNATURE_NAMES))
    ratio = of.scale[columns] / to.scale[columns]
    moved = spread.copy()
    moved[..., 1:] = spread[..., 1:] * ratio
    moved[..., 0] += spread[..., 1:] @ ((to.shift[columns] - of.shift[columns]) * of.scale[columns])
    return moved
