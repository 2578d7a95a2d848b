"""Framing files: what they say comes to be, and what is wrong with one is told in one line."""

from __future__ import annotations

import dataclasses
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from varishold.errors import FormatError, InputError
from varishold.live import PadLayout
from varishold.live.framing import FRAMINGS, decoder_of, framing_of, read_framing

PLAIN = 'dtype = "uint8"\nshape = [2, 3]\nhead = "AA 55"\n'

ESCAPE = 'dtype = "uint8"\nshape = [2, 3]\nhead = "5B"\ntail = "5D"\n'


def _read(folder: Path, text: str) -> Any:
    (folder / "mine.toml").write_text(text)
    return read_framing(folder / "mine.toml")


def _one(folder: Path, text: str, data: bytes) -> dict[str, Any]:
    """Return the first frame of what is sent twice."""
    return dict(decoder_of(_read(folder, text)).feed(data * 2)[0].pads)


def test_what_stands_in_it_comes_to_be(tmp_path: Path) -> None:
    framing = _read(
        tmp_path,
        PLAIN + 'name = "mine"\nbaud = 9600\nunit = "kPa"\npolarity = "down"\npitch_m = [1e-3, 2e-3]\nstart = "01"\n',
    )
    assert (framing.name, framing.baud, framing.start) == ("mine", 9600, b"\x01")
    assert framing.pads[0].layout == PadLayout((2, 3), "pressure", (1e-3, 2e-3), "kPa", "down")


def test_bytes_stand_where_it_says(tmp_path: Path) -> None:
    text = 'dtype = "int16"\nendian = "big"\nshape = [1, 2]\nhead = "AA ??"\nskip = 1\nextra = 2\ntail = "0D"\n'
    pads = _one(tmp_path, text, bytes.fromhex("AA 77 00 FFFE 0102 9999 0D"))
    assert pads["pad"].tolist() == [[-2, 258]]
    columns = _one(tmp_path, PLAIN + 'order = "columns"\n', bytes.fromhex("AA55 010203040506"))
    assert columns["pad"].tolist() == [[1, 3, 5], [2, 4, 6]]


def test_several_pads_of_several_types(tmp_path: Path) -> None:
    text = """head = "AA"
[[pads]]
name = "tip"
dtype = "uint8"
shape = [1, 2]
[[pads]]
name = "base"
dtype = "uint16"
endian = "big"
shape = [2, 1]
[[pads]]
name = "imu"
kind = "signals"
dtype = "int8"
shape = [1, 2]
names = ["x", "y"]
"""
    pads = _one(tmp_path, text, bytes.fromhex("AA 01 02 0003 0004 FB 06"))
    assert {name: values.tolist() for name, values in pads.items()} == {
        "tip": [[1, 2]],
        "base": [[3], [4]],
        "imu": [-5, 6],
    }
    assert framing_names(tmp_path, text) == ("x", "y")


def framing_names(folder: Path, text: str) -> tuple[str, ...]:
    layout = _read(folder, text).pads[-1].layout
    return tuple(layout.names)


def test_a_clock_and_a_number_go_on_where_they_wrap(tmp_path: Path) -> None:
    text = (
        PLAIN + 'skip = 3\ntime = { at = 2, dtype = "uint16", unit_s = 1e-3 }\nsequence = { at = 4, dtype = "uint8" }\n'
    )
    data = b"".join(
        b"\xaa\x55" + (65000 + 400 * k & 0xFFFF).to_bytes(2, "little") + bytes([(250 + k) & 0xFF]) + bytes(6)
        for k in range(10)
    )
    readings = decoder_of(_read(tmp_path, text)).feed(data)
    assert [reading.sequence for reading in readings] == list(range(250, 260))
    assert [reading.device_time_s for reading in readings] == pytest.approx([65.0 + 0.4 * k for k in range(10)])


