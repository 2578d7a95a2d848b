"""Laws and contracts of how a grasp is loaded in time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import clone

from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.touch.course.features import LoadingFeatures
from varishold.touch.course.loading import LOAD_SHARES, Loading, loading_features


def by_name(loading: Loading) -> dict[str, float]:
    return {name: loading[name] for name in loading.names}


def grasp(
    n: int = 40, *, pads: int = 2, lag: float = 0.1, rise: float = 0.5, rate: float = 40.0, release: float | None = None
):
    """Return frames (n, pads, 8, 6) whose load rises evenly from .2 s on, each pad `lag` later, and their times."""
    time = np.arange(n) / rate
    v, u = np.mgrid[:8, :6]
    spot = np.exp(-0.5 * ((v - 3.0) ** 2 + (u - 2.5) ** 2) / 2.0)
    frames = np.zeros((n, pads, 8, 6))
    for k in range(pads):
        force = np.clip((time - 0.2 - k * lag) / rise, 0, 1)
        if release is not None:
            force *= np.clip((release + 0.2 - time) / 0.2, 0, 1)
        frames[:, k] = 100 * force[:, None, None] * spot
    return frames, time


def of(loading: Loading, part: str) -> np.ndarray:
    return np.array([v for name, v in by_name(loading).items() if part in name])


def test_lags_and_rise_are_told_in_seconds():
    loading = loading_features(*grasp(), floor=0.0)
    # The onset is at a fixed share of the largest load: the same delay on both pads.
    assert loading["pad_0_onset_lag"] == 0
    assert loading["pad_1_onset_lag"] == pytest.approx(0.1, abs=1e-9)
    assert loading["difference_of_pad_0_and_pad_1_onset_lag"] == pytest.approx(-0.1, abs=1e-9)
    for share in LOAD_SHARES:
        assert loading[f"pad_0_time_to_{share:g}_of_load"] == pytest.approx(0.5 * (share - 0.02), abs=1e-9)
    assert loading.clock == "seconds"
    assert loading.remarks == ()


@settings(max_examples=25)
@given(st.floats(0.1, 50.0), st.floats(-100, 100), st.integers(0, 2**31))
def test_when_the_clock_began_and_how_large_a_unit_is_change_nothing(gain, began, seed):
    frames, time = grasp()
    frames = frames + np.random.default_rng(seed).uniform(0, 2, frames.shape) * (frames > 0)
    a = loading_features(frames, time, floor=0.0, times=[0.1, 0.3])
    b = loading_features(gain * frames, time + began, floor=0.0, times=[0.1, 0.3])
    scaled = ("_largest_load", "_peak_at_time_0", "_peak_at_time_1", "_load_at_time_0", "_load_at_time_1")
    unit = np.where([name.endswith(scaled) and "_share_of_load_" not in name for name in a.names], gain, 1.0)
    np.testing.assert_allclose(b.values, unit * a.values, rtol=1e-6, atol=1e-6)


@settings(max_examples=15)
@given(st.integers(0, 2**31))
def test_another_rate_and_uneven_times_measure_the_same(seed):
    even = loading_features(*grasp(), floor=0.0)
    frames, time = grasp(400, rate=400.0)
    rng = np.random.default_rng(seed)
    kept = np.sort(np.concatenate([[0, 399], rng.choice(np.arange(1, 399), 150, replace=False)]))
    uneven = loading_features(frames[kept], time[kept], floor=0.0)
    for part in ("pad_0_time_to_0.5", "pad_1_onset_lag", "pad_1_time_to_0.9"):
        assert of(uneven, part) == pytest.approx(of(even, part), abs=0.02)


def test_mirrored_pads_move_the_other_way():
    frames, time = grasp()
    a = by_name(loading_features(frames, time, floor=0.0, times=[0.2]))
    b = by_name(loading_features(frames[..., ::-1], time, floor=0.0, times=[0.2]))
    for name, value in a.items():
        if "columns" not in name:
            sign = -1 if "_x_at" in name and "spread" not in name else 1
            assert b[name] == pytest.approx(sign * value, abs=1e-9), name


def test_how_long_it_was_recorded_before_contact_does_not_count():
    frames, time = grasp()
    early = np.concatenate([np.zeros((30, *frames.shape[1:])), frames])
    before = np.concatenate([time[0] - np.arange(30, 0, -1) / 40, time])
    np.testing.assert_allclose(
        loading_features(early, before, floor=0.0).values, loading_features(frames, time, floor=0.0).values, atol=1e-9
    )


def test_a_grasp_that_is_let_go_has_dwell_fall_and_hysteresis():
    held = loading_features(*grasp(60, release=1.2), floor=0.0)
    assert held["pad_0_let_go"] == 1
    # Above .9 of the load from .2 + .45 s to 1.2 + .02 s.
    assert held["pad_0_dwell"] == pytest.approx(0.57, abs=0.03)
    assert held["pad_0_fall_time"] == pytest.approx(0.08, abs=0.03)
    kept = loading_features(*grasp(60), floor=0.0)
    assert kept["pad_0_let_go"] == kept["pad_0_dwell"] == kept["pad_0_fall_time"] == 0


def test_only_the_span_counts():
    frames, time = grasp()
    short = loading_features(frames, time, floor=0.0, span=0.25)
    assert short["pad_0_largest_load"] < 0.6 * loading_features(frames, time, floor=0.0)["pad_0_largest_load"]


def test_without_time_frames_are_counted_and_it_says_so():
    loading = loading_features(grasp()[0], floor=0.0)
    assert loading.clock == "frames"
    assert "counted in frames" in loading.remarks[0]
    assert loading["pad_1_onset_lag"] == pytest.approx(4.0)


def test_an_untouched_pad_has_zeros_and_is_named():
    frames, time = grasp()
    frames[:, 1] = 0
    loading = loading_features(frames, time, floor=0.0)
    assert all(v == 0 for name, v in by_name(loading).items() if name.startswith("pad_1_"))
    assert loading.remarks == ("not touched: pad_1",)
    nothing = loading_features(np.zeros((5, 2, 4, 4)), floor=0.0)
    assert not nothing.values.any()


def test_pads_of_a_recording_may_differ_in_shape_and_keep_their_names():
    frames, time = grasp()
    valid = np.ones((8, 6), bool)
    valid[0, 0] = False
    broken = frames[:, 0].copy()
    broken[:, 0, 0] = np.nan
    recording = Recording({"thumb": Pad(broken, valid=valid), "palm": Pad(frames[:, 1, :5])}, time)
    loading = loading_features(recording)
    assert np.isfinite(loading.values).all()
    assert loading["palm_onset_lag"] > 0
    assert "mean_of_thumb_and_palm_onset_lag" in loading.names
    with pytest.raises(KeyError):
        loading["wrist_onset_lag"]


@pytest.mark.parametrize("shape", [(1, 1, 1, 1), (2, 1, 1, 5), (3, 3, 2, 2)])
def test_tiny_grasps_are_measured(shape):
    assert np.isfinite(loading_features(np.ones(shape), floor=0.0, times=[0, 5]).values).all()


def test_no_time_that_is_taken_is_too_long_for_what_is_measured():
    load = np.array([0.0, 1, 2, 4, 4, 1, 0])[:, None, None] * np.ones((4, 4))
    found = loading_features(load, 1e100 * np.linspace(-1, 1, len(load)), floor=0.0, times=[1e300], span=1.7e308)
    assert np.isfinite(found.values).all()


@pytest.mark.parametrize(
    ("frames", "options", "message"),
    [
        (np.ones((4, 5)), {}, r"must have shape \(n_frames, n_pads, rows, cols\)"),
        (np.ones((4, 0, 2, 2)), {}, "must have shape"),
        ([[[1.0]], [[1.0, 2.0]]], {}, "must be one array"),
        (np.ones((0, 1, 2, 2)), {}, "at least one frame"),
        (np.full((3, 1, 2, 2), np.nan), {}, "finite"),
        (np.ones((3, 1, 2, 2)), {"time_s": [0, 1]}, "time_s must be one number a frame"),
        (np.ones((3, 1, 2, 2)), {"time_s": [0, 2, 1]}, "must not run backward, got 1 after 2 at frame 2"),
        (np.ones((3, 1, 2, 2)), {"time_s": [0, np.nan, 1]}, "time_s must be finite"),
        (np.ones((3, 1, 2, 2)), {"time_s": [0, 1, 1e300]}, r"time_s must be within \+-1e\+100, got 1e\+300 at frame 2"),
        (np.ones((3, 1, 2, 2)), {"field": np.ones((3, 3))}, "field must have shape"),
        (np.ones((3, 1, 2, 2)), {"bands": -1}, "bands must be a whole number"),
        (np.ones((3, 1, 2, 2)), {"span": 0}, "span must be a finite number, above 0"),
        (np.ones((3, 1, 2, 2)), {"floor": np.inf}, "floor must be a finite number"),
        (np.ones((3, 1, 2, 2)), {"times": [-1.0]}, "times must be one row"),
        (np.ones((3, 1, 2, 2)), {"times": "soon"}, "times must be numbers"),
    ],
)
def test_bad_input_is_told_in_one_line(frames, options, message):
    with pytest.raises(InputError, match=message) as caught:
        loading_features(frames, **options)
    assert "\n" not in str(caught.value)


def test_the_transformer_takes_grasps_of_differing_lengths():
    grasps = [grasp(n, rise=rise) for n, rise in ((40, 0.5), (55, 0.3), (70, 0.9))]
    features = LoadingFeatures(floor=0.0, times=5)
    inputs = features.fit_transform(grasps)
    assert inputs.shape == (3, len(features.get_feature_names_out()))
    assert np.isfinite(inputs).all()
    assert features.clock_ == "seconds"
    assert len(features.times_) == 5
    # The median rise is that of .5 s.
    assert features.times_[-1] == pytest.approx(1.25 * 0.5 * 0.93, rel=0.01)
    np.testing.assert_array_equal(features.transform(grasps[1:])[0], inputs[1])
    again = clone(features).fit(grasps)
    np.testing.assert_array_equal(again.transform(grasps), inputs)
    assert features.transform([]).shape == (0, inputs.shape[1])


def test_the_transformer_says_which_grasp_is_wrong():
    good = grasp()
    features = LoadingFeatures(floor=0.0, times=3).fit([good])
    with pytest.raises(InputError, match="grasp 1: time_s must not run backward"):
        features.transform([good, (good[0], good[1][::-1])])
    with pytest.raises(InputError, match="grasp 0 has times in frames, the grasps of fit in seconds"):
        features.transform([good[0]])
    with pytest.raises(InputError, match="grasp 0 has the pads pad_0, those of fit were pad_0, pad_1"):
        features.transform([(good[0][:, :1], good[1])])
    rows, cols = good[0].shape[-2:]
    narrow = f"grasp 1: its pad pad_0 has {rows} x {cols - 1} taxels, that of fit had {rows} x {cols}"
    with pytest.raises(InputError, match=narrow):
        features.transform([good, (good[0][..., 1:], good[1])])
    with pytest.raises(InputError, match="times must be numbers, got 'soon'"):
        LoadingFeatures(times="soon").fit([good])
    with pytest.raises(InputError, match="at least one grasp"):
        LoadingFeatures().fit([])
    with pytest.raises(InputError, match="must be a sequence"):
        features.transform(5)
    with pytest.raises(InputError, match="times must be a whole number"):
        LoadingFeatures(times=-2).fit([good])
