"""Laws of presses that are there more than once, and of labels that are none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.test_learning_adaptation import presses

from varishold import TactileClassifier
from varishold.errors import InputError
from varishold.evaluation import evaluate
from varishold.learning.training import _why_unheld, named_alike


@pytest.fixture(scope="module")
def fitted() -> TactileClassifier:
    return TactileClassifier(drift=0).fit(*presses(0, each=4))


def test_a_copy_is_learned_once_and_told(fitted: TactileClassifier) -> None:
    X, y = presses(0, each=4)
    again = TactileClassifier(drift=0).fit([*X, *X[:5]], [*y, *y[:5]])
    assert again.loss_ == fitted.loss_
    np.testing.assert_array_equal(again.predict_proba(X), fitted.predict_proba(X))
    told = "5 presses are copies of others, with identical frames: each is learned once; leave the copies out"
    assert told in again.remarks_
    assert told not in fitted.remarks_
    otherwise = TactileClassifier(drift=0).fit([*X, X[0]], [*y, y[1]])
    pair = f"press 0 is {str(y[0])!r}, press {len(X)} is {str(y[1])!r}"
    assert f"1 press is a copy of others that have another label: {pair}; look which is right" in otherwise.remarks_


def test_copies_with_another_label_are_learned_once_too() -> None:
    X, y = presses(0, each=4)
    once = TactileClassifier(drift=0).fit([*X, X[0]], [*y, y[1]])
    twice = TactileClassifier(drift=0).fit([*X, X[0], X[0]], [*y, y[1], y[1]])
    np.testing.assert_array_equal(twice.predict_proba(X), once.predict_proba(X))


def test_names_that_are_nearly_alike_are_told() -> None:
    names = np.array(["Ball", "Blue cup", "ball", "blue-cup", "box", "box 1", "box 1 1", "box 11", "-1", "1"])
    assert named_alike(names) == (
        "things with names that are nearly alike are told apart: 'Ball', 'ball'; 'Blue cup', 'blue-cup'; "
        "if they are one, give them one name",
    )
    assert named_alike(np.array([1, 11, 111])) == named_alike(np.array(["-1", "1", "1_1", "11", "1.1"])) == ()
    assert "apart: '1', '1.0'; '10', '010'; if" in named_alike(np.array(["1", "1.0", "10", "010"]))[0]
    X, y = presses(0, each=4)
    learned = TactileClassifier(drift=0).fit(X, np.where(np.arange(len(y)) < len(y) / 2, y, np.char.upper(y)))
    assert any(remark.startswith("things with names that are nearly alike") for remark in learned.remarks_)


def test_evaluation_tells_of_copies_with_another_label_and_of_names_nearly_alike() -> None:
    X, y = presses(0, each=4)
    labels = [*y, y[1], *np.char.upper(y)]
    found = evaluate([*X, X[0], *(frames + 1e-3 for frames in X)], labels, shots=(), peers=False, strangers=False)
    assert any("1 press is a copy of others that have another label" in remark for remark in found.remarks)
    assert any(remark.startswith("things with names that are nearly alike") for remark in found.remarks)


def test_a_new_class_of_known_presses_is_told() -> None:
    X, y = presses(0, each=4)
    model = TactileClassifier(drift=0).fit(X, y).add("impostor", X[:3])
    assert model.remarks_[-1].startswith("3 of 3 presses of 'impostor' were learned already, as ")


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (None, "press 0 has no label"),
        (np.nan, "press 0 has no label"),
        (1.5, "press 0: its label must be a text or a whole number, got 1.5"),
    ],
)
def test_a_label_that_is_none_is_named(wrong: Any, told: str) -> None:
    X, y = presses(0, each=4)
    rest: list[Any] = y[1:].tolist() if wrong is None else [float(k % 2) for k in range(len(y) - 1)]
    with pytest.raises(InputError, match=told):
        TactileClassifier(drift=0).fit(X, [wrong, *rest])


def test_frames_without_a_reading_are_named(fitted: TactileClassifier) -> None:
    with pytest.raises(InputError, match="press 0: every taxel is NaN in some frame"):
        fitted.predict([np.full((4, 12, 14), np.nan)])


def test_what_is_no_press_is_named(fitted: TactileClassifier) -> None:
    with pytest.raises(InputError, match="press 0: must be a recording or frames, got 'abc'"):
        fitted.predict(["abc"])
    for ask in (fitted.predict, lambda X: TactileClassifier().fit(X, ["a"])):
        with pytest.raises(InputError, match="presses must be a sequence of recordings or frames, got None"):
            ask(None)
    with pytest.raises(InputError, match="y must be one label a press, got None"):
        TactileClassifier().fit(presses(0, each=2)[0], None)


def test_of_a_class_whose_presses_are_copies_it_is_told() -> None:
    one, other = np.random.default_rng(0).random((2, 3, 8, 8))
    with pytest.raises(InputError, match="'0' has one press only, copies being one: give each class at least two"):
        TactileClassifier().fit([one, one, other, other + 0.1], [0, 0, 1, 1])


def test_far_too_many_things_are_refused_at_once() -> None:
    X = np.random.default_rng(0).random((6000, 1, 2, 2))
    with pytest.raises(InputError, match="3000 things in 6000 presses are too many to be learned at once") as told:
        TactileClassifier().fit(X, np.arange(6000) // 2)
    assert told.value.parameter == "label"


@pytest.mark.parametrize(
    ("sessions", "why"),
    [
        (None, "no sessions are known"),
        ("xxxxxxxxxx", "all presses are of one session, 'x'"),
        ("xyxyxyxyxx", "'e' was felt in one session only"),
        ("xyxyxxyyxx", "'c', 'd', 'e' were felt in one session only"),
        ("xxxyxxyyzz", "'a', 'c', 'd' and 1 more were felt in one session only"),
        ("xyxyxyxyxy", "without any share of the sessions some thing would be unknown"),
    ],
)
def test_why_no_session_is_held_out(sessions: str | None, why: str) -> None:
    given = None if sessions is None else np.array(list(sessions))
    assert _why_unheld(np.array(list("abcde")), np.repeat(np.arange(5), 2), given) == why
