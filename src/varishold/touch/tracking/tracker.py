"""The tracker: contacts of successive frames become touches, and what happens to them is told."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_floats
from varishold.levelset.contact import Contact
from varishold.recording import UNNAMED_PAD
from varishold.touch.tracking.assignment import assign
from varishold.touch.tracking.event import Event, EventKind
from varishold.touch.tracking.felt import Felt, feel
from varishold.touch.tracking.motion import Motion, Told
from varishold.touch.tracking.noise import Noise
from varishold.touch.tracking.touch import Touch
from varishold.touch.tracking.track import Track, TrackState

__all__ = ["ContactTracker"]

# A touch begins with three taxels and a peak of so many sigma, or with a peak of four times that.
_ON, _LONE, _FEWEST_TAXELS = 8.0, 4.0, 3
# It lasts while its peak is above so many sigma, and above this share of its highest: below lies what zeroing leaves.
_OFF, _OFF_SHARE = 5.0, 0.05
# For so long after a release what stands below this share of the highest is what the touch has left.
_LEFT_S, _LEFT_SHARE = 1.0, 0.15
# It is told once so many frames and so much time have shown it, and released once so many have not.
_ON_FRAMES, _ON_S = 2, 0.004
_OFF_FRAMES, _OFF_S = 2, 0.010
# What falls off from a contact is a touch of its own after so long.
_FRAGMENT_S = 0.1
# Frames farther apart show different touches.
_GAP_S = 0.5


class ContactTracker:
    """Follows the contacts of one pad.

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
        self._touches: list[Touch] = []
        self._motions: dict[int, Motion] = {}
        self._time_s = -math.inf
        self._count = 0
        self._sigma = 0.0
        self._released: list[Touch] = []
        self._noise = Noise()
        self._shape: tuple[int, int] | None = None

    @property
    def tracks(self) -> tuple[Track, ...]:
        """Every touch that was told and not yet released, the oldest first."""
        sure = sorted((touch for touch in self._touches if touch.is_sure), key=lambda touch: touch.number)
        return tuple(self._track(touch) for touch in sure)

    def update(self, time_s: float, contacts: Sequence[Contact], frame: ArrayLike) -> list[Event]:
        """Take the contacts of one more frame.

        Parameters
        ----------
        time_s : float
            Time of the frame, by the sensor's own clock where it has one.
        contacts : sequence of Contact
            All of the frame, from `find_contacts`, in any order.
        frame : array_like of shape (rows, cols)
            The frame, in the unit of the contacts.

        Returns
        -------
        list of Event
            What is sure by this frame.

        Raises
        ------
        InputError
            If the time is not finite, or the frame has another shape than those before.
        """
        values = self._checked(time_s, contacts, frame)
        events: list[Event] = []
        if not 0 <= time_s - self._time_s <= _GAP_S:
            events += self.end(time_s)
        self._time_s = time_s
        felt = feel(contacts, self._noise.sigma)
        self._noise.update(time_s, values, felt)
        self._sigma = self._noise.sigma
        if felt:
            values = felt[0].contact.frame.padded[1:-1, 1:-1]
        felt = [one for one in felt if one.peak >= _OFF * self._sigma]
        events += self._follow(felt, values)
        for touch in self._touches:
            if touch.is_sure and touch.is_visible and not touch.is_merged:
                events += self._watch(touch, values)
        return events

    def end(self, time_s: float | None = None) -> list[Event]:
        """Release every touch: the source has ended, or its clock has jumped."""
        told = self._time_s if time_s is None else time_s
        events = [self._event("released", touch, touch.seen_s, told) for touch in self._touches if touch.is_sure]
        self._touches, self._motions, self._released = [], {}, []
        return events

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

    def _follow(self, felt: list[Felt], values: NDArray[np.float64]) -> list[Event]:
        """Give every contact its touch; return who touched and who released."""
        time_s, touches = self._time_s, self._touches
        result = assign(touches, felt)
        for i, k in (*result.pairs.items(), *result.merged.items()):
            if felt[k].peak < self._off(touches[i]):
                result.pairs.pop(i, None)
                result.merged.pop(i, None)
        sharing: dict[int, list[Touch]] = {}
        for i, k in (*result.pairs.items(), *result.merged.items()):
            if i in result.pairs or touches[i].is_sure:
                sharing.setdefault(k, []).append(touches[i])
        for k, those in sharing.items():
            sure = [touch for touch in those if touch.is_sure] or those[:1]
            for touch in sure:
                if len(sure) > 1:
                    touch.merge(felt[k])
                elif touch.is_merged:
                    touch.part()
                    self._motions[touch.number] = Motion()
                touch.see(felt[k], time_s)
        for k, i in result.fragments.items():
            touches.append(Touch(felt[k], time_s, time_s, fragment_of=touches[i]))
        touches.extend(Touch(felt[k], time_s, time_s) for k in result.new)
        return self._told(values)

    def _told(self, values: NDArray[np.float64]) -> list[Event]:
        """Return the events of touches that are sure by now, and of those that are over."""
        events, kept = [], []
        flat = values.ravel()
        for touch in self._touches:
            seen = touch.seen_s == self._time_s
            if not seen and touch.is_sure and flat[touch.felt.taxels].max(initial=0.0) > self._off(touch):
                # Too faint for a contact beside others, and still there.
                touch.missed = 0
                touch.seen_s, touch.is_visible = self._time_s, False
            elif not seen:
                touch.is_visible = False
                touch.missed += 1
                if not touch.is_sure:
                    continue
                if touch.missed >= _OFF_FRAMES and self._time_s - touch.seen_s >= _OFF_S:
                    events.append(self._event("released", touch, touch.seen_s, self._time_s))
                    self._motions.pop(touch.number, None)
                    self._released.append(touch)
                    continue
            elif not touch.is_sure and self._begins(touch):
                self._count += 1
                touch.number = self._count
                touch.fragment_of = None
                self._motions[touch.number] = Motion()
                events.append(self._event("touched", touch, touch.onset_s, self._time_s))
            kept.append(touch)
        self._touches = kept
        return events

    def _off(self, touch: Touch) -> float:
        """Return how high the peak of a touch stands at least, in the unit of the frame."""
        return max(_OFF * self._sigma, _OFF_SHARE * touch.peak)

    def _begins(self, touch: Touch) -> bool:
        """Tell whether a touch has been seen well enough to be told."""
        felt = touch.felt
        if not self._noise.is_known:
            return False
        if felt.peak < _ON * self._sigma * (1.0 if len(felt.taxels) >= _FEWEST_TAXELS else _LONE):
            return False
        if felt.peak < _LEFT_SHARE * self._left(felt):
            return False
        waits = _ON_S if touch.fragment_of is None else _FRAGMENT_S
        return touch.frames >= _ON_FRAMES and self._time_s - touch.onset_s >= waits

    def _left(self, felt: Felt) -> float:
        """Return the highest peak of the touches that were just released where a contact is."""
        self._released = [touch for touch in self._released if self._time_s - touch.seen_s <= _LEFT_S]
        return max((touch.peak for touch in self._released if touch.lay_at(felt)), default=0.0)

    def _watch(self, touch: Touch, values: NDArray[np.float64]) -> list[Event]:
        """Look at one touch that is a contact of its own: what it is, whether it moves."""
        touch.evidence.look(self._time_s, touch.felt.contact, touch.felt.load)
        told = self._motions[touch.number].update(self._time_s, touch.felt, values)
        return [] if told is None else [self._motion_event(touch, told)]

    def _motion_event(self, touch: Touch, told: Told) -> Event:
        row_pitch, col_pitch = touch.felt.contact.spacing
        x, y = told.way
        in_metres = touch.felt.contact.pitch is not None
        return self._event(
            told.kind,
            touch,
            told.begun_s,
            self._time_s,
            direction_rad=math.atan2(y * row_pitch, x * col_pitch),
            distance_taxels=math.hypot(x, y),
            distance_m=math.hypot(x * col_pitch, y * row_pitch) if in_metres else None,
            resting=told.resting,
        )

    def _event(self, kind: EventKind, touch: Touch, time_s: float, told_s: float, **more: float | bool | None) -> Event:
        felt = touch.felt
        contact = felt.contact
        x, y = felt.position
        row_pitch, col_pitch = contact.spacing
        known = contact.pitch is not None
        area = len(felt.taxels)
        if kind == "released":
            more |= {"duration_s": touch.seen_s - touch.onset_s, "peak_load": touch.peak_load}
        return Event(
            kind=kind,
            time_s=time_s,
            told_s=told_s,
            track=touch.number,
            pad=self._pad,
            position_taxels=felt.position,
            position_m=(x * col_pitch, y * row_pitch) if known else None,
            area_taxels=float(area),
            area_m2=area * contact.taxel_area if known else None,
            load=felt.load,
            force_n=self._force(felt),
            **more,  # type: ignore[arg-type]
        )

    def _force(self, felt: Felt) -> float | None:
        if self._pascal is None or felt.contact.pitch is None:
            return None
        return felt.load * felt.contact.taxel_area * self._pascal

    def _track(self, touch: Touch) -> Track:
        felt = touch.felt
        x, y = felt.position
        row_pitch, col_pitch = felt.contact.spacing
        return Track(
            number=touch.number,
            pad=self._pad,
            onset_s=touch.onset_s,
            seen_s=touch.seen_s,
            state=self._state(touch),
            position=(x * col_pitch, y * row_pitch),
            area=len(felt.taxels) * felt.contact.taxel_area,
            load=felt.load,
            peak_load=touch.peak_load,
            force_n=self._force(felt),
            contact=felt.contact,
            answer=touch.evidence.answer,
            looks=touch.evidence.looks,
        )

    def _state(self, touch: Touch) -> TrackState:
        if not touch.is_visible:
            return "lost"
        if touch.is_merged:
            return "merged"
        return self._motions[touch.number].state
