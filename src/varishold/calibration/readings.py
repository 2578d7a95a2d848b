"""The presses of a calibration: one frame each, above rest, from recordings that are fit for it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError, require_a
from varishold.frame import recording_noise
from varishold.recording import Pad, Recording, presses
from varishold.sensor import Sensor, upright_recording

__all__ = ["Presses", "presses_of"]

Floats = NDArray[np.float64]

# A press's frame is the mean of the frames in which it is held: their load is less than its largest by no more than
# this share of it, or by so many sigma of its noise, which may be this share at most.
_HOLDS, _HOLD_SIGMAS, _MOST_SLACK = 0.02, 3.0, 0.5
# Frames that follow one another and are less alike than this are two presses, but for what is no more than this share
# of the load that it grows to or comes from.
_ALIKE, _SKIRT = 0.9, 0.6
# Unloaded frames that a rest needs, and that are needed at either end of a recording to see it move.
_FEWEST_QUIET, _FEWEST_AT_END = 3, 4
# So many times the standard error of a mean is that of a median.
_OF_A_MEDIAN = 1.25
# The rest has moved where so many taxels (share, and at least two) moved by more than so many standard errors and
# than this share of the presses' peak; where light presses stand for rests, so many taxels.
_MOVED_TAXELS, _MOVED_SIGMAS, _MOVED_SHARE, _MOVED_PAD = 0.05, 5.0, 0.03, 0.5
# An end that reads this share of a press on the mean of the pad is one that is held.
_HELD = 0.6
# Taxels that are compared with each other.
_FEWEST_TAXELS = 2
# Readings have ended where so many taxels, and this share of the pad, are at the highest one, and so many times as many
# as at the next lower one.
_FEWEST_ENDED, _ENDED, _PILED = 5, 0.02, 4


@dataclass(frozen=True, eq=False)
class Presses:
    """Presses on one pad.

    Parameters
    ----------
    frames : ndarray of shape (n_presses, rows, cols), float64
        Readings above rest.
    noise : ndarray of shape (n_presses,), float64
        Standard deviation of the noise of each.
    recording : ndarray of shape (n_presses,), int
        Which of the recordings each is from.
    usable : ndarray of shape (rows, cols), bool
        Where there is a taxel, and nobody has marked it broken.
    rest : ndarray of shape (rows, cols), float64 or None
        What the taxels read without load, above the rest that was known; None where no frame shows it.
    pitch_m : (float, float) or None
    notes : tuple of str
    sources : tuple of str
        What each of the recordings is called.
    rest_noise : ndarray of shape (n_recordings,), float64 or None
        Standard deviation of the noise of each recording's rest, which all of its presses are counted from; 0 where
        it is taken as known. None where all are.
    """

    frames: Floats
    noise: Floats
    recording: NDArray[np.intp]
    usable: NDArray[np.bool_]
    rest: Floats | None
    pitch_m: tuple[float, float] | None
    notes: tuple[str, ...]
    sources: tuple[str, ...]
    rest_noise: Floats | None = None

    @property
    def n(self) -> int:
        return int(self.frames.shape[0])

    def where(self, press: int) -> str:
        """Return the file of a press, and which it is there."""
        here = self.recording[press]
        return f"{self.sources[here]}: press {int(np.count_nonzero(self.recording[:press] == here))}"

    def rest_of(self, known: Sensor) -> float | Floats:
        """Return the rest of the raw readings: what was known, and what unloaded frames add to it."""
        if self.rest is None:
            return known.rest
        return known.rest + (self.rest if known.polarity == "up" else -self.rest)

    def sensor_with(self, known: Sensor, **measured: Any) -> Sensor:
        """Return what is known of the sensor, with what was measured: by these presses, its shape and its rest too."""
        told: dict[str, Any] = {
            "shape": self.usable.shape,
            "pitch_m": known.pitch_m or self.pitch_m,
            "rest": self.rest_of(known),
            "source": "",
        }
        return replace(known, **{**told, **measured})


def presses_of(
    recordings: Sequence[Recording], sensor: Sensor, *, pad: str | None = None, most_ended: float = 0.5
) -> Presses:
    """Return the presses of recordings of one pad.

    Parameters
    ----------
    recordings : sequence of Recording
        Raw readings.
    sensor : Sensor
        What is known of the sensor: its rest and polarity are undone.
    pad : str, optional
        Which pad; needed where a recording has several.
    most_ended : float
        The largest share of presses that may hold many saturated taxels.

    Raises
    ------
    InputError
        If there is no press, shapes or units differ, a rest moves, or too many presses hold readings at their end.
    """
    frames: list[Floats] = []
    noise: list[float] = []
    which: list[int] = []
    notes: list[str] = []
    rests: list[Floats] = []
    rest_noise: list[float] = []
    ended: list[str] = []
    usable: NDArray[np.bool_] | None = None
    _check_given(recordings, sensor)
    pitch = sensor.pitch_m
    for number, recording in enumerate(recordings):
        source = recording.source or f"recording {number}"
        turned = upright_recording(_only(recording, pad, source), sensor)
        (here,) = turned.pads.values()
        if here.positions_m is not None or sensor.positions_m is not None:
            raise InputError(
                f"{source}: taxels on no grid cannot be calibrated yet; calibrate them on an even pressure"
                " by hand and write their gain_map"
            )
        _check_one_sensor(here, recording, source, None if usable is None else usable.shape, recordings[0].unit)
        usable = here.usable if usable is None else usable & here.usable
        pitch = here.pitch_m or pitch
        loaded = presses(turned)
        if not loaded:
            raise InputError(f"{source}: no press found: the total never rises above its noise")
        _check_changes(here, source)
        sigma = recording_noise(here.frames, here.field, here.valid)
        rest, noise_of_rest = _rest(here, loaded, sigma, source)
        rest_noise.append(noise_of_rest)
        runs = [part for run in loaded for part in _pressed(here, _parts(here, run, rest), rest, sigma)]
        if rest is None:
            notes.append(f"{source}: no unloaded frame: its rest is taken as known")
        else:
            rests.append(rest)
        on = here.usable
        held = [
            _held_frames(here, run, rest, sigma, f"{source}: press {len(frames) + k}") for k, run in enumerate(runs)
        ]
        # What reads high unpressed, as a taxel that sticks does, is no end of the others.
        highest = max(float(values[:, on][above[:, on] > 0].max(initial=0.0)) for values, above in held)
        exact = sigma == 0 and any(values[:, on].min() == values[:, on].max() < highest for values, _ in held)
        for values, above in held:
            words = _ended(values[:, on], highest, exact=exact)
            ended += [] if words is None else [f"{source}: press {len(frames)}: {words}"]
            frames.append(above.mean(axis=0))
            noise.append(sigma / np.sqrt(len(values)))
            which.append(number)
    if len(ended) > most_ended * len(frames):
        raise InputError(f"{ended[0]} are saturated, and nothing can be told of them; press less")
    if usable is None:
        raise InputError("a calibration needs at least one recording, got none")
    return Presses(
        np.array(frames),
        np.array(noise),
        np.array(which),
        usable,
        np.mean(rests, axis=0) if rests else None,
        pitch,
        tuple(notes),
        tuple(each.source or f"recording {number}" for number, each in enumerate(recordings)),
        np.array(rest_noise),
    )


def _check_given(recordings: Any, sensor: Any) -> None:
    """Refuse other things than recordings and a sensor."""
    require_a(Sensor, sensor, "sensor", "as read_sensor(path) gives it")
    if not isinstance(recordings, list | tuple):
        raise InputError(f"recordings must be a list of Recording, got {type(recordings).__name__}")
    wrong = [each for each in recordings if not isinstance(each, Recording)]
    if wrong:
        raise InputError(f"recordings must be a list of Recording, got {type(wrong[0]).__name__} in it")


def _check_one_sensor(pad: Pad, recording: Recording, source: str, shape: tuple[int, ...] | None, unit: str) -> None:
    """Refuse readings in another unit, or of another pad, than those of the recordings before."""
    if recording.unit != unit:
        raise InputError(
            f"{source}: readings are in {recording.unit}, in the recordings before in {unit}; give one unit"
        )
    if shape is not None and pad.shape != shape:
        raise InputError(
            f"{source}: has {pad.shape[0]} x {pad.shape[1]} taxels, the recordings before "
            f"{shape[0]} x {shape[1]}; calibrate one sensor at a time"
        )


def _check_changes(pad: Pad, source: str) -> None:
    """Refuse what tells nothing of taxels beside each other: a single one, and readings that never change."""
    if np.count_nonzero(pad.usable) < _FEWEST_TAXELS:
        raise InputError(f"{source}: has one taxel that works: there is no other to compare it with")
    if not (pad.frames[1:] != pad.frames[:1])[:, pad.usable].any():
        raise InputError(f"{source}: no reading ever changes: record presses with pauses between them")


def _ended(plateau: Floats, highest: float, *, exact: bool) -> str | None:
    """Return which taxels of a press are at the end of what they can read, in words; None where there are few or none.

    Where readings end, many taxels share the highest one of all presses, and few are just below it. Taxels that are
    exactly alike at lower readings too are so without an end.
    """
    strongest = plateau.max(axis=0)
    at_end = strongest == highest
    n = int(np.count_nonzero(at_end))
    if n < max(_FEWEST_ENDED, _ENDED * at_end.size):
        return None
    below = strongest[strongest < highest]
    next_below = int(np.count_nonzero(below == below.max())) if below.size else 0
    steady = not exact and bool((plateau[:, at_end] == highest).all()) and len(plateau) > 1
    if n <= _PILED * next_below or not (below.size or steady):
        return None
    return f"{n} of {at_end.size} taxels read exactly {highest:g} and none more: they"


def _only(recording: Recording, pad: str | None, source: str) -> Recording:
    names = list(recording.pads)
    if pad is None and len(names) > 1:
        raise InputError(
            f"{source}: has the pads {', '.join(names)}; calibrate one at a time: say which", parameter="pad"
        )
    chosen = names[0] if pad is None else pad
    if chosen not in recording.pads:
        raise InputError(f"{source}: has no pad {chosen!r}; it has {', '.join(names)}")
    return Recording(
        {chosen: recording.pads[chosen]}, recording.time_s, recording.unit, recording.sensor, recording.source
    )


def _held_frames(pad: Pad, run: range, rest: Floats | None, sigma: float, what: str) -> tuple[Floats, Floats]:
    """Return the frames in which a press is held, as they were read and above rest, each (n_held, rows, cols)."""
    values = _numbers(pad.frames[run.start : run.stop])
    if not values[:, pad.usable].sum(axis=1).max() > 0:
        raise InputError(
            f"{what}: its readings lie below their rest on the mean: the rest sways, as by the hum of the mains, or a "
            "sensor file says another rest; keep it still, and record again"
        )
    above = values - (0.0 if rest is None else rest)
    held = _held(above[:, pad.usable].sum(axis=1), sigma * np.sqrt(np.count_nonzero(pad.usable)))
    return values[held], above[held]


def _held(load: Floats, sigma: float) -> NDArray[np.bool_]:
    """Return in which frames a press is held, from its load in each and the load's noise."""
    top = float(load.max())
    return np.asarray(load >= top - max(_HOLDS * top, min(_HOLD_SIGMAS * sigma, _MOST_SLACK * abs(top))))


