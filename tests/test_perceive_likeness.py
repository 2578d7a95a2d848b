"""A new thing beside what a library knows: how often it would be taken for it."""

from __future__ import annotations

import numpy as np
from tests.toy_library import OBJECTS, library, touches

from varishold.perceive import Evidence
from varishold.perceive.likeness import taken_for


def test_a_thing_that_feels_as_a_known_one_is_taken_for_it_and_a_stranger_for_none() -> None:
    rng = np.random.default_rng(3)
    known = library()
    name, scale = list(OBJECTS.items())[1]
    assert taken_for(known, [touches(scale, rng) for _ in range(12)]).get(name, 0) > 8
    strange = [[Evidence(e.touch, {key: 50 + value for key, value in e.values.items()}) for e in touches(scale, rng)]]
    assert taken_for(known, strange) == {}


def test_touches_that_failed_or_are_unknown_say_nothing() -> None:
    known, (name, scale) = library(), next(iter(OBJECTS.items()))
    example = touches(scale, np.random.default_rng(4))
    more = [Evidence("prod", {"x": 1.0}), Evidence(example[0].touch, {}, failed=True), *example]
    assert taken_for(known, [more]) == taken_for(known, [example])
    assert taken_for(known, [[]]) == taken_for(known, []) == {}
    assert name in known.objects
