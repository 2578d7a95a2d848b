"""How far another session has drifted, from presses of it that nobody has labelled.

What is looked for is one shift of each measure that is common to all things: a hand that sits elsewhere, a load that
has changed, a sensor that has aged. Which press is of which thing is not known; every press counts for each thing as
far as it is believed to be of it, and both are found in turn (expectation maximization).

References
----------
A. Dempster, N. Laird and D. Rubin, "Maximum likelihood from incomplete data via the EM algorithm", 1977.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.learning.sources import Learned
from varishold.trust import conformal_p_value

__all__ = ["estimate_drift"]

Floats = NDArray[np.float64]

_STEPS = 8
# A shift counts as far as it stands out of so many of its standard errors.
_STANDS_OUT = 2.0
# With fewer presses that are believed, or fewer that are not of the commonest thing, drift is not told from what was
# pressed.
_LEAST_PRESSES, _LEAST_OTHERS = 5.0, 1.5
# Of what is known by its form at least this share must be like what is known in all measures, once they are shifted.
_LEAST_EXPLAINED = 0.25


def estimate_drift(
    learned: Learned, measures: Mapping[str, Floats], forms: Mapping[str, Floats], error: float
) -> dict[str, Floats]:
    """Return by how much each standardized measure has shifted, shape (n_measures,) for each source.

    Nothing has where a shift would make fewer presses like what is known than there are without it.

    Parameters
    ----------
    learned : Learned
    measures, forms : mapping of str to ndarray of shape (n, n_measures), float64
        Of unlabelled presses, and those of forms alone, where the model has learned these by themselves; NaN where
        unknown.
    error : float
        Presses whose conformal p-value is less count for less.

    Raises
    ------
    InputError
        If too few presses are like anything that is known, all are of one thing, or no common shift makes those like
        what is known whose forms are.
    """
    codes = learned.landmark_codes
    usual = {
        name: np.stack([source.landmarks[codes == k].mean(axis=0) for k in range(codes.max() + 1)])
        for name, source in learned.sources.items()
    }
    none = {name: np.zeros(of.shape[1]) for name, of in measures.items()}
    drift, scaled = none, replace(learned, drift=none).scaled(measures)
    said, believed = _judged(learned, scaled, error)
    # Of what was learned no more are like it.
    least = min(float(believed.sum()), (1 - error) * len(believed))
    by_forms = None if learned.forms is None else _judged(learned.forms, learned.forms.scaled(forms), error)
    said = said if by_forms is None else by_forms[0]
    for _ in range(_STEPS):
        shares = (believed if by_forms is None else by_forms[1])[:, None] * np.exp(said)
        _check_enough(shares)
        drift = {name: _shift(of, usual[name], shares, drift[name]) for name, of in scaled.items()}
        scaled = replace(learned, drift=drift).scaled(measures)
        said, believed = _judged(learned, scaled, error)
    if by_forms is not None:
        _check_explained(by_forms[1], believed)
    # What makes fewer presses like what is known has led from one thing to the next.
    return drift if believed.sum() >= least else none


def _judged(learned: Learned, scaled: Mapping[str, Floats], error: float) -> tuple[Floats, Floats]:
    """Return log-probabilities, and how far each press counts: the less, the stranger it is."""
    said, strange = learned.judge(scaled)
    return said, np.minimum(conformal_p_value(strange, learned.known) / error, 1.0) ** 2


def _shift(scaled: Floats, usual: Floats, shares: Floats, so_far: Floats) -> Floats:
    """Return the shift so far and what is left of it, drawn towards none as far as chance may have made it."""
    speaks = ~np.isnan(scaled).any(axis=1)
    scaled, shares = scaled[speaks], shares[speaks]
    whole = shares.sum()
    if whole < _LEAST_PRESSES:
        return np.zeros(scaled.shape[1])
    left = (shares.sum(axis=1) @ scaled - shares.sum(axis=0) @ usual) / whole
    off = scaled[:, None] - usual - left
    variance = np.einsum("nk,nkm->m", shares, off * off) / whole
    shift = so_far + left
    by_chance = _STANDS_OUT**2 * variance / whole
    return np.asarray(shift * np.maximum(1.0 - by_chance / np.maximum(shift * shift, 1e-300), 0.0))


def _check_enough(shares: Floats) -> None:
    each = shares.sum(axis=0)
    whole = float(each.sum())
    if whole < _LEAST_PRESSES:
        raise InputError(
            f"only {math.floor(10 * whole) / 10:.1f} of {len(shares)} new presses are like what is known, "
            f"{_LEAST_PRESSES:g} are needed to tell how things have drifted; give more, or learn again"
        )
    others = whole - float(each.max())
    if others < _LEAST_OTHERS:
        but = f" but for {others:.1f} of {whole:.1f}" if others >= 0.05 else ""
        raise InputError(
            f"the new presses are all of one thing{but}: what has drifted is not told from how it was pressed; "
            "give two presses or more of another thing too"
        )


def _check_explained(by_forms: Floats, by_all: Floats) -> None:
    explained, known = float((by_forms * by_all).sum()), float(by_forms.sum())
    if explained < _LEAST_EXPLAINED * known:
        raise InputError(
            f"{known:.1f} of {len(by_forms)} new presses have forms that are known, but no drift common to all makes "
            f"more than {explained:.1f} of them like what is known; give presses of known things, or learn again"
        )
