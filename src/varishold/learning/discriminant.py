"""The learner: a kernel discriminant, in closed form and plain numbers.

Measures are standardized and compared with those of training presses by a kernel of their mean difference a measure:
absolute differences (a Laplacian kernel), which a few spoiled measures do not outvote, or squared ones (a Gaussian
kernel), which are smooth. In the space of the kernel the scatter within classes, shrunk towards an even one, is
whitened, and only the directions in which classes differ are kept: there every class is a point, and an answer's score
is minus half its squared distance from it.

References
----------
S. Mika et al., "Fisher discriminant analysis with kernels", 1999.
J. Friedman, "Regularized discriminant analysis", 1989.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.kernel import address, bind

__all__ = [
    "Discriminant",
    "Scaling",
    "blocks",
    "differences",
    "discriminants",
    "distances",
    "landmark_rows",
    "learn_scaling",
    "linear_discriminants",
    "single",
]

Floats = NDArray[np.float64]

# A standardized measure counts no further than so many standard deviations.
_CLIP = 4.0
# Directions of the kernel's space whose share of the largest is less are rounding.
_RANK = 1e-9
# More training presses than these, or with more measures in all, are not compared with one by one: a model stays small.
_MOST_LANDMARKS, _MOST_NUMBERS = 800, 300_000
# Numbers that are worked on together: they stay in a processor's cache.
_TOGETHER = 1 << 15

_distances = bind("vh_distances", "pipiiip")


@dataclass(frozen=True, eq=False)
class Scaling:
    """What turns measures into numbers of one size: shape (n_measures,) each; a constant one has scale 0."""

    shift: Floats
    scale: Floats

    def apply(self, measures: Floats, drift: Floats | float = 0.0) -> Floats:
        """Return standardized measures less their drift, cut off.

        What is unknown is at the mean, but NaN where nothing is known of a press.
        """
        scaled = np.clip((measures - self.shift) * self.scale - drift, -_CLIP, _CLIP)
        nothing = np.isnan(scaled).all(axis=1, keepdims=True)
        # Single precision is what a model file keeps.
        return np.where(nothing, np.nan, np.nan_to_num(scaled, nan=0.0)).astype(np.float32).astype(np.float64)


@dataclass(frozen=True, eq=False)
class Discriminant:
    """What was learned from differences of one power.

    Parameters
    ----------
    power : {1, 2}
        Whether differences are absolute or squared.
    width : float
        The mean difference a measure at which the kernel has fallen to 1 / e.
    shrinkage : float
        How far the scatter within classes was drawn towards an even one.
    whiten : ndarray of shape (n_landmarks, n_directions), float64
        From similarities to coordinates in which every class scatters by 1; at most n_classes - 1 directions.
    means : ndarray of shape (n_classes, n_directions), float64
    """

    power: int
    width: float
    shrinkage: float
    whiten: Floats
    means: Floats

    def coordinates(self, apart: Floats) -> Floats:
        """Return where presses lie, shape (n, n_directions), by their `distances` from the landmarks."""
        return np.asarray(np.exp(-apart / self.width) @ self.whiten)

    def judge_alike(self, alike: Floats, nearest: Floats) -> tuple[Floats, Floats]:
        """Judge presses as `judge` does, by their similarities to the landmarks, which discriminants of a width share.

        Parameters
        ----------
        alike : ndarray of shape (n, n_landmarks), float64
            ``exp(-apart / width)``.
        nearest : ndarray of shape (n,), float64
            The mean difference from the nearest landmark.
        """
        at = alike @ self.whiten
        squared = (at * at).sum(axis=1)[:, None] - 2 * at @ self.means.T + (self.means * self.means).sum(axis=1)
        squared = np.maximum(squared, 0.0)
        return -0.5 * squared, np.stack([squared.min(axis=1), nearest], axis=1)

    def judge(self, apart: Floats) -> tuple[Floats, Floats]:
        """Judge presses by their `distances` from the landmarks, shape (n, n_landmarks).

        Returns
        -------
        scores : ndarray of shape (n, n_classes), float64
        strangeness : ndarray of shape (n, 2), float64
            Squared distance from the nearest class, and the mean difference from the nearest landmark.
        """
        return self.judge_alike(np.exp(-apart / self.width), apart.min(axis=1))


def learn_scaling(measures: Floats) -> Scaling:
    """Return the scaling that some presses teach, shape (n, n_measures); NaN where a measure is unknown."""
    known = np.isfinite(measures)
    n = np.maximum(known.sum(axis=0), 1)
    shift = np.where(known, measures, 0.0).sum(axis=0) / n
    spread = np.sqrt((np.where(known, measures - shift, 0.0) ** 2).sum(axis=0) / n)
    constant = spread <= 1e-9 * (1.0 + np.abs(shift))
    return Scaling(shift, np.where(constant, 0.0, 1.0 / np.where(constant, 1.0, spread)))


def discriminants(
    apart: Floats,
    rows: NDArray[np.intp],
    codes: NDArray[np.intp],
    n_classes: int,
    power: int,
    width: float,
    shrinkages: Sequence[float],
) -> list[Discriminant]:
    """Learn one discriminant for each shrinkage.

    Parameters
    ----------
    apart : ndarray of shape (n, n_landmarks), float64
        `distances` of presses from the landmarks, of this power.
    rows : ndarray of shape (n_landmarks,), int
        Which presses are landmarks.
    codes : ndarray of shape (n,), int
        The class of each press; every class that is named must be there.
    n_classes : int
    power : {1, 2}
    width : float
        The mean difference a measure at which the kernel has fallen to 1 / e.
    shrinkages : sequence of float
        From 0 (the scatter within classes as it is) to 1 (even in all directions).
    """
    alike = np.exp(-apart / width)
    values, vectors = np.linalg.eigh(alike[rows])
    kept = values > _RANK * values[-1]
    to_space = vectors[:, kept] / np.sqrt(values[kept])
    return [
        Discriminant(power, width, shrinkage, single(to_space @ directions), single(means))
        for shrinkage, (directions, means) in zip(
            shrinkages, linear_discriminants(alike @ to_space, codes, n_classes, shrinkages), strict=True
        )
    ]


def linear_discriminants(
    at: Floats, codes: NDArray[np.intp], n_classes: int, shrinkages: Sequence[float]
) -> list[tuple[Floats, Floats]]:
    """Return for each shrinkage the directions in which classes differ, and where each class lies along them.

    Parameters
    ----------
    at : ndarray of shape (n, n_dimensions), float64
    codes : ndarray of shape (n,), int
        The class of each; one that nothing is of lies in the middle of all.
    n_classes : int
    shrinkages : sequence of float
        From 0 (the scatter within classes as it is) to 1 (even in all directions).

    Returns
    -------
    list of (ndarray of shape (n_dimensions, r), ndarray of shape (n_classes, r)), float64
        Along the directions, at most n_classes - 1, every class scatters by 1.
    """
    means = np.stack([at[of].mean(axis=0) if (of := codes == k).any() else at.mean(axis=0) for k in range(n_classes)])
    off = at - means[codes]
    within, turn = np.linalg.eigh(off.T @ off / max(len(at) - n_classes, 1))
    within = np.maximum(within, 0.0)
    even = float(within.mean()) or 1.0
    found = []
    for shrinkage in shrinkages:
        gain = 1.0 / np.sqrt((1 - shrinkage) * within + shrinkage * even)
        places = (means @ turn) * gain
        between = np.linalg.svd(places - places.mean(axis=0), full_matrices=False)[2][: n_classes - 1].T
        found.append(((turn * gain) @ between, places @ between))
    return found


def single(array: Floats) -> Floats:
    """Return numbers as a model file keeps them."""
    return array.astype(np.float32).astype(np.float64)


def distances(scaled: Floats, landmarks: Floats, power: int) -> Floats:
    """Return the mean absolute (power 1) or squared (2) difference a measure, shape (n, n_landmarks)."""
    n, (n_landmarks, n_measures) = len(scaled), landmarks.shape
    apart = np.zeros((n, n_landmarks))
    if apart.size and n_measures:
        ones, others = (np.require(of, np.float64, ["C", "W"]) for of in (scaled, landmarks))
        _distances(address(ones), n, address(others), n_landmarks, n_measures, power, address(apart))
    return apart


def differences(landmarks: Floats, one: Floats, power: int) -> Floats:
    """Return the absolute (power 1) or squared (2) difference of each measure, shape (n_landmarks, n_measures)."""
    off = landmarks - one
    return np.abs(off, out=off) if power == 1 else np.multiply(off, off, out=off)


def blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    """Yield the rows of a table in blocks that stay in a processor's cache."""
    n_rows, n_columns = shape
    together = max(1, _TOGETHER // max(n_columns, 1))
    return (slice(first, first + together) for first in range(0, n_rows, together))


def landmark_rows(codes: NDArray[np.intp], n_measures: int, share: float = 1.0) -> NDArray[np.intp]:
    """Return which presses are landmarks: all, or of each class as many, the first ones.

    A model that is one of two keeps a share of the numbers that one alone may keep.
    """
    most = min(_MOST_LANDMARKS, int(share * _MOST_NUMBERS) // n_measures)
    if len(codes) <= most:
        return np.arange(len(codes))
    classes = np.unique(codes)
    each = max(1, most // len(classes))
    chosen = []
    for k in classes:
        of = np.flatnonzero(codes == k)
        chosen.append(of[:each])
    return np.sort(np.concatenate(chosen))
