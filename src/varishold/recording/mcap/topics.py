"""What is called what in the file: topics, their types, and what is said of each pad."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.files import parse_json
from varishold.frame import as_pitch

__all__ = [
    "COUNTED",
    "IMAGE",
    "MARKS",
    "NOTES",
    "NUMBERS",
    "PAD",
    "PRESSES",
    "SCHEMAS",
    "STAMP",
    "STRING",
    "TYPE",
    "ZEROS",
    "PadFacts",
    "facts_of",
    "topic_of",
]

_LINE = "=" * 80
_TIME = f"{_LINE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
_HEADER = f"{_LINE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{_TIME}"
_DIMENSION = f"{_LINE}\nMSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n"
_LAYOUT = (
    f"{_LINE}\nMSG: std_msgs/MultiArrayLayout\nstd_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n{_DIMENSION}"
)

IMAGE, STRING = "sensor_msgs/msg/Image", "std_msgs/msg/String"
#: The message that holds signals of a type without loss; a type that is not listed is held by that of its kind's last.
NUMBERS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        **dict.fromkeys(("f2", "f4", "i1", "u1", "i2", "u2"), ("std_msgs/msg/Float32MultiArray", "<f4")),
        **dict.fromkeys(("f8", "i4", "u4"), ("std_msgs/msg/Float64MultiArray", "<f8")),
        "i8": ("std_msgs/msg/Int64MultiArray", "<i8"),
        "u8": ("std_msgs/msg/UInt64MultiArray", "<u8"),
    }
)
_WORDS = {"f4": "float32", "f8": "float64", "i8": "int64", "u8": "uint64"}

#: The text of every message type that is written.
SCHEMAS: Mapping[str, str] = MappingProxyType(
    {
        IMAGE: "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
        f"uint32 step\nuint8[] data\n{_HEADER}",
        STRING: "string data\n",
        **{
            name: f"std_msgs/MultiArrayLayout layout\n{_WORDS[dtype[1:]]}[] data\n{_LAYOUT}"
            for name, dtype in NUMBERS.values()
        },
    }
)

#: The metadata record that says what a pad is.
PAD = "varishold.pad"
#: What is said of a channel's messages: whose time their stamp is ("device", "host" or "none"), whether their number
#: is the sensor's own ("yes"), and of which type the values were.
STAMP, COUNTED, TYPE = "stamp", "counted", "type"
_OURS = "varishold/"
#: Topics of JSON text beside those of the pads: where each press begins and ends, what a person marked, the zeros.
NOTES = PRESSES, MARKS, ZEROS = tuple(f"/{_OURS}{name}" for name in ("press", "marks", "zero"))


def topic_of(pad: str) -> str:
    """Return the topic of a pad; no two have the same, and none that of anything else.

    Examples
    --------
    >>> topic_of("palm"), topic_of("varishold/press")
    ('/palm', '/pads/varishold/press')
    """
    return f"/pads/{pad}" if pad.startswith((_OURS, "pads/")) else f"/{pad}"


@dataclass(frozen=True, eq=False)
class PadFacts:
    """What is said of a pad once, whatever it reads.

    Parameters
    ----------
    name : str
    kind : {"pressure", "signals"}
    unit, sensor : str
    polarity : {"up", "down"}
    pitch_m : (float, float), optional
    field, valid : ndarray of shape (rows, cols), bool, optional
    positions_m : ndarray of shape (n_taxels, 2), optional
        Of taxels on no grid; an image is then one row of them.
    names : tuple of str
        What each signal is called.
    """

    name: str
    kind: Literal["pressure", "signals"] = "pressure"
    unit: str = "raw"
    sensor: str = ""
    polarity: Literal["up", "down"] = "up"
    pitch_m: tuple[float, float] | None = None
    field: NDArray[np.bool_] | None = None
    valid: NDArray[np.bool_] | None = None
    positions_m: NDArray[np.float64] | None = None
    names: tuple[str, ...] = ()

    def record(self) -> dict[str, str]:
        """Return the metadata record that says all this."""
        told: dict[str, str] = {"pad": self.name, "topic": topic_of(self.name), "kind": self.kind}
        told |= {"unit": self.unit, "sensor": self.sensor, "polarity": self.polarity}
        if self.pitch_m is not None:
            told["pitch_m"] = json.dumps([float(each) for each in self.pitch_m])
        for key in ("field", "valid"):
            if (mask := getattr(self, key)) is not None:
                told[key] = json.dumps(mask.astype(int).tolist(), separators=(",", ":"))
        if self.positions_m is not None:
            told["positions_m"] = json.dumps(self.positions_m.tolist())
        if self.names:
            told["names"] = json.dumps(list(self.names))
        return told


def facts_of(record: Mapping[str, str], *, where: str) -> PadFacts:
    """Return what a metadata record says of a pad; whether it fits the frames is not looked at.

    Raises
    ------
    FormatError
        If an entry cannot be meant.
    """
    values: dict[str, Any] = {key: record[key] for key in ("unit", "sensor") if key in record}
    for key, allowed in (("kind", ("pressure", "signals")), ("polarity", ("up", "down"))):
        values[key] = record.get(key, allowed[0])
        if values[key] not in allowed:
            raise FormatError(f"{where}: {key} must be {' or '.join(allowed)}, got {values[key]!r}")
    for key in ("pitch_m", "field", "valid", "positions_m", "names"):
        if key in record:
            values[key] = _parsed(key, parse_json(record[key], where=f"{where}: {key}"), where)
    return PadFacts(record.get("pad", ""), **values)


def _parsed(key: str, value: Any, where: str) -> Any:
    if key == "pitch_m":
        try:
            return as_pitch(value)
        except InputError as error:
            raise FormatError(f"{where}: {error}") from None
    if key == "names":
        return tuple(str(each) for each in value) if isinstance(value, list) else ()
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.empty(0, object)
    if array.dtype.kind not in "iuf" or not array.size:
        raise FormatError(f"{where}: {key} must be numbers, equally many in each row, got {str(value)[:60]!r}")
    return array != 0 if key in ("field", "valid") else array
