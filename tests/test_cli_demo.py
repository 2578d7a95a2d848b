"""``varishold demo`` and ``doctor``: what somebody runs who has nothing yet."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from varishold.cli import browser, demo
from varishold.cli.app import app
from varishold.errors import MissingKernelError
from varishold.recording import Pad, Recording

ROOT = Path(__file__).parents[1]


def told(*words: str, status: int = 0) -> str:
    done = CliRunner().invoke(app, list(words), catch_exceptions=False)
    assert done.exit_code == status, done.output
    return done.output


def test_a_demonstration_needs_nothing_and_says_which_command_does_the_same(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    said = told("demo", "--report", str(page))
    assert said.startswith(f"$ varishold touch {demo.EXAMPLES / 'surfaces.npz'} --frames press --report {page}\n")
    assert "lying cylinder" in said
    assert said.endswith(f"open it in a browser: {page}\n")
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")


def test_without_a_place_the_page_goes_to_a_new_temporary_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(demo.tempfile, "tempdir", str(tmp_path))
    said = told("demo", "touch", "--no-open")
    (page,) = tmp_path.glob("varishold-*/touch.html")
    assert said.endswith(f"open it in a browser: {page}\n")


def test_a_page_is_opened_where_somebody_looks(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    opened: list[str] = []
    monkeypatch.setattr(demo, "show_page", lambda address: opened.append(address) or True)
    page = tmp_path / "a page.html"
    assert "open it" not in told("demo", "--report", str(page))
    assert opened == [page.as_uri()]
    assert "open it" in told("demo", "--report", str(page), "--no-open")
    assert len(opened) == 1


def test_nothing_is_opened_where_nobody_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(address: str) -> bool:
        raise AssertionError(address)

    monkeypatch.setattr("webbrowser.open", never)
    assert not browser.show_page("file:///nowhere.html")
    monkeypatch.setattr(browser.sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(browser.sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert not browser.show_page("file:///nowhere.html")
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda address: True)
    assert browser.show_page("file:///nowhere.html")


def test_five_things_are_learned_and_evaluated(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """With presses that take no simulation."""

    def day(name: str, seed: int) -> Recording:
        rng = np.random.default_rng(seed)
        y, x = np.mgrid[-4:4, -4:4] + 0.5
        forms = (6 - np.hypot(x, y), 5 - abs(x), 4 - np.maximum(abs(x), abs(y)))
        rows = [share * np.maximum(forms[k % 3], 0) for k in range(15) for share in (0, 0.5, 1, 0)]
        return Recording(
            {"pad": Pad(100 * np.array(rows) + rng.normal(0, 1, (60, 8, 8)))},
            press=np.repeat(np.arange(15), 4),
            press_columns={"thing": np.array(list("abc") * 5), "day": np.repeat(name, 15)},
        )

    monkeypatch.setattr(demo, "_script", lambda name: SimpleNamespace(DAYS=("monday", "tuesday"), day=day))
    said = told("demo", "learn", "--report", str(tmp_path / "page.html"))
    assert "$ varishold evaluate" in said
    assert "30 presses of 2 groups, 3 things" in said
    assert not [line for line in said.splitlines() if "peer:" in line]


def test_the_examples_that_it_shows_are_those_of_the_project() -> None:
    things = demo._script("five_things")
    assert set(things.things()) == {"ball", "can", "nut", "die", "spike"}
    assert demo.EXAMPLES in (ROOT / "examples", Path(demo.__file__).parents[1] / "examples")


def test_what_cannot_be_shown_is_a_usage_error() -> None:
    assert "'nothing' is not one of" in told("demo", "nothing", status=2)


def test_the_doctor_says_what_is_there() -> None:
    said = told("doctor")
    assert said.startswith("varishold 0.1.0, Python 3.")
    assert "\nkernel    varishold_" in said
    found = json.loads(told("doctor", "--json"))
    assert found["kernel_error"] is None
    assert found["extras"]["learn"].keys() == {"scikit-learn", "scipy"}
    assert found["extras"]["learn"]["scipy"] is not None


def test_the_doctor_knows_every_extra() -> None:
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text("utf-8"))["project"]
    assert set(json.loads(told("doctor", "--json"))["extras"]) == set(project["optional-dependencies"]) - {
        "all",
        "docs",
        "dev",
    }


def test_the_doctor_says_what_is_missing_and_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    from varishold.cli import doctor

    there = doctor._version
    monkeypatch.setattr(doctor, "_version", lambda name: None if name in ("scipy", "mcap") else there(name))
    lines = told("doctor").splitlines()
    assert "skin      lacks scipy for --skin, --exact, skin, sensor calibrate; run: pip install -e '.[skin]'" in lines
    assert any(line.startswith("live      lacks mcap for ") for line in lines)
    assert json.loads(told("doctor", "--json"))["extras"]["live"]["mcap"] is None


def test_a_kernel_that_does_not_work_is_told_and_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> None:
        raise MissingKernelError("the compiled kernel is missing; build it")

    monkeypatch.setattr("varishold.kernel.library.library", broken)
    assert "kernel    does not work: the compiled kernel is missing; build it" in told("doctor", status=1)
    assert json.loads(told("doctor", "--json", status=1))["kernel"] is None


@pytest.mark.parametrize("words", [("-h",), ("touch", "-h"), ("grasp", "fit", "-h"), ("touch", "export", "-h")])
def test_a_short_option_asks_for_help(words: tuple[str, ...]) -> None:
    assert "Usage:" in told(*words)
