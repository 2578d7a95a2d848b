"""What is said beside numbers: words of messages, presses, marks, units, notes; each as a whole, each at its edge."""
# ruff: noqa: E501

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_recording_bound_laws import refused
from tests.test_recording_messages import cloud
from tests.test_recording_piece_laws import image

from varishold import open as open_recording
from varishold.errors import FormatError, InputError
from varishold.recording import Mark, Pad, Recording, Signals, presses, read, write
from varishold.recording.conversion import beyond_recording, convert, losses
from varishold.recording.formats import csv_titles, press_rows
from varishold.recording.formats.format import Options
from varishold.recording.formats.guessing import guessed
from varishold.recording.formats.lerobot_plan import plan_of
from varishold.recording.formats.mcap import is_measured
from varishold.recording.formats.named_arrays import stored_in
from varishold.recording.formats.numbers import Rows, Separator
from varishold.recording.formats.topics_said import exact_times, left_out, marks_of, said_of
from varishold.recording.grasp_table import cell_text
from varishold.recording.mcap import Moments, PadFacts, TopicWriter, gather, stream
from varishold.recording.mcap.gathering import Gathered
from varishold.recording.mcap.press_notes import COLUMNS, press_notes, presses_of, typed_column
from varishold.recording.mcap.readings import Note
from varishold.recording.mcap.topics import MARKS, PRESSES, ZEROS
from varishold.recording.messages import message_decoder, read_message
from varishold.recording.pad import frame_of
from varishold.recording.press_table import checked_marks, press_table
from varishold.recording.stored import Stored, StoredPad

FRAMES = np.arange(5 * 3 * 4, dtype=np.uint16).reshape(5, 3, 4)


def said(act: Callable[[], object], told: str) -> None:
    """Assert that something is refused in these words, whole."""
    with pytest.raises(InputError) as error:
        act()
    assert str(error.value) == told


# Messages


IMAGE = {"height": 2, "width": 3, "encoding": "mono8", "step": 3, "data": [*range(6)]}


@pytest.mark.parametrize(
    ("message", "told"),
    [
        (IMAGE | {"encoding": "rgb8"}, "an image in 'rgb8' came, which is no map of pressure; 32FC1, 64FC1, 16UC1, 16SC1, 32SC1, 8UC1, mono8 and mono16 are"),
        (IMAGE | {"encoding": "8FC1"}, "an image in '8FC1' came: there are no such numbers"),
        (IMAGE | {"height": -1}, "an image of -1 x 3 came"),
        (IMAGE | {"height": 1 << 23}, "an image of 8388608 x 3 came"),
        (IMAGE | {"step": 2}, "an image of 2 x 3 mono8 with 2 bytes a row came with 6 bytes"),
        (IMAGE | {"step": 4}, "an image of 2 x 3 mono8 with 4 bytes a row came with 6 bytes"),
        (IMAGE | {"data": [0, 256] * 3}, "an image's data must be bytes, from 0 to 255 each"),
        (IMAGE | {"data": [0, -1] * 3}, "an image's data must be bytes, from 0 to 255 each"),
        (IMAGE | {"data": [0.5] * 6}, "an image's data must be bytes, from 0 to 255 each"),
        (IMAGE | {"data": "no base64!"}, "an image's data came as text that is no base64: 'no base64!'"),
        ({"layout": {"dim": [{"size": 3}], "data_offset": 0}, "data": [1.0, 2.0]}, "an array's layout says 3 values, and 2 came"),
        ({"layout": {"dim": [{"size": 2}, {"size": 2}]}, "data": [1.0] * 5}, "an array's layout says 2 x 2 values, and 5 came"),
        ({"layout": {"dim": [{"size": 2}, {"size": 0}]}, "data": [1.0]}, "an array's layout says 2 x 0 values"),
        ({"layout": {"dim": [{"size": 1 << 24}, {"size": 2}]}, "data": [1.0]}, "an array's layout says 16777216 x 2 values"),
        ({"layout": {"dim": [], "data_offset": 3}, "data": [1.0, 2.0]}, "an array's data begin at 3, and 2 values came"),
        ({"layout": {"dim": [], "data_offset": -1}, "data": [1.0, 2.0]}, "an array's data begin at -1, and 2 values came"),
        ({"cells_x": 2, "cells_y": 3, "pressure": [1.0] * 5}, "a matrix of 3 x 2 cells came with 5 values"),
        ({"sensor": "1", "model": "uSPa44", "data": "zz"}, "a sensor's data came that are no hexadecimal words: 'zz'"),
        ({"sensor": "1", "model": "uSPa44", "data": "1,2", "taxels": 1}, "a sensor of 1 taxels came with 2 values, three a taxel"),
        ({"sensor": "1", "model": "uSPa44", "data": "1,2,3", "taxels": 2}, "a sensor of 2 taxels came with 3 values, three a taxel"),
        ({"taxels": [{"x": 1, "y": 2}]}, "a taxel came without a number for one of x, y, z"),
        ({"pillars": [{"fX": 1, "fY": 2}]}, "a taxel came without a number for one of fx, fy, fz"),
        ({"values": np.zeros((2, 2, 2, 2))}, "values of 4 dimensions came; a pad has rows and columns"),
        (5, "a message has fields, and int has none"),
        ({"what": "x", "n": [1, "a"], "l": [{}, {}]}, "a message is not understood: its fields are what, n[2], l[2]; name the one that holds the values as field"),
    ],
)  # fmt: skip
def test_what_a_message_cannot_mean_is_told(message: Any, told: str) -> None:
    said(lambda: read_message(message), told)


@pytest.mark.parametrize(
    "message",
    [
        IMAGE | {"height": 0},
        IMAGE | {"width": 0},
        {"height": 0, "width": 3, "fields": [{"name": "pressure", "offset": 0, "datatype": 7}], "point_step": 4, "data": np.zeros(0, np.uint8), "empty": []},
    ],
)  # fmt: skip
def test_what_holds_nothing_is_no_pad(message: dict[str, Any]) -> None:
    assert dict(read_message(message | {"empty": []}).pads) == {}


@pytest.mark.parametrize(
    ("message", "pads"),
    [
        (IMAGE, {"pad": [[0, 1, 2], [3, 4, 5]]}),
        (IMAGE | {"step": 0}, {"pad": [[0, 1, 2], [3, 4, 5]]}),
        (IMAGE | {"encoding": "MONO8"}, {"pad": [[0, 1, 2], [3, 4, 5]]}),
        (IMAGE | {"step": 4, "data": [*range(7)]}, {"pad": [[0, 1, 2], [4, 5, 6]]}),
        (IMAGE | {"encoding": "16uc1", "width": 1, "step": 2, "data": [1, 2, 3, 4]}, {"pad": [[0x201], [0x403]]}),
        (IMAGE | {"encoding": "16SC", "width": 1, "step": 2, "data": [1, 2, 3, 255], "is_bigendian": 1}, {"pad": [[0x102], [0x3FF]]}),
        ({"layout": {"dim": [], "data_offset": 1}, "data": [1.0, 2.0, 3.0]}, {"pad": [2, 3]}),
        ({"layout": {"dim": [{"size": 2, "stride": 5}, {"size": 2, "stride": 3}]}, "data": [*range(5)]}, {"pad": [[0, 1], [3, 4]]}),
        ({"layout": {"dim": [{"size": 2}, {"size": 2, "stride": 1}]}, "data": [*range(4)]}, {"pad": [[0, 1], [2, 3]]}),
        ({"layout": {"dim": [{"size": 1}, {"size": 2}, {"size": 3, "label": "xyz"}]}, "data": [*range(6)]}, {"pad": [[2, 5]], "shear.pad": [0, 1, 3, 4]}),
        ({"layout": {"dim": [{"size": 1}, {"size": 2}, {"size": 3}]}, "data": [*range(6)]}, {"pad": [[0, 1, 2], [3, 4, 5]]}),
        ({"layout": {"dim": [{"size": 2}, {"size": 1}, {"size": 3}]}, "data": [*range(6)]}, {"pad": [[2], [5]], "shear.pad": [0, 1, 3, 4]}),
        ({"layout": {"dim": [{"size": 2}, {"size": 2}, {"size": 1}]}, "data": [*range(4)]}, {"pad": [[0, 1], [2, 3]]}),
        ({"layout": {"dim": [{"size": 2}, {"size": 1}, {"size": 2}]}, "data": [*range(4)]}, {"0": [[0, 1]], "1": [[2, 3]]}),
        ({"cells_x": 2, "cells_y": 1, "pressure": [1.0, 2.0], "tactile_array": [3, 4]}, {"pad": [[3, 4]]}),
        ({"cells_x": 1, "cells_y": 2, "pressure": [1.0, 2.0], "matrix_id": 7}, {"7": [[1], [2]]}),
        ({"pressure_values": [*range(9)], "sensor_name": " tip "}, {"tip": [[0, 1, 2], [3, 4, 5], [6, 7, 8]]}),
        ({"pressure_values": [*range(4)]}, {"pad": [0, 1, 2, 3]}),
        ({"values": [1, 2], "temperature": [20.5]}, {"pad": [1, 2], "temperature.pad": [20.5]}),
        ({"values": [1, 2], "temperature": []}, {"pad": [1, 2]}),
        ({"values": [1, 2], "temperature": [[5.0]]}, {"pad": [1, 2]}),
        ({"left": [[1, 2]], "right": [[3], [4]], "n": 5}, {"left": [[1, 2]], "right": [[3], [4]]}),
        ({"sensor": "a", "model": "uSPa44", "data": "1,2,a"}, {"a": [10], "shear.a": [1, 2]}),
        ({"sensor": "a", "model": "x12", "data": "1,2,3,4,5,6", "calibrated": [0.5, 1.5, 2.5, 3.5, 4.5, 5.5]}, {"a": [[2.5, 5.5]], "shear.a": [0.5, 1.5, 3.5, 4.5]}),
        ({"hand": 1, "sequence": 3, "pressure": [1.0, 2.0]}, {"pad": [1, 2]}),
        ({"forces": [*range(12)], "displacements": [], "sn": "s"}, {"s": [[2, 5], [8, 11]], "shear.s": [0, 1, 3, 4, 6, 7, 9, 10]}),
        ({"electrodes": [5, 6], "pdc": 7}, {"pad": [5, 6, 7]}),
        ({"electrodes": [5, 6]}, {"pad": [5, 6]}),
        ({"magnetic_data": [{"x": 1, "y": 2, "z": 3}], "temperature_data": []}, {"pad": [1, 2, 3]}),
        ({"palm_touch": [*range(9)], "nail_touch": [1]}, {"palm": [[0, 1, 2], [3, 4, 5], [6, 7, 8]]}),
        ({"hands": [{"values": [1]}, {"values": [2]}], "header": {"values": [9]}}, {"hands_0": [1], "hands_1": [2]}),
        ({"a": {"b": {"values": [1]}}, "stamp": {"values": [5]}}, {"a_b": [1]}),
        ({"x": {"name": "tip", "values": [1]}, "y": {"name": "tip", "values": [2]}}, {"tip": [1], "tip_2": [2]}),
        ({"a": {"name": True, "values": [1]}, "b": {"name": "\x07", "values": [2]}}, {"a": [1], "b": [2]}),
        ({"a": {"name": "n" * 99, "values": [1]}}, {"n" * 80: [1]}),
        ({"values": [True, False]}, {"pad": [1, 0]}),
    ],
)  # fmt: skip
def test_what_a_message_means_is_its_pads(message: dict[str, Any], pads: dict[str, Any]) -> None:
    assert {name: pad.values.tolist() for name, pad in read_message(message).pads.items()} == pads


