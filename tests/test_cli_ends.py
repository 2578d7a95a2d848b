"""How the program ends: by Ctrl-C, by a closed pipe, and where nothing can be written but the output."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import varishold

PROGRAM = (sys.executable, "-c", "from varishold.cli import main; main()")
SURFACES = Path(__file__).parents[1] / "examples" / "surfaces.npz"


@pytest.mark.parametrize(
    ("number", "after_s", "times"),
    [
        (signal.SIGINT, 0.0, 1),
        (signal.SIGINT, 1.0, 1),
        (signal.SIGINT, 2.0, 2),
        (signal.SIGTERM, 1.0, 1),
        (signal.SIGHUP, 1.0, 1),
    ],
)
def test_what_asks_to_end_is_heard_and_told_in_one_line(
    tmp_path: Path, number: int, after_s: float, times: int
) -> None:
    words = ("skin", "collect", "--count", "100000", "--processes", "2", "-o", str(tmp_path / "p.npz"))
    process = subprocess.Popen(
        [*PROGRAM, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A shell's background job ignores Ctrl-C, and so would all that it starts.
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),
    )
    # It has begun when something stands in its folder.
    until = time.monotonic() + 120
    while not any(tmp_path.iterdir()) and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(after_s)
    # A terminal tells all that it runs of Ctrl-C; ``kill`` tells one process.
    for _ in range(times):
        (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
        time.sleep(0.01)
    out, told = process.communicate(timeout=120)
    assert (process.returncode, out, told) == (128 + number, "", "varishold: interrupted\n")
    assert not (tmp_path / "p.npz").exists()


def test_a_closed_pipe_ends_with_nothing() -> None:
    process = subprocess.Popen([*PROGRAM, "touch", "--help"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == ""
    process.wait()
    process.stderr.close()


@pytest.mark.skipif(os.geteuid() != 0 or shutil.which("setpriv") is None, reason="takes root to become somebody else")
def test_a_service_user_needs_to_write_nothing_but_the_output(tmp_path: Path) -> None:
    import numpy as np

    for folder in (tmp_path, *tmp_path.parents[:2]):
        folder.chmod(0o755)
    (tmp_path / "out").mkdir()
    os.chown(tmp_path / "out", 61234, 61234)
    np.savez(tmp_path / "in.npz", pressure=np.eye(8)[None])
    code = (
        "from varishold.recording import read, write\n"
        "from varishold.levelset import find_contacts\n"
        "assert find_contacts(read('../in.npz').pads['pad'].frames[0])\n"
        "write(read('../in.npz'), 'copy.npz')\n"
    )
    done = subprocess.run(
        ["setpriv", "--reuid=61234", "--regid=61234", "--clear-groups", sys.executable, "-c", code],
        cwd=tmp_path / "out",
        env={"PATH": os.environ["PATH"], "PYTHONPATH": str(Path(__file__).parents[1] / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    if "python" in done.stderr and ("Permission denied" in done.stderr or "shared libraries" in done.stderr):
        pytest.skip("the interpreter itself is not readable for others")
    assert done.returncode == 0, done.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["copy.npz"]


_READ_ONLY = """
mount --make-rprivate / && mount --bind "$1" "$1" && mount -o remount,bind,ro / || exit 99
mount -t tmpfs -o ro tmpfs /dev/shm || exit 99
cd / && shift && exec "$@"
"""


@pytest.mark.parametrize(
    "words",
    [
        "skin press sphere --size-m 0.01 -o {}/press.npz --picture {}/press.png",
        "skin collect --count 128 --shape 12x12 --processes 2 -o {}/presses.npz",
        "grasp fit {}/in.csv --label object -o {}/model.json",
    ],
)
def test_nothing_but_the_output_needs_to_be_writable(tmp_path: Path, words: str) -> None:
    (tmp_path / "in.csv").write_text("object,switch.a\ncone,1\ncone,1\ncube,0\ncube,0\n")
    command = [sys.executable, "-m", "varishold", *words.replace("{}", str(tmp_path)).split()]
    alone = ("unshare", "-m", "sh", "-c", _READ_ONLY, "sh", str(tmp_path))
    if shutil.which("unshare") is None or subprocess.run([*alone, "true"], capture_output=True, check=False).returncode:
        pytest.skip("no file system can be made read-only here")
    done = subprocess.run(
        [*alone, *command],
        env={
            "PATH": os.environ["PATH"],
            "HOME": "/nonexistent",
            "PYTHONPATH": str(Path(varishold.__file__).parents[1]),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert not list(tmp_path.glob(".*"))
