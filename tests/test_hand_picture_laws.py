"""Pictures of a grasp, drawn by what stands for MuJoCo."""

from __future__ import annotations

import importlib
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.scripted_bench import ScriptedBench

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.errors import InputError, MissingExtraError
from varishold.hand import HandDesign
from varishold.hand import picture as pictures
from varishold.hand.layouts import PAPER_22

DESIGN = HandDesign()
collecting = importlib.import_module("varishold.hand.collect")


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
        geom_rgba=np.zeros((250, 4)),
    )
    bench.data = None  # type: ignore[misc]
    shown = {
        switch.name: np.array([200 + names.index(switch.name)])
        if switch.part == "palm"
        else firsts[switch.part][0] + np.arange(firsts[switch.part][1])
        for switch in PAPER_22.switches
    }
    bench.wiring = SimpleNamespace(shown=shown)  # type: ignore[assignment]
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
