"""``live`` and ``replay`` do what their options say, with a session and a page that stand for all."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from tests.loaded_rooms import load

from varishold.cli import live as command
from varishold.cli.app import app
from varishold.errors import InputError, LostSourceError
from varishold.files import write_archive
from varishold.recording import Pad, Recording, write
from varishold.sensor import Sensor, write_sensor

load("corpus", "evaluation", "learning", "live", "perceive", "report", "sensor", "skin", "touch")


def said(*words: object) -> str:
    done = CliRunner().invoke(app, list(map(str, words)), catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.stdout


class Told(dict[str, Any]):
    """Notes how a session and its page are asked for; is over when it was looked at so often."""

    looks = 0
    over_at = 1
    failure: Exception | None = None
    shown: tuple[str, ...] = ()
    slept: tuple[float, ...] = ()


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> Told:
    noted = Told()

    class Session:
        def __init__(self, source: Any, **how: Any) -> None:
            noted.update(how, source=source)

        stream = SimpleNamespace(state="open", received=1, damaged=0, damage="", overrun=0, address="a:")

        @property
        def failure(self) -> Exception | None:
            return noted.failure if noted.looks >= noted.over_at else None

        def wait_over(self, seconds: float) -> bool:
            noted.looks += 1
            noted.slept += (seconds,)
            if noted.looks > 20:
                raise TimeoutError("it looks for ever")
            return noted.looks >= noted.over_at

        def __enter__(self) -> Session:
            return self

        def __exit__(self, *_: object) -> None:
            noted["closed"] = True

    class Server:
        address = "http://127.0.0.1:1234/"

        def __init__(self, session: Any, **how: Any) -> None:
            noted.update(page=how)

        def __enter__(self) -> Server:
            return self

        def __exit__(self, *_: object) -> None:
            return None

    monkeypatch.setattr("varishold.live.session.Session", Session)
    monkeypatch.setattr("varishold.live.server.PageServer", Server)
    monkeypatch.setattr("varishold.live.sources.source_at", lambda address: ("source", address))
    monkeypatch.setattr(command, "show_page", lambda address: setattr(noted, "shown", (*noted.shown, address)))
    monkeypatch.setattr(command.time, "sleep", lambda seconds: setattr(noted, "slept", (*noted.slept, seconds)))
    return noted


def ends(noted: Told, words: tuple[object, ...]) -> tuple[str, str]:
    """Run until the source fails; return what was printed, and the failure."""
    noted.failure = noted.failure or LostSourceError("it is gone")
    done = CliRunner().invoke(app, list(map(str, words)))
    return done.stdout, str(done.exception)


def test_a_page_is_served_and_shown_until_the_source_fails(told: Told, tmp_path: Path) -> None:
    told.over_at = 3
    out, failure = ends(told, ("live", "sim:sphere"))
    assert (out, failure) == ("http://127.0.0.1:1234/  (Ctrl-C ends)\n", "it is gone")
    assert (told["source"], told["sensor"], told["model"], told["levels"]) == (("source", "sim:sphere"), None, None, 32)
    assert (told["on_seen"], told["folder"], told["closed"]) == (None, Path(), True)
    assert told["page"] == {"host": "127.0.0.1", "port": 8765, "viewers": False}
    assert told.shown == ("http://127.0.0.1:1234/",)
    # It looks some times a second, and sleeps in between.
    assert told.looks == 3
    assert all(0 < seconds <= 0.5 for seconds in told.slept)
    assert len(told.slept) == 5


def test_a_page_is_as_its_options_say(told: Told, tmp_path: Path) -> None:
    words = ("--levels", 9, "--port", 0, "--host", "0.0.0.0", "--folder", tmp_path, "--foxglove", "--no-open")
    out, _ = ends(told, ("live", "sim:sphere", *words, "--sensor", "weiss-dsa"))
    assert out.splitlines() == [
        "http://127.0.0.1:1234/  (Ctrl-C ends)",
        "everybody on the network can look, and press its buttons",
        "ws://127.0.0.1:1234  for Foxglove's app",
    ]
    assert told["page"] == {"host": "0.0.0.0", "port": 0, "viewers": True}
    assert (told["levels"], told["folder"], told["sensor"].name) == (9, tmp_path, "Weiss DSA 9205")
    assert told.shown == ()


def test_a_folder_that_is_not_there_is_told_before_anything_is_recorded(told: Told, tmp_path: Path) -> None:
    _, failure = ends(told, ("live", "sim:sphere", "--folder", tmp_path / "absent"))
    assert failure == f"{tmp_path / 'absent'}: there is no such folder; make it first"
    assert "source" not in told


def test_a_page_stays_when_its_source_has_ended_but_lines_end(told: Told) -> None:
    told.over_at = 1
    # With lines it ends with the source; nothing but lines is printed.
    assert said("live", "sim:sphere", "--json", "--port", "0") == ""
    assert (told.looks, told["on_seen"]) == (1, command._print_seen)
    assert said("live", "sim:sphere", "--json", "--foxglove") == ""
    assert told["page"] == {"host": "127.0.0.1", "port": 8765, "viewers": True}
    assert told.shown == ()
    # The page of a source that has ended without a failure can still be looked at.
    told.looks = 0
    with pytest.raises(TimeoutError):
        said("live", "sim:sphere")


@pytest.fixture
def watched(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    noted: dict[str, Any] = {"seen": [], "changes": []}

    def watch(source: str, *, on_change: Callable[[Any], None], **how: Any) -> Any:
        noted.update(how, source=source)
        for change in noted["changes"]:
            on_change(change)
        return iter(noted["seen"])

    monkeypatch.setattr("varishold.live.watching.watch", watch)
    monkeypatch.setattr("varishold.live.lines.lines_of", lambda seen: [{"a": seen}, {"b": seen}])
    monkeypatch.setattr("varishold.live.lines.change_line", lambda change: {"state": change.state})
    return noted


class Numbered(int):
    """What was seen, as far as it matters here: a number, and no reading."""

    sample = None


def test_lines_are_of_what_is_seen_and_of_what_became_of_the_source(
    watched: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    watched["seen"] = [Numbered(1), Numbered(2)]
    changes = [("open", ""), ("lost", "gone\x1b")]
    watched["changes"] = [SimpleNamespace(state=state, words=words, host_time_s=0.0) for state, words in changes]
    command.live("sim:sphere?speed=0", json=True, levels=9)
    out, err = capsys.readouterr()
    assert [json.loads(line) for line in out.splitlines()] == [
        {"state": "open"}, {"state": "lost"}, {"a": 1}, {"b": 1}, {"a": 2}, {"b": 2},
    ]  # fmt: skip
    assert err == "varishold: gone\\x1b; trying again\n"
    assert (watched["source"], watched["sensor"], watched["model"], watched["levels"]) == (
        "sim:sphere?speed=0", None, None, 9,
    )  # fmt: skip
    # All is looked at where the source can wait.
    for address, every in (("sim:sphere?speed=0", True), ("sim:sphere", False)):
        command.live(address, json=True)
        assert watched["every"] is every


def test_the_sensor_beside_a_recording_that_is_played_is_used(watched: dict[str, Any], tmp_path: Path) -> None:
    write(Recording({"p": Pad(np.ones((2, 3, 3)))}), tmp_path / "a.npz")
    write_sensor(Sensor(span=1.0, name="mat"), tmp_path / "sensor.toml")
    said("live", f"replay:{tmp_path / 'a.npz'}?speed=0", "--json")
    assert watched["sensor"].name == "mat"
    said("live", f"replay:{tmp_path / 'a.npz'}?speed=0", "--json", "--sensor", "weiss-dsa")
    assert watched["sensor"].name == "Weiss DSA 9205"
    said("live", "sim:sphere", "--json", "--sensor", tmp_path / "sensor.toml")
    assert watched["sensor"].name == "mat"
    said("live", "sim:sphere", "--json")
    assert watched["sensor"] is None


def test_a_model_is_a_library_where_it_has_a_head(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("varishold.perceive.read_library", lambda path: f"library {path.name}")
    monkeypatch.setattr("varishold.perceive.Perceiver", lambda library: f"perceiver of {library}")
    monkeypatch.setattr("varishold.learning.read_model", lambda path: f"model {path.name}")
    write_archive({"head": np.zeros(1)}, tmp_path / "l.npz", kind="library")
    write_archive({"other": np.zeros(1)}, tmp_path / "m.npz", kind="learned")
    found = [command._model(path) for path in (None, tmp_path / "l.npz", tmp_path / "m.npz")]
    assert found == [None, "perceiver of library l.npz", "model m.npz"]


# Replay


def test_what_is_played_is_told_to_live(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[tuple[str, dict[str, Any]]] = []
    monkeypatch.setattr("varishold.cli.live.live", lambda source, **how: asked.append((source, how)))
    monkeypatch.chdir(tmp_path)
    np.save("a.npy", np.ones((2, 20)))
    plain = {"sensor": None, "model": None, "port": None, "no_open": False, "json": False}
    said("replay", "a.npy")
    assert asked.pop() == ("replay:a.npy?speed=1&loop=0", plain)
    Path("m.npz").touch()
    words = ("--speed", "2.5", "--loop", "--shape", "4x5", "--pitch-m", "0.002", "--model", "m.npz", "--port", 7)
    said("replay", "a.npy", *words, "--no-open", "--json")
    assert asked.pop() == (
        "replay:a.npy?speed=2.5&loop=1&shape=4x5&pitch_m=0.002",
        {"sensor": None, "model": Path("m.npz"), "port": 7, "no_open": True, "json": True},
    )
    # What the file leaves unsaid its sensor says.
    write_sensor(Sensor(span=1.0, shape=(5, 4), polarity="down"), Path("mat.toml"))
    said("replay", "a.npy", "--sensor", "mat.toml")
    source, how = asked.pop()
    assert (source, how["sensor"]) == ("replay:a.npy?speed=1&loop=0&polarity=down&shape=5x4", "mat.toml")
    said("replay", "a.npy", "--sensor", "mat.toml", "--shape", "2x10")
    assert asked.pop()[0].endswith("&polarity=down&shape=2x10")
    write_sensor(Sensor(span=1.0), Path("plain.toml"))
    said("replay", "a.npy", "--sensor", "plain.toml")
    assert asked.pop()[0] == "replay:a.npy?speed=1&loop=0&polarity=up"
    np.save("b?.npy", np.ones((2, 20)))
    with pytest.raises(InputError, match=r"b\?\.npy: a file that is played must have no \? in its name"):
        said("replay", "b?.npy")
