"""A recorder loses nothing of what came, and a file of it is there at any moment."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

pytest.importorskip("mcap", reason="recording needs the extra live")
from tests.live_scripted import Scripted, sample, wait_until

from varishold.errors import EndOfSourceError, InputError
from varishold.learning import labelled_presses
from varishold.live import PadLayout, Recorder, Sample, Stream, samples_of, source_at
from varishold.live.sample_file import Limits, sample_file
from varishold.recording import Blocks, read, write
from varishold.recording.mcap import gather
from varishold.recording.mcap.clock import seconds
from varishold.recording.mcap.topics import MARKS, ZEROS


@st.composite
def samples(draw: st.DrawFn) -> list[Sample]:
    """Samples of two pads and signals, which come together or not."""
    made = []
    for number in range(draw(st.integers(1, 8))):
        pads = {
            "palm": draw(hnp.arrays(np.uint16, (2, 3))),
            "free": draw(hnp.arrays(np.float32, (4,), elements=st.floats(-9, 9, width=32))),
            "coils": draw(hnp.arrays(np.float64, (2, 3), elements=st.floats(allow_nan=False))),
        }
        names = draw(st.lists(st.sampled_from(sorted(pads)), min_size=1, unique=True))
        device = draw(st.none() | st.integers(0, 10**6).map(lambda tick: tick / 1000))
        sequence = draw(st.none() | st.integers(0, 2**32 - 1))
        made.append(Sample(device, 1.7e9 + number / 64, sequence, {name: pads[name] for name in names}))
    return made


LAYOUTS = {
    "palm": PadLayout((2, 3), pitch_m=(0.001, 0.002), unit="kPa"),
    "free": PadLayout((4,), polarity="down"),
    "coils": PadLayout((2, 3), kind="signals", names=("Bx", "By", "Bz")),
}


@settings(max_examples=50)
@given(samples())
def test_every_sample_is_in_the_file_as_it_came(tmp_path_factory: pytest.TempPathFactory, came: list[Sample]) -> None:
    path = tmp_path_factory.mktemp("rec") / "a.mcap"
    with sample_file(path, lambda: LAYOUTS, sensor="a hand") as file:
        for each in came:
            file.add(each)
    held = gather(path)
    for name, layout in LAYOUTS.items():
        mine = [each for each in came if name in each.pads]
        if not mine:
            assert name not in held.pads
            continue
        series = held.pads[name]
        facts = series.facts
        assert (facts.kind, facts.unit, facts.polarity) == (layout.kind, layout.unit, layout.polarity)
        assert (facts.names, facts.sensor) == (layout.names, "a hand")
        assert facts.pitch_m == layout.pitch_m
        np.testing.assert_array_equal(seconds(series.log_ns), [each.host_time_s for each in mine])
        values = np.array([each.pads[name] for each in mine])
        assert series.values.dtype == values.dtype
        np.testing.assert_array_equal(series.values.reshape(values.shape), values)
        if all(each.device_time_s is not None for each in mine):
            assert series.stamp == "device"
            np.testing.assert_array_equal(seconds(series.stamp_ns), [each.device_time_s for each in mine])
        if all(each.sequence is not None for each in mine):
            assert series.sequence is not None
            assert series.sequence.tolist() == [each.sequence for each in mine]


@settings(max_examples=50)
@given(samples(), st.booleans())
def test_what_was_recorded_is_played_as_it_came(
    tmp_path_factory: pytest.TempPathFactory, came: list[Sample], killed: bool
) -> None:
    path = tmp_path_factory.mktemp("rec") / "a.mcap"
    with sample_file(path, lambda: LAYOUTS) as file:
        for each in came:
            file.add(each)
    if killed:
        # The end and the index before it.
        path.write_bytes(path.read_bytes()[:-200])
    source = source_at(f"replay:{path}?speed=0")
    played = list(samples_of(source))
    assert len(played) == len(came)
    for mine, its in zip(came, played, strict=True):
        assert (mine.device_time_s, mine.sequence) == (its.device_time_s, its.sequence)
        assert its.host_time_s - played[0].host_time_s == pytest.approx(
            mine.host_time_s - came[0].host_time_s, abs=1e-5
        )
        assert list(its.pads) == list(mine.pads)
        for name, values in mine.pads.items():
            assert its.pads[name].dtype == values.dtype
            np.testing.assert_array_equal(its.pads[name].reshape(values.shape), values)
    assert {name: source.pads[name] for name in source.pads} == {
        name: replace(layout, shape=source.pads[name].shape) for name, layout in LAYOUTS.items() if name in source.pads
    }


def test_masks_of_a_source_are_recorded(tmp_path: Path) -> None:
    path, layout = tmp_path / "a.mcap", PadLayout((2, 3), gaps=(5,), broken=(0, 1))
    with sample_file(path, lambda: {"pad": layout}) as file:
        file.add(sample(1))
    pad = read(path).pads["pad"]
    assert pad.field is not None
    assert pad.valid is not None
    assert pad.field.ravel().tolist() == [True] * 5 + [False]
    assert pad.valid.ravel().tolist() == [False] * 2 + [True] * 4
    source = source_at(f"replay:{path}?speed=0")
    source.open()
    assert source.pads == {"pad": layout}
    source.close()


def test_a_stream_is_recorded_with_what_its_ring_holds_already(tmp_path: Path) -> None:
    source = Scripted()
    for number in range(3):
        source.script.put(sample(number))
    with Stream(source) as stream:
        wait_until(lambda: stream.received == 3)
        with (
            Recorder(stream, tmp_path / "all.mcap") as whole,
            Recorder(stream, tmp_path / "new.mcap", from_now=True) as new,
        ):
            for number in range(3, 6):
                source.script.put(sample(number))
            source.script.put(EndOfSourceError("all of it"))
            assert whole.wait(20)
            assert new.wait(20)
    assert read(tmp_path / "all.mcap").pads["pad"].frames[:, 0, 0].tolist() == list(range(6))
    assert read(tmp_path / "new.mcap").pads["pad"].frames[:, 0, 0].tolist() == [3, 4, 5]
    assert (whole.tally.samples, whole.tally.lost, whole.missed) == (6, 0, 0)


def test_the_file_can_be_read_while_it_grows(tmp_path: Path) -> None:
    source, path = Scripted(), tmp_path / "a.mcap"
    with Stream(source) as stream, Recorder(stream, path) as recorder:
        assert not path.exists()
        source.script.put(sample(0))
        wait_until(path.exists)
        assert read(path).n_frames == 1
        source.script.put(sample(1))
        # It comes without a further sample.
        wait_until(lambda: read(path).n_frames == 2)
        assert "has no end" in read(path).remarks[0]
    assert recorder.tally.samples == 2
    assert not any("has no end" in remark for remark in read(path).remarks)


def test_marks_and_zeros_stand_beside_the_readings(tmp_path: Path) -> None:
    source, path = Scripted(), tmp_path / "a.mcap"
    source.script.put(sample(0))
    files = {"sensor.toml": "span = 5\n"}
    with Stream(source) as stream, Recorder(stream, path, sensor="hand", files=files) as recorder:
        wait_until(path.exists)
        recorder.mark("cone", press=3)
        recorder.zeroed({"time_s": 0.5, "taken": False, "why": "something presses"})
    held = gather(path)
    assert [(note.topic, note.told) for note in held.notes] == [
        (MARKS, {"label": "cone", "press": 3}),
        (ZEROS, {"time_s": 0.5, "taken": False, "why": "something presses"}),
    ]
    assert abs(held.notes[0].log_ns / 1e9 - time.time()) < 3600
    assert held.attachments == {"sensor.toml": b"span = 5\n"}


def test_lost_and_strange_readings_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with sample_file(path, dict) as file:
        for number in (0, 1, 4, 5, 2, 3):
            file.add(sample(number))
        for strange in (np.zeros((3, 3), np.int32), np.zeros((2, 3), complex), np.zeros((0, 3), np.int32)):
            file.add(Sample(None, 1e9, 9, {"pad": strange}))
        file.add(Sample(float("nan"), float("inf"), None, {"pad": np.zeros((2, 3), np.int32)}))
        tally = file.tally
    assert (tally.samples, tally.lost, tally.refused) == (7, 2, 3)
    assert tally.why == "pad pad was of shape (3, 3) after (2, 3)"
    assert gather(path).pads["pad"].values[:, 0, 0].tolist() == [0, 1, 4, 5, 2, 3, 0]


@pytest.mark.parametrize(
    ("limits", "expected"), [(Limits(samples=5), 5), (Limits(seconds=0.07), 7), (Limits(3, 0.07), 3), (Limits(), 20)]
)
def test_it_ends_where_it_is_told_to(tmp_path: Path, limits: Limits, expected: int) -> None:
    source, path = Scripted(), tmp_path / "a.mcap"
    for number in range(20):
        source.script.put(sample(number))
    source.script.put(EndOfSourceError("all of it"))
    with Recorder(source, path, limits=limits) as recorder:
        assert recorder.wait(20)
    assert recorder.tally.samples == read(path).n_frames == expected
    assert source.closed


def test_a_silent_source_ends_a_recording_that_is_to_take_so_long(tmp_path: Path) -> None:
    source, path = Scripted(), tmp_path / "a.mcap"
    source.script.put(sample(0))
    with Stream(source) as stream, Recorder(stream, path, limits=Limits(seconds=0.1)) as recorder:
        assert recorder.wait(20)
    assert read(path).n_frames == 1


class InPieces(Scripted):
    """A pipe whose readings are longer than what is read of it at once."""

    pieces = 400

    def read(self, timeout_s: float) -> list[Sample]:
        self.pieces -= 1
        return [] if self.pieces >= 0 else super().read(timeout_s)


def test_a_reading_that_comes_in_pieces_is_not_waited_for_between_them(tmp_path: Path) -> None:
    source = InPieces()
    source.script.put(sample(0))
    source.script.put(EndOfSourceError("all"))
    begun_s = time.monotonic()
    with Recorder(source, tmp_path / "a.mcap") as recorder:
        assert recorder.wait(60)
    # Of a twentieth of a second a piece it would be twenty.
    assert time.monotonic() - begun_s < 10
    assert read(tmp_path / "a.mcap").n_frames == 1


def test_a_source_without_a_reading_leaves_no_file(tmp_path: Path) -> None:
    source = Scripted()
    source.script.put(EndOfSourceError("nothing"))
    with Recorder(source, tmp_path / "a.mcap") as recorder:
        assert recorder.wait(20)
    assert list(tmp_path.iterdir()) == []


def test_a_source_that_can_never_be_read_is_told(tmp_path: Path) -> None:
    source = Scripted()
    source.wrong = InputError("scripted:: no such thing")
    with (
        pytest.raises(InputError, match="no such thing"),
        Stream(source) as stream,
        Recorder(stream, tmp_path / "a.mcap") as recorder,
    ):
        recorder.wait(20)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="takes a device that is always full")
def test_a_full_disk_ends_it_with_one_line() -> None:
    with (
        pytest.raises(InputError, match="no space left on device"),
        Recorder(source_at("sim:sphere?speed=0&duration_s=1e4"), "/dev/full") as recorder,
    ):
        assert recorder.wait(60)


def test_what_was_said_to_be_felt_labels_the_presses(tmp_path: Path) -> None:
    source, path = Scripted(), tmp_path / "a.mcap"
    load = 60 * np.outer(np.hanning(8), np.hanning(8))

    def put(first: int, label: str) -> None:
        recorder.mark(label)
        for k in range(first, first + 60):
            frame = np.random.default_rng(k).normal(0, 1, (8, 8)) + (load if k % 30 > 20 else 0)
            # Marks are made by the clock of this machine.
            source.script.put(Sample(k / 100, time.time(), k, {"pad": frame}))
        wait_until(lambda: recorder.tally.samples == first + 60)

    with Recorder(source, path) as recorder:
        put(0, "cone")
        put(60, "ball")
        put(120, "")
    recording = read(path)
    assert [mark.label for mark in recording.marks] == ["cone", "ball", ""]
    assert [mark.frame for mark in recording.marks] == [0, 60, 120]
    table = recording.presses
    assert table.columns["label"].tolist() == ["cone", "cone", "ball", "ball", "", ""]
    write(recording, tmp_path / "a.npz")
    assert read(tmp_path / "a.npz").marks == recording.marks
    some = Blocks(recording).frames[70:130]
    assert some.marks == ((0, "ball"), (50, ""))
    labelled = labelled_presses([Blocks(recording).frames[:120]], label="label")
    assert labelled.labels.tolist() == ["cone", "cone", "ball", "ball"]
