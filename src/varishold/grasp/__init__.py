"""Grasp: switch patterns to hyperplanes, sign tables and a circuit (the paper's section 3).

`HyperplaneClassifier` learns from a few grasps of each object and answers with reasons;
`ThresholdEncoder` makes switches of analog readings. Between them stand the paper's own steps:
`bisectors` (eq. [22]), `SignTable`, `smallest_hyperplanes`, `reduced_table`, `minimal_table`.
"""

from __future__ import annotations

from varishold.grasp.classifier import HyperplaneClassifier
from varishold.grasp.explanation import Explanation
from varishold.grasp.hyperplanes import Hyperplanes, bisectors
from varishold.grasp.separating import Selection, separating_set, smallest_sets
from varishold.grasp.sign_table import (
    MinimalTable,
    SignTable,
    minimal_table,
    reduced_table,
    smallest_hyperplanes,
)
from varishold.grasp.training import TrainingGrasps, training_grasps

__all__ = [
    "Explanation",
    "HyperplaneClassifier",
    "Hyperplanes",
    "MinimalTable",
    "Selection",
    "SignTable",
    "TrainingGrasps",
    "bisectors",
    "minimal_table",
    "reduced_table",
    "separating_set",
    "smallest_hyperplanes",
    "smallest_sets",
    "training_grasps",
]
