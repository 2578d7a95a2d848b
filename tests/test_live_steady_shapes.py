"""A pad's shape: a stray frame of another one is damage, another skin is not."""

from __future__ import annotations

import json
from collections import Counter

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.live.address import parse_address
from varishold.live.interpreter import Interpreter
from varishold.live.steady_shapes import SteadyShapes

OWN, OTHER = (8, 8), (7, 8)


def _taken(shapes: list[tuple[int, ...]]) -> list[bool]:
    pads = SteadyShapes()
    return [pads.takes("pad", shape) for shape in shapes]


@given(st.sets(st.integers(0, 99), max_size=30))
def test_strays_are_never_taken_among_frames_of_another_shape(strays: set[int]) -> None:
    apart = {k for k in strays if not {k - 4, k - 3, k - 2, k - 1} & strays}
    taken = _taken([OWN] * 5 + [OTHER if k in apart else OWN for k in range(100)])
    assert taken == [True] * 5 + [k not in apart for k in range(100)]


def test_a_first_frame_that_is_stray_costs_none_of_the_others() -> None:
    assert _taken([OTHER, *[OWN] * 9]) == [True] * 10


def test_a_shape_that_stays_is_taken_from_its_fifth_frame_on() -> None:
    assert _taken([*[OWN] * 20, *[OTHER] * 9]) == [True] * 20 + [False] * 4 + [True] * 5


@given(st.lists(st.sampled_from([OWN, OTHER, (3,)]), min_size=1, max_size=60), st.integers(1, 3))
def test_shapes_that_alternate_settle(shapes: list[tuple[int, ...]], n: int) -> None:
    # As often in a row as readings were taken before: each change makes the next one dearer.
    taken = _taken([*[OWN] * n, *[shape for _ in range(20) for shape in (OTHER, OWN)]])
    assert sum(taken[n + 4 :]) in (18, 19)
    # Pads know nothing of each other.
    pads = SteadyShapes()
    both = [(pads.takes("a", shape), pads.takes("b", OWN)) for shape in shapes]
    assert [one for one, _ in both] == _taken(shapes)
    assert all(other for _, other in both)


@given(st.sets(st.integers(0, 59), max_size=4), st.booleans())
@settings(max_examples=30)
def test_of_a_message_the_stray_pad_alone_is_left_out_and_counted(strays: set[int], alone: bool) -> None:
    strays = {k for k in strays if k - 1 not in strays}
    its, came = Interpreter(parse_address("ws://host/")), Counter[str]()
    for k in range(65):
        palm = np.zeros(OTHER if k - 5 in strays else OWN, int).tolist()
        message = {"palm": palm} if alone else {"palm": palm, "thumb": [[k, 2]]}
        came.update(name for sample in its.payload(json.dumps(message).encode()) for name in sample.pads)
    assert (came["palm"], came["thumb"]) == (65 - len(strays), 0 if alone else 65)
    assert its.damaged == len(strays)
    assert its.damage == ("pad palm came with 7 x 8 values among frames of 8 x 8" if strays else "")
    assert its.pads["palm"].shape == OWN
