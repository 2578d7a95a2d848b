"""Pads pressed by solids in known poses: what the pad reports, and what truly lay under it.

The truth comes from the solid itself. Rays tell where its surface lies before each cell of a pad and which way it
faces there; the contact that the skin's solver finds says which of these cells count. Where the surface's
direction jumps inside the contact or along its border, there is a kink; where three of the patches that kinks
part meet, or a kink ends, there is a point.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from varishold.errors import InputError, NotConvergedError
from varishold.skin import Skin, Taxels, press, sense
from varishold.solids import (
    Cone,
    ConeFrustum,
    Cylinder,
    Ellipsoid,
    HexagonalPrism,
    Pyramid,
    PyramidFrustum,
    Sphere,
    SquarePillar,
    TriangularPrism,
)
from varishold.solids.body import Part, regular_polygon

__all__ = ["NOMINAL", "LabelledPad", "Place", "labelled_press", "scenes", "vary_skin"]

Floats = NDArray[np.float64]

#: The skin that a pad is told to have.
NOMINAL = Skin("layer", thickness_m=0.004, poisson=0.45, sensing_depth_m=0.001, youngs_modulus_pa=1.5e5)

# Rays start so far behind the pad, and what lies farther before it cannot touch. Metres.
_BEHIND_M, _BEFORE_M = 0.015, 0.012
# Neighbouring cells that face apart by more lie on both sides of a kink: the tightest bend offered turns by
# a third of it from cell to cell, facets of a round body included. Radians.
_KINK_RAD = np.radians(20.0)
# A surface that bends less is flat. 1/m.
_FLAT_1_M = 1 / 0.15
# One that bends more, as a cone close to its tip, has no name. 1/m.
_SHARP_1_M = 1 / 0.006
# Slopes are taken between rays so far apart, that next to none lie on both sides of a kink. Metres.
_STEP_M = 1e-7
_TOLERANCE = 1e-3
# How often each solid is drawn.
_SOLIDS = {
    "cylinder": 0.13,
    "sphere": 0.09,
    "ellipsoid": 0.03,
    "cone": 0.09,
    "cone-frustum": 0.08,
    "square": 0.12,
    "triangle": 0.1,
    "hexagon": 0.09,
    "octagon": 0.05,
    "pyramid": 0.1,
    "pyramid-frustum": 0.07,
    "box": 0.05,
}


@dataclass(frozen=True)
class Place:
    """A pad before a solid.

    Parameters
    ----------
    parts : tuple of Part
    origin, across, up, outward : ndarray of shape (3,)
        Middle of the pad in the solid's frame, metres, and unit vectors along its columns, its rows and out of it.
    shape : (int, int)
        Rows and columns of taxels.
    pitch_m : float
    force_n : float
    """

    parts: tuple[Part, ...]
    origin: Floats
    across: Floats
    up: Floats
    outward: Floats
    shape: tuple[int, int]
    pitch_m: float
    force_n: float


@dataclass(frozen=True)
class LabelledPad:
    """A pad's frame and what pressed it.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols)
    pitch_m : float
    surface : {0, 1, 2, 3}
        Index into `varishold.touch.SURFACES`.
    curvature_1_m : (float, float)
        Of the true surface over the contact, along columns and rows: of the quadratic that fits it best.
    radius_m : float
        Least radius of curvature of a curved surface; NaN for others.
    force_n : float
    skin : Skin
        The true skin.
    """

    frame: Floats
    pitch_m: float
    surface: int
    curvature_1_m: tuple[float, float]
    radius_m: float
    force_n: float
    skin: Skin


def labelled_press(place: Place, skin: Skin, taxels: Taxels, *, seed: int) -> LabelledPad | None:
    """Press a solid on a pad; None where it does not meet the pad or what touches cannot be named."""
    height, normal = _surface(place)
    if not (height > -_BEFORE_M).any():
        return None
    top = height.max()
    cut = np.maximum(height, top - _BEFORE_M)
    per_taxel = max(2, int(np.ceil(place.pitch_m / skin.sensing_depth_m - 1e-9))) if skin.sensing_depth_m else 2
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            pressed = press(
                cut,
                skin,
                force=place.force_n,
                shape=place.shape,
                pitch_m=place.pitch_m,
                per_taxel=per_taxel,
                tolerance=_TOLERANCE,
            )
    except (NotConvergedError, InputError):
        return None
    contact = _on_cells(pressed.contact, height.shape)
    named = _name(height, normal, contact, place.pitch_m / 2)
    if named is None:
        return None
    surface, curvature, radius = named
    frame = sense(pressed, taxels, seed=seed)
    return LabelledPad(frame, place.pitch_m, surface, curvature, radius, place.force_n, skin)


def _on_cells(contact: NDArray[np.bool_], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """A contact found on other cells, on cells of half a taxel."""
    rows = np.minimum((np.arange(contact.shape[0]) + 0.5) * shape[0] / contact.shape[0], shape[0] - 1).astype(int)
    cols = np.minimum((np.arange(contact.shape[1]) + 0.5) * shape[1] / contact.shape[1], shape[1] - 1).astype(int)
    out = np.zeros(shape, dtype=bool)
    i, j = np.nonzero(contact)
    out[rows[i], cols[j]] = True
    return out


def _surface(place: Place) -> tuple[Floats, Floats]:
    """Height before the pad on cells of half a taxel (-inf: nothing), and unit normals toward the pad."""
    rows, cols = 2 * place.shape[0], 2 * place.shape[1]
    u = (np.arange(cols) + 0.5 - cols / 2) * place.pitch_m / 2
    v = (np.arange(rows) + 0.5 - rows / 2) * place.pitch_m / 2
    grid_u, grid_v = np.meshgrid(u, v)

    def heights(du: float, dv: float) -> Floats:
        points = (
            place.origin
            + (grid_u[..., None] + du) * place.across
            + (grid_v[..., None] + dv) * place.up
            - _BEHIND_M * place.outward
        ).reshape(-1, 3)
        reach = np.full(len(points), np.inf)
        for part in place.parts:
            reach = np.minimum(reach, part.hits(points, place.outward))
        return (_BEHIND_M - reach).reshape(rows, cols)

    height = heights(0.0, 0.0)
    with np.errstate(invalid="ignore"):
        slope_u = (heights(_STEP_M, 0.0) - height) / _STEP_M
        slope_v = (heights(0.0, _STEP_M) - height) / _STEP_M
    slope_u = np.where(np.isfinite(slope_u), slope_u, 0.0)
    slope_v = np.where(np.isfinite(slope_v), slope_v, 0.0)
    normal = np.stack([-slope_u, -slope_v, np.ones_like(height)], axis=-1)
    return height, normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def _name(
    height: Floats, normal: Floats, contact: NDArray[np.bool_], cell_m: float
) -> tuple[int, tuple[float, float], float] | None:
    there = np.isfinite(height)
    contact = contact & there
    if not contact.any():
        return None
    near = ndimage.binary_dilation(contact, structure=np.ones((3, 3)))
    solid = near & there
    patch, kinks, drops = _patches(normal, near, there)
    curvature, greatest = _bend(normal, solid if contact.sum() < 12 else contact, cell_m)
    sizes = np.bincount(patch[solid])
    large = sizes >= max(2, 0.03 * solid.sum())
    shown = np.where(solid & large[np.maximum(patch, 0)], patch, -1)
    count = np.unique(shown[shown >= 0]).size
    if _meet(shown) or (count == 1 and kinks >= 2):
        return 3, curvature, np.nan
    if kinks >= 2 or drops >= 3:
        return 2, curvature, np.nan
    if kinks or drops:
        return None
    if greatest > _SHARP_1_M:
        return None
    if greatest > _FLAT_1_M:
        return 1, curvature, 1 / greatest
    return 0, curvature, np.nan


def _patches(normal: Floats, near: NDArray[np.bool_], there: NDArray[np.bool_]) -> tuple[NDArray[np.intp], int, int]:
    """Number the smooth patches (-1: none), and count the steps over a kink and over the solid's end."""
    solid = near & there
    number = np.arange(near.size).reshape(near.shape)
    links, kinks, drops = [], 0, 0
    for a, b in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        both = solid[a] & solid[b]
        smooth = (normal[a] * normal[b]).sum(axis=-1) > np.cos(_KINK_RAD)
        links.append(np.stack([number[a][both & smooth], number[b][both & smooth]]))
        kinks += int((both & ~smooth).sum())
        drops += int((near[a] & near[b] & (there[a] != there[b])).sum())
    i, j = np.concatenate(links, axis=1)
    _, of = connected_components(coo_array((np.ones(i.size), (i, j)), shape=(near.size, near.size)), directed=False)
    patch = np.full(near.shape, -1)
    patch[solid] = np.unique(of.reshape(near.shape)[solid], return_inverse=True)[1]
    return patch, kinks, drops


