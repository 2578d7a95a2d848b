"""What a source brings, checked and kept as it is: anybody may write one."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.live.sample import Sample
from varishold.live.source import Source

__all__ = ["as_source", "taken"]

_PARTS = ("address", "pads", "open", "read", "close")


def as_source(source: object) -> Source:
    """Return what is a source; InputError of anything else."""
    if isinstance(source, type):
        raise InputError(f"a source must be an object, got the class {source.__name__}; write {source.__name__}()")
    if missing := [part for part in _PARTS if not hasattr(source, part)]:
        raise InputError(
            f"a source must be an address, or have {', '.join(_PARTS)}; {type(source).__name__} lacks "
            f"{', '.join(missing)}"
        )
    return source  # type: ignore[return-value]


def taken(source: Source, timeout_s: float) -> list[Sample]:
    """Return the next readings of a source, whose arrays nobody writes into any more.

    Raises
    ------
    InputError
        If it brings something else.
    LostSourceError, EndOfSourceError
        As the source says.
    """
    came: object = source.read(timeout_s)
    if not isinstance(came, list | tuple) or isinstance(came, Sample):
        raise InputError(f"{source.address}: read must return a list of Sample, got {type(came).__name__}")
    return [_kept(sample, source.address) for sample in came]


def _kept(sample: object, where: str) -> Sample:
    if not isinstance(sample, Sample):
        raise InputError(f"{where}: read must return a list of Sample, got {type(sample).__name__} in it")
    for name, value, kind, of in (
        ("device_time_s", sample.device_time_s, Real, "seconds or None"),
        ("host_time_s", sample.host_time_s, Real, "seconds since 1970"),
        ("sequence", sample.sequence, Integral, "a whole number or None"),
    ):
        if not isinstance(value, kind) and (value is not None or name == "host_time_s"):
            raise InputError(f"{where}: {name} of a Sample must be {of}, got {value!r}")
    pads: object = sample.pads
    if not isinstance(pads, Mapping):
        raise InputError(f"{where}: pads of a Sample must be a mapping of names to arrays, got {type(pads).__name__}")
    return sample._replace(pads={name: _fixed(name, values, where) for name, values in pads.items()})


def _fixed(name: object, values: object, where: str) -> NDArray[Any]:
    """Return an array that stays as it is, whatever its owner writes into it next."""
    if not isinstance(values, np.ndarray):
        raise InputError(f"{where}: pad {name!r} must be an array, got {type(values).__name__}")
    if values.flags.writeable:
        values = values.copy()
        values.flags.writeable = False
    return values
