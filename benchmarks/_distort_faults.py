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
from scipy import ndimage

#: Takes readings of shape (n, rows, cols) and random numbers; returns readings of the same shape.
Fault = Callable[[np.ndarray, np.random.Generator], np.ndarray]


def memory(v: np.ndarray, rng: np.random.Generator, share: float) -> np.ndarray:
    """Add what the last press left."""
    return v + share * v[rng.permutation(len(v))]


def crosstalk(v: np.ndarray, rng: np.random.Generator, share: float) -> np.ndarray:
    """Leak to the four neighbours."""
    del rng
    kernel = np.array([[0, share, 0], [share, 1, share], [0, share, 0]])
    leaked = ndimage.convolve(v, kernel[None] / kernel.sum(), mode="nearest")
    return leaked / leaked.max(axis=(1, 2), keepdims=True)


def blur(v: np.ndarray, rng: np.random.Generator, taxels: float) -> np.ndarray:
    """Blur by a Gaussian."""
    del rng
    blurred = ndimage.gaussian_filter(v, (0, taxels, taxels), mode="nearest")
    return blurred / blurred.max(axis=(1, 2), keepdims=True)


def ghosts(v: np.ndarray, rng: np.random.Generator, share: float) -> np.ndarray:
    """Add what rows and columns that are read together let through."""
    del rng
    product = v.sum(axis=2)[:, :, None] * v.sum(axis=1)[:, None, :]
    return v + share * product / product.max(axis=(1, 2), keepdims=True)


def gains(v: np.ndarray, rng: np.random.Generator, spread: float) -> np.ndarray:
    """Scale every taxel by its own gain."""
    return v * np.maximum(1 + spread * rng.standard_normal(v.shape), 0.05)


def gain_map(side: int, spread: float) -> np.ndarray:
    """Return the gains of the one sensor that `known_gains` is."""
    return np.maximum(1 + spread * np.random.default_rng(side).standard_normal((side, side)), 0.05)


def known_gains(v: np.ndarray, rng: np.random.Generator, spread: float) -> np.ndarray:
    """Scale every taxel by its gain, the same in all frames: one sensor, which somebody can know."""
    del rng
    return v * gain_map(v.shape[1], spread)


def dead_zone(v: np.ndarray, rng: np.random.Generator, below: float) -> np.ndarray:
    """Say nothing of what is less than `below`."""
    del rng
    return np.maximum(v - below, 0.0) / (1 - below)


def logarithm(v: np.ndarray, rng: np.random.Generator, a: float) -> np.ndarray:
    """Respond with the logarithm."""
    del rng
    return np.log1p(a * np.maximum(v, 0.0)) / np.log1p(a)


def power(v: np.ndarray, rng: np.random.Generator, exponent: float) -> np.ndarray:
    """Respond with a power."""
    del rng
    return np.maximum(v, 0.0) ** exponent


def offsets(v: np.ndarray, rng: np.random.Generator, spread: float) -> np.ndarray:
    """Add every taxel's own rest."""
    return v + spread * rng.standard_normal(v.shape)


def slope(v: np.ndarray, rng: np.random.Generator, rise: float) -> np.ndarray:
    """Add a rest that slopes across the pad."""
    n, rows, cols = v.shape
    turn = rng.uniform(0, 2 * np.pi, (n, 1, 1))
    y, x = np.mgrid[:rows, :cols]
    ramp = x * np.cos(turn) + y * np.sin(turn)
    ramp -= ramp.min(axis=(1, 2), keepdims=True)
    return v + rise * ramp / ramp.max(axis=(1, 2), keepdims=True)


def pink(v: np.ndarray, rng: np.random.Generator, spread: float) -> np.ndarray:
    """Add noise whose power falls as one over the spatial frequency."""
    _, rows, cols = v.shape
    wave = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.rfftfreq(cols)[None, :])
    wave[0, 0] = np.inf
    noise = np.fft.irfft2(np.fft.rfft2(rng.standard_normal(v.shape)) / np.sqrt(wave), (rows, cols))
    return v + spread * noise / noise.std(axis=(1, 2), keepdims=True)


def dead(v: np.ndarray, rng: np.random.Generator, share: float) -> np.ndarray:
    """Let single taxels read nothing."""
    return np.where(rng.uniform(size=v.shape) < share, 0.0, v)


def dead_line(v: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Let one row or column through the contact read nothing."""
    out = v.copy()
    for frame in out:
        axis = int(rng.integers(2))
        loaded = np.flatnonzero((frame > 0.1).any(axis=1 - axis))
        line = int(rng.choice(loaded))
        frame[(line, slice(None)) if axis == 0 else (slice(None), line)] = 0.0
    return out


def noise(v: np.ndarray, rng: np.random.Generator, spread: float) -> np.ndarray:
    """Add white noise."""
    return v + spread * rng.standard_normal(v.shape)


def saturated(v: np.ndarray, rng: np.random.Generator, at: float) -> np.ndarray:
    """Read no more than `at`."""
    del rng
    return np.minimum(v, at)


def counts(v: np.ndarray, rng: np.random.Generator, n: int) -> np.ndarray:
    """Round to whole counts."""
    del rng
    return np.round(v * n) / n


def stretch(v: np.ndarray, rng: np.random.Generator, ratio: float) -> np.ndarray:
    """Space the columns `ratio` times as far as thought, so that the contact seems narrower by as much."""
    del rng
    out = np.empty_like(v)
    for k, frame in enumerate(v):
        middle = float(frame.sum(axis=0) @ np.arange(frame.shape[1]) / frame.sum())
        at = middle + ratio * (np.arange(frame.shape[1]) - middle)
        rows = np.arange(frame.shape[0])
        out[k] = ndimage.map_coordinates(frame, np.meshgrid(rows, at, indexing="ij"), order=1, mode="nearest")
    return out / out.max(axis=(1, 2), keepdims=True)
