"""How far sizes are off, by kind and by what the sensor's state says: what size intervals are made of."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from training.faces import WEIGHTS, Drawn, Face, face_over
from training.frames import PADS, draw_pad, taxel_mean
from training.readings import SENSORS, Task, read_frames
from training.samples import CHUNK, clean_frames, true_size, wear_of
from varishold.touch import KINDS, SIGNATURE_NAMES, find_contacts, recognize

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
# Share of the faces on height maps that are not worn at all.
_PLAIN = 0.25
# Pads whose largest faces are narrower than this share of the shorter side are left out of height maps.
_FILLED = 0.4
_ROUNDS = 25
_KEYS = [kind.key for kind in KINDS]
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
    """Return a row of each right name that drawn sensors' readings get: kind, whitened inputs, errors in taxels.

    The errors are those of the long side and of the short one, the true length less the measured one.
    """
    clean = clean_frames(task.making, task.seed, task.index, task.pads)
    rows = []
    count = SENSORS["whole"][task.making] // 2
    for i, _, _, frame, _ in read_frames(clean, (task.seed, task.index, 7), count, task.pads):
        long, short = clean.size[i].tolist()
        contacts = find_contacts(frame)
        if not np.isfinite(long) or not contacts:
            continue
        contact = contacts[0]
        long, short = at_floor(KINDS[clean.kind[i]].key, long, short, max(contact.floor / contact.peak, 0.0))
        # What leaves the field at both ends has a length that nobody can see.
        long = long if long <= max(frame.shape) else np.nan
        surface = recognize(contact)
        if KINDS[clean.kind[i]].name == surface.name:
            whole = np.nan if np.isnan(long) else max(long, short)
            off = [whole - surface.size[0], (short if np.isnan(long) else min(long, short)) - surface.size[1]]
            rows.append([clean.kind[i], *surface.inputs, *off])
    return _stacked(rows)


def _errors_of_maps(task: Task) -> Array:
    """Return such rows of height maps, no fault but noise: faces that are whole and hardly worn."""
    rng = np.random.default_rng([task.seed, task.index, list(PADS).index(task.pads), 11])
    keys = [key for key in WEIGHTS if np.isfinite(true_size(Drawn(key, 2.0, 1.0, 1.0))).all()]
    # What is much smaller than a map has errors of another kind.
    pads = tuple(row for row in PADS[task.pads] if row[1].size[1] >= _FILLED * min(row[1].shape))
    rows: list[list[float]] = []
    for _ in range(CHUNK["ideal"]):
        pad, key = draw_pad(rng, pads), str(rng.choice(keys))
        per_taxel = max(3, min(10, 160 // max(pad.shape)))
        face = face_over(rng, key, pad.shape, pad.size, per_taxel=per_taxel, plain=_PLAIN)
        if (np.array(wear_of(face.drawn, pad.shape)) > _MILD).any():
            continue
        frame = taxel_mean(np.maximum(face.height, 0.0), per_taxel)
        sigma = float(np.exp(rng.uniform(*np.log(pad.noise)))) * float(frame.max())
        contacts = find_contacts(frame + rng.normal(0.0, sigma, frame.shape))
        if not contacts:
            continue
        kind, surface = _KEYS.index(key), recognize(contacts[0])
        if KINDS[kind].name == surface.name and not surface.cut:
            long, short = _true_section(face, contacts[0].floor)
            rows.append([kind, *surface.inputs, long - surface.size[0], short - surface.size[1]])
    return _stacked(rows)


def _true_section(face: Face, floor: float) -> tuple[float, float]:
    """Return the (long, short) lengths in taxels that recognition should report: a faced body's are its face's.

    Those of others are of the section at the height `floor`, of the circle, square or rectangle of its area and second
    moments.
    """
    kind = KINDS[_KEYS.index(face.key)]
    if kind.form in ("pillar", "frustum"):
        long, short = true_size(face.drawn)
        return max(long, short), min(long, short)
    y, x = np.nonzero(face.height > floor)
    area = len(x) / face.per_taxel**2
    if kind.section == "circle":
        return 2 * np.sqrt(area / np.pi), 2 * np.sqrt(area / np.pi)
    if kind.section == "square":
        return np.sqrt(area), np.sqrt(area)
    minor, major = np.linalg.eigvalsh(np.cov(np.stack([x, y])))
    aspect = np.sqrt(major / minor)
    return float(np.sqrt(area * aspect)), float(np.sqrt(area / aspect))


def _stacked(rows: list[list[float]]) -> Array:
    return np.array(rows, np.float32).reshape(len(rows), len(SIGNATURE_NAMES) + 3)


def size_spread(tasks: list[Task], maps: list[Task]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return where true sizes lie beside the measured ones, as linear functions of the whitened inputs.

    Parameters
    ----------
    tasks, maps : list of Task
        What is read by drawn sensors, and what is read as height maps.

    Returns
    -------
    spread, map_spread : ndarray of shape (n_kinds, 2, 2, 1 + n_inputs), float32
        Of each kind's long and short side: the middle of the interval that holds 90 %, from the measured size, and the
        logarithm of its half-width, in taxels. Of any frame, and of height maps.
    """
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        rows = np.concatenate(list(pool.map(_errors, tasks))).astype(np.float64)
        of_maps = np.concatenate(list(pool.map(_errors_of_maps, maps))).astype(np.float64)
    return _spread_of(rows, "any frame"), _spread_of(of_maps, "height maps")


def _spread_of(rows: Array, what: str) -> NDArray[np.float32]:
    spread = np.zeros((len(KINDS), 2, 2, rows.shape[1] - 2), np.float32)
    design = np.column_stack([np.ones(len(rows)), rows[:, 1:-2]])
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
            print(
                f"{what}: {KINDS[kind].key:20} side {side}: median half-width {np.exp(np.median(a @ half)):.2f} "
                f"taxels, holds {np.mean(far <= a @ half):.3f} of {of.sum()}"
            )
    return spread


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
    moved = spread.astype(np.float64)
    moved[..., 1:] = spread[..., 1:] * ratio
    moved[..., 0] += spread[..., 1:] @ ((to.shift[columns] - of.shift[columns]) * of.scale[columns])
    return moved.astype(np.float32)
