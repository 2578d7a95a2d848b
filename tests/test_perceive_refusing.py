"""What is stranger than all that is known is refused, also where few examples know all of the touches."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from varishold.perceive import NONE_OF_THESE, Evidence, Library, Perceiver

TOUCHES = ("grasp", "higher", "lower", "turned")


def example(middle: float, rng: np.random.Generator, lost: float = 0.0, *, odd: float = 0.0) -> list[Evidence]:
    """Touches of one thing, of which some were lost by chance."""
    felt = [Evidence(touch, {"a": middle + rng.normal(), "b": odd + rng.normal()}) for touch in TOUCHES]
    return [each for k, each in enumerate(felt) if not k or rng.random() >= lost]


@cache
def library(n: int, lost: float) -> Library:
    rng = np.random.default_rng(3)
    return Library.from_examples(
        {name: [example(middle, rng, lost) for _ in range(n)] for name, middle in (("ball", 0.0), ("box", 12.0))},
        others=[example(rng.uniform(-3, 15), rng, odd=rng.choice([-6.0, 6.0])) for _ in range(100)],
    )


def felt(of: Library, touches: list[Evidence]) -> Perceiver:
    perceiver = Perceiver(of, error=1e-9, least_touches=4)
    for touch in touches:
        perceiver.feel(touch)
    return perceiver


@pytest.mark.parametrize("n", [10, 20, 40])
@pytest.mark.parametrize("lost", [0.0, 0.4])
def test_what_is_stranger_than_every_example_is_refused_however_few_made_all_touches(n: int, lost: float) -> None:
    rng = np.random.default_rng(n)
    assert felt(library(n, lost), example(0.0, rng, odd=6.0)).answer().object == NONE_OF_THESE


@pytest.mark.parametrize("lost", [0.0, 0.4])
def test_known_things_are_refused_about_as_often_as_their_number_allows(lost: float) -> None:
    rng, n = np.random.default_rng(8), 20
    beliefs = [felt(library(n, lost), example(0.0, rng)).belief for _ in range(150)]
    refused = np.mean([belief.atypical for belief in beliefs])
    assert refused <= 3.5 / (n + 1)
    # The least p-value that can be is that of what is stranger than all of an object's examples.
    assert min(belief.p_value for belief in beliefs) >= 1 / (n + 1) - 1e-12


def test_where_enough_examples_made_all_touches_they_alone_are_compared_with() -> None:
    of, rng = library(400, 0.2), np.random.default_rng(5)
    whole = int(np.all([model.made[of.owner == 0] for model in of.touches.values()], axis=0).sum())
    assert 100 < whole < 300
    ranks = [felt(of, example(0.0, rng)).belief.p_value * (whole + 1) for _ in range(5)]
    assert ranks == pytest.approx(np.round(ranks))
