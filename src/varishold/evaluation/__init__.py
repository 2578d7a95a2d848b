"""Evaluation: how well a user's own things will be told apart tomorrow, and how far that figure may be believed.

`evaluate` learns and tests on what was held out, beside plain peers and with warnings about leaks; `evaluate_model` and
`evaluate_shipped` test what was learned before. Each returns an `Evaluation`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = ["SHOTS", "Evaluation", "Figure", "Leak", "evaluate", "evaluate_model", "evaluate_shipped"]

if TYPE_CHECKING:
    from varishold.evaluation.figures import Figure
    from varishold.evaluation.given import evaluate_model, evaluate_shipped
    from varishold.evaluation.leaks import Leak
    from varishold.evaluation.result import Evaluation
    from varishold.evaluation.running import evaluate
    from varishold.evaluation.shots import SHOTS
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
