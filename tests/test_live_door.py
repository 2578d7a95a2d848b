"""Who may come in to the page, request by request; and what the page may do, as a browser is told."""

from __future__ import annotations

import base64
import hashlib
import re
import socket
from types import SimpleNamespace
from typing import Any

import pytest
from tests.live_scripted import Scripted
from websockets.datastructures import Headers

from varishold.live import browsers, server
from varishold.live.browsers import Browser, Offer
from varishold.live.door import VIEWERS, Door, is_loopback
from varishold.live.page_text import page_security, page_text
from varishold.live.server import PageServer
from varishold.live.session import Session
from varishold.report.colours import palette

HOST = "localhost:8765"


class Connection:
    """Answers as the library would."""

    def respond(self, status: int, text: str) -> tuple[int, str]:
        return status, text


def _answer(path: str, *headers: tuple[str, str], viewers: bool = False, open_pages: int = 0) -> Any:
    """Return the status and text of an answer; None where the socket is opened."""
    its = PageServer(Session(Scripted()), viewers=viewers)
    its._server = SimpleNamespace(connections=range(open_pages))  # type: ignore[assignment]
    request = SimpleNamespace(headers=Headers(list(headers)), path=path)
    told = its._receive_request(Connection(), request)  # type: ignore[arg-type]
    return told if told is None or isinstance(told, tuple) else (told.status_code, told.body.decode())


UPGRADE = ("Upgrade", "WebSocket")


def test_each_path_is_answered() -> None:
    assert _answer("/", ("Host", HOST)) == (200, page_text())
    assert _answer("/?theme=dark", ("Host", HOST)) == (200, page_text())
    assert _answer("/ws", ("Host", HOST)) is None
    assert _answer("/ws?a=b", ("Host", HOST), open_pages=15) is None
    assert _answer("/ws", ("Host", HOST), open_pages=16) == (503, "16 pages are open already\n")
    assert _answer("/", ("Host", HOST), open_pages=16)[0] == 200
    assert _answer("/other", ("Host", HOST)) == (404, "the page is at /\n")
    # A viewer's socket is opened at the page's own path, where viewers are served.
    assert _answer("/", ("Host", HOST), UPGRADE) == (200, page_text())
    assert _answer("/", ("Host", HOST), UPGRADE, viewers=True) is None
    assert _answer("/", ("Host", HOST), viewers=True) == (200, page_text())
    assert _answer("/", ("Host", HOST), UPGRADE, viewers=True, open_pages=16)[0] == 503
    assert _answer("/other", ("Host", HOST), UPGRADE, viewers=True)[0] == 404


def test_a_request_has_one_host_and_at_most_one_origin() -> None:
    own, wrong = ("Origin", f"http://{HOST}"), (400, "one Host and at most one Origin\n")
    assert _answer("/ws", ("Host", HOST), own) is None
    assert _answer("/ws") == _answer("/ws", ("Host", HOST), ("Host", HOST)) == wrong
    assert _answer("/ws", ("Host", HOST), own, own) == wrong
    assert _answer("/ws", ("Host", "evil.example")) == (403, "evil.example is no name of this machine\n")
    foreign = (403, f"https://evil.example is another page than http://{HOST}\n")
    assert _answer("/ws", ("Host", HOST), ("Origin", "https://evil.example")) == foreign
    assert _answer("/", ("Host", HOST), ("Origin", "https://evil.example"), UPGRADE, viewers=True) == foreign
    # Only what viewers get may be got by a viewer.
    (viewer, *_) = VIEWERS
    assert _answer("/", ("Host", HOST), ("Origin", viewer), UPGRADE, viewers=True) is None
    assert _answer("/ws", ("Host", HOST), ("Origin", viewer), UPGRADE, viewers=True)[0] == 403
    assert _answer("/", ("Host", HOST), ("Origin", viewer), viewers=True)[0] == 403


@pytest.mark.parametrize(
    ("origin", "welcome"),
    [
        *((viewer, True) for viewer in sorted(VIEWERS)),
        ("app://foxglove", True),
        ("file://", True),
        ("vscode-webview://abc", True),
        ("https://evil.example", False),
        ("http://evil.example", False),
        ("null", False),
        ("", False),
        ("blob:https://evil.example/1", False),
        ("data:text/html,a", False),
        ("about:blank", False),
        ("http://[::1", False),
        ("app://[::1", False),
    ],
)
def test_a_viewer_is_a_program_or_foxgloves_own_page(origin: str, welcome: bool) -> None:
    door = Door("127.0.0.1")
    assert (door.refusal(HOST, origin, viewer=True) is None) == welcome
    assert door.refusal(HOST, origin) is not None


