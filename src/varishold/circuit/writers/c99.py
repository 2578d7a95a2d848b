"""C99 for a microcontroller: tables of small integers, no allocation, no floating point."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from varishold.circuit.evaluation import evaluate
from varishold.circuit.netlist import Netlist
from varishold.circuit.simplification import simplify
from varishold.circuit.writers.names import c_string, comments, identifier
from varishold.circuit.writers.templates import render
from varishold.circuit.writers.vectors import check_vectors

__all__ = ["c99_files", "compiled_size"]


def c99_files(netlist: Netlist, name: str = "recognizer", *, vectors: int = 256) -> dict[str, str]:
    """Return a header, a source and a self-test, clean under ``-std=c99 -Wall -Wextra -Werror -pedantic``.

    ``NAME_classify`` takes an array of switches (``uint8_t``, anything but 0 is on), or of counts
    (``int32_t``) where the netlist has comparators, and returns the class index.

    Parameters
    ----------
    netlist : Netlist
    name : str
        Made an identifier, it opens every file's and symbol's name.
    vectors : int
        Inputs that the self-test holds and checks.

    Returns
    -------
    dict of str to str
        Texts by file name.
    """
    name = identifier(name, header=True)
    small = simplify(netlist)
    X = check_vectors(netlist, vectors)
    used = sorted({bit for unit in small.units for bit, _ in unit.weights})
    place = {bit: k for k, bit in enumerate(used)}
    literals = [2 * unit + wanted for term in small.terms for unit, wanted in term.literals]
    sums = [(unit.weights, unit.bias) for unit in small.units]
    sums += [(score.weights, score.bias) for score in small.scores]
    reach = max(sum(abs(weight) for _, weight in weights) + abs(bias) for weights, bias in sums)
    columns = [
        [(k, dict(score.weights).get(t, 0)) for k, score in enumerate(small.scores)] for t in range(len(small.terms))
    ]
    gains = [[(k, w) for k, w in column if w] for column in columns]
    values = {
        "name": name,
        "guard": f"{name.upper()}_H",
        "prefix": name.upper(),
        "counts": bool(netlist.comparators),
        "channels": comments(netlist.channels),
        "labels": [c_string(label) for label in netlist.classes],
        "accumulator": _signed_type([reach, -reach]),
        "bits": len(used),
        "bit_channels": [netlist.comparators[bit].channel if netlist.comparators else bit for bit in used],
        "bit_channel_type": _unsigned_type(len(netlist.channels)),
        "bit_thresholds": [netlist.comparators[bit].threshold for bit in used] if netlist.comparators else [],
        "units": len(small.units),
        "unit_ends": _ends([len(unit.weights) for unit in small.units]),
        "unit_end_type": _unsigned_type(sum(len(unit.weights) for unit in small.units)),
        "inputs": [place[bit] for unit in small.units for bit, _ in unit.weights],
        "input_type": _unsigned_type(len(used)),
        "weights": [weight for unit in small.units for _, weight in unit.weights],
        "weight_type": _signed_type([weight for unit in small.units for _, weight in unit.weights]),
        "biases": [unit.bias for unit in small.units],
        "bias_type": _signed_type([unit.bias for unit in small.units]),
        "terms": len(small.terms),
        "term_ends": _ends([len(term.literals) for term in small.terms]),
        "term_end_type": _unsigned_type(len(literals)),
        "literals": literals,
        "literal_type": _unsigned_type(2 * len(small.units)),
        "gain_ends": _ends([len(gain) for gain in gains]),
        "gain_end_type": _unsigned_type(sum(map(len, gains))),
        "gain_classes": [k for gain in gains for k, _ in gain],
        "gain_class_type": _unsigned_type(len(small.scores)),
        "gains": [w for gain in gains for _, w in gain],
        "gain_type": _signed_type([w for gain in gains for _, w in gain]),
        "score_biases": [score.bias for score in small.scores],
        "vectors": X.tolist(),
        "expected": evaluate(netlist, X).tolist(),
    }
    return {
        f"{name}.h": render("c99.h.j2", **values),
        f"{name}.c": render("c99.c.j2", **values),
        f"{name}_test.c": render("c99_test.c.j2", **values),
    }


def compiled_size(netlist: Netlist, *, compiler: str = "gcc") -> dict[str, int] | None:
    """Return the bytes of the compiled classifier by section ("text", "data", "bss"), at -Os.

    Parameters
    ----------
    netlist : Netlist
    compiler : str
        A command that takes gcc's options; ``size`` of binutils must be there, too.

    Returns
    -------
    dict of str to int, or None
        None where the compiler or ``size`` is missing.
    """
    if shutil.which(compiler) is None or shutil.which("size") is None:
        return None
    files = c99_files(netlist, "recognizer")
    with tempfile.TemporaryDirectory() as folder:
        for file, text in files.items():
            Path(folder, file).write_text(text, encoding="utf-8")
        command = [compiler, "-std=c99", "-Os", "-c", "recognizer.c", "-o", "recognizer.o"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        report = subprocess.run(["size", "recognizer.o"], cwd=folder, check=True, capture_output=True, text=True)
    text_bytes, data, bss = report.stdout.splitlines()[1].split()[:3]
    return {"text": int(text_bytes), "data": int(data), "bss": int(bss)}


def _ends(lengths: list[int]) -> list[int]:
    return [int(end) for end in np.cumsum(lengths)]


def _unsigned_type(count: int) -> str:
    """Return the smallest type that holds 0 ... count."""
    return "uint8_t" if count <= 0xFF else "uint16_t" if count <= 0xFFFF else "uint32_t"


def _signed_type(values: list[int]) -> str:
    largest = max((abs(value) for value in values), default=0)
    return "int8_t" if largest <= 0x7F else "int16_t" if largest <= 0x7FFF else "int32_t"
