"""A growing file: never in its writer's way, there from its first bytes on, and never more than one writer's."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest
from tests.live_scripted import wait_until

from varishold.errors import InputError
from varishold.files import growing, growing_file


def test_nothing_is_there_before_it_is_shown_and_all_of_it_after(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"an earlier one")
    with growing_file(path) as file:
        assert file.write(b"first ") == 6
        assert path.read_bytes() == b"an earlier one"
        file.show()
        assert path.read_bytes() == b"first "
        file.write(b"second")
        wait_until(lambda: path.read_bytes() == b"first second")
        assert file.tell() == 12
    assert path.read_bytes() == b"first second"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.bin"]


def test_what_was_never_shown_leaves_nothing(tmp_path: Path) -> None:
    with growing_file(tmp_path / "a.bin") as file:
        file.write(b"some")
    assert list(tmp_path.iterdir()) == []


def test_what_was_shown_stays_where_its_writer_fails(tmp_path: Path) -> None:
    def fail() -> None:
        with growing_file(tmp_path / "a.bin") as file:
            file.write(b"some")
            file.show()
            file.write(b" more")
            raise KeyError("something")

    with pytest.raises(KeyError):
        fail()
    assert (tmp_path / "a.bin").read_bytes() == b"some more"


def test_a_second_writer_is_kept_away(tmp_path: Path) -> None:
    with (
        growing_file(tmp_path / "a.bin"),
        pytest.raises(InputError, match="another process is writing this file"),
        growing_file(tmp_path / "a.bin"),
    ):
        pass


def test_threads_end_with_it(tmp_path: Path) -> None:
    before = threading.active_count()
    with growing_file(tmp_path / "a.bin") as file:
        file.write(bytes(1 << 20))
        assert threading.active_count() == before + 1
    assert threading.active_count() == before


@pytest.mark.parametrize(("name", "told"), [("", "it is a folder"), ("no/where", "there is no folder")])
def test_where_nothing_can_be_written(tmp_path: Path, name: str, told: str) -> None:
    with pytest.raises(InputError, match=told), growing_file(tmp_path / name):
        pass


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="takes a device that is always full")
def test_a_full_disk_is_told_in_one_line() -> None:
    def fill() -> None:
        with growing_file("/dev/full") as file:
            for _ in range(10_000):
                file.write(bytes(1000))

    with pytest.raises(InputError, match=r"^/dev/full: cannot write here: no space left on device$"):
        fill()


def test_a_disk_that_takes_long_delays_nobody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def slow(handle: int) -> None:
        begun.set()
        assert go_on.wait(60)

    monkeypatch.setattr(growing, "_SYNC_S", 0.0)
    monkeypatch.setattr(growing.os, "fsync", slow)
    with growing_file(tmp_path / "a.bin") as file:
        file.write(b"0")
        assert begun.wait(60)
        for k in range(1, 1000):
            file.write(b"%d" % (k % 10))
        assert file.tell() == 1000
        go_on.set()
        file.show()
    assert (tmp_path / "a.bin").read_bytes() == b"0123456789" * 100


@pytest.mark.skipif(os.name == "nt", reason="takes a system that lets go of files that are open")
@pytest.mark.parametrize("how", ["removed", "moved", "replaced", "with its folder"])
def test_a_file_that_is_taken_away_while_it_grows_is_told(tmp_path: Path, how: str) -> None:
    folder = tmp_path / "of it"
    folder.mkdir()
    path = folder / "a.bin"

    def grow() -> None:
        with growing_file(path) as file:
            file.write(b"some")
            file.show()
            if how == "with its folder":
                folder.rename(tmp_path / "elsewhere")
            elif how == "moved":
                path.rename(folder / "b.bin")
            else:
                path.unlink()
            if how == "replaced":
                path.write_bytes(b"somebody else's")
            file.write(b" more")

    with pytest.raises(InputError, match=r"a\.bin: was moved, replaced or removed while it was written"):
        grow()
    if how == "replaced":
        assert path.read_bytes() == b"somebody else's"


@pytest.mark.skipif(os.name == "nt", reason="takes a system that lets go of files that are open")
def test_it_is_told_while_it_grows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(growing, "_SYNC_S", 0.0)

    def grow() -> None:
        with growing_file(tmp_path / "a.bin") as file:
            file.show()
            (tmp_path / "a.bin").unlink()
            wait_until(lambda: file.write(b"more") == 0)

    with pytest.raises(InputError, match="was moved, replaced or removed"):
        grow()
