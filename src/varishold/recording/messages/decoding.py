"""Bytes of messages, taken apart by the text of their type, which comes with them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from varishold._lazy import missing_extra
from varishold.errors import InputError
from varishold.files.documents import parse_json

__all__ = ["ENCODINGS", "message_decoder", "ros_type_name"]

#: Encodings of messages that are understood.
ENCODINGS = ("cdr", "ros1", "json")

# Far above what a message's type needs, for each of its types is made into code before the first message.
_LONGEST_TEXT, _MOST_UNROLLED = 1 << 18, 1024
_TYPE_NAME = re.compile(r"[A-Za-z]\w*(/[A-Za-z]\w*){1,3}", re.ASCII)


def message_decoder(
    encoding: str, type_name: str = "", text: str = "", text_encoding: str = ""
) -> Callable[[bytes], Any]:
    """Return the function that makes a message of its bytes, and raises InputError where they are none.

    Parameters
    ----------
    encoding : {"cdr", "ros1", "json"}
        How messages are written.
    type_name : str
        As in ``sensor_msgs/msg/Image``; the middle part may be missing.
    text : str
        The type's definition with those of all types in it, as bags and bridges hold it. Empty: a standard type.
    text_encoding : {"", "ros2msg", "ros1msg", "ros2idl"}
        How that is written.

    Raises
    ------
    InputError
        If the encoding is not understood, or the text is no definition of the type.
    MissingExtraError
        If rosbags is needed and not installed.
    """
    if encoding == "json":
        return _decode_json
    if encoding not in ENCODINGS:
        raise InputError(f"messages encoded as {encoding!r} cannot be read; {', '.join(ENCODINGS)} can")
    try:
        from rosbags.typesys import Stores, get_typestore
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    name = ros_type_name(type_name)
    types = _types_of(name, text, text_encoding) if text.strip() else {}
    needed = dict(_needed(name, types, get_typestore(Stores.LATEST).fielddefs))
    store = get_typestore(Stores.EMPTY)
    try:
        store.register(needed)
        store.get_msgdef(name)
    except Exception as error:
        raise InputError(f"the definition of {name} cannot be used: {error}") from None
    deserialize = store.deserialize_cdr if encoding == "cdr" else store.deserialize_ros1

    def decode(content: bytes) -> Any:
        try:
            return deserialize(content, name)
        except Exception as error:
            raise InputError(f"{len(content)} bytes are no {name}: {error}") from None

    return decode


def ros_type_name(name: str) -> str:
    """Return a type's name with all its parts, as in ``sensor_msgs/msg/Image``.

    Raises
    ------
    InputError
        If it is no name of a type.

    Examples
    --------
    >>> ros_type_name("sensor_msgs/Image"), ros_type_name("sensor_msgs::msg::dds_::Image_")
    ('sensor_msgs/msg/Image', 'sensor_msgs/msg/Image')
    """
    parts = [part for part in name.replace("::", "/").split("/") if part != "dds_"]
    if "::" in name:
        parts[-1] = parts[-1].removesuffix("_")
    if len(parts) == 2:
        parts.insert(1, "msg")
    whole = "/".join(parts)
    if len(whole) > 200 or not _TYPE_NAME.fullmatch(whole):
        raise InputError(f"{name[:100]!r} is no name of a message's type; it must be as sensor_msgs/msg/Image")
    return whole


def _decode_json(content: bytes) -> Any:
    try:
        text = content.decode()
    except UnicodeDecodeError:
        raise InputError(f"{len(content)} bytes are no JSON: no UTF-8") from None
    return parse_json(text, where="a message", finite=False)


def _types_of(name: str, text: str, text_encoding: str) -> dict[str, Any]:
    """Return the parsed types of a definition."""
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    if len(text) > _LONGEST_TEXT:
        raise InputError(f"the definition of {name} has {len(text)} letters; {_LONGEST_TEXT} are the most")
    # The text of a ROS 1 type ends its lines as it likes.
    plain = text.replace("\r\n", "\n")
    try:
        types = get_types_from_idl(plain) if text_encoding == "ros2idl" else get_types_from_msg(plain, name)
    except Exception as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"the definition of {name} cannot be read: {type(error).__name__}: {reason}") from None
    return dict(types)


def _needed(name: str, types: Mapping[str, Any], standard: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield a type and all types in it, each once; refuse what would never end or fill the memory."""
    done: set[str] = set()
    unrolled = 0

    def visit(which: str, above: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
        nonlocal unrolled
        if which in above:
            raise InputError(f"the definition of {name} holds {which} within itself")
        if which in done:
            return
        if not _TYPE_NAME.fullmatch(which):
            raise InputError(f"the definition of {name} names {which!r}, which is no type")
        found = types.get(which) or standard.get(which)
        if found is None:
            raise InputError(f"the definition of {name} lacks that of {which}")
        done.add(which)
        for field, description in found[1]:
            kind, inner = int(description[0]), description[1]
            if kind == _ARRAY and inner[1] < 1:
                raise InputError(f"the definition of {name} has an array of no length, {field} of {which}")
            within = inner[0] if kind in (_ARRAY, _SEQUENCE) else description
            if kind == _ARRAY and (int(within[0]) == _NAME or within[1][0] == "string"):
                unrolled += inner[1]
            if int(within[0]) == _NAME:
                yield from visit(within[1], (*above, which))
        if unrolled > _MOST_UNROLLED or len(done) > _MOST_UNROLLED:
            raise InputError(f"the definition of {name} holds more than {_MOST_UNROLLED} messages of fixed number")
        yield which, (found[0], found[1])

    yield from visit(name, ())


# As rosbags numbers what a field is.
_NAME, _ARRAY, _SEQUENCE = 2, 3, 4