def _parts(pad: Pad, run: range, rest: Floats | None = None) -> list[range]:
    """Return the presses of a run of loaded frames: where a frame is unlike the one before, another begins.

    A press that grows or lets go is smaller than it becomes, and so unlike, but no other.
    """
    values = pad.frames[run.start : run.stop][:, pad.usable].astype(np.float64)
    length = np.linalg.norm(values, axis=1)
    alike = (values[1:] * values[:-1]).sum(axis=1) / np.maximum(length[1:] * length[:-1], 1e-300)
    total = values.sum(axis=1)
    load = total - (0.0 if rest is None else float(rest[pad.usable].sum()))
    grown, left = _climb(load), len(load) - 1 - _climb(load[::-1])
    # What lies below the rest that was told is no skirt: that rest is wrong, or sways.
    ahead = (total > 0) & (load < _SKIRT * load[grown]) & (np.arange(len(load)) < grown)
    behind = (total > 0) & (load < _SKIRT * load[left]) & (np.arange(len(load)) > left)
    cuts = (np.flatnonzero((alike < _ALIKE) & ~ahead[:-1] & ~behind[1:]) + 1).tolist()
    return [range(run.start + a, run.start + b) for a, b in itertools.pairwise([0, *cuts, len(values)])]


def _pressed(pad: Pad, parts: list[range], rest: Floats | None, sigma: float) -> list[range]:
    """Return the parts of a run that bear more than noise: what follows a press may be cut off it, and is none."""
    if rest is None or len(parts) < 2:
        return parts
    least = _HOLD_SIGMAS * sigma * np.sqrt(np.count_nonzero(pad.usable))
    above = [(pad.frames[part.start : part.stop] - rest)[:, pad.usable].sum(axis=1).max() for part in parts]
    return [part for part, load in zip(parts, above, strict=True) if load > least] or parts


