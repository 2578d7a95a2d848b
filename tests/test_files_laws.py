"""Laws of the ways in and out: parity with an independent reader, limits exact to the byte, nothing left behind."""

from __future__ import annotations

import errno
import io
import os
import re
import signal
import stat
import sys
import time
import zipfile
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from varishold.errors import FormatError, InputError
from varishold.files import (
    KINDS,
    archive_names,
    atomic_write,
    check_output,
    input_files,
    only_writer,
    open_archive,
    open_file,
    opening,
    parse_json,
    read_bytes,
    read_npy,
    read_toml,
    spread,
    text_chunks,
    workers,
    write_archive,
)
from varishold.files import archive as archives
from varishold.files.png import png_bytes

# Reading


@given(
    lines=st.lists(st.text(st.characters(exclude_categories=["Cs", "Cc"], exclude_characters="\u2028\u2029"))),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
    ended=st.booleans(),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-32"]),
    block=st.integers(1, 40),
)
def test_lines_are_those_of_the_whole_text(
    tmp_path_factory: pytest.TempPathFactory, lines: list[str], end: str, ended: bool, encoding: str, block: int
) -> None:
    text = end.join(lines) + end * ended
    if encoding.startswith("utf-8") and text.startswith("\ufeff"):
        return  # a mark, and no text
    path = tmp_path_factory.getbasetemp() / "lines.txt"
    path.write_bytes(text.encode(encoding))
    expected = re.split("\r\n|\r|\n", text)
    if not expected[-1]:
        expected.pop()
    got: list[str] = []
    for first, some in text_chunks(path, block=block):
        assert first == len(got) + 1
        assert some
        got += some
    assert got == expected


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "utf-32-le", "utf-32-be"])
def test_either_order_of_bytes_is_told_by_the_mark(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "it").write_bytes("\ufeffone\ntwo".encode(encoding))
    assert list(text_chunks(tmp_path / "it")) == [(1, ["one"]), (2, ["two"])]


def test_what_is_no_text_is_told_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "it"
    path.write_bytes(b"1\n2\n3\0")
    with pytest.raises(FormatError, match="is no text: a NUL byte stands in or after line 3"):
        list(text_chunks(path, block=4))


@pytest.mark.parametrize("end", ["", "\n"])
def test_the_longest_line_is_the_last_that_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: str) -> None:
    monkeypatch.setattr(opening, "_LONGEST_LINE", 8)
    path = tmp_path / "it"
    path.write_text("1\n" + "x" * 8 + end)
    assert [line for _, some in text_chunks(path) for line in some] == ["1", "x" * 8]
    path.write_text("1\n" + "x" * 9 + end)
    for block, line in ((2, 2), (100, 1)):
        with pytest.raises(FormatError, match=f"line {line} or one after it is longer than 8 characters"):
            list(text_chunks(path, block=block))


def test_a_file_of_just_so_many_bytes_is_read(tmp_path: Path) -> None:
    (tmp_path / "it").write_bytes(b"x" * (1 << 20))
    assert read_bytes(tmp_path / "it", most=1 << 20) == b"x" * (1 << 20)
    with pytest.raises(FormatError, match="is larger than 0 MiB"):
        read_bytes(tmp_path / "it", most=(1 << 20) - 1)


def test_standard_input_is_read_up_to_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opening, "LARGEST_BYTES", 8)
    read = opening._standard_input.__wrapped__
    for given_bytes in (b"x" * 8, b""):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(given_bytes)))
        assert read() == given_bytes
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"x" * 9)))
    with pytest.raises(InputError, match="more than 8 bytes on standard input"):
        read()
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(InputError, match="standard input is closed"):
        read()


def test_a_name_that_is_none_is_told() -> None:
    for name in ("a\0b", "\ud800"):
        with pytest.raises(InputError, match=r"is no file name|there is no such file"):
            open_file(name)


def nested(depth: int, opening: str, closing: str) -> str:
    return opening * depth + "1" + closing * depth


