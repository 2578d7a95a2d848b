"""A felt surface in words and drawn: plain projections beside the program's."""

from __future__ import annotations

import json
import math
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
pytest.importorskip("scipy", reason="SciPy is not installed; pip install -e '.[skin]'")

from varishold.exploration import SurfaceTouch
from varishold.perceive import SurfaceMesh
from varishold.perceive.contour_mesh import contour_mesh
from varishold.report import surface_drawing as drawing
from varishold.report.axonometry import AZIMUTH, ELEVATION
from varishold.report.colours import css, darker
from varishold.report.scene_data import STEP_M, SceneData
from varishold.report.surface_words import surface_in_words, surface_touch_in_words

GAP = "\u202f"


@pytest.mark.parametrize(
    ("touch", "points", "sigma_m", "said"),
    [
        (SurfaceTouch("search"), 0, math.nan, "searched and gripped it: 0 points; no surface yet"),
        (SurfaceTouch("search"), 1, 0.00234, "searched and gripped it: 1 point; known to 2.3 mm on the mean"),
        (
            SurfaceTouch("grip", math.pi / 3, 0.0454),
            2,
            0.012,
            "gripped it from 60°, palm 45 mm over its zero: 2 points; known to 12.0 mm on the mean",
        ),
        (
            SurfaceTouch("grip", -math.pi / 2, -0.02),
            11,
            math.nan,
            "gripped it from −90°, palm −20 mm over its zero: 11 points; no surface yet",
        ),
        (
            SurfaceTouch("fingertip", math.pi, 0.07),
            1,
            0.001,
            "came down with a fingertip from 180°: 1 point; known to 1.0 mm on the mean",
        ),
    ],
)
def test_a_touch_is_told_in_these_words(touch: SurfaceTouch, points: int, sigma_m: float, said: str) -> None:
    assert surface_touch_in_words(touch, points, sigma_m) == said


def ball(steps: int = 15) -> SurfaceMesh:
    pitch = 0.1 / (steps - 1)
    ways = [pitch * (np.arange(steps) - (steps - 1) / 2)] * 3
    level = np.linalg.norm(np.stack(np.meshgrid(*ways, indexing="ij"), axis=-1), axis=-1) - 0.04
    vertices, faces = contour_mesh(level, np.array([0.05, 0.1, 0.0]), pitch)
    return SurfaceMesh(vertices, faces, 0.001 + 0.1 * np.abs(vertices[:, 0] - 0.1))


def felt(mesh: SurfaceMesh) -> Any:
    """A surface that was touched at six places, out of which each lies 1 mm."""
    out = np.vstack([np.eye(3), -np.eye(3)])
    points = np.array([0.1, 0.15, 0.05]) + 0.041 * out
    touches = [SimpleNamespace(point_m=points[k : k + 3], normal=out[k : k + 3]) for k in (0, 3)]
    surface = SimpleNamespace(
        least_known=lambda _: (np.array([0.1234, -0.0216, 0.0]), 0.00346), mesh=lambda *, steps: (steps, mesh)[1]
    )
    return SimpleNamespace(
        mesh=mesh,
        felt=tuple(touches),
        touches=(SurfaceTouch("search"), SurfaceTouch("grip", math.pi / 2, 0.01)),
        history_m=(math.nan, 0.0026),
        surface=surface,
    )


def test_the_whole_is_told_in_these_words() -> None:
    some = felt(ball())
    volume = 1e6 * some.mesh.volume_m3
    assert 240 < volume < 268.1
    assert surface_in_words(some) == (
        f"The surface after 2 touches: {volume:.0f} cm³ within, known to 2.6 mm on the mean, "
        "worst to 3.5 mm at (123, −22, 0) mm"
    )


def test_colours_stand_for_what_most_of_the_surface_has() -> None:
    mesh = ball()
    low, high = np.quantile(mesh.sigma_m, [0.02, 0.98])
    assert high > 1.5 * low
    least, colours, most = drawing.sigma_key(felt(mesh))
    assert (least, most) == (f"{1e3 * low:.1f}{GAP}mm", f"{1e3 * high:.1f}{GAP}mm")
    assert colours == tuple(darker(css(0.3 + 0.7 * part), 1.0) for part in (0.0, 0.25, 0.5, 0.75, 1.0))
    even = SurfaceMesh(mesh.vertices_m, mesh.faces, np.full(len(mesh.vertices_m), 0.002))
    assert drawing.sigma_key(felt(even))[::2] == (f"2.0{GAP}mm", f"3.0{GAP}mm")


def seen_from(azimuth: float, places: np.ndarray) -> np.ndarray:
    """Right, up and toward the eye, of an object that is turned first and then tipped forward."""
    x, y, z = places.T
    right = math.cos(azimuth) * x - math.sin(azimuth) * y
    near = -math.sin(azimuth) * x - math.cos(azimuth) * y
    up = math.cos(ELEVATION) * z - math.sin(ELEVATION) * near
    return np.column_stack([right, up, math.sin(ELEVATION) * z + math.cos(ELEVATION) * near])


