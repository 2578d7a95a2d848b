"""Messages of robots: what rosbags writes is what is read, whoever took it apart; and what is none is told."""

from __future__ import annotations

import array
import base64
import json
import math
from contextlib import suppress
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.recording.messages import MESSAGES, MessageReading, message_decoder, read_message, shapes
from varishold.recording.messages.decoding import ros_type_name

pytest.importorskip("rosbags", reason="rosbags is not installed")

from tests.ros_messages import as_dict, bytes_of, made, store_of, text_of

some = settings(max_examples=40)
RNG = np.random.default_rng(5)
STAMP = {"stamp": {"sec": 17, "nanosec": 250_000_000}, "frame_id": "palm"}


def taxels(rng: np.random.Generator, n: int, top: int = 60_000) -> list[dict[str, int]]:
    return [dict(zip("xyz", map(int, row), strict=True)) for row in rng.integers(0, top, (n, 3))]


def heard(name: str, encoding: str = "cdr", *, little_endian: bool = True, **values: Any) -> MessageReading:
    """Return what is read of a message that went over the wire; and check that its JSON says the same."""
    store = store_of(name)
    message = made(name, store, **values)
    decode = message_decoder(encoding, name, text_of(name))
    said = read_message(decode(bytes_of(message, store, encoding, little_endian=little_endian)))
    same(said, read_message(message))
    return said


def same(first: MessageReading, second: MessageReading) -> None:
    assert (first.time_s, first.sequence, list(first.pads)) == (second.time_s, second.sequence, list(second.pads))
    for name, pad in first.pads.items():
        other = second.pads[name]
        np.testing.assert_array_equal(pad.values, other.values)
        assert (pad.kind, pad.unit, pad.polarity, pad.names) == (other.kind, other.unit, other.polarity, other.names)


# What is sent of each type, and the pads by name that it is: (values, kind, unit, polarity).
XELA_TAXELS, XELA_FORCES = taxels(RNG, 24), [{"x": 0.5, "y": -0.25, "z": k / 4} for k in range(16)]
PILLARS = [{"id": k, "fX": k / 2, "fY": -k / 4, "fZ": k / 8, "dX": 1.0} for k in (4, 0, 1, 2, 3, 5, 8, 7, 6)]
TIP, PALM = RNG.integers(0, 4096, 9), RNG.integers(0, 4096, 112)
WUJI = RNG.integers(0, 2136, 768)
FLOATS = np.where(RNG.random(768) < 0.2, np.nan, RNG.random(768)).astype(np.float32)
FORCES = RNG.normal(size=1200)
PRESSED = RNG.random(12).astype(np.float32)
GRID = RNG.integers(0, 4096, (13, 6)).astype(np.int16)

