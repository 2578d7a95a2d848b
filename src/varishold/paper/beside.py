"""One of the paper's tables beside ours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

__all__ = ["PaperTable"]


@dataclass(frozen=True)
class PaperTable:
    """One of the paper's tables beside ours.

    Parameters
    ----------
    number : int
    title : str
        As in the paper.
    scanned, ours : str
        Printed forms.
    restored : str or None
        Printed form after restoration; None where the scan needs none.
    notes : tuple of str
        What was restored and why; what was computed and how.
    agrees : bool
        Whether our computation gives the paper's table.
    rows : tuple of dict
        The same as JSON-ready rows.
    """

    number: int
    title: str
    scanned: str
    restored: str | None
    ours: str
    notes: tuple[str, ...]
    agrees: bool
    rows: tuple[dict[str, Any], ...]

    def __str__(self) -> str:
        blocks = [f"Table {self.number}. {self.title}", f"As scanned:\n{self.scanned}"]
        if self.restored is not None:
            blocks.append(f"Restored:\n{self.restored}")
        blocks.append(f"Computed here ({'agrees' if self.agrees else 'differs'}):\n{self.ours}")
        blocks.append("\n".join(f"- {note}" for note in self.notes))
        return "\n\n".join(blocks)
