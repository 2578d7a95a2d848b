"""Programs that send frames of 16 x 16 over a network on this machine, each stamped with the time at which it is sent.

Run by `benchmarks.live_network`, each in a process of its own:
``python -m benchmarks._network_senders KIND PORT FRAMES RATE_HZ``.
"""

from __future__ import annotations

import json
import struct
import sys
import time
from collections.abc import Callable, Iterator, Mapping

import numpy as np

__all__ = ["SENDERS", "frame_of"]

SHAPE = (16, 16)
ARRAY = "std_msgs/msg/Float32MultiArray"
TEXT = """MultiArrayLayout layout
float32[] data
================================================================================
MSG: std_msgs/MultiArrayLayout
MultiArrayDimension[] dim
uint32 data_offset
================================================================================
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
"""


def frame_of(number: int) -> np.ndarray:
    """Return the frame of a number, counts of 12 bits."""
    return np.random.default_rng(number).integers(0, 4096, SHAPE).astype(np.uint16)


def _paced(n_frames: int, rate_hz: float) -> Iterator[np.ndarray]:
    frames = [frame_of(number) for number in range(n_frames)]
    begun = time.perf_counter()
    for number, frame in enumerate(frames):
        time.sleep(max(0.0, begun + number / rate_hz - time.perf_counter()))
        yield frame


def _cdr(frame: np.ndarray) -> bytes:
    """Return a Float32MultiArray of two dimensions without labels."""
    dims = b"".join(struct.pack("<IBxxxII", 1, 0, size, size) for size in SHAPE)
    return b"\0\1\0\0" + struct.pack("<I", 2) + dims + struct.pack("<II", 0, frame.size) + frame.astype("<f4").tobytes()


def xela(port: int, n_frames: int, rate_hz: float) -> None:
    from websockets.sync.server import serve

    def talk(connection: object) -> None:
        for number, frame in enumerate(_paced(n_frames, rate_hz)):
            words = ",".join(f"0,0,{count:X}" for count in frame.ravel())
            sensor = {"time": time.time(), "sensor": "1", "model": "", "taxels": frame.size, "data": words}
            connection.send(json.dumps({"message": number, "1": sensor}))  # type: ignore[attr-defined]
        time.sleep(1)

    with serve(talk, "127.0.0.1", port, compression=None) as server:
        server.serve_forever()


def foxglove(port: int, n_frames: int, rate_hz: float) -> None:
    from websockets.sync.server import serve

    channel = {"id": 1, "topic": "/skin", "encoding": "cdr", "schemaName": ARRAY, "schema": TEXT}

    def talk(connection: object) -> None:
        connection.send(json.dumps({"op": "advertise", "channels": [channel]}))  # type: ignore[attr-defined]
        connection.recv()  # type: ignore[attr-defined]
        for frame in _paced(n_frames, rate_hz):
            head = struct.pack("<BIQ", 1, 1, time.time_ns())
            connection.send(head + _cdr(frame))  # type: ignore[attr-defined]
        time.sleep(1)

    with serve(talk, "127.0.0.1", port, compression=None, subprotocols=["foxglove.sdk.v1"]) as server:  # type: ignore[list-item]
        server.serve_forever()


def zenoh(port: int, n_frames: int, rate_hz: float) -> None:
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    with zenoh.open(config) as session:
        publisher = session.declare_publisher("0/skin/std_msgs::msg::dds_::Float32MultiArray_/RIHS01_0")
        alive = f"@ros2_lv/0/{session.zid()}/0/1/MP/%/%/n/%skin/std_msgs::msg::dds_::Float32MultiArray_/RIHS01_0/::"
        token = session.liveliness().declare_token(alive)
        while not publisher.matching_status.matching:
            time.sleep(0.01)
        for number, frame in enumerate(_paced(n_frames, rate_hz)):
            attached = struct.pack("<qqB", number, time.time_ns(), 16) + bytes(16)
            publisher.put(_cdr(frame), attachment=attached)
        time.sleep(1)
        token.undeclare()


def lsl(port: int, n_frames: int, rate_hz: float) -> None:
    import pylsl

    info = pylsl.StreamInfo(f"skin-{port}", "Tactile", 256, rate_hz, pylsl.cf_int16, f"skin-{port}")
    for name in ("rows", "cols"):
        info.desc().append_child_value(name, "16")
    outlet = pylsl.StreamOutlet(info)
    while not outlet.wait_for_consumers(1.0):
        pass
    for frame in _paced(n_frames, rate_hz):
        outlet.push_sample(frame.ravel().tolist(), time.time())
    time.sleep(1)


def mqtt(port: int, n_frames: int, rate_hz: float) -> None:
    import paho.mqtt.client as paho

    client = paho.Client(paho.CallbackAPIVersion.VERSION2)
    client.connect("127.0.0.1", port)
    client.loop_start()
    time.sleep(1)
    for number, frame in enumerate(_paced(n_frames, rate_hz)):
        content = {"pressure": frame.tolist(), "time_s": time.time(), "sequence": number}
        client.publish("skin", json.dumps(content))
    time.sleep(1)
    client.disconnect()
    client.loop_stop()


#: By what stands before the colon of their address.
SENDERS: Mapping[str, Callable[[int, int, float], None]] = {
    "ws": xela,
    "foxglove": foxglove,
    "zenoh": zenoh,
    "lsl": lsl,
    "mqtt": mqtt,
}

if __name__ == "__main__":
    SENDERS[sys.argv[1]](int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]))
