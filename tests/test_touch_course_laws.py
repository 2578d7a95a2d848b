"""Every number of a grasp's loading against a slow reference, and exact cases worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reference_loading import loading_of, onset_of

from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.touch.course.features import LoadingFeatures
from varishold.touch.course.loading import as_grasp, grasp_floor, loading_features


def drawn(rng, n, pads, rows, cols):
    """A grasp with wandering contacts, bumps and drops; often let go, sometimes one pad hardly touched."""
    steps = np.cumsum(rng.normal(0.3, 1.0, (n, pads)), axis=0).clip(0, 6)
    if rng.random() < 0.5:
        stop = rng.integers(n // 2, n)
        steps[stop:] *= np.clip(1 - 0.3 * np.arange(1, n - stop + 1), 0, 1)[:, None]
    steps[: rng.integers(0, 4)] = 0
    if pads > 1 and rng.random() < 0.3:
        steps[:, -1] *= rng.choice([0.0, 0.01, 0.05])
    y, x = np.ogrid[:rows, :cols]
    frames = np.zeros((n, pads, rows, cols))
    for k in range(pads):
        for i in range(n):
            cy, cx = rng.uniform(0, rows), rng.uniform(0, cols)
            spot = np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / 4)
            frames[i, k] = steps[i, k] * spot + rng.uniform(-0.02, 0.02, (rows, cols))
    return frames, np.cumsum(rng.choice([0.0, 0.01, 0.02, 0.05], n, p=[0.1, 0.4, 0.3, 0.2]))


@given(st.integers(0, 2**31), st.integers(2, 25), st.sampled_from([(5, 4), (1, 6), (3, 9), (7, 2)]), st.integers(0, 5))
@settings(max_examples=40)
def test_every_number_is_that_of_the_reference(seed, n, shape, bands):
    rng = np.random.default_rng(seed)
    pads = int(rng.integers(1, 4))
    frames, time = drawn(rng, n, pads, *shape)
    floor, moments = rng.choice([0.0, 0.05]), [0.0, 0.03, 0.2]
    field = rng.random(shape) > 0.1
    timed = rng.random() < 0.7
    loading = loading_features(frames, time if timed else None, field=field, floor=floor, times=moments, bands=bands)
    clock = time if timed else np.arange(n, dtype=float)
    heights = [np.where(field, np.maximum(frames[:, k] - floor, 0), 0.0) for k in range(pads)]
    loads = [height.sum(axis=(1, 2)).max() for height in heights]
    touched = [load > 0 and load >= 0.02 * max(loads) for load in loads]
    start = min((onset_of(h, clock) for h, t in zip(heights, touched, strict=True) if t), default=clock[0])
    names = [name.removeprefix("pad_0_") for name in loading.names if name.startswith("pad_0_")]
    told = {name: loading[name] for name in loading.names}
    alone = []
    for k, height in enumerate(heights):
        expected = loading_of(height, clock, start, moments, bands) if touched[k] else dict.fromkeys(names, 0.0)
        assert set(expected) == set(names)
        for name, value in expected.items():
            assert told[f"pad_{k}_{name}"] == pytest.approx(value, rel=1e-7, abs=1e-7), name
        alone.append(expected)
    for a in range(pads):
        for b in range(a + 1, pads):
            for name in names:
                one, other = alone[a][name], alone[b][name]
                mean, apart = (told[f"{word}_of_pad_{a}_and_pad_{b}_{name}"] for word in ("mean", "difference"))
                assert (mean, apart) == pytest.approx(((one + other) / 2, one - other), rel=1e-7, abs=1e-7)
    assert len(told) == len(names) * (pads + pads * (pads - 1))
    assert loading.clock == ("seconds" if timed else "frames")
    quiet = [f"pad_{k}" for k, t in enumerate(touched) if not t]
    assert any("not touched" in remark for remark in loading.remarks) == bool(quiet)
    if quiet:
        assert loading.remarks[-1] == f"not touched: {', '.join(quiet)}"


@given(st.integers(0, 2**31), st.floats(0.01, 1.0))
@settings(max_examples=25)
def test_a_span_is_as_if_the_recording_had_ended(seed, span):
    rng = np.random.default_rng(seed)
    frames, time = drawn(rng, 20, 2, 4, 5)
    cut = loading_features(frames, time, floor=0.0, span=span, times=[0.02])
    heights = [np.maximum(frames[:, k], 0) for k in range(2)]
    loads = [h.sum(axis=(1, 2)).max() for h in heights]
    start = min(onset_of(h, time) for h, load in zip(heights, loads, strict=True) if load >= 0.02 * max(loads))
    kept = time <= start + span
    stop = max(int(kept.sum()), 1)
    expected = loading_features(frames[:stop], time[:stop], floor=0.0, times=[0.02])
    np.testing.assert_allclose(cut.values, expected.values, rtol=1e-9, atol=1e-9)


def test_a_rise_and_a_fall_by_hand():
    """One taxel that rises by 1 a second to 4, stays for two seconds and falls by 2 a second."""
    load = np.array([0, 0, 1, 2, 3, 4, 4, 4, 2, 0], float)
    loading = loading_features(load[:, None, None], np.arange(10.0), floor=0.0, bands=0, times=[1.0, 2.5], pairs=False)
    told = {name.removeprefix("pad_0_"): loading[name] for name in loading.names}
    # It is touched at 2 % of the largest load, .08 s after it begins to rise at 1 s.
    assert told["time_to_0.5_of_load"] == pytest.approx(2 - 0.08)
    assert told["time_to_1_of_load"] == pytest.approx(4 - 0.08)
    assert told["load_at_time_0"] == pytest.approx(1.08)
    assert told["share_of_load_at_time_1"] == pytest.approx(2.58 / 4)
    assert told["dwell"] == pytest.approx(7 - 4.6)
    # Half the load is met at 8 s and no less: it is let go of when it falls below.
    assert told["let_go"] == 1
    assert told["fall_time"] == pytest.approx(8 - 7)
    assert told["creep"] == pytest.approx(1 / 4)
    assert told["unsteadiness"] == told["largest_drop"] == 0
    assert told["area_at_0.5_of_load"] == 1
    # A drop on the way up counts; one after the top does not.
    load[4] = 1.5
    dropped = loading_features(load[:, None, None], np.arange(10.0), floor=0.0, bands=0)
    assert dropped["pad_0_largest_drop"] == pytest.approx(0.5 / 4)
    assert dropped["pad_0_unsteadiness"] == pytest.approx((1.5 + 3.0) / 2 / 4)


def test_bands_tell_which_way_the_contact_spreads():
    frames = np.zeros((8, 4, 6))
    for k in range(8):
        frames[k, :, : max(0, min(k - 1, 6))] = 1.0
    loading = loading_features(frames, np.arange(8.0), floor=0.0, bands=3)
    columns = [loading[f"pad_0_columns_{k}_onset_lag"] for k in range(3)]
    rows = [loading[f"pad_0_rows_{k}_onset_lag"] for k in range(3)]
    # Two columns a band, one a second; touched means 2 % of the largest load, .48: .12 s of a column of 4 taxels.
    assert columns == pytest.approx([0, 2, 4], abs=1e-9)
    # All rows grow at once, by a taxel a second each: a row alone is touched after .48 s, two rows after .24 s.
    assert rows == pytest.approx([0.36, 0.36, 0.12], abs=1e-9)
    assert "pad_0_rows_0_onset_lag" not in loading_features(frames, floor=0.0, bands=0).names


def test_a_recording_and_its_frames_are_measured_alike():
    rng = np.random.default_rng(2)
    frames, time = drawn(rng, 15, 2, 4, 5)
    field = np.ones((2, 4, 5), bool)
    field[1, 0] = False
    frames[:, 1] = 0.7 * frames[:, 0]
    recording = Recording({"a": Pad(frames[:, 0], field=field[0]), "b": Pad(frames[:, 1], field=field[1])}, time)
    one, other = loading_features(recording), loading_features(frames, time, field=field)
    np.testing.assert_array_equal(one.values, other.values)
    assert [name.replace("pad_0", "a").replace("pad_1", "b") for name in other.names] == list(one.names)
    # The standard plane is four sigma of each pad's own noise.
    pads = list(recording.pads.values())
    apart = [loading_features(Recording({"a": pad}, time), floor=grasp_floor([pad])) for pad in pads]
    assert one["a_largest_load"] == apart[0]["a_largest_load"]
    assert one["b_largest_load"] == apart[1]["a_largest_load"]
    assert grasp_floor(pads) == pytest.approx(np.mean([grasp_floor([pad]) for pad in pads]))
    later = as_grasp(recording, time + 1.0)
    np.testing.assert_array_equal(later.time_s, time + 1)


def test_a_broken_taxel_is_left_out():
    frames = np.ones((4, 3, 3)) * np.arange(4)[:, None, None]
    valid = np.ones((3, 3), bool)
    valid[1, 1] = False
    hurt = frames.copy()
    hurt[:, 1, 1] = 1e6
    loading = loading_features(Recording({"a": Pad(hurt, valid=valid)}), floor=0.5)
    assert loading["a_largest_load"] == pytest.approx(8 * 2.5)
    assert loading["a_area_at_1_of_load"] == 8


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"bands": -1}, "bands must be"),
        ({"bands": True}, "bands must be"),
        ({"bands": 2.0}, "bands must be"),
        ({"span": 0}, "span must be a finite number, above 0"),
        ({"span": -1.0}, "span must be"),
        ({"span": np.inf}, "span must be"),
        ({"span": True}, "span must be"),
        ({"floor": -0.1}, "floor must be a finite number, not negative"),
        ({"floor": "low"}, "floor must be"),
        ({"times": [-1.0]}, "times must be one row"),
        ({"times": [[1.0]]}, "times must be one row"),
        ({"times": [np.nan]}, "times must be one row"),
        ({"times": "soon"}, "times must be numbers"),
        ({"field": np.ones((2, 2), bool)}, "field must have shape"),
        ({"field": [[True], [True, False]]}, "field must have shape .*, got rows of different lengths"),
        ({"time_s": [0.0, [1.0, 2.0]]}, "time_s must be one number a frame, got rows of different lengths"),
        ({"time_s": [0.0, 2.0, 1.0, 3.0]}, "time_s"),
    ],
)
def test_what_cannot_be_is_refused(options, words):
    with pytest.raises(InputError, match=words):
        loading_features(np.ones((4, 3, 3)), **options)


@pytest.mark.parametrize("options", [{"bands": 0}, {"bands": np.int64(2)}, {"span": 1}, {"floor": 0}, {"times": [0.0]}])
def test_what_just_can_be_is_taken(options):
    assert np.isfinite(loading_features(np.ones((4, 3, 3)), **options).values).all()


def rising(rise, n=30, lag=2):
    load = np.clip((np.arange(n) - lag) / rise, 0, 1)
    return load[:, None, None, None] * np.array([1.0, 1.0])[:, None, None] * np.ones((2, 3, 3))


def test_moments_are_set_by_the_median_rise():
    grasps = [(rising(r), 0.1 * np.arange(30)) for r in (5, 10, 20)]
    learned = LoadingFeatures(floor=0.0, times=5).fit(grasps)
    # From 2 to 95 % of a rise of one second.
    rise = 1.0 * (0.95 - 0.02)
    assert learned.times_[[0, -1]] == pytest.approx([rise / 25, 1.25 * rise])
    np.testing.assert_allclose(np.diff(np.log(learned.times_)), np.log(31.25) / 4)
    assert learned.clock_ == "seconds"
    assert learned.floor_ == 0.0
    values = learned.transform(grasps)
    assert values.shape == (3, len(learned.names_))
    for row, (frames, time) in zip(values, grasps, strict=True):
        told = loading_features(frames, time, floor=0.0, times=learned.times_)
        np.testing.assert_array_equal(row, told.values)
        assert told.names == learned.names_
    assert LoadingFeatures(floor=0.0, times=0).fit(grasps).times_.shape == (0,)
    assert list(LoadingFeatures(floor=0.0, times=[0.2, 0.4]).fit(grasps).times_) == [0.2, 0.4]
    # Where nothing rises the moments are set by one unit of the clock.
    still = LoadingFeatures(floor=0.0, times=2).fit([np.zeros((5, 1, 3, 3))])
    assert still.times_ == pytest.approx([1 / 25, 1.25])
    assert still.clock_ == "frames"


def test_a_floor_is_learned_as_the_median_of_grasps():
    rng = np.random.default_rng(0)
    grasps = [rising(10) + s * rng.normal(size=(30, 2, 3, 3)) for s in (0.001, 0.01, 0.1)]
    learned = LoadingFeatures().fit(grasps)
    floors = sorted(grasp_floor(list(as_grasp(g).pads.values())) for g in grasps)
    assert learned.floor_ == pytest.approx(floors[1])


def test_grasps_that_do_not_belong_together_are_told():
    timed, plain = (rising(5), 0.1 * np.arange(30)), rising(5)
    learned = LoadingFeatures(floor=0.0).fit([timed])
    with pytest.raises(InputError, match="grasp 1 has times in frames, the grasps of fit in seconds"):
        learned.transform([timed, plain])
    with pytest.raises(InputError, match="grasp 0 has the pads pad_0, those of fit were pad_0, pad_1"):
        learned.transform([(rising(5)[:, :1], 0.1 * np.arange(30))])
    with pytest.raises(InputError, match="grasp 1: "):
        learned.transform([timed, (rising(5), np.arange(3.0))])
    with pytest.raises(InputError, match=r"grasp 0: .*backward"):
        learned.transform([(rising(5), -np.arange(30.0))])
    with pytest.raises(InputError, match="times must be a whole number, at least 0, or the moments, got -1"):
        LoadingFeatures(floor=0.0, times=-1).fit([timed])
    with pytest.raises(InputError, match="at least one grasp"):
        LoadingFeatures().fit([])
    for wrong in (5, Recording({"a": Pad(np.ones((3, 2, 2)))})):
        with pytest.raises(InputError, match="must be a sequence of recordings"):
            learned.transform(wrong)
    assert learned.transform([]).shape == (0, len(learned.names_))
