"""Figures by matplotlib, and their files: the same bytes for the same figure."""

from __future__ import annotations

import io
import logging
import os
from pathlib import Path
from tempfile import gettempdir
from typing import TYPE_CHECKING

from varishold.errors import InputError
from varishold.files import atomic_write, folder_beside

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["figure_kind", "new_figure", "save_figure"]

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


def new_figure(width_in: float, height_in: float, *, beside: str | os.PathLike[str]) -> Figure:
    """Make an empty figure that needs no screen.

    Parameters
    ----------
    width_in, height_in : float
        Its size in inches.
    beside : str or path-like
        The file to be written. Where matplotlib may write nowhere else it keeps its list of fonts there for a moment.
    """
    # It tells every caller where it would rather have kept that list.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    try:
        gettempdir()
    except OSError:
        with folder_beside(Path(beside)) as kept:
            os.environ.setdefault("MPLCONFIGDIR", str(kept.absolute()))
            import matplotlib.figure  # noqa: F401
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained", facecolor="white")


def save_figure(figure: Figure, path: str | os.PathLike[str], *, kind: str | None = None, dpi: int = 110) -> None:
    """Write a figure; a file that is there is replaced only when the new one is complete.

    Parameters
    ----------
    figure : Figure
    path : str or path-like
    kind : {"png", "svg", "pdf"}, optional
        Default: by the file's ending.
    dpi : int
        Pixels an inch.

    Raises
    ------
    InputError
        If the ending is no kind of figure, or the file cannot be written.
    """
    kind = kind or figure_kind(path)
    picture = io.BytesIO()
    figure.savefig(picture, format=kind, dpi=dpi, metadata=_UNSAID[kind])
    with atomic_write(path) as file:
        file.write(picture.getvalue())
