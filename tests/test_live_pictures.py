"""Pictures for the page: a head of JSON and numbers behind it, which draw what was seen."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_seen import COLS, ROWS, heap, seen, seen_pad

from varishold.live import PadLayout
from varishold.live.pad_watcher import SeenPad
from varishold.live.picture import DRAWN_LEVELS, picture_of
from varishold.live.watcher import Seen
from varishold.live.words import words_of
from varishold.report.quantities import percent
from varishold.touch import ContactTracker, find_contacts
from varishold.touch.tracking.track import Track


def read_picture(message: bytes) -> tuple[dict[str, Any], np.ndarray]:
    size = int.from_bytes(message[:4], "little")
    assert size % 4 == 0
    return json.loads(message[4 : 4 + size]), np.frombuffer(message[4 + size :], "<f4")


@pytest.mark.parametrize("pitch", [None, (0.002, 0.003)])
def test_a_picture_holds_what_was_seen(pitch: tuple[float, float] | None) -> None:
    first, second = seen_pad(heap(4, 5), heap(12, 3, 50, 2), pitch=pitch), seen_pad(name="other")
    head, numbers = read_picture(picture_of(seen(first, second)))
    assert (head["number"], head["time_s"], head["host_time_s"]) == (7, 1.5, 1e9)
    assert [pad["name"] for pad in head["pads"]] == ["pad", "other"]
    for told, pad in zip(head["pads"], (first, second), strict=True):
        assert (told["rows"], told["cols"], told["kind"]) == (ROWS, COLS, "pressure")
        assert numbers[told["at"] : told["at"] + ROWS * COLS] == pytest.approx(pad.frame.ravel(), rel=1e-6)
    told, empty = head["pads"]
    assert told["aspect"] == pytest.approx(1.5 if pitch else 1.0)
    assert told["pitch_mm"] == (pytest.approx(3.0) if pitch else None)
    assert (empty["peak"], empty["contacts"], empty["floor"]) == (None, [], 3.0)
    assert told["peak"] == max(track.contact.peak for track in first.tracks)
    assert told["floor"] == min(track.contact.floor for track in first.tracks)
    for contact, track in zip(told["contacts"], first.tracks, strict=True):
        its = track.contact
        unit = 1e3 if pitch else 1.0
        assert (contact["track"], contact["load"], contact["state"]) == (f"pad/{track.number}", track.load, track.state)
        assert track.answer is not None
        assert (contact["name"], contact["sure"]) == (track.answer.name, percent(track.answer.probability))
        x0, y0, x1, y1 = contact["window"]
        assert (slice(y0, y1), slice(x0, x1)) == its.window
        assert 0 < contact["levels"] <= DRAWN_LEVELS
        n, at = contact["levels"], contact["curves"]
        height, root, perimeter, usable = numbers[at : at + 4 * n].reshape(4, n)
        # From the lowest section to the highest, in the page's units.
        shown = [int(np.argmin(abs(its.profile.threshold - t))) for t in its.floor + height * (its.peak - its.floor)]
        assert root == pytest.approx(unit * np.sqrt(its.profile.area[shown]), rel=1e-5)
        assert perimeter == pytest.approx(unit * its.profile.perimeter[shown], rel=1e-5)
        # Small sections are usable last.
        large = its.profile.area[shown] / its.taxel_area
        assert set(usable.tolist()) <= {0, 1}
        assert usable[large >= 16].all()
        assert not usable[large < 2].any()
        assert (0 <= height).all()
        assert (height <= 1).all()
        assert len(set(shown)) == n
        # The centre of load stands inside of the window.
        assert x0 <= contact["position"][0] <= x1
        assert y0 <= contact["position"][1] <= y1


@pytest.mark.parametrize(("at_x", "at_y"), [(7, 5), (0, 5), (15, 5), (7, 0), (7, 11), (15, 11), (0, 0)])
def test_a_picture_draws_the_outline_of_each_section(at_x: int, at_y: int) -> None:
    """Also where the border of the pad closes it."""
    pad = seen_pad(heap(at_x, at_y))
    head, numbers = read_picture(picture_of(seen(pad)))
    (contact,) = head["pads"][0]["contacts"]
    assert len(contact["outlines"]) == contact["levels"]
    height, root = numbers[contact["curves"] :][: 2 * contact["levels"]].reshape(2, -1)
    at = contact["at"]
    areas = []
    for lines in contact["outlines"]:
        area = 0.0
        for count in lines:
            points = numbers[at : at + 2 * count].reshape(-1, 2)
            at += 2 * count
            x, y = points.T.astype(float)
            area += abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2
            # Around the heap's middle, taxels counted from the upper left corner.
            low, high = points.min(axis=0), points.max(axis=0)
            assert (low >= 0).all()
            assert (high <= (COLS, ROWS)).all()
            assert (low <= (at_x + 0.6, at_y + 0.6)).all()
            assert (high >= (at_x + 0.4, at_y + 0.4)).all()
        areas.append(area)
    assert np.sqrt(areas) == pytest.approx(root, rel=0.02, abs=0.05)
    assert np.argsort(height).tolist() in ([*range(len(areas))], [*range(len(areas))][::-1])


def test_a_picture_of_many_contacts_leaves_out_sections_and_then_contacts() -> None:
    pad = seen_pad(heap(4, 5), heap(12, 3, 50, 2))
    many = [
        SeenPad(f"pad {k}", pad.layout, pad.raw, pad.zeroed, pad.frame, tracks=pad.tracks * 5, sigma=0.5)
        for k in range(8)
    ]
    head, _ = read_picture(picture_of(seen(*many)))
    contacts = [contact for pad in head["pads"] for contact in pad["contacts"]]
    assert len(contacts) == 64
    assert {contact["levels"] for contact in contacts} == {4}
    lost = [SimpleNamespace(**{**vars(track), "state": "lost"}) for track in pad.tracks]
    head, _ = read_picture(picture_of(seen(SeenPad("pad", *[pad.layout] + [pad.frame] * 3, tracks=tuple(lost)))))  # type: ignore[arg-type]
    assert head["pads"][0]["contacts"] == []


def test_tracks_of_no_answer_have_none() -> None:
    pad = seen_pad(heap(7, 5))
    (track,) = pad.tracks
    bare = Track(**{**vars(track), "answer": None})
    assert pad.answer(bare, number=1, time_s=0.0) is None
    head, _ = read_picture(picture_of(seen(SeenPad("pad", *[pad.layout] + [pad.frame] * 3, tracks=(bare,)))))  # type: ignore[arg-type]
    (contact,) = head["pads"][0]["contacts"]
    assert (contact["name"], contact["sure"]) == (None, None)
    told = words_of(seen(SeenPad("pad", *[pad.layout] + [pad.frame] * 3, tracks=(bare,))))  # type: ignore[arg-type]
    assert told["pad/1"]["name"] is None


@pytest.mark.parametrize("pitch", [None, (0.002, 0.003)])
@pytest.mark.parametrize("gaps", [(), (0, 1, 40)])
def test_a_contact_is_drawn_by_its_own_figures(pitch: tuple[float, float] | None, gaps: tuple[int, ...]) -> None:
    field = np.ones((ROWS, COLS), bool)
    field.flat[list(gaps)] = False
    frame = heap(6.3, 4.6, 200.0, 4.0) + heap(13, 9, 120.0, 1.5)
    tracker = ContactTracker(pad="pad")
    for k in range(20):
        tracker.update(k / 100, find_contacts(frame, 32, pitch=pitch, field=field, sigma=0.5), frame)
    pad = SeenPad("pad", PadLayout((ROWS, COLS), pitch_m=pitch), frame, frame, frame, tracks=tracker.tracks)
    head, numbers = read_picture(picture_of(seen(pad)))
    (told,) = head["pads"]
    assert (told["signals"], told["at"]) == ([], 0)
    at = ROWS * COLS
    for contact, track in zip(told["contacts"], tracker.tracks, strict=True):
        its, profile = track.contact, track.contact.profile
        shown = np.flatnonzero(np.nan_to_num(profile.area) > 0)
        count = min(len(shown), DRAWN_LEVELS)
        # The first and the last of them, and evenly between.
        shown = shown[[round(k * (len(shown) - 1) / max(count - 1, 1)) for k in range(count)]]
        assert (contact["levels"], contact["curves"]) == (count, at)
        unit = 1.0 if pitch is None else 1e3
        curves = [
            (profile.threshold[shown] - its.floor) / (its.peak - its.floor),
            unit * np.sqrt(profile.area[shown]),
            unit * profile.perimeter[shown],
            profile.area[shown] >= 4 * its.taxel_area,
        ]
        assert numbers[at : at + 4 * count].reshape(4, count) == pytest.approx(np.array(curves), rel=1e-6)
        at += 4 * count
        assert contact["at"] == at
        at += 2 * sum(sum(lines) for lines in contact["outlines"])
        x, y = track.position_taxels
        assert contact["position"] == pytest.approx([x + COLS / 2, y + ROWS / 2])
        assert (contact["peak"], contact["floor"]) == (its.peak, its.floor)
    assert at == len(numbers)
    assert told["aspect"] == (1.0 if pitch is None else 1.5)


def test_a_pad_that_nothing_touches_and_signals_are_drawn_by_their_numbers() -> None:
    layout = PadLayout((5,), "signals", pitch_m=(0.004, 0.002), names=("a", "b", "c", "d", "e"))
    values = np.array([[1.0, -2.0, 3.0, 1e300, 0.5]])
    pads = [SeenPad(f"p{k}", layout, values, values, values, sigma=sigma) for k, sigma in enumerate((None, 0.25))]
    head, numbers = read_picture(picture_of(seen(*pads)))
    for k, (told, floor) in enumerate(zip(head["pads"], (0.0, 1.5), strict=True)):
        assert (told["kind"], told["signals"]) == ("signals", ["a", "b", "c", "d", "e"])
        assert (told["rows"], told["cols"], told["at"], told["floor"]) == (1, 5, 5 * k, floor)
        # The layout's spacing, where no contact has its own.
        assert (told["aspect"], told["pitch_mm"]) == (0.5, pytest.approx(2.0))
    assert numbers[:5].tolist() == [1.0, -2.0, 3.0, math.inf, 0.5]
    assert read_picture(picture_of(Seen(1, 2.0, None, {})))[0] == {
        "number": 1,
        "time_s": 2.0,
        "host_time_s": None,
        "pads": [],
    }


@pytest.mark.parametrize(("count", "levels"), [(1, 16), (12, 16), (13, 14), (24, 8), (47, 4), (48, 4), (64, 4)])
def test_the_more_contacts_there_are_the_fewer_sections_are_drawn_of_each(count: int, levels: int) -> None:
    pad = seen_pad(heap(7, 5))
    pads = [SeenPad(f"p{k}", *[pad.layout] + [pad.frame] * 3, tracks=pad.tracks) for k in range(count)]  # type: ignore[arg-type]
    head, _ = read_picture(picture_of(seen(*pads)))
    assert {contact["levels"] for told in head["pads"] for contact in told["contacts"]} == {levels}
