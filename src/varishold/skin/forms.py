"""Forms with free sizes and poses, for fitting; heights are in units of the depth.

A press scales: an object and a depth twice as high press twice as hard. So a form is described with a depth of
1, its lateral sizes are metres, and a gain stands for the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

__all__ = ["FORMS", "Form", "Hint"]

Floats = NDArray[np.float64]
#: (u, v, sizes) -> (how far the face lies below its top in depths, distance to its nearest wall in metres).
Surface = Callable[[Floats, Floats, Floats], tuple[Floats, Floats]]


# A frustum falls by the depth over this share of its top's radius or more: a steeper one is a pillar, whose
# wall it would imitate to within the grid.
_STEEPEST = 0.3


@dataclass(frozen=True)
class Hint:
    """What a mask says before anything is fitted; lengths in metres.

    Parameters
    ----------
    x_m, y_m : float
        Centroid of the contact.
    long_m, short_m : float
        Lengths of the rectangle that has the contact's second moments.
    yaw_rad, yaw4_rad : float
        Direction of the long axis, and of a square's side, from the fourth moments.
    area_m2 : float
        Area of the contact.
    rise : float
        Height of the top above the contact's border, in units of the depth.
    border : (float, float, float)
        Middle (x, y) and outward direction of the straight border that parts contact and free skin best.
    """

    x_m: float
    y_m: float
    long_m: float
    short_m: float
    yaw_rad: float
    yaw4_rad: float
    area_m2: float
    rise: float
    border: tuple[float, float, float]


@dataclass(frozen=True)
class Form:
    """A form that can be fitted.

    Parameters
    ----------
    pose : tuple of str
        Which of "x", "y", "yaw" are free.
    sizes : tuple of str
        Names of its sizes, all positive lengths: `radius`, `length`, `breadth`, and `fall`, over which the
        face falls by the depth.
    surface : callable
        The face in its own axes.
    guess : callable
        First sizes from a `Hint`: one set or several, of which the best is taken.
    yaw : {"long", "square", "border"}
        Which direction of the hint it starts from.
    """

    pose: tuple[str, ...]
    sizes: tuple[str, ...]
    surface: Surface
    guess: Callable[[Hint], tuple[tuple[float, ...], ...]]
    yaw: str = "long"

    def starts(self, hint: Hint) -> list[Floats]:
        """Return first parameters: pose (metres, radians), then logarithms of the sizes."""
        place = {"x": hint.x_m, "y": hint.y_m, "yaw": hint.yaw_rad}
        if self.yaw == "square":
            place["yaw"] = hint.yaw4_rad
        elif self.yaw == "border":
            place["x"], place["y"], place["yaw"] = hint.border
        pose = [place[name] for name in self.pose]
        return [np.array(pose + [float(np.log(size)) for size in sizes]) for sizes in self.guess(hint)]

    def face(self, q: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return the face at points of the pad for parameters `q`."""
        place = dict(zip(self.pose, q, strict=False))
        dx, dy = x - place.get("x", 0.0), y - place.get("y", 0.0)
        c, s = np.cos(place.get("yaw", 0.0)), np.sin(place.get("yaw", 0.0))
        return self.surface(c * dx + s * dy, c * dy - s * dx, np.exp(q[len(self.pose) :]))

    def described(self, q: Floats) -> dict[str, float]:
        """Return the parameters by name, sizes as lengths."""
        out = {f"{name}_rad" if name == "yaw" else f"{name}_m": float(v) for name, v in zip(self.pose, q, strict=False)}
        lengths = np.exp(q[len(self.pose) :])
        return out | {f"{name}_m": float(v) for name, v in zip(self.sizes, lengths, strict=True)}


def _flat(distance: Floats) -> tuple[Floats, Floats]:
    return np.zeros_like(distance), distance


def _open(drop: Floats) -> tuple[Floats, Floats]:
    return drop, np.full_like(drop, np.inf)