def test_columns_of_a_text_before_its_values(tmp_path: Path) -> None:
    text = 'text = "line"\nshape = [1, 3]\nskip = 1\ntime = { at = 0, unit_s = 1e-3 }\n'
    (reading,) = decoder_of(_read(tmp_path, text)).feed(b"1500, 1, 2, 3\r\n")
    assert reading.device_time_s == pytest.approx(1.5)
    assert reading.pads["pad"].tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    "line",
    [b"1,2,3", b"1;2;3", b"1\t2\t3", b"  1 2  3 ", b"[1, 2, 3]", b"{1;2;3}\r", b"+1 2.0 3e0"],
)
def test_numbers_are_told_apart_by_anything_usual(tmp_path: Path, line: bytes) -> None:
    text = 'text = "line"\nshape = [1, 3]\ndtype = "int16"\n'
    (reading,) = decoder_of(_read(tmp_path, text)).feed(line + b"\n")
    assert reading.pads["pad"].tolist() == [[1, 2, 3]]
    assert reading.pads["pad"].dtype == np.int16


@pytest.mark.parametrize("line", [b"1,2", b"1,2,3,4", b"1,2,x", b"1,2,1_0", b"1,2,40000", b"1,2,0.5", b"1,2,nan"])
def test_a_line_that_does_not_fit_is_left_out(tmp_path: Path, line: bytes) -> None:
    decoder = decoder_of(_read(tmp_path, 'text = "line"\nshape = [1, 3]\ndtype = "int16"\n'))
    assert decoder.feed(line + b"\n") == []
    assert decoder.damaged == 1


def test_titles_between_the_rows_are_passed_over(tmp_path: Path) -> None:
    decoder = decoder_of(_read(tmp_path, 'text = "rows"\nshape = [2, 2]\n'))
    readings = decoder.feed(b"Frame 1\n1 2\n3 4\n\nFrame 2\n5 6\n7 8\n\nFrame 3\n9 1\n\nFrame 4\n1 1\n2 2\n\n")
    assert [reading.pads["pad"].tolist() for reading in readings] == [
        [[1, 2], [3, 4]],
        [[5, 6], [7, 8]],
        [[1, 1], [2, 2]],
    ]


