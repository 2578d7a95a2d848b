"""Addresses: what each option may be and nothing beyond, what is usual, and what every kind says of itself."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from tests.live_scripted import Scripted

from varishold.errors import InputError, LostSourceError
from varishold.live import (
    source_at,
)
from varishold.live.address import parse_address
from varishold.live.interpreted import topics_at
from varishold.live.sources import KINDS, source_kind

_FROM_TO = [
    ("sim:sphere?seed=", "0", "2147483648", "-1", "2147483649"),
    ("sim:sphere?pads=", "1", "64", "0", "65"),
    ("sim:sphere?rate_hz=", "0.1", "1e5", "0.09", "1.1e5"),
    ("sim:sphere?speed=", "0", "1e6", "-0.1", "1.1e6"),
    ("sim:sphere?duration_s=", "0", "inf", "-0.1", "nan"),
    ("sim:sphere?noise=", "0", "4095", "-0.1", "4096"),
    ("sim:sphere?drift=", "-4095", "4095", "-4096", "4096"),
    ("sim:sphere?creep=", "0", "1", "-0.1", "1.1"),
    ("sim:sphere?moves=", "0", "1", "-0.1", "1.1"),
    ("sim:sphere?hold_s=", "0.01", "1e5", "0.009", "1.1e5"),
    ("sim:sphere?rest_s=", "0.01", "1e5", "0.009", "1.1e5"),
    ("sim:sphere?pitch_m=", "1e-5", "1", "0.9e-5", "1.1"),
    ("sim:sphere?shape=", "4x4", "256x256", "3x9", "257x9"),
    ("replay:FILE?speed=", "0", "1e6", "-0.1", "1.1e6"),
    ("replay:FILE?rate_hz=", "1e-3", "1e6", "0.9e-3", "1.1e6"),
    ("replay:FILE?loop=", "0", "1", "-1", "2"),
    ("replay:FILE?pitch_m=", "1e-9", "1e3", "0.9e-9", "1.1e3"),
    ("replay:FILE?shape=", "1x1", "4096x4096", "0x1", "4097x1"),
    ("serial:/dev/x?preset=flexitac&baud=", "50", "100000000", "49", "100000001"),
    ("serial:/dev/x?preset=flexitac&pitch_m=", "1e-9", "1e3", "0.9e-9", "1.1e3"),
    ("stdin:?preset=arduino-rows&rate_hz=", "1e-3", "1e6", "0.9e-3", "1.1e6"),
    ("zenoh://h/skin?domain=", "0", "232", "-1", "233"),
    ("udp::9000?shape=", "1x1", "4096x4096", "1x0", "1x4097"),
]


@pytest.mark.parametrize(("text", "least", "most", "below", "above"), _FROM_TO)
def test_an_option_may_be_its_least_and_its_most_and_nothing_beyond(
    text: str, least: str, most: str, below: str, above: str, tmp_path: Path
) -> None:
    file = tmp_path / "press.npz"
    file.touch()
    text = text.replace("FILE", str(file))
    for value in (least, most):
        assert source_at(text + value).address == text + value
    for value in (below, above):
        with pytest.raises(InputError) as told:
            source_at(text + value)
        assert str(told.value).startswith(f"{text}{value}: ")


@pytest.mark.parametrize(
    ("text", "host", "port"), [("udp::1", "", 1), ("udp::65535", "", 65535), ("udp:127.0.0.1", "127.0.0.1", 9000)]
)
def test_a_port_is_from_1_to_65535_and_there_is_a_usual_one(text: str, host: str, port: int) -> None:
    source: Any = source_at(text)
    assert (source._port._place.host, source._port._place.port) == (host, port)
    for wrong in ("udp::0", "udp::65536"):
        with pytest.raises(InputError, match="must be as udp:HOST:PORT, got"):
            source_at(wrong)


def test_only_what_comes_when_it_is_asked_for_can_wait() -> None:
    waits = {"stdin:": True, "sim:cone?speed=0": True, "sim:cone": False, "replay:a.npz?speed=2": False, "udp:": False}
    assert {text: parse_address(text).can_wait for text in waits} == waits


@pytest.mark.parametrize("error", [LostSourceError("nobody"), InputError("must name a topic"), None])
def test_topics_are_told_in_their_order_however_opening_ends(error: Exception | None) -> None:
    source: Any = Scripted()
    source.wrong, source.topics = error, {"/b": "Image", "/a": "Int16"}
    assert topics_at("root:", source) == [("root:/a", "Int16"), ("root:/b", "Image")]
    assert source.closed == 1


@pytest.mark.parametrize("name", KINDS)
def test_each_kind_of_source_has_a_title_and_an_example_that_makes_one(name: str, tmp_path: Path) -> None:
    kind = source_kind(name)
    assert source_kind(parse_address(kind.example).kind) is kind
    assert ":" not in kind.title
    assert kind.title[:1].isalpha()
    file = tmp_path / "press.npz"
    file.touch()
    example = kind.example.replace("FILE", str(file))
    if any(find_spec(module) is None for module in kind.needs):
        return
    source = kind.make(parse_address(example))
    assert (source.address, type(source)) == (example, type(source_at(example)))
