"""The probability that is stated with a name: less what is left for things that the library does not know."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.toy_library import library, touches

from varishold.errors import InputError
from varishold.perceive import NONE_OF_THESE, Library, Perceiver, Perception
from varishold.trust import strange_share


@cache
def knowing(power: float, others: int = 600) -> Library:
    """A library whose touches each tell so large a share of what is most like its objects from them."""
    of = library(others=others)
    told = {
        touch: replace(model, power=np.full_like(model.power, power if touch == "grasp" else 0.0))
        for touch, model in of.touches.items()
    }
    return replace(of, touches=told)


def felt(of: Library, off: float = 0.0, *, strangers: float = 0.1) -> Perceiver:
    perceiver = Perceiver(of, most_touches=2, refuse=False, strangers=strangers)
    for touch in touches(4.0, np.random.default_rng(1)):
        perceiver.feel(replace(touch, values={**touch.values, "form": 4.0 + off, "load": 0.0}))
    return perceiver


def test_where_touches_tell_nothing_of_strangers_a_name_has_at_most_nine_tenths() -> None:
    answer = felt(knowing(0.0)).answer()
    assert answer.object == "box"
    assert answer.trace[-1].probability["box"] > 0.999
    assert answer.probability == pytest.approx(0.9, abs=1e-3)


def test_the_better_strangers_are_told_the_surer_a_name_may_be() -> None:
    stated = [felt(knowing(power)).answer().probability for power in (0.0, 0.3, 0.6, 0.9, 1.0)]
    assert stated == sorted(stated)
    assert stated[-1] > 0.99


def test_a_power_that_was_counted_on_few_other_things_says_less() -> None:
    stated = [felt(knowing(1.0, others)).answer().probability for others in (20, 100, 600)]
    assert stated == sorted(set(stated))
    assert stated[0] < 0.97


def test_the_fewer_strangers_are_met_the_surer_a_name_is() -> None:
    stated = [felt(knowing(0.3), strangers=share).answer().probability for share in (0.9, 0.5, 0.1, 0.0)]
    assert stated == sorted(set(stated))
    nobody = felt(knowing(0.3), strangers=0.0).answer()
    assert nobody.probability == _plain(nobody)
    again = felt(knowing(0.0), strangers=0.25)
    again.forget()
    for touch in touches(4.0, np.random.default_rng(1)):
        again.feel(touch)
    assert again.answer().probability < 0.76


@pytest.mark.parametrize("share", [-0.1, 1.0, float("nan"), "few", None])
def test_a_share_of_strangers_is_a_share(share: Any) -> None:
    with pytest.raises(InputError, match="strangers must be a share"):
        Perceiver(library(), strangers=share)


def test_what_feels_odd_is_less_sure_than_what_feels_usual() -> None:
    answers = [felt(knowing(0.8), off).answer() for off in np.linspace(-1.5, 1.5, 13)]
    assert {answer.object for answer in answers} == {"box"}
    inside = sorted((answer.trace[-1].p_value, answer.probability) for answer in answers if _plain(answer) > 0.99)
    assert inside[0][0] < 0.2 < 0.8 < inside[-1][0]
    assert [p for _, p in inside] == sorted(p for _, p in inside)
    assert all(answer.probability < _plain(answer) for answer in answers)


def _plain(answer: Perception) -> float:
    return answer.trace[-1].probability["box"]


def test_where_nothing_is_known_of_other_things_nothing_is_left_for_them() -> None:
    answer = felt(library()).answer()
    assert answer.probability == answer.trace[-1].probability[answer.object]


def test_the_verdict_and_what_each_touch_says_are_as_if_it_were_one_of_these() -> None:
    sure, plain = felt(knowing(0.0)), felt(knowing(1.0))
    for blind, seeing in zip(sure.answer().trace, plain.answer().trace, strict=True):
        assert (blind.verdict, blind.probability, blind.why) == (seeing.verdict, seeing.probability, seeing.why)


def test_that_a_thing_is_none_of_these_is_the_surer_the_more_strangers_are_met() -> None:
    stated = []
    for share in (0.0, 0.01, 0.1, 0.5, 0.9):
        perceiver = Perceiver(knowing(0.9), most_touches=1, strangers=share)
        perceiver.feel(touches(-40.0, np.random.default_rng(2))[0])
        answer = perceiver.answer()
        assert answer.object == NONE_OF_THESE
        stated.append(answer.probability)
        assert answer.probability == pytest.approx(strange_share(answer.trace[-1].p_value, share))
    assert stated == sorted(set(stated))
    assert stated[0] == 0.0
