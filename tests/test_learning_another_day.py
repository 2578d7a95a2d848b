"""Another day where one day was learned: what is known is judged by forms alone."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.pressed_things import told

from varishold import Pad, Recording, TactileClassifier, write
from varishold.learning import read_model, write_model
from varishold.touch.course.measures import form_alone, learn_settings, measure_presses, of_forms
from varishold.touch.course.presses import Press, drifted
from varishold.trust import conformal_p_value

SHAPES = {"left": (9, 8), "right": (7, 10)}
THINGS = ["bar", "coin", "ring"]


class Day:
    """How a hand of two pads is on a day: its gains, where it sits, how hard it presses."""

    def __init__(self, seed: int, *, moved: float = 0.0, load: float = 1.0, drift: float = 0.0) -> None:
        self.rng = np.random.default_rng(seed)
        self.load = load
        self.gain = {name: np.exp(self.rng.normal(0, drift, shape)) for name, shape in SHAPES.items()}
        self.at = {name: self.rng.uniform(-moved, moved, 2) for name in SHAPES}

    def press(self, thing: str) -> Press:
        """Return a press of a thing, on both pads."""
        rng, pads = self.rng, {}
        course = np.concatenate([[0.0, 0.0], np.sort(rng.uniform(0.1, 1.0, 6)), [1.0]])[:, None, None]
        by, jitter = 100 * self.load * rng.uniform(0.9, 1.1), rng.normal(0, 0.2, 2)
        for name, (rows, cols) in SHAPES.items():
            middle = np.array([(rows - 1) / 2, (cols - 1) / 2]) + self.at[name] + jitter
            y, x = np.indices((rows, cols)) - middle[:, None, None]
            r = np.hypot(x, y)
            form = {
                "bar": np.exp(-((y / 1.2) ** 2)) * (np.abs(x) < 3.5),
                "coin": 1 / (1 + np.exp(4 * (r - 2.2))),
                "ring": np.exp(-(((r - 2.3) / 0.7) ** 2)),
                "cross": np.exp(-((np.minimum(np.abs(x), np.abs(y)) / 0.7) ** 2)) * (r < 4),
            }[thing]
            pads[name] = by * course * form * self.gain[name] + rng.normal(0, 0.5, (len(course), rows, cols))
        return Press(pads, {name: np.ones(shape, bool) for name, shape in SHAPES.items()}, place=f"{thing}")

    def presses(self, things: list[str], each: int) -> tuple[list[Press], np.ndarray]:
        labels = np.tile(things, each)
        return [self.press(str(thing)) for thing in labels], labels


@pytest.fixture(scope="module")
def fitted() -> TactileClassifier:
    return TactileClassifier().fit(*Day(0).presses(THINGS, 10))


@pytest.fixture(scope="module")
def tomorrow() -> Day:
    return Day(1, moved=1.5, load=0.75, drift=0.1)


def test_known_things_of_another_day_are_named_and_hardly_refused(fitted: TactileClassifier, tomorrow: Day) -> None:
    presses, labels = tomorrow.presses(THINGS, 12)
    probabilities, _ = fitted.judge(presses)
    assert fitted.refused(presses).mean() <= 0.15
    assert (fitted.predict(presses) == labels).mean() >= 0.95
    sure = probabilities.max(axis=1) > 0.9
    assert (fitted.predict(presses)[sure] == labels[sure]).all()
    # By place and load they are strange.
    plain = replace(fitted.learned_, forms=None)
    measures = fitted._measures(presses, fitted.settings_)
    strange = plain.judge(plain.scaled(measures))[1]
    assert (conformal_p_value(strange, plain.known) <= fitted.error).mean() > 0.3
    assert any(found.unlike_session for found in fitted.explain(presses))


def test_strangers_are_refused_or_not_surely_named(fitted: TactileClassifier, tomorrow: Day) -> None:
    for day in (Day(2), tomorrow):
        strangers, _ = day.presses(["cross"], 20)
        assert fitted.refused(strangers).mean() >= 0.5
        assert (fitted.predict_proba(strangers).max(axis=1) > 0.9).mean() <= 0.25


def test_what_is_felt_as_on_the_day_that_was_learned_and_whose_form_agrees_is_named_as_before(
    fitted: TactileClassifier,
) -> None:
    presses, _ = Day(3).presses(THINGS, 5)
    found = fitted.explain(presses)
    scaled = fitted.learned_.scaled(fitted._measures(presses, fitted.settings_))
    said, strange = fitted.learned_.judge(scaled)
    alike = conformal_p_value(strange, fitted.learned_.known) > fitted.error
    assert alike.sum() > 10
    assert fitted.predict(presses).tolist() == fitted.classes_[said.argmax(axis=1)].tolist()
    assert [one.unlike_session for one in found] == (~alike).tolist()
    answered = alike & ~fitted.refused(presses)
    np.testing.assert_array_equal(fitted.predict_proba(presses)[answered], np.exp(said)[answered])


def test_what_is_named_unlike_session_is_sure_only_where_its_form_is_usual(
    fitted: TactileClassifier, tomorrow: Day
) -> None:
    presses, _ = tomorrow.presses([*THINGS, "cross"], 8)
    probabilities, p_values = fitted.judge(presses)
    unlike = np.array([one.unlike_session for one in fitted.explain(presses)])
    assert (probabilities[unlike & (p_values <= 0.3)] <= 0.9).all()


def test_nothing_is_named_more_surely_than_its_form_allows() -> None:
    # Where and how hard a thing is felt tells what it is, on the day that was learned; gains that differ by half from
    # press to press leave little of its form.
    def presses(places: dict[str, tuple[float, float]]) -> list[Press]:
        found = []
        for number, thing in enumerate(THINGS * 10):
            day = Day(number, drift=0.5, load=places[thing][1])
            day.at = {name: np.array([0.0, places[thing][0]]) for name in SHAPES}
            found.append(day.press(thing))
        return found

    places = {"bar": (-1.5, 0.6), "coin": (0.0, 1.0), "ring": (1.5, 1.6)}
    fitted = TactileClassifier().fit(presses(places), np.tile(THINGS, 10))
    moved = presses(dict(zip(THINGS, [places["coin"], places["ring"], places["bar"]], strict=True)))
    measures = fitted._measures(moved, fitted.settings_)
    forms = fitted.learned_.forms
    assert forms is not None
    said = np.exp(fitted.learned_.judge(fitted.learned_.scaled(measures))[0])
    by_forms = np.exp(forms.judge(forms.scaled(fitted._forms_asked(measures)))[0])
    agree = said.argmax(axis=1) == by_forms.argmax(axis=1)
    most = np.where(agree, 0.75 + 0.25 * by_forms.max(axis=1), 0.9)
    alike = np.array([not one.unlike_session for one in fitted.explain(moved)])
    assert (said.max(axis=1) > most)[alike].any()
    assert (fitted.predict_proba(moved).max(axis=1) <= most + 1e-12).all()


@pytest.mark.parametrize(("position", "absolute"), [(True, True), (True, False), (False, True), (False, False)])
def test_forms_are_what_is_measured_with_neither_place_nor_load(position: bool, absolute: bool) -> None:
    presses, _ = Day(4).presses(THINGS, 2)
    presses[1] = replace(presses[1], pads={"left": presses[1].pads["left"]})
    settings = learn_settings(presses, position=position, absolute=absolute)
    found = form_alone(measure_presses(presses, settings), settings)
    np.testing.assert_array_equal(found, measure_presses(presses, of_forms(settings)))


def test_forms_are_learned_by_themselves_only_where_place_or_load_of_one_session_are() -> None:
    presses, labels = Day(5).presses(THINGS, 4)
    sessions = np.repeat(["mo", "tu"], 6)
    assert TactileClassifier().fit(presses, labels).learned_.forms is not None
    assert TactileClassifier().fit(presses, labels, sessions).learned_.forms is None
    for how in ({"drift": 0.0}, {"position": False, "absolute": False}):
        assert TactileClassifier(**how).fit(presses, labels).learned_.forms is None


def test_a_model_file_keeps_what_was_learned_of_forms(fitted: TactileClassifier, tomorrow: Day, tmp_path: Path) -> None:
    presses, _ = tomorrow.presses([*THINGS, "cross"], 3)
    write_model(fitted, tmp_path / "m.npz")
    read = read_model(tmp_path / "m.npz")
    for one, other in zip(fitted.judge(presses), read.judge(presses), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)
    assert [one.to_dict() for one in read.explain(presses)] == [one.to_dict() for one in fitted.explain(presses)]


def test_a_class_that_is_added_is_known_by_its_form_too(tmp_path: Path, tomorrow: Day) -> None:
    model = TactileClassifier().fit(*Day(0).presses(THINGS, 10))
    model.add("cross", Day(6).presses(["cross"], 8)[0])
    crosses, labels = tomorrow.presses(["cross"], 10)
    assert (model.predict(crosses) == labels).mean() >= 0.9
    write_model(model, tmp_path / "m.npz")
    assert (read_model(tmp_path / "m.npz").predict(crosses) == labels).mean() >= 0.9


def test_a_drawn_day_leaves_a_thing_on_a_small_pad() -> None:
    frames = np.ones((2, 1, 12))
    press = Press({"tip": frames}, {"tip": np.ones((1, 12), bool)})
    for k in range(50):
        moved = drifted(press, 0.0, (k,), elsewhere=2).pads["tip"]
        assert moved.sum() >= 20


def test_the_command_and_the_model_say_so(fitted: TactileClassifier, tomorrow: Day, tmp_path: Path) -> None:
    assert any("what is refused is judged by forms alone" in remark for remark in fitted.remarks_)
    write_model(fitted, tmp_path / "m.npz")
    pressed = [tomorrow.press("coin").pads for _ in range(6)]
    pads = {name: Pad(np.concatenate([one[name] for one in pressed])) for name in SHAPES}
    write(Recording(pads, press=np.repeat(np.arange(6), len(pressed[0]["left"]))), tmp_path / "coins.npz")
    done = told("recognize", tmp_path / "m.npz", tmp_path / "coins.npz")
    assert "; felt unlike the session that was learned; " in done.output
    done = told("recognize", tmp_path / "m.npz", tmp_path / "coins.npz", "--json")
    said = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    assert any(one.get("unlike_session") for one in said)
    assert {one["label"] for one in said} == {"coin"}
