"""What each sense is said to say: who, how likely, in which order, and how much of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.report.senses import belief_before, by_share, sense_bars, senses_in_words

CAMERA = {"box": 0.2, "cone-frustum": 0.7, "sphere": 0.1}
TOUCH = {"box": 0.996, "cone-frustum": 0.0049, "sphere": 0.0}
BOTH = {"box": 0.99, "cone-frustum": 0.01, "sphere": 0.0}


def sequence(*senses: tuple[str, dict[str, float]]) -> Any:
    return SimpleNamespace(senses=senses)


SEEN = sequence(("camera 2", CAMERA), ("touch", TOUCH), ("together", BOTH))


def test_the_belief_before_is_what_was_said_first() -> None:
    assert belief_before(SEEN) is CAMERA
    assert belief_before(sequence()) is None


def test_shares_stand_with_the_greatest_first() -> None:
    assert by_share(CAMERA) == [("cone-frustum", 0.7), ("box", 0.2), ("sphere", 0.1)]


def test_a_line_says_the_two_likeliest_that_are_worth_a_word() -> None:
    assert senses_in_words(SEEN) == ("camera 2 alone: cone-frustum 0.70, box 0.20", "touch alone: box 1.00")
    least = {"box": 0.995, "sphere": 0.005}
    assert senses_in_words(sequence(("camera", least))) == ("camera alone: box 0.99, sphere 0.01",)
    assert senses_in_words(sequence()) == ()


def test_who_says_nothing_of_names_is_not_said_to_name_two_of_them() -> None:
    even = {name: 0.1 + off for name, off in zip("abcdefghij", np.linspace(0, 1e-16, 10), strict=True)}
    assert senses_in_words(sequence(("camera", even))) == ("camera alone: all names alike",)
    assert senses_in_words(sequence(("camera", {"a": 0.504, "b": 0.496}))) == ("camera alone: a 0.50, b 0.50",)
    assert senses_in_words(sequence(("touch", {"a": 1.0}))) == ("touch alone: a 1.00",)


def test_bars_are_of_all_senses_in_their_order() -> None:
    bars = sense_bars(SEEN)
    assert [who for who, _ in bars] == ["camera 2 alone", "touch alone", "both together"]
    assert [bar.name for bar in bars[0][1]][:2] == ["cone frustum", "box"]
    assert sense_bars(sequence()) == []