def test_two_sensors_on_one_cable(tmp_path: Path) -> None:
    text = PLAIN.replace("AA 55", "AA ??") + '[whose]\nat = 1\n"01" = "left"\n"02" = "right"\n'
    decoder = decoder_of(_read(tmp_path, text))
    assert dict(decoder.pads) == {}
    left, right, stranger = (bytes([0xAA, which]) + bytes([which] * 6) for which in (1, 2, 3))
    readings = decoder.feed(left + right + stranger + right + left)
    assert [next(iter(reading.pads)) for reading in readings] == ["left", "right", "right", "left"]
    assert decoder.pads["right"].shape == (2, 3)
    assert decoder.damaged == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("dtype = 5\n", "dtype must be one of uint8, int8, uint16, int16, uint32, int32, float32, float64, got 5"),
        ('shape = [2, 2]\nhead = "AA"\n', "dtype must be one of uint8"),
        ('dtype = "uint8"\nhead = "AA"\n', "shape must be [rows, columns], it is missing"),
        ('dtype = "uint8"\nshape = [0, 2]\nhead = "AA"\n', "shape must be [rows, columns], each from 1 to 4096"),
        ('dtype = "uint8"\nshape = 5\nhead = "AA"\n', "each from 1 to 4096, got 5"),
        ('dtype = "uint8"\nshape = [4096, 4096]\nhead = "AA"\n', "a packet has 16777217 bytes, more than 1048576"),
        ('dtype = "uint8"\nshape = [2, 2]\n', "a packet needs a head or a tail: nothing else tells where it begins"),
        (PLAIN.replace("AA 55", "??"), "a packet needs a head or a tail"),
        (PLAIN.replace("AA 55", "AA 5"), 'head must be bytes in hexadecimal, as in "AA 55", with ?? for any byte'),
        (PLAIN.replace('"AA 55"', "170"), "head must be bytes in hexadecimal"),
        (PLAIN + "colour = 3\n", "unknown key colour; known are name, notes"),
        (PLAIN + "skip = -1\n", "skip must be a whole number from 0 to"),
        (PLAIN + "skip = true\n", "skip must be a whole number"),
        (PLAIN + "baud = 1\n", "baud must be a whole number from 50 to"),
        (PLAIN + 'endian = "middle"\n', "endian must be one of little, big, got 'middle'"),
        (PLAIN + 'order = "spiral"\n', "order must be one of rows, columns"),
        (PLAIN + 'polarity = "left"\n', "polarity must be one of up, down"),
        (PLAIN + "pitch_m = -1\n", "pitch_m must be one spacing in metres"),
        (PLAIN + 'checksum = "md5"\n', "checksum: kind must be one of sum8, lrc8"),
        (PLAIN + 'checksum = { kind = "sum8", at = 3 }\n', "checksum: unknown key at; known are kind, from, endian"),
        (PLAIN + 'time = { at = 7, dtype = "uint16" }\n', "time stands beyond the first packet, which has 8 bytes"),
        (PLAIN + 'time = { dtype = "uint16" }\n', "time: at must be a whole number"),
        (PLAIN + "time = 3\n", "time must be a table of at, dtype, endian, unit_s, got 3"),
        (PLAIN + 'sequence = { at = 2, dtype = "float32" }\n', "sequence: dtype must be of whole numbers"),
        (PLAIN + 'request = "AA ??"\n', 'request must be bytes in hexadecimal, as in "AA 55", without ??'),
        (PLAIN + 'kind = "smell"\n', "kind must be one of pressure, signals"),
        (PLAIN + 'kind = "signals"\nnames = ["a"]\n', "names must be 6 names, or 3 for each of 2 rows, got ['a']"),
        (PLAIN + 'names = "a"\nkind = "signals"\n', "names must be a list of names"),
        (PLAIN + 'text = "rows"\n', "a text has no head"),
        (PLAIN + 'names = ["a", "b", "c"]\n', 'names must be for signals only, kind = "signals"'),
        ('text = "rows"\nkind = "signals"\n', 'signals come in one line a frame: text = "line"'),
        ('text = "poem"\n', "text must be one of rows, line"),
        (PLAIN + "[[packets]]\nbytes = 6\n", "head cannot stand beside [[packets]]; write it in each"),
        (
            'dtype = "uint8"\nshape = [1, 2]\n[[packets]]\nhead = "AA"\nbytes = 3\n',
            "2 bytes of values, the packets hold 3",
        ),
        (
            'dtype = "uint8"\nshape = [1, 2]\n[[packets]]\nhead = "AA ??"\nbytes = 1\n'
            '[[packets]]\nhead = "?? 55"\nbytes = 1\n',
            "the heads of two packets do not tell them apart",
        ),
        ("packets = 3\n" + PLAIN.replace('head = "AA 55"\n', ""), "packets must be tables [[packets]], 1 to 64"),
        (PLAIN + "[[pads]]\nname = 3\n", "dtype, shape must stand in each of [[pads]]"),
        ('head = "AA"\n[[pads]]\nname = 3\ndtype = "uint8"\nshape = [1, 1]\n', "pad 0: name must be a text"),
        ('head = "AA"\n' + '[[pads]]\ndtype = "uint8"\nshape = [1, 1]\n' * 2, "two pads have the same name"),
        (PLAIN + "[whose]\nat = 1\n", 'whose needs names that differ, as in "01" = "left"'),
        (PLAIN + '[whose]\nat = 9\n"01" = "a"\n', "whose stands at byte 9, beyond a packet's end"),
        (PLAIN + '[whose]\n"01" = "a"\n', "whose: at must be a whole number"),
        (PLAIN + '[whose]\nat = 1\nleft = "01"\n', 'whose must be as in "01" = "left"'),
        (ESCAPE + "[escape]\n", "[escape] needs pairs that begin with one byte"),
        (ESCAPE + '[escape]\n"5C" = "5B"\n', "escape must be as in \"5C 01\" = \"5B\", got '5C' = '5B'"),
        (ESCAPE + '[escape]\n"5C 01" = "5B"\n"5C 02" = "5D"\n', "escape does not say how 5C itself is sent"),
        (ESCAPE + '[escape]\n"5C 00" = "5C"\n"5C 01" = "5B"\n', "escape does not say how 5D itself is sent"),
        (
            ESCAPE + '[escape]\n"5C 00" = "5C"\n"5C 5B" = "5B"\n"5C 02" = "5D"\n',
            "what escape sends must not be head or tail",
        ),
        (
            ESCAPE.replace("5B", "5B 5B") + '[escape]\n"5C 00" = "5C"\n',
            "head must be one byte, where there is an escape",
        ),
        ('dtype = "uint8"\nshape = [1, 1]\n[escape]\n"5C 00" = "5C"\n', "[escape] needs a head or a tail of one byte"),
        ("not toml", "is not a TOML file"),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(FormatError) as told:
        _read(tmp_path, text)
    assert words in str(told.value)
    assert str(told.value).startswith(str(tmp_path / "mine.toml"))
    assert "\n" not in str(told.value)


