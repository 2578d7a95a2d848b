"""The discriminant beside plain linear algebra in the kernel's space, and the scaling beside plain means."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.learning import discriminant as learner
from varishold.learning.discriminant import Discriminant, Scaling, discriminants, landmark_rows, learn_scaling


def plain_scaling(column: list[float]) -> tuple[float, float]:
    known = [value for value in column if math.isfinite(value)]
    if not known:
        return 0.0, 0.0
    mean = sum(known) / len(known)
    spread = math.sqrt(sum((value - mean) ** 2 for value in known) / len(known))
    return mean, 0.0 if spread <= 1e-9 * (1 + abs(mean)) else 1 / spread


@given(st.integers(0, 2**31), st.integers(1, 9))
@settings(max_examples=30)
def test_measures_are_scaled_by_what_is_known_of_them(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    measures = rng.normal(3, 2, (n, 5)) * (1, 1e4, 1e-4, 1, 1)
    measures[rng.random((n, 5)) < 0.2] = np.nan
    measures[:, 3] = 7.0
    measures[:, 4] = np.nan
    made = learn_scaling(measures)
    for column, shift, scale in zip(measures.T.tolist(), made.shift, made.scale, strict=True):
        assert (shift, scale) == pytest.approx(plain_scaling(column), rel=1e-9, abs=1e-12)
    # No further than four deviations; what is unknown or never differs lies at the mean.
    far = made.shift + 9.0 * np.where(made.scale > 0, 1 / np.where(made.scale > 0, made.scale, 1), 1.0)
    for sign in (1, -1):
        scaled = made.apply((made.shift + sign * (far - made.shift))[None])[0]
        np.testing.assert_array_equal(scaled, np.where(made.scale > 0, sign * 4.0, 0.0))
    middle = made.apply((0.7 * far + 0.3 * made.shift)[None] / 9 + (1 - 1 / 9) * made.shift)[0]
    np.testing.assert_allclose(middle, np.where(made.scale > 0, 0.7, 0.0), rtol=1e-3)
    assert not made.apply(np.full((2, 5), np.nan)).any()


def similarity(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    out = np.empty((len(a), len(b)))
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i, j] = math.exp(-((x - y) ** 2).sum() / (2 * width * len(x)))
    return out


@given(st.integers(0, 2**31), st.integers(2, 4), st.booleans())
@settings(max_examples=20, deadline=None)
def test_scores_are_distances_in_the_whitened_space_of_the_kernel(seed: int, n_classes: int, few: bool) -> None:
    """By Cholesky's factor where the program takes eigenvectors: the space is the same but for a turn."""
    rng = np.random.default_rng(seed)
    codes = np.tile(np.arange(n_classes), 5)
    scaled = rng.normal(0, 1, (len(codes), 6)) + 1.2 * np.eye(n_classes, 6)[codes]
    rows = np.arange(0, len(codes), 2) if few else np.arange(len(codes))
    width, shrinkages = 0.7, (0.1, 0.6, 1.0)
    found = discriminants(scaled, codes, n_classes, width, shrinkages, Scaling(np.zeros(6), np.ones(6)), rows)
    landmarks = scaled[rows]
    root = np.linalg.cholesky(similarity(landmarks, landmarks, width))

    def place(x: np.ndarray) -> np.ndarray:
        return np.linalg.solve(root, similarity(x, landmarks, width).T).T

    at = place(scaled)
    means = np.array([at[codes == k].mean(axis=0) for k in range(n_classes)])
    scatter = sum(np.outer(p - means[k], p - means[k]) for p, k in zip(at, codes, strict=True))
    scatter = scatter / (len(at) - n_classes)
    fresh = rng.normal(0, 1.5, (7, 6))
    for made, shrinkage in zip(found, shrinkages, strict=True):
        assert (made.shrinkage, made.width) == (shrinkage, width)
        assert made.whiten.shape == (len(rows), n_classes - 1)
        shrunk = (1 - shrinkage) * scatter + shrinkage * np.trace(scatter) / len(scatter) * np.eye(len(scatter))
        values, vectors = np.linalg.eigh(shrunk)
        whiten = (vectors / np.sqrt(values)) @ vectors.T
        centres = means @ whiten
        apart = np.linalg.svd(centres - centres.mean(axis=0), full_matrices=False)[2][: n_classes - 1]
        projected, points = centres @ apart.T, place(fresh) @ whiten @ apart.T
        squared = ((points[:, None] - projected[None]) ** 2).sum(axis=2)
        scores, strange = made.judge(fresh)
        np.testing.assert_allclose(scores, -squared / 2, rtol=2e-3, atol=2e-3 * squared.max())
        np.testing.assert_allclose(strange[:, 0], squared.min(axis=1), rtol=2e-3, atol=2e-3 * squared.max())
        nearest = [min(((x - y) ** 2).sum() for y in landmarks) / 6 for x in fresh]
        np.testing.assert_allclose(strange[:, 1], nearest, rtol=1e-9)
        np.testing.assert_allclose(made.coordinates(scaled[codes == 0]).mean(axis=0), made.means[0], atol=1e-2)
        # What is kept is what a file keeps.
        assert (made.whiten == made.whiten.astype(np.float32)).all()


def test_without_any_scatter_classes_are_still_told_apart() -> None:
    scaled = np.repeat(np.eye(3), 2, axis=0)
    codes = np.repeat(np.arange(3), 2)
    (made,) = discriminants(scaled, codes, 3, 1.0, (0.5,), Scaling(np.zeros(3), np.ones(3)), np.arange(6))
    scores, strange = made.judge(np.eye(3))
    assert scores.argmax(axis=1).tolist() == [0, 1, 2]
    assert np.isfinite(scores).all()
    np.testing.assert_allclose(strange, 0, atol=1e-3)
    assert isinstance(made, Discriminant)


def test_a_model_stays_small(monkeypatch: pytest.MonkeyPatch) -> None:
    codes = np.array([0, 1, 0, 2, 1, 0, 2, 0, 1, 2])
    assert landmark_rows(codes, 100).tolist() == list(range(10))
    monkeypatch.setattr(learner, "_MOST_LANDMARKS", 10)
    assert landmark_rows(codes, 1).tolist() == list(range(10))
    monkeypatch.setattr(learner, "_MOST_LANDMARKS", 9)
    # As many of each class, the first ones, in the order in which they stand.
    assert landmark_rows(codes, 1).tolist() == [0, 1, 2, 3, 4, 5, 6, 8, 9]
    monkeypatch.setattr(learner, "_MOST_LANDMARKS", 7)
    assert landmark_rows(codes, 1).tolist() == [0, 1, 2, 3, 4, 6]
    monkeypatch.setattr(learner, "_MOST_LANDMARKS", 2)
    assert landmark_rows(codes, 1).tolist() == [0, 1, 3]
    monkeypatch.undo()
    many = np.zeros(1000, int)
    assert len(landmark_rows(many, 10)) == 400
    assert len(landmark_rows(many, 3000)) == 100
