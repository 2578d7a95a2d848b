"""Laws of SurfaceFeatures on presses, of its tables and of its threads."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.utils.estimator_checks import parametrize_with_checks

from varishold import Pad, Recording
from varishold.errors import InputError, MissingExtraError
from varishold.frame import recording_noise
from varishold.touch import SurfaceFeatures
from varishold.touch.course.held import held_frames
from varishold.touch.course.presses import as_presses


@parametrize_with_checks(
    [SurfaceFeatures(per="press"), SurfaceFeatures(per="press", levels=3, relative_levels=2, floor=0.0, n_jobs=2)]
)
def test_keeps_the_estimator_contract(estimator: Any, check: Any) -> None:
    check(estimator)


def spot(x: float, y: float, breadth: float, shape: tuple[int, int] = (9, 11)) -> np.ndarray:
    v, u = np.indices(shape) - (np.array(shape)[:, None, None] - 1) / 2
    return np.exp(-((u - x) ** 2 + (v - y) ** 2) / breadth)


def press(rng: np.random.Generator, n_pads: int | None = None, shape: tuple[int, int] = (9, 11)) -> np.ndarray:
    """A press that starts unloaded, on one pad without an axis of pads, or on several."""
    rise = np.concatenate([[0, 0, 0], np.sort(rng.uniform(0.1, 1, rng.integers(3, 12))), [1, 0.9, 0.3]])
    pads = [rise[:, None, None] * 40 * spot(*rng.normal(0, 1, 2), rng.uniform(3, 9), shape) for _ in range(n_pads or 1)]
    frames = np.stack(pads, axis=1) + rng.normal(0, 0.3, (len(rise), len(pads), *shape)) + 5
    return frames if n_pads else frames[:, 0]


@given(st.integers(0, 10**6), st.sampled_from([None, 2]), st.booleans())
@settings(max_examples=15)
def test_a_press_is_the_mean_of_its_held_frames(seed: int, n_pads: int | None, pairs: bool) -> None:
    rng = np.random.default_rng(seed)
    given_ = [press(rng, n_pads) for _ in range(5)]
    features = SurfaceFeatures(per="press", levels=4, relative_levels=3, pairs=pairs).fit(given_)
    presses = as_presses(given_)
    noise = [recording_noise(frames, one.fields[name]) for one in presses for name, frames in one.pads.items()]
    assert features.floor_ == pytest.approx(4 * np.median(noise))
    frames = []
    for one in presses:
        load = sum(np.maximum(of - features.floor_, 0).sum(axis=(1, 2)) for of in one.pads.values())
        held = held_frames(np.asarray(load))
        assert (load[held] >= 0.8 * load.max()).all()
        assert 1 <= len(held) <= 6
        frames.append(np.stack([of[held] for of in one.pads.values()], axis=1))
    # Learned and measured as frames, and pooled by hand.
    together = np.concatenate(frames)
    plain = SurfaceFeatures(levels=4, relative_levels=3, pairs=pairs, floor=features.floor_)
    plain.fit(together if n_pads else together[:, 0])
    np.testing.assert_allclose(features.levels_, plain.levels_)
    expected = [plain.transform(of if n_pads else of[:, 0]).mean(axis=0) for of in frames]
    np.testing.assert_allclose(features.transform(given_), expected, rtol=1e-9, atol=1e-9)
    assert features.get_feature_names_out().tolist() == plain.get_feature_names_out().tolist()
    assert features.shape_ == plain.shape_
    assert features.n_features_in_ == plain.n_features_in_


def test_presses_come_as_recordings_arrays_or_pairs() -> None:
    rng = np.random.default_rng(0)
    given_ = [press(rng)[:8] for _ in range(4)]
    fitted = SurfaceFeatures(per="press", levels=3).fit(given_)
    expected = fitted.transform(given_)
    np.testing.assert_array_equal(fitted.transform([(frames, 0.1 * np.arange(8)) for frames in given_]), expected)
    np.testing.assert_array_equal(fitted.transform(np.array(given_)), expected)
    np.testing.assert_array_equal(fitted.transform(as_presses(given_)), expected)
    # A table of flat presses of one frame each.
    one = np.array([frames[-1] for frames in given_])
    by_frame = SurfaceFeatures(per="press", levels=3).fit(one)
    flat = SurfaceFeatures((9, 11), per="press", levels=3).fit(one.reshape(4, -1))
    np.testing.assert_array_equal(flat.transform(one.reshape(4, -1)), by_frame.transform(one))
    assert flat.shape_ == by_frame.shape_ == (9, 11)
    assert SurfaceFeatures(per="press").fit(one.reshape(4, -1)).shape_ == (9, 11)


def test_pads_of_recordings_keep_their_names_and_their_fields() -> None:
    rng = np.random.default_rng(1)
    field = np.ones((9, 11), bool)
    field[:2, :3] = False

    def recording(frames: np.ndarray) -> Recording:
        return Recording({"left": Pad(frames[:, 0], field=field), "right": Pad(frames[:, 1])})

    given_ = [press(rng, 2) for _ in range(3)]
    features = SurfaceFeatures(per="press", levels=2, relative_levels=2, pairs=True).fit([*map(recording, given_)])
    assert features.pads_ == ("left", "right")
    names = features.get_feature_names_out().tolist()
    assert len(names) == len(set(names)) == features.transform([recording(given_[0])]).shape[1]
    assert names[0] == "pad_left_area_above_level_1"
    assert "difference_of_pads_left_and_right_total" in names
    other = given_[0].copy()
    other[:, 0, ~field] = 1e5
    np.testing.assert_array_equal(features.transform([recording(other)]), features.transform([recording(given_[0])]))
    # The order of the pads is that of the first press.
    swapped = Recording(dict(reversed(recording(given_[0]).pads.items())))
    np.testing.assert_array_equal(features.transform([swapped]), features.transform([recording(given_[0])]))
    said = SurfaceFeatures(per="press", field=np.ones((9, 11), bool)).fit([recording(given_[0])])
    assert said._field_.all()


@pytest.mark.parametrize("n_jobs", [2, -1])
@pytest.mark.parametrize("per", ["frame", "press"])
def test_threads_change_nothing(n_jobs: int, per: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.touch.features._TAXELS_AT_ONCE", 200)
    rng = np.random.default_rng(2)
    X = [press(rng, 2) for _ in range(9)] if per == "press" else rng.normal(0, 1, (40, 2, 6, 5)) ** 2
    alone = SurfaceFeatures(per=per, pairs=True).fit_transform(X)
    np.testing.assert_array_equal(SurfaceFeatures(per=per, pairs=True, n_jobs=n_jobs).fit_transform(X), alone)


def test_a_table_has_a_column_a_name(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    X = [press(rng) for _ in range(4)]
    features = SurfaceFeatures(per="press", levels=2, relative_levels=1).fit(X)
    table = features.table(X)
    assert list(table) == features.get_feature_names_out().tolist()
    np.testing.assert_array_equal(np.stack(list(table.values()), axis=1), features.transform(X))
    table.write_csv(tmp_path / "t.csv")
    with (tmp_path / "t.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["total"]) for row in rows] == table["total"].tolist()
    try:
        import pandas
    except ImportError:
        with pytest.raises(MissingExtraError, match="a DataFrame needs pandas"):
            table.to_pandas()
    else:
        assert isinstance(table.to_pandas(), pandas.DataFrame)


def test_what_cannot_be_is_told() -> None:
    rng = np.random.default_rng(4)
    X = [press(rng, 2), press(rng, 2)]
    with pytest.raises(InputError, match="per must be 'frame' or 'press', got 'grasp'"):
        SurfaceFeatures(per="grasp").fit(X)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="there is no press: give at least one"):
        SurfaceFeatures(per="press").fit(np.empty((0, 3, 4, 4)))
    uneven = Recording({"a": Pad(np.ones((4, 5, 5))), "b": Pad(np.ones((4, 5, 6)))})
    with pytest.raises(InputError, match="pads must be of one size, got a 5 x 5, b 5 x 6; measure each by itself"):
        SurfaceFeatures(per="press").fit([uneven])
    with pytest.raises(InputError, match="press 1: has the pads pad_0 9 x 11, wanted are pad_0 9 x 11, pad_1 9 x 11"):
        SurfaceFeatures(per="press").fit([X[0], X[1][:, 0]])
    fitted = SurfaceFeatures(per="press").fit(X)
    with pytest.raises(InputError, match="press 0: has the pads pad_0 4 x 4, wanted are pad_0 9 x 11, pad_1 9 x 11"):
        fitted.transform([np.ones((3, 4, 4))])
    with pytest.raises(InputError, match=r"frames must have shape \(2, 4, 4\), as `shape` says, got \(2, 9, 11\)"):
        SurfaceFeatures((2, 4, 4), per="press").fit(X)
