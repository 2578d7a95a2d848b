"""The hand at one object, with what it takes to go on after a fall."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from varishold.exploration.touch import Felt, PoseEstimate, Touch
from varishold.exploration.touches import TOUCHES
from varishold.hand import Bench, HandSetting, Step
from varishold.hand.grasping import stand_up

__all__ = ["Episode"]

#: After a fall or a miss, a grip of all digits takes the touch's place.
_AFTER_A_FALL = "squeeze"

#: Falls and misses after which the hand gives up.
_MOST_DROPS = 12


@dataclass
class Episode:
    """The hand at one object.

    Parameters
    ----------
    bench : Bench
    rng : numpy.random.Generator
        Places the object again; both from `varishold.hand.set_up`.
    setting : HandSetting
    on_fall : callable, optional
        Called with the touch that failed, when the object was stood up again at a new place.
    watch : callable, optional
        Called with the bench and the hand's step when a touch is complete.
    """

    bench: Bench
    rng: np.random.Generator
    setting: HandSetting
    on_fall: Callable[[Touch], None] | None = None
    watch: Callable[[Bench, Step], None] | None = None
    pose: PoseEstimate = field(default_factory=PoseEstimate)
    drops: int = 0
    #: What all touches have taken so far, falls and misses included; while a person stands it up the clock stops.
    seconds: float = 0.0

    def touch(self, wanted: Touch) -> Felt | None:
        """Make a touch; after a fall or a miss stand the object up again and close all digits about it.

        Returns
        -------
        Felt or None
            None where the hand gives up.
        """
        for tried in self._tries(wanted):
            begun_s = self.bench.time_s
            felt = tried.make(self.bench, self.pose, self.setting)
            self.seconds += self.bench.time_s - begun_s
            if felt is not None:
                if self.watch is not None:
                    self.watch(self.bench, felt.step)
                return felt
            self.drops += 1
            stand_up(self.bench, self.setting, self.rng)
            self.pose = PoseEstimate()
            if self.on_fall is not None:
                self.on_fall(tried)
        return None

    def _tries(self, wanted: Touch) -> Iterator[Touch]:
        yield wanted
        while self.drops < _MOST_DROPS:
            yield TOUCHES[_AFTER_A_FALL]
