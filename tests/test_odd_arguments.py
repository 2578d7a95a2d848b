"""What is no such thing as a call takes is refused in one line that says what would be right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sklearn.exceptions import NotFittedError

from varishold import HyperplaneClassifier, InputError, Pad, Recording, ThresholdEncoder, find_contacts, recognize
from varishold.circuit import Comparator, Hyperplane, Netlist, PackedEvaluator, Score, Term, evaluate, minimize
from varishold.circuit.writers import c99_files, verilog_files
from varishold.grasp import fit_model
from varishold.perceive import grip_size, switch_values
from varishold.recording import GraspTable
from varishold.sensor import Sensor
from varishold.skin import Skin, Taxels, press, reconstruct
from varishold.solids import Sphere
from varishold.touch import recognize_recording

FRAMES = np.random.default_rng(0).normal(0, 0.1, (3, 8, 8)) + np.pad(np.ones((1, 4, 4)), ((0, 0), (2, 2), (2, 2)))
MANY = np.ones((3, 3))
SWITCHES = np.eye(6, dtype=np.bool_)
OBJECTS = np.array(list("abcabc"))
GATE = Netlist(
    ("a", "b"), (), (Hyperplane([(0, 1), (1, 1)], 1),), (Term([(0, 1)]),), (Score([]), Score([(0, 1)])), ("no", "yes")
)
COUNTED = replace(GATE, comparators=(Comparator(0, 3), Comparator(1, 5)))


def table(**cells: Any) -> GraspTable:
    return GraspTable({"what": OBJECTS, "switch.a": SWITCHES[:, 0], "switch.b": SWITCHES[:, 1], **cells})


def classifier(**options: Any) -> HyperplaneClassifier:
    return HyperplaneClassifier(**{"mode": "vote", **options}).fit(SWITCHES, OBJECTS)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: list(recognize_recording(FRAMES)), "recording must be a Recording, as read.path. gives it"),
        (lambda: list(recognize_recording(Recording({"pad": Pad(FRAMES)}), frames=MANY)), "frames must be 'peak'"),
        (lambda: recognize(find_contacts(FRAMES[0])[0], among="cone"), "among must be several names of"),
        (lambda: recognize(find_contacts(FRAMES[0])[0], among=MANY), "among must be several names of"),
        (lambda: Pad(FRAMES, polarity=MANY), "polarity must be up or down"),
        (lambda: Pad(FRAMES, notes="turned"), "notes must be a tuple of texts, got 'turned'"),
        (lambda: Recording({"pad": Pad(FRAMES)}, notes=None), "notes must be a tuple of texts, got 'None'"),
        (lambda: Recording({"pad": Pad(FRAMES)}, source=MANY), "source must be text, got ndarray"),
        (lambda: Recording({"pad": Pad(FRAMES)}, sensor=None), "sensor must be text, got NoneType"),
        (lambda: GraspTable(MANY), "cells of a table must be a Mapping, columns by name, got ndarray"),
        (lambda: GraspTable({"a": [[1], [1, 2]]}), "must be of one length and one dimension, got rows of different"),
        (lambda: table(f=np.ma.array(np.arange(6.0), mask=[1, 0, 0, 0, 0, 0])), "got some that are masked"),
        (lambda: fit_model(MANY, label="what"), "table must be a GraspTable, as read_grasp_table"),
        (lambda: fit_model(table(), label=MANY), "label must be the name of a column"),
        (lambda: fit_model(table(), label="what", group=3), "group must be the name of a column, got 3"),
        (lambda: fit_model(table(), label="what", seed=-1), "random_state must be a whole number from 0 on, got -1"),
        (lambda: evaluate(GATE, [[1, 0], [1]]), "X must have shape .n_grasps, 2., one column a channel, got rows of"),
        (
            lambda: evaluate(GATE, np.ma.array([[1, 0]], mask=[[1, 0]])),
            "one column a channel, got some that are masked",
        ),
        (lambda: minimize([[1, 0], [1]], [[0, 0]]), "on must have shape .n_patterns, n_variables., got rows of"),
        (
            lambda: PackedEvaluator(GATE).pack([[1, 0], [1]]),
            "switches must have shape .n_grasps, n_switches., got rows",
        ),
        (lambda: PackedEvaluator(COUNTED).pack(3), "X must have shape .n_grasps, 2., one column a channel, got ()"),
        (lambda: PackedEvaluator(GATE).predict([[1, 0]]), "grasps must be a PackedGrasps, as pack.X. gives them, got"),
        (lambda: Hyperplane.between([1, 0], [1]), "two patterns must be 0 and 1, of one length, got .1, 0. and .1."),
        (lambda: Hyperplane.between("10", "01"), "two patterns must be 0 and 1, of one length, got '10' and '01'"),
        (lambda: verilog_files(COUNTED, count_bits=33), "count_bits must be a whole number from 1 to 32, got 33"),
        (lambda: c99_files(GATE, vectors=0), "vectors must be a whole number from 1, got 0"),
        (lambda: classifier(mode=MANY), "mode must be auto, paper, robust, vote, got"),
        (lambda: classifier(flip_rate="x"), "flip_rate must be at least 0 and below 0.5, got 'x'"),
        (lambda: classifier(error=None), "error must lie between 0 and 1, got None"),
        (lambda: classifier(max_hyperplanes=2.5), "max_hyperplanes must be positive or None, got 2.5"),
        (lambda: classifier(max_hyperplanes=10**30), "max_hyperplanes must be positive or None, got 1000"),
        (lambda: classifier(random_state="x"), "random_state must be a whole number from 0 on, got 'x'"),
        (
            lambda: classifier(binarize=np.nan),
            "binarize must be a number, above which a switch is on, or None, got nan",
        ),
        (lambda: classifier(binarize="0"), "binarize must be a number, above which a switch is on, or None, got '0'"),
        (lambda: classifier(binarize=True), "binarize must be a number, .* got True"),
        (lambda: classifier(time_limit_s=-1), "time_limit_s must be a number from 0 on, got -1"),
        (lambda: classifier(time_limit_s=np.nan), "time_limit_s must be a number from 0 on, got nan"),
        (lambda: HyperplaneClassifier().fit(SWITCHES, ["a"] * 6), "two classes to tell apart, got 1 class: 'a'$"),
        (
            lambda: HyperplaneClassifier().fit(SWITCHES, OBJECTS, [None] * 6),
            "groups must be one a grasp, 6 of them, all",
        ),
        (
            lambda: classifier().predict_or_reject(SWITCHES, min_probability=np.nan),
            "min_probability must be a number, got nan",
        ),
        (lambda: classifier(variants=[[0], [1, 2]]), "variants must be integers .* got rows of different lengths"),
        (lambda: HyperplaneClassifier().fit(SWITCHES, OBJECTS, [[0], [1, 2]]), "groups must be one a grasp, 6 of them"),
        (lambda: classifier().explain([[0], [1, 2]]), "a grasp must be a row of 6 switches, got rows of different"),
        (lambda: classifier().add_class(SWITCHES[:2], MANY), "label must be one name, of the same kind as 'a'"),
        (lambda: classifier().add_class(SWITCHES[:2], None), "label must be one name, .* got None"),
        (lambda: classifier().add_class(SWITCHES[:2], 7), "label must be one name, .* got 7"),
        (
            lambda: HyperplaneClassifier("vote").fit(SWITCHES, np.arange(6) // 2).add_class(SWITCHES[:2], np.nan),
            "label must be one name, .* got nan",
        ),
        (lambda: ThresholdEncoder(MANY).fit(FRAMES[0]), "strategy must be quantile, even or supervised"),  # type: ignore[arg-type]
        (lambda: ThresholdEncoder(levels="4").fit(FRAMES[0]), "levels must lie between 1 and 1024, got '4'"),  # type: ignore[arg-type]
        (lambda: ThresholdEncoder(levels=2.5).fit(FRAMES[0]), "levels must lie between 1 and 1024, got 2.5"),  # type: ignore[arg-type]
        (
            lambda: ThresholdEncoder().fit(FRAMES[0]).beyond([1.0, 2.0]),
            r"values must be numbers of shape .n_samples, 8.",
        ),
        (lambda: ThresholdEncoder().fit(FRAMES[0]).beyond(1j * FRAMES[0]), "values must be numbers of shape"),
        (lambda: Sensor(polarity=MANY), "polarity of a sensor must be up or down"),
        (lambda: Sensor(response="linear"), "response of a sensor must be one of varishold.sensor.RESPONSES, got str"),
        (lambda: Sensor(calibration=MANY), "calibration of a sensor must be a Mapping, what was measured, by name"),
        (lambda: Sensor().stress([[1], [1, 2]]), r"readings must be numbers of shape .* got rows of different lengths"),
        (lambda: Sensor().undo([[1], [1, 2]]), r"readings must be numbers of shape .* got rows of different lengths"),
        (lambda: Sensor().undo(MANY, valid=MANY), "valid must be True or False for each taxel, got float64"),
        (lambda: Sensor().undo(MANY, valid=True), r"valid must have the shape of a frame, \(3, 3\), got"),
        (lambda: Taxels(noise=MANY), "noise of taxels must be finite and not negative"),
        (lambda: Taxels(dead=None), "dead of taxels must be finite and not negative, got None"),
        (lambda: Taxels().read([[1.0], [1.0, 2.0]]), "stress must have shape .* got rows of different lengths"),
        (lambda: Taxels().read(1j * MANY), "stress must have shape .* got complex128"),
        (lambda: Taxels(noise=0.1).read(np.inf * MANY), r"stress must be numbers within \+-1e\+100"),
        (lambda: press(Sphere(0.02), Skin("half-space"), depth=1e-3, pose=MANY), "pose must be a Pose, as Pose"),
        (lambda: reconstruct(1e308 * MANY, Skin("half-space"), pitch=1e-3), r"within \+-1e\+100, got 1e\+308"),
        (lambda: switch_values(MANY), "switches must be True, False or None by name, got ndarray"),
        (lambda: grip_size(MANY), "contacts must be a GripContacts, where a hand's parts touch, got ndarray"),
    ],
)
def test_it_is_refused_in_one_line(call: Callable[[], Any], says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("ask", [lambda c: c.explain(SWITCHES[0]), lambda c: c.outside([0.1]), lambda c: c.remarks_])
def test_what_was_not_fitted_says_so(ask: Callable[[HyperplaneClassifier], Any]) -> None:
    with pytest.raises(NotFittedError, match="not fitted yet"):
        ask(HyperplaneClassifier())


def test_a_table_takes_whole_numbers_and_lists() -> None:
    whole, plain = (table(f=of) for of in (np.arange(6), np.arange(6.0)))
    np.testing.assert_array_equal(whole.numbers("f"), plain.numbers("f"))
    assert table(f=[0, 1, 2, 3, 4, 5]).numbers("f").tolist() == plain.numbers("f").tolist()
    models = [fit_model(each, label="what", columns="f", encode="even", levels=3) for each in (whole, plain)]
    assert models[0].netlist == models[1].netlist


def test_names_of_classes_may_be_numbers_of_any_kind() -> None:
    y = np.array([1, 2, 3, 1, 2, 3], np.uint8)
    assert HyperplaneClassifier("vote").fit(SWITCHES, y).add_class(SWITCHES[:2], 7).classes_.tolist() == [1, 2, 3, 7]
    named = HyperplaneClassifier("vote").fit(SWITCHES, OBJECTS.astype(object)).add_class(SWITCHES[:2], "d")
    assert named.classes_.tolist() == ["a", "b", "c", "d"]
