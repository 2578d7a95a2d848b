"""The sensor: one model of what taxels make of stress, forward and back."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._remade import remade
from varishold.errors import InputError
from varishold.frame.checks import MOST_READ, as_given, as_mask
from varishold.frame.fill import fill_invalid
from varishold.sensor.checks import LEAST_GAIN, check_sensor
from varishold.sensor.cover import Skin
from varishold.sensor.positions import Resampling, resampling_of
from varishold.sensor.responses import Linear, Response
from varishold.sensor.spread import Spread, spread_of

__all__ = ["Polarity", "Sensor", "Undone"]

Floats = NDArray[np.float64]
Polarity = Literal["up", "down"]

_LINEAR = Linear()
# Rounding of a reading at saturation may fall short of it by so much.
_ROUNDING = 1e-9
# A point of the grid is saturated where more than this share of its stress comes from saturated taxels.
_SATURATED_SHARE = 0.25


@dataclass(frozen=True, eq=False)
class Undone:
    """A frame without its sensor.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Stress above the dead band, in the sensor's unit. A saturated taxel holds the least that it can have
        felt; a broken one is filled from its neighbours.
    saturated : ndarray of shape (rows, cols), bool
        Where the reading was at saturation: the stress is at least the frame's.
    broken : ndarray of shape (rows, cols), bool
        Where a taxel inside the field was not to be believed.
    beneath : float
        Stress of the dead band: a taxel that felt anything felt this much more than the frame holds.
    """

    frame: Floats
    saturated: NDArray[np.bool_]
    broken: NDArray[np.bool_]
    beneath: float


@dataclass(frozen=True, eq=False)
class Sensor:
    """What is known of a sensor: where its taxels are, and how their readings follow the stress on them.

    With F = `full_scale`, c = `crosstalk`, b = `blur_taxels`, L the Laplacian of the grid of taxels (the four
    neighbours that exist, so that an even stress stays even), d = `dead_band`, g a taxel's gain, R the response
    (odd, R(0) = 0, R(1) = 1) and s = `saturation`, the reading of a stress p is, in this order,

    1. x = p / F
    2. x' = (I - c L) exp(-b^2 L / 2) x     crosstalk to neighbours, and blur
    3. x'' = max(x' - d, 0) / (1 - d)       the dead band
    4. y = min(R(g x''), s)                 gain, response, saturation
    5. raw = rest + span y, or rest - span y where the polarity is "down".

    Parameters
    ----------
    name : str
        What it is called.
    shape : (int, int), optional
        Rows and columns.
    pitch_m : float or (float, float), optional
        Row and column spacing, metres; one number stands for both.
    field : array_like of shape (rows, cols), bool, optional
        False where there is no taxel.
    polarity : {"up", "down"}
        Whether readings go up or down with stress.
    rest : float or array_like of shape (rows, cols)
        Reading without load.
    span : float, optional
        Reading at full scale, counted from rest. Default: `full_scale`, or 1.
    full_scale : float, optional
        Stress at full scale, in `unit`. Default: `span`, or 1, so that stresses are in units of the reading.
    unit : str
        Unit of the stress; "raw" where it is unknown. Readings themselves have none.
    response : Response
        One of `varishold.sensor.RESPONSES`.
    gains : array_like of shape (rows, cols), optional
        Sensitivity of each taxel beside the usual one. 0 or NaN marks a broken taxel.
    dead_band : float
        Share of full scale that is not felt, in [0, .9].
    saturation : float, optional
        Reading, as a share of `span`, above which readings do not go.
    crosstalk : float
        Share of a taxel's stress that reaches each of its four neighbours, in [0, .2].
    blur_taxels : float
        Standard deviation of a Gaussian blur, in taxels, in [0, 4].
    positions_m : array_like of shape (n_taxels, 2), optional
        (x, y) of each taxel in metres, where they stand on no grid; frames are then one row of
        readings, and `shape`, `field`, `crosstalk` and `blur_taxels` are not for it.
    cover : Skin, optional
        The elastic skin over the taxels.
    third_party : bool
        Whether what is known comes from somebody else than the maker.
    notes : str
        Anything a person should know.
    calibration : mapping of str to plain values
        How it was measured, as `varishold sensor calibrate` writes it.
    source : str
        The file it was read from; may be empty.

    Raises
    ------
    InputError
        If a value is out of its range, or they do not fit together.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.sensor import Logarithmic, Sensor
    >>> mat = Sensor(response=Logarithmic(5.0), span=1023, polarity="down", rest=1023)
    >>> raw = mat.forward(np.array([[102.3, 511.5, 1023.0]]))
    >>> raw.round(1).tolist()
    [[791.5, 307.7, 0.0]]
    >>> mat.undo(raw).frame.round(1).tolist()
    [[102.3, 511.5, 1023.0]]
    """

    name: str = ""
    shape: tuple[int, int] | None = None
    pitch_m: tuple[float, float] | None = None
    field: NDArray[np.bool_] | None = None
    polarity: Polarity = "up"
    rest: float | Floats = 0.0
    span: float = None  # type: ignore[assignment]
    full_scale: float = None  # type: ignore[assignment]
    unit: str = "raw"
    response: Response = _LINEAR
    gains: Floats | None = None
    dead_band: float = 0.0
    saturation: float | None = None
    crosstalk: float = 0.0
    blur_taxels: float = 0.0
    positions_m: Floats | None = None
    cover: Skin | None = None
    third_party: bool = False
    notes: str = ""
    calibration: Mapping[str, Any] = dataclasses.field(default_factory=lambda: MappingProxyType({}))
    source: str = ""

    def __post_init__(self) -> None:
        for name, value in check_sensor(self).items():
            object.__setattr__(self, name, value)

    __reduce__ = remade

    @property
    def readings_shape(self) -> tuple[int, int] | None:
        """Rows and columns of the readings: one row where the taxels stand on no grid; None where unknown."""
        return (1, self.positions_m.shape[0]) if self.positions_m is not None else self.shape

    @cached_property
    def resampling(self) -> Resampling | None:
        """How taxels on no grid become a frame; None where they stand on one."""
        if self.positions_m is None:
            return None
        try:
            return resampling_of(self.positions_m, self.pitch_m)
        except InputError as error:
            raise InputError(f"{self.source}: {error}" if self.source else str(error)) from None

    @cached_property
    def broken(self) -> NDArray[np.bool_] | None:
        """Where a taxel's gain says that it is broken; of the readings' shape, None where no gain does."""
        if self.gains is None:
            return None
        broken: NDArray[np.bool_] = ~(self.gains >= LEAST_GAIN)
        if self.field is not None:
            broken &= self.field
        return broken if broken.any() else None

    def upright(self) -> Sensor:
        """Return this sensor as it is once its rest is taken off and its readings go up."""
        return dataclasses.replace(self, polarity="up", rest=0.0)

    def forward(self, stress: ArrayLike) -> Floats:
        """Return the readings of a stress.

        Parameters
        ----------
        stress : array_like of shape (..., rows, cols)
            In the sensor's unit; with `positions_m`, of shape (..., 1, n_taxels).

        Returns
        -------
        ndarray of the same shape, float64
            A broken taxel reads its rest.

        Raises
        ------
        InputError
            If the shape is not the sensor's.
        """
        x = self._frames(stress, "stress") / self.full_scale
        spread = self._spread(x.shape[-2:])
        if spread is not None:
            x = spread.mix(x)
        if self.dead_band:
            x = np.maximum(x - self.dead_band, 0.0) / (1.0 - self.dead_band)
        if self.gains is not None:
            x = x * np.where(self.gains >= LEAST_GAIN, self.gains, 0.0)
        y = self.response.reading(x)
        if self.saturation is not None:
            y = np.minimum(y, self.saturation)
        return self.rest + (self.span * y if self.polarity == "up" else -self.span * y)

    def stress(self, raw: ArrayLike, *, broken: NDArray[np.bool_] | None = None) -> Floats:
        """Return the stress above the dead band that readings stand for: the inverse of `forward`.

        It is exact where nothing was lost: above the dead band, below saturation, on taxels that
        work, under crosstalk and blur of which a quarter of every pattern is left.

        Parameters
        ----------
        raw : array_like of shape (..., rows, cols)
            Readings; with `positions_m`, of shape (..., 1, n_taxels).
        broken : ndarray of shape (rows, cols), bool, optional
            Taxels that are not to be believed, filled from their neighbours; with `positions_m`, of shape
            (1, n_taxels). Default: those of the gain map.

        Returns
        -------
        ndarray of the same shape, float64
            Noise about rest stays noise about zero.
        """
        readings = self._frames(raw, "readings")
        bad = self.broken if broken is None else as_mask(broken, readings.shape[-2:], "broken")
        return self._stress(self._above(readings), bad)

    def undo(self, raw: ArrayLike, *, valid: NDArray[np.bool_] | None = None) -> Undone:
        """Return what one frame of readings stands for.

        Parameters
        ----------
        raw : array_like of shape (rows, cols)
            Readings; with `positions_m`, of shape (n_taxels,) or (1, n_taxels).
        valid : ndarray of the readings' shape, bool, optional
            False where a taxel is broken, beside those of the gain map.

        Returns
        -------
        Undone
            On the grid of `resampling` where the taxels stand on none.

        Raises
        ------
        InputError
            If the shape is not the sensor's, or every taxel is broken.
        """
        given = as_given(raw, "readings must be numbers of shape (rows, cols)")
        if self.positions_m is not None and given.ndim == 1:
            given = given[None]
        values = self._frames(given, "readings")
        if values.ndim != 2:
            raise InputError(f"one frame of readings must have shape (rows, cols), got {values.shape}")
        broken = self._all_broken(values, None if valid is None else as_mask(valid, values.shape, "valid"))
        above = self._above(values)
        saturated = np.zeros(values.shape, np.bool_)
        if self.saturation is not None:
            # Half a count, as a share of the span, where readings are whole numbers.
            half_step = 0.5 / self.span if given.dtype.kind in "iu" and self.span > 1 else 0.0
            saturated = above / self.span >= self.saturation * (1.0 - _ROUNDING) - half_step
        frame = self._stress(above, broken)
        if broken is None:
            broken = np.zeros(values.shape, np.bool_)
        saturated &= ~broken
        if self.resampling is not None:
            frame = self.resampling.frame(frame)
            saturated = self.resampling.share(saturated) > _SATURATED_SHARE
            broken = self.resampling.share(broken) > _SATURATED_SHARE
        return Undone(frame, saturated, broken, self.dead_band * self.full_scale)

    @property
    def tells_saturation(self) -> bool:
        """Whether it says itself where readings end, or its taxels are seen as others, which know it of them."""
        return self.saturation is not None or self.resampling is not None

    def beyond(self, raw: ArrayLike) -> NDArray[np.bool_]:
        """Return which readings stand for no number, so far are they from rest behind a bent response.

        Parameters
        ----------
        raw : array_like of shape (..., rows, cols)

        Returns
        -------
        ndarray of the same shape, bool
        """
        above = self._above(self._frames(raw, "readings"))
        # What a sensor can read is within its span.
        if not np.abs(above).max(initial=0.0) > self.span:
            return np.zeros(above.shape, np.bool_)
        beyond: NDArray[np.bool_] = np.abs(self._response_undone(above, 1.0)) > MOST_READ
        return beyond

    def least_stress(self, reading: float) -> float:
        """Return the stress that a reading of so much above rest stands for; noise, for instance.

        Undoing crosstalk and blur raises noise, and so does an uneven gain: it is counted.
        """
        share = min(float(self._response_undone(np.array([reading]), 1.0)[0]), MOST_READ)
        gains = self.gains
        if gains is not None:
            share /= np.sqrt(1.0 / np.mean(1.0 / gains[gains >= LEAST_GAIN] ** 2))
        spread = None if self.readings_shape is None else self._spread(self.readings_shape)
        loudness = 1.0 if spread is None else spread.loudness
        return float(share) * (1.0 - self.dead_band) * self.full_scale * loudness

    def _above(self, raw: Floats) -> Floats:
        """Return how far readings stand above rest, in the direction of the polarity; none is above saturation."""
        above = raw - self.rest if self.polarity == "up" else self.rest - raw
        return above if self.saturation is None else np.minimum(above, self.saturation * self.span)

    def _stress(self, above: Floats, broken: NDArray[np.bool_] | None) -> Floats:
        full = (1.0 - self.dead_band) * self.full_scale
        x = self._finite_stress(above, full, broken)
        if self.gains is not None:
            x = x / np.where(self.gains >= LEAST_GAIN, self.gains, 1.0)
        if not isinstance(self.response, Linear):
            x = x * full
        if broken is not None:
            x = self._filled(x, broken)
        spread = self._spread(x.shape[-2:])
        return x if spread is None else spread.undo(x)

    def _finite_stress(self, above: Floats, full: float, broken: NDArray[np.bool_] | None) -> Floats:
        """Return the stress of readings above rest; 0 where a taxel is broken, and no number can be had."""
        x = self._response_undone(above, full)
        wild = np.abs(x) > MOST_READ
        if not wild.any():
            return x
        believed = wild if broken is None else wild & ~broken
        if believed.any():
            *_, row, col = at = tuple(np.argwhere(believed)[0].tolist())
            raise InputError(
                f"the reading at (row, col) = ({row}, {col}) is {above[at] / self.span:g} times the span: behind a "
                f"{self.response.kind} response that is beyond all numbers; give the right span or saturation, or mark "
                "the taxel as broken in valid"
            )
        return np.where(wild, 0.0, x)

    def _response_undone(self, above: Floats, full: float) -> Floats:
        """Return the stress of readings above rest, gains apart.

        Counts that it is proportional to are multiplied once, by `full` too: whole ones often stay whole, and so do
        their sums.
        """
        with np.errstate(over="ignore"):
            if isinstance(self.response, Linear):
                return above * (full / self.span)
            return self.response.stress(above / self.span)

    def _filled(self, x: Floats, broken: NDArray[np.bool_]) -> Floats:
        if self.resampling is not None:
            return self.resampling.filled(x, broken.reshape(-1))
        frames = x.reshape(-1, *x.shape[-2:])
        return np.array([fill_invalid(frame, ~broken, self.field) for frame in frames]).reshape(x.shape)

    def _all_broken(self, values: Floats, valid: NDArray[np.bool_] | None) -> NDArray[np.bool_] | None:
        broken = self.broken
        if valid is not None:
            broken = ~valid if broken is None else broken | ~valid
            if self.field is not None:
                broken = broken & self.field
        return broken if broken is not None and broken.any() else None

    def _spread(self, shape: tuple[int, ...]) -> Spread | None:
        if not (self.crosstalk or self.blur_taxels):
            return None
        return spread_of((int(shape[0]), int(shape[1])), self.field, self.crosstalk, self.blur_taxels)

    def _frames(self, values: ArrayLike, what: str) -> Floats:
        must = f"{what} must be numbers of shape (..., rows, cols)"
        frames = as_given(values, must)
        if frames.dtype.kind not in "biuf" or frames.ndim < 2 or 0 in frames.shape:
            raise InputError(f"{must}, got {frames.dtype} {frames.shape}")
        expected = self.readings_shape
        if expected is not None and frames.shape[-2:] != expected:
            raise InputError(
                f"{what} must have the shape of the sensor{' ' + self.name if self.name else ''}, "
                f"{expected[0]} x {expected[1]}, got {frames.shape[-2]} x {frames.shape[-1]}"
            )
        return frames.astype(np.float64)
