"""How a recorder writes: what is taken when, where marks stand, what ends it; and how presses are learned from."""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace
from typing import Any

import pytest
from tests.live_scripted import Scripted, sample

from varishold import learning
from varishold.errors import EndOfSourceError, InputError, LostSourceError, MissingExtraError
from varishold.live import Recorder, Stream
from varishold.live.recorder import _Read, _Streamed
from varishold.live.teaching import Teaching


class Written:
    """A file that notes what is done with it."""

    def __init__(self, room: int = 1000) -> None:
        self.done: list[Any] = []
        self._room, self.looks = room, 0

    @property
    def full(self) -> bool:
        return sum(isinstance(one, int) for one in self.done) >= self._room

    def add(self, one: Any) -> None:
        self.done.append(one)

    def mark(self, told: Any, host_time_s: float, *, zero: bool) -> None:
        self.done.append((dict(told), zero))

    def look(self) -> None:
        self.looks += 1


def _writing(recorder: Recorder, takes: list[tuple[list[Any], bool]], file: Written) -> list[str]:
    """Let a recorder write what a feed gives; return what it did in its turn."""
    did: list[str] = []
    coming = deque(takes)

    def take() -> tuple[list[Any], bool]:
        did.append("takes")
        return coming.popleft()

    recorder._feed = SimpleNamespace(take=take, missed=7, pause_s=0.05)  # type: ignore[assignment]
    recorder._unwanted.wait = lambda timeout_s=None: did.append(f"waits {timeout_s}") or False  # type: ignore[func-returns-value, method-assign]
    recorder._write(file)  # type: ignore[arg-type]
    return did


def _recorder() -> Recorder:
    return Recorder(Scripted(), "nowhere.mcap")


def test_what_comes_is_written_and_where_nothing_comes_it_is_waited_for() -> None:
    file, recorder = Written(), _recorder()
    did = _writing(recorder, [([], False), ([1, 2], False), ([3], False), ([], False), ([4], True)], file)
    assert file.done == [1, 2, 3, 4]
    assert did == ["takes", "waits 0.05", "takes", "takes", "takes", "waits 0.05", "takes"]
    # What waits is handed over now and then though nothing comes.
    assert file.looks == 5
    assert recorder.missed == 7


def test_a_full_file_takes_no_more() -> None:
    file = Written(room=3)
    did = _writing(_recorder(), [([1, 2], False), ([3], False), ([4], False)], file)
    assert (file.done, did) == ([1, 2, 3], ["takes", "takes"])
    assert _writing(_recorder(), [], Written(room=0)) == []


def test_what_came_before_it_was_unwanted_is_still_written() -> None:
    file, recorder = Written(), _recorder()
    recorder._unwanted.set()
    assert _writing(recorder, [([1], False), ([2], False)], file) == ["takes"]
    assert file.done == [1]


def test_marks_stand_before_what_came_after_them() -> None:
    file, recorder = Written(), _recorder()
    recorder.mark("cone", press=3)
    recorder.zeroed({"taken": True})
    _writing(recorder, [([1], False), ([2], True)], file)
    assert file.done == [({"label": "cone", "press": 3}, False), ({"taken": True}, True), 1, 2]


def test_a_source_is_opened_once_and_read_to_its_end() -> None:
    source = Scripted()
    feed = _Read(source)
    for number in range(2):
        source.script.put(sample(number))
    source.script.put(EndOfSourceError("over"))
    taken = [feed.take() for _ in range(3)]
    assert [([one.sequence for one in samples], over) for samples, over in taken] == [
        ([0], False),
        ([1], False),
        ([], True),
    ]
    assert (source.opened, feed.missed, feed.pads) == (1, 0, source.pads)
    source.script.put(LostSourceError("gone"))
    with pytest.raises(LostSourceError, match="gone"):
        feed.take()
    feed.close()
    assert source.closed == 1


def test_a_stream_is_written_from_its_ring_or_from_now_until_it_has_ended() -> None:
    stream = Stream(Scripted(), keep=3)
    stream._put([sample(k) for k in range(5)])
    whole, new = _Streamed(stream, False), _Streamed(stream, True)
    assert [one.sequence for one in whole.take()[0]] == [2, 3, 4]
    assert (new.take(), whole.missed, new.missed) == (([], False), 2, 0)
    stream._put([sample(5)])
    stream._become("ended")
    for feed in (whole, new):
        samples, over = feed.take()
        assert ([one.sequence for one in samples], over) == ([5], True)
        feed.close()
    assert whole.pads == stream.pads


# What was kept is learned from.


class Learner:
    """Learns what a test says."""

    fails: Exception | None = None

    def fit(self, presses: list[str], labels: list[str]) -> Learner:
        if self.fails is not None:
            raise self.fails
        self.presses, self.classes_ = presses, sorted(set(labels))
        self.labels = labels
        return self


def _taught(*presses: tuple[str, int]) -> tuple[Teaching, list[Any]]:
    learned: list[Any] = []
    teaching = Teaching(learned.append)
    for label, count in presses:
        teaching.set_label(label)
        for k in range(count):
            teaching.take(SimpleNamespace(press=f"{label} {k}"))  # type: ignore[arg-type]
    return teaching, learned


def test_presses_are_learned_from_with_their_labels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learning, "TactileClassifier", Learner)
    # A label that nothing was kept under is passed over.
    teaching, learned = _taught(("cone", 2), ("nothing", 0), ("hip", 3))
    teaching.learn()
    teaching.close()
    (model,) = learned
    assert model.presses == ["cone 0", "cone 1", "hip 0", "hip 1", "hip 2"]
    assert model.labels == ["cone"] * 2 + ["hip"] * 3
    assert teaching.to_dict()["words"] == "learned 2 things from 5 presses"
    # It may be learned again.
    teaching.learn()
    teaching.close()
    assert len(learned) == 2


@pytest.mark.parametrize("error", [InputError("too much alike"), MissingExtraError("scikit-learn")])
def test_why_nothing_was_learned_is_said(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learning, "TactileClassifier", Learner)
    monkeypatch.setattr(Learner, "fails", error)
    teaching, learned = _taught(("cone", 2), ("hip", 2))
    teaching.learn()
    teaching.close()
    assert (learned, teaching.to_dict()["words"]) == ([], str(error))


@pytest.mark.parametrize(
    ("presses", "have"),
    [
        ([], "none"),
        ([("cone", 5)], "cone: 5"),
        ([("cone", 5), ("hip", 1)], "cone: 5, hip: 1"),
        ([("cone", 5), ("nothing", 0)], "cone: 5"),
        ([("cone", 2), ("hip", 2), ("edge", 1)], "cone: 2, hip: 2, edge: 1"),
    ],
)
def test_too_little_to_learn_from_is_told(presses: list[tuple[str, int]], have: str) -> None:
    teaching, _ = _taught(*presses)
    with pytest.raises(InputError) as told:
        teaching.learn()
    assert str(told.value).endswith(f"; there are: {have}")
    assert teaching.to_dict()["words"] == ""


def test_nothing_is_learned_twice_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    teaching, _ = _taught(("cone", 2), ("hip", 2))
    teaching._thread = SimpleNamespace(is_alive=lambda: True, join=lambda: None)  # type: ignore[assignment]
    with pytest.raises(InputError, match="it is being learned; wait for it"):
        teaching.learn()
    teaching.close()