def _climb(load: Floats) -> int:
    """Return the number of the frame up to which a load grows from the first one on."""
    falls = np.flatnonzero(np.diff(load) <= 0)
    return int(falls[0]) if falls.size else len(load) - 1


def _rest(pad: Pad, runs: list[range], sigma: float, source: str) -> tuple[Floats | None, float]:
    """Return the median unloaded frame, checked to stay where it is, and its noise; None where there are too few."""
    loaded = np.zeros(pad.n_frames, np.bool_)
    for run in runs:
        # The frames before and after a press may be its skirts.
        loaded[max(run.start - 1, 0) : run.stop + 1] = True
    quiet = np.flatnonzero(~loaded)
    _check_still(pad, quiet, runs, sigma, source)
    if quiet.size < _FEWEST_QUIET:
        return None, 0.0
    unloaded = pad.frames[quiet]
    return _numbers(np.median(unloaded, axis=0)), _noise_of_median(unloaded[:, pad.usable].astype(np.float64))


def _noise_of_median(values: Floats) -> float:
    """Return the standard deviation of the median over frames, as most taxels show it, from values (n_frames, n)."""
    n = len(values)
    # The median of a sample's variance is less than the variance, where there are few frames (Wilson and Hilferty).
    usual = float(np.median(values.std(axis=0, ddof=1))) / (1 - 2 / (9 * (n - 1))) ** 1.5
    return float(_OF_A_MEDIAN * usual / np.sqrt(n))


