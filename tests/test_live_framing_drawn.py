"""Framings drawn at random and written as files: what a writer of the test's own sends by them comes out again."""

from __future__ import annotations

import json
import zlib
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.live import PadLayout
from varishold.live.framing import decoder_of, read_framing
from varishold.live.framing.reading import Reading

DTYPES = ["uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"]

CUTS = st.lists(st.integers(0, 1 << 12), max_size=6)


def _crc16(data: bytes) -> int:
    """CRC-16/MODBUS, bit by bit."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value


CHECKS = {
    "sum8": (1, lambda data: sum(data) % 256),
    "lrc8": (1, lambda data: (256 - sum(data) % 256) % 256),
    "sum16": (2, lambda data: sum(data) % 65536),
    "crc16-modbus": (2, _crc16),
    "crc32": (4, zlib.crc32),
}


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {_toml(each)}" for key, each in value.items()) + " }"
    return "[" + ", ".join(map(_toml, value)) + "]" if isinstance(value, list) else json.dumps(value)


def _written(folder: Path, content: dict[str, Any]) -> Path:
    path = folder / "drawn.toml"
    path.write_text("\n".join(f"{key} = {_toml(value)}" for key, value in content.items()))
    return path


@dataclass
class Drawn:
    """A framing file's content, and what writes by it.

    Parameters
    ----------
    content : dict
    pads, packets : list of dict
        As they stand in the file, what is unsaid filled in.
    names : dict of int to str
        Of several sensors, by their byte.
    """

    content: dict[str, Any]
    pads: list[dict[str, Any]]
    packets: list[dict[str, Any]]
    endian: str
    names: dict[int, str] = field(default_factory=dict)

    def frame(self, rng: np.random.Generator) -> dict[str, np.ndarray]:
        """Return values of all pads in the order in which they are sent."""
        found = {}
        for pad in self.pads:
            dtype, count = np.dtype(pad["dtype"]), pad["shape"][0] * pad["shape"][1]
            values = rng.integers(-100, 100, count) if dtype.kind in "if" else rng.integers(0, 200, count)
            found[pad["name"]] = (values * (100 if dtype.itemsize > 1 else 1)).astype(dtype)
        return found

    def bytes_of(self, frame: dict[str, np.ndarray], marks: dict[int, bytes], rng: np.random.Generator) -> bytes:
        """Return a frame's packets; `marks` stand in the first one, and one of a single byte in each."""
        values = b"".join(
            frame[pad["name"]].astype(np.dtype(pad["dtype"]).newbyteorder("<>"[pad["endian"] == "big"])).tobytes()
            for pad in self.pads
        )
        sent = b""
        for number, packet in enumerate(self.packets):
            content, values = values[: packet["bytes"]], values[packet["bytes"] :]
            one = bytearray(packet["head"] + rng.bytes(packet["skip"]) + content + rng.bytes(packet["extra"]))
            for at, mark in marks.items():
                if number == 0 or at in self.content.get("whose", {}).values():
                    one[at : at + len(mark)] = mark
            if packet["checksum"]:
                size, of = CHECKS[packet["checksum"]["kind"]]
                counted = bytes(one[packet["checksum"]["from"] :])
                one += of(counted).to_bytes(size, packet["checksum"]["endian"])
            sent += bytes(one) + packet["tail"]
        assert not values
        return sent

    def shown(self, frame: dict[str, np.ndarray], whose: str) -> dict[str, list[Any]]:
        """Return a frame as it must come out."""
        found = {}
        for pad in self.pads:
            rows, cols = pad["shape"]
            values = frame[pad["name"]]
            if pad["kind"] == "pressure":
                values = values.reshape(cols, rows).T if pad["order"] == "columns" else values.reshape(rows, cols)
            found[self.name(pad, whose)] = [str(values.dtype), values.tolist()]
        return found

    def name(self, pad: dict[str, Any], whose: str) -> str:
        return pad["name"] if not whose else whose if pad["name"] == "pad" else f"{whose}.{pad['name']}"

    def layouts(self, whose: str) -> dict[str, PadLayout]:
        found = {}
        for pad in self.pads:
            rows, cols = pad["shape"]
            names = pad["names"]
            if names and len(names) < rows * cols:
                names = [f"{name}{row}" for row in range(rows) for name in names]
            signals = pad["kind"] == "signals"
            found[self.name(pad, whose)] = PadLayout(
                (rows * cols,) if signals else (rows, cols),
                pad["kind"],
                None if pad["pitch_m"] is None else tuple(pad["pitch_m"]),
                pad["unit"],
                pad["polarity"],
                tuple(names),
            )
        return found


