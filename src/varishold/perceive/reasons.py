"""Why: which part of a touch's evidence speaks for the likeliest object against the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.perceive.belief import Belief
from varishold.perceive.evidence import Evidence
from varishold.perceive.likelihood import log_mean
from varishold.perceive.touch_model import TouchModel

__all__ = ["GROUPS", "reasons_of"]

#: Groups of numbers by the beginning of their names, and what they are called.
GROUPS = {
    "fit.": "how sections fit the grip",
    "switch.": "the switches",
    "pad.": "the surfaces under the pads",
    "form.": "round or angular on the whole",
    "tip.": "the fingertip's height",
}

# Examples of each of the two objects that are asked.
_ASKED = 80

# Log-odds below this say nothing.
_LEAST = 0.3


def reasons_of(evidence: Evidence, after: Belief) -> tuple[str, ...]:
    """Return in words what each part of a touch says of the two likeliest objects.

    A part's say is what the log-odds of the two lose when its numbers are unknown.

    Parameters
    ----------
    evidence : Evidence
    after : Belief
        The belief that the touch has led to.
    """
    library = after.library
    names = list(after.probability)
    model = library.touches[evidence.touch]
    values = evidence.vector(model.metric.names)
    if len(names) < 2 or not np.isfinite(values).any():
        return ()
    first, second = names[:2]
    groups = {
        what: np.array([name.startswith(start) for name in model.metric.names]) & np.isfinite(values)
        for start, what in GROUPS.items()
    }
    groups = {what: mask for what, mask in groups.items() if mask.any()}
    rest = np.isfinite(values) & ~np.any([*groups.values(), np.zeros(len(values), bool)], axis=0)
    if rest.any():
        groups["its other numbers"] = rest
    rows = [
        order[:_ASKED]
        for name in (first, second)
        for of in [np.flatnonzero((library.owner == library.objects.index(name)) & model.made)]
        for order in [of[np.argsort(-after.log_weight[of], kind="stable")]]
    ]
    if not (rows[0].size and rows[1].size):
        return ()
    whole = _log_odds(model, values, rows)
    out = []
    for what, mask in groups.items():
        said = whole - _log_odds(model, np.where(mask, np.nan, values), rows)
        if abs(said) >= _LEAST:
            speaks, against = (first, second) if said > 0 else (second, first)
            out.append((abs(said), f"{what}: for {speaks} against {against} by a factor of {_factor(abs(said))}"))
    return tuple(text for _, text in sorted(out, reverse=True))


def _log_odds(model: TouchModel, values: NDArray[np.float64], rows: list[NDArray[np.int64]]) -> float:
    first, second = (log_mean(model.log_kernel(values, rows=index)) for index in rows)
    return float(first - second)


def _factor(log_odds: float) -> str:
    if log_odds < 4:
        return f"{np.exp(log_odds):.1f}"
    return f"{np.exp(min(log_odds, 30)):.0e}" if log_odds > 9 else f"{np.exp(log_odds):.0f}"