def test_messages_within_messages_are_looked_into_six_deep() -> None:
    def nested(depth: int) -> dict[str, Any]:
        made: dict[str, Any] = {"values": [1.0]}
        for _ in range(depth):
            made = {"a": made}
        return made

    assert list(read_message(nested(6)).pads) == ["_".join("a" * 6)]
    with pytest.raises(InputError, match="is not understood"):
        read_message(nested(7))


@pytest.mark.parametrize(("many", "fits"), [(1024, True), (1025, False)])
def test_a_message_has_so_many_pads(many: int, fits: bool) -> None:
    message = {"hands": [{"values": [k]} for k in range(many)]}
    if fits:
        assert len(read_message(message).pads) == many
    else:
        said(lambda: read_message(message), "a message of more than 1024 pads came")


@pytest.mark.parametrize(
    ("header", "time_s", "number"),
    [
        ({"stamp": {"sec": 5, "nanosec": 250_000_000}, "seq": 3}, 5.25, 3),
        ({"stamp": {"secs": 5, "nsecs": 500_000_000}}, 5.5, None),
        ({"stamp": {"sec": 0, "nsec": 1}}, 1e-9, None),
        ({"stamp": {"sec": 0, "nanosec": 0}, "sequence": 0}, None, 0),
        ({"stamp": {"sec": 5}}, None, None),
        ({"timestamp": {"sec": 5, "nanosecs": 0}, "message": 7}, 5.0, 7),
        ({"stamp": 5.5}, None, None),
    ],
)
def test_the_time_of_a_header_is_whole_seconds_and_parts(
    header: dict[str, Any], time_s: float | None, number: int | None
) -> None:
    for message in ({"header": header, "values": [1]}, header | {"values": [1]}):
        reading = read_message(message)
        assert (reading.time_s, reading.sequence) == (time_s, number)


@pytest.mark.parametrize(
    ("message", "time_s", "number"),
    [
        ({"taxels": [{"x": 1, "y": 2, "z": 3}], "time": 2.5, "message": 4}, 2.5, 4),
        ({"pillars": [{"fx": 1, "fy": 2, "fz": 3}], "tus": 1500}, 0.0015, None),
        ({"hand": 0, "sequence": 9, "pressure": [0] * 768, "device_timestamp_ms": 2500}, 2.5, 9),
        ({"hand": 0, "sequence": 9, "pressure": [0] * 768, "device_timestamp": 500}, 0.5, 9),
        ({"forces": [1, 2, 3], "displacements": [], "sendtimestamp": 7.25, "index": 6}, 7.25, 6),
        ({"values": [1], "time_s": 3.5}, 3.5, None),
        ({"left": [[1]], "time_s": 4.5}, 4.5, None),
        ({"values": [1], "time_s": math.nan}, None, None),
        ({"values": [1], "time_s": 2.0**63}, None, None),
        ({"values": [1], "time_s": True}, 1.0, None),
    ],
)
def test_a_sensor_s_own_clock_and_number_go_before(message: dict[str, Any], time_s: float, number: int | None) -> None:
    reading = read_message(message)
    assert reading.sequence == number
    assert reading.time_s == (None if time_s is None else pytest.approx(time_s))


def test_what_is_known_of_sensors_is_said() -> None:
    def sensor(message: dict[str, Any], name: str = "pad") -> tuple[str, str, str]:
        pad = read_message(message).pads[name]
        return pad.sensor, pad.unit, pad.polarity

    taxel = {"x": 1, "y": 2, "z": 3}
    assert sensor({"taxels": [taxel], "model": "uSPa46"}) == ("xela-uspa46", "raw", "up")
    assert sensor({"taxels": [taxel], "model": "uSPa45"}) == ("", "raw", "up")
    assert sensor({"forces": [taxel], "taxels": [], "model": "uSPa44"}) == ("", "N", "up")
    assert sensor({"hand": 0, "sequence": 0, "pressure": [0] * 768}) == ("wuji", "raw", "down")
    assert sensor({"hand": 0, "sequence": 0, "pressure": [0.5] * 768}) == ("wuji-float", "raw", "up")
    assert sensor({"forces": [1, 2, 3], "displacements": [1, 2, 3]}) == ("tac3d", "N", "up")
    assert sensor({"cells_x": 1, "cells_y": 1, "pressure": [1]}) == ("", "Pa", "up")
    assert sensor({"cells_x": 1, "cells_y": 1, "tactile_array": [1]}) == ("", "raw", "up")
    assert sensor({"pressure_values": [*range(9)]}) == ("robotis-tactile", "raw", "up")
    for n, shape, name in ((9, (3, 3), "tip"), (96, (12, 8), "nail"), (80, (10, 8), "pad"), (112, (8, 14), "palm")):
        pad = read_message({"x_touch": [0] * n}).pads["x"]
        assert (pad.values.shape, pad.sensor) == (shape, f"inspire-{name}")
    asked = read_message({"forces": [1, 2, 3], "displacements": [4, 5, 6]}, field="Displacements")
    assert asked.pads["pad"].values.tolist() == [4, 5, 6]
    biotac = read_message({"electrodes": [5], "pdc": 1, "pac0": 2, "pac1": 3, "tac": 4, "tdc": 5}).pads["pad"]
    assert (biotac.names, biotac.values.tolist()) == (("e1", "pdc", "pac0", "pac1", "tac", "tdc"), [5, 1, 2, 3, 4, 5])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"point_step": 0}, "a cloud of 1 x 4 points of 0 bytes, 32 a row, came"),
        ({"row_step": 31}, "a cloud of 1 x 4 points of 8 bytes, 31 a row, came"),
        ({"width": 5, "row_step": 40}, "a cloud of 1 x 5 points of 8 bytes came with 32 bytes"),
        ({"height": -1}, "a cloud of -1 x 4 points of 8 bytes, 32 a row, came"),
        ({"width": 1 << 24, "row_step": 1 << 27}, "a cloud of 1 x 16777216 points of 8 bytes came with 32 bytes"),
        ({"width": (1 << 24) + 1, "row_step": 1 << 28}, "a cloud of 1 x 16777217 points of 8 bytes, 268435456 a row, came"),
        ({"fields": [{"name": "pressure", "offset": 5, "datatype": 7}]}, "a cloud's field 'pressure' begins at byte 5 of a point of 8"),
        ({"fields": [{"name": "pressure", "offset": -1, "datatype": 7}]}, "a cloud's field 'pressure' begins at byte -1 of a point of 8"),
        ({"fields": [{"name": "x", "offset": 0, "datatype": 7}, {"name": "pressure", "offset": 4, "datatype": 9}]}, "a cloud of points with the fields x came, and none of pressure, force, normal_force, force_z, fz, intensity, intensities; name the one that is pressure as field"),
    ],
)  # fmt: skip
def test_what_a_cloud_of_points_cannot_be_is_told(change: dict[str, Any], told: str) -> None:
    points = np.zeros(4, [("x", "<f4"), ("pressure", "<f4")])
    said(lambda: read_message(cloud(points, 1) | change), told)


def test_places_of_points_are_kept_where_all_are_numbers() -> None:
    points = np.zeros(3, [("x", "<f4"), ("y", "<f4"), ("pressure", "<f4")])
    points["x"], points["y"], points["pressure"] = [1, 2, 3], [4, 5, 6], [7, 8, 9]
    pad = read_message(cloud(points, 1)).pads["pad"]
    assert pad.positions_m is not None
    assert pad.positions_m.tolist() == [[1, 4], [2, 5], [3, 6]]
    points["y"][1] = np.nan
    assert read_message(cloud(points, 1)).pads["pad"].positions_m is None
    del points
    bare = np.zeros(3, [("y", "<f4"), ("pressure", "<f4")])
    assert read_message(cloud(bare, 1)).pads["pad"].positions_m is None


def test_definitions_have_so_many_letters_and_messages() -> None:
    tail = "\n# " + "x" * ((1 << 18) - len("float32 a") - 3)
    message_decoder("cdr", "a/msg/B", "float32 a" + tail, "ros2msg")
    said(
        lambda: message_decoder("cdr", "a/msg/B", "float32 a" + tail + "x", "ros2msg"),
        f"the definition of a/msg/B has {(1 << 18) + 1} letters; {1 << 18} are the most",
    )
    line = "=" * 80
    for many, fits in ((1024, True), (1025, False)):
        text = f"a/C[{many}] c\nfloat32[{many}] f\n{line}\nMSG: a/C\nfloat32 x\n"
        if fits:
            message_decoder("cdr", "a/msg/B", text, "ros2msg")
        else:
            said(
                lambda: message_decoder("cdr", "a/msg/B", text, "ros2msg"),  # noqa: B023
                "the definition of a/msg/B holds more than 1024 messages of fixed number",
            )
    said(
        lambda: message_decoder("cdr", "a/msg/B", "a/C c\n", "ros2msg"),
        "the definition of a/msg/B lacks that of a/msg/C",
    )
    said(
        lambda: message_decoder("cdr", "a/msg/B", f"a/C c\n{line}\nMSG: a/C\na/B b\n", "ros2msg"),
        "the definition of a/msg/B holds a/msg/B within itself",
    )
    said(lambda: message_decoder("xml"), "messages encoded as 'xml' cannot be read; cdr, ros1, json can")


# Presses and marks


TYPES = {"label": "<U3", "n": "<i2", "f": "<f8", "on": "|b1"}


