"""Scenes as the page's script takes them: short numbers, and each mesh once however often it is seen."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.hand import Camera
from varishold.report.axonometry import AZIMUTH, ELEVATION

if TYPE_CHECKING:
    from varishold.hand.scene import Scene
    from varishold.perceive import SurfaceMesh

__all__ = ["CAMERA", "SceneData"]

#: Where a touch is seen from first, in pictures and scenes.
CAMERA = Camera(width=480, height=400, distance_m=0.40, look_at_m=(0.05, 0.0, 0.01))

#: Lengths are told in whole steps of this. Metres.
STEP_M = 1e-5
# Digits of the axes.
_DIGITS = 4
# A point that was touched, and its colour.
_POINT_M, _WHITE = 9e-4, (255, 255, 255)
# The eye is 45 degrees wide; few things reach as far up as their corners are apart.
_ROOM = 1.15 * math.sin(math.radians(22.5))


class SceneData:
    """The scenes of one page, in the order in which the page shows them; touches are the first."""

    def __init__(self, touches: Iterable[Scene] = ()) -> None:
        self._meshes: list[list[Any]] = []
        self._known: dict[bytes, int] = {}
        self._scenes: list[dict[str, Any]] = []
        for scene in touches:
            self.add_scene(scene)

    def add_scene(self, scene: Scene) -> None:
        """Add the hand at an object, seen as `CAMERA` sees it first."""
        bodies = [
            [
                body.kind,
                _steps(np.array(body.half_m))
                if body.corners_m is None or body.faces is None
                else self._mesh(body.corners_m, body.faces),
                _steps(body.place_m),
                np.round(body.turn.ravel(), _DIGITS).tolist(),
                list(body.colour),
            ]
            for body in scene
        ]
        self._add(bodies, CAMERA)

    def add_surface(self, mesh: SurfaceMesh, colours: NDArray[np.uint8], points_m: NDArray[np.float64]) -> None:
        """Add a surface whose faces have colours, shape (n_faces, 3), and points on it; seen as drawings see it."""
        low, high = mesh.vertices_m.min(axis=0), mesh.vertices_m.max(axis=0)
        (x, y, z), reach = ((low + high) / 2).tolist(), float(np.linalg.norm(high - low)) / 2
        number = self._mesh(mesh.vertices_m, mesh.faces)
        here, upright = [0, 0, 0], np.eye(3).ravel().tolist()
        bodies: list[list[Any]] = [["mesh", number, here, upright, colours.ravel().tolist()]]
        size = _steps(np.full(3, _POINT_M))
        bodies += [["sphere", size, _steps(point), upright, list(_WHITE)] for point in points_m]
        self._add(
            bodies,
            Camera(
                azimuth_deg=90.0 - math.degrees(AZIMUTH),
                elevation_deg=-math.degrees(ELEVATION),
                distance_m=reach / _ROOM,
                look_at_m=(x, y, z),
            ),
        )

    @property
    def markup(self) -> Markup | None:
        """All of it as JSON that can stand in a page, for there is no text of a user in it; None where it is empty."""
        if not self._scenes:
            return None
        told = {"step": STEP_M, "meshes": self._meshes, "scenes": self._scenes}
        return Markup(json.dumps(told, separators=(",", ":")))

    def _add(self, bodies: list[list[Any]], camera: Camera) -> None:
        self._scenes.append(
            {
                "azimuth": round(math.radians(camera.azimuth_deg), _DIGITS),
                "elevation": round(math.radians(camera.elevation_deg), _DIGITS),
                "distance": round(camera.distance_m, _DIGITS),
                "middle": _steps(np.array(camera.look_at_m)),
                "bodies": bodies,
            }
        )

    def _mesh(self, corners_m: NDArray[np.float64], faces: NDArray[np.int64]) -> int:
        key = corners_m.tobytes() + faces.tobytes()
        if key not in self._known:
            self._known[key] = len(self._meshes)
            self._meshes.append([_steps(corners_m), faces.ravel().tolist()])
        return self._known[key]


def _steps(lengths_m: NDArray[np.float64]) -> list[int]:
    out: list[int] = np.round(lengths_m.ravel() / STEP_M).astype(np.int64).tolist()
    return out
