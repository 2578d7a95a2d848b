"""Sizes of things that are known by few examples: how often the interval holds them."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.perceive import Belief, Evidence, Library

KINDS, NUMBERS = 3, 12


class World:
    """Things of three kinds, whose numbers depend on their size by bent lines."""

    def __init__(self, rng: np.random.Generator, *, sized: bool) -> None:
        self.rng, self.sized = rng, sized
        self.middle, self.slope, self.bend = rng.normal(0, [[[1.0]], [[0.5]], [[0.2]]], (3, KINDS, NUMBERS))
        self.factor = rng.normal(0, 0.3, KINDS)

    def touch(self, k: int, log_size: float) -> Evidence:
        u = (log_size - np.log(0.07)) / 0.3
        form = self.middle[k] + self.slope[k] * u + self.bend[k] * u**2 + 0.3 * self.rng.normal(size=NUMBERS)
        size = {"size.a": self.factor[k] + log_size + self.rng.normal(0, 0.03)} if self.sized else {}
        return Evidence("grasp", {f"form.{i}": float(x) for i, x in enumerate(form)} | size)

    def library(self, log_sizes: np.ndarray) -> Library:
        """A library whose objects have examples of these sizes each."""
        return Library.from_examples(
            {str(k): [[self.touch(k, size)] for size in log_sizes.tolist()] for k in range(KINDS)},
            sizes_m=dict.fromkeys(map(str, range(KINDS)), np.exp(log_sizes).tolist()),
        )


@pytest.mark.parametrize("sized", [True, False])
@pytest.mark.parametrize("n", [3, 5, 12])
def test_of_few_examples_an_interval_holds_the_size_as_often_as_it_says(n: int, sized: bool) -> None:
    held = []
    for seed in range(25):
        rng = np.random.default_rng([n, sized, seed])
        world, log_sizes = World(rng, sized=sized), np.log(0.07) + rng.uniform(-0.4, 0.4, n)
        library = world.library(log_sizes)
        for k in range(KINDS):
            # A tenth within or beyond.
            true = rng.uniform(log_sizes.min() - 0.1, log_sizes.max() + 0.1)
            said = Belief.before(library).after(world.touch(k, true)).size(str(k))
            assert said is not None
            held.append(said[1] <= np.exp(true) <= said[2])
    # Three standard deviations of 75 draws about .95 and more.
    assert np.mean(held) >= 0.87


@pytest.mark.parametrize("n", [1, 2, 10])
def test_things_felt_in_one_size_may_have_another(n: int) -> None:
    held = []
    for seed in range(20):
        rng = np.random.default_rng([n, seed])
        world = World(rng, sized=True)
        library = world.library(np.full(n, np.log(0.07)))
        for true in np.log((0.06, 0.08)):
            said = Belief.before(library).after(world.touch(0, true)).size("0")
            assert said is not None
            held.append(said[1] <= np.exp(true) <= said[2])
    assert np.mean(held) >= 0.8


def test_an_objects_size_line_is_no_surer_for_fewer_examples() -> None:
    """Two examples lie on a line, whatever they say."""
    scales = {}
    for n in (2, 3, 5, 30):
        drawn = [World(np.random.default_rng([7, n, seed]), sized=True) for seed in range(20)]
        models = [world.library(world.rng.uniform(-3.0, -2.3, n)).touches["grasp"].size for world in drawn]
        scales[n] = np.median([model.scale for model in models if model is not None])
    assert scales[2] > scales[3] > scales[30]
    assert scales[5] > scales[30]
