"""Messages: what is made of each, what is known of pads by them, and when a source is given up."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.live import PadLayout
from varishold.live import interpreter as interpreting
from varishold.live.address import parse_address
from varishold.live.interpreter import Interpreter


def interpreter(options: str = "") -> Interpreter:
    return Interpreter(parse_address(f"ws://host/{options}"))


def test_messages_that_nobody_understands_are_given_up_after_some() -> None:
    its = interpreter()
    for k in range(4):
        assert its.payload(b"nothing") == []
        assert its.damaged == k + 1
    with pytest.raises(InputError, match="ws://host"):
        its.payload(b"nothing")


def test_once_one_was_understood_any_number_may_be_damaged() -> None:
    its = interpreter("?shape=2x3")
    (first,) = its.payload(b"[1, 2, 3, 4, 5, 6]", host_time_s=5.0, device_time_s=2.0, sequence=8)
    (pad,) = first.pads.values()
    assert pad.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert (first.host_time_s, first.device_time_s, first.sequence) == (5.0, 2.0, 8)
    known = its.pads
    for k in range(30):
        assert its.payload(b"[1, 2") == []
        assert its.damaged == k + 1
    assert its.damage
    assert its.pads is known


@given(st.lists(st.integers(-(2**15), 2**15 - 1), min_size=1, max_size=9))
@settings(max_examples=30)
def test_bare_numbers_are_little_endian(values: list[int]) -> None:
    its = interpreter("?dtype=int16")
    (sample,) = its.payload(b"".join(value.to_bytes(2, "little", signed=True) for value in values))
    assert np.concatenate([pad.ravel() for pad in sample.pads.values()]).tolist() == values
    assert its.payload(b"\x01") == []
    assert its.payload(b"") == []
    assert its.damaged == 2


def test_no_more_pads_than_a_thousand_are_known() -> None:
    its = interpreter()
    for k in range(1024):
        assert its.payload(json.dumps({"data": [1.0, 2.0]}).encode(), name=f"pad {k}")
    assert len(its.pads) == 1024
    assert its.payload(b'{"data": [1.0, 2.0]}', name="one more") == []
    assert its.payload(b'{"data": [1.0, 2.0]}', name="pad 5")
    assert (len(its.pads), its.damaged) == (1024, 1)


def test_a_message_without_a_taxel_is_understood_and_gives_no_reading() -> None:
    its = interpreter()
    assert its.sample(SimpleNamespace(pads={})) == []  # type: ignore[arg-type]
    for _ in range(9):
        assert its.payload(b"nothing") == []
    assert (its.damaged, its.pads) == (9, {})


def _said(*names: str, time_s: float | None = None, sequence: int | None = None) -> Any:
    pads = {
        name: SimpleNamespace(values=np.ones((2, 3)), kind="pressure", unit="kPa", polarity="up", names=())
        for name in names
    }
    return SimpleNamespace(pads=pads, time_s=time_s, sequence=sequence)


def test_a_pad_without_a_name_is_called_as_whoever_brings_it_says() -> None:
    names = ("pad", "arm.pad", "padded", "left", "pad.x")
    (one,) = interpreter().sample(_said(*names), name="tip")
    assert list(one.pads) == ["tip", "arm.tip", "padded", "left", "pad.x"]
    for name in (None, ""):
        (one,) = interpreter().sample(_said(*names), name=name)
        assert tuple(one.pads) == names


def test_what_a_message_says_of_itself_goes_before_what_is_known_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interpreting, "time", SimpleNamespace(time=lambda: 7e8))
    its = interpreter()
    known: dict[str, Any] = {"host_time_s": 5.0, "device_time_s": 6.0, "sequence": 7}
    (one,) = its.sample(_said("pad"), **known)
    assert one[:3] == (6.0, 5.0, 7)
    (one,) = its.sample(_said("pad", time_s=0.0, sequence=0), **known)
    assert one[:3] == (0.0, 5.0, 0)
    (one,) = its.sample(_said("pad"))
    assert one[:3] == (None, 7e8, None)
    # What is known of pads is a new mapping at each change, and the same otherwise.
    before = its.pads
    assert before == {"pad": PadLayout((2, 3), unit="kPa")}
    its.sample(_said("pad"))
    assert its.pads is before
    its.sample(_said("other"))
    assert (list(its.pads), list(before)) == (["pad", "other"], ["pad"])


SAID = "; does the address say another than is sent, or is there more than the values?"


@pytest.mark.parametrize(
    ("options", "content", "parameter", "remedy"),
    [
        ("?dtype=uint16", b"abc", "dtype", SAID),
        ("", b"\xff\xfe", "dtype", "; add ?dtype=TYPE to the address where numbers come as bare bytes"),
        ("?shape=2x2", b"[1, 2, 3]", "shape", SAID),
        ("", b"{", None, ""),
    ],
)
def test_who_is_given_up_is_told_what_to_add(options: str, content: bytes, parameter: str | None, remedy: str) -> None:
    its = interpreter(options)
    for _ in range(4):
        assert its.payload(content) == []
    with pytest.raises(InputError) as told:
        its.payload(content)
    assert str(told.value) == f"ws://host/{options}: {its.damage}{remedy}"
    assert getattr(told.value, "parameter", None) == parameter
    assert its.damaged == 5


@pytest.mark.parametrize("between", [b"\n", b"", b"\r\n", b" \n\n"])
def test_several_texts_in_one_message_are_several_readings(between: bytes) -> None:
    its = interpreter()
    texts = [json.dumps({"pressure": [[k, 1], [2, 3]], "time_s": k / 10, "name": "a ][ b"}).encode() for k in range(3)]
    found = its.payload(between.join(texts) + between, host_time_s=7.0)
    assert [sample.device_time_s for sample in found] == [0.0, 0.1, 0.2]
    assert {sample.host_time_s for sample in found} == {7.0}
    # One that is cut off is counted, the others are taken.
    assert len(its.payload(texts[0] + between + texts[1][:20])) == 1
    assert its.damaged == 1
    # What looks like an end in a text is none.
    assert len(its.payload(texts[0])) == 1


def test_a_message_of_very_many_texts_is_one_that_cannot_be_used() -> None:
    its = interpreter()
    assert its.payload(b"[]" * 100_000) == []
    assert its.damaged == 1


def test_a_row_that_is_null_has_no_numbers_and_the_others_are_taken() -> None:
    (sample,) = interpreter().payload(b'{"pressure": [[1, 2, 3], null, [4, 5, 6]]}')
    (pad,) = sample.pads.values()
    assert np.isnan(pad[1]).all()
    assert pad[[0, 2]].tolist() == [[1, 2, 3], [4, 5, 6]]


def test_rows_of_unlike_lengths_are_told_by_their_number() -> None:
    its = interpreter()
    assert its.payload(b'{"pressure": [[1, 2, 3], [1, 2], [4, 5, 6]]}') == []
    assert "rows of 'pressure' are unlike: row 1 has 2 values, row 0 has 3; send as many values in each" == its.damage


def test_a_text_may_be_as_long_as_a_large_frame_and_no_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interpreting, "_LONGEST_TEXT", 20)
    its = interpreter()
    assert its.payload(b"[[1, 2], [3, 4]]    ")
    assert its.payload(b"[[1, 2], [3, 4]]     ") == []
    assert its.damage == "21 bytes of JSON are more than 20"
    # Bare numbers are as many as they are.
    assert interpreter("?dtype=uint8").payload(bytes(30))


def test_a_name_from_outside_is_one_that_a_recording_may_have() -> None:
    (one,) = interpreter().payload(b"[[1, 2]]", name="a\x1bb\n")
    assert list(one.pads) == ["a\\x1bb\\n"]
    (one,) = interpreter().payload(b"[[1, 2]]", name=" ")
    assert list(one.pads) == ["pad"]
