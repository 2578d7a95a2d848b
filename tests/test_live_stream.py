"""A stream reads a source, waits for nobody, counts what each reader missed, and comes back by itself."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.live_scripted import Scripted, sample, wait_until

from varishold.errors import EndOfSourceError, InputError, LostSourceError
from varishold.live import Stream, samples_of, source_at


def test_samples_come_in_their_order_and_are_read_only() -> None:
    source = Scripted()
    for number in range(5):
        source.script.put(sample(number))
    source.script.put(EndOfSourceError("all of it"))
    with Stream(source) as stream:
        came = list(stream.reader())
    assert [each.sequence for each in came] == list(range(5))
    assert (stream.state, stream.words, stream.damaged) == ("ended", "all of it", 0)
    with pytest.raises(ValueError, match="read-only"):
        came[0].pads["pad"][0, 0] = 1
    assert source.closed >= 1


@given(keep=st.integers(1, 9), bursts=st.lists(st.integers(0, 12), max_size=8))
def test_what_is_read_and_what_is_missed_are_all_that_came(keep: int, bursts: list[int]) -> None:
    stream, number = Stream(Scripted(), keep=keep), 0
    reader, read = stream.reader(), 0
    for burst in bursts:
        stream._put([sample(number + k) for k in range(burst)])
        number += burst
        came = reader.read()
        read += len(came)
        assert [each.sequence for each in came] == list(range(number - min(burst, keep), number))
        assert reader.number == stream.received == number
        assert read + reader.missed == number


def test_a_slow_reader_misses_and_delays_nobody() -> None:
    source = source_at("sim:sphere?speed=0&duration_s=5")
    with Stream(source, keep=10) as stream:
        slow, own = stream.reader(), stream.reader()
        wait_until(lambda: stream.state == "ended")
        assert len(slow.read()) == 10
        assert (slow.missed, stream.received) == (490, 500)
        assert len(list(own)) == 10
        assert slow.read() == []


def test_a_lost_source_is_told_within_a_second_and_comes_back() -> None:
    source = Scripted()
    with Stream(source) as stream:
        assert stream.wait_open(20)
        source.there = False
        source.script.put(LostSourceError("scripted:: is gone"))
        wait_until(lambda: stream.state == "lost")
        wait_until(lambda: stream.words == "scripted:: is not there")
        source.there = True
        source.script.put(sample(7))
        reader = stream.reader()
        assert [each.sequence for each in reader.read(20)] == [7]
        assert stream.state == "open"
    assert [change.state for change in stream.changes] == ["opening", "open", "lost", "lost", "open", "ended"]
    assert not any(thread.name.startswith("varishold scripted") for thread in threading.enumerate())


def test_a_source_that_is_not_there_at_first_is_waited_for() -> None:
    source = Scripted()
    source.there = False
    with Stream(source) as stream:
        assert not stream.wait_open(0.01)
        wait_until(lambda: stream.state == "lost")
        source.there = True
        assert stream.wait_open(20)


@pytest.mark.parametrize("error", [InputError("never so"), RuntimeError("a fault")])
def test_what_can_never_be_read_is_raised_where_it_is_read(error: Exception) -> None:
    source = Scripted()
    source.wrong = error
    with Stream(source) as stream:
        with pytest.raises(type(error), match=str(error)):
            next(iter(stream.reader()))
        with pytest.raises(type(error), match=str(error)):
            stream.wait_open(20)
    assert (stream.state, stream.words) == ("ended", str(error))


def test_a_reader_waits_no_longer_than_it_says_and_closing_frees_it() -> None:
    stream = Stream(Scripted()).start()
    reader = stream.reader()
    assert reader.read(0.01) == []
    closer = threading.Timer(0.05, stream.close)
    closer.start()
    assert list(reader) == []
    closer.join()
    stream.close()


def test_newest_and_skip() -> None:
    stream = Stream(Scripted(), keep=4)
    assert stream.newest() is None
    stream._put([sample(k) for k in range(6)])
    newest = stream.newest()
    assert newest is not None
    assert newest.sequence == 5
    reader = stream.reader()
    reader.skip()
    assert ([each.sequence for each in reader.read()], reader.missed) == ([5], 0)
    with pytest.raises(InputError, match="keep must be 1 sample or more, got 0"):
        Stream(Scripted(), keep=0)


def test_samples_of_closes_the_source_also_where_reading_stops_early() -> None:
    source = Scripted()
    source.script.put(sample(0))
    coming = samples_of(source)
    assert next(coming).sequence == 0
    coming.close()
    assert source.closed == 1
    source.script.put(LostSourceError("gone"))
    with pytest.raises(LostSourceError, match="gone"):
        list(samples_of(source))


def test_real_time_is_kept() -> None:
    began = time.monotonic()
    with Stream(source_at("sim:sphere?rate_hz=200&duration_s=0.3")) as stream:
        came = list(stream.reader())
    assert time.monotonic() - began >= 0.29
    assert len(came) == 60
    assert np.diff([each.host_time_s for each in came]).min() >= 0
