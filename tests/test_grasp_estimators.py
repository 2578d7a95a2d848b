"""scikit-learn's contract for the classifier and the encoder."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sklearn.pipeline import make_pipeline
from sklearn.utils.estimator_checks import parametrize_with_checks

from varishold.errors import InputError
from varishold.grasp import HyperplaneClassifier, ThresholdEncoder


@parametrize_with_checks(
    [
        HyperplaneClassifier("auto", binarize=0.0, max_hyperplanes=40),
        HyperplaneClassifier("paper", binarize=0.0),
        HyperplaneClassifier("robust", binarize=0.0),
        HyperplaneClassifier("vote", binarize=0.0, max_hyperplanes=40),
        ThresholdEncoder("quantile"),
        ThresholdEncoder("even"),
        ThresholdEncoder("supervised"),
    ]
)
@pytest.mark.filterwarnings("ignore")
def test_scikit_learn_contract(estimator: Any, check: Any) -> None:
    check(estimator)


def test_a_pipeline_takes_any_sensor() -> None:
    rng = np.random.default_rng(0)
    X = np.concatenate([rng.normal(0, 1, (20, 6)), rng.normal(3, 1, (20, 6))])
    y = np.repeat(["soft", "hard"], 20)
    pipe = make_pipeline(ThresholdEncoder(), HyperplaneClassifier()).fit(X, y)
    assert pipe.score(X, y) == 1.0


def test_options_are_checked() -> None:
    X, y = [[0, 1], [1, 0]], ["a", "b"]
    for wrong, message in (
        ({"mode": "best"}, "mode must be auto, paper, robust, vote, got 'best'"),
        ({"flip_rate": 0.5}, "flip_rate must be at least 0 and below 0.5"),
        ({"max_hyperplanes": 0}, "max_hyperplanes must be positive or None, got 0"),
        ({"variants": [[0, 2]]}, r"variants must be integers from -1 to 1 of shape \(n_variants, 2\)"),
    ):
        with pytest.raises(InputError, match=message):
            HyperplaneClassifier(**wrong).fit(X, y)
    with pytest.raises(InputError, match="levels must lie between 1 and 1024, got 0"):
        ThresholdEncoder(levels=0).fit(X)
    with pytest.raises(InputError, match="strategy must be quantile, even or supervised, got 'odd'"):
        ThresholdEncoder("odd").fit(X)  # type: ignore[arg-type]


def test_what_is_no_switch_is_named() -> None:
    with pytest.raises(InputError, match=r"switches must be 0 or 1, got 0.5 at \(grasp, switch\) = \(1, 0\)"):
        HyperplaneClassifier().fit([[0, 1], [0.5, 0]], ["a", "b"])
    with pytest.raises(ValueError, match="NaN"):
        HyperplaneClassifier().fit([[0, 1], [np.nan, 0]], ["a", "b"])
    with pytest.raises(InputError, match="at least two classes to tell apart, got 1 class"):
        HyperplaneClassifier().fit([[0, 1], [1, 0]], ["a", "a"])
    with pytest.raises(ValueError, match="0 sample"):
        HyperplaneClassifier().fit(np.zeros((0, 3)), [])
