"""A netlist as JSON, and back without trusting the file."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from typing import Any, Final, TypeVar

from varishold.circuit.netlist import Comparator, Hyperplane, Netlist, Score, Term
from varishold.errors import FormatError, InputError
from varishold.files import atomic_write, parse_json, read_json

__all__ = [
    "FORMAT",
    "VERSION",
    "netlist_from_dict",
    "netlist_from_json",
    "netlist_to_dict",
    "netlist_to_json",
    "read_netlist",
    "write_netlist",
]

FORMAT: Final = "varishold-netlist"
VERSION: Final = 1

_T = TypeVar("_T")


def netlist_to_dict(netlist: Netlist) -> dict[str, Any]:
    """Return the netlist as lists, strings and integers, in a fixed order of keys."""
    units: list[dict[str, Any]] = []
    for unit in netlist.units:
        entry: dict[str, Any] = {"weights": [list(pair) for pair in unit.weights], "bias": unit.bias}
        if unit.pair is not None:
            entry["pair"] = list(unit.pair)
        units.append(entry)
    return {
        "format": FORMAT,
        "version": VERSION,
        "channels": list(netlist.channels),
        "comparators": [[c.channel, c.threshold] for c in netlist.comparators],
        "units": units,
        "terms": [[list(literal) for literal in term.literals] for term in netlist.terms],
        "scores": [{"weights": [list(pair) for pair in score.weights], "bias": score.bias} for score in netlist.scores],
        "classes": list(netlist.classes),
    }


def netlist_from_dict(document: object, *, where: str = "netlist") -> Netlist:
    """Build a netlist from a parsed JSON document.

    Parameters
    ----------
    document : object
        What `netlist_to_dict` returned, or anything at all.
    where : str
        Opens every error message: a file's name, or a place in a larger document.

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

    def layer(key: str, build: Callable[[object], _T]) -> tuple[_T, ...]:
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

    try:
        return Netlist(
            channels=layer("channels", _name),
            comparators=layer("comparators", lambda item: Comparator(*_pair(item))),
            units=layer("units", _unit),
            terms=layer("terms", lambda item: Term(_pair_list(item))),
            scores=layer("scores", _score),
            classes=layer("classes", _name),
        )
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{where}: {error}") from None


def netlist_to_json(netlist: Netlist) -> str:
    """Return the netlist as a JSON document, one line a unit, the same bytes for the same netlist."""
    document = netlist_to_dict(netlist)
    lines = []
    for key, value in document.items():
        if isinstance(value, list) and value:
            rows = ",\n".join(f"  {json.dumps(item, ensure_ascii=False)}" for item in value)
            lines.append(f" {json.dumps(key)}: [\n{rows}\n ]")
        else:
            lines.append(f" {json.dumps(key)}: {json.dumps(value)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def netlist_from_json(text: str, *, where: str = "netlist") -> Netlist:
    """Parse a JSON document into a netlist.

    Raises
    ------
    FormatError
        Where the text is not JSON, repeats a key, or does not describe a netlist.
    """
    return netlist_from_dict(parse_json(text, where=where), where=where)


def read_netlist(path: str | os.PathLike[str]) -> Netlist:
    """Read a netlist's JSON file; nothing in it is executed.

    Raises
    ------
    FormatError
        Where the file cannot be read as a netlist, naming the file and the place.
    """
    return netlist_from_dict(read_json(path), where=str(path))


def write_netlist(netlist: Netlist, path: str | os.PathLike[str]) -> None:
    """Write a netlist's JSON file in one step: a reader finds the old file or the new one."""
    with atomic_write(path, "w") as file:
        file.write(netlist_to_json(netlist))


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
    if isinstance(value, int) and abs(value) > 10**30:
        return "an integer of more than 30 digits"
    if isinstance(value, dict | list):
        return _kind(value) + f" of length {len(value)}"
    text = ascii(value)
    return text if len(text) <= 40 else text[:37] + "..."
