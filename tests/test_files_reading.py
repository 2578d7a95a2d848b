"""The guarded ways in: whatever a file is, its reader answers at once, with content or with one line."""

from __future__ import annotations

import io
import os
import socket
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hostile.fuzz import try_case
from hostile.specimens import specimens
from varishold.circuit.interchange import read_netlist
from varishold.errors import FormatError, InputError
from varishold.files import let_go, open_archive, read_json, read_npy, read_toml, write_archive
from varishold.grasp import read_model
from varishold.perceive import read_library
from varishold.recording import read, read_grasp_table, read_height_map
from varishold.skin import read_skin

READERS: dict[str, Callable[[Path], object]] = {
    "recording": read,
    "grasp table": read_grasp_table,
    "height map": read_height_map,
    "skin": read_skin,
    "model": read_model,
    "netlist": read_netlist,
    "library": read_library,
}


def make_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(path))


NO_FILES: dict[str, tuple[Callable[[Path], object], str]] = {
    "pipe": (os.mkfifo, "is a pipe"),
    "folder": (Path.mkdir, "is a folder"),
    "socket": (make_socket, "is a socket"),
    "device": (lambda path: path.symlink_to("/dev/zero"), "is a device"),
    "loop": (lambda path: path.symlink_to(path), "cannot be read"),
    "nothing": (lambda path: None, "there is no such file"),
}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("kind", NO_FILES)
def test_what_is_no_file_is_told_at_once(
    tmp_path: Path, reader: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # the name of a socket may not be long
    path = Path("it.npz")
    make, message = NO_FILES[kind]
    make(path)
    with pytest.raises(InputError, match=message) as told:
        READERS[reader](path)
    assert "\n" not in str(told.value)
    assert "it.npz" in str(told.value)


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\0" * 99,
        b"\xff\xfe" * 50,
        b"[" * 100_000,
        b'{"a":' * 100_000,
        b"a = " + b"[" * 100_000,
        b"9" * 5000,
        b"a = " + b"9" * 5000,
        b"[skin]\n[[skin]]\n\nkind = " + b"9" * 5000,
        b".".join([b"a"] * 50_000) + b" = 1",
        b"a = {" + b" . ".join([b'"b"'] * 50_000) + b" = 1}",
        b"a" * 200_000 + b" = '" + b"b. " * 200_000,
        b"PK\x05\x06" + b"\0" * 18,
    ],
)
def test_hostile_bytes_are_told_in_one_line(tmp_path: Path, reader: str, content: bytes) -> None:
    path = tmp_path / "it.dat"
    path.write_bytes(content)
    with pytest.raises(InputError) as told:
        READERS[reader](path)
    assert "\n" not in str(told.value)
    assert str(path) in str(told.value)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32"])
def test_documents_are_read_as_tables_are(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "a.json").write_bytes('{"name": "Händ"}\r\n'.encode(encoding))
    (tmp_path / "a.toml").write_bytes('name = "Händ"\r\n'.encode(encoding))
    assert read_json(tmp_path / "a.json") == read_toml(tmp_path / "a.toml") == {"name": "Händ"}


def test_documents_say_where_they_are_wrong(tmp_path: Path) -> None:
    path = tmp_path / "it.json"
    for text, message in {
        '{"a": 1, "a": 2}': "key 'a' stands twice",
        '{"a": NaN}': "numbers must be finite, got NaN",
        '{"a": ' + "9" * 5000 + "}": "an integer of thousands of digits",
        "[" * 80 + "1" + "]" * 80: "nested deeper than 64 levels",
        '{"a": }': "Expecting value at line 1, column 7",
    }.items():
        path.write_text(text)
        with pytest.raises(FormatError, match=message):
            read_json(path)
    path.write_text("a = 1\na = 2\n")
    with pytest.raises(FormatError, match="is not a TOML file"):
        read_toml(path)
    path.write_text("a = [{b = 0x" + "9" * 5000 + "}]\n")
    with pytest.raises(FormatError, match="an integer of thousands of digits"):
        read_toml(path)
    path.write_text('\ufeff["[[[[[[[[[[[[[", 1]')
    assert read_json(path) == ["[[[[[[[[[[[[[", 1]


def archive_of(path: Path, members: list[tuple[str, bytes]], method: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(path, "w", method) as made, pytest.warns() if len(dict(members)) < len(members) else _quiet():
        for name, content in members:
            made.writestr(name, content)
    return path


class _quiet:
    def __enter__(self) -> None: ...
    def __exit__(self, *_: object) -> None: ...


def npy(array: object) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, np.asarray(array))
    return buffer.getvalue()


def test_members_hold_what_their_header_says(tmp_path: Path) -> None:
    path = tmp_path / "it.npz"
    for content, message in {
        npy(np.ones((1, 4, 4))) + b"x": "holds more than it says: 128 bytes .* announced, 129 there",
        npy(np.ones((1, 4, 4)))[:-1]: "is cut off: 128 bytes .* announced, 127 there",
    }.items():
        with pytest.raises(FormatError, match=message):
            read(archive_of(path, [("pressure.npy", content)]))
        (tmp_path / "it.npy").write_bytes(content)
        with pytest.raises(FormatError, match=message):
            read_npy(tmp_path / "it.npy")


