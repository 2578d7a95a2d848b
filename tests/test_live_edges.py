"""How much is taken, kept or told at most: what just fits does, and one more does not."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_clock import Clock
from tests.live_scripted import Scripted, sample
from tests.test_live_nodes import Library, _life, _token
from tests.test_live_patience import _bridged, _channel
from tests.test_live_port import _opened

from varishold.errors import InputError, LostSourceError
from varishold.live import Sample, page_recorder, samples_of, source_at
from varishold.live.address import parse_address
from varishold.live.browsers import Browser, Offer
from varishold.live.door import Door
from varishold.live.framing.text import TextDecoder
from varishold.live.page_recorder import free_path
from varishold.live.piped import JsonLines
from varishold.live.sample_file import sample_file
from varishold.live.server import PageServer
from varishold.live.session import Session
from varishold.live.sources import foxglove, serial_port, zenoh_topic
from varishold.live.sources.standard_input import StandardInput

# Text.


def _decoder(folder: Path, text: str) -> TextDecoder:
    from varishold.live.framing import decoder_of, read_framing

    (folder / "a.toml").write_text(text)
    decoder = decoder_of(read_framing(folder / "a.toml"))
    assert isinstance(decoder, TextDecoder)
    return decoder


@pytest.mark.parametrize(("text", "most"), [('text = "line"\n', 1 << 18), ('text = "line"\nshape = [1, 3]\n', 32 * 5)])
@pytest.mark.parametrize("cut", [False, True])
def test_a_line_of_text_is_as_long_as_its_numbers_may_be(tmp_path: Path, text: str, most: int, cut: bool) -> None:
    decoder = _decoder(tmp_path, text)

    def feed(line: bytes) -> int:
        return len([one for part in ((line, b"\n") if cut else (line + b"\n",)) for one in decoder.feed(part)])

    decoder.feed(b"1 2 3\n1 2 3\n")
    most = most if "shape" in text else 32 * 5
    assert feed(b"1 2 3" + b" " * (most - 5)) == 1
    assert feed(b"1 2 3" + b" " * (most - 4)) == 0
    assert decoder.damaged == 1
    assert feed(b"1 2 3") == 1


@pytest.mark.parametrize("cut", [False, True])
def test_a_line_of_text_that_is_not_counted_yet_may_be_longer(tmp_path: Path, cut: bool) -> None:
    for more, damaged in ((0, 0), (1, 2)):
        decoder = _decoder(tmp_path, 'text = "line"\n')
        line = b"1 2 3" + b" " * ((1 << 18) - 5 + more)
        for part in (line, b"\n", line, b"\n") if cut else (line + b"\n" + line + b"\n",):
            decoder.feed(part)
        assert decoder.damaged == damaged
        assert (dict(decoder.pads) == {}) == bool(damaged)


@pytest.mark.parametrize(("rows", "known"), [(1024, True), (1025, False), (2000, False)])
def test_a_text_whose_rows_are_not_counted_yet_has_1024_at_most(tmp_path: Path, rows: int, known: bool) -> None:
    decoder = _decoder(tmp_path, 'text = "rows"\n')
    frames = decoder.feed((b"1 2\n" * rows + b"\n") * 3)
    # No frame is shown cut off.
    assert [one.pads["pad"].shape for one in frames] == ([(rows, 2)] * 2 if known else [])
    assert decoder.damaged == (0 if known else 3)
    # One row more or less than is known is damage.
    decoder = _decoder(tmp_path, 'text = "rows"\nshape = [2, 2]\n')
    assert len(decoder.feed(b"\n1 2\n3 4\n\n1 2\n\n1 2\n3 4\n\n")) == 2
    assert decoder.damaged == 1


def test_as_many_columns_may_stand_before_the_values_as_a_frame_has_bytes(tmp_path: Path) -> None:
    assert _decoder(tmp_path, 'text = "line"\nskip = 1048576\n')._framing.skip == 1 << 20


@pytest.mark.parametrize("cut", [False, True])
def test_a_line_of_json_may_hold_a_frame_of_512_x_512(cut: bool) -> None:
    lines = JsonLines(parse_address("stdin:"))
    fits = b"[1, 2]" + b" " * ((1 << 23) - 6)
    for line, count in ((fits, 1), (fits + b" ", 0 if cut else 1), (b"[1, 2]", 1)):
        came = [one for part in ((line, b"\n") if cut else (line + b"\n",)) for one in lines.samples(part)]
        assert len(came) == count
    assert lines.damaged == (1 if cut else 0)
    assert len(lines._rest) == 0


# What is read at once.


@pytest.fixture
def wired() -> Iterator[tuple[Any, socket.socket]]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        source: Any = source_at("udp:127.0.0.1:1?dtype=uint8&shape=2x1")
        source._port._place = SimpleNamespace(host="127.0.0.1", port=0, path="")
        source.open()
        sender.connect(source._port._socket.getsockname())
        yield source, sender
        source.close()


def test_a_port_is_read_256_times_at_once(wired: tuple[Any, socket.socket]) -> None:
    source, sender = wired
    for k in range(600):
        sender.send(bytes([k % 256, k // 256]))
    came = [source.read(1.0) for _ in range(3)]
    assert [len(each) for each in came] == [256, 256, 88]
    numbers = [int(one.pads["pad"][0, 0]) + 256 * int(one.pads["pad"][1, 0]) for each in came for one in each]
    assert numbers == list(range(600))
    assert source.read(0.0) == []


def test_the_largest_datagram_there_is_is_read_whole(wired: tuple[Any, socket.socket]) -> None:
    source, sender = wired
    source._of = parse_address("udp::1?dtype=uint8")
    source.open()
    sender.connect(source._port._socket.getsockname())
    sender.send(bytes(65507))
    (one,) = source.read(1.0)
    assert one.pads["pad"].size == 65507


def test_65536_bytes_are_read_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    source, port, _ = _opened(Clock(monkeypatch, serial_port), "serial:/dev/x?preset=flexitac&shape=2x1")
    port.came = b"\xaa\x55\x01\x02" * 40_000
    # One byte tells that there are more.
    source.read(0.0)
    assert len(port.came) == 4 * 40_000 - 65537
    asked: list[int] = []
    from varishold.live.sources import standard_input

    unpacking = SimpleNamespace(samples=lambda data: [], finish=lambda: ["the last"], pads={}, damaged=0)
    monkeypatch.setattr(standard_input.os, "read", lambda handle, size: asked.append(size) or b"x")
    monkeypatch.setattr(standard_input.sys, "stdin", SimpleNamespace(fileno=lambda: 0))
    monkeypatch.setattr(standard_input.select, "select", lambda *_: [[0]])
    assert StandardInput("stdin:", unpacking).read(0.0) == []  # type: ignore[arg-type]
    assert asked == [65536]


# What is kept of what others tell.


def test_a_bridge_may_tell_of_ten_thousand_topics_and_fifty_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    says = _channel(0, "/a")
    one = says["channels"][0]
    says["channels"] = [{**one, "id": k, "topic": f"/t{k:05}"} for k in range(10_001)]
    source = _bridged(Clock(monkeypatch, foxglove), "/skin", {0.1: says})
    with pytest.raises(LostSourceError) as told:
        source.open()
    assert len(source.topics) == 10_000
    assert str(told.value).rpartition("there are ")[2] == ", ".join(f"/t{k:05} ()" for k in range(50))


def test_of_a_router_fifty_topics_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    library = Library()
    monkeypatch.setattr(zenoh_topic, "_library", lambda: library)
    source: Any = source_at("zenoh://router/skin")
    for k in range(60):
        _life(source, _token(f"t{k:02}"))
    told = str(source._no_topic())
    assert told.rpartition("there are ")[2] == ", ".join(f"/t{k:02} (std_msgs/msg/Int16)" for k in range(50))


def test_the_text_of_a_definition_has_as_many_bytes_as_a_long_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(zenoh_topic, "_library", Library)
    (tmp_path / "a.msg").write_bytes(b"#" * (1 << 18))
    source: Any = source_at(f"zenoh://router/skin?msg={tmp_path}/a.msg")
    assert source._text == "#" * (1 << 18)
    (tmp_path / "a.msg").write_bytes(b"#" * ((1 << 18) + 1))
    with pytest.raises(InputError, match=r"a\.msg"):
        source_at(f"zenoh://router/skin?msg={tmp_path}/a.msg")
    (tmp_path / "a.msg").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"^zenoh://router/skin\?msg=.*a\.msg is no text$"):
        source_at(f"zenoh://router/skin?msg={tmp_path}/a.msg")


def test_a_session_keeps_4096_readings_and_looks_at_eight_contacts() -> None:
    its = Session(Scripted())
    its.stream._put([sample(k) for k in range(5000)])
    assert [one.sequence for one in its.stream.reader().read()] == list(range(904, 5000))
    for k in range(10):
        its.look_at(f"pad/{k}")
    assert list(its.looked_at) == [f"pad/{k}" for k in range(2, 10)]


@pytest.mark.parametrize(("numbers", "lost"), [((0, 10_001), 10_000), ((0, 10_002), 0), ((5, 5), 0), ((5, 4, 6), 1)])
def test_a_number_that_leaps_by_more_than_ten_thousand_tells_of_no_loss(
    tmp_path: Path, numbers: tuple[int, ...], lost: int
) -> None:
    with sample_file(tmp_path / "a.mcap", dict) as file:
        for k, number in enumerate(numbers):
            file.add(Sample(None, 1e9 + k, number, {"pad": np.ones((2, 2))}))
        assert (file.tally.samples, file.tally.lost) == (len(numbers), lost)


def test_moments_of_a_file_are_read_256_ahead(tmp_path: Path) -> None:
    with sample_file(tmp_path / "a.mcap", dict) as file:
        for k in range(300):
            file.add(Sample(None, 1e9 + k, k, {"pad": np.ones((2, 2))}))
    source: Any = source_at(f"replay:{tmp_path}/a.mcap?speed=0")
    source.open()
    assert len(source._ahead) == 256
    source.close()
    assert [one.sequence for one in samples_of(source)] == list(range(300))


def test_a_file_is_never_named_as_one_that_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_recorder, "time", SimpleNamespace(strftime=lambda how: "at-noon"))
    names = []
    for _ in range(120):
        names.append(free_path(tmp_path, ".npz").name)
        (tmp_path / names[-1]).touch()
    assert names == ["at-noon.npz", *(f"at-noon-{k}.npz" for k in range(2, 121))]
    assert free_path(tmp_path, ".mcap").name == "at-noon.mcap"


# The page.


class Page:
    """What a page says, one message after the other."""

    def __init__(self, *says: Any) -> None:
        self._says = says

    async def __aiter__(self) -> AsyncIterator[Any]:
        for one in self._says:
            yield one


@pytest.mark.parametrize(
    ("says", "shown", "answers"), [("9" * 15, True, 0), ("9" * 16, False, 1), ("2", True, 0), (b"2", False, 1)]
)
def test_a_page_says_how_many_pictures_it_has_shown_in_fifteen_digits(says: Any, shown: bool, answers: int) -> None:
    its = Session(Scripted())
    server, browser, wake = PageServer(its), Browser(Offer(its)), asyncio.Event()
    browser._sent = 2
    asyncio.run(server._listen(Page(says), browser, wake))  # type: ignore[arg-type]
    assert (browser._shown == 2, len(browser.answers), wake.is_set()) == (shown, answers, True)


def test_a_page_is_answered_sixteen_times_at_once() -> None:
    browser = Browser(Offer(Session(Scripted())))
    for k in range(20):
        browser.answers.append({"words": str(k)})
    told = [json.loads(message) for message in browser.due() if isinstance(message, str)]
    assert [one["words"] for one in told if one["kind"] == "answer"] == [str(k) for k in range(4, 20)]


def test_a_refusal_repeats_no_more_than_a_line() -> None:
    door = Door("127.0.0.1")
    assert door.refusal("a" * 300, None) == f"{'a' * 100} is no name of this machine"
    assert door.refusal(None, None) == door.refusal("", None) == "nothing is no name of this machine"
    origin = "https://" + "b" * 300
    assert door.refusal("localhost", origin) == f"{origin[:100]} is another page than http://localhost"
