"""The page's server: who may come in, what a page may say, and that no browser delays another."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import islice
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.live_presses import pressed
from tests.live_scripted import Scripted, wait_until
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from varishold.errors import InputError, LostSourceError
from varishold.live import source_at
from varishold.live.browsers import Browser, Offer
from varishold.live.door import Door
from varishold.live.requests import asked
from varishold.live.server import PageServer
from varishold.live.session import Session

GOOD, FOREIGN = "http://127.0.0.1:{port}", "https://example.com"


@pytest.fixture
def served() -> Iterator[tuple[Session, PageServer]]:
    with Session(source_at("sim:sphere?rest_s=1.2")) as session, PageServer(session, port=0) as server:
        yield session, server


def _port(server: PageServer) -> int:
    return int(server.address.rsplit(":", 1)[1].strip("/"))


def _socket(server: PageServer, **options: Any) -> ClientConnection:
    return connect(f"ws://127.0.0.1:{_port(server)}/ws", compression=None, **options)


def _get(server: PageServer, path: str = "/", host: str | None = None, more: str = "") -> tuple[str, str]:
    """Ask by hand; return the answer's head and body."""
    name = f"127.0.0.1:{_port(server)}" if host is None else host
    with socket.create_connection(("127.0.0.1", _port(server)), timeout=20) as plain:
        plain.sendall(f"GET {path} HTTP/1.1\r\nHost: {name}\r\n{more}\r\n".encode())
        told = b""
        while part := plain.recv(65536):
            told += part
    head, _, body = told.decode().partition("\r\n\r\n")
    return head, body


def _next(page: ClientConnection, kind: str) -> Any:
    """Return the page's next message of a kind, a picture's head for "picture"."""
    for _ in range(500):
        message = page.recv(timeout=20)
        if isinstance(message, bytes):
            # More than it can have shown counts as all.
            page.send("9" * 15)
            if kind == "picture":
                return json.loads(message[4 : 4 + int.from_bytes(message[:4], "little")])
        elif json.loads(message)["kind"] == kind:
            return json.loads(message)
    raise AssertionError(f"no {kind} came")


def test_the_page_is_one_text_that_may_run_nothing_but_itself(served: tuple[Session, PageServer]) -> None:
    head, body = _get(served[1])
    assert head.startswith("HTTP/1.1 200 OK")
    assert "default-src 'none'" in head
    assert "script-src 'sha256-" in head
    assert body.startswith("<!doctype html>")
    for word in ("<script src", '<link rel="stylesheet', "http://", "https://", "/* style */", "/* script */"):
        assert word not in body
    assert _get(served[1], "/nothing")[0].startswith("HTTP/1.1 404")
    assert _get(served[1], "/../../etc/passwd")[0].startswith("HTTP/1.1 404")


@pytest.mark.parametrize(
    "host", ["example.com", "example.com:80", "127.0.0.1.example.com", "", "a b", "[::1", "user@localhost"]
)
def test_a_foreign_name_is_refused(served: tuple[Session, PageServer], host: str) -> None:
    assert _get(served[1], host=host)[0].startswith("HTTP/1.1 403")
    assert _get(served[1], "/ws", host=host)[0].startswith("HTTP/1.1 403")


@pytest.mark.parametrize(
    "origin", ["https://example.com", "null", "http://localhost", "http://127.0.0.1:1", "file://", "x" * 500]
)
def test_a_foreign_page_is_refused(served: tuple[Session, PageServer], origin: str) -> None:
    with pytest.raises(InvalidStatus) as refused, _socket(served[1], origin=origin):
        pass
    assert refused.value.response.status_code == 403


def test_the_own_page_and_a_program_are_welcome(served: tuple[Session, PageServer]) -> None:
    port = _port(served[1])
    for origin in (f"http://127.0.0.1:{port}", None):
        with _socket(served[1], origin=origin) as page:
            assert _next(page, "picture")["pads"][0]["name"] == "pad"
    more = f"Origin: http://127.0.0.1:{port}\r\nOrigin: {FOREIGN}\r\n"
    assert _get(served[1], "/ws", more=more)[0].startswith("HTTP/1.1 400")
    assert _get(served[1], more="Host: localhost\r\n")[0].startswith("HTTP/1.1 400")