CASES: list[tuple[str, dict[str, Any], dict[str, tuple[np.ndarray, str, str, str]], float | None, int | None]] = [
    (
        "tactile_msgs/msg/TactileState",
        {"header": STAMP, "sensors": [{"name": "ff", "values": [1, 2, 3]}, {"name": "th", "values": [4]}]},
        {"ff": (np.float32([1, 2, 3]), "pressure", "raw", "up"), "th": (np.float32([4]), "pressure", "raw", "up")},
        17.25,
        None,
    ),
    (
        "xela_server_ros2/msg/SensStream",
        {
            "sensors": [
                {"message": 7, "time": 1.5, "model": "uSPa46", "sensor_pos": 1, "taxels": XELA_TAXELS},
                {"message": 7, "time": 1.5, "model": "uSPa44", "sensor_pos": 2, "forces": XELA_FORCES},
            ]
        },
        {
            "1": (np.reshape([t["z"] for t in XELA_TAXELS], (4, 6)), "pressure", "raw", "up"),
            "shear.1": (np.ravel([[t["x"], t["y"]] for t in XELA_TAXELS]), "signals", "raw", "up"),
            "2": (np.reshape([t["z"] for t in XELA_FORCES], (4, 4)), "pressure", "N", "up"),
            "shear.2": (np.ravel([[t["x"], t["y"]] for t in XELA_FORCES]), "signals", "N", "up"),
        },
        1.5,
        7,
    ),
    (
        "papillarray_ros2_v2/msg/SensorState",
        {"header": STAMP, "tus": 2_500_000, "pillars": PILLARS},
        {
            "pad": (np.arange(9.0).reshape(3, 3) / 8, "pressure", "N", "up"),
            "shear.pad": (
                np.stack([np.arange(9.0) / 2, -np.arange(9.0) / 4], 1).ravel(),
                "signals",
                "N",
                "up",
            ),
        },
        2.5,
        None,
    ),
    (
        "sr_robot_msgs/msg/BiotacAll",
        {"header": STAMP, "tactiles": [{"pdc": 9, "tac": -1, "electrodes": np.arange(19)}, {"electrodes": [3] * 19}]},
        {
            "tactiles_0": (np.array([*range(19), 9, 0, 0, -1, 0]), "signals", "raw", "up"),
            "tactiles_1": (np.array([3] * 19 + [0] * 5), "signals", "raw", "up"),
        },
        17.25,
        None,
    ),
    (
        "sr_robot_msgs/msg/MST",
        {"timestamp": STAMP["stamp"], "magnetic_data": [{"x": 1.0, "y": 2.0, "z": 3.0}], "temperature_data": [21.5]},
        {
            "pad": (np.array([1.0, 2, 3]), "signals", "raw", "up"),
            "temperature.pad": (np.float32([21.5]), "signals", "raw", "up"),
        },
        17.25,
        None,
    ),
    (
        "schunk_sdh/msg/TactileSensor",
        {
            "header": STAMP,
            "tactile_matrix": [{"matrix_id": 3, "cells_x": 6, "cells_y": 13, "tactile_array": GRID.ravel()}],
        },
        {"3": (GRID, "pressure", "raw", "up")},
        17.25,
        None,
    ),
    (
        "schunk_sdh/msg/PressureArrayList",
        {"pressure_list": [{"sensor_name": "t1", "cells_x": 2, "cells_y": 1, "pressure": [5e3, 6e3]}]},
        {"t1": (np.array([[5e3, 6e3]]), "pressure", "Pa", "up")},
        None,
        None,
    ),
    (
        "robotis_interfaces/msg/HandPressures",
        {"header": STAMP, "sensors": [{"sensor_name": "thumb", "pressure_values": np.arange(9)}]},
        {"thumb": (np.arange(9).reshape(3, 3), "pressure", "raw", "up")},
        17.25,
        None,
    ),
    (
        "wujihand_msgs/msg/TactileFrame",
        {"header": STAMP, "hand": 1, "sequence": 65535, "device_timestamp": 1500, "pressure": WUJI},
        {"pad": (WUJI.reshape(24, 32), "pressure", "raw", "down")},
        1.5,
        65535,
    ),
    (
        "wujihand_tactile_msgs/msg/TactileFrame",
        {"header": STAMP, "sequence": 2, "device_timestamp_ms": 250, "pressure": FLOATS},
        {"pad": (FLOATS.reshape(24, 32), "pressure", "raw", "up")},
        0.25,
        2,
    ),
    (
        "unitree_hg/msg/HandState",
        {"press_sensor_state": [{"pressure": PRESSED, "temperature": PRESSED + 20, "lost": 1}] * 9},
        {
            f"{before}press_sensor_state_{k}": (PRESSED + add, kind, "raw", "up")
            for k in range(9)
            for before, kind, add in (("", "pressure", 0), ("temperature.", "signals", 20))
        },
        None,
        None,
    ),
    (
        "tactile_msgs/msg/TactileMsg",
        {
            "header": STAMP,
            "left": {"SN": "A1", "index": 8, "sendTimestamp": 3.5, "Forces": FORCES},
            "right": {"Forces": FORCES},
        },
        {
            f"{before}{name}": (values, kind, "N", "up")
            for name in ("A1", "right")
            for before, kind, values in (
                ("", "pressure", FORCES.reshape(20, 20, 3)[..., 2]),
                ("shear.", "signals", FORCES.reshape(-1, 3)[:, :2].ravel()),
            )
        },
        3.5,
        8,
    ),
    (
        "inspire/msg/inspire_hand_touch",
        {"fingerone_tip_touch": TIP, "palm_touch": PALM},
        {
            "fingerone_tip": (TIP.reshape(3, 3), "pressure", "raw", "up"),
            "palm": (PALM.reshape(8, 14), "pressure", "raw", "up"),
        },
        None,
        None,
    ),
]


@pytest.mark.parametrize(
    ("encoding", "little_endian"), [("cdr", True), ("cdr", False), ("ros1", True)], ids=["cdr", "big", "ros1"]
)
@pytest.mark.parametrize(("name", "sent", "pads", "time_s", "number"), CASES, ids=[case[0] for case in CASES])
def test_what_a_driver_sends_is_read(
    name: str, sent: Any, pads: Any, time_s: Any, number: Any, encoding: str, little_endian: bool
) -> None:
    said = heard(name, encoding, little_endian=little_endian, **sent)
    assert list(said.pads) == list(pads)
    for which, (values, *facts) in pads.items():
        pad = said.pads[which]
        np.testing.assert_array_equal(pad.values, values)
        assert [pad.kind, pad.unit, pad.polarity] == facts
        assert pad.values.dtype.isnative
    assert (said.time_s, said.sequence) == (time_s, number)


