"""What is told on standard error of a source that is lost: once as long as it goes on like that."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.cli.live import _tell_change
from varishold.live.losses import Losses
from varishold.live.stream import Change


def told(*changes: tuple[float, str, str]) -> list[float]:
    losses = Losses()
    return [at_s for at_s, state, words in changes if losses.is_news(Change(at_s, state, words))]  # type: ignore[arg-type]


def test_a_server_that_hangs_up_again_and_again_is_told_once() -> None:
    flaps = [(0.5 * k, "lost" if k % 2 else "open", "gone" * (k % 2)) for k in range(100)]
    assert told(*flaps) == [0.5]


def test_what_was_there_for_long_is_lost_anew() -> None:
    for there_s, again in ((9.0, []), (11.0, [12.0])):
        before = [(0.5, "lost", "gone"), (1.0, "open", ""), (3.0, "open", "no reading has come")]
        assert told(*before, (1.0 + there_s, "lost", "gone")) == [0.5, *again]


def test_another_reason_is_told_and_another_number_is_none() -> None:
    words = ["silent for 0.9 s", "silent for 1.1 s", "hung up", "silent for 2 s", "hung up"]
    assert told(*((float(k), "lost", one) for k, one in enumerate(words))) == [0.0, 2.0]


@given(st.lists(st.text(max_size=5), max_size=60))
def test_what_a_peer_makes_up_is_told_eight_times_at_most(words: list[str]) -> None:
    assert len(told(*((float(k), "lost", one) for k, one in enumerate(words)))) <= 8


def test_every_change_is_a_line_and_the_loss_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    losses = Losses()
    for k in range(6):
        _tell_change("a:", losses, Change(float(k), "lost" if k % 2 else "open", "gone" * (k % 2)))
    came = capsys.readouterr()
    assert len(came.out.splitlines()) == 6
    assert came.err == "varishold: gone; trying again\n"
