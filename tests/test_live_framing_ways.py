"""Other ways than plain packets: two bytes for one, and numbers as text, as files at random have them."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_live_framing_drawn import CHECKS, CUTS, DTYPES, _come, _written
from tests.test_live_framing_file import _read

from varishold.live.framing import decoder_of, read_framing


@given(
    ends=st.sampled_from([("7E", "7F"), ("7E", ""), ("", "7F"), ("7E", "7E")]),
    values=st.lists(st.lists(st.sampled_from([0, 1, 0x7D, 0x7E, 0x7F, 255]), min_size=6, max_size=6), max_size=5),
    check=st.sampled_from(["", *sorted(CHECKS)]),
    at=CUTS,
)
@settings(max_examples=80)
def test_what_is_escaped_comes_out(
    tmp_path_factory: pytest.TempPathFactory, ends: tuple[str, str], values: list[list[int]], check: str, at: list[int]
) -> None:
    head, tail = (bytes.fromhex(end) for end in ends)
    pairs = {"7D 01": "7D", "7D02": "7e", "7d 03": "7F"}
    content = {"dtype": "uint8", "shape": [2, 3], "skip": 1, "sequence": {"at": 0, "dtype": "uint8"}, "escape": pairs}
    content |= {key: end for key, end in (("head", ends[0]), ("tail", ends[1])) if end}
    if check:
        content["checksum"] = {"kind": check, "from": 1}
    decoder = decoder_of(read_framing(_written(tmp_path_factory.mktemp("escaped"), content)))
    means = {0x7D: b"\x7d\x01", 0x7E: b"\x7d\x02", 0x7F: b"\x7d\x03"}
    data = b""
    for number, six in enumerate(values):
        one = bytes([number, *six])
        if check:
            size, of = CHECKS[check]
            one += of(one[1:]).to_bytes(size, "little")
        data += head + b"".join(means.get(byte, bytes([byte])) for byte in one) + tail
    # Without a tail, the next head ends it.
    data += b"" if tail else head
    places = [0, *sorted(min(place, len(data)) for place in at), len(data)]
    readings = [one for a, b in pairwise(places) for one in decoder.feed(data[a:b])]
    assert [one.pads["pad"].ravel().tolist() for one in readings] == values
    assert [one.sequence for one in readings] == list(range(len(values)))
    assert decoder.damaged == 0


@given(
    rows=st.booleans(),
    shape=st.tuples(st.integers(1, 3), st.integers(1, 4)),
    skip=st.integers(0, 3),
    dtype=st.sampled_from([None, *DTYPES]),
    by_columns=st.booleans(),
    seed=st.integers(0, 99),
)
@settings(max_examples=80)
def test_what_is_sent_as_text_comes_out(
    tmp_path_factory: pytest.TempPathFactory,
    rows: bool,
    shape: tuple[int, int],
    skip: int,
    dtype: str | None,
    by_columns: bool,
    seed: int,
) -> None:
    rng, signals = np.random.default_rng(seed), not rows and seed % 2 == 1
    content: dict[str, Any] = {"text": "rows" if rows else "line", "shape": list(shape), "skip": skip}
    content |= {} if dtype is None else {"dtype": dtype}
    by_columns = by_columns and not rows and not signals
    content |= {"order": "columns"} if by_columns else {}
    content |= {"kind": "signals"} if signals else {}
    content |= {"time": {"at": 0, "unit_s": 0.5}} if skip > 0 else {}
    content |= {"sequence": {"at": skip - 1}} if skip > 1 else {}
    decoder = decoder_of(read_framing(_written(tmp_path_factory.mktemp("text"), content)))
    data, told = b"", []
    for number in range(4):
        values = rng.integers(0, 100, shape)
        before = [3 * number, *[-5] * (skip - 1)][:skip]
        before[skip - 1 : skip] = [number] if skip > 1 else before[skip - 1 : skip]
        lines = [[*before, *row] for row in values.tolist()] if rows else [[*before, *values.ravel().tolist()]]
        data += b"".join(" ".join(map(str, line)).encode() + b"\r\n" for line in lines) + (b"\n" if rows else b"")
        if by_columns:
            values = values.ravel().reshape(shape[::-1]).T
        pads = [dtype or "float64", (values.ravel() if signals else values).tolist()]
        told.append(({"pad": pads}, 1.5 * number if skip > 0 else None, number if skip > 1 else None))
    assert [_come(one) for one in decoder.feed(data)] == told
    assert decoder.damaged == 0
    assert decoder.pads["pad"].shape == ((shape[0] * shape[1],) if signals else shape)


def test_a_frame_of_rows_comes_with_its_last_row(tmp_path: Path) -> None:
    """Where a blank line stood before it; the one behind it may come with the next frame only."""
    decoder = decoder_of(_read(tmp_path, 'text = "rows"\nshape = [2, 2]\n'))
    assert decoder.feed(b"7 8\n1 2\n3 4\n") == []
    assert decoder.feed(b"\n") == []
    assert decoder.damaged == 1
    assert [len(decoder.feed(part)) for part in (b"1 2\n", b"3 4\n", b"\n", b"5 6\n", b"7 8", b"\n")] == [
        0,
        1,
        0,
        0,
        0,
        1,
    ]
    # Text that no blank line has begun yet is a frame when one ends it.
    decoder = decoder_of(_read(tmp_path, 'text = "rows"\nshape = [2, 2]\n'))
    assert [len(decoder.feed(part)) for part in (b"1 2\n", b"3 4\n", b"\n")] == [0, 0, 1]
    decoder.restart()
    assert [len(decoder.feed(part)) for part in (b"1 2\n", b"3 4\n", b"\n")] == [0, 0, 1]
    assert decoder.damaged == 0
