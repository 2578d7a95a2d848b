"""Meshes as solids: what is read, what is mended or refused, and that convex parts fill what the mesh encloses."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("trimesh", reason="trimesh is not installed; pip install -e '.[meshes]'")
pytest.importorskip("coacd", reason="coacd is not installed; pip install -e '.[meshes]'")
pytest.importorskip("networkx")

import trimesh
from examples.household_meshes import FORMS, make_meshes
from scipy.spatial import ConvexHull

from hostile.meshes import meshes
from varishold.errors import FormatError, InputError, MissingExtraError
from varishold.solids import MeshSolid, Part, mesh_apart
from varishold.solids.mesh_file import TriangleMesh, is_mesh_file, read_mesh
from varishold.solids.mesh_parts import convex_parts

SIZE_M = 0.08


def triangles(mesh: Any) -> TriangleMesh:
    return TriangleMesh(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))


def volume_of(parts: tuple[Part, ...]) -> float:
    return float(sum(ConvexHull(np.array(part.corners_m)).volume for part in parts))


def entered(parts: tuple[Part, ...], origins: np.ndarray, direction: np.ndarray) -> np.ndarray:
    return np.asarray(np.min([part.hits(origins, direction) for part in parts], axis=0))


@pytest.fixture(scope="module")
def household(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return make_meshes(tmp_path_factory.mktemp("household"), size_m=SIZE_M)


@pytest.mark.parametrize("name", FORMS)
def test_the_ten_things_close_stand_on_the_table_and_are_of_one_size(household: dict[str, Path], name: str) -> None:
    mesh = read_mesh(household[name])
    assert not mesh.remarks
    assert mesh.volume > 0
    assert mesh.extents[:2].max() == pytest.approx(SIZE_M, rel=1e-5)
    standing = mesh.standing(2.0)
    low, high = standing.vertices.min(axis=0), standing.vertices.max(axis=0)
    assert low[2] == 0.0
    np.testing.assert_allclose((low + high)[:2], 0.0, atol=1e-9)
    np.testing.assert_allclose(high - low, 2 * mesh.extents)


@pytest.fixture(scope="module")
def mug(household: dict[str, Path]) -> MeshSolid:
    return MeshSolid("mug", convex_parts(read_mesh(household["mug"]).standing(1.0)))


@pytest.mark.parametrize("name", ["mug", "bottle", "brick", "wedge"])
def test_parts_fill_the_volume_of_the_mesh_and_its_box(household: dict[str, Path], mug: MeshSolid, name: str) -> None:
    mesh = read_mesh(household[name]).standing(1.0)
    solid = mug if name == "mug" else MeshSolid(name, convex_parts(mesh))
    assert volume_of(solid.parts) == pytest.approx(mesh.volume, rel=0.05)
    np.testing.assert_allclose(solid.extents_m, mesh.extents, atol=2e-4)
    assert solid.size_m == pytest.approx(SIZE_M, rel=5e-3)
    assert not solid.rolls
    if name == "bottle":
        assert convex_parts(mesh) == solid.parts


def test_a_mug_is_hollow_and_a_hand_meets_its_handle(mug: MeshSolid) -> None:
    x, y = np.array([-0.01, 0.035]), np.zeros(2)
    floor, handle = mug.height(x, y)
    assert floor < 0.15 * mug.top_m
    assert 0.3 * mug.top_m < handle < 0.9 * mug.top_m
    assert mug.height(np.array(0.2), np.array(0.0)) == 0.0


def test_rays_meet_a_ball_a_box_and_a_ring_where_they_should() -> None:
    rng = np.random.default_rng(3)
    ball = convex_parts(triangles(trimesh.creation.icosphere(subdivisions=3, radius=0.04)))
    assert len(ball) == 1
    origins = rng.uniform(-0.02, 0.02, (50, 3)) - [0, 0.2, 0]
    true = 0.2 - (origins[:, 1] + 0.2) - np.sqrt(0.04**2 - origins[:, 0] ** 2 - origins[:, 2] ** 2)
    np.testing.assert_allclose(entered(ball, origins, np.array([0.0, 1.0, 0.0])), true, atol=7e-4)

    box = convex_parts(triangles(trimesh.creation.box((0.06, 0.08, 0.1))).standing(1.0))
    way = np.array([0.36, 0.48, -0.8])
    starts = rng.uniform(-0.1, 0.1, (200, 3)) - 0.3 * way
    np.testing.assert_allclose(entered(box, starts, way), Part.box(0.06, 0.08, 0.1).hits(starts, way), atol=1e-8)

    ring = convex_parts(triangles(trimesh.creation.torus(0.04, 0.015, major_sections=32, minor_sections=12)))
    turn = rng.uniform(0, 2 * np.pi, 60)
    far = rng.uniform(0.0, 0.07, 60)
    down = entered(
        ring, np.column_stack([far * np.cos(turn), far * np.sin(turn), np.full(60, 0.1)]), np.array([0, 0, -1.0])
    )
    inside = np.abs(far - 0.04) < 0.013
    np.testing.assert_allclose(down[inside], 0.1 - np.sqrt(0.015**2 - (far[inside] - 0.04) ** 2), atol=2e-3)
    assert np.isinf(down[np.abs(far - 0.04) > 0.018]).all()


def test_bodies_that_cross_are_one_thing() -> None:
    outer, across = trimesh.creation.box((0.08, 0.08, 0.08)), trimesh.creation.box((0.02, 0.12, 0.02))
    assert len(convex_parts(triangles(trimesh.util.concatenate([outer, across])))) == 2


def test_what_takes_a_mesh_apart_may_end_or_go_on_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    ring = triangles(trimesh.creation.torus(0.04, 0.015, major_sections=8, minor_sections=6))
    monkeypatch.setattr(mesh_apart, "MOST_S", 0.01)
    with pytest.raises(FormatError, match=r"^cannot be taken apart .*: not within 0\.01 s; simplify the mesh$"):
        convex_parts(ring)
    monkeypatch.setattr(mesh_apart, "MOST_S", 100)
    monkeypatch.setattr(mesh_apart.sys, "executable", "false")
    with pytest.raises(FormatError, match=r"^cannot be taken apart .*: does its surface pass through itself\?$"):
        convex_parts(ring)
    # What is convex needs no other process.
    assert len(convex_parts(triangles(trimesh.creation.box((1, 1, 1))))) == 1


def test_more_bodies_than_can_be_gripped_are_refused_at_once() -> None:
    boxes = [
        trimesh.creation.box((1, 1, 1), trimesh.transformations.translation_matrix((2 * k, 0, 0))) for k in range(129)
    ]
    with pytest.raises(FormatError, match="129 convex parts cannot be gripped; at most 128 can"):
        convex_parts(triangles(trimesh.util.concatenate(boxes)))
    assert len(convex_parts(triangles(trimesh.util.concatenate(boxes[:128])))) == 128


def test_spoilt_files_are_refused_in_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    # Corners of a triangle that are one, a list of another type, a text without its end, an element without its rows.
    made = meshes()
    spoilt = {
        "one.ply": made["text.ply"].split(b"end_header")[0] + b"end_header\n" + b"0 0 0\n" * 12 + b"3 1 1 1\n" * 20,
        "list.ply": made["packed.ply"].replace(b"list uchar int", b"list float int"),
        "half.stl": made["text.stl"][:-300],
        "none.ply": made["text.ply"].replace(b"element face", b"element fate"),
    }
    for name, content in spoilt.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FormatError) as told:
            read_mesh(tmp_path / name)
        assert str(told.value).startswith(f"{tmp_path / name}: ")
        assert "\n" not in str(told.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "STL"])
def test_each_format_gives_the_same_mesh(tmp_path: Path, ending: str) -> None:
    made = trimesh.creation.cone(0.03, 0.1)
    path = tmp_path / f"cone.{ending}"
    path.write_bytes(
        made.export(file_type=ending.lower()).encode() if ending == "obj" else made.export(file_type=ending.lower())
    )
    mesh = read_mesh(path)
    assert is_mesh_file(path)
    assert mesh.volume == pytest.approx(made.volume, rel=1e-5)
    assert len(mesh.faces) == len(made.faces)


def test_words_of_a_mesh_may_be_in_any_encoding(tmp_path: Path) -> None:
    box, words = trimesh.creation.box((1, 1, 1)), "größe".encode("latin-1")
    as_bytes = {kind: box.export(file_type=kind) for kind in ("obj", "ply", "stl_ascii", "stl")}
    as_bytes = {kind: made.encode() if isinstance(made, str) else made for kind, made in as_bytes.items()}
    for name, content in (
        ("a.obj", b"# " + words + b"\n" + as_bytes["obj"]),
        ("a.ply", as_bytes["ply"].replace(b"end_header", b"comment " + words + b"\nend_header")),
        ("words.stl", as_bytes["stl_ascii"].replace(b"solid", b"solid " + words, 1)),
        ("a.stl", words.ljust(80) + as_bytes["stl"][80:]),
    ):
        (tmp_path / name).write_bytes(content)
        assert read_mesh(tmp_path / name).volume == pytest.approx(1.0)


def test_what_an_obj_names_beside_itself_is_not_opened(tmp_path: Path) -> None:
    text = trimesh.creation.box((1, 1, 1)).export(file_type="obj")
    (tmp_path / "box.obj").write_text("mtllib /dev/zero\nmtllib ../box.mtl\nusemtl a\n" + text)
    assert read_mesh(tmp_path / "box.obj").volume == pytest.approx(1.0)


def test_a_small_hole_is_closed_and_told_and_faces_turned_inside_out_are_turned_back(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.08, 0.08, 0.08))
    box.update_faces(np.arange(len(box.faces)) != 3)
    box.export(tmp_path / "open.stl")
    mesh = read_mesh(tmp_path / "open.stl")
    assert mesh.remarks == ("holes of the mesh were closed with 1 triangle",)
    assert mesh.volume == pytest.approx(0.08**3, rel=1e-5)
    ball = trimesh.creation.icosphere(subdivisions=1)
    ball.invert()
    ball.export(tmp_path / "ball.ply")
    assert read_mesh(tmp_path / "ball.ply").volume > 0


def bad_files(folder: Path) -> dict[str, tuple[bytes, str]]:
    ball = trimesh.creation.icosphere(subdivisions=2)
    whole = ball.export(file_type="stl")
    half = trimesh.Trimesh(ball.vertices, ball.faces[ball.triangles_center[:, 2] > 0])
    sheet = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [2, 1, 3], [2, 1, 0], [3, 1, 2]])
    nan = np.frombuffer(whole, np.uint8).copy()
    nan[96:100] = np.frombuffer(np.float32(np.nan).tobytes(), np.uint8)
    ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    return {
        "empty.stl": (b"", "is empty"),
        "words.stl": (b"this is no mesh at all, only words", "is no STL"),
        "words.obj": (b"this is no mesh at all, only words", "no triangle"),
        "words.ply": (b"this is no mesh at all, only words", "no mesh that can be read"),
        "cut.stl": (whole[: len(whole) // 2], "320 triangles announced, 159 there"),
        "nan.stl": (nan.tobytes(), r"got \(nan, 0.850651, 0\) at triangle 0 of 320; mend it where it was made$"),
        "open.stl": (half.export(file_type="stl"), "does not close: [0-9]+ of its edges"),
        "flat.obj": (sheet.export(file_type="obj").encode(), "does not close"),
        "points.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangle"),
        "beyond.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "damaged or cut off"),
        "promise.ply": (ply.replace(b" 3\n", b" 999999999999\n") + b"end_header\n0 0 0\n", "no triangle"),
        "mug.step": (b"ISO-10303-21;", "no mesh by its name"),
    }


def test_what_is_no_closed_mesh_is_refused_in_a_line_that_names_the_file(tmp_path: Path) -> None:
    for name, (content, said) in bad_files(tmp_path).items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=said) as raised:
            read_mesh(tmp_path / name)
        assert str(raised.value).startswith(str(tmp_path / name)), name
        assert "\n" not in str(raised.value)
    with pytest.raises(InputError, match="there is no such file"):
        read_mesh(tmp_path / "none.stl")


@pytest.mark.parametrize("scale", [1e-13, 0.9e-7, 1.1e-7, 1e-3, 0.9e9, 1.1e9, 1e13])
def test_numbers_of_another_unit_are_refused_with_what_to_do(tmp_path: Path, scale: float) -> None:
    corners = scale * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    lines = ["v " + " ".join(f"{at:.17g}" for at in corner) for corner in corners]
    (tmp_path / "a.obj").write_text("\n".join([*lines, "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]))
    if 1e-7 < scale < 1e9:
        assert read_mesh(tmp_path / "a.obj").volume == pytest.approx(scale**3 / 6)
        return
    said = "long at its longest, in its own unit" if scale < 1 else "finite and within 1e+09"
    with pytest.raises(FormatError, match=f"{re.escape(said)}.* write it in another unit$"):
        read_mesh(tmp_path / "a.obj")


def test_too_many_triangles_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.solids.mesh_file.MOST_FACES", 100)
    trimesh.creation.icosphere(subdivisions=2).export(tmp_path / "ball.stl")
    with pytest.raises(FormatError, match="has 320 triangles; at most 100"):
        read_mesh(tmp_path / "ball.stl")
    monkeypatch.setattr("varishold.solids.mesh_file._MOST_BYTES", 1 << 10)
    with pytest.raises(FormatError, match="is larger than"):
        read_mesh(tmp_path / "ball.stl")


@pytest.mark.parametrize("missing", ["trimesh", "networkx"])
def test_a_missing_extra_is_told_with_its_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    monkeypatch.setitem(__import__("sys").modules, missing, None)
    (tmp_path / "a.stl").write_bytes(b"solid")
    with pytest.raises(MissingExtraError, match=rf"need {missing}.*\[meshes\]"):
        read_mesh(tmp_path / "a.stl")


def test_a_thing_needs_a_name_and_a_part_and_has_its_own_proportions() -> None:
    part = Part.box(0.08, 0.04, 0.03)
    for called, parts in ((" ", (part,)), ("brick", ())):
        with pytest.raises(InputError):
            MeshSolid(called, parts)
    with pytest.raises(InputError, match="no usual proportions"):
        MeshSolid.of_size(0.05)
    ball = convex_parts(triangles(trimesh.creation.icosphere(subdivisions=3, radius=0.04)).standing(1.0))
    pole = convex_parts(triangles(trimesh.creation.cylinder(0.02, 0.1)).standing(1.0))
    assert MeshSolid("ball", ball).rolls
    assert not MeshSolid("pole", pole).rolls
