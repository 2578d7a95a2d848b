"""How the page is served: what each browser gets and when, who is woken, what a viewer is told."""

from __future__ import annotations

import asyncio
import json
from types import SimpleNamespace
from typing import Any

import pytest
from tests.live_clock import Clock
from tests.live_scripted import Scripted, sample

from varishold.live import (
    browsers,
)
from varishold.live.browsers import Browser, Offer
from varishold.live.event_log import EventLog
from varishold.live.server import PageServer
from varishold.live.session import Session
from varishold.live.viewer import Viewer


class Shown:
    """A session of 100 readings a second, and a browser that is served as the server does it."""

    def __init__(self, clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
        self.clock, self.events = clock, EventLog()
        self.newest: Any = None
        self.named, self.looked_at = None, ()
        self.pictures, self.asleep_s = 0, 0.0
        self.told: list[tuple[float, str]] = []
        monkeypatch.setattr(browsers, "picture_of", lambda seen: b"picture %d" % seen.number)
        monkeypatch.setattr(browsers, "words_of", lambda seen, also: {"number": seen.number})

    def status(self) -> dict[str, Any]:
        return {"at_s": self.clock.now_s}

    def serve(self, browser: Browser, for_s: float, *, shows: bool = True, silent: bool = False) -> None:
        ends_s, news_s = self.clock.now_s + for_s, self.clock.now_s
        while self.clock.now_s < ends_s:
            if not silent and self.clock.now_s >= news_s - 1e-9:
                number = 0 if self.newest is None else self.newest.number + 1
                self.newest, news_s = SimpleNamespace(number=number), news_s + 0.01
            for message in browser.due():
                if isinstance(message, bytes):
                    self.pictures += 1
                    assert message == b"picture %d" % self.newest.number
                    if shows:
                        browser.has_shown(self.pictures)
                else:
                    self.told.append((self.clock.now_s, json.loads(message)["kind"]))
            wake_s = self.clock.now_s + max(browser.wait_s(), 1e-6)
            if not silent:
                # The server wakes for news only who wants them; here everybody else sleeps on.
                while news_s < wake_s and not browser.wants_news:
                    number = 0 if self.newest is None else self.newest.number + 1
                    self.newest, news_s = SimpleNamespace(number=number), news_s + 0.01
                wake_s = min(wake_s, news_s)
            self.clock.now_s = wake_s

    def count(self, kind: str) -> int:
        return sum(one == kind for _, one in self.told)


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> Shown:
    return Shown(Clock(monkeypatch, browsers), monkeypatch)


def test_a_browser_gets_fifty_pictures_five_words_and_two_states_a_second(shown: Shown) -> None:
    shown.serve(Browser(Offer(shown)), 10.0)  # type: ignore[arg-type]
    assert 300 <= shown.pictures <= 501
    assert 40 <= shown.count("words") <= 51
    assert 19 <= shown.count("status") <= 21
    assert shown.count("events") == 0


def test_a_browser_that_shows_nothing_gets_two_pictures_and_learns_how_the_source_is(shown: Shown) -> None:
    browser = Browser(Offer(shown))  # type: ignore[arg-type]
    shown.serve(browser, 5.0, shows=False)
    assert (shown.pictures, browser.wants_picture, browser.wants_news) == (2, False, False)
    assert 9 <= shown.count("status") <= 11
    assert shown.count("words") <= 2
    # What it has not got yet it cannot have shown.
    browser.has_shown(99)
    shown.serve(browser, 5.0, shows=False)
    assert shown.pictures == 4
    # Nor does it forget what it has shown.
    browser.has_shown(4)
    browser.has_shown(0)
    assert browser.wants_picture


def test_a_browser_of_a_silent_source_sleeps_until_the_next_state(shown: Shown) -> None:
    browser = Browser(Offer(shown))  # type: ignore[arg-type]
    shown.serve(browser, 3.0, silent=True)
    assert shown.pictures == 0
    assert 5 <= shown.count("status") <= 7
    list(browser.due())
    assert 0 < browser.wait_s() <= 0.5


def test_a_browser_that_comes_late_is_told_the_newest_events_and_each_new_one_at_once(shown: Shown) -> None:
    for number in range(100):
        shown.events.add("zero", 0.0, str(number))
    browser = Browser(Offer(shown))  # type: ignore[arg-type]
    (events,) = [json.loads(m) for m in browser.due() if b"events" in m.encode() and '"kind":"events"' in m]
    words = [event["words"] for event in events["events"]]
    assert words == [str(number) for number in range(40, 100)]
    shown.clock.sleep(0.1)
    assert list(browser.due()) == []
    shown.events.add("touched", 0.0, "now")
    browser.answers.append({"ok": True})
    told = [json.loads(message) for message in browser.due()]
    assert [one["kind"] for one in told] == ["answer", "events", "status"]
    assert [event["words"] for event in told[1]["events"]] == ["now"]
    # How the source is is asked anew, for it may have changed with that.
    assert told[2]["at_s"] == shown.clock.now_s


def test_one_state_and_one_picture_are_made_for_all_browsers(shown: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int] = []
    monkeypatch.setattr(browsers, "picture_of", lambda seen: made.append(seen.number) or b"picture")
    shown.newest = SimpleNamespace(number=5)
    offer = Offer(shown)  # type: ignore[arg-type]
    told = [list(Browser(offer).due()) for _ in range(8)]
    assert made == [5]
    assert all(one == told[0] for one in told)


def test_who_was_woken_asks_again_before_it_is_woken_again() -> None:
    server = PageServer(Session(Scripted()))
    first, second = asyncio.Event(), asyncio.Event()
    server._waiting |= {first, second}
    server._wake_all()
    assert first.is_set()
    assert second.is_set()
    first.clear()
    second.clear()
    server._waiting.add(second)
    server._wake_all()
    assert not first.is_set()
    assert second.is_set()


def test_news_wake_nobody_where_nobody_waits_and_no_loop_that_is_gone() -> None:
    server, calls = PageServer(Session(Scripted())), []
    server._there_is_news()
    server._waiting.add(asyncio.Event())
    server._there_is_news()
    server._loop = SimpleNamespace(call_soon_threadsafe=calls.append)  # type: ignore[assignment]
    server._there_is_news()
    assert calls == [server._wake_all]

    def gone(call: object) -> None:
        raise RuntimeError("Event loop is closed")

    server._loop = SimpleNamespace(call_soon_threadsafe=gone)  # type: ignore[assignment]
    server._there_is_news()


@pytest.mark.parametrize(
    ("host", "address"),
    [("127.0.0.1", "http://127.0.0.1:80/"), ("::1", "http://[::1]:80/"), ("robot.local", "http://robot.local:80/")],
)
def test_the_page_is_where_the_server_listens(host: str, address: str) -> None:
    assert PageServer(Session(Scripted()), host=host, port=80).address == address


def test_a_viewer_that_comes_late_gets_what_comes_then_and_wants_no_more_than_it_may() -> None:
    its = Session(Scripted())
    its.stream._put([sample(k) for k in range(3)])
    its.events.add("zero", 0.0, "before")
    viewer = Viewer(its)
    assert list(viewer.due()) == []
    its.stream._put([sample(3)])
    (told,) = [json.loads(message) for message in viewer.due() if isinstance(message, str)]
    (channel,) = told["channels"]
    assert channel["topic"] == "/pad"

    def wish(*numbers: Any) -> str | None:
        told = [{"id": number, "channelId": channel["id"]} for number in numbers]
        return viewer.hear(json.dumps({"op": "subscribe", "subscriptions": told}))

    assert wish(0, 2**32 - 1) is None
    for number in (-1, 2**32, "a", 0.5, None):
        assert "not understood" in str(wish(number))
    assert viewer.hear(json.dumps({"op": "unsubscribe", "subscriptionIds": [2**32 - 1]})) is None
    assert wish(*range(256)) is None
    assert "not understood" in str(wish(256))
    its.stream._put([sample(4)])
    sent = [message for message in viewer.due() if isinstance(message, bytes)]
    assert sorted(int.from_bytes(message[1:5], "little") for message in sent) == list(range(256))
    (time_ns,) = {int.from_bytes(message[5:13], "little") for message in sent}
    assert time_ns == pytest.approx(1_000_000_000_040_000_000, abs=1000)
    assert viewer.hear(json.dumps({"op": "unsubscribe", "subscriptionIds": [*range(1, 256), 900]})) is None
    its.stream._put([sample(5)])
    assert len(list(viewer.due())) == 1
    # A number that is no channel's is refused.
    assert "not understood" in str(viewer.hear('{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 99}]}'))
