"""The paper's Tables 1 to 4 from its own data: what agrees, what was restored, and the circuit.

Run: python -m benchmarks.grasp_paper
"""

from __future__ import annotations

from benchmarks._figures import figure
from varishold.circuit import gate_count
from varishold.grasp import HyperplaneClassifier, minimal_table, smallest_hyperplanes, smallest_sets
from varishold.paper import lost_columns, paper_table, printed_sign_table


def main() -> None:
    """Print agreement and the circuit."""
    for number in (1, 2, 3, 4):
        table = paper_table(number)
        figure(f"Table {number} agrees", table.agrees)
        print(f"Table {number}: {'agrees' if table.agrees else 'misprinted; see varishold paper table 1'}")
    signs = printed_sign_table()
    chosen, selection = smallest_hyperplanes(signs)
    sets = smallest_sets(signs.signs, signs.codes, size=len(selection.columns))
    n_sets = figure("smallest separating sets", len(sets or []))
    print(f"smallest separating set: {', '.join(chosen.hyperplanes)}; sets of that size: {n_sets}")
    print(f"places where the lost column of Table 2 fits: {[place for place, _ in lost_columns()]}")
    print(f"cylinder = {minimal_table(chosen).formula(1)}")
    circuit = HyperplaneClassifier("paper").fit(chosen.signs, list(chosen.labels)).netlist_
    print(f"gates of a circuit over the two signs: {figure('gates over the two signs', gate_count(circuit))}")


if __name__ == "__main__":
    main()
