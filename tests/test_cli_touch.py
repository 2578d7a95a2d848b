"""The command ``varishold touch`` as a person runs it: answers, errors in one line, exit statuses."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
SURFACES = ROOT / "examples" / "surfaces.npz"
# Of the fourteen presses of the bundled recording, in order.
NAMES = [
    "cylinder",
    "square pillar",
    "rectangular pillar",
    "frustum of a cone",
    "frustum of a pyramid",
    "sphere",
    "cone",
    "pyramid",
    "ridge",
    "hip",
    "lying cylinder",
    "edge",
    "edge",
    "plane",
]
KEYS = [
    "file",
    "frame",
    "time_s",
    "pad",
    "contact",
    "name",
    "form",
    "section",
    "probability",
    "alternatives",
    "outline",
    "outline_probability",
    "answer_set",
    "cut",
    "reasons",
    "position_m",
    "orientation_rad",
    "size_m",
    "size_interval_m",
    "radius_m",
    "radius_interval_m",
    "area_m2",
    "position_taxels",
    "size_taxels",
    "area_taxels",
    "apex_exponent",
    "defect_sqrt_area",
    "defect_perimeter",
    "bulge_sqrt_area",
    "bulge_perimeter",
    "holes",
    "force_n",
    "depth_m",
    "depth_interval_m",
    "tilt_rad",
    "rounding_m",
    "sensor",
    "frame_notes",
]


Run = Callable[..., tuple[int, str, str]]


def test_the_bundled_recording_is_read_rightly() -> None:
    # As a process of its own; the others run in this one.
    command = [sys.executable, "-m", "varishold", "touch", str(SURFACES), "--frames", "press", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert [answer["name"] for answer in answers] == NAMES
    assert all(list(answer) == KEYS for answer in answers)
    assert all(answer["force_n"] > 0 and answer["reasons"] for answer in answers)


def test_a_table_for_people_and_a_page(run: Run, tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    status, out, err = run("touch", SURFACES, "--report", page)
    assert status == 0, err
    assert out.splitlines()[0].split()[:3] == ["frame", "name", "p"]
    assert str(page) in out.splitlines()[-1]
    assert page.read_text(encoding="utf-8").lower().startswith("<!doctype html>")


def test_a_known_skin_is_seen_through(run: Run, tmp_path: Path) -> None:
    skin = tmp_path / "skin.toml"
    skin.write_text('[skin]\nkind = "layer"\nthickness_m = 6e-3\npoisson = 0.45\nsensing_depth_m = 1e-3\n')
    status, out, err = run("touch", SURFACES, "--frames", "press", "--skin", skin, "--json")
    assert status == 0, err
    named = [json.loads(line)["name"] for line in out.splitlines()]
    assert sum(a == b for a, b in zip(named, NAMES, strict=True)) >= 13


def refused(tmp_path: Path) -> dict[str, tuple[list[str | Path], str]]:
    np.save(tmp_path / "flat.npy", np.zeros((3, 256)))
    np.savez(tmp_path / "pitchless.npz", pressure=np.eye(12)[None])
    np.savez(tmp_path / "inverted.npz", pressure=-np.ones((2, 8, 8)))
    (tmp_path / "skin.toml").write_text('[skin]\nkind = "half-space"\n')
    (tmp_path / "odd.toml").write_text('[skin]\nkind = "half-space"\ncolour = "pink"\n')
    (tmp_path / "rows.csv").write_text("\n".join(",".join(["0"] * 12) for _ in range(4)))
    return {
        "missing file": ([tmp_path / "none.npz"], "there is no such file"),
        "bad shape": ([tmp_path / "flat.npy", "--shape", "sixteen"], "--shape must be ROWSxCOLS, as in 16x16"),
        "wrong shape": ([tmp_path / "flat.npy", "--shape", "5x5"], "25"),
        "csv without shape": ([tmp_path / "rows.csv"], "--shape"),
        "polarity": ([tmp_path / "inverted.npz"], "mostly negative"),
        "frame": ([SURFACES, "--frames", "99"], "there is no frame 99: frames are numbered 0 to 98"),
        "frames": ([SURFACES, "--frames", "some"], "frames must be 'peak', 'all', 'press' or"),
        "no frames": ([SURFACES, "--frames", ""], "frames must be 'peak', 'all', 'press' or"),
        "exact without skin": ([SURFACES, "--exact"], "needs a skin, or [skin] in a sensor file (--skin)"),
        "skin without pitch": ([tmp_path / "pitchless.npz", "--skin", tmp_path / "skin.toml"], "--pitch-m"),
        "unknown skin key": ([SURFACES, "--skin", tmp_path / "odd.toml"], "colour"),
        "missing skin": ([SURFACES, "--skin", tmp_path / "none.toml"], "none.toml"),
        "report in no folder": ([SURFACES, "--report", tmp_path / "none" / "deep" / "r.html"], "none"),
    }


@pytest.mark.parametrize(
    "case",
    [
        "missing file",
        "bad shape",
        "wrong shape",
        "csv without shape",
        "polarity",
        "frame",
        "frames",
        "exact without skin",
        "skin without pitch",
        "unknown skin key",
        "missing skin",
        "report in no folder",
    ],
)
def test_bad_input_ends_in_one_line(case: str, run: Run, tmp_path: Path) -> None:
    arguments, message = refused(tmp_path)[case]
    status, out, err = run("touch", *arguments)
    assert status == 1, out
    assert message in err
    assert err.count("\n") == 1
    assert "Traceback" not in err


def test_wrong_use_has_its_own_status(run: Run) -> None:
    assert run("touch")[0] == 2
    assert run("touch", SURFACES, "--levels", "1")[0] == 2
