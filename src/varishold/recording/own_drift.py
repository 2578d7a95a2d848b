"""A rest that each taxel leaves in its own way: followed where nothing presses, and taken off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Frames, Mask, pieces_at
from varishold.frame.noise import MEDIAN_ABS_NORMAL, OF_MEDIAN, sigma_of_half
from varishold.frame.quiet import timed_noise
from varishold.frame.spread import spread_over
from varishold.frame.together import readings_end, taken_off
from varishold.recording.recording import Recording

__all__ = ["OwnDrift", "may_drift", "own_drift"]

_FEWEST_TAXELS, _FEWEST_FRAMES = 16, 24
# Windows over the whole recording in which taxels are compared before anything is looked for, and the frames of each.
_WINDOWS, _WIDTH, _SUSPECT = 12, 12, 1.3
# The rest is the median of at least and at most so many frames, at either end of a span in which nothing presses; a
# short span has one.
_FEWEST, _MOST, _SHORT = 5, 32, 48
# What goes before a press is its beginning; of what follows it this share is its end.
_BEFORE, _AFTER = 2, 0.25
# Half of the taxels rest so many standard errors elsewhere, and this share of what is read at most.
_ERRORS, _LEAST = 1.5, 0.01
# Frames that tell how high presses stand; bytes of all rests.
_LOOKED_AT, _ROOM = 256, 1 << 26


@dataclass(frozen=True, eq=False)
class OwnDrift:
    """How far each taxel is off the rest that it begins at, at some moments of a recording.

    Parameters
    ----------
    frames : Frames
        All of the recording, shape (n_frames, rows, cols).
    at : ndarray of shape (n,), float64
        Moments, as numbers of frames, rising; between two of them a taxel goes evenly.
    off : ndarray of shape (n, rows, cols), float64
    ends_at : float
        The value at which readings end; they stay there.
    """

    frames: Frames
    at: Floats
    off: Floats
    ends_at: float

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 on the rest that each taxel begins at."""
        read = np.asarray(self.frames[first:last])
        return taken_off(read, self.off_at(np.arange(first, last, dtype=np.float64)), self.ends_at)

    def off_at(self, moments: Floats) -> Floats:
        """Return how far each taxel is off at each of some moments, shape (n_moments, rows, cols)."""
        after = np.clip(np.searchsorted(self.at, moments), 1, len(self.at) - 1)
        share = np.clip((moments - self.at[after - 1]) / (self.at[after] - self.at[after - 1]), 0.0, 1.0)
        share = share[:, None, None]
        off: Floats = (1.0 - share) * self.off[after - 1] + share * self.off[after]
        return off

    def words(self) -> tuple[str, ...]:
        """Return how far taxels go, in words."""
        farthest = np.abs(self.off).max(axis=0)
        return (
            f"the rest of each taxel drifts of its own, half of them by {np.median(farthest[farthest > 0]):.3g} and "
            "more: taken off as frames show it in which nothing presses",
        )


def own_drift(recording: Recording, pressed: list[range]) -> dict[str, OwnDrift]:
    """Return how far each taxel's rest goes of its own, for each pad where that is certain and worth it.

    It is read before and after each press, and goes on evenly through it.

    Parameters
    ----------
    recording : Recording
        Without what all taxels do together.
    pressed : list of range
        The frames of each press, in time.

    Examples
    --------
    >>> from varishold.recording import Pad
    >>> rng = np.random.default_rng(0)
    >>> goes = rng.normal(0, 20, (8, 8)) * np.linspace(0, 1, 200)[:, None, None]
    >>> frames = rng.normal(0, 1, (200, 8, 8)) + goes
    >>> frames[90:110, 2:6, 2:6] += 100.0
    >>> found = own_drift(Recording({"pad": Pad(frames)}), [range(90, 110)])["pad"]
    >>> bool(np.std(frames[190:]) > 15), bool(np.std(found.mended(190, 200)) < 4)
    (True, True)
    """
    spans = _quiet_spans(pressed, recording.n_frames)
    found = {name: _followed(pad.frames, pad.usable, spans) for name, pad in recording.pads.items()}
    return {name: rule for name, rule in found.items() if rule is not None}


