"""What is known of a source: its status in words, and the limits of its framing."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.test_live_framing_file import PLAIN, _read

from varishold.errors import FormatError
from varishold.live import PadLayout, StreamHealth
from varishold.live.framing import read_framing
from varishold.live.framing.model import Packet
from varishold.live.framing.packets import PacketSplitter
from varishold.live.framing.text import TextDecoder
from varishold.live.health import StreamReport
from varishold.live.sample import UNNAMED_PAD
from varishold.live.status import source_status
from varishold.live.stream import Change


def _sent(**more: Any) -> StreamReport:
    unknown = dict.fromkeys(("lost", "twice", "late", "restarts", "clock_ppm", "clock_set"))
    plain = {"received": 7, "rate_hz": 99.96, "jitter_s": 0.00123, "longest_gap_s": 0.02, "silent_s": 0.256}
    return StreamReport(**{**plain, **unknown, **more})


def _status(sent: StreamReport, pads: dict[str, Any], *, damaged: int = 0, newest: Any = None) -> dict[str, Any]:
    health: Any = StreamHealth()
    health.report = lambda now_s: sent
    stream = SimpleNamespace(health=health, changes=(Change(1e9, "open", ""),), address="a:", state="open", words="w")
    stream.received, stream.damaged, stream.overrun = 8, damaged, 0
    return source_status(stream, pads, newest)  # type: ignore[arg-type]


def _pad(*words: str, remarks: tuple[str, ...] = (), pitch_m: float | None = None, rows: int = 2) -> Any:
    bad = tuple(SimpleNamespace(row=k, col=k + 1, word=word) for k, word in enumerate(words))
    report = SimpleNamespace(bad=bad, remarks=remarks, to_dict=lambda: {"bad": len(bad)})
    pitch = None if pitch_m is None else (pitch_m, 2 * pitch_m)
    zero = SimpleNamespace(state="held")
    return SimpleNamespace(shape=(rows, 5), pitch_m=pitch, how_it_is=lambda: report, zero=zero)


def test_a_status_tells_the_stream_in_figures() -> None:
    status = _status(_sent(), {})
    assert (status["rate_hz"], status["silent_s"], status["received"]) == (100.0, 0.26, 8)
    assert (status["address"], status["state"], status["words"]) == ("a:", "open", "w")
    assert status["facts"] == [["jitter", "1.2\u202fms"]]
    assert (status["remarks"], status["broken"], status["zero"]) == ([], {}, {})
    facts = dict(_status(_sent(lost=0, clock_ppm=0.9), {}, damaged=3)["facts"])
    assert facts == {"jitter": "1.2\u202fms", "lost on the way": "0", "damaged": "3", "sensor's clock": "right"}


@pytest.mark.parametrize(
    ("ppm", "told"), [(0.99, "right"), (-0.99, "right"), (1.2, "1.2\u202fppm fast"), (-34.4, "34\u202fppm slow")]
)
def test_a_clock_is_right_fast_or_slow(ppm: float, told: str) -> None:
    assert dict(_status(_sent(clock_ppm=ppm), {})["facts"])["sensor's clock"] == told


def test_a_status_tells_what_is_odd_about_the_newest_readings() -> None:
    pads = {name: SimpleNamespace(sigma=None, unit="raw", remarks=(f"{name} falls",)) for name in ("left", "right")}
    for n in (1, 2):
        told = _status(_sent(), {}, newest=SimpleNamespace(pads=dict(list(pads.items())[:n])))["remarks"]
        assert told == (["left falls"] if n == 1 else ["left: left falls", "right: right falls"])


def test_a_status_tells_pads_and_what_is_wrong_with_them() -> None:
    one = {"left": _pad("dead", "noisy", "stuck", remarks=("a", "b"), pitch_m=0.002)}
    status = _status(_sent(), one)
    assert status["facts"][1:] == [["taxels", "2 × 5 at 2\u202fmm"]]
    # What is noisy still tells something.
    assert status["broken"] == {"left": [[0, 1], [2, 3]]}
    assert (status["remarks"], status["zero"]) == (["a", "b"], {"left": "held"})
    assert status["health"]["pads"] == {"left": {"bad": 3}}
    many = {f"pad {k}": _pad("open line", "no number", "impulses", remarks=("a",), rows=k + 1) for k in range(9)}
    status = _status(_sent(lost=50), many)
    assert status["facts"][2:] == [[f"pad {k}", f"{k + 1} × 5"] for k in range(6)]
    assert status["remarks"] == [*_sent(lost=50).remarks, *(f"pad {k}: a" for k in range(8))]
    assert status["broken"]["pad 3"] == [[0, 1], [1, 2]]
    assert len(status["zero"]) == len(status["broken"]) == 9


_PLAIN = {"dtype": '"uint8"', "shape": "[2, 3]", "head": '"AA 55"'}


def _framing(folder: Path, **entries: str) -> Any:
    told = {**_PLAIN, **entries}
    text = "\n".join(f"{key} = {value}" for key, value in told.items() if value)
    (folder / "skin.toml").write_text(text)
    return read_framing(folder / "skin.toml")


def _at(place: int, dtype: str, unit_s: str = "") -> str:
    return f'{{ at = {place}, dtype = "{dtype}"{f", unit_s = {unit_s}" if unit_s else ""} }}'


def _from(place: int, **names: str) -> str:
    return "{ " + ", ".join([f"at = {place}", *(f'{byte} = "{name}"' for name, byte in names.items())]) + " }"


def test_what_a_framing_leaves_unsaid_is_the_usual(tmp_path: Path) -> None:
    its = _framing(tmp_path)
    (pad,), (packet,) = its.pads, its.packets
    assert (its.baud, its.skip, its.start, its.request, its.name, its.notes) == (115200, 0, b"", b"", "", "")
    assert (its.third_party, its.escape, its.text, its.time, its.sequence, its.whose) == (False, *[None] * 5)
    assert (packet.head, packet.tail, packet.skip, packet.extra, packet.checksum) == ((0xAA, 0x55), (), 0, 0, None)
    assert (packet.start, packet.body, packet.size) == (2, 6, 8)
    assert (pad.name, pad.columns_first, pad.column_names, pad.count) == (UNNAMED_PAD, False, (), 6)
    assert pad.layout == PadLayout((2, 3))
    its = _framing(
        tmp_path, dtype='"uint16"', time='{ at = 2, dtype = "uint32" }', sequence='{ at = 6, dtype = "int8" }'
    )
    assert (its.pads[0].dtype, its.time.dtype, its.time.at, its.time.unit_s) == ("<u2", "<u4", 2, 1.0)
    assert (its.sequence.dtype, its.sequence.at) == ("i1", 6)
    its = _framing(tmp_path, dtype='"uint16"', endian='"big"', time='{ at = 2, dtype = "uint32", endian = "little" }')
    assert (its.pads[0].dtype, its.time.dtype) == (">u2", "<u4")
    assert _framing(tmp_path, dtype='"uint16"', checksum='"sum16"', endian='"big"').packets[0].checksum.endian == "big"
    its = _framing(tmp_path, dtype="", head="", text='"line"', shape="")
    assert (its.pads[0].dtype, its.pads[0].layout.shape, its.packets) == ("<f8", (), ())


@pytest.mark.parametrize(
    ("key", "good", "bad"),
    [
        ("baud", ["50", "100000000"], ["49", "100000001", "true", "9600.0"]),
        ("skip", ["0", "1000"], ["-1", "1048577"]),
        ("extra", ["0", "1000"], ["-1", "1048577"]),
        ("shape", ["[1, 1]", "[4096, 1]", "[1, 4096]"], ["[0, 1]", "[4097, 1]", "[1, 4097]", "[2]", "[2, 3, 4]", "5"]),
        ("head", [f'"{"AA " * 64}"', '"AA ??"'], [f'"{"AA " * 65}"', '"A"', '"AAA"', '"??"', "5"]),
        ("request", ['""', f'"{"AA " * 64}"'], ['"AA ??"']),
        ("checksum", ['"sum8"', '{ kind = "sum8", from = 255 }'], ['{ kind = "sum8", from = 256 }', '"sum9"']),
        ("time", [_at(7, "uint8"), _at(4, "uint32")], [_at(8, "uint8"), _at(5, "uint32")]),
        ("time", [_at(0, "uint8", s) for s in ("1e-12", "1e6")], [_at(0, "uint8", s) for s in ("0.9e-12", "1.1e6")]),
        ("sequence", [_at(2, "uint8")], [_at(2, "float32"), "5"]),
        ("whose", [_from(7, a="01", b="02")], [_from(8, a="01"), _from(2), _from(2, a="1")]),
        ("whose", ['{ at = 2, 01 = "a", 02 = "b" }'], ['{ at = 2, 01 = "a", 02 = "a" }']),
        ("third_party", ["true"], ["1"]),
        ("name", ['"a"'], ["1"]),
        ("unit", ['"kPa"'], ["1"]),
        ("polarity", ['"down"'], ['"left"']),
        ("order", ['"columns"'], ['"diagonal"']),
    ],
)
def test_an_entry_may_be_its_least_and_its_most_and_nothing_beyond(
    key: str, good: list[str], bad: list[str], tmp_path: Path
) -> None:
    for value in good:
        _framing(tmp_path, **{key: value})
    for value in bad:
        with pytest.raises(FormatError, match=r"skin\.toml"):
            _framing(tmp_path, **{key: value})


def test_a_packet_is_no_larger_than_a_frame_of_512_x_512(tmp_path: Path) -> None:
    float32 = {"dtype": '"float32"', "head": '"AA"'}
    assert _framing(tmp_path, **float32, shape="[511, 512]").packets[0].size == 1 + 4 * 511 * 512
    with pytest.raises(FormatError, match="a packet has 1048577 bytes, more than 1048576"):
        _framing(tmp_path, **float32, shape="[512, 512]")


def test_names_of_signals_are_those_of_all_or_of_each_row(tmp_path: Path) -> None:
    signals = {"kind": '"signals"'}
    its = _framing(tmp_path, **signals, names='["x", "y", "z"]').pads[0]
    assert its.layout.names == ("x0", "y0", "z0", "x1", "y1", "z1")
    assert its.layout.shape == (6,)
    assert _framing(tmp_path, **signals, names='["a", "b", "c", "d", "e", "f"]').pads[0].layout.names == tuple("abcdef")
    assert _framing(tmp_path, **signals, shape="[1, 2]", names='["a", "b"]').pads[0].layout.names == ("a", "b")
    assert _framing(tmp_path, **signals).pads[0].layout.names == ()
    for wrong in ('["x", "y"]', '["x"]'):
        with pytest.raises(FormatError, match="6 names, or 3 for each of 2 rows"):
            _framing(tmp_path, **signals, names=wrong)
    with pytest.raises(FormatError, match="for signals only"):
        _framing(tmp_path, names='["x", "y", "z"]')


def test_a_column_first_frame_is_turned(tmp_path: Path) -> None:
    pad = _framing(tmp_path, order='"columns"').pads[0]
    assert pad.shaped(np.arange(6)).tolist() == [[0, 2, 4], [1, 3, 5]]
    assert _framing(tmp_path).pads[0].shaped(np.arange(6)).tolist() == [[0, 1, 2], [3, 4, 5]]


@pytest.mark.parametrize(("damaged", "lost"), [(1, False), (2, False), (3, False), (8, True)])
def test_some_damaged_heads_in_a_row_do_not_make_it_leave_but_many_do(damaged: int, lost: bool) -> None:
    """Every second packet's head is damaged, and values look like a head at one place all the time."""
    sent = [b"\xaa\x55" + bytes([number, 1, 2]) + b"\xaa\x55" + bytes([3, 4, 5]) for number in range(40)]
    for k in range(damaged):
        at = 10 + 2 * k
        sent[at] = b"\x00\x00" + sent[at][2:]
    splitter = PacketSplitter((Packet(8, (0xAA, 0x55)),))
    # It begins in step, for the first packets carry no false head.
    for k in range(6):
        sent[k] = sent[k][:5] + bytes(5)
    found = [packet for _, packet in splitter.feed(b"".join(sent))]
    whole = [packet for packet in sent[:38] if packet[:1] == b"\xaa"]
    missing = [packet for packet in whole if packet not in found]
    assert bool(missing) == lost
    assert splitter.damaged >= min(damaged, 3)
    if not lost:
        assert splitter.damaged == damaged


