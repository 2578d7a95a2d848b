"""Random presses, the data set made of them, and the commands that make both."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import varishold
from varishold.cli.app import app
from varishold.errors import InputError
from varishold.files import open_archive
from varishold.skin import PressDraw, Skin, Taxels, collect_presses, draw_press, press
from varishold.skin import draws as draws_module
from varishold.solids import SOLIDS, Sphere


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(draws_module, "_PART", 4)


DRAW = PressDraw(Skin("layer", 6e-3, 0.45, 1e-3), (16, 16), 2e-3, size_taxels=(4, 10), taxels=Taxels(noise=0.02))


def _run(*words: str | Path) -> str:
    outcome = CliRunner().invoke(app, [str(word) for word in words])
    if outcome.exception is not None and not isinstance(outcome.exception, SystemExit):
        raise outcome.exception
    assert outcome.exit_code == 0, outcome.output
    return outcome.output


@pytest.mark.parametrize("solid", SOLIDS)
def test_every_drawable_solid_is_pressed(solid: str) -> None:
    one = draw_press(np.random.default_rng(5), DRAW, solid=solid)
    again = draw_press(np.random.default_rng(5), DRAW, solid=solid)
    assert np.array_equal(one.frame, again.frame)
    assert one.name == SOLIDS[solid].name
    assert one.force_n > 0
    assert one.area_m2 > 0


def test_the_file_does_not_depend_on_the_processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(draws_module, "_PARTS_WORTH_A_PROCESS", 1)
    one, two = tmp_path / "one.npz", tmp_path / "two.npz"
    collect_presses(one, DRAW, 8, seed=7)
    collect_presses(two, DRAW, 8, seed=7, processes=2)
    assert one.read_bytes() == two.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.npz", "two.npz"]


def test_an_interrupted_collection_is_carried_on(tmp_path: Path) -> None:
    whole, broken = tmp_path / "whole.npz", tmp_path / "broken.npz"
    collect_presses(whole, DRAW, 10, seed=7)

    def stop(done: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        collect_presses(broken, DRAW, 10, seed=7, advance=stop)
    assert not broken.exists()
    steps: list[int] = []
    assert collect_presses(broken, DRAW, 10, seed=7, advance=steps.append) == 4
    assert sum(steps) == 10
    assert broken.read_bytes() == whole.read_bytes()
    # Another seed takes nothing from what an earlier call left behind.
    with pytest.raises(KeyboardInterrupt):
        collect_presses(broken, DRAW, 10, seed=7, advance=stop)
    assert collect_presses(broken, DRAW, 10, seed=8) == 0


def test_the_data_set_is_a_recording(tmp_path: Path) -> None:
    path = tmp_path / "presses.npz"
    collect_presses(path, DRAW, 6, seed=1)
    recording = varishold.read(path)
    pad = recording.pads["pad"]
    assert pad.n_frames == 6
    assert pad.pitch_m == (2e-3, 2e-3)
    assert recording.unit == "raw"
    with np.load(path) as arrays:
        assert set(arrays["press.solid"]) <= set(SOLIDS)
        assert [SOLIDS[solid].name for solid in arrays["press.solid"]] == list(arrays["press.label"])
    # What is known of a press is a column, by which `learn`, `evaluate` and a table can ask for it.
    assert recording.remarks == ()
    assert len(recording.presses) == 6
    lengths = ("position_x_m", "position_y_m", "size_long_m", "size_short_m", "depth_m")
    assert set(recording.press_columns) == {"label", "solid", *lengths, "yaw_rad", "force_n", "area_m2"}
    assert all(recording.press_columns["size_long_m"] >= recording.press_columns["size_short_m"])


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"solids": ("ball",)}, "solids must name one or more of"),
        ({"solids": ()}, "got none"),
        ({"size_taxels": (0, 5)}, "size_taxels must be a range (low, high)"),
        ({"size_taxels": (5, 40)}, "must not exceed the pad's 32 taxels, got 40"),
        ({"slope": (0.3, 0.1)}, "slope must be a range"),
        ({"shape": (8, 0)}, "shape must be (rows, cols)"),
        *(({"pitch_m": pitch}, "pitch_m must be one spacing") for pitch in (np.nan, np.inf, -1.0, 0.0, 1e100)),
    ],
)
def test_what_is_wrong_is_told(options: dict[str, object], says: str) -> None:
    with pytest.raises(InputError) as caught:
        PressDraw(Skin("half-space"), **options)  # type: ignore[arg-type]
    assert says in str(caught.value)


def test_a_collection_of_nothing_or_nowhere_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="count must be 1 or more"):
        collect_presses(tmp_path / "a.npz", DRAW, 0)
    with pytest.raises(InputError, match="processes must be 1 or more"):
        collect_presses(tmp_path / "a.npz", DRAW, 1, processes=0)
    with pytest.raises(InputError, match="cannot write here: no such file or directory"):
        collect_presses(tmp_path / "none" / "a.npz", DRAW, 1)


def test_more_presses_than_a_file_can_hold_are_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="count must be at most 3355443 presses of 16 x 16 taxels"):
        collect_presses(tmp_path / "a.npz", DRAW, 10**20)
    assert list(tmp_path.iterdir()) == []
    small = dataclasses.replace(DRAW, shape=(12, 12))
    collect_presses(tmp_path / "a.npz", small, 8)
    with open_archive(tmp_path / "a.npz") as archive:
        held = sum(archive.array(name).nbytes for name in archive.names)
    assert held <= 8 * (12 * 12 * 4 + draws_module._COLUMN_BYTES) + 200


def test_a_press_that_fails_leaves_nothing(tmp_path: Path) -> None:
    coarse = dataclasses.replace(DRAW, pitch_m=1e3)
    with pytest.raises(InputError, match="the grid is too coarse"):
        collect_presses(tmp_path / "a.npz", coarse, 2)
    assert list(tmp_path.iterdir()) == []
    fine = dataclasses.replace(DRAW, pitch_m=1e-9)
    with pytest.raises(
        InputError, match=r"too close for a sensing depth of 0\.001 m, .* give a pitch_m of 1\.1e-05 or"
    ):
        collect_presses(tmp_path / "a.npz", fine, 2)
    hard = dataclasses.replace(DRAW, skin=dataclasses.replace(DRAW.skin, youngs_modulus_pa=1e99))
    with pytest.raises(InputError, match=r"frames of up to \S+ are beyond what a file of presses holds"):
        collect_presses(tmp_path / "a.npz", hard, 2)
    assert list(tmp_path.iterdir()) == []


def test_oblong_cells_of_a_thin_layer_are_refused() -> None:
    with pytest.raises(InputError, match=r"cells of .* m are too oblong for a layer of 0\.002 m; give a pitch_m"):
        press(Sphere(0.02), Skin("layer", 2e-3), depth=1e-3, shape=(8, 8), pitch_m=(1e-2, 1e-8), per_taxel=1)


def test_press_command(tmp_path: Path) -> None:
    picture, recording = tmp_path / "press.png", tmp_path / "press.npz"
    said = _run(
        *("skin", "press", "cone", "--size-m", "0.012", "--noise", "0.01", "--seed", "2"),
        *("--picture", picture, "-o", recording, "--json"),
    )
    answer = json.loads(said)
    assert answer["depth_m"] == 1e-3
    assert answer["force_n"] is None
    assert answer["converged"] is True
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert varishold.read(recording).pads["pad"].shape == (32, 32)


def test_press_command_by_force_and_for_people(tmp_path: Path) -> None:
    skin = tmp_path / "skin.toml"
    skin.write_text('[skin]\nkind = "half-space"\nsensing_depth_m = 1e-3\nyoungs_modulus_pa = 2e5\n')
    said = _run("skin", "press", "square-pillar", "--size-m", "0.01", "--skin", skin, "--force-n", "3")
    assert "force 3 N" in said
    assert "(Pa)" in said


@pytest.mark.parametrize("suffix", [".npy", ".csv"])
def test_press_command_with_a_height_map(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"face{suffix}"
    x = np.linspace(-1, 1, 20)
    height = 5e-3 * np.maximum(1 - x[:, None] ** 2 - x[None, :] ** 2, 0)
    if suffix == ".npy":
        np.save(path, height)
    else:
        np.savetxt(path, height, delimiter=",")
    assert json.loads(_run("skin", "press", path, "--depth-m", "0.5e-3", "--json"))["peak_taxel"] > 0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["cone"], "a cone needs --size-m"),
        (["ball", "--size-m", "0.01"], "unknown solid 'ball'"),
        (["ball"], "unknown solid 'ball'"),
        (["."], ".: the name of a height map ends in .npy, .csv, .txt"),
        (["hip", "--size-m", "-1"], "the size of a hip must be positive and finite, got -1.0 m (--size-m)"),
        (["none.npy"], "none.npy: there is no such file"),
        (["none.npy", "--size-m", "0.01"], "a height map has its own size"),
        (["cone", "--size-m", "0.01", "--skin", "none.toml"], "none.toml: there is no such file"),
        (["cone", "--size-m", "0.01", "--force-n", "1"], "needs the skin's youngs_modulus_pa"),
        (["cone", "--size-m", "0.01", "--x-m", "1"], "lies outside the field"),
        (["cone", "--size-m", "0.01", "--shape", "3y3"], "--shape must be ROWSxCOLS"),
    ],
)
def test_press_command_tells_what_is_wrong(words: list[str], says: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        _run("skin", "press", *words)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_broken_height_map_is_told(tmp_path: Path) -> None:
    path = tmp_path / "face.csv"
    path.write_text("1,2\n3\n")
    with pytest.raises(InputError, match=r"face.csv: line 2 must have 2 numbers"):
        _run("skin", "press", path)


def test_collect_command(tmp_path: Path) -> None:
    path = tmp_path / "presses.npz"
    said = _run(
        *("skin", "collect", "-o", path, "--count", "6", "--solids", "cone,plane", "--shape", "8x12"),
        *("--pitch-m", "2e-3", "--processes", "1", "--bits", "12"),
    )
    assert f"{path}: 6 presses" in said
    with np.load(path) as arrays:
        assert arrays["pressure"].shape == (6, 8, 12)
        assert set(arrays["press.solid"]) <= {"cone", "plane"}


def test_what_is_drawn_by_default_and_from_which_sizes() -> None:
    skin = Skin("half-space")
    draw = PressDraw(skin)
    assert (draw.shape, draw.pitch_m, draw.solids) == ((32, 32), 1e-3, tuple(SOLIDS))
    assert (draw.size_taxels, draw.slope, draw.taxels) == ((8.0, 20.0), (0.05, 0.3), Taxels())
    # A contact is as broad as the pad's shorter side at most.
    PressDraw(skin, shape=(20, 12), size_taxels=(4, 12))
    with pytest.raises(InputError, match="must not exceed the pad's 12 taxels, got 13"):
        PressDraw(skin, shape=(20, 12), size_taxels=(4, 13))
    for wrong in ((5.0, 4.0), (0.0, 4.0), (1.0, float("inf"))):
        with pytest.raises(InputError, match="must be a range"):
            PressDraw(skin, size_taxels=wrong)
    PressDraw(skin, size_taxels=(4.0, 4.0))


def test_a_press_is_drawn_in_the_pad_s_own_metres() -> None:
    draw = PressDraw(Skin("layer", 6e-3, 0.45, 1e-3), (10, 16), 2e-3, size_taxels=(5, 6), slope=(0.1, 0.1))
    one = draw_press(np.random.default_rng(3), draw, solid="square-pillar")
    assert 10e-3 <= one.drawn.size_m[0] <= 12.1e-3
    assert one.area_m2 == pytest.approx(one.drawn.size_m[0] * one.drawn.size_m[1], rel=0.1)
    assert one.frame.sum() * 4e-6 == pytest.approx(one.force_n, rel=0.05)
    # A pillar of one width is drawn from the same chances whichever seed its noise has.
    seen = {draw_press(np.random.default_rng(k), draw).solid for k in range(12)}
    assert len(seen) > 5
