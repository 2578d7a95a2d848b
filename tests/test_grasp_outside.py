"""What is said of grasps outside of what was learned: other objects, unknown switches, numbers out of range."""

from __future__ import annotations

import json
import sys
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold.cli import main
from varishold.errors import InputError
from varishold.grasp import HyperplaneClassifier, ThresholdEncoder, fit_model, read_model, write_model
from varishold.grasp.likelihood import GraspLikelihood
from varishold.recording import GraspTable, write_grasp_table

seeds = st.integers(0, 2**32 - 1)


def grasps(
    rng: np.random.Generator, n: int, typical: NDArray[np.bool_], flips: float = 0.1
) -> tuple[NDArray[np.bool_], NDArray[np.str_]]:
    kind = np.arange(n) % len(typical)
    return typical[kind] ^ (rng.random((n, typical.shape[1])) < flips), np.array(list("abcdef"))[kind]


def table_of(values: NDArray[np.float64], kind: NDArray[np.int64], **more: Any) -> GraspTable:
    cells: dict[str, Any] = {"what": np.array(["hard", "soft"])[kind], **more}
    return GraspTable(cells | {f"force_n.f{k}": values[:, k] for k in range(values.shape[1])})


@settings(max_examples=30)
@given(seeds, st.sampled_from([0.02, 0.05, 0.3]))
def test_what_is_rejected_is_never_promised(seed: int, error: float) -> None:
    rng = np.random.default_rng(seed)
    X, y = grasps(rng, int(rng.integers(4, 60)), rng.random((2 + seed % 3, 12)) < 0.5)
    clf = HyperplaneClassifier("vote", max_hyperplanes=20, error=error).fit(X, y)
    asked = np.concatenate([X, rng.random((40, 12)) < 0.5])
    labels, p, p_values = clf.judge(asked)
    _, rejected = clf.predict_or_reject(asked)
    np.testing.assert_array_equal(rejected, p_values <= max(error, 1 / (1 + clf._likelihood.n_known)))
    assert (p.max(axis=1)[rejected] <= 0.9).all()
    np.testing.assert_array_equal(p, clf.predict_proba(asked))
    np.testing.assert_array_equal(labels, clf.predict(asked))
    np.testing.assert_array_equal(labels, clf.classes_[p.argmax(axis=1)])


def test_known_grasps_are_rejected_as_often_as_stated_and_strange_ones_more() -> None:
    rng = np.random.default_rng(0)
    known, strange = [], []
    for _ in range(60):
        typical = rng.random((4, 24)) < 0.5
        X, y = grasps(rng, 59, typical[:2])
        clf = HyperplaneClassifier("vote", max_hyperplanes=10).fit(X, y)
        known += clf.judge(grasps(rng, 20, typical[:2])[0])[2].tolist()
        strange += clf.judge(grasps(rng, 20, typical[2:])[0])[2].tolist()
    for error in (0.05, 0.1, 0.3):
        assert np.mean(np.array(known) <= error) <= error + 0.02
    assert np.mean(np.array(strange) <= 0.05) > 0.9


@pytest.mark.parametrize(("n_switches", "flips"), [(3, 0.2), (4, 0.3), (8, 0.1)])
def test_answers_above_nine_in_ten_are_right_where_patterns_of_objects_are_alike(n_switches: int, flips: float) -> None:
    right, told, missed = [], [], []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        typical = rng.random((2, n_switches)) < 0.5
        clf = HyperplaneClassifier("vote").fit(*grasps(rng, 120, typical, flips))
        asked, truth = grasps(rng, 400, typical, flips)
        labels, p, _ = clf.judge(asked)
        sure = p.max(axis=1) > 0.9
        right += (labels == truth)[sure].tolist()
        told += p.max(axis=1).tolist()
        missed += (labels == truth).tolist()
    assert np.mean(right) > 0.9
    assert abs(np.mean(told) - np.mean(missed)) < 0.04


