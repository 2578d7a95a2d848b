"""``stdin:`` what another program writes: lines of JSON, rows of text, or any framing."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Mapping

from varishold._counted import counted
from varishold.errors import EndOfSourceError, InputError
from varishold.live.address import Address
from varishold.live.piped import PIPE_OPTIONS, Unpacking, unpacking_at
from varishold.live.sample import PadLayout, Sample
from varishold.live.sources.kind import SourceKind

__all__ = ["KIND", "StandardInput"]

_AT_ONCE = 1 << 16


class StandardInput:
    """A pipe on standard input. Where the system cannot wait for a pipe, reading waits until something comes.

    Parameters
    ----------
    address : str
    unpacking : Unpacking
    rate_hz : float, optional
        Frames a second, where they carry no time and do not come when they are measured.
    """

    def __init__(self, address: str, unpacking: Unpacking, *, rate_hz: float | None = None) -> None:
        self._address = address
        self._unpacking = unpacking
        self._rate_hz = rate_hz
        self._count = 0
        self._is_over = False
        self._n_bytes, self._n_samples = 0, 0

    @property
    def address(self) -> str:
        return self._address

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return self._unpacking.pads

    @property
    def damaged(self) -> int:
        """How often something was not as it should be."""
        return self._unpacking.damaged

    @property
    def damage(self) -> str:
        """What was wrong with the newest of it, where that is known."""
        return self._unpacking.damage

    def open(self) -> None:
        if sys.stdin is None or sys.stdin.closed:
            raise InputError(f"{self._address}: there is no standard input")
        if sys.stdin.isatty():
            raise InputError(f"{self._address}: nothing is piped in; write PROGRAM | varishold ... {self._address}")

    def read(self, timeout_s: float) -> list[Sample]:
        if self._is_over and not self._n_samples:
            why = f": {self.damage}" if self.damage else ""
            came = (
                f"{counted(self._n_bytes, 'byte')} came and no frame was in them{why}"
                if self._n_bytes
                else "nothing came"
            )
            raise InputError(
                f"{self._address}: {came}; write JSON, or rows of text and a blank line, or say "
                "what comes: ?preset=NAME (a line a frame: ?preset=arduino-line&shape=ROWSxCOLS)"
            )
        if self._is_over:
            raise EndOfSourceError(f"{self._address}: the program that wrote has ended")
        handle = sys.stdin.fileno()
        if os.name == "posix" and not select.select([handle], [], [], timeout_s)[0]:
            return []
        data = os.read(handle, _AT_ONCE)
        self._is_over = not data
        samples = self._unpacking.samples(data) if data else self._unpacking.finish()
        self._n_bytes += len(data)
        self._n_samples += len(samples)
        return samples if self._rate_hz is None else [self._timed(sample, self._rate_hz) for sample in samples]

    def close(self) -> None:
        """Standard input is the program's own and stays as it is."""

    def _timed(self, sample: Sample, rate_hz: float) -> Sample:
        self._count += 1
        own = sample.device_time_s is not None
        return sample if own else sample._replace(device_time_s=(self._count - 1) / rate_hz)


def _make(address: Address) -> StandardInput:
    address.only(*PIPE_OPTIONS, "rate_hz")
    if address.place not in ("", "-"):
        raise InputError(f"{address.text}: stdin has no place; write stdin:?preset=NAME")
    rate_hz = address.number("rate_hz", 0.0, least=1e-3, most=1e6) or None
    return StandardInput(address.text, unpacking_at(address), rate_hz=rate_hz)


KIND = SourceKind("another program's output", "stdin:?preset=arduino-line&shape=8x8", _make)
