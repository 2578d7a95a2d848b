"""A stranger's surface, felt by the simulated hand, and what is said, drawn and written of it."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from benchmarks._true_surface import distances_m, mesh_points_m, true_points
from varishold.cli import main
from varishold.cli.felt_surface import surface_to_dict, touches_wanted
from varishold.errors import InputError
from varishold.exploration import SurfaceExploration, check_touches, explore_surface
from varishold.hand import HandSetting, PadSetting, set_up
from varishold.hand.objects import graspable
from varishold.hand.palm_place import palm_place
from varishold.perceive import library_file
from varishold.report.surface_drawing import sigma_key, surface_drawing
from varishold.report.surface_words import surface_in_words, surface_touch_in_words

NAME, SIZE_M, TOUCHES = "lump-8", 0.06, 6


@pytest.fixture(scope="module")
def felt() -> SurfaceExploration:
    return explore_surface(NAME, SIZE_M, seed=5, touches=TOUCHES)


def test_six_touches_give_most_of_the_surface(felt: SurfaceExploration) -> None:
    own, normals = true_points(graspable(NAME, SIZE_M), 1500)
    origin, axes = felt.pose
    reached = own[(own[:, 2] > 5e-4) | (normals[:, 2] > -0.9)]
    assert distances_m(reached @ axes.T + origin, felt.mesh).mean() < 0.004
    assert len(felt.touches) == len(felt.felt) == len(felt.history_m) == TOUCHES
    assert felt.history_m[-1] < felt.history_m[0]
    assert felt.touches[0].kind == "search"
    assert any(touch.kind == "fingertip" for touch in felt.touches)
    assert not any(touch.like(other) for k, touch in enumerate(felt.touches) for other in felt.touches[:k])


def test_points_lie_on_the_object_and_the_hand_does_not(felt: SurfaceExploration) -> None:
    points = np.vstack([each.point_m for each in felt.felt])
    free = np.vstack([each.free_m for each in felt.felt])
    origin, axes = felt.pose
    places, normals = true_points(graspable(NAME, SIZE_M), 20_000)
    away = ((points[:, None] - (places @ axes.T + origin)[None, ::10]) ** 2).sum(axis=-1)
    assert np.median(np.sqrt(away.min(axis=1))) < 0.003
    nearest = np.argmin(((free[:, None] - (places @ axes.T + origin)[None, ::10]) ** 2).sum(axis=-1), axis=1)
    out = ((free - (places @ axes.T + origin)[::10][nearest]) * (normals @ axes.T)[::10][nearest]).sum(axis=1)
    assert np.mean(out > 0) > 0.95


def test_a_clamped_object_stays_where_it_is() -> None:
    setting = HandSetting(search=True, clamped=True, pads=PadSetting())
    bench, _ = set_up(NAME, SIZE_M, seed=5, setting=setting)
    after = explore_surface(NAME, SIZE_M, seed=5, touches=3).pose
    before = bench.object_pose()
    np.testing.assert_allclose(after[0], before[0], atol=5e-4)
    np.testing.assert_allclose(after[1], before[1], atol=5e-3)


def test_the_palm_is_where_its_carriage_says() -> None:
    bench, _ = set_up("cylinder", 0.07, seed=1, setting=HandSetting())
    bench.put_carriage({"reach": -0.2, "shift": 0.03, "raise": 0.05, "turn": 0.7, "roll": 0.4, "wrist": 0.3})
    origin, axes = palm_place(bench.sense().carriage, bench.design)
    palm = bench.data.body("palm")
    np.testing.assert_allclose(origin, palm.xpos, atol=1e-9)
    np.testing.assert_allclose(axes, palm.xmat.reshape(3, 3), atol=1e-9)


def test_the_same_seed_gives_the_same_surface(felt: SurfaceExploration) -> None:
    again = explore_surface(NAME, SIZE_M, seed=5, touches=2)
    assert again.touches == felt.touches[:2]
    np.testing.assert_array_equal(again.felt[1].point_m, felt.felt[1].point_m)


def test_what_cannot_be_felt_is_refused() -> None:
    for touches in (1, 17):
        with pytest.raises(InputError, match=r"touches must lie in 2 \.\. 16"):
            check_touches(touches)
    with pytest.raises(InputError, match="a surface is felt by pads"):
        explore_surface(NAME, SIZE_M, seed=1, setting=HandSetting(clamped=True))
    with pytest.raises(InputError, match="the object must stay where it is"):
        explore_surface(NAME, SIZE_M, seed=1, setting=HandSetting(pads=PadSetting()))
    with pytest.raises(InputError, match="name its file with --surface"):
        touches_wanted(5, None)
    assert touches_wanted(None, None) == 12


def test_words_numbers_and_drawings_say_the_same(felt: SurfaceExploration) -> None:
    place, sigma_m = felt.surface.least_known(felt.mesh)
    said = surface_to_dict(felt, Path("felt.stl"))
    assert json.loads(json.dumps(said)) == said
    assert said["least_known_sigma_m"] == sigma_m
    assert said["least_known_m"] == place.tolist()
    assert said["faces"] == len(felt.mesh.faces)
    assert [each["touch"] for each in said["touches"]] == [touch.kind for touch in felt.touches]
    words = surface_in_words(felt)
    assert f"after {TOUCHES} touches" in words
    assert f"worst to {1e3 * sigma_m:.1f} mm" in words
    assert "searched and gripped it: 1 point; no surface yet" == surface_touch_in_words(
        felt.touches[0], 1, float("nan")
    )
    mesh = felt.surface.mesh(steps=12)
    drawing = surface_drawing(felt, mesh, 0.4, side="the front")
    assert drawing == surface_drawing(felt, mesh, 0.4, side="the front")
    assert drawing.count("<circle ") <= sum(len(each.point_m) for each in felt.felt)
    assert len(mesh.faces) / 4 < drawing.count("<path color=") < len(mesh.faces) * 0.75
    least, colours, most = sigma_key(felt)
    assert float(least.split()[0]) < float(most.split()[0])
    assert len(set(colours)) == len(colours)


def test_points_of_a_mesh_lie_on_it(felt: SurfaceExploration) -> None:
    points = mesh_points_m(felt.mesh, 200)
    assert distances_m(points, felt.mesh).max() < 1e-9
    moved = replace(felt.mesh, vertices_m=felt.mesh.vertices_m + np.array([0.0, 0.0, 1.0]))
    assert distances_m(points, moved).min() > 0.5


@pytest.mark.skipif(not library_file._SHIPPED.is_file(), reason="no library of objects is shipped")
def test_the_command_writes_a_mesh_and_a_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(*words: str) -> int:
        monkeypatch.setattr(sys, "argv", ["varishold", "perceive", NAME, "--size-m", "0.06", *words])
        with pytest.raises(SystemExit) as ended:
            main()
        return int(ended.value.code or 0)

    mesh, page = tmp_path / "felt.stl", tmp_path / "felt.html"
    assert run("--surface", str(mesh), "--touches", "3", "--report", str(page), "--json") == 0
    answer = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert answer["surface"]["file"] == str(mesh)
    assert len(answer["surface"]["touches"]) == 3
    assert mesh.stat().st_size == 84 + 50 * answer["surface"]["faces"]
    text = page.read_text()
    assert text.count('class="screen surface"') == 2
    assert "The surface after 3 touches" in text
    (tmp_path / "mine.stl").write_text("solid mine")
    assert run("--surface", str(tmp_path / "mine.stl")) == 1
    assert "is there, and is no surface of this program" in capsys.readouterr().err
    assert run("--surface", str(tmp_path / "felt.obj")) == 1
    assert "its name must end in .stl" in capsys.readouterr().err
    assert run("--touches", "3") == 1
    assert "name its file with --surface" in capsys.readouterr().err
    assert run("--surface", str(mesh), "--touches", "99") == 1
    assert "touches must lie in 2 .. 16, got 99" in capsys.readouterr().err
