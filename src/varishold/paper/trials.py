"""Trial grasps of Table 5: made in simulation, described in groups of function, and named from a few that train."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.hand import HandSetting, Job, grasp_object, run_jobs
from varishold.hand.features import FEATURE_GROUPS, Features, features

__all__ = ["Trial", "classify", "simulate"]


@dataclass(frozen=True)
class Trial:
    """One grasp's end: what it felt, in each group of function, and whether the object is in the hand.

    Parameters
    ----------
    features : dict of str to Features
        By key of `FEATURE_GROUPS`.
    held : bool
    attempts : int
    """

    features: dict[str, Features]
    held: bool
    attempts: int


@dataclass(frozen=True)
class _Work:
    """What a process does with a job: grasp, and describe the end."""

    setting: HandSetting
    groups: tuple[str, ...]

    def __call__(self, job: Job) -> Trial:
        done = grasp_object(job.name, job.size_m, seed=job.seed, setting=self.setting)
        described = {
            group: features(done.end, group, design=self.setting.design, layout=self.setting.layout)
            for group in self.groups
            if done.end.pads is not None or FEATURE_GROUPS[group].sense == "contact"
        }
        return Trial(described, done.held, len(done.attempts))


def simulate(
    jobs: Sequence[Job],
    *,
    setting: HandSetting,
    groups: Sequence[str],
    processes: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Trial]:
    """Make all grasps and describe each in the groups; the answers come in the jobs' order."""
    out = []
    for trial in run_jobs(jobs, _Work(setting, tuple(groups)), processes=processes):
        out.append(trial)
        if progress is not None:
            progress(len(out), len(jobs))
    return out


def classify(
    train: Sequence[Features], labels: Sequence[str], test: Sequence[Features], *, mode: str = "auto"
) -> NDArray[Any]:
    """Train on some grasps and name others.

    Analog features become thermometer bits at thresholds chosen on the training grasps.

    Parameters
    ----------
    train, test : sequence of Features
    labels : sequence of str
        The training grasps' objects.
    mode : {"auto", "paper", "robust", "vote"}

    Returns
    -------
    ndarray of shape (n_test,), str
    """
    from varishold.grasp import HyperplaneClassifier, ThresholdEncoder

    def switches(rows: Sequence[Features]) -> NDArray[np.float64]:
        return np.array([list(row.on_off.values()) for row in rows], dtype=np.float64)

    def numbers(rows: Sequence[Features]) -> NDArray[np.float64]:
        return np.array([list(row.analog.values()) for row in rows], dtype=np.float64)

    trained, tested = [switches(train)], [switches(test)]
    if train[0].analog:
        encoder = ThresholdEncoder("supervised").fit(numbers(train), list(labels))
        trained.append(encoder.transform(numbers(train)).astype(np.float64))
        tested.append(encoder.transform(numbers(test)).astype(np.float64))
    classifier = HyperplaneClassifier(mode=mode).fit(np.hstack(trained), list(labels))  # type: ignore[arg-type]
    return classifier.predict(np.hstack(tested))