def may_drift(frames: Frames, usable: Mask) -> bool:
    """Tell, by a few of many frames, whether half of a pad's taxels rest elsewhere in some of them than in most."""
    n_frames, n_taxels = frames.shape[0], np.count_nonzero(usable)
    if n_frames < max(_FEWEST_FRAMES, 2 * _WIDTH) or n_taxels < _FEWEST_TAXELS:
        return False
    begins = spread_over(n_frames - _WIDTH + 1, min(_WINDOWS, n_frames // _WIDTH))
    windows = [piece[:, usable].astype(np.float64) for piece in pieces_at(frames, begins.tolist(), _WIDTH)]
    sigma = np.median([np.median(np.abs(np.diff(w, axis=0)), axis=None) for w in windows]) / MEDIAN_ABS_NORMAL
    rests = np.array([np.median(w, axis=0) for w in windows])
    off = np.median(np.abs(rests - np.median(rests, axis=0)), axis=1) / MEDIAN_ABS_NORMAL
    # Successive differences scatter by the square root of two more.
    return bool(np.count_nonzero(off > _SUSPECT * OF_MEDIAN * sigma / math.sqrt(2.0 * _WIDTH)) >= 2)


def _quiet_spans(pressed: list[range], n_frames: int) -> list[range]:
    """Return the frames before, between and after presses in which nothing presses any more, nor yet, if there are."""
    starts = [0, *(press.stop for press in pressed)]
    stops = [*(press.start for press in pressed), n_frames]
    spans = []
    for k, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        begins = start + (math.ceil(_AFTER * (stop - start)) if k > 0 else 0)
        ends = stop - (_BEFORE if k < len(pressed) else 0)
        if ends > begins:
            spans.append(range(begins, ends))
    return spans


def _moments(spans: list[range]) -> list[range]:
    """Return the frames of each rest: both ends of long spans, all of short ones."""
    found = []
    for span in spans:
        found += [span] if len(span) < _SHORT else [span[:_MOST], span[-_MOST:]]
    return found


def _followed(frames: NDArray[Any], usable: Mask, spans: list[range]) -> OwnDrift | None:
    """Return how the rests of a pad go from span to span; None where they stay, or that is not certain."""
    spread = _moments([span for span in spans if len(span) >= _FEWEST])
    some = [spread[k] for k in spread_over(len(spread), max(2, _ROOM // (8 * usable.size)))] if spread else []
    if len(some) < 2:
        return None
    sigma = timed_noise(frames, valid=usable) or 0.0
    rests = np.zeros((len(some), *usable.shape))
    scatter = np.zeros(len(some))
    for k, span in enumerate(some):
        chosen = frames[span.start : span.stop][spread_over(len(span), _MOST)][:, usable].astype(np.float64)
        rests[k][usable] = np.median(chosen, axis=0)
        # Noise that is slow makes halves of them unlike, and a rest half as uncertain as they are.
        early, late = (np.median(half, axis=0) for half in np.array_split(chosen, 2))
        scatter[k] = max(sigma_of_half(late - early) / 2, OF_MEDIAN * sigma / math.sqrt(len(chosen)))
    # Halves that are alike by chance make no rest surer than the others are.
    n_chosen = np.array([min(len(span), _MOST) for span in some])
    scatter = np.maximum(scatter, np.median(scatter * np.sqrt(n_chosen)) / np.sqrt(n_chosen))
    off = rests - rests[0]
    # What all do together is none of their own.
    goes = np.array([sigma_of_half(each[usable] - np.median(each[usable])) for each in off])
    looked = frames[spread_over(len(frames), _LOOKED_AT)][:, usable].astype(np.float64)
    highest = float((looked - rests[0][usable]).max())
    if not (goes > np.maximum(_ERRORS * np.hypot(scatter, scatter[0]), _LEAST * highest)).any():
        return None
    found = OwnDrift(frames, _middles(some), off, readings_end(looked, frames.dtype.kind))
    others = [span for span in spans if len(span) < _FEWEST]
    # A missed press makes the halves of a rest unlike too: noise alone tells how rests scatter.
    noise = OF_MEDIAN * sigma / math.sqrt(np.median(n_chosen))
    return found if _borne_out(found, usable, others, noise) else None


def _middles(spans: list[range]) -> Floats:
    return np.array([(span.start + span.stop - 1) / 2 for span in spans])


def _borne_out(found: OwnDrift, usable: Mask, others: list[range], scatter: float) -> bool:
    """Tell whether frames that went into no rest go as is found, where that is by more than rests scatter.

    Where presses follow each other fast, a long span is mostly one whose press was missed.
    """
    if not others:
        return True
    read = np.array(
        [found.frames[each.start : each.stop][:, usable].astype(np.float64).mean(axis=0) for each in others]
    )
    off = found.off_at(_middles(others))[:, usable]
    read, off = (values - values.mean(axis=0) for values in (read, off))
    return float(off.std()) < _ERRORS * scatter or float((off * (2.0 * read - off)).sum()) >= 0.0
