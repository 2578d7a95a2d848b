"""A figure as a file: its kind by its ending, the same bytes for the same figure."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from varishold.errors import InputError
from varishold.files import atomic_write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["figure_kind", "save_figure"]

# By what a figure of each kind was made, and never when.
_UNSAID = {
    "png": {"Software": "varishold"},
    "svg": {"Date": None, "Creator": "varishold"},
    "pdf": {"CreationDate": None, "Creator": "varishold"},
}


def figure_kind(path: str | os.PathLike[str]) -> str:
    """Return png, svg or pdf, by a file's ending.

    Raises
    ------
    InputError
        If the ending is none of these.
    """
    kind = Path(path).suffix.lower().removeprefix(".")
    if kind not in _UNSAID:
        raise InputError(f"{path}: a figure's name must end in {', '.join('.' + k for k in _UNSAID)}")
    return kind


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure; a file that is there is replaced only when the new one is complete.

    Raises
    ------
    InputError
        If the ending is no kind of figure, or the file cannot be written.
    """
    kind = figure_kind(path)
    with atomic_write(path) as file:
        figure.savefig(file, format=kind, dpi=150, metadata=_UNSAID[kind])
