"""``record`` waits, gives up and tells what it wrote, with a recorder and a clock that stand for all."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from threading import Event
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from tests.loaded_rooms import load

from varishold.cli import record as recording_command
from varishold.cli import silence
from varishold.cli.app import app
from varishold.errors import InputError
from varishold.live.sample_file import Limits
from varishold.live.stream import Change
from varishold.recording import Pad, Recording

load("corpus", "evaluation", "learning", "live", "perceive", "report", "sensor", "skin", "touch")


def said(*words: object) -> str:
    done = CliRunner().invoke(app, list(map(str, words)), catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.stdout


# Recording


class Waited:
    """A recorder that is over after so many looks, at a clock that goes on with each."""

    address, damaged, damage, overrun = "a:", 0, "", 0

    def __init__(self, monkeypatch: pytest.MonkeyPatch, over_at: int, samples: Callable[[int], int]) -> None:
        self.looks, self.refuses_at = 0, over_at
        self.shown: list[int] = []
        self.seconds = 0.0
        self._over_at, self._samples = over_at, samples
        monkeypatch.setattr(recording_command.time, "monotonic", lambda: self.seconds)

    @property
    def tally(self) -> Any:
        refused = max(self.looks - self.refuses_at, 0)
        return SimpleNamespace(samples=self._samples(self.looks), refused=refused, why="odd" * (refused > 0))

    def wait(self, seconds: float) -> bool:
        self.seconds += seconds
        self.looks += 1
        return self.looks >= self._over_at


@pytest.mark.parametrize(
    ("state", "limit_s", "given_up_s"),
    [("lost", None, 10.0), ("opening", None, 10.0), ("open", None, None), ("open", 5.0, 15.0), ("lost", 5.0, 15.0)],
)
def test_what_says_nothing_is_given_up_in_time(
    monkeypatch: pytest.MonkeyPatch, state: str, limit_s: float | None, given_up_s: float | None
) -> None:
    stream: Any = SimpleNamespace(state=state, changes=(), received=1)
    one: Any = Waited(monkeypatch, 1000, lambda looks: 0)
    recording_command._wait(one, stream, Limits(None, limit_s), Event())
    if given_up_s is None:
        assert one.looks == 1000
    else:
        assert given_up_s < one.seconds <= given_up_s + 1.0
    # What has said something, and what waits itself, is not given up.
    for source, samples in ((stream, 1), (None, 0)):
        other: Any = Waited(monkeypatch, 500, lambda looks, samples=samples: samples)
        recording_command._wait(other, source, Limits(None, limit_s), Event())
        assert other.looks == 500


def test_a_recording_ends_when_it_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    stop = Event()
    stop.set()
    one: Any = Waited(monkeypatch, 100, lambda looks: 3)
    recording_command._wait(one, None, Limits(None, None), stop)
    assert one.looks == 1


def test_readings_that_are_not_written_are_told_once_as_they_come(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    one: Any = Waited(monkeypatch, 20, lambda looks: looks)
    one.refuses_at = 5
    recording_command._wait(one, None, Limits(None, None), Event())
    assert capsys.readouterr().err == "varishold: a:: odd; such readings are not written\n"


def test_a_source_that_is_lost_is_told_once_by_its_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    told = {3: ("lost", "gone"), 6: ("open", ""), 7: ("lost", "gone"), 8: ("lost", "away\x1b"), 9: ("open", "")}
    # Much later it fails again.
    later = {15: ("lost", "gone"), 16: ("open", ""), 17: ("lost", "gone")}
    stream: Any = SimpleNamespace(state="open", changes=(Change(0.0, "open", ""),), received=1)

    def samples(looks: int) -> int:
        if looks in told | later and stream.changes[-1].host_time_s != looks:
            stream.state, words = (told | later)[looks]
            stream.changes += (Change(looks if looks in told else looks + 10.0, stream.state, words),)
        return 1

    one: Any = Waited(monkeypatch, 20, samples)
    recording_command._wait(one, stream, Limits(None, None), Event())
    assert capsys.readouterr().err.splitlines() == [
        "varishold: gone; trying again", "varishold: away\\x1b; trying again", "varishold: gone; trying again",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("tally", "missed", "words"),
    [
        ({}, 0, "7 frames in 1.25 s, 50 a second; none lost"),
        ({"rate_hz": None}, 0, "7 frames in 1.25 s; none lost"),
        ({"lost": 2}, 0, "7 frames in 1.25 s, 50 a second; 2 never came, by the sensor's own numbers"),
        ({}, 3, "7 frames in 1.25 s, 50 a second; 3 came faster than they could be written"),
        ({"overrun": 5}, 0, "7 frames in 1.25 s, 50 a second; 5 came faster than they could be read"),
        ({"refused": 4, "why": "odd"}, 0, "7 frames in 1.25 s, 50 a second; 4 were not written: odd"),
        ({"damaged": 3}, 0, "7 frames in 1.25 s, 50 a second; 3 messages held no frame that could be used"),
        (
            {"damaged": 3, "damage": "no JSON"}, 0,
            "7 frames in 1.25 s, 50 a second; 3 messages held no frame that could be used: no JSON",
        ),
        (
            {"lost": 1, "refused": 1, "why": "odd"}, 1,
            "7 frames in 1.25 s, 50 a second; 1 never came, by the sensor's own numbers; "
            "1 came faster than they could be written; 1 was not written: odd",
        ),
    ],
)  # fmt: skip
def test_what_was_recorded_and_what_not_is_told(
    tally: dict[str, Any], missed: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    held = {
        "samples": 7,
        "seconds": 1.25,
        "rate_hz": 50.0,
        "lost": 0,
        "refused": 0,
        "why": "",
        "odd_clock": "",
        **tally,
    }
    counted = {"missed": missed, "damaged": held.pop("damaged", 0), "overrun": held.pop("overrun", 0)}
    damage = held.pop("damage", "")
    recorder: Any = SimpleNamespace(tally=SimpleNamespace(**held), damage=damage, **counted)
    recording_command._tell(recorder, Path("a.mcap"), json=False)
    assert capsys.readouterr().out == f"a.mcap: {words}\n"
    recording_command._tell(recorder, Path("a.mcap"), json=True)
    frames = held.pop("samples")
    told = json.loads(capsys.readouterr().out)
    assert told == {"file": "a.mcap", "frames": frames, **counted, **held}


@pytest.mark.parametrize("bytes_over", [0, 1])
def test_what_is_too_large_for_its_format_stays_as_it_came(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bytes_over: int
) -> None:
    held = Recording({"p": Pad(np.ones((2, 3, 3)))})
    written = tmp_path / "a.npz.mcap"
    written.touch()
    monkeypatch.setattr("varishold.recording.read", lambda path: held)
    monkeypatch.setattr("varishold.files.LARGEST_BYTES", 2 * 9 * 8 - bytes_over)
    if bytes_over:
        with pytest.raises(
            InputError, match=r"a\.npz: cannot be made: 144 bytes .*; all that came is in .*\.npz\.mcap"
        ):
            recording_command._convert(written, tmp_path / "a.npz")
    else:
        recording_command._convert(written, tmp_path / "a.npz")
    assert (written.exists(), (tmp_path / "a.npz").exists()) == (bool(bytes_over), not bytes_over)


def test_a_long_recording_waits_for_a_busy_machine() -> None:
    # At a thousand readings a second some seconds are kept.
    assert 1000 < recording_command._KEPT <= 1 << 16
    assert recording_command._ending(Path("A.MCAP")) == ".mcap"
    assert recording_command._ending(Path("a.Npz")) == ".npz"
    with pytest.raises(InputError, match=r"its name must end in \.mcap or \.npz"):
        recording_command._ending(Path("a.csv"))


@pytest.mark.parametrize(
    ("states", "received", "told_at"),
    [
        # A moment is a second; it is told once.
        (["open"] * 9, [0] * 9, 4),
        (["open"] * 9, [0, 0, 0, 1, 2, 3, 4, 5, 5], None),
        (["lost"] * 9, [0] * 9, None),
        # The time begins when it is open, anew each time.
        (["opening", "opening", "open", "open", "lost", "open", "open", "open", "open"], [0] * 9, 8),
        # What was heard once is silent, too.
        (["open"] * 9, [1] * 9, 4),
    ],
)
def test_silence_is_told_once_when_it_has_lasted_three_seconds(
    states: list[str],
    received: list[int],
    told_at: int | None,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    now = [0.0]
    source: Any = Waited(monkeypatch, 1, lambda looks: 0)
    monkeypatch.setattr(silence.time, "monotonic", lambda: now[0])
    looking = silence.Silence("serial:\x1b")
    for moment, (state, came) in enumerate(zip(states, received, strict=True)):
        now[0] = float(moment)
        looking.look(came, source, is_open=state == "open")
        told = capsys.readouterr().err
        assert told == ("varishold: serial:\\x1b: no reading has come in 3 s; waiting\n" if moment == told_at else "")
