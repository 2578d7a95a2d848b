"""MCAP: the one mapping between readings of pads and topics of ROS 2.

Each pad is a topic of `sensor_msgs/msg/Image`, each pad of signals one of `std_msgs/msg/Float32MultiArray`; presses,
marks and the zeroing log are topics of JSON text. `TopicWriter` writes readings as they come, `gather` gives them
back, `Moments` one moment after the other, and `opened_mcap` with `TopicReader` some at a time. Every message is
plain ROS 2, so that any viewer and any reader of bags opens the file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "Gathered",
    "Moment",
    "Moments",
    "Note",
    "PadFacts",
    "Series",
    "TopicReader",
    "TopicWriter",
    "attachments_of",
    "gather",
    "gathered",
    "opened_mcap",
]

if TYPE_CHECKING:
    from varishold.recording.mcap.container import attachments_of, opened_mcap
    from varishold.recording.mcap.gathering import Gathered, Series, gather, gathered
    from varishold.recording.mcap.moments import Moment, Moments
    from varishold.recording.mcap.readings import Note, TopicReader
    from varishold.recording.mcap.topics import PadFacts
    from varishold.recording.mcap.writer import TopicWriter
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
