"""What sensors do to frames, for measuring alone: nothing here is shared with the sensor's model or with training.

Every fault takes frames whose peak is 1 and gives readings whose peak is about 1; all shares are of the peak.

- gain spread s: each taxel's reading times 1 + s n, n standard normal, at least .05.
- offsets s: each taxel's reading plus s n.
- sloping rest s: a ramp from 0 at one end of the pad to s at the other, in a random direction.
- ghosts s: the product of each taxel's row sum and column sum, the largest scaled to s, added.
- memory s: another frame of the set, its peak scaled to s, added.
- crosstalk s: each of the four neighbours reads the share s of a taxel's pressure; the sum is kept.
- blur s: Gaussian, standard deviation s taxels.
- pink s: added noise of standard deviation s over the pad, its power falling as 1 / spatial frequency.
- dead s: each taxel reads 0 with probability s, and nobody says so. Dead line: one row or column through the
  contact reads 0.
- logarithmic a: log(1 + a v) / log(1 + a). Power k: v ** k.
- dead zone s: max(v - s, 0) / (1 - s).
- saturated s: min(v, s), after the noise, so that saturated taxels read exactly alike.
- counts n: rounded to n whole counts of the peak, after the noise.
- stretch s: columns s times as far apart as taken to be, the contact's centre kept in its place.

The order is: memory, crosstalk, ghosts, gains, dead zone, response, offsets, slope, pink, dead, white noise,
saturation, counts.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Floats = NDArray[np.float64]

__all__ = [
    "Fault",
    "blur",
    "counts",
    "crosstalk",
    "dead",
    "dead_line",
    "dead_zone",
    "gains",
    "ghosts",
    "logarithm",
    "memory",
    "noise",
    "offsets",
    "pink",
    "power",
    "saturated",
    "slope",
    "stretch",
]

#: Takes readings of shape (n, rows, cols) and random numbers; returns readings of the same shape.
Fault = Callable[[Floats, np.random.Generator], Floats]


def memory(v: Floats, rng: np.random.Generator, share: float) -> Floats:
    """Add what the last press left."""
    return v + share * v[rng.permutation(len(v))]


def crosstalk(v: Floats, rng: np.random.Generator, share: float) -> Floats:
    """Leak to the four neighbours."""
    del rng
    kernel = np.array([[0, share, 0], [share, 1, share], [0, share, 0]])
    leaked = ndimage.convolve(v, kernel[None] / kernel.sum(), mode="nearest")
    return np.asarray(leaked / leaked.max(axis=(1, 2), keepdims=True))


def blur(v: Floats, rng: np.random.Generator, taxels: float) -> Floats:
    """Blur by a Gaussian."""
    del rng
    blurred = ndimage.gaussian_filter(v, (0, taxels, taxels), mode="nearest")
    return np.asarray(blurred / blurred.max(axis=(1, 2), keepdims=True))


def ghosts(v: Floats, rng: np.random.Generator, share: float) -> Floats:
    """Add what rows and columns that are read together let through."""
    del rng
    product = v.sum(axis=2)[:, :, None] * v.sum(axis=1)[:, None, :]
    return np.asarray(v + share * product / product.max(axis=(1, 2), keepdims=True))


def gains(v: Floats, rng: np.random.Generator, spread: float) -> Floats:
    """Scale every taxel by its own gain."""
    return v * np.maximum(1 + spread * rng.standard_normal(v.shape), 0.05)


def dead_zone(v: Floats, rng: np.random.Generator, below: float) -> Floats:
    """Say nothing of what is less than `below`."""
    del rng
    return np.maximum(v - below, 0.0) / (1 - below)


def logarithm(v: Floats, rng: np.random.Generator, a: float) -> Floats:
    """Respond with the logarithm."""
    del rng
    return np.asarray(np.log1p(a * np.maximum(v, 0.0)) / np.log1p(a))


def power(v: Floats, rng: np.random.Generator, exponent: float) -> Floats:
    """Respond with a power."""
    del rng
    return np.maximum(v, 0.0) ** exponent


def offsets(v: Floats, rng: np.random.Generator, spread: float) -> Floats:
    """Add every taxel's own rest."""
    return v + spread * rng.standard_normal(v.shape)


def slope(v: Floats, rng: np.random.Generator, rise: float) -> Floats:
    """Add a rest that slopes across the pad."""
    n, rows, cols = v.shape
    turn = rng.uniform(0, 2 * np.pi, (n, 1, 1))
    y, x = np.mgrid[:rows, :cols]
    ramp = x * np.cos(turn) + y * np.sin(turn)
    ramp -= ramp.min(axis=(1, 2), keepdims=True)
    return np.asarray(v + rise * ramp / ramp.max(axis=(1, 2), keepdims=True))


def pink(v: Floats, rng: np.random.Generator, spread: float) -> Floats:
    """Add noise whose power falls as one over the spatial frequency."""
    _, rows, cols = v.shape
    wave = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.rfftfreq(cols)[None, :])
    wave[0, 0] = np.inf
    noise = np.fft.irfft2(np.fft.rfft2(rng.standard_normal(v.shape)) / np.sqrt(wave), (rows, cols))
    return np.asarray(v + spread * noise / noise.std(axis=(1, 2), keepdims=True))


def dead(v: Floats, rng: np.random.Generator, share: float) -> Floats:
    """Let single taxels read nothing."""
    return np.where(rng.uniform(size=v.shape) < share, 0.0, v)


def dead_line(v: Floats, rng: np.random.Generator) -> Floats:
    """Let one row or column through the contact read nothing."""
    out = v.copy()
    for frame in out:
        axis = int(rng.integers(2))
        loaded = np.flatnonzero((frame > 0.1).any(axis=1 - axis))
        line = int(rng.choice(loaded))
        frame[(line, slice(None)) if axis == 0 else (slice(None), line)] = 0.0
    return out


def noise(v: Floats, rng: np.random.Generator, spread: float) -> Floats:
    """Add white noise."""
    return v + spread * rng.standard_normal(v.shape)


def saturated(v: Floats, rng: np.random.Generator, at: float) -> Floats:
    """Read no more than `at`."""
    del rng
    return np.minimum(v, at)


def counts(v: Floats, rng: np.random.Generator, n: int) -> Floats:
    """Round to whole counts."""
    del rng
    return np.round(v * n) / n


def stretch(v: Floats, rng: np.random.Generator, ratio: float) -> Floats:
    """Space the columns `ratio` times as far as thought, so that the contact seems narrower by as much."""
    del rng
    out = np.empty_like(v)
    for k, frame in enumerate(v):
        middle = float(frame.sum(axis=0) @ np.arange(frame.shape[1]) / frame.sum())
        at = middle + ratio * (np.arange(frame.shape[1]) - middle)
        rows = np.arange(frame.shape[0])
        out[k] = ndimage.map_coordinates(frame, np.meshgrid(rows, at, indexing="ij"), order=1, mode="nearest")
    return np.asarray(out / out.max(axis=(1, 2), keepdims=True))
