"""A netlist's layers from a parsed JSON document, without trusting it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from varishold.circuit.elements import Comparator, Hyperplane, Score, Term, shown
from varishold.errors import FormatError, InputError

__all__ = ["FORMAT", "VERSION", "netlist_layers"]

FORMAT: Final = "varishold-netlist"
VERSION: Final = 1


def netlist_layers(document: object, *, where: str) -> dict[str, tuple[Any, ...]]:
    """Return the layers of a netlist that a document holds, by their names.

    Raises
    ------
    FormatError
        Naming the place and what would be right.
    """
    if not isinstance(document, dict):
        raise FormatError(f"{where}: must be a JSON object, got {_kind(document)}")
    if document.get("format") != FORMAT:
        raise FormatError(f'{where}: "format" must be "{FORMAT}", got {_show(document.get("format"))}')
    version = document.get("version")
    if type(version) is not int or version < 1:
        raise FormatError(f'{where}: "version" must be a positive integer, got {_show(version)}')
    if version > VERSION:
        raise FormatError(
            f"{where}: written in version {_show(version)} of the format, "
            f"this program reads up to {VERSION}; update varishold"
        )
    _check_keys(
        document,
        required=("format", "version", "channels", "comparators", "units", "terms", "scores", "classes"),
        where=where,
    )

    def layer(key: str, build: Callable[[object], Any]) -> tuple[Any, ...]:
        items = document[key]
        if not isinstance(items, list):
            raise FormatError(f"{where}: {key} must be a list, got {_kind(items)}")
        out = []
        for k, item in enumerate(items):
            try:
                out.append(build(item))
            except InputError as error:
                raise FormatError(f"{where}: {key}[{k}]: {error}") from None
        return tuple(out)

    return {
        "channels": layer("channels", _name),
        "comparators": layer("comparators", lambda item: Comparator(*_pair(item))),
        "units": layer("units", _unit),
        "terms": layer("terms", lambda item: Term(_pair_list(item))),
        "scores": layer("scores", _score),
        "classes": layer("classes", _name),
    }


def _name(item: object) -> str:
    if not isinstance(item, str):
        raise InputError(f"must be a string, got {_kind(item)}")
    return item


def _pair(item: object) -> tuple[int, int]:
    if not isinstance(item, list) or len(item) != 2:
        raise InputError(f"must be a list of two integers, got {_show(item)}")
    for number in item:
        if type(number) is not int:
            raise InputError(f"must be a list of two integers, got {_show(item)}")
    return item[0], item[1]


def _pair_list(item: object) -> list[tuple[int, int]]:
    if not isinstance(item, list):
        raise InputError(f"must be a list of pairs, got {_kind(item)}")
    return [_pair(entry) for entry in item]


def _unit(item: object) -> Hyperplane:
    entry = _object(item, required=("weights", "bias"), optional=("pair",))
    pair = _pair(entry["pair"]) if "pair" in entry else None
    return Hyperplane(_pair_list(entry["weights"]), entry["bias"], pair)


def _score(item: object) -> Score:
    entry = _object(item, required=("weights", "bias"))
    return Score(_pair_list(entry["weights"]), entry["bias"])


def _object(item: object, *, required: tuple[str, ...], optional: tuple[str, ...] = ()) -> dict[str, Any]:
    if not isinstance(item, dict):
        raise InputError(f"must be an object with {', '.join(required)}, got {_kind(item)}")
    _check_keys(item, required=required, optional=optional, where="")
    return item


def _check_keys(item: dict[str, Any], *, required: tuple[str, ...], where: str, optional: tuple[str, ...] = ()) -> None:
    prefix = f"{where}: " if where else ""
    for key in required:
        if key not in item:
            raise FormatError(f'{prefix}"{key}" is missing')
    for key in item:
        if key not in required and key not in optional:
            raise FormatError(f"{prefix}{_show(key)} is not a key of version {VERSION}")


def _kind(value: object) -> str:
    names = {dict: "an object", list: "a list", str: "a string", bool: "a truth value", type(None): "null"}
    return names.get(type(value), "a number")


def _show(value: object) -> str:
    if isinstance(value, dict | list):
        return f"{_kind(value)} of length {len(value)}"
    return shown(value)
