"""The netlist's own JSON, by the name that exports use."""

from __future__ import annotations

from varishold.circuit.interchange import netlist_to_json
from varishold.circuit.netlist import Netlist
from varishold.circuit.writers.names import identifier

__all__ = ["json_files"]


def json_files(netlist: Netlist, name: str = "recognizer") -> dict[str, str]:
    """Return the netlist as one JSON file."""
    return {f"{identifier(name)}.json": netlist_to_json(netlist)}
