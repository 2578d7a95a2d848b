"""An evaluation followed with a pencil: who learned from what, what was said, and every figure and remark of it."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.evaluation_made import made
from tests.plain_learner import PlainLearner, number_of, press_of

from varishold import Pad, Recording
from varishold.errors import InputError
from varishold.evaluation import Evaluation, evaluate, evaluate_model, evaluate_shipped, given, running
from varishold.evaluation.figures import share_figure
from varishold.evaluation.held_out import Felt, answer_strangers, n_strangers
from varishold.evaluation.result import StrangerScore
from varishold.evaluation.running import interval_remarks, stranger_score
from varishold.evaluation.scores import Answers, score
from varishold.evaluation.shots import SHOTS, draw_shots, shots_curve
from varishold.evaluation.splits import Split, split_presses
from varishold.touch import NAMES
from varishold.touch.course.presses import Press


@pytest.fixture(autouse=True)
def nothing_leaks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leaks have tests of their own, which take longer."""

    def none(*told: Any, tick: Any, **_: Any) -> tuple[()]:
        for _k in range(3):
            tick()
        return ()

    monkeypatch.setattr(running, "find_leaks", none)
    PlainLearner.learned.clear()


def things_felt(n_things: int, n_groups: int, each: int = 3, seed: int = 0) -> tuple[list[Press], list[str], list[str]]:
    rng = np.random.default_rng(seed)
    labels = [f"t{k:02}" for _ in range(n_groups) for k in range(n_things) for _ in range(each)]
    groups = [f"g{g:02}" for g in range(n_groups) for _ in range(n_things * each)]
    numbers = [int(label[1:]) + rng.normal(0, 0.8) + 20 for label in labels]
    return [press_of(number) for number in numbers], labels, groups


def learned_from(presses: list[Press], labels: list[str], rows: list[int], sharp: float = 1.0) -> PlainLearner:
    learner = PlainLearner(sharp).fit([presses[k] for k in rows], [labels[k] for k in rows])
    PlainLearner.learned.pop()
    return learner


def share(figure: Any) -> tuple[float, int]:
    return figure.value, figure.n


def plainly(**how: Any) -> Evaluation:
    return evaluate(classifier=PlainLearner(), peers=False, **how)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", [0, 1])
