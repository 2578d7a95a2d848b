"""What each sense says of the name: what was said before the first touch, touch alone, and both."""

from __future__ import annotations

from varishold.exploration import Exploration
from varishold.report.exploration_words import in_words
from varishold.report.wording import Bar, likeliest_bars

__all__ = ["belief_before", "sense_bars", "senses_in_words"]

# A share that is worth a word.
_SAID = 0.005


def belief_before(sequence: Exploration) -> dict[str, float] | None:
    """Return what was believed before the first touch; None where nothing was said."""
    return sequence.senses[0][1] if sequence.senses else None


def sense_bars(sequence: Exploration) -> list[tuple[str, tuple[Bar, ...]]]:
    """Return who says it and a bar for each of the likeliest names; nothing where only touch said something."""
    return [
        (sense_in_words(who), likeliest_bars((in_words(name), p) for name, p in by_share(said)))
        for who, said in sequence.senses
    ]


def by_share(said: dict[str, float]) -> list[tuple[str, float]]:
    """Return names and shares, the greatest first."""
    return sorted(said.items(), key=lambda item: -item[1])


def sense_in_words(who: str) -> str:
    """Return who says it: the source alone, touch alone, or both.

    Examples
    --------
    >>> sense_in_words("camera 2"), sense_in_words("touch"), sense_in_words("together")
    ('camera 2 alone', 'touch alone', 'both together')
    """
    return "both together" if who == "together" else f"{who} alone"


def senses_in_words(sequence: Exploration) -> tuple[str, ...]:
    """Return a line for what was said before the first touch and one for what touch says alone; none without either."""
    told = []
    for who, said in sequence.senses[:2]:
        likely = ", ".join(f"{name} {p:.2f}" for name, p in by_share(said)[:2] if p >= _SAID)
        nothing = len(said) > 1 and max(said.values()) - min(said.values()) < _SAID
        told.append(f"{sense_in_words(who)}: {'all names alike' if nothing else likely}")
    return tuple(told)
