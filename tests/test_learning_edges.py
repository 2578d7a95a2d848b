"""Edges of what is learned of presses: what is listed, refused, typical and strange, by plain counting."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.learning import pad_networks
from varishold.learning.discriminant import discriminants, distances, linear_discriminants
from varishold.learning.pad_networks import _calibrated, _solved, _strangest, _typical, refusal_limit
from varishold.learning.press_classifier import PressClassifier
from varishold.trust import Calibration

few = settings(max_examples=30)
seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize(
    ("probabilities", "listed"),
    [
        ([0.9, 0.09, 0.01], {"b": 0.09, "c": 0.01}),
        ([0.0099, 0.0101, 0.98], {"b": 0.0101}),
        ([0.5, 0.5, 0.0], {"b": 0.5}),
        ([0.0, 0.0, 1.0], {}),
    ],
)
def test_alternatives_have_a_hundredth_at_least(probabilities: list[float], listed: dict[str, float]) -> None:
    reasons = [(f"measure {k}", 1.0 - 0.1 * k) for k in range(7)]
    judge = SimpleNamespace(
        _outside=lambda said, k: (),
        _unlike=lambda said, k: False,
        _reasons=lambda said, k, first, second: (reasons, 1),
        classes_=np.array(["a", "b", "c"]),
        error=0.05,
        places_=["p", "q"],
        landmark_codes=np.array([2, 0]),
        adapted_to_="monday",
    )
    press = SimpleNamespace(place="here")
    for p_value in (0.05, 0.0501):
        told = PressClassifier._recognition(judge, press, 0, np.array(probabilities), p_value, None)
        assert told.label == "abc"[int(np.argmax(probabilities))]
        assert told.probability == max(probabilities)
        assert told.alternatives == listed
        assert list(told.alternatives.values()) == sorted(listed.values(), reverse=True)
        assert told.refused == (p_value <= 0.05)
        assert told.measures == tuple(reasons[:5])
        assert (told.nearest, told.nearest_label, told.place, told.adapted_to) == ("q", "a", "here", "monday")


@few
@given(seeds, st.integers(0, 30), st.floats(0.01, 0.5))
def test_a_press_at_the_limit_is_the_strangest_that_is_refused(seed: int, n: int, error: float) -> None:
    known = np.random.default_rng(seed).normal(size=n)
    limit = refusal_limit(known, error)

    def p_value(strange: float) -> float:
        return (1 + np.count_nonzero(known >= strange)) / (1 + n)

    if np.isinf(limit):
        assert 1 / (1 + n) > error
        return
    assert p_value(np.nextafter(limit, np.inf)) <= error
    assert p_value(limit) > error


@few
@given(seeds, st.integers(1, 4))
def test_the_strangest_pad_counts_and_a_press_of_none_is_stranger_than_any(seed: int, pads: int) -> None:
    rng = np.random.default_rng(seed)
    away = rng.uniform(-2, 5, (pads, 9))
    away[rng.random(away.shape) < 0.5] = np.nan
    told = _strangest(list(away))
    for k in range(9):
        known = away[np.isfinite(away[:, k]), k]
        assert told[k] == (known.max() if known.size else 1e9)
    flat = away[0][np.isfinite(away[0])]
    assert _typical(away[0]) == (max(np.quantile(flat, 0.9), 1e-9) if flat.size else 1.0)
    assert _typical(np.zeros(4)) == 1e-9


@few
@given(seeds, st.floats(0.1, 30))
def test_the_largest_temperature_of_about_the_least_loss_is_taken(seed: int, sharp: float) -> None:
    rng = np.random.default_rng(seed)
    truth = rng.integers(0, 3, 40)
    scores = sharp * (rng.normal(size=(40, 3)) + 1.5 * (np.arange(3) == truth[:, None]))
    temperature, loss = _calibrated(scores, truth)

    def loss_of(t: float) -> float:
        p = Calibration(t, 0.0).probabilities(scores)
        # A class counts as the root of how many are of it.
        each = [-np.log(np.maximum(p[truth == k, k], 1e-12)).mean() for k in range(3)]
        return float(np.average(each, weights=np.sqrt(np.bincount(truth, minlength=3))))

    tried = np.geomspace(0.25, 1024, 73)
    losses = np.array([loss_of(t) for t in tried])
    assert loss == pytest.approx(loss_of(temperature))
    assert temperature in tried
    assert loss <= losses.min() + 0.01
    assert (losses[tried > temperature] > losses.min() + 0.01).all()


def test_a_pad_that_nobody_touched_tells_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing = _solved(np.full((6, 4), np.nan), np.arange(6) % 3, 3)
    assert len(nothing) == 6
    for found in nothing:
        arrays = [value for value in vars(found).values() if isinstance(value, np.ndarray)]
        assert {array.shape for array in arrays} == {(4, 1), (3, 1)}
        assert not any(array.any() for array in arrays)
    rng = np.random.default_rng(0)
    codes = np.arange(30) % 3
    signatures = rng.normal(size=(30, 4)) + codes[:, None]
    signatures[4] = np.nan
    found = _solved(signatures, codes, 3)
    assert len(found) == len(pad_networks._SHRINKAGES)
    touched = np.delete(np.arange(30), 4)
    scaled = found[0].scaling.apply(signatures[touched])
    wanted = linear_discriminants(scaled, codes[touched], 3, pad_networks._SHRINKAGES)
    for one, (directions, means) in zip(found, wanted, strict=True):
        shapes = {array.shape: array for array in vars(one).values() if isinstance(array, np.ndarray)}
        np.testing.assert_allclose(shapes[4, 2], directions, rtol=1e-6, atol=1e-7)
        np.testing.assert_allclose(shapes[3, 2], means, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("power", [1, 2])
def test_a_press_that_was_learned_twice_is_a_landmark_once(power: int) -> None:
    rng = np.random.default_rng(3)
    codes = np.arange(24) % 3
    presses = rng.normal(size=(24, 5)) + 0.8 * codes[:, None]
    asked = rng.normal(size=(10, 5))
    told = []
    for rows in (np.arange(24), np.concatenate([np.arange(24), np.arange(24)])):
        apart = distances(presses, presses[rows], power)
        (found,) = discriminants(apart, rows, codes, 3, power, 2.0, [0.2])
        told.append(found.judge(distances(asked, presses[rows], power)))
        assert np.isfinite(told[-1][0]).all()
    for one, other in zip(*told, strict=True):
        np.testing.assert_allclose(one, other, rtol=2e-3, atol=2e-3)
