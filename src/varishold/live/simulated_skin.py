"""A skin that is pressed again and again, by numpy alone: what `sim:` streams.

A bed of independent springs under rigid forms, so that what is pressed is known exactly; with what makes real skins
hard: warmth that shifts all taxels, each by its own share, a walk of each taxel, creep under load, and noise. It is
no measure of how well anything is recognized on a real skin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from varishold.solids import Drawn, draw_contact, ideal_frame

__all__ = ["Press", "SimulatedSkin", "SkinTraits"]

Floats = NDArray[np.float64]

# Points along each side of a taxel over which its reading is the mean.
_POINTS = 4
# Counts of a twelve-bit converter, and the count of a skin that nothing touches.
_FULL_SCALE, _REST = 4095, 200.0
# Counts under a contact as deep as an eighth of the pad's shorter side.
_COUNTS = 1500.0
# Time constants: of creep, of warming up and of the taxels' own walk. Seconds.
_CREEP_S, _WARM_S, _WALK_S = 8.0, 300.0, 600.0
# The slow swing of warmth after that: its share of the drift, and its period in seconds.
_SWING, _SWING_S = 0.3, 1200.0
# Standard deviation of the taxels' shares of the drift, and of their own walk over the drift.
_SHARES, _WALK = 0.25, 0.05
# A contact's longer side as a share of the pad's shorter one, and its depth over its breadth.
_SIZES, _SLOPES = (0.35, 0.6), (0.2, 0.35)
# Seconds that a contact takes to come and to go.
_RAMP_S = 0.15


@dataclass(frozen=True)
class SkinTraits:
    """What a simulated skin is like.

    Parameters
    ----------
    forms : tuple of str
        Keys of `varishold.solids.SOLIDS`; each press draws one of them.
    shape : (int, int)
        Rows and columns.
    pitch_m : float
        Taxel spacing, metres.
    noise : float
        Standard deviation of each reading, counts.
    drift : float
        By how much the skin's readings rise as it warms up, counts.
    creep : float
        By what share a held load's readings grow, in the end.
    moves : float
        Share of the presses that move while they are held.
    hold_s : (float, float)
        The shortest and the longest hold. Seconds.
    rest_s : (float, float)
        The shortest and the longest time between presses. Seconds.
    """

    forms: tuple[str, ...]
    shape: tuple[int, int] = (16, 16)
    pitch_m: float = 2e-3
    noise: float = 4.0
    drift: float = 58.0
    creep: float = 0.12
    moves: float = 0.3
    hold_s: tuple[float, float] = (0.5, 2.5)
    rest_s: tuple[float, float] = (0.6, 1.6)


@dataclass(frozen=True)
class Press:
    """One press: what is true of it.

    Parameters
    ----------
    form : str
        A key of `varishold.solids.SOLIDS`.
    drawn : Drawn
        The solid, where it lies at first, and how deep it goes.
    start_s, hold_s : float
        When it first touches, and how long it is held at its full depth. Seconds.
    motion_m : (float, float)
        How far it moves along x and y while it is held. Metres.
    """

    form: str
    drawn: Drawn
    start_s: float
    hold_s: float
    motion_m: tuple[float, float]

    @property
    def end_s(self) -> float:
        """When it touches no more. Seconds."""
        return self.start_s + self.hold_s + 2 * _RAMP_S

    def depth_at(self, time_s: float) -> float:
        """Return how deep it is pressed in. Metres."""
        since, left = time_s - self.start_s, self.end_s - time_s
        rise = min(max(min(since, left) / _RAMP_S, 0.0), 1.0)
        return self.drawn.depth_m * (0.5 - 0.5 * math.cos(math.pi * rise))

    def place_at(self, time_s: float) -> tuple[float, float]:
        """Return where its middle is, (x, y). Metres from the pad's centre."""
        done = min(max((time_s - self.start_s - _RAMP_S) / self.hold_s, 0.0), 1.0)
        pose = self.drawn.pose
        return pose.x_m + done * self.motion_m[0], pose.y_m + done * self.motion_m[1]


