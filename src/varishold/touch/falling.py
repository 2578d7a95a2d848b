"""Recognition while the threshold falls: an answer at every sampling instant, refined as sections arrive."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from varishold.errors import InputError
from varishold.frame.checks import as_numbers, is_masked_array
from varishold.levelset.contacts import find_contacts
from varishold.touch.recognizer import recognize
from varishold.touch.surface import Surface

__all__ = ["recognize_falling"]

# A section of fewer taxels has no form yet.
_FEWEST_TAXELS = 4


def recognize_falling(
    frames: Iterable[ArrayLike],
    thresholds: ArrayLike,
    *,
    pitch_m: float | tuple[float, float] | None = None,
    valid: ArrayLike | None = None,
    field: ArrayLike | None = None,
) -> Iterator[Surface | None]:
    """Say at every instant what the largest contact is, from what has come out above the threshold so far.

    The threshold falls by one step a sampling instant. At instant i only what stands above theta_i has been
    felt; the answer weighs it by a table learned from frames whose threshold had fallen part of its way,
    and is as unsure as that leaves it ("recognized by the state of touch sensation in case of subscript
    i = 1").

    Parameters
    ----------
    frames : iterable of array_like of shape (rows, cols)
        What the array says at each instant; a held contact gives the same frame again and again.
    thresholds : array_like of shape (n,)
        theta_1 ... theta_n, falling, in the frames' unit; see `varishold.levelset` for schedules.
    pitch_m, valid, field
        As `pitch`, `valid` and `field` of `find_contacts`.

    Yields
    ------
    Surface or None
        One an instant, as long as both last; None while fewer than four taxels are above the threshold.

    Raises
    ------
    InputError
        If the thresholds do not fall.

    References
    ----------
    Kinoshita, Aida and Mori 1971, section 2 and eq. [13].

    Examples
    --------
    >>> from varishold.levelset import even
    >>> from varishold.solids import Cylinder, ideal_frame
    >>> held = ideal_frame(Cylinder(14.0, 3.0), (32, 32), 1.0)
    >>> answers = list(recognize_falling([held] * 8, even(3.0, 0.1, 8)))
    >>> answers[-1].name
    'cylinder'
    """
    theta = np.asarray(thresholds, dtype=np.float64)
    if theta.ndim != 1 or theta.size == 0 or not np.isfinite(theta).all() or np.any(np.diff(theta) >= 0):
        raise InputError(f"thresholds must be finite and fall, got shape {theta.shape}: {theta}")
    for frame, level in zip(frames, theta.tolist(), strict=False):
        floor = max(level, 0.0)
        # What stands below the threshold has not been felt.
        numbers = as_numbers(frame, 2, "a frame", masked=True)
        felt = np.ma.maximum(frame, floor) if is_masked_array(frame) else np.maximum(numbers, floor)
        contacts = find_contacts(felt, pitch=pitch_m, valid=valid, field=field, floor=floor)
        if contacts and contacts[0].n_taxels >= _FEWEST_TAXELS:
            yield recognize(contacts[0], early=True)
        else:
            yield None
