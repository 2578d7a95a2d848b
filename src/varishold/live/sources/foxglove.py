"""``foxglove://HOST:PORT/TOPIC`` a topic of ROS, or of any program, by the protocol of Foxglove's bridge."""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from varishold.errors import InputError, LostSourceError
from varishold.files.documents import parse_json
from varishold.live.address import Address
from varishold.live.endpoint import endpoint_of
from varishold.live.interpreted import InterpretedSource, topics_at
from varishold.live.interpreter import OPTIONS
from varishold.live.sample import Sample
from varishold.live.sources.kind import SourceKind
from varishold.live.web_sockets import WebSocket
from varishold.recording.messages import message_decoder

__all__ = ["KIND", "Channel", "Foxglove"]

_PORT = 8765
# The bridge of today and that of yesterday speak the same of what is read here.
_SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
# So long a topic is waited for after connecting, and so long a silence ends the list of topics. Seconds.
_WAIT_S, _LIST_S = 1.0, 0.2
_SUBSCRIPTION = 1
_MESSAGE = struct.Struct("<BIQ")
_MOST_CHANNELS = 10_000


@dataclass(frozen=True)
class Channel:
    """What a server says of one of its topics.

    Parameters
    ----------
    number : int
    topic, encoding, type_name, text, text_encoding : str
        As `varishold.recording.messages.message_decoder` takes them.
    """

    number: int
    topic: str
    encoding: str
    type_name: str
    text: str
    text_encoding: str


class Foxglove(InterpretedSource):
    """One topic of a server that speaks Foxglove's protocol.

    Parameters
    ----------
    address : Address
        Without a topic, opening tells the topics that there are.
    """

    def __init__(self, address: Address) -> None:
        address.only(*OPTIONS)
        if "dtype" in address.options:
            raise InputError(f"{address.text}: messages tell their types; dtype is for bare bytes")
        super().__init__(address)
        place = endpoint_of(address, port=_PORT, host="localhost")
        self._topic = "/" + place.path.strip("/") if place.path.strip("/") else ""
        self._socket = WebSocket(address.text, f"ws://{place.host_and_port}", _SUBPROTOCOLS)
        self._channels: dict[int, Channel] = {}
        self._subscribed: int | None = None
        self._decode: Callable[[bytes], Any] | None = None

    @property
    def topics(self) -> dict[str, str]:
        """The type of each topic that the server has told of."""
        return {channel.topic: channel.type_name for channel in self._channels.values()}

    def open(self) -> None:
        self._channels, self._subscribed, self._decode = {}, None, None
        self._socket.open()
        ends_s = time.monotonic() + _WAIT_S
        while self._subscribed is None and time.monotonic() < ends_s:
            came = self._socket.receive(_LIST_S)
            for content in came:
                self._hear(content)
            if not came and self._channels and not self._topic:
                break
        if self._subscribed is None:
            raise self._no_topic()

    def read(self, timeout_s: float) -> list[Sample]:
        return [sample for content in self._socket.receive(timeout_s) for sample in self._hear(content)]

    def close(self) -> None:
        self._socket.close()

    def _hear(self, content: bytes) -> list[Sample]:
        if content[:1] == b"{":
            self._obey(content)
            return []
        if self._decode is None or content[:1] != b"\x01":
            return []
        if len(content) < _MESSAGE.size:
            self._interpreter.tell(f"a message of {len(content)} bytes came, which lacks its head")
            return []
        _, subscription, time_ns = _MESSAGE.unpack_from(content)
        if subscription != _SUBSCRIPTION:
            return []
        return self._interpreter.message(
            content[_MESSAGE.size :], self._decode, device_time_s=time_ns * 1e-9 if time_ns else None
        )

    def _obey(self, content: bytes) -> None:
        """Take in what the server says of itself."""
        try:
            said = parse_json(content.decode(errors="replace"), where="the server's word")
        except InputError as error:
            self._interpreter.tell(error)
            return
        if said.get("op") == "advertise":
            for told in _dicts(said.get("channels")):
                channel = _channel_of(told)
                if channel is not None and len(self._channels) < _MOST_CHANNELS:
                    # Other topics' definitions may be long.
                    self._channels[channel.number] = replace(channel, text="")
                    if channel.topic == self._topic and self._subscribed is None:
                        self._subscribe(channel)
        elif said.get("op") == "unadvertise":
            gone = said.get("channelIds")
            for number in gone if isinstance(gone, list) else []:
                if isinstance(number, int):
                    self._channels.pop(number, None)
            if self._subscribed is not None and self._subscribed not in self._channels:
                raise LostSourceError(f"{self.address}: nobody sends the topic any more")

    def _subscribe(self, channel: Channel) -> None:
        try:
            self._decode = message_decoder(channel.encoding, channel.type_name, channel.text, channel.text_encoding)
        except InputError as error:
            raise InputError(f"{self.address}: {error}") from None
        wish = {"op": "subscribe", "subscriptions": [{"id": _SUBSCRIPTION, "channelId": channel.number}]}
        self._socket.send(json.dumps(wish))
        self._subscribed = channel.number

    def _no_topic(self) -> Exception:
        known = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(self.topics.items())[:50]) or "none"
        if not self._topic:
            return InputError(f"{self.address}: must name a topic, as in {KIND.example}; there are {known}")
        return LostSourceError(f"{self.address}: there is no topic {self._topic}; there are {known}")


def _dicts(value: object) -> list[dict[str, Any]]:
    return [item for item in value if isinstance(item, dict)] if isinstance(value, list) else []


def _channel_of(told: Mapping[str, Any]) -> Channel | None:
    texts = [told.get(name) or "" for name in ("topic", "encoding", "schemaName", "schema", "schemaEncoding")]
    if not isinstance(told.get("id"), int) or not all(isinstance(text, str) for text in texts):
        return None
    topic, *rest = texts
    return Channel(told["id"], "/" + topic.strip("/"), *rest)


def _found() -> list[tuple[str, str]]:
    """Return the topics of a bridge on this machine."""
    source = Foxglove(Address("foxglove://localhost", "foxglove", "localhost", {}))
    return topics_at(f"foxglove://localhost:{_PORT}", source)


KIND = SourceKind(
    "a topic of ROS, by foxglove_bridge", "foxglove://localhost:8765/skin", Foxglove, _found, ("rosbags",)
)
