"""What runs without the extras, and how each that is missing is told: in one line that names the command to run."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from tests.pressed_things import told

from varishold import _lazy
from varishold._lazy import missing_extra, to_install
from varishold.errors import MissingExtraError

ROOT = Path(__file__).parents[1]
EXTRAS = ("scipy", "sklearn", "threadpoolctl", "matplotlib", "mujoco")
# Nothing of the extras can be imported, as on a machine where they are not installed; a process for each command, which
# begins where the program and what it always needs is loaded.
BARE = f"""
import json, os, sys
class Bare:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {EXTRAS!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Bare())
import varishold.cli.app, numpy
from varishold.cli import main
for words in json.load(sys.stdin):
    child = os.fork()
    if not child:
        for stream, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(f"bare.{{name}}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), stream)
        sys.argv = ["varishold", *words]
        main()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    said = [open(f"bare.{{name}}", encoding="utf-8").read() for name in ("out", "err")]
    print(json.dumps([status, *said]), flush=True)
"""
MISSING = [
    (("skin", "press", "cone", "--size-m", "0.01", "-o", "press.npz"), "skin"),
    (("grasp", "fit", "table.csv", "--label", "object", "-o", "other.json"), "learn"),
    (("hand", "grasp", "cone", "--size-m", "0.04"), "sim"),
    (("perceive", "cone", "--size-m", "0.04"), "sim"),
    (("paper", "table", "5"), "all"),
]
ANSWERED = [
    ("predict", "model.json", "table.csv"),
    ("predict", "model.json", "table.csv", "--json"),
    ("tables", "model.json"),
    ("export", "model.json", "--to", "c", "-o", "out-c"),
    ("export", "model.json", "--to", "verilog", "-o", "out-verilog"),
    ("export", "model.json", "--to", "json", "-o", "out-json"),
]


def bare(*commands: Sequence[str], folder: Path) -> list[tuple[int, str, str]]:
    """Run commands where nothing of the extras is; return the status, output and errors of each."""
    done = subprocess.run(
        [sys.executable, "-c", BARE], input=json.dumps(commands), cwd=folder, capture_output=True, text=True, check=True
    )
    found = [tuple(json.loads(line)) for line in done.stdout.splitlines()]
    assert len(found) == len(commands)
    return found


def whole(*arguments: str, folder: Path) -> str:
    """Run a command where everything is; return its output."""
    with contextlib.chdir(folder):
        done = told(*arguments)
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.fixture(scope="module")
def grasps(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a grasp table and a model that was learned from it."""
    folder = tmp_path_factory.mktemp("grasps")
    rng = np.random.default_rng(0)
    kinds = rng.random((3, 8)) > 0.5
    rows = [",".join(["abc"[k % 3], *map(str, (kinds[k % 3] ^ (rng.random(8) < 0.05)).astype(int))]) for k in range(60)]
    (folder / "table.csv").write_text("\n".join(["object," + ",".join(f"switch.s{i}" for i in range(8)), *rows]))
    whole("grasp", "fit", "table.csv", "--label", "object", "-o", "model.json", folder=folder)
    return folder


@pytest.fixture(scope="module")
def bare_grasps(grasps: Path) -> dict[tuple[str, ...], tuple[int, str, str]]:
    """What each command says in that folder where nothing of the extras is."""
    commands = [*(asked for asked, _ in MISSING), *(("grasp", *asked) for asked in ANSWERED)]
    return dict(zip(commands, bare(*commands, folder=grasps), strict=True))


def test_touch_runs_without_extras_and_says_the_same(tmp_path: Path) -> None:
    asked = ("touch", str(ROOT / "examples" / "surfaces.npz"), "--frames", "press", "--json")
    ((status, out, err),) = bare((*asked, "--report", "bare.html"), folder=tmp_path)
    assert status == 0, err
    assert out == whole(*asked, "--report", "whole.html", folder=tmp_path)
    assert (tmp_path / "bare.html").stat().st_size == pytest.approx((tmp_path / "whole.html").stat().st_size, rel=0.01)


@pytest.mark.parametrize("asked", ANSWERED)
def test_a_learned_model_answers_without_extras_and_says_the_same(
    asked: tuple[str, ...], grasps: Path, bare_grasps: dict[tuple[str, ...], tuple[int, str, str]]
) -> None:
    status, out, err = bare_grasps["grasp", *asked]
    assert status == 0, err
    again = [*asked, "--force"] if "-o" in asked else asked
    assert out == whole("grasp", *again, folder=grasps)


def test_a_learned_touch_model_answers_without_extras_and_says_the_same(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    y, x = np.mgrid[-4:5, -4:5]
    forms = (np.hypot(x, y) < 3, np.abs(x) < 2)
    ramp = np.array([0.0, 0.5, 1.0, 0.0])
    frames = np.concatenate([50 * ramp[:, None, None] * forms[k % 2] + rng.normal(0, 1, (4, 9, 9)) for k in range(20)])
    names = np.array(["disc", "bar"] * 10)
    np.savez(tmp_path / "bag.npz", **{"pressure": frames, "press": np.repeat(np.arange(20), 4), "press.thing": names})
    whole("learn", "bag.npz", "--label", "thing", "-o", "model.npz", folder=tmp_path)
    asked = ("recognize", "model.npz", "bag.npz", "--json")
    ways = (("evaluate", "bag.npz", "--label", "thing"), ("learn", "bag.npz", "--label", "thing", "-o", "other.npz"))
    (status, out, err), *refused = bare(asked, *ways, folder=tmp_path)
    assert status == 0, err
    assert out == whole(*asked, folder=tmp_path)
    for status, _, err in refused:
        assert status == 1
        assert "run: pip install -e '.[learn]'" in err


@pytest.mark.parametrize(("asked", "extra"), MISSING)
def test_a_missing_extra_is_told_in_one_line(
    asked: tuple[str, ...], extra: str, bare_grasps: dict[tuple[str, ...], tuple[int, str, str]]
) -> None:
    status, _, err = bare_grasps[asked]
    assert status == 1
    assert err.count(os.linesep) == 1
    assert err.startswith("varishold: this needs ")
    assert f"run: pip install -e '.[{extra}]'" in err


def test_what_is_no_extra_stays_what_it_is() -> None:
    error = ModuleNotFoundError("No module named 'yesterday'", name="yesterday")
    assert missing_extra(error) is error
    assert isinstance(
        missing_extra(ModuleNotFoundError("No module named 'scipy.fft'", name="scipy.fft")), MissingExtraError
    )


def test_who_installed_a_package_is_not_sent_to_a_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package whose folder stands in no checkout names itself; pip then adds what the extra needs."""
    assert to_install("learn") == "pip install -e '.[learn]'"
    monkeypatch.setattr(_lazy, "__file__", str(tmp_path / "site-packages" / "varishold" / "_lazy.py"))
    assert to_install("learn") == "pip install 'varishold[learn]'"
