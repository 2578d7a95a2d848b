"""Peers choose their settings by plain counting inside the training part; the yardstick's scores are plain means."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.plain_learner import press_of

from varishold.evaluation import peers, running
from varishold.evaluation.features import FEATURES, feature_table, pooled_frames
from varishold.evaluation.figures import difference_figure, mean_figure, share_figure
from varishold.evaluation.held_out import Felt, Said
from varishold.evaluation.peers import LEARNERS, Peer, all_peers, answer_peers
from varishold.evaluation.scores import calibration_error
from varishold.evaluation.splits import Split, split_presses
from varishold.evaluation.yardstick import scoring
from varishold.evaluation.yardstick.answers import Told, outline_of, read_answer
from varishold.evaluation.yardstick.forms import Change
from varishold.evaluation.yardstick.rows import Row
from varishold.evaluation.yardstick.scoring import RowScore, ShapeScore, YardstickScore, score_functions
from varishold.touch import NAMES
from varishold.touch.names import OUTLINE_OF, OUTLINES

Floats = np.ndarray[Any, np.dtype[np.float64]]


class Threshold:
    """Says 1 above a threshold of the first feature, 0 below."""

    seen: list[Floats] = []  # noqa: RUF012

    def __init__(self, at: float) -> None:
        self.at = at

    def fit(self, X: Floats, y: Any) -> None:
        Threshold.seen.append(np.array(X))
        self.classes_ = np.array([0, 1])

    def predict_proba(self, X: Floats) -> Floats:
        above = np.asarray(X)[:, 0] > self.at
        return np.stack([~above, above], axis=1).astype(float)


def setting(at: float, *, standardized: bool = False, log: list[tuple[int, int]] | None = None) -> Any:
    def make(seed: int, n: int) -> Threshold:
        if log is not None:
            log.append((seed, n))
        return Threshold(at)

    return SimpleNamespace(standardized=standardized, make=make)


def test_the_first_of_the_settings_that_name_most_is_taken() -> None:
    train = np.arange(10.0)[:, None]
    codes, fold = (np.arange(10) > 4).astype(int), np.arange(10) % 3
    test = np.array([[4.0], [4.7], [9.0]])
    for settings, at in (((9.0, 4.5, 4.2), 4.5), ((4.2, 4.5, 9.0), 4.2), ((3.5, 5.5), 3.5), ((0.0, 6.5, 9.0), 6.5)):
        told, classes = peers._learn_and_answer([setting(one) for one in settings], train, codes, test, fold, 0)
        assert classes.tolist() == [0, 1]
        assert told.argmax(axis=1).tolist() == [int(x > at) for x in test[:, 0]]
    first, _ = peers._learn_and_answer([setting(9.0), setting(4.5)], train, codes, test, None, 0)
    assert first.argmax(axis=1).tolist() == [0, 0, 0]
    log: list[tuple[int, int]] = []
    peers._learn_and_answer([setting(4.5, log=log)], train, codes, test, fold, 7)
    assert log == [(7, 6), (7, 7), (7, 7), (7, 10)]


def test_a_setting_is_standardized_by_what_it_learns_from() -> None:
    rng = np.random.default_rng(0)
    train, test = rng.normal(5, 3, (20, 3)), rng.normal(5, 3, (4, 3))
    train[:, 1], test[:, 1] = 1e6, 1e6 + 1
    Threshold.seen.clear()
    told, _ = peers._fitted(setting(0.5, standardized=True), train, np.arange(20) % 2, test, 0)
    (seen,) = Threshold.seen
    assert seen.mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
    assert seen.std(axis=0) == pytest.approx([1, 0, 1])
    scaled = (test[:, 0] - train[:, 0].mean()) / train[:, 0].std()
    assert told.argmax(axis=1).tolist() == (scaled > 0.5).astype(int).tolist()
    peers._fitted(setting(0.5), train, np.arange(20) % 2, test, 0)
    assert np.array_equal(Threshold.seen[1], train)


def test_what_is_not_known_is_taken_at_the_mean_of_the_training_presses() -> None:
    nan = math.nan
    table = np.array([[1.0, nan, nan], [3.0, 4.0, nan], [nan, 8.0, nan], [100.0, nan, nan]])
    assert peers._known(table, 3).tolist() == [[1, 6, 0], [3, 4, 0], [2, 8, 0], [100, 6, 0]]


def test_settings_are_chosen_over_groups_where_there_are_some() -> None:
    codes = np.tile([0, 1], 6)
    presses = [press_of(k) for k in range(12)]
    groups = np.repeat(["a", "b", "c"], 4)
    grouped, plain = (Felt(presses, codes, np.array(["x", "y"]), one) for one in (groups, None))
    fold = peers._inner_folds(grouped, np.arange(12))
    assert fold is not None
    assert [len(set(fold[groups == group])) for group in "abc"] == [1, 1, 1]
    assert len(set(fold)) == 3
    dealt = peers._inner_folds(plain, np.arange(12))
    assert dealt is not None
    assert len(set(dealt)) == 3
    # One press of a thing cannot be held out from the other.
    assert peers._inner_folds(plain, np.array([0, 1, 2])) is None
    assert peers._inner_folds(plain, np.array([0, 1, 2, 3])) is not None


def test_every_learner_is_what_it_is_called() -> None:
    kinds = {"nearest neighbour": "KNeighborsClassifier", "logistic regression": "LogisticRegression"}
    for name, settings in LEARNERS.items():
        made = [one.make(3, 4) for one in settings]
        if name in kinds:
            assert {type(one).__name__ for one in made} == {kinds[name]}
    near = [(one.standardized, one.make(0, 4).n_neighbors) for one in LEARNERS["nearest neighbour"]]
    assert near == [(False, 1), (False, 3), (False, 4), (True, 1), (True, 3), (True, 4)]
    assert [one.make(0, 99).n_neighbors for one in LEARNERS["nearest neighbour"][:3]] == [1, 3, 5]
    assert {one.make(0, 9).weights for one in LEARNERS["nearest neighbour"]} == {"distance"}
    trees = [one.make(3, 9) for one in LEARNERS["forest"]]
    assert [type(one).__name__ for one in trees] == ["ExtraTreesClassifier", "RandomForestClassifier"]
    assert {(one.n_estimators, one.random_state) for one in trees} == {(200, 3)}
    lines = [one.make(0, 9) for one in LEARNERS["logistic regression"]]
    assert [one.C for one in lines] == [0.01, 0.1, 1, 10, 100]
    assert all(one.standardized for one in LEARNERS["logistic regression"])
    assert not any(one.standardized for one in LEARNERS["forest"])
    assert [(one.features, one.learner) for one in all_peers()] == [(f, name) for f in FEATURES for name in LEARNERS]
    assert peers.N_PEERS == len(all_peers()) == 9


def test_peers_answer_each_fold_from_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[Floats, Any, Floats]] = []

    def learned(_: Any, train: Floats, codes: Any, test: Floats, *rest: Any) -> tuple[Floats, Any]:
        asked.append((train, codes, test))
        return np.tile([0.25, 0.75], (len(test), 1)), np.array([0, 2])

    monkeypatch.setattr(peers, "_learn_and_answer", learned)
    codes = np.tile([0, 1, 2], 6)
    presses = [press_of(5 + k, **{"angle_rad.j": float(k)}) for k in range(18)]
    felt = Felt(presses, codes, np.array(list("xyz")), np.repeat(["a", "b", "c"], 6))
    split = split_presses(felt.classes[codes], felt.groups)
    ticks: list[int] = []
    some = [Peer("raw frame", "forest"), Peer("moments", "forest")]
    said = answer_peers(some, felt, split, seed=0, tick=lambda: ticks.append(1))
    assert len(ticks) == len(asked) == 6
    assert len(said) == 2
    assert all((one == [0.25, 0, 0.75]).all() for one in said)
    for k, (train, test) in enumerate(split.parts()):
        rows = [*train.tolist(), *test.tolist()]
        for (learned_from, told, answered), peer in zip(asked[2 * k : 2 * k + 2], some, strict=True):
            assert told.tolist() == codes[train].tolist()
            both = np.concatenate([learned_from, answered])
            assert both[:, -1].tolist() == rows
            if peer.features == "raw frame":
                mine = [presses[row] for row in rows]
                pooled = pooled_frames(mine, mine[0].shapes, 0.0)
                assert both == pytest.approx(feature_table("raw frame", pooled, mine, ["angle_rad.j"], 0.0))
    asked.clear()
    chosen = [train[:4] for train, _ in split.parts()]
    chosen[1] = np.array([0, 3])  # one thing only: nothing can be told
    (few,) = answer_peers(some[:1], felt, split, seed=0, chosen=chosen)
    assert [train[:, -1].tolist() for train, _, _ in asked] == [chosen[0].tolist(), chosen[2].tolist()]
    assert (few[split.fold == 1] == 0).all()
    assert (few[split.fold != 1] == [0.25, 0, 0.75]).all()


# ---- the yardstick's scores


ROWS = (Row("clean"), Row("tilted", change=Change(tilt=5.0)), Row("lost", counted=False))


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> dict[bytes, tuple[str, ...]]:
    """A yardstick of three rows, each frame a number; what is true of it."""
    truths: dict[bytes, tuple[str, ...]] = {}
    rng = np.random.default_rng(0)

    def clean(medium: str, side: int, change: Change, frames: int, seed: int, *, tick: Any) -> tuple[Floats, Any]:
        for _ in scoring.KINDS:
            tick()
        return np.full((13 * frames, 2, 2), len(medium) + 100.0 * side), np.repeat(scoring.KINDS, frames)

    def distort(row: Row, drawn: Floats, kinds: Any, medium: str, seed: int) -> tuple[Floats, list[tuple[str, ...]]]:
        read = drawn + rng.random((len(drawn), 1, 1))
        names = [
            ("ridge" if kind == "hip" else str(kind), *(("plane",) if k % 5 == 0 else ()))
            for k, kind in enumerate(kinds)
        ]
        truths.update({frame.tobytes(): name for frame, name in zip(read, names, strict=True)})
        return read, names

    monkeypatch.setattr(scoring, "ROWS", ROWS)
    monkeypatch.setattr(scoring, "clean_frames", clean)
    monkeypatch.setattr(scoring, "distorted", distort)
    return truths


@pytest.mark.parametrize("frames", [1, 3])
def test_scores_are_means_over_rows_and_objects(small: dict[bytes, tuple[str, ...]], frames: int) -> None:
    rng = np.random.default_rng(1)
    asked: list[tuple[bytes, object]] = []

    def says(frame: Floats) -> object:
        name = str(rng.choice([*NAMES, "unknown", "unknown"]))
        p = float(rng.choice([0.3, 0.9, 0.95, 1.0]))
        answer: object = {name: p}
        if rng.random() < 0.3:
            answer = (answer, str(rng.choice(OUTLINES)))
        asked.append((frame.tobytes(), answer))
        return answer

    ticks: list[dict[str, int]] = []
    (found,) = score_functions(
        {"f": says}, shapes=[(16, 16), (32, 32)], frames=frames, seed=3, tick=lambda **t: ticks.append(t)
    )
    each = 2 * 13 * frames
    assert len(asked) == 2 * 3 * each
    assert ticks[0]["total"] == sum(t["advance"] for t in ticks[1:]) == 2 * (2 + 3) * each
    # Each shape: both rows without a change on one medium, then on the other; then the tilted one.
    order = ["clean", "lost", "clean", "lost", "tilted", "tilted"]
    for s, one in enumerate(found.shapes):
        told: dict[str, list[tuple[Told, tuple[str, ...]]]] = {row.name: [] for row in ROWS}
        at = s * 3 * each
        for name in order:
            for frame, answer in asked[at : at + each // 2]:
                told[name].append((read_answer(answer), small[frame]))
            at += each // 2
        for row, score in zip(ROWS, one.rows, strict=True):
            pairs = told[row.name]
            assert (score.name, score.counted, score.frames) == (row.name, row.counted, each)
            assert score.right == pytest.approx(np.mean([t.name in true for t, true in pairs]))
            outlines = [{OUTLINE_OF[name] for name in true} for _, true in pairs]
            assert [outline_of(true) for _, true in pairs] == outlines
            assert score.outline == pytest.approx(
                np.mean([t.outline in known for (t, _), known in zip(pairs, outlines, strict=True)])
            )
            assert score.unknown == pytest.approx(np.mean([t.name == "unknown" for t, _ in pairs]))
            wrong = [t.name not in true and t.name != "unknown" and t.probability > 0.9 for t, true in pairs]
            assert score.sure_wrong == pytest.approx(np.mean(wrong))
        counted = [told["clean"], told["tilted"]]
        right = [[t.name in true for t, true in pairs] for pairs in counted]
        objects = np.tile(np.arange(each), 2)
        assert one.right == share_figure(np.array(right).ravel(), objects)
        stated = np.array([t.probability for pairs in counted for t, _ in pairs])
        assert one.calibration_error == pytest.approx(calibration_error(stated, np.array(right).ravel()))
        for name in ("outline", "unknown", "sure_wrong"):
            mean = (getattr(one.rows[0], name) + getattr(one.rows[1], name)) / 2
            assert getattr(one, name) == pytest.approx(mean)
        assert (one.shape, one.noise) == (((16, 16), 0.02), ((32, 32), 0.01))[s]


def test_json_of_a_score_holds_it_to_six_digits() -> None:
    figure = share_figure(np.array([True, False, True, True]))
    rows = (RowScore("a", True, 4, 1 / 3, 2 / 3, 1 / 7, 2 / 7), RowScore("b", False, 4, 0.5, 0.25, 0.0, 0.0))
    shape = ShapeScore((16, 16), 0.02, rows, figure, 1 / 9, 2 / 9, 4 / 9, 5 / 9)
    told = YardstickScore("f", 40, 1972, (shape,)).to_dict()
    assert (told["tested"], told["standard"], told["seed"], told["frames_of_each_form"]) == ("f", True, 1972, 40)
    (one,) = told["shapes"]
    assert (one["shape"], one["noise"]) == ([16, 16], 0.02)
    assert one["rows"][0] == {
        "name": "a",
        "counted": True,
        "frames": 4,
        "right": 0.333333,
        "outline": 0.666667,
        "unknown": 0.142857,
        "sure_wrong": 0.285714,
    }
    assert figure.low is not None
    assert figure.high is not None
    assert one["score"] == {
        "right": 0.75,
        "outline": 0.111111,
        "unknown": 0.222222,
        "sure_wrong": 0.444444,
        "right_low": round(figure.low, 6),
        "right_high": round(figure.high, 6),
        "calibration_error": 0.555556,
        "counted_rows": 1,
    }


@pytest.mark.parametrize("outline", [None, *OUTLINES])
def test_an_answers_name_and_outline_are_the_likeliest(outline: str | None) -> None:
    rng = np.random.default_rng(0)
    for _ in range(60):
        p = rng.dirichlet(np.full(len(NAMES), 0.4)) * rng.choice([1.0, 0.5])
        given = dict(zip(NAMES, p.tolist(), strict=True))
        told = read_answer(given if outline is None else (given, outline))
        merged = {name: q + (given["hip"] if name == "ridge" else 0.0) for name, q in given.items() if name != "hip"}
        assert told.probability == pytest.approx(max(merged.values()))
        assert merged[told.name] == max(merged.values())
        shares = {one: sum(q for name, q in merged.items() if OUTLINE_OF[name] == one) for one in OUTLINES}  # type: ignore[index]
        assert told.outline == (max(shares, key=shares.__getitem__) if outline is None else outline)


@pytest.mark.parametrize("grouped", [True, False])
def test_peers_are_compared_press_by_press_over_the_same_groups_the_best_first(
    monkeypatch: pytest.MonkeyPatch, grouped: bool
) -> None:
    rng = np.random.default_rng(2)
    codes = np.tile([0, 1, 2], 12)
    groups = np.repeat(["a", "b", "c", "d"], 9) if grouped else None
    felt = Felt([press_of(k) for k in range(36)], codes, np.array(list("xyz")), groups)
    known = rng.random(36) < 0.9
    split = Split("groups", np.repeat([0, 1, 2, 3], 9), known, codes)
    mine, *others = (rng.dirichlet([0.4, 0.4, 0.4], 36) for _ in range(1 + peers.N_PEERS))
    monkeypatch.setattr(running, "answer_peers", lambda *_, **__: others)
    found = running._peer_scores(felt, split, Said(mine, np.ones(36), {}), 0, 1, lambda: None)
    assert len(found) == 9
    mine_right = (mine.argmax(axis=1) == codes)[known]
    told = {(one.features, one.learner): one for one in found}
    over = None if groups is None else groups[known]
    for peer, answers in zip(all_peers(), others, strict=True):
        one = told[peer.features, peer.learner]
        right = (answers.argmax(axis=1) == codes)[known]
        assert one.right == share_figure(right, over)
        assert one.ahead == difference_figure(mine_right, right, over)
        loss = [-math.log(max(row[code], 1e-12)) for row, code in zip(answers[known], codes[known], strict=True)]
        assert one.log_loss.to_dict() == mean_figure(loss, over).to_dict()
        assert one.calibration_error == pytest.approx(calibration_error(answers[known].max(axis=1), right))
        assert one.right.over == ("groups" if grouped else "presses")
    order = [(-one.right.value, one.log_loss.value) for one in found]
    assert order == sorted(order)
