"""``--hand``: a hand of a user's in place of the built-in one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from varishold.cli.command import Option
from varishold.cli.files import Reads

if TYPE_CHECKING:
    from varishold.hand import Hand
    from varishold.hand.mjcf import MjcfHand
    from varishold.perceive import Library

__all__ = ["FeelingHandName", "HandName", "hand_named", "require_library_of"]

_Hand = Annotated[
    str | None,
    Option(
        "A hand of your own: a file (TOML) that names the parts of an MJCF; or three-finger. "
        "Default: the built-in hand.",
        metavar="HAND.toml",
    ),
]
HandName = Annotated[_Hand, Reads("hand")]
FeelingHandName = Annotated[_Hand, Reads("feeling hand")]


def hand_named(name: str | None, *, finger_scale: float = 1.0, pads_for: str | None = None) -> MjcfHand | None:
    """Return the hand that an option names, or None for the built-in one.

    Parameters
    ----------
    name : str or None
    finger_scale : float
        What was asked of the built-in hand's digits: another hand's are as long as its file says.
    pads_for : str, optional
        The option that needs pads.
    """
    from varishold.errors import InputError, require
    from varishold.hand.mjcf import read_hand

    if name is None:
        return None
    require(
        finger_scale == 1.0, "--finger-scale is of the built-in hand; the digits of --hand are as its MJCF has them"
    )
    hand = read_hand(name)
    if pads_for is not None and not hand.pads:
        raise InputError(
            f'{name}: has no pads, and {pads_for} needs them; add pads = "all" or [[pads]], or leave it out'
        )
    return hand


def require_library_of(hand: Hand, library: Library, *, where: str, given: str) -> None:
    """Check that a library was felt by a hand.

    Parameters
    ----------
    hand : Hand
    library : Library
    where : str
        What the library is called: it opens the message.
    given : str
        What named the hand.

    Raises
    ------
    InputError
        If another hand felt it.
    """
    from varishold.errors import InputError
    from varishold.hand import HandDesign

    usual = HandDesign().identity
    by = library.hand or usual
    if by == hand.identity:
        return
    who = by.partition("@")[0]
    if hand.identity == usual:
        raise InputError(f"{where}: was felt by another hand, {who!r}; name that hand with --hand, or another library")
    whose = "this hand before its files changed" if who == hand.identity.partition("@")[0] else f"another hand, {who!r}"
    raise InputError(
        f"{where}: was felt by {whose}; make this hand's own with 'varishold objects feel --hand {given} -o FILE.npz', "
        "and give it with --library FILE.npz"
    )
