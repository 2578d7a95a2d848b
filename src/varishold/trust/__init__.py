"""Trust: how far an answer may be believed, measured on what was not learned from.

Folds that keep a session together (`group_folds`), probabilities calibrated on held-out answers (`Calibration`), of
which the rare ones count more (`class_weights`), the conformal p-value of "this is like what was learned"
(`conformal_p_value`), ranges of what was learned (`learn_ranges`), answers that promise nothing outside of it
(`widened`), one belief from several sources (`fuse`), and how far a counted share (`share_interval`), or the difference
of two (`difference_interval`), may be off.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "Calibration",
    "Ranges",
    "SourceWeights",
    "calibrate",
    "choose_weights",
    "class_weights",
    "conformal_p_value",
    "difference_interval",
    "first_without_name",
    "fuse",
    "group_folds",
    "held_out_beyond",
    "kept_together",
    "known_share",
    "learn_ranges",
    "least_error",
    "merged_p_value",
    "same_partition",
    "share_interval",
    "strange_share",
    "weighed_p_value",
    "widened",
]

if TYPE_CHECKING:
    from varishold.trust.conformal import (
        conformal_p_value,
        known_share,
        least_error,
        merged_p_value,
        strange_share,
        weighed_p_value,
        widened,
    )
    from varishold.trust.folds import first_without_name, group_folds, kept_together, same_partition
    from varishold.trust.fusion import SourceWeights, choose_weights, fuse
    from varishold.trust.interval import difference_interval, share_interval
    from varishold.trust.probability import Calibration, calibrate, class_weights
    from varishold.trust.ranges import Ranges, held_out_beyond, learn_ranges
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
