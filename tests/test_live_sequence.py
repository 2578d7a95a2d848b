"""Numbers of readings at their edges: how far one may leap, come late or go round before the sensor began anew."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.live.sequence import SequenceCounter


def _counted(*numbers: int, each_s: float = 0.01) -> SequenceCounter:
    counter = SequenceCounter()
    for number in numbers:
        counter.add(number, each_s)
    return counter


def _told(counter: SequenceCounter) -> tuple[int, int, int, int]:
    return counter.lost, counter.twice, counter.late, counter.restarts


@pytest.mark.parametrize(("waited_s", "most"), [(0.01, 19), (0.02, 22), (0.1, 46), (1.0, 316)])
def test_no_more_can_have_been_lost_than_three_times_what_the_time_allows_and_some(waited_s: float, most: int) -> None:
    for ahead, told in ((most, (most - 1, 0, 0, 0)), (most + 1, (0, 0, 0, 1))):
        counter = _counted(*range(100))
        counter.add(99 + ahead, waited_s)
        assert _told(counter) == told
        # It goes on from there.
        counter.add(100 + ahead, 0.01)
        assert _told(counter) == told


def test_where_readings_come_at_once_some_may_be_lost() -> None:
    for ahead, told in ((32, (31, 0, 0, 0)), (33, (0, 0, 0, 1))):
        counter = _counted(*range(100), each_s=0.0)
        counter.add(99 + ahead, 0.0)
        assert _told(counter) == told
    # Before two have come nobody knows how fast they come.
    assert _told(_counted(5, 1_000_000)) == (0, 0, 0, 0)
    assert _told(_counted(5, 5, 1_000_000)) == (0, 1, 0, 0)


@pytest.mark.parametrize(("back", "lost", "told"), [(16, 1, "late"), (17, 1, "anew"), (16, 0, "anew"), (1, 1, "late")])
def test_one_that_is_late_was_counted_as_lost(back: int, lost: int, told: str) -> None:
    counter = _counted(*range(1000, 1050), *([1051] if lost else [1050]), *range(1052 - (not lost), 1080))
    assert counter.lost == lost
    counter.add(1079 - back, 0.01)
    assert _told(counter) == ((0, 0, 1, 0) if told == "late" else (lost, 0, 0, 1))
    counter.add(1080 if told == "late" else 1080 - back, 0.01)
    assert counter.restarts == (told == "anew")


@pytest.mark.parametrize("step", [1, 2, 5])
@pytest.mark.parametrize("bits", [8, 16, 32, 64])
def test_a_counter_goes_round_from_its_upper_half(step: int, bits: int) -> None:
    """It is known by the least of 8, 16, 32 and 64 bits that hold its numbers."""
    start = 2**bits - 50 * step
    counter = _counted(*((start + step * k) % 2**bits for k in range(100) if k not in (40, 60, 61)))
    assert _told(counter) == (3, 0, 0, 0)
    # From the lower half it does not go round: it began anew.
    counter = _counted(*(2 ** (bits - 1) - 100 * step + step * k for k in range(100)), 0, step, 2 * step)
    assert _told(counter) == (0, 0, 0, 1)


def test_a_counter_that_began_anew_is_measured_anew() -> None:
    counter = _counted(*range(200, 256), *range(10))
    assert _told(counter) == (0, 0, 0, 0)
    # It has gone round as one of 8 bits, and is now seen to have more.
    for number in (*range(10, 300), 0, 1, 2):
        counter.add(number, 0.01)
    assert _told(counter) == (0, 0, 0, 1)
    for number in (*range(3, 256), 0, 1):
        counter.add(number, 0.01)
    assert _told(counter) == (0, 0, 0, 1)


def test_how_fast_readings_come_is_learned_slowly_and_lost_ones_count() -> None:
    counter = _counted(*range(0, 200, 2), each_s=0.02)
    assert counter._usual_s == pytest.approx(0.02)
    # Six at once that took six times as long leave the usual time as it is.
    counter.add(210, 0.12)
    assert (counter.lost, counter._usual_s) == (5, pytest.approx(0.02))
    counter.add(212, 0.06)
    assert counter._usual_s == pytest.approx(0.02 + 0.05 * 0.04)
    # The time of one that came twice is part of the next one's, and time does not go back.
    counter.add(212, 0.05)
    counter.add(214, -1.0)
    assert counter._usual_s == pytest.approx(0.022 + 0.05 * (0.05 - 0.022))


@given(
    st.lists(st.sampled_from([1, 1, 1, 1, 2, 3, 10]), min_size=3, max_size=60),
    st.integers(0, 2**34),
    st.sampled_from([8, 16, 32, 64]),
    st.sampled_from([1, 2]),
)
@settings(max_examples=100)
def test_what_is_left_out_is_lost_wherever_the_counter_goes_round(
    steps: list[int], start: int, bits: int, each: int
) -> None:
    number, told = start % (2**bits // each) * each, 0
    counter = SequenceCounter()
    counter.add(number, 0.0)
    for k, step in enumerate([1, *steps]):
        number = (number + each * step) % 2**bits
        counter.add(number, 0.01 * step)
        told += (step - 1) * (k > 0)
    # One that goes round before its upper half was seen cannot be told from one that began anew.
    assert counter.lost == told or counter.restarts > 0
    assert counter.twice == counter.late == 0
