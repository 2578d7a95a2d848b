"""A file is written whole or not at all."""

from __future__ import annotations

import os
import re
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from varishold import InputError
from varishold.files import atomic_write, check_output


def test_bytes_and_text_arrive(tmp_path: Path) -> None:
    with atomic_write(tmp_path / "a.bin") as file:
        file.write(b"\x00\x01")
    with atomic_write(tmp_path / "a.txt", "w") as text:
        text.write("θ\r\n")
    assert (tmp_path / "a.bin").read_bytes() == b"\x00\x01"
    assert (tmp_path / "a.txt").read_bytes() == "θ\r\n".encode()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.bin", "a.txt"]


def test_what_was_written_can_be_read_again(tmp_path: Path) -> None:
    """HDF5 looks again at what it wrote in a file of tens of thousands of parts."""
    with atomic_write(tmp_path / "a") as file:
        file.write(b"abcdef")
        file.seek(2)
        assert file.read(3) == b"cde"
        file.write(b"!")
    assert (tmp_path / "a").read_bytes() == b"abcde!"


def test_a_block_that_raises_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), atomic_write(path, "w") as file:
        file.write(f"new {1 // 0}")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_nothing_is_seen_before_the_end(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    with atomic_write(path, "w") as file:
        file.write("new")
        file.flush()
        assert not path.exists()
        assert Path(file.name).read_text() == "new"
    assert path.read_text() == "new"


def test_permissions_follow_the_umask_or_the_file_that_is_replaced(tmp_path: Path) -> None:
    fresh, kept = tmp_path / "fresh", tmp_path / "kept"
    kept.write_text("x")
    kept.chmod(0o640)
    mask = os.umask(0o022)
    try:
        for path in (fresh, kept):
            with atomic_write(path) as file:
                file.write(b"y")
    finally:
        os.umask(mask)
    assert stat.S_IMODE(fresh.stat().st_mode) == 0o644
    assert stat.S_IMODE(kept.stat().st_mode) == 0o640


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    with atomic_write(tmp_path / "link", "w") as file:
        file.write("new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def test_a_device_is_written_directly() -> None:
    with atomic_write("/dev/null") as file:
        file.write(b"gone")
    assert not Path("/dev/null").is_file()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("absent/file", r"absent/file: cannot write here: there is no folder .*absent; make it first"),
        (".", "it is a folder; name a file"),
        ("x" * 300, "cannot write here: file name too long"),
        ("nul\0byte", "cannot write here: .*null"),
    ],
)
def test_a_place_that_cannot_be_written(tmp_path: Path, name: str, message: str) -> None:
    with pytest.raises(InputError, match=message), atomic_write(tmp_path / name) as file:
        file.write(b"")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("below", ["it", "deeper/it"])
def test_a_place_below_a_file_cannot_be_written(tmp_path: Path, below: str) -> None:
    file = tmp_path / "file"
    file.write_text("kept")
    said = re.escape(f"{file / below}: cannot write here: {file} is a file and no folder; name another")
    with pytest.raises(InputError, match=said), atomic_write(file / below):
        pass
    with pytest.raises(InputError, match=said):
        check_output(file / below, "page")
    assert file.read_text() == "kept"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="permission denied"), atomic_write(tmp_path / "a") as file:
        file.write(b"")


def test_a_full_disk_is_told_in_one_line() -> None:
    with pytest.raises(InputError, match="/dev/full: cannot write here: no space left"):  # noqa: SIM117
        with atomic_write("/dev/full") as file:
            file.write(b"x" * 100_000)


def test_an_error_of_the_callers_own_is_not_renamed(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_write(tmp_path / "a"):
        (tmp_path / "other").read_text()


def test_files_are_read_and_written_where_there_are_no_locks_of_whole_files(tmp_path: Path) -> None:
    """As on Windows: there is no module of locks, no opening that never waits, no mask of signals."""
    code = (
        "import os, signal, sys; sys.modules['fcntl'] = None; del os.O_NONBLOCK, signal.pthread_sigmask;"
        "from varishold.cli import main; main()"
    )
    report = tmp_path / "report.html"
    command = [sys.executable, "-c", code, "touch", "examples/surfaces.npz", "--report", str(report)]
    done = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert report.stat().st_size > 1000
