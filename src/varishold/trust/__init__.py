"""Trust: how far an answer may be believed, measured on what was not learned from.

Folds that keep a session together (`group_folds`), probabilities calibrated on held-out answers (`Calibration`), the
conformal p-value of "this is like what was learned" (`conformal_p_value`), one belief from several sources (`fuse`),
and how far a counted share may be off (`share_interval`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "Calibration",
    "SourceWeights",
    "calibrate",
    "choose_weights",
    "conformal_p_value",
    "fuse",
    "group_folds",
    "kept_together",
    "same_partition",
    "share_interval",
]

if TYPE_CHECKING:
    from varishold.trust.conformal import conformal_p_value
    from varishold.trust.folds import group_folds, kept_together, same_partition
    from varishold.trust.fusion import SourceWeights, choose_weights, fuse
    from varishold.trust.interval import share_interval
    from varishold.trust.probability import Calibration, calibrate
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
