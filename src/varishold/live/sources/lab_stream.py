"""``lsl:NAME`` a stream of the Lab Streaming Layer, whose description may tell rows and columns."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varishold._counted import counted
from varishold._lazy import missing_extra
from varishold.errors import InputError, LostSourceError
from varishold.live.address import Address
from varishold.live.sample import UNNAMED_PAD, PadLayout, Sample
from varishold.live.sources.kind import SourceKind

if TYPE_CHECKING:
    from pylsl import StreamInfo, StreamInlet

__all__ = ["KIND", "LabStream"]

# A stream is looked for, opened and asked for its description so long. Seconds.
_FIND_S, _OPEN_S = 1.0, 1.0
# A stream that promises at least so many readings a second is gone when it is silent so long. Per second, seconds.
_STEADY_HZ, _SILENT_S = 4.0, 0.9
# Seconds of readings that the library keeps until they are read, and readings that are taken together.
_KEPT_S, _AT_ONCE = 10, 256
_MOST_VALUES = 1 << 20
_TYPES = {1: "float32", 2: "float64", 4: "int32", 5: "int16", 6: "int8", 7: "int64"}


class LabStream:
    """A stream of the Lab Streaming Layer.

    Its description's ``rows`` and ``cols`` are the pad's, its ``pitch_m`` the spacing of taxels, and the labels of its
    channels what they are called where they stand on no grid.

    Parameters
    ----------
    address : Address
        Its options: shape, which goes before the description; source, the identity of one among several streams of
        the same name.
    """

    def __init__(self, address: Address) -> None:
        address.only("shape", "source")
        self._address, self._name = address.text, address.place
        self._shape, self._source = address.shape(), address.options.get("source")
        if not self._name:
            raise InputError(f"{address.text}: must name a stream, as in {KIND.example}")
        _library()
        self._inlet: StreamInlet | None = None
        self._layout: PadLayout | None = None
        # Of the stream that is open.
        self._type: str
        self._heard_s: float
        self._rate_hz: float

    @property
    def address(self) -> str:
        return self._address

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return {} if self._layout is None else {UNNAMED_PAD: self._layout}

    def open(self) -> None:
        pylsl = _library()
        self.close()
        found = pylsl.resolve_byprop("name", self._name, minimum=1, timeout=_FIND_S)
        found = [info for info in found if self._source in (None, info.source_id())]
        if not found:
            raise LostSourceError(f"{self._address}: no such stream is in reach")
        inlet = pylsl.StreamInlet(found[0], max_buflen=_KEPT_S, recover=False)
        try:
            inlet.open_stream(timeout=_OPEN_S)
            info = inlet.info(timeout=_OPEN_S)
        except (pylsl.util.LostError, pylsl.util.TimeoutError) as error:
            raise LostSourceError(f"{self._address}: the stream does not answer: {error}") from None
        self._layout, self._type = self._layout_of(info), self._type_of(info)
        self._inlet, self._rate_hz, self._heard_s = inlet, info.nominal_srate(), time.monotonic()

    def read(self, timeout_s: float) -> list[Sample]:
        inlet, layout = self._inlet, self._layout
        if inlet is None or layout is None:
            raise LostSourceError(f"{self._address}: is not open")
        try:
            first, at_s = inlet.pull_sample(timeout=timeout_s)
            if first is None:
                self._look_alive()
                return []
            more, times = inlet.pull_chunk(timeout=0.0, max_samples=_AT_ONCE)
        except _library().util.LostError:
            raise LostSourceError(f"{self._address}: the stream has ended") from None
        now_s = time.time()
        self._heard_s = time.monotonic()
        frames = np.array([first, *(more if times else [])], self._type).reshape(-1, *layout.shape)
        return [
            Sample(device_s if math.isfinite(device_s) else None, now_s, None, {UNNAMED_PAD: frame})
            for device_s, frame in zip([at_s, *times], frames, strict=True)
        ]

    def close(self) -> None:
        inlet, self._inlet = self._inlet, None
        if inlet is not None:
            inlet.close_stream()

    def _look_alive(self) -> None:
        silent_s = time.monotonic() - self._heard_s
        if self._rate_hz >= _STEADY_HZ and silent_s > _SILENT_S:
            raise LostSourceError(
                f"{self._address}: is silent for {silent_s:.1f} s, and promises {self._rate_hz:g} readings a second"
            )

    def _type_of(self, info: StreamInfo) -> str:
        found = _TYPES.get(info.channel_format())
        if found is None:
            raise InputError(f"{self._address}: sends text; a stream of numbers is needed")
        return found

    def _layout_of(self, info: StreamInfo) -> PadLayout:
        count = info.channel_count()
        if not 0 < count <= _MOST_VALUES:
            raise InputError(f"{self._address}: has {counted(count, 'channel')}")
        rows, cols = _number(info, "rows"), _number(info, "cols")
        shape = self._shape or (None if rows is None or cols is None else (int(rows), int(cols)))
        if shape is not None and math.prod(shape) != count:
            raise InputError(
                f"{self._address}: has {counted(count, 'channel, which is', 'channels, which are')} "
                f"no {shape[0]} x {shape[1]}; "
                "add ?shape=ROWSxCOLS to the address",
                parameter="shape",
            )
        labels, units = _channels(info)
        unit = units.pop() if len(units) == 1 else "raw"
        if shape is None:
            return PadLayout((count,), "signals" if labels else "pressure", unit=unit, names=labels)
        pitch_m = _number(info, "pitch_m")
        return PadLayout(shape, unit=unit, pitch_m=None if not pitch_m else (pitch_m, pitch_m))


def _number(info: StreamInfo, name: str) -> float | None:
    """Return a number of the stream's description; None where it has none that is finite and above 0."""
    try:
        value = float(info.desc().child_value(name))
    except ValueError:
        return None
    return value if 0 < value < _MOST_VALUES else None


def _channels(info: StreamInfo) -> tuple[tuple[str, ...], set[str]]:
    """Return the labels of all channels, none where not each has its own, and all their units."""
    channel = info.desc().child("channels").child("channel")
    labels: list[str] = []
    units: set[str] = set()
    while not channel.empty() and len(labels) <= _MOST_VALUES:
        labels.append(channel.child_value("label"))
        units.add(channel.child_value("unit"))
        channel = channel.next_sibling("channel")
    whole = len(set(labels) - {""}) == info.channel_count() == len(labels)
    return tuple(labels) if whole else (), units - {""}


@cache
def _library() -> Any:
    try:
        import pylsl
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    except (OSError, RuntimeError) as error:
        raise InputError(f"the library of the Lab Streaming Layer cannot be loaded: {error}") from None
    # It prints its progress unless told not to; whoever has a configuration of his own keeps it.
    folders = (Path(), Path.home() / "lsl_api", Path("/etc/lsl_api"))
    own = "LSLAPICFG" in os.environ or any((folder / "lsl_api.cfg").exists() for folder in folders)
    if not own and hasattr(pylsl, "set_config_content"):
        pylsl.set_config_content("[log]\nlevel = -3\n")
    return pylsl


def _found() -> list[tuple[str, str]]:
    streams = _library().resolve_streams(_FIND_S * 0.8)
    return sorted(
        (
            f"lsl:{info.name()}",
            f"{info.type() or 'a stream'}, {counted(info.channel_count(), 'channel')}, {info.nominal_srate():g} Hz",
        )
        for info in streams
    )


KIND = SourceKind("a stream of the Lab Streaming Layer", "lsl:skin", LabStream, _found, ("pylsl",))
