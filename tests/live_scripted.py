"""A source that does what a test tells it, and a wait that is long on a busy machine and short on an idle one."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from queue import Empty, SimpleQueue

import numpy as np

from varishold.live import PadLayout, Sample

__all__ = ["Scripted", "sample", "wait_until"]


def sample(number: int) -> Sample:
    """A sample that can be told from others."""
    return Sample(number / 100, 1e9 + number / 100, number, {"pad": np.full((2, 3), number, np.int32)})


def wait_until(true: Callable[[], bool], limit_s: float = 20.0) -> None:
    """Wait for a condition; fail only long after it should have come."""
    ends = time.monotonic() + limit_s
    while not true():
        assert time.monotonic() < ends, "waited in vain"
        time.sleep(0.002)


class Scripted:
    """Gives what the test puts: samples, or an error to raise."""

    address = "scripted:"
    pads: Mapping[str, PadLayout] = {"pad": PadLayout((2, 3))}

    def __init__(self) -> None:
        self.script: SimpleQueue[Sample | Exception] = SimpleQueue()
        self.there = True
        self.opened = self.closed = 0
        self.wrong: Exception | None = None

    def open(self) -> None:
        from varishold.errors import LostSourceError

        if self.wrong is not None:
            raise self.wrong
        if not self.there:
            raise LostSourceError("scripted:: is not there")
        self.opened += 1

    def read(self, timeout_s: float) -> list[Sample]:
        try:
            first = self.script.get(timeout=timeout_s)
        except Empty:
            return []
        if isinstance(first, Exception):
            raise first
        return [first]

    def close(self) -> None:
        self.closed += 1