def _cylinder(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _flat(s[0] - np.hypot(u, v))


def _square_pillar(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _flat(s[0] / 2 - np.maximum(np.abs(u), np.abs(v)))


def _rectangular_pillar(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _flat(np.minimum(s[0] / 2 - np.abs(u), s[1] / 2 - np.abs(v)))


def _cone_frustum(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _open(np.maximum(np.hypot(u, v) - s[0], 0.0) / max(s[1], _STEEPEST * s[0]))


def _pyramid_frustum(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    fall = max(s[1], _STEEPEST * s[0] / 2)
    return _open(np.maximum(np.maximum(np.abs(u), np.abs(v)) - s[0] / 2, 0.0) / fall)


def _sphere(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _open((u * u + v * v) / s[0] ** 2)


def _cone(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _open(np.hypot(u, v) / s[0])


def _pyramid(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _open(np.maximum(np.abs(u), np.abs(v)) / s[0])


def _ridge(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return np.abs(v) / s[1], s[0] / 2 - np.abs(u)


def _hip(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _open(np.maximum(np.abs(v), np.abs(u) - s[0] / 2) / s[1])


def _lying_cylinder(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return (v / s[1]) ** 2, s[0] / 2 - np.abs(u)


def _wedge(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _open(np.abs(v) / s[0] + 0.0 * u)


def _edge(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _flat(-u + 0.0 * v)


def _plane(u: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    return _flat(np.full(u.shape, np.inf))


def _fall(hint: Hint, over_m: float) -> float:
    """Length over which the face falls by the depth, if it falls by the hint's rise over `over_m`."""
    return over_m / min(max(hint.rise, 0.15), 1.0)


_XY, _XYW = ("x", "y"), ("x", "y", "yaw")


def _radius(hint: Hint) -> float:
    return float(np.sqrt(hint.area_m2 / np.pi))


def _breadth(hint: Hint) -> float:
    return float(np.sqrt(hint.area_m2))


def _cone_frusta(hint: Hint) -> tuple[tuple[float, ...], ...]:
    # On a thick skin little more than the top touches, on a thin one the whole slope.
    radius = _radius(hint)
    return (0.5 * radius, _fall(hint, 0.6 * radius)), (0.9 * radius, 0.5 * radius), (radius, 1.2 * radius)


def _pyramid_frusta(hint: Hint) -> tuple[tuple[float, ...], ...]:
    breadth = _breadth(hint)
    return (0.5 * breadth, _fall(hint, 0.3 * breadth)), (0.9 * breadth, 0.25 * breadth), (breadth, 0.6 * breadth)


def _round(hint: Hint, half_m: float) -> float:
    """Length over which a round face falls by the depth, if it falls by the hint's rise over `half_m`."""
    return half_m / float(np.sqrt(min(max(hint.rise, 0.15), 1.0)))


def _hips(hint: Hint) -> tuple[tuple[float, ...], ...]:
    crest = max(hint.long_m - hint.short_m, 0.3 * hint.long_m)
    return ((crest, _fall(hint, hint.short_m / 2)),)


#: The forms by the name of their solid in `varishold.solids.SOLIDS`.
FORMS: Mapping[str, Form] = MappingProxyType(
    {
        "cylinder": Form(_XY, ("radius",), _cylinder, lambda h: ((_radius(h),),)),
        "square-pillar": Form(_XYW, ("breadth",), _square_pillar, lambda h: ((_breadth(h),),), "square"),
        "rectangular-pillar": Form(
            _XYW, ("length", "breadth"), _rectangular_pillar, lambda h: ((h.long_m, h.short_m),)
        ),
        "cone-frustum": Form(_XY, ("radius", "fall"), _cone_frustum, _cone_frusta),
        "pyramid-frustum": Form(_XYW, ("breadth", "fall"), _pyramid_frustum, _pyramid_frusta, "square"),
        "sphere": Form(_XY, ("fall",), _sphere, lambda h: ((_round(h, _radius(h)),),)),
        "cone": Form(_XY, ("fall",), _cone, lambda h: ((_fall(h, _radius(h)),),)),
        "pyramid": Form(_XYW, ("fall",), _pyramid, lambda h: ((_fall(h, _breadth(h) / 2),),), "square"),
        "ridge": Form(_XYW, ("length", "fall"), _ridge, lambda h: ((h.long_m, _fall(h, h.short_m / 2)),)),
        "hip": Form(_XYW, ("length", "fall"), _hip, _hips),
        "lying-cylinder": Form(
            _XYW, ("length", "fall"), _lying_cylinder, lambda h: ((1.1 * h.long_m, _round(h, h.short_m / 2)),)
        ),
        "wedge": Form(_XYW, ("fall",), _wedge, lambda h: ((_fall(h, h.short_m / 2),),)),
        "edge": Form(_XYW, (), _edge, lambda h: ((),), "border"),
        "plane": Form((), (), _plane, lambda h: ((),)),
    }
)
