"""The conformal p-value: how rare it is that something known is as strange, and what that does to an answer."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError

__all__ = [
    "conformal_p_value",
    "known_share",
    "least_error",
    "merged_p_value",
    "strange_share",
    "weighed_p_value",
    "widened",
]

Floats = NDArray[np.float64]

#: Of the answer to what is refused, at most this share is believed; the rest is shared out evenly. With two classes no
#: probability is above .9 then, with more it is below.
_MOST_BELIEVED = 0.8


def conformal_p_value(strangeness: ArrayLike, known: ArrayLike) -> NDArray[np.float64]:
    """Return how rare it is that something known is as strange.

    Parameters
    ----------
    strangeness : array_like of shape (n,)
        Of what is to be judged; larger is stranger.
    known : array_like of shape (n_known,)
        Of known things that were held out when the measure was learned.

    Returns
    -------
    ndarray of shape (n,), float64
        (1 + how many of `known` are at least as strange) / (1 + n_known). Of things exchangeable with the known ones it
        is at most e in a share of at most e, whatever the measure.

    Raises
    ------
    InputError
        If `known` is empty.

    References
    ----------
    V. Vovk, A. Gammerman and G. Shafer, "Algorithmic Learning in a Random World", 2005, chapter 2.

    Examples
    --------
    >>> conformal_p_value([0.5, 9.0], [1.0, 2.0, 3.0]).tolist()
    [1.0, 0.25]
    """
    held = np.sort(np.asarray(known, dtype=np.float64))
    if held.ndim != 1 or not held.size:
        raise InputError(f"known must be one number for each of at least one known thing, got shape {held.shape}")
    below = np.searchsorted(held, np.asarray(strangeness, dtype=np.float64), side="left")
    return np.asarray((1 + held.size - below) / (1 + held.size))


def merged_p_value(p_values: ArrayLike) -> float:
    """Return one p-value of several looks at the same thing, however they hang together: twice their mean; 1 of none.

    References
    ----------
    V. Vovk and R. Wang, "Combining p-values via averaging", Biometrika 107 (2020) 791-808, theorem 1 with r = 1.

    Examples
    --------
    >>> merged_p_value([0.03]), merged_p_value([0.01, 0.03]), merged_p_value([0.9, 0.4])
    (0.03, 0.04, 1.0)
    """
    p = np.asarray(p_values, dtype=np.float64)
    return min(1.0, float(p.mean()) * (1 if p.size == 1 else 2)) if p.size else 1.0


def weighed_p_value(p_value: float, other: float, weight: float) -> float:
    """Return one p-value of two that do not hang together, of which the other counts so much less.

    Parameters
    ----------
    p_value, other : float
        From above 0 to 1.
    weight : float
        The power of the other, above 0 and below 1.

    Returns
    -------
    float
        How rare it is that ``p_value * other**weight`` is as small.

    References
    ----------
    I. J. Good, "On the weighted combination of significance tests", J. R. Stat. Soc. B 17 (1955) 264-265.

    Examples
    --------
    >>> round(weighed_p_value(0.01, 0.5, 0.5), 4), round(weighed_p_value(0.01, 0.01, 0.5), 4)
    (0.0141, 0.002)
    """
    product: float = p_value * other**weight
    # Below this every other one makes the product as small, whatever it is weighed with.
    enough: float = product ** (1 / weight)
    return (product - weight * enough) / (1 - weight)


def least_error(error: float, n_known: int) -> float:
    """Return the error at which something can be refused: as stated, or where that takes more known things, the least.

    What is stranger than all known things is always refused.

    Examples
    --------
    >>> least_error(0.05, 99), least_error(0.05, 9)
    (0.05, 0.1)
    """
    return max(error, 1.0 / (1 + max(n_known, 1)))


def known_share(p_value: float, power: float, significance: float, strangers: float) -> float:
    """Return the probability that a thing is known at all, where a share of all things is not.

    P-values of known things are even. Those of strange ones are taken to have the density ``a * p**(a - 1)``, of which
    a share of `power` lies below `significance`.

    Parameters
    ----------
    p_value : float
        How rare it is that something known is as strange, above 0 and at most 1.
    power : float
        The share of strange things, of those that are most like what the thing is taken for, that have a p-value of
        at most `significance`. What is no more than `significance` tells nothing.
    significance : float
        Above 0 and below 1.
    strangers : float
        How many of all things are strange, a share of at least 0 and below 1.

    References
    ----------
    T. Sellke, M. J. Bayarri and J. O. Berger, "Calibration of p values for testing precise null hypotheses", The
    American Statistician 55 (2001) 62-71, section 3: these densities.

    Examples
    --------
    >>> [round(known_share(p, 0.9, 0.02, 0.1), 3) for p in (0.01, 0.1, 1.0)]
    [0.791, 0.973, 0.997]
    >>> [round(known_share(p, 0.02, 0.02, 0.1), 3) for p in (0.01, 1.0)]
    [0.9, 0.9]
    """
    a = math.log(max(power, significance)) / math.log(significance)
    odds = strangers / (1 - strangers) * a * p_value ** (a - 1)
    return float(1 / (1 + odds))


def strange_share(p_value: float, strangers: float) -> float:
    """Return the probability that a thing is strange where it is as odd as it is, were every strange one as odd.

    Of known things a share of `p_value` is as odd too. How many of them are felt beside the strange ones decides what a
    p-value is worth: less one, it is no probability of a stranger.

    Parameters
    ----------
    p_value : float
        How rare it is that something known is as strange, above 0 and at most 1.
    strangers : float
        How many of all things are strange, a share of at least 0 and below 1.

    Examples
    --------
    >>> [round(strange_share(p, 0.1), 3) for p in (0.003, 0.008, 1 / 11, 1.0)]
    [0.974, 0.933, 0.55, 0.1]
    """
    return strangers / (strangers + (1 - strangers) * p_value)


def widened(probabilities: ArrayLike, p_values: ArrayLike, error: float) -> Floats:
    """Return probabilities that promise nothing of what is like nothing learned.

    Parameters
    ----------
    probabilities : array_like of shape (n, n_classes)
        As if each thing were one of the classes; they sum to 1.
    p_values : array_like of shape (n,)
        How rare it is that something known is as strange.
    error : float
        What has a p-value of at most this is outside of what was learned.

    Returns
    -------
    ndarray of shape (n, n_classes), float64
        As given where the p-value is above `error`. Else drawn towards an even share, the farther the smaller the
        p-value: in the same order, and none above .9. A single class keeps that much, and the rest is nobody's.

    Examples
    --------
    >>> widened([[0.99, 0.01]] * 3, [0.5, 0.05, 0.01], 0.05).round(3).tolist()
    [[0.99, 0.01], [0.892, 0.108], [0.516, 0.484]]
    """
    plain, p = np.asarray(probabilities, dtype=np.float64), np.asarray(p_values, dtype=np.float64)[:, None]
    believed = _MOST_BELIEVED * (p / error) ** 2
    even = 1.0 / max(plain.shape[1], 2)
    return np.where(p > error, plain, believed * plain + (1 - believed) * even)
