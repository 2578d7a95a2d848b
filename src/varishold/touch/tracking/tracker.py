"""The tracker: contacts of successive frames become touches, and what happens to them is told."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from statistics import median

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_floats
from varishold.levelset.contact import Contact
from varishold.recording import UNNAMED_PAD
from varishold.touch.tracking.event import Event, EventKind
from varishold.touch.tracking.felt import Felt, feel
from varishold.touch.tracking.following import Following
from varishold.touch.tracking.motion import Told
from varishold.touch.tracking.noise import Noise
from varishold.touch.tracking.sliding import as_shear, is_sliding
from varishold.touch.tracking.touch import Touch
from varishold.touch.tracking.track import Track, TrackState

__all__ = ["ContactTracker"]

# Frames farther apart show different touches, but where so many before came as slowly that no more than two are lost.
_GAP_S, _GAP_TIMES, _STEPS = 0.5, 3.5, 5


class ContactTracker:
    """Follows the contacts of one pad: who is who, what each is, and what happens to it.

    Parameters
    ----------
    pad : str
        Its name, which events carry.
    pascals_per_unit : float, optional
        What one unit of the frames is, where it is a pressure; where the pitch is known too, loads are forces.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.touch import find_contacts
    >>> y, x = np.mgrid[-8:9, -8:9]
    >>> tracker = ContactTracker()
    >>> for k in range(20):
    ...     frame = np.maximum(6.0 - np.hypot(x, y), 0.0) if 8 < k < 15 else np.zeros(x.shape)
    ...     for event in tracker.update(0.01 * k, find_contacts(frame), frame):
    ...         print(event.kind, event.track, event.time_s)
    touched 1 0.09
    released 1 0.14
    """

    def __init__(self, *, pad: str = UNNAMED_PAD, pascals_per_unit: float | None = None) -> None:
        self._pad = pad
        self._pascal = pascals_per_unit
        self._following = Following()
        self._noise = Noise()
        self._time_s = -math.inf
        # The newest steps from frame to frame.
        self._steps_s: deque[float] = deque(maxlen=_STEPS)
        self._shape: tuple[int, int] | None = None

    @property
    def tracks(self) -> tuple[Track, ...]:
        """Every touch that was told and is not over, in the order of their numbers."""
        told = sorted(self._following.told, key=lambda touch: touch.number)
        return tuple(self._track(touch) for touch in told)

    def update(
        self, time_s: float, contacts: Sequence[Contact], frame: ArrayLike, *, shear: ArrayLike | None = None
    ) -> list[Event]:
        """Take the contacts of one more frame.

        Parameters
        ----------
        time_s : float
            Time of the frame, by the sensor's own clock where it has one. Where it jumps back, or ahead by more than
            half a second and more than two lost frames, every touch is over.
        contacts : sequence of Contact
            All of the frame, from `find_contacts`, in any order.
        frame : array_like of shape (rows, cols)
            The frame, in the unit of the contacts.
        shear : array_like of shape (rows, cols, 2), optional
            Shear stress on the skin along x and y, in the unit of the frame.

        Returns
        -------
        list of Event
            What is sure by this frame.

        Raises
        ------
        InputError
            If the time is not finite, the frame has another shape than its contacts' or than those before, or the shear
            does not fit.
        """
        values = self._checked(time_s, contacts, frame)
        pulled = None if shear is None else as_shear(shear, values.shape)
        events = [] if self._follows_on(time_s) else self.end(time_s)
        self._time_s = time_s
        felt = feel(contacts, self._noise.sigma)
        self._noise.update(time_s, values, felt)
        if felt:
            values = felt[0].contact.frame.padded[1:-1, 1:-1]
        known = self._noise.is_known
        begun, over = self._following.update(time_s, felt, values, self._noise.sigma, may_begin=known)
        events += [self._event("touched", touch, touch.onset_s) for touch in begun]
        events += [self._released(touch, time_s) for touch in over]
        shear_noise = 0.0 if pulled is None else _noise_of(pulled, felt)
        for touch in self._following.told:
            if touch.is_visible and not touch.is_merged:
                if pulled is not None:
                    touch.shear.update(touch.felt, pulled, shear_noise)
                events += self._watch(touch, values, measures_shear=pulled is not None)
        return events

    def end(self, time_s: float | None = None) -> list[Event]:
        """Release every touch: the source has ended, or its clock has jumped.

        Parameters
        ----------
        time_s : float, optional
            When that is known. Default: with the newest frame.
        """
        told_s = self._time_s if time_s is None else time_s
        return [self._released(touch, told_s) for touch in self._following.clear()]

    def _follows_on(self, time_s: float) -> bool:
        """Tell whether a frame's time goes on from that of the frame before it, as fast as frames come."""
        step_s = time_s - self._time_s
        usual_s = median(self._steps_s) if self._steps_s else 0.0
        if math.isfinite(step_s) and step_s >= 0.0:
            self._steps_s.append(step_s)
        return 0.0 <= step_s <= max(_GAP_S, _GAP_TIMES * usual_s)

    def _checked(self, time_s: float, contacts: Sequence[Contact], frame: ArrayLike) -> NDArray[np.float64]:
        if not math.isfinite(time_s):
            raise InputError(f"a frame's time must be finite, got {time_s!r}")
        values = as_floats(frame, 2, "a frame", masked=True)
        shape = values.shape
        if contacts and contacts[0].shape != shape:
            raise InputError(f"the frame has shape {shape}, its contacts are of a frame of {contacts[0].shape}")
        if self._shape is not None and shape != self._shape:
            raise InputError(f"a pad's frames must keep their shape, got {shape} after {self._shape}")
        self._shape = shape
        return values

    def _watch(self, touch: Touch, frame: NDArray[np.float64], *, measures_shear: bool) -> list[Event]:
        """Look at one touch that is a contact of its own: what it is, whether it moves."""
        if touch.is_whole:
            touch.evidence.look(self._time_s, touch.felt)
        told = touch.motion.update(self._time_s, touch.felt, frame)
        if told is None:
            return []
        if told.is_new:
            touch.word = _word(touch, told, measures_shear=measures_shear)
        row_pitch, col_pitch = touch.felt.contact.spacing
        x, y = told.way
        in_metres = touch.felt.contact.pitch is not None
        return [
            self._event(
                touch.word,
                touch,
                told.time_s,
                direction_rad=math.atan2(y * row_pitch, x * col_pitch),
                distance_taxels=math.hypot(x, y),
                distance_m=math.hypot(x * col_pitch, y * row_pitch) if in_metres else None,
                resting=told.resting,
            )
        ]

    def _released(self, touch: Touch, told_s: float) -> Event:
        seen_s = touch.seen_s
        # A clock that has jumped back tells it no earlier than it was.
        told_s = max(told_s, seen_s)
        return self._event(
            *("released", touch, seen_s, told_s), duration_s=seen_s - touch.onset_s, peak_load=touch.widest.load
        )

    def _event(
        self, kind: EventKind, touch: Touch, time_s: float, told_s: float | None = None, **more: float | bool | None
    ) -> Event:
        felt, contact = touch.felt, touch.felt.contact
        known = contact.pitch is not None
        area = len(felt.taxels)
        return Event(
            kind=kind,
            time_s=time_s,
            told_s=self._time_s if told_s is None else told_s,
            track=touch.number,
            pad=self._pad,
            position_taxels=felt.position,
            position_m=_in_metres(felt) if known else None,
            area_taxels=float(area),
            area_m2=area * contact.taxel_area if known else None,
            load=felt.load,
            force_n=self._force(felt),
            **more,  # type: ignore[arg-type]
        )

    def _track(self, touch: Touch) -> Track:
        felt = touch.felt
        return Track(
            number=touch.number,
            pad=self._pad,
            onset_s=touch.onset_s,
            seen_s=touch.seen_s,
            state=_state(touch),
            position=_in_metres(felt),
            area=len(felt.taxels) * felt.contact.taxel_area,
            load=felt.load,
            peak_load=touch.widest.load,
            force_n=self._force(felt),
            contact=felt.contact,
            answer=touch.evidence.answer,
            looks=touch.evidence.looks,
        )

    def _force(self, felt: Felt) -> float | None:
        if self._pascal is None or felt.contact.pitch is None:
            return None
        return felt.load * felt.contact.taxel_area * self._pascal


def _word(touch: Touch, told: Told, *, measures_shear: bool) -> EventKind:
    """Return what a motion is called."""
    if told.kind == "tipped":
        return "tipped"
    if measures_shear and touch.shear.pulls(told.way, touch.felt.load):
        return "slip"
    return "slid" if is_sliding(touch.evidence.answer) else "moved"


def _state(touch: Touch) -> TrackState:
    if not touch.is_visible:
        return "lost"
    return "merged" if touch.is_merged else touch.motion.state


def _in_metres(felt: Felt) -> tuple[float, float]:
    """Return the centre of load in metres; in taxels where the pitch is unknown."""
    row_pitch, col_pitch = felt.contact.spacing
    return felt.position[0] * col_pitch, felt.position[1] * row_pitch


def _noise_of(shear: NDArray[np.float64], felt: Sequence[Felt]) -> float:
    """Return the standard deviation of the shear where nothing touches."""
    free = np.ones(len(shear), np.bool_)
    for one in felt:
        free[one.taxels] = False
    return float(np.sqrt(np.mean(shear[free] ** 2))) if free.any() else 0.0
