"""What the classifier learns from and what it says, by hand: copies, settings, belief, reasons, remarks, labels."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from varishold import Pad, Recording, TactileClassifier, evaluate
from varishold.errors import InputError
from varishold.learning import Recognition, classifier, labelled_presses
from varishold.learning.explanation import deciding_measures, nearest_landmark
from varishold.touch.course.measures import learn_settings, measure_presses
from varishold.touch.course.presses import Press, as_presses, drifted
from varishold.trust import conformal_p_value, group_folds

SHAPE = (5, 6)
FIELD = np.ones(SHAPE, bool)


def press(kind: int, rng: np.random.Generator, pads: tuple[str, ...] = ("pad",), **columns: float) -> Press:
    """A spot, a bar or a ring of a few frames."""
    y, x = np.indices(SHAPE) - np.array([2.0, 2.5])[:, None, None] - rng.normal(0, 0.2, (2, 1, 1))
    form = [np.exp(-(x * x + y * y) / 2), np.exp(-y * y / 2), np.exp(-((np.hypot(x, y) - 2) ** 2))][kind]
    ramp = np.array([0.0, 0.5, 1.0])[:, None, None] * rng.uniform(0.8, 1.2) * 10
    frames = {name: ramp * form + rng.normal(0, 0.2, (3, *SHAPE)) for name in pads}
    return Press(frames, dict.fromkeys(pads, FIELD), columns=columns, place=f"press {rng.integers(1000)}")


def presses(seed: int, each: int = 6, n_classes: int = 3, **how: Any) -> tuple[list[Press], np.ndarray]:
    rng = np.random.default_rng(seed)
    kinds = np.tile(np.arange(n_classes), each)
    return [press(int(kind), rng, **how) for kind in kinds], np.array(["bar", "cup", "ring"])[kinds]


@pytest.fixture(scope="module")
def fitted() -> TactileClassifier:
    X, y = presses(0, each=7)
    return TactileClassifier(drift=0, error=0.2).fit(X, y)


def learning(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Note what every call of the learner is given and what it finds."""
    calls: list[dict[str, Any]] = []
    plain = classifier.learn

    def learn(measures: Any, codes: Any, n_classes: int, fold: Any, **how: Any) -> Any:
        found = plain(measures, codes, n_classes, fold, **how)
        calls.append({"measures": measures, "codes": codes, "n": n_classes, "fold": fold, **how, "found": found[0]})
        return found

    monkeypatch.setattr(classifier, "learn", learn)
    return calls


@pytest.mark.parametrize(
    ("position", "absolute", "elsewhere", "lighter"),
    [(False, False, 2, 0.4), (True, False, 0, 0.4), (False, True, 2, 0.0), (True, True, 0, 0.0)],
)
def test_five_drifted_copies_of_every_press_are_learned_and_asked(
    monkeypatch: pytest.MonkeyPatch, position: bool, absolute: bool, elsewhere: int, lighter: float
) -> None:
    X, y = presses(1, each=3)
    calls = learning(monkeypatch)
    clf = TactileClassifier(position=position, absolute=absolute, drift=0.07, folds=3).fit(X, y)
    # Where place or load are learned, forms are learned by themselves too.
    call, *of_forms = calls
    assert len(of_forms) == (position or absolute)
    s = learn_settings(X, position=position, absolute=absolute)
    copies = [drifted(X[k], 0.07, (c, k), elsewhere=elsewhere, lighter=lighter) for c in range(5) for k in range(9)]
    np.testing.assert_array_equal(call["measures"]["touch"], measure_presses([*X, *copies], s))
    assert list(call["measures"]) == ["touch"]
    assert (call["n"], clf.columns_) == (3, ())
    assert call["codes"].tolist() == [0, 1, 2] * 18
    assert call["fold"].tolist() == group_folds(y, folds=3).tolist() * 6
    assert call["asked"].tolist() == [False] * 9 + [True] * 45
    assert clf.places_.tolist() == [one.place for one in X] * 6
    assert (clf.settings_.position, clf.settings_.absolute) == (position, absolute)
    assert clf.n_features_in_ == 30


