"""What is measured of a frame's sections together, number by number, from the contacts one by one."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.exceptions import NotFittedError

from varishold.errors import InputError
from varishold.frame import frame_noise
from varishold.touch import SurfaceFeatures, find_contacts


def drawn(rng, n, rows, cols, spots=3):
    y, x = np.ogrid[:rows, :cols]
    frames = np.zeros((n, rows, cols))
    for i in range(n):
        for _ in range(rng.integers(0, spots + 1)):
            cy, cx, r = rng.uniform(0, rows), rng.uniform(0, cols), rng.uniform(1, 4)
            frames[i] = np.maximum(
                frames[i], rng.uniform(1, 9) * np.maximum(1 - np.hypot((x - cx) / r, (y - cy) / 2), 0)
            )
    return frames + rng.uniform(0, 0.01, frames.shape)


def joined(contacts, k):
    """Measure a frame's sections at one threshold together; a contact that has ended keeps its last section."""
    area = perimeter = 0.0
    first, second = np.zeros(2), np.zeros((2, 2))
    for contact in contacts:
        p = contact.profile
        known = [j for j in range(k + 1) if not math.isnan(p.area[j])]
        if not known or not p.area[known[-1]] > 0:
            continue
        j = known[-1]
        area += p.area[j]
        perimeter += p.perimeter[j]
        first += p.area[j] * p.centroid[j]
        second += p.area[j] * (p.covariance[j] + np.outer(p.centroid[j], p.centroid[j]))
    if area == 0:
        return [0.0] * 9
    middle = first / area
    c = second / area - np.outer(middle, middle)
    short, long = np.sqrt(np.maximum(np.linalg.eigvalsh(c), 0))
    return [area, perimeter, *middle, c[0, 0], c[0, 1], c[1, 1], 4 * long, 4 * short]


MEASURES = ("area", "perimeter", "x", "y", "variance_x", "covariance_xy", "variance_y", "length", "breadth")


@given(st.integers(0, 2**31), st.sampled_from([(12, 10), (7, 16)]), st.integers(0, 4), st.integers(0, 3), st.booleans())
@settings(max_examples=30)
def test_every_number_is_that_of_the_contacts_together(seed, shape, levels, relative, gap):
    if levels + relative == 0:
        levels = 1
    rng = np.random.default_rng(seed)
    frames = drawn(rng, 6, *shape)
    field = np.ones(shape, bool)
    if gap:
        field[2:4, 3:6] = False
    features = SurfaceFeatures(levels=levels, relative_levels=relative, floor=0.05, field=field).fit(frames)
    above = frames[:, field][frames[:, field] > 0.05]
    shares = [(levels - k - 0.5) / levels for k in range(levels)]
    np.testing.assert_allclose(features.levels_, np.quantile(above, shares) if len(above) else 0.05 + np.array(shares))
    told = dict(zip(features.get_feature_names_out(), features.transform(frames).T, strict=True))
    for i, frame in enumerate(frames):
        peak = frame[field].max()
        own = [0.05 + (peak - 0.05) * (relative - k - 0.5) / relative for k in range(relative)]
        thresholds = [*features.levels_, *own]
        names = [f"level_{k + 1}" for k in range(levels)]
        names += [f"{(relative - k - 0.5) / relative:.3g}_of_peak" for k in range(relative)]
        falling = sorted(thresholds, reverse=True)
        mask = None if field.all() else field
        contacts = find_contacts(frame, np.array(falling), field=mask, floor=0.05) if peak > 0.05 else []
        areas = {}
        for name, theta in zip(names, thresholds, strict=True):
            expected = joined(contacts, falling.index(theta))
            areas[name] = expected[0]
            for measure, value in zip(MEASURES, expected, strict=True):
                assert told[f"{measure}_above_{name}"][i] == pytest.approx(value, rel=1e-6, abs=1e-5), (measure, name)
        for some in (names[:levels], names[levels:]):
            for a, b in itertools.pairwise(some):
                word = f"growth_from_{a.removesuffix('_of_peak')}_to_{b.removeprefix('level_')}"
                assert told[word][i] == pytest.approx(areas[a] / areas[b] if areas[b] > 0 else 0.0, rel=1e-6)
        height = np.maximum(np.where(field, frame, 0.0) - 0.05, 0)
        assert told["total"][i] == pytest.approx(height.sum())
        assert told["peak"][i] == pytest.approx(height.max())
        assert told["touched_area"][i] == (height > 0).sum()
        assert told["contacts"][i] == len(contacts)
        y, x = np.mgrid[: shape[0], : shape[1]]
        total = height.sum()
        for word, at, n in (("x", x, shape[1]), ("y", y, shape[0])):
            middle = (height * at).sum() / total - (n - 1) / 2 if total > 0 else 0.0
            assert told[word][i] == pytest.approx(middle, abs=1e-9)


