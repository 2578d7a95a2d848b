"""What a viewer of robots' data gets: Foxglove's protocol, with the messages that a recording holds.

References
----------
"Foxglove WebSocket protocol", version 1, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping
from typing import Any

from websockets.typing import Subprotocol

from varishold.live.sample import PadLayout, Sample
from varishold.live.session import Session
from varishold.recording.mcap.cdr import string_message
from varishold.recording.mcap.clock import nanoseconds
from varishold.recording.mcap.coding import MessageCoder
from varishold.recording.mcap.notes import note_text
from varishold.recording.mcap.topics import SCHEMAS, STRING, PadFacts, topic_of

__all__ = ["EVENTS_TOPIC", "SUBPROTOCOLS", "Viewer"]

#: Old viewers speak the one, new ones the other; what is said here is the same in both.
SUBPROTOCOLS = (Subprotocol("foxglove.sdk.v1"), Subprotocol("foxglove.websocket.v1"))
#: What happens, each as JSON text.
EVENTS_TOPIC = "/varishold/event"

# struct: opcode of a message, subscription, time in nanoseconds.
_MESSAGE = struct.Struct("<BIQ")
_DATA, _WARNING = 1, 1
_MOST_SUBSCRIPTIONS = 256
_LATEST_NS = 2**64 - 1


class Viewer:
    """What one viewer is told, and what it wants.

    Parameters
    ----------
    session : Session
        What is watched.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._reader = session.stream.reader()
        self._reader.skip_all()
        self._events = session.events.count
        self._coder = MessageCoder()
        self._channels: dict[tuple[str, str], int] = {}
        self._subscriptions: dict[int, int] = {}
        self._channel(EVENTS_TOPIC, STRING)

    def greeting(self) -> list[str]:
        """Return what it is told first."""
        info = {"op": "serverInfo", "name": f"varishold: {self._session.stream.address}", "capabilities": []}
        return [_text({**info, "supportedEncodings": [], "metadata": {}}), self._advertised(EVENTS_TOPIC, STRING)]

    def hear(self, message: str | bytes) -> str | None:
        """Take what it says; return what it is answered, None for nothing."""
        try:
            said = json.loads(message)
            wanted = said["op"]
            if wanted == "subscribe":
                for one in said["subscriptions"]:
                    self._subscribe(one["id"], one["channelId"])
            elif wanted == "unsubscribe":
                for number in said["subscriptionIds"]:
                    self._subscriptions.pop(number, None)
        except (ValueError, TypeError, KeyError, RecursionError):
            return _text({"op": "status", "level": _WARNING, "message": "this is not understood"})
        return None

    def due(self) -> Iterator[str | bytes]:
        """Yield what has come since the last call: pads that are new, readings and events that it wants."""
        for sample in self._reader.read():
            yield from self._told(sample)
        by_channel = self._wanted()
        events = self._session.events.since(self._events)
        self._events = self._session.events.count
        for event in events:
            for subscription in by_channel.get(self._channel(EVENTS_TOPIC, STRING), []):
                text = string_message(note_text(event))
                yield _message(subscription, event["host_time_s"], text)

    def _told(self, sample: Sample) -> Iterator[str | bytes]:
        by_channel = self._wanted()
        layouts = self._session.stream.pads
        for name, values in sample.pads.items():
            facts = _facts(name, layouts.get(name))
            stamp_s = sample.host_time_s if sample.device_time_s is None else sample.device_time_s
            kind, content = self._coder.coded(facts, values, nanoseconds(stamp_s))
            known = (topic_of(name), kind) in self._channels
            channel = self._channel(topic_of(name), kind)
            if not known:
                yield self._advertised(topic_of(name), kind)
            for subscription in by_channel.get(channel, []):
                yield _message(subscription, sample.host_time_s, content)

    def _subscribe(self, number: int, channel: int) -> None:
        if not isinstance(number, int) or not 0 <= number < 2**32 or channel not in self._channels.values():
            raise ValueError
        if len(self._subscriptions) >= _MOST_SUBSCRIPTIONS:
            raise ValueError
        self._subscriptions[number] = channel

    def _wanted(self) -> Mapping[int, list[int]]:
        """Return the subscriptions of each channel."""
        wanted: dict[int, list[int]] = {}
        for subscription, channel in self._subscriptions.items():
            wanted.setdefault(channel, []).append(subscription)
        return wanted

    def _channel(self, topic: str, kind: str) -> int:
        return self._channels.setdefault((topic, kind), len(self._channels) + 1)

    def _advertised(self, topic: str, kind: str) -> str:
        channel = {"id": self._channel(topic, kind), "topic": topic, "encoding": "cdr", "schemaName": kind}
        return _text(
            {"op": "advertise", "channels": [{**channel, "schema": SCHEMAS[kind], "schemaEncoding": "ros2msg"}]}
        )


def _facts(name: str, layout: PadLayout | None) -> PadFacts:
    return PadFacts(name) if layout is None else PadFacts(name, kind=layout.kind, unit=layout.unit)


def _message(subscription: int, time_s: float, content: bytes) -> bytes:
    return _MESSAGE.pack(_DATA, subscription, min(max(nanoseconds(time_s), 0), _LATEST_NS)) + content


def _text(told: dict[str, Any]) -> str:
    return json.dumps(told, allow_nan=False, separators=(",", ":"))
