"""Reading a source in a test: so many samples, or until it fails."""

from __future__ import annotations

import time
from typing import NoReturn

from varishold.live import Sample, Source

__all__ = ["read_on", "read_some"]


def read_some(source: Source, count: int, limit_s: float = 20.0) -> list[Sample]:
    """Read until so many samples have come."""
    samples: list[Sample] = []
    ends_s = time.monotonic() + limit_s
    while len(samples) < count:
        assert time.monotonic() < ends_s, f"{len(samples)} of {count} came"
        samples += source.read(0.05)
    return samples


def read_on(source: Source, limit_s: float = 20.0) -> NoReturn:
    """Read until the source raises something."""
    ends_s = time.monotonic() + limit_s
    while time.monotonic() < ends_s:
        source.read(0.1)
    raise AssertionError("the source went on and on")