def test_with_sessions_presses_themselves_are_asked_and_the_best_of_four_ways_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    X, y = presses(2, each=4)
    session = np.repeat(["mo", "tu"], 6)
    calls = learning(monkeypatch)
    clf = TactileClassifier().fit(X, y, session)
    assert all(call["asked"].tolist() == [True] * 12 + [False] * 60 for call in calls)
    assert all(call["fold"].tolist() == ([0] * 6 + [1] * 6) * 6 for call in calls)
    losses = [call["found"].loss for call in calls]
    best = int(np.argmin(losses))
    assert clf.learned_ is calls[best]["found"]
    ways = [(True, True), (True, False), (False, True), (False, False)]
    assert (clf.settings_.position, clf.settings_.absolute) == ways[best]
    for call, (position, absolute) in zip(calls, ways, strict=True):
        s = learn_settings(X, position=position, absolute=absolute)
        np.testing.assert_array_equal(call["measures"]["touch"][:12], measure_presses(X, s))


def test_without_drift_there_are_no_copies_and_presses_are_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    X, y = presses(3, each=3)
    calls = learning(monkeypatch)
    for groups in (None, np.tile([0, 1, 2], 3)[np.argsort(np.tile([0, 1, 2], 3), kind="stable")]):
        TactileClassifier(drift=0, position=False, absolute=False).fit(X, y, groups)
    assert [call["asked"].tolist() for call in calls] == [[True] * 9] * 2
    assert [len(call["measures"]["touch"]) for call in calls] == [9, 9]


@pytest.mark.parametrize(("pads", "whether"), [(("pad",), False), (("a", "b"), True)])
def test_without_sessions_place_and_load_are_learned_of_a_hand_only(
    monkeypatch: pytest.MonkeyPatch, pads: tuple[str, ...], whether: bool
) -> None:
    X, y = presses(4, each=2, n_classes=2, pads=pads)
    calls = learning(monkeypatch)
    clf = TactileClassifier(drift=0).fit(X, y)
    assert (clf.settings_.position, clf.settings_.absolute) == (whether, whether)
    clf = TactileClassifier(drift=0, position=not whether).fit(X, y)
    assert (clf.settings_.position, clf.settings_.absolute) == (not whether, whether)
    assert len(calls) == 2


def test_numbers_beside_are_a_source_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(5)
    X = [press(k % 2, rng, **({"switch.b": float(k)} if k % 3 else {"angle_rad.a": 0.5})) for k in range(6)]
    calls = learning(monkeypatch)
    clf = TactileClassifier(drift=0).fit(X, [0, 1] * 3)
    assert clf.columns_ == ("angle_rad.a", "switch.b")
    nan = np.nan
    expected = [[0.5, nan], [nan, 1], [nan, 2], [0.5, nan], [nan, 4], [nan, 5]]
    np.testing.assert_array_equal(calls[0]["measures"]["numbers"], expected)
    assert list(clf.learned_.sources) == ["touch", "numbers"]


def test_an_answer_is_drawn_to_an_even_share_as_it_is_strange(fitted: TactileClassifier) -> None:
    X, _ = presses(6, each=4)
    rng = np.random.default_rng(6)
    X += [Press({"pad": rng.normal(0, s, (3, *SHAPE))}, {"pad": FIELD}) for s in (1, 5)]
    X[0].pads["pad"][2, :, 3:] *= 1.4
    learned = fitted.learned_
    said, strange = learned.judge(learned.scaled({"touch": measure_presses(X, fitted.settings_)}))
    p_values = np.array([(1 + (learned.known >= one).sum()) / (1 + len(learned.known)) for one in strange])
    np.testing.assert_allclose(fitted.p_values(X), p_values)
    # What is hardly less strange than what is refused promises as little as the least strange of that.
    shares = np.array([1.0 if p > 0.4 else 0.8 * min(p / 0.2, 1) ** 2 for p in p_values])[:, None]
    assert ((shares < 1) & (shares > 0)).any()
    expected = shares * np.exp(said) + (1 - shares) / 3
    np.testing.assert_allclose(fitted.predict_proba(X), expected)
    assert (expected.max(axis=1)[p_values <= 0.4] <= 0.9).all()
    assert fitted.predict(X).tolist() == fitted.classes_[expected.argmax(axis=1)].tolist()
    assert fitted.refused(X).tolist() == [p <= 0.2 for p in p_values]
    assert {True, False} == set(fitted.refused(X).tolist())


