"""How far another session has drifted, from presses of it that nobody has labelled.

What is looked for is one shift of each measure that is common to all things: a hand that sits elsewhere, a load that
has changed, a sensor that has aged. Which press is of which thing is not known; every press counts for each thing as
far as it is believed to be of it, and both are found in turn (expectation maximization).

References
----------
A. Dempster, N. Laird and D. Rubin, "Maximum likelihood from incomplete data via the EM algorithm", 1977.
"""

from __future__ import annotations

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
# With fewer presses that are believed, or fewer things among them, drift is not told from what was pressed.
_LEAST_PRESSES, _LEAST_THINGS = 5.0, 2.0


def estimate_drift(learned: Learned, measures: Mapping[str, Floats], error: float) -> dict[str, Floats]:
    """Return by how much each standardized measure has shifted, shape (n_measures,) for each source.

    Parameters
    ----------
    learned : Learned
    measures : mapping of str to ndarray of shape (n, n_measures), float64
        Of unlabelled presses; NaN where unknown.
    error : float
        Presses whose conformal p-value is less count for less.

    Raises
    ------
    InputError
        If too few presses are like anything that is known, or all are of one thing.
    """
    codes = learned.landmark_codes
    usual = {
        name: np.stack([source.landmarks[codes == k].mean(axis=0) for k in range(codes.max() + 1)])
        for name, source in learned.sources.items()
    }
    drift = {name: np.zeros(of.shape[1]) for name, of in measures.items()}
    for _ in range(_STEPS):
        scaled = replace(learned, drift=drift).scaled(measures)
        said, strange = learned.judge(scaled)
        believed = np.minimum(conformal_p_value(strange, learned.known) / error, 1.0) ** 2
        shares = believed[:, None] * np.exp(said)
        _check_enough(shares)
        drift = {name: _shift(of, usual[name], shares, drift[name]) for name, of in scaled.items()}
    return drift


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
            f"only {whole:.1f} of {len(shares)} new presses are like what is known, {_LEAST_PRESSES:g} are needed to "
            "tell how things have drifted; give more, or learn again"
        )
    part = each[each > 0] / whole
    if float(np.exp(-(part * np.log(part)).sum())) < _LEAST_THINGS:
        raise InputError(
            "the new presses are all of one thing: what has drifted is not told from how it was pressed; "
            "give presses of several things"
        )