@given(st.text(max_size=60), st.one_of(st.none(), st.text(max_size=60)))
def test_the_door_lets_only_own_names_in(host: str, origin: str | None) -> None:
    refusal = Door("127.0.0.1").refusal(host, origin)
    if refusal is None:
        assert host.lower().rpartition(":")[0] in ("localhost", "127.0.0.1", "[::1]") or host.lower() in (
            "localhost",
            "127.0.0.1",
            "[::1]",
        )
        assert origin is None or origin.lower().partition("://")[2].rstrip("/") == host.lower()


def test_a_door_to_the_network_takes_addresses_and_its_own_name() -> None:
    door = Door("0.0.0.0")
    for host in ("192.168.1.7:8765", "[fe80::1]:8765", f"{socket.gethostname()}:8765", "localhost"):
        assert door.refusal(host, None) is None
        assert door.refusal(host, f"http://{host.lower()}") is None
        assert door.refusal(host, FOREIGN) is not None
    assert door.refusal("evil.example:8765", None) is not None


NONSENSE = [
    *(
        "",
        "{",
        "[]",
        "null",
        "7.5",
        "-1",
        "true",
        '"zero"',
        "{}",
        '{"do": 5}',
        '{"do": []}',
        '{"do": "format"}',
        "\x00",
        "９",
    ),
    *(
        '{"do": "label"}x',
        '{"do": "label", "label": 5}',
        '{"do": "label", "label": ""}',
        '{"do": "label", "label": "a\\nb"}',
    ),
    json.dumps({"do": "label", "label": "x" * 61}),
    *('{"do": "look"}', '{"do": "look", "track": 7}', '{"do": "record", "on": 1}', '{"do": "save"}'),
    *('{"do": "learn"}', '{"do": "forget"}', "[" * 2000, "9" * 400, b"\xff\xfe", b"", b"{}"),
]


def _drain(page: ClientConnection) -> None:
    while True:
        page.recv(timeout=20)


def test_nonsense_is_refused_and_survived(served: tuple[Session, PageServer]) -> None:
    with _socket(served[1]) as page:
        for message in NONSENSE:
            page.send(message)
            told = _next(page, "answer")
            assert not told["ok"], message
            assert told["words"]
            assert "\n" not in told["words"]
        assert _next(page, "picture")
        page.send("x" * 5000)
        with pytest.raises(ConnectionClosed):
            _drain(page)
    with _socket(served[1]) as page:
        assert _next(page, "picture")


# Never begun: what is asked for waits.
IDLE = Session(Scripted())


@given(
    st.one_of(
        st.binary(),
        st.text(),
        st.recursive(
            st.none() | st.booleans() | st.floats() | st.text(),
            lambda inner: st.lists(inner) | st.dictionaries(st.sampled_from(["do", "label", "on"]), inner),
        ).map(json.dumps),
    )
)
def test_whatever_is_asked_is_answered(message: str | bytes) -> None:
    told = asked(IDLE, message)
    assert told["ok"] in (True, False)
    json.dumps(told, allow_nan=False)


def test_bytes_that_are_no_request_are_survived(served: tuple[Session, PageServer]) -> None:
    for nonsense in (
        b"\x00\x01\x02\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /" + b"a" * 100_000,
        b"\r\n" * 50,
    ):
        with socket.create_connection(("127.0.0.1", _port(served[1])), timeout=20) as plain:
            plain.sendall(nonsense)
            plain.shutdown(socket.SHUT_WR)
            while plain.recv(4096):
                pass
    assert _get(served[1])[0].startswith("HTTP/1.1 200")


def test_a_stalled_browser_gets_the_newest_when_it_wakes_and_delays_nobody(served: tuple[Session, PageServer]) -> None:
    session, server = served
    with _socket(server) as stalled, _socket(server) as lively:
        first = [_next(lively, "picture")["number"] for _ in range(100)]
        assert first == sorted(set(first))
        held = []
        # It has not said that it has shown anything: it got two pictures, and no more.
        while len(held) < 2:
            message = stalled.recv(timeout=20)
            if isinstance(message, bytes):
                held.append(message)
        begun, number = session.stream.received, first[-1]
        _next(lively, "picture")
        assert session.newest is not None
        stalled.send("2")
        newest = _next(stalled, "picture")["number"]
        # What lay between was dropped.
        assert newest >= number
        assert newest >= begun - 50


