"""The modes: ways from training grasps to hyperplanes and a circuit; one file a mode.

`MODES` is the registry, by the name that users give.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from varishold.grasp.modes.learned import Learned, ModeOptions
from varishold.grasp.modes.paper import learn_paper
from varishold.grasp.modes.robust import learn_robust
from varishold.grasp.modes.vote import learn_vote
from varishold.grasp.training import TrainingGrasps

__all__ = ["MODES", "Learned", "ModeOptions", "learn_paper", "learn_robust", "learn_vote"]

MODES: Mapping[str, Callable[[TrainingGrasps, ModeOptions], Learned]] = {
    "paper": learn_paper,
    "robust": learn_robust,
    "vote": learn_vote,
}
