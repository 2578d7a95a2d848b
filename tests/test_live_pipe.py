"""Standard input that does what a test tells it: what is there to be read, how long is waited, and its end."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from tests.live_scripted import sample

from varishold.errors import EndOfSourceError, InputError
from varishold.live import source_at
from varishold.live.sources import standard_input
from varishold.live.sources.standard_input import StandardInput


class Pipe:
    """Something that is piped in, piece by piece; None is a moment in which nothing comes."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *pieces: bytes | None) -> None:
        self._pieces, self.waits = list(pieces), []  # type: ignore[var-annotated]
        monkeypatch.setattr(standard_input.sys, "stdin", self)
        monkeypatch.setattr(standard_input.select, "select", self._select)
        monkeypatch.setattr(standard_input.os, "read", lambda handle, size: self._pieces.pop(0) or b"")
        self.closed, self._terminal = False, False

    def _select(self, reading: list[int], writing: list[int], failing: list[int], wait_s: float) -> tuple[Any, ...]:
        assert (reading, writing, failing) == ([5], [], [])
        self.waits.append(wait_s)
        if self._pieces and self._pieces[0] is None:
            self._pieces.pop(0)
            return [], [], []
        return [5], [], []

    def fileno(self) -> int:
        return 5

    def isatty(self) -> bool:
        return self._terminal


def test_what_is_piped_in_is_read_and_its_end_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    pipe = Pipe(monkeypatch, b"[[1, 2]]\n[[3", None, b", 4]]\n[1", b"")
    source = source_at("stdin:")
    source.open()
    came = [source.read(0.3) for _ in range(4)]
    assert [[one.pads["pad"].tolist() for one in each] for each in came] == [[[[1, 2]]], [], [[[3, 4]]], []]
    assert pipe.waits == [0.3] * 4
    # The line that broke off is damage.
    assert source.damaged == 1  # type: ignore[attr-defined]
    for _ in range(2):
        with pytest.raises(EndOfSourceError, match=r"^stdin:: the program that wrote has ended$"):
            source.read(0.0)
    source.close()


def test_a_last_line_without_its_end_is_read_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    Pipe(monkeypatch, b"[[1, 2]]", b"")
    source = source_at("stdin:")
    assert source.read(0.0) == []
    assert [one.pads["pad"].tolist() for one in source.read(0.0)] == [[[1, 2]]]
    with pytest.raises(EndOfSourceError):
        source.read(0.0)


def test_a_rate_gives_times_to_those_that_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    Pipe(monkeypatch, b"a", b"b", b"")
    own = sample(1)._replace(device_time_s=9.5)
    bare = sample(0)._replace(device_time_s=None)
    unpacking: Any = SimpleNamespace(samples=lambda data: [bare, own, bare], finish=lambda: [bare], pads={}, damaged=4)
    source = StandardInput("stdin:", unpacking, rate_hz=4.0)
    assert [one.device_time_s for _ in range(3) for one in source.read(0.0)] == [0.0, 9.5, 0.5, 0.75, 9.5, 1.25, 1.5]
    assert (source.damaged, source.pads, source.address) == (4, {}, "stdin:")
    Pipe(monkeypatch, b"a")
    assert [one.device_time_s for one in StandardInput("stdin:", unpacking).read(0.0)] == [None, 9.5, None]
    assert source_at("stdin:-?rate_hz=50")._rate_hz == 50.0  # type: ignore[attr-defined]
    assert source_at("stdin:")._rate_hz is None  # type: ignore[attr-defined]


def test_nothing_that_is_piped_in_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    pipe, source = Pipe(monkeypatch), source_at("stdin:")
    source.open()
    pipe._terminal = True
    with pytest.raises(InputError, match=r"^stdin:: nothing is piped in; write PROGRAM \| varishold \.\.\. stdin:$"):
        source.open()
    pipe.closed = True
    with pytest.raises(InputError, match=r"^stdin:: there is no standard input$"):
        source.open()
    monkeypatch.setattr(standard_input.sys, "stdin", None)
    with pytest.raises(InputError, match=r"^stdin:: there is no standard input$"):
        source.open()


def test_where_a_pipe_cannot_be_waited_for_it_is_read_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    pipe, source = Pipe(monkeypatch, b"[[1, 2]]\n"), source_at("stdin:")
    monkeypatch.setattr(standard_input.os, "name", "nt")
    try:
        assert len(source.read(0.3)) == 1
    finally:
        monkeypatch.undo()
    assert pipe.waits == []
