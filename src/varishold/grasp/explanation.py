"""Why a grasp is answered as it is: hyperplanes, switches, the nearest training grasp, and what it bears."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.grasp.certificate import certify, unit_flips
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.hyperplanes import Hyperplanes

__all__ = ["Explanation", "HyperplaneReason", "explain_pattern"]

#: Hyperplanes that an explanation names; of many that vote, those with most weight in the answer.
_NAMED = 8


@dataclass(frozen=True)
class HyperplaneReason:
    """What one hyperplane says of a grasp.

    Parameters
    ----------
    name : str
        As in the tables.
    sign : int
        s of eqs. [24]-[25].
    pair : (int, int) or None
        Numbers of the training grasps between which it lies, the one on the positive side first.
    agreeing, opposing : tuple of int
        Numbers (from one) of the switches that vote for the sign, and of those that vote against it.
    flips : int or None
        Wrong switches that would turn it over; None where nothing does.
    """

    name: str
    sign: int
    pair: tuple[int, int] | None
    agreeing: tuple[int, ...]
    opposing: tuple[int, ...]
    flips: int | None

    def __str__(self) -> str:
        return self.told()

    def told(self, names: Sequence[str] | None = None) -> str:
        """Return it in a line, with the switches' own names where they are given."""
        between = f" between v{self.pair[0]} and v{self.pair[1]}" if self.pair else ""
        against = f", against it {_switches(self.opposing, names)}" if self.opposing else ""
        return f"s_{self.name} = {self.sign}{between}: for it {_switches(self.agreeing, names)}{against}"


@dataclass(frozen=True)
class Explanation:
    """The reasons of one answer.

    Parameters
    ----------
    label : object
        The answer.
    hyperplanes : tuple of HyperplaneReason
        Those that decided: of the true product terms, or with most weight in the vote.
    nearest : (int, object, int) or None
        Number and class of the nearest training grasp, and how many switches differ from it.
    certified_flips : int
        Whatever that many switches read wrongly, the answer stays: proved.
    exact : bool
        One more wrong switch can change the answer.
    flips : tuple of int
        Numbers (from one) of switches that change it together; empty where none were found.
    other : object or None
        What it changes to.
    """

    label: Any
    hyperplanes: tuple[HyperplaneReason, ...]
    nearest: tuple[int, Any, int] | None
    certified_flips: int
    exact: bool
    flips: tuple[int, ...]
    other: Any

    def __str__(self) -> str:
        return "\n".join([str(self.label), *(f"  {line}" for line in self.reasons())])

    def reasons(self, names: Sequence[str] | None = None) -> list[str]:
        """Return the reasons, a line each, with the switches' own names where they are given."""
        lines = [reason.told(names) for reason in self.hyperplanes]
        if self.nearest is not None:
            number, label, distance = self.nearest
            differ = counted(distance, "switch differs", "switches differ")
            lines.append(f"nearest training grasp: v{number} ({label}), {differ}")
        n = self.certified_flips
        bears = f"any {counted(n, 'wrong switch')}" if n else "no wrong switch for certain"
        if self.flips:
            wrong = _switches(self.flips, names)
            lines.append(f"the answer bears {bears}; {wrong} read wrongly would make it {self.other}")
        else:
            lines.append(f"the answer bears {bears}" + ("" if self.exact else ", perhaps more"))
        return lines


def explain_pattern(
    circuit: CompiledCircuit,
    hyperplanes: Hyperplanes,
    pattern: NDArray[np.bool_],
    *,
    labels: Sequence[Any],
    nearest: tuple[int, Any, int] | None,
) -> Explanation:
    """Explain the circuit's answer to one pattern, shape (n_switches,)."""
    answer = int(circuit.evaluate(pattern[None])[0])
    certificate = certify(circuit, pattern)
    flips = unit_flips(circuit, pattern)
    fired = circuit.excess(pattern[None])[0] > 0
    reasons = [
        _reason(hyperplanes, k, pattern, bool(fired[k]), float(flips[k]))
        for k in _deciding(circuit, fired, answer)[:_NAMED]
    ]
    return Explanation(
        label=labels[answer],
        hyperplanes=tuple(reasons),
        nearest=nearest,
        certified_flips=certificate.flips,
        exact=certificate.exact,
        flips=tuple(k + 1 for k in certificate.counterexample),
        other=None if certificate.other is None else labels[certificate.other],
    )


def _deciding(circuit: CompiledCircuit, fired: NDArray[np.bool_], answer: int) -> list[int]:
    """Units by how much their terms speak for the answer against its nearest rival."""
    true = circuit.true_terms(fired[None])[0]
    scores = true @ circuit.score_weights + circuit.score_bias
    rivals = np.delete(np.arange(len(scores)), answer)
    rival = int(rivals[scores[rivals].argmax()])
    lead = circuit.score_weights[:, answer] - circuit.score_weights[:, rival]
    used = circuit.literals != 0
    violated = used & ((circuit.literals > 0) != fired[:, None])
    # A true term speaks through all its literals, a false one of the rival through those that fail.
    for_it = used @ np.where(true, lead, 0.0).clip(min=0) + violated @ np.where(true, 0.0, -lead).clip(min=0)
    order = np.argsort(-for_it, kind="stable")
    return [int(k) for k in order if for_it[k] > 0]


def _reason(
    hyperplanes: Hyperplanes, k: int, pattern: NDArray[np.bool_], fires: bool, flips: float
) -> HyperplaneReason:
    row = hyperplanes.weights[k]
    first, second = (int(v) for v in hyperplanes.pairs[k])
    vote = row * np.where(pattern, 1, -1) * (1 if fires else -1)
    return HyperplaneReason(
        name=hyperplanes.names[k],
        sign=int(fires),
        pair=(first, second) if first > 0 else None,
        agreeing=tuple(int(s) + 1 for s in np.flatnonzero(vote > 0)),
        opposing=tuple(int(s) + 1 for s in np.flatnonzero(vote < 0)),
        flips=int(flips) if np.isfinite(flips) else None,
    )


def _switches(numbers: Sequence[int], names: Sequence[str] | None = None) -> str:
    return " ".join(f"x{n}" if names is None else names[n - 1] for n in numbers) or "none"
