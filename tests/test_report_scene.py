"""The turned scene of a page: what a script draws is what the simulation's own pictures show."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from benchmarks._chromium import Chromium, chromium_program
from varishold.errors import MissingExtraError
from varishold.exploration import Exploration, perceive
from varishold.hand import Bench, HandSetting, PadSetting, Step
from varishold.hand.picture import Photographer
from varishold.hand.scene import Scene, take_scene
from varishold.perceive import Perceiver, library_file
from varishold.perceive.contour_mesh import SurfaceMesh
from varishold.report import render_perceive_report
from varishold.report.page import render_page
from varishold.report.photo import Photo
from varishold.report.scene_data import CAMERA, STEP_M, SceneData

needs_library = pytest.mark.skipif(
    not library_file._SHIPPED.is_file(), reason="no library of objects is shipped; python -m training.objects makes it"
)
SETTING = HandSetting(pads=PadSetting())
Seen = tuple[Exploration, list[Scene], list[Photo]]


@pytest.fixture(scope="module")
def seen() -> Seen:
    """A grasp and a fingertip, their scenes, and their pictures where something here can draw."""
    scenes: list[Scene] = []
    photos: list[Photo] = []
    photographer: list[Photographer] = []

    def watch(bench: Bench, step: Step) -> None:
        scenes.append(take_scene(bench))
        try:
            photographer[:] = photographer or [Photographer(bench, CAMERA)]
            photos.append(photographer[0].take(bench))
        except MissingExtraError:
            pass

    made = perceive(
        "hexagonal-prism",
        0.06,
        seed=4,
        perceiver=Perceiver(error=1e-12, least_touches=2),
        setting=SETTING,
        order=("grasp", "fingertip-middle"),
        watch=watch,
    )
    for each in photographer:
        each.close()
    return made, scenes, photos


@pytest.fixture(scope="module")
def browser() -> Iterator[Chromium]:
    if chromium_program() is None:
        pytest.skip("there is no Chromium here")
    with Chromium(1240, 900) as chromium:
        yield chromium
        assert chromium.problems == []


def opened(browser: Chromium, path: Path, seen: Seen, *, photos: bool = True) -> None:
    made, scenes, pictures = seen
    page = render_perceive_report(made, setting=SETTING, scenes=scenes, pictures=pictures if photos else ())
    path.write_text(page, "utf-8")
    browser.open(path.as_uri())


def drawn(browser: Chromium, number: int = 0) -> np.ndarray:
    """What stands on a canvas, shape (400, 480, 4)."""
    pixels = browser.value(
        f"(() => {{ const c = document.querySelectorAll('.scene')[{number}];"
        "const small = document.createElement('canvas'); small.width = 480; small.height = 400;"
        "const p = small.getContext('2d'); p.drawImage(c, 0, 0, 480, 400);"
        "return btoa(Array.from(p.getImageData(0, 0, 480, 400).data, x => String.fromCharCode(x)).join('')); })()"
    )
    return np.frombuffer(base64.b64decode(pixels), np.uint8).reshape(400, 480, 4)


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    return float((a & b).sum() / (a | b).sum())


def is_red(picture: np.ndarray) -> np.ndarray:
    red, green, blue = np.moveaxis(picture[..., :3].astype(float), -1, 0)
    return (red > 1.8 * green) & (red > 1.8 * blue) & (red > 60)


def is_wood(picture: np.ndarray) -> np.ndarray:
    red, green, blue = np.moveaxis(picture[..., :3].astype(float), -1, 0)
    return (red > 1.08 * green) & (red < 1.6 * green) & (green > 1.2 * blue)


@needs_library
def test_the_first_look_is_that_of_the_picture(browser: Chromium, seen: Seen, tmp_path: Path) -> None:
    if not seen[2]:
        pytest.skip("nothing here can draw a picture without a screen")
    opened(browser, tmp_path / "page.html", seen)
    for number, photo in enumerate(seen[2]):
        canvas = drawn(browser, number)
        assert overlap(is_wood(canvas) & (canvas[..., 3] > 128), is_wood(photo)) > 0.94
        assert overlap(is_red(canvas) & (canvas[..., 3] > 128), is_red(photo)) > 0.88
    hidden = "[...document.querySelectorAll('.photo')].every(photo => photo.hidden)"
    assert browser.value(hidden)


@needs_library
def test_it_is_turned_brought_nearer_and_put_back(browser: Chromium, seen: Seen, tmp_path: Path) -> None:
    opened(browser, tmp_path / "page.html", seen)
    first = drawn(browser)
    browser.value("document.querySelector('.scene').focus()")
    at_rest = "document.querySelector('.scene').width === 960"

    def after(*keys: str) -> np.ndarray:
        for key in keys:
            browser.press(key)
        browser.wait("document.querySelector('.scene').width === 480")
        browser.wait(at_rest)
        return drawn(browser)

    turned = after("ArrowRight", "ArrowRight")
    assert (turned != first).any(axis=-1).mean() > 0.05
    assert (drawn(browser, 1) == drawn(browser, 1)).all()
    nearer = after("Home", "+", "+", "+")
    assert (nearer[..., 3] > 0).sum() > 1.2 * (first[..., 3] > 0).sum()
    assert (after("Home") == first).all()
    # Seen from straight above, and no farther.
    above = after(*["ArrowUp"] * 40)
    assert (after("ArrowUp") == above).all()


@needs_library
def test_without_pictures_the_scene_stands_alone(browser: Chromium, seen: Seen, tmp_path: Path) -> None:
    opened(browser, tmp_path / "page.html", seen, photos=False)
    assert browser.value("[...document.querySelectorAll('figure')].every(figure => !figure.hidden)")
    assert browser.value("document.querySelectorAll('img.photo').length") == 0
    assert (drawn(browser)[..., 3] > 0).mean() > 0.1


@needs_library
def test_a_page_without_its_script_shows_the_pictures(seen: Seen) -> None:
    made, scenes, _ = seen
    pictures = [np.full((40, 48, 3), 200, np.uint8)] * 2
    page = render_perceive_report(made, setting=SETTING, scenes=scenes, pictures=pictures)
    assert page.count('class="photo still"') == page.count('<canvas class="scene"') == 2
    assert all("hidden" in canvas for canvas in re.findall(r"<canvas[^>]*>", page))
    assert not any("hidden" in image for image in re.findall(r"<img[^>]*>", page))
    # One scene too few is none at all: none would stand with its touch.
    without = render_perceive_report(made, setting=SETTING, scenes=scenes[:1], pictures=pictures)
    assert "<canvas" not in without
    assert "<script" not in without


@needs_library
def test_a_mesh_is_told_once(seen: Seen) -> None:
    data = SceneData()
    for scene in seen[1]:
        data.add_scene(scene)
    told = json.loads(data.markup or "")
    assert len(told["meshes"]) == 1
    assert [body[1] for scene in told["scenes"] for body in scene["bodies"] if body[0] == "mesh"] == [0, 0]
    mesh = next(body for body in seen[1][0] if body.kind == "mesh")
    assert mesh.corners_m is not None
    flat, faces = told["meshes"][0]
    assert np.array(flat).reshape(-1, 3) * STEP_M == pytest.approx(mesh.corners_m, abs=0.5 * STEP_M + 1e-12)
    assert max(faces) == len(flat) // 3 - 1
    placed = [body[2] for body in told["scenes"][0]["bodies"]]
    assert np.array(placed) * STEP_M == pytest.approx(
        np.array([b.place_m for b in seen[1][0]]), abs=0.5 * STEP_M + 1e-9
    )
    assert told["scenes"][0]["distance"] == CAMERA.distance_m


def test_nothing_is_told_of_no_scene() -> None:
    assert SceneData().markup is None


def test_a_surface_is_seen_whole_with_a_colour_for_each_face_and_its_points(browser: Chromium, tmp_path: Path) -> None:
    corners = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]) * 0.03 + [0.2, 0, 0]
    faces = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    colours = np.zeros((8, 3), np.uint8)
    colours[:4, 1] = 200
    colours[4:, 2] = 200
    data = SceneData()
    data.add_surface(SurfaceMesh(corners, faces, np.ones(6)), colours, corners[4:5])
    page = render_page(
        "perceive.html", title="", answer="", truth="", right="open", facts=[], notes=[], chart=None, narrow_chart=None,
        cards=[], senses=[], turned=False, scenes=data.markup, surface_colours=[],
        felt={"said": "", "drawings": ["", ""], "key": ("", (), ""), "touches": []},
    )  # fmt: skip
    path = tmp_path / "page.html"
    path.write_text(page, "utf-8")
    browser.open(path.as_uri())
    canvas = drawn(browser)
    shown = canvas[..., 3] > 128
    assert shown.mean() > 0.12
    assert not shown[[0, -1]].any()
    assert not shown[:, [0, -1]].any()
    red, green, blue = np.moveaxis(canvas[..., :3].astype(int), -1, 0)
    rows, _ = np.nonzero(shown & (green > blue) & (red < green))
    below, _ = np.nonzero(shown & (blue > green))
    # The eye stands above: the upper half is green, and what is seen of the lower half is below it.
    assert rows.mean() < below.mean()
    assert len(rows) > len(below) > 0
    points, _ = np.nonzero(shown & (red > 150) & (green > 150))
    assert 0 < len(points) < 400
    assert points.mean() < rows.mean()
