"""Size of generated circuits: two-input gates by construction, cells by yosys + abc, bytes of C.

Run with ``python -m benchmarks.circuit_cells``. Cells are those of the combinational Verilog module after
``synth -flatten`` and ``abc -g AND,NAND,OR,NOR,XOR,XNOR`` (two-input gates; NOT, which abc adds, is counted
apart), and after ``synth_ice40`` (four-input lookup tables and carries of a small FPGA). Bytes are gcc -Os
on this machine's architecture.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from pathlib import Path

from benchmarks._figures import figure
from benchmarks.circuit_speed import robust_netlist
from varishold.circuit import Hyperplane, Netlist, Score, Term, gate_count
from varishold.circuit.writers import verilog_files
from varishold.circuit.writers.c99 import compiled_size

GATES = "AND,NAND,OR,NOR,XOR,XNOR"


def paper_netlist() -> Netlist:
    """Make the circuit of the paper's size: two hyperplanes of nine and seven switches, one term."""
    first = Hyperplane([(k, 1 if k % 2 else -1) for k in range(9)], 0)
    third = Hyperplane([(k, 1 if k % 3 else -1) for k in range(4, 11)], 1)
    return Netlist(
        channels=tuple(f"v{k + 1}" for k in range(11)),
        comparators=(),
        units=(first, third),
        terms=(Term([(0, 1), (1, 0)]),),
        scores=(Score([], 1), Score([(0, 2)])),
        classes=("pillar", "cylinder"),
    )


def cells(netlist: Netlist, commands: str) -> dict[str, int]:
    """Return the number of cells by type after the yosys commands."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in verilog_files(netlist, "hand", vectors=1).items():
            Path(folder, file).write_text(text, encoding="utf-8")
        script = f"read_verilog hand.v; {commands}; tee -q -o stat.json stat -json"
        subprocess.run(["yosys", "-q", "-p", script], cwd=folder, check=True, timeout=240)
        report = json.loads(Path(folder, "stat.json").read_text())
    counted: dict[str, int] = report["design"]["num_cells_by_type"]
    return counted


def main() -> None:
    """Print the sizes of a few netlists."""
    netlists = {
        "paper's size": paper_netlist(),
        "compact, 8 hyperplanes of 7": robust_netlist(1, hyperplanes=8, switches_each=7, terms=5),
        "robust, 12 hyperplanes of 9": robust_netlist(0),
        "robust, 15 hyperplanes of 9": robust_netlist(2, hyperplanes=15, terms=10),
    }
    yosys = shutil.which("yosys")
    for name, netlist in netlists.items():
        print(f"{name}: {figure(f'{name}: two-input gates', gate_count(netlist))} two-input gates by construction")
        if yosys:
            mapped = cells(netlist, f"synth -flatten -top hand; abc -g {GATES}; opt_clean")
            inverters = sum(count for kind, count in mapped.items() if kind.strip("$_") == "NOT")
            n_cells = figure(f"{name}: yosys + abc", sum(mapped.values()) - inverters, "", "cells")
            print(f"  yosys + abc ({GATES}): {n_cells} and {inverters} NOT")
            lookup = cells(netlist, "synth_ice40 -top hand")
            luts = figure(f"{name}: yosys synth_ice40", lookup.get("SB_LUT4", 0), "", "SB_LUT4")
            print(f"  yosys synth_ice40: {luts}, {lookup.get('SB_CARRY', 0)} SB_CARRY")
        else:
            print("  yosys is not installed: no cell count")
        size = compiled_size(netlist)
        if size is None:
            print("  gcc or size is not installed: no bytes")
        else:
            text = figure(f"{name}: gcc -Os", size["text"], "", "bytes of text")
            print(f"  gcc -Os: {text}, {size['data']} of data, {size['bss']} of bss")


if __name__ == "__main__":
    main()
