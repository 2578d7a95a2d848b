"""The course of a press in time: `loading_features` measures one press, `features` is the transformer."""

from __future__ import annotations

from varishold.touch.course.loading import Loading, loading_features

__all__ = ["Loading", "loading_features"]