@settings(max_examples=60)
@given(st.lists(st.integers(-1, 4), min_size=1, max_size=9), st.integers(0, 3))
def test_presses_as_notes_say_which_each_frame_is(drawn: list[int], more: int) -> None:
    numbers = np.array(drawn)
    rows = int(numbers.max()) + 1 + more
    columns: dict[str, Any] = {"n": np.arange(rows) * 3, "label": np.array([f"p{k}" for k in range(rows)], "U3")}
    told = list(press_notes(numbers, columns))
    begun = [each["press"] for each in told if each["frame"] is not None]
    assert begun == [n for k, n in enumerate(drawn) if n != (drawn[k - 1] if k else -1)]
    # Columns are told in order, each once.
    assert [each["press"] for each in told if "columns" in each] == [*range(rows)]
    held = Gathered(
        {}, tuple(Note(PRESSES, 0, each) for each in told), {COLUMNS: {"n": "<i8", "label": "<U3"}}, {}, {}, ""
    )
    press, known = presses_of(held, len(numbers), where="here")
    assert press is not None
    assert press.tolist() == drawn
    assert known["n"].tolist() == columns["n"].tolist()
    assert known["label"].tolist() == columns["label"].tolist()
    assert presses_of(Gathered({}, (), {}, {}, {}, ""), 3, where="") == (None, {})


@pytest.mark.parametrize(
    "told",
    [
        {"frame": "0", "press": 1},
        {"frame": 0, "press": None},
        {"frame": 0, "press": -2},
        {"frame": 0, "press": 1 << 63},
        {"frame": 0, "press": 1, "columns": []},
        {"frame": 0, "press": 1, "columns": {"n": 1}},
    ],
)
def test_notes_of_presses_that_cannot_be_meant_are_told(told: dict[str, Any]) -> None:
    held = Gathered({}, (Note(PRESSES, 0, told),), {COLUMNS: {}}, {}, {}, "")
    refused(
        lambda: presses_of(held, 3, where="here"),
        f"here: topic {PRESSES}: must tell frame, press and columns, got {str(told)[:80]}",
    )


@pytest.mark.parametrize(
    "told",
    [{"frame": 0, "press": 0, "columns": {"n": 1}}, {"frame": 9, "press": (1 << 63) - 1}, {"frame": -5, "press": -1}],
)
def test_notes_of_presses_at_the_edge_are_taken(told: dict[str, Any]) -> None:
    held = Gathered({}, (Note(PRESSES, 0, told),), {COLUMNS: {"n": "<i8"}}, {}, {}, "")
    press, _ = presses_of(held, 3, where="here")
    assert press is not None
    assert press.tolist() == ([0] * 3 if told["frame"] == 0 else [-1] * 3)


def test_a_column_is_of_the_type_that_is_told() -> None:
    cells = {0: "ab", 2: "c"}
    assert typed_column("p", "x", cells, "<U2").tolist() == ["ab", "", "c"]
    assert typed_column("p", "x", cells, "<U2").dtype == np.dtype("<U2")
    # A type of so many signs that a few cells would fill the memory is that of its longest.
    assert typed_column("p", "x", {0: "ab"}, f"<U{1 << 24}").dtype.itemsize == 4 << 24
    assert typed_column("p", "x", {0: "ab", 1: "c"}, f"<U{1 << 24}").dtype == np.dtype("<U2")
    assert typed_column("p", "x", {1: 5}, "|b1").tolist() == [False, True]
    assert typed_column("p", "x", {1: 5}, ">i2").tolist() == [0, 5]
    np.testing.assert_array_equal(typed_column("p", "x", {1: 5}, "f4"), np.array([np.nan, 5], np.float32))
    assert len(typed_column("p", "x", {}, "<u8")) == 0
    refused(lambda: typed_column("p", "x", {}, "object"), "p: x must be of text or numbers, got 'object'")
    refused(lambda: typed_column("p", "x", {0: "a"}, "<i2"), "p: x must be <i2: invalid literal for int()")
    refused(lambda: typed_column("p", "x", {0: 1 << 15}, "<i2"), "p: x must be <i2: ")


def notes(*marks: dict[str, Any]) -> Gathered:
    return Gathered({}, tuple(Note(MARKS, 10 * k, told) for k, told in enumerate(marks)), {}, {}, {}, "")


def test_marks_are_at_the_first_frame_after_them() -> None:
    times = np.array([0, 10, 20, 15, 30])
    held = notes({"label": "a"}, {"label": "b"}, {"label": 5}, {"label": "c"}, {"label": "late"})
    assert marks_of(held, times) == (Mark(0, "a"), Mark(1, "b"), Mark(4, "c"))
    held = notes({"label": "a", "frame": 3}, {"label": "b", "frame": 1}, {"label": "c", "frame": 5}, {"frame": 1})
    assert marks_of(held, times) == (Mark(3, "a"), Mark(3, "b"))
    other = Gathered({}, (Note(ZEROS, 0, {"label": "no mark"}),), {}, {}, {}, "")
    assert marks_of(other, times) == ()
    said(lambda: checked_marks([(5, "x")], 5), "marks must be at frames 0 to 4, rising, got 5 for 'x'")
    said(lambda: checked_marks([(2, "x"), (1, "y")], 5), "marks must be at frames 0 to 4, rising, got 1 for 'y'")
    assert checked_marks([(0, "x"), (0, "y"), (4, "z")], 5) == (Mark(0, "x"), Mark(0, "y"), Mark(4, "z"))


def test_presses_that_were_found_are_labelled_by_the_newest_mark() -> None:
    force = np.array([0, 0, 5, 9, 5, 0, 0, 0, 7, 8, 0, 0])
    pad = Pad(np.tile(force[:, None, None], (1, 4, 4)))
    assert press_table(Recording({"pad": pad})).columns == {}
    for at, labels in ((0, ["m", "m"]), (2, ["m", "m"]), (3, ["", "m"]), (8, ["", "m"]), (9, ["", ""])):
        found = press_table(Recording({"pad": pad}, marks=(Mark(at, "m"),)))
        assert found.columns["label"].tolist() == labels
        assert found.frames == (range(2, 5), range(8, 10))
        assert found.spans == (range(5), range(5, 10))


# MCAP and what else topics say


def test_said_of_topics() -> None:
    passed = {f"/{k}": "t" for k in range(8)}
    eight = ", ".join(f"/{k} (t)" for k in range(8))
    assert list(said_of(Gathered({}, (), {}, {}, {}, ""))) == []
    assert list(said_of(Gathered({}, (), {}, {}, passed, "early"))) == ["early", f"passed over: {eight}"]
    assert list(said_of(Gathered({}, (), {}, {}, passed | {"/8": "t"}, ""))) == [f"passed over: {eight}, ..."]


def test_taxels_that_are_no_numbers_are_left_out_of_those_that_count() -> None:
    finite = np.array([[True, False], [False, True]])
    valid, remarks = left_out(PadFacts("p"), finite)
    assert valid is not None
    assert valid.tolist() == finite.tolist()
    assert remarks == ("pad p: 2 taxels are left out, whose readings are no numbers",)
    mask = np.array([[True, False], [True, True]])
    valid, remarks = left_out(PadFacts("p", valid=mask), finite)
    assert valid is not None
    assert valid.tolist() == [[True, False], [False, True]]
    assert remarks == ("pad p: 1 taxel is left out, whose readings are no numbers",)
    assert left_out(PadFacts("p", field=finite), finite) == (None, ())
    assert left_out(PadFacts("p", valid=np.ones((1, 3), bool)), np.ones((2, 2), bool))[1] == ()


def test_exact_times_are_as_many_as_readings(tmp_path: Path) -> None:
    held = Gathered({}, (), {}, {"time_s.float64": np.arange(3.0).tobytes() + b"more"}, {}, "")
    exact = exact_times(held, 3)
    assert exact is not None
    assert exact.tolist() == [0, 1, 2]
    assert exact_times(held, 4) is None
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        writer.attach("time_s.float64", b"hello")
        writer.reading({"x": np.ones((1, 1))}, log_ns=10**9, timed=False)
        writer.finish()
    assert read(path).time_s is None
    assert exact_times(Gathered({}, (), {}, {}, {}, ""), 3) is None


@pytest.mark.parametrize("kind", ["recording", "measurement"])
def test_what_a_recorder_wrote_is_known_by_its_head(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file, kind)
        writer.reading({"pad": np.ones((2, 2))}, log_ns=5)
        writer.finish()
    assert is_measured(path) is (kind == "measurement")
    path.write_bytes(b"x" + path.read_bytes())
    assert not is_measured(path)


def measured(path: Path, **how: Any) -> Path:
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(3):
            writer.reading(
                {"pad": FRAMES[k]}, log_ns=10**9 + k * 10**6, **{key: k * value for key, value in how.items()}
            )
        writer.finish()
    return path


def test_what_no_recording_holds_is_told_before_it_is_lost(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    assert beyond_recording(measured(path)) == ()
    assert beyond_recording(measured(path, sequence=1)) == ("the sensor's numbers of readings",)
    assert beyond_recording(measured(path, device_ns=5)) == ("the time of the machine that recorded",)
    with path.open("wb") as file:
        writer = TopicWriter(file)
        writer.reading({"pad": FRAMES[0]}, log_ns=7, device_ns=7)
        writer.tell(MARKS, {"label": "a", "frame": 0}, log_ns=5)
        writer.attach("time_s.float64", b"")
        writer.finish()
    assert beyond_recording(path) == ()
    with path.open("wb") as file:
        writer = TopicWriter(file)
        writer.reading({"pad": FRAMES[0]}, log_ns=7)
        for told in ({"label": "a", "by": "me"}, {"label": "b", "by": "me"}):
            writer.tell(MARKS, told, log_ns=5)
        writer.tell(ZEROS, {}, log_ns=5)
        writer.attach("sensor.toml", b"")
        writer.finish()
    assert beyond_recording(path) == (f"topic {MARKS}", f"topic {ZEROS}", "attachment sensor.toml")
    write(Recording({"pad": Pad(FRAMES)}), tmp_path / "a.npz")
    assert beyond_recording(tmp_path / "a.npz") == ()


def whole(**more: Any) -> Recording:
    told: dict[str, Any] = {
        "pads": {"a": Pad(FRAMES), "b": Pad(FRAMES + 1)},
        "time_s": np.arange(5.0),
        "press": np.array([-1, 0, 0, 1, 1]),
        "press_columns": {"label": np.array(["x", "y"])},
        "signals": {"s": Signals(np.arange(5.0)[:, None], ("n",), "N")},
        "marks": (Mark(1, "m"),),
    }
    return Recording(**told | more)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({}, ()),
        ({"time_s": None}, ("time",)),
        ({"time_s": np.arange(5.0) + 1}, ("time",)),
        ({"press": None, "press_columns": {}}, ("press of each frame", "press.label")),
        ({"press_columns": {"label": np.array(["x", "z"])}}, ("press.label",)),
        ({"signals": {}}, ("signals s",)),
        ({"signals": {"s": Signals(np.arange(5.0)[:, None], ("o",), "N")}}, ("signals s",)),
        ({"signals": {"s": Signals(np.arange(5.0)[:, None], ("n",), "V")}}, ("signals s",)),
        ({"signals": {"s": Signals(np.arange(5)[:, None], ("n",), "N")}}, ("signals s",)),
        ({"marks": ()}, ("marks",)),
        ({"unit": "kPa"}, ("unit",)),
        ({"sensor": "S"}, ("sensor",)),
        ({"pads": {"a": Pad(FRAMES)}}, ("pad b",)),
        ({"pads": {"a": Pad(FRAMES), "b": Pad(FRAMES)}}, ("values of pad b",)),
        ({"pads": {"a": Pad(FRAMES), "b": Pad((FRAMES + 1).astype(float))}}, ("type uint16 of the values of pad b",)),
        ({"pads": {"a": Pad(FRAMES), "b": Pad(FRAMES[:, :2] + 1)}}, ("values of pad b",)),
        ({"pads": {"a": Pad(FRAMES, pitch_m=0.1), "b": Pad(FRAMES + 1)}}, ("pitch of pad a",)),
        ({"pads": {"a": Pad(FRAMES, valid=np.ones((3, 4), bool)), "b": Pad(FRAMES + 1)}}, ("mask of broken taxels of pad a",)),
    ],
)  # fmt: skip
def test_what_is_lost_of_a_recording_is_told(more: dict[str, Any], told: tuple[str, ...]) -> None:
    assert losses(whole(), whole(**more)) == told