def test_sixty_four_levels_are_the_deepest(tmp_path: Path) -> None:
    for pair in (("[", "]"), ('{"a":', "}"), ('[{"a":', "}]")):
        levels = 2 if len(pair[1]) == 2 else 1
        parse_json(nested(64 // levels, *pair), where="it")
        with pytest.raises(FormatError, match="it: is nested deeper than 64 levels"):
            parse_json(nested(64 // levels + 1, *pair), where="it")
    path = tmp_path / "it.toml"
    path.write_text("a = " + nested(63, "[", "]"))
    assert list(read_toml(path)) == ["a"]
    path.write_text("a = " + nested(64, "[", "]"))
    with pytest.raises(FormatError, match=r"it\.toml: is nested deeper than 64 levels"):
        read_toml(path)
    assert parse_json("[" * 64 + "]" * 64, where="it")
    assert parse_json("3", where="it") == 3


def test_the_key_that_stands_twice_is_named() -> None:
    with pytest.raises(FormatError, match="key 'b' stands twice"):
        parse_json('{"a": 1, "b": 2, "c": 3, "b": 4}', where="it")
    with pytest.raises(FormatError) as told:
        parse_json('{{"{}": 1, "{}": 2}}'.format("k" * 500, "k" * 500), where="it")
    assert len(str(told.value)) < 110


# Archives

DTYPES = st.one_of(
    arrays.floating_dtypes(endianness="?"), arrays.integer_dtypes(endianness="?"), arrays.boolean_dtypes()
)


@given(array=arrays.arrays(DTYPES, arrays.array_shapes(min_dims=0, min_side=0)), fortran=st.booleans())
def test_an_array_comes_back_as_it_was(
    tmp_path_factory: pytest.TempPathFactory, array: np.ndarray, fortran: bool
) -> None:
    folder = tmp_path_factory.getbasetemp()
    array = np.array(array, order="F" if fortran else "C")
    np.save(folder / "it.npy", array)
    np.savez(folder / "numpy.npz", it=array)
    write_archive({"it": array}, folder / "ours.npz")
    with open_archive(folder / "numpy.npz") as theirs, open_archive(folder / "ours.npz") as ours:
        got = [read_npy(folder / "it.npy"), theirs.array("it"), ours.array("it")]
    got.append(np.load(folder / "ours.npz")["it"])
    for each in got:
        assert each.dtype == array.dtype
        np.testing.assert_array_equal(each, array)


def test_columns_first_from_standard_input_too(monkeypatch: pytest.MonkeyPatch) -> None:
    buffer = io.BytesIO()
    array = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    np.save(buffer, array)
    monkeypatch.setattr(opening, "_standard_input", buffer.getvalue)
    np.testing.assert_array_equal(read_npy("-"), array)


@given(texts=st.lists(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"))))
def test_a_text_comes_back_as_it_was(tmp_path_factory: pytest.TempPathFactory, texts: list[str]) -> None:
    path = tmp_path_factory.getbasetemp() / "texts.npz"
    array = np.array(texts, dtype=np.str_)
    write_archive({"it": array, "swapped": array.astype(array.dtype.newbyteorder())}, path)
    with open_archive(path) as archive:
        for name in archive.names:
            assert archive.array(name).tolist() == texts
            if len(texts) == 1:
                assert archive.text(name) == texts[0]
            else:
                with pytest.raises(FormatError, match=f"{name} must be one text, got .* of shape"):
                    archive.text(name)


def test_code_points_are_replaced_where_unicode_has_none_and_only_there() -> None:
    points = np.array([0xD7FF, 0xD800, 0xDFFF, 0xE000, 0x10FFFF, 0x110000], np.uint32)
    got = archives.possible_text(points.view("U6"))
    assert list(got[0]) == ["\ud7ff", "\ufffd", "\ufffd", "\ue000", "\U0010ffff", "\ufffd"]


def test_what_is_not_one_text_is_refused(tmp_path: Path) -> None:
    write_archive({"one": np.array(3.0), "two": np.array(["a", "b"]), "three": np.array(["a"])}, tmp_path / "it.npz")
    with open_archive(tmp_path / "it.npz") as archive:
        assert archive.unread == ("one", "two", "three")
        for name in ("one", "two"):
            with pytest.raises(FormatError, match=f"{name} must be one text"):
                archive.text(name)
        assert archive.text("three") == "a"
        assert archive.unread == ()
        with pytest.raises(FormatError, match="holds no array 'four'"):
            archive.array("four")


def test_what_nobody_has_asked_for_is_checked_all_the_same(tmp_path: Path) -> None:
    path = tmp_path / "it.npz"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("note.txt", "a" * 1000)
    content = path.read_bytes().replace(b"aaaa", b"abaa", 1)
    path.write_bytes(content)
    with pytest.raises(FormatError, match=r"member 'note\.txt': is damaged"), open_archive(path):
        pass


def test_an_archive_without_members_is_empty(tmp_path: Path) -> None:
    np.savez(tmp_path / "it.npz")
    with open_archive(tmp_path / "it.npz") as archive:
        assert archive.names == ()
    (tmp_path / "no.npz").write_bytes(b"PK\x03\x04" + b"\0" * 40)
    with (
        pytest.raises(FormatError, match="the list of its members, at its end, is missing"),
        open_archive(tmp_path / "no.npz"),
    ):
        pass
    assert archive_names(tmp_path / "no.npz") == archive_names(tmp_path / "absent.npz") == ()


@pytest.mark.parametrize("length", [0, 1, 65535])
def test_a_comment_of_any_length_is_allowed_and_what_follows_it_is_not(tmp_path: Path, length: int) -> None:
    path = tmp_path / "it.npz"
    with zipfile.ZipFile(path, "w") as made:
        made.comment = b"x" * length
        made.writestr("a.npy", b"")
    assert archive_names(path) == ("a",)
    path.write_bytes(path.read_bytes() + b"x")
    with pytest.raises(FormatError, match="is damaged or cut off"), open_archive(path):
        pass


def test_the_limits_of_an_archive_are_exact(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "it.npz"
    write_archive({"a": np.zeros(100), "b": np.ones(100)}, path)
    with zipfile.ZipFile(path) as known:
        unpacked = sum(info.file_size for info in known.infolist())
        packed = min(info.compress_size for info in known.infolist())
        listed = len(path.read_bytes()) - known.start_dir - 22 - len(known.comment)
    limits = {"_MOST_ARRAYS": 2, "_MOST_LISTED": listed, "LARGEST_BYTES": unpacked, "_BOMB_BYTES": unpacked // 2}
    monkeypatch.setattr(archives, "_BOMB_RATIO", 0)
    for name, most in limits.items():
        with monkeypatch.context() as changed:
            changed.setattr(archives, name, most)
            assert archive_names(path) == ("a", "b"), name
            changed.setattr(archives, name, most - 1)
            with pytest.raises(FormatError), open_archive(path):
                pass
    # However large, an array may be so many times as large as its packed bytes.
    monkeypatch.setattr(archives, "_BOMB_BYTES", 0)
    monkeypatch.setattr(archives, "_BOMB_RATIO", -(-unpacked // 2 // packed))
    assert archive_names(path) == ("a", "b")
    monkeypatch.setattr(archives, "_BOMB_RATIO", unpacked // 2 // packed - 1)
    assert archive_names(path) == ()


def test_small_archives_are_packed_and_large_ones_written_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archives, "_COMPRESSED_BYTES", 8000)
    for n, method in ((500, zipfile.ZIP_DEFLATED), (501, zipfile.ZIP_STORED)):
        write_archive({"a": np.zeros(n), "b": np.zeros(500)}, tmp_path / "it.npz", kind="toy")
        with zipfile.ZipFile(tmp_path / "it.npz") as made:
            assert {info.compress_type for info in made.infolist()} == {method}
            assert {info.date_time for info in made.infolist()} == {(1980, 1, 1, 0, 0, 0)}
            assert made.comment == b"varishold toy"
            assert made.namelist() == ["a.npy", "b.npy"]
    first = (tmp_path / "it.npz").read_bytes()
    write_archive({"a": np.zeros(501), "b": np.zeros(500)}, tmp_path / "it.npz", kind="toy")
    assert (tmp_path / "it.npz").read_bytes() == first


def test_what_numpy_would_unpickle_is_refused_both_ways(tmp_path: Path) -> None:
    np.savez(tmp_path / "it.npz", a=np.array([{}], dtype=object))
    np.save(tmp_path / "it.npy", np.array([{}], dtype=object))
    with pytest.raises(FormatError, match="holds pickled objects"), open_archive(tmp_path / "it.npz") as archive:
        archive.array("a")
    with pytest.raises(FormatError, match="holds pickled objects"):
        read_npy(tmp_path / "it.npy")
    with pytest.raises(ValueError, match=r"[Oo]bject"):
        write_archive({"a": np.array([{}], dtype=object)}, tmp_path / "new.npz")
    assert not (tmp_path / "new.npz").exists()


# Which files


def test_a_folder_stands_for_its_shown_files_and_below(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    there = [
        "b.csv",
        "a.CSV",
        "c.txt",
        ".hidden.csv",
        "in/d.csv",
        "in/.e.csv",
        ".git/f.csv",
        "in/deep/g.npz",
        "[1].csv",
    ]
    for name in there:
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).touch()
    assert input_files(["."], endings=[".csv"]) == ["[1].csv", "a.CSV", "b.csv", "in/d.csv"]
    assert input_files(["in"]) == ["in/d.csv", "in/deep/g.npz"]
    assert input_files(["./in/../in"]) == ["in/../in/d.csv", "in/../in/deep/g.npz"]
    assert input_files(["in", "in/d.csv", "-", "absent", "-"]) == ["in/d.csv", "in/deep/g.npz", "-", "absent"]
    assert input_files(["b.csv", "a.CSV"]) == ["b.csv", "a.CSV"]
    assert input_files(["*.csv"]) == ["[1].csv", "b.csv"]
    assert input_files(["**/*.npz"]) == ["in/deep/g.npz"]
    # A file may be named like a pattern.
    assert input_files(["[1].csv"]) == ["[1].csv"]
    with pytest.raises(InputError, match=r"in: is a folder without a file to read \(\.json, \.toml\)"):
        input_files(["in"], endings=[".json", ".toml"])
    Path("empty").mkdir()
    with pytest.raises(InputError, match=r"\(it is empty\)$"):
        input_files(["empty"])
    for name in ("a.PNG", "b.png", "notes", "c.x", "d.x", "e.x", "f.y", "g.z"):
        Path("empty", name).touch()
    with pytest.raises(InputError, match=r"\(\.csv\); it holds 3 \.x, 2 \.png, 1 [^,]+, 1 [^,]+$"):
        input_files(["empty"], endings=[".csv"])
    # What is hidden below the named folder is passed over; it may itself be hidden, or be in a hidden one.
    for name in (".far/in/a.csv", ".far/in/.b.csv", ".far/in/.c/d.csv"):
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).touch()
    for folder in (".far", ".far/in", "./.far/../.far/in"):
        assert input_files([folder], endings=[".csv"]) == [str(Path(folder, "in" * (folder == ".far"), "a.csv"))]
    for pattern in ("*.none", "empt*"):
        with pytest.raises(InputError, match="no file matches"):
            input_files([pattern])


# What may be written over

SAMPLES: dict[str, bytes] = {
    "page": b'<!doctype html>\n<html><meta name="generator" content="varishold">\n',
    "model": b'{"format":"varishold grasp model","version":1}',
    "source": b"/* Generated by varishold */\nint f(void);\n",
    "circuit": b"/* Generated by varishold: classifies 2 switches into 2 classes. */\n",
    "picture": png_bytes(np.zeros((2, 2, 3), np.uint8)),
    "grasps": b"object,size_m,seed,step,held,attempts,finger_scale,switch.a\n",
    "sensor": b"# Written by varishold.\n[sensor]\n",
} | {
    kind: b"PK\x05\x06" + b"\0" * 16 + len(comment).to_bytes(2, "little") + comment
    for kind, comment in (
        ("press", b"varishold press"),
        ("presses", b"varishold presses"),
        ("recording", b"varishold recording"),
        ("learned", b"varishold model"),
    )
}


def test_no_file_is_called_as_standard_input_is() -> None:
    for path in ("-", Path("-")):
        with pytest.raises(InputError, match=r"^-: a file is not written to standard output; name one$"):
            check_output(path, "model", force=True)


@pytest.mark.parametrize("kind", KINDS)
def test_only_its_own_kind_is_replaced_and_an_empty_file(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "it"
    check_output(path, kind)
    for other, content in SAMPLES.items():
        path.write_bytes(content)
        # Presses are recordings too.
        if other == kind or (kind == "recording" and other in ("press", "presses")):
            check_output(path, kind)
        else:
            with pytest.raises(InputError, match=f"is there, and is no {KINDS[kind].title}") as told:
                check_output(path, kind)
            assert told.value.parameter == "force"
            check_output(path, kind, force=True)
    path.write_bytes(b"")
    check_output(path, kind)
    # What was measured cannot be made again: no file is its own kind.
    path.write_bytes(b" " + SAMPLES.get(kind, b"PK"))
    assert not KINDS[kind].recognizes(path)


def test_a_mark_stands_near_the_start_or_near_the_end(tmp_path: Path) -> None:
    path = tmp_path / "it"
    for size in (0, 3000, 100_000):
        path.write_bytes(b"PK" + b"\0" * size + b"varishold press")
        assert KINDS["press"].recognizes(path)
        path.write_bytes(b"%PDF" + b"\0" * size + b"varishold" + b"\0" * size)
        assert KINDS["picture"].recognizes(path) == (size < 100_000)


def test_no_input_is_written_over_by_whatever_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a").touch()
    Path("b").touch()
    Path("link").symlink_to("a")
    os.link("a", "hard")
    for output in ("a", "./a", tmp_path / "a", "link", "hard"):
        for force in (False, True):
            with pytest.raises(InputError, match="is read by this very call"):
                check_output(output, "page", inputs=["b", "a"], force=force)
    check_output("b", "page", inputs=["a", "absent", "a\0"])
    check_output("new", "page", inputs=["a", "new"])
    with open("a", "rb") as stream:
        kept = os.dup(0)
        try:
            os.dup2(stream.fileno(), 0)
            with pytest.raises(InputError, match="is read by this very call"):
                check_output("a", "page", inputs=["-"])
            check_output("b", "page", inputs=["-"])
        finally:
            os.dup2(kept, 0)
            os.close(kept)


def test_places_that_cannot_be_written_are_told_beforehand(tmp_path: Path) -> None:
    for path, message in (
        (tmp_path / "absent" / "it", "there is no folder .*absent; make it first"),
        (tmp_path, "it is a folder; name a file in it, or what is not there yet"),
        (f"{tmp_path}/a\0b", "is no file name"),
    ):
        with pytest.raises(InputError, match=message):
            check_output(path, "page", force=True)
    check_output("/dev/null", "page")
    os.mkfifo(tmp_path / "pipe")
    check_output(tmp_path / "pipe", "page")


def test_a_folder_that_may_not_be_written_is_told_beforehand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "absent" / "it")
    with pytest.raises(InputError, match=r"there is no folder .*absent; make it first"):
        check_output(tmp_path / "link", "page")
    (tmp_path / "link").unlink()
    check_output(tmp_path / "it", "page")
    # Nothing stays of the trial.
    assert not list(tmp_path.iterdir())

    # To root nothing is forbidden.
    def refuse(path: Path, *_: Any, **__: Any) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(InputError, match="it: cannot write here: permission denied"):
        check_output(tmp_path / "it", "page")
    assert not list(tmp_path.iterdir())


# Pictures


@given(pixels=arrays.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9), st.just(3))))
def test_another_reader_sees_the_same_picture(pixels: np.ndarray) -> None:
    seen = cv2.imdecode(np.frombuffer(png_bytes(pixels), np.uint8), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(seen[..., ::-1], pixels)
    assert png_bytes(pixels) == png_bytes(pixels.copy())


@given(
    places=arrays.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 3)),
    palette=st.binary(min_size=12, max_size=12),
    opacity=st.binary(min_size=1, max_size=4),
)
def test_another_reader_sees_the_same_colours_and_opacity(places: np.ndarray, palette: bytes, opacity: bytes) -> None:
    picture = png_bytes(places, palette=palette, transparency=opacity)
    seen = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_UNCHANGED)
    colours = np.frombuffer(palette, np.uint8).reshape(4, 3)
    alpha = np.frombuffer(opacity.ljust(4, b"\xff"), np.uint8)
    np.testing.assert_array_equal(seen[..., 2::-1], colours[places])
    np.testing.assert_array_equal(seen[..., 3], alpha[places])


def test_a_picture_with_a_palette_is_no_larger_than_it_need_be() -> None:
    plain = np.tile(np.arange(200, dtype=np.uint8), (200, 1))
    # Every line is the one above: the differences are zero.
    assert len(png_bytes(np.repeat(plain[..., None], 3, axis=2))) < 2000
    assert b"Software\0varishold" in png_bytes(np.repeat(plain[..., None], 3, axis=2))
    assert b"Software" not in png_bytes(plain, palette=bytes(768))


# Writers and workers


def test_a_file_has_one_writer_and_no_trace_of_it_stays(tmp_path: Path) -> None:
    path, link = tmp_path / "it.csv", tmp_path / "link.csv"
    link.symlink_to(path)
    for first, second in ((path, path), (path, link), (link, path)):
        with only_writer(first):
            with pytest.raises(InputError, match="another process is writing this file"), only_writer(second):
                pass
            with only_writer(tmp_path / "other.csv"):
                assert len(list(tmp_path.glob(".*.lock"))) == 2
            assert len(list(tmp_path.glob(".*.lock"))) == 1
        assert sorted(p.name for p in tmp_path.iterdir()) == ["link.csv"]
    with pytest.raises(ZeroDivisionError), only_writer(path):
        raise ZeroDivisionError
    with only_writer(path):
        pass
    with (
        pytest.raises(InputError, match="it: cannot write here: no such file or directory"),
        only_writer(tmp_path / "absent" / "it"),
    ):
        pass


def test_what_a_dead_writer_left_is_no_lock(tmp_path: Path) -> None:
    with only_writer(tmp_path / "it"):
        lock = next(tmp_path.glob(".*.lock"))
    lock.touch()
    with only_writer(tmp_path / "it"):
        assert lock.exists()
    assert not lock.exists()


def test_one_who_waited_for_a_lock_that_is_gone_takes_a_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between opening and locking another writer may end and remove the file: then that lock holds nothing."""
    from varishold.files import resume

    lock_it, opened = resume.lock, []

    def lock(handle: int, *, wait: bool) -> None:
        opened.append(handle)
        if len(opened) == 1:
            next(tmp_path.glob(".*.lock")).unlink()
        lock_it(handle, wait=wait)

    monkeypatch.setattr(resume, "lock", lock)
    before = len(os.listdir("/proc/self/fd"))
    with only_writer(tmp_path / "it"):
        assert len(opened) == 2
        assert list(tmp_path.glob(".*.lock"))
        with pytest.raises(InputError, match="another process"), only_writer(tmp_path / "it"):
            pass
    assert len(os.listdir("/proc/self/fd")) == before


def _half_of_all(n: int) -> float:
    return n / 2


def _never_zero(n: int) -> float:
    return 6 / n


@pytest.mark.parametrize(("processes", "chunk"), [(1, 1), (2, 1), (2, 3)])
def test_spread_work_comes_back_in_order(processes: int, chunk: int) -> None:
    assert list(spread(_half_of_all, range(7), processes=processes, chunk=chunk)) == [n / 2 for n in range(7)]
    got = spread(_never_zero, [3, 2, 0], processes=processes, chunk=1)
    assert (next(got), next(got)) == (2.0, 3.0)
    with pytest.raises(ZeroDivisionError):
        next(got)


def _own_process(_: int) -> int:
    return os.getpid()


def test_one_process_is_this_one_and_two_are_others() -> None:
    assert set(spread(_own_process, [0, 1], processes=1)) == {os.getpid()}
    others = set(spread(_own_process, [0, 1, 2], processes=2))
    assert os.getpid() not in others
    for process in others:
        with pytest.raises(ProcessLookupError):
            os.kill(process, 0)


def _slow(n: int) -> int:
    time.sleep(600 * (n > 0))
    return os.getpid()


def test_who_stops_asking_ends_the_workers_at_once() -> None:
    began = time.monotonic()
    work = spread(_slow, [0, 1, 1], processes=2)
    worker = next(work)
    work.close()
    assert time.monotonic() - began < 60
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)


def test_a_worker_ends_with_the_one_that_started_it() -> None:
    listening, held = get_context("spawn").Pipe(duplex=False)
    child = os.fork()
    if child == 0:
        held.close()
        workers.end_with(listening)
        time.sleep(60)
        os._exit(7)
    try:
        time.sleep(0.05)
        assert os.waitpid(child, os.WNOHANG) == (0, 0)
        held.close()
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1
    finally:
        listening.close()


def test_ctrl_c_is_heard_afterwards_and_everything_is_as_it_was(request: pytest.FixtureRequest) -> None:
    # Who starts the tests in the background has Ctrl-C ignored.
    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, usual))
    handler, mask = signal.getsignal(signal.SIGINT), signal.pthread_sigmask(signal.SIG_BLOCK, ())
    done = False
    with pytest.raises(KeyboardInterrupt):  # noqa: PT012
        with workers.interrupted_afterwards():
            assert signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())
            # To another thread, as it were: one that does not mask it.
            signal.getsignal(signal.SIGINT)(signal.SIGINT, None)  # type: ignore[operator, misc]
            done = True
        pytest.fail("nobody heard")
    assert done
    with pytest.raises(KeyboardInterrupt):  # noqa: SIM117
        with workers.interrupted_afterwards():
            os.kill(os.getpid(), signal.SIGINT)
    with workers.interrupted_afterwards():
        pass
    assert signal.getsignal(signal.SIGINT) is handler
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == mask


# Writing whole files


def test_what_writers_that_were_killed_left_is_swept_and_what_is_being_written_is_not(tmp_path: Path) -> None:
    left, foreign = tmp_path / ".varishold-0123.part", [tmp_path / ".varishold-x", tmp_path / "x.part"]
    for path in (left, *foreign):
        path.touch()
    # Two in one folder, as two processes might: the second sweeps when the first is half written.
    from varishold.files import writing

    with atomic_write(tmp_path / "a") as first:
        first.write(b"a")
        assert not left.exists()
        writing._sweep.__wrapped__(tmp_path)
        with atomic_write(tmp_path / "b") as second:
            second.write(b"b")
    assert sorted(p.name for p in tmp_path.iterdir()) == [".varishold-x", "a", "b", "x.part"]


def test_a_folder_goes_with_its_block_or_with_the_next_writer(tmp_path: Path) -> None:
    from varishold.files import writing
    from varishold.files.writing import folder_beside

    # Two that were killed: the mark of the one is there no more, so nobody knows whose folder it is.
    for name in ("a", "b"):
        folder = tmp_path / f".varishold-{name}"
        folder.mkdir()
        (folder / "much").write_bytes(b"much")
    (tmp_path / ".varishold-a.part").touch()
    with folder_beside(tmp_path / "it") as mine:
        assert sorted(p.name for p in tmp_path.iterdir()) == sorted([".varishold-b", mine.name, f"{mine.name}.part"])
        assert list(mine.iterdir()) == []
        # Another process looks for what was left.
        writing._sweep.__wrapped__(tmp_path)
        (mine / "made").write_text("made")
        with folder_beside(mine / "made") as inner:
            (inner / "made").write_text("again")
            (inner / "made").replace(mine / "made")
        assert [p.name for p in mine.iterdir()] == ["made"]
        (mine / "made").replace(tmp_path / "it")
    assert sorted(p.name for p in tmp_path.iterdir()) == [".varishold-b", "it"]
    assert (tmp_path / "it").read_text() == "again"
    with pytest.raises(RuntimeError, match="mine"), folder_beside(tmp_path / "it"):
        raise RuntimeError("mine")
    assert sorted(p.name for p in tmp_path.iterdir()) == [".varishold-b", "it"]
    with pytest.raises(FileNotFoundError), folder_beside(tmp_path / "nowhere" / "it"):
        pass


def test_one_whose_file_was_swept_before_it_was_locked_takes_a_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from varishold.files import writing

    lock_it, locked = writing.lock, []

    def lock(handle: int, *, wait: bool) -> None:
        locked.append(handle)
        if len(locked) == 1:
            next(tmp_path.glob(".varishold-*")).unlink()
        lock_it(handle, wait=wait)

    monkeypatch.setattr(writing, "lock", lock)
    with atomic_write(tmp_path / "it", "w") as file:
        file.write("\ud800 half a pair")
    assert (tmp_path / "it").read_text() == "\\ud800 half a pair"
    assert len(locked) == 2


def test_a_failing_disk_and_a_failing_caller_are_told_apart(tmp_path: Path) -> None:
    failures: list[tuple[OSError, type[Exception]]] = [
        (OSError(code, "x"), InputError) for code in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
    ]
    failures.append((PermissionError(errno.EACCES, "x", "other"), PermissionError))
    for error, expected in failures:
        with pytest.raises(expected), atomic_write(tmp_path / "it"):
            raise error
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="cannot write here"), atomic_write(tmp_path / "it") as file:
        raise PermissionError(errno.EACCES, "x", file.name)


def test_a_pipe_is_written_as_it_comes(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    with pytest.raises(ZeroDivisionError), atomic_write(pipe) as file:  # noqa: PT012
        file.write(b"so far")
        raise ZeroDivisionError
    assert os.read(reader, 100) == b"so far"
    os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
