"""Topics of MQTT: paho publishes to mosquitto on this machine."""

from __future__ import annotations

import getpass
import json
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")

import paho.mqtt.client as mqtt
from tests.live_reading import read_on, read_some
from tests.live_scripted import wait_until

from benchmarks._silent_servers import silent_broker
from varishold.errors import InputError, LostSourceError
from varishold.live import Stream, source_at
from varishold.live.sources import mqtt_topic

MOSQUITTO = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")
needs_broker = pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed")
RNG = np.random.default_rng(2)


@contextmanager
def broker(folder: Path, *, port: int = 0, settings: str = "allow_anonymous true") -> Iterator[int]:
    """Run mosquitto; yield its port."""
    if not port:
        with socket.create_server(("127.0.0.1", 0)) as listener:
            port = listener.getsockname()[1]
    (folder / "broker.conf").write_text(f"listener {port} 127.0.0.1\nuser {getpass.getuser()}\n{settings}\n")
    assert MOSQUITTO is not None
    command = [MOSQUITTO, "-c", str(folder / "broker.conf")]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
        wait_until(lambda: answers(port))
        try:
            yield port
        finally:
            running.kill()


def answers(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), 1).close()
    except OSError:
        return False
    return True


@contextmanager
def publisher(port: int) -> Iterator[Any]:
    """Yield a function that publishes, and waits until it is done."""
    client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
    client.connect("127.0.0.1", port)
    client.loop_start()

    def publish(topic: str, content: Any, **options: Any) -> None:
        content = content if isinstance(content, bytes) else json.dumps(content)
        client.publish(topic, content, qos=1, **options).wait_for_publish(20)

    try:
        yield publish
    finally:
        client.disconnect()
        client.loop_stop()


@needs_broker
def test_what_is_published_is_what_is_read(tmp_path: Path) -> None:
    frames = RNG.integers(0, 4096, (300, 4, 6)).astype(np.uint16)
    with broker(tmp_path) as port, publisher(port) as publish:
        bare = source_at(f"mqtt://127.0.0.1:{port}/lab/skin?dtype=uint16&shape=4x6")
        plain = source_at(f"mqtt://127.0.0.1:{port}/json")
        bare.open()
        plain.open()
        for frame in frames:
            publish("lab/skin", frame.astype("<u2").tobytes())
            publish("json", {"pressure": frame.tolist(), "time_s": 2.5, "sequence": 4})
        raw, read = read_some(bare, 300), read_some(plain, 300)
        bare.close()
        plain.close()
        plain.close()
    np.testing.assert_array_equal([sample.pads["pad"] for sample in raw], frames)
    np.testing.assert_array_equal([sample.pads["pad"] for sample in read], frames)
    assert (read[0].device_time_s, read[0].sequence) == (2.5, 4)
    assert bare.pads["pad"].shape == (4, 6)


@needs_broker
def test_each_topic_under_a_wildcard_is_a_pad(tmp_path: Path) -> None:
    with broker(tmp_path) as port, publisher(port) as publish:
        source = source_at(f"mqtt://127.0.0.1:{port}/hand/+")
        source.open()
        publish("hand/left", [[1, 2]])
        publish("hand/right", [[3, 4]])
        samples = read_some(source, 2)
        source.close()
    assert {name: values.tolist() for sample in samples for name, values in sample.pads.items()} == {
        "left": [[1, 2]],
        "right": [[3, 4]],
    }


@needs_broker
def test_what_the_broker_kept_is_not_taken_for_new(tmp_path: Path) -> None:
    with broker(tmp_path) as port, publisher(port) as publish:
        publish("skin", [1], retain=True)
        source = source_at(f"mqtt://127.0.0.1:{port}/skin")
        source.open()
        publish("skin", [2])
        assert read_some(source, 1)[0].pads["pad"].tolist() == [2]
        source.close()


@needs_broker
def test_wrong_messages_are_counted_and_passed_over(tmp_path: Path) -> None:
    wrong = [b"", b"{", b"\xff\xfe", b"[1, [2]]", b'{"a": 1}', b"[" * 3000, b"17"]
    with broker(tmp_path) as port, publisher(port) as publish:
        source = source_at(f"mqtt://127.0.0.1:{port}/skin")
        source.open()
        for number in range(20):
            publish("skin", [number])
            for each in wrong[number : number + 1]:
                publish("skin", each)
        samples = read_some(source, 20)
        source.close()
    assert [int(sample.pads["pad"][0]) for sample in samples] == list(range(20))
    assert source.damaged == len(wrong)
    assert source.damage


