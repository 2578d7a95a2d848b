"""The search action: the hand moves until it touches, and centres itself by touch."""

from __future__ import annotations

from dataclasses import dataclass

from varishold.hand.bench import Bench
from varishold.hand.coordinates import feels_held, gripped

__all__ = ["Search", "approach", "open_hand", "search", "square_up"]

#: How far the palm pushes on after its first touch, so that a turned flat face comes to lie against it. Metres.
_PUSH_M = 0.002

#: The palm turns by such steps, about a side column of its switches, at most so far. Radians, metres.
_TURN_RAD, _MOST_TURN_RAD, _TURN_ARM_M = 0.06, 0.36, 0.015

#: A turn may lose touch with a face; it is found again within this. Metres.
_REGAIN_M = 0.004

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

#: The palm goes forward at most so far at a time. Metres.
_FAR_M = 0.18

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
    bench.put_digits(open_digits=tuple(bench.design.digits))
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
        Whether one of the palm's switches closed.
    """
    tick_s, gone_m = 0.01, 0.0
    bench.seen[:] = bench.closed
    while not bench.closed.any() and gone_m < most_m:
        bench.advance(tick_s, carriage=bench.ahead(_SPEED_M_S * tick_s))
        gone_m += _SPEED_M_S * tick_s
    if bench.palm_touched():
        bench.advance(0.04, carriage=bench.ahead(push_m))
    return bench.palm_touched()


def square_up(bench: Bench) -> float:
    """Turn the palm until it is pressed on both sides, as far as one side says which way.

    A flat face that is turned meets one side of the palm first; turning toward the other side lays it flat.

    Parameters
    ----------
    bench : Bench
        The hand open, its palm touching.

    Returns
    -------
    float
        How far the palm turned. Radians.
    """
    turned = 0.0
    while abs(turned) < _MOST_TURN_RAD:
        fingers_side, thumb_side = bench.palm_sides()
        if fingers_side == thumb_side:
            break
        step = _TURN_RAD if fingers_side else -_TURN_RAD
        if turned * step < 0:
            break
        # The side that touches stays where it is; the other side comes forward.
        turned += step
        bench.seen[:] = False
        carriage = bench.ahead(_TURN_ARM_M * _TURN_RAD) | {"turn": bench.target["turn"] + step}
        bench.advance(0.04, carriage=carriage)
        if not bench.palm_touched():
            approach(bench, most_m=_REGAIN_M, push_m=_REGAIN_M / 4)
    return turned


def search(bench: Bench, *, most_m: float | None = None) -> Search:
    """Find the object before the hand and come to stand with its middle before the palm's.

    Parameters
    ----------
    bench : Bench
        The hand open, behind the object.
    most_m : float, optional
        How far the palm may go forward at a time. Metres. Default: 0.18, and more for longer digits.

    Returns
    -------
    Search
    """
    most_m = _FAR_M + bench.design.longer_m if most_m is None else most_m
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
        if palm:
            square_up(bench)
        touches += 1
        grip = _feel(bench, palm=palm)
        open_hand(bench)
        if grip is None:
            # Felt before and not now: thin where the fingers are, or gone; the grasp will tell.
            return Search(touches > 1, touches, bench.target["shift"])
        if abs(grip[1]) <= _CENTRED_M or touches == _MOST_TOUCHES:
            return Search(True, touches, bench.target["shift"])
        # What is felt for gives way a little, so the whole distance would be too far.
        _step_aside(bench, _PART_OF_WAY * grip[1])
    return Search(False, touches, bench.target["shift"])


def _side_touched(bench: Bench) -> int:
    """+1 where only fingers touch, -1 where only the thumb does, 0 otherwise."""
    design = bench.design
    fingers, thumbs = (
        any(bench.digit_touched(digit.name) for digit in digits) for digits in (design.fingers, design.opposers)
    )
    return int(fingers) - int(thumbs)


def _step_aside(bench: Bench, by_m: float) -> None:
    bench.advance(0.06, carriage=bench.ahead(-_BACK_M))
    bench.advance(0.1, carriage=bench.ahead(0.0, by_m))


def _feel(bench: Bench, *, palm: bool) -> tuple[float, float] | None:
    """Close the pointing finger and the thumb gently; return breadth and middle of what is between them.

    What is too low or too thin for that finger is felt for with the others.
    """
    design = bench.design
    pointing = (design.pointer,)
    others = tuple(finger.name for finger in design.fingers if finger.name not in pointing)
    thumbs = tuple(digit.name for digit in design.opposers)
    for fingers, idle in ((pointing, others), (others, pointing)) if others else ((pointing, others),):
        gains = dict.fromkeys((*fingers, *thumbs), design.search_gain)
        bench.put_digits(closed_digits=gains, open_digits=idle)
        for _ in range(8):
            bench.advance(0.06)
            if all(any(bench.digit_touched(digit) for digit in digits) for digits in (fingers, thumbs)):
                break
        sensed = bench.sense()
        if feels_held(sensed, design, bench.layout, palm=palm):
            return gripped(sensed, design, bench.layout)
    return None