@pytest.mark.parametrize(("name", "sent"), [case[:2] for case in CASES], ids=[case[0] for case in CASES])
def test_case_of_names_and_who_took_it_apart_change_nothing(name: str, sent: Any) -> None:
    message = made(name, store_of(name), **sent)
    plain = as_dict(message)
    said = read_message(message)
    same(said, read_message(plain))
    same(said, read_message(json.loads(json.dumps(plain))))
    shouted = json.loads(
        json.dumps(plain), object_pairs_hook=lambda pairs: {key.upper(): value for key, value in pairs}
    )
    same(said, read_message(shouted))
    same(said, read_message(of_rclpy(plain)))


def of_rclpy(plain: Any) -> Any:
    """Return a message as rclpy makes it: objects that tell their fields, arrays of the standard library."""
    if isinstance(plain, dict):
        made = SimpleNamespace(**{key: of_rclpy(value) for key, value in plain.items()})
        made.get_fields_and_field_types = lambda: dict.fromkeys(plain, "any")
        return made
    if isinstance(plain, list) and plain and all(isinstance(item, float) for item in plain):
        return array.array("d", plain)
    return [of_rclpy(item) for item in plain] if isinstance(plain, list) else plain


@pytest.mark.parametrize("key", MESSAGES)
def test_every_shape_makes_a_difference(key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    others = [
        {"encoding": "mono8", "width": 2, "height": 1, "data": b"12"},
        cloud(np.zeros(4, [("pressure", "f4")]), 2),
        multi_array(np.arange(6), [2, 3]),
        XELA_WORDS,
        {"left": [[1, 2], [3, 4]]},
    ]
    sent = [*(as_dict(made(case[0], store_of(case[0]), **case[1])) for case in CASES), *others]
    before = [told(message) for message in sent]
    monkeypatch.setattr(shapes, "MESSAGES", {name: shape for name, shape in MESSAGES.items() if name != key})
    assert [told(message) for message in sent] != before


def told(message: Any) -> Any:
    try:
        return [(name, pad.values.tolist()) for name, pad in read_message(message).pads.items()]
    except InputError as error:
        return str(error)


XELA_WORDS = {
    "message": 4,
    "type": "routine",
    "1": {"time": 2.5, "sensor": "1", "model": "uSPa22", "taxels": 4, "data": ",".join(f"{k:04X}" for k in range(12))},
    "2": {"time": 2.5, "sensor": "2", "model": "uSPa46", "taxels": 2, "data": "0", "calibrated": [1, 2, 3, 4, 5, 6.5]},
}


def test_words_of_xela_are_read() -> None:
    said = read_message(XELA_WORDS)
    assert (said.time_s, said.sequence, list(said.pads)) == (2.5, 4, ["1", "shear.1", "2", "shear.2"])
    assert said.pads["1"].values.tolist() == [[2, 5], [8, 11]]
    assert said.pads["shear.1"].values.tolist() == [0, 1, 3, 4, 6, 7, 9, 10]
    assert said.pads["shear.1"].names == ("x0", "y0", "x1", "y1", "x2", "y2", "x3", "y3")
    assert (said.pads["2"].values.tolist(), said.pads["2"].unit) == ([3, 6.5], "N")
    for wrong, words in (
        ({"data": "0,1,x"}, "no hexadecimal words: '0,1,x'"),
        ({"data": "0,1"}, "a sensor of 4 taxels came with 2 values"),
        ({"data": "0,1,2", "calibrated": [1, 2]}, "came with 2 values, three a taxel"),
    ):
        with pytest.raises(InputError, match=words):
            read_message({"1": XELA_WORDS["1"] | wrong})


def test_rows_and_columns_of_json_are_pads_by_any_name() -> None:
    said = read_message({"left": [[1, 2]], "right": [[3, 4], [5, 6.5]], "time_s": 2, "what": "x", "n": [1]})
    assert {name: pad.values.tolist() for name, pad in said.pads.items()} == {
        "left": [[1, 2]],
        "right": [[3, 4], [5, 6.5]],
    }
    assert said.time_s == 2


@pytest.mark.parametrize("sides", [("rows", "cols"), ("Rows", "columns"), ("n_rows", "n_cols"), ("height", "width")])
def test_rows_and_columns_that_are_said_beside_values_are_theirs(sides: tuple[str, str]) -> None:
    said = dict(zip(sides, (2, 3), strict=True))
    grid = np.arange(6).reshape(2, 3)
    read = read_message({**said, "data": grid.ravel().tolist(), "t_s": 1.0})
    np.testing.assert_array_equal(read.pads["pad"].values, grid)
    axes = read_message({**said, "data": [[0, 0, value] for value in grid.ravel().tolist()]})
    np.testing.assert_array_equal(axes.pads["pad"].values, grid)
    # A person's word goes before, and values that do not fit stay in their row.
    assert read_message({**said, "data": [0] * 6}, shape=(3, 2)).pads["pad"].values.shape == (3, 2)
    assert read_message({**said, "data": [0] * 7}).pads["pad"].values.shape == (7,)
    assert read_message({**said, "data": grid.T.tolist()}).pads["pad"].values.shape == (3, 2)


def multi_array(values: np.ndarray, sizes: list[int], **layout: Any) -> dict[str, Any]:
    strides = [int(np.prod(sizes[at:])) for at in range(len(sizes))]
    dims = [{"label": "", "size": size, "stride": stride} for size, stride in zip(sizes, strides, strict=True)]
    return {"layout": {"dim": dims, "data_offset": 0} | layout, "data": values}


@some
@given(
    st.sampled_from(["Float32", "Float64", "Int16", "UInt8", "UInt16", "Int32"]),
    st.integers(1, 7),
    st.integers(1, 7),
    st.integers(0, 3),
    st.booleans(),
)
def test_arrays_take_their_layout_or_the_shape_that_is_asked_for(
    kind: str, rows: int, cols: int, before: int, laid_out: bool
) -> None:
    dtype = np.dtype(kind.lower())
    grid = (np.arange(rows * cols) * 3 % 251).astype(dtype).reshape(rows, cols)
    name = f"std_msgs/msg/{kind}MultiArray"
    store = store_of(name)
    values = np.concatenate([np.zeros(before, dtype), grid.ravel()])
    sent = multi_array(values, [rows, cols] if laid_out else [], data_offset=before)
    message = message_decoder("cdr", name, text_of(name))(bytes_of(made(name, store, **sent), store))
    np.testing.assert_array_equal(read_message(message, shape=(rows, cols)).pads["pad"].values, grid)
    (pad,) = read_message(message).pads.values()
    np.testing.assert_array_equal(pad.values, grid if laid_out else grid.ravel())
    assert pad.values.dtype == dtype


def test_rows_of_an_array_may_be_longer_than_they_need_be() -> None:
    values = np.arange(12.0)
    dims = [{"label": "rows", "size": 3, "stride": 12}, {"label": "cols", "size": 2, "stride": 4}]
    said = read_message({"layout": {"dim": dims, "data_offset": 1}, "data": values[:]})
    assert said.pads["pad"].values.tolist() == [[1, 2], [5, 6], [9, 10]]


def test_three_dimensions_are_axes_or_pads() -> None:
    axes = np.arange(24.0).reshape(2, 4, 3)
    said = read_message(multi_array(axes.ravel(), [2, 4, 3]))
    np.testing.assert_array_equal(said.pads["pad"].values, axes[..., 2])
    np.testing.assert_array_equal(said.pads["shear.pad"].values, axes[..., :2].ravel())
    said = read_message(multi_array(axes.ravel(), [3, 2, 4]))
    np.testing.assert_array_equal(said.pads["1"].values, axes.reshape(3, 2, 4)[1])
    assert list(said.pads) == ["0", "1", "2"]
    assert read_message(multi_array(axes.ravel(), [6, 4, 1])).pads["pad"].values.shape == (6, 4)


def test_a_shape_that_goes_several_times_makes_several_pads() -> None:
    said = read_message({"data": list(range(56))}, shape=(7, 4))
    assert [(name, pad.values.shape) for name, pad in said.pads.items()] == [("0", (7, 4)), ("1", (7, 4))]
    assert said.pads["1"].values[0, 0] == 28


IMAGES = {"32FC1": "f4", "64FC1": "f8", "16UC1": "u2", "16SC1": "i2", "8UC1": "u1", "mono8": "u1", "mono16": "u2"}


@some
@given(
    st.sampled_from(sorted(IMAGES)),
    st.integers(1, 6),
    st.integers(1, 6),
    st.integers(0, 5),
    st.booleans(),
    st.sampled_from(["cdr", "ros1"]),
)
def test_images_may_have_padded_rows_in_either_order_of_bytes(
    encoding: str, rows: int, cols: int, padding: int, big: bool, wire: str
) -> None:
    dtype = np.dtype(IMAGES[encoding]).newbyteorder(">" if big else "<")
    grid = (np.arange(rows * cols) * 7 % 200).astype(dtype).reshape(rows, cols)
    step = cols * dtype.itemsize + padding
    lines = np.full((rows, step), 0xEE, np.uint8)
    lines[:, : cols * dtype.itemsize] = grid.view(np.uint8).reshape(rows, -1)
    name = "sensor_msgs/msg/Image"
    store = store_of(name)
    message = made(
        name,
        store,
        header=STAMP,
        height=rows,
        width=cols,
        encoding=encoding,
        is_bigendian=int(big),
        step=step,
        data=lines.ravel(),
    )
    said = read_message(message_decoder(wire, name, text_of(name))(bytes_of(message, store, wire)))
    np.testing.assert_array_equal(said.pads["pad"].values, grid)
    assert said.pads["pad"].values.dtype == dtype.newbyteorder("=")
    assert said.time_s == 17.25
    plain = as_dict(message)
    np.testing.assert_array_equal(read_message(plain).pads["pad"].values, grid)
    plain["data"] = base64.b64encode(lines.tobytes()).decode()
    np.testing.assert_array_equal(read_message(plain).pads["pad"].values, grid)


def cloud(points: np.ndarray, rows: int, *, big: bool = False, padding: int = 0) -> dict[str, Any]:
    """Return a cloud of points, whose dtype names its fields."""
    codes = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}
    fields = [
        {"name": name, "offset": offset, "datatype": codes[dtype.str[1:]], "count": 1}
        for name, (dtype, offset) in points.dtype.fields.items()
    ]
    cols = points.size // rows
    lines = np.zeros((rows, cols * points.dtype.itemsize + padding), np.uint8)
    lines[:, : cols * points.dtype.itemsize] = points.reshape(rows, cols).view(np.uint8).reshape(rows, -1)
    return {
        "height": rows,
        "width": cols,
        "fields": fields,
        "is_bigendian": big,
        "point_step": points.dtype.itemsize,
        "row_step": lines.shape[1],
        "data": lines.ravel(),
        "is_dense": True,
    }


