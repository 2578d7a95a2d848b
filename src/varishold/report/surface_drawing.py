"""A touched surface as a solid in parallel projection: light where it is least known, with the points that told it."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.exploration import SurfaceExploration
from varishold.perceive import SurfaceMesh
from varishold.report.axonometry import AZIMUTH, ELEVATION
from varishold.report.colours import css, darker
from varishold.report.scene_data import SceneData
from varishold.report.screen import SCREEN_HEIGHT, SCREEN_WIDTH, Fit, scale_bar, screen
from varishold.report.surface_words import surface_in_words, surface_touch_in_words
from varishold.report.wording import sentence

__all__ = ["sigma_key", "surface_drawing", "surface_pane"]

Floats = NDArray[np.float64]

_PADDING = 22
# Steps of the mesh that is drawn: finer triangles than these are not seen.
_DRAWN_STEPS = 24
# Places on the colour scale of what is known best and least, and how many steps of colour and of shade lie between.
_KNOWN, _UNKNOWN, _COLOURS, _TONES = 0.3, 1.0, 12, 6
# A face that looks away from the light keeps so much of it; the light comes from the upper left, before the object.
_DARKEST = 0.55
_LIGHT = np.array([-0.5, 0.75, 0.6]) / np.linalg.norm([-0.5, 0.75, 0.6])
# Points this far behind the surface are still its own. Metres.
_BEHIND_M = 0.004


def surface_pane(felt: SurfaceExploration, scenes: SceneData) -> dict[str, Any]:
    """Add a surface to a page's scenes; return its two drawings, their key, and what each touch told."""
    mesh = felt.surface.mesh(steps=_DRAWN_STEPS)
    # The page's own light makes the shades.
    colours = np.array([list(bytes.fromhex(_shaded(k, _TONES)[1:])) for k in range(_COLOURS + 1)], dtype=np.uint8)
    step = np.round(_COLOURS * _known(felt, mesh)).astype(np.int64)
    scenes.add_surface(mesh, colours[step], np.vstack([each.point_m for each in felt.felt]))
    told = zip(felt.touches, felt.felt, felt.history_m, strict=True)
    return {
        "said": sentence(surface_in_words(felt)),
        "drawings": [
            surface_drawing(felt, mesh, AZIMUTH + turn, side=side)
            for side, turn in (("the front", 0.0), ("behind", math.pi))
        ],
        "key": sigma_key(felt),
        "touches": [sentence(surface_touch_in_words(touch, len(points.point_m), s)) for touch, points, s in told],
    }


def _sigma_range_m(felt: SurfaceExploration) -> tuple[float, float]:
    """Return the standard deviations that the colours' two ends stand for; a few worse places share the upper one."""
    low, high = np.quantile(felt.mesh.sigma_m, (0.02, 0.98)).tolist()
    return low, max(high, 1.5 * low)


def surface_drawing(felt: SurfaceExploration, mesh: SurfaceMesh, azimuth: float, *, side: str) -> Markup:
    """Draw a surface as it is seen from one side.

    Parameters
    ----------
    felt : SurfaceExploration
    mesh : SurfaceMesh
        Its surface, coarse enough to be drawn.
    azimuth : float
        How far the object is turned before the eye. Radians.
    side : str
        What the drawing shows, for those who cannot see it.
    """
    c, s, rise = math.cos(azimuth), math.sin(azimuth), math.sin(ELEVATION)
    turn = np.array([[c, -s, 0.0], [0.0, 0.0, 1.0], [-s, -c, 0.0]])
    tip = np.array([[1.0, 0.0, 0.0], [0.0, math.cos(ELEVATION), -rise], [0.0, rise, math.cos(ELEVATION)]])
    view = tip @ turn
    corners, normals = mesh.vertices_m @ view.T, mesh.face_normals @ view.T
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    scale = float(min(np.array([SCREEN_WIDTH, SCREEN_HEIGHT]) - 2 * _PADDING) / max(high - low))
    middle = (low + high) / 2

    def place(points: Floats) -> Floats:
        out: Floats = np.array([SCREEN_WIDTH, SCREEN_HEIGHT]) / 2 + scale * (points[:, :2] - middle) * [1.0, -1.0]
        return out

    on_screen = place(corners)
    length = np.linalg.norm(normals, axis=1)
    seen = np.flatnonzero(normals[:, 2] > 1e-3 * length)
    seen = seen[np.argsort(corners[mesh.faces[seen], 2].mean(axis=1), kind="stable")]
    known = _known(felt, mesh)
    tone = np.clip(normals @ _LIGHT / np.maximum(length, 1e-30), 0, 1)
    body = []
    for face in seen.tolist():
        colour = _shaded(round(float(known[face]) * _COLOURS), round(float(tone[face]) * _TONES))
        (a, b), (d, e), (f, g) = on_screen[mesh.faces[face]].round(1).tolist()
        body.append(f'<path color="{colour}" d="M{a:g} {b:g}L{d:g} {e:g}L{f:g} {g:g}z"/>')
    dots = [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="1.7"/>' for x, y in place(_seen_points(felt, corners, view)).tolist()
    ]
    bar = scale_bar(Fit(0.0, 0.0, scale), 1.0)
    label = f"The surface from {side}: {len(dots)} of the points that were touched lie on this side"
    return screen(
        f'<g class="faces">{"".join(body)}</g><g class="points">{"".join(dots)}</g>{bar}', label=label, kind="surface"
    )


def sigma_key(felt: SurfaceExploration) -> tuple[str, tuple[str, ...], str]:
    """Return the least standard deviation in words, the colours between, and the greatest in words."""
    least, most = _sigma_range_m(felt)
    colours = tuple(_shaded(k, _TONES) for k in range(0, _COLOURS + 1, 3))
    return f"{1e3 * least:.1f}\u202fmm", colours, f"{1e3 * most:.1f}\u202fmm"


def _known(felt: SurfaceExploration, mesh: SurfaceMesh) -> Floats:
    """How little is known of each face: 0 of what is known best, 1 of what is known least."""
    least, most = _sigma_range_m(felt)
    return np.asarray(np.clip((mesh.sigma_m[mesh.faces].mean(axis=1) - least) / (most - least), 0, 1))


@cache
def _shaded(known: int, tone: int) -> str:
    colour = css(_KNOWN + (_UNKNOWN - _KNOWN) * known / _COLOURS)
    return darker(colour, _DARKEST + (1 - _DARKEST) * tone / _TONES)


def _seen_points(felt: SurfaceExploration, corners: Floats, view: Floats) -> Floats:
    """The touched points that the surface does not hide, as the eye has them."""
    points = np.vstack([each.point_m for each in felt.felt]) @ view.T
    normals = np.vstack([each.normal for each in felt.felt]) @ view.T
    pitch = float(np.ptp(corners[:, 0])) / 20
    cell = np.floor(corners[:, :2] / pitch).astype(int)
    nearest: dict[tuple[int, int], float] = {}
    for key, depth in zip(map(tuple, cell.tolist()), corners[:, 2].tolist(), strict=True):
        nearest[key] = max(nearest.get(key, -math.inf), depth)
    keys = map(tuple, np.floor(points[:, :2] / pitch).astype(int).tolist())
    before = np.array([nearest.get(key, -math.inf) for key in keys])
    return points[(normals[:, 2] > 0) & (points[:, 2] > before - _BEHIND_M - pitch)]
