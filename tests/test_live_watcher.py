"""The watcher: what touches is told when it touches, whatever the clock, the pads and the values do."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.live_presses import FORMS, pressed
from tests.live_scripted import Scripted

from varishold.errors import EndOfSourceError, InputError
from varishold.live import PadLayout, Sample, Watcher, watch
from varishold.live.lines import lines_of
from varishold.live.pad_silence import PAD_SILENT
from varishold.live.steady_time import SteadyTime
from varishold.sensor import Sensor

TIMES = st.one_of(st.none(), st.floats(), st.floats(0, 100))


@given(st.lists(st.tuples(TIMES, st.floats(0, 2e9)), max_size=20))
def test_time_never_goes_back_whatever_the_clocks_say(clocks: list[tuple[float | None, float]]) -> None:
    steady = SteadyTime()
    times = [steady.time_s(Sample(device, host, None, {})) for device, host in clocks]
    assert all(math.isfinite(time) for time in times)
    assert times == sorted(times)


@given(st.lists(st.floats(0, 10), min_size=1, max_size=20), st.floats(0, 1e6))
def test_a_clock_that_only_goes_on_is_kept(steps: list[float], start: float) -> None:
    steady, device = SteadyTime(), start + np.cumsum(steps)
    assert [steady.time_s(Sample(d, 5.0 + d, None, {})) for d in device.tolist()] == device.tolist()


def _kinds(seen: list) -> list[str]:
    return [event.kind for each in seen for pad in each.pads.values() for event in pad.events]


def test_each_press_is_touched_and_released_and_kept() -> None:
    with Watcher() as watcher:
        seen = [watcher.see(sample) for sample in pressed("cone", "pillar")]
    kinds = [kind for kind in _kinds(seen) if kind in ("touched", "released")]
    assert kinds == ["touched", "released"] * 2
    ended = [each.ended for each in seen if each.ended is not None]
    assert [kept.number for kept in ended] == [0, 1]
    for kept, start in zip(ended, (1.30, 2.93), strict=True):
        assert abs(kept.start_s - start) < 0.05
        frames = kept.press.pads["pad"]
        # Some of the rest stands before it.
        assert np.abs(frames[0]).max() < 10 < np.abs(frames[len(frames) // 2]).max()
        assert np.isclose(kept.press.time_s[-1], kept.end_s, atol=0.2)


def test_the_same_presses_downward_and_with_a_sensor_that_says_so() -> None:
    def turned(sample: Sample) -> Sample:
        return sample._replace(pads={"pad": 1000.0 - sample.pads["pad"]})

    layout = {"pad": PadLayout((16, 16), polarity="down")}
    with Watcher(layout) as told, Watcher(sensor=Sensor(polarity="down", rest=1000.0, span=1000.0)) as given:
        for watcher in (told, given):
            seen = [watcher.see(turned(sample)) for sample in pressed("cone")]
            assert [kind for kind in _kinds(seen) if kind in ("touched", "released")] == ["touched", "released"]


def test_another_sensor_is_told() -> None:
    with Watcher(sensor=Sensor(name="mat", shape=(4, 4))) as watcher, pytest.raises(InputError) as told:
        watcher.see(next(pressed()))
    assert str(told.value) == "mat is for 4 x 4 taxels, pad 'pad' has 16 x 16"


def test_values_that_are_no_numbers_are_survived() -> None:
    strange = [np.nan, np.inf, -np.inf, 1e300, -1e300]
    with Watcher() as watcher:
        for k, sample in enumerate(pressed("cone", "pillar")):
            frame = sample.pads["pad"].copy()
            if k % 3 == 0:
                frame[k % 16, 3] = strange[k % 5]
            if k in (50, 140):
                frame[:] = np.nan
            seen = watcher.see(sample._replace(pads={"pad": frame}))
            json.dumps(list(lines_of(seen)), allow_nan=False)


def test_pads_may_come_one_by_one_and_in_another_shape() -> None:
    with Watcher() as watcher:
        for k, sample in enumerate(pressed("cone")):
            frame = sample.pads["pad"]
            name = ("left", "right")[k % 2]
            seen = watcher.see(sample._replace(pads={name: frame[:8] if k > 145 else frame}))
            assert set(seen.pads) == {name}
        assert {name: pad.shape for name, pad in watcher.pads.items()} == {"left": (8, 16), "right": (8, 16)}


def test_a_pad_that_comes_no_more_is_told_and_touched_by_nothing() -> None:
    """A press on a pad that is gone would last for ever, and take every later one in."""
    samples = [*pressed("cone", free=140, held=400)]
    with Watcher() as watcher:
        events, remarks, ended = [], [], []
        for k, sample in enumerate(samples):
            frame = sample.pads["pad"]
            pads = {"right": frame - FORMS["cone"] * (150 < k < 542)}
            if k < 150 or k > 560:
                pads["left"] = frame
            seen = watcher.see(sample._replace(pads=pads))
            assert "left" in watcher.newest
            events += [(name, event.kind, k) for name, pad in seen.pads.items() for event in pad.events]
            remarks += [(name, *pad.remarks, k) for name, pad in seen.pads.items() if pad.is_news]
            ended += [k] if seen.ended is not None else []
    assert [event for event in events if event[0] == "left"] == [("left", "touched", 141), ("left", "released", 450)]
    assert remarks == [("left", PAD_SILENT, 450), ("left", 561)]
    assert len(ended) == 1


def test_signals_and_taxels_on_no_grid_are_watched() -> None:
    layout = {"field": PadLayout((6,), kind="signals", names=("T", "x", "y", "z", "a", "b"))}
    with Watcher(layout) as watcher:
        for k in range(30):
            seen = watcher.see(Sample(None, float(k), None, {"field": np.arange(6.0) + k, "row": np.ones(9)}))
        assert seen.pads["field"].tracks == ()
        assert seen.pads["field"].zeroed.shape == (1, 6)


def test_lines_have_the_keys_that_are_documented() -> None:
    touched = 0
    with Watcher({"pad": PadLayout((16, 16), pitch_m=(0.002, 0.002), unit="kPa")}) as watcher:
        for sample in pressed("cone"):
            lines = [json.loads(json.dumps(line, allow_nan=False)) for line in lines_of(watcher.see(sample))]
            keys = {"line", "frame", "time_s", "device_time_s", "host_time_s", "sequence", "contacts"}
            assert set(lines[0]) == keys
            assert lines[0]["line"] == "frame"
            assert lines[0]["sequence"] == lines[0]["frame"] == sample.sequence
            for contact in lines[0]["contacts"]:
                touched += 1
                assert {"pad", "track", "state", "name", "probability", "position_taxels"} <= set(contact)
            for line in lines[1:]:
                assert line["line"] in ("event", "zero")
                wanted = {"event", "track"} if line["line"] == "event" else {"why", "taken", "reason"}
                assert {"frame", "pad", "time_s", *wanted} <= set(line)
    assert touched >= 28


def test_watching_yields_every_reading_and_calls_back() -> None:
    source, told = Scripted(), []
    for sample in pressed("cone"):
        source.script.put(sample)
    source.script.put(EndOfSourceError("all of it"))
    changes = []
    seen = list(watch(source, on_event=lambda pad, event: told.append((pad, event.kind)), on_change=changes.append))
    assert [each.number for each in seen] == list(range(len(seen)))
    assert [each.sample is None for each in seen] == [False] * (len(seen) - 1) + [True]
    assert ("pad", "touched") in told
    assert [change.state for change in changes][-2:] == ["open", "ended"]
    assert _kinds(seen) == [kind for _, kind in told]


def test_whole_numbers_that_hardly_flicker_touch_nothing() -> None:
    rng = np.random.default_rng(0)
    with Watcher() as watcher:
        for k in range(1500):
            # Rest right between two counts: every taxel flickers by one.
            frame = np.rint(rng.normal(20.5, 0.1, (12, 12))).astype(np.uint8)
            seen = watcher.see(Sample(k / 100, 0.0, None, {"pad": frame}))
            assert not seen.touched


def test_signals_are_held_at_their_zero_and_go_both_ways() -> None:
    rng = np.random.default_rng(0)
    layout = PadLayout((15,), kind="signals")
    with Watcher({"pad": layout}) as watcher:
        for k in range(1000):
            pressed_now = -400.0 if k > 300 else 0.0
            seen = watcher.see(Sample(k / 100, 0.0, None, {"pad": rng.normal(50 + pressed_now, 1.0, 15)}))
        assert seen.pads["pad"].zeroed.mean() == pytest.approx(-400, abs=2)
        assert watcher.pads["pad"].zero.state == "holding"
        assert watcher.pads["pad"].how_it_is().bad == ()


def test_the_health_of_a_pad_is_watched() -> None:
    with Watcher() as watcher:
        for sample in pressed(*["cone"] * 10):
            frame = sample.pads["pad"].copy()
            frame[:, 2], frame[5, 7] = 0.0, 33.0
            watcher.see(sample._replace(pads={"pad": frame}))
        report = watcher.pads["pad"].how_it_is()
    assert report.open_cols == (2,)
    assert "taxel (5, 7) never changes its value: stuck" in report.remarks
