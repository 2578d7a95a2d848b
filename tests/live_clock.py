"""A clock that stands still until somebody waits."""

from __future__ import annotations

from types import ModuleType

import pytest

__all__ = ["Clock"]


class Clock:
    """Stands in for the module `time`: whoever waits lets the time pass at once.

    Parameters
    ----------
    monkeypatch : pytest.MonkeyPatch
    modules : module
        Those that get this clock.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *modules: ModuleType) -> None:
        self.now_s = 1000.0
        for module in modules:
            monkeypatch.setattr(module, "time", self)

    def monotonic(self) -> float:
        return self.now_s

    def time(self) -> float:
        return 1e9 + self.now_s

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0
        # Never a little too short, or whoever waits for a moment waits for ever.
        self.now_s += seconds + (1e-6 if seconds else 0.0)
