"""What comes over a wire or through a pipe, however it is cut; and what becomes of it in a file."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold import read
from varishold.errors import InputError, LostSourceError
from varishold.live import PadLayout, Sample, framed
from varishold.live.address import parse_address
from varishold.live.framed import FramedBytes, framing_at
from varishold.live.framing.counting import Counting
from varishold.live.framing.escaped import EscapedSplitter
from varishold.live.framing.model import Escape, Framing, Number, Packet, PadValues
from varishold.live.framing.text import TextDecoder
from varishold.live.sample_file import Limits, Tally, sample_file

cuts = st.lists(st.integers(0, 400), max_size=12)


def pieces(data: bytes, at: list[int]) -> list[bytes]:
    places = [0, *sorted(min(place, len(data)) for place in at), len(data)]
    return [data[a:b] for a, b in pairwise(places)]


@given(
    st.sampled_from(["<u1", "<u2", ">u2", "<u4", ">u4"]),
    st.integers(0, 2**33),
    st.lists(st.integers(-20, 100), max_size=60),
    st.integers(0, 5),
)
@settings(max_examples=100)
def test_a_number_goes_on_where_it_wraps(kind: str, start: int, steps: list[int], at: int) -> None:
    """It may stand at the very end of a packet."""
    dtype = np.dtype(kind)
    span = 2 ** (8 * dtype.itemsize)
    times, numbers = (Counting(Number(at, dtype, unit_s=0.5)) for _ in range(2))
    true = first = start % span
    for step in [0, *steps]:
        true += step
        packet = bytes(at) + np.array([true % span], dtype).tobytes()
        assert times.of_bytes(packet) == 0.5 * true
        assert numbers.whole_of_bytes(packet) == true
    assert first == start % span


def test_a_number_of_a_text_stands_in_its_column() -> None:
    counting = Counting(Number(1, np.dtype("f8"), unit_s=1e-3))
    assert counting.of_column([5.0, 2500.0]) == 2.5
    assert counting.of_column([5.0]) is None
    assert counting.of_column([5.0, math.nan]) is None
    whole = Counting(Number(1, np.dtype("f8")))
    assert (whole.whole_of_column([5.0, 7.0]), whole.whole_of_column([5.0, 1e300])) == (7, None)
    none = Counting(None)
    assert (
        none.of_bytes(b"1") is none.whole_of_bytes(b"1") is none.of_column([1.0]) is none.whole_of_column([1.0]) is None
    )
    real = Counting(Number(0, np.dtype("<f4"), unit_s=2.0))
    assert real.of_bytes(np.array([1.5], "<f4").tobytes()) == 3.0
    assert real.of_bytes(np.array([math.inf], "<f4").tobytes()) is None


MARK, HEAD, TAIL = 0x7D, 0x7E, 0x7F

four = st.lists(st.sampled_from([0, 1, MARK, HEAD, TAIL, 255]), min_size=4, max_size=4)

MEANT = {0x5D: MARK, 0x5E: HEAD, 0x5F: TAIL}


def escaped(content: bytes) -> bytes:
    told = {meant: bytes([MARK, second]) for second, meant in MEANT.items()}
    return b"".join(told.get(byte, bytes([byte])) for byte in content)


@given(
    st.lists(
        st.tuples(st.booleans(), st.lists(st.sampled_from([0, 1, MARK, HEAD, TAIL, 255]), min_size=4, max_size=4))
    ),
    cuts,
    st.sampled_from([(HEAD, TAIL), (None, TAIL), (HEAD, None)]),
)
@settings(max_examples=150)
def test_what_was_escaped_comes_out_however_it_is_cut(
    sent: list[tuple[bool, list[int]]], at: list[int], ends: tuple[int | None, int | None]
) -> None:
    head, tail = ends
    splitter = EscapedSplitter(Packet(4), Escape(MARK, MEANT, head, tail))
    data = b""
    for whole, values in sent:
        content = escaped(bytes(values if whole else values[:3]))
        data += (b"" if head is None else bytes([head])) + content + (b"" if tail is None else bytes([tail]))
    if tail is None:
        # The next one's head is the end of one.
        data += bytes([HEAD])
    found = [packet for piece in pieces(data, at) for packet in splitter.feed(piece)]
    assert found == [(0, bytes(values)) for whole, values in sent if whole]
    assert splitter.damaged == sum(not whole for whole, _ in sent)


def test_bytes_between_packets_are_nothing_and_endless_ones_take_no_room() -> None:
    splitter = EscapedSplitter(Packet(4), Escape(MARK, MEANT, HEAD, TAIL))
    assert splitter.feed(bytes([1, 2, TAIL, 3, HEAD, 5, 6, 7, 8, TAIL])) == [(0, bytes([5, 6, 7, 8]))]
    assert splitter.damaged == 0
    # A second head begins anew; what was begun is lost.
    assert splitter.feed(bytes([HEAD, 1, 2, HEAD, 5, 6, 7, 8, TAIL])) == [(0, bytes([5, 6, 7, 8]))]
    assert splitter.damaged == 1
    splitter.feed(bytes([HEAD]))
    for _ in range(50):
        splitter.feed(b"x" * 1000)
        assert len(splitter._rest) <= 10
    assert splitter.feed(bytes([TAIL, HEAD, 1, 2, 3, 4, TAIL])) == [(0, bytes([1, 2, 3, 4]))]
    assert splitter.damaged == 2
    # Two escapes of four bytes fit as well.
    assert splitter.feed(bytes([HEAD]) + escaped(bytes([HEAD] * 4)) + bytes([TAIL])) == [(0, bytes([HEAD] * 4))]
    splitter.feed(bytes([HEAD, 1, 2]))
    splitter.restart()
    assert splitter.feed(bytes([3, 4, TAIL])) == []


def test_bytes_without_a_frame_are_told_after_some_seconds_and_some_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [1000.0]
    monkeypatch.setattr(framed.time, "monotonic", lambda: now_s[0])
    framing = framing_at(parse_address("serial:/dev/null?preset=arduino-rows"))

    def until_told(step_s: float, piece: bytes) -> tuple[float, int] | None:
        its, began_s = FramedBytes("here", framing), now_s[0]
        for k in range(30):
            try:
                its.samples(piece)
            except LostSourceError:
                return now_s[0] - began_s, (k + 1) * len(piece)
            now_s[0] += step_s
        return None

    assert until_told(0.1, b"x" * 50) is None
    assert until_told(1.0, b"x") is None
    passed_s, n = until_told(1.0, b"x" * 60) or (0.0, 0)
    assert 4 < passed_s <= 6
    assert n > 256
    # A frame, or a new beginning, and all is well again.
    its = FramedBytes("here", framing)
    for _ in range(4):
        its.samples(b"x" * 200)
        now_s[0] += 3
        its.restart()
    with pytest.raises(InputError, match="give preset or framing, not both"):
        framing_at(parse_address("serial:/dev/null?preset=arduino-rows&framing=a.toml"))
    with pytest.raises(InputError, match="say what it sends"):
        framing_at(parse_address("serial:/dev/null"))
    pitched = framing_at(parse_address("serial:/dev/null?preset=arduino-rows&pitch_m=0.004&shape=2x3"))
    assert {pad.layout.pitch_m for pad in pitched.pads} == {(0.004, 0.004)}
    assert {pad.layout.shape for pad in pitched.pads} == {(2, 3)}


def reading(number: int, *, at_s: float | None = None, shape: tuple[int, ...] = (2, 3)) -> Sample:
    return Sample(
        None, 1e9 + (number / 10 if at_s is None else at_s), number, {"pad": np.full(shape, number % 200, np.uint8)}
    )


@given(st.lists(st.integers(-3, 12_000), min_size=1, max_size=12))
@settings(max_examples=25)
def test_what_never_came_is_counted_by_the_numbers(tmp_path_factory: pytest.TempPathFactory, steps: list[int]) -> None:
    path = tmp_path_factory.mktemp("file") / "a.mcap"
    number, lost = 50_000, 0
    with sample_file(path, dict) as file:
        file.add(reading(number, at_s=0.0))
        for k, step in enumerate(steps):
            number += step
            lost += step - 1 if 1 < step <= 10_001 else 0
            file.add(reading(number, at_s=0.1 * (k + 1)))
    assert (file.tally.samples, file.tally.lost, file.tally.refused) == (1 + len(steps), lost, 0)
    assert file.tally.seconds == pytest.approx(0.1 * len(steps))
    assert file.tally.rate_hz == pytest.approx(10.0)
    assert read(path).n_frames == 1 + len(steps)


@pytest.mark.parametrize(
    ("limits", "written"),
    [
        *((None, 30), (Limits(samples=0), 0), (Limits(samples=1), 1), (Limits(samples=7), 7)),
        *((Limits(seconds=0.95), 10), (Limits(seconds=1.05), 11)),
        *((Limits(samples=5, seconds=1.0), 5), (Limits(samples=50, seconds=0.05), 1)),
    ],
)
def test_a_file_ends_where_it_is_to_end(tmp_path: Path, limits: Limits | None, written: int) -> None:
    path = tmp_path / "a.mcap"
    with sample_file(path, dict, limits=limits) as file:
        for k in range(30):
            file.add(reading(k))
        assert file.full == (limits is not None)
    assert file.tally.samples == written
    # Where nothing came there is no file.
    assert path.exists() == (written > 0)


def test_what_is_no_frame_is_refused_and_told_once(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with sample_file(path, lambda: {"pad": PadLayout((2, 3), gaps=(1,), broken=(5, 99))}) as file:
        file.add(reading(0, shape=(2, 3, 4, 5)))
        file.add(reading(1))
        file.add(reading(2, shape=(3, 2)))
        file.add(Sample(None, 1e9, None, {"pad": np.array(["a"])}))
        file.add(Sample(None, 1e9, None, {"pad": np.empty((0, 3))}))
        file.add(reading(3))
    assert (file.tally.samples, file.tally.refused) == (2, 4)
    assert file.tally.why == "pad pad was uint8 of shape (2, 3, 4, 5)"
    pad = read(path).pads["pad"]
    assert np.argwhere(~pad.field).tolist() == [[0, 1]]  # type: ignore[operator]
    assert np.argwhere(~pad.usable).tolist() == [[0, 1], [1, 2]]


def test_a_tally_of_one_reading_has_no_rate() -> None:
    assert (Tally().seconds, Tally().rate_hz) == (0.0, None)
    assert (Tally(1, first_s=5.0, last_s=7.0).seconds, Tally(1, first_s=5.0, last_s=7.0).rate_hz) == (0.0, None)
    assert Tally(5, first_s=5.0, last_s=7.0).rate_hz == 2.0
    assert Tally(5, first_s=7.0, last_s=5.0).seconds == 0.0


def text_decoder(kind: Any, shape: tuple[int, int] | None, *, skip: int = 0, dtype: str = "<u2") -> TextDecoder:
    layout = PadLayout(() if shape is None else shape)
    return TextDecoder(Framing((PadValues(np.dtype(dtype), layout),), text=kind, skip=skip))


numbers_of_a_row = st.lists(st.integers(0, 60_000), min_size=3, max_size=3)

blocks_of_text = st.lists(
    st.tuples(
        st.sampled_from(["good", "short", "ragged", "words", "large", "half"]),
        st.lists(numbers_of_a_row, min_size=2, max_size=2),
    ),
    max_size=8,
)


def spoilt(kind: str, rows: list[list[int]]) -> list[str]:
    """Return the lines of a frame of two rows, whole or spoilt."""
    lines = [" ".join(map(str, row)) for row in rows]
    return {
        "good": lines,
        "short": lines[:1],
        "ragged": [lines[0], lines[1] + " 5"],
        "words": [lines[0], "one two three"],
        "large": [lines[0], "1 2 70000"],
        "half": [lines[0], "1 2 0.5"],
    }[kind]


@given(blocks_of_text, cuts)
@settings(max_examples=120)
def test_rows_of_text_are_frames_and_every_spoilt_one_is_counted(sent: list[tuple[str, Any]], at: list[int]) -> None:
    decoder = text_decoder("rows", (2, 3))
    data = "".join("\n".join(spoilt(kind, rows)) + "\n\n" for kind, rows in sent).encode()
    found = [reading for piece in pieces(data, at) for reading in decoder.feed(piece)]
    assert [next(iter(reading.pads.values())).tolist() for reading in found] == [
        rows for kind, rows in sent if kind == "good"
    ]
    assert decoder.damaged == sum(kind != "good" for kind, _ in sent)


@given(blocks_of_text, cuts, st.integers(0, 2))
@settings(max_examples=120)
def test_lines_of_text_are_frames_and_every_spoilt_one_is_counted(
    sent: list[tuple[str, Any]], at: list[int], skip: int
) -> None:
    decoder = text_decoder("line", (2, 3), skip=skip)
    data = "".join("9 " * skip + " ".join(spoilt(kind, rows)) + "\r\n\n" for kind, rows in sent).encode()
    found = [reading for piece in pieces(data, at) for reading in decoder.feed(piece)]
    assert [next(iter(reading.pads.values())).tolist() for reading in found] == [
        rows for kind, rows in sent if kind == "good"
    ]
    assert decoder.damaged == sum(kind != "good" for kind, _ in sent)
    # A line that holds nothing but what is skipped is none.
    before = decoder.damaged
    decoder.feed(b"9 " * skip + b"\n")
    assert decoder.damaged == before + (skip > 0)


@pytest.mark.parametrize("kind", ["rows", "line"])
def test_a_line_of_text_that_never_ends_takes_no_room_and_one_that_just_fits_is_read(kind: Any) -> None:
    decoder = text_decoder(kind, (1, 4), skip=1)
    assert len(decoder.feed(b"1 2 3 4 5\n\n")) == 1
    for _ in range(50):
        assert decoder.feed(b"1 " * 1000) == []
        assert len(decoder._rest) <= 32 * 7 + 2000
    assert decoder.feed(b"1\n\n") == []
    assert [len(decoder.feed(b"1 2 3 4 5\n\n")) for _ in range(2)] == [1, 1]
    wide = b" ".join(b"%031d" % k for k in range(5))
    assert len(decoder.feed(wide + b"\n\n")) == 1
    assert decoder.feed(b" " * 100 + wide + b"\n\n") == []


def test_two_frames_that_agree_tell_the_shape_of_a_text() -> None:
    frames = ("rows", b"1 2\n3 4\n\n", b"1 2 5\n3 4 5\n\n"), ("line", b"1 2 3 4\n", b"1 2 3 4 5\n")
    for kind, data, other in frames:
        decoder = text_decoder(kind, None)
        assert (decoder.feed(data), decoder.pads) == ([], {})
        (reading,) = decoder.feed(data)
        ((_, layout),) = decoder.pads.items()
        assert next(iter(reading.pads.values())).shape == layout.shape
        decoder = text_decoder(kind, None)
        assert decoder.feed(data + other + data) == []
        assert decoder.pads == {}
