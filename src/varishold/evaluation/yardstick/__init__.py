"""The yardstick: frames of faulty sensors and awkward poses, apart from all that the shipped tables learned from.

`score_function` lets any function name them, and tells what its answers are worth. `rows` lists faults and poses, each
at one strength; `media` presses the faces of `forms` by the solver of `solver`; `faults` says what sensors do to the
frames.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "FRAMES",
    "ROWS",
    "SEED",
    "SHAPES",
    "VERSION",
    "Row",
    "RowScore",
    "ShapeScore",
    "Told",
    "YardstickScore",
    "load_function",
    "read_answer",
    "score_function",
    "score_functions",
    "shipped_names",
]

if TYPE_CHECKING:
    from varishold.evaluation.yardstick.answers import Told, read_answer, shipped_names
    from varishold.evaluation.yardstick.loading import load_function
    from varishold.evaluation.yardstick.rows import ROWS, Row
    from varishold.evaluation.yardstick.scoring import (
        FRAMES,
        SEED,
        SHAPES,
        VERSION,
        RowScore,
        ShapeScore,
        YardstickScore,
        score_function,
        score_functions,
    )
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