@some
@given(
    st.sampled_from(["Pressure", "intensity", "force"]),
    st.sampled_from(["f4", "f8", "u1", "i2", "u4"]),
    st.integers(1, 4),
    st.integers(1, 5),
    st.integers(0, 9),
    st.booleans(),
)
def test_clouds_are_read_by_the_name_of_a_field(
    field: str, kind: str, rows: int, cols: int, padding: int, big: bool
) -> None:
    order = ">" if big else "<"
    dtype = np.dtype(
        {
            "names": ["x", "y", field, "temperature"],
            "formats": [order + "f4", order + "f4", order + kind, order + "f4"],
            "offsets": [0, 4, 12, 24],
            "itemsize": 32,
        }
    )
    points = np.zeros(rows * cols, dtype)
    points[field] = np.arange(rows * cols)
    points["x"], points["temperature"] = np.arange(rows * cols) / 8, 3
    name = "sensor_msgs/msg/PointCloud2"
    store = store_of(name)
    message = made(name, store, header=STAMP, **cloud(points, rows, big=big, padding=padding))
    message = message_decoder("cdr", name, text_of(name))(bytes_of(message, store))
    pad = read_message(message).pads["pad"]
    np.testing.assert_array_equal(pad.values.ravel(), points[field])
    assert pad.values.shape == ((rows, cols) if rows > 1 else (cols,))
    assert read_message(message, field="temperature").pads["pad"].values.ravel().tolist() == [3] * rows * cols
    if rows == 1:
        np.testing.assert_array_equal(pad.positions_m, np.stack([points["x"], points["y"]], 1))
        assert read_message(message, shape=(1, cols)).pads["pad"].values.shape == (1, cols)


