"""The node of ROS 2 among the examples: driven by stand-ins for what ROS brings, with messages that rosbags made."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="rosbags is not installed")

from tests.ros_messages import made, store_of

NAME = "sensor_msgs/msg/Image"
PARAMETERS = {"topic": "/skin", "shape": "16x16"}


class StandIn:
    """A node as far as the example needs one."""

    def __init__(self, name: str) -> None:
        self.published: list[str] = []
        self.warned: list[str] = []
        self.heard: Any = None

    def declare_parameter(self, name: str, default: str) -> Any:
        return SimpleNamespace(value=PARAMETERS.get(name, default))

    def create_publisher(self, kind: Any, topic: str, depth: int) -> Any:
        return SimpleNamespace(publish=lambda message: self.published.append(message.data))

    def create_timer(self, period_s: float, call: Any) -> Any:
        return SimpleNamespace(cancel=lambda: None)

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [("/other", ["std_msgs/msg/String"]), ("/skin", [NAME])]

    def create_subscription(self, kind: Any, topic: str, call: Any, quality: Any) -> None:
        assert (kind, topic) == (NAME, "/skin")
        self.heard = call

    def get_logger(self) -> Any:
        return SimpleNamespace(warning=lambda words, **_: self.warned.append(words))


def module(name: str, **names: Any) -> ModuleType:
    made_up = ModuleType(name)
    vars(made_up).update(names)
    return made_up


def test_the_node_tells_what_touches(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, names in {
        "rclpy": {},
        "rclpy.node": {"Node": StandIn},
        "rclpy.qos": {"qos_profile_sensor_data": None},
        "rosidl_runtime_py": {},
        "rosidl_runtime_py.utilities": {"get_message": lambda name: name},
        "std_msgs": {},
        "std_msgs.msg": {"String": SimpleNamespace},
    }.items():
        monkeypatch.setitem(sys.modules, name, module(name, **names))
    spec = importlib.util.spec_from_file_location("ros2_node", Path(__file__).parents[1] / "examples" / "ros2_node.py")
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    node = example.TouchNode()
    node.look_for_topic()
    store, rng = store_of(NAME), np.random.default_rng(1)
    row, col = np.mgrid[:16, :16]
    ball = 900 * np.clip(1 - ((row - 8) ** 2 + (col - 8) ** 2) / 16, 0, None)
    for number in range(150):
        frame = rng.normal(500, 3, (16, 16)) + (ball if number >= 120 else 0)
        node.heard(image(store, frame.astype("<u2"), 10_000_000 * number))
    node.heard(image(store, np.zeros((2, 0), "<u2"), 0, height=2, width=2))
    node.watcher.close()
    lines = [json.loads(line) for line in node.published]
    assert [line["event"] for line in lines if line["line"] == "event"][:1] == ["touched"]
    assert all(line["contacts"] for line in lines if line["line"] == "frame")
    assert node.warned == ["an image of 2 x 2 16UC1 with 4 bytes a row came with 0 bytes"]


def image(store: Any, frame: np.ndarray, time_ns: int, **wrong: int) -> Any:
    stamp = {"sec": 5 + time_ns // 10**9, "nanosec": time_ns % 10**9}
    size = {"height": frame.shape[0], "width": frame.shape[1]} | wrong
    data = np.frombuffer(frame.tobytes(), np.uint8)
    return made(NAME, store, header={"stamp": stamp}, encoding="16UC1", data=data, **size)
