"""Laws of learning from recordings that were made otherwise than those before: clocks, units, labels, copies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from varishold import TactileClassifier
from varishold.errors import InputError

SHAPE = (9, 10)
Pairs = list[tuple[np.ndarray, np.ndarray]]


def presses(seed: int, each: int = 8) -> tuple[Pairs, np.ndarray]:
    """Spots and bars that come up at 100 Hz, the bars in half the time."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(SHAPE) - np.array([4.0, 4.5])[:, None, None]
    forms = {"spot": np.exp(-(x * x + y * y) / 4), "bar": np.exp(-y * y / 3)}
    labels = np.tile(list(forms), each)
    made: Pairs = []
    for label in labels:
        n = 12 if label == "spot" else 6
        ramp = np.concatenate([np.zeros(2), np.linspace(0, 1, n), [0.5]])[:, None, None]
        frames = 100 * rng.uniform(0.9, 1.1) * ramp * forms[label] + rng.normal(0, 0.5, (n + 3, *SHAPE))
        made.append((frames, np.arange(n + 3) / 100))
    return made, labels


def without_time(pairs: Pairs) -> list[np.ndarray]:
    return [frames for frames, _ in pairs]


@pytest.fixture(scope="module")
def timed() -> TactileClassifier:
    return TactileClassifier(drift=0, folds=2).fit(*presses(0))


def test_a_press_without_times_is_refused_by_a_model_that_learned_times(timed: TactileClassifier) -> None:
    X, _ = presses(1)
    with pytest.raises(InputError, match=r"press 0: has no time_s, .* learn without"):
        timed.predict(without_time(X)[:3])
    with pytest.raises(InputError, match=r"press 1: has no time_s"):
        timed.predict([X[0], X[1][0], X[2]])


def test_where_some_training_press_has_no_time_nobodys_times_count() -> None:
    X, y = presses(0)
    mixed: list[Any] = [X[k] if k % 3 else X[k][0] for k in range(len(X))]
    plain = TactileClassifier(drift=0, folds=2).fit(without_time(X), y)
    some = TactileClassifier(drift=0, folds=2).fit(mixed, y)
    asked, _ = presses(2)
    expected = plain.predict_proba(without_time(asked))
    np.testing.assert_array_equal(some.predict_proba(asked), expected)
    np.testing.assert_array_equal(plain.predict_proba([(frames, 1e3 * time) for frames, time in asked]), expected)
