"""Messages of robots, understood by their shape and not by the package that they come from.

`read_message` takes a message, whoever took it apart, and returns its pads; `message_decoder` takes bytes apart by
the text of their type. One entry of `MESSAGES` a shape: a new one is a function and a line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "MESSAGES",
    "MessagePad",
    "MessageReading",
    "MessageShape",
    "message_decoder",
    "read_message",
    "readable_name",
]

if TYPE_CHECKING:
    from varishold.recording.messages.decoding import message_decoder
    from varishold.recording.messages.reading import MessagePad, MessageReading
    from varishold.recording.messages.shapes import MESSAGES, MessageShape, read_message, readable_name
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