def _meet(patch: NDArray[np.intp]) -> bool:
    """Whether three patches meet within three cells."""
    padded = np.pad(patch, 1, constant_values=-1)
    rows, cols = patch.shape
    around = np.stack([padded[r : r + rows, c : c + cols] for r in range(3) for c in range(3)])
    around.sort(axis=0)
    fresh = (np.diff(around, axis=0) > 0).sum(axis=0) + (around[0] >= 0)
    return bool((fresh >= 3).any())


def _bend(normal: Floats, cells: NDArray[np.bool_], cell_m: float) -> tuple[tuple[float, float], float]:
    """Curvatures along columns and rows and the greatest one, 1/m, convex positive: how slopes change over cells."""
    i, j = np.nonzero(cells)
    y, x = (i - i.mean()) * cell_m, (j - j.mean()) * cell_m
    slopes = -normal[i, j, :2] / normal[i, j, 2:]
    design = np.stack([np.full(x.shape, cell_m), x, y], axis=1)
    (p, q), (xx, xy), (yx, yy) = np.linalg.lstsq(design, slopes, rcond=1e-6)[0]
    p, q, xy = p * cell_m, q * cell_m, (xy + yx) / 2
    along = -xx / (1 + p * p) ** 1.5, -yy / (1 + q * q) ** 1.5
    # The shape operator of a graph.
    first = np.array([[1 + p * p, p * q], [p * q, 1 + q * q]])
    second = -np.array([[xx, xy], [xy, yy]]) / np.sqrt(1 + p * p + q * q)
    principal = np.linalg.eigvals(np.linalg.solve(first, second)).real
    return (float(along[0]), float(along[1])), float(principal.max())