def test_an_evaluation_is_that_of_plain_loops(seed: int) -> None:
    presses, labels, groups = things_felt(4, 3, seed=seed)
    # A fifth thing of one group, which is unknown where that is held out.
    alone = [press_of(23.4), press_of(29.0), press_of(31.0)]
    presses, labels, groups = [*presses, *alone], [*labels, *["odd"] * 3], [*groups, *["g01"] * 3]
    found = plainly(X=presses, y=labels, groups=groups, shots=(), seed=seed)
    things, n = sorted(set(labels)), len(labels)
    assert found.things == tuple(things)
    probabilities, p_values = np.zeros((n, len(things))), np.ones(n)
    held = {}
    for group in sorted(set(groups)):
        rows = [k for k in range(n) if groups[k] != group]
        learner = learned_from(presses, labels, rows)
        held[group] = learner.chosen_["sharp"]
        for k in (k for k in range(n) if groups[k] == group):
            said, p = learner.judge([presses[k]])
            p_values[k] = p[0]
            for thing, probability in zip(learner.classes_, said[0], strict=True):
                probabilities[k, things.index(thing)] = probability
    known = [k for k in range(n) if labels[k] != "odd"]
    truth = np.array([things.index(label) for label in labels])
    plain = score(Answers(probabilities[known], truth[known], p_values[known] <= 0.2, np.array(groups)[known]))
    for name in ("right", "log_loss", "overstated", "sure", "sure_right", "refused", "kept_right"):
        assert getattr(found.scores, name) == getattr(plain, name), name
    assert np.array_equal(found.scores.confusion, plain.confusion)
    assert found.unheard is not None
    odd = [k for k in range(n) if labels[k] == "odd"]
    limit = np.quantile(p_values[known], 0.2)
    assert found.unheard.things == ("odd",)
    assert share(found.unheard.refused) == (np.mean([p_values[k] <= 0.2 for k in odd]), 3)
    assert found.unheard.refused_alike == np.mean([p_values[k] <= limit for k in odd])
    # Each thing is a stranger once, in a fold of its own, to one that took over what was chosen for that fold.
    asked, strange = [], []
    for k, thing in enumerate(things):
        there = sorted({group for group, label in zip(groups, labels, strict=True) if label == thing})
        group = there[k % len(there)]
        rows = [i for i in range(n) if groups[i] != group and labels[i] != thing]
        learner = learned_from(presses, labels, rows, held[group])
        mine = [i for i in range(n) if groups[i] == group and labels[i] == thing]
        asked += mine
        strange += learner.p_values([presses[i] for i in mine]).tolist()
    assert found.strangers is not None
    assert found.strangers.things == tuple(things)
    assert found.strangers.refused == share_figure(np.array(strange) <= 0.2, np.array(groups)[asked])
    assert found.strangers.refused_alike == np.mean(np.array(strange) <= limit)
    assert len(PlainLearner.learned) == 3 + 5
    # Groups are handed on where there are two or more of them that are not the things.
    for numbers, _, told, _ in PlainLearner.learned:
        of = [groups[next(i for i in range(n) if number_of(presses[i]) == number)] for number in numbers]
        assert told == of
    assert (found.split, found.n_folds, found.n_presses, found.error) == ("groups", 3, n, 0.2)
    assert found.groups == ("g00", "g01", "g02")
    (remark,) = found.remarks
    assert remark.startswith("in one group only, so that it is unknown")
    assert remark.endswith(": odd")


@pytest.mark.parametrize(("strangers", "shots"), [(True, (1, 2, 3, 99)), (False, ()), (True, ()), (False, (2,))])
def test_steps_are_as_many_as_were_told(strangers: bool, shots: tuple[int, ...]) -> None:
    presses, labels, groups = things_felt(3, 4)
    told: list[dict[str, int]] = []
    plainly(X=presses, y=labels, groups=groups, strangers=strangers, shots=shots, tick=lambda **t: told.append(t))
    assert told[0] == {"total": 4 + 3 * strangers + 3 + len(shots)}
    assert told[1:] == [{"advance": 1}] * told[0]["total"]


def test_remarks_tell_how_it_was_done() -> None:
    presses, labels, groups = things_felt(2, 13, each=2)
    many = plainly(X=presses, y=labels, groups=groups, shots=())
    assert many.n_folds == 12
    assert many.remarks[0] == "13 groups were held out several at a time, 12 times in all"
    assert many.remarks[1] == "there are too few things to leave one out of learning: no strangers were tried"
    assert many.strangers is None
    presses, labels, groups = things_felt(3, 12, each=2)
    assert plainly(X=presses, y=labels, groups=groups, shots=()).remarks == ()
    presses, labels, groups = things_felt(3, 2)
    more, names = [press_of(1.0), press_of(2.0)] * 2, ["x", "x", "y", "y"]
    two = plainly(X=[*presses, *more], y=[*labels, *names], groups=[*groups, *["g01"] * 4], shots=())
    assert two.remarks[0].startswith("in one group only, so that they are unknown")
    assert two.remarks[0].endswith(": x, y")
    assert two.remarks[1].startswith("there are 2 groups only: no interval over groups can be given (3 are needed)")
    assert two.unheard is not None
    assert two.unheard.things == ("x", "y")
    twice = plainly(X=[*presses, presses[0]], y=[*labels, labels[0]], groups=[*groups, groups[0]], shots=())
    assert twice.remarks[-1].startswith("1 press is a copy of others beside them, with identical frames: each counts")
    assert interval_remarks(np.array(list("abc"))) == []
    assert interval_remarks(np.array(list("aaa")))[0].startswith("there is 1 group only: ")
    assert interval_remarks(None)[0].startswith("no groups are given: ")
    none = plainly(X=presses, y=labels, shots=(), folds=3)
    assert (none.n_folds, none.split, none.groups) == (3, "neighbours", ())


