"""A library that a source needs and that is not installed is told in one line, with the command that installs it."""

from __future__ import annotations

import sys

import pytest

from varishold.errors import MissingExtraError
from varishold.live import source_at
from varishold.live.sources import lab_stream, source_kind
from varishold.recording.messages import message_decoder


@pytest.mark.parametrize(
    ("address", "library", "extra"),
    [
        ("zenoh://localhost/skin", "zenoh", "zenoh"),
        ("lsl:skin", "pylsl", "lsl"),
        ("mqtt://localhost/skin", "paho", "mqtt"),
    ],
)
def test_a_source_says_what_it_needs(address: str, library: str, extra: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lab_stream._library.cache_clear()
    for name in [*sys.modules]:
        if name.partition(".")[0] == library:
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingExtraError, match=rf"^this needs {library}, .* run: pip install -e '\.\[{extra}\]'$"):
        source_at(address)
    found = source_kind(address.partition(":")[0]).found
    if found is not None:
        with pytest.raises(MissingExtraError):
            found()
    lab_stream._library.cache_clear()


def test_messages_of_ros_say_what_they_need(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [*sys.modules]:
        if name.partition(".")[0] == "rosbags":
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(MissingExtraError, match=r"^this needs rosbags, .* run: pip install -e '\.\[live\]'$"):
        message_decoder("cdr", "std_msgs/msg/String")
    assert message_decoder("json")(b"{}") == {}
