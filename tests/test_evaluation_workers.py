"""Evaluating on several processes: the same figures, told of as often."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.plain_learner import PlainLearner, press_of

from varishold.errors import InputError
from varishold.evaluation import evaluate
from varishold.evaluation.features import FEATURES
from varishold.evaluation.peers import Peer, answer_peers
from varishold.evaluation.running import felt_presses
from varishold.evaluation.splits import split_presses
from varishold.files.crew import processes
from varishold.touch.course.presses import Press

THINGS = ["cone", "cube", "disc"]


def drawn() -> tuple[list[Press], np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    things = np.array([thing for _ in range(12) for thing in THINGS])
    presses = [press_of(THINGS.index(thing) + rng.normal(0, 0.4), place=f"press {k}") for k, thing in enumerate(things)]
    return presses, things, np.repeat(["mon", "tue", "wed"], 12)


def evaluated(workers: Any, **how: Any) -> tuple[dict[str, Any], int, int]:
    presses, things, days = drawn()
    ticks: list[dict[str, int]] = []
    found = evaluate(
        presses,
        things,
        days,
        classifier=PlainLearner(),
        shots=(1, 2, 40),
        workers=workers,
        tick=lambda **said: ticks.append(said),
        **how,
    )
    return found.to_dict(), ticks[0]["total"], sum(tick.get("advance", 0) for tick in ticks)


def test_many_processes_find_what_one_finds() -> None:
    one, total, done = evaluated(1, peers=False)
    assert (one, total, done) == evaluated(2, peers=False)
    assert total == done


def test_peers_answer_alike_by_many_processes() -> None:
    presses, things, days = drawn()
    felt = felt_presses(presses, things, days)
    split = split_presses(things, np.asarray(days))
    quick = [Peer(features, "nearest neighbour") for features in FEATURES]
    with processes(2) as crew:
        one, two = (answer_peers(quick, felt, split, seed=0, crew=those) for those in ((), crew))
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_cluster_finds_what_one_finds() -> None:
    pytest.importorskip("distributed", reason="takes the extra cluster")
    from varishold.corpus.cluster import cluster

    assert evaluated(1, peers=False) == evaluated(cluster("local", number=2), peers=False)


@pytest.mark.parametrize("workers", [0, -1, 1.5, True])
def test_processes_are_counted_from_one(workers: Any) -> None:
    with pytest.raises(InputError, match="workers must be a whole number, at least 1"):
        evaluated(workers, peers=False)
