"""A netlist as JSON, and back without trusting the file."""

from __future__ import annotations

import json
import os

from varishold.circuit.netlist import Netlist
from varishold.files import atomic_write, parse_json, read_json

__all__ = ["netlist_from_json", "netlist_to_json", "read_netlist", "write_netlist"]


def netlist_to_json(netlist: Netlist) -> str:
    """Return the netlist as a JSON document, one line a unit, the same bytes for the same netlist."""
    document = netlist.to_dict()
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
    return Netlist.from_dict(parse_json(text, where=where), where=where)


def read_netlist(path: str | os.PathLike[str]) -> Netlist:
    """Read a netlist's JSON file; nothing in it is executed.

    Raises
    ------
    FormatError
        Where the file cannot be read as a netlist, naming the file and the place.
    """
    return Netlist.from_dict(read_json(path), where=str(path))


def write_netlist(netlist: Netlist, path: str | os.PathLike[str]) -> None:
    """Write a netlist's JSON file in one step: a reader finds the old file or the new one."""
    with atomic_write(path, "w") as file:
        file.write(netlist_to_json(netlist))
