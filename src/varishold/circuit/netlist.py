"""The netlist: hyperplanes, product terms and class scores, all in integers.

A signal passes five layers::

    channels -> comparators -> bits -> units -> terms -> scores -> class
                (if any)              w.x > b   AND      largest wins

Every number is an integer and every sum fits 32 signed bits, so that numpy, C and Verilog agree on
every input. Where a choice has to be made it is made here once: a unit whose sum equals its bias does
not fire, and of equal scores the class with the lowest index wins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from varishold.circuit.document import FORMAT, VERSION, netlist_layers
from varishold.circuit.elements import Comparator, Hyperplane, Score, Term, shown
from varishold.errors import FormatError, InputError

__all__ = ["Netlist"]

# Names go into generated source and onto diagrams; a name longer than this is a mistake or an attack.
MAX_NAME_LENGTH: Final = 256


@dataclass(frozen=True, slots=True)
class Netlist:
    """A classifier of switch patterns (or of counts cut by comparators) as a circuit of integers.

    Parameters
    ----------
    channels : tuple of str
        Names of the inputs, all different.
    comparators : tuple of Comparator
        The bits, one each. Empty: the channels are switches, and bit k is channel k.
    units : tuple of Hyperplane
        Over the bits.
    terms : tuple of Term
        Over the units.
    scores : tuple of Score
        Over the terms, one a class. The largest wins, the lowest index among equals.
    classes : tuple of str
        Labels, all different.

    Raises
    ------
    InputError
        Where an index points outside its layer, a name repeats, or a sum could pass 32 signed bits.

    Examples
    --------
    A cylinder is felt where the first switch is on and the second is off:

    >>> netlist = Netlist(
    ...     channels=("palm", "tip"),
    ...     comparators=(),
    ...     units=(Hyperplane([(0, 1)], 0), Hyperplane([(1, 1)], 0)),
    ...     terms=(Term([(0, 1), (1, 0)]),),
    ...     scores=(Score([], 1), Score([(0, 2)], 0)),
    ...     classes=("pillar", "cylinder"),
    ... )
    >>> netlist.bit_names
    ('palm', 'tip')
    """

    channels: tuple[str, ...]
    comparators: tuple[Comparator, ...]
    units: tuple[Hyperplane, ...]
    terms: tuple[Term, ...]
    scores: tuple[Score, ...]
    classes: tuple[str, ...]

    def __post_init__(self) -> None:
        for field, kind in (
            ("channels", str),
            ("comparators", Comparator),
            ("units", Hyperplane),
            ("terms", Term),
            ("scores", Score),
            ("classes", str),
        ):
            layer = tuple(getattr(self, field))
            for k, item in enumerate(layer):
                if not isinstance(item, kind):
                    raise InputError(f"{field}[{k}] must be of type {kind.__name__}, got {type(item).__name__}")
            object.__setattr__(self, field, layer)
        _check_names(self.channels, "channels")
        _check_names(self.classes, "classes")
        if len(self.scores) != len(self.classes):
            raise InputError(
                f"scores must hold one score a class, got {len(self.scores)} scores and {len(self.classes)} classes"
            )
        for k, comparator in enumerate(self.comparators):
            if not 0 <= comparator.channel < len(self.channels):
                raise InputError(
                    f"comparators[{k}] reads channel {comparator.channel}, but there are {len(self.channels)} channels"
                )
        _check_indices([unit.weights for unit in self.units], self.bit_count, layer="units", below="bit", plural="bits")
        _check_indices(
            [term.literals for term in self.terms],
            len(self.units),
            layer="terms",
            below="unit",
            plural="units",
        )
        _check_indices(
            [score.weights for score in self.scores],
            len(self.terms),
            layer="scores",
            below="term",
            plural="terms",
        )

    @property
    def bit_count(self) -> int:
        """Number of bits that the units see."""
        return len(self.comparators) or len(self.channels)

    @property
    def bit_names(self) -> tuple[str, ...]:
        """A readable name of every bit: a switch's name, or ``channel >= threshold``."""
        if not self.comparators:
            return self.channels
        return tuple(f"{self.channels[c.channel]} >= {c.threshold}" for c in self.comparators)

    def to_dict(self) -> dict[str, Any]:
        """Return the netlist as JSON-ready lists and integers; `from_dict` reads it back."""
        units: list[dict[str, Any]] = []
        for unit in self.units:
            entry: dict[str, Any] = {"weights": [list(pair) for pair in unit.weights], "bias": unit.bias}
            if unit.pair is not None:
                entry["pair"] = list(unit.pair)
            units.append(entry)
        return {
            "format": FORMAT,
            "version": VERSION,
            "channels": list(self.channels),
            "comparators": [[c.channel, c.threshold] for c in self.comparators],
            "units": units,
            "terms": [[list(literal) for literal in term.literals] for term in self.terms],
            "scores": [
                {"weights": [list(pair) for pair in score.weights], "bias": score.bias} for score in self.scores
            ],
            "classes": list(self.classes),
        }

    @classmethod
    def from_dict(cls, document: object, *, where: str = "netlist") -> Netlist:
        """Build a netlist from what `to_dict` returned, trusting nothing.

        Parameters
        ----------
        document : object
            A parsed JSON document, or anything at all.
        where : str
            Opens every error message: a file's name, or a place in a larger document.

        Raises
        ------
        FormatError
            Naming `where` and the place in the document.
        """
        layers = netlist_layers(document, where=where)
        try:
            return cls(**layers)
        except InputError as error:
            raise FormatError(f"{where}: {error}") from None

    def diagram(self) -> str:
        """Return the block diagram as text: switches, hyperplanes, terms, classes."""
        from varishold.circuit.diagram import text_diagram

        return text_diagram(self)

    def diagram_svg(self) -> str:
        """Return the block diagram as an SVG document."""
        from varishold.circuit.diagram import svg_diagram

        return svg_diagram(self)


def _check_names(names: tuple[str, ...], field: str) -> None:
    if not names:
        raise InputError(f"{field} must not be empty")
    seen: dict[str, int] = {}
    for k, name in enumerate(names):
        if not name or len(name) > MAX_NAME_LENGTH:
            raise InputError(f"{field}[{k}] must be a name of 1 to {MAX_NAME_LENGTH} characters, got {len(name)}")
        try:
            name.encode()
        except UnicodeEncodeError:
            raise InputError(f"{field}[{k}] must be valid Unicode, got {shown(name)}") from None
        if name in seen:
            raise InputError(f"{field} must all differ, got {shown(name)} at {seen[name]} and {k}")
        seen[name] = k


def _check_indices(
    rows: Sequence[tuple[tuple[int, int], ...]], size: int, *, layer: str, below: str, plural: str
) -> None:
    for k, row in enumerate(rows):
        if row and row[-1][0] >= size:
            raise InputError(f"{layer}[{k}] reads {below} {row[-1][0]}, but there are {size} {plural}")
