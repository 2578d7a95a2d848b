"""A sequence of touches in words: what was done, what is believed, what comes next, the answer and whether it is right.

Text only: commands print it, the page shows it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from varishold._counted import counted
from varishold.exploration import TOUCHES, Exploration, MadeTouch
from varishold.perceive import NONE_OF_THESE, BeliefUpdate, NextTouch
from varishold.report.quantities import percent

__all__ = [
    "answer_in_words",
    "chosen_in_words",
    "in_words",
    "information",
    "next_in_words",
    "size_in_words",
    "spoken",
    "truth_in_words",
    "verdict_in_words",
    "was_right",
    "with_article",
]

# What a name would have, were the thing known, is told where it is so much more than what it has.
_TOLD_APART = 0.01

# Names that are not read as they are written.
_SPOKEN = {"l-block": "L-block", "half-cylinder": "half-cylinder"}


def in_words(name: str) -> str:
    """Return an object's name as a person reads it.

    Examples
    --------
    >>> in_words("square-pillar"), in_words("l-block")
    ('square pillar', 'L-block')
    >>> in_words("lump-17")
    'lump (number 17)'
    """
    if name.startswith(("lump-", "assembly-", "variant-")):
        kind, number = name.split("-")
        return f"{kind} (number {number})"
    return _SPOKEN.get(name, name.replace("-", " "))


def with_article(name: str) -> str:
    """Return an object's name in words with its article.

    Examples
    --------
    >>> with_article("ellipsoid"), with_article("l-block"), with_article("cone-frustum")
    ('an ellipsoid', 'an L-block', 'a cone frustum')
    """
    words = in_words(name)
    return f"{'an' if words[0] in 'aeiouL' else 'a'} {words}"


def size_in_words(size_m: float | None, interval_m: tuple[float, float] | None, *, digits: int = 0) -> str:
    """Return a size with the interval that holds it with 95 %, in millimetres.

    Examples
    --------
    >>> size_in_words(0.0704, (0.068, 0.0731))
    '70 mm (68 to 73)'
    """
    if size_m is None:
        return "size unknown"
    text = f"{1e3 * size_m:.{digits}f} mm"
    if interval_m is None:
        return text
    return f"{text} ({1e3 * interval_m[0]:.{digits}f} to {1e3 * interval_m[1]:.{digits}f})"


def information(nats: float) -> str:
    """Return an amount of information in nats and bits."""
    return f"{nats:.2f} nats ({nats / math.log(2):.2f} bits)".replace("-", "−")


def next_in_words(touch: MadeTouch) -> str | None:
    """Return which touch comes next, what it is expected to tell and how long it takes; None where there is none."""
    if touch.then is None:
        return None
    name, nats = touch.then
    return name if nats is None else f"{name}, {chosen_in_words(nats, touch.planned)}"


def chosen_in_words(nats: float, planned: NextTouch | None) -> str:
    """Return what the next touch is chosen for.

    Examples
    --------
    >>> chosen_in_words(0.34, NextTouch("fingertip-edge", 0.34, 5.2, along_with="regrasp-lower"))
    'expected to tell 0.34 nats (0.49 bits) about the name in 5.2 s, with regrasp-lower in view after it'
    """
    text = f"expected to tell {information(nats)} about the name"
    if planned is None:
        return text
    text += "" if planned.seconds is None else f" in {planned.seconds:.1f} s"
    return text + ("" if planned.along_with is None else f", with {planned.along_with} in view after it")


def verdict_in_words(touch: MadeTouch) -> str:
    """Return whether it goes on after a touch."""
    if touch.update.verdict != "go on":
        return "stops"
    return "would go on, but no touch is left" if touch.then is None else "goes on"


def was_right(sequence: Exploration) -> bool | None:
    """Return whether the answer is true; None where there is no answer, or none that it stands by.

    An object that the library does not know is rightly called none of these.
    """
    perception = sequence.perception
    if perception is None:
        return None
    if sequence.name not in perception.trace[-1].probability:
        return perception.object == NONE_OF_THESE
    return perception.object in (sequence.name, *sequence.also_right)


def answer_in_words(sequence: Exploration) -> str:
    """Return the answer in one or two plain sentences."""
    perception = sequence.perception
    if perception is None:
        return f"Nothing was gripped: the hand missed or dropped the object {_times(sequence.drops)} and gave up."
    last, n = perception.trace[-1], len(perception.trace)
    touches = counted(n, "touch")
    if perception.object == NONE_OF_THESE:
        name, _ = next(iter(last.probability.items()))
        return (
            f"After {touches}: none of the {counted(len(last.probability), 'object')} it knows. "
            f"The nearest would be {with_article(name)}, but only {_share(last.p_value)} of touches of one are as odd."
        )
    size = size_in_words(perception.size_m, perception.size_interval_m)
    # What stands is as it is usually met.
    lies = "" if perception.pose in (None, "upright") else f", {perception.pose}"
    what = f"{with_article(perception.object)}{lies}, {size}, with a probability of {_share(perception.probability)}"
    among = last.probability.get(perception.object, 0.0)
    if among - perception.probability > _TOLD_APART:
        what += f" ({_share(among)} were it one of those it knows)"
    if last.verdict == "sure":
        return f"After {touches}: {what}."
    return f"After {touches}: most likely {what}; it stopped without being sure. {_unsure(sequence, last)}"


def _unsure(sequence: Exploration, last: BeliefUpdate) -> str:
    if last.verdict == "enough":
        return "No more touches were allowed."
    if sequence.touches[-1].then is not None:
        return f"The hand lost the object {_times(sequence.drops)} and gave up."
    return "No other touch was left."


def truth_in_words(sequence: Exploration) -> str:
    """Return what the object truly is, and whether the answer was right."""
    truth = f"{with_article(sequence.name)} of {round(1e3 * sequence.size_m, 1):g} mm"
    perception, right = sequence.perception, was_right(sequence)
    if perception is None or right is None:
        return f"It was {truth}."
    known = sequence.name in perception.trace[-1].probability
    text = f"{'Right' if right else 'Wrong'}: it is {truth}" + ("" if known else ", which the library does not know")
    if right and perception.object in sequence.also_right:
        text += f", which is {with_article(perception.object)} as well"
    if right and perception.size_m is not None:
        text += f"; the size is {100 * abs(perception.size_m / sequence.size_m - 1):.1f} % off"
    return f"{text}."


def _share(p: float) -> str:
    return percent(p).replace(">\u202f", "more than ").replace("<\u202f", "less than ")


def _times(n: int) -> str:
    return "once" if n == 1 else "twice" if n == 2 else counted(n, "time")


def spoken(text: str, names: Iterable[str]) -> str:
    """Return a text with the names of objects and touches in it in words."""
    for name in sorted((*names, *TOUCHES), key=len, reverse=True):
        text = text.replace(name, in_words(name))
    return text
