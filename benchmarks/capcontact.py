"""Fingers on a touch screen (CapContact): position, orientation and area of single contacts against the truth.

A single contact is a part of {capacitance > 60} that touches exactly one part of the true contact mask, that
mask part touching no other and covering at least one cell. The mask was seen optically, at 64 points a cell.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage

from benchmarks._figures import figure, share
from benchmarks._real_data import find_recording
from varishold.touch import contact_pose, find_contacts, recognize

THRESHOLD = 60.0
# Orientation means something only where the true contact is oblong.
LEAST_ASPECT = 1.35


@dataclass(frozen=True)
class Truth:
    """A single contact as the optical mask shows it; positions in cells from the screen's centre."""

    frame: int
    person: str
    blob: np.ndarray
    position: tuple[float, float]
    area: float
    aspect: float
    orientation: float


def single_contacts(path: Path) -> tuple[np.ndarray, list[Truth]]:
    """Return the frames and every single contact's truth."""
    with np.load(path, allow_pickle=False) as data:
        frames = data["capacitance"].astype(float)
        coverage = data["contact_coverage_64ths"] / 64.0
        person = data["person"]
    found = []
    for f in range(len(frames)):
        blobs, _ = ndimage.label(frames[f] > THRESHOLD)
        masks, n_masks = ndimage.label(coverage[f] > 0)
        touching = [np.unique(blobs[masks == m]) for m in range(1, n_masks + 1)]
        touching = [t[t > 0] for t in touching]
        for m, touched in enumerate(touching, start=1):
            weight = np.where(masks == m, coverage[f], 0.0)
            if len(touched) != 1 or weight.sum() < 1:
                continue
            if sum(touched[0] in other for other in touching) != 1:
                continue
            position, moments = weighted_moments(weight)
            long, short = axes(moments)
            found.append(
                Truth(
                    f,
                    str(person[f]),
                    blobs == touched[0],
                    position,
                    float(weight.sum()),
                    long / max(short, 1e-9),
                    direction(moments),
                )
            )
    return frames, found


def weighted_moments(weight: np.ndarray) -> tuple[tuple[float, float], np.ndarray]:
    """Return the centroid from the centre and the second central moments of weights on cells."""
    rows, cols = weight.shape
    y, x = np.mgrid[:rows, :cols]
    x, y = x - (cols - 1) / 2, y - (rows - 1) / 2
    total = weight.sum()
    mx, my = float((weight * x).sum() / total), float((weight * y).sum() / total)
    x, y = x - mx, y - my
    xy = (weight * x * y).sum()
    return (mx, my), np.array([[(weight * x * x).sum(), xy], [xy, (weight * y * y).sum()]]) / total


def axes(moments: np.ndarray) -> tuple[float, float]:
    """Return the standard deviations along the long and the short axis."""
    short, long = np.sqrt(np.maximum(np.linalg.eigvalsh(moments), 0.0))
    return float(long), float(short)


def direction(moments: np.ndarray) -> float:
    """Return the long axis' angle from +x toward +y."""
    return 0.5 * float(np.arctan2(2 * moments[0, 1], moments[0, 0] - moments[1, 1]))