def test_a_name_that_stands_twice_is_refused(tmp_path: Path) -> None:
    one = npy(np.eye(4)[None])
    for names in (("pressure.npy", "pressure.npy"), ("pressure.npy", "pressure")):
        path = archive_of(tmp_path / "it.npz", [(name, one) for name in names])
        with pytest.raises(FormatError, match="holds 'pressure' twice"):
            read(path)


def test_what_nobody_knows_is_told(tmp_path: Path) -> None:
    path = archive_of(
        tmp_path / "it.npz", [("pressure.npy", npy(np.eye(4)[None])), ("colour.npy", npy(3)), ("a.txt", b"")]
    )
    assert "passed over, for it is no part of a recording: colour, a.txt" in read(path).remarks


@pytest.mark.parametrize("member", ["pressure", "colour"])
def test_no_answer_from_a_damaged_archive(tmp_path: Path, member: str) -> None:
    frames = np.random.default_rng(0).random((3, 8, 8))
    path = archive_of(tmp_path / "it.npz", [("pressure.npy", npy(frames)), ("colour.npy", npy(frames * 2))])
    with zipfile.ZipFile(path) as archive:
        at = archive.getinfo(f"{member}.npy").header_offset
    content = bytearray(path.read_bytes())
    content[at + 700] ^= 1
    path.write_bytes(content)
    with pytest.raises(FormatError, match=f"{member}.*damaged.*CRC"):
        read(path)


def test_bombs_are_refused_before_they_are_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "it.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as made, made.open("pressure.npy", "w") as member:
        member.write(npy(np.zeros((1, 1, 1)))[:128])
        for _ in range(300):
            member.write(bytes(1 << 20))
    with pytest.raises(FormatError, match="nothing measured is so empty"):
        read(path)
    with pytest.raises(FormatError, match="holds 1001 arrays; at most 1000"):
        read(archive_of(path, [(f"{k}.npy", b"") for k in range(1001)]))
    with pytest.raises(FormatError, match="packed in a way that numpy never uses"):
        read(archive_of(path, [("pressure.npy", npy(np.eye(3)[None]))], zipfile.ZIP_LZMA))


def test_texts_that_no_file_can_hold_are_replaced(tmp_path: Path) -> None:
    impossible = np.array([0x10FFFF + 1, ord("a"), 0xD800, 0xFFFFFFFF], np.uint32).view("U4")
    write_archive({"text": impossible, "bytes": np.array(b"\xff\xfe")}, tmp_path / "it.npz")
    with open_archive(tmp_path / "it.npz") as archive:
        assert archive.array("text").tolist() == [archive.text("text")] == ["\ufffda\ufffd\ufffd"]
        assert archive.text("bytes") == "\ufffd\ufffd"


def test_standard_input_is_a_file_like_any_other(tmp_path: Path) -> None:
    np.save(tmp_path / "it.npy", np.arange(24).reshape(2, 3, 4))
    (tmp_path / "it.csv").write_text("1,2\n3,4\n\n5,6\n7,8\n")
    np.savez(tmp_path / "it.npz", pressure=np.eye(3)[None])
    code = "import varishold; r = varishold.read('-'); print(r.n_frames, r.pads['pad'].shape, r.totals().sum())"
    for name, said in (("it.npy", "2 (3, 4) 276.0"), ("it.csv", "2 (2, 2) 36.0"), ("it.npz", "1 (3, 3) 3.0")):
        with (tmp_path / name).open("rb") as stream:
            done = subprocess.run(
                [sys.executable, "-c", code], stdin=stream, capture_output=True, text=True, check=False
            )
        assert done.stdout.strip() == said, done.stderr


def test_specimens_are_read_whole_and_refused_or_answered_spoilt(tmp_path: Path) -> None:
    known = specimens()
    for each in known:
        (tmp_path / each.name).write_bytes(each.content)
        each.read(tmp_path / each.name)
    for case in range(50):
        _, kind, what = try_case(0, case, known, tmp_path)
        assert kind in ("answered", "refused"), what


@pytest.mark.parametrize("read", [read_json, read_toml])
def test_a_file_that_is_missing_is_named_once(tmp_path: Path, read: Callable[[Path], object]) -> None:
    with pytest.raises(InputError) as told:
        read(tmp_path / "none")
    assert str(told.value) == f"{tmp_path / 'none'}: there is no such file"


def test_a_mapped_file_gives_its_memory_back_and_reads_the_same_again(tmp_path):
    values = np.arange(1 << 20, dtype=np.int64)
    np.save(tmp_path / "many.npy", values)
    mapped = read_npy(tmp_path / "many.npy")
    view = mapped.reshape(4, -1)[1:]
    assert view.sum() == values[1 << 18 :].sum()
    let_go(view)
    assert view.sum() == values[1 << 18 :].sum()
    # What somebody may have written to stays.
    changed = np.memmap(tmp_path / "many.npy", np.int64, "c", 128)
    changed[:] = 7
    let_go(changed)
    assert (changed == 7).all()
    let_go(values)