@pytest.mark.parametrize(
    ("host", "welcome"),
    [
        ("localhost", True),
        ("LOCALHOST:80", True),
        ("127.0.0.1:1", True),
        ("[::1]:8765", True),
        ("::1", False),
        ("localhost:99999", False),
        ("localhost:a", False),
        ("a@localhost", False),
        ("localhost/a", False),
        ("192.168.1.7", False),
        ("robot", False),
        (None, False),
    ],
)
def test_names_of_this_machine_are_answered(host: str | None, welcome: bool) -> None:
    assert (Door("localhost").refusal(host, None) is None) == welcome
    if host is not None and welcome:
        for scheme, own in (("http", True), ("https", True), ("ftp", False)):
            assert (Door("[::1]").refusal(host, f"{scheme}://{host}".replace("L", "l")) is None) == own


def test_who_listens_at_a_name_is_asked_for_by_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(socket, "gethostname", lambda: "Robot.lab.example")
    names = ["robot.lab.example", "robot", "robot.local", "10.0.0.7", "[fe80::1]", "arm.example"]
    asked = {host: [Door(host).refusal(name, None) is None for name in names] for host in ("127.0.0.1", "Arm.example")}
    assert asked["127.0.0.1"] == [False] * 6
    assert asked["Arm.example"] == [True] * 6
    assert Door("0.0.0.0").refusal("arm.example", None) is not None
    assert [is_loopback(host) for host in ("localhost", "[::1]", "127.0.0.1", "0.0.0.0", "", "LocalHost")] == [
        *[True] * 3,
        *[False] * 2,
        True,
    ]
    monkeypatch.setattr(server, "gethostname", socket.gethostname)
    for host, name in (("0.0.0.0", "Robot.lab.example"), ("::", "Robot.lab.example"), ("::1", "[::1]"), ("a", "a")):
        assert PageServer(Session(Scripted()), host=host, port=7).address == f"http://{name}:7/"


# The page.


def test_the_page_may_run_its_own_script_and_nothing_else() -> None:
    page, told = page_text(), page_security("robot:80")
    for tag, name in (("style", "style-src"), ("script", "script-src")):
        (text,) = re.findall(f"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"; {name} 'sha256-{digest}'; " in told
    assert "connect-src 'self' ws://robot:80 wss://robot:80; " in told
    assert told.startswith("default-src 'none'; ")
    assert told.endswith("img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")
    # The colours that the page draws with are those of reports, 256 of them.
    assert palette(256).hex() in page
    assert '"setup"' not in page
    assert "/* style */" not in page
    assert "/* script */" not in page
    assert page.count('"use strict"') == 1


def test_the_page_is_sent_whole_and_kept_by_nobody() -> None:
    answer = server._page("robot:80")
    assert (answer.status_code, answer.reason_phrase, answer.body) == (200, "OK", page_text().encode())
    assert dict(answer.headers.raw_items()) == {
        "Content-Type": "text/html; charset=utf-8",
        "Content-Length": str(len(page_text().encode())),
        "Cache-Control": "no-store",
        "Content-Security-Policy": page_security("robot:80"),
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Connection": "close",
    }


def test_a_machine_that_has_just_been_started_serves_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its clock stands near 0."""
    its: Any = SimpleNamespace(
        newest="a reading", named=None, looked_at=(), status=dict, events=SimpleNamespace(count=0)
    )
    monkeypatch.setattr(browsers, "time", SimpleNamespace(monotonic=lambda: 0.0))
    monkeypatch.setattr(browsers, "picture_of", lambda seen: b"picture")
    monkeypatch.setattr(browsers, "words_of", lambda seen, also: {})
    browser = Browser(Offer(its))
    assert (browser.wants_news, browser.wait_s()) == (True, 0.0)
    picture, words, status = browser.due()
    assert picture == b"picture"
    assert (str(words)[:15], str(status)[:16]) == ('{"kind":"words"', '{"kind":"status"')
    assert not browser.wants_news
    assert 0.0 < browser.wait_s() <= 0.5
