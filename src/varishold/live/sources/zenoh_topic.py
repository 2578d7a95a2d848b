"""``zenoh://HOST:PORT/TOPIC`` a topic of ROS 2 over zenoh (rmw_zenoh), or a plain key of zenoh."""

from __future__ import annotations

import atexit
import json
import struct
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from threading import Condition
from typing import TYPE_CHECKING, Any, NamedTuple

from varishold._lazy import missing_extra
from varishold.errors import InputError, LostSourceError
from varishold.files import read_bytes
from varishold.live.address import Address
from varishold.live.endpoint import endpoint_of
from varishold.live.interpreted import InterpretedSource, topics_at
from varishold.live.interpreter import OPTIONS
from varishold.live.sample import Sample
from varishold.live.sources.kind import SourceKind
from varishold.live.zenoh_types import asked_definition
from varishold.recording.messages import message_decoder
from varishold.recording.messages.decoding import ros_type_name

if TYPE_CHECKING:
    import zenoh

__all__ = ["KIND", "ZenohTopic"]

_PORT = 7447
# Connecting, and hearing of a publisher, may take so long. Seconds.
_OPEN_S, _FIND_S = 0.5, 1.0
# So long the list of topics is waited for. Seconds.
_LIST_S = 0.3
# So many messages are kept until they are read; older ones give way.
_KEPT = 1024
# Where nodes of ROS 2 say that they are alive, and how one says that it is a publisher.
_ALIVE, _PUBLISHER = "@ros2_lv", "MP"
_LARGEST_TEXT = 1 << 18


class _Published(NamedTuple):
    """A topic that somebody publishes, without its first slash, and its type."""

    topic: str
    type_name: str


class _Message(NamedTuple):
    """What came under a key, and when."""

    host_time_s: float
    key: str
    content: bytes
    attachment: bytes


class ZenohTopic(InterpretedSource):
    """A topic of ROS 2 over zenoh, or a plain key whose values are JSON or bare numbers.

    Parameters
    ----------
    address : Address
        Without a host, whoever answers in this network is asked. Its options are those of the interpreter; the
        domain of ROS 2, 0 where none is given; msg, a file with the definition of a type that is in no standard
        package.
    """

    def __init__(self, address: Address) -> None:
        address.only(*OPTIONS, "domain", "msg")
        super().__init__(address)
        place = endpoint_of(address, port=_PORT)
        self._host, self._at = place.host, place.host_and_port
        self._topic = place.path.strip("/")
        self._domain = address.whole("domain", 0, least=0, most=232)
        if any(sign in self._topic for sign in "*$#?"):
            raise InputError(f"{address.text}: {self._topic!r} is no topic")
        self._text = _text_of(address)
        self._zenoh = _library()
        self._session: Any = None
        self._declared: list[Any] = []
        self._kept: deque[_Message] = deque(maxlen=_KEPT)
        self._passed_over = 0
        self._news = Condition()
        self._publishers: dict[str, _Published] = {}
        self._was_published = False
        self._decoders: dict[str, Callable[[bytes], Any]] = {}

    @property
    def damaged(self) -> int:
        """How many messages could not be used, or were passed over because nobody read them in time."""
        return super().damaged + self._passed_over

    @property
    def topics(self) -> dict[str, str]:
        """The type of each topic that somebody publishes in the domain."""
        with self._news:
            return {"/" + topic: type_name for topic, type_name in self._publishers.values()}

    def open(self) -> None:
        self.close()
        with self._news:
            self._publishers, self._was_published = {}, False
            self._kept.clear()
        # The library's threads must not call this program when it has ended.
        atexit.register(self.close)
        try:
            self._session = self._zenoh.open(self._config())
            # Called in the library's own threads: those of Python would outlive the program.
            on_life, on_value = (
                self._zenoh.handlers.Callback(call, indirect=False) for call in (self._on_life, self._on_value)
            )
            alive = f"{_ALIVE}/{self._domain}/**"
            self._declared = [self._session.liveliness().declare_subscriber(alive, on_life, history=True)]
            for key in (f"{self._domain}/{self._topic}/*/*", self._topic) if self._topic else ():
                self._declared.append(self._session.declare_subscriber(key, on_value))
        except self._zenoh.ZError as error:
            self.close()
            raise LostSourceError(f"{self.address}: nobody answers: {error}") from None
        with self._news:
            limit_s = _FIND_S if self._topic else _LIST_S
            if not self._news.wait_for(lambda: self._kept or self._is_published(), limit_s):
                raise self._no_topic()

    def read(self, timeout_s: float) -> list[Sample]:
        if self._session is None:
            raise LostSourceError(f"{self.address}: is not open")
        with self._news:
            self._news.wait_for(lambda: self._kept, timeout_s)
            came = list(self._kept)
            self._kept.clear()
        if not came:
            self._look_alive()
        return [sample for each in came for sample in self._samples(each)]

    def close(self) -> None:
        atexit.unregister(self.close)
        session, self._session = self._session, None
        if session is not None:
            with suppress(self._zenoh.ZError):
                session.close()

    def _samples(self, message: _Message) -> list[Sample]:
        _, key, content, attachment = message
        at_s = message.host_time_s
        if key == self._topic:
            return self._interpreter.payload(content, host_time_s=at_s)
        number, source_s = _attachment(attachment)
        _, type_name, type_hash = key.rsplit("/", 2)
        if type_name not in self._decoders:
            self._decoders[type_name] = self._decoder(type_name, type_hash)
        return self._interpreter.message(
            content, self._decoders[type_name], host_time_s=at_s, device_time_s=source_s, sequence=number
        )

    def _decoder(self, type_name: str, type_hash: str) -> Callable[[bytes], Any]:
        """Return what takes messages of a type apart: by the text that was given, a standard one, or what nodes say."""
        try:
            try:
                return message_decoder("cdr", type_name, self._text)
            except InputError:
                told = asked_definition(self._session, self._domain, ros_type_name(type_name), type_hash)
                if self._text or not told:
                    raise
                return message_decoder("cdr", type_name, told)
        except InputError as error:
            raise InputError(
                f"{self.address}: {error}; no node tells the definition: give it as ?msg=FILE", parameter="msg"
            ) from None

    def _on_value(self, sample: zenoh.Sample) -> None:
        """Keep what came, in a thread of the library."""
        attachment = b"" if sample.attachment is None else sample.attachment.to_bytes()
        with self._news:
            self._passed_over += len(self._kept) == _KEPT
            self._kept.append(_Message(time.time(), str(sample.key_expr), sample.payload.to_bytes(), attachment))
            self._news.notify()

    def _on_life(self, sample: zenoh.Sample) -> None:
        """Keep who publishes what, in a thread of the library."""
        key = str(sample.key_expr)
        topic = _published(key)
        with self._news:
            if sample.kind == self._zenoh.SampleKind.DELETE:
                self._publishers.pop(key, None)
            elif topic is not None and len(self._publishers) < _KEPT:
                self._publishers[key] = topic
                self._was_published |= topic.topic == self._topic
            self._news.notify()

    def _is_published(self) -> bool:
        return any(topic == self._topic for topic, _ in self._publishers.values())

    def _look_alive(self) -> None:
        session = self._session
        if session is not None and not session.info.routers_zid() and not session.info.peers_zid():
            raise LostSourceError(f"{self.address}: the connection is gone")
        with self._news:
            left = self._was_published and not self._is_published()
        if left:
            raise LostSourceError(f"{self.address}: nobody publishes the topic any more")

    def _config(self) -> Any:
        config = self._zenoh.Config()
        config.insert_json5("scouting/multicast/enabled", json.dumps(not self._host))
        if self._host:
            config.insert_json5("mode", '"client"')
            config.insert_json5("connect/endpoints", json.dumps([f"tcp/{self._at}"]))
            config.insert_json5("connect/timeout_ms", str(int(_OPEN_S * 1000)))
        return config

    def _no_topic(self) -> Exception:
        told = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(self.topics.items())[:50]) or "none"
        if not self._topic:
            return InputError(f"{self.address}: must name a topic, as in {KIND.example}; there are {told}")
        return LostSourceError(
            f"{self.address}: nobody publishes /{self._topic} in domain {self._domain}; there are {told}"
        )


