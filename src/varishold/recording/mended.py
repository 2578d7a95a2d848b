"""Recordings without the faults that time tells: lost signs, glitches, noise, what sticks, what adapts, drift."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.files import let_go
from varishold.frame.adapting import adapting_readings
from varishold.frame.checks import as_usable
from varishold.frame.common_mode import CommonMode, common_mode
from varishold.frame.drifting import drifting_rest
from varishold.frame.enlarged import enlargement
from varishold.frame.fault import Fault
from varishold.frame.glitches import GlitchRule, glitch_rule
from varishold.frame.line_noise import column_noise, row_noise
from varishold.frame.marked import marked_readings
from varishold.frame.noisy import noisy_taxels, noisy_words
from varishold.frame.padded import padding, padding_words
from varishold.frame.scaled import centred_frames, scaled_frames
from varishold.frame.silent import silent_frames
from varishold.frame.spoilt import spoilt_frames
from varishold.frame.standardized import standardized_taxels
from varishold.frame.sticking import sticking_taxels
from varishold.frame.wrapped import wrapped_readings
from varishold.recording.own_drift import OwnDrift, may_drift, own_drift
from varishold.recording.recording import Recording
from varishold.recording.selection import presses
from varishold.recording.stored import Column, Stored, StoredPad, Turned, stored_of

__all__ = ["stored_without_faults", "without_faults"]

# In this order: nothing is right without signs, frames without a picture, or with half of one, and readings that are
# none would hide all else, what sticks would hide glitches, a glitch is no part of what all taxels do, and drift is
# seen where they do nothing else.
_FAULTS = (
    wrapped_readings,
    silent_frames,
    marked_readings,
    standardized_taxels,
    scaled_frames,
    centred_frames,
    spoilt_frames,
    sticking_taxels,
    glitch_rule,
    adapting_readings,
    common_mode,
    row_noise,
    column_noise,
    drifting_rest,
)

# So often presses are looked for while the rest of each taxel becomes known.
_LOOKS = 3


def without_faults(recording: Recording) -> Recording:
    """Return a recording in which readings that stand alone in time and place are replaced; each pad's notes say so.

    What is replaced gets the median of what the taxel reads in the frames beside it. A taxel or a line that sticks from
    some frame on is filled from the taxels around it. Frames that break off or are full of noise for a moment are as
    those beside them, as are readings of one number far beyond all others, and taxels that are far noisier than others
    are marked as broken. Readings that adapt to what presses are taken back to it. What all taxels do together, as by
    mains hum, is taken off where some that nothing presses show it; so is how far the rest of all of them drifts, or of
    each of them. Readings below zero that were stored without their sign get it back, frames that were enlarged the
    size that they had, those that were laid into larger ones no taxels around them, and frames that were scaled each
    for itself, or centred, the level and the scale of what nothing presses. Taxels that were each scaled to their own
    spread get a scale on which all have the same noise. A recording without any of this is returned as it is.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.recording import Pad
    >>> frames = np.random.default_rng(0).normal(0, 1, (20, 8, 8))
    >>> frames[5:, 2:6, 2:6] += 100.0
    >>> frames[10, 3, 0] = 200.0
    >>> without_faults(Recording({"pad": Pad(frames)})).remarks
    ('1 reading stands alone in time and place: replaced by those beside it',)
    """
    stored, pads = stored_of(recording), {}
    small = {name: _as_it_was(pad) for name, pad in stored.pads.items()}
    if any(small[name] is not pad for name, pad in stored.pads.items()):
        stored = replace(stored, pads=small)
        recording = stored.whole()
    for name, pad in recording.pads.items():
        frames, words = _mended(pad.frames, pad.usable, counts=True, named=stored.press is not None)
        given = stored.pads[name]
        mended = _without_noisy(replace(given, frames=frames, notes=(*pad.notes, *words)) if words else given)
        if mended is not given:
            pads[name] = mended
    whole = _whole(replace(stored, pads={**stored.pads, **pads}), recording) if pads else recording
    suspect = any(may_drift(pad.frames, pad.usable) for pad in whole.pads.values())
    return _seen_without(whole, _own_drifts(whole)) if suspect else whole


def stored_without_faults(stored: Stored) -> Stored:
    """Return a recording in its file as `without_faults` would: each block is mended as it is read."""
    pads, usable = {}, {}
    for name, given in stored.pads.items():
        pad = _as_it_was(given)
        # To count glitches takes one more look at all of it.
        frames, words = _mended(pad.frames, _usable(pad), counts=False, named=stored.press is not None)
        pads[name] = _without_noisy(replace(pad, frames=frames, notes=(*pad.notes, *words)))
        usable[name] = _usable(pads[name])
    mended = replace(stored, pads=pads)
    if not any(may_drift(pad.frames, usable[name]) for name, pad in mended.pads.items()):
        return mended
    try:
        whole = mended.whole()
    except InputError:
        # Whoever reads it is told why.
        return mended
    return _without(mended, _own_drifts(whole))


def _own_drifts(recording: Recording) -> dict[str, OwnDrift]:
    """Return how each taxel's rest goes; presses that it hides are seen without it, and it is looked for again."""
    pressed = presses(recording)
    drifts = own_drift(recording, pressed)
    for _ in range(_LOOKS - 1 if drifts else 0):
        before, pressed = pressed, presses(_seen_without(recording, drifts))
        if drifts and pressed == before:
            break
        drifts = own_drift(recording, pressed)
    return drifts


