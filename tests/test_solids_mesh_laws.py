"""Laws of meshes by small ones made by hand: lengths, holes, limits on both sides, parts, and what rolls."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("trimesh", reason="trimesh is not installed; pip install -e '.[meshes]'")
pytest.importorskip("coacd", reason="coacd is not installed; pip install -e '.[meshes]'")
pytest.importorskip("networkx")

import trimesh

from varishold.errors import FormatError, InputError
from varishold.solids import MeshSolid, Part, mesh_file, mesh_parts
from varishold.solids.body_height import height_of, top_of
from varishold.solids.mesh_file import TriangleMesh, is_mesh_file, read_mesh
from varishold.solids.mesh_parts import convex_parts


def triangles(mesh: Any) -> TriangleMesh:
    return TriangleMesh(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))


def box(lengths: tuple[float, float, float], at: tuple[float, float, float] = (0, 0, 0)) -> Any:
    return trimesh.creation.box(lengths, trimesh.transformations.translation_matrix(at))


def read(folder: Path, mesh: Any, ending: str = "ply") -> TriangleMesh:
    mesh.export(folder / f"thing.{ending}")
    return read_mesh(folder / f"thing.{ending}")


def test_a_mesh_far_from_the_origin_has_its_lengths_and_stands_in_the_middle() -> None:
    mesh = triangles(box((1, 2, 3), (10, 20, 30)))
    assert mesh.extents == pytest.approx([1, 2, 3])
    assert mesh.volume == pytest.approx(6)
    assert TriangleMesh(mesh.vertices, mesh.faces[:, ::-1]).volume == pytest.approx(-6)
    standing = mesh.standing(0.1)
    assert standing.vertices.min(axis=0) == pytest.approx([-0.05, -0.1, 0])
    assert standing.vertices.max(axis=0) == pytest.approx([0.05, 0.1, 0.3])
    assert mesh.remarks == standing.remarks == ()


def test_a_mesh_is_known_by_its_ending_alone() -> None:
    assert [is_mesh_file(name) for name in ("a.stl", "a.OBJ", "b/c.Ply")] == [True] * 3
    assert [is_mesh_file(name) for name in ("stl", "a.stl.txt", "a.step", "a")] == [False] * 4


@pytest.mark.parametrize("unit", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_corners_are_one_within_a_millionth_of_the_whole_in_every_unit(tmp_path: Path, unit: float) -> None:
    mesh = box((4, 2, 1))
    loose = trimesh.Trimesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False)
    near = loose.vertices + np.random.default_rng(1).uniform(-1e-8, 1e-8, (36, 3))
    for vertices, corners in ((loose.vertices, 8), (near, 8)):
        # Away from where corners are rounded up or down.
        text = "".join(f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in ((vertices + 0.0123456001) * unit).tolist())
        text += "".join(f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}\n" for k in range(12))
        (tmp_path / "thing.obj").write_text(text)
        found = read_mesh(tmp_path / "thing.obj")
        assert (len(found.vertices), len(found.faces), found.remarks) == (corners, 12, ())
        assert found.volume == pytest.approx(8 * unit**3, rel=1e-6)


def test_corners_farther_apart_than_a_hundred_thousandth_stay_two(tmp_path: Path) -> None:
    made = box((1, 1, 1e-4))
    assert len(read(tmp_path, made, "obj").vertices) == 8


def test_what_is_doubled_or_flat_or_unused_is_left_out(tmp_path: Path) -> None:
    made = box((1, 1, 1))
    faces = np.vstack([made.faces, made.faces[3], [0, 0, 1]])
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in [*made.vertices.tolist(), (9, 9, 9)])
    text += "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces.tolist())
    (tmp_path / "thing.obj").write_text(text)
    found = read_mesh(tmp_path / "thing.obj")
    assert (len(found.vertices), len(found.faces), found.remarks) == (8, 12, ())
    assert found.extents == pytest.approx([1, 1, 1])


def test_every_body_of_a_file_is_read(tmp_path: Path) -> None:
    scene = trimesh.Scene([box((1, 1, 1)), box((1, 1, 2), (5, 0, 0)), box((1, 3, 1), (10, 0, 0))])
    scene.export(tmp_path / "three.obj")
    found = read_mesh(tmp_path / "three.obj")
    assert (len(found.vertices), len(found.faces)) == (24, 36)
    assert found.volume == pytest.approx(6)
    assert found.extents == pytest.approx([11, 3, 2])


def test_faces_turned_inside_out_are_turned_back(tmp_path: Path) -> None:
    made = box((1, 1, 1))
    made.invert()
    assert read(tmp_path, made).volume == pytest.approx(1)
    some = box((1, 1, 1))
    some.faces[2:5] = some.faces[2:5, ::-1]
    assert read(tmp_path, some).volume == pytest.approx(1)


def test_a_limit_of_triangles_is_reached_and_not_passed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert mesh_file.MOST_FACES == 200_000
    assert mesh_file._MOST_BYTES == 134_217_728
    monkeypatch.setattr(mesh_file, "MOST_FACES", 12)
    assert len(read(tmp_path, box((1, 1, 1))).faces) == 12
    monkeypatch.setattr(mesh_file, "MOST_FACES", 11)
    with pytest.raises(FormatError, match=r"has 12 triangles; at most 11 are read: simplify it first$"):
        read(tmp_path, box((1, 1, 1)))


def test_a_corner_may_lie_as_far_as_a_thousand_million(tmp_path: Path) -> None:
    assert read(tmp_path, box((2e9, 1e9, 1e9)), "obj").extents == pytest.approx([2e9, 1e9, 1e9])
    with pytest.raises(FormatError, match=r"within 1e\+09, got \(.*\) at triangle 0 of 12; mend it"):
        read(tmp_path, box((2.0001e9, 1e9, 1e9)), "obj")


def test_a_binary_stl_holds_as_many_triangles_as_it_says(tmp_path: Path) -> None:
    whole = box((1, 1, 1)).export(file_type="stl")
    path = tmp_path / "thing.stl"
    for content, there in ((whole[:-50], 11), (whole[:-1], 11), (whole + whole[-50:], 13), (whole[:60], 0)):
        path.write_bytes(content)
        with pytest.raises(FormatError, match=f"cut off: [0-9]+ triangles announced, {there} there$"):
            read_mesh(path)
    # A text begins with its word, and says no number.
    path.write_bytes(b"  SOLID".ljust(80) + whole[80:-50])
    with pytest.raises(FormatError) as told:
        read_mesh(path)
    assert "announced" not in str(told.value)


def test_a_triangle_names_only_corners_that_are_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = box((1, 1, 1))
    (tmp_path / "thing.ply").write_bytes(b"x")
    for bad, said in ((8, "names corner 8 of 8"), (-1, "names corner 7 of 8")):
        faces = made.faces.copy()
        faces[faces == (7 if bad == 8 else 0)] = bad
        monkeypatch.setattr(mesh_file, "_triangles", lambda *_, faces=faces: (np.array(made.vertices), faces))
        with pytest.raises(FormatError, match=f"{said}; it is damaged or cut off$"):
            read_mesh(tmp_path / "thing.ply")


def test_a_hole_is_closed_and_what_stays_open_is_told_with_a_place(tmp_path: Path) -> None:
    made = box((2, 2, 2))
    top = np.flatnonzero(made.face_normals[:, 2] > 0.5)
    made.update_faces(np.setdiff1d(np.arange(12), top))
    found = read(tmp_path, made)
    assert found.remarks == ("holes of the mesh were closed with 2 triangles",)
    assert found.volume == pytest.approx(8)
    ball = trimesh.creation.icosphere(subdivisions=1)
    half = trimesh.Trimesh(ball.vertices, ball.faces[ball.triangles_center[:, 2] > 0.3])
    edges = sum(np.unique(np.sort(half.edges, axis=1), axis=0, return_counts=True)[1] == 1)
    with pytest.raises(FormatError, match=rf"does not close: {edges} of its edges have not two triangles, as at \("):
        read(tmp_path, half)


def test_what_is_as_thin_as_nothing_encloses_nothing(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.3 0.3 {:.17g}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    (tmp_path / "thing.obj").write_text(text.format(1))
    assert read_mesh(tmp_path / "thing.obj").volume == pytest.approx(1 / 6)
    (tmp_path / "thing.obj").write_text(text.format(1.2e-8))
    assert read_mesh(tmp_path / "thing.obj").volume == pytest.approx(2e-9)
    (tmp_path / "thing.obj").write_text(text.format(3e-9))
    with pytest.raises(FormatError, match=r"encloses nothing; a solid thing is wanted$"):
        read_mesh(tmp_path / "thing.obj")


def test_the_face_of_parts_is_the_highest_of_them() -> None:
    low, high = Part.box(4.0, 4.0, 1.0), Part("box", (0.5, 1.0, 1.0), (0.5, 0.0, 3.0))
    assert top_of((low, high)) == 4.0
    assert top_of((high, low)) == 4.0
    x, y = np.array([[0.5, -1.0, 3.0]]), np.array([[0.0], [1.5]])
    np.testing.assert_allclose(height_of((low, high), x, y), [[4, 1, 0], [1, 1, 0]])
    assert height_of((low,), np.array(0.0), np.array(1)).shape == ()


def test_a_thing_has_the_lengths_of_all_its_parts_together() -> None:
    thing = MeshSolid("steps", (Part("box", (1, 2, 3), (10, 0, 3)), Part("box", (2, 1, 1), (5, 4, 1))))
    assert thing.extents_m == (8, 7, 6)
    assert thing.size_m == 8
    assert thing.top_m == 6
    assert MeshSolid("tower", (Part.box(1.0, 2.0, 9.0),)).size_m == 2.0
    assert thing.remarks == ()
    assert thing.body() == thing.parts
    np.testing.assert_allclose(thing.height(np.array([10.0, 5.0, 0.0]), np.array([0.0, 4.0, 0.0])), [6, 2, 0])


def foot(x_m: float, y_m: float, z_m: float = 0.0) -> MeshSolid:
    """A thing of 1 m by 2 m on a foot of these lengths, whose corners end at a height."""
    corners = [(sx * x_m / 2, sy * y_m / 2, z_m) for sx in (-1, 1) for sy in (-1, 1)]
    corners += [(sx * 0.5, sy * 1.0, 1.0) for sx in (-1, 1) for sy in (-1, 1)]
    return MeshSolid("foot", (Part.hull(np.array([*corners, (0, 0, 0)])),))


def test_what_stands_on_less_than_a_third_of_its_breadth_either_way_rolls() -> None:
    assert not foot(0.31, 0.61).rolls
    assert foot(0.29, 0.61).rolls
    assert foot(0.31, 0.59).rolls
    # A foot that ends half a millimetre higher does not carry it.
    assert not foot(0.31, 0.61, 0.0004).rolls
    assert foot(0.31, 0.61, 0.0006).rolls
    # What has no corners, or none at the table, is not known to roll.
    assert not MeshSolid("block", (Part.box(1.0, 1.0, 1.0),)).rolls


def test_a_thing_says_what_it_lacks() -> None:
    with pytest.raises(InputError, match=r"^a thing of a mesh needs a name, got ' '$"):
        MeshSolid(" ", (Part.box(1.0, 1.0, 1.0),))
    with pytest.raises(InputError, match=r"^the mesh of 'cup' has no part$"):
        MeshSolid("cup", ())


def taken(
    monkeypatch: pytest.MonkeyPatch, pieces: list[np.ndarray]
) -> list[tuple[np.ndarray, np.ndarray, dict[str, Any]]]:
    """Let these be the pieces of whatever is taken apart, and note what was asked."""
    asked: list[tuple[np.ndarray, np.ndarray, dict[str, Any]]] = []

    def pretend(vertices: np.ndarray, faces: np.ndarray, **how: Any) -> list[np.ndarray]:
        asked.append((vertices, faces, how))
        return pieces

    monkeypatch.setattr(mesh_parts, "taken_apart", pretend)
    return asked


def test_a_hollow_thing_is_taken_apart_at_size_one_and_given_back_at_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    ring = trimesh.creation.annulus(1.0, 2.0, 0.5, sections=8)
    cube = np.asarray(box((0.5, 0.25, 0.125)).vertices)
    # A crumb of less than a millionth, and what is flat, are left out; what is no less than that stays.
    small, crumb = cube * 0.0101, cube * 0.0099
    asked = taken(monkeypatch, [cube, crumb, small, cube[:3]])
    parts = convex_parts(triangles(ring))
    size = ring.extents.max()
    assert [part.half_m for part in parts] == [
        pytest.approx(np.array([0.25, 0.125, 0.0625]) * size * k, abs=2e-9) for k in (1, 0.0101)
    ]
    ((vertices, faces, how),) = asked
    assert np.ptp(vertices, axis=0).max() == pytest.approx(1)
    assert faces.shape == (len(ring.faces), 3)
    assert how == {
        "threshold": pytest.approx(0.03),
        "preprocess_mode": "off",
        "resolution": 1000,
        "mcts_nodes": 10,
        "mcts_iterations": 30,
        "mcts_max_depth": 2,
        "max_ch_vertex": 64,
        "seed": 1,
    }


def test_each_body_is_cut_as_finely_as_the_whole_asks_and_no_more_coarsely_than_a_limit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    far = trimesh.creation.annulus(1.0, 2.0, 0.5, sections=8)
    far.apply_translation((96.0, 0.0, 0.0))
    near = trimesh.creation.annulus(5.0, 10.0, 5.0, sections=8)
    asked = taken(monkeypatch, [np.asarray(box((0.5, 0.25, 0.125)).vertices)])
    whole = trimesh.util.concatenate([near, far])
    assert len(convex_parts(triangles(whole))) == 2
    size = whole.extents.max()
    thresholds = sorted(how["threshold"] for *_, how in asked)
    assert thresholds == pytest.approx([0.03 * size / near.extents.max(), 0.3])


def test_what_nearly_fills_its_hull_is_convex(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = taken(monkeypatch, [np.asarray(box((0.5, 0.25, 0.125)).vertices)])
    for missing, times in ((0.008, 0), (0.012, 1)):
        # A cube with a pyramid-shaped dent of this share.
        cube = box((1, 1, 1))
        top = np.flatnonzero(cube.vertices[:, 2] > 0)
        faces = cube.faces[cube.face_normals[:, 2] < 0.5]
        order = top[np.argsort(np.arctan2(cube.vertices[top, 1], cube.vertices[top, 0]))]
        dent = [(order[k], order[(k + 1) % 4], 8) for k in range(4)]
        vertices = np.vstack([cube.vertices, [0, 0, 0.5 - 3 * missing]])
        asked.clear()
        convex_parts(TriangleMesh(vertices, np.vstack([faces, dent])))
        assert len(asked) == times


def test_a_round_thing_keeps_the_corners_that_reach_farthest() -> None:
    few = trimesh.creation.icosphere(subdivisions=2)
    (part,) = convex_parts(triangles(few))
    assert len(part.corners_m) == 162
    many = trimesh.creation.icosphere(subdivisions=4)
    (part,) = convex_parts(triangles(many))
    corners = np.array(part.corners_m)
    assert 350 < len(corners) <= 406
    assert part.half_m == pytest.approx((1, 1, 1), abs=1e-9)
    np.testing.assert_allclose(np.linalg.norm(corners, axis=1), 1, atol=1e-8)
    # No place of the ball lies far from all of them.
    gap = np.arccos(np.clip(many.vertices @ corners.T, -1, 1)).min(axis=1)
    assert gap.max() < 0.16


def test_a_mesh_has_at_least_one_part_and_at_most_so_many(monkeypatch: pytest.MonkeyPatch) -> None:
    ring = triangles(trimesh.creation.annulus(1.0, 2.0, 0.5, sections=8))
    cube = np.asarray(box((0.5, 0.25, 0.125)).vertices)
    taken(monkeypatch, [cube] * 128)
    assert len(convex_parts(ring)) == 128
    for number in (0, 129):
        taken(monkeypatch, [cube] * number)
        with pytest.raises(FormatError, match=f"^a mesh of {number} convex parts cannot be gripped; at most 128 can$"):
            convex_parts(ring)