@pytest.mark.parametrize("azimuth", [0.0, 0.4, 2.0, -2.5])
def test_a_drawing_holds_the_faces_that_look_here_from_far_to_near(azimuth: float) -> None:
    mesh = ball(9)
    some = felt(mesh)
    text = str(drawing.surface_drawing(some, mesh, azimuth, side="the <side>"))
    drawn = re.findall(r'<path color="([^"]+)" d="M(\S+) (\S+)L(\S+) (\S+)L(\S+) (\S+)z"/>', text)
    view = seen_from(azimuth, mesh.vertices_m)
    low, high = view[:, :2].min(axis=0), view[:, :2].max(axis=0)
    scale = (300 - 2 * 22) / (high - low).max()
    on_screen = [180, 150] + scale * (view[:, :2] - (low + high) / 2) * [1, -1]
    light = np.array([-0.5, 0.75, 0.6]) / math.sqrt(0.25 + 0.5625 + 0.36)
    least, most = np.quantile(mesh.sigma_m, [0.02, 0.98])
    expected = []
    for face in mesh.faces:
        a, b, c = view[face]
        normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
        if normal[2] <= 1e-3:
            continue
        known = min(1.0, max(0.0, (mesh.sigma_m[face].mean() - least) / (most - least)))
        tone = min(1.0, max(0.0, float(normal @ light)))
        colour = darker(css(0.3 + 0.7 * round(12 * known) / 12), 0.55 + 0.45 * round(6 * tone) / 6)
        expected.append((view[face, 2].mean(), colour, on_screen[face].ravel()))
    assert len(drawn) == len(expected)
    expected.sort(key=lambda each: each[0])
    places = np.array([[float(x) for x in each[1:]] for each in drawn])
    # Faces that are as far away may change places.
    for _, colour, corners in expected:
        match = np.flatnonzero(np.abs(places - corners).max(axis=1) < 0.0501)
        assert any(drawn[k][0] == colour for k in match)
    ranks = [np.abs(places - corners).max(axis=1).argmin() for *_, corners in expected]
    depth = np.array([each[0] for each in expected])
    assert np.abs(depth[np.argsort(ranks, kind="stable")] - depth).max() < 1e-3
    assert "The surface from the &lt;side&gt;: " in text


@pytest.mark.parametrize("azimuth", [0.3, 2.2])
def test_a_drawing_shows_the_points_that_the_surface_does_not_hide(azimuth: float) -> None:
    mesh = ball(45)
    some = felt(mesh)
    text = str(drawing.surface_drawing(some, mesh, azimuth, side="here"))
    dots = np.array(re.findall(r'<circle cx="([^"]+)" cy="([^"]+)" r="1.7"/>', text), dtype=float)
    points = np.vstack([each.point_m for each in some.felt])
    normals = seen_from(azimuth, np.vstack([each.normal for each in some.felt]))
    view, corners = seen_from(azimuth, points), seen_from(azimuth, mesh.vertices_m)
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    scale = 256 / (high - low).max()
    on_screen = [180, 150] + scale * (view[:, :2] - (low + high) / 2) * [1, -1]
    shown = on_screen[normals[:, 2] > 0]
    assert len(shown) == 3
    np.testing.assert_allclose(dots, shown, atol=0.051)
    assert "3 of the points that were touched lie on this side" in text
    # One that lies deep within is hidden, whichever way it looks.
    eye = seen_from(azimuth, np.eye(3))[:, 2]
    # Its own are those up to 4 mm behind the surface, and a twentieth of the drawing's breadth more.
    for behind, count in ((0.04, 3), (0.0085, 3), (0.0075, 4), (-0.001, 4)):
        deep = SimpleNamespace(point_m=[np.array([0.1, 0.15, 0.05]) + (0.04 - behind) * eye], normal=eye[None])
        some_more = SimpleNamespace(**{**vars(some), "felt": (*some.felt, deep)})
        assert str(drawing.surface_drawing(some_more, mesh, azimuth, side="here")).count("<circle") == count


def test_a_pane_holds_two_sides_the_key_and_each_touch() -> None:
    mesh = ball(9)
    some = felt(mesh)
    steps: list[int] = []
    some.surface.mesh = lambda *, steps_=steps, steps: (steps_.append(steps), mesh)[1]
    scenes = SceneData()
    pane = drawing.surface_pane(some, scenes)
    assert steps == [24]
    told = json.loads(scenes.markup or "")
    (scene,) = told["scenes"]
    surface, *points = scene["bodies"]
    assert np.array(told["meshes"][0][0]).reshape(-1, 3) == pytest.approx(mesh.vertices_m / STEP_M, abs=0.5001)
    # Least known is lightest, on the scale of the key; three points a touch.
    colours = np.array(surface[4]).reshape(-1, 3)
    assert len(colours) == len(mesh.faces)
    least, most = drawing._sigma_range_m(some)
    known = np.clip((mesh.sigma_m[mesh.faces].mean(axis=1) - least) / (most - least), 0, 1)
    of_key = [tuple(bytes.fromhex(colour[1:])) for colour in drawing.sigma_key(some)[1]]
    for share, colour in ((0.0, of_key[0]), (1.0, of_key[-1])):
        for face in np.flatnonzero(np.abs(known - share) < 0.04):
            assert tuple(colours[face].tolist()) == colour
    assert len(points) == sum(len(each.point_m) for each in some.felt)
    assert pane["said"] == surface_in_words(some) + "."
    assert pane["key"] == drawing.sigma_key(some)
    assert pane["drawings"] == [
        drawing.surface_drawing(some, mesh, AZIMUTH, side="the front"),
        drawing.surface_drawing(some, mesh, AZIMUTH + math.pi, side="behind"),
    ]
    assert pane["touches"] == [
        "Searched and gripped it: 3 points; no surface yet.",
        "Gripped it from 90°, palm 10 mm over its zero: 3 points; known to 2.6 mm on the mean.",
    ]