def scenes(
    seed: int,
    count: int,
    *,
    skin: Skin | None = NOMINAL,
    spread: float = 0.3,
    noise: tuple[float, float] = (0.003, 0.03),
) -> Iterator[LabelledPad]:
    """Yield pads of many shapes pressed by solids of many forms, sizes and poses.

    Parameters
    ----------
    seed : int
    count : int
        Scenes to draw; those where nothing touches are left out.
    skin : Skin, optional
        The skin whose thickness and modulus are spread; without it every scene has a layer of its own.
    spread : float
        Thickness and modulus lie within 1 - spread .. 1 / (1 - spread) of the skin's.
    noise : (float, float)
        Range of the taxels' noise over the peak, even in logarithm.
    """
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        true_skin = vary_skin(rng, skin, spread)
        place = _draw_place(rng)
        if place is None:
            continue
        taxels = Taxels(noise=float(np.exp(rng.uniform(*np.log(noise)))))
        pad = labelled_press(place, true_skin, taxels, seed=int(rng.integers(2**31)))
        if pad is not None:
            yield pad


def vary_skin(rng: np.random.Generator, skin: Skin | None, spread: float) -> Skin:
    if skin is None:
        return Skin(
            "layer",
            thickness_m=float(np.exp(rng.uniform(np.log(0.002), np.log(0.008)))),
            poisson=float(rng.uniform(0.35, 0.48)),
            sensing_depth_m=float(rng.choice([0.0, 0.0005, 0.001, 0.0015])),
            youngs_modulus_pa=float(np.exp(rng.uniform(np.log(7e4), np.log(4e5)))),
        )
    thick, stiff = np.exp(rng.uniform(-1, 1, 2) * -np.log(1 - spread))
    return replace(
        skin,
        thickness_m=float((skin.thickness_m or 0.004) * thick),
        youngs_modulus_pa=float((skin.youngs_modulus_pa or 1.5e5) * stiff),
    )


def _draw_solid(rng: np.random.Generator) -> tuple[str, tuple[Part, ...]]:
    size = float(np.exp(rng.uniform(np.log(0.035), np.log(0.14))))
    tall = float(rng.uniform(1.0, 2.5)) * size
    kind = str(rng.choice(list(_SOLIDS), p=list(_SOLIDS.values())))
    top = float(rng.uniform(0.4, 0.8)) * size
    makers: dict[str, object] = {
        "cylinder": Cylinder(size, tall),
        "sphere": Sphere(size),
        "ellipsoid": Ellipsoid.of_size(size),
        "cone": Cone(size, tall),
        "cone-frustum": ConeFrustum(size, top, tall),
        "square": SquarePillar(size, tall),
        "triangle": TriangularPrism(size, tall),
        "hexagon": HexagonalPrism(size, tall),
        "pyramid": Pyramid(size, tall),
        "pyramid-frustum": PyramidFrustum(size, top, tall),
    }
    if kind == "octagon":
        return kind, (Part.prism(regular_polygon(8, size / 2), tall),)
    if kind == "box":
        return kind, (Part.box(1.4 * size, size, tall),)
    return kind, makers[kind].body()  # type: ignore[attr-defined]


