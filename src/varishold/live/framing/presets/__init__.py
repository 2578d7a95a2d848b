"""Framings that are known by name: one TOML file each."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from varishold.errors import InputError
from varishold.live.framing.file import read_framing
from varishold.live.framing.model import Framing

__all__ = ["FRAMINGS", "framing_of"]

#: The file of every preset, by its name.
FRAMINGS: Mapping[str, Path] = MappingProxyType(
    {path.stem: path for path in sorted(Path(__file__).parent.glob("*.toml"))}
)


def framing_of(name: str | os.PathLike[str]) -> Framing:
    """Return the framing of a preset's name or of a framing file.

    Parameters
    ----------
    name : str or path-like
        A name of `FRAMINGS`, or a TOML file. A file of the same name goes first.

    Raises
    ------
    InputError
        If it is neither, or the file cannot be read.

    Examples
    --------
    >>> framing_of("flexitac").baud
    2000000
    """
    text = os.fspath(name)
    if text in FRAMINGS and not Path(text).is_file():
        return read_framing(FRAMINGS[text])
    if not text.endswith(".toml") and not Path(text).exists():
        raise InputError(
            f"{text}: is no framing file (TOML) and no preset; presets are {', '.join(FRAMINGS)} (varishold sources)"
        )
    return read_framing(text)
