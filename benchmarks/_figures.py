"""Figures that a benchmark prints, kept for ``python -m benchmarks NAME --json``."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

__all__ = ["figure", "share", "taken"]


@dataclass(frozen=True)
class _Figure:
    name: str
    value: float | None
    unit: str
    bar: str


_kept: list[_Figure] = []


def figure(name: str, value: float, spec: str = "", unit: str = "", *, bar: str = "") -> str:
    """Keep a figure, and return it as it is printed: the value as `spec` says, its unit and its bar.

    Parameters
    ----------
    name : str
        What it is, and of what: no two figures of a benchmark have the same. Repeated spaces do not count.
    value : float
    spec : str
        As `format` takes it.
    unit : str
    bar : str
        What it must reach, as in ``>= 97``.
    """
    _kept.append(_Figure(" ".join(name.split()), float(value) if math.isfinite(value) else None, unit, bar))
    return format(value, spec) + (f" {unit}" if unit else "") + (f" (bar {bar})" if bar else "")


def share(name: str, value: float, spec: str = ".1f", *, bar: str = "") -> str:
    """Keep a share as a figure in percent, and return it as it is printed."""
    return figure(name, 100 * value, spec, "%", bar=bar)


def taken() -> list[dict[str, Any]]:
    """Return the figures that were kept since this was last called: name, value (None if not finite), unit and bar."""
    figures = [asdict(each) for each in _kept]
    _kept.clear()
    return figures
