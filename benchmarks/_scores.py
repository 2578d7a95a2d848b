"""Shares, intervals and calibration of names given with probabilities."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from varishold.paper.intervals import share_interval

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

    def report(self) -> None:
        """Print the shares."""
        right, p = self.right, np.array(self.probability)
        low, high = share_interval(int(right.sum()), len(right))
        print(f"  right name {right.mean():.4f} of {len(right)} frames, 95 % interval {low:.4f}-{high:.4f}")
        sure = p > 0.9
        wrong = 1 - right[sure].mean() if sure.any() else 0.0
        print(f"  given with p > .9: {sure.mean():.3f} of frames, wrong {wrong:.4f} (bar .01)")
        print(f"  calibration error in ten bins {self.calibration_error():.4f} (bar .03)")
        unknown = np.array(self.given) == "unknown"
        print(f"  known surfaces called unknown {unknown.mean():.4f} (bar .02)")
        worst = Counter((t, g) for t, g in zip(self.truth, self.given, strict=True) if t != g).most_common(4)
        for truth in dict.fromkeys(self.truth):
            of = np.array(self.truth) == truth
            print(f"    {truth:22} {right[of].mean():.3f}")
        if worst:
            print("    most often confused: " + "; ".join(f"{t} read as {g} {n} x" for (t, g), n in worst))