@pytest.mark.parametrize(("n", "left_out"), [(2, 2), (10, 10), (11, 5), (30, 5)])
def test_of_more_than_ten_things_five_are_strangers(n: int, left_out: int) -> None:
    assert n_strangers(n) == left_out
    if n < 4:
        return
    presses, labels, groups = things_felt(n, 3, each=1)
    codes = np.unique(labels, return_inverse=True)[1]
    felt = Felt(presses, codes, np.unique(labels), np.array(groups))
    split = split_presses(np.array(labels), np.array(groups))
    chosen = {fold: {"sharp": 2.0} for fold in range(3)}
    drawn, again, other = (
        answer_strangers(PlainLearner(), felt, split, chosen, seed=seed)
        for seed in (5, 5, 6)  # type: ignore[arg-type]
    )
    assert len(drawn.classes) == left_out
    assert list(drawn.classes) == sorted(set(drawn.classes))
    assert drawn.classes == again.classes
    assert (drawn.classes != other.classes) == (n > 10)
    assert [int(codes[row]) for row in drawn.rows] == list(drawn.classes)
    for (numbers, things, _, sharp), thing in zip(PlainLearner.learned, drawn.classes, strict=False):
        assert thing not in things
        assert sharp == 2.0
        assert len(numbers) == 2 * (n - 1)


def test_shots_are_answered_by_who_learned_from_so_many() -> None:
    presses, labels, groups = things_felt(3, 3, each=4)
    codes = np.unique(labels, return_inverse=True)[1]
    felt = Felt(presses, codes, np.unique(labels), np.array(groups))
    split = split_presses(np.array(labels), np.array(groups))
    ticks: list[int] = []
    curve = shots_curve(
        PlainLearner(),
        felt,
        split,
        shots=(1, 2, 8, 9),
        seed=4,
        tick=lambda: ticks.append(1),  # type: ignore[arg-type]
    )
    assert len(ticks) == 4
    assert [one.presses for one in curve] == [2, 8]
    for one in curve:
        drawn = draw_shots(felt, split, one.presses, seed=4)
        assert drawn is not None
        right = np.zeros(len(labels), bool)
        for rows, (train, test) in zip(drawn, split.parts(), strict=True):
            assert set(rows.tolist()) <= set(train.tolist())
            assert [int((codes[rows] == k).sum()) for k in range(3)] == [one.presses] * 3
            assert rows.tolist() == sorted(rows.tolist())
            learner = learned_from(presses, labels, rows.tolist())
            for k in test.tolist():
                right[k] = learner.classes_[int(np.argmax(learner.judge([presses[k]])[0]))] == labels[k]
        assert one.right == share_figure(right, np.array(groups))
        assert one.peer is None
        assert one.to_dict() == {"presses": one.presses, "right": one.right.to_dict(), "peer": None}
    assert draw_shots(felt, split, 8, seed=4) is not None
    assert draw_shots(felt, split, 9, seed=4) is None
    few, other = draw_shots(felt, split, 2, seed=4), draw_shots(felt, split, 2, seed=5)
    assert few is not None
    assert other is not None
    assert any(a.tolist() != b.tolist() for a, b in zip(few, other, strict=True))


def test_a_curve_begins_with_one_press_and_about_doubles_up_to_twenty() -> None:
    assert (SHOTS[0], SHOTS[-1]) == (1, 20)
    assert all(b in (2 * a, 2.5 * a) for a, b in pairwise(SHOTS))