def test_what_is_lost_of_a_single_pad_is_told(tmp_path: Path) -> None:
    assert losses(Recording({"a": Pad(FRAMES)}), Recording({"b": Pad(FRAMES + 1)})) == ("the pad's name a", "values")
    with pytest.raises(InputError, match=r"no/a\.npz: cannot be written: no such file or directory"):
        convert(whole(), tmp_path / "no/a.npz")
    (tmp_path / "a.npz").mkdir()
    with pytest.raises(InputError, match=r"a\.npz: cannot be written: is a directory"):
        convert(whole(), tmp_path / "a.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


def test_streams_and_whole_files_are_refused_in_the_same_words(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"

    def taken() -> list[str]:
        told = []
        for act in (lambda: read(path), lambda: list(open_recording(path).blocks(2))):
            with pytest.raises(FormatError) as error:
                act()
            told.append(str(error.value))
        return told

    def writing(*readings: dict[str, Any], **facts: Any) -> None:
        with path.open("wb") as file:
            writer = TopicWriter(file)
            writer.describe(PadFacts("x", **facts))
            for k, each in enumerate(readings):
                writer.reading(each, log_ns=10**9 * k)
                writer.flush()
            writer.finish()

    x = np.ones((2, 2))
    writing({"x": x}, kind="pressure", field=np.ones((3, 3), bool))
    assert len({each.split(": pad 'x'")[0] for each in taken()}) == 1
    writing({"x": np.ones(3)}, kind="signals")
    assert (
        taken()
        == [f"{path}: holds signals only (x), and what touches is felt by pressure; varishold replay plays it"] * 2
    )
    writing({"x": x})
    told = f"{path}: has frames of 2 x 2, not 3 x 3; leave the shape out"
    for act in (lambda: read(path, shape=(3, 3)), lambda: open_recording(path, shape=(3, 3))):
        said(act, told)
    writing()
    assert taken() == [f"{path}: holds no message"] * 2


def test_rows_of_taxels_take_their_shape_from_streams_too(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(3):
            writer.reading({"x": np.where(np.arange(6) == 5, np.nan, np.arange(6.0) + k)}, log_ns=k)
        writer.finish()
    one = read(path, shape=(2, 3))
    with open_recording(path, shape=(2, 3)) as opened:
        two = opened.whole
    for recording in (one, two):
        assert recording.pads["x"].frames.shape == (3, 2, 3)
        assert recording.pads["x"].usable.tolist() == [[True] * 3, [True, True, False]]
        assert recording.pads["x"].frames[1, 1, 0] == 4


@pytest.mark.parametrize("kept", [1, 1 << 25])
def test_files_that_follow_one_another_are_one_stream(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kept: int
) -> None:
    """Blocks may begin and end in any of them."""
    from tests.test_recording_rosbags import FRAMES as MANY
    from tests.test_recording_rosbags import bag2

    monkeypatch.setattr(stream, "_KEPT", kept)
    folder = bag2(tmp_path / "bag")
    (first,) = folder.glob("*.db3")
    for number in (1, 2):
        (folder / f"bag_{number}.db3").write_bytes(first.read_bytes())
    expected = np.concatenate([MANY] * 3)
    with open_recording(folder) as opened:
        for a, b in ((0, 120), (35, 85), (39, 41), (79, 120), (0, 1), (119, 120), (40, 80), (80, 81)):
            np.testing.assert_array_equal(opened.frames[a:b].pads["skin"].frames, expected[a:b])


def test_a_recorder_lets_go_after_a_megabyte(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = TopicWriter(file)
        head = None
        for k in range(12):
            writer.reading({"x": np.zeros((256, 512), np.uint8)}, log_ns=k)
            head = file.tell() if head is None else head
            # Messages of 128 KiB, and some bytes of each for its head.
            assert (file.tell() > head) == (k >= 7), k
        writer.finish()


# Moments


def test_moments_are_parted_where_anything_differs(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    x, y = np.ones((1, 2)), np.zeros((1, 2))
    with path.open("wb") as file:
        writer = TopicWriter(file)
        writer.reading({"x": x, "y": y}, log_ns=10**9, device_ns=5 * 10**9, sequence=1)
        writer.reading({"x": x}, log_ns=10**9, device_ns=5 * 10**9, sequence=2)
        writer.reading({"y": y}, log_ns=10**9, device_ns=6 * 10**9, sequence=2)
        writer.reading({"x": x}, log_ns=2 * 10**9, device_ns=6 * 10**9, sequence=2)
        writer.reading({"x": x}, log_ns=2 * 10**9, device_ns=6 * 10**9, sequence=2)
        writer.tell(MARKS, {"label": "a"}, log_ns=5)
        writer.flush()
        writer.tell(MARKS, {"label": "b"}, log_ns=5)
        writer.finish()
    with Moments(path) as moments:
        found = [(each.device_time_s, each.host_time_s, each.sequence, list(each.pads)) for each in moments]
        assert list(moments.facts) == ["x", "y"]
    assert found == [
        (5.0, 1.0, 1, ["x", "y"]),
        (5.0, 1.0, 2, ["x"]),
        (6.0, 1.0, 2, ["y"]),
        (6.0, 2.0, 2, ["x"]),
        (6.0, 2.0, 2, ["x"]),
    ]
    path.write_bytes(path.read_bytes()[:9] + b"\0" * 40)
    with Moments(path) as moments:
        assert list(moments) == []


# Stored recordings and named arrays


class Arrays:
    """Arrays in memory, by their names."""

    def __init__(self, **held: Any) -> None:
        self.held = {name.replace("__", "."): np.asarray(value) for name, value in held.items()}
        self.unread: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.held)

    def array(self, name: str) -> Any:
        return self.held[name]

    column = array

    def text(self, name: str) -> str:
        return str(self.held[name])


@pytest.mark.parametrize(
    ("held", "told"),
    [
        ({"pressure": FRAMES, "pressure__a": FRAMES}, "f: holds both 'pressure' and 'pressure.a'; name every pad"),
        ({f"x{k}": [1] for k in range(13)}, f"f: must hold an array 'pressure' or 'pressure.NAME', holds {', '.join(f'x{k}' for k in range(12))}"),
        ({}, "f: must hold an array 'pressure' or 'pressure.NAME', holds nothing"),
        ({"pressure": FRAMES, "polarity": "left"}, "f: pressure: polarity must be up or down, got 'left'"),
        ({"pressure": FRAMES, "mark__frame": [1], "mark__label": ["a", "b"]}, "f: mark.frame and mark.label must be a frame and a label each, got (1,) and (2,)"),
        ({"pressure": FRAMES, "mark__frame": [[1]], "mark__label": [["a"]]}, "f: mark.frame and mark.label must be a frame and a label each, got (1, 1) and (1, 1)"),
        ({"pressure": FRAMES[:, 0]}, "f: pressure must have shape (n, rows, cols), got (5, 4); say the shape of a frame if each row is one, or store one frame as (1, rows, cols)"),
        ({"pressure": np.arange(4)}, "f: pressure: must be numbers of shape (n_frames, rows, cols), got shape (4,)"),
        ({"pressure": FRAMES, "pitch_m": 0}, "f: pressure: pitch_m must be"),
    ],
)  # fmt: skip
def test_named_arrays_that_are_no_recording_are_told(held: dict[str, Any], told: str) -> None:
    with pytest.raises(FormatError) as error:
        stored_in(Arrays(**held), Path("f"), Options())
    assert str(error.value).startswith(told)
    assert str(error.value) == told or told.endswith("must be")


def test_named_arrays_are_a_recording() -> None:
    held = Arrays(
        pressure__a=FRAMES,
        pressure__b=FRAMES.reshape(5, 12),
        polarity__b="down",
        polarity="up",
        pitch_m=0.1,
        pitch_m__b=0.2,
        mark__frame=[1, 2],
        mark__label=["x", "y"],
    )
    recording = stored_in(held, Path("f"), Options(shape=(3, 4))).whole()
    assert {name: (pad.pitch_m, pad.polarity, pad.shape) for name, pad in recording.pads.items()} == {
        "a": ((0.1, 0.1), "up", (3, 4)),
        "b": ((0.2, 0.2), "down", (3, 4)),
    }
    assert recording.marks == (Mark(1, "x"), Mark(2, "y"))
    recording = stored_in(held, Path("f"), Options((3, 4), (0.5, 0.6), "down")).whole()
    assert {(pad.pitch_m, pad.polarity) for pad in recording.pads.values()} == {((0.5, 0.6), "down")}
    for many, told in ((12, ""), (13, ", ...")):
        held.unread = ("pitch_m", *(f"x{k}" for k in range(many)))
        note = f"passed over, for it is no part of a recording: {', '.join(f'x{k}' for k in range(12))}{told}"
        assert stored_in(held, Path("f"), Options((3, 4)), notes=("n",)).notes == ("n", note)


def test_frames_of_others_are_guessed_by_shape_and_name() -> None:
    def told(shape: tuple[int, int] | None = None, **columns: Any) -> Any:
        return guessed(
            Path("f"), {name.replace("__", "/"): np.zeros(each) for name, each in columns.items()}, Options(shape)
        )

    assert told(a=(5, 3, 4), b=(5, 3)) == ({"pressure": "a"}, ("taken for frames, by shape and name: a",))
    assert told(a=(5, 3, 4), g__Time=(5,))[0] == {"pressure": "a", "time_s": "g/Time"}
    assert told(a=(5, 3, 4), timestamp=(5,), time=(5,))[1][1] == "taken for times in seconds: time"
    assert told(a=(5, 3, 4), time=(6,)) == ({"pressure": "a"}, ("taken for frames, by shape and name: a",))
    assert told(tactile_a=(5, 3, 4), skin=(4, 3, 4), image=(9, 9, 9)) == (
        {"pressure": "tactile_a"},
        (
            "taken for frames, by shape and name: tactile_a",
            "left out, for they have not 5 frames: skin (4, 3, 4); make a recording of each",
        ),
    )
    many = {f"skin_{k:02d}": (4, 3, 4) for k in range(13)}
    assert told(skin=(5, 3, 4), **many)[1][1].endswith("skin_11 (4, 3, 4), ...; make a recording of each")
    # Frames of which time is the last axis, as the shape says, have as many times as that is long.
    assert told((5, 3), a=(5, 3, 4), b=(4, 9), time=(4,))[0] == {"pressure": "a", "time_s": "time"}
    assert told((3, 4), a=(5, 3, 4), time=(4,))[0] == {"pressure": "a"}
    assert told(a=(4, 3, 4), time=(4,))[0] == {"pressure": "a", "time_s": "time"}
    assert told(a=(5, 3, 4), time=(4,), timestamp=(5,))[0] == {"pressure": "a", "time_s": "timestamp"}
    said(
        lambda: told(a=(5, 3, 4), g__t=(4,)),
        "f: g/t has 4 times, as many as the last axis of a (5, 3, 4): say the shape of a frame, 5x3 if time is the "
        "last axis, 3x4 if it is the first",
    )
    for name, shape in (("time_ms", (5,)), ("timestamp_ns", (5,)), ("Time", (5, 1)), ("times", (1, 5))):
        assert told(skin=(5, 3, 4), **{name: shape})[1][1] == (
            f"no time is read: {name} {shape} is no vector of seconds that is called time_s or time"
        )
    for name, shape in (("time_ms", (6,)), ("s", (5, 1)), ("ms", (5,)), ("t", (5, 2)), ("tilt", (5,))):
        assert len(told(skin=(5, 3, 4), **{name: shape})[1]) == 1
    said(
        lambda: told((3, 4), a=(5, 13), b=(5, 3)),
        "f: holds no array of frames (n, 3, 4) or (n, 12), it holds a (5, 13), b (5, 3)",
    )
    assert list(told(tactile_a=(5, 3, 4), skin=(5, 3, 4))[0]) == ["pressure.tactile_a", "pressure.skin"]
    assert told((3, 4), a=(5, 12), b=(5, 13))[0] == {"pressure": "a"}
    held = "a (5, 3, 4), b (5, 3, 4)"
    said(
        lambda: told(a=(5, 3, 4), b=(5, 3, 4)),
        f"f: holds {held}, and nobody says which are frames; call them pressure",
    )
    for columns, words in (({"a": (5, 3), "b": (0, 3, 4)}, "a (5, 3), b (0, 3, 4)"), ({}, "no numbers")):
        said(
            lambda: told(**columns),  # noqa: B023
            f"f: holds no array of frames (n, rows, cols), it holds {words}; say the shape of a frame if each row is one",
        )
    many = {f"x{k}": (5,) for k in range(13)}
    with pytest.raises(FormatError) as error:
        told(**many)
    assert "x11 (5,); say" in str(error.value)


def test_parts_of_a_stored_recording_say_whose_fault_it_is() -> None:
    wrong = np.full((2, 2, 2), -5.0)
    for called, source, told in (
        ("", "", "pressure is mostly negative"),
        ("frames", "", "frames: pressure is mostly negative"),
        ("", "f", "f: pressure is mostly negative"),
        ("frames", "f", "f: frames: pressure is mostly negative"),
    ):
        with pytest.raises(InputError) as error:
            Stored({"pad": StoredPad(wrong, called)}, source=source).part(0, 2)
        assert str(error.value).startswith(told)
        assert isinstance(error.value, FormatError) == bool(source)
    assert Stored({"pad": StoredPad(FRAMES)}).n_bytes == 0


def test_marks_of_a_part_are_counted_from_its_first_frame() -> None:
    stored = Stored({"pad": StoredPad(FRAMES)}, marks=(Mark(0, "a"), Mark(1, "b"), Mark(3, "c")))
    assert stored.part(0, 5).marks == stored.marks
    assert stored.part(1, 5).marks == (Mark(0, "b"), Mark(2, "c"))
    assert stored.part(2, 3).marks == (Mark(0, "b"),)
    assert stored.part(2, 4).marks == (Mark(0, "b"), Mark(1, "c"))
    assert stored.part(0, 1).marks == (Mark(0, "a"),)


def test_frames_are_numbered_from_0() -> None:
    pad = Pad(FRAMES)
    assert frame_of(pad, 0).tolist() == FRAMES[0].tolist()
    assert frame_of(pad, 4).dtype == np.float64
    for wrong in (-1, 5):
        said(lambda: frame_of(pad, wrong), f"there is no frame {wrong}: frames are numbered 0 to 4")  # noqa: B023


# LeRobot's plan


@pytest.mark.parametrize(
    ("times", "fps"),
    [(None, 30), ([0.5], 30), ([0.0, 0.02], 50), ([0.0, 0.0, 0.0], 30), ([0.0, 0.1, 0.3, 0.4], 10), ([0.0, 1e-9], 1_000_000), ([0.0, 9.0], 1), ([3.0, 2.0, 1.0], 30)],
)  # fmt: skip
def test_the_rate_of_a_data_set_is_that_of_the_usual_interval(times: list[float] | None, fps: int) -> None:
    n = len(times or [0])
    assert (
        plan_of(Recording({"pad": Pad(np.ones((n, 1, 1)))}, None if times is None else np.array(times)), 1).fps == fps
    )


# Text


def test_room_for_rows_grows_and_keeps_what_stands_in_it() -> None:
    rows = Rows(Path("f"), Separator(","))
    made = np.arange(600 * 3).reshape(600, 3)
    at = 0
    for many in (1, 63, 1, 200, 300, 35):
        lines = [",".join(map(str, row)) for row in made[at : at + many]]
        rows.add(lines, [*range(at + 1, at + many + 1)])
        at += many
        np.testing.assert_array_equal(rows._values[: rows.n], made[:at])
    assert (rows.n, rows.width) == (600, 3)
    np.testing.assert_array_equal(rows.values(), made)
    assert rows.values().dtype == np.int32
    rows.add([], [])
    assert rows.n == 600


TEKSCAN = """DATA_TYPE MOVIE
ROWS 2
COLS 2
{header}ASCII_DATA @@
Frame 3
1,2
3,4

Frame 5
5,6
7,8
@@
"""


@pytest.mark.parametrize(
    ("said_of_it", "pitch"),
    [
        ("ROW_SPACING 2 mm\nCOL_SPACING 3\n", (2e-3, 3e-3)),
        ("ROW_SPACING 0.5 cm\nCOL_SPACING 0.001 m\n", (5e-3, 1e-3)),
        ("ROW_SPACING 0,1 inch\nCOL_SPACING 1 inches\n", (2.54e-3, 25.4e-3)),
        ("ROW_SPACING 1 in\nCOL_SPACING 4 Millimeters\n", (25.4e-3, 4e-3)),
        ("ROW_SPACING 1 in\n", None),
    ],
)
def test_lengths_of_tekscan_are_in_the_unit_that_is_said(
    tmp_path: Path, said_of_it: str, pitch: tuple[float, float] | None
) -> None:
    path = tmp_path / "a.asf"
    path.write_text(TEKSCAN.format(header=said_of_it + "SECONDS_PER_FRAME 0,5\nUNITS RAW\nSENSOR_TYPE 5051\n"))
    recording = read(path)
    found = recording.pads["pad"].pitch_m
    assert found == (None if pitch is None else pytest.approx(pitch))
    assert recording.pads["pad"].frames.tolist() == [[[1, 2], [3, 4]], [[5, 6], [7, 8]]]
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [0, 1]
    assert (recording.unit, recording.sensor, recording.notes) == ("raw", "5051", ())


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("ROWS 2", "ROWS 0"), "ROWS must be a whole number from 1 to 10000, got '0'"),
        (("ROWS 2", "ROWS 10001"), "ROWS must be a whole number from 1 to 10000, got '10001'"),
        (("ROWS 2", "ROWS 10000"), "frame 3 (line 5) has 2 rows, ROWS says 10000"),
        (("COLS 2", "COLS 3"), "rows hold 2 cells, COLS says 3"),
        (("COLS 2", "COLS x"), "COLS must be a whole number from 1 to 10000, got 'x'"),
        (("COLS 2", "COLS 1\nROW_SPACING 0 mm\nCOL_SPACING 1"), "rows hold 2 cells, COLS says 1"),
        (("COLS 2", "COLS 2\nROW_SPACING 0 mm\nCOL_SPACING 1"), "ROW_SPACING must be a positive length in mm, cm, m or inch, got '0 mm'"),
        (("COLS 2", "COLS 2\nROW_SPACING 1 foot\nCOL_SPACING 1"), "ROW_SPACING must be a positive length in mm, cm, m or inch, got '1 foot'"),
        (("COLS 2", "COLS 2\nSECONDS_PER_FRAME 0"), "SECONDS_PER_FRAME must be a positive number, got '0'"),
        (("ASCII_DATA @@\n", ""), "is cut off: there is no line ASCII_DATA"),
        (("Frame 3\n", ""), "line 5 must be 'Frame n', got '1,2'"),
        (("5,6", "5,B"), "frame 5 (line 9) differs from the first in where B stands, at (row, col) = (0, 1); a sensel is there in all frames or in none"),
        (("7,8\n", ""), "frame 5 (line 9) has 1 row, ROWS says 2"),
    ],
)  # fmt: skip
def test_what_tekscan_cannot_say_is_told(tmp_path: Path, change: tuple[str, str], told: str) -> None:
    path = tmp_path / "a.asf"
    path.write_text(TEKSCAN.format(header="").replace(*change))
    said(lambda: read(path), f"{path}: {told}")


@pytest.mark.parametrize(("first", "last", "promised"), [(1, 2, None), (1, 3, 3), (2, 2, 1), (0, 1, None)])
def test_frames_that_tekscan_promises_are_counted(tmp_path: Path, first: int, last: int, promised: int | None) -> None:
    path = tmp_path / "a.asf"
    path.write_text(TEKSCAN.format(header=f"START_FRAME {first}\nEND_FRAME {last}\n"))
    note = f"2 frames are there, START_FRAME and END_FRAME promise {promised}"
    assert read(path).notes == (() if promised is None else (note,))


def test_a_header_of_tekscan_has_ten_thousand_lines(tmp_path: Path) -> None:
    path = tmp_path / "a.asf"
    head = "DATA_TYPE MOVIE\nROWS 2\nCOLS 2\n" + "COMMENT x\n" * 9997
    path.write_text(TEKSCAN.format(header="").replace("DATA_TYPE MOVIE\nROWS 2\nCOLS 2\n", head[: -len("COMMENT x\n")]))
    assert read(path).n_frames == 2
    path.write_text(TEKSCAN.format(header="").replace("DATA_TYPE MOVIE\nROWS 2\nCOLS 2\n", head + "COMMENT y\n"))
    said(lambda: read(path), f"{path}: no line ASCII_DATA in the first 10000 lines")


XSENSOR = """Frame:,1
Time:,10:00:01.5
Rows:,2
Columns:,2
Units:,kPa
Sensor:,X
1,2
3,4
Frame:,2
Time:,10:01:03.0
5,6
7,8
"""


@pytest.mark.parametrize("mark", [",", ";"])
@pytest.mark.parametrize("quoted", [False, True])
def test_xsensor_parts_its_cells_as_its_line_of_rows_does(tmp_path: Path, mark: str, quoted: bool) -> None:
    """With semicolons the decimal sign may be a comma."""
    path = tmp_path / "a.csv"
    text = XSENSOR.replace(",", mark).replace(f"1{mark}2\n", f"1.5{mark}2\n" if mark == "," else f"1,5{mark}2\n")
    # What other lines say is not asked.
    text = text.replace("Sensor:", "Note:,a;b\nSensor:" if mark == "," else "Note:\nSensor:").replace(
        f"Sensor:{mark}X", "Sensor:,X"
    )
    if quoted:
        text = text.replace("Units:", '"Units:"').replace(f"3{mark}4", f'"3"{mark}4{mark}{mark}')
    path.write_text(text.replace("Columns", "Cols") if quoted else text)
    recording = read(path)
    assert recording.pads["pad"].frames.tolist() == [[[1.5, 2], [3, 4]], [[5, 6], [7, 8]]]
    assert (recording.unit, recording.sensor) == ("kPa", "X")
    if quoted:
        path.write_text(text.replace('"3"', '"3'))
        with pytest.raises(FormatError, match=r"line 9: .*; a cell must close its quotes"):
            read(path)


def test_clocks_of_xsensor_are_seconds_of_a_day(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(XSENSOR)
    recording = read(path)
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [0, 61.5]
    assert (recording.unit, recording.sensor) == ("kPa", "X")
    path.write_text(XSENSOR.replace("10:01:03.0", "12:00:01,5"))
    recording = read(path)
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [0, 7200]
    path.write_text(XSENSOR.replace("10:00:01.5", "23:59:58.5").replace("10:01:03.0", "00:00:01.0"))
    over_midnight = read(path)
    assert over_midnight.time_s is not None
    assert over_midnight.time_s.tolist() == [0, 2.5]
    path.write_text(XSENSOR.replace("10:01:03.0", "noon").replace("Units:", "Pressure Units:"))
    recording = read(path)
    assert recording.time_s is None
    assert recording.notes == ("no time is read: that of frame 1 must be HH:MM:SS.FFF, got 'noon'",)
    path.write_text(XSENSOR.replace("Time:,10:00:01.5\n", ""))
    assert read(path).notes == ("no time is read: that of frame 0 must be HH:MM:SS.FFF, got 'nothing'",)
    path.write_text(XSENSOR.replace("Time:,10:00:01.5\n", "").replace("Time:,10:01:03.0\n", ""))
    assert read(path).notes == ()
    assert recording.unit == "kPa"
    for change, told in (
        (("Rows:,2", "Rows:,3"), "frame 0 (line 7) has 2 rows, Rows says 3"),
        (("Columns:,2", "Columns:,3"), "line 7 holds 2 numbers, Columns says 3"),
        (("Rows:,2", "Rows:,0"), "Rows must be a whole number from 1 to 10000, got '0'"),
        (("Rows:,2", "Rows:,10001"), "Rows must be a whole number from 1 to 10000, got '10001'"),
        (("Columns:,2", "Columns:,"), "Columns must be a whole number from 1 to 10000, got 'nothing'"),
        (("7,8\n", ""), "frame 1 (line 11) has 1 row, Rows says 2"),
    ):
        path.write_text(XSENSOR.replace(*change))
        said(lambda: read(path), f"{path}: {told}")
    path.write_text(XSENSOR.replace("1,2\n3,4\n", "").replace("5,6\n7,8\n", ""))
    said(lambda: read(path), f"{path}: holds no rows of numbers")
    path.write_text(XSENSOR)
    said(lambda: read(path, shape=(3, 2)), f"{path}: has frames of 2 x 2, not 3 x 2; leave the shape out")


@pytest.mark.parametrize(
    ("lines", "shape", "told"),
    [
        (["1,2,3,4"] * 4, (2, 2), [[[1, 2], [3, 4]]] * 4),
        (["9,1,2,3,4"] * 2, (2, 2), [[[1, 2], [3, 4]]] * 2),
        (["9,1,2,3,4"] * 4, (2, 2), "holds one column more than taxels, and the first one never changes, so that it is no time; leave out the column that is no taxel"),
        (["1,2"] * 4, (2, 2), [[[1, 2], [1, 2]]] * 2),
        (["9,1,2"] * 4, (2, 2), [[[1, 2], [1, 2]]] * 2),
        (["1,2"] * 3, (2, 2), "3 lines of one row each are no whole number of frames of 2 rows"),
        (["1"] * 4, (4, 1), [[[1], [1], [1], [1]]]),
        (["1,2"] * 4, (1, 2), [[[1, 2]]] * 4),
        (["1,2"] * 2, (2, 1), [[[1], [2]]] * 2),
        (["1,2,3"] * 2, (2, 2), [[[2, 3], [2, 3]]]),
        (["1,2,3"] * 2, (3, 1), [[[1], [2], [3]]] * 2),
        (["1,2,3"] * 2, (2, 4), "a line must hold 8 numbers, or one more with the time ahead, for this shape; got 3"),
        (["1,2,3"] * 2, None, "2 lines of 3 numbers and no blank line between frames: say the shape of a frame, (rows, columns)"),
        (["1,2", "1,2", "", "1,2", "1,2"], (3, 2), "frame 0 (line 1) has 2 rows where the given shape has 3"),
        (["1,2", "1,2", "", "1,2"], None, "frame 1 (line 4) has 1 row where frame 0 has 2"),
        (["1,2", "1,2", "", "3,4", "3,4"], None, [[[1, 2], [1, 2]], [[3, 4], [3, 4]]]),
        (["time,b", "1,2", "1,2", "", "3,4", "3,4"], None, [[[2], [2]], [[4], [4]]]),
        (["time", "1", "", "3"], None, "holds no taxels beside the column 'time'"),
    ],
)  # fmt: skip
def test_lines_are_frames_or_rows_by_what_is_said(
    tmp_path: Path, lines: list[str], shape: tuple[int, int] | None, told: Any
) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join(lines) + "\n")
    if isinstance(told, str):
        said(lambda: read(path, shape=shape), f"{path}: {told}")
    else:
        assert read(path, shape=shape).pads["pad"].frames.tolist() == told


UNITS_S = {
    1e-9: ("ns", "nsec", "nanoseconds"),
    1e-6: ("us", "\u00b5s", "\u03bcs", "usec", "microseconds"),
    1e-3: ("ms", "msec", "millis", "milliseconds"),
    1.0: ("s", "sec", "secs", "seconds"),
}
TIME_TITLES = {
    **dict.fromkeys(("time", "t", "timestamp"), 1.0),
    **{unit: unit_s for unit_s, units in UNITS_S.items() for unit in units},
    **{f"{clock}_{unit}": s for clock in ("time", "t", "timestamp") for s, units in UNITS_S.items() for unit in units},
    "time (s)": 1.0,
    "t [ms]": 1e-3,
    "timestamp(us)": 1e-6,
    "time[ns]": 1e-9,
    "time ms": 1e-3,
    **dict.fromkeys(("time_min", "time_minutes", "time (min)", "t [minutes]"), 60.0),
    **dict.fromkeys(("time_h", "time (h)", "t [hours]", "t / h"), 3600.0),
    **dict.fromkeys(("timems", "timestampms", "t/ms", "time / ms", "time ( ms )", "millisecond", "msecs"), 1e-3),
    **dict.fromkeys(("micros", "time_micros", "usecs", "timeus"), 1e-6),
}


@pytest.mark.parametrize("title", TIME_TITLES)
def test_titles_of_times_say_their_unit(tmp_path: Path, title: str) -> None:
    (tmp_path / "a.csv").write_text(f"{title.upper() if title.isascii() else title},a,b\n1,2,3\n4,5,6\n")
    recording = read(tmp_path / "a.csv", shape=(1, 2))
    assert recording.time_s is not None
    np.testing.assert_allclose(recording.time_s, np.array([1, 4]) * TIME_TITLES[title])
    assert csv_titles.names_time(title)


@pytest.mark.parametrize(
    ("title", "unit_s"),
    [("Zeit [ms]", 1e-3), ("Zeit/ms", 1e-3), ("elapsed [h]", 3600.0), ("elapsed_us", 1e-6), ("elapsed_msec", 1e-3), ("zeit_milliseconds", 1e-3), ("stamp (ns)", 1e-9), ("clock (min)", 60.0), ("clock_min", 1.0),
     ("clock", 1.0), ("terms", 1.0), ("clock_s_of_day", 1.0)],
)  # fmt: skip
def test_a_unit_at_the_end_of_any_title_before_the_taxels_is_that_of_the_time(
    tmp_path: Path, title: str, unit_s: float
) -> None:
    (tmp_path / "a.csv").write_text(f"{title},a,b\n1,2,3\n4,5,6\n")
    recording = read(tmp_path / "a.csv", shape=(1, 2))
    assert recording.time_s is not None
    np.testing.assert_allclose(recording.time_s, np.array([1, 4]) * unit_s)


def test_a_column_called_min_and_such_is_no_time_of_a_press(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("min,t_min,p.0.0,p.0.1\n7,8,0,1\n9,6,2,3\n")
    recording = read(tmp_path / "a.csv")
    assert recording.time_s is None
    assert {name: column.tolist() for name, column in recording.press_columns.items()} == {
        "min": [7, 9],
        "t_min": [8, 6],
    }


def test_a_table_of_presses_has_so_many_bytes_of_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.csv"
    path.write_text("label,p.0.0,p.0.1,p.1.0,p.1.1\n" + "x,1,2,3,4\n" * 3)
    monkeypatch.setattr(press_rows, "LARGEST_BYTES", 96)
    assert read(path).n_frames == 3
    monkeypatch.setattr(press_rows, "LARGEST_BYTES", 95)
    refused(lambda: read(path), f"{path}: has more than 95 bytes of numbers; store it as NPZ")
    path.write_text("time,label,p.0.0,p.0.1,p.1.0,p.1.1\n" + "soon,x,1,2,3,4\n" * 3)
    monkeypatch.undo()
    refused(lambda: read(path), f"{path}: column 'time' must be numbers, got 'soon'")


def test_cells_are_written_in_the_fewest_signs() -> None:
    cells = (True, np.False_, 1.0, 0.1, np.float32(0.5), math.nan, -2.0, 3, "x", 1e22)
    assert [cell_text(cell) for cell in cells] == ["1", "0", "1", "0.1", "0.5", "", "-2", "3", "x", "1e+22"]


def test_presses_of_the_strongest_are_found_beside_nothing() -> None:
    """What is pressed all the time is one press; what never is, none."""
    assert presses(Recording({"pad": Pad(np.ones((9, 4, 4)))})) == [range(9)]
    assert presses(Recording({"pad": Pad(np.zeros((9, 4, 4)))})) == []


def test_numbers_of_connections_and_topics_of_a_database_have_16_bits(tmp_path: Path) -> None:
    import sqlite3

    from tests.test_recording_rosbags import bag2

    (path,) = bag2(tmp_path / "bag").glob("*.db3")
    for number, fits in ((65535, True), (65536, False), (-1, False)):
        with sqlite3.connect(path) as base:
            base.execute(f"UPDATE topics SET id = {number}")
            base.execute(f"UPDATE messages SET topic_id = {number}, timestamp = 9223372036854775807")
        base.close()
        if fits:
            held = gather_database(path)
            assert held == [65535]
        else:
            refused(lambda: read(path), f"{path}: is damaged: a topic has the number '{number}'")
    path.write_bytes(struct.pack("<4s", b"what") + path.read_bytes()[4:])
    (tmp_path / "bag/a.db3").write_bytes(path.read_bytes())
    refused(lambda: read(tmp_path / "bag"), "does not start like SQLite; is it damaged, or something else?")


def gather_database(path: Path) -> list[int]:
    from varishold.recording.formats.rosbag2 import Database

    base = Database(path)
    try:
        return sorted({n for batch in base.batches() for n in batch.heads["channel"].tolist()})
    finally:
        base.close()


def test_all_that_was_gathered_is_in_its_order(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(6):
            # The sensor's number comes now and then, so that the topic has two channels.
            writer.reading({"x": np.full((1, 1), k)}, log_ns=k, device_ns=k * 2, **({"sequence": k} if k % 2 else {}))
        writer.finish()
    series = gather(path).pads["x"]
    assert series.values.ravel().tolist() == [*range(6)]
    assert series.log_ns.tolist() == [*range(6)]
    assert (series.stamp, series.stamp_ns.tolist(), series.sequence) == ("device", [0, 2, 4, 6, 8, 10], None)
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(6):
            writer.reading({"x": np.full((1, 1), k)}, log_ns=k, device_ns=k * 2 if k % 2 else None, sequence=k)
        writer.finish()
    series = gather(path).pads["x"]
    assert (series.stamp, series.stamp_ns.tolist()) == ("host", [*range(6)])
    assert series.sequence is not None
    assert series.sequence.tolist() == [*range(6)]
    with open_recording(path) as opened:
        assert [int(block.pads["x"].frames[0, 0, 0]) for block in opened.blocks(1)] == [*range(6)]


# What is seldom met


def test_a_topic_of_two_types_holds_both(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k, dtype in enumerate(("u1", "u2", "u1", "f4", "i2")):
            writer.reading({"x": np.full((2, 2), 200 + k, dtype)}, log_ns=k)
            writer.flush()
        writer.finish()
    with open_recording(path) as opened:
        both = opened.whole.pads["x"].frames, read(path).pads["x"].frames
        assert opened.frames[1:2].pads["x"].frames.dtype == both[0].dtype
    for frames in both:
        assert frames[:, 0, 0].tolist() == [200, 201, 202, 203, 204]
        assert frames.dtype == np.float32
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(3):
            writer.reading({"x": np.ones((2, 2 + k // 2), "u1" if k < 2 else "u2")}, log_ns=k * 10**9)
            writer.flush()
        writer.finish()
    told = f"{path}: topic /x: message of 2.000000 s has shape (2, 3), those before have (2, 2)"
    for act in (read, open_recording):
        said(lambda: act(path), told)  # noqa: B023


def images_by_others(path: Path, topic: str, messages: list[tuple[int, bytes, int]]) -> None:
    """Write a topic of images by the format's own library: log time, message and publish time of each."""
    from mcap.writer import Writer

    with path.open("wb") as file:
        made = Writer(file)
        made.start()
        schema = made.register_schema("sensor_msgs/msg/Image", "ros2msg", b"")
        channel = made.register_channel(topic, "cdr", schema)
        for message in messages:
            made.add_message(channel, *message)
        made.finish()  # type: ignore[no-untyped-call]


def test_colours_are_no_frames_and_are_passed_over(tmp_path: Path) -> None:
    for encoding, size in (("8UC3", 3), ("8UC2", 2), ("16UC4", 8)):
        path = tmp_path / "a.mcap"
        images_by_others(path, "/eye", [(1, image(2, 3, encoding, 3 * size, bytes(6 * size)), 1)])
        said(
            lambda: read(path),  # noqa: B023
            f"{path}: holds no topic with frames: /eye (sensor_msgs/msg/Image): has {encoding[-1]} numbers a pixel; pressure has one",
        )


def test_a_record_that_begins_at_the_end_of_a_chunk_is_damage() -> None:
    from varishold.recording.mcap.chunk import messages_of

    whole = struct.pack("<BQ", 200, 3) + b"abc"
    assert messages_of(whole + whole).starts == []
    for more in range(1, 9):
        with pytest.raises(ValueError, match=rf"^a record begins at byte 12 of {12 + more}$"):
            messages_of(whole + whole[:more])
    for content, told in (
        (struct.pack("<BQ", 0, 0), "a record of kind 0 and 0 bytes stands at byte 9 of 9"),
        (whole[:-1], "a record of kind 200 and 3 bytes stands at byte 9 of 11"),
        (struct.pack("<BQ", 5, 21) + bytes(21), "a record of kind 5 and 21 bytes stands at byte 9 of 30"),
    ):
        with pytest.raises(ValueError, match=rf"^{told}$"):
            messages_of(content)
    (one,) = [messages_of(struct.pack("<BQ", 5, 22 + n) + bytes(22) + b"x" * n) for n in (0,)]
    assert (one.starts, one.stops, one.heads.tolist()) == ([31], [31], [(0, 0, 0, 0)])


def test_columns_that_are_made_are_columns(tmp_path: Path) -> None:
    """Each tells its type, and gives any part."""
    import pyarrow as pa
    from tests.test_recording_lerobot import EPISODES, data_set
    from tests.test_recording_lerobot import FRAMES as MANY

    from varishold.recording.formats import open_stored
    from varishold.recording.formats.lerobot_windows import Window, window_of
    from varishold.recording.formats.named_arrays import HeldArrays
    from varishold.recording.stored import Turned

    deep = pa.array(np.stack([MANY, MANY + 1], 1).tolist(), pa.list_(pa.list_(pa.list_(pa.float32()))))
    path = data_set(tmp_path / "set", {"tactile.a": deep}, {"tactile.a": ("float32", [2, 3, 4], ["time", "r", "c"])})
    stored = open_stored(path)
    assert stored.press is not None
    assert stored.time_s is not None
    assert (stored.press.dtype, stored.press.shape) == (np.dtype(np.int64), (18,))
    assert (stored.time_s.dtype, stored.time_s.shape) == (np.dtype(np.float64), (18,))
    assert stored.press[3:9].tolist() == np.repeat(EPISODES, 2)[3:9].tolist()
    whole = stored.time_s[:]
    for a, b in ((0, 1), (1, 2), (3, 8), (7, 18), (5, 5)):
        assert stored.time_s[a:b].tolist() == whole[a:b].tolist()
    stored.close()
    values = np.arange(4 * 2 * 3 * 2).reshape(4, 2, 3, 2)
    window = Window(values, 2)
    assert (window.shape, window.dtype) == ((4, 3, 2), values.dtype)
    assert window[2:5].tolist() == values.reshape(8, 3, 2)[2:5].tolist()
    spread = Window(Turned(values, (3, 2), lambda block: block[:, 0])).spread(3)
    assert spread.shape == (12, 3, 2)
    assert spread[1:7].tolist() == values[:, 0].repeat(3, 0)[1:7].tolist()
    for tail, names, times in (
        ((5,), (), None),
        ((3, 4, 5, 6), (), None),
        ((3, 4), (), 1),
        ((4, 5, 3), (), 1),
        ((4, 5, 3), ("Time",), 4),
        ((3, 5, 6), (), None),
        ((4, 5, 6), (), 4),
        ((4, 5, 6), ("x",), None),
        ((1, 5, 6), (), 1),
        ((3, 5, 6), ("window",), 3),
    ):
        found = window_of("f", np.zeros((2, *tail)), names)
        assert (found.times if found else None) == times, tail
    held = HeldArrays({}, {"x": np.arange(3), "t": np.array("one"), "u": np.array(["one", "two"])})
    assert held.names == ("x", "t", "u")
    assert held.column("x")[1:].tolist() == [1, 2]
    assert (held.text("t"), held.unread) == ("one", ())
    said(lambda: held.text("u"), "u must be one text, got <U3 of shape (2,)")
    said(lambda: held.text("x"), "x must be one text, got int64 of shape (3,)")


def test_a_database_of_old_says_no_types(tmp_path: Path) -> None:
    import sqlite3

    from tests.test_recording_rosbags import FRAMES as MANY
    from tests.test_recording_rosbags import bag2

    (path,) = bag2(tmp_path / "bag").glob("*.db3")
    with sqlite3.connect(path) as base:
        base.execute("DROP TABLE message_definitions")
    base.close()
    np.testing.assert_array_equal(read(path).pads["skin"].frames, MANY)


def test_fields_of_a_struct_that_hold_nothing_are_no_variables(tmp_path: Path) -> None:
    from tests.test_recording_bound_laws import MAT5_FRAMES, mat5
    from tests.test_recording_matlab import element, matrix

    names = element(5, struct.pack("<i", 2)) + element(1, b"a\0b\0")
    inner = matrix(6, (1, 2), "", element(9, struct.pack("<2d", 5, 6)))
    path = mat5(tmp_path / "a.mat", MAT5_FRAMES, matrix(2, (1, 1), "s", names + element(14, b"") + inner))
    assert read(path).notes == ("passed over, for it is no part of a recording: s/b",)


@pytest.mark.parametrize(
    ("message", "told"),
    [
        ({"layout": {"dim": []}, "data": "text"}, None),
        ({"layout": 5, "data": [1.0, 2.0]}, [1, 2]),
        ({"layout": {"dim": []}, "data": [[1.0], [2.0]]}, [[1], [2]]),
        ({"fields": [], "point_step": 4, "data": [1, 2]}, [1, 2]),
        ({"fields": [{"name": "pressure"}], "point_step": 4, "data": [1.5, 2.5]}, [1.5, 2.5]),
        (IMAGE | {"data": [[1, 2]]}, [[1, 2]]),
        (IMAGE | {"encoding": 5}, None),
        ({"sensor": 1, "model": "x", "data": [1, 2]}, [1, 2]),
        ({"electrodes": [[1], [2]]}, [[1], [2]]),
        ({"cells_x": 1, "cells_y": 2, "data": [1, 2]}, [1, 2]),
        ({"forces": [1, 2], "displacements": [], "values": [5]}, [5]),
        ({"pressure_values": [[1], [2]]}, [[1], [2]]),
        ({"hand": 1, "sequence": 1, "pressure": "x", "values": [5]}, [5]),
        ({"values": [1, 2], "encoding": "x"}, None),
        ({"values": [1, 2], "format": "x"}, None),
        ({"left_touch": [[0] * 9], "values": [7]}, [7]),
    ],
)  # fmt: skip
def test_what_only_looks_like_a_message_is_looked_at_further(message: dict[str, Any], told: Any) -> None:
    if told is None:
        with pytest.raises(InputError, match="is not understood"):
            read_message(message)
    else:
        (pad,) = read_message(message).pads.values()
        assert pad.values.tolist() == told


def test_a_type_s_name_is_one() -> None:
    from varishold.recording.messages.decoding import ros_type_name

    for name, told in (
        ("a/B", "a/msg/B"),
        ("a/srv/B", "a/srv/B"),
        ("a::msg::dds_::B_", "a/msg/B"),
        ("a::msg::B", "a/msg/B"),
        ("a/msg/B_", "a/msg/B_"),
        ("a/b/c/D", "a/b/c/D"),
        ("a/" + "b" * 194, "a/msg/" + "b" * 194),
    ):
        assert ros_type_name(name) == told
    for name in ("a", "a/1", "a/b/c/d/E", "a/" + "b" * 195, "", "a b/C"):
        said(
            lambda: ros_type_name(name),  # noqa: B023
            f"{name[:100]!r} is no name of a message's type; it must be as sensor_msgs/msg/Image",
        )
    with pytest.raises(InputError, match=r"^the definition of a/msg/B (names|cannot be read)"):
        message_decoder("cdr", "a/msg/B", "b/c/d/e/F x\n", "ros2msg")
    said(
        lambda: message_decoder("cdr", "a/msg/B", "float32[0] x\n", "ros2msg"),
        "the definition of a/msg/B has an array of no length, x of a/msg/B",
    )
    assert message_decoder("cdr", "a/msg/B", "uint8[1] x\n", "ros2msg")(b"\0\1\0\0\5").x.tolist() == [5]


def test_a_topic_that_is_not_understood_is_passed_over_to_the_end(tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        made = Writer(file, chunk_size=50)
        made.start()
        schema = made.register_schema("x", "jsonschema", b"")
        skin = made.register_channel("/skin", "json", schema)
        words = made.register_channel("/words", "json", 0)
        for k in range(6):
            made.add_message(skin, k, b'{"values": [1, 2, %d]}' % k, k)
            # Later it could be understood, and is not: what came before is lost.
            made.add_message(words, k, b'{"values": [1]}' if k > 2 else b'{"word": "x"}', k)
        made.finish()  # type: ignore[no-untyped-call]
    for act in (read, lambda path: open_recording(path).whole):
        recording = act(path)
        assert recording.notes[-1] == "passed over: /words (json)"
        assert {name: pad.frames[:, 0, 2].tolist() for name, pad in recording.pads.items()} == {"skin": [*range(6)]}


def test_text_of_matlab_is_never_taken_for_frames(tmp_path: Path) -> None:
    import h5py
    from tests.test_recording_refusal_laws import labelled

    path = tmp_path / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["skin"] = FRAMES.T
        labelled(file, "touch", np.ones((5, 3, 4), np.uint16), MATLAB_class=np.bytes_("char"))
        labelled(file, "flags", np.ones((4, 3, 5), np.uint8), MATLAB_class=np.bytes_("logical"))
        labelled(file, "none", np.array([0, 0], np.uint64), MATLAB_class=np.bytes_("double"), MATLAB_empty=np.uint8(1))
        labelled(file, "some", np.zeros((1, 1)), MATLAB_class=np.bytes_("double"), MATLAB_empty=np.uint8(0))
    with path.open("r+b") as binary:
        binary.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    recording = read(path)
    np.testing.assert_array_equal(recording.pads["pad"].frames, FRAMES)
    assert recording.notes == ("taken for frames, by shape and name: skin",)


def test_small_columns_are_read_whole(tmp_path: Path) -> None:
    import pyarrow as pa
    from tests.test_recording_bound_laws import column, parquet

    from varishold.recording.formats.lerobot_windows import Window

    with column(parquet(tmp_path / "a.parquet", x=pa.array([[1, 2], [3, 4]], pa.list_(pa.int8(), 2)))) as held:
        assert held.small().tolist() == [[1, 2], [3, 4]]
        spread = Window(held).spread(2)
        assert spread.small().tolist() == [[1, 2], [1, 2], [3, 4], [3, 4]]
        held.typed(np.dtype("i2"), (1, 2))
        assert (held.shape, held[:].dtype) == ((2, 1, 2), np.dtype("i2"))
        for dtype, tail in (("i2", (3,)), ("U1", (2,)), ("i2", (-1, -2)), ("i2", ())):
            told = f"{tmp_path / 'a.parquet'}: column x: has 2 numbers a row, {tail} of {np.dtype(dtype)} are announced"
            said(lambda: held.typed(np.dtype(dtype), tail), told)  # noqa: B023


def test_what_cannot_be_frames_is_told_by_its_file(tmp_path: Path) -> None:
    """As what is mostly below zero."""
    path = tmp_path / "a.csv"
    for text in (
        "\n".join(["-5,-6", "-7,-8", "", "-1,-2", "-3,-4"]),
        "label,p.0.0,p.0.1\nx,-5,-6\ny,-7,-8\n",
        "Rows:,2\nColumns:,2\n-1,-2\n-3,-4\n",
        "DATA_TYPE MOVIE\nROWS 1\nCOLS 2\nASCII_DATA @@\nFrame 1\n-1,-2\n",
    ):
        path.write_text(text)
        with pytest.raises(FormatError) as error:
            read(path)
        assert str(error.value).startswith(f"{path}: pressure is mostly negative")
        for pad in read(path, polarity="down", pitch_m=(0.1, 0.2)).pads.values():
            assert (pad.polarity, pad.pitch_m) == ("down", (0.1, 0.2))


def test_files_that_follow_one_another_are_each_opened_once_by_who_reads_onward(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    from varishold.recording.formats import parquet_folder

    for k in range(3):
        pq.write_table(pa.table({"x": np.arange(4) + 4 * k, "y": np.zeros(4)}), tmp_path / f"{k}.parquet")
    files = [tmp_path / f"{k}.parquet" for k in range(3)]
    parts = parquet_folder.parts_of(files)
    assert [(part.n_rows, part.n_bytes, part.names) for part in parts] == [
        (4, file.stat().st_size, ("x", "y")) for file in files
    ]
    asked = []
    whole = parquet_folder.opened_parquet
    monkeypatch.setattr(parquet_folder, "opened_parquet", lambda path: asked.append(path.name) or whole(path))
    held = parquet_folder.FilesColumn("set", parts, "x")
    assert (held.shape, held.dtype, held.place) == ((12,), np.dtype("i8"), "set: column x")
    for first, last in ((0, 2), (2, 5), (5, 5), (5, 12), (11, 12)):
        assert held[first:last].tolist() == [*range(first, last)]
    assert asked == ["0.parquet", "1.parquet", "2.parquet"]
    assert held[3:9].tolist() == [*range(3, 9)]
    held.close()
    held.close()
    assert held[3:4].tolist() == [3]
    held.close()


@pytest.mark.parametrize(("seconds", "stamp"), [((0, 0, 0), "host"), ((0, 0, 7), "device"), ((5, 6, 7), "device")])
def test_stamps_of_others_are_times_where_any_is_one(tmp_path: Path, seconds: tuple[int, ...], stamp: str) -> None:
    path, told = tmp_path / "a.mcap", image(2, 3, "mono8", 3, bytes(6))
    stamped = [told[:4] + struct.pack("<iI", each, 0) + told[12:] for each in seconds]
    images_by_others(path, "/skin", [(100 + k, message, 200 + k) for k, message in enumerate(stamped)])
    series = gather(path).pads["skin"]
    times = [each * 10**9 for each in seconds] if stamp == "device" else [100, 101, 102]
    assert (series.stamp, series.stamp_ns.tolist(), series.log_ns.tolist()) == (stamp, times, [100, 101, 102])


def test_checksums_of_zarr_stand_within_what_is_packed_or_behind() -> None:
    from varishold.recording.formats.zarr_codecs import pipeline_3

    for names, told in (
        (("bytes",), (0, 0)),
        (("bytes", "crc32c"), (4, 0)),
        (("bytes", "crc32c", "crc32c"), (8, 0)),
        (("bytes", "zstd"), (0, 0)),
        (("bytes", "crc32c", "zstd"), (4, 0)),
        (("bytes", "zstd", "crc32c"), (0, 4)),
        (("bytes", "crc32c", "gzip", "crc32c"), (4, 4)),
    ):
        made = pipeline_3("p", [{"name": name} for name in names], (2,), np.dtype("u2"))
        assert (made.checksum, made.packed_checksum, made.shuffled, made.n_bytes) == (*told, 0, 4)