_SCALARS = st.one_of(
    st.integers(-5, 300),
    st.floats(allow_nan=False, allow_infinity=False),
    st.booleans(),
    st.sampled_from(["", "AA", "AA 55", "??", "rows", "line", "uint8", "float32", "signals", "big", "sum8", "x"]),
)

_VALUES = st.recursive(
    _SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(
            st.sampled_from(["at", "dtype", "01", "5C 01", "kind", "head", "bytes", "shape"]), inner, max_size=3
        ),
    ),
    max_leaves=8,
)


@given(
    name=st.sampled_from(sorted(FRAMINGS)),
    changes=st.dictionaries(st.text("abc_", max_size=3), _VALUES, max_size=1),
    data=st.data(),
)
@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
def test_whatever_stands_in_it_is_read_or_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, changes: dict[str, Any], data: st.DataObject
) -> None:
    content = tomllib.loads(FRAMINGS[name].read_text())
    for key in data.draw(
        st.lists(
            st.sampled_from(
                [*content, "head", "tail", "text", "time", "whose", "pads", "packets", "escape", "checksum"]
            ),
            max_size=3,
        )
    ):
        content[key] = data.draw(_VALUES)
    monkeypatch.setattr("varishold.live.framing.file.read_toml", lambda path: {**content, **changes})
    try:
        framing = read_framing("mine.toml")
    except FormatError:
        return
    decoder_of(framing).feed(b"\xaa\x55 1 2 3\n\n" * 20)


def test_presets_and_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="nobody: is no framing file"):
        framing_of("nobody")
    with pytest.raises(InputError, match=r"none\.toml"):
        framing_of("none.toml")
    (tmp_path / "flexitac").write_text(PLAIN)
    assert framing_of("flexitac").pads[0].count == 6
    with pytest.raises(dataclasses.FrozenInstanceError):
        framing_of("anyskin").baud = 3  # type: ignore[misc]


def test_what_is_said_of_a_text_stays_when_its_shape_is_seen(tmp_path: Path) -> None:
    decoder = decoder_of(_read(tmp_path, 'text = "rows"\nunit = "kPa"\npitch_m = 0.01\n'))
    assert dict(decoder.pads) == {}
    assert len(decoder.feed(b"1 2\n3 4\n\n5 6\n7 8\n\n9 1\n2 3\n\n")) == 2
    assert decoder.pads["pad"] == PadLayout((2, 2), "pressure", (0.01, 0.01), "kPa")


def test_another_shape() -> None:
    assert framing_of("anyskin").with_shape((2, 4)).pads[0].layout.names == (
        *("T0", "Bx0", "By0", "Bz0"),
        *("T1", "Bx1", "By1", "Bz1"),
    )
    flexitac = framing_of("flexitac").with_shape((16, 32))
    assert flexitac.packets[0].values == 512
    with pytest.raises(InputError, match="the pads pad, orientation"):
        framing_of("jq-glove").with_shape((8, 8))