def test_a_floor_is_four_sigma_of_the_middle_frame():
    rng = np.random.default_rng(1)
    frames = np.stack([s * rng.normal(size=(12, 12)) for s in (0.1, 0.2, 0.4)])
    features = SurfaceFeatures().fit(frames)
    assert features.floor_ == pytest.approx(4 * sorted(frame_noise(f) for f in frames)[1])
    # Of very many frames 500 are asked, from the first to the last.
    many = np.concatenate([np.repeat(frames[:1], 700, axis=0), np.repeat(frames[2:], 301, axis=0)])
    assert SurfaceFeatures(levels=1, relative_levels=0).fit(many).floor_ == pytest.approx(4 * frame_noise(frames[0]))
    pads = np.stack([frames[[0, 0, 0]], frames[[2, 2, 2]]], axis=1)
    field = np.ones((2, 12, 12), bool)
    field[1, :2] = False
    told = SurfaceFeatures(field=field).fit(pads).floor_
    alone = [frame_noise(frames[0]), frame_noise(frames[2], field[1])]
    assert told == pytest.approx(4 * np.median(alone * 3))


def test_pads_have_their_own_fields():
    rng = np.random.default_rng(2)
    frames = drawn(rng, 4, 10, 9)
    pads = np.stack([frames, frames], axis=1)
    field = np.ones((2, 10, 9), bool)
    field[1, :, 4:] = False
    features = SurfaceFeatures(field=field, floor=0.05, levels=3, relative_levels=2).fit(pads)
    told = features.transform(pads)
    half = told.shape[1] // 2
    names = features.get_feature_names_out()
    assert [n.removeprefix("pad_0_") for n in names[:half]] == [n.removeprefix("pad_1_") for n in names[half:]]
    for k in range(2):
        alone = SurfaceFeatures(field=field[k], floor=0.05, levels=3, relative_levels=2).fit(pads[:, k])
        alone.levels_ = features.levels_
        np.testing.assert_allclose(told[:, k * half : (k + 1) * half], alone.transform(pads[:, k]))
    # One field for all pads is each pad's.
    both = SurfaceFeatures(field=field[1], floor=0.05).fit(pads).transform(pads)
    np.testing.assert_array_equal(both[:, : both.shape[1] // 2], both[:, both.shape[1] // 2 :])
    nothing = SurfaceFeatures(field=np.zeros((10, 9), bool), floor=0.05).fit(frames)
    assert not nothing.transform(frames).any()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"levels": True}, "levels must be a whole number"),
        ({"relative_levels": -1}, "relative_levels must be a whole number, at least 0, got -1"),
        ({"levels": 0, "relative_levels": 0}, "are both 0"),
        ({"shape": (12,)}, "shape must be"),
        ({"shape": (1, 2, 3, 2)}, "shape must be"),
        ({"shape": (0, 12)}, "shape must be"),
        ({"shape": (4, 4)}, "needs 16 values a sample, got 12"),
        ({"floor": -1.0}, "floor"),
        ({"field": np.ones((3, 5), bool)}, "field"),
    ],
)
def test_options_that_cannot_be_are_refused(options, words):
    with pytest.raises(InputError, match=words):
        SurfaceFeatures(**options).fit(np.random.default_rng(0).random((5, 12)))


def test_options_that_just_can_be_are_taken():
    flat = np.random.default_rng(0).random((5, 12))
    for options in ({"levels": 0}, {"relative_levels": 0}, {"shape": (1, 12)}, {"shape": (1, 12, 1)}, {"floor": 0}):
        assert np.isfinite(SurfaceFeatures(**options).fit_transform(flat)).all()
    assert SurfaceFeatures(shape=(2, 2, 3)).fit(flat).shape_ == (2, 2, 3)
    assert SurfaceFeatures(levels=np.int64(2)).fit(flat).levels_.shape == (2,)
    with pytest.raises(InputError, match=r"frames must have shape \(3, 4\), as `shape` says, got \(4, 3\)"):
        SurfaceFeatures(shape=(3, 4)).fit(flat.reshape(5, 4, 3))
    fitted = SurfaceFeatures().fit(flat.reshape(5, 3, 4))
    with pytest.raises(InputError, match=r"the shape that fit saw, \(3, 4\), got \(4, 3\)"):
        fitted.transform(flat.reshape(5, 4, 3))
    with pytest.raises(InputError, match=r"number of features \(12\), got 2"):
        fitted.get_feature_names_out(["a", "b"])
    assert len(fitted.get_feature_names_out([f"x{k}" for k in range(12)])) == fitted.transform(flat).shape[1]
    # Where nothing stands above the floor, levels are set all the same.
    still = SurfaceFeatures(levels=2, floor=5.0).fit(flat)
    np.testing.assert_allclose(still.levels_, [5.75, 5.25])


def test_before_a_fit_nothing_can_be_asked():
    for asked in (lambda f: f.transform(np.ones((2, 3, 4))), lambda f: f.get_feature_names_out()):
        with pytest.raises(NotFittedError):
            asked(SurfaceFeatures())