def turn_error(got: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return the angle between two axes, degrees."""
    return np.degrees(np.abs((got - true + np.pi / 2) % np.pi - np.pi / 2))


def poses(frames: np.ndarray, truth: list[Truth], floor: float | None) -> np.ndarray:
    """Return x, y, orientation, mean area and area at half height of the largest contact in each blob."""
    contacts: dict[int, list] = {}
    rows = []
    for t in truth:
        if t.frame not in contacts:
            contacts = {t.frame: find_contacts(frames[t.frame], floor=floor)}
        contact = next(c for c in contacts[t.frame] if t.blob[c.peak_taxel])
        pose = contact_pose(contact)
        half = float(np.interp(-0.5 * (contact.peak + contact.floor), -contact.profile.threshold, contact.profile.area))
        rows.append([*pose.position, pose.orientation, pose.mean_area, half])
    return np.array(rows)


def fitted_area_error(measure: np.ndarray, truth: list[Truth]) -> list[float]:
    """Return each person's median relative area error with a straight line fitted on the other two.

    The line is the one of least mean absolute relative error, by reweighted least squares.
    """
    area, person = np.array([t.area for t in truth]), np.array([t.person for t in truth])
    columns = np.column_stack([np.ones(len(area)), measure]) / area[:, None]
    errors = []
    for tested in np.unique(person):
        train = columns[person != tested]
        weight = np.ones(len(train))
        for _ in range(100):
            scaled = train * weight[:, None]
            line = np.linalg.solve(scaled.T @ train, scaled.sum(axis=0))
            weight = 1 / np.maximum(np.abs(1 - train @ line), 1e-3)
        errors.append(float(np.median(np.abs(1 - columns[person == tested] @ line))))
    return errors


def _interval(errors: np.ndarray, frame: np.ndarray) -> tuple[float, float]:
    """Return the 95 % bootstrap interval of the median; whole frames are drawn."""
    rng = np.random.default_rng(0)
    of_frame = [errors[frame == f] for f in np.unique(frame)]
    medians = [
        np.median(np.concatenate([of_frame[i] for i in rng.integers(0, len(of_frame), len(of_frame))]))
        for _ in range(400)
    ]
    low, high = np.percentile(medians, [2.5, 97.5])
    return float(low), float(high)


def figures(path: Path) -> None:
    """Print every figure."""
    frames, truth = single_contacts(path)
    position = np.array([t.position for t in truth])
    oblong = np.array([t.aspect > LEAST_ASPECT for t in truth])
    turn = np.array([t.orientation for t in truth])
    frame = np.array([t.frame for t in truth])
    print(
        f"  {figure('single contacts', len(truth))} single contacts, {oblong.sum()} of them oblong; "
        f"median true area {np.median([t.area for t in truth]):.1f} cells"
    )

    plain = [weighted_moments(np.where(t.blob, frames[t.frame], 0.0)) for t in truth]
    off = np.hypot(*(np.array([p for p, _ in plain]) - position).T)
    turned = turn_error(np.array([direction(c) for _, c in plain]), turn)[oblong]
    print(
        f"  weighted centroid: position median {figure('weighted centroid: position', np.median(off), '.3f', 'cell')}, "
        f"95 % {np.percentile(off, 95):.3f}; orientation median "
        f"{figure('weighted centroid: orientation', np.median(turned), '.2f', 'degrees')}"
    )
    for floor in (THRESHOLD, None):
        got = poses(frames, truth, floor)
        off = np.hypot(*(got[:, :2] - position).T)
        turned = turn_error(got[:, 2], turn)[oblong]
        areas = fitted_area_error(got[:, 3], truth)
        half = fitted_area_error(got[:, 4], truth)
        of = f"contact_pose, floor {f'{floor:.0f}' if floor is not None else 'the default'}"
        low, high = _interval(off, frame)
        print(f"  {of}, nothing fitted:")
        print(
            f"    position median {figure(f'{of}: position', np.median(off), '.3f', 'cell', bar='<= .365')} "
            f"({low:.3f}-{high:.3f}), "
            f"95 % {figure(f'{of}: position, 95 %', np.percentile(off, 95), '.3f', 'cell', bar='<= .88')}"
        )
        low, high = _interval(turned, frame[oblong])
        print(
            f"    orientation median {figure(f'{of}: orientation', np.median(turned), '.2f', 'degrees', bar='<= 4.3')} "
            f"({low:.2f}-{high:.2f}), 95 % {np.percentile(turned, 95):.1f}"
        )
        print(
            "    relative area error, a straight line (two constants) fitted on two people: mean "
            f"{figure(f'{of}: relative area error', np.mean(areas), '.3f', bar='<= .16')}, by person "
            f"{', '.join(f'{e:.3f}' for e in areas)}; from the half-height section alone {np.mean(half):.3f}"
        )


def recognize_untrained(frames: np.ndarray, truth: list[Truth]) -> None:
    """Print what `recognize`, which has never seen this sensor, calls the fingers."""
    given: Counter[str] = Counter()
    for t in truth:
        contacts = find_contacts(frames[t.frame], floor=THRESHOLD)
        given[recognize(next(c for c in contacts if t.blob[c.peak_taxel])).name] += 1
    n = given.total()
    called = (f"{name} {share(f'called {name}', k / n)}" for name, k in given.most_common(5))
    print(f"  recognize calls the fingers {', '.join(called)}")


def main() -> None:
    """Print the figures."""
    path = find_recording("capcontact_fingers.npz")
    if path is not None:
        figures(path)
        recognize_untrained(*single_contacts(path))


if __name__ == "__main__":
    main()