def test_a_browser_that_dies_is_let_go(served: tuple[Session, PageServer]) -> None:
    _, server = served
    with _socket(server) as page, _socket(server) as dead:
        _next(dead, "picture")
        dead.socket.shutdown(socket.SHUT_RDWR)
        for _ in range(20):
            _next(page, "picture")
        wait_until(lambda: server._server is not None and len(server._server.connections) == 1)


def test_no_more_browsers_than_there_is_room_for(served: tuple[Session, PageServer]) -> None:
    with ExitStack() as pages:
        for _ in range(16):
            pages.enter_context(_socket(served[1]))
        with pytest.raises(InvalidStatus) as refused, _socket(served[1]):
            pass
        assert refused.value.response.status_code == 503


def test_a_lost_source_is_told_within_a_second_and_comes_back() -> None:
    source = Scripted()
    with Session(source) as session, PageServer(session, port=0) as server, _socket(server) as page:
        assert _next(page, "status")["state"] in ("opening", "open")
        wait_until(lambda: session.stream.state == "open")
        source.there = False
        source.script.put(LostSourceError("scripted:: is gone"))
        begun = time.monotonic()
        while (told := _next(page, "status"))["state"] != "lost":
            assert time.monotonic() - begun < 20
        assert "scripted::" in told["words"]
        source.there = True
        while _next(page, "status")["state"] != "open":
            assert time.monotonic() - begun < 20
        kinds = [event["kind"] for event in session.events.since(0)]
        assert kinds == ["opening", "open", *["lost"] * (len(kinds) - 3), "open"]


def test_a_source_that_can_never_be_read_is_told() -> None:
    source = Scripted()
    source.wrong = InputError("scripted:: is of another kind")
    with Session(source) as session, PageServer(session, port=0) as server, _socket(server) as page:
        wait_until(lambda: session.failure is not None)
        assert session.wait_over(20)
        while not (told := _next(page, "status"))["words"]:
            pass
        assert told["words"] == "scripted:: is of another kind"


def test_the_zero_is_taken_and_refused_and_told() -> None:
    source = Scripted()
    with Session(source) as session:
        for sample in pressed("cone", free=260, held=200):
            if sample.sequence in (150, 400):
                session.ask_zero()
                time.sleep(0.15)
            source.script.put(sample)
            if sample.sequence in (149, 399):
                wait_until(lambda: session.newest is not None and session.newest.number == sample.sequence)  # noqa: B023
        wait_until(lambda: session.newest is not None and session.newest.number == sample.sequence)
        told = [event for event in session.events.since(0) if event["kind"] in ("zero", "refused")]
    assert [event["kind"] for event in told] == ["zero", "zero", "refused"]
    assert "something presses" in told[-1]["words"]


def test_a_port_that_is_taken_is_told(served: tuple[Session, PageServer]) -> None:
    with Session(Scripted()) as session, pytest.raises(InputError) as told:
        PageServer(session, port=_port(served[1])).__enter__()
    where = f"cannot listen at 127.0.0.1, port {_port(served[1])}"
    assert str(told.value) == f"{where}: another program listens there; end it, or name another port"
    assert told.value.parameter == "port"


def test_a_host_that_is_none_of_this_machine_is_told() -> None:
    for host in ("300.1.1.1", "192.0.2.1"):
        with Session(Scripted()) as session, pytest.raises(InputError, match="name an address of this machine") as told:
            PageServer(session, host=host, port=0).__enter__()
        assert told.value.parameter == "host"


def test_nothing_is_left_running() -> None:
    before = set(threading.enumerate())
    with Session(source_at("sim:sphere")) as session, PageServer(session, port=0) as server, _socket(server) as page:
        _next(page, "picture")
    assert {thread for thread in set(threading.enumerate()) - before if "varishold" in thread.name} == set()


def test_words_come_no_faster_than_a_person_reads() -> None:
    source = Scripted()
    with Session(source) as session:
        offer = Offer(session)
        browser = Browser(offer)
        # It still presses when it is looked at, however late that is; a session that falls behind leaves readings out.
        for number, sample in enumerate(islice(pressed("cone", free=120, held=20), 140)):
            source.script.put(sample)
            if number % 20 == 0:
                wait_until(lambda at=number: session.newest is not None and session.newest.number >= at)
        wait_until(lambda: session.newest is not None and bool(session.newest.touched))
        kinds = [json.loads(message)["kind"] for message in browser.due() if isinstance(message, str)]
        assert "words" in kinds
        again = [json.loads(message)["kind"] for message in browser.due() if isinstance(message, str)]
        assert "words" not in again