@pytest.mark.parametrize("text", ["line", "rows"])
def test_damage_of_a_text_only_grows(text: str, tmp_path: Path) -> None:
    its = TextDecoder(_framing(tmp_path, dtype='"uint8"', head="", text=f'"{text}"'))
    end, counts = {"line": (b"\n", [])}.get(text, (b"\n\n", []))
    good = b"1 2 3 4 5 6" if text == "line" else b"1 2 3\n4 5 6"
    for bad in (b"1 2 3 4", b"1 2 3\n4 5" if text == "rows" else b"1 2 x", good.replace(b"6", b"900")):
        its.feed(good + end + bad + end + good + end)
        counts.append(its.damaged)
    assert all(np.diff([0, *counts]) >= 1)


def test_pads_and_packets_are_64_at_most(tmp_path: Path) -> None:
    def pads(count: int) -> str:
        return 'head = "AA"\n' + "".join(
            f'[[pads]]\nname = "{k}"\ndtype = "uint8"\nshape = [1, 1]\n' for k in range(count)
        )

    def packets(count: int) -> str:
        return f'dtype = "uint8"\nshape = [1, {count}]\n' + "".join(
            f'[[packets]]\nhead = "{k:02X}"\nbytes = 1\n' for k in range(count)
        )

    assert len(_read(tmp_path, pads(64)).pads) == len(_read(tmp_path, packets(64)).packets) == 64
    for text in (pads(65), packets(65), "pads = []\n" + PLAIN[PLAIN.index("head") :], "packets = []\n" + PLAIN[:30]):
        with pytest.raises(FormatError, match="1 to 64"):
            _read(tmp_path, text)