def test_a_pattern_that_two_objects_gave_is_as_probable_as_it_was_of_each() -> None:
    X = np.repeat([[0, 0, 0, 0, 0, 0], [1, 1, 1, 1, 1, 1], [1, 1, 1, 0, 0, 0]], [20, 20, 40], axis=0)
    y = np.repeat(["a", "b", "a", "b"], [20, 20, 30, 10])
    labels, p, _ = HyperplaneClassifier("vote").fit(X, y).judge([[1, 1, 1, 0, 0, 0]])
    assert labels[0] == "a"
    # 30 of the 50 grasps of a gave it, and 10 of the 30 of b.
    np.testing.assert_allclose(p[0, 0], (30 / 50) / (30 / 50 + 10 / 30), atol=0.02)


def test_nothing_is_promised_where_no_object_was_felt_in_two_groups() -> None:
    rng = np.random.default_rng(3)
    X, y = grasps(rng, 40, rng.random((2, 22)) < 0.5)
    for groups, said in ((np.zeros(40), "grasps of two groups"), (y, "grasps of two groups"), (np.arange(40), None)):
        clf = HyperplaneClassifier("vote").fit(X, y, groups)
        remark = f"no object has {said}, which tell how grasps of one differ: no answer has a p above .9"
        assert (remark in clf.remarks_) == (said is not None)
        top = clf.predict_proba(np.concatenate([X, rng.random((99, 22)) < 0.5])).max()
        assert top <= 0.9 if said else top > 0.99
    one_each = HyperplaneClassifier("vote").fit([[0] * 22, [1] * 22], ["a", "b"])
    assert one_each.predict_proba([[0] * 22]).max() <= 0.9
    assert any(remark.startswith("no object has two grasps, which tell") for remark in one_each.remarks_)


def test_sessions_are_held_out_whole() -> None:
    rng = np.random.default_rng(1)
    typical = rng.random((2, 30)) < 0.5
    session = np.repeat(np.arange(4), 10)
    # Each session reads some switches wrongly of its own.
    off = rng.random((5, 30)) < 0.15
    X, y = grasps(rng, 40, typical, 0.02)
    X ^= off[session]
    tomorrow, truth = grasps(rng, 200, typical, 0.02)
    tomorrow ^= off[4]
    alone, whole = (HyperplaneClassifier("vote", max_hyperplanes=20).fit(X, y, g) for g in (None, session))
    assert alone.netlist_ == whole.netlist_
    rejected = [clf.predict_or_reject(tomorrow)[1].mean() for clf in (alone, whole)]
    assert rejected[0] > 0.5 > rejected[1] + 0.3
    sure = [(clf.predict_proba(tomorrow).max(axis=1)).mean() for clf in (alone, whole)]
    assert sure[0] < sure[1] <= (whole.predict(tomorrow) == truth).mean() + 0.02
    with pytest.raises(InputError, match=r"groups must be one a grasp, 40 of them, got shape \(3,\)"):
        HyperplaneClassifier().fit(X, y, [1, 2, 3])
    added = whole.add_class(~typical[:1].repeat(3, axis=0), "c")
    assert len(added._groups) == 43


def test_a_class_that_is_added_keeps_how_far_grasps_lay_beyond_the_others() -> None:
    rng = np.random.default_rng(4)
    kind = np.arange(30) % 2
    table = table_of(rng.normal(3.0 * kind[:, None], 1.0, (30, 3)), kind)
    clf = fit_model(table, label="what", encode="quantile").classifier
    before = clf._beyond.tolist()
    assert max(before) > 0
    clf.add_class(clf._rows[:3], "wet")
    assert clf._beyond.tolist() == [*before, 0, 0, 0]
    clf.add_class(clf._rows[:2], "wet", beyond=[0.5, 2.0])
    assert clf._beyond.tolist() == [*before, 0, 0, 0, 0.5, 2.0]
    held = clf._likelihood.held
    assert held is not None
    assert held.beyond.max() == max([*before, 2.0])


@pytest.mark.parametrize("beyond", [[1.0], [[0.0], [0.0]], -1.0, np.nan, np.inf, "far", [None, 1]])
def test_beyond_is_a_number_for_each_grasp(beyond: Any) -> None:
    clf = HyperplaneClassifier("vote").fit([[0, 1], [1, 0]], ["a", "b"])
    for asked in (
        lambda: clf.judge([[0, 1], [1, 1]], beyond=beyond),
        lambda: clf.add_class(np.eye(2), "c", beyond=beyond),
    ):
        with pytest.raises(InputError, match=r"beyond must be a number from 0 to 1e\+100 for each of 2 grasps"):
            asked()


