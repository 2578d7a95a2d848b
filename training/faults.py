"""Drawn sensors: what a real array makes of a clean frame, drawn at random."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Families of faults, each with the weight at which it is drawn.
FAMILIES: dict[str, float] = {
    "gain": 2.1,
    "power": 1.0,
    "logarithm": 1.3,
    "saturation": 1.7,
    "crosstalk": 1.0,
    "blur": 0.8,
    "offset": 1.0,
    "slope": 0.7,
    "dead zone": 1.6,
    "counts": 0.9,
    "dead": 1.1,
    "line": 0.9,
    "ghost": 1.0,
    "memory": 2.1,
    "pink": 0.9,
}
_POWER, _LOGARITHM, _SATURATED, _SQUASHED = 0, 1, 2, 3


@dataclass(frozen=True)
class DrawnSensor:
    """One array with its faults; every fault is off by default. Lengths in taxels, readings as shares of full scale.

    Parameters
    ----------
    noise : float
        Standard deviation of white noise.
    pink : float
        Standard deviation of noise whose amplitude falls as one over frequency.
    gain : float
        Spread of the taxels' gains around 1.
    line_gain : float
        Spread of the gains of whole rows and columns.
    weak : float
        Share of taxels at about a third of their gain.
    power : float
        Exponent of the response.
    logarithm : float
        a of the response log(1 + a v) / log(1 + a); 0 for none.
    saturation : float
        Reading beyond which there is none.
    soft : float
        Sharpness of the saturation: 0 for a clip, else the share over which it bends.
    crosstalk : float
        Share that leaks into each of four neighbours.
    blur : float
        Standard deviation of a Gaussian blur.
    offset : float
        Standard deviation of the taxels' own offsets.
    line_offset : float
        Standard deviation of the offsets of rows and columns.
    slope : float
        Rise of the rest over the pad; `bias` is where the rest stands.
    bias : float
        Reading at rest.
    dead_zone : float
        Reading below which a taxel shows nothing; `shifted` takes it off the rest.
    shifted : bool
        Whether readings above the dead zone begin at zero.
    zone_first : bool
        Whether the dead zone lies before the response, as that of a gap under a cover does, or after it.
    counts : float
        Steps of full scale; 0 for no rounding.
    dead : float
        Share of taxels that read nothing.
    dead_lines : int
        Rows or columns that read nothing.
    ghost : float
        Strength of ghosts along rows and columns, and `ghost_kind` how they come about.
    memory : float
        Share of the last press that is still there.
    clipped : bool
        Whether readings below zero are zero.
    """

    noise: float = 0.0
    pink: float = 0.0
    gain: float = 0.0
    line_gain: float = 0.0
    weak: float = 0.0
    power: float = 1.0
    logarithm: float = 0.0
    saturation: float = np.inf
    soft: float = 0.0
    crosstalk: float = 0.0
    blur: float = 0.0
    offset: float = 0.0
    line_offset: float = 0.0
    slope: float = 0.0
    bias: float = 0.0
    dead_zone: float = 0.0
    shifted: bool = True
    zone_first: bool = False
    counts: float = 0.0
    dead: float = 0.0
    dead_lines: int = 0
    ghost: float = 0.0
    ghost_kind: int = 0
    memory: float = 0.0
    clipped: bool = False
    families: tuple[str, ...] = field(default=())

    def read(self, rng: np.random.Generator, clean: Array, last: Array | None = None) -> Array:
        """Return what the array reports of a clean frame whose peak is 1, after `last` was pressed."""
        v = clean
        shape = clean.shape
        if self.memory and last is not None:
            v = v + self.memory * last
        if self.blur:
            v = blurred(v, self.blur)
        if self.crosstalk:
            v = _leaked(v, self.crosstalk)
        gains = _gains(rng, shape, self)
        before = rng.random() < 0.5
        if gains is not None and before:
            v = v * gains
        if self.ghost:
            v = v + self.ghost * _ghosts(v, self.ghost_kind)
        peak = max(float(v.max()), 1e-12)
        # A response is a property of the taxels: it is drawn against the pressure of this press.
        v = np.maximum(v / peak, 0.0)
        if self.zone_first:
            v = _beyond_zone(v, self)
        v = _response(v, self)
        if gains is not None and not before:
            v = v * gains
        if not self.zone_first:
            v = _beyond_zone(v, self)
        rest = np.zeros(shape)
        if self.offset:
            rest = rest + self.offset * rng.standard_normal(shape)
        if self.line_offset:
            rest = (
                rest
                + self.line_offset * (rng.standard_normal((shape[0], 1)) + rng.standard_normal((1, shape[1]))) / 1.4
            )
        if self.slope:
            rest = rest + _slope(rng, shape, self.slope)
        v = v + rest + self.bias
        if self.pink:
            v = v + self.pink * _pink(rng, shape)
        if self.noise:
            v = v + rng.normal(0.0, self.noise, shape)
        if self.clipped:
            v = np.maximum(v, 0.0)
        if np.isfinite(self.saturation):
            v = np.minimum(v, self.saturation * (1.0 if self.soft == 0.0 else 1.0 + self.soft))
        if self.counts:
            full = max(float(v.max()), 1e-12)
            v = np.round(v / full * self.counts) / self.counts * full
        if self.dead or self.dead_lines:
            v = _killed(rng, v, self)
        return v


def _beyond_zone(v: Array, sensor: DrawnSensor) -> Array:
    if not sensor.dead_zone:
        return v
    return np.maximum(v - sensor.dead_zone, 0.0) if sensor.shifted else np.where(v > sensor.dead_zone, v, 0.0)


def _response(v: Array, sensor: DrawnSensor) -> Array:
    if sensor.power != 1.0:
        v = v**sensor.power
    if sensor.logarithm:
        v = np.log1p(sensor.logarithm * v) / np.log1p(sensor.logarithm)
    if np.isfinite(sensor.saturation) and sensor.soft:
        # Bends over instead of breaking off.
        n = 1.0 / sensor.soft
        v = v / (1.0 + (v / sensor.saturation) ** n) ** (1.0 / n)
    return v


def _gains(rng: np.random.Generator, shape: tuple[int, ...], sensor: DrawnSensor) -> Array | None:
    if not (sensor.gain or sensor.line_gain or sensor.weak):
        return None
    kind = rng.random()
    if kind < 0.6:
        gains = 1.0 + sensor.gain * rng.standard_normal(shape)
    elif kind < 0.8:
        gains = np.exp(sensor.gain * rng.standard_normal(shape))
    else:
        gains = 1.0 + sensor.gain * np.sqrt(3.0) * rng.uniform(-1, 1, shape)
    if sensor.line_gain:
        lines = rng.standard_normal((shape[0], 1)) + rng.standard_normal((1, shape[1]))
        gains = gains * (1.0 + sensor.line_gain * lines / 1.4)
    if sensor.weak:
        gains = np.where(rng.random(shape) < sensor.weak, gains * rng.uniform(0.2, 0.5), gains)
    return np.maximum(gains, 0.0)


def blurred(v: Array, sigma: float) -> Array:
    """Return a frame blurred by a Gaussian, its border held."""
    reach = max(1, int(np.ceil(3 * sigma)))
    at = np.arange(-reach, reach + 1)
    weight = np.exp(-0.5 * (at / sigma) ** 2)
    weight /= weight.sum()
    for axis in (0, 1):
        padded = np.pad(v, [(reach, reach) if k == axis else (0, 0) for k in (0, 1)], mode="edge")
        n = v.shape[axis]
        v = sum(w * (padded[i : i + n] if axis == 0 else padded[:, i : i + n]) for i, w in enumerate(weight))  # type: ignore[assignment]
    return v


def _leaked(v: Array, share: float) -> Array:
    padded = np.pad(v, 1)
    around = padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:]
    return (1.0 - 4.0 * share) * v + share * around


def _ghosts(v: Array, kind: int) -> Array:
    row, col = v.mean(axis=1, keepdims=True), v.mean(axis=0, keepdims=True)
    if kind == 0:
        ghost = row + col
    elif kind == 1:
        ghost = row * col
    elif kind == 2:
        ghost = np.sqrt(np.maximum(row * col, 0.0))
    else:
        ghost = np.maximum(v.max(axis=1, keepdims=True) * row.max(), 0.0) + v.max(axis=0, keepdims=True) * col.max()
    top = float(ghost.max())
    return ghost / top if top > 0 else ghost


def _slope(rng: np.random.Generator, shape: tuple[int, ...], rise: float) -> Array:
    angle = rng.uniform(-np.pi, np.pi)
    y, x = np.meshgrid(np.linspace(-0.5, 0.5, shape[0]), np.linspace(-0.5, 0.5, shape[1]), indexing="ij")
    plane = np.cos(angle) * x + np.sin(angle) * y
    plane *= rise / max(float(np.ptp(plane)), 1e-9)
    if rng.random() < 0.15:
        # Some rests sag rather than slope.
        plane = plane + rise * rng.uniform(-0.6, 0.6) * (x * x + y * y)
    return plane - plane.min() * rng.choice([0.0, 1.0])


def _pink(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    white = np.fft.rfft2(rng.standard_normal(shape))
    fy, fx = np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])[None, :]
    f = np.hypot(fy, fx)
    f[0, 0] = np.inf
    noise = np.fft.irfft2(white / f ** rng.uniform(0.7, 1.2), s=shape)
    return np.asarray(noise / max(float(noise.std()), 1e-12))


def _killed(rng: np.random.Generator, v: Array, sensor: DrawnSensor) -> Array:
    rows, cols = v.shape
    gone = rng.random(v.shape) < sensor.dead
    for _ in range(sensor.dead_lines):
        if rng.random() < rows / (rows + cols):
            gone[int(rng.integers(rows))] = True
        else:
            gone[:, int(rng.integers(cols))] = True
    if rng.random() < 0.4:
        # A lost wire may float: it shows the noise.
        return np.where(gone, sensor.bias + rng.normal(0.0, max(sensor.noise, 1e-3), v.shape), v)
    return np.where(gone, 0.0, v)


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _one_fault(rng: np.random.Generator, family: str, most: float) -> dict[str, float | int | bool]:
    """Return the settings of one fault; `most` shrinks it where several come together."""
    draws: dict[str, Callable[[], dict[str, float | int | bool]]] = {
        "gain": lambda: _gain_fault(rng, most),
        "power": lambda: {"power": _power(rng, most)},
        "logarithm": lambda: {"logarithm": _between(rng, 0.5, 12.0) * most},
        "saturation": lambda: {
            "saturation": 1.0 - most * rng.uniform(0.05, 0.55),
            "soft": rng.uniform(0.05, 0.3) if rng.random() < 0.3 else 0.0,
        },
        "crosstalk": lambda: {"crosstalk": most * _between(rng, 0.01, 0.16)},
        "blur": lambda: {"blur": most * _between(rng, 0.3, 2.0)},
        "offset": lambda: (
            {"offset": most * _between(rng, 0.01, 0.10)}
            if rng.random() < 0.7
            else {"offset": most * _between(rng, 0.005, 0.05), "line_offset": most * _between(rng, 0.01, 0.06)}
        ),
        "slope": lambda: {
            "slope": most * _between(rng, 0.03, 0.35),
            "bias": float(rng.choice([0.0, rng.uniform(0, 0.5)])),
        },
        "dead zone": lambda: {
            "dead_zone": most * _between(rng, 0.03, 0.42),
            "shifted": bool(rng.random() < 0.6),
            "zone_first": bool(rng.random() < 0.5),
        },
        "counts": lambda: {"counts": float(np.round(_between(rng, 5.0, 120.0)))},
        "dead": lambda: {"dead": most * _between(rng, 0.01, 0.09)},
        "line": lambda: {"dead_lines": 2 if rng.random() < 0.2 * most else 1},
        "ghost": lambda: {"ghost": most * _between(rng, 0.02, 0.25), "ghost_kind": int(rng.integers(4))},
        "memory": lambda: {"memory": most * _between(rng, 0.04, 0.4)},
        "pink": lambda: {"pink": most * _between(rng, 0.01, 0.09)},
    }
    return draws[family]()


def _power(rng: np.random.Generator, most: float) -> float:
    """Return an exponent between 1/2 and 2, a little more often far from 1 than near it."""
    away = rng.uniform(0.0, 1.0) ** 0.7 * np.log(2.15) * most
    return float(np.exp(away * rng.choice([-1, 1])))


def _gain_fault(rng: np.random.Generator, most: float) -> dict[str, float | int | bool]:
    gains: dict[str, float | int | bool] = {"gain": most * _between(rng, 0.02, 0.33)}
    if rng.random() < 0.15:
        gains["line_gain"] = most * _between(rng, 0.02, 0.15)
    if rng.random() < 0.15:
        gains["weak"] = rng.uniform(0.002, 0.03)
    return gains


def _ordinary(rng: np.random.Generator) -> dict[str, float | int | bool]:
    """Return the faults that every array has at once, each of them mild."""
    return {
        "crosstalk": rng.uniform(0.02, 0.11),
        "gain": rng.uniform(0.01, 0.08),
        "pink": rng.uniform(0.005, 0.065),
        "counts": float(np.round(_between(rng, 60.0, 1000.0))),
    }


def _poor(rng: np.random.Generator) -> dict[str, float | int | bool]:
    """Return the faults of a cheap resistive array, all at once."""
    return {
        "crosstalk": rng.uniform(0.02, 0.11),
        "gain": rng.uniform(0.03, 0.14),
        "dead_zone": rng.uniform(0.03, 0.2),
        "shifted": True,
        "zone_first": bool(rng.random() < 0.7),
        "logarithm": _between(rng, 1.0, 12.0),
        "counts": float(np.round(_between(rng, 25.0, 250.0))),
    }


#: The families of the faults that every array has at once.
ORDINARY = ("crosstalk", "gain", "pink", "counts")
# Kinds of arrays: the chance of each, what it has, and the families that these are.
_ARRAYS: tuple[tuple[float, Callable[[np.random.Generator], dict[str, float | int | bool]], tuple[str, ...]], ...] = (
    (0.15, _ordinary, ORDINARY),
    (0.07, _poor, ("crosstalk", "gain", "dead zone", "logarithm", "counts")),
)


def draw_sensor(
    rng: np.random.Generator,
    noise: tuple[float, float],
    *,
    chances: tuple[float, float, float, float] = (0.22, 0.43, 0.20, 0.15),
    arrays: bool = True,
    uneven: float = 0.0,
    without: str = "",
) -> DrawnSensor:
    """Draw a sensor: a usual kind of array, or else one with faults by chance.

    `chances` are those of no fault but noise, of one, of two, and of three to six that are mostly milder.

    Parameters
    ----------
    rng : numpy.random.Generator
    noise : (float, float)
        Range of white noise, as a share of full scale.
    chances : tuple of four floats
    arrays : bool
        Whether usual kinds of arrays are among them.
    uneven : float
        Share of the sensors with no fault of gains whose gains are a little unequal all the same.
    without : str
        A family that is left out, to see how names do on what was never learned.
    """
    names = [name for name in FAMILIES if name != without]
    weight = np.array([FAMILIES[name] for name in names])
    kind = rng.random()
    for chance, array, families in _ARRAYS:
        if arrays and kind < chance and without not in families:
            return _with_noise(rng, noise, array(rng), families)
        kind -= chance
    choice = int(rng.choice(4, p=chances))
    count = choice if choice < 3 else int(rng.integers(3, 7))
    most = (1.0, 1.0, 0.9, float(rng.uniform(0.35, 1.0)))[choice]
    families = tuple(str(f) for f in rng.choice(names, size=count, replace=False, p=weight / weight.sum()))
    settings: dict[str, float | int | bool] = {}
    for family in families:
        settings |= _one_fault(rng, family, most)
    if uneven and without != "gain" and "gain" not in settings and rng.random() < uneven:
        settings["gain"] = _between(rng, 0.01, 0.12)
    return _with_noise(rng, noise, settings, families)


def _with_noise(
    rng: np.random.Generator,
    noise: tuple[float, float],
    settings: dict[str, float | int | bool],
    families: tuple[str, ...],
) -> DrawnSensor:
    settings["noise"] = _between(rng, *noise)
    settings["clipped"] = bool(rng.random() < 0.15)
    if "bias" not in settings and rng.random() < 0.04:
        settings["bias"] = rng.uniform(0.0, 0.6)
    return DrawnSensor(**settings, families=families)  # type: ignore[arg-type]
