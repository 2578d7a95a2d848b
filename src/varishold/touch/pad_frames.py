"""A pad's frames as touch looks at them: zero at rest, broken taxels known, their noise measured in time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._cached import cached_property
from varishold.files import let_go
from varishold.frame.fault import blocks_of
from varishold.frame.floor import noise_reach
from varishold.frame.gains import gains_of
from varishold.frame.health import full_scale, taxels_in_words
from varishold.frame.noise import OF_MEDIAN, ROUNDING, frame_noise
from varishold.frame.quiet import FEWEST_FRAMES, SMOOTHED, is_level, is_smoothed, noise_in_time, off_plane
from varishold.frame.reading_end import ReadingEnd, reading_end
from varishold.frame.smooth import frame_is_smoothed
from varishold.frame.spread import spread_over
from varishold.frame.standardized import ROUGHLY
from varishold.frame.swaying import SWAYS, sways
from varishold.levelset.contacts import find_contacts
from varishold.recording import Pad, Recording, presses

__all__ = ["PadFrames", "pad_frames"]

# A rest is the median of at least so many frames; more than so many change it no more.
_FEWEST_QUIET, _MOST_QUIET = 3, 256
# Where a recording begins loaded, of so many frames between presses, not the first ones after a press.
_FEWEST_BETWEEN, _AFTER = 6, 2
# A plane is fitted to a rest to within this share of it.
_OF_FLOATS = 1e-12
# A contact of fewer taxels in a rest is a taxel that rests high.
_FEWEST_TAXELS = 4
# The first and the last frames, which say what lies there before and after all presses: the same to within so many
# sigma and this share of it. So does at least half of it through half of the presses, of which some are looked at.
_ENDS, _SAME_SIGMAS, _SAME_SHARE, _STEADY = 8, 8.0, 0.1, 0.5
_MOST_PRESSES = 256
# So many presses tell what taxels read, and so many frames of each which is its strongest.
_MOST_FOR_GAINS, _MOST_OF_PRESS = 128, 33


@dataclass(frozen=True, eq=False)
class PadFrames:
    """A pad, and what its whole recording tells of each of its frames.

    Parameters
    ----------
    pad : Pad
    rest : ndarray of shape (rows, cols), float64, or None
        What each taxel shows when nothing touches it; None where the recording does not tell, or it is zero.
    sigma : float or None
        Standard deviation of the noise, measured in time where nothing presses; None where zeros hide it.
    valid : ndarray of shape (rows, cols), bool, or None
        False where a taxel is broken, as the recording says or as it shows; None where all work.
    full_scale : float or None
        The value at which taxels are saturated.
    notes : tuple of str
        What was done, in words.
    ends_at : ReadingEnd or None
        Beyond what no taxel reads, as its presses show; None where they show no end.
    lies : ndarray of shape (rows, cols), float64, or None
        What each taxel shows where something lies from the first frame to the last, the same before and after all
        presses and no part of them; None where nothing does.
    smoothed : bool
        Whether taxels share their noise with those beside them, as smoothed or interpolated ones do.
    gains : ndarray of shape (rows, cols), float64, or None
        How much more or less each taxel reads than others; None where that is not certain.
    sways : bool
        Whether all taxels go up and down together and never rest, as a rest that drifts does: a plane is not sure.
    """

    pad: Pad
    rest: NDArray[np.float64] | None
    sigma: float | None
    valid: NDArray[np.bool_] | None
    full_scale: float | None
    notes: tuple[str, ...]
    ends_at: ReadingEnd | None = None
    lies: NDArray[np.float64] | None = None
    smoothed: bool = False
    gains: NDArray[np.float64] | None = None
    sways: bool = False

    @cached_property
    def blurs_forms(self) -> bool:
        """Whether small forms are not sure: taxels share their noise, or their gains are known roughly at most."""
        return self.smoothed or any(note.startswith(ROUGHLY) for note in self.notes)

    @cached_property
    def noise(self) -> float | None:
        """Standard deviation of the noise of `frame`, as `sigma`."""
        if self.sigma is None or self.gains is None:
            return self.sigma
        return self.sigma * math.sqrt(float(np.mean(self.gains**-2.0)))

    @cached_property
    def _most(self) -> NDArray[np.float64] | float | None:
        """How high above its rest each taxel reads at most."""
        if self.ends_at is None:
            return None
        usable = self.pad.usable if self.valid is None else self.pad.usable & self.valid
        return self.ends_at.above(self.rest, usable)

    def frame(self, index: int, *, of_press: bool = False) -> NDArray[np.float64]:
        """Return one frame without the rest, up to where readings end, taxels even; shape (rows, cols).

        Of a press what lies there all the time is none: it is taken off too.
        """
        loaded = self._loaded(index, of_press=of_press)
        return loaded if self.gains is None else loaded / self.gains

    def _loaded(self, index: int, *, of_press: bool = False) -> NDArray[np.float64]:
        frame = np.array(self.pad.frames[index], dtype=np.float64, order="C")
        if self.rest is not None:
            frame -= self.rest
        elif of_press and self.lies is not None:
            frame -= self.lies
        # What stands above the end is noise on it.
        return frame if self._most is None else np.minimum(frame, self._most)

    def readings(self, index: int) -> NDArray[Any]:
        """Return one frame without the rest, for a sensor that is still to be undone; shape (rows, cols).

        Whole numbers stay whole: their rounding is a part of their noise.
        """
        raw: NDArray[Any] = self.pad.frames[index]
        if self.rest is None:
            return raw
        return raw.astype(np.int64) - np.rint(self.rest).astype(np.int64) if raw.dtype.kind in "iu" else raw - self.rest

    def saturated(self, index: int) -> NDArray[np.bool_] | None:
        """Return where a frame's taxels felt at least what they show; None for nowhere."""
        most = self._most
        if self.full_scale is None and most is None:
            return None
        full = np.zeros(self.pad.shape, np.bool_)
        if self.full_scale is not None:
            full |= self.pad.frames[index] >= self.full_scale
        if most is not None:
            full |= self._loaded(index) >= most
        return full if full.any() else None