def test_both_are_judged_of_presses_that_are_measured_once(
    fitted: TactileClassifier, monkeypatch: pytest.MonkeyPatch
) -> None:
    X, _ = presses(6, each=2)
    apart = fitted.predict_proba(X), fitted.p_values(X)
    measured = []
    monkeypatch.setattr(
        classifier, "measure_presses", lambda some, of: measured.append(len(some)) or measure_presses(some, of)
    )
    for one, other in zip(fitted.judge(X), apart, strict=True):
        np.testing.assert_array_equal(one, other)
    assert measured == [len(X)]


def test_what_stands_at_the_stated_error_is_refused(fitted: TactileClassifier) -> None:
    X, _ = presses(7, each=2)
    p = float(fitted.p_values(X)[0])
    clf = fitted.adapt(presses(8)[0])
    clf.learned_, clf.adapted_to_ = fitted.learned_, 0
    clf.error = p
    assert clf.refused(X)[0]
    assert clf.explain(X)[0].refused


def test_an_explanation_by_hand(fitted: TactileClassifier) -> None:
    X, _ = presses(9, each=2)
    strange = Press({"pad": np.random.default_rng(9).normal(0, 5, (3, *SHAPE))}, {"pad": FIELD}, place="odd")
    X.append(strange)
    shares, p_values = fitted.predict_proba(X), fitted.p_values(X)
    learned = fitted.learned_
    for k, found in enumerate(fitted.explain(X)):
        scaled = learned.scaled({"touch": measure_presses(X[k : k + 1], fitted.settings_)})
        order = sorted(range(3), key=lambda j: -shares[k, j])
        assert (found.label, found.probability) == (fitted.classes_[order[0]], shares[k, order[0]])
        assert list(found.alternatives) == [fitted.classes_[j] for j in order[1:] if shares[k, j] >= 0.01]
        assert list(found.alternatives.values()) == [shares[k, j] for j in order[1:] if shares[k, j] >= 0.01]
        assert (found.p_value, found.refused) == (p_values[k], p_values[k] <= 0.2)
        reasons = deciding_measures(learned, scaled, {"touch": fitted.measure_names_}, order[0], order[1])
        assert found.measures == tuple(reasons[:5])
        assert len(found.measures) == 5
        near = nearest_landmark(learned.sources["touch"], scaled["touch"])
        assert (found.nearest, found.nearest_label) == (
            fitted.places_[near],
            fitted.classes_[learned.landmark_codes[near]],
        )
        assert (found.place, found.adapted_to) == (X[k].place, 0)
    assert found.place == "odd"


def test_what_json_holds_is_rounded() -> None:
    found = Recognition("a", 0.12345678, {1: 0.23456789, "c": 0.5}, 0.01234567, True, (("x", 1.23456),), "n", 2, "p")
    assert found.to_dict() == {
        "press": "p",
        "label": "a",
        "probability": 0.123457,
        "alternatives": {"1": 0.234568, "c": 0.5},
        "p_value": 0.012346,
        "refused": True,
        "reasons": [{"measure": "x", "nats": 1.235}],
        "nearest": {"press": "n", "label": "2"},
    }
    adapted = Recognition("a", 1.0, {}, 1.0, False, (), "n", "a", "p", 7)
    assert adapted.to_dict()["adapted_to"] == 7
    assert (adapted.to_dict()["refused"], adapted.to_dict()["reasons"]) == (False, [])


