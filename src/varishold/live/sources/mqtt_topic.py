"""``mqtt://HOST:PORT/TOPIC`` and ``mqtts:`` a topic of an MQTT broker: JSON, or bare numbers."""

from __future__ import annotations

import os
import select
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from varishold._lazy import missing_extra
from varishold.errors import InputError, LostSourceError
from varishold.live.address import Address
from varishold.live.endpoint import endpoint_of, untrusted
from varishold.live.interpreted import InterpretedSource
from varishold.live.interpreter import OPTIONS
from varishold.live.sample import Sample
from varishold.live.sources.kind import SourceKind

if TYPE_CHECKING:
    from paho.mqtt.client import Client, MQTTMessage

__all__ = ["KIND", "MqttTopic"]

_PORTS = {"mqtt": 1883, "mqtts": 8883}
_PASSWORD = "VARISHOLD_MQTT_PASSWORD"
# Connecting may take so long. Seconds.
_OPEN_S = 1.0
# After so long without a word the broker is asked for one, and given up so long after that. Seconds.
_ASK_S, _ANSWER_S = 0.3, 0.6
_AT_ONCE = 64
# Nobody publishes there: leaving it is a question that every broker answers.
_NOWHERE = "varishold/nowhere"


class MqttTopic(InterpretedSource):
    """What is published under a topic of a broker, one reading a message.

    With wildcards in it, each pad without a name of its own is called by what stands in the topic that it came under
    from the first wildcard on.

    Parameters
    ----------
    address : Address
        Its options are those of the interpreter and the user's name; his password is in the environment.
    """

    def __init__(self, address: Address) -> None:
        address.only(*OPTIONS, "user")
        self._secure = address.kind == "mqtts"
        super().__init__(address)
        self._place = endpoint_of(address, port=_PORTS[address.kind], host="localhost")
        self._topic, self._user = self._place.path, address.options.get("user")
        if not self._topic:
            raise InputError(f"{address.text}: must name a topic, as in {KIND.example}")
        levels = self._topic.split("/")
        # How many levels of a topic come before the first wildcard; None where there is none.
        self._before = next((k for k, level in enumerate(levels) if level in ("+", "#")), None)
        _library()
        self._client: Client | None = None
        self._came: list[tuple[float, MQTTMessage]] = []
        self._refused: str
        self._subscribed: bool
        # When the broker was heard last, and asked for a word; 0 where it is not asked. When bytes came last: a large
        # message may be long on its way.
        self._heard_s: float
        self._byte_s = 0.0
        self._asked_s: float

    def open(self) -> None:
        self.close()
        client = self._made()
        try:
            client.connect(self._place.host, self._place.port)
        except (OSError, ValueError) as error:
            if (wrong := untrusted(self.address, error)) is not None:
                raise wrong from None
            raise LostSourceError(f"{self.address}: no broker answers: {error}") from None
        self._client, self._came = client, []
        self._refused, self._subscribed = "", False
        ends_s = time.monotonic() + _OPEN_S
        while not self._subscribed:
            failed = client.loop(0.05)
            if self._refused:
                raise InputError(f"{self.address}: {self._refused}")
            if failed or time.monotonic() > ends_s:
                raise LostSourceError(f"{self.address}: what answers is no broker")
        self._heard_s, self._asked_s = time.monotonic(), 0.0

    def read(self, timeout_s: float) -> list[Sample]:
        ends_s = time.monotonic() + timeout_s
        while True:
            left_s = ends_s - time.monotonic()
            self._step(min(max(left_s, 0.0), _ASK_S / 2))
            if self._came or left_s <= 0:
                break
            self._look_alive()
        count = 0
        while len(self._came) > count and len(self._came) < _AT_ONCE:
            count = len(self._came)
            self._step(0.0)
        came, self._came = self._came, []
        return [sample for at_s, message in came for sample in self._samples(at_s, message)]

    def close(self) -> None:
        client, self._client = self._client, None
        if client is not None:
            with suppress(Exception):
                client.disconnect()
                client.loop(0.0)

    def _samples(self, at_s: float, message: MQTTMessage) -> list[Sample]:
        # What a broker kept for those who come later was measured before they came.
        if message.retain:
            return []
        name = None if self._before is None else "/".join(message.topic.rstrip("/").split("/")[self._before :])
        return self._interpreter.payload(bytes(message.payload), host_time_s=at_s, name=name)

    def _step(self, timeout_s: float) -> None:
        if self._client is None:
            raise LostSourceError(f"{self.address}: is not open")
        before = len(self._came)
        failed = self._client.loop(0.0 if self._wait(timeout_s) else timeout_s)
        if failed and len(self._came) == before:
            raise LostSourceError(f"{self.address}: the broker is gone ({failed.name})")
        if len(self._came) > before:
            self._heard()

    def _wait(self, timeout_s: float) -> bool:
        """Wait for a byte where there is a connection, and note when it came; tell whether there was one to wait at."""
        opened: Any = None if self._client is None else self._client.socket()
        if opened is None:
            return False
        # What is decrypted already does not wait in the system.
        here = self._secure and opened.pending() > 0
        if here or select.select([opened], [], [], timeout_s)[0]:
            self._byte_s = time.monotonic()
        return True

    def _look_alive(self) -> None:
        silent_s = time.monotonic() - max(self._heard_s, self._byte_s)
        if not self._asked_s and silent_s >= _ASK_S and self._client is not None:
            self._asked_s = time.monotonic()
            self._client.unsubscribe(_NOWHERE)
        elif self._asked_s and silent_s >= _ASK_S + _ANSWER_S:
            raise LostSourceError(f"{self.address}: the broker has been silent for {silent_s:.1f} s")

    def _heard(self, *_: Any) -> None:
        self._heard_s, self._asked_s = time.monotonic(), 0.0

    def _made(self) -> Client:
        mqtt = _library()
        client: Client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
        client.connect_timeout = _OPEN_S
        if self._user is not None:
            client.username_pw_set(self._user, os.environ.get(_PASSWORD))
        if self._secure:
            client.tls_set()
        client.on_connect = self._on_connect
        client.on_subscribe = self._on_subscribe
        client.on_unsubscribe = self._heard
        client.on_message = lambda _client, _data, message: self._came.append((time.time(), message))
        return client

    def _on_connect(self, client: Client, _data: Any, _flags: Any, reason: Any, _properties: Any) -> None:
        if reason.is_failure:
            self._refused = f"the broker says: {reason}; give ?user=NAME, and the password in ${_PASSWORD}"
            return
        try:
            client.subscribe(self._topic)
        except ValueError as error:
            self._refused = f"{self._topic!r} is no topic: {error}"

    def _on_subscribe(self, _client: Client, _data: Any, _number: int, reasons: Any, _properties: Any) -> None:
        self._subscribed = True
        if any(reason.is_failure for reason in reasons):
            self._refused = f"the broker does not give the topic: {reasons[0]}"


def _library() -> Any:
    try:
        import paho.mqtt.client
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    return paho.mqtt.client


KIND = SourceKind("a topic of an MQTT broker", "mqtt://localhost:1883/skin", MqttTopic, needs=("paho",))
