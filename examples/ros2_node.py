"""A node of ROS 2 that watches a topic of touch, and publishes what touches and what happens as JSON.

It runs where ROS 2 is installed and sourced, beside this package::

    python examples/ros2_node.py --ros-args -p topic:=/skin -p shape:="16x16"
    ros2 topic echo /skin/touch

Any type is taken whose messages `varishold.recording.messages` understands; `field` names the field that holds the
values of another. Publishers of skins mostly send best effort, which a node that asks for less than that also hears.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rosidl_runtime_py.utilities import get_message
from std_msgs.msg import String

from varishold import InputError
from varishold.live import Watcher
from varishold.live.address import parse_address
from varishold.live.interpreter import Interpreter
from varishold.live.lines import lines_of
from varishold.recording.messages import read_message


class TouchNode(Node):  # type: ignore[misc]
    """Subscribes to a topic as soon as somebody publishes it."""

    def __init__(self) -> None:
        super().__init__("varishold")
        self.topic = str(self.declare_parameter("topic", "/skin").value)
        shape = str(self.declare_parameter("shape", "").value)
        self.field = str(self.declare_parameter("field", "").value) or None
        address = parse_address(f"ros:{self.topic}" + (f"?shape={shape}" if shape else ""))
        self.shape = address.shape()
        self.interpreter = Interpreter(address)
        self.watcher = Watcher()
        self.told = self.create_publisher(String, f"{self.topic}/touch", 10)
        self.subscribed = False
        self.timer = self.create_timer(0.5, self.look_for_topic)

    def look_for_topic(self) -> None:
        types = dict(self.get_topic_names_and_types()).get(self.topic)
        if types and not self.subscribed:
            self.create_subscription(get_message(types[0]), self.topic, self.hear, qos_profile_sensor_data)
            self.subscribed = True
            self.timer.cancel()

    def hear(self, message: Any) -> None:
        try:
            said = read_message(message, shape=self.shape, field=self.field)
        except InputError as error:
            self.get_logger().warning(str(error), throttle_duration_sec=5.0)
            return
        for sample in self.interpreter.sample(said):
            self.watcher.layouts = self.interpreter.pads
            for line in lines_of(self.watcher.see(sample)):
                if line["line"] != "frame" or line["contacts"]:
                    self.told.publish(String(data=json.dumps(line)))


def main() -> None:
    rclpy.init(args=sys.argv)
    node = TouchNode()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.watcher.close()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
