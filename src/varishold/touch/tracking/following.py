"""Following touches: which contact is whose, when a touch begins, and when it is over."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.assignment import assign
from varishold.touch.tracking.felt import Felt, gap, joined
from varishold.touch.tracking.letting_go import LettingGo
from varishold.touch.tracking.motion import Motion
from varishold.touch.tracking.touch import Touch

__all__ = ["Following"]

# A touch begins with three taxels and a peak of so many sigma, or with a peak of four times that.
_ON, _LONE, _FEWEST_TAXELS = 8.0, 4.0, 3
# It lasts while its peak is above so many sigma, and above this share of its highest: below lies what zeroing leaves.
_OFF, _OFF_SHARE = 5.0, 0.05
# For so long after a release what stands below this share of the highest is what the touch has left.
_LEFT_S, _LEFT_SHARE = 1.0, 0.15
# A touch is told once so many frames and so much time have shown it, and over once so many have not.
_ON_FRAMES, _ON_S = 2, 0.004
_OFF_FRAMES, _OFF_S = 2, 0.010
# What falls off from a contact is a touch of its own after so long; what comes in in parts has grown together by then.
_FRAGMENT_S = 0.1
# Parts of one contact that comes in have so few rows or columns between them.
_GAP = 3
# Times are compared to within this.
_SAME_S = 1e-6


class Following:
    """Follows the touches of one pad.

    A touch is told when its peak stands clear of the noise, and lasts until it is nearly gone. A frame or two without
    it do not end it. Of two touches over one contact both last as long as the contact covers their places; one that was
    told only a moment before was a part of the other.
    """

    def __init__(self) -> None:
        #: Every touch, those that are not told yet too.
        self.touches: list[Touch] = []
        self._over: list[Touch] = []
        self._letting_go = LettingGo()
        self._count = 0

    @property
    def told(self) -> list[Touch]:
        """Every touch that was told and is not over."""
        return [touch for touch in self.touches if touch.is_sure]

    def clear(self) -> list[Touch]:
        """Forget all touches; return those that were told."""
        told = self.told
        self.touches, self._over = [], []
        self._letting_go.clear()
        return told

    def update(
        self, time_s: float, felt: Sequence[Felt], frame: NDArray[np.float64], sigma: float, *, may_begin: bool
    ) -> tuple[list[Touch], list[Touch]]:
        """Take a new frame's contacts; return the touches that are new and those that are over.

        Parameters
        ----------
        time_s : float
        felt : sequence of Felt
        frame : ndarray of shape (rows, cols), float64
            In it a touch is looked for that is too faint for a contact beside others.
        sigma : float
            The noise, in the unit of the frame.
        may_begin : bool
            Whether so much is known of the noise that a touch can be told.
        """
        for touch in self.touches:
            touch.is_visible = False
        clear = [one for one in felt if one.peak >= _OFF * sigma]
        absorbed = self._share(time_s, clear, sigma)
        begun, over, kept = [], [], []
        for touch in self.touches:
            if not touch.is_visible:
                touch.missed += 1
                if touch.is_sure and _faint(touch, clear, frame) > _off(touch, sigma):
                    touch.seen_s, touch.missed = time_s, 0
            if touch in absorbed or self._is_over(touch, time_s):
                if touch.is_sure:
                    over.append(touch)
                continue
            if may_begin and not touch.is_sure and self._begins(touch, time_s, sigma):
                self._count += 1
                touch.number = self._count
                if touch.part_of is not None:
                    # What is left of the other is another contact.
                    touch.part_of.motion, touch.part_of = Motion(), None
                begun.append(touch)
            kept.append(touch)
        self.touches = kept
        self._over += over
        self._letting_go.update(time_s, frame)
        return begun, over

    def _share(self, time_s: float, felt: list[Felt], sigma: float) -> list[Touch]:
        """Give every contact to its touches; return those that were parts of others."""
        found = assign(self.touches, felt)
        sharing: dict[int, list[Touch]] = {}
        for i, k in (*found.pairs.items(), *found.merged.items()):
            if felt[k].peak >= _off(self.touches[i], sigma):
                sharing.setdefault(k, []).append(self.touches[i])
        parts: dict[int, list[Felt]] = {}
        for k, i in found.fragments.items():
            parts.setdefault(id(self.touches[i]), []).append(felt[k])
        absorbed = []
        for k, those in sharing.items():
            sure = [touch for touch in those if touch.is_sure]
            if not sure:
                parent = those[0].part_of
                those[0].see(felt[k], time_s)
                parts.setdefault(id(parent), []).append(felt[k])
                continue
            came_in = _came_in(sure, time_s)
            absorbed += came_in
            sharing[k] = [touch for touch in sure if touch not in came_in]
        for k, those in sharing.items():
            for touch in those:
                if touch.is_sure:
                    self._see(touch, felt[k], parts.get(id(touch), []), time_s, alone=len(those) == 1)
        for k, i in found.fragments.items():
            parent = self.touches[i] if self.touches[i].is_sure else None
            self.touches.append(Touch(felt[k], time_s, time_s, part_of=parent))
        self.touches.extend(Touch(felt[k], time_s, time_s) for k in found.new)
        return absorbed

    def _see(self, touch: Touch, felt: Felt, parts: list[Felt], time_s: float, *, alone: bool) -> None:
        """Give a told touch its contact, and what has fallen off from that."""
        if alone:
            touch.part()
        else:
            touch.merge(felt)
        touch.see(joined(felt, parts), time_s, is_whole=not parts)

    def _is_over(self, touch: Touch, time_s: float) -> bool:
        if not touch.is_sure:
            return touch.missed > 0
        return touch.missed >= _OFF_FRAMES and time_s - touch.seen_s >= _OFF_S - _SAME_S

    def _begins(self, touch: Touch, time_s: float, sigma: float) -> bool:
        """Tell whether a touch has been seen well enough to be told."""
        felt = touch.felt
        least = _ON * sigma * (1.0 if len(felt.taxels) >= _FEWEST_TAXELS else _LONE)
        if felt.peak < max(least, _LEFT_SHARE * self._left_at(felt, time_s)):
            return False
        waits = _FRAGMENT_S if touch.part_of is not None or self._comes_in(touch) else _ON_S
        shown = touch.frames >= _ON_FRAMES and time_s - touch.onset_s >= waits - _SAME_S
        return shown and not self._letting_go.is_falling(felt)

    def _comes_in(self, touch: Touch) -> bool:
        """Tell whether a touch may be a part of one that comes in beside it, and is heavier or told."""
        return any(
            touch.onset_s - other.onset_s < _FRAGMENT_S
            and (other.is_sure or other.felt.load >= touch.felt.load)
            and gap(other.felt, touch.felt) <= _GAP
            for other in self.touches
            if other is not touch and other.is_visible
        )

    def _left_at(self, felt: Felt, time_s: float) -> float:
        """Return the highest peak of the touches that were just released where a contact is."""
        self._over = [touch for touch in self._over if time_s - touch.seen_s <= _LEFT_S]
        there = (touch for touch in self._over if np.isin(felt.taxels, touch.widest.taxels).any())
        return max((touch.peak for touch in there), default=0.0)


def _off(touch: Touch, sigma: float) -> float:
    """Return how high the peak of a touch stands at least, in the unit of the frame."""
    return max(_OFF * sigma, _OFF_SHARE * touch.peak)


def _faint(touch: Touch, felt: Sequence[Felt], frame: NDArray[np.float64]) -> float:
    """Return how high a frame stands where a touch was and no contact is."""
    left = frame.ravel()[touch.taxels]
    for one in felt:
        left[np.isin(touch.taxels, one.taxels)] = 0.0
    return float(left.max(initial=0.0))


def _came_in(touches: list[Touch], time_s: float) -> list[Touch]:
    """Return which of the told touches over one contact are parts of another that came in with it."""
    oldest = min(touches, key=lambda touch: touch.number)
    return [
        touch
        for touch in touches
        if touch is not oldest and not touch.is_merged and time_s - touch.onset_s < _FRAGMENT_S
    ]
