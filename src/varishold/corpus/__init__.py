"""The corpus: many recordings, answered by many workers, in one table.

`run_corpus` asks every recording the same (`AskTouch`, `AskMeasure`, `AskRecognize`), a block of frames a task, and
joins what the tasks have written to one Parquet file. What was done stays where it is when a run is interrupted, and
the next run goes on from there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = ["AskMeasure", "AskRecognize", "AskTouch", "Column", "Outcome", "run_corpus"]

if TYPE_CHECKING:
    from varishold.corpus.columns import Column
    from varishold.corpus.measure import AskMeasure
    from varishold.corpus.recognize import AskRecognize
    from varishold.corpus.run import Outcome, run_corpus
    from varishold.corpus.touch import AskTouch
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
