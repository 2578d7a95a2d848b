"""Verilog-2001 for an FPGA: a combinational module, a registered one, and a bench that checks both."""

from __future__ import annotations

from varishold.circuit.elements import Hyperplane
from varishold.circuit.evaluation import evaluate
from varishold.circuit.netlist import Netlist
from varishold.circuit.simplification import simplify
from varishold.circuit.writers.names import comments, identifier
from varishold.circuit.writers.templates import render
from varishold.circuit.writers.vectors import check_vectors
from varishold.errors import InputError, require
from varishold.frame.checks import as_whole

__all__ = ["verilog_files"]


def verilog_files(
    netlist: Netlist, name: str = "recognizer", *, vectors: int = 1024, count_bits: int = 32
) -> dict[str, str]:
    """Return the modules, a self-checking test bench and its vectors.

    Parameters
    ----------
    netlist : Netlist
    name : str
        Made an identifier, it opens every file's and module's name.
    vectors : int
        Inputs that the bench checks; with that many patterns or fewer, all of them.
    count_bits : int
        Width of a count, two's complement, where the netlist has comparators; 1 to 32.

    Returns
    -------
    dict of str to str
        Texts by file name: ``NAME.v``, ``NAME_tb.v`` and ``NAME_vectors.hex``, which the bench reads
        from the folder in which it runs.

    Raises
    ------
    InputError
        Where `count_bits` is no such width, or a threshold does not fit it.
    """
    count_bits = as_whole(count_bits, "count_bits")
    require(count_bits <= 32, f"count_bits must be a whole number from 1 to 32, got {count_bits}")
    name = identifier(name)
    small = simplify(netlist)
    largest = 2 ** (count_bits - 1) - 1
    for k, comparator in enumerate(netlist.comparators):
        if not -largest - 1 <= comparator.threshold <= largest:
            raise InputError(
                f"comparators[{k}] has threshold {comparator.threshold}, which does not fit "
                f"{count_bits} signed bits; raise count_bits"
            )
    r = len(netlist.channels)
    width = r * count_bits if netlist.comparators else r
    index_width = max(1, (len(netlist.classes) - 1).bit_length())
    X = check_vectors(netlist, vectors, largest=largest)
    digits = -(-(width + index_width) // 4)
    lines = []
    for row, expected in zip(X.tolist(), evaluate(netlist, X).tolist(), strict=True):
        word = expected
        for value in reversed(row):
            word = word << count_bits | value % 2**count_bits if netlist.comparators else word << 1 | value
        lines.append(f"{word:0{digits}x}")
    values = {
        "name": name,
        "port": "counts" if netlist.comparators else "switches",
        "width": width,
        "index_width": index_width,
        "channels": comments(netlist.channels),
        "labels": comments(netlist.classes),
        "bit_count": netlist.bit_count,
        "comparisons": [
            (k, c.channel * count_bits, _signed_constant(c.threshold, count_bits))
            for k, c in enumerate(netlist.comparators)
        ],
        "count_bits": count_bits,
        "units": [_unit(unit) for unit in small.units],
        "terms": [
            " & ".join(f"{'' if wanted else '~'}fired_{unit}" for unit, wanted in term.literals) for term in small.terms
        ],
        "scores": _scores(small),
        "score_width": _score_width(small),
        "vectors": len(lines),
    }
    return {
        f"{name}.v": render("verilog.v.j2", **values),
        f"{name}_tb.v": render("verilog_tb.v.j2", **values),
        f"{name}_vectors.hex": "\n".join(lines) + "\n",
    }


def _unit(unit: Hyperplane) -> dict[str, object]:
    """Return the sum of a unit with positive weights alone: w x is |w| (1 - x) - |w| for w < 0."""
    bound = unit.bias - sum(min(weight, 0) for _, weight in unit.weights)
    total = sum(abs(weight) for _, weight in unit.weights)
    width = total.bit_length()
    summands = []
    for bit, weight in unit.weights:
        literal = f"bits[{bit}]" if weight > 0 else f"!bits[{bit}]"
        size = abs(weight)
        summands.append(literal if size == 1 else f"({literal} ? {width}'d{size} : {width}'d0)")
    return {"width": width, "sum": " + ".join(summands), "bound": f"{width}'d{bound}"}


def _scores(netlist: Netlist) -> list[str]:
    # The same added to every class changes nothing: no weight and no bias need be negative.
    width = _score_width(netlist)
    columns, biases = _raised_scores(netlist)
    out = []
    for k, bias in enumerate(biases):
        summands = [
            f"(term_{t} ? {width}'d{column[k]} : {width}'d0)" if column[k] > 1 else f"term_{t}"
            for t, column in enumerate(columns)
            if column[k]
        ]
        if bias or not summands:
            summands.append(f"{width}'d{bias}")
        out.append(" + ".join(summands))
    return out


def _raised_scores(netlist: Netlist) -> tuple[list[list[int]], list[int]]:
    rows = [dict(score.weights) for score in netlist.scores]
    columns = [[row.get(t, 0) for row in rows] for t in range(len(netlist.terms))]
    least = min(score.bias for score in netlist.scores)
    return (
        [[weight - min(column) for weight in column] for column in columns],
        [score.bias - least for score in netlist.scores],
    )


def _score_width(netlist: Netlist) -> int:
    columns, biases = _raised_scores(netlist)
    largest = max(bias + sum(column[k] for column in columns) for k, bias in enumerate(biases))
    return max(1, largest.bit_length())


def _signed_constant(value: int, width: int) -> str:
    # The magnitude of the most negative count does not fit; its bit pattern does.
    return f"$signed({width}'h{value % 2**width:x})"
