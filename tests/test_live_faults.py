"""A watched pad names what presses by what its taxels can be believed: broken, saturated, smoothed ones are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold.frame.running_end import RunningEnd
from varishold.frame.running_quiet import RunningQuiet
from varishold.live.lines import lines_of
from varishold.live.pad_watcher import PadWatcher, SeenPad
from varishold.live.sample import PadLayout
from varishold.live.watcher import Seen

Floats = NDArray[np.float64]
RATE_HZ, SIDE, NOISE = 50, 16, 1.5
REST, PRESS = 12 * RATE_HZ, np.r_[np.zeros(25), np.linspace(0.1, 1.0, 8), np.ones(20), np.linspace(0.8, 0.0, 6)]


def cone(side: int = SIDE, breadth: float = 10.0) -> Floats:
    y, x = np.mgrid[:side, :side] - (side - 1) / 2
    return np.asarray(np.maximum(1.0 - np.hypot(x, y - 0.3) / (breadth / 2), 0.0))


def stream(*forces: float, form: Floats | None = None, seed: int = 0) -> Floats:
    """Presses on an uneven rest, in readings of which the strongest press has 100."""
    rng = np.random.default_rng(seed)
    course = np.concatenate([np.zeros(REST), *(force * PRESS for force in forces), np.zeros(25)])
    form = cone() if form is None else form
    pressed: Floats = 100.0 * course[:, None, None] * form
    return pressed + 20.0 * rng.random(form.shape) + rng.normal(0.0, NOISE, pressed.shape)


def watched(frames: NDArray[np.floating] | NDArray[np.integer], *, whole: bool = False) -> list[SeenPad]:
    watcher = PadWatcher("pad", PadLayout(shape=frames.shape[1:]), whole=whole)
    return [watcher.see(k / RATE_HZ, frame) for k, frame in enumerate(frames)]


def names(seen: list[SeenPad]) -> list[tuple[str, float]]:
    """Return the last name of each touch, and how sure it is."""
    last = {track.number: track.answer for one in seen for track in one.tracks if track.answer is not None}
    return [(answer.name, answer.probability) for answer in last.values()]


def test_sound_taxels_are_all_believed() -> None:
    seen = watched(stream(1.0, 0.7))
    assert [name for name, _ in names(seen)] == ["cone", "cone"]
    assert not any(seen[-1].notes)


def test_rows_that_say_nothing_are_filled_once_that_is_known() -> None:
    frames = stream(1.0, 0.7)
    frames[:, SIDE // 2 : SIDE // 2 + 2] = 7.0
    seen = watched(frames)
    assert [name for name, _ in names(seen)] == ["cone", "cone"]
    assert any("32 taxels" in note and "filled from its neighbours" in note for note in seen[-1].notes)


def test_taxels_that_nothing_has_pressed_are_not_broken_where_none_has_noise() -> None:
    frames = np.rint(np.maximum(stream(*[1.0] * 12) - 25.0, 0.0)).astype(np.uint8)
    seen = watched(frames, whole=True)
    assert not any("filled" in note for one in seen for note in one.notes)


def test_far_too_noisy_taxels_touch_nothing() -> None:
    frames = stream(1.0, 0.7)
    rng = np.random.default_rng(1)
    for row, col in ((1, 2), (3, 13), (12, 4), (14, 14)):
        frames[:, row, col] += rng.normal(0.0, 15 * NOISE, len(frames))
    seen = watched(frames)
    assert [name for name, _ in names(seen)] == ["cone", "cone"]
    assert len([event for one in seen for event in one.events if event.kind == "touched"]) == 2
    assert any("far too noisy" in note for note in seen[-1].notes)


@pytest.mark.parametrize("kind", ["noise on it", "whole counts"])
def test_where_readings_end_taxels_are_saturated(kind: str) -> None:
    frames = stream(1.0, 1.0, 0.8, 1.0)
    if kind == "noise on it":
        ended = np.minimum(frames, 55.0) + np.random.default_rng(2).normal(0.0, NOISE, frames.shape)
        seen = watched(ended)
        assert any("readings end at about" in note for note in seen[-1].notes)
    else:
        seen = watched(np.clip(np.rint(frames + 200.0), 0, 255).astype(np.uint8), whole=True)
    later = [track for one in seen[-100:] for track in one.tracks]
    assert any(track.contact.state.saturated > 6 for track in later)
    assert not any(name != "cone" and p > 0.9 for name, p in names(seen))


def test_a_rest_at_full_scale_is_not_saturated_where_readings_fall() -> None:
    frames = np.clip(np.rint(255.0 - stream(0.7)), 0, 255).astype(np.uint8)
    watcher = PadWatcher("pad", PadLayout(shape=frames.shape[1:], polarity="down"), whole=True)
    seen = [watcher.see(k / RATE_HZ, frame) for k, frame in enumerate(frames)]
    tracks = [track for one in seen for track in one.tracks]
    assert tracks
    assert not any(track.contact.state.saturated for track in tracks)


def test_readings_that_fall_under_pressure_are_told() -> None:
    falling = watched(300.0 - stream(1.0, 0.7, 1.0))
    assert any("readings fall where something presses" in note for note in falling[-1].notes)
    assert not any("fall" in note for one in watched(stream(1.0, 0.7, 1.0)) for note in one.notes)
    watcher = PadWatcher("pad", PadLayout(shape=(SIDE, SIDE), polarity="down"))
    seen = [watcher.see(k / RATE_HZ, frame) for k, frame in enumerate(stream(1.0, 0.7, 1.0))]
    assert any("is the polarity right?" in note for note in seen[-1].notes)


def test_smoothed_readings_leave_small_forms_unsure() -> None:
    rough = stream(1.0, 0.7)
    smooth = sum(np.roll(rough, (i, j), axis=(1, 2)) for i in (-1, 0, 1) for j in (-1, 0, 1)) / 9
    for frames, most in ((rough, 1.0), (smooth, 0.85)):
        assert all(p <= most + 1e-9 for _, p in names(watched(frames)))
    assert max(p for _, p in names(watched(rough))) > 0.9


def test_an_end_is_taken_back_by_a_press_that_goes_beyond() -> None:
    end, rest = RunningEnd(np.ones((SIDE, SIDE), np.bool_)), np.zeros((SIDE, SIDE))
    known = []
    for most in (55.0, 55.0, 55.0, np.inf):
        for share in PRESS:
            end.update(np.minimum(100.0 * share * cone(), most), rest, 0.1, is_pressed=share > 0)
        known.append(end.end is not None)
    assert known == [False, True, True, False]


@pytest.mark.parametrize("frames", [10, 40, 200])
def test_a_top_that_grows_slowly_is_no_end(frames: int) -> None:
    rng = np.random.default_rng(3)
    end, rest = RunningEnd(np.ones((SIDE, SIDE), np.bool_)), np.zeros((SIDE, SIDE))
    seen = []
    for force in np.linspace(5.0, 100.0, frames):
        end.update(force * cone() + rng.normal(0.0, NOISE, (SIDE, SIDE)), rest, NOISE, is_pressed=True)
        seen.append(end.end is not None)
    assert np.mean(seen) < 0.05
    end.update(np.zeros((SIDE, SIDE)), rest, NOISE, is_pressed=False)
    assert end.end is None


def test_what_is_odd_is_a_line_when_it_changes() -> None:
    frames = stream(1.0, 0.7)
    frames[:, SIDE // 2] = 7.0
    seen = watched(frames)
    news = [one for one in seen if one.is_news]
    assert len(news) == 1
    assert news[0].remarks == seen[-1].remarks
    whole = Seen(number=3, time_s=0.0, sample=None, pads={"pad": news[0]})
    lines = [line for line in lines_of(whole) if line["line"] == "remarks"]
    assert lines == [{"line": "remarks", "frame": 3, "pad": "pad", "remarks": list(news[0].remarks)}]


def test_few_taxels_show_no_end_and_share_no_noise() -> None:
    end, sharing = RunningEnd(np.ones((3, 3), np.bool_)), RunningQuiet(np.ones((1, 9), np.bool_))
    for k in range(100):
        end.update(np.full((3, 3), min(k % 30, 10.0)), np.zeros((3, 3)), 0.1, is_pressed=k % 30 > 5)
        sharing.update(k / 50, np.full((1, 9), float(k % 2)), is_pressed=False)
    assert end.end is None
    assert not sharing.shares