def _numbers(values: NDArray[Any]) -> Floats:
    """Return values with 0 where there is no number, as broken taxels may have it."""
    return np.nan_to_num(values.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)


def _check_still(pad: Pad, quiet: NDArray[np.intp], runs: list[range], sigma: float, source: str) -> None:
    """Refuse a recording whose unloaded frames differ at its beginning and its end.

    A rest that moves far is itself taken for a load: where one end has no unloaded frame, its lightest ones
    stand for it, most of the pad must have moved, and by less than a press that is held would move it.
    """
    third = pad.n_frames // 3
    if third < _FEWEST_AT_END:
        return
    parts = (np.arange(third), np.arange(pad.n_frames - third, pad.n_frames))
    ends = [np.intersect1d(quiet, part) for part in parts]
    seen = [end.size >= _FEWEST_AT_END for end in ends]
    if not any(seen):
        return
    totals = pad.totals()
    for k in (0, 1):
        if not seen[k]:
            ends[k] = np.sort(parts[k][np.argsort(totals[parts[k]], kind="stable")[:_FEWEST_AT_END]])
    first = np.median(pad.frames[ends[0]], axis=0)
    moved = (np.median(pad.frames[ends[1]], axis=0) - first)[pad.usable]
    # Of a press what it adds: a rest may be high beside it.
    peak = float(np.median([(pad.frames[run.start : run.stop] - first)[:, pad.usable].max() for run in runs]))
    if not all(seen) and np.abs(np.median(moved)) > _HELD * peak:
        return
    error = _OF_A_MEDIAN * sigma * np.sqrt(1 / ends[0].size + 1 / ends[1].size)
    n_moved = int(np.count_nonzero(np.abs(moved) > max(_MOVED_SIGMAS * error, _MOVED_SHARE * peak)))
    if n_moved >= max(2, (_MOVED_TAXELS if all(seen) else _MOVED_PAD) * moved.size):
        raise InputError(
            f"{source}: the rest moves: {counted(n_moved, 'taxel')} by up to {np.abs(moved).max():.3g} between frames "
            f"{ends[0][-1]} and {ends[1][0]}, {100 * np.abs(moved).max() / peak:.0f} % of a press; let the sensor warm "
            "up, and record again"
        )
