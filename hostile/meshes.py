"""Small meshes of every format: an L of two bars, which is not convex."""

from __future__ import annotations

import numpy as np

__all__ = ["meshes"]

_CORNERS = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])


def meshes() -> dict[str, bytes]:
    """Return the files by their names."""
    n = len(_CORNERS)
    points = 0.03 * np.array([(x, y, z) for z in (0, 1) for x, y in _CORNERS.tolist()])
    below = [(0, k + 1, k) for k in range(1, n - 1)]
    above = [(n, n + k, n + k + 1) for k in range(1, n - 1)]
    sides = [(k, (k + 1) % n, n + (k + 1) % n, n + k) for k in range(n)]
    faces = [*below, *above, *[half for a, b, c, d in sides for half in ((a, b, c), (a, c, d))]]
    vertices = "".join(f"{x:g} {y:g} {z:g}\n" for x, y, z in points.tolist())
    triangles = [points[list(face)] for face in faces]
    rows = np.zeros(len(faces), [("numbers", "<f4", (4, 3)), ("more", "<u2")])
    rows["numbers"][:, 1:] = triangles
    stl = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x:g} {y:g} {z:g}\n" for x, y, z in triangle.tolist())
        + "endloop\nendfacet\n"
        for triangle in triangles
    )
    head = f"element vertex {2 * n}\n" + "".join(f"property float {axis}\n" for axis in "xyz")
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    indices = np.zeros(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    indices["count"], indices["corners"] = 3, faces
    return {
        "text.stl": f"solid L\n{stl}endsolid L\n".encode(),
        "packed.stl": b"an L".ljust(80) + len(faces).to_bytes(4, "little") + rows.tobytes(),
        # Its sides are of four corners, and a material is named that is not there.
        "quads.obj": (
            "mtllib none.mtl\no L\n"
            + "".join(f"v {row}\n" for row in vertices.splitlines())
            + "usemtl none\n"
            + "".join("f " + " ".join(str(k + 1) for k in face) + "\n" for face in [*below, *above, *sides])
        ).encode(),
        "text.ply": (
            f"ply\nformat ascii 1.0\ncomment L\n{head}{vertices}" + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
        ).encode(),
        "packed.ply": f"ply\nformat binary_little_endian 1.0\n{head}".encode()
        + points.astype("<f4").tobytes()
        + indices.tobytes(),
    }
