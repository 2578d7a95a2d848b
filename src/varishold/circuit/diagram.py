"""The block diagram of a netlist, for a person to read: switches, hyperplanes, inverters, AND, OR, class.

As text it is a crossbar: switches run across the hyperplanes' columns and leave their weights there, and
the hyperplanes' columns run down across the terms, which take them as they are (●) or inverted (○). As a
drawing it is laid out from left to right like Fig. 5 of the paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

if TYPE_CHECKING:
    from varishold.circuit.netlist import Netlist


__all__ = ["svg_diagram", "text_diagram"]

_LONGEST_NAME = 32


def text_diagram(netlist: Netlist) -> str:
    """Return the block diagram as text.

    Parameters
    ----------
    netlist : Netlist

    Examples
    --------
    >>> from varishold.circuit import Hyperplane, Netlist, Score, Term
    >>> netlist = Netlist(
    ...     channels=("palm", "tip"),
    ...     comparators=(),
    ...     units=(Hyperplane([(0, 1)], 0), Hyperplane([(0, -1), (1, 2)], 1)),
    ...     terms=(Term([(0, 1), (1, 0)]),),
    ...     scores=(Score([], 1), Score([(0, 2)], 0)),
    ...     classes=("pillar", "cylinder"),
    ... )
    >>> print(text_diagram(netlist), end="")
             s1  s2
    palm   ──+1──-1
    tip    ───┼──+2
    sum >     0   1
              │   │
    t1     ───●───○── AND
    <BLANKLINE>
    cylinder where t1, otherwise pillar
    """
    used = sorted({bit for unit in netlist.units for bit, _ in unit.weights})
    names = [_printable(netlist.bit_names[bit]) for bit in used]
    terms = [f"t{t + 1}" for t in range(len(netlist.terms))]
    label = max(map(len, [*names, *terms, "sum >"]), default=0) + 2
    weights = [dict(unit.weights) for unit in netlist.units]
    cells = [[f"{row[bit]:+d}" if bit in row else "" for row in weights] for bit in used]
    heads = [f"s{k + 1}" for k in range(len(netlist.units))]
    biases = [str(unit.bias) for unit in netlist.units]
    width = max((len(text) for row in (*cells, heads, biases) for text in row), default=2) + 2

    lines = []
    if heads:
        lines.append(_row("", heads, label, width, fill=" "))
    for name, row in zip(names, cells, strict=True):
        lines.append(_row(name, row, label, width, fill="─"))
    if heads:
        lines.append(_row("sum >", biases, label, width, fill=" "))
        lines.append(_row("", ["│"] * len(heads), label, width, fill=" "))
    for name, term in zip(terms, netlist.terms, strict=True):
        taken = dict(term.literals)
        marks = [{1: "●", 0: "○"}[taken[k]] if k in taken else "┼" for k in range(len(heads))]
        gate = "AND" if len(taken) > 1 else "" if taken else "always"
        lines.append(_row(name, marks, label, width, fill="─") + f"── {gate}".rstrip())
    lines.extend(["", *_decision(netlist, terms)])
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _row(name: str, cells: Sequence[str], label: int, width: int, *, fill: str) -> str:
    # a wire without a contact crosses over
    return name.ljust(label) + "".join((cell or "┼").rjust(width, fill) for cell in cells)


def _decision(netlist: Netlist, terms: Sequence[str]) -> list[str]:
    """Return what the scores mean: a plain OR where they are one, the sums otherwise."""
    labels = [_printable(label) for label in netlist.classes]
    either = _or_class(netlist)
    if either is not None:
        own = [terms[t] for t, _ in netlist.scores[either].weights]
        return [f"{labels[either]} where {' OR '.join(own)}, otherwise {labels[1 - either]}"]
    lines = ["the largest score wins, the upper among equals:"]
    width = max(map(len, labels))
    for label, score in zip(labels, netlist.scores, strict=True):
        sum_ = " ".join(f"{weight:+d} {terms[t]}" for t, weight in score.weights)
        lines.append(f"  {label.ljust(width)} = {score.bias} {sum_}".rstrip())
    return lines


def _or_class(netlist: Netlist) -> int | None:
    """Return the class that wins exactly where one of its terms is true, if the scores say that."""
    if len(netlist.scores) != 2:
        return None
    for k in (0, 1):
        mine, other = netlist.scores[k], netlist.scores[1 - k]
        # equal scores go to class 0
        margin = other.bias - mine.bias + (1 if k else 0)
        alone = not other.weights and mine.weights and margin > 0
        if alone and all(weight >= margin for _, weight in mine.weights):
            return k
    return None


_ROW = 22
_COLUMNS = {"bits": 20, "wire": 190, "units": 380, "terms": 600, "classes": 760, "end": 900}


def svg_diagram(netlist: Netlist) -> str:
    """Return the block diagram as an SVG document.

    Positive weights are dark lines, negative ones red and dashed; a weight other than one is written on
    its line, an inverted input of a term has a ring.

    Parameters
    ----------
    netlist : Netlist
    """
    x = _COLUMNS
    used = sorted({bit for unit in netlist.units for bit, _ in unit.weights})
    rows = max(len(used), 2 * len(netlist.units), 2 * len(netlist.terms), 2 * len(netlist.classes), 1)
    height = (rows + 3) * _ROW
    y_bit = dict(zip(used, _spread(len(used), height), strict=True))
    y_unit = _spread(len(netlist.units), height)
    y_term = _spread(len(netlist.terms), height)
    y_class = _spread(len(netlist.classes), height)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {x["end"]} {height}" '
        f'width="{x["end"]}" height="{height}" font-family="sans-serif" font-size="12">',
        "<title>Block diagram of a grasp classifier</title>",
        f'<rect width="{x["end"]}" height="{height}" fill="white"/>',
    ]
    for name, at in (("switches", "bits"), ("hyperplanes", "units"), ("terms", "terms"), ("class", "classes")):
        out.append(f'<text x="{x[at]}" y="16" fill="#666">{name}</text>')
    for bit, y in y_bit.items():
        out.append(f'<text x="{x["bits"]}" y="{y + 4}">{_xml(netlist.bit_names[bit])}</text>')
    for unit, y in zip(netlist.units, y_unit, strict=True):
        for bit, weight in unit.weights:
            style = 'stroke="#c0392b" stroke-dasharray="5 3"' if weight < 0 else 'stroke="#2c3e50"'
            out.append(_line(x["wire"], y_bit[bit], x["units"], y, style))
            if abs(weight) != 1:
                x_text, y_text = (x["wire"] + 3 * x["units"]) // 4, (y_bit[bit] + 3 * y) // 4
                out.append(f'<text x="{x_text}" y="{y_text - 2}" font-size="10">{weight:+d}</text>')
    for t, (term, y) in enumerate(zip(netlist.terms, y_term, strict=True)):
        for place, (source, wanted) in enumerate(term.literals):
            y_pin = y - 8 + 16 * (place + 1) // (len(term.literals) + 1)
            out.append(_line(x["units"] + 90, y_unit[source], x["terms"], y_pin, 'stroke="#2c3e50"'))
            if not wanted:
                out.append(f'<circle cx="{x["terms"] - 4}" cy="{y_pin}" r="4" fill="white" stroke="#2c3e50"/>')
        for k, score in enumerate(netlist.scores):
            weight = dict(score.weights).get(t, 0)
            if weight:
                style = 'stroke="#c0392b" stroke-dasharray="5 3"' if weight < 0 else 'stroke="#2c3e50"'
                out.append(_line(x["terms"] + 50, y, x["classes"], y_class[k], style))
    either = _or_class(netlist)
    for k, (unit, y) in enumerate(zip(netlist.units, y_unit, strict=True)):
        out.append(_box(x["units"], y, 90, f"s{k + 1}: sum > {unit.bias}"))
    for term, y in zip(netlist.terms, y_term, strict=True):
        gate = "AND" if len(term.literals) > 1 else "1" if not term.literals else ""
        out.append(
            f'<path d="M{x["terms"]} {y - 10}h36a14 10 0 0 1 0 20h-36z" fill="#fdf6e3" stroke="#2c3e50"/>'
            f'<text x="{x["terms"] + 8}" y="{y + 4}">{gate}</text>'
        )
    for k, y in enumerate(y_class):
        head = "" if either is None else "OR: " if k == either else "else: "
        out.append(_box(x["classes"], y, 130, head + _printable(netlist.classes[k])))
    return "\n".join([*out, "</svg>"]) + "\n"


def _spread(n: int, height: int) -> list[int]:
    return [2 * _ROW + (2 * k + 1) * (height - 3 * _ROW) // (2 * n) for k in range(n)]


def _line(x1: int, y1: int, x2: int, y2: int, style: str) -> str:
    return f'<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}" {style}/>'


def _box(x: int, y: int, width: int, text: str) -> str:
    return (
        f'<rect x="{x}" y="{y - 10}" width="{width}" height="20" rx="3" fill="#eaf2f8" stroke="#2c3e50"/>'
        f'<text x="{x + 6}" y="{y + 4}">{escape(text)}</text>'
    )


def _printable(name: str) -> str:
    text = "".join(character if character.isprintable() else " " for character in name)
    return text if len(text) <= _LONGEST_NAME else text[: _LONGEST_NAME - 1] + "…"


def _xml(name: str) -> str:
    return escape(_printable(name))