def test_a_type_that_nobody_knows_is_read_by_the_field_that_is_named() -> None:
    name = "somebody/msg/Skin"
    store = store_of(name)
    content = bytes_of(made(name, store, what="foam", skin=[1, 2, 3, 4]), store)
    message = message_decoder("cdr", name, text_of(name))(content)
    with pytest.raises(InputError, match=r"^somebody/msg/Skin is not understood: its fields are what, skin\[4\]"):
        read_message(message)
    assert read_message(message, field="SKIN", shape=(2, 2)).pads["pad"].values.tolist() == [[1, 2], [3, 4]]
    assert read_message({"a": [{"b": {"c": [5]}}]}, field="a.b.c").pads["pad"].values.tolist() == [5]


def test_what_lists_no_taxel_this_time_is_understood() -> None:
    for empty in ({"sensors": []}, {"pillars": []}, {"taxels": []}, {"data": []}, {"layout": {"dim": []}, "data": []}):
        assert dict(read_message(empty).pads) == {}


@pytest.mark.parametrize(
    ("sent", "pad"),
    [
        ("a\nb", "pressure_a\\nb"),
        ("\u202eabc", "pressure_\\u202eabc"),
        ("\ud800", "pressure_\\ud800"),
        ("\x1b[31m", "pressure_\\x1b[31m"),
        ("\0", "pressure_\\x00"),
        ("naïve 🙂", "pressure_naïve 🙂"),
    ],
)
def test_names_that_no_recording_could_hold_stand_as_their_codes(sent: str, pad: str) -> None:
    (found,) = read_message({"pressure": {sent: [[1, 2], [3, 4]]}}).pads
    assert found == pad
    (found,) = read_message({sent: [[1, 2], [3, 4]]}).pads
    assert found.isprintable()


