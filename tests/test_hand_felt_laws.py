"""Pads, features, pictures and tables of the hand, each beside what it should say of a made-up grasp."""

from __future__ import annotations

import importlib
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.scripted_bench import ScriptedBench, angles_at

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.errors import InputError, MissingExtraError, NotConvergedError
from varishold.hand import HandDesign, HandSetting, Job, PadSetting, Step, collect_grasps, run_jobs
from varishold.hand import pads as padding
from varishold.hand import picture as pictures
from varishold.hand.bench import Sensed
from varishold.hand.coordinates import contact_points, grip_circle
from varishold.hand.features import _curvature, _stiffness, features
from varishold.hand.layouts import PAPER_22
from varishold.hand.pads import PadFrames
from varishold.recording import read_grasp_table
from varishold.skin import Skin, Taxels

DESIGN = HandDesign()
collecting = importlib.import_module("varishold.hand.collect")


# Pads


class Pressed(ScriptedBench):
    """Every part that has a force is pressed by a flat surface, one that is bent, or none."""

    forces: dict[str, float]

    def object_forces_n(self) -> dict[str, float]:
        return dict.fromkeys(DESIGN.parts, 0.0) | self.forces


def test_pads_press_what_lies_before_them_with_the_force_that_they_bear(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Pressed()
    bench.forces = {"index.middle": 0.6, "thumb.distal": 0.09, "palm": 2.0, "ring.distal": 0.1, "little.middle": 0.5}
    setting = PadSetting(taxels=Taxels(noise=0.02), palm_pitch_m=0.006)
    told: dict[str, Any] = {}

    def surface(b: Any, part: str, shape: tuple[int, int], pitch_m: float) -> Any:
        return None if part == "little.middle" else (part, shape, pitch_m)

    def press(height: Any, skin: Skin, **how: Any) -> Any:
        if height[0] == "ring.distal":
            raise NotConvergedError("no depth found")
        told[height[0]] = (height, skin, how)
        return height

    def sense(pressed: Any, taxels: Taxels, *, seed: int) -> Any:
        assert taxels in (setting.taxels, PadSetting().taxels)
        return np.full(pressed[1], float(seed))

    monkeypatch.setattr(padding, "surface_before", surface)
    monkeypatch.setattr(padding, "press", press)
    monkeypatch.setattr(padding, "sense", sense)
    made = padding.press_pads(bench, setting=setting, seed=3)
    assert set(told) == {"index.middle", "palm"}
    parts = list(DESIGN.parts)
    for part, pitch, cells in (("index.middle", 0.002, 2), ("palm", 0.006, 6)):
        height, skin, how = told[part]
        shape = padding.pad_shape(part, DESIGN, setting)
        assert height == (part, shape, pitch)
        assert skin is setting.skin
        assert how == {
            "force": bench.forces[part],
            "shape": shape,
            "pitch_m": pitch,
            "per_taxel": cells,
            "tolerance": setting.tolerance,
        }
        assert (made.frames[part] == 3000 + parts.index(part)).all()
    for part in parts:
        assert made.frames[part].shape == padding.pad_shape(part, DESIGN, setting)
        assert made.pitch_m[part] == (0.006 if part == "palm" else 0.002)
        if part not in told:
            assert (made.frames[part] == 0).all()
    assert made.force_n == bench.object_forces_n()
    # Nothing asked for: the usual pads and seed.
    usual = padding.press_pads(bench)
    assert (usual.frames["index.middle"] == parts.index("index.middle")).all()
    assert usual.pitch_m["palm"] == 0.004


def test_a_solver_s_warning_that_it_stopped_short_is_not_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Pressed()
    bench.forces = {"palm": 1.0}
    flat = lambda *a: np.zeros((44, 42))  # noqa: E731
    monkeypatch.setattr(padding, "surface_before", flat)
    setting = PadSetting(tolerance=1e-9, taxels=Taxels())
    frame = padding.press_pads(bench, setting=setting).frames["palm"]
    assert frame.sum() * 0.004**2 == pytest.approx(1.0, rel=0.2)


def test_what_cannot_be_pads_is_told() -> None:
    for wrong, says in (
        ({"least_n": 0.0}, "least_n of the pads must be positive"),
        ({"tolerance": math.inf}, "tolerance of the pads must be positive"),
        ({"palm_pitch_m": -1.0}, "palm_pitch_m of the pads must be positive"),
        ({"cells_a_taxel": 0}, "cells_a_taxel of the pads must lie in 1 .. 16, got 0"),
        ({"cells_a_taxel": 17}, "cells_a_taxel of the pads must lie in 1 .. 16, got 17"),
        ({"skin": Skin("half-space")}, "the pads' skin needs youngs_modulus_pa"),
    ):
        with pytest.raises(InputError, match=says):
            PadSetting(**wrong)  # type: ignore[arg-type]
    usual = PadSetting(cells_a_taxel=16)
    assert (usual.phalanx_pitch_m, usual.palm_pitch_m, usual.least_n, usual.tolerance) == (0.002, 0.004, 0.1, 1e-3)
    assert PadSetting(cells_a_taxel=1).skin == Skin("layer", 4e-3, 0.45, 1e-3, 1.5e5)
    assert (usual.taxels, PadSetting().cells_a_taxel) == (Taxels(noise=0.01), 2)


# Features


def _curvature_by_hand(line: np.ndarray, pitch: float, stiffness: float) -> float:
    """The parabola through what stands above .4 of the peak beside it; through three columns where fewer do."""
    top = int(np.argmax(line))
    first = last = top
    while first > 0 and line[first - 1] > 0.4 * line[top]:
        first -= 1
    while last < len(line) - 1 and line[last + 1] > 0.4 * line[top]:
        last += 1
    if last - first < 2:
        first, last = max(top - 1, 0), min(top + 1, len(line) - 1)
    if last - first < 2:
        first = 0 if first == 0 else len(line) - 3
        last = first + 2
    x = np.arange(first, last + 1) * pitch
    a, _, _ = np.linalg.lstsq(np.stack([x * x, x, np.ones_like(x)], axis=1), line[first : last + 1], rcond=None)[0]
    return -2 * a / stiffness


@given(st.integers(0, 2**31), st.integers(3, 12))
@settings(max_examples=60)
def test_a_curvature_is_that_of_the_parabola_through_the_peak(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    frame = rng.random((4, n)) ** 3 + np.exp(-((np.arange(n) - rng.uniform(-1, n)) ** 2) / rng.uniform(0.5, 20))
    skin = PadSetting().skin
    line = 1e4 * frame.mean(axis=0)
    told = _curvature_by_hand(line, 0.002, _stiffness(skin))
    assert _curvature(1e4 * frame, 0.002, skin) == pytest.approx(told, rel=1e-6)
    assert _curvature(-frame, 0.002, skin) is None
    assert _curvature(0 * frame, 0.002, skin) is None


def test_a_stiffness_is_that_of_a_confined_layer() -> None:
    assert _stiffness(Skin("layer", 2e-3, 0.3, youngs_modulus_pa=1e5)) == pytest.approx(1e5 * 0.7 / (1.3 * 0.4) / 2e-3)
    # An incompressible one is taken for one that hardly yields; what is unknown, for the usual pad's.
    nearly = 0.5 / (1.5 * 0.02) / 1e-3
    assert _stiffness(Skin("layer", 1e-3, 0.5)) == pytest.approx(nearly)
    assert _stiffness(Skin("half-space", poisson=0.0)) == pytest.approx(1 / 0.004)


def _felt(closed: Sequence[str], angles: np.ndarray) -> Sensed:
    on = np.array([name in closed for name in PAPER_22.names])
    return Sensed(on, on.astype(float), angles, np.zeros(6))


def _step(sensed: Sensed, frames: dict[str, np.ndarray]) -> Step:
    force = {part: float(part in frames) for part in DESIGN.parts}
    every = {part: frames.get(part, np.zeros((8, 10))) for part in DESIGN.parts}
    return Step(5, "grip", sensed, True, True, PadFrames(every, dict.fromkeys(DESIGN.parts, 0.002), force))


def test_surfaces_are_told_by_their_extremes_in_decades() -> None:
    x = np.arange(10) - 4.5
    skin = PadSetting().skin
    unit = 0.5 * 0.002**2 * _stiffness(skin)
    frames = {
        "index.middle": 1e6 * np.ones((8, 1)) - 40 * unit * x**2 * np.ones((8, 1)),
        "thumb.distal": 1e6 * np.ones((8, 1)) + 5 * unit * x**2 * np.ones((8, 1)),
        "ring.middle": 1e6 * np.ones((8, 1)) - 12 * unit * x**2 * np.ones((8, 1)),
    }
    got = features(_step(_felt((), np.zeros(15)), frames), "surface", design=DESIGN, layout=PAPER_22).analog
    bends = np.array([40.0, -5.0, 12.0])
    assert got["surface.sharpest"] == pytest.approx(math.log10(41))
    assert got["surface.flattest"] == pytest.approx(-math.log10(6), rel=1e-6)
    assert got["surface.range"] == pytest.approx(45 / 40)
    assert got["surface.spread"] == pytest.approx(bends.std() / np.abs(bends).mean())
    # What is flat everywhere has no spread that noise could make: below half a metre's curve counts as half.
    faint = {
        "palm": 1e6 * np.ones((8, 1)) - 0.1 * unit * x**2 * np.ones((8, 1)),
        "thumb.distal": 1e6 * np.ones((8, 10)),
    }
    got = features(_step(_felt((), np.zeros(15)), faint), "surface", design=DESIGN, layout=PAPER_22).analog
    assert got["surface.range"] == pytest.approx(0.1 / 0.5, rel=1e-3)
    assert got["surface.spread"] == pytest.approx(0.05 / 0.5, rel=1e-3)
    none = features(_step(_felt((), np.zeros(15)), {}), "surface", design=DESIGN, layout=PAPER_22).analog
    assert set(none.values()) == {0.0}


def test_coordinates_go_by_pads_where_the_surface_is_felt_and_by_switches_where_contact_is() -> None:
    angles = angles_at(0.05, -0.03)
    pressed = np.zeros((8, 10))
    pressed[:, 8] = 1.0
    step = _step(_felt(("index_distal", "thumb_distal", "thumb_middle"), angles), {"index.distal": pressed})
    by_switch = features(step, "contact+coordinates", design=DESIGN, layout=PAPER_22)
    by_pad = features(step, "surface+coordinates", design=DESIGN, layout=PAPER_22)
    contacts = contact_points(step.sensed, DESIGN, PAPER_22)
    circle = grip_circle(contacts)
    assert circle is not None
    size = max(circle.diameter_m, 0.02)
    assert by_switch.analog["coordinate.thumb.distal.off"] == pytest.approx(abs(circle.off_m[-1]) / size)
    # One pad alone makes no circle.
    assert by_pad.analog["coordinate.off"] == 0
    assert not by_pad.on_off
    assert by_switch.on_off["switch.thumb_middle"]
    # A grip that has closed to nothing counts as two centimetres.
    near = contact_points(_felt(("index_distal", "thumb_distal"), angles_at(0.004, -0.004)), DESIGN, PAPER_22)
    small = grip_circle(near)
    assert small is not None
    tight = _step(_felt(("index_distal", "thumb_distal"), angles_at(0.004, -0.004)), {})
    told = features(tight, "contact+coordinates", design=DESIGN, layout=PAPER_22).analog
    beyond = np.maximum(np.abs(small.beside_m) - near.slack_m, 0).max() / max(small.diameter_m, 0.02)
    assert told["coordinate.beyond"] == pytest.approx(beyond)


# Pictures


class Drawing:
    """Stands for MuJoCo: notes how it is asked to draw."""

    def __init__(self) -> None:
        self.rendered: list[Any] = []
        for name in ("mjFontScale", "mjtFramebuffer", "mjtCatBit"):
            setattr(self, name, SimpleNamespace())
        self.mjtFontScale = SimpleNamespace(mjFONTSCALE_100=SimpleNamespace(value=100))
        self.mjtFramebuffer = SimpleNamespace(mjFB_OFFSCREEN=SimpleNamespace(value=1))
        self.mjtCatBit = SimpleNamespace(mjCAT_ALL=SimpleNamespace(value=7))
        self.MjvOption, self.MjvPerturb = SimpleNamespace, SimpleNamespace
        self.MjvCamera = lambda: SimpleNamespace(lookat=np.zeros(3), azimuth=0.0, elevation=0.0, distance=0.0)
        self.freed = 0

    def MjrContext(self, model: Any, scale: int) -> Any:
        assert scale == 100
        return SimpleNamespace(free=self._free)

    def _free(self) -> None:
        self.freed += 1

    def mjr_setBuffer(self, buffer: int, context: Any) -> None:
        self.buffer = buffer

    def MjvScene(self, model: Any, maxgeom: int) -> Any:
        # A hand, an object of forty hulls and their reflections.
        assert maxgeom >= 200
        return "scene"

    def mjv_updateScene(self, model: Any, data: Any, *rest: Any) -> None:
        self.view = rest[2]
        assert rest[3:] == (7, "scene")

    def MjrRect(self, *corner: int) -> tuple[int, ...]:
        return corner

    def mjr_render(self, frame: Any, scene: Any, context: Any) -> None:
        self.rendered.append(frame)

    def mjr_readPixels(self, picture: np.ndarray, depth: Any, frame: Any, context: Any) -> None:
        picture[:] = np.arange(len(picture), dtype=np.uint8)[:, None, None]


def _photographed(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Drawing, Any, list[int]]:
    drawing, freed = Drawing(), []
    monkeypatch.setattr(pictures, "require_mujoco", lambda: drawing)
    monkeypatch.setattr(pictures, "_context", lambda w, h: SimpleNamespace(free=lambda: freed.append(1), size=(w, h)))
    bench = ScriptedBench()
    names = [switch.name for switch in PAPER_22.switches if switch.part == "palm"]
    firsts = {part: (10 * k, 1 + part.startswith("thumb")) for k, part in enumerate(DESIGN.joints)}
    bench.model = SimpleNamespace(  # type: ignore[misc]
        vis=SimpleNamespace(global_=SimpleNamespace(offwidth=0, offheight=0)),
        geom=lambda name: SimpleNamespace(id=200 + names.index(name)),
        body=lambda part: SimpleNamespace(geomadr=[firsts[part][0]], geomnum=[firsts[part][1]]),
        geom_rgba=np.zeros((250, 4)),
    )
    bench.data = None  # type: ignore[misc]
    return bench, drawing, firsts, freed


def test_a_picture_is_taken_from_beside_the_carriage(monkeypatch: pytest.MonkeyPatch) -> None:
    bench, drawing, firsts, freed = _photographed(monkeypatch)
    taker = pictures.Photographer(bench)
    assert (bench.model.vis.global_.offwidth, bench.model.vis.global_.offheight) == (420, 420)
    bench.target |= {"reach": 0.1, "shift": -0.2, "turn": 0.5}
    bench.closed[:] = np.array([name in ("palm_centre", "thumb_distal") for name in PAPER_22.names])
    picture = taker.take(bench)
    assert picture.shape == (420, 420, 3)
    # Rows come from below.
    np.testing.assert_array_equal(picture[:, 0, 0], np.arange(420).astype(np.uint8)[::-1])
    assert drawing.rendered == [(0, 0, 420, 420)]
    assert drawing.view.azimuth == pytest.approx(232 + math.degrees(0.5))
    assert (drawing.view.elevation, drawing.view.distance) == (-30.0, 0.5)
    np.testing.assert_allclose(drawing.view.lookat, [0.1 + 0.05 * math.cos(0.5), -0.2 + 0.05 * math.sin(0.5), 0.0])
    # Closed switches are red: both capsules of the thumb, a button; the others have their own colour.
    red = np.array([0.86, 0.27, 0.22, 1])
    rgba = bench.model.geom_rgba
    first, count = firsts["thumb.distal"]
    np.testing.assert_allclose(rgba[first : first + count], [red] * 2)
    centre = [s.name for s in PAPER_22.switches if s.part == "palm"].index("palm_centre")
    np.testing.assert_allclose(rgba[200 + centre], red)
    np.testing.assert_allclose(rgba[200], (0.22, 0.28, 0.36, 1))
    np.testing.assert_allclose(rgba[firsts["index.middle"][0]], (0.38, 0.50, 0.66, 1))
    assert not rgba[firsts["index.middle"][0] + 1].any()
    taker.close()
    assert (freed, drawing.freed) == ([1], 1)
    aside = pictures.Camera(10.0, -5.0, 0.7, (0.1, 0.02, 0.03), 64, 48)
    taker = pictures.Photographer(bench, aside)
    assert taker.take(bench).shape == (48, 64, 3)
    c, s = math.cos(0.5), math.sin(0.5)
    told = [0.1 + c * 0.1 - s * 0.02, -0.2 + s * 0.1 + c * 0.02, 0.03]
    np.testing.assert_allclose(drawing.view.lookat, told)
    drawing.MjrContext = lambda *a: (_ for _ in ()).throw(RuntimeError("no screen"))  # type: ignore[method-assign]
    with pytest.raises(MissingExtraError, match=r"OpenGL cannot draw without a screen here \(no screen\)"):
        pictures.Photographer(bench)


def test_a_way_to_draw_is_tried_after_another_unless_one_is_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[str] = []

    def load(name: str) -> Any:
        tried.append(name)
        if name != "mujoco.osmesa":
            raise ImportError("not here")
        return SimpleNamespace(GLContext=lambda w, h: SimpleNamespace(make_current=lambda: None, size=(w, h)))

    monkeypatch.setattr(pictures.importlib, "import_module", load)
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setenv("PYOPENGL_PLATFORM", "egl")
    assert pictures._context(3, 4).size == (3, 4)
    assert tried == ["mujoco.egl", "mujoco.osmesa"]
    assert "PYOPENGL_PLATFORM" not in pictures.os.environ
    monkeypatch.setenv("MUJOCO_GL", "EGL")
    monkeypatch.setenv("PYOPENGL_PLATFORM", "egl")
    tried.clear()
    with pytest.raises(MissingExtraError, match=r"draw without a screen here \(egl: not here\)"):
        pictures._context(3, 4)
    assert tried == ["mujoco.egl"]
    assert pictures.os.environ["PYOPENGL_PLATFORM"] == "egl"


def test_pictures_are_laid_row_by_row_on_white() -> None:
    one = [np.full((4, 5, 3), k, np.uint8) for k in range(1, 6)]
    sheet = pictures.tile(one, columns=3, gap=2)
    assert sheet.shape == (2 * 6 + 2, 3 * 7 + 2, 3)
    for k in range(5):
        top, left = 2 + 6 * (k // 3), 2 + 7 * (k % 3)
        assert (sheet[top : top + 4, left : left + 5] == k + 1).all()
    white = (sheet == 255).all(axis=2)
    assert white.sum() == sheet.shape[0] * sheet.shape[1] - 5 * 20
    assert pictures.tile(one[:1], columns=1).shape == (16, 17, 3)


def test_a_photograph_shows_the_last_attempt(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    shots: list[Any] = []
    closed: list[int] = []

    class Taker:
        def __init__(self, bench: Any, camera: Any) -> None:
            shots.append(camera)

        def take(self, bench: Any) -> np.ndarray:
            return np.full((2, 3, 3), len(shots), np.uint8)

        def close(self) -> None:
            closed.append(1)

    numbers = [1, 2, 1, 2, 3]
    told: dict[str, Any] = {}

    def grasp(name: str, size_m: float, **how: Any) -> str:
        told.update(how, name=name, size_m=size_m)
        for number in numbers:
            how["watch"]("bench", SimpleNamespace(number=number))
        return "done"

    laid: list[tuple[int, int]] = []
    monkeypatch.setattr(pictures, "Photographer", Taker)
    monkeypatch.setattr(pictures, "grasp", grasp)
    monkeypatch.setattr(
        pictures, "tile", lambda taken, columns: laid.append((len(taken), columns)) or np.zeros((4, 4, 3), np.uint8)
    )
    path = tmp_path / "a.png"
    assert pictures.photograph("cone", 0.06, path, seed=2, camera="camera") == "done"  # type: ignore[arg-type]
    assert path.read_bytes().startswith(b"\x89PNG")
    assert (laid, shots, closed) == ([(3, 3)], ["camera"], [1])
    assert (told["name"], told["size_m"], told["seed"], told["pad_steps"]) == ("cone", 0.06, 2, (5,))
    numbers[:] = [1, 2, 3, 4, 5, 6]
    pictures.photograph("cone", 0.06, path, seed=2)
    assert laid[-1] == (6, 5)
    numbers.clear()
    with pytest.raises(InputError, match="no picture: the hand did not find the cone; try another seed"):
        pictures.photograph("cone", 0.06, path, seed=2)


# Tables


def _row(job: Job, number: int, held: bool) -> dict[str, Any]:
    row: dict[str, Any] = {"object": job.name, "size_m": job.size_m, "seed": job.seed, "step": number, "held": held}
    row |= {"attempts": 1, "finger_scale": 1.0, "searched": 0, "still": 0}
    return row | {f"switch.{name}": held for name in PAPER_22.names} | {"angle_rad.x": 0.1, "force_n.y": 0.2}


class Made:
    """Stands for the grasps; some end early."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, early: Sequence[int] = ()) -> None:
        self.jobs: list[Job] = []

        def grasp(name: str, size_m: float, *, seed: int, setting: Any) -> Job:
            self.jobs.append(Job(name, size_m, seed))
            return self.jobs[-1]

        def rows(done: Job, setting: Any, *, steps: Sequence[int]) -> list[dict[str, Any]]:
            return [_row(done, 0, False)] if done.seed in early else [_row(done, step, True) for step in steps]

        monkeypatch.setattr(collecting, "grasp", grasp)
        monkeypatch.setattr(collecting, "grasp_rows", rows)


JOBS = [Job("cylinder", 0.08, seed) for seed in range(5)]


def test_a_collection_is_carried_on_and_keeps_what_was_not_asked_for_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = tmp_path / "t.csv"
    made = Made(monkeypatch, early=(1,))
    collect_grasps(JOBS[:3], path, steps=(2, 5), processes=1)
    assert made.jobs == JOBS[:3]
    made.jobs.clear()
    counts: list[tuple[int, int]] = []
    table = collect_grasps(
        [JOBS[4], JOBS[1], JOBS[4]], path, steps=(2, 5), processes=1, progress=lambda d, w: counts.append((d, w))
    )
    assert made.jobs == [JOBS[4]]
    # What is asked for comes first, what else is there after it.
    assert table.cells["seed"].tolist() == [4, 4, 1, 0, 0, 2, 2]
    assert counts == [(2, 2)]
    assert read_grasp_table(path).cells["seed"].tolist() == table.cells["seed"].tolist()
    made.jobs.clear()
    anew = collect_grasps(JOBS[:1], path, steps=(2, 5), processes=1, anew=True)
    assert made.jobs == JOBS[:1]
    assert len(anew) == 2
    path.write_text("")
    assert len(collect_grasps(JOBS[:1], path, processes=1)) == 1


def test_a_table_is_renewed_every_ten_seconds_and_when_a_run_is_stopped(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    Made(monkeypatch)
    now = [0.0]
    monkeypatch.setattr(collecting.time, "monotonic", lambda: now[0])
    path, lengths = tmp_path / "t.csv", []

    def progress(done: int, wanted: int) -> None:
        lengths.append(len(path.read_text().splitlines()) if path.exists() else 0)
        now[0] += 6.0

    collect_grasps(JOBS, path, processes=1, progress=progress)
    # Saved after the second and the fourth grasp.
    assert lengths == [0, 0, 3, 3, 5]

    def stop(done: int, wanted: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        collect_grasps(JOBS, tmp_path / "u.csv", processes=1, progress=stop)
    assert len(read_grasp_table(tmp_path / "u.csv")) == 1
    # Stopped before anything was made, it leaves nothing.
    monkeypatch.setattr(collecting, "grasp", stop)
    with pytest.raises(TypeError):
        collect_grasps(JOBS, tmp_path / "v.csv", processes=1)
    assert not (tmp_path / "v.csv").exists()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda t: t.replace("finger_scale", "scale"), "has no column 'finger_scale', so that it cannot be carried on"),
        (lambda t: t.replace("step", "stage"), "has no column 'step'"),
        (lambda t: t.replace("cylinder,0.08,1,", "cylinder,0.08,,"), "column 'seed' has an empty cell"),
        (lambda t: t.replace("cylinder,0.08,1,5", "cylinder,0.08,1,4"), r"holds steps \[4\] of cylinder, not \[5\]"),
    ],
)
def test_what_cannot_be_carried_on_is_told(
    change: Any, says: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    Made(monkeypatch)
    path = tmp_path / "t.csv"
    collect_grasps(JOBS[:3], path, processes=1)
    path.write_text(change(path.read_text()))
    with pytest.raises(InputError, match=says):
        collect_grasps(JOBS[:3], path, processes=1)


def test_lines_of_another_collection_are_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    Made(monkeypatch)
    path = tmp_path / "t.csv"
    collect_grasps(JOBS[:3], path, processes=1)
    with pytest.raises(InputError, match=r"t\.csv: was collected with another still than 1 \(line 2\)"):
        collect_grasps(JOBS[:3], path, setting=HandSetting(still=True), processes=1)
    scaled = replace(HandSetting(), design=DESIGN.scaled(1.1))
    with pytest.raises(InputError, match=r"another finger_scale than 1\.1 \(line 2\)"):
        collect_grasps(JOBS[:3], path, setting=scaled, processes=1)
    # An early end at whatever step is carried on: those of step 0 and of fewer steps are held by no hand.
    text = path.read_text().splitlines()
    head = text[0].split(",")
    cells = text[3].split(",")
    cells[head.index("step")], cells[head.index("held")] = "3", "0"
    path.write_text("\n".join([*text[:3], ",".join(cells)]) + "\n")
    assert len(collect_grasps(JOBS[:3], path, processes=1)) == 3


@pytest.mark.parametrize(
    ("count", "processes", "told"),
    [
        (3, 8, (1, 1)),
        (4, 8, (4, 1)),
        (100, 2, (2, 12)),
        (1000, 2, (2, 16)),
        (9, 1, (1, 2)),
    ],
)
def test_jobs_are_spread_in_pieces(
    count: int, processes: int, told: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Any] = []

    def spread(work: Any, jobs: Sequence[Job], *, processes: int, chunk: int) -> Any:
        seen.append((processes, chunk))
        return iter(map(work, jobs))

    monkeypatch.setattr(collecting, "spread", spread)
    jobs = [Job("cylinder", 0.08, seed) for seed in range(count)]
    assert list(run_jobs(jobs, lambda job: job.seed, processes=processes)) == list(range(count))
    assert seen == [told]
    assert list(run_jobs(jobs[:2], lambda job: job.seed)) == [0, 1]
    monkeypatch.setattr(collecting.os, "sched_getaffinity", lambda _: {0, 1, 2})
    list(run_jobs([Job("cone", 0.06, k) for k in range(20)], lambda job: job.seed))
    assert seen[-1] == (3, 1)
