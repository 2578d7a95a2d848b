"""The search action: the hand moves until it touches, and centres itself by touch."""

from __future__ import annotations

from dataclasses import dataclass

from varishold.hand.bench import Bench
from varishold.hand.coordinates import gripped
from varishold.hand.design import FINGERS
from varishold.hand.model import DIGITS

__all__ = ["Search", "approach", "open_hand", "search"]

#: How far the palm pushes on after its first touch, so that a turned flat face comes to lie against it. Metres.
_PUSH_M = 0.002

#: Speed of a guarded move. Metres per second.
_SPEED_M_S = 0.12

#: The hand lets go of what it felt for and steps back so far before it moves sideways. Metres.
_BACK_M = 0.012

#: A step aside after a digit, and not the palm, met the object. Metres.
_ASIDE_M = 0.012

#: The object lies well enough when its middle is so near the palm's. Metres.
_CENTRED_M = 0.005

#: The part of an offset that one move aside makes up for.
_PART_OF_WAY = 0.8

#: An object that was felt from both sides so often is taken where it stands.
_MOST_TOUCHES = 3

#: Moves after which a search gives up.
_MOST_MOVES = 12


@dataclass(frozen=True)
class Search:
    """How a search went.

    Parameters
    ----------
    found : bool
        Whether the hand stands before something that it felt from both sides.
    touches : int
        How often it felt for the object.
    shift_m : float
        How far it moved aside in all. Metres.
    """

    found: bool
    touches: int
    shift_m: float


def open_hand(bench: Bench, *, seconds: float = 0.15) -> None:
    """Open every digit."""
    bench.put_digits(open_digits=DIGITS)
    bench.advance(seconds)


def approach(bench: Bench, *, most_m: float, push_m: float = _PUSH_M) -> bool:
    """Move the palm forward until a switch closes, and a little on if it is one of the palm's.

    Parameters
    ----------
    bench : Bench
    most_m : float
        How far to go at most. Metres.
    push_m : float
        How far to push on. Metres.

    Returns
    -------
    bool
        Whether one of the palm's switches is closed.
    """
    tick_s, gone_m = 0.01, 0.0
    while not bench.closed.any() and gone_m < most_m:
        bench.advance(tick_s, carriage=bench.ahead(_SPEED_M_S * tick_s))
        gone_m += _SPEED_M_S * tick_s
    if bench.palm_touched():
        bench.advance(0.04, carriage=bench.ahead(push_m))
    return bench.palm_touched()


def search(bench: Bench, *, most_m: float = 0.18) -> Search:
    """Find the object before the hand and come to stand with its middle before the palm's.

    Parameters
    ----------
    bench : Bench
        The hand open, behind the object.
    most_m : float
        How far the palm may go forward at a time. Metres.

    Returns
    -------
    Search
    """
    touches, aside_m, last_side = 0, _ASIDE_M, 0
    for _ in range(_MOST_MOVES):
        palm = approach(bench, most_m=most_m)
        side = 0 if palm else _side_touched(bench)
        if side:
            # Touched on the other side than before: the middle lies between, so the steps shrink.
            aside_m = aside_m / 2 if side == -last_side else aside_m
            last_side = side
            _step_aside(bench, side * aside_m)
            continue
        touches += 1
        grip = _feel(bench)
        open_hand(bench)
        if grip is None:
            return Search(False, touches, bench.target["shift"])
        if abs(grip[1]) <= _CENTRED_M or touches == _MOST_TOUCHES:
            return Search(True, touches, bench.target["shift"])
        # What is felt for gives way a little, so the whole distance would be too far.
        _step_aside(bench, _PART_OF_WAY * grip[1])
    return Search(False, touches, bench.target["shift"])


def _side_touched(bench: Bench) -> int:
    """+1 where only fingers touch, -1 where only the thumb does, 0 otherwise."""
    fingers = any(bench.digit_touched(digit) for digit in FINGERS)
    thumb = bench.digit_touched("thumb")
    return int(fingers) - int(thumb)


def _step_aside(bench: Bench, by_m: float) -> None:
    bench.advance(0.06, carriage=bench.ahead(-_BACK_M))
    bench.advance(0.1, carriage=bench.ahead(0.0, by_m))


def _feel(bench: Bench) -> tuple[float, float] | None:
    """Close index finger and thumb gently; return breadth and middle of what is between them."""
    gain = bench.design.search_gain
    bench.put_digits(closed_digits={"index": gain, "thumb": gain})
    for _ in range(8):
        bench.advance(0.06)
        if bench.digit_touched("index") and bench.digit_touched("thumb"):
            break
    return gripped(bench.sense(), bench.design, bench.layout)