def test_as_many_known_presses_are_refused_as_strangers_are_compared_with() -> None:
    known = np.linspace(0.01, 1, 100)
    refused = np.array([True, False, True, True])
    strange = np.array([0.02, 0.5, 0.1, 0.1 + 1e-9])
    limit = float(np.quantile(known, 0.1))
    found = stranger_score(refused, None, (np.array([0.02, 0.5, limit, limit + 1e-9]), known, 0.1), ("a",))
    assert found.refused_alike == 0.5
    assert found.refused == share_figure(refused)
    assert stranger_score(refused, None, None, ("a",)).refused_alike is None
    assert stranger_score(refused, None, (strange, np.zeros(0), 0.1), ("a",)).refused_alike is None
    third = StrangerScore(found.refused, 1 / 3, ("a", "b"))
    assert third.to_dict(["a leak"]) == {
        **found.refused.to_dict(),
        "refused_alike": 0.333333,
        "things": ["a", "b"],
        "leaks": ["a leak"],
    }
    assert StrangerScore(found.refused, None, ()).to_dict([])["refused_alike"] is None


# ---- what was learned before


@pytest.mark.parametrize("n", [1, 50, 51, 100, 101])
def test_a_model_is_asked_in_parts_and_answers_as_if_in_one(n: int) -> None:
    rng = np.random.default_rng(n)
    labels = np.array(["a", "b", "stranger"])[np.arange(n) % 3]
    presses = [press_of(rng.normal(20, 3), f"day.npz, press {k}") for k in range(n)]
    model = PlainLearner().fit(
        [press_of(18, "day.npz, press 0"), press_of(22, "x"), press_of(24, "y")], ["a", "b", "c"]
    )
    told: list[dict[str, int]] = []
    found = evaluate_model(model, presses, labels, seed=7, tick=lambda **t: told.append(t))  # type: ignore[arg-type]
    assert told == [{"total": -(-n // 50)}, *[{"advance": 1}] * -(-n // 50)]
    probabilities, p = model.judge(presses)
    known = labels != "stranger"
    truth = np.array(["abc".find(label) for label in labels])
    plain = score(Answers(probabilities[known], truth[known], p[known] <= 0.2, None))
    assert found.scores.right == plain.right
    assert found.scores.refused == plain.refused
    assert (found.strangers is None) == bool(known.all())
    if found.strangers is not None:
        assert found.strangers.things == ("stranger",)
        assert share(found.strangers.refused) == ((p[~known] <= 0.2).mean(), (~known).sum())
        assert found.strangers.refused_alike == (p[~known] <= np.quantile(p[known], 0.2)).mean()
    assert [leak.name for leak in found.leaks] == ["learned from these"]
    assert "from 1 of these very presses at least" in found.leaks[0].says
    assert (found.n_presses, found.n_folds, found.seed, found.things) == (n, 0, 7, ("a", "b", "c"))
    assert found.remarks[-1] == f"{min(n, 2)} of the 3 things that it knows were tested"
    unnamed = [press_of(number_of(press), "x") for press in presses]
    assert evaluate_model(model, unnamed, labels).leaks == ()  # type: ignore[arg-type]


@pytest.mark.parametrize("n", [11, 12, 13, 20])
def test_a_dozen_unknown_labels_are_listed(n: int) -> None:
    model = PlainLearner().fit([press_of(1), press_of(2)], ["a", "b"])
    labels = [f"k{k:02}" for k in range(n)]
    with pytest.raises(InputError, match="the model knows none of these labels: ") as said:
        evaluate_model(model, [press_of(1)] * n, labels)  # type: ignore[arg-type]
    listed = str(said.value).split(": ")[1].split(";")[0]
    assert listed == ", ".join(labels[:12]) + (f" and {n - 12} more" if n > 12 else "")


def test_a_press_is_named_by_its_strongest_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    """Presses of three, one and two frames; the second touches nothing, the third in two places."""
    asked: list[tuple[str, int, object]] = []

    def answer(strength: float, name: str) -> SimpleNamespace:
        names = {known: float(known == name) for known in NAMES}
        contact = SimpleNamespace(values=np.full((2, 2), strength))
        return SimpleNamespace(surface=SimpleNamespace(contact=contact, names=names))

    answers = [[answer(1, "cone")], [], [answer(2, "cone"), answer(3, "edge"), answer(-9, "plane")]]

    def recognized(cut: Recording, *, frames: str, sensor: object) -> list[SimpleNamespace]:
        asked.append((frames, cut.n_frames, sensor))
        return answers[len(asked) - 1]

    monkeypatch.setattr(given, "recognize_recording", recognized)
    values = np.zeros((6, 4, 4))
    values[[1, 4]] = 5.0
    recording = Recording({"pad": Pad(values)}, time_s=np.arange(6) / 10, press=np.array([0, 0, 0, 1, 2, 2]))
    told: list[dict[str, int]] = []
    found = evaluate_shipped([recording], ["Cone", " UNKNOWN", "-edge_"], tick=lambda **t: told.append(t))
    assert [frames for _, frames, _ in asked] == [3, 1, 2]
    assert told == [{"total": 3}, *[{"advance": 1}] * 3]
    assert share(found.scores.right) == (1.0, 2)
    assert found.strangers is not None
    assert share(found.strangers.refused) == (1.0, 1)
    assert found.strangers.refused_alike is None
    assert found.things == (*[name for name in NAMES if name != "unknown"], "unknown")
    assert found.error is None
    asked.clear()
    with pytest.raises(InputError, match="y must be one label a press, 3 of them, got 2"):
        evaluate_shipped([recording], ["cone", "edge"])
    with pytest.raises(InputError, match="every press is labelled unknown"):
        evaluate_shipped([recording], ["unknown"] * 3)


# ---- what JSON holds


def test_json_holds_every_figure_as_it_is() -> None:
    found = made(3)
    s, told = found.scores, found.to_dict()
    marked = lambda figure: {**figure.to_dict(), "leaks": []}  # noqa: E731
    assert told["right"] == marked(s.right)
    for name, figure in (
        *(("log_loss", s.log_loss), ("mean_p_minus_right", s.overstated), ("sure", s.sure)),
        *(("sure_right", s.sure_right), ("known_refused", s.refused), ("kept_right", s.kept_right)),
        ("ahead_of_best_peer", found.peers[0].ahead),
    ):
        assert told[name] == marked(figure)
    assert told["macro_recall"] == {"value": round(s.macro_recall, 6), "leaks": []}
    assert told["calibration_error"] == {"value": round(s.calibration_error, 6), "leaks": []}
    assert (told["chance"], told["presses"], told["error"], told["seed"]) == (0.333333, 36, 0.05, 0)
    assert told["split"] == {"kind": "groups", "folds": 3}
    (peer,) = told["peers"]
    assert peer["right"] == marked(found.peers[0].right)
    assert peer["log_loss"] == marked(found.peers[0].log_loss)
    assert peer["calibration_error"] == {"value": 0.1, "leaks": []}
    assert [one["presses"] for one in told["shots"]] == [1, 2, 5, 20]
    assert told["confusion"] == s.confusion.tolist()
    for row, b in zip(told["reliability"], s.reliability, strict=True):
        assert row == {
            "presses": b.n,
            **{
                name: round(value, 6)
                for name, value in (("p", b.probability), ("right", b.right), ("low", b.low), ("high", b.high))
            },
            "leaks": [],
        }
    assert [(one["refused"], one["errors"]) for one in told["refusals"]] == [
        (round(share, 6), round(errors, 6)) for share, errors in s.refusals
    ]
    assert found.peers[0].name == "moments, forest"
    assert found.best_peer is found.peers[0]


def test_a_split_is_told_apart_from_its_folds() -> None:
    split = Split("groups", np.array([2, 0, 2, 5]), np.ones(4, bool), np.array([0, 0, 0, 0]))
    assert split.n_folds == 3
    assert [test.tolist() for _, test in split.parts()] == [[1], [0, 2], [3]]
    assert split.training(2).tolist() == [1, 3]
    assert split.training(9).tolist() == [0, 1, 2, 3]
