"""What a user's own presses taught about the contacts of one pad, in the form that a controller evaluates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold._name import NONE_OF_THESE
from varishold.errors import InputError
from varishold.touch.network import Decision
from varishold.touch.scale import MOST_SIDE, as_learned
from varishold.touch.sensing import find_contacts
from varishold.touch.signature import SIGNATURE_NAMES, contact_signature

__all__ = ["CLIP", "NONE_OF_THESE", "ContactNetwork", "check_sides", "frame_signature"]

Floats = NDArray[np.float64]

#: A whitened input counts no further than so much.
CLIP = 4.0
#: Thresholds a contact.
LEVELS = 32
_FEWEST_SIDE = 4
# Squares of less than this, and sums of them, are numbers of single precision.
_MOST = 1e15
# Log-odds of a stranger where it is none, and the scale of its distance: what is farther by a thousandth is one.
_NO_STRANGER, _FARTHEST = -1e6, 1e10
# No limit of distance is less.
_NEAREST = 1e-12


def check_sides(shape: tuple[int, int]) -> None:
    """Check that a controller can hold a pad of so many rows and columns.

    Raises
    ------
    InputError
        If it is too small to tell forms, or larger than contacts are looked at on their own scale.
    """
    if not all(_FEWEST_SIDE <= side <= MOST_SIDE for side in shape):
        raise InputError(
            f"a controller's pad has {_FEWEST_SIDE} to {MOST_SIDE} rows and columns, got {shape[0]}x{shape[1]}",
            parameter="shape",
        )


def frame_signature(frame: Floats, field: NDArray[np.bool_]) -> Floats:
    """Return the signature of a frame's largest contact, shape (n_inputs,); NaN where nothing touches.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Zero at rest.
    field : ndarray of shape (rows, cols), bool
        Where there are taxels.
    """
    contacts = find_contacts(frame, LEVELS, field=None if field.all() else field)
    if not contacts:
        return np.full(len(SIGNATURE_NAMES), np.nan)
    return contact_signature(as_learned(contacts[0]))


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactNetwork(Decision):
    """One layer of weights over the numbers of a contact's signature; each name is a kind, the last one the stranger.

    Parameters
    ----------
    field : ndarray of shape (rows, cols), bool
        Where the pad has taxels.
    examples : ndarray of shape (n, rows, cols), float32
        Frames that it learned from, by which an exported network is tested.
    """

    field: NDArray[np.bool_]
    examples: NDArray[np.float32]

    @classmethod
    def of(
        cls,
        classes: tuple[str, ...],
        field: NDArray[np.bool_],
        scaling: tuple[Floats, Floats],
        directions: Floats,
        means: Floats,
        *,
        temperature: float,
        farthest: float,
        examples: NDArray[np.floating],
    ) -> ContactNetwork:
        """Return the network of a discriminant: minus half the squared distance from each class, calibrated.

        Parameters
        ----------
        classes : tuple of str
        field : ndarray of shape (rows, cols), bool
        scaling : (ndarray, ndarray) of shape (n_inputs,), float64
            Shift and scale of the inputs.
        directions : ndarray of shape (n_inputs, r), float64
        means : ndarray of shape (n_classes, r), float64
        temperature : float
            What is divided by before the exponential.
        farthest : float
            What lies farther from all classes is none of these; infinite: nothing is refused.
        examples : ndarray of shape (n, rows, cols)

        Raises
        ------
        InputError
            If a number is too large for single precision.
        """
        plain = directions @ means.T / temperature
        bias = -0.5 * (means * means).sum(axis=1) / temperature
        refuses = np.isfinite(farthest)
        unit = _FARTHEST / max(farthest, _NEAREST) if refuses else 0.0
        if not all(np.abs(of).max(initial=0.0) < _MOST for of in (plain, bias, unit * directions, unit * means)):
            raise InputError(
                "what was learned is beyond a controller's single precision: learn from presses with noise"
            )
        none = np.empty((0, 0))
        names = (*classes, NONE_OF_THESE)
        return cls(
            names=names,
            name_of=np.arange(len(names), dtype=np.uint8),
            stranger=len(classes),
            plane=-1,
            bar=-1,
            square=-1,
            shift=scaling[0],
            scale=scaling[1],
            clip=CLIP,
            weights=(np.concatenate([plain, np.zeros((len(plain), 1))], axis=1).astype(np.float32),),
            biases=(np.append(bias, _NO_STRANGER).astype(np.float32),),
            whiten=(unit * directions if refuses else none).astype(np.float32),
            means=(unit * means if refuses else none).astype(np.float32),
            farthest=_FARTHEST,
            field=field,
            examples=np.asarray(examples, np.float32),
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the pad."""
        return self.field.shape[0], self.field.shape[1]
