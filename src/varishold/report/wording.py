"""What every page says alike: sentences, and bars of probability."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from varishold.report.quantities import percent

if TYPE_CHECKING:
    from varishold.touch import Surface

__all__ = ["Bar", "bars", "cut_at", "likeliest_bars", "sentence", "sentences"]

_FEWEST_BARS, _MOST_BARS = 3, 6


@dataclass(frozen=True)
class Bar:
    """One name's probability.

    Parameters
    ----------
    name : str
    share : float
        P(name).
    text : str
        As a person reads it.
    """

    name: str
    share: float
    text: str


def bars(probability: Iterable[tuple[str, float]]) -> tuple[Bar, ...]:
    """Return a bar for each name and its probability."""
    return tuple(Bar(name, p, percent(p)) for name, p in probability)


def likeliest_bars(probability: Iterable[tuple[str, float]]) -> tuple[Bar, ...]:
    """Return a bar for each of the likeliest names, which come first, and one for all others together."""
    shown = [(name, p) for k, (name, p) in enumerate(probability) if p >= 0.01 or k < _FEWEST_BARS][:_MOST_BARS]
    rest = 1.0 - sum(p for _, p in shown)
    return bars([*shown, *([("all others", rest)] if rest >= 0.0005 else [])])


def cut_at(surface: Surface) -> tuple[str, ...]:
    """Return the sides of the pad that hide a part of a surface; a plane and an edge go on beyond by what they are."""
    return () if surface.form in ("plane", "edge") else surface.cut


def sentence(text: str) -> str:
    """Return a text with a capital letter and a full stop.

    Examples
    --------
    >>> sentence("outline circle"), sentence("Is it?")
    ('Outline circle.', 'Is it?')
    """
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")


def sentences(texts: Iterable[str]) -> tuple[str, ...]:
    """Return each text as a sentence, but none that is empty."""
    return tuple(sentence(text) for text in texts if text)