@pytest.mark.parametrize("key", ["name", "pad", "sensor", "sensor_name", "sensor_id", "finger"])
@pytest.mark.parametrize("said", ["left", 3])
def test_pads_that_come_in_turn_say_which_they_are(key: str, said: str | int) -> None:
    for values in ([[1, 2], [3, 4]], [1, 2, 3, 4]):
        (found,) = read_message({key: said, "pressure": values}, shape=(2, 2)).pads.items()
        assert (found[0], found[1].values.tolist()) == (str(said), [[1, 2], [3, 4]])
    # A number of the message's own names no pad, and what holds the values is no name.
    assert list(read_message({"id": said, "pressure": [[1, 2]]}).pads) == ["pad"]
    assert list(read_message({key: [[1, 2], [3, 4]]}).pads) == [key]


@pytest.mark.parametrize("field", [None, "pressure"])
@pytest.mark.parametrize("shape", [(2, 4), (8, 1)])
def test_three_values_a_place_of_an_array_are_its_axes(shape: tuple[int, int], field: str | None) -> None:
    axes = np.arange(24.0).reshape(8, 3)
    rows = {"name": "tip", "pressure": axes.reshape(*shape, 3).tolist()}
    flat = {"name": "tip", "pressure": axes.tolist()}
    for message, asked in ((rows, None), (flat, shape)):
        found = read_message(message, shape=asked, field=field).pads
        pad, shear = ("pad", "shear.pad") if field else ("tip", "shear.tip")
        assert list(found) == [pad, shear]
        assert found[pad].values.tolist() == axes[:, 2].reshape(shape).tolist()
        assert (found[shear].kind, found[shear].values.tolist()) == ("signals", axes[:, :2].ravel().tolist())
    # Rows and columns stay where nothing says otherwise, and several frames of three columns are asked for as such.
    assert read_message(flat).pads["tip"].values.shape == (8, 3)
    assert len(read_message({"pressure": axes.ravel().tolist()}, shape=(4, 3)).pads) == 2


@pytest.mark.parametrize("name", ["timestamp", "time", "t"])
def test_a_time_may_be_a_date(name: str) -> None:
    message = {"pressure": [[1, 2]], name: "2026-11-30T10:00:03.25Z"}
    assert read_message(message).time_s == 1796032803.25
    assert read_message({**message, name: "2026-11-30 11:00:03,25+01:00"}).time_s == 1796032803.25
    assert read_message({**message, name: "soon"}).time_s is None
    # One that counts goes before.
    assert read_message({**message, "time_s": 7}).time_s == 7


def test_a_blank_name_is_none() -> None:
    assert list(read_message({" ": [[1, 2], [3, 4]]}).pads) == ["pad"]


def test_pads_of_one_name_are_told_apart() -> None:
    said = read_message({"sensors": [{"name": "tip", "values": [1]}, {"name": "tip", "values": [2]}]})
    assert [(name, int(pad.values[0])) for name, pad in said.pads.items()] == [("tip", 1), ("tip_2", 2)]


