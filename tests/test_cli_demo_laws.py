"""``demo`` shows what it says, where somebody looks; what asks a program to end is heard."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Thread
from types import SimpleNamespace
from typing import Any

import click
import pytest
from tests.commands_said import said

from varishold.cli import browser, demo, interrupts

# Demonstrations


def test_each_demonstration_says_the_command_that_it_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ran: list[Any] = []
    monkeypatch.setattr("varishold.cli.live.live", lambda *what, **how: ran.append((what, how)))
    monkeypatch.setattr("varishold.cli.perceive.perceive", lambda *what, **how: ran.append((what, how)))
    monkeypatch.setattr(demo, "show_page", lambda address: pytest.fail("a page was opened"))
    assert said("demo", "live").splitlines() == [f"$ varishold live {ran[0][0][0]}"]
    assert ran.pop() == (("sim:sphere?seed=1",), {"no_open": False})
    assert said("demo", "live", "--no-open") == "$ varishold live sim:sphere?seed=1 --no-open\n"
    assert ran.pop() == (("sim:sphere?seed=1",), {"no_open": True})
    page = tmp_path / "p.html"
    line, last = said("demo", "perceive", "--report", page, "--no-open").splitlines()
    (((name,), how),) = ran
    assert line == f"$ varishold perceive {name} --size-m {how['size_m']} --seed {how['seed']} --report {page}"
    assert (how["report"], last) == (page, f"open it in a browser: {page}")


def test_days_are_pressed_evaluated_and_gone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made: list[Any] = []
    ticks: list[Any] = []
    things = SimpleNamespace(DAYS=("mon", "tue"), day=lambda name, seed: (name, seed))

    class Bar:
        def __init__(self, what: str, total: int) -> None:
            ticks.append((what, total))

        def __enter__(self) -> Callable[..., None]:
            return lambda **how: ticks.append(how)

        def __exit__(self, *_: object) -> None:
            return None

    def tried(files: list[str], **how: Any) -> None:
        made.append((files, how, [Path(file).exists() for file in files]))

    monkeypatch.setattr(demo, "_script", lambda name: {"five_things": things}[name])
    monkeypatch.setattr("varishold.recording.write", lambda day, path: made.append(day) or path.write_text(day[0]))
    monkeypatch.setattr("varishold.cli.progress.progress_bar", Bar)
    monkeypatch.setattr("varishold.cli.evaluate.evaluate", tried)
    page = tmp_path / "p.html"
    line = said("demo", "learn", "--report", page).splitlines()[0]
    *days, (files, how, there) = made
    assert days == [("mon", 0), ("tue", 1)]
    assert [Path(file).name for file in files] == ["mon.npz", "tue.npz"]
    assert there == [True, True]
    assert not any(Path(file).parent.exists() for file in files)
    assert how == {"label": "thing", "group": "day", "shots": "0", "peers": False, "report": page}
    told = f"--label thing --group day --no-peers --shots 0 --report {page}"
    assert line == f"$ varishold evaluate {' '.join(files)} {told}"
    assert ticks == [("five things are pressed ten times each on three days", 2), {"advance": 1}, {"advance": 1}]


def test_a_page_is_shown_where_somebody_sits(monkeypatch: pytest.MonkeyPatch) -> None:
    import webbrowser

    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda address: bool(opened.append(address)) or address != "file:///no")
    terminal = SimpleNamespace(isatty=lambda: True)
    for stdout, system, shown, told in (
        (SimpleNamespace(isatty=lambda: False), "darwin", {}, False),
        (terminal, "darwin", {}, True),
        (terminal, "linux", {}, False),
        (terminal, "linux", {"DISPLAY": ":0"}, True),
        (terminal, "linux", {"WAYLAND_DISPLAY": "w"}, True),
    ):
        opened.clear()
        monkeypatch.setattr(browser, "sys", SimpleNamespace(stdout=stdout, platform=system))
        monkeypatch.setattr(browser, "os", SimpleNamespace(environ=shown))
        assert browser.show_page("file:///a") is told
        assert opened == ["file:///a"] * told
    assert not browser.show_page("file:///no")

    def broken(address: str) -> bool:
        raise webbrowser.Error("none")

    monkeypatch.setattr(webbrowser, "open", broken)
    assert not browser.show_page("file:///a")


# Signals


@pytest.fixture
def heard() -> Iterator[tuple[Any, ...]]:
    """Yield the signals that ask a program to end; each has a handler of its own, whoever runs the tests."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = [signal.signal(number, lambda *_: None) for number in numbers]
    yield numbers
    for number, handler in zip(numbers, before, strict=True):
        signal.signal(number, handler)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="has no such signals")
def test_what_asks_to_end_is_heard_once_and_the_second_time_ends_it(
    heard: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = [signal.getsignal(number) for number in heard]
    left: list[int] = []
    monkeypatch.setattr(interrupts, "leave", left.append)
    for number in heard:
        with interrupts.until_stopped() as wanted:
            assert not wanted.is_set()
            signal.raise_signal(number)
            assert (wanted.is_set(), left) == (True, [])
            signal.raise_signal(number)
            assert left.pop() == number
        assert [signal.getsignal(each) for each in heard] == before
    with pytest.raises(click.exceptions.Exit), interrupts.until_stopped():
        raise click.exceptions.Exit(1)
    assert [signal.getsignal(each) for each in heard] == before


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="has no such signals")
def test_what_is_ignored_stays_so_and_only_the_main_thread_hears(heard: tuple[Any, ...]) -> None:
    for number in heard:
        signal.signal(number, signal.SIG_IGN)
        with interrupts.until_stopped() as wanted:
            signal.raise_signal(number)
            assert not wanted.is_set()
            assert signal.getsignal(number) is signal.SIG_IGN
    told: list[bool] = []

    def elsewhere() -> None:
        with interrupts.until_stopped() as other:
            told.append(other.is_set())

    thread = Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert told == [False]