class SimulatedSkin:
    """A skin's frames one after the other; the same traits, rate and seed give the same frames.

    Parameters
    ----------
    traits : SkinTraits
    rate_hz : float
        Frames a second.
    seed : int

    Attributes
    ----------
    time_s : float
        Of the frame that comes next.
    press : Press
        The one that touches now, or touches next.
    """

    def __init__(self, traits: SkinTraits, *, rate_hz: float, seed: int) -> None:
        self._traits = traits
        self._step_s = 1.0 / rate_hz
        self._frame = 0
        self._noise = np.random.default_rng([seed, 0])
        self._chance = np.random.default_rng([seed, 1])
        pad = np.random.default_rng([seed, 2])
        self._share = 1.0 + _SHARES * pad.standard_normal(traits.shape)
        self._phase = float(pad.uniform(0, 2 * math.pi))
        self._walk = np.zeros(traits.shape)
        self._crept = np.zeros(traits.shape)
        self._stiffness = _COUNTS / (min(traits.shape) * traits.pitch_m / 8)
        self._pressed = ((0.0, 0.0, 0.0), np.zeros(traits.shape))
        self.press = self._next_press(0.0)

    @property
    def time_s(self) -> float:
        return self._frame * self._step_s

    def next_frame(self) -> NDArray[np.uint16]:
        """Return the next frame, shape (rows, cols), counts."""
        traits, time_s = self._traits, self.time_s
        if time_s >= self.press.end_s:
            self.press = self._next_press(self.press.end_s)
        load = self._load(time_s)
        self._crept += (load - self._crept) * -math.expm1(-self._step_s / _CREEP_S)
        step = math.exp(-self._step_s / _WALK_S)
        spread = _WALK * traits.drift * math.sqrt(1 - step * step)
        self._walk = step * self._walk + spread * self._noise.standard_normal(traits.shape)
        warmth = -math.expm1(-time_s / _WARM_S) + _SWING * math.sin(2 * math.pi * time_s / _SWING_S + self._phase)
        reading = _REST + load + traits.creep * self._crept + traits.drift * warmth * self._share + self._walk
        reading += traits.noise * self._noise.standard_normal(traits.shape)
        self._frame += 1
        return np.clip(np.rint(reading), 0, _FULL_SCALE).astype(np.uint16)

    def _load(self, time_s: float) -> Floats:
        """Return the counts of the springs that are pressed down, without creep."""
        press = self.press
        where = (press.depth_at(time_s), *press.place_at(time_s))
        if where != self._pressed[0]:
            depth_m, x_m, y_m = where
            load = np.zeros(self._traits.shape)
            if depth_m > 0:
                pose = replace(press.drawn.pose, x_m=x_m, y_m=y_m)
                above_m = ideal_frame(
                    press.drawn.solid,
                    self._traits.shape,
                    self._traits.pitch_m,
                    depth_m=depth_m,
                    pose=pose,
                    per_taxel=_POINTS,
                )
                load = self._stiffness * above_m
            self._pressed = (where, load)
        return self._pressed[1]

    def _next_press(self, after_s: float) -> Press:
        traits, rng = self._traits, self._chance
        form = traits.forms[int(rng.integers(len(traits.forms)))]
        field_m = (traits.shape[0] * traits.pitch_m, traits.shape[1] * traits.pitch_m)
        drawn = draw_contact(
            rng,
            form,
            field_m=field_m,
            size_m=(_SIZES[0] * min(field_m), _SIZES[1] * min(field_m)),
            slope=_SLOPES,
        )
        start_s = after_s + float(rng.uniform(*traits.rest_s))
        hold_s = float(rng.uniform(*traits.hold_s))
        way_m, toward = float(rng.uniform(1.0, 3.0)) * traits.pitch_m, float(rng.uniform(-math.pi, math.pi))
        moves = float(rng.random()) < traits.moves
        motion_m = (way_m * math.cos(toward), way_m * math.sin(toward)) if moves else (0.0, 0.0)
        return Press(form, drawn, start_s, hold_s, motion_m)
