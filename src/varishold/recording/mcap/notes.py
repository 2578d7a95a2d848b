"""Words beside the readings: JSON text in messages, whatever a person or a program puts into it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from varishold.errors import FormatError
from varishold.files import parse_json
from varishold.recording.mcap.cdr import string_of

__all__ = ["note_of", "note_text"]


def note_text(told: Mapping[str, Any]) -> str:
    """Return a note as JSON text; numbers that are not finite stand as text, arrays as lists.

    Examples
    --------
    >>> note_text({"label": "cone", "noise": float("nan"), "taxels": np.arange(2)})
    '{"label": "cone", "noise": "nan", "taxels": [0, 1]}'
    """
    return json.dumps(_plain(told), allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(each) for each in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    return value if isinstance(value, bool | int | str | None) else str(value)


def note_of(message: bytes, *, where: str) -> dict[str, Any]:
    """Return the note that a message holds.

    Raises
    ------
    FormatError
        If it is no JSON object.
    """
    try:
        told = parse_json(string_of(message), where=where)
    except ValueError as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"{where}: {error}") from None
    if not isinstance(told, dict):
        raise FormatError(f"{where}: must be a JSON object, got {str(told)[:60]!r}")
    return told
