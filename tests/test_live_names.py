"""What presses are called, by a model or by a perceiver: when they are asked for, and how it is told."""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_scripted import wait_until
from tests.test_live_believer import library

from varishold.errors import InputError
from varishold.learning.recognition import Recognition
from varishold.live import Sample
from varishold.live.press_believer import BelievedObject, PressBeliever
from varishold.live.press_namer import NamedPress, PressNamer
from varishold.live.watcher import Watcher
from varishold.live.words import named_line, named_words
from varishold.perceive import NONE_OF_THESE, BeliefUpdate, Perceiver, Perception
from varishold.report.quantities import percent


def kept_press(number: int) -> Any:
    return SimpleNamespace(number=number, start_s=0.5 * number, end_s=0.5 * number + 0.25, press=number)


def test_presses_are_named_in_their_order_and_each_once() -> None:
    named_of = PressNamer(lambda kept: SimpleNamespace(to_dict=lambda: {"object": kept.number}))  # type: ignore[arg-type, return-value]
    assert named_of.idle
    for k in range(9):
        named_of.ask(kept_press(k), over=k % 2 == 0)
    named = named_of.finish(20.0)
    assert named_of.idle
    assert named_of.done() == []
    assert [each.to_dict() for each in named] == [
        {"object": k, "press": k, "start_s": 0.5 * k, "end_s": 0.5 * k + 0.25} for k in range(9)
    ]
    assert [each.over for each in named] == [k % 2 == 0 for k in range(9)]
    named_of.close()
    named_of.close()


def test_presses_that_wait_too_long_go_without_a_name_the_oldest_first() -> None:
    free, named = threading.Event(), []

    def name(kept: Any) -> Any:
        free.wait(20)
        named.append(kept.number)
        if kept.number % 2:
            raise InputError("too little")
        return "a thing"

    namer = PressNamer(name)
    for number in range(200):
        namer.ask(SimpleNamespace(number=number, start_s=1.0 * number, end_s=number + 0.5), over=number > 5)  # type: ignore[arg-type]
        if number == 0:
            wait_until(lambda: namer._busy and not namer._waiting)
    assert not namer.idle
    free.set()
    done = namer.finish(20)
    assert namer.idle
    assert named[0] == 0
    assert named[1:] == list(range(200 - len(named) + 1, 200))
    # One is being named, as many wait, and as many names.
    assert (len(named), len(done)) == (65, 64)
    for one in done:
        assert (one.start_s, one.end_s, one.over) == (one.number, one.number + 0.5, one.number > 5)
        assert (one.recognition, one.words) == ((None, "too little") if one.number % 2 else ("a thing", ""))
        assert ("refusal" in one.to_dict()) if one.number % 2 else one.words == ""
    assert namer.done() == []
    namer.close()
    namer.close()


@pytest.mark.parametrize(("units", "told"), [(("kPa", "kPa"), "kPa"), (("kPa", "N"), "raw"), (("N",), "N")])
def test_a_press_is_a_recording_of_its_own_pads_in_their_unit(units: tuple[str, ...], told: str) -> None:
    field, sound = np.ones((4, 5), bool), np.ones((4, 5), bool)
    field[0, 0] = sound[1, 1] = False
    watched = {
        f"pad {k}": SimpleNamespace(unit=unit, pitch_m=(0.001 * (k + 1), 0.003), field=field, sound=sound)
        for k, unit in enumerate(units)
    }
    pads = {name: np.full((3, 4, 5), 7.0) for name in watched}
    watched["another"] = SimpleNamespace(unit="lbf", pitch_m=None, field=field, sound=sound)
    believer = PressBeliever(Perceiver(library()), watched)  # type: ignore[arg-type]
    recording = believer._recording(
        SimpleNamespace(press=SimpleNamespace(pads=pads, time_s=np.arange(3.0)))  # type: ignore[arg-type]
    )
    assert (list(recording.pads), recording.unit) == (list(pads), told)
    for k, pad in enumerate(recording.pads.values()):
        assert pad.pitch_m == (0.001 * (k + 1), 0.003)
        assert not pad.field[0, 0]
        assert not pad.valid[1, 1]
        assert np.all(pad.frames[:, 2, 2] == 7.0)
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [0, 1, 2]


def test_what_is_believed_is_told_with_six_digits() -> None:
    update = BeliefUpdate("grasp", {"a": 1 / 3}, None, None, 1 / 7, "go on", "why", ("because",))
    answer = Perception("a", 2 / 3, 0.04, (0.03, 0.05), {"b": 1 / 9}, (update, update), ("odd",))
    one = BelievedObject(update, answer)
    assert json.loads(json.dumps(one.to_dict())) == {
        "object": "a",
        "probability": 0.666667,
        "alternatives": {"b": 0.111111},
        "size_m": 0.04,
        "size_interval_m": [0.03, 0.05],
        "p_value": 0.142857,
        "touches": 2,
        "verdict": "go on",
        "why": "why",
        "reasons": ["because"],
        "remarks": ["odd"],
    }
    assert (one.touches, one.unknown, one.probability) == (2, False, 2 / 3)


