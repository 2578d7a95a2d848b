"""A skin that warms up, walks and creeps while it is pressed: readings, and what pressed them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

__all__ = ["DriftingSkin", "Press", "World"]

_BLOCK = 1000
# Counts where nothing presses, and the converter's full scale.
_REST, _FULL_SCALE = (300.0, 700.0), 4095


@dataclass(frozen=True)
class World:
    """What a skin goes through.

    Parameters
    ----------
    shape : (int, int)
    rate_hz, lasts_s : float
    warmth, warm_up_s : float
        How far the mean taxel drifts until the end, counts, and the time constant of it.
    sways, sway_s : float
        How far the mean taxel sways about that, counts, and how long a sway takes.
    share_spread : float
        Scatter of the taxels' shares of it, half of it the same for neighbours.
    walk : float
        How far a taxel walks on its own in a second, counts.
    creep, creep_s : float
        What a long press gains, as a share of it, and how soon.
    noise : float
        Of the typical taxel, counts.
    n_presses : int
        Short presses.
    hold_s : (float, float)
        When one contact begins and ends that is held.
    covers : float
        The share of the pad that the held contact covers; 0 for a tip's.
    faults : bool
        Whether one taxel in a hundred is dead, one is four times as noisy, and one reading in 100,000 is an impulse.
    """

    shape: tuple[int, int] = (16, 16)
    rate_hz: float = 100.0
    lasts_s: float = 600.0
    warmth: float = 58.0
    warm_up_s: float = 250.0
    sways: float = 1.0
    sway_s: float = 90.0
    share_spread: float = 0.25
    walk: float = 0.06
    creep: float = 0.12
    creep_s: float = 8.0
    noise: float = 1.2
    n_presses: int = 25
    hold_s: tuple[float, float] = (300.0, 480.0)
    covers: float = 0.0
    faults: bool = False

    @classmethod
    def of_hours(cls, n_hours: float, *, rate_hz: float, n_presses: int) -> World:
        """Return hours of drift that sways, with presses all day long and one that is held."""
        return cls(
            rate_hz=rate_hz,
            lasts_s=3600.0 * n_hours,
            warm_up_s=3600.0,
            sways=10.0,
            sway_s=2400.0,
            n_presses=n_presses,
            hold_s=(600.0, 780.0),
        )


@dataclass(frozen=True)
class Press:
    """One press: where, how hard, and its course.

    Parameters
    ----------
    form : ndarray of shape (rows, cols)
        Counts at full force, before it creeps.
    corners_s : (float, float, float, float)
        When it begins, has its full force, begins to end, has ended.
    """

    form: NDArray[np.float64]
    corners_s: tuple[float, float, float, float]

    def course(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of its force at these times."""
        along = np.interp(time_s, self.corners_s, (0.0, 1.0, 1.0, 0.0))
        return along * along * (3.0 - 2.0 * along)