def pad_frames(recording: Recording) -> dict[str, PadFrames]:
    """Look through a recording once, and return each pad's frames by its name.

    A recording that starts unloaded is zeroed: each taxel's median over the frames before the first press is taken
    off; of one that starts loaded, that over the longest while in which nothing presses. Taxels that never change while
    nearly all others do are taken to be broken.

    Parameters
    ----------
    recording : Recording
        Where a sensor file is known, upright: today's rest may differ from the file's.

    Returns
    -------
    dict of str to PadFrames

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> y, x = np.mgrid[-8:9, -8:9]
    >>> force = np.repeat([0.0, 5.0], 10)[:, None, None]
    >>> frames = 30 + force * np.maximum(6.0 - np.hypot(x, y), 0.0) + rng.normal(0, 0.3, (20, 17, 17))
    >>> print(*pad_frames(Recording({"pad": Pad(frames)}))["pad"].notes)
    zeroed on frames 0 to 9, before the first touch
    """
    pressed = presses(recording) if recording.n_frames > _FEWEST_QUIET else []
    # Presses that have names are presses.
    unnamed = recording.press is None
    return {name: _seen(pad, pressed, may_sway=unnamed) for name, pad in recording.pads.items()}


def _quiet(pressed: list[range], n_frames: int) -> NDArray[np.intp]:
    """Return the numbers of frames in which nothing presses.

    They are those before the first press, or where they are too few, the longest while between two or after the last;
    where all of these are short, all of them. None where there is no press, or too few go before and after it.
    """
    if not pressed:
        return np.arange(0)
    if pressed[0].start >= _FEWEST_QUIET:
        return np.arange(pressed[0].start)
    # What a press leaves behind goes away slowly.
    stops = [*(press.start for press in pressed[1:]), n_frames]
    whiles = [np.arange(press.stop + _AFTER, stop) for press, stop in zip(pressed, stops, strict=True)]
    longest = max(whiles, key=len)
    found = longest if len(longest) >= _FEWEST_BETWEEN else np.concatenate(whiles)
    return found if len(found) >= _FEWEST_BETWEEN else np.arange(0)


def _zeroed_words(quiet: NDArray[np.intp], n_frames: int) -> str:
    """Return on which frames a recording was zeroed, in words."""
    first, last = int(quiet[0]), int(quiet[-1])
    if last - first >= len(quiet):
        return f"zeroed on {len(quiet)} frames between touches"
    when = "after the last touch" if last == n_frames - 1 else "between touches"
    return f"zeroed on frames {first} to {last}, {'before the first touch' if first == 0 else when}"


def _seen(pad: Pad, pressed: list[range], *, may_sway: bool) -> PadFrames:
    quiet = _quiet(pressed, pad.n_frames)
    notes = [*pad.notes]
    if pad.n_frames == 1:
        notes.append("a single frame: noise and the taxels' unevenness cannot be told apart")
    broken = pad.broken
    if broken.any():
        notes.append(f"{taxels_in_words(broken)} is dead or stuck: filled from its neighbours")
    works = pad.usable & ~broken
    sigma, hidden = noise_in_time(pad.frames, works)
    rest = _rest(pad, works, quiet, sigma or 0.0)
    if rest is not None:
        notes.append(_zeroed_words(quiet, pad.n_frames))
    valid = pad.valid
    if broken.any():
        valid = ~broken if valid is None else valid & ~broken
    full = full_scale(pad.extent, pad.usable, pad.frames.dtype) if pad.n_frames > 1 else None
    ends_at = reading_end(pad.frames, works, rest, pressed, sigma or 0.0)
    if ends_at is not None:
        notes.append(str(ends_at))
    smoothed = pad.positions_m is None and _smoothed(pad.frames, works)
    if smoothed:
        notes.append(SMOOTHED)
    swaying = may_sway and bool(pressed) and sways(pad.frames, works)
    if swaying:
        notes.append(SWAYS)
    lies = _lying(pad, works, sigma or 0.0, pressed) if rest is None and pressed else None
    # Where zeros hide it, noise of what is loaded, mere rounding perhaps, says nothing of where a contact ends.
    at_rest = None if hidden else sigma
    gains = None if pad.positions_m is not None else gains_of(_strongest(pad, rest, pressed), works, sigma or 0.0)
    return PadFrames(pad, rest, at_rest, valid, full, tuple(notes), ends_at, lies, smoothed, gains, swaying)


