"""What every mode takes and returns, and how chosen hyperplanes become a netlist."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from varishold.circuit import Hyperplane, Netlist, Score, Term
from varishold.grasp.hyperplanes import Hyperplanes
from varishold.grasp.separating import Selection
from varishold.grasp.training import TrainingGrasps

__all__ = [
    "Learned",
    "ModeOptions",
    "circuit_of",
    "class_names",
    "constant_circuit",
    "learn_constant",
    "term_scores",
    "units_of",
]

Literals = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class ModeOptions:
    """Options that modes share; each mode reads those that concern it.

    Parameters
    ----------
    keep : Hyperplanes or None
        Hyperplanes that stay whatever is learned: those of an earlier fit, when a class is added.
    max_hyperplanes : int or None
        Most hyperplanes to use; None leaves it to the mode.
    flip_rate : float
        How often a switch is expected to read wrongly (`robust`).
    time_limit_s : float
        Seconds for the integer program (`paper`).
    seed : int
        Of everything that is drawn at random.
    decoder : str or None
        Decoder to take (`vote`); None chooses by cross-validation.
    groups : tuple of int
        For every pattern, the grasp that it is a copy of: folds of a cross-validation keep copies together.
        Empty: every pattern is its own.
    """

    keep: Hyperplanes | None = None
    max_hyperplanes: int | None = None
    flip_rate: float = 0.15
    time_limit_s: float = 10.0
    seed: int = 0
    decoder: str | None = None
    groups: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Learned:
    """What a mode learned: hyperplanes, the circuit over them, and how it came about.

    Parameters
    ----------
    hyperplanes : Hyperplanes
        Unit k of the netlist is hyperplane k.
    netlist : Netlist
        Over the switches; class k is class k of the training grasps.
    selection : Selection or None
        What is proved about the number of hyperplanes, where a mode proves anything.
    notes : mapping of str to str
        What the mode chose, in words.
    """

    hyperplanes: Hyperplanes
    netlist: Netlist
    selection: Selection | None = None
    notes: Mapping[str, str] = field(default_factory=dict)


def units_of(hyperplanes: Hyperplanes) -> tuple[Hyperplane, ...]:
    """Return every hyperplane as a unit of a netlist."""
    units = []
    for row, bias, (first, second) in zip(
        hyperplanes.weights, hyperplanes.biases.tolist(), hyperplanes.pairs.tolist(), strict=True
    ):
        at = np.flatnonzero(row)
        weights = zip(at.tolist(), row[at].tolist(), strict=True)
        units.append(Hyperplane(weights, bias, (first, second) if first >= 0 else None))
    return tuple(units)


def circuit_of(
    grasps: TrainingGrasps, hyperplanes: Hyperplanes, terms: Sequence[Literals], scores: Sequence[Score]
) -> Netlist:
    """Assemble a netlist over the switches x1 ... xr."""
    return Netlist(
        channels=tuple(f"x{k + 1}" for k in range(grasps.n_switches)),
        comparators=(),
        units=units_of(hyperplanes),
        terms=tuple(Term(term) for term in terms),
        scores=tuple(scores),
        classes=tuple(class_names(grasps.classes)),
    )


def class_names(labels: Sequence[Hashable]) -> list[str]:
    """Class labels as text, all different, as a netlist wants them."""
    names: list[str] = []
    for label in labels:
        name = str(label) or "(empty)"
        while name in names:
            name += "'"
        names.append(name)
    return names


def constant_circuit(grasps: TrainingGrasps, hyperplanes: Hyperplanes) -> Netlist:
    """Answer the class with most grasps, whatever is felt: all that contradictory grasps allow."""
    counts = np.bincount(grasps.labels, weights=grasps.weights, minlength=grasps.n_classes)
    best = int(counts.argmax())
    scores = [Score([], int(k == best)) for k in range(grasps.n_classes)]
    return circuit_of(grasps, hyperplanes, [], scores)


def learn_constant(grasps: TrainingGrasps, options: ModeOptions) -> Learned:
    """Learn no hyperplane but those that are kept: contradictory grasps leave one class, or none."""
    planes = options.keep or Hyperplanes(np.zeros((0, grasps.n_switches), dtype=np.int8))
    return Learned(planes, constant_circuit(grasps, planes))


def term_scores(
    grasps: TrainingGrasps, terms_of: Mapping[int, Sequence[Literals]]
) -> tuple[list[Literals], list[Score]]:
    """Scores of an OR of terms a class: two points a true term; the remaining or largest class starts with one."""
    counts = np.bincount(grasps.labels, weights=grasps.weights, minlength=grasps.n_classes)
    without = [k for k in range(grasps.n_classes) if k not in terms_of and counts[k] > 0]
    default = without[0] if without else int(counts.argmax())
    terms: list[Literals] = []
    scores = []
    for k in range(grasps.n_classes):
        own = list(terms_of.get(k, ()))
        scores.append(Score([(len(terms) + t, 2) for t in range(len(own))], 1 if k == default else 0))
        terms += own
    return terms, scores