def _seen_without(recording: Recording, drifts: Mapping[str, OwnDrift]) -> Recording:
    return _whole(_without(stored_of(recording), drifts), recording) if drifts else recording


def _whole(mended: Stored, recording: Recording) -> Recording:
    """Return a mended recording; the recording itself where what is left of it, noise below zero, is none."""
    try:
        return mended.whole()
    except InputError:
        return recording


def _without(stored: Stored, drifts: Mapping[str, OwnDrift]) -> Stored:
    """Return a recording whose pads go back to the rest that each taxel begins at."""
    pads = dict(stored.pads)
    for name, drift in drifts.items():
        pad = pads[name]
        frames = _Mended(pad.frames, replace(drift, frames=pad.frames))
        pads[name] = replace(pad, frames=frames, notes=(*pad.notes, *drift.words()))
    return replace(stored, pads=pads)


def _as_it_was(pad: StoredPad) -> StoredPad:
    """Return a pad as it was before its frames were enlarged or laid into larger ones; others are returned as given."""
    small = _not_enlarged(pad)
    around = None if pad.positions_m is not None else padding(small.frames, _usable(small))
    if around is None:
        return small
    field = ~around if small.field is None else small.field & ~around
    return replace(small, field=field, notes=(*small.notes, padding_words(around)))


def _not_enlarged(pad: StoredPad) -> StoredPad:
    """Return a pad as it was before its frames were enlarged; one whose frames were not is returned itself."""
    rows, cols = (1, 1) if pad.positions_m is not None else enlargement(pad.frames)
    if rows == cols == 1:
        return pad
    shape = (pad.frames.shape[1] // rows, pad.frames.shape[2] // cols)
    words = (
        f"frames were enlarged: each of {shape[0]} x {shape[1]} taxels stands {rows} x {cols} times, and is taken once"
    )
    return replace(
        pad,
        frames=Turned(pad.frames, shape, lambda block: block[:, ::rows, ::cols]),
        field=None if pad.field is None else pad.field[::rows, ::cols],
        valid=None if pad.valid is None else pad.valid[::rows, ::cols],
        pitch_m=None if pad.pitch_m is None else (rows * pad.pitch_m[0], cols * pad.pitch_m[1]),
        notes=(*pad.notes, words),
    )


def _usable(pad: StoredPad) -> NDArray[np.bool_]:
    """Return where a pad has a taxel that works; shape (rows, cols)."""
    shape = (pad.frames.shape[1], pad.frames.shape[2])
    return as_usable(np.zeros((1, *shape)), shape, pad.field, pad.valid)


def _without_noisy(pad: StoredPad) -> StoredPad:
    """Return a pad whose far too noisy taxels are marked; one that has none is returned itself."""
    noisy = None if pad.positions_m is not None else noisy_taxels(pad.frames, _usable(pad))
    if noisy is None:
        return pad
    valid = ~noisy if pad.valid is None else pad.valid & ~noisy
    return replace(pad, valid=valid, notes=(*pad.notes, noisy_words(noisy)))


def _mended(frames: Column, usable: NDArray[np.bool_], *, counts: bool, named: bool) -> tuple[Column, list[str]]:
    """Return frames without faults, and what is mended, in words; of glitches only where they are counted.

    Presses that are `named` are presses, though all taxels do nothing but go up and down together.
    """
    told: list[str] = []
    for find in _FAULTS:
        rule = find(frames, usable)
        let_go(frames)
        if rule is None or (named and isinstance(rule, CommonMode) and not rule.pressed):
            continue
        uncounted = isinstance(rule, GlitchRule) and not counts
        words = () if uncounted else rule.words()
        if words or uncounted:
            frames = _Mended(frames, rule)
            told += words
    return frames, told


@dataclass(frozen=True)
class _Mended:
    """A column of frames that are mended as they are read."""

    source: Column
    rule: Fault

    @property
    def shape(self) -> tuple[int, ...]:
        return self.source.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.rule.mended(0, 1).dtype

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        first, last, _ = wanted.indices(self.shape[0])
        return self.rule.mended(first, last) if first < last else np.empty((0, *self.shape[1:]), self.dtype)
