"""What a session says of itself and does when it is asked, without a thread: a model, a zero, another object, names."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_presses import LAYOUT
from tests.live_scripted import Scripted, sample
from tests.test_live_believer import library
from tests.test_live_ends import Told

from varishold import learning
from varishold.errors import InputError
from varishold.live.session import Session
from varishold.live.watcher import Seen
from varishold.perceive import Perceiver
from varishold.sensor import Sensor


def _model(*labels: Any) -> Any:
    return SimpleNamespace(classes_=np.array(labels), explain=lambda presses: [None])


@pytest.mark.parametrize(
    ("model", "known", "objects"),
    [
        (None, None, False),
        (_model("a", "b"), ["a", "b"], False),
        (_model(1, 2), ["1", "2"], False),
        ("library", 2, True),
    ],
)
def test_a_session_says_what_it_tells_apart(model: Any, known: Any, objects: bool, tmp_path: Path) -> None:
    its = Session(Scripted(), model=Perceiver(library()) if model == "library" else model, folder=tmp_path)
    status = its.status()
    assert status["model"] == (["cone", "pillar"] if known == 2 else known)
    assert status["objects"] is objects
    if objects:
        its.next_object()
    else:
        with pytest.raises(InputError, match="objects are told apart by a library; none was given"):
            its.next_object()
    if model is None or objects:
        with pytest.raises(InputError, match="nothing was learned yet"):
            its.save()


def test_without_a_folder_nothing_is_written() -> None:
    its = Session(Scripted(), model=_model("a"))
    assert (its.status()["can_record"], its.status()["recording"]) == (False, None)
    for ask, words in ((lambda: its.record(True), "no folder was given to record to"), (its.save, "to write to")):
        with pytest.raises(InputError, match=words):
            ask()
    its.set_label("cone")
    its._do_what_is_due()


def test_a_model_that_was_learned_names_presses_from_then_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    its, model, written = Session(Scripted(), folder=tmp_path), _model("x"), []
    monkeypatch.setattr(learning, "write_model", lambda *given: written.append(given))
    assert (its.status()["can_record"], its.status()["recording"]) == (True, None)
    its._named = SimpleNamespace()  # type: ignore[assignment]
    its._learned(model)
    # It is taken over between two readings.
    assert (its.status()["model"], its.named is None) == (None, False)
    its._do_what_is_due()
    assert (its.status()["model"], its.named) == (["x"], None)
    words = its.save()
    ((saved, path),) = written
    assert saved is model
    assert (words, path.parent, path.suffix) == (f"saved as {path}", tmp_path, ".npz")
    its._watcher.close()


def test_a_zero_is_asked_of_every_pad_and_in_its_turn() -> None:
    its, asked = Session(Scripted()), []
    for name in ("left", "right"):
        its._watcher._pads[name] = SimpleNamespace(ask_zero=lambda now_s, name=name: asked.append((name, now_s)))  # type: ignore[assignment, misc]
    its._watcher._clock._last = 7.5, 0.0
    its.ask_zero()
    its.ask_zero()
    assert asked == []
    its._do_what_is_due()
    assert asked == [("left", 7.5), ("right", 7.5)] * 2


def _zeroing(taken: bool) -> Any:
    return SimpleNamespace(taken=taken, reason="", time_s=1.0, to_dict=lambda: {"taken": taken})


def test_what_is_seen_is_told_kept_and_written() -> None:
    its, news, zeros = Session(Scripted()), [], []
    its._recorder = SimpleNamespace(zeroed=zeros.append, look=lambda: None)  # type: ignore[assignment]
    its.on_news = lambda: news.append(its.newest)
    pad = SimpleNamespace(events=(), zeroings=(_zeroing(True), _zeroing(False)))
    first, second = SimpleNamespace(over=False), SimpleNamespace(over=False)
    whole = {"left": "the newest of all", "right": "another"}
    its._watcher._newest = whole  # type: ignore[assignment]
    its._publish(None)
    assert (news, its.newest) == ([], None)
    ended = SimpleNamespace(press="a press")
    its._publish(Seen(3, 1.5, None, {"left": pad}, ended, (first, second)))  # type: ignore[arg-type, dict-item]
    assert zeros == [{"pad": "left", "taken": True}, {"pad": "left", "taken": False}]
    # Nobody has set a label.
    assert [entry["kind"] for entry in its.events.since(0)] == ["zero", "refused"]
    assert its.named is second
    assert its.newest is not None
    assert (its.newest.number, dict(its.newest.pads), news) == (3, whole, [its.newest])
    its._teaching.set_label("cone")
    for _ in range(2):
        its._publish(Seen(4, 2.5, None, {}, ended))  # type: ignore[arg-type]
    kept = its.events.since(2)
    assert [(entry["kind"], entry["time_s"]) for entry in kept] == [("kept", 2.5)] * 2
    assert [entry["words"] for entry in kept] == ["press 1 of cone kept", "press 2 of cone kept"]
    # Who was named last stays named.
    assert its.named is second
    assert len(news) == 3


def test_a_session_follows_its_stream_to_the_end() -> None:
    looks: list[Any] = [
        ([sample(0)], "open"),
        ([], "open"),
        ([sample(1), sample(2)], "lost"),
        ([sample(3)], "ended"),
        ([], "ended"),
    ]
    its, numbers, news = Session(Scripted()), [], []
    stream = Told(looks)
    stream.pads, stream.missed = LAYOUT, 5  # type: ignore[attr-defined]
    stream.received = stream.damaged = stream.overrun = 0  # type: ignore[attr-defined]
    stream.health, stream.words, stream.address = its.stream.health, "", "told:"  # type: ignore[attr-defined]
    its.stream = stream  # type: ignore[assignment]
    its._on_seen = lambda seen: numbers.append((seen.number, seen.sample is None))
    its.on_news = lambda: news.append(None)
    its._unwanted = SimpleNamespace(is_set=lambda: False, wait=lambda timeout_s: stream.waits.append(timeout_s) or True)  # type: ignore[assignment]
    its._run()
    assert its.failure is None
    assert numbers == [(0, False), (1, False), (2, False), (3, False), (4, True)]
    assert [entry["kind"] for entry in its.events.since(0)] == ["opening", "open", "lost", "ended"]
    # What happened is news as what was seen is.
    assert len(news) == len(numbers) + 4
    assert its._watcher.layouts is LAYOUT
    assert its._missed == 5
    assert its.status()["left_out"] == 5
    assert its._over.is_set()
    assert 0.03 < min(stream.waits) <= max(stream.waits) < 0.1


@pytest.mark.parametrize("error", [InputError("never"), ValueError("a fault")])
def test_whoever_looks_is_told_why_nothing_is_watched_any_more(error: Exception) -> None:
    its = Session(Scripted())

    def fails(seen: Seen) -> None:
        raise error

    its._on_seen = fails
    its.stream._put([sample(0)])
    its._unwanted.set = lambda: None  # type: ignore[method-assign]
    its._unwanted.wait = lambda timeout_s=None: True  # type: ignore[method-assign]
    its._run()
    assert its.failure is error
    assert its.status()["words"] == str(error)
    assert its.wait_over(0.0)


def test_a_recording_carries_the_sensor_and_its_ends_are_events(tmp_path: Path) -> None:
    its = Session(Scripted(), folder=tmp_path, sensor=Sensor(name="a mat", span=7.0))
    news: list[None] = []
    its.on_news = lambda: news.append(None)
    recorder: Any = its._recorder
    assert recorder._sensor == "a mat"
    assert any("7.0" in text for text in recorder._files.values())
    recorder._tell(True, "well")
    recorder._tell(False, "not well")
    assert [(entry["kind"], entry["words"]) for entry in its.events.since(0)] == [
        ("recorded", "well"),
        ("refused", "not well"),
    ]
    assert len(news) == 2
    plain: Any = Session(Scripted(), folder=tmp_path)._recorder
    assert (plain._sensor, plain._files) == ("", None)
