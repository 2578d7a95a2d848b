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
from varishold.touch.decision import SPREADING
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
_FEWEST = 60
_RIDGE = 20.0


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
    """Return a row (kind, whitened spreading inputs, error of the long side, of the short one) of each right name."""
    clean = clean_frames(task.making, task.seed, task.index, small=task.small)
    columns = [SIGNATURE_NAMES.index(name) for name in SPREADING]
    rows = []
    for i, _, _, frame, _ in read_frames(clean, (task.seed, task.index, 7), SENSORS["whole"][task.making] // 2):
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
            off = [surface.size[0] - whole, surface.size[1] - (short if np.isnan(long) else min(long, short))]
            rows.append([clean.kind[i], *surface.inputs[columns], *off])
    return np.array(rows).reshape(len(rows), len(SPREADING) + 3)


def size_spread(tasks: list[Task]) -> NDArray[np.float32]:
    """Return the logarithm of the half-widths that hold 90 % of true sizes, as linear functions of the state.

    Returns
    -------
    ndarray of shape (n_kinds, 2, 1 + n), float32
    """
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        rows = np.concatenate(list(pool.map(_errors, tasks)))
    spread = np.zeros((len(KINDS), 2, 1 + len(SPREADING)), np.float32)
    design = np.column_stack([np.ones(len(rows)), rows[:, 1:-2]])
    for kind in range(len(KINDS)):
        for side in (0, 1):
            of = (rows[:, 0] == kind) & np.isfinite(rows[:, side - 2])
            error = np.log(np.abs(rows[of, side - 2]) + _LEAST)
            if len(error) < _FEWEST:
                continue
            a = design[of]
            penalty = _RIDGE * np.eye(a.shape[1])
            penalty[0, 0] = 0.0
            b = np.linalg.solve(a.T @ a + penalty, a.T @ error)
            b[0] += np.quantile(error - a @ b, COVERED)
            spread[kind, side] = b
            held = np.mean(error <= a @ b)
            half = np.exp(np.median(a @ b))
            print(
                f"{KINDS[kind].key:20} side {side}: median half-width {half:.2f} taxels, holds {held:.3f} of {of.sum()}"
            )
    return spread


def moved_to(spread: NDArray[np.float32], of: Whitened, to: Whitened) -> NDArray[np.float32]:
    """Return the same spread as a function of another table's whitened inputs."""
    columns = [SIGNATURE_NAMES.index(name) for name in SPREADING]
    ratio = of.scale[columns] / to.scale[columns]
    moved = spread.copy()
    moved[..., 1:] = spread[..., 1:] * ratio
    moved[..., 0] += spread[..., 1:] @ ((to.shift[columns] - of.shift[columns]) * of.scale[columns])
    return moved
