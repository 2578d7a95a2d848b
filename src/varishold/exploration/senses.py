"""What each sense says of the name, where something was said before the first touch."""

from __future__ import annotations

from varishold.perceive import Belief, Perceiver

__all__ = ["what_senses_say"]


def what_senses_say(perceiver: Perceiver) -> tuple[tuple[str, dict[str, float]], ...]:
    """Return what was believed before the first touch, what touch says alone, and both; nothing without a prior.

    Probabilities divided by those of before are what the touches alone say.
    """
    if perceiver.prior is None:
        return ()
    belief = perceiver.belief
    before = Belief.before(perceiver.library, perceiver.prior).probability
    odds = {name: p / before[name] for name, p in belief.probability.items()}
    touch = {name: share / sum(odds.values()) for name, share in odds.items()}
    first = {name: before[name] for name in odds}
    return ((perceiver.prior.source, first), ("touch", touch), ("together", belief.believed))
