"""Laws of the classifier of presses."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.utils.estimator_checks import parametrize_with_checks

from varishold import Pad, Recording, TactileClassifier
from varishold.errors import InputError
from varishold.learning import LabelledPresses, labelled_presses, press_classifier
from varishold.solids import Cone, Pose, Sphere, SquarePillar, ideal_frame
from varishold.touch.course.presses import as_presses

SHAPE = (12, 14)
SOLIDS = {"cone": Cone(8.0, 4.0), "sphere": Sphere(9.0), "pillar": SquarePillar(6.0, 4.0)}


def press(name: str, rng: np.random.Generator, *, n_frames: int = 9) -> np.ndarray:
    """A ramp of a solid that lies anywhere near the middle, noise of one percent."""
    frame = ideal_frame(SOLIDS[name], SHAPE, 1.0, pose=Pose(*rng.uniform(-1, 1, 2)))
    ramp = np.concatenate([[0.0], np.sin(np.linspace(0.15, 0.5 * np.pi, n_frames - 2)), [0.3]])
    return 100 * rng.uniform(0.8, 1.2) * (ramp[:, None, None] * frame / 4 + rng.normal(0, 0.01, (n_frames, *SHAPE)))


def presses(seed: int, each: int = 8) -> tuple[list[np.ndarray], np.ndarray]:
    rng = np.random.default_rng(seed)
    labels = np.tile(list(SOLIDS), each)
    return [press(name, rng, n_frames=int(rng.integers(7, 12))) for name in labels], labels


@pytest.fixture(scope="module")
def fitted() -> TactileClassifier:
    return TactileClassifier().fit(*presses(0))


@parametrize_with_checks(
    [TactileClassifier(folds=2), TactileClassifier(position=True, absolute=True, drift=0, folds=2)]
)
@pytest.mark.filterwarnings("ignore")
def test_scikit_learn_contract(estimator: Any, check: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    # One copy under drift instead of five: the contract is the same, and most of the time goes into copies.
    monkeypatch.setattr(press_classifier, "COPIES", 1)
    check(estimator)


def test_presses_of_any_length_are_told(fitted: TactileClassifier) -> None:
    X, y = presses(1)
    assert fitted.score(X, y) > 0.95
    p = fitted.predict_proba(X)
    np.testing.assert_allclose(p.sum(axis=1), 1.0)
    assert p.shape == (len(X), 3)


def test_the_same_presses_as_arrays_recordings_and_pairs_are_the_same(fitted: TactileClassifier) -> None:
    X, _ = presses(2, each=1)
    plain = fitted.predict_proba(X)
    as_recordings = [Recording({"pad_0": Pad(frames)}) for frames in X]
    np.testing.assert_array_equal(fitted.predict_proba(as_recordings), plain)
    np.testing.assert_array_equal(fitted.predict_proba([frames[:, None] for frames in X]), plain)


def test_arrays_of_one_frame_of_frames_and_of_pads() -> None:
    X, y = presses(3)
    same = np.stack([frames[:6] for frames in X])
    for given in (same[:, 5], same, np.stack([same, same[:, ::-1]], axis=2)):
        assert TactileClassifier().fit(given, y).score(given, y) > 0.9


def test_neither_place_nor_mirror_nor_load_nor_time_after_the_peak_changes_an_answer(fitted: TactileClassifier) -> None:
    X, _ = presses(4, each=2)
    X = [np.clip(np.round(frames), 3, None) - 3 for frames in X]
    plain = fitted.predict_proba(X)
    longer = [np.concatenate([frames, 0.3 * frames[-2:-1], 0 * frames[:3]]) for frames in X]
    for same in ([frames[:, ::-1] for frames in X], [frames[:, :, ::-1] for frames in X], longer):
        np.testing.assert_allclose(fitted.predict_proba(same), plain, atol=1e-6)
    padded = [np.pad(frames, ((0, 0), (4, 4), (4, 4))) for frames in X]
    moved = [np.roll(frames, (3, -2), axis=(1, 2)) for frames in padded]
    other = TactileClassifier().fit(padded, np.tile(list(SOLIDS), 2))
    np.testing.assert_allclose(other.predict_proba(moved), other.predict_proba(padded), atol=1e-6)


def test_names_of_classes_and_their_order_change_nothing() -> None:
    X, y = presses(5)
    new = {"cone": "z", "sphere": "a", "pillar": "m"}
    one = TactileClassifier().fit(X, y)
    other = TactileClassifier().fit(X, [new[name] for name in y])
    order = [list(other.classes_).index(new[name]) for name in one.classes_]
    np.testing.assert_allclose(other.predict_proba(X)[:, order], one.predict_proba(X), atol=1e-9)


def test_sessions_that_change_places_in_the_list_change_nothing() -> None:
    X, y = presses(6)
    session = np.repeat([0, 1, 2, 3], 6)
    one = TactileClassifier().fit(X, y, session)
    order = np.random.default_rng(0).permutation(len(y))
    other = TactileClassifier().fit([X[k] for k in order], y[order], session[order])
    np.testing.assert_allclose(other.predict_proba(X), one.predict_proba(X), atol=1e-3)
    assert not any("session" in remark for remark in one.remarks_)


def test_what_was_never_learned_is_refused_and_known_things_hardly_are(fitted: TactileClassifier) -> None:
    X, _ = presses(7, each=40)
    assert fitted.refused(X).mean() < 0.15
    rng = np.random.default_rng(8)
    strange = [np.abs(rng.normal(0, 50, (8, *SHAPE))) * np.linspace(0, 1, 8)[:, None, None] for _ in range(20)]
    assert fitted.refused(strange).mean() > 0.9
    assert fitted.predict_proba(strange).max() < 0.9


def test_an_explanation_names_measures_and_the_nearest_press(fitted: TactileClassifier) -> None:
    X, y = presses(0)
    for found, truth in zip(fitted.explain(X[:6]), y, strict=False):
        assert found.label == truth == found.nearest_label
        assert found.nearest.startswith("press ")
        assert found.measures[0][1] >= found.measures[-1][1]
        assert found.probability + sum(found.alternatives.values()) <= 1 + 1e-9
        assert found.refused == (found.p_value <= fitted.error)


def test_dead_taxels_and_missing_pads_are_ordinary() -> None:
    X, y = presses(9)
    both = [np.stack([frames, frames[:, ::-1, ::-1]], axis=1) for frames in X]
    clf = TactileClassifier().fit(both, y)
    dead = [frames.astype(float) for frames in both]
    for frames in dead:
        frames[:, 0, 2, 3] = np.nan
    assert clf.score(dead, y) > 0.9
    one_pad = [frames[:, :1] for frames in both]
    assert clf.score(one_pad, y) > 0.6


def test_angles_are_learned_beside_touch() -> None:
    X, _ = presses(10)
    rng = np.random.default_rng(0)
    y = rng.permutation(np.repeat(["near", "far"], 12))
    given = [
        Recording(
            {"pad_0": Pad(frames)},
            press=np.zeros(len(frames), int),
            press_columns={"angle_rad.finger": np.array([(0.5 if name == "near" else 1.5) + rng.normal(0, 0.1)])},
        )
        for frames, name in zip(X, y, strict=True)
    ]
    clf = TactileClassifier().fit(given, y)
    assert clf.columns_ == ("angle_rad.finger",)
    assert clf.score(given, y) > 0.95
    assert clf.explain(given[:1])[0].measures[0][0] == "angle_rad.finger"


def test_a_press_without_numbers_is_answered_from_touch() -> None:
    X, y = presses(21)
    rng = np.random.default_rng(21)
    angles = np.where(y == "cone", 0.2, 0.6) + rng.normal(0, 0.02, len(y))
    with_numbers = [replace(p, columns={"angle_rad.finger": a}) for p, a in zip(as_presses(X), angles, strict=True)]
    clf = TactileClassifier().fit(with_numbers, y)
    touch_alone = TactileClassifier().fit(X, y)
    new, truth = presses(22)
    assert clf.score(new, truth) > 0.95
    np.testing.assert_allclose(
        clf.predict_proba(new).argmax(axis=1), touch_alone.predict_proba(new).argmax(axis=1), atol=0
    )
    assert all("angle" not in name for found in clf.explain(new) for name, _ in found.measures)


def test_a_class_is_added_without_learning_the_rest_again() -> None:
    X, y = presses(11)
    two = y != "pillar"
    clf = TactileClassifier().fit([x for x, keep in zip(X, two, strict=True) if keep], y[two])
    trust = clf.learned_.trust
    clf.add("pillar", [x for x, keep in zip(X, two, strict=True) if not keep])
    assert clf.classes_.tolist() == ["cone", "pillar", "sphere"]
    assert clf.learned_.trust == trust
    assert clf.score(*presses(12)) > 0.9
    with pytest.raises(InputError, match="'cone' is known already"):
        clf.add("cone", X[:2])
    with pytest.raises(InputError, match="'new' has one press only"):
        clf.add("new", X[:1])


def test_what_cannot_be_learned_is_told_in_one_line() -> None:
    X, y = presses(13, each=2)
    for labels, groups, message in (
        (["cone"] * 6, None, "y must hold at least two classes to tell apart, got 1 class: 'cone'"),
        ([*"aabbbc"], None, "'c' has one press only: give each class at least two"),
        (y, y, "groups are the labels themselves"),
        (y[:5], None, "y must be one label a press, 6 of them"),
    ):
        with pytest.raises(InputError, match=message):
            TactileClassifier().fit(X, labels, groups)
    with pytest.raises(InputError, match="error must lie between 0 and 1, got 2"):
        TactileClassifier(error=2).fit(X, y)
    with pytest.raises(InputError, match="drift must be at least 0 and below 1, got 1"):
        TactileClassifier(drift=1).fit(X, y)
    with pytest.raises(InputError, match="folds must be a whole number, at least 2, got 1"):
        TactileClassifier(folds=1).fit(X, y)
    with pytest.raises(InputError, match="press 1: frames must be numbers"):
        TactileClassifier().fit([X[0], np.array([["a"]])], ["a", "b"])
    with pytest.raises(InputError, match="presses must be a sequence"):
        TactileClassifier().fit(Recording({"pad": Pad(X[0])}), y)
    with pytest.raises(InputError, match="press 0: smaller readings mean more pressure here; give a sensor file"):
        TactileClassifier().fit([Recording({"pad": Pad(X[0], polarity="down")})] * 6, y)


def test_another_sensor_is_refused(fitted: TactileClassifier) -> None:
    with pytest.raises(InputError, match=r"press 0: has a pad 'pad_0' of 5 x 5 taxels; the model is of another sensor"):
        fitted.predict(np.ones((1, 4, 5, 5)))


def test_few_presses_refuse_nothing_and_say_so() -> None:
    X, y = presses(14, each=2)
    assert "6 presses are too few to refuse anything at an error of 0.05: give 19 or more" in (
        TactileClassifier().fit(X, y).remarks_
    )


def _recording(source: str, **columns: Any) -> Recording:
    X, _ = presses(15, each=1)
    frames = np.concatenate(X)
    number = np.repeat(np.arange(3), [len(x) for x in X])
    return Recording(
        {"pad": Pad(frames)}, source=source, press=number, press_columns={k: np.array(v) for k, v in columns.items()}
    )


def test_labels_come_from_columns_and_folders() -> None:
    one = _recording("/data/monday/a.npz", thing=["cup", "can", "cup"])
    two = _recording("/data/tuesday/a.npz", thing=["can", "can", "cup"])
    found = labelled_presses([one, two], label="thing", group="folder")
    assert isinstance(found, LabelledPresses)
    assert found.labels.tolist() == ["cup", "can", "cup", "can", "can", "cup"]
    assert found.groups is not None
    assert found.groups.tolist() == ["monday"] * 3 + ["tuesday"] * 3
    assert found.presses[4].place == "/data/tuesday/a.npz, press 1"
    assert labelled_presses([one], label="folder").groups is None


def test_where_press_names_none_that_is_what_is_told() -> None:
    none = Recording({"pad": Pad(np.arange(75).reshape(3, 5, 5))}, source="c.npz", press=np.full(3, -1))
    with pytest.raises(InputError, match=r"^c\.npz: no press found: press names none, it is -1 in every frame$"):
        labelled_presses([none], label="folder")


def test_labels_tell_what_is_missing() -> None:
    one = _recording("a.npz", thing=["cup", " ", "cup"])
    with pytest.raises(InputError, match=r"a.npz: presses have no column 'object', known are: thing") as told:
        labelled_presses([one], label="object")
    assert told.value.parameter == "label"
    with pytest.raises(InputError, match=r"a.npz: press 1 has no thing; fill it in, or leave the press out"):
        labelled_presses([one], label="thing")
    other = Recording({"pad": Pad(np.arange(75).reshape(3, 5, 5))}, source="b.npz", press=np.zeros(3, int))
    with pytest.raises(InputError, match=r"b.npz, press 0: has the pads pad 5 x 5, those before it pad 12 x 14"):
        labelled_presses([_recording("a.npz"), other], label="folder")


def test_it_can_be_cloned_with_its_options() -> None:
    options = {"position": True, "absolute": False, "error": 0.1, "drift": 0.2, "folds": 3, "shape": (2, 3)}
    assert clone(TactileClassifier(**options)).get_params() == options