@pytest.mark.parametrize(
    ("message", "asked", "words"),
    [
        (5, {}, "a message has fields, and int has none"),
        ({"a": 1, "b": [1, 2]}, {}, r"a message is not understood: its fields are a, b\[2\]; name the one that"),
        ({"a": 1}, {"field": "q"}, "a message has no array of numbers called 'q'; its fields are a"),
        ({"data": [1, 2, 3]}, {"shape": (2, 2)}, "3 values came, which are no 2 x 2"),
        (multi_array(np.arange(3), [2, 2]), {}, "layout says 2 x 2 values, and 3 came"),
        (multi_array(np.arange(3), [3], data_offset=4), {}, "data begin at 4, and 3 values came"),
        (multi_array(np.arange(3), [10**9, 10**9]), {}, "layout says 1000000000 x 1000000000"),
        (multi_array(np.arange(16), [2, 2, 2, 2]), {}, "values of 4 dimensions came"),
        (
            {"encoding": "rgb8", "width": 1, "height": 1, "step": 3, "data": [1, 2, 3]},
            {},
            "an image in 'rgb8' came, which is no map of pressure; 32FC1",
        ),
        ({"encoding": "8FC1", "width": 1, "height": 1, "data": [1]}, {}, "there are no such numbers"),
        (
            {"encoding": "32FC1", "width": 2, "height": 2, "step": 8, "data": b"123"},
            {},
            "an image of 2 x 2 32FC1 with 8 bytes a row came with 3 bytes",
        ),
        ({"encoding": "mono8", "width": 2, "height": 1, "data": [1, 256]}, {}, "must be bytes, from 0 to 255"),
        ({"encoding": "mono8", "width": 2, "height": 1, "data": "§"}, {}, "text that is no base64"),
        ({"encoding": "mono8", "width": 1e9, "height": 1e9, "data": b""}, {}, "an image of 1000000000 x"),
        (cloud(np.zeros(4, [("x", "f4")]), 2), {}, "with the fields x came, and none of pressure, force"),
        (cloud(np.zeros(4, [("pressure", "f4")]), 2) | {"data": b"12"}, {}, "came with 2 bytes"),
        (cloud(np.zeros(4, [("pressure", "f4")]), 2) | {"point_step": 0}, {}, "points of 0 bytes"),
        (
            cloud(np.zeros(1, [("pressure", "f4")]), 1)
            | {"fields": [{"name": "pressure", "datatype": 7, "offset": 2}]},
            {},
            "field 'pressure' begins at byte 2 of a point of 4",
        ),
        ({"cells_x": 2, "cells_y": 2, "tactile_array": [1]}, {}, "a matrix of 2 x 2 cells came with 1 value"),
        ({"taxels": [{"x": 1, "y": 2, "z": "three"}]}, {}, "a taxel came without a number for one of x, y, z"),
        ({"s": [{"values": [1]}] * 2000}, {}, "a message of more than 1024 pads came"),
    ],
)
def test_what_is_wrong_is_told(message: Any, asked: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_message(message, **asked)


@pytest.mark.parametrize("none", [None, math.nan, math.inf])
@pytest.mark.parametrize(
    ("taxels", "more"),
    [
        ({"taxels": [{"x": 1, "y": 2, "z": 3}] * 4}, {"z": None}),
        ({"taxels": [], "forces": [{"x": 1.5, "y": 2.0, "z": 3.0}] * 4}, {"z": None}),
        ({"pillars": [{"fx": 1.0, "fy": 2.0, "fz": 3.0}] * 4}, {"fz": None}),
    ],
)
def test_a_taxel_without_a_number_costs_no_other(taxels: Any, more: Any, none: Any) -> None:
    taxels = {
        name: [*items[:-1], items[-1] | dict.fromkeys(more, none)] if items else items for name, items in taxels.items()
    }
    values = read_message(taxels, shape=(2, 2)).pads["pad"].values
    assert values[:, 0].tolist() == [3.0, 3.0]
    assert values[0, 1] == 3.0
    assert np.isnan(values[1, 1])


NAMES = """sensors values name taxels forces x y z pillars data layout dim size stride data_offset encoding width
height step fields point_step row_step offset datatype pressure temperature cells_x cells_y tactile_array electrodes
pdc hand sequence header stamp sec nanosec displacements magnetic_data time message model sensor_pos pressure_values
palm_touch"""

json_like = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(NAMES.split()),
            inner,
            max_size=6,
        )
    ),
    max_leaves=30,
)


@settings(max_examples=300)
@given(json_like, st.sampled_from([None, (2, 2)]), st.sampled_from([None, "data", "a.b"]))
def test_nonsense_is_read_or_told(message: Any, shape: Any, field: Any) -> None:
    with suppress(InputError):
        said = read_message(message, shape=shape, field=field)
        assert all(pad.values.dtype.kind in "iuf" for pad in said.pads.values())


@settings(max_examples=100)
@given(st.sampled_from([case[:2] for case in CASES]), st.data(), st.sampled_from(["cdr", "ros1"]))
def test_damaged_bytes_are_read_or_told(case: Any, data: Any, encoding: str) -> None:
    name, sent = case
    store = store_of(name)
    content = bytearray(bytes_of(made(name, store, **sent), store, encoding))
    for at in data.draw(st.lists(st.integers(0, len(content) - 1), max_size=8)):
        content[at] = data.draw(st.integers(0, 255))
    content = content[: data.draw(st.integers(0, len(content)))] + data.draw(st.binary(max_size=4))
    with suppress(InputError):
        read_message(message_decoder(encoding, name, text_of(name))(bytes(content)))


