"""What the shipped library is learned from: which objects, how large, by which seeds."""

from __future__ import annotations

import argparse

import numpy as np
import pytest

from training import lying
from training import objects as training
from varishold.hand import OBJECTS
from varishold.perceive import shipped_library


def jobs(**options: int) -> list[training.Job]:
    none = dict.fromkeys(("examples", "broad", "lumps", "assemblies"), 0)
    return training._jobs(argparse.Namespace(any_turn=True, **none | options))


def test_broad_boxes_and_pillars_are_as_broad_as_the_hand_just_holds() -> None:
    made = jobs(broad=60)
    sizes = [job.drawn(name)[0] for job in made for name in job.names]
    assert {name for job in made for name in job.names} == {"box", "square-pillar"}
    assert len(sizes) == 240
    assert 0.092 <= min(sizes) < 0.095
    assert 0.119 < max(sizes) <= 0.122


def test_every_job_is_kept_in_a_file_of_its_own_and_draws_seeds_that_are_small() -> None:
    made = [*jobs(examples=150, broad=60, lumps=28, assemblies=28), *lying.jobs_of(330, 10, 10)]
    assert len({job.path for job in made}) == len(made) == 2 * (150 + 60 + 28 + 28 + 330 + 10 + 10)
    seeds = [(name, job.setting.pose, job.drawn(name)[1]) for job in made for name in job.names]
    assert len(set(seeds)) == len(seeds)
    assert max(seed for _, pose, seed in seeds if pose == "upright") < 100_000
    assert max(seed for *_, seed in seeds) < 120_000


@pytest.mark.parametrize(
    ("made", "names", "pose"),
    [
        (lying.jobs_of(1, 0, 0), set(OBJECTS) - {"sphere"}, "lying"),
        (jobs(examples=1), set(OBJECTS), "upright"),
    ],
)
def test_a_ball_has_no_side_to_lie_on(made: list[training.Job], names: set[str], pose: str) -> None:
    assert {name for job in made for name in job.names} == names
    assert {job.setting.pose for job in made} == {pose}


def test_shares_of_all_kinds_are_felt_side_by_side() -> None:
    """A run that was stopped has as large a part of each."""
    made = jobs(examples=40, broad=10)
    for part in (made[: len(made) // 2], made[len(made) // 2 :]):
        assert sum(job.broad for job in part) == pytest.approx(10, abs=2)


def test_what_tells_much_is_rounded_less() -> None:
    """No step of a number is a large part of the kernel's width; what was felt reaches as far."""
    library = shipped_library("lying")
    rough = training.coarse(library)
    for touch, model in library.touches.items():
        units, kept = (model.metric.standardized(each.touches[touch].values) for each in (library, rough))
        told = np.linalg.norm(model.metric.whitening, axis=1) / (model.width * np.sqrt(len(model.metric.names)))
        moved = np.nanmax(np.abs(units - kept), axis=0)
        assert (moved <= 0.125 + 1e-9).all()
        assert (moved * told <= np.maximum(0.1, 0.025 * told) + 1e-9).all()
        assert (np.nanmax(kept, axis=0) >= np.nanmax(units, axis=0) - 1e-9).all()
        assert (np.nanmin(kept, axis=0) <= np.nanmin(units, axis=0) + 1e-9).all()


def test_a_thinned_library_holds_so_many_of_each_kind_and_all_that_was_learned() -> None:
    library = shipped_library("lying")
    thin = lying.thinned(library, 30)
    assert thin.counts.tolist() == [30] * len(library.objects)
    for touch, model in thin.touches.items():
        assert model.metric is library.touches[touch].metric
        assert len(model.values) == len(model.scores) == 30 * len(library.objects)
    # Those that are kept are examples as they were, and all kinds stay where they are.
    felt = {row.tobytes() for row in library.touches["grasp"].values}
    assert all(row.tobytes() in felt for row in thin.touches["grasp"].values)
    assert lying.thinned(library, 30).owner.tobytes() == thin.owner.tobytes()
