"""Libraries of 3 to 20 examples of each of 2 to 6 things: how often the size's interval holds it, and names.

Run: ``python -m benchmarks.perceive_small_libraries [--libraries 160] [--seed 2]``. Numbers are drawn: 6 to 200 of
them depend on the size by lines and bends of chance, share a pose, and are noisy; with or without fitted sizes.
Examples are of one size, of two or three, or of any of a range; new things within these sizes, or up to a fifth beyond.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks._figures import figure, share
from varishold.perceive import NONE_OF_THESE, Evidence, Library, Perceiver

Floats = NDArray[np.float64]

_TOUCHES = ("grasp", "tip", "turn")
_MIDDLE = float(np.log(0.07))


@dataclass(frozen=True)
class _Felt:
    """One new thing: where its size lies, how the thing is named, and its interval under its own name."""

    beyond: bool
    right: bool
    refused: bool
    sure: bool
    held: bool
    width: float


@dataclass
class _World:
    """Things, and a hand that feels them."""

    rng: np.random.Generator
    things: int
    touches: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        rng, things = self.rng, self.things
        numbers, self.fitted = int(rng.choice([6, 20, 60, 200])), int(rng.choice([0, 0, 1, 3]))
        self.touches = _TOUCHES[: int(rng.integers(1, 4))]
        slope, bend = rng.choice([0, 0.3, 1]), rng.choice([0, 0.3, 0.8])
        self.noise, self.fit_noise = rng.choice([0.3, 1]), rng.choice([0.01, 0.03, 0.08])
        self.heavy = bool(rng.random() < 0.3)
        self.middle = rng.normal(size=(things, numbers))
        self.slope = slope * (rng.normal(size=numbers) + 0.5 * rng.normal(size=(things, numbers)))
        self.bend = bend * rng.normal(size=(things, numbers))
        self.pose = rng.choice([0, 0.5]) * rng.normal(size=(3, numbers))
        self.fit = [rng.normal(0, wide, (things, self.fitted)) for wide in (0.3, 0.1, 0.1 * bend)]

    def example(self, thing: int, log_size: float) -> list[Evidence]:
        """Return every touch of a thing of some size."""
        pose = self.rng.normal(size=3) @ self.pose
        return [self._touch(name, thing, log_size, pose) for name in self.touches]

    def _touch(self, name: str, thing: int, log_size: float, pose: Floats) -> Evidence:
        off = (log_size - _MIDDLE) / 0.3
        form = self.middle[thing] + self.slope[thing] * off + self.bend[thing] * off**2 + pose
        form += self.noise * self._drawn(len(form))
        factor, line, bend = (part[thing] for part in self.fit)
        size = factor + (1 + line) * log_size + bend * off**2 + self.fit_noise * self._drawn(self.fitted)
        told = {f"form.{k}": float(x) for k, x in enumerate(form)} | {f"size.{k}": float(x) for k, x in enumerate(size)}
        return Evidence(name, told)

    def _drawn(self, n: int) -> Floats:
        return self.rng.standard_t(3, n) if self.heavy else self.rng.normal(size=n)

    def log_sizes(self, n: int, how: str) -> Floats:
        """Return the sizes of n examples of a thing."""
        middle = _MIDDLE + self.rng.uniform(-0.3, 0.3)
        several = {"one": np.zeros(1), "some": self.rng.uniform(-0.35, 0.35, int(self.rng.integers(2, 4)))}
        off = several.get(how, self.rng.uniform(-0.4, 0.4, n))
        return np.asarray(middle + off[np.arange(n) % len(off)])


def _feel(rng: np.random.Generator) -> list[_Felt]:
    """Return three new touches of each thing of a library: two within its sizes, and one beyond."""
    things, n, how = int(rng.integers(2, 7)), int(rng.integers(3, 21)), str(rng.choice(["one", "some", "range"]))
    world = _World(rng, things)
    sizes = {str(k): world.log_sizes(n, how) for k in range(things)}
    library = Library.from_examples(
        {name: [world.example(int(name), size) for size in of] for name, of in sizes.items()},
        sizes_m={name: np.exp(of).tolist() for name, of in sizes.items()},
    )
    return [_one(world, library, name, sizes[name], beyond) for name in sizes for beyond in (False, False, True)]


def _one(world: _World, library: Library, name: str, sizes: Floats, beyond: bool) -> _Felt:
    low, high = sizes.min(), sizes.max()
    more = world.rng.uniform(0.03, 0.2)
    away = low - more if world.rng.random() < 0.5 else high + more
    true = float(away if beyond else world.rng.uniform(low, high))
    perceiver = Perceiver(library, most_touches=len(world.touches))
    for evidence in world.example(int(name), true):
        perceiver.feel(evidence)
        if perceiver.stopped:
            break
    answer, size = perceiver.answer(), perceiver.belief.size(name)
    _, least, most = size or (np.nan, np.nan, np.nan)
    refused, right = answer.object == NONE_OF_THESE, answer.object == name
    sure = not (refused or right) and answer.probability > 0.95
    return _Felt(beyond, right, refused, sure, bool(least <= np.exp(true) <= most), float(np.log(most / least)))


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--libraries", type=int, default=160)
    parser.add_argument("--seed", type=int, default=2)
    options = parser.parse_args(list(argv))
    felt = [one for k in range(options.libraries) for one in _feel(np.random.default_rng([options.seed, k]))]
    for of, some in (
        ("all", felt),
        ("within the examples' sizes", [one for one in felt if not one.beyond]),
        ("beyond them", [one for one in felt if one.beyond]),
    ):
        print(
            f"  {of}, {len(some)} things: the 95 % interval holds the size in "
            f"{share(f'{of}: held', np.mean([one.held for one in some]))}, median width "
            f"{figure(f'{of}: width', float(np.nanmedian([one.width for one in some])), '.2f')} in logarithm; right "
            f"{share(f'{of}: right', np.mean([one.right for one in some]))}, refused "
            f"{share(f'{of}: refused', np.mean([one.refused for one in some]))}, another name with more than .95 "
            f"{share(f'{of}: wrong and sure', np.mean([one.sure for one in some]))}"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