LINE = "=" * 80


@pytest.mark.parametrize(
    ("name", "text", "encoding", "words"),
    [
        ("a/msg/B", "float32[] data", "protobuf", "messages encoded as 'protobuf' cannot be read; cdr, ros1, json can"),
        ("a b", "float32[] data", "cdr", "'a b' is no name of a message's type"),
        ("a/msg/B", "$$$", "cdr", "the definition of a/msg/B cannot be read: TypesysError"),
        ("a/msg/B", "C c", "cdr", "the definition of a/msg/B lacks that of a/msg/C"),
        ("a/msg/B", "", "cdr", "the definition of a/msg/B lacks that of a/msg/B"),
        ("a/msg/B", "B b", "cdr", "holds a/msg/B within itself"),
        ("a/msg/B", f"C c\n{LINE}\nMSG: a/C\nB[] b", "cdr", "holds a/msg/B within itself"),
        ("a/msg/B", "string[4000000000] x", "cdr", "more than 1024 messages of fixed number"),
        ("a/msg/B", f"C[5000] c\n{LINE}\nMSG: a/C\nint8 x", "cdr", "more than 1024 messages of fixed number"),
        ("a/msg/B", "float32[0] x", "cdr", "an array of no length, x of a/msg/B"),
        ("a/msg/B", "int8 x" + " " * 300_000, "cdr", "has 300006 letters; 262144 are the most"),
        ("a/msg/B", "int8 x\nint8 x", "cdr", "the definition of a/msg/B cannot be used"),
    ],
)
def test_definitions_that_are_none_are_told(name: str, text: str, encoding: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        message_decoder(encoding, name, text)


@settings(max_examples=100)
@given(st.text(alphabet="abcMSGint8float32[]<=/ \n_:=#\"'\\0945()"), st.sampled_from(["", "ros2idl"]))
def test_no_text_of_a_type_does_more_than_be_refused(text: str, written: str) -> None:
    with suppress(InputError):
        message_decoder("cdr", "a/msg/B", text, written)


def test_a_standard_type_needs_no_text() -> None:
    name = "sensor_msgs/msg/Image"
    store = store_of(name)
    content = bytes_of(made(name, store, height=1, width=1, encoding="mono8", step=1, data=[7]), store)
    assert read_message(message_decoder("cdr", "sensor_msgs::msg::dds_::Image_")(content)).pads["pad"].values == 7
    assert ros_type_name("a/B") == "a/msg/B"


def test_json_is_taken_apart_as_it_is() -> None:
    decode = message_decoder("json")
    assert read_message(decode(b'{"data": [1, 2]}')).pads["pad"].values.tolist() == [1, 2]
    for wrong in (b"\xff", b"{", b"[" * 100):
        with pytest.raises(InputError):
            decode(wrong)


@pytest.mark.parametrize("none", ["NaN", "null", "Infinity", "-Infinity"])
def test_a_taxel_of_json_that_is_no_number_is_one_of_its_frame(none: str) -> None:
    decode = message_decoder("json")
    for text in ('{"data": [[1, %s], [3, 4]]}', '{"palm": [[1, %s], [3, 4]]}', '{"data": [[1, %s], [3, 4.5]]}'):
        (pad,) = read_message(decode(text.replace("%s", none).encode())).pads.values()
        assert pad.values.shape == (2, 2)
        assert np.isfinite(pad.values).tolist() == [[True, False], [True, True]]
        assert np.isnan(pad.values[0, 1]) == (none in ("NaN", "null"))
    whole = read_message(decode(f'{{"data": [[{none}, {none}]]}}'.encode()))
    assert whole.pads["pad"].values.shape == (1, 2)


def test_a_list_that_holds_something_else_beside_null_is_no_frame() -> None:
    for held in ([1, None, "a", 2], [None, "a", None], [None, {"a": 1}], [None, 10**400], [[1, 2], 3, None]):
        with pytest.raises(InputError, match="is not understood"):
            read_message({"data": held})


def test_frames_that_have_a_time_each_are_no_pads() -> None:
    frames = [[[1, 2], [3, 4]], [[1, 2], [3, 5]]]
    with pytest.raises(InputError, match="t_s has 2 times: write a message for each reading"):
        read_message({"t_s": [0.0, 0.1], "pressure": frames})
    # Of one time they are pads, as of as many other numbers.
    for beside in ({"t_s": 0.1}, {"gains": [1.0, 2.0]}):
        assert list(read_message({**beside, "pressure": frames}).pads) == ["0", "1"]