@settings(max_examples=25)
@given(seeds, st.integers(1, 9))
def test_a_grasp_is_judged_by_the_switches_that_are_known(seed: int, n_unknown: int) -> None:
    rng = np.random.default_rng(seed)
    X, y = grasps(rng, 30, rng.random((2, 10)) < 0.5)
    clf = HyperplaneClassifier("vote", max_hyperplanes=10).fit(X, y)
    whole = clf._likelihood
    hidden = np.isin(np.arange(10), rng.permutation(10)[:n_unknown])
    part = GraspLikelihood(whole.patterns[:, ~hidden], whole.labels, whole.weights, 2, whole.beta, whole.held)
    asked = rng.random((5, 10)) < 0.5
    posterior, expected = part.judge(asked[:, ~hidden])
    holes = np.where(hidden, np.nan, asked)
    labels, p, p_values = clf.judge(holes)
    np.testing.assert_allclose(p_values, expected)
    inside = ~clf.outside(p_values) & (labels == clf.classes_[clf._class_of[posterior.argmax(axis=1)]])
    np.testing.assert_allclose(p[inside], posterior[:, np.argsort(clf._class_of)][inside], rtol=1e-6)
    np.testing.assert_allclose(p.sum(axis=1), 1)
    # The circuit is given what the nearest training grasp read, and answers for one of the fillings.
    for row, label in zip(asked, labels, strict=True):
        filled = np.tile(row, (2**n_unknown, 1))
        filled[:, hidden] = list(product((0, 1), repeat=n_unknown))
        assert label in set(clf.predict(filled).tolist())
        assert clf.explain(np.where(hidden, np.nan, row)).label == label
    with pytest.raises(ValueError, match="NaN"):
        clf.predict(holes)


def test_rows_that_lack_different_switches_are_judged_one_by_one() -> None:
    rng = np.random.default_rng(2)
    X, y = grasps(rng, 60, rng.random((3, 20)) < 0.5)
    clf = HyperplaneClassifier().fit(X, y)
    holes = np.where(rng.random((12, 20)) < 0.2, np.nan, X[:12])
    holes[0] = np.nan
    together = clf.judge(holes)
    for k in range(12):
        (label,), (p,), (p_value,) = clf.judge(holes[k : k + 1])
        assert (label, p_value) == (together[0][k], together[2][k])
        np.testing.assert_allclose(p, together[1][k], rtol=1e-9)
    # Of a grasp of which nothing is known nothing is said.
    assert together[2][0] == 1.0
    np.testing.assert_allclose(together[1][0], 1 / 3)


@settings(max_examples=20)
@given(seeds, st.sampled_from(["quantile", "even", "supervised"]))
def test_the_farther_beyond_the_stranger(seed: int, encode: str) -> None:
    rng = np.random.default_rng(seed)
    kind = np.arange(40) % 2
    values = rng.normal(2.0 * kind[:, None], 1.0, (40, 3))
    model = fit_model(table_of(values, kind), label="what", encode=encode)
    asked = np.tile(values[:1], (4, 1))
    asked[:, 1] = values[:, 1].max() + np.array([0.0, 0.1, 5.0, 1e6])
    answers = list(model.answer(table_of(asked, np.zeros(4, np.int64))))
    p_values = [answer.p_value for answer in answers]
    assert p_values == sorted(p_values, reverse=True)
    assert [answer.outside for answer in answers] == [()] + [("force_n.f1",)] * 3
    assert answers[3].p_value == 1 / (1 + model.classifier._likelihood.n_known)
    assert answers[3].rejected
    assert answers[3].probability <= 0.9
    assert len({answer.object for answer in answers}) == 1, "the circuit compares alike beyond the last threshold"


