"""Streams of the Lab Streaming Layer: pylsl's own outlet sends them in this process."""

from __future__ import annotations

import re
import uuid
from pathlib import Path
from typing import Any

import numpy as np
import pytest

try:
    import pylsl
except (ImportError, OSError, RuntimeError):
    pytest.skip("pylsl is not installed", allow_module_level=True)

from tests.live_reading import read_on, read_some
from tests.live_scripted import wait_until

from varishold.errors import InputError, LostSourceError
from varishold.live import Stream, source_at
from varishold.live.sources import source_kind

RNG = np.random.default_rng(4)
FORMATS = {"float32": pylsl.cf_float32, "float64": pylsl.cf_double64, "int16": pylsl.cf_int16, "int32": pylsl.cf_int32}


def outlet(
    channels: int, name: str = "", kind: str = "float32", *, rate_hz: float = 0.0, labels: bool = False, **told: Any
) -> tuple[Any, str]:
    """Return an outlet, and the name of its stream, which no other has."""
    name = name or f"skin-{uuid.uuid4()}"
    info = pylsl.StreamInfo(name, "Tactile", channels, rate_hz, FORMATS.get(kind, pylsl.cf_string), str(uuid.uuid4()))
    for key, value in told.items():
        info.desc().append_child_value(key, str(value))
    if labels:
        listed = info.desc().append_child("channels")
        for number in range(channels):
            channel = listed.append_child("channel")
            channel.append_child_value("label", f"B{number}")
            channel.append_child_value("unit", "uT")
    return pylsl.StreamOutlet(info), name


@pytest.mark.parametrize("kind", FORMATS)
def test_what_an_outlet_sends_is_what_is_read(kind: str) -> None:
    frames = RNG.integers(0, 2**15, (300, 4, 6)).astype(kind)
    sender, name = outlet(24, kind=kind, rows=4, cols=6, pitch_m=0.002)
    source = source_at(f"lsl:{name}")
    assert dict(source.pads) == {}
    source.open()
    wait_until(sender.have_consumers)
    for number, frame in enumerate(frames):
        sender.push_sample(frame.ravel().tolist(), timestamp=100.0 + number)
    samples = read_some(source, 300)
    source.close()
    source.close()
    np.testing.assert_array_equal([sample.pads["pad"] for sample in samples], frames)
    assert samples[0].pads["pad"].dtype == kind
    assert [sample.device_time_s for sample in samples] == [100.0 + number for number in range(300)]
    layout = source.pads["pad"]
    assert (layout.shape, layout.kind, layout.pitch_m) == ((4, 6), "pressure", (0.002, 0.002))


def test_the_shape_that_is_asked_for_goes_before_the_description() -> None:
    sender, name = outlet(6, rows=3, cols=2)
    source = source_at(f"lsl:{name}?shape=2x3")
    source.open()
    wait_until(sender.have_consumers)
    sender.push_sample([1, 2, 3, 4, 5, 6])
    assert read_some(source, 1)[0].pads["pad"].tolist() == [[1, 2, 3], [4, 5, 6]]
    source.close()


def test_the_page_shows_how_to_send() -> None:
    page = (Path(__file__).parents[1] / "docs" / "live.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(import pylsl\n.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {}
    exec(block, names)
    source = source_at("lsl:skin?source=my-skin-1")
    source.open()
    assert (source.pads["pad"].shape, source.pads["pad"].pitch_m) == ((16, 16), (0.004, 0.004))
    source.close()


def test_labelled_channels_on_no_grid_are_signals() -> None:
    sender, name = outlet(3, labels=True)
    source = source_at(f"lsl:{name}")
    source.open()
    wait_until(sender.have_consumers)
    sender.push_sample([1, 2, 3])
    assert read_some(source, 1)[0].pads["pad"].tolist() == [1, 2, 3]
    layout = source.pads["pad"]
    assert (layout.shape, layout.kind, layout.names, layout.unit) == ((3,), "signals", ("B0", "B1", "B2"), "uT")
    source.close()
    del sender


@pytest.mark.parametrize("told", [{}, {"rows": "many", "cols": 2}, {"rows": -4, "cols": 1}, {"rows": "nan", "cols": 4}])
def test_a_description_that_says_nothing_leaves_a_row(told: Any) -> None:
    sender, name = outlet(4, **told)
    source = source_at(f"lsl:{name}")
    source.open()
    assert source.pads["pad"].shape == (4,)
    source.close()
    del sender


def test_an_outlet_that_leaves_is_told_and_found_again() -> None:
    sender, name = outlet(1)
    stream = Stream(source_at(f"lsl:{name}")).start()
    wait_until(lambda: stream.state == "open")
    del sender
    wait_until(lambda: stream.state == "lost")
    sender, _ = outlet(1, name)
    wait_until(lambda: stream.state == "open")
    wait_until(sender.have_consumers)
    sender.push_sample([7])
    wait_until(lambda: stream.received == 1)
    stream.close()


def test_a_steady_stream_that_falls_silent_is_told() -> None:
    sender, name = outlet(1, rate_hz=100)
    source = source_at(f"lsl:{name}")
    source.open()
    with pytest.raises(LostSourceError, match=r"is silent for \d+\.\d s, and promises 100 readings a second"):
        read_on(source)
    source.close()
    del sender


@pytest.mark.parametrize(
    ("channels", "kind", "told", "words"),
    [
        (4, "float32", {"rows": 3, "cols": 2}, r"has 4 channels, which are no 3 x 2; add \?shape=ROWSxCOLS"),
        (1, "string", {}, "sends text; a stream of numbers is needed"),
    ],
)
def test_streams_that_cannot_be_read_are_told(channels: int, kind: str, told: Any, words: str) -> None:
    sender, name = outlet(channels, kind=kind, **told)
    source = source_at(f"lsl:{name}")
    with pytest.raises(InputError, match=f"^lsl:{name}: {words}"):
        source.open()
    source.close()
    del sender


def test_nobody_there_is_told() -> None:
    source = source_at("lsl:nobody-sends-this")
    with pytest.raises(LostSourceError, match=r"^lsl:nobody-sends-this: no such stream is in reach"):
        source.open()
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)
    sender, name = outlet(1)
    with pytest.raises(LostSourceError, match="no such stream is in reach"):
        source_at(f"lsl:{name}?source=another").open()
    del sender


def test_streams_in_reach_are_found() -> None:
    sender, name = outlet(6, rate_hz=50)
    found = source_kind("lsl").found
    assert found is not None
    assert (f"lsl:{name}", "Tactile, 6 channels, 50 Hz") in found()
    del sender


@pytest.mark.parametrize(
    ("address", "words"),
    [("lsl:", "must name a stream, as in lsl:skin"), ("lsl:a?x=1", "lsl has no option 'x'; known are shape, source")],
)
def test_addresses_that_cannot_be_are_told(address: str, words: str) -> None:
    with pytest.raises(InputError) as told:
        source_at(address)
    assert words in str(told.value)
