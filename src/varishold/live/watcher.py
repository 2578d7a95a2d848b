"""The watcher: a source's readings in, what touches and what happens out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.live.pad_silence import PAD_SILENT, PadSilence
from varishold.live.pad_watcher import PadWatcher, SeenPad, grid_of
from varishold.live.press_keeper import KeptPress, PressKeeper
from varishold.live.press_namer import NamedPress, PressNamer
from varishold.live.sample import PadLayout, Sample
from varishold.live.steady_time import SteadyTime
from varishold.touch.course.one_sensor import UNKNOWN_UNIT, SensorScale

if TYPE_CHECKING:
    from varishold.learning import PressClassifier
    from varishold.live.press_believer import PressBeliever
    from varishold.perceive import Perceiver
    from varishold.sensor import Sensor

__all__ = ["Seen", "Watcher"]

# A press that lasts is named anew so often. Seconds.
_NAME_EVERY_S = 0.25


@dataclass(frozen=True, eq=False)
class Seen:
    """What was seen in one reading.

    Parameters
    ----------
    number : int
        Running number of the reading, from 0; what was missed is counted.
    time_s : float
        By the sensor's clock where it has one, else by this machine's; never goes back.
    sample : Sample or None
        The reading as it came; None of what is told between readings or after the last one.
    pads : mapping of str to SeenPad
    ended : KeptPress or None
        The press that has ended with this reading.
    named : tuple of NamedPress
        What the model said meanwhile of this press and those before.
    """

    number: int
    time_s: float
    sample: Sample | None
    pads: Mapping[str, SeenPad]
    ended: KeptPress | None = None
    named: tuple[NamedPress, ...] = field(default=())

    @property
    def touched(self) -> bool:
        """Whether anything touches."""
        return any(pad.tracks for pad in self.pads.values())


class Watcher:
    """Watches all pads of a source; one thread's only.

    Parameters
    ----------
    layouts : mapping of str to PadLayout, optional
        What the source says of its pads; those that it tells later are taken as they come.
    sensor : Sensor, optional
        What made the readings of all pads.
    model : PressClassifier or Perceiver, optional
        A model names each press while it lasts and when it has ended. A perceiver says of each press that has ended
        which object of its library it is by all presses of it; the press after the one that was enough, or after
        `next_object`, is of another.
    levels : int
        Thresholds a contact.

    Attributes
    ----------
    layouts : mapping of str to PadLayout
        To be set anew where the source has told more.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.live import Sample
    >>> from varishold.solids import Cone, ideal_frame
    >>> cone, noise = 100 * ideal_frame(Cone(8.0, 4.0), (16, 16), 1.0), np.random.default_rng(0)
    >>> with Watcher() as watcher:
    ...     for k in range(140):
    ...         frame = noise.normal(0, 1, (16, 16)) + (cone if k >= 120 else 0)
    ...         seen = watcher.see(Sample(k / 100, 0.0, k, {"pad": frame}))
    ...         for event in seen.pads["pad"].events:
    ...             print(event.kind, event.time_s)
    touched 1.2
    """

    def __init__(
        self,
        layouts: Mapping[str, PadLayout] | None = None,
        *,
        sensor: Sensor | None = None,
        model: PressClassifier | Perceiver | None = None,
        levels: int = 32,
    ) -> None:
        self.layouts = {} if layouts is None else layouts
        self._sensor, self._levels = sensor, levels
        self._clock = SteadyTime()
        self._pads: dict[str, PadWatcher] = {}
        self._newest: dict[str, SeenPad] = {}
        self._silence = PadSilence()
        self._keeper = PressKeeper()
        self._namer: PressNamer | None = None
        self._believer: PressBeliever | None = None
        self._asked_s = -np.inf
        self._next = 0
        self.learned(model)

    @property
    def pads(self) -> Mapping[str, PadWatcher]:
        """The pads that have been seen."""
        return self._pads

    @property
    def newest(self) -> Mapping[str, SeenPad]:
        """What was seen last of every pad."""
        return self._newest

    @property
    def now_s(self) -> float:
        """The time of the newest reading; 0 before the first."""
        return self._clock.now_s

    @property
    def classifier(self) -> PressClassifier | None:
        """What names each press by itself."""
        return self._classifier

    @property
    def perceiver(self) -> Perceiver | None:
        """What tells objects apart by all their presses."""
        return None if self._believer is None else self._believer.perceiver

    def learned(self, model: PressClassifier | Perceiver | None) -> None:
        """Name presses by another model or perceiver from now on; None for by none."""
        if self._namer is not None:
            self._namer.close()
        self._namer = self._believer = None
        classifier, perceiver = _told_apart(model)
        self._classifier = classifier
        if classifier is not None:
            self._namer = PressNamer(lambda kept: classifier.explain([self._right_way(kept).press])[0])
        elif perceiver is not None:
            from varishold.live.press_believer import PressBeliever

            self._believer = believer = PressBeliever(perceiver, self._pads)
            self._namer = PressNamer(lambda kept: believer(self._right_way(kept)))

    @property
    def wrong_way(self) -> str | None:
        """Why no press is named: a pad's readings fall where something presses; None where none's do."""
        return next(filter(None, (pad.wrong_way for pad in tuple(self._pads.values()))), None)

    def _right_way(self, kept: KeptPress) -> KeptPress:
        """Return a press of pads whose readings rise where something presses; InputError of others."""
        if (why := self.wrong_way) is not None:
            raise InputError(why)
        return kept

    def next_object(self) -> None:
        """Say that another object is pressed from now on, for a perceiver."""
        if self._believer is not None:
            self._believer.next_object()

    def see(self, sample: Sample, *, number: int | None = None) -> Seen:
        """Take the next reading.

        Parameters
        ----------
        sample : Sample
        number : int, optional
            Its running number, where some were missed. Default: the next.

        Raises
        ------
        InputError
            If the sensor that was given is another's.
        """
        number = self._next if number is None else number
        self._next = number + 1
        time_s = self._clock.time_s(sample)
        pads = {name: self._pad(name, raw).see(time_s, raw) for name, raw in sample.pads.items()}
        fallen, back = self._silence.look(time_s, pads)
        # What is told of a silent pad is over.
        pads |= {name: replace(pads[name], is_news=True) for name in back}
        pads |= {name: self._silent(name, time_s) for name in fallen}
        self._newest |= pads
        ended, named = self._press(time_s)
        return Seen(number, time_s, sample, pads, ended, named)

    def meanwhile(self) -> Seen | None:
        """Return the names that have come while no reading did; None where there are none."""
        named = () if self._namer is None else tuple(self._namer.done())
        return Seen(self._next, self.now_s, None, {}, None, named) if named else None

    def finish(self, timeout_s: float = 10.0) -> Seen | None:
        """Return what is left to tell when no reading comes any more; None where nothing ever came.

        What touches is released, and the names are waited for that presses have not got yet.
        """
        if not self._newest:
            return None
        time_s, keeper = self._clock.now_s, self._keeper
        pads = {
            name: replace(pad, tracks=(), events=self._pads[name].end(time_s), zeroings=())
            for name, pad in self._newest.items()
        }
        ended = keeper.so_far()
        keeper.begin_anew({name: pad.field for name, pad in self._pads.items()})
        named: tuple[NamedPress, ...] = ()
        if self._namer is not None:
            if ended is not None:
                self._namer.ask(ended, over=True)
            named = tuple(self._namer.finish(timeout_s))
        return Seen(self._next, time_s, None, pads, ended, named)

    def close(self) -> None:
        """Let the thread that names presses go. May be called again."""
        self.learned(None)

    def __enter__(self) -> Watcher:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _pad(self, name: str, raw: NDArray[Any]) -> PadWatcher:
        if raw.dtype.kind not in "biuf" or raw.ndim not in (1, 2):
            raise InputError(f"pad {name!r} must be numbers of one or two dimensions, got {raw.dtype} of {raw.shape}")
        known = self._pads.get(name)
        if known is None or known.shape != grid_of(raw.shape):
            # A pad that comes in another shape is another pad.
            told = self.layouts.get(name)
            layout = told if told is not None and told.shape == raw.shape else PadLayout(raw.shape)
            known = self._pads[name] = PadWatcher(
                name, layout, sensor=self._sensor, levels=self._levels, whole=raw.dtype.kind in "iu"
            )
            self._newest.pop(name, None)
            felt = {name: pad.field for name, pad in self._pads.items() if pad.layout.kind == "pressure"}
            self._keeper.begin_anew(felt, self._scale())
        return known

    def _silent(self, name: str, time_s: float) -> SeenPad:
        """Return a pad that comes no more: nothing is known to touch it."""
        last, nothing = self._newest[name], np.zeros_like(self._newest[name].frame)
        remarks = (*last.remarks, PAD_SILENT)
        events = self._pads[name].end(time_s)
        return replace(
            last, zeroed=nothing, frame=nothing, tracks=(), events=events, zeroings=(), remarks=remarks, is_news=True
        )

    def _scale(self) -> SensorScale:
        """Return the unit of presses, where all pads say one, and how far taxels are apart, as far as it is known."""
        felt = {name: pad for name, pad in self._pads.items() if pad.layout.kind == "pressure"}
        units = {pad.layout.unit for pad in felt.values()}
        return SensorScale(
            units.pop() if len(units) == 1 else UNKNOWN_UNIT,
            {name: pad.pitch_m for name, pad in felt.items() if pad.pitch_m is not None},
        )

    def _press(self, time_s: float) -> tuple[KeptPress | None, tuple[NamedPress, ...]]:
        """Return the press that has ended, and what the model has said meanwhile."""
        felt = {name: pad for name, pad in self._newest.items() if pad.layout.kind == "pressure"}
        touched = any(pad.tracks for pad in felt.values())
        works = {name: pad.works for name, pad in felt.items() if pad.works is not None}
        ended = self._keeper.see(time_s, {name: pad.zeroed for name, pad in felt.items()}, works, touched=touched)
        if self._namer is None:
            return ended, ()
        if ended is not None:
            self._namer.ask(ended, over=True)
        elif (
            self._believer is None
            and time_s - self._asked_s > _NAME_EVERY_S
            and self._namer.idle
            and (so_far := self._keeper.so_far()) is not None
        ):
            self._namer.ask(so_far, over=False)
            self._asked_s = time_s
        return ended, tuple(self._namer.done())


def _told_apart(model: PressClassifier | Perceiver | None) -> tuple[PressClassifier | None, Perceiver | None]:
    # The model itself says which it is, so that neither room is loaded for the other's.
    if model is None or hasattr(model, "explain"):
        return cast("PressClassifier | None", model), None
    return None, model
