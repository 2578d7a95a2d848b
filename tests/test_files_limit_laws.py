"""Limits as they are told to users, to the byte; marks of every kind of file; when a growing file reaches the disk."""

from __future__ import annotations

import errno
import os
import re
import threading
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np
import pytest

from varishold.errors import FormatError, InputError
from varishold.files import (
    KINDS,
    LARGEST_BYTES,
    archive_names,
    atomic_write,
    damage_told,
    growing,
    growing_file,
    open_archive,
    opening,
    parse_json,
    read_json,
    read_toml,
    text_chunks,
    write_archive,
    write_texts,
    writing,
)
from varishold.files.inputs import input_files
from varishold.files.locking import lock
from varishold.files.png import png_bytes


def test_a_line_of_two_to_the_24_characters_is_read_and_none_longer(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    path.write_bytes(b"1\n" + b"x" * (1 << 24) + b"\n2\n")
    assert [len(line) for _, lines in text_chunks(path) for line in lines] == [1, 1 << 24, 1]
    path.write_bytes(b"1\n" + b"x" * ((1 << 24) + 1) + b"\n2\n")
    with pytest.raises(FormatError, match=r"longer than 16777216 characters"):
        list(text_chunks(path))


def test_a_million_frames_of_256_taxels_are_half_of_what_is_taken_into_memory() -> None:
    assert 0.45 < 10**6 * 256 * 8 / LARGEST_BYTES < 0.5


def test_a_toml_file_has_a_mebibyte_at_most(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"a = 1\n#" + b"x" * ((1 << 20) - 7))
    assert read_toml(path) == {"a": 1}
    path.write_bytes(path.read_bytes() + b"x")
    with pytest.raises(FormatError, match="is larger than 1 MiB; such a file is never so large"):
        read_toml(path)


@pytest.mark.parametrize(("read", "mebibytes"), [(read_json, 1024), (read_toml, 1)])
def test_documents_have_so_many_mebibytes_at_most(
    monkeypatch: pytest.MonkeyPatch, read: Callable[[str], object], mebibytes: int
) -> None:
    # A file without end: it holds as many bytes as are asked for.
    monkeypatch.setattr(opening, "open_file", lambda path: nullcontext(SimpleNamespace(read=range)))
    with pytest.raises(FormatError, match=rf"^endless: is larger than {mebibytes} MiB; such a file is never so large$"):
        read("endless")


@pytest.mark.parametrize(("length", "fine"), [(1090, True), (1200, False)])
def test_the_list_of_an_archives_members_has_a_mebibyte_at_most(tmp_path: Path, length: int, fine: bool) -> None:
    # Each stands in it with 46 bytes, its name and its ending.
    write_archive({f"{k:0{length}}": np.zeros(1, np.uint8) for k in range(900)}, tmp_path / "a.npz")
    assert (900 * (46 + length + 4) <= 1 << 20) == fine
    assert len(archive_names(tmp_path / "a.npz")) == 900 * fine


def test_nothing_is_swept_that_is_being_written_and_no_writer_waits_for_another(tmp_path: Path) -> None:
    with atomic_write(tmp_path / "a") as one, atomic_write(tmp_path / "a") as other:
        one.write(b"1")
        other.write(b"2")
        assert len(list(tmp_path.iterdir())) == 2
        for file in (one, other):
            with open(file.name, "rb") as again, pytest.raises(BlockingIOError):
                lock(again.fileno(), wait=False)
    # Who ends last has written it.
    assert (tmp_path / "a").read_bytes() == b"1"


def test_whole_numbers_have_ten_thousand_bits_at_most(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    for bits, fine in ((10_000, True), (10_001, False)):
        path.write_text(f"a = [[{hex(2**bits - 1)}]]\n")
        if fine:
            assert read_toml(path) == {"a": [[2**bits - 1]]}
        else:
            with pytest.raises(FormatError, match="holds an integer of thousands of digits"):
                read_toml(path)
    assert parse_json("1" * 3000, where="it") == int("1" * 3000)
    with pytest.raises(FormatError, match=r"^it: holds an integer of thousands of digits$"):
        parse_json("[" + "1" * 4000 + "]", where="it")


def test_a_thousand_arrays_are_read_and_sixty_four_mebibytes_are_packed(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    for n in (1000, 1001):
        write_archive({f"a{k}": np.zeros(1, np.uint8) for k in range(n)}, path)
        if n == 1000:
            assert len(archive_names(path)) == n
            continue
        with pytest.raises(FormatError, match="holds 1001 arrays; at most 1000 are read"), open_archive(path):
            pass
    for more, method in ((0, zipfile.ZIP_DEFLATED), (1, zipfile.ZIP_STORED)):
        write_archive({"a": np.zeros((1 << 26) - 5 + more, np.uint8), "b": np.zeros(5, np.uint8)}, path)
        with zipfile.ZipFile(path) as made:
            assert {info.compress_type for info in made.infolist()} == {method}


def test_what_is_wrong_is_told_in_two_hundred_characters_of_one_line() -> None:
    for raised, told in (
        (ValueError("a\n  b\tc"), "a b c"),
        (KeyError(), "KeyError"),
        (EOFError("x" * 300), "x" * 200),
        (OSError("no"), "no"),
    ):
        with pytest.raises(FormatError) as caught, damage_told("it"):
            raise raised
        assert str(caught.value) == f"it: is damaged or cut off: {told}"
    with pytest.raises(InputError, match=r"^mine$"), damage_told("it"):
        raise InputError("mine")
    with pytest.raises(ZeroDivisionError), damage_told("it"):
        raise ZeroDivisionError


MARKS = [
    ("recording", b"\x89MCAP0\r\n\x01" + b"\0" * 12 + b"ros2" + b"\0" * 4 + b"varishold 1", True),
    ("recording", b"\x89MCAP0\r\n\x01" + b"\0" * 11 + b"ros2" + b"\0" * 4 + b"varishold 1", False),
    ("recording", b"\x89MCAP0\r\n\x01" + b"\0" * 12 + b"ros2" + b"\0" * 4 + b"another 1", False),
    ("recording", b"\x89HDF\r\n" + b"\0" * 900 + b"varishold", True),
    ("recording", b"MATLAB 7.3 MAT-file" + b" " * 490 + b"\x89HDF\r\n" + b"\0" * 9 + b"varishold", True),
    ("recording", b"MATLAB 5.0 MAT-file varishold", False),
    ("recording", b"PAR1" + b"\0" * 9000 + b"varishold recording" + b"\0" * 40 + b"PAR1", True),
    ("recording", b"PAR1" + b"\0" * 90 + b"varishold table" + b"\0" * 40 + b"PAR1", False),
    ("table", b"PAR1" + b"\0" * 90 + b"varishold table" + b"\0" * 40 + b"PAR1", True),
    ("press", b"PK" + b"\0" * 90 + b"varishold press", True),
    ("press", b"PK" + b"\0" * 90 + b"varishold presses", False),
    ("press", b"PK" + b"\0" * 90 + b"varishold press ", False),
    ("presses", b"PK" + b"\0" * 90 + b"varishold presses", True),
    ("learned", b"PK" + b"\0" * 90 + b"varishold model", True),
    ("source", b"# Generated by varishold", True),
    ("source", b"<!-- Generated by varishold -->", True),
    ("source", b"/* Generated by varishold: it", False),
    ("source", b"/* Generated by varishold. No", False),
    ("source", b"% Generated by varishold", False),
    ("circuit", b"// Generated by varishold: it", True),
    ("circuit", b"/* Generated by varishold. No allocation", True),
    ("circuit", b"/* Generated by varishold. */", False),
    ("circuit", b'{\n "format": "varishold-netlist",', True),
    ("circuit", b"00ff\n1_x0\n", True),
    ("circuit", b"00fg\n", False),
    ("picture", b"<?xml version='1.0'?><!-- varishold -->", True),
    ("picture", b"<svg>varishold</svg>", False),
    ("picture", b"%PDF-1.4 (varishold)", True),
    ("picture", png_bytes(np.zeros((1, 1, 3), np.uint8)), True),
    ("sensor", b"# made by varishold.calibration\n", True),
    ("sensor", b"# made by hand\nvarishold.\n", False),
    ("grasps", b"object,size_m,seed,step,held,attempts,finger_scale,more", True),
    ("grasps", b" object,size_m,seed,step,held,attempts,finger_scale,more", False),
    ("page", b'<!doctype html><head><meta name="generator" content="varishold"></head>', True),
    ("page", b'<!doctype html><head><meta name="generator" content="others"></head>', False),
    ("model", b'{"format":"varishold grasp model","version":1', True),
    ("model", b'{"format": "varishold grasp model"', False),
    ("measurement", b"1,2,3\n", False),
    ("measurement", b"", True),
]


@pytest.mark.parametrize(("kind", "content", "known"), MARKS)
def test_a_kind_is_known_by_its_mark(tmp_path: Path, kind: str, content: bytes, known: bool) -> None:
    (tmp_path / "it").write_bytes(content)
    assert KINDS[kind].recognizes(tmp_path / "it") == known
    if known and content:
        others = {name for name, other in KINDS.items() if other.recognizes(tmp_path / "it")}
        # Presses are recordings too.
        assert others == {kind, *(["recording"] if kind in ("press", "presses") else [])}


# Files that grow


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """A clock that stands still, and a list of when the disk was asked."""
    here = SimpleNamespace(now=100.0, synced=[])
    monkeypatch.setattr(growing, "time", SimpleNamespace(monotonic=lambda: here.now))
    monkeypatch.setattr(growing.os, "fsync", lambda handle: here.synced.append(here.now))
    return here


def test_the_disk_is_asked_every_two_seconds_where_something_was_written(
    tmp_path: Path, clock: SimpleNamespace
) -> None:
    with growing_file(tmp_path / "a.bin") as file:
        for now, synced in (
            (100.0, []),
            (101.99, []),
            (102.0, [102.0]),
            (103.0, [102.0]),
            (103.99, [102.0]),
            (110.0, [102.0, 110.0]),
            (110.5, [102.0, 110.0]),
        ):
            clock.now = now
            file.write(b"x")
            file._drain()
            assert clock.synced == synced
        assert not file.shown
        assert not (tmp_path / "a.bin").exists()
        file.show()
        assert file.shown
        assert (tmp_path / "a.bin").read_bytes() == b"x" * 7
    # What was written last reaches it at the end; nothing does twice.
    assert clock.synced == [102.0, 110.0, 110.5]


def test_who_writes_waits_once_too_much_waits_for_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(growing, "_MOST_WAITING", 10)
    monkeypatch.setattr(growing, "_SYNC_S", 0.0)
    asked, go_on = threading.Event(), threading.Event()
    monkeypatch.setattr(growing.os, "fsync", lambda handle: (asked.set(), go_on.wait(60)))
    with growing_file(tmp_path / "a.bin") as file:
        file.show()
        assert file.write(b"abc") == 3
        assert asked.wait(60)
        # Three are on their way; six more are nine, and the next may come; then there are more than ten.
        assert file.write(b"defghi") == 6
        assert file.write(b"jk") == 2
        assert file.tell() == 11
        late = threading.Thread(target=lambda: file.write(b"l"))
        late.start()
        late.join(0.2)
        assert late.is_alive()
        assert file.tell() == 11
        go_on.set()
        late.join(60)
        assert file.tell() == 12
    assert (tmp_path / "a.bin").read_bytes() == b"abcdefghijkl"


# Writing and naming


def test_a_file_that_is_not_complete_yet_is_hidden_beside_its_place(tmp_path: Path) -> None:
    for mode, text in (("w", "one\r\ntwo\ud800\n"), ("wb", b"\0\xff")):
        with atomic_write(tmp_path / "it", mode) as file:
            assert re.fullmatch(r"\.varishold-[0-9a-f]{16}\.part", Path(file.name).name)
            assert Path(file.name).parent == tmp_path
            file.write(text)
        assert [path.name for path in tmp_path.iterdir()] == ["it"]
        kept = text if isinstance(text, bytes) else b"one\r\ntwo\\ud800\n"
        assert (tmp_path / "it").read_bytes() == kept


def test_texts_are_written_together_or_refused_before_the_first(tmp_path: Path) -> None:
    asked: list[Path] = []
    folder = tmp_path / "new" / "deep"
    made = write_texts(folder, {"a": "1", "b": "2"}, check=asked.append)
    assert made == asked == [folder / "a", folder / "b"]
    assert [path.read_text() for path in made] == ["1", "2"]

    def refuse(path: Path) -> None:
        if path.name == "b":
            raise InputError("not this one")

    with pytest.raises(InputError, match="not this one"):
        write_texts(folder, {"a": "3", "b": "4"}, check=refuse)
    assert (folder / "a").read_text() == "1"
    with pytest.raises(InputError, match="cannot be made a folder: "):
        write_texts(folder / "a", {"c": "5"})


def test_names_with_endings_are_taken_from_folders_whatever_their_case(tmp_path: Path) -> None:
    for name in ("b.CSV", "a.csv", "c.txt", ".hidden.csv", "sub/d.csv", ".git/e.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    found = [str(Path(path).relative_to(tmp_path)) for path in input_files([tmp_path], endings=[".csv"])]
    assert found == ["a.csv", "b.CSV", "sub/d.csv"]
    assert len(input_files([tmp_path])) == 4


OLD, NEW = {name: f"old {name}" for name in "abcd"}, {name: f"new {name}" for name in "abcde"}


def standing(folder: Path) -> dict[str, str]:
    """Return what stands in a folder for somebody who looks, and see that nothing else is left there."""
    return {path.name: path.read_text() for path in folder.iterdir()}


@pytest.mark.parametrize("stops", range(5))
def test_texts_that_a_stop_leaves_are_all_old_or_new_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stops: int
) -> None:
    write_texts(tmp_path, OLD)
    replace, moved = os.replace, []

    def stopped(written: Path, target: Path) -> None:
        if len(moved) == stops:
            raise KeyboardInterrupt
        moved.append(target)
        replace(written, target)

    monkeypatch.setattr(os, "replace", stopped)
    with pytest.raises(KeyboardInterrupt):
        write_texts(tmp_path, NEW)
    monkeypatch.undo()
    left = standing(tmp_path)
    assert len(left) == stops
    assert left.items() <= NEW.items()
    write_texts(tmp_path, NEW)
    assert standing(tmp_path) == NEW


@pytest.mark.parametrize("full", range(5))
def test_texts_for_which_there_is_no_room_leave_the_old_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, full: int
) -> None:
    write_texts(tmp_path, OLD)
    begun = []

    @contextmanager
    def filled(path: Path, mode: Literal["w"]) -> Iterator[Any]:
        with atomic_write(path, mode) as handle:
            begun.append(path)
            if len(begun) > full:
                raise OSError(errno.ENOSPC, "no room")
            yield handle

    monkeypatch.setattr(writing, "atomic_write", filled)
    with pytest.raises(InputError, match=r"cannot write here: no room"):
        write_texts(tmp_path, NEW)
    assert standing(tmp_path) == OLD


def test_texts_keep_permissions_follow_links_and_go_into_pipes(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "elsewhere").write_text("old")
    (tmp_path / "out" / "a").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "out" / "b").symlink_to("/dev/null")
    (tmp_path / "out" / "c").write_text("old")
    (tmp_path / "out" / "c").chmod(0o640)
    write_texts(tmp_path / "out", {"a": "1", "b": "2", "c": "3"})
    assert (tmp_path / "elsewhere").read_text() == "1"
    assert (tmp_path / "out" / "b").is_char_device()
    assert ((tmp_path / "out" / "c").read_text(), (tmp_path / "out" / "c").stat().st_mode & 0o777) == ("3", 0o640)
