"""Shares, intervals and calibration of names given with probabilities."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from benchmarks._figures import figure, share
from varishold.trust import share_interval

# Ridge and hip differ by one slope at the ends: where names are scored they count as one.
_SAME = {"hip": "ridge"}


@dataclass
class Scores:
    """Names given against true names."""

    truth: list[str] = field(default_factory=list)
    given: list[str] = field(default_factory=list)
    probability: list[float] = field(default_factory=list)

    def add(self, truth: str, given: str, probability: float) -> None:
        """Add one answer."""
        self.truth.append(_SAME.get(truth, truth))
        self.given.append(_SAME.get(given, given))
        self.probability.append(probability)

    @property
    def right(self) -> np.ndarray:
        """Whether each name was right."""
        return np.array(self.truth) == np.array(self.given)

    def calibration_error(self) -> float:
        """Return the expected calibration error in ten even bins."""
        p, right = np.array(self.probability), self.right
        bins = np.minimum((p * 10).astype(int), 9)
        return float(
            sum(abs(right[bins == b].mean() - p[bins == b].mean()) * (bins == b).mean() for b in np.unique(bins))
        )

    def report(self, of: str, *, bar: str = "") -> None:
        """Print the shares; `of` what they are begins each figure's name."""
        right, p = self.right, np.array(self.probability)
        low, high = share_interval(int(right.sum()), len(right))
        name = share(f"{of}: right name", right.mean(), ".2f", bar=bar)
        print(f"  right name {name} of {len(right)} frames, 95 % interval {100 * low:.2f}-{100 * high:.2f} %")
        sure = p > 0.9
        wrong = 1 - right[sure].mean() if sure.any() else 0.0
        said = share(f"{of}: given with p > .9", sure.mean())
        print(f"  given with p > .9: {said}, wrong {share(f'{of}: wrong with p > .9', wrong, '.2f', bar='<= 1')}")
        error = figure(f"{of}: calibration error", self.calibration_error(), ".4f", bar="<= .03")
        print(f"  calibration error in ten bins {error}")
        unknown = np.array(self.given) == "unknown"
        print(f"  called unknown {share(f'{of}: called unknown', unknown.mean(), '.2f', bar='<= 2')}")
        worst = Counter((t, g) for t, g in zip(self.truth, self.given, strict=True) if t != g).most_common(4)
        for truth in dict.fromkeys(self.truth):
            own = np.array(self.truth) == truth
            print(f"    {truth:22} {share(f'{of}: right name, {truth}', right[own].mean())}")
        if worst:
            print("    most often confused: " + "; ".join(f"{t} read as {g} {n} x" for (t, g), n in worst))
