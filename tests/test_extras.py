"""What runs without the extras, and how each that is missing is told: in one line that names the command to run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from varishold._lazy import missing_extra
from varishold.errors import MissingExtraError

ROOT = Path(__file__).parents[1]
EXTRAS = ("scipy", "sklearn", "threadpoolctl", "matplotlib", "mujoco")
# Nothing of the extras can be imported, as on a machine where they are not installed.
BARE = f"""
import sys
class Bare:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {EXTRAS!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Bare())
from varishold.cli import main
main()
"""


def bare(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", BARE, *arguments], cwd=folder, capture_output=True, text=True, check=False
    )


def whole(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    code = "from varishold.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *arguments], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def grasps(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a grasp table and a model that was learned from it."""
    folder = tmp_path_factory.mktemp("grasps")
    rng = np.random.default_rng(0)
    kinds = rng.random((3, 8)) > 0.5
    rows = [",".join(["abc"[k % 3], *map(str, (kinds[k % 3] ^ (rng.random(8) < 0.05)).astype(int))]) for k in range(60)]
    (folder / "table.csv").write_text("\n".join(["object," + ",".join(f"switch.s{i}" for i in range(8)), *rows]))
    done = whole("grasp", "fit", "table.csv", "--label", "object", "-o", "model.json", folder=folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_touch_runs_without_extras_and_says_the_same(tmp_path: Path) -> None:
    asked = ("touch", str(ROOT / "examples" / "surfaces.npz"), "--frames", "press", "--json")
    done = bare(*asked, "--report", "bare.html", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout == whole(*asked, "--report", "whole.html", folder=tmp_path).stdout
    assert (tmp_path / "bare.html").stat().st_size == pytest.approx((tmp_path / "whole.html").stat().st_size, rel=0.01)


@pytest.mark.parametrize(
    "asked",
    [
        ("predict", "model.json", "table.csv"),
        ("predict", "model.json", "table.csv", "--json"),
        ("tables", "model.json"),
        ("export", "model.json", "--to", "c", "-o"),
        ("export", "model.json", "--to", "verilog", "-o"),
        ("export", "model.json", "--to", "json", "-o"),
    ],
)
def test_a_learned_model_answers_without_extras_and_says_the_same(asked: tuple[str, ...], grasps: Path) -> None:
    here = [*asked, "out-" + asked[3]] if asked[-1] == "-o" else [*asked]
    done = bare("grasp", *here, folder=grasps)
    assert done.returncode == 0, done.stderr
    again = [*here, "--force"] if asked[-1] == "-o" else here
    assert done.stdout == whole("grasp", *again, folder=grasps).stdout


def test_a_learned_touch_model_answers_without_extras_and_says_the_same(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    y, x = np.mgrid[-4:5, -4:5]
    forms = (np.hypot(x, y) < 3, np.abs(x) < 2)
    ramp = np.array([0.0, 0.5, 1.0, 0.0])
    frames = np.concatenate([50 * ramp[:, None, None] * forms[k % 2] + rng.normal(0, 1, (4, 9, 9)) for k in range(20)])
    names = np.array(["disc", "bar"] * 10)
    np.savez(tmp_path / "bag.npz", **{"pressure": frames, "press": np.repeat(np.arange(20), 4), "press.thing": names})
    done = whole("learn", "bag.npz", "--label", "thing", "-o", "model.npz", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    done = bare("recognize", "model.npz", "bag.npz", "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout == whole("recognize", "model.npz", "bag.npz", "--json", folder=tmp_path).stdout
    asked = ("evaluate", "bag.npz", "--label", "thing", "--with", "model.npz")
    for way in (asked[:-2], ("learn", "bag.npz", "--label", "thing", "-o", "other.npz")):
        done = bare(*way, folder=tmp_path)
        assert done.returncode == 1
        assert "run: pip install -e '.[learn]'" in done.stderr


@pytest.mark.parametrize(
    ("asked", "extra"),
    [
        (("skin", "press", "cone", "--size-m", "0.01", "-o", "press.npz"), "skin"),
        (("grasp", "fit", "table.csv", "--label", "object", "-o", "other.json"), "learn"),
        (("hand", "grasp", "cone", "--size-m", "0.04"), "sim"),
        (("perceive", "cone", "--size-m", "0.04"), "sim"),
        (("paper", "table", "5"), "all"),
    ],
)
def test_a_missing_extra_is_told_in_one_line(asked: tuple[str, ...], extra: str, grasps: Path) -> None:
    done = bare(*asked, folder=grasps)
    assert done.returncode == 1
    assert done.stderr.count(os.linesep) == 1
    assert done.stderr.startswith("varishold: this needs ")
    assert f"run: pip install -e '.[{extra}]'" in done.stderr


def test_what_is_no_extra_stays_what_it_is() -> None:
    error = ModuleNotFoundError("No module named 'yesterday'", name="yesterday")
    assert missing_extra(error) is error
    assert isinstance(
        missing_extra(ModuleNotFoundError("No module named 'scipy.fft'", name="scipy.fft")), MissingExtraError
    )
