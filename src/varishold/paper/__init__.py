"""The paper: its tables as data, and its experiments as functions.

`paper_table` gives each table as the scan has it, as it was restored and why, and as it is computed here.

References
----------
G. Kinoshita, S. Aida and M. Mori, "Pattern recognition by an artificial tactile sense", 1971, section 3.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "Accuracy",
    "PaperTable",
    "PrintedHyperplane",
    "lost_columns",
    "paper_table",
    "printed_accuracies",
    "printed_hyperplanes",
    "printed_minimal_table",
    "printed_reduced_table",
    "printed_sign_table",
    "scanned_signs",
    "scanned_text",
]

if TYPE_CHECKING:
    from varishold.paper.beside import PaperTable
    from varishold.paper.experiments import lost_columns, paper_table
    from varishold.paper.tables import (
        Accuracy,
        PrintedHyperplane,
        printed_accuracies,
        printed_hyperplanes,
        printed_minimal_table,
        printed_reduced_table,
        printed_sign_table,
        scanned_signs,
        scanned_text,
    )
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
