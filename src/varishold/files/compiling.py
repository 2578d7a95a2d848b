"""Compiled functions are kept in a cache where one can be written, and in memory where not."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numba

__all__ = ["njit"]


def njit(*signature: Any, cache: bool = True, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """As `numba.njit`; where no cache can be written (a read-only install, no home) each process compiles for itself.

    Parameters
    ----------
    *signature
        One signature to compile for at once; default: each call's own.
    cache : bool
        Keep the compiled code between runs where that is possible.
    **options
        As those of `numba.njit`.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        # Without a home numba would make a folder called ~ where it stands.
        if cache and os.path.expanduser("~") != "~":
            try:
                return numba.njit(*signature, cache=True, **options)(function)
            except RuntimeError:  # no place for a cache
                pass
        return numba.njit(*signature, **options)(function)

    return compiled
