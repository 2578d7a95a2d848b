"""Readings that do not come, and messages that hold none: told in time, once as long as it lasts."""

from __future__ import annotations

import time
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.live_scripted import Scripted, sample

from varishold.errors import EndOfSourceError
from varishold.live import Sample, lull, watching
from varishold.live.lull import Lull, overrun_words, unused_words
from varishold.live.stream import Change

SILENT = "no reading has come in 3 s; waiting"


def told(kinds: list[str], step_s: float = 0.01) -> list[tuple[float, str]]:
    """Return what is told, and when, of messages so far apart: "+" a reading, "-" one that is none, " " no message."""
    looking, received, damaged, said = Lull(0.0), 0, 0, []
    for k, kind in enumerate(kinds, 1):
        received += kind == "+"
        damaged += kind == "-"
        if words := looking.look(received, SimpleNamespace(damaged=damaged, damage="odd"), k * step_s):
            said.append((k * step_s, words))
    return said


@settings(max_examples=30)
@given(st.lists(st.integers(1, 290), min_size=1, max_size=20))
def test_readings_less_than_three_seconds_apart_are_never_told(gaps: list[int]) -> None:
    assert told([kind for gap in gaps for kind in [" "] * gap + ["+"]]) == []


def test_a_silence_is_told_once_and_the_next_one_again() -> None:
    ((when_s, words), (again_s, _)) = told(["+"] * 400 + [" "] * 900 + ["+"] * 400 + [" "] * 900)
    assert (words, when_s, again_s) == (SILENT, pytest.approx(7.0, abs=0.02), pytest.approx(20.0, abs=0.02))


def test_a_sensor_that_is_slow_is_told_once() -> None:
    assert [words for _, words in told(([" "] * 999 + ["+"]) * 20)] == [SILENT]


@pytest.mark.parametrize(
    ("mixed", "words"),
    [
        (["-"], "messages held no frame that could be used: odd"),
        (["+", "-"], "messages held no frame that could be used: odd"),
        (["+"] * 9 + ["-"], "messages held no frame that could be used: odd"),
        # A few of many are told at the end.
        (["+"] * 99 + ["-"], ""),
    ],
)
def test_messages_that_hold_no_frame_are_told_once_within_three_seconds(mixed: list[str], words: str) -> None:
    kinds = ["+"] * 400 + mixed * (2000 // len(mixed))
    said = told(kinds)
    assert len(said) == bool(words)
    for when_s, what in said:
        assert 4.0 < when_s < 7.0
        assert what.endswith(words)
        assert (" of " in what) == (mixed != ["-"])


def test_one_bad_message_is_told_where_nothing_else_comes() -> None:
    ((when_s, words),) = told(["+"] * 100 + ["-"] + [" "] * 900)
    assert words == "1 message held no frame that could be used: odd"
    assert when_s == pytest.approx(4.0, abs=0.02)
    assert told(["+"] * 100 + ["-"] + ["+"] * 900) == []


def test_time_begins_when_the_source_is_there() -> None:
    looking = Lull(0.0)
    looking.restart(50.0)
    assert looking.look(0, None, 52.9) == ""
    assert looking.look(0, None, 53.1) == SILENT
    assert unused_words(0) == ""


class Silent(Scripted):
    """Gives two samples, then nothing for some time, then ends."""

    def __init__(self) -> None:
        super().__init__()
        self.came, self.ends_s = 0, time.monotonic() + 0.5

    def read(self, timeout_s: float) -> list[Sample]:
        self.came += 1
        if self.came <= 2:
            return [sample(self.came)]
        time.sleep(0.01)
        if time.monotonic() > self.ends_s:
            raise EndOfSourceError("over")
        return []


@pytest.mark.parametrize("every", [True, False])
def test_who_watches_is_told_of_a_silence_once(every: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lull, "_SILENT_S", 0.2)
    changes: list[Change] = []
    number = sum(seen.sample is not None for seen in watching.watch(Silent(), every=every, on_change=changes.append))
    assert number == 2
    assert [(change.state, change.words) for change in changes] == [
        ("opening", ""),
        ("open", ""),
        ("open", "no reading has come in 0 s; waiting"),
        ("ended", "" if every else "over"),
    ]


def lost(grows: list[int], step_s: float = 0.1) -> list[tuple[float, str]]:
    """Return what is told, and when, where so many messages are lost between a look and the next."""
    looking, overrun, said = Lull(0.0), 0, []
    for k, more in enumerate(grows, 1):
        overrun += more
        if words := looking.look(k, SimpleNamespace(overrun=overrun), k * step_s):
            said.append((k * step_s, words))
    return said


def test_what_came_faster_than_it_was_read_is_told_once_with_all_of_a_burst() -> None:
    assert lost([0] * 100) == []
    ((when_s, words),) = lost([0, 40, 60, 2] + [0] * 100)
    assert (words, when_s) == (overrun_words(102), pytest.approx(0.7))
    # As long as it lasts it is told once, and the next one again.
    assert [words for _, words in lost([7] * 300)] == [overrun_words(42)]
    assert [words for _, words in lost([7] + [0] * 40 + [8] + [0] * 10)] == [overrun_words(7), overrun_words(8)]


def test_a_loss_is_told_after_what_else_there_is_to_tell() -> None:
    looking = Lull(0.0)
    said = [looking.look(0, SimpleNamespace(overrun=5), k / 10) for k in range(1, 40)]
    assert [words for words in said if words] == [overrun_words(5), SILENT]


def test_one_message_that_was_lost_is_one() -> None:
    assert overrun_words(0) == ""
    assert overrun_words(1) == "1 message was lost: it came faster than it could be read"