def test_models_are_given_presses_without_the_readings_of_taxels_that_are_not_believed() -> None:
    watcher, asked = Watcher(), []
    namer = SimpleNamespace(
        idle=False, done=list, close=lambda: None, ask=lambda kept, *, over: asked.append(kept.press)
    )
    watcher._namer = namer  # type: ignore[assignment]
    rng, heap = np.random.default_rng(0), np.zeros((16, 16))
    heap[5:10, 5:10] = 100.0
    for k in range(1700):
        frame = np.abs(rng.normal(0, 1, (16, 16)) + heap * (k % 800 >= 600) * (k % 800 < 700))
        frame[7, 7] = 0.0
        watcher.see(Sample(k / 100, 0.0, k, {"pad": frame}))
    first, second = asked
    # Ten seconds after it began to be looked at, a taxel is known to be dead.
    assert not first.filled
    assert np.argwhere(second.filled["pad"]).tolist() == [[7, 7]]
    assert np.median(second.pads["pad"][20:80, 7, 7]) == pytest.approx(100, rel=0.05)


def test_a_press_that_lasts_is_named_some_four_times_a_second() -> None:
    watcher, asked = Watcher(), []
    namer = SimpleNamespace(idle=True, done=list, close=lambda: None, finish=lambda timeout_s: [])
    namer.ask = lambda kept, *, over: asked.append((watcher.now_s, over))
    watcher._namer = namer  # type: ignore[assignment]
    rng, heap = np.random.default_rng(0), np.zeros((16, 16))
    heap[5:10, 5:10] = 100.0
    for k in range(600):
        frame = rng.normal(0, 1, (16, 16)) + heap * (150 <= k < 450)
        watcher.see(Sample(k / 100, 0.0, k, {"pad": frame}))
    steps = np.diff([at_s for at_s, over in asked if not over])
    assert 0.2 <= steps.min() <= steps.max() <= 0.35
    assert [over for _, over in asked].count(True) == 1
    # While one is being named none waits behind it.
    namer.idle = False
    asked.clear()
    for k in range(600, 900):
        watcher.see(Sample(k / 100, 0.0, k, {"pad": rng.normal(0, 1, (16, 16)) + heap * (650 <= k)}))
    assert asked == []
    # A press that ends with the source is named all the same.
    last = watcher.finish()
    assert last is not None
    assert last.ended is not None
    assert [over for _, over in asked] == [True]
    assert [event.kind for event in last.pads["pad"].events] == ["released"]


@pytest.mark.parametrize("refused", [False, True])
def test_what_a_model_says_of_a_press_is_told_with_what_decided(refused: bool) -> None:
    measures = (("max_load", 3.26), ("area", -1.24), ("course", 0.5), ("more", 0.1))
    found = Recognition("cone", 0.9, {"pillar": 0.07}, 0.004, refused, measures, "a.npz: press 3", "cone", "press 7")
    words = named_words(NamedPress(7, 1.0, 2.0, True, found))
    assert (words["when"], words["name"]) == ("Press 7", "none of what was learned" if refused else "cone")
    assert [bar[0] for bar in words["bars"]] == ["cone", "pillar", "all others"]
    assert [bar[1] for bar in words["bars"]] == [0.9, 0.07, pytest.approx(0.03)]
    strange = ["Strange: of known things one in 250 is."] if refused else []
    decided = "Decided by max load +3.3, area -1.2, course +0.5 nats."
    assert words["lines"] == [*strange, decided, "Most like a.npz: press 3 (cone)."]
    line = named_line(NamedPress(7, 1.0, 2.0, True, found))
    assert line == ("press 7: none of what was learned" if refused else "press 7: cone, 90 %".replace(" %", line[-2:]))
    assert named_words(NamedPress(7, 1.0, 2.0, False, found))["when"] == "This press, so far"
    rare = Recognition("cone", 0.9, {}, 0.0, True, measures, "a", "cone", "b")
    assert named_words(NamedPress(0, 0.0, 0.0, True, rare))["lines"][0] == "Strange: of known things one in 1000 is."
    unlike = replace(rare, refused=False, unlike_session=True)
    told = named_words(NamedPress(0, 0.0, 0.0, True, unlike))["lines"]
    assert told[0] == "Felt unlike the session that was learned."
    nothing = NamedPress(2, 0.0, 1.0, True, None, "too few frames")
    assert named_words(nothing) == {
        "when": "Press 2",
        "name": "not recognized",
        "bars": [],
        "lines": ["Too few frames."],
    }
    assert named_line(nothing) == "press 2: not recognized"
    assert nothing.to_dict() == {"press": 2, "start_s": 0.0, "end_s": 1.0, "refusal": "too few frames"}


@pytest.mark.parametrize(("touches", "size_m"), [(1, None), (3, 0.0312)])
def test_what_a_perceiver_says_of_an_object_is_told_with_its_reasons(touches: int, size_m: float | None) -> None:
    update = BeliefUpdate(
        "grasp", {"mug": 1.0}, None, None, 0.5, "go on", "two are likely", ("it is round", "it is hard")
    )
    for known in ("mug", NONE_OF_THESE):
        answer = Perception(known, 0.75, size_m, None, {"can": 0.2}, (update,) * touches, ("pad 2 felt nothing",))
        named = NamedPress(4, 1.0, 2.0, True, BelievedObject(update, answer))
        words = named_words(named)
        assert words["when"] == ("Press 4" if touches == 1 else "Press 4, 3 presses of it")
        assert words["name"] == known
        bars = [("mug", 0.75)] if known == "mug" else []
        assert [bar[:2] for bar in words["bars"]][: len(bars) + 1] == [[n, p] for n, p in [*bars, ("can", 0.2)]]
        size = [] if size_m is None else ["About 31.2\u202fmm wide."]
        assert words["lines"] == ["Two are likely.", *size, "It is round.", "It is hard.", "Pad 2 felt nothing."]
        line = named_line(named)
        assert line == (f"press 4: mug, {percent(0.75)}" if known == "mug" else f"press 4: {known}")