@needs_broker
def test_a_broker_that_leaves_is_told_and_comes_back(tmp_path: Path) -> None:
    with broker(tmp_path) as port:
        stream = Stream(source_at(f"mqtt://127.0.0.1:{port}/skin")).start()
        wait_until(lambda: stream.state == "open")
    wait_until(lambda: stream.state == "lost")
    assert "the broker is gone" in stream.words or "no broker answers" in stream.words
    with broker(tmp_path, port=port), publisher(port) as publish:
        wait_until(lambda: stream.state == "open")
        publish("skin", [5])
        wait_until(lambda: stream.received == 1)
        stream.close()


@needs_broker
def test_a_broker_with_nothing_to_say_is_not_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mqtt_topic, "_ANSWER_S", 1.0)
    with broker(tmp_path) as port:
        source = source_at(f"mqtt://127.0.0.1:{port}/skin")
        source.open()
        ends_s = time.monotonic() + 2.0
        while time.monotonic() < ends_s:
            assert source.read(0.2) == []
        source.close()


@needs_broker
def test_a_broker_that_refuses_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with broker(tmp_path, settings="allow_anonymous false") as port:
        source = source_at(f"mqtt://127.0.0.1:{port}/skin")
        with pytest.raises(InputError, match=r"the broker says: Not authorized; give \?user=NAME, and the password in"):
            source.open()
        source.close()
    passwords = tmp_path / "passwords"
    tool = shutil.which("mosquitto_passwd")
    if tool is None:
        pytest.skip("mosquitto_passwd is not installed")
    subprocess.run([tool, "-b", "-c", str(passwords), "anna", "secret"], check=True, capture_output=True)
    passwords.chmod(0o644)
    with broker(tmp_path, settings=f"allow_anonymous false\npassword_file {passwords}") as port:
        monkeypatch.setenv("VARISHOLD_MQTT_PASSWORD", "secret")
        source = source_at(f"mqtt://127.0.0.1:{port}/skin?user=anna")
        source.open()
        source.close()


def test_silence_behind_a_pulled_cable_is_told() -> None:
    with silent_broker() as port:
        source = source_at(f"mqtt://127.0.0.1:{port}/skin")
        source.open()
        with pytest.raises(LostSourceError, match=r"the broker has been silent for \d+\.\d s"):
            read_on(source)
        source.close()


def test_a_message_may_be_longer_on_its_way_than_a_silence_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a depth map is through a slow radio link: the broker cannot answer in the middle of it."""
    monkeypatch.setattr(mqtt_topic, "_ANSWER_S", 0.4)
    content = b"\x00\x04skin" + b"[[1, 2], [3, 4]]".ljust(90)
    with silent_broker(b"\x30" + bytes([len(content)]) + content) as port:
        source = source_at(f"mqtt://127.0.0.1:{port}/skin")
        source.open()
        (one,) = read_some(source, 1)
        with pytest.raises(LostSourceError, match=r"the broker has been silent for \d+\.\d s"):
            read_on(source)
        source.close()
    assert one.pads["pad"].tolist() == [[1, 2], [3, 4]]


def test_nobody_there_and_somebody_else_are_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        source = source_at(f"mqtt://127.0.0.1:{port}/skin")
        with pytest.raises(LostSourceError, match=r"what answers is no broker|no broker answers"):
            source.open()
        source.close()
    with pytest.raises(LostSourceError, match="no broker answers"):
        source.open()
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("mqtt://h", "must name a topic, as in mqtt://localhost:1883/skin"),
        ("mqtt://h/t?x=1", "mqtt has no option 'x'; known are shape, field, dtype, skip, user"),
        ("mqtt://h/t?dtype=float16", "dtype must be one of"),
    ],
)
def test_addresses_that_cannot_be_are_told(address: str, words: str) -> None:
    with pytest.raises(InputError) as told:
        source_at(address)
    assert words in str(told.value)


@needs_broker
def test_a_topic_that_is_none_is_told(tmp_path: Path) -> None:
    with broker(tmp_path) as port:
        source = source_at(f"mqtt://127.0.0.1:{port}/a#b")
        with pytest.raises(InputError, match="'a#b' is no topic"):
            source.open()
        source.close()
