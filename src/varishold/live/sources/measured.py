"""What `varishold record` wrote, played as it came: pads and signals together or apart, with the sensor's numbers."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import EndOfSourceError, LostSourceError
from varishold.live.pace import Pace
from varishold.live.sample import PadLayout, Sample
from varishold.live.unsaid import Reading, places
from varishold.recording.mcap import Moment, Moments, PadFacts

__all__ = ["Measured"]

# Moments that are read ahead of their time.
_AHEAD = 256


class Measured:
    """A file of this program's that is played in bounded memory, by the clock of the machine that wrote it.

    Parameters
    ----------
    address : str
    file : str
        An MCAP file.
    speed : float
        Its seconds in one of ours; 0 for as fast as it goes.
    loop : bool
        Whether it begins again at its end; its time goes on.
    reading : Reading
        Pitch and polarity go before what the file says; the shape is that of taxels in one row.
    """

    def __init__(self, address: str, file: str, *, speed: float, loop: bool, reading: Reading) -> None:
        self._address, self._file, self._loop, self._reading = address, file, loop, reading
        self._pace = Pace(speed)
        self._moments: Moments | None = None
        self._layouts: dict[str, PadLayout] = {}

    @property
    def address(self) -> str:
        return self._address

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return self._layouts

    def open(self) -> None:
        self.close()
        #: When the reading before was due, since the beginning; how long the turns before took, and the last step.
        self._due_s = self._turned_s = self._step_s = 0.0
        self._number = 0
        self._ahead: deque[tuple[float, Moment]] = deque()
        self._turn()
        self._fill()
        self._pace.restart()

    def read(self, timeout_s: float) -> list[Sample]:
        if self._moments is None:
            raise LostSourceError(f"{self._address}: is not open")
        self._fill()
        if not self._ahead:
            early = f"; {self._moments.early}" if self._moments.early else ""
            raise EndOfSourceError(f"{self._address}: {counted(self._number, 'reading')}, all of the file{early}")
        first = self._number
        last = self._pace.due(lambda number: self._ahead[number - first][0], first, first + len(self._ahead), timeout_s)
        self._number = last
        return [self._sample(*self._ahead.popleft()) for _ in range(last - first)]

    def close(self) -> None:
        if self._moments is not None:
            self._moments.close()
            self._moments = None

    def _turn(self) -> None:
        """Begin with the first moment."""
        self.close()
        self._moments = Moments(self._file)
        self._coming: Iterator[Moment] = iter(self._moments)
        self._began_s: float | None = None

    def _fill(self) -> None:
        while len(self._ahead) < _AHEAD:
            moment = next(self._coming, None)
            if moment is None:
                # A file without a moment would be turned for ever.
                if not self._loop or self._began_s is None:
                    return
                self._turned_s = self._due_s + self._step_s
                self._turn()
                continue
            if self._began_s is None:
                self._began_s = moment.host_time_s
            # One whose time goes back is due at once.
            due_s = max(self._turned_s + moment.host_time_s - self._began_s, self._due_s)
            self._step_s, self._due_s = due_s - self._due_s, due_s
            if moment.device_time_s is not None:
                moment = moment._replace(device_time_s=moment.device_time_s + self._turned_s)
            self._ahead.append((due_s, moment))
            self._know(moment)

    def _know(self, moment: Moment) -> None:
        """Take in the pads that are new."""
        new = {name: values for name, values in moment.pads.items() if name not in self._layouts}
        if new and self._moments is not None:
            facts = self._moments.facts
            told = {name: self._layout(facts[name], values) for name, values in new.items()}
            # Who looks at the pads meanwhile sees the old ones or all.
            self._layouts = {**self._layouts, **told}

    def _layout(self, facts: PadFacts, values: NDArray[Any]) -> PadLayout:
        how = self._reading
        return PadLayout(
            self._shaped(values).shape,
            facts.kind,
            facts.pitch_m if how.pitch_m is None else (how.pitch_m, how.pitch_m),
            facts.unit,
            "down" if how.polarity == "down" else facts.polarity,
            facts.names,
            places(facts.field),
            places(facts.valid),
        )

    def _sample(self, due_s: float, moment: Moment) -> Sample:
        pads = {name: np.array(self._shaped(values)) for name, values in moment.pads.items()}
        return Sample(moment.device_time_s, self._pace.host_time_s(due_s), moment.sequence, pads)

    def _shaped(self, values: NDArray[Any]) -> NDArray[Any]:
        shape = self._reading.shape
        # Taxels on no grid stand in a row, with or without a first axis.
        return values.reshape(shape) if shape and values.shape[-1] == values.size == shape[0] * shape[1] else values
