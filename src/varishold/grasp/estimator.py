"""The contract of scikit-learn's estimators; where that is not installed, as much of it as answering takes.

A model that was learned elsewhere answers without it; learning needs it.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from varishold._counted import counted
from varishold._lazy import missing_extra
from varishold.errors import InputError

__all__ = [
    "BaseEstimator",
    "ClassifierMixin",
    "TransformerMixin",
    "check_classification_targets",
    "check_is_fitted",
    "feature_names",
    "few_of_each_class",
    "validate_data",
]


@contextmanager
def few_of_each_class() -> Iterator[None]:
    """Say nothing of there being nearly as many classes as grasps: each may well be its own."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The number of unique classes", UserWarning)
        yield


try:
    from sklearn.base import BaseEstimator, ClassifierMixin, TransformerMixin
    from sklearn.utils.multiclass import check_classification_targets
    from sklearn.utils.validation import _check_feature_names_in as feature_names
    from sklearn.utils.validation import check_is_fitted, validate_data
except ModuleNotFoundError as _error:
    _missing = _error

    class BaseEstimator:  # type: ignore[no-redef]
        """What an estimator is made of is its own."""

    class ClassifierMixin:  # type: ignore[no-redef]
        """A classifier."""

    class TransformerMixin:  # type: ignore[no-redef]
        """A transformer."""

    def check_classification_targets(y: Any) -> None:
        """Learning needs scikit-learn."""
        raise missing_extra(_missing) from None

    def check_is_fitted(estimator: Any) -> None:
        """Answer only what was learned."""
        if not hasattr(estimator, "n_features_in_"):
            raise InputError(f"this {type(estimator).__name__} has not learned anything yet; fit it, or read a model")

    def feature_names(estimator: Any, given: Any = None) -> Any:
        """Return the names of an estimator's inputs: those given, or x0, x1 ..."""
        if given is None:
            return np.array([f"x{i}" for i in range(estimator.n_features_in_)], dtype=object)
        if len(given) != estimator.n_features_in_:
            raise InputError(f"there are {estimator.n_features_in_} inputs, got {counted(len(given), 'name')}")
        return np.asarray(given, dtype=object)

    def validate_data(estimator: Any, X: Any, *targets: Any, reset: bool = True, dtype: Any = None, **_: Any) -> Any:
        """Return grasps as an array of shape (n_grasps, n_features) of as many features as were learned."""
        if reset or targets:
            raise missing_extra(_missing) from None
        values = np.asarray(X, dtype=dtype)
        if values.ndim != 2 or values.shape[1] != estimator.n_features_in_:
            raise InputError(
                f"X must have {counted(estimator.n_features_in_, 'column')}, got an array of shape {values.shape}"
            )
        return values