def test_an_encoder_goes_on_counting_beyond_its_range() -> None:
    encoder = ThresholdEncoder("even", levels=4).fit([[0.0, 7.0], [10.0, 7.0]])
    asked = [[5.0, 7.0], [15.0, 7.0], [-10.0, 8.0], [np.nan, np.nan]]
    np.testing.assert_allclose(encoder.beyond(asked), [[0, 0], [2, 0], [4, 4], [0, 0]])


def test_a_model_answers_unknown_cells_and_its_file_keeps_all(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    kind = np.arange(60) % 2
    values = rng.normal(3.0 * kind[:, None], 1.0, (60, 4))
    day = np.array(["mon", "tue", "wed"])[np.arange(60) // 20]
    model = fit_model(table_of(values, kind, day=day), label="what", group="day", encode="even")
    assert model.columns == tuple(f"force_n.f{k}" for k in range(4))
    assert len(np.unique(model.classifier._groups)) == 3
    holes = values[:6].copy()
    holes[1, 2] = holes[2, :] = np.nan
    answers = list(model.answer(table_of(holes, kind[:6])))
    assert answers[0].outside == ()
    assert answers[1].outside == ("force_n.f2",)
    assert answers[2].outside == model.columns
    assert answers[2].probability == pytest.approx(0.5)
    assert answers[2].rejected, "nothing is known of it"
    assert not answers[0].rejected
    write_model(model, tmp_path / "model.json")
    assert list(read_model(tmp_path / "model.json").answer(table_of(holes, kind[:6]))) == answers


def test_a_file_of_the_first_version_is_read(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    kind = np.arange(40) % 2
    table = table_of(rng.normal(3.0 * kind[:, None], 1.0, (40, 2)), kind)
    path = tmp_path / "model.json"
    for encode in ("even", None):
        if encode is None:
            table = GraspTable({"what": table.cells["what"], "switch.a": kind == 1, "switch.b": rng.random(40) < 0.5})
        model = fit_model(table, label="what", encode=encode)
        write_model(model, path)
        document = json.loads(path.read_text())
        for key in ("groups", "beyond", "checksum"):
            del document[key]
        if encode:
            del document["encoder"]["ranges"]
        path.write_text(json.dumps({**document, "version": 1}))
        old = read_model(path)
        assert old.netlist == model.netlist
        now, then = list(model.answer(table)), list(old.answer(table))
        assert [answer.object for answer in then] == [answer.object for answer in now]
        assert not any(answer.outside for answer in then)
        if encode is None:
            assert then == now


def test_the_command_says_what_is_outside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> str:
        monkeypatch.setattr(sys, "argv", ["varishold", "grasp", *words])
        with pytest.raises(SystemExit) as left:
            main()
        assert not left.value.code
        return capsys.readouterr().out

    rng = np.random.default_rng(5)
    X, y = grasps(rng, 40, rng.random((2, 12)) < 0.5)
    cells: dict[str, Any] = {"object": y, "day": np.repeat(["mon", "tue"], 20)}
    write_grasp_table(GraspTable(cells | {f"switch.s{k}": X[:, k] for k in range(12)}), tmp_path / "train.csv")
    columns = ("--columns", "switch.*")
    for more in ((), columns):
        run("fit", "train.csv", "--label", "object", "--group", "day", *more, "-o", "model.json")
        assert len(set(json.loads(Path("model.json").read_text())["groups"])) == 2
    header = Path("train.csv").read_text().splitlines()[0]
    rows = ["a,mon," + ",".join("01"[int(on)] for on in X[0]), "a,mon" + "," * 12]
    Path("new.csv").write_text("\n".join([header, *rows]) + "\n")
    known, nothing = (json.loads(line) for line in run("predict", "model.json", "new.csv", "--json").splitlines())
    assert list(known) == ["row", "object", "probability", "rejected", "p_value", "outside", "file"]
    assert (known["rejected"], known["outside"]) == (False, [])
    assert nothing["outside"] == [f"switch.s{k}" for k in range(12)]
    assert nothing["probability"] == 0.5
    with pytest.raises(InputError, match="no column 'week'"):
        fit_model(GraspTable({"object": y, "switch.s": X[:, 0]}), label="object", group="week")