def test_remarks_tell_of_sessions_and_of_few_presses() -> None:
    X, y = presses(10, each=3, n_classes=2)
    held = "no session was held out, and on another day answers may be worse than they claim"
    few = "presses are too few to refuse anything at an error of"
    learn = TactileClassifier(drift=0, position=False, absolute=False)

    def remarks(groups: Any = None, **how: Any) -> tuple[str, ...]:
        *told, last = learn.set_params(**({"error": 0.05} | how)).fit(X, y, groups).remarks_
        assert last == "from 6 presses no answer has a p above .9: give 19 or more"
        return tuple(told)

    assert remarks(error=0.2) == (f"no sessions are known: {held}",)
    assert remarks([0, 0, 0, 1, 1, 1], error=0.2) == (f"no sessions are known: {held}",)[1:]
    # All of one thing is in one session.
    one = np.where(y == "bar", 0, np.arange(6) % 4)
    assert remarks(one, error=0.2) == (f"'bar' was felt in one session only: {held}",)
    assert remarks(["a"] * 6, error=0.2) == (f"all presses are of one session, 'a': {held}",)
    assert remarks()[1:] == (f"6 {few} 0.05: give 19 or more",)
    # Six are enough for an error of one in seven, and not for less.
    assert remarks(error=1 / 7) == (f"no sessions are known: {held}",)
    assert remarks(error=0.14)[1:] == (f"6 {few} 0.14: give 7 or more",)


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"error": 0}, "error must lie between 0 and 1, got 0"),
        ({"error": 1.0}, "error must lie between 0 and 1, got 1.0"),
        ({"drift": -0.1}, "drift must be at least 0 and below 1, got -0.1"),
        ({"drift": 1.0}, "drift must be at least 0 and below 1, got 1.0"),
        ({"folds": True}, "folds must be a whole number, at least 2, got True"),
        ({"folds": 2.0}, "folds must be a whole number, at least 2, got 2.0"),
        ({"position": "no"}, "position must be True, False or None, got 'no'"),
        ({"absolute": 0}, "absolute must be True, False or None, got 0"),
    ],
)
def test_options_have_their_limits(how: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as told:
        TactileClassifier(**how).fit(*presses(0, each=2))
    assert str(told.value) == message


@pytest.mark.parametrize("missing", [None, float("nan")])
def test_a_press_without_session_is_named(missing: Any) -> None:
    X, y = presses(0, each=2)
    groups = [*range(len(X) - 1), missing]
    with pytest.raises(InputError, match=f"press {len(X) - 1} has no group: name its session, or leave the groups out"):
        TactileClassifier().fit(X, y, groups)
    with pytest.raises(InputError, match=f"press {len(X) - 1} has no group; fill it in, or leave the press out"):
        evaluate(X, y, groups)
    named = np.array(["a"] * (len(X) // 2) + ["b"] * (len(X) // 2), dtype=object)
    learned = TactileClassifier(drift=0, position=False, absolute=False, error=0.4).fit(X, y, named)
    assert not any("session" in remark for remark in learned.remarks_)


def test_options_at_their_limits_are_taken() -> None:
    X, y = presses(11, each=2, n_classes=2)
    clf = TactileClassifier(error=0.9, drift=0, folds=np.int64(2)).fit(X, y)
    assert clf.score(X, y) == 1.0
    assert clf.adapted_to_ == 0


def test_pads_of_one_name_have_one_shape() -> None:
    X = [np.ones((2, *SHAPE)), np.ones((3, *SHAPE)), np.ones((2, 6, 6)), np.ones((2, *SHAPE))]
    with pytest.raises(InputError) as told:
        TactileClassifier().fit(X, [0, 1, 0, 1])
    assert str(told.value) == (
        "press 2: has the pads pad_0 6 x 6, those before it pad_0 5 x 6; give presses of one sensor"
    )


def test_presses_may_have_some_of_the_pads() -> None:
    rng = np.random.default_rng(12)
    X = [press(k % 2, rng, pads) for k, pads in enumerate([("a", "b"), ("a",), ("b",), ("b", "a")])]
    clf = TactileClassifier(drift=0).fit(X, [0, 1, 0, 1])
    assert list(clf.settings_.shapes) == ["a", "b"]
    with pytest.raises(
        InputError, match=r"has a pad 'c' of 5 x 6 taxels; the model is of another sensor: a 5 x 6, b 5"
    ):
        clf.predict([press(0, rng, ("a", "c"))])


def test_no_presses_are_told() -> None:
    clf = TactileClassifier(drift=0).fit(*presses(13, each=2, n_classes=2))
    with pytest.raises(InputError, match="there is no press: give at least one"):
        clf.predict(np.empty((0, 3, *SHAPE)))
    with pytest.raises(InputError, match="there is no press: give at least two of each class"):
        TactileClassifier().fit(np.empty((0, 3, *SHAPE)), [])


def test_flat_frames_are_of_the_shape_that_is_told() -> None:
    X, y = presses(14, each=4)
    flat = np.stack([one.pads["pad"][2].ravel() for one in X])
    clf = TactileClassifier((5, 6), drift=0).fit(flat, y)
    assert clf.settings_.shapes == {"pad_0": SHAPE}
    assert clf.n_features_in_ == 30
    np.testing.assert_array_equal(clf.predict(flat), clf.predict(flat.reshape(-1, *SHAPE)))
    assert clf.explain(flat[:1])[0].place == "press 0"
    assert TactileClassifier(drift=0).fit(flat, y).settings_.shapes == {"pad_0": (5, 6)}


def test_labels_of_text_as_objects_are_text() -> None:
    X, y = presses(15, each=2, n_classes=2)
    clf = TactileClassifier(drift=0).fit(X, np.array(y, dtype=object))
    assert clf.classes_.dtype.kind == "U"


def test_a_class_is_put_in_its_place() -> None:
    X, y = presses(16, each=4)
    known = y != "cup"
    clf = TactileClassifier(drift=0).fit([x for x, k in zip(X, known, strict=True) if k], y[known])
    before = clf.places_.tolist()
    new = [x for x, k in zip(X, ~known, strict=True) if k]
    assert clf.add("cup", new[:2]) is clf
    assert clf.classes_.tolist() == ["bar", "cup", "ring"]
    assert clf.learned_.landmark_codes.tolist() == [0, 2] * 4 + [1, 1]
    assert clf.places_.tolist() == before + [one.place for one in new[:2]]
    assert clf.add("a very long name", new[2:]).classes_.tolist() == ["a very long name", "bar", "cup", "ring"]
    with pytest.raises(InputError, match="'cup' is known already; choose another label"):
        clf.add("cup", new)


def test_adapting_takes_the_error_and_what_was_learned(monkeypatch: pytest.MonkeyPatch) -> None:
    X, y = presses(17, each=6)
    clf = TactileClassifier(drift=0, error=0.3).fit(X, y)
    adapted = clf.adapt(X)
    drift = classifier.estimate_drift(clf.learned_, {"touch": measure_presses(X, clf.settings_)}, {}, 0.3)
    np.testing.assert_array_equal(adapted.learned_.drift["touch"], drift["touch"])
    assert adapted.learned_.sources is clf.learned_.sources
    assert clf.learned_.drift == {}


def recording(
    source: str, shape: tuple[int, int] = SHAPE, pads: tuple[str, ...] = ("pad",), **columns: Any
) -> Recording:
    frames = np.ones((4, *shape)) * np.array([0, 1, 0, 1])[:, None, None]
    return Recording(
        dict.fromkeys(pads, Pad(frames)),
        source=source,
        press=np.array([0, 0, 1, 1]),
        press_columns={name: np.array(of) for name, of in columns.items()},
    )


def test_labels_and_sessions_are_columns_or_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    given = [
        recording("a.npz", n=[1.5, 2.0], s=["x", "y"]),
        recording(os.fspath(tmp_path / "b" / "c.npz"), n=[3.0, 4.0]),
    ]
    found = labelled_presses(given, label="n", group="folder")
    assert found.labels.tolist() == ["1.5", "2.0", "3.0", "4.0"]
    assert found.groups is not None
    assert found.groups.tolist() == ["here", "here", "b", "b"]
    assert len(found) == len(found.presses) == 4
    assert [one.place for one in found.presses[:2]] == ["a.npz, press 0", "a.npz, press 1"]
    alone = labelled_presses(given, label="folder")
    assert (alone.labels.tolist(), alone.groups) == (["here", "here", "b", "b"], None)


def test_a_session_may_be_the_folder_around_that_of_the_thing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mon" / "cup").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "mon" / "cup")
    given = [recording("a.npz", n=[1, 2]), recording("../../tue/can/b.npz", n=[3, 4])]
    found = labelled_presses(given, label="folder", group="folder/..")
    assert found.labels.tolist() == ["cup", "cup", "can", "can"]
    assert found.groups is not None
    assert found.groups.tolist() == ["mon", "mon", "tue", "tue"]
    assert set(labelled_presses(given, label="folder/../..").labels.tolist()) == {tmp_path.name}
    for wrong in ("folder/", "folder/.", "folders", "folder/..."):
        with pytest.raises(InputError, match="presses have no column"):
            labelled_presses(given, label=wrong)


def test_a_space_at_the_end_of_a_label_makes_no_other_thing() -> None:
    found = labelled_presses([recording("a.npz", n=["cup", "cup "], s=["1", " 1"])], label="n", group="s")
    assert found.labels.tolist() == ["cup", "cup"]
    assert found.groups is not None
    assert found.groups.tolist() == ["1", "1"]


def test_a_letter_whose_mark_stands_apart_makes_no_other_thing() -> None:
    given = [
        recording("Wu\u0308rfel/a.npz", n=["Ku\u0308bel"] * 2),
        recording("W\u00fcrfel/b.npz", n=["K\u00fcbel"] * 2),
    ]
    assert set(labelled_presses(given, label="n").labels.tolist()) == {"K\u00fcbel"}
    assert set(labelled_presses(given, label="folder").labels.tolist()) == {"W\u00fcrfel"}


def test_columns_that_are_missing_are_told() -> None:
    one = recording("a.npz", n=[1.0, np.nan], s=["x", " "])
    for kind, column, message in (
        ("label", "k", "a.npz: presses have no column 'k', known are: n, s; name one of these, or 'folder'"),
        ("group", "k", "a.npz: presses have no column 'k', known are: n, s; name one of these, or 'folder'"),
        ("label", "n", "a.npz: press 1 has no n; fill it in, or leave the press out"),
        ("group", "s", "a.npz: press 1 has no s; fill it in, or leave the press out"),
    ):
        with pytest.raises(InputError) as told:
            labelled_presses([one], **({"label": "folder"} | {kind: column}))
        assert str(told.value) == message
        assert told.value.parameter == (kind if column == "k" else None)
    with pytest.raises(InputError) as told:
        labelled_presses([recording("")], label="k")
    assert str(told.value).startswith("the recording: presses have no column 'k', known are: none;")


def test_recordings_are_of_one_sensor() -> None:
    for other, message in (
        (
            recording("b", pads=("new",)),
            "b, press 0: has the pads new 5 x 6, those before it pad 5 x 6, two 5 x 6",
        ),
        (
            recording("b", (7, 6), ("pad", "two")),
            "b, press 0: has the pads pad 7 x 6, two 7 x 6, those before it pad 5 x 6, two 5 x 6",
        ),
    ):
        with pytest.raises(InputError) as told:
            labelled_presses([recording("a", pads=("pad", "two")), other], label="folder")
        assert str(told.value).startswith(message)
        assert str(told.value).endswith("; give presses of one sensor")
    mixed = Recording(
        {"pad": Pad(np.ones((2, 7, 6))), "two": Pad(np.ones((2, *SHAPE)))}, source="b", press=np.zeros(2, int)
    )
    with pytest.raises(InputError) as told:
        labelled_presses([recording("a", pads=("pad", "two")), mixed], label="folder")
    assert str(told.value) == (
        "b, press 0: has the pads pad 7 x 6, two 5 x 6, those before it pad 5 x 6, two 5 x 6; "
        "give presses of one sensor"
    )
    some = labelled_presses([recording("a", pads=("pad", "two")), recording("b", pads=("pad", "more"))], label="folder")
    assert len(some) == 4


def test_p_values_are_of_what_was_held_out(fitted: TactileClassifier) -> None:
    X, _ = presses(18, each=2)
    asked = as_presses(X)
    scaled = fitted.learned_.scaled({"touch": measure_presses(asked, fitted.settings_)})
    strange = fitted.learned_.judge(scaled)[1]
    np.testing.assert_array_equal(fitted.p_values(X), conformal_p_value(strange, fitted.learned_.known))
    assert len(fitted.learned_.known) == 21


def test_numbers_among_objects_are_not_made_text() -> None:
    X, _ = presses(19, each=2, n_classes=2)
    for labels in ([1, 2, 1, 2], [1, "a", 1, "a"]):
        with pytest.raises(ValueError, match="Unknown label type"):
            TactileClassifier(drift=0).fit(X, np.array(labels, dtype=object))
