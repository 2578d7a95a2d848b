"""``varishold perceive --surface``: what is printed of a surface that was touched, and its file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from varishold.cli.printing import echo
from varishold.errors import require

if TYPE_CHECKING:
    from varishold.exploration import SurfaceExploration, SurfaceTouch, TouchedPoints
    from varishold.hand import HandSetting
    from varishold.solids import MeshSolid

_USUAL_TOUCHES = 12


def touches_wanted(touches: int | None, surface: Path | None) -> int:
    """Return how many touches a surface takes, checked before anything is touched."""
    from varishold.exploration import check_touches

    require(surface is not None or touches is None, "--touches are those of a surface: name its file with --surface")
    return check_touches(_USUAL_TOUCHES if touches is None else touches)


def answer_and_feel(
    answer: Callable[[dict[str, Any]], None],
    name: str | MeshSolid,
    size_m: float,
    path: Path | None,
    *,
    seed: int,
    touches: int,
    setting: HandSetting,
    json: bool,
) -> SurfaceExploration | None:
    """Show the answer, and feel the surface where a mesh of it is wanted: before the answer where it is one line."""
    if not json or path is None:
        answer({})
    if path is None:
        return None
    felt = _feel(name, size_m, path, seed=seed, touches=touches, setting=setting, quiet=json)
    if json:
        answer({"surface": surface_to_dict(felt, path)})
    return felt


def _feel(
    name: str | MeshSolid, size_m: float, path: Path, *, seed: int, touches: int, setting: HandSetting, quiet: bool
) -> SurfaceExploration:
    """Touch an object's surface, say so, and write the mesh."""
    from dataclasses import replace

    from varishold.exploration import explore_surface
    from varishold.perceive import write_stl
    from varishold.report.surface_words import surface_in_words, surface_touch_in_words

    def show(number: int, touch: SurfaceTouch, felt: TouchedPoints, sigma_m: float) -> None:
        if not quiet:
            echo(f"{number} {surface_touch_in_words(touch, len(felt.point_m), sigma_m)}")

    clamped = replace(setting, clamped=True)
    felt = explore_surface(name, size_m, seed=seed, touches=touches, setting=clamped, on_touch=show)
    write_stl(path, felt.mesh)
    if not quiet:
        echo(f"{surface_in_words(felt)}; mesh: {path}")
    return felt


def surface_to_dict(felt: SurfaceExploration, path: Path) -> dict[str, Any]:
    """Return what the last JSON line says of the surface; metres and radians."""
    place, sigma = felt.surface.least_known(felt.mesh)
    return {
        "file": str(path),
        "touches": [
            {
                "touch": touch.kind,
                "turn_rad": touch.turn_rad,
                "height_m": touch.height_m,
                "place_m": list(touch.place_m),
                "points": len(points.point_m),
                "mean_sigma_m": sigma_m if sigma_m == sigma_m else None,
            }
            for touch, points, sigma_m in zip(felt.touches, felt.felt, felt.history_m, strict=True)
        ],
        "vertices": len(felt.mesh.vertices_m),
        "faces": len(felt.mesh.faces),
        "volume_m3": felt.mesh.volume_m3,
        "least_known_m": place.tolist(),
        "least_known_sigma_m": sigma,
    }
