"""What another sense said before anything was touched, in a file: a camera's guess, as JSON."""

from __future__ import annotations

import os
from dataclasses import fields

from varishold.errors import FormatError, InputError
from varishold.files.documents import read_json
from varishold.perceive.name_evidence import NameEvidence

__all__ = ["read_prior"]

_KEYS = tuple(field.name for field in fields(NameEvidence))
_NEEDED = ("source", "probability")


def read_prior(path: str | os.PathLike[str]) -> NameEvidence:
    """Read what somebody says of an object's name: an object with the keys of `NameEvidence`.

    Parameters
    ----------
    path : str or path-like
        JSON, as in ``{"source": "camera", "probability": {"sphere": 0.7, "cone": 0.3}}``.

    Raises
    ------
    FormatError
        If it is no such file, in one line.
    """
    said = read_json(path)
    if not isinstance(said, dict) or not all(key in said for key in _NEEDED):
        raise FormatError(f'{path}: must be {{"source": WHO, "probability": {{NAME: SHARE, ...}}}}')
    unknown = [key for key in said if key not in _KEYS]
    if unknown:
        raise FormatError(f"{path}: has no key {ascii(unknown[0])[:60]}; known are {', '.join(_KEYS)}")
    try:
        return NameEvidence(**said)
    except InputError as error:
        raise FormatError(f"{path}: {error}") from None
