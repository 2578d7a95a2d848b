"""Grasp: switch patterns to hyperplanes, sign tables and a circuit (the paper's section 3).

`HyperplaneClassifier` learns from a few grasps of each object and answers with reasons;
`ThresholdEncoder` makes switches of analog readings. Between them stand the paper's own steps:
`bisectors` (eq. [22]), `SignTable`, `smallest_hyperplanes`, `reduced_table`, `minimal_table`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "Explanation",
    "GraspModel",
    "HyperplaneClassifier",
    "Hyperplanes",
    "MinimalTable",
    "Selection",
    "SignTable",
    "ThresholdEncoder",
    "TrainingGrasps",
    "bisectors",
    "describe_tables",
    "fit_model",
    "minimal_table",
    "read_model",
    "reduced_table",
    "separating_set",
    "shift_variants",
    "smallest_hyperplanes",
    "smallest_sets",
    "training_grasps",
    "with_encoder",
    "write_model",
]

if TYPE_CHECKING:
    from varishold.grasp.classifier import HyperplaneClassifier
    from varishold.grasp.encoder import ThresholdEncoder, with_encoder
    from varishold.grasp.explanation import Explanation
    from varishold.grasp.hyperplanes import Hyperplanes, bisectors
    from varishold.grasp.model import GraspModel, fit_model
    from varishold.grasp.model_file import read_model, write_model
    from varishold.grasp.separating import Selection, separating_set, smallest_sets
    from varishold.grasp.sign_table import MinimalTable, SignTable, minimal_table, reduced_table, smallest_hyperplanes
    from varishold.grasp.tables import describe_tables
    from varishold.grasp.training import TrainingGrasps, training_grasps
    from varishold.grasp.variants import shift_variants
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
