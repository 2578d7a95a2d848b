"""How a pad's taxels are, as numbers and in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from varishold.frame.health import taxels_in_words

__all__ = ["BadTaxel", "HealthReport", "Word"]

Word = Literal[
    "dead",
    "stuck",
    "open line",
    "noisy",
    "impulses",
    "saturated",
    "no number",
    "slow to return",
    "drifts alone",
    "sticks",
    "flickers",
]

# What a remark says of each word's taxels, and of their figure.
_SAID: dict[str, str] = {
    "dead": "shows no noise while the others do: dead",
    "stuck": "never changes its value: stuck",
    "noisy": "is noisy: up to {noise_times_median:.1f} times as much as the typical taxel",
    "impulses": "has impulses: up to {impulses_per_min:.0f} a minute",
    "saturated": "is at full scale in up to {saturated_share:.0f} % of the frames: saturated",
    "no number": "sends no finite number in up to {not_finite_share:.1f} % of the frames",
    "slow to return": "is slow to return: up to {stays_share:.0f} % of a press stays half a second after it",
    "drifts alone": "drifts alone: by up to {drift_per_min:.3g} a minute",
    "sticks": "stays where it is while others are pressed and let go: sticks",
    "flickers": "jumps again and again while none beside it does: flickers",
}


@dataclass(frozen=True)
class BadTaxel:
    """One taxel, and what is wrong with it.

    Parameters
    ----------
    row, col : int
    word : str
        "dead" (no noise while the others have it), "stuck" (always the same value, not 0), "open line" (its whole row
        or column is so), "noisy", "impulses", "saturated", "no number", "slow to return", "drifts alone", "sticks"
        (it stays where it is while others are pressed and let go) or "flickers" (it jumps again and again, alone).
    figures : mapping of str to float
        How much, by name: `noise_times_median`, `value`, `silent_s`, `impulses_per_min`, `saturated_share`,
        `not_finite_share`, `stays_share` and `return_s`, or `drift_per_min` in the unit of the frames.
    """

    row: int
    col: int
    word: Word
    figures: Mapping[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {"row": self.row, "col": self.col, "word": self.word, **self.figures}


@dataclass(frozen=True)
class HealthReport:
    """How a pad is.

    Parameters
    ----------
    n_frames : int
        Frames that it was told from.
    watched_s : float
    noise : float
        Of the typical taxel, in the unit of the frames.
    drift_per_min : float or None
        Of the typical taxel, in the unit of the frames; None before it is known.
    impulses_per_min : float
        Of all taxels together.
    saturated_share, not_finite_share : float
        Of all readings lately.
    open_rows, open_cols : tuple of int
        Lines that are silent as a whole.
    bad : tuple of BadTaxel
        A taxel may be bad in several ways.
    """

    n_frames: int
    watched_s: float
    noise: float
    drift_per_min: float | None
    impulses_per_min: float
    saturated_share: float
    not_finite_share: float
    open_rows: tuple[int, ...]
    open_cols: tuple[int, ...]
    bad: tuple[BadTaxel, ...]

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is wrong, a sentence for each kind of fault."""
        lines = [
            f"{name} {number} is silent: an open line"
            for name, numbers in (("row", self.open_rows), ("column", self.open_cols))
            for number in numbers
        ]
        for word, said in _SAID.items():
            found = [taxel for taxel in self.bad if taxel.word == word]
            if found:
                mask = np.zeros((1 + max(one.row for one in found), 1 + max(one.col for one in found)), np.bool_)
                mask[[one.row for one in found], [one.col for one in found]] = True
                most = {name: max(one.figures.get(name, 0.0) for one in found) for name in found[0].figures}
                most = {name: 100.0 * figure if name.endswith("_share") else figure for name, figure in most.items()}
                lines.append(f"{taxels_in_words(mask)} {said.format(**most)}")
        return tuple(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON has it, with its remarks."""
        told = {**asdict(self), "open_rows": list(self.open_rows), "open_cols": list(self.open_cols)}
        return {**told, "bad": [taxel.to_dict() for taxel in self.bad], "remarks": list(self.remarks)}
