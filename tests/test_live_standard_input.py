"""Another program's output on standard input."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from benchmarks._skin_senders import SENDERS, frames_of
from varishold.errors import InputError
from varishold.live import source_at

READ = """
import json, sys
from varishold.live import Stream, source_at
with Stream(source_at(sys.argv[1])) as stream:
    for sample in stream.reader():
        print(json.dumps({name: values.tolist() for name, values in sample.pads.items()}))
print(stream.words, file=sys.stderr)
"""


def _read(address: str, given: bytes | None) -> tuple[list[dict[str, list]], str]:
    done = subprocess.run(
        [sys.executable, "-c", READ, address],
        input=given,
        stdin=subprocess.DEVNULL if given is None else None,
        capture_output=True,
        timeout=120,
    )
    return [json.loads(line) for line in done.stdout.decode().splitlines()], done.stderr.decode()


@pytest.mark.parametrize("name", ["arduino-rows", "arduino-line", "flexitac", "jq-glove"])
def test_what_a_program_writes_comes(name: str) -> None:
    frames = frames_of(name, 12)
    shape = {"arduino-line": "&shape=6x6", "arduino-rows": "&shape=5x7"}.get(name, "")
    written = b"".join(SENDERS[name].bytes_of(frame) for frame in frames)
    found, words = _read(f"stdin:?preset={name}{shape}", written)
    assert len(found) == 12
    for one, other in zip(found, frames, strict=True):
        assert set(one) == set(other)
        assert all(np.array_equal(one[pad], other[pad].tolist()) for pad in one)
    assert "the program that wrote has ended" in words


def test_the_last_frame_needs_no_end_of_line() -> None:
    assert _read("stdin:?shape=2x2", b"1 2\n3 4\n\n5 6\n7 8")[0] == [
        {"pad": [[1, 2], [3, 4]]},
        {"pad": [[5, 6], [7, 8]]},
    ]
    assert _read("stdin:", b"")[0] == []
    assert _read("stdin:", None)[0] == []


def test_a_pipe_that_brings_no_frame_says_so() -> None:
    assert "stdin:: nothing came; write JSON, or rows of text and a blank line" in _read("stdin:", b"")[1]
    assert "3600 bytes came and no frame was in them" in _read("stdin:", bytes(range(128, 200)) * 50)[1]


def test_lines_of_json_are_seen_by_their_first_character() -> None:
    lines = [{"pressure": [[1, 2], [3, 4]], "time_s": 0.5}, {"pressure": [[5, 6], [7, 8]], "time_s": 1.5}]
    written = "\n \n" + "\n".join(json.dumps(line) for line in lines)
    assert _read("stdin:", written.encode())[0] == [{"pad": line["pressure"]} for line in lines]
    found, _ = _read("stdin:", b'[[1, 2], [3, 4]]\n[[1, 2]\n{"a": NaN}\n[[5, 6], [7, 8]]\n')
    assert found == [{"pad": [[1, 2], [3, 4]]}, {"pad": [[5, 6], [7, 8]]}]


@pytest.mark.parametrize("separator", [";", "\t", " ; "])
def test_beside_semicolons_and_tabs_a_comma_is_a_decimal_sign(separator: str) -> None:
    """As in files."""
    frames = [[[0.5, 1, 12.25], [2, -0.125, 3]], [[0, 7.5, 1], [1.5, 2, 4]]] * 2
    rows = "".join("\n".join(separator.join(map(str, row)) for row in frame) + "\n\n" for frame in frames)
    lines = "\n".join(separator.join(str(value) for row in frame for value in row) for frame in frames) + separator
    for address, text in (("stdin:", rows), ("stdin:?shape=2x3", lines)):
        assert _read(address, text.replace(".", ",").encode())[0] == _read(address, text.encode())[0] != []
    # Where commas separate as well they are no decimal signs.
    assert _read("stdin:?shape=2x3", b"1,2,3;4,5,6\n1,2.5,3;4,5,6\n")[0] == [
        {"pad": [[1, 2, 3], [4, 5, 6]]},
        {"pad": [[1, 2.5, 3], [4, 5, 6]]},
    ]


def test_a_rate_gives_the_frames_their_times() -> None:
    read = READ.replace(
        "json.dumps({name: values.tolist() for name, values in sample.pads.items()})", "sample.device_time_s"
    )
    done = subprocess.run(
        [sys.executable, "-c", read, "stdin:?rate_hz=50"],
        input=b'[[1, 2]]\n[[3, 4]]\n{"pressure": [[5, 6]], "time_s": 7.5}\n[[7, 8]]\n',
        capture_output=True,
        timeout=120,
    )
    assert [float(line) for line in done.stdout.split()] == [0.0, 0.02, 7.5, 0.06]


def test_bare_numbers_follow_each_other() -> None:
    values = np.arange(24, dtype="<u2").reshape(4, 2, 3)
    found, _ = _read("stdin:?dtype=uint16&shape=2x3", values.tobytes() + b"rest")
    assert found == [{"pad": frame.tolist()} for frame in values]


def test_what_cannot_be_is_told() -> None:
    with pytest.raises(InputError, match="stdin has no place"):
        source_at("stdin:file.csv")
    with pytest.raises(InputError, match="no option 'speed'"):
        source_at("stdin:?speed=1")
    with pytest.raises(InputError, match="bare numbers need their shape, as in shape=16x16"):
        source_at("stdin:?dtype=uint8")
    with pytest.raises(InputError, match="shape must be rows x columns, as in 16x16, got '0x0'"):
        source_at("stdin:?shape=0x0")
    with pytest.raises(InputError, match="dtype must be one of uint8"):
        source_at("stdin:?dtype=object&shape=2x2")
