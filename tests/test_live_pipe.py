"""Pipes: what is there to be read, however it is cut, how long is waited for it, and its end."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.live_scripted import sample
from tests.test_live_wire import cuts, pieces

from varishold.errors import EndOfSourceError, InputError, LostSourceError
from varishold.live import framed, piped, source_at
from varishold.live.address import parse_address
from varishold.live.framed import FramedBytes
from varishold.live.piped import BareNumbers, Guessed, JsonLines, unpacking_at
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


@settings(max_examples=50)
@given(
    text=st.sampled_from(['[[1, 2]]\n{"pressure": [[3, 4]], "name": "pad"}\n', "1 2\n3 4\n\n5 6\n7 8\n\n1 2\n3 4\n\n"]),
    ends=st.sampled_from(["\n", "\r", "\r\n"]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-32"]),
    data=st.data(),
)
def test_a_pipe_is_encoded_and_ended_as_a_file_may_be(text: str, ends: str, encoding: str, data: st.DataObject) -> None:
    def read(came: list[bytes]) -> list[list[list[float]]]:
        by = Guessed(parse_address("stdin:"))
        found = [one for piece in came for one in by.samples(piece)] + by.finish()
        assert by.damaged == 0
        return [values.tolist() for one in found for values in one.pads.values()]

    whole = text.replace("\n", ends).encode(encoding)
    assert read(pieces(whole, data.draw(cuts))) == read([text.encode()]) != []


def test_a_taxel_that_is_no_number_costs_no_frame() -> None:
    lines = JsonLines(parse_address("stdin:"))
    came = lines.samples(b'[[1, NaN]]\n[[null, 2]]\n{"pressure": [[1, Infinity]], "time_s": NaN}\n[[3, 4]]\n')
    assert [str(one.pads.popitem()[1].tolist()) for one in came] == [  # type: ignore[attr-defined]
        "[[1.0, nan]]",
        "[[nan, 2.0]]",
        "[[1.0, inf]]",
        "[[3, 4]]",
    ]
    assert (lines.damaged, came[2].device_time_s) == (0, None)


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


def address(options: str) -> Any:
    return parse_address(f"-:{options}") if ":" in options else parse_address(f"stdin:{options}")


@given(st.lists(st.lists(st.integers(0, 99), min_size=3, max_size=3), max_size=8), cuts, st.booleans())
@settings(max_examples=80)
def test_lines_and_bare_numbers_come_however_they_are_cut(rows: list[list[int]], at: list[int], ended: bool) -> None:
    lines, bare = JsonLines(address("")), BareNumbers(address("?shape=1x3&dtype=uint8"))
    text = b"\n".join(b" \n" * (k % 2) + str(row).encode() for k, row in enumerate(rows)) + b"\n" * ended
    found = [sample for piece in pieces(text, at) for sample in lines.samples(piece)]
    if not ended and rows:
        assert len(found) == len(rows) - 1
    found += lines.finish()
    assert [next(iter(sample.pads.values())).ravel().tolist() for sample in found] == rows
    data = bytes(value for row in rows for value in row) + b"\x01\x02"
    found = [sample for piece in pieces(data, at) for sample in bare.samples(piece)] + bare.finish()
    assert [next(iter(sample.pads.values())).ravel().tolist() for sample in found] == rows
    assert all(next(iter(sample.pads.values())).shape == (1, 3) for sample in found)
    assert (lines.damaged, bare.damaged) == (0, 0)


def test_a_line_that_never_ends_is_passed_over_with_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(piped, "_LONGEST", 100)
    lines = JsonLines(address(""))
    assert len(lines.samples(b"[1, 2]\n")) == 1
    assert lines.samples(b"[" + b"1, " * 40) == []
    assert lines.damaged == 1
    assert lines.samples(b"2]") == []
    assert len(lines.samples(b" and so on]\n[3, 4]\n")) == 1
    assert lines.damaged == 1
    # One that just fits is read.
    assert len(lines.samples(b"[" + b" " * 88 + b"5,6]\n")) == 1


@pytest.mark.parametrize("text", [b"[[1, 2]]\n[[3, 4]]\n", b"1 2\n3 4\n\n5 6\n7 8\n\n"])
def test_a_mark_at_the_begin_of_utf_8_is_no_frame_s(text: bytes) -> None:
    plain = Guessed(address(""))
    wanted = [each.pads["pad"].tolist() for each in [*plain.samples(text), *plain.finish()]]
    for cut in range(5):
        marked, guessed = b"\xef\xbb\xbf" + text, Guessed(address(""))
        found = [*guessed.samples(marked[:cut]), *guessed.samples(marked[cut:]), *guessed.finish()]
        assert [each.pads["pad"].tolist() for each in found] == wanted != []


def test_what_comes_is_told_by_its_first_character() -> None:
    rows = b"1 2 3\n4 5 6\n\n" * 3
    for first, kind in ((b' \n {"data": [1, 2]}\n', JsonLines), (b"[1, 2]\n", JsonLines), (rows, FramedBytes)):
        guessed = Guessed(address(""))
        assert (guessed.samples(b"  \n"), guessed.pads, guessed.damaged, guessed.finish()) == ([], {}, 0, [])
        sample = [*guessed.samples(first), *guessed.finish()][-1]
        assert isinstance(guessed._by, kind)
        assert guessed.pads
        assert next(iter(sample.pads.values())).size in (2, 6)
    assert isinstance(unpacking_at(address("?dtype=uint8&shape=2x2")), BareNumbers)
    assert isinstance(unpacking_at(address("?preset=arduino-rows")), FramedBytes)
    assert isinstance(unpacking_at(address("")), Guessed)
    with pytest.raises(InputError, match="bare numbers need their shape"):
        unpacking_at(address("?dtype=uint8"))


BANNER = b"ESP-ROM:esp32c3\r\nBuild:Feb  7 2021\r\n\r\n115200\r\n"


@pytest.mark.parametrize("step", [1, 7, 10_000])
@pytest.mark.parametrize(
    "sent",
    [
        b"1,2,3,4,5,6\n" * 3,
        b"1 2 3\n4 5 6\n\n" * 3,
        b"[[1, 2, 3], [4, 5, 6]]\n" * 3,
        b"2,3,4,5,6\n" + b"1,2,3,4,5,6\n" * 3,
    ],
)
def test_what_a_controller_says_as_it_starts_is_passed_over_and_counted(sent: bytes, step: int) -> None:
    guessed, whole = Guessed(address("?shape=2x3")), BANNER + sent
    found = [one for at in range(0, len(whole), step) for one in guessed.samples(whole[at : at + step])]
    found += guessed.finish()
    assert [one.pads["pad"].tolist() for one in found] == [[[1, 2, 3], [4, 5, 6]]] * 3
    assert guessed.damaged == 3 + sent.startswith(b"2")
    assert guessed.damage == (
        "a line holds 5 numbers, and a frame 2 x 3"
        if sent.startswith(b"2")
        else "a line holds 1 number, and a frame 2 x 3"
    )


PASSED = "a line holds {} numbers, and a frame 2 x 2; a framing file with skip = {} passes over the first"


@pytest.mark.parametrize(
    ("options", "sent", "why"),
    [
        ("", b"t0=10 t1=9\n", "'t0=10 t1=9' is neither JSON nor a line of numbers"),
        ("", b"L:" + b"1," * 50, f"'L:{'1,' * 19} ...' is neither JSON nor a line of numbers"),
        ("?shape=2x2", b"1,2,3,4,5\n", PASSED.format(5, 1)),
        ("?shape=2x2", b"1,2,3,4,5,6\n", f"{PASSED.format(6, 2)} 2"),
        ("?shape=2x2", b"1,2,3,4,5,6,7,8,9\n", "a line holds 9 numbers, and a frame 2 x 2"),
        ("?preset=arduino-line&shape=2x2", b"boot\x1b[0m\n", "'boot\\x1b[0m' is no line of numbers"),
        ("?preset=arduino-line&shape=2x2", b"1,2,3\n", "a line holds 3 numbers, and a frame 2 x 2"),
        ("?preset=arduino-rows&shape=2x2", b"1 2\n3\n\n", "rows of 1 and 2 numbers came, which are no frame"),
        ("?preset=arduino-rows&shape=2x2", b"1 2\n\n", "1 x 2 numbers came, and a frame has 2 x 2"),
    ],
)
def test_text_that_holds_no_frame_is_told_by_what_stands_in_it(
    options: str, sent: bytes, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipe = Pipe(monkeypatch, sent, sent, b"")
    source = StandardInput(f"stdin:{options}", unpacking_at(address(options)))
    for _ in range(3):
        assert source.read(0.5) == []
    assert source.damage == why
    with pytest.raises(InputError, match="came and no frame was in them") as told:
        source.read(0.5)
    assert f" in them: {why}; write JSON" in str(told.value)
    assert not pipe.waits[3:]


def test_json_of_several_lines_is_told_to_be_one() -> None:
    lines = JsonLines(address(""))
    with pytest.raises(InputError, match="; each line is to be one reading"):
        lines.samples(json.dumps({"pressure": [[1, 2], [3, 4]]}, indent=1).encode())


def test_a_cable_whose_text_holds_no_frame_is_told_by_what_stands_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = iter(range(100))
    monkeypatch.setattr(framed.time, "monotonic", lambda: next(seconds))
    cable = FramedBytes("serial:/dev/x", framed.framing_at(address("?preset=arduino-line&shape=8x8")))
    sent = b"0" + b",1" * 64 + b"\n"
    for _ in range(4):
        assert cable.samples(sent * 3) == []
    with pytest.raises(LostSourceError, match="a line holds 65 numbers, and a frame 8 x 8; a framing file") as told:
        cable.samples(sent)
    assert str(told.value).endswith("; is it another preset, shape or baud?")


@pytest.mark.parametrize("between", [b",", b"; ", b"\t", b" "])
@pytest.mark.parametrize(("text", "n"), [([6, 6, 6, 6], 4), ([3, 3, 0, 3, 3, 0, 3, 3], 3), ([6], 1)])
def test_a_line_that_holds_all_of_the_shape_is_a_frame(between: bytes, text: list[int], n: int) -> None:
    sent = b"\n".join(between.join(b"%d" % k for k in range(count)) for count in text)
    for step in (1, len(sent)):
        guessed = Guessed(address("?shape=2x3"))
        found = [one for at in range(0, len(sent), step) for one in guessed.samples(sent[at : at + step])]
        found += guessed.finish()
        assert [next(iter(one.pads.values())).size for one in found] == [6] * n