def _smoothed(frames: NDArray[Any], works: NDArray[np.bool_]) -> bool:
    """Tell whether taxels share their noise in time, or of few frames in the one that is loaded least."""
    if len(frames) >= FEWEST_FRAMES:
        return is_smoothed(frames, works)
    loads = [frame[works].astype(np.float64).sum() for frame in frames]
    return bool(loads) and frame_is_smoothed(frames[int(np.argmin(loads))], works)


def _strongest(pad: Pad, rest: NDArray[np.float64] | None, pressed: list[range]) -> list[NDArray[np.float64]]:
    """Return the strongest of some frames of some presses, without the rest."""
    frames = []
    for press in [pressed[k] for k in spread_over(len(pressed), _MOST_FOR_GAINS)] if pressed else []:
        some = np.asarray(pad.frames[press.start + spread_over(len(press), _MOST_OF_PRESS)], dtype=np.float64)
        let_go(pad.frames)
        strongest = some[int(some[:, pad.usable].sum(axis=1).argmax())]
        frames.append(strongest if rest is None else strongest - rest)
    return frames


def _rest(pad: Pad, works: NDArray[np.bool_], quiet: NDArray[np.intp], sigma: float) -> NDArray[np.float64] | None:
    """Return the median of the quiet frames; None where it is zero to within the noise, or something lies there."""
    if len(quiet) == 0:
        return None
    chosen = quiet[spread_over(len(quiet), _MOST_QUIET)]
    rest = np.asarray(np.median(np.asarray(pad.frames[chosen], dtype=np.float64), axis=0))
    rest[~works] = 0.0
    if np.abs(rest).max() <= noise_reach(OF_MEDIAN * sigma / math.sqrt(chosen.size), rest.size):
        return None
    return rest if is_level(rest, works) or not _touched(pad, works, rest, sigma).any() else None


def _touched(pad: Pad, works: NDArray[np.bool_], rest: NDArray[np.float64], sigma: float) -> NDArray[np.bool_]:
    """Return where something touches already in what is to be a rest; shape (rows, cols)."""
    # A rest is a slope, an offset and each taxel's own; what stands out of it broadly touches.
    rounding = ROUNDING if pad.frames.dtype.kind in "iu" else _OF_FLOATS * float(np.abs(rest).max())
    noise = max(sigma, frame_noise(rest, valid=works), rounding)
    found = find_contacts(off_plane(rest, works), 4, valid=works, field=pad.field, sigma=noise if noise > 0 else None)
    touched = np.zeros(pad.shape, np.bool_)
    for contact in found:
        if contact.n_taxels >= _FEWEST_TAXELS:
            touched[contact.window] |= contact.mask
    return touched


def _lying(pad: Pad, works: NDArray[np.bool_], sigma: float, pressed: list[range]) -> NDArray[np.float64] | None:
    """Return what the taxels show before and after all presses where something lies there that is no part of them."""
    if pad.n_frames < 3 * _ENDS:
        return None
    first, last = (np.median(part, axis=0).astype(np.float64) for part in (pad.frames[:_ENDS], pad.frames[-_ENDS:]))
    same = _SAME_SIGMAS * sigma + _SAME_SHARE * np.abs(first - np.median(first[works]))
    if (np.abs(last - first) > same)[works].any():
        return None
    touched = _touched(pad, works, np.where(works, first, 0.0), sigma)
    if not touched.any():
        return None
    looked_at = spread_over(len(pressed), _MOST_PRESSES)
    stays = [_steady(pad.frames[pressed[k].start : pressed[k].stop], touched, first, same) for k in looked_at]
    return np.where(works, (first + last) / 2, 0.0) if np.median(stays) >= _STEADY else None


def _steady(
    frames: NDArray[Any], where: NDArray[np.bool_], rest: NDArray[np.float64], same: NDArray[np.float64]
) -> float:
    """Return of which share of some taxels no frame of a press shows anything but the rest."""
    farthest = np.zeros(np.count_nonzero(where))
    for _, block in blocks_of(frames):
        farthest = np.maximum(farthest, np.abs(block[:, where] - rest[where]).max(axis=0))
    return float(np.mean(farthest <= same[where]))
