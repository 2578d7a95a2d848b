"""Objects that are known by several presses, while they are pressed."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.live_presses import LAYOUT, Pressing, pressed
from tests.live_scripted import wait_until

from varishold.errors import InputError
from varishold.live import Seen, Watcher, press_believer
from varishold.live.lines import lines_of
from varishold.live.press_believer import BelievedObject, PressBeliever
from varishold.live.requests import asked
from varishold.live.session import Session
from varishold.live.words import named_line, named_words
from varishold.perceive import NONE_OF_THESE, Evidence, Library, Perceiver, evidence_of_recording
from varishold.recording import Pad, Recording


def _frames(form: str, seed: int) -> np.ndarray:
    """The loaded frames of a press, zero at rest."""
    return np.array([sample.pads["pad"] for sample in pressed(form, rest=0.0, free=0, seed=seed)])


@cache
def library() -> Library:
    def examples(form: str) -> list[list[Evidence]]:
        return [
            [evidence_of_recording(Recording({"pad": Pad(_frames(form, 100 + seed), pitch_m=0.002)}))]
            for seed in range(10)
        ]

    return Library.from_examples({form: examples(form) for form in ("cone", "pillar")})


def _all_of(watcher: Watcher, *forms: str) -> Iterator[Seen]:
    with watcher:
        yield from map(watcher.see, pressed(*forms, seed=7))
        last = watcher.finish()
        assert last is not None
        yield last


def _told(watcher: Watcher, *forms: str) -> list[BelievedObject]:
    named = [named for seen in _all_of(watcher, *forms) for named in seen.named]
    assert all(one.over for one in named)
    return [one.recognition for one in named if isinstance(one.recognition, BelievedObject)]


def test_each_object_is_known_when_it_was_pressed_often_enough() -> None:
    forms = ("cone",) * 4 + ("pillar",) * 4
    told = _told(Watcher(LAYOUT, model=Perceiver(library(), least_touches=2, most_touches=2, refuse=False)), *forms)
    assert [one.answer.object for one in told] == list(forms)
    # It begins anew after each that was enough.
    assert [one.touches for one in told] == [1, 2] * 4
    assert [one.update.verdict == "go on" for one in told] == [True, False] * 4
    for one in told:
        assert json.loads(json.dumps(one.to_dict(), allow_nan=False))["verdict"] == one.update.verdict


def test_lines_and_words_say_what_is_believed() -> None:
    with Watcher(LAYOUT, model=Perceiver(library())) as watcher:
        seen = [*map(watcher.see, pressed("pillar")), watcher.finish()]
    (named,) = [named for each in seen if each is not None for named in each.named]
    (line,) = [line for each in seen if each is not None for line in lines_of(each) if line["line"] == "press"]
    assert (line["object"], line["touches"], line["press"]) == ("pillar", 1, 0)
    words = named_words(named)
    assert words["name"] == "pillar"
    assert words["bars"][0][0] == "pillar"
    assert words["lines"]
    assert named_line(named).startswith("press 0: pillar, ")


def test_a_press_that_says_nothing_is_refused_and_the_next_one_is_felt() -> None:
    # Without a spacing no pad counts.
    with Watcher(model=Perceiver(library())) as watcher:
        seen = [*map(watcher.see, pressed("cone")), watcher.finish()]
    (named,) = [named for each in seen if each is not None for named in each.named]
    assert named.recognition is None
    assert "spacing" in named.words


def _knows(*touches: str) -> Perceiver:
    rows = {name: [[Evidence(t, {"a": float(k)}) for t in touches] for k in range(10)] for name in ("x", "y")}
    return Perceiver(Library.from_examples(rows))


def test_a_press_is_a_grasp_or_the_only_touch_of_a_library() -> None:
    assert PressBeliever(_knows("grasp"), {})._touch == "grasp"
    assert PressBeliever(_knows("lift", "grasp"), {})._touch == "grasp"
    assert PressBeliever(_knows("lift"), {})._touch == "lift"
    with pytest.raises(InputError, match=r"the library knows lift, shake, not grasp"):
        PressBeliever(_knows("lift", "shake"), {})


def test_the_page_asks_for_another_object(tmp_path: Path) -> None:
    pressing = Pressing(folder=tmp_path)
    with pressing.session as session:
        assert asked(session, '{"do": "next"}')["ok"] is False
    pressing = Pressing(model=Perceiver(library(), least_touches=3))
    with pressing.session as session:
        assert session.status()["objects"]
        assert session.status()["model"] == ["cone", "pillar"]
        pressing.press("cone")
        wait_until(lambda: _felt(session) == 1)
        pressing.press("cone", seed=1)
        wait_until(lambda: _felt(session) == 2)
        assert asked(session, '{"do": "next"}')["ok"] is True
        pressing.press("pillar", seed=2)
        wait_until(lambda: _felt(session) == 1)
        assert session.named is not None
        assert isinstance(session.named.recognition, BelievedObject)
        assert session.named.recognition.answer.object in ("pillar", NONE_OF_THESE)


def _felt(session: Session) -> int:
    named = session.named
    return named.recognition.touches if named is not None and isinstance(named.recognition, BelievedObject) else 0


def test_the_first_press_is_of_an_object_that_nothing_is_known_of(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the perceiver has felt before; and the next ones are of the same, otherwise laid, until it is known."""
    did: list[str] = []

    class Felt:
        library, stopped = _knows("grasp").library, False

        def feel(self, evidence: object) -> str:
            did.append("feels")
            return "update"

        def forget(self) -> None:
            did.append("forgets")

        def moved(self) -> None:
            did.append("moved")

        def answer(self) -> str:
            return "answer"

    says = Evidence("grasp", {"a": 1.0})
    monkeypatch.setattr(press_believer, "evidence_of_recording", lambda recording, *, touch: says)
    perceiver = Felt()
    believer = PressBeliever(perceiver, {})  # type: ignore[arg-type]
    monkeypatch.setattr(believer, "_recording", lambda kept: kept)
    for stops, another in ((False, False), (True, False), (False, True), (False, False)):
        if another:
            believer.next_object()
        assert believer(None).answer == "answer"  # type: ignore[arg-type, comparison-overlap]
        perceiver.stopped = stops
    # A press that says nothing changes nothing.
    says = Evidence("grasp", {}, remarks=("too light", "too short"))
    with pytest.raises(InputError, match=r"^too light; too short$"):
        believer(None)  # type: ignore[arg-type]
    says = Evidence("grasp", {})
    with pytest.raises(InputError, match=r"^no pad felt anything$"):
        believer(None)  # type: ignore[arg-type]
    perceiver.stopped = True
    says = Evidence("grasp", {"a": 1.0})
    believer(None)  # type: ignore[arg-type]
    first = [one for one in did if one != "feels"]
    assert first == ["forgets", "moved", "forgets", "moved", "forgets"]
    assert did[1::2] == ["feels"] * 5