def _some(draw: st.DrawFn, usual: dict[str, Any], choices: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return entries of which some are said, and the same with what is unsaid filled in."""
    said = {key: draw(choice) for key, choice in choices.items() if draw(st.booleans())}
    return said, {**usual, **said}


@st.composite
def _pads(draw: st.DrawFn, names: list[str], endian: str) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    said, whole = [], []
    for name in names:
        entries = {"dtype": draw(st.sampled_from(DTYPES)), "shape": [draw(st.integers(1, 4)), draw(st.integers(1, 5))]}
        usual = {"endian": endian, "order": "rows", "unit": "raw", "polarity": "up", "pitch_m": None}
        choices = {
            "endian": st.sampled_from(["little", "big"]),
            "order": st.sampled_from(["rows", "columns"]),
            "unit": st.sampled_from(["kPa", "N"]),
            "polarity": st.sampled_from(["up", "down"]),
            "pitch_m": st.sampled_from([[0.001, 0.002], [0.003, 0.003]]),
        }
        more, filled = _some(draw, usual, choices)
        filled |= {"kind": "pressure", "names": []}
        if draw(st.booleans()):
            more["kind"] = filled["kind"] = "signals"
            more.pop("order", None)
            filled["order"] = "rows"
            rows, cols = entries["shape"]
            count = draw(st.sampled_from([0, cols, rows * cols]))
            if count:
                more["names"] = filled["names"] = [f"s{number}" for number in range(count)]
        said.append({"name": name, **entries, **more})
        whole.append({"name": name, **entries, **filled})
    return said, whole


@st.composite
def drawn_framings(draw: st.DrawFn) -> Drawn:
    """Framings of packets that are told apart by their heads."""
    content: dict[str, Any] = {}
    endian = draw(st.sampled_from(["little", "big"]))
    if endian == "big" or draw(st.booleans()):
        content["endian"] = endian
    names = draw(st.sampled_from([["pad"], ["pad", "tip"], ["tip", "base", "imu"]]))
    said, pads = draw(_pads(names, endian))
    if names == ["pad"] and draw(st.booleans()):
        content |= {key: value for key, value in said[0].items() if key not in ("name", "endian")}
        pads[0]["endian"] = endian
    else:
        content["pads"] = [{k: v for k, v in one.items() if (k, v) != ("name", "pad")} for one in said]
    total = sum(np.dtype(pad["dtype"]).itemsize * pad["shape"][0] * pad["shape"][1] for pad in pads)
    parts = draw(st.integers(1, min(3, total)))
    places = [0, *sorted(draw(st.permutations(range(1, total)))[: parts - 1]), total]
    several = parts > 1 or draw(st.booleans())
    packets, written = [], []
    for number, (first, last) in enumerate(pairwise(places)):
        checksum = None
        entries: dict[str, Any] = {"head": f"AA {number:02X} ??", "skip": draw(st.integers(8, 10))}
        if draw(st.booleans()):
            kind = draw(st.sampled_from(sorted(CHECKS)))
            how, checksum = _some(
                draw,
                {"kind": kind, "from": 0, "endian": endian},
                {"from": st.integers(0, 9), "endian": st.sampled_from(["little", "big"])},
            )
            entries["checksum"] = {"kind": kind, **how} if how or draw(st.booleans()) else kind
        more, filled = _some(draw, {"extra": 0, "tail": ""}, {"extra": st.integers(0, 3), "tail": st.just("0D 0a")})
        head = bytes([0xAA, number, draw(st.integers(0, 255))])
        whole = {"head": head, "skip": entries["skip"], "bytes": last - first, "checksum": checksum}
        packets.append({**whole, "extra": filled["extra"], "tail": bytes.fromhex(filled["tail"])})
        written.append({**entries, **more, **({"bytes": last - first} if several else {})})
    if several:
        content["packets"] = written
    else:
        content |= written[0]
    drawn = Drawn(content, pads, packets, endian)
    if draw(st.booleans()):
        drawn.names = {0x01: "left", 0xF2: "right"}
        content["whose"] = {"at": 2, **{f"{byte:02X}": name for byte, name in drawn.names.items()}}
    return drawn


def test_a_frame_whose_packets_do_not_follow_each_other_is_damage(tmp_path: Path) -> None:
    content = {"dtype": "uint8", "shape": [1, 3], "whose": {"at": 2, "01": "a", "02": "b"}}
    content["packets"] = [{"head": f"AA {k:02X} ??", "bytes": 1} for k in range(3)]
    decoder = decoder_of(read_framing(_written(tmp_path, content)))

    def feed(*sent: tuple[int, int]) -> list[tuple[str, list[list[int]]]]:
        readings = decoder.feed(b"".join(bytes([0xAA, kind, whose, 10 * whose + kind]) for kind, whose in sent))
        return [(name, values.tolist()) for one in readings for name, values in one.pads.items()]

    # Those of another sensor may come between.
    assert feed((0, 1), (0, 2), (1, 1), (1, 2), (2, 2), (2, 1)) == [("b", [[20, 21, 22]]), ("a", [[10, 11, 12]])]
    assert decoder.damaged == 0
    whole = [("a", [[10, 11, 12]])]
    for sent, damaged in (
        # One is missing at the start, in the middle, at the end; one comes twice; one is nobody's.
        ([(1, 1), (2, 1)], 2),
        ([(0, 1), (2, 1)], 1),
        ([(0, 1), (1, 1)], 1),
        ([(0, 1), (0, 1), (1, 1), (2, 1)], 1),
        ([(0, 3)], 1),
    ):
        before = decoder.damaged
        told = feed(*sent, (0, 1), (1, 1), (2, 1))
        assert told == (whole * 2 if len(sent) == 4 else whole)
        assert decoder.damaged == before + damaged
    # What was begun before is forgotten with a new beginning.
    assert feed((0, 1), (1, 1)) == []
    decoder.restart()
    before = decoder.damaged
    assert feed((2, 1), (0, 1), (1, 1), (2, 1)) == whole
    assert decoder.damaged == before + 1


@given(drawn=drawn_framings(), seed=st.integers(0, 99), count=st.integers(2, 6), at=CUTS, clocks=st.booleans())
@settings(max_examples=150)
def test_what_is_sent_by_any_framing_comes_out(
    tmp_path_factory: pytest.TempPathFactory, drawn: Drawn, seed: int, count: int, at: list[int], clocks: bool
) -> None:
    rng, content = np.random.default_rng(seed), drawn.content
    # The numbers stand between the head and the values.
    time_kind, number_kind = (("uint32", "uint8"), ("float32", "uint16"), ("uint16", "int8"))[seed % 3]
    number_endian = ("little", "big")[seed % 2]
    if clocks:
        content["time"] = {"at": 3, "dtype": time_kind, "unit_s": 0.25}
        content["sequence"] = {"at": 7, "dtype": number_kind, "endian": number_endian}
    decoder = decoder_of(read_framing(_written(tmp_path_factory.mktemp("drawn"), content)))
    told: list[tuple[dict[str, list[Any]], float | None, int | None]] = []
    data, known = b"", {} if drawn.names else drawn.layouts("")
    assert dict(decoder.pads) == known
    span = 2 ** (8 * np.dtype(number_kind).itemsize)
    first = {"int8": 120, "uint8": 254, "uint16": 65534}[number_kind]
    counts = dict.fromkeys(drawn.names or [0], 0)
    for _ in range(count):
        byte = int(rng.choice(list(counts)))
        k, counts[byte] = counts[byte], counts[byte] + 1
        marks = {2: bytes([byte])} if drawn.names else {}
        if clocks:
            order = "<>"[drawn.endian == "big"]
            marks[3] = np.array([4 * k + 7]).astype(np.dtype(time_kind).newbyteorder(order)).tobytes()
            marks[7] = ((first + k) % span).to_bytes(span.bit_length() // 8, number_endian)
        frame, whose = drawn.frame(rng), drawn.names.get(byte, "")
        told.append((drawn.shown(frame, whose), 0.25 * (4 * k + 7) if clocks else None, first + k if clocks else None))
        data += drawn.bytes_of(frame, marks, rng)
        known |= drawn.layouts(whose)
    # What follows tells that the last packet is one, where no checksum does.
    places = [0, *sorted(min(place, len(data)) for place in at), len(data)]
    readings = [one for a, b in pairwise(places) for one in decoder.feed(data[a:b])]
    assert [_come(one) for one in readings] == told
    assert decoder.damaged == 0
    assert dict(decoder.pads) == known


def _come(reading: Reading) -> tuple[dict[str, list[Any]], float | None, int | None]:
    pads = {name: [str(values.dtype), values.tolist()] for name, values in reading.pads.items()}
    return pads, reading.device_time_s, reading.sequence
