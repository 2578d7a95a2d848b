"""The shapes of messages that are understood, in one registry, and the function that reads by it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

from varishold.errors import InputError
from varishold.recording.messages.arrays import asked_pads, grids_pads, multi_array_pads, plain_pads
from varishold.recording.messages.clouds import cloud_pads
from varishold.recording.messages.fields import (
    Fields,
    fields_of,
    is_empty_list,
    messages_in,
    number_at,
    numbers_in,
    odd_row,
)
from varishold.recording.messages.images import image_pads
from varishold.recording.messages.reading import Asked, MessagePad, MessageReading
from varishold.recording.messages.tactile import (
    biotac_pads,
    cell_pads,
    inspire_pads,
    magnetic_pads,
    pillar_pads,
    robotis_pads,
    tac3d_pads,
    wuji_pads,
    xela_pads,
    xela_words_pads,
)
from varishold.recording.pad import UNNAMED_PAD

__all__ = ["MESSAGES", "MessageShape", "read_message", "readable_name"]


@dataclass(frozen=True)
class MessageShape:
    """One shape of message.

    Parameters
    ----------
    title : str
        What sends it.
    needs : tuple of str
        Fields that it has, in small letters.
    pads : callable
        Takes the fields and what was asked for; returns pads by name, or None where the fields hold something else.
        The name of the whole message's pad is empty; one that ends with a dot stands before the pad's own name.
    called : tuple of str
        The fields that may hold its name.
    clock : tuple of (str, float)
        The fields that may hold its own time, and the seconds of a unit.
    number : str
        The field that holds its own number of the reading.
    """

    title: str
    needs: tuple[str, ...]
    pads: Callable[[Fields, Asked], Mapping[str, MessagePad] | None]
    called: tuple[str, ...] = ()
    clock: tuple[tuple[str, float], ...] = ()
    number: str = ""


# A person's own JSON: fields that say which pad it is of; a number called id is that of the message as often.
_PLAIN_NAMES = ("name", "pad", "sensor", "sensor_name", "sensor_id", "finger")
# The name of a time says its unit.
_PLAIN_CLOCK = (
    *(
        (f"{name}{unit}", unit_s)
        for unit, unit_s in (("_s", 1.0), ("_ms", 1e-3), ("_us", 1e-6), ("_ns", 1e-9))
        for name in ("time", "timestamp", "t")
    ),
)
# These names do not, and are taken where their numbers are of the calendar: between two powers of ten of seconds.
_BARE_CLOCK, _CALENDAR = ("timestamp", "time", "t"), (1e9, 1e10)
_WUJI_CLOCK = (("device_timestamp", 1e-3), ("device_timestamp_ms", 1e-3))

#: Every shape; the first that fits reads a message, so a special one stands before a general one.
MESSAGES: Mapping[str, MessageShape] = MappingProxyType(
    {
        "image": MessageShape("sensor_msgs/Image", ("encoding", "data", "width", "height"), image_pads),
        "cloud": MessageShape("sensor_msgs/PointCloud2", ("fields", "point_step", "data"), cloud_pads),
        "array": MessageShape("std_msgs/Float32MultiArray and its kin", ("layout", "data"), multi_array_pads),
        "xela": MessageShape("XELA SensStream", ("taxels",), xela_pads, ("sensor_pos",), (("time", 1.0),), "message"),
        "xela-words": MessageShape(
            "XELA's WebSocket", ("sensor", "model", "data"), xela_words_pads, ("sensor",), (("time", 1.0),)
        ),
        "contactile": MessageShape("Contactile SensorState", ("pillars",), pillar_pads, (), (("tus", 1e-6),)),
        "biotac": MessageShape("BioTac", ("electrodes",), biotac_pads),
        "matrix": MessageShape(
            "Schunk TactileMatrix, PressureArray", ("cells_x", "cells_y"), cell_pads, ("sensor_name", "matrix_id")
        ),
        "robotis": MessageShape("ROBOTIS TactileSensor", ("pressure_values",), robotis_pads, ("sensor_name",)),
        "wuji": MessageShape(
            "Wuji TactileFrame", ("hand", "sequence", "pressure"), wuji_pads, (), _WUJI_CLOCK, "sequence"
        ),
        "inspire": MessageShape("Inspire's hand", (), inspire_pads),
        "tac3d": MessageShape(
            "Tac3D Frame", ("forces", "displacements"), tac3d_pads, ("sn",), (("sendtimestamp", 1.0),), "index"
        ),
        "mst": MessageShape("Shadow MST", ("magnetic_data",), magnetic_pads),
        "plain": MessageShape(
            "an array under a telling name, as in tactile_msgs", (), plain_pads, _PLAIN_NAMES, _PLAIN_CLOCK
        ),
        "grids": MessageShape("JSON of rows and columns, by any name", (), grids_pads, (), _PLAIN_CLOCK),
    }
)

# Messages within messages are looked into so deeply, and for so many pads.
_DEEPEST, _MOST_PADS = 6, 1024


def read_message(message: object, *, shape: tuple[int, int] | None = None, field: str | None = None) -> MessageReading:
    """Return what a message says of a touch, by its shape.

    A message that is none of `MESSAGES` is looked into: its fields may hold such messages, or lists of them, each of
    which is then a pad by its own name or by that of its field.

    Parameters
    ----------
    message : object
        Taken apart by rosbags or rclpy, or of JSON (a mapping).
    shape : (int, int), optional
        Rows and columns, where values come in one row; so many times their product makes several pads.
    field : str, optional
        The field that holds the values, with dots between fields in fields: of a cloud of points, the point's.

    Returns
    -------
    MessageReading

    Raises
    ------
    InputError
        If nobody understands it, or it is not what its own fields say. Its `parameter` names what would mend it.

    Examples
    --------
    >>> said = read_message({"sensors": [{"name": "tip", "values": [1.0, 2.0, 3.0, 4.0]}]}, shape=(2, 2))
    >>> said.pads["tip"].values.tolist()
    [[1.0, 2.0], [3.0, 4.0]]
    """
    asked = Asked(shape, field)
    fields = fields_of(message)
    if fields is None:
        raise InputError(f"a message has fields, and {type(message).__name__} has none")
    if field is not None and (picked := asked_pads(fields, asked)) is not None:
        found = [_Found("", picked, _own_time(fields, MESSAGES["plain"]), None)]
    else:
        found = list(_found_in(fields, asked, "", 0))
    if not found and not _holds_nothing(fields):
        for name, value in fields.items():
            if odd := odd_row(value):
                raise InputError(f"rows of {name!r} are unlike: {odd}; send as many values in each")
        raise InputError(_not_understood(message, fields, asked), parameter="field")
    times = [each.time_s for each in found if each.time_s is not None]
    numbers = [each.number for each in found if each.number is not None]
    stamp, header_number = _header(fields)
    return MessageReading(_named(found), times[0] if times else stamp, numbers[0] if numbers else header_number)


class _Found(NamedTuple):
    """A shape that was found in a message, and under which name."""

    name: str
    pads: Mapping[str, MessagePad]
    time_s: float | None
    number: int | None


def _found_in(fields: Fields, asked: Asked, name: str, depth: int) -> Iterator[_Found]:
    for shape in MESSAGES.values():
        if all(need in fields for need in shape.needs) and (pads := shape.pads(fields, asked)) is not None:
            yield _Found(_own_name(fields, shape) or name, pads, _own_time(fields, shape), _own_number(fields, shape))
            return
    if depth == _DEEPEST:
        return
    for field, value in fields.items():
        if field in ("header", "stamp"):
            continue
        below = f"{name}_{field}" if name else field
        within = fields_of(value)
        if within is not None:
            yield from _found_in(within, asked, below, depth + 1)
        else:
            for number, item in enumerate(messages_in(value)):
                yield from _found_in(item, asked, f"{below}_{number}", depth + 1)


def _named(found: list[_Found]) -> dict[str, MessagePad]:
    """Return all pads by their names, each name once."""
    pads: dict[str, MessagePad] = {}
    for each in found:
        name, taken = each.name, 1
        while any(_pad_name(name, part) in pads for part in each.pads):
            taken += 1
            name = f"{each.name or UNNAMED_PAD}_{taken}"
        pads |= {_pad_name(name, part): pad for part, pad in each.pads.items()}
        if len(pads) > _MOST_PADS:
            raise InputError(f"a message of more than {_MOST_PADS} pads came")
    return pads


def _pad_name(name: str, part: str) -> str:
    if part.endswith("."):
        return readable_name(part + (name or UNNAMED_PAD))
    return readable_name(f"{name}_{part}" if name and part else name or part or UNNAMED_PAD)


def readable_name(name: str) -> str:
    """Return a name as a recording may hold it: what cannot be printed stands as its code, and it is not blank."""
    if name.isprintable():
        return name if name.strip() else UNNAMED_PAD
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in name)


def _own_name(fields: Fields, shape: MessageShape) -> str:
    for called in shape.called:
        value = fields.get(called)
        if isinstance(value, str | int) and not isinstance(value, bool):
            text = "".join(letter for letter in str(value)[:80] if letter.isprintable()).strip()
            if text:
                return text
    return ""


def _own_time(fields: Fields, shape: MessageShape) -> float | None:
    for name, unit_s in shape.clock:
        value = number_at(fields, name)
        if value is not None:
            return value * unit_s
    return _calendar_time(fields) if shape.clock is _PLAIN_CLOCK else None


def _calendar_time(fields: Fields) -> float | None:
    """Return a time since 1970 in seconds, of a date or a number; its size tells whether it counts parts of them."""
    for text in (fields.get(name) for name in _BARE_CLOCK):
        if isinstance(text, str):
            from varishold.recording.formats.csv_dates import date_seconds

            return date_seconds(text)
    value = _first_number(fields, *_BARE_CLOCK)
    units = (unit_s for unit_s in (1.0, 1e-3, 1e-6, 1e-9) if value is not None)
    return next((value * u for u in units if value is not None and _CALENDAR[0] <= value * u < _CALENDAR[1]), None)


def _own_number(fields: Fields, shape: MessageShape) -> int | None:
    value = number_at(fields, shape.number) if shape.number else None
    return None if value is None else int(value)


def _header(fields: Fields) -> tuple[float | None, int | None]:
    """Return the stamp, seconds, and the number in a message's header; None for what it has not."""
    header = fields_of(fields.get("header")) or fields
    number = _first_number(header, "seq", "sequence", "message")
    for name in ("stamp", "timestamp"):
        stamp = fields_of(header.get(name))
        if stamp is None:
            continue
        whole = _first_number(stamp, "sec", "secs")
        parts = _first_number(stamp, "nanosec", "nsec", "nsecs", "nanosecs")
        if whole is not None and parts is not None and (whole or parts):
            return whole + parts * 1e-9, None if number is None else int(number)
    return None, None if number is None else int(number)


def _first_number(fields: Fields, *names: str) -> float | None:
    return next((value for name in names if (value := number_at(fields, name)) is not None), None)


def _holds_nothing(fields: Fields) -> bool:
    return any(is_empty_list(value) for value in fields.values())


def _not_understood(message: object, fields: Fields, asked: Asked) -> str:
    kind = getattr(message, "__msgtype__", "a message")
    said = ", ".join(name + _dims(value) for name, value in list(fields.items())[:40]) or "none"
    if asked.field is not None:
        return f"{kind} has no array of numbers called {asked.field!r}; its fields are {said}"
    return f"{kind} is not understood: its fields are {said}; name the one that holds the values as field"


def _dims(value: object) -> str:
    numbers = numbers_in(value)
    if numbers is not None:
        return f"[{' x '.join(map(str, numbers.shape))}]"
    return f"[{len(value)}]" if isinstance(value, list | tuple) else ""