class DriftingSkin:
    """One skin's readings in one world.

    Attributes
    ----------
    hold : Press
    presses : list of Press
        The short ones.
    sigma : ndarray of shape (rows, cols)
        Noise of each taxel, counts, rounding included.
    """

    def __init__(self, world: World, seed: int) -> None:
        self.world, self._rng = world, np.random.default_rng([seed, 71])
        rng, shape = self._rng, world.shape
        self._rest = rng.uniform(*_REST, shape)
        self._share = 1.0 + world.share_spread * (rng.normal(size=shape) + _smooth(rng, shape)) / math.sqrt(2.0)
        self._own = rng.normal(0.0, 0.0, shape)
        self.sigma = world.noise * np.exp(rng.normal(0.0, 0.2, shape))
        self.dead = np.zeros(shape, np.bool_)
        if world.faults:
            n = max(1, round(0.01 * self._rest.size))
            places = rng.permutation(self._rest.size)
            self.dead.flat[places[:n]] = True
            self.sigma.flat[places[n : 2 * n]] *= 4.0
        self._phase = rng.uniform(0, 2 * np.pi)
        self.hold = self._draw_hold()
        self.presses = self._draw_presses()

    @property
    def times_s(self) -> NDArray[np.float64]:
        """When its frames are taken."""
        return np.arange(round(self.world.lasts_s * self.world.rate_hz)) / self.world.rate_hz

    def warmth(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far the mean taxel has drifted, counts."""
        world = self.world
        warm = np.expm1(-time_s / world.warm_up_s) / math.expm1(-world.lasts_s / world.warm_up_s)
        return world.warmth * warm + world.sways * np.sin(2 * np.pi * time_s / world.sway_s + self._phase)

    def crept(self, press: Press) -> tuple[int, NDArray[np.float64]]:
        """Return a press's first frame and its force from there on, creep included, by its full force without."""
        rate, times = self.world.rate_hz, self.times_s
        begins, ends = np.searchsorted(times, [press.corners_s[0], press.corners_s[3] + 12.0 * self.world.creep_s])
        course = press.course(times[begins:ends])
        keep = math.exp(-1.0 / (rate * self.world.creep_s))
        slow, state = np.zeros_like(course), 0.0
        for k in range(course.size):
            state = keep * state + (1.0 - keep) * course[k]
            slow[k] = state
        return int(begins), course + self.world.creep * slow

    def blocks(self) -> Iterator[tuple[NDArray[np.float64], NDArray[np.uint16]]]:
        """Go through its readings: times and frames of shape (some, rows, cols)."""
        world, rng, times = self.world, self._rng, self.times_s
        forces = [(press, *self.crept(press)) for press in [self.hold, *self.presses]]
        step = world.walk / math.sqrt(world.rate_hz)
        for start in range(0, times.size, _BLOCK):
            time_s = times[start : start + _BLOCK]
            walk = np.cumsum(rng.normal(0.0, step, (time_s.size, *world.shape)), axis=0) + self._own
            self._own = walk[-1]
            frames = self._rest + self.warmth(time_s)[:, None, None] * self._share + walk
            # A finger is never quite still.
            tremor = 1.0 + 0.01 * np.sin(2 * np.pi * 1.3 * time_s)
            for press, begins, force in forces:
                first, last = max(begins, start), min(begins + force.size, start + time_s.size)
                if first < last:
                    here = force[first - begins : last - begins] * tremor[first - start : last - start]
                    frames[first - start : last - start] += here[:, None, None] * press.form
            frames += rng.normal(0.0, 1.0, frames.shape) * self.sigma
            if world.faults:
                struck = rng.random(frames.shape) < 1e-5
                frames[struck] += rng.uniform(100, 2000, int(struck.sum()))
                frames[:, self.dead] = 0.0
            yield time_s, np.clip(np.rint(frames), 0, _FULL_SCALE).astype(np.uint16)

    def _draw_hold(self) -> Press:
        begins, ends = self.world.hold_s
        if self.world.covers:
            along = np.linspace(0.0, 1.0, self.world.shape[1])[None, :] + 0.1 * _smooth(self._rng, self.world.shape)
            wet = along <= np.quantile(along, self.world.covers)
            form = wet * (45.0 + 10.0 * _smooth(self._rng, self.world.shape))
        else:
            form = self._tip(self._rng.uniform(90, 160))
        return Press(form, (begins, begins + 0.4, ends - 0.3, ends))

    def _draw_presses(self) -> list[Press]:
        """Draw short presses one after another, some of them beside the contact that is held."""
        rng, (begins, ends), world = self._rng, self.world.hold_s, self.world
        presses: list[Press] = []
        slots = np.linspace(4.0, world.lasts_s - 6.0, world.n_presses + 1)
        for first, last in pairwise(slots.tolist()):
            start = first + rng.uniform(0.0, 0.4) * (last - first)
            lasts = min(rng.uniform(0.4, 5.0), 0.4 * (last - first))
            beside = start + lasts + 2.0 > begins - 1.0 and start < ends + 1.0
            form = self._tip(rng.uniform(60, 300))
            for _ in range(50):
                if not beside or np.max(form * self.hold.form) < 1.0:
                    break
                form = self._tip(rng.uniform(60, 300))
            else:
                continue
            rises, falls = rng.uniform(0.05, 0.5, 2)
            presses.append(Press(form, (start, start + rises, start + rises + lasts, start + rises + lasts + falls)))
        return presses

    def _tip(self, peak: float) -> NDArray[np.float64]:
        """Return a rounded tip's counts: a dome and its skirt."""
        rng, shape = self._rng, self.world.shape
        longest = min(3.4, max(1.2, 0.22 * min(shape)))
        row, col = (rng.uniform(0.5, n - 1.5) if n > 2 else (n - 1) / 2 for n in shape)
        long, short = sorted(rng.uniform(1.1, longest, 2))[::-1]
        turn = rng.uniform(0, np.pi)
        y, x = np.mgrid[: shape[0], : shape[1]]
        u = (x - col) * math.cos(turn) + (y - row) * math.sin(turn)
        v = (y - row) * math.cos(turn) - (x - col) * math.sin(turn)
        r = np.hypot(u / long, v / short)
        skirt = 0.5 * np.exp(-(r - 1.0) * math.sqrt(long * short) / 0.8)
        return peak * np.where(r < 1.0, np.sqrt(np.maximum(1.0 - 0.75 * r * r, 0.0)), skirt)


def _smooth(rng: np.random.Generator, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return a smooth random surface of mean 0 and standard deviation 1."""
    y, x = (np.linspace(0.0, 1.0, n) for n in shape)
    surface = np.zeros(shape)
    for k in range(3):
        for j in range(3):
            if k or j:
                waves = np.cos(np.pi * k * y)[:, None] * np.cos(np.pi * j * x)[None, :]
                surface += rng.normal() / (1 + k + j) * waves
    surface -= surface.mean()
    spread = float(surface.std())
    return surface / spread if spread > 0 else surface