def _text_of(address: Address) -> str:
    """Return the text of the file that an address names as msg; empty where it names none."""
    path = address.options.get("msg")
    if path is None:
        return ""
    try:
        return read_bytes(path, most=_LARGEST_TEXT).decode()
    except UnicodeDecodeError:
        raise InputError(f"{address.text}: {path} is no text") from None


def _published(key: str) -> _Published | None:
    """Return the topic of a publisher's token of life; None of any other's.

    Examples
    --------
    >>> tuple(_published("@ros2_lv/0/a1/0/3/MP/%/%/node/%skin%left/std_msgs::msg::dds_::Int16_/RIHS01_0/::,1:"))
    ('skin/left', 'std_msgs/msg/Int16')
    """
    parts = key.split("/")
    if len(parts) < 12 or parts[5] != _PUBLISHER:
        return None
    try:
        return _Published(parts[9].replace("%", "/").strip("/"), ros_type_name(parts[10]))
    except InputError:
        return None


def _attachment(content: bytes) -> tuple[int | None, float | None]:
    """Return the publisher's number of a message and its time, seconds; None for what is not told.

    Two numbers of eight bytes, each behind its name in the first versions of rmw_zenoh.
    """
    first, second = (16, 41) if content[1:16] == b"sequence_number" else (0, 8)
    if len(content) < second + 8:
        return None, None
    (number,), (time_ns,) = struct.unpack_from("<q", content, first), struct.unpack_from("<q", content, second)
    return number, time_ns * 1e-9 if time_ns > 0 else None


def _library() -> Any:
    try:
        import zenoh
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    return zenoh


def _found() -> list[tuple[str, str]]:
    """Return the topics that a router on this machine knows of."""
    source = ZenohTopic(Address("zenoh://localhost", "zenoh", "localhost", {}))
    return topics_at(f"zenoh://localhost:{_PORT}", source)


KIND = SourceKind(
    "a topic of ROS 2 over zenoh", "zenoh://localhost:7447/skin", ZenohTopic, _found, ("zenoh", "rosbags")
)
