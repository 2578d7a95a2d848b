"""What is told of a stream: words, lines, and the log of what happened."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.live_seen import heap, seen, seen_pad

from varishold.live import StreamHealth
from varishold.live.event_log import EventLog
from varishold.live.lines import change_line, lines_of
from varishold.live.pad_watcher import SeenPad
from varishold.live.press_namer import NamedPress
from varishold.live.status import source_status
from varishold.live.stream import Change
from varishold.live.watcher import Seen
from varishold.live.words import _verdict, event_words, words_of, zeroing_words
from varishold.report.measures import measures
from varishold.report.quantities import percent, reading
from varishold.report.wording import likeliest_bars, sentences
from varishold.touch import Event
from varishold.touch.chords import inequality


def event(**more: Any) -> Event:
    usual: dict[str, Any] = {
        "kind": "moved",
        "time_s": 1.0,
        "told_s": 1.0,
        "track": 1,
        "pad": "pad",
        "position_taxels": (0.0, 0.0),
        "position_m": None,
        "area_taxels": 9.0,
        "area_m2": None,
        "load": 1.0,
        "force_n": None,
    }
    return Event(**{**usual, **more})


TOWARD = ["right", "lower right", "bottom", "lower left", "left", "upper left", "top", "upper right"]


@given(st.integers(-16, 16), st.floats(-0.35, 0.35), st.sampled_from(["moved", "slid", "slip", "tipped"]))
def test_an_event_says_toward_where(eighth: int, off: float, kind: Any) -> None:
    """An eighth of a turn each; y goes down."""
    angle = eighth * math.pi / 4 + off
    words = event_words(event(kind=kind, direction_rad=angle, distance_taxels=2.0))
    assert words.startswith(kind)
    assert words.endswith(f" toward the {TOWARD[eighth % 8]}")
    assert ("2" in words) == (kind != "tipped")


def test_an_event_says_how_far_and_how_long() -> None:
    assert event_words(event(direction_rad=0.0, distance_taxels=2.0, distance_m=0.004)).startswith("moved 4")
    assert "mm" in event_words(event(direction_rad=0.0, distance_taxels=2.0, distance_m=0.004))
    assert "taxels" in event_words(event(direction_rad=0.0, distance_taxels=2.0))
    assert event_words(event(kind="touched", direction_rad=0.0)) == "touched"
    assert event_words(event(kind="released", duration_s=2.5)).startswith("released after 2.5")
    assert event_words(event(kind="released")) == "released"
    assert event_words(event(direction_rad=0.0)) == "moved toward the right"


def test_a_zero_is_told_with_its_reason() -> None:
    assert zeroing_words(SimpleNamespace(taken=True, reason="")) == "zero taken"  # type: ignore[arg-type]
    assert zeroing_words(SimpleNamespace(taken=False, reason="it is pressed")) == "zero refused: it is pressed"  # type: ignore[arg-type]


def test_the_heaviest_contacts_are_spoken_of_and_those_that_are_looked_at() -> None:
    spots = [(2, 2), (7, 2), (12, 2), (2, 8), (7, 8), (12, 8)]
    pad = seen_pad(*(heap(x, y, 40 + 10 * k, 1.2) for k, (x, y) in enumerate(spots)))
    assert len(pad.tracks) == 6
    by_load = sorted(pad.tracks, key=lambda track: -track.load)
    keys = [f"pad/{track.number}" for track in by_load]
    assert set(words_of(seen(pad))) == set(keys[:4])
    assert set(words_of(seen(pad), (keys[5], "pad/99"))) == {*keys[:4], keys[5]}
    told = words_of(seen(pad))[keys[0]]
    answer = pad.answer(by_load[0], number=7, time_s=1.5)
    assert answer is not None
    assert told["name"] == answer.surface.name
    assert told["looks"] == by_load[0].looks
    assert told["held"] == list(answer.surface.answer_set)
    assert told["unit"] == "taxels"
    assert len(told["reasons"]) == len(answer.surface.reasons)
    # The likeliest first; the last is all others.
    assert told["bars"][0][:2] == [answer.surface.name, round(answer.surface.probability, 4)]
    assert sum(bar[1] for bar in told["bars"]) == pytest.approx(1, abs=1e-3)
    assert told["growth"][0]["title"] == "√area"


@pytest.mark.parametrize("pitch", [None, (0.002, 0.002)])
def test_a_contact_is_spoken_of_by_its_answer(pitch: tuple[float, float] | None) -> None:
    pad = seen_pad(heap(7, 5), pitch=pitch, unit="kPa")
    (track,) = pad.tracks
    (words,) = words_of(seen(pad)).values()
    answer = pad.answer(track, number=7, time_s=1.5)
    assert answer is not None
    surface, contact = answer.surface, track.contact
    assert (words["theta_top"], words["theta_floor"]) == (reading(contact.peak, "kPa"), reading(contact.floor, "kPa"))
    told = inequality(contact.profile, taxel_area=contact.taxel_area, sigma=contact.sigma)
    assert words["growth"] == [
        {"title": title, "bulge": f"{bulge:.2f}", "defect": f"{defect:.2f}"}
        for title, bulge, defect in (
            ("√area", told.bulge_sqrt_area, told.defect_sqrt_area),
            ("Perimeter", told.bulge_perimeter, told.defect_perimeter),
        )
    ]
    assert words["unit"] == ("taxels" if pitch is None else "mm")
    assert words["probability"] == percent(surface.probability)
    assert words["outline"] == f"{surface.outline}, {percent(surface.outline_probability)}"
    for key, names in (("bars", surface.names), ("outline_bars", surface.outlines)):
        bars = likeliest_bars(names.items())
        assert words[key] == [[bar.name, round(bar.share, 4), bar.text] for bar in bars]
    assert words["reasons"] == list(sentences(surface.reasons))
    assert words["measures"] == [list(pair) for pair in measures(answer)]


def test_what_cannot_be_compared_is_told_as_unknown() -> None:
    assert _verdict("a", 0.126, 0.5) == {"title": "a", "bulge": "0.13", "defect": "0.50"}
    unknown = {"title": "a", "bulge": None, "defect": None}
    assert _verdict("a", math.nan, 0.5) == _verdict("a", 0.5, math.inf) == _verdict("a", math.nan, math.nan) == unknown


def test_lost_contacts_are_not_spoken_of() -> None:
    pad = seen_pad(heap(7, 5))
    lost = [SimpleNamespace(**{**vars(track), "state": "lost"}) for track in pad.tracks]
    assert words_of(seen(SeenPad("pad", *[pad.layout] + [pad.frame] * 3, tracks=tuple(lost)))) == {}  # type: ignore[arg-type]


def test_something_touches_where_any_pad_is_touched() -> None:
    free, touched = seen_pad(name="free"), seen_pad(heap(7, 5), name="touched")
    assert [seen(*pads).touched for pads in ((), (free,), (free, touched), (touched,))] == [False, False, True, True]


def test_an_answer_says_whose_it_is() -> None:
    pad = seen_pad(heap(7, 5), pitch=(0.002, 0.002), unit="kPa", notes=("zeroed",), sensor="glove")
    (track,) = pad.tracks
    answer = pad.answer(track, number=9, time_s=4.0)
    assert answer is not None
    assert (answer.frame, answer.time_s, answer.pad, answer.contact) == (9, 4.0, "pad", 1)
    assert (answer.unit, answer.pascals_per_unit, answer.sensor) == ("kPa", 1000.0, "glove")
    assert (answer.pitch_m, answer.frame_notes, answer.surface) == ((0.002, 0.002), ("zeroed",), track.answer)


class Named(SimpleNamespace):
    def to_dict(self) -> dict[str, Any]:
        return {"kind": "press" if self.over else "so far"}


def test_lines_tell_each_thing_once_and_names_of_presses_that_are_over() -> None:
    its = Named(over=True), Named(over=False)
    zero = SimpleNamespace(to_dict=lambda: {"taken": True})
    pad = seen_pad(heap(7, 5), events=(event(), event(kind="slid")), zeroings=(zero,))
    told = [*lines_of(seen(pad, named=its))]
    assert [line["line"] for line in told] == ["frame", "event", "event", "zero", "press"]
    assert (told[0]["frame"], told[0]["sequence"], told[0]["device_time_s"]) == (7, 3, 1.5)
    assert told[0]["contacts"] == [track.to_dict() for track in pad.tracks]
    assert [line["event"] for line in told[1:3]] == ["moved", "slid"]
    assert (told[3]["pad"], told[3]["taken"]) == ("pad", True)
    later = Seen(8, 2.0, None, {}, None, (its[0],))  # type: ignore[arg-type]
    assert [line["line"] for line in lines_of(later)] == ["press"]
    assert change_line(Change(5.0, "lost", "gone")) == {
        "line": "source",
        "host_time_s": 5.0,
        "state": "lost",
        "words": "gone",
    }


@given(st.lists(st.sampled_from(["opening", "open", "lost", "ended"]), max_size=30), st.integers(0, 40))
def test_the_log_numbers_what_happened_and_a_state_only_where_it_changes(states: list[Any], first: int) -> None:
    log = EventLog()
    for k, state in enumerate(states):
        log.add_change(Change(0.0, state, ""), float(k))
    changes = [state for k, state in enumerate(states) if k == 0 or states[k - 1] != state]
    assert [entry["kind"] for entry in log.since(0)] == changes
    assert log.count == len(changes)
    assert [entry["number"] for entry in log.since(first)] == [*range(first, len(changes))]


def test_the_log_forgets_the_oldest_and_keeps_counting() -> None:
    log = EventLog()
    for k in range(250):
        log.add("kept", k, f"press {k}", pad="palm", track=k if k % 2 else None)
    told = log.since(0)
    assert [entry["number"] for entry in told] == [*range(50, 250)]
    assert (told[-1]["track"], told[-2]["track"], told[-1]["pad"]) == ("palm/249", None, "palm")
    assert (told[-1]["time_s"], told[-1]["words"]) == (249, "press 249")


def test_what_is_seen_is_logged_and_a_press_once_it_is_over() -> None:
    log = EventLog()
    named = NamedPress(3, 0.5, 1.0, over=True, recognition=None, words="too light")
    zeros = tuple(SimpleNamespace(taken=taken, reason="", time_s=2.0) for taken in (True, False))
    pad = seen_pad(heap(7, 5), events=(event(time_s=1.25),), zeroings=zeros)
    log.add_seen(seen(pad, named=(named, NamedPress(4, 1.0, 1.1, over=False, recognition=None, words="so far"))))
    told = log.since(0)
    assert [entry["kind"] for entry in told] == ["moved", "zero", "refused", "named"]
    assert (told[0]["time_s"], told[0]["track"], told[0]["pad"]) == (1.25, "pad/1", "pad")
    assert [entry["words"] for entry in told[1:3]] == ["zero taken", "zero refused"]
    assert (told[3]["time_s"], told[3]["words"]) == (1.0, "press 3: not recognized")


@pytest.mark.parametrize(("units", "told"), [((), 0), (("kPa",), 1), (("kPa", "kPa"), 1), (("kPa", "raw"), 0)])
def test_noise_is_told_in_the_unit_that_all_pads_have(units: tuple[str, ...], told: int) -> None:
    pads = [seen_pad(name=f"pad {k}", unit=unit) for k, unit in enumerate(units)]
    stream = SimpleNamespace(health=StreamHealth(), changes=(Change(0.0, "open", ""),), address="a", state="open")
    stream.words, stream.received, stream.damaged, stream.overrun = "", 0, 3, 2
    status = source_status(stream, {}, seen(*pads) if pads else None)  # type: ignore[arg-type]
    facts = [tuple(fact) for fact in status["facts"]]
    assert sum(name == "noise σ" for name, _ in facts) == told
    assert {("damaged", "3"), ("came too fast", "2")} <= set(facts)
    assert "lost on the way" not in dict(facts)
    # A source that has said nothing is silent since it was opened.
    assert status["silent_s"] > 1e9