def _draw_pad(rng: np.random.Generator) -> tuple[tuple[int, int], float]:
    which = rng.random()
    if which < 0.7:
        return (int(rng.choice([8, 8, 9, 10])), int(rng.integers(11, 29))), 0.002
    if which < 0.85:
        return (23, int(rng.integers(14, 25))), 0.002
    return (22, 21), 0.004


def _draw_place(rng: np.random.Generator) -> Place | None:
    """Turn a solid before a pad, and lay the pad on it."""
    _, parts = _draw_solid(rng)
    shape, pitch = _draw_pad(rng)
    force = float(np.exp(rng.uniform(np.log(0.1), np.log(60.0))))
    outward = _toward(rng, parts)
    # The pad looks along `outward` at the solid; its columns lie across the upright axis, or anyhow.
    axis = np.array([0.0, 0.0, 1.0])
    across = np.cross(axis, outward)
    if np.linalg.norm(across) < 0.3 or rng.random() < 0.2:
        across = np.cross(rng.normal(size=3), outward)
    across /= np.linalg.norm(across)
    if rng.random() < 0.5:
        across = -across
    turn = rng.normal(0, np.radians(6.0))
    up = np.cross(outward, across)
    across = np.cos(turn) * across + np.sin(turn) * up
    up = np.cross(outward, across)
    middle = np.mean([part.centre_m for part in parts], axis=0)
    origin = _lay(rng, parts, middle, (across, up, outward), shape, pitch)
    if origin is None:
        return None
    return Place(parts, origin, across, up, outward, shape, pitch, force)


def _toward(rng: np.random.Generator, parts: Sequence[Part]) -> Floats:
    """The direction in which a pad looks at a solid: square to a face, to its side, or anyhow; a little tilted."""
    which = rng.random()
    if which < 0.55:
        faces = _face_normals(parts[0])
        outward = -faces[rng.integers(len(faces))]
    elif which < 0.90:
        yaw, pitch = rng.uniform(0, 2 * np.pi), rng.normal(0, np.radians(12.0))
        outward = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
    elif which < 0.95:
        outward = np.array([0.0, 0.0, -1.0]) + rng.normal(0, 0.25, 3)
    else:
        outward = rng.normal(size=3)
    # Fingers lie against what they touch along their length, less so across it.
    spread = np.radians(rng.choice([0.3, 1.5, 8.0], p=[0.35, 0.35, 0.3]))
    outward = outward + rng.normal(0, spread, 3)
    unit: Floats = outward / np.linalg.norm(outward)
    return unit


def _face_normals(part: Part) -> Floats:
    if part.kind == "hull":
        return part._planes[:, :3]
    if part.kind == "box":
        return np.vstack([np.eye(3), -np.eye(3)])
    yaw = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    return np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=1)


def _lay(
    rng: np.random.Generator,
    parts: Sequence[Part],
    middle: Floats,
    axes: tuple[Floats, Floats, Floats],
    shape: tuple[int, int],
    pitch: float,
) -> Floats | None:
    """Choose where on the solid the pad's middle comes to lie: about its highest point there, or anywhere."""
    across, up, outward = axes
    n = 60
    at = (np.arange(n) + 0.5 - n / 2) * 0.004
    u, v = np.meshgrid(at, at)
    start = 0.3
    points = (middle + u[..., None] * across + v[..., None] * up - start * outward).reshape(-1, 3)
    reach = np.full(len(points), np.inf)
    for part in parts:
        reach = np.minimum(reach, part.hits(points, outward))
    hit = np.flatnonzero(np.isfinite(reach))
    if not hit.size:
        return None
    # Spread over what is nearly the highest, for a face square to the pad is met anywhere.
    slack = 0.0003 if rng.random() < 0.4 else 0.012
    high = hit[reach[hit] <= reach[hit].min() + slack]
    chosen = points[rng.choice(high)]
    half = np.array([shape[1], shape[0]]) * pitch / 2
    off = rng.uniform(-1, 1, 2) * half * rng.choice([0.3, 1.0])
    # The height is measured from the highest point before the pad, so its place along the rays is free within reach.
    lateral = chosen + start * outward - off[0] * across - off[1] * up
    near = np.hypot(*(((points - chosen) @ np.stack([across, up], axis=1)) / (2 * half)).T) < 1
    lowest = reach[near & np.isfinite(reach)].min() if (near & np.isfinite(reach)).any() else reach[hit].min()
    origin: Floats = lateral + (lowest - start) * outward
    return origin
