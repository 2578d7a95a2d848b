"""What plain peers are given of a press: the mean of the held frames, which taxels are on, or moments.

Presses are zeroed and filled as they are for the learner, and pooled over the same frames.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.touch.course.held import held_of
from varishold.touch.course.presses import Press, values_of

__all__ = ["FEATURES", "feature_table", "pooled_frames"]

Floats = NDArray[np.float64]

FEATURES = ("raw frame", "on/off", "moments")
# A taxel is on above this share of the press's largest one.
_ON = 0.1
# Less than this is no load.
_NOTHING = 1e-9


def pooled_frames(presses: Sequence[Press], shapes: Mapping[str, tuple[int, int]], floor: float) -> dict[str, Floats]:
    """Return the mean of each press's held frames.

    Parameters
    ----------
    presses : sequence of Press
    shapes : mapping of str to (int, int)
        All pads.
    floor : float
        What counts as load begins above it.

    Returns
    -------
    dict of str to ndarray of shape (n_presses, rows, cols), float64
        0 where a press has not this pad.
    """
    pooled = {name: np.zeros((len(presses), *shape)) for name, shape in shapes.items()}
    for k, press in enumerate(presses):
        held = held_of(press, floor)
        for name, frames in press.pads.items():
            pooled[name][k] = frames[held].mean(axis=0)
    return pooled


def feature_table(
    kind: str, pooled: Mapping[str, Floats], presses: Sequence[Press], columns: Sequence[str], floor: float
) -> Floats:
    """Return one kind of features of presses, with their angles, switches and forces, shape (n, n_features)."""
    if kind == "raw frame":
        found = [frames.reshape(len(presses), -1) for frames in pooled.values()]
    elif kind == "on/off":
        largest = np.max([frames.max(axis=(1, 2)) for frames in pooled.values()], axis=0)
        limit = np.maximum(_ON * largest, floor)[:, None, None]
        found = [(frames > limit).reshape(len(presses), -1).astype(np.float64) for frames in pooled.values()]
    else:
        loads = np.stack([np.maximum(frames, 0.0).sum(axis=(1, 2)) for frames in pooled.values()], axis=1)
        whole = np.maximum(loads.sum(axis=1, keepdims=True), max(floor, _NOTHING))
        found = [np.log(whole), loads / whole, *(_moments(frames, floor) for frames in pooled.values())]
    return np.concatenate([*found, values_of(presses, columns)] if columns else found, axis=1)


def _moments(frames: Floats, floor: float) -> Floats:
    """Return place, spread, Hu's seven invariants, peak and number of taxels on, shape (n, 14)."""
    shape = frames.shape[1:]
    y, x = np.indices(shape) - (np.array(shape)[:, None, None] - 1) / 2
    largest = np.maximum(frames.max(axis=(1, 2)), max(floor, _NOTHING))
    weight = np.maximum(frames, 0.0) / largest[:, None, None]
    load = np.maximum(weight.sum(axis=(1, 2)), _NOTHING)
    at_x, at_y = (weight * x).sum(axis=(1, 2)) / load, (weight * y).sum(axis=(1, 2)) / load
    off_x, off_y = x - at_x[:, None, None], y - at_y[:, None, None]

    def mu(p: int, q: int) -> Floats:
        return np.asarray((weight * off_x**p * off_y**q).sum(axis=(1, 2)))

    def eta(p: int, q: int) -> Floats:
        return np.asarray(mu(p, q) / load ** (1 + (p + q) / 2))

    second = [mu(2, 0) / load, mu(1, 1) / load, mu(0, 2) / load]
    hu = [np.sign(one) * np.log1p(np.abs(one) * 1e6) for one in _hu(eta)]
    on = (frames > np.maximum(_ON * largest, floor)[:, None, None]).sum(axis=(1, 2))
    return np.stack([at_x, at_y, *second, *hu, np.log(largest), on], axis=1)


def _hu(eta: Callable[[int, int], Floats]) -> list[Floats]:
    """Return the seven invariants of M.-K. Hu, "Visual pattern recognition by moment invariants", 1962."""
    n20, n11, n02 = eta(2, 0), eta(1, 1), eta(0, 2)
    a, b = eta(3, 0) - 3 * eta(1, 2), 3 * eta(2, 1) - eta(0, 3)
    c, d = eta(3, 0) + eta(1, 2), eta(2, 1) + eta(0, 3)
    return [
        n20 + n02,
        (n20 - n02) ** 2 + 4 * n11**2,
        a**2 + b**2,
        c**2 + d**2,
        a * c * (c**2 - 3 * d**2) + b * d * (3 * c**2 - d**2),
        (n20 - n02) * (c**2 - d**2) + 4 * n11 * c * d,
        b * c * (c**2 - 3 * d**2) - a * d * (3 * c**2 - d**2),
    ]
