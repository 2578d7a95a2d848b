"""Pictures for the page: a head of JSON and numbers behind it, which draw what was seen."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_seen import COLS, ROWS, heap, seen, seen_pad

from varishold.live.pad_watcher import SeenPad
from varishold.live.picture import DRAWN_LEVELS, picture_of
from varishold.live.words import words_of
from varishold.report.quantities import percent
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
