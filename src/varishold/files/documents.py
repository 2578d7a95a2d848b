"""JSON and TOML of strangers: of bounded size and depth, and every fault told in one line."""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections import Counter
from typing import Any

from varishold.errors import FormatError
from varishold.files.opening import encoding_of, read_bytes

__all__ = ["parse_json", "read_json", "read_toml"]

# Well above what a program writes or a person types.
_LARGEST_JSON, _LARGEST_TOML = 1 << 30, 1 << 20
_DEEPEST = 64
# A key of very many parts: tomllib would take minutes over it, for its time grows with their square.
_KEY_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"{_KEY_PART}(?:[ \t]*+\.[ \t]*+{_KEY_PART}){{{_DEEPEST}}}")
# Python prints no integer of many more bits than these, which TOML can still hold as 0x...
_MOST_BITS = 10_000
_LONG_INTEGER = "holds an integer of thousands of digits"


def read_json(path: str | os.PathLike[str]) -> Any:
    """Return what a JSON file holds.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is no UTF-8, or UTF-16 or UTF-32 with a byte order mark, no JSON, repeats a key, or is nested too deeply.
    """
    return parse_json(_text(path, _LARGEST_JSON), where=str(path))


def parse_json(text: str, *, where: str, finite: bool = True) -> Any:
    """Return what a JSON text holds; `where` opens every message. Errors as in `read_json`.

    NaN and Infinity, which many programs write, are errors if `finite`.
    """
    constant = _no_constant if finite else float
    try:
        document = json.loads(text, parse_constant=constant, object_pairs_hook=_without_repeats)
    except json.JSONDecodeError as error:
        reason = f"{error.msg} at line {error.lineno}, column {error.colno}"
        raise FormatError(f"{where}: is not complete JSON: {reason}") from None
    except RecursionError:
        raise FormatError(f"{where}: is nested too deeply") from None
    except ValueError as error:
        raise FormatError(f"{where}: {_too_long(error)}") from None
    _check_printable(document, where)
    return document


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is no UTF-8, or UTF-16 or UTF-32 with a byte order mark, or no TOML, or is nested too deeply.
    """
    text = _text(path, _LARGEST_TOML)
    if _LONG_KEY.search(text):
        raise FormatError(f"{path}: is nested deeper than {_DEEPEST} levels")
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FormatError(f"{path}: is not a TOML file: {error}") from None
    except RecursionError:
        raise FormatError(f"{path}: is nested too deeply") from None
    except ValueError as error:
        raise FormatError(f"{path}: {_too_long(error)}") from None
    _check_printable(content, str(path))
    return content


def _text(path: str | os.PathLike[str], most: int) -> str:
    content = read_bytes(path, most=most)
    encoding, skipped = encoding_of(content)
    try:
        return content[skipped:].decode(encoding)
    except UnicodeDecodeError as error:
        known = encoding[: len("utf-16")].upper()
        raise FormatError(f"{path}: is no {known} text: byte {skipped + error.start} is not") from None


def _too_long(error: ValueError) -> str:
    return _LONG_INTEGER if "integer string" in str(error) else str(error)


def _no_constant(name: str) -> float:
    raise ValueError(f"numbers must be finite, got {name}")


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        twice = Counter(key for key, _ in pairs).most_common(1)[0][0]
        raise ValueError(f"key {ascii(twice)[:60]} stands twice in one object")
    return made


def _check_printable(document: Any, where: str) -> None:
    """Refuse what a message about it could not print."""
    level = [document]
    for _ in range(_DEEPEST):
        within = [
            inner
            for outer in level
            if isinstance(outer, dict | list)
            for inner in (outer.values() if isinstance(outer, dict) else outer)
        ]
        if any(isinstance(inner, int) and inner.bit_length() > _MOST_BITS for inner in within):
            raise FormatError(f"{where}: {_LONG_INTEGER}")
        level = [inner for inner in within if isinstance(inner, dict | list) and inner]
        if not level:
            return
    raise FormatError(f"{where}: is nested deeper than {_DEEPEST} levels")
