"""Laws of learning from recordings that were made otherwise than those before: clocks, units, labels, copies."""

from __future__ import annotations

import copy
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from varishold import Pad, Recording, TactileClassifier
from varishold.cli.learn import tell_strange
from varishold.cli.recordings import odd_recordings
from varishold.errors import InputError
from varishold.evaluation import evaluate, evaluate_model
from varishold.evaluation.running import felt_presses
from varishold.learning import PortableClassifier, labelled_presses, read_model, write_model
from varishold.touch.course.presses import as_presses
from varishold.touch.course.unlike import bear_nothing

SHAPE = (9, 10)
Pairs = list[tuple[np.ndarray, np.ndarray]]


def presses(seed: int, each: int = 8) -> tuple[Pairs, np.ndarray]:
    """Spots and bars that come up at 100 Hz, the bars in half the time."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(SHAPE) - np.array([4.0, 4.5])[:, None, None]
    forms = {"spot": np.exp(-(x * x + y * y) / 4), "bar": np.exp(-y * y / 3)}
    labels = np.tile(list(forms), each)
    made: Pairs = []
    for label in labels:
        n = 12 if label == "spot" else 6
        ramp = np.concatenate([np.zeros(2), np.linspace(0, 1, n), [0.5]])[:, None, None]
        frames = 100 * rng.uniform(0.9, 1.1) * ramp * forms[label] + rng.normal(0, 0.5, (n + 3, *SHAPE))
        made.append((frames, np.arange(n + 3) / 100))
    return made, labels


def without_time(pairs: Pairs) -> list[np.ndarray]:
    return [frames for frames, _ in pairs]


@pytest.fixture(scope="module")
def timed() -> TactileClassifier:
    return TactileClassifier(drift=0, folds=2).fit(*presses(0, each=12))


def test_a_press_without_times_is_refused_by_a_model_that_learned_times(timed: TactileClassifier) -> None:
    X, _ = presses(1)
    with pytest.raises(InputError, match=r"press 0: has no time_s, .* learn without"):
        timed.predict(without_time(X)[:3])
    with pytest.raises(InputError, match=r"press 1: has no time_s"):
        timed.predict([X[0], X[1][0], X[2]])


def test_where_some_training_press_has_no_time_nobodys_times_count() -> None:
    X, y = presses(0)
    mixed: list[Any] = [X[k] if k % 3 else X[k][0] for k in range(len(X))]
    plain = TactileClassifier(drift=0, folds=2).fit(without_time(X), y)
    some = TactileClassifier(drift=0, folds=2).fit(mixed, y)
    asked, _ = presses(2)
    expected = plain.predict_proba(without_time(asked))
    np.testing.assert_array_equal(some.predict_proba(asked), expected)
    np.testing.assert_array_equal(plain.predict_proba([(frames, 1e3 * time) for frames, time in asked]), expected)


def test_what_lies_outside_of_all_that_was_learned_is_named(timed: TactileClassifier) -> None:
    X, _ = presses(3)
    inside = timed.explain(X)
    assert not any(found.outside for found in inside if not found.refused)
    slow = timed.explain([(frames, 1e3 * time) for frames, time in X])
    assert all(found.refused and found.outside[0] == "time" for found in slow)
    assert slow[0].to_dict()["outside"][0] == "time"
    assert "outside" not in next(found for found in inside if not found.refused).to_dict()


def test_names_that_differ_by_a_space_at_the_ends_are_one(timed: TactileClassifier) -> None:
    X, y = presses(3)
    kept = TactileClassifier().fit(X, [f"{label} " if k % 3 else f" {label}" for k, label in enumerate(y)])
    assert kept.classes_.tolist() == timed.classes_.tolist()
    with pytest.raises(InputError, match="at least two classes"):
        TactileClassifier().fit(X[:6], ["a", "a "] * 3)
    with pytest.raises(InputError, match=r"press 1: its label must be a line of printable text, got 'a\\nb'"):
        TactileClassifier().fit(X[:6], ["a", "a\nb"] * 3)
    with pytest.raises(InputError, match="'bar' is known already"):
        timed.add("bar ", X)
    with pytest.raises(InputError, match="a line of printable text, got 'a"):
        timed.add("a\nb", X)


@pytest.mark.parametrize("kind", [TactileClassifier, PortableClassifier])
def test_presses_that_were_learned_are_known_again_wherever_they_stand(kind: Any, tmp_path: Path) -> None:
    X, y = presses(0)
    write_model(kind(drift=0, folds=2).fit(X, y), tmp_path / "m")
    model = read_model(tmp_path / "m")
    fresh, _ = presses(4)
    assert model.learned_from(X).all()
    assert not model.learned_from(fresh).any()
    assert not model.learned_from([np.zeros((5, *SHAPE))] if kind is PortableClassifier else [(0 * X[0][0], X[0][1])])[
        0
    ]


def test_an_evaluation_knows_copies_of_what_its_model_learned(timed: TactileClassifier) -> None:
    X, y = presses(0, each=12)
    found = evaluate_model(timed, X[2:6], y[2:6])
    assert [leak.name for leak in found.leaks] == ["learned from these"]
    assert "4 of these very presses" in found.leaks[0].says
    assert evaluate_model(timed, *presses(5)).leaks == ()


@pytest.mark.parametrize("kind", [TactileClassifier, PortableClassifier])
def test_labels_that_say_nothing_of_the_presses_are_told_after_learning(kind: Any) -> None:
    rng = np.random.default_rng(0)
    X, y = presses(0, each=15)
    assert not any("guessing" in words for words in kind(folds=2).fit(X, y).remarks_)
    spots = [X[2 * int(k)] for k in rng.integers(0, 15, 30)]
    assert any("no better than by guessing" in words for words in kind(folds=2).fit(spots, y).remarks_)


def test_many_things_of_one_press_are_refused_without_a_warning_of_a_library() -> None:
    X, _ = presses(0)
    with pytest.raises(InputError, match="one press only"):
        TactileClassifier().fit(X, np.array([f"thing {k}" for k in range(len(X))]))


def test_numbers_beside_presses_that_no_sensor_reads_are_refused_with_their_place() -> None:
    X, y = presses(0)
    made = recording(X, y, source="a.npz")
    wild = np.where(np.arange(len(y)) == 3, 1e308, 0.0)
    with pytest.raises(
        InputError, match=r"^a\.npz: press 3: angle_rad\.a must lie within 1e\+100 of zero, got 1e\+308"
    ):
        labelled_presses([replace(made, press_columns={**made.press_columns, "angle_rad.a": wild})], label="thing")


@pytest.mark.parametrize("kind", [TactileClassifier, PortableClassifier])
def test_no_thing_is_called_as_strangers_are(kind: Any, timed: TactileClassifier) -> None:
    X, _ = presses(2)
    with pytest.raises(InputError, match="press 1: no thing can be called 'none of these', which is said of strangers"):
        kind().fit(X[:6], ["a", " none of these"] * 3)
    with pytest.raises(InputError, match="no thing can be called 'none of these'"):
        timed.add("none of these ", X)
    # To be told of strangers a model may be asked for presses that are called so; nothing learns from them.
    with pytest.raises(InputError, match="no thing can be called 'none of these'") as raised:
        evaluate(X, ["a", "none of these"] * (len(X) // 2))
    assert raised.value.parameter == "label"
    assert felt_presses(X, ["a", "none of these "] * (len(X) // 2), None).classes.tolist() == ["a", "none of these"]
    assert kind().fit(X, ["none of the", "None Of These"] * (len(X) // 2)).classes_.size == 2


@pytest.mark.parametrize("label", ["", "  ", "\t"])
def test_a_class_without_a_name_is_not_added(timed: TactileClassifier, label: str) -> None:
    with pytest.raises(InputError, match="no name"):
        timed.add(label, presses(1)[0])


def recording(X: Pairs, labels: np.ndarray, **of: Any) -> Recording:
    number = np.repeat(np.arange(len(X)), [len(frames) for frames, _ in X])
    pad = Pad(np.concatenate([frames for frames, _ in X]))
    return Recording({"pad": pad}, press=number, press_columns={"thing": labels}, **of)


def test_a_label_for_each_frame_is_no_label_for_each_press() -> None:
    X, y = presses(0)
    assert len(labelled_presses([recording(X, y)], label="thing")) == len(X)
    of_frames = np.repeat(y, [len(frames) for frames, _ in X])
    with pytest.raises(InputError, match=r"an entry for each of \d+ frames; give one for each of the 16 presses"):
        labelled_presses([recording(X, of_frames)], label="thing")


@pytest.mark.parametrize("factor", [1e3, 20.0, 1e-3, 0.0])
@pytest.mark.parametrize("pads", [1, 2])
def test_a_press_of_another_clock_is_refused_however_many_measures_its_form_has(factor: float, pads: int) -> None:
    # On a mat of 16 x 16 taxels six times stand beside more than two hundred measures of forms.
    rng = np.random.default_rng(pads)
    y, x = np.indices((16, 16)) - 7.5
    forms = {"spot": np.exp(-(x * x + y * y) / 6), "bar": np.exp(-y * y / 3 - x * x / 60)}
    pressed, labels = [], np.tile(list(forms), 14)
    for label in labels:
        n = int(rng.integers(9, 12)) if label == "spot" else int(rng.integers(6, 9))
        ramp = np.concatenate([np.zeros(2), np.linspace(0, 1, n), np.ones(3)])[:, None, None]
        frames = 100 * rng.uniform(0.8, 1.2) * ramp * forms[label]
        noisy = frames[:, None] + rng.normal(0, 1, (n + 5, pads, 16, 16))
        pressed.append((noisy, np.arange(n + 5) / 50))
    model = TactileClassifier().fit(pressed[:20], labels[:20])
    asked = pressed[20:]
    assert not model.refused(asked).any()
    other = [(frames, factor * time) for frames, time in asked]
    probabilities, p_values = model.judge(other)
    assert (p_values <= model.error).all()
    assert (probabilities <= 0.9).all()
    assert all(found.outside[0] == "time" for found in model.explain(other))


def test_presses_as_unlike_in_time_as_those_learned_are_of_no_other_clock() -> None:
    X, y = presses(3, each=12)
    rng = np.random.default_rng(0)
    paced = [(frames, time * np.exp(rng.normal(0, 2))) for frames, time in X]
    model = TactileClassifier().fit(paced, y)
    assert not model.refused([(frames, 12.0 * time) for frames, time in X]).any()


def test_a_recording_of_another_clock_is_told_beside_its_answers(
    timed: TactileClassifier, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    X, _ = presses(6)
    tell_strange("a.npz", timed.explain(X))
    assert capsys.readouterr().err == ""
    tell_strange("a.npz", timed.explain([(frames, 1e3 * time) for frames, time in X]))
    told = capsys.readouterr().err
    assert re.search(r"a\.npz: 1[3-6] of 16 presses are like nothing that was learned, above all in time", told)
    assert told.endswith("other things, or another sensor, unit, clock or load\n")
    tell_strange("a.npz", timed.explain([(frames, 1e3 * time) for frames, time in X]), adaptable=True)
    assert capsys.readouterr().err.endswith("clock or load; if it is another day, --adapt allows for its drift\n")


def test_what_is_odd_about_recordings_is_told_once_with_their_files() -> None:
    def one(name: str, dead: int = 0, high: float = np.inf) -> tuple[str, Recording]:
        X, y = presses(7)
        made = recording(X, y)
        frames = np.minimum(made.pads["pad"].frames, high).copy()
        frames[:, 0, :dead] = 0
        return name, Recording({"pad": Pad(frames)}, press=made.press, press_columns=made.press_columns)

    plain, broken, again, cut = one("a.npz"), one("b.npz", 1), one("c.npz", 1), one("d.npz", 0, 20.0)
    assert odd_recordings(*zip(plain, strict=True)) == []
    files, read = zip(plain, broken, again, cut, strict=True)
    told = odd_recordings(files, read)
    assert len(told) == 2
    assert told[0].startswith("b.npz and 1 more: taxel (0, 0) is always 0")
    assert re.match(r"d\.npz: .* reaches? exactly the same highest value, 20: saturated, or flat", told[1])
    many = [one(f"{k}.npz", 0, 20.0 + k) for k in range(8)]
    told = odd_recordings(*zip(*many, strict=True))
    assert (len(told), told[-1]) == (7, "2 remarks more: varishold info FILE tells them")


def lighter(pairs: Pairs, share: float) -> Pairs:
    return [(share * frames, time_s) for frames, time_s in pairs]


@pytest.mark.parametrize("share", [0.0, 1e-3])
def test_what_bears_next_to_nothing_is_refused_and_named_evenly(timed: TactileClassifier, share: float) -> None:
    X, _ = presses(1, each=3)
    faint = lighter(X, share)
    probabilities, p_values = timed.judge([*faint, *X])
    assert probabilities[:6] == pytest.approx(0.5)
    assert (p_values[:6] <= timed.error).all()
    np.testing.assert_array_equal(timed.judge(X)[0], probabilities[6:])
    np.testing.assert_array_equal(timed.judge(X)[1], p_values[6:])
    found = timed.explain(faint)[0]
    assert found.refused
    assert found.outside == ("load",)
    assert found.measures == ()


def test_lighter_presses_bear_something_and_nothing_is_known_where_it_was_learned(timed: TactileClassifier) -> None:
    X, y = presses(1)
    assert not bear_nothing(as_presses(lighter(X, 0.3)), timed.settings_).any()
    assert bear_nothing(as_presses(lighter(X, 0.05)), timed.settings_).all()
    empty = np.zeros((5, *SHAPE)), np.arange(5) / 100
    learned = TactileClassifier(drift=0, folds=2).fit([*X, *[empty] * 6], [*y, *["nothing"] * 6])
    assert learned.settings_.least_load == 0
    assert learned.predict([empty]).tolist() == ["nothing"]
    assert not learned.refused([empty]).any()


def test_a_faint_class_that_is_added_is_known_from_then_on(timed: TactileClassifier) -> None:
    X, y = presses(2, each=4)
    faint = lighter([press for press, label in zip(X, y, strict=True) if label == "bar"], 0.05)
    grown = copy.deepcopy(timed).add("breath", faint)
    assert 0 < grown.settings_.least_load < 0.1 * timed.settings_.least_load
    assert not np.allclose(grown.judge(faint)[0], 1 / 3)


def test_of_what_bears_next_to_nothing_numbers_still_tell(tmp_path: Path) -> None:
    X, y = presses(0, each=12)
    rng = np.random.default_rng(0)

    def recorded(pairs: Pairs, labels: np.ndarray) -> list[Recording]:
        return [
            Recording(
                {"pad": Pad(frames)},
                time_s,
                press=np.zeros(len(frames), int),
                press_columns={"angle_rad.a": np.array([float(label == "bar") + rng.normal(0, 0.1)])},
            )
            for (frames, time_s), label in zip(pairs, labels, strict=True)
        ]

    clf = TactileClassifier(drift=0, folds=2).fit(recorded(X, y), y)
    write_model(clf, tmp_path / "m.npz")
    for model in (clf, read_model(tmp_path / "m.npz")):
        found = model.explain(recorded(lighter(X, 0.0), y))
        assert all(one.refused and one.probability < 0.9 for one in found)
        assert [one.label for one in found] == y.tolist()
        assert {name for one in found for name, _ in one.measures} == {"angle_rad.a"}


def test_from_few_presses_no_answer_is_sure(tmp_path: Path) -> None:
    X, y = presses(3, each=9)
    few = TactileClassifier(drift=0, folds=2).fit(X, y)
    assert few.n_presses_ == 18
    assert "from 18 presses no answer has a p above .9: give 19 or more" in few.remarks_
    asked = presses(4, each=6)[0]
    write_model(few, tmp_path / "m.npz")
    np.testing.assert_array_equal(read_model(tmp_path / "m.npz").predict_proba(asked), few.predict_proba(asked))
    assert 0.89 < few.predict_proba(asked).max() <= 0.9
    more, labels = presses(3, each=10)
    enough = TactileClassifier(drift=0, folds=2).fit([*X, more[18]], [*y, labels[18]])
    assert enough.predict_proba(asked).max() > 0.9
    assert not any("no answer has a p above" in remark for remark in enough.remarks_)
    np.testing.assert_array_equal(few.predict(asked), enough.predict(asked))


def test_a_class_that_is_added_makes_presses_enough() -> None:
    X, y = presses(3, each=9)
    clf = TactileClassifier(drift=0, folds=2).fit(X, y)
    clf.add("soft", lighter(X[:2], 0.6))
    assert clf.n_presses_ == 20


def test_what_was_pressed_seldom_is_hardly_surely_called_what_was_pressed_often() -> None:
    rng = np.random.default_rng(0)
    radii, often = {"a": 1.4, "b": 1.7, "c": 1.55, "d": 1.9}, {"a": 40, "b": 40, "c": 3, "d": 3}

    def presses(counts: dict[str, int]) -> tuple[list[np.ndarray], np.ndarray]:
        found = []
        for thing, count in counts.items():
            for _ in range(count):
                y, x = np.indices((6, 8)) - np.array([2.5, 3.5])[:, None, None] - rng.normal(0, 0.5, 2)[:, None, None]
                most = np.exp(-((np.hypot(x, y) / radii[thing]) ** 2)) * rng.uniform(80, 120)
                found.append(np.multiply.outer([0.0, 0.0, 0.3, 0.6, 1.0], most) + rng.normal(0, 5, (5, 6, 8)))
        return found, np.repeat(list(counts), list(counts.values()))

    fitted = TactileClassifier().fit(*presses(often))
    assert any(said.startswith("'c' was pressed 3 times, 'a' 40 times: ") for said in fitted.remarks_)
    new, thing = presses(dict.fromkeys(radii, 40))
    probabilities = fitted.predict_proba(new)
    sure, wrong = probabilities.max(axis=1) > 0.9, fitted.predict(new) != thing
    assert (sure & wrong).mean() <= 0.02
    # On the mean answers promise what they keep.
    assert probabilities.max(axis=1).mean() <= 1 - wrong.mean() + 0.05


def without_row(pairs: Pairs, row: int) -> Pairs:
    cut = [(frames.copy(), time_s) for frames, time_s in pairs]
    for frames, _ in cut:
        frames[:, row] = np.nan
    return cut


def test_what_stands_on_taxels_that_broke_since_promises_little(timed: TactileClassifier) -> None:
    X, _ = presses(4, each=4)
    beside, amid = without_row(X, 0), without_row(X, 4)
    assert timed.predict_proba(beside).max() > 0.95
    assert timed.predict_proba(amid).max(axis=1).max() <= 0.9
    np.testing.assert_array_equal(timed.predict_proba([*amid, *X])[len(X) :], timed.predict_proba(X))
    assert timed.remarks_on(beside) == ()
    assert timed.remarks_on([*X, amid[0]]) == (
        "1 press stands in part on broken taxels, where none usually did in learning: no p above .9 there",
    )


def test_where_taxels_were_broken_in_learning_too_answers_are_as_sure_as_held_out_presses_were() -> None:
    X, y = presses(0, each=12)
    learned = TactileClassifier(drift=0, folds=2).fit(without_row(X, 4), y)
    asked, truth = presses(4, each=4)
    assert 0.2 < learned.settings_.filled < 0.5
    assert learned.predict(without_row(asked, 4)).tolist() == truth.tolist()
    assert np.median(learned.predict_proba(without_row(asked, 4)).max(axis=1)) > 0.95
    assert learned.remarks_on(without_row(asked, 4)) == ()


def test_that_taxels_were_broken_in_few_presses_of_many_does_not_make_it_usual() -> None:
    X, y = presses(0, each=12)
    learned = TactileClassifier(drift=0, folds=2).fit([*without_row(X[:2], 4), *X[2:]], y)
    assert learned.settings_.filled == 0


@pytest.mark.parametrize("label", [None, np.nan, np.inf, 1.5, ("a", "b"), b"cup", ["cup"]])
def test_what_is_no_label_adds_no_class(timed: TactileClassifier, label: Any) -> None:
    model = copy.deepcopy(timed)
    with pytest.raises(InputError, match="the new class has no name: give it a label"):
        model.add(label, presses(1)[0])
    np.testing.assert_array_equal(model.classes_, timed.classes_)


def test_a_number_and_its_text_are_one_label(tmp_path: Path) -> None:
    X, y = presses(0, each=4)
    model = TactileClassifier(drift=0, folds=2).fit(X, (y == "bar").astype(int))
    for label in (1, "1", 1.0, np.int64(0), "0 "):
        with pytest.raises(InputError, match="is known already"):
            model.add(label, X[:3])
    model.add("2", X[:3])
    write_model(model, tmp_path / "m.npz")
    assert read_model(tmp_path / "m.npz").classes_.tolist() == ["0", "1", "2"]


def test_bytes_are_no_labels() -> None:
    with pytest.raises(InputError, match=r"labels must be texts or whole numbers, got bytes: .*b'a'.*; decode them"):
        TactileClassifier().fit(presses(0, each=2)[0], [b"a", b"b"] * 2)


@pytest.mark.parametrize(("drift", "times"), [(0.0, 1), (0.1, 6)])
def test_a_class_more_is_learned_as_another_day_may_bring_it_where_the_others_were(drift: float, times: int) -> None:
    X, y = presses(0, each=6)
    model = TactileClassifier(drift=drift, folds=2).fit(X, y)
    n_before, known = len(model.places_), len(model.learned_.known)
    model.add("soft", [(frames**2 / 100, time_s) for frames, time_s in X[:4:2]])
    assert (model.classes_[model.landmark_codes] == "soft").sum() == len(model.places_) - n_before == 2 * times
    # How strange its presses are is told by themselves alone.
    assert len(model.learned_.known) == known + 2
    assert model.n_presses_ == 14


def test_a_class_more_that_is_hardly_told_from_others_is_said_to_be_so() -> None:
    X, y = presses(0, each=8)
    model = TactileClassifier(drift=0, folds=2).fit(X, y)
    bars = [press for press, label in zip(presses(5)[0], y, strict=True) if label == "bar"]
    alike = copy.deepcopy(model).add("other bar", bars[:3]).remarks_
    (told,) = [remark for remark in alike if "named otherwise" in remark]
    assert re.match(r"[123] of 3 presses of 'other bar', each held out, are named otherwise: answers near it", told)
    blocks = [(100 * np.maximum(frames > 30, 0.0), time_s) for frames, time_s in bars]
    assert not any("named otherwise" in remark for remark in model.add("block", blocks).remarks_)
