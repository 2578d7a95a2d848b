"""The course of a press in time: `loading_features` measures one press, `LoadingFeatures` is the transformer."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from varishold.touch.course.loading import Loading, loading_features

if TYPE_CHECKING:
    from varishold.touch.course.features import LoadingFeatures

__all__ = ["Loading", "LoadingFeatures", "loading_features"]


def __getattr__(name: str) -> Any:
    if name == "LoadingFeatures":
        # scikit-learn is loaded when it is asked for.
        return importlib.import_module("varishold.touch.course.features").LoadingFeatures
    raise AttributeError(f"module 'varishold.touch.course' has no attribute {name!r}")
