"""The surface of a stranger: the hand touches it where its surface is least known."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from varishold.errors import require
from varishold.exploration.surface_contacts import TouchedPoints, touched_points
from varishold.exploration.touch import PoseEstimate, surfaces_of
from varishold.exploration.touches import TOUCHES
from varishold.hand import Bench, HandSetting, PadSetting, Step, set_up
from varishold.hand.actions import CLEAR_M, approach, come_down, let_go, move_round, squeeze
from varishold.perceive import ImplicitSurface, SurfaceContacts, SurfaceMesh
from varishold.solids import MeshSolid

__all__ = ["MOST_SURFACE_TOUCHES", "SurfaceExploration", "SurfaceTouch", "check_touches", "explore_surface"]

Floats = NDArray[np.float64]

#: Touches that are made at most: more points than those of so many would make the surface slow.
MOST_SURFACE_TOUCHES = 16

# Grips are tried from so many sides, and with the palm's middle at heights that are so far apart; fingertips at so many
# places on the top from so many sides. Metres.
_SIDES, _HEIGHT_STEP_M, _TIPS, _TIP_SIDES = 12, 0.02, 9, 4

# The palm's middle stays so far above the table, and at most so far above the top. Metres.
_LOWEST_M, _ABOVE_TOP_M = 0.025, 0.01

# A hand that goes round turns by such steps; it stands off by this until it knows how broad the object is, and goes
# forward at most so much farther. Radians, metres.
_STEP_RAD, _STAND_OFF_M, _FARTHER_M = 0.8, 0.15, 0.03

# Touches that are nearer than this feel the same. Metres.
_LIKE_M = 0.008

# Steps of the grid on which the surface is looked at between touches.
_COARSE = 20

# A section of the mesh is what lies within this of a height. Metres.
_SECTION_M = 0.006

# A face looks up where its normal does by more than this, 1.
_UP = 0.8


@dataclass(frozen=True)
class SurfaceTouch:
    """A touch for the surface's sake.

    Parameters
    ----------
    kind : {"search", "grip", "fingertip"}
        The first grip, which searches; a grip of all digits; a fingertip from above.
    turn_rad : float
        The side that the palm stands on: its heading, from +x toward +y.
    height_m : float
        Of a grip: height of the palm's middle over its zero. Metres.
    place_m : (float, float)
        Of a fingertip: where it comes down. Of a grip: the object's middle. Metres.
    away_m : float
        How far from there the palm stands before it moves on. Metres.
    """

    kind: Literal["search", "grip", "fingertip"]
    turn_rad: float = 0.0
    height_m: float = 0.0
    place_m: tuple[float, float] = (0.0, 0.0)
    away_m: float = _STAND_OFF_M

    def like(self, other: SurfaceTouch) -> bool:
        """Whether it would feel what another one felt."""
        apart = float(np.hypot(self.place_m[0] - other.place_m[0], self.place_m[1] - other.place_m[1]))
        same = self.kind == other.kind and abs(self.turn_rad - other.turn_rad) < 1e-6
        return same and (apart < _LIKE_M if self.kind == "fingertip" else abs(self.height_m - other.height_m) < _LIKE_M)

    @property
    def heading(self) -> Floats:
        """Unit vector (x, y) that the palm looks along."""
        return np.array([np.cos(self.turn_rad), np.sin(self.turn_rad)])


@dataclass(frozen=True)
class SurfaceExploration:
    """A surface that was touched, and how.

    Parameters
    ----------
    name : str
        What the object truly is.
    size_m : float
        Its true size. Metres.
    seed : int
    touches : tuple of SurfaceTouch
    felt : tuple of TouchedPoints
        What each told; no points where it missed.
    surface : ImplicitSurface
    mesh : SurfaceMesh
    history_m : tuple of float
        Mean standard deviation over the surface after each touch; NaN as long as there is none. Metres.
    pose : tuple of ndarray of shape (3,) and ndarray of shape (3, 3)
        The truth, which the hand cannot know: origin (metres) and axes of the object.
    """

    name: str
    size_m: float
    seed: int
    touches: tuple[SurfaceTouch, ...]
    felt: tuple[TouchedPoints, ...]
    surface: ImplicitSurface
    mesh: SurfaceMesh
    history_m: tuple[float, ...]
    pose: tuple[Floats, Floats]


def explore_surface(
    name: str | MeshSolid,
    size_m: float,
    *,
    seed: int,
    touches: int = 12,
    setting: HandSetting | None = None,
    on_touch: Callable[[int, SurfaceTouch, TouchedPoints, float], None] | None = None,
) -> SurfaceExploration:
    """Touch an object that is clamped to the table, each time where its surface is least known.

    Parameters
    ----------
    name : str or MeshSolid
        As of `varishold.hand.set_up`.
    size_m : float
        Diameter or breadth. Metres.
    seed : int
        The same seed gives the same exploration.
    touches : int
        How many touches, 2 to 16.
    setting : HandSetting, optional
        Default: the usual hand with pads, which must search. It must have pads, and the object be clamped.
    on_touch : callable, optional
        Called after each touch with its number, what it was, what it told, and the mean standard deviation (metres).

    Raises
    ------
    InputError
        If the object is unknown or does not fit the hand, the seed is negative, the number of touches is out of range,
        or the setting has no pads or no clamp; if too little was felt to close a surface.
    MissingExtraError
        If MuJoCo is not installed.
    """
    check_touches(touches)
    setting = setting or HandSetting(search=True, clamped=True, pads=PadSetting())
    require(setting.pads is not None, "a surface is felt by pads: give HandSetting(pads=PadSetting())")
    require(setting.clamped, "the object must stay where it is: give HandSetting(clamped=True)")
    bench, _ = set_up(name, size_m, seed=seed, setting=setting)
    hand = _Hand(bench, setting)
    wanted = SurfaceTouch("search")
    made: list[SurfaceTouch] = []
    felt: list[TouchedPoints] = []
    history: list[float] = []
    surface = None
    for number in range(1, touches + 1):
        made.append(wanted)
        felt.append(hand.touch(wanted))
        if sum(len(each.point_m) for each in felt) < 4:
            history.append(float("nan"))
            # Nothing there: from the other sides, where it may be reached.
            wanted = SurfaceTouch("grip", wanted.turn_rad + np.pi / 2, wanted.height_m, hand.guess_m)
        else:
            surface = ImplicitSurface(_contacts(felt), table_m=bench.table_m)
            mesh = surface.mesh(steps=_COARSE)
            area = mesh.vertex_areas_m2 * _above_table(mesh, bench)
            history.append(float(area @ mesh.sigma_m / area.sum()))
            if number < touches:
                wanted = _next(surface, mesh, bench, made)
        if on_touch is not None:
            on_touch(number, made[-1], felt[-1], history[-1])
    # Of too few points, this says so.
    surface = surface or ImplicitSurface(_contacts(felt), table_m=bench.table_m)
    true = name if isinstance(name, str) else name.called
    return SurfaceExploration(
        true, size_m, seed, tuple(made), tuple(felt), surface, surface.mesh(), tuple(history), bench.object_pose()
    )


def check_touches(touches: int) -> int:
    """Return how many touches a surface takes, refused where a surface cannot take so many."""
    require(2 <= touches <= MOST_SURFACE_TOUCHES, f"touches must lie in 2 .. {MOST_SURFACE_TOUCHES}, got {touches!r}")
    return touches


def _contacts(felt: list[TouchedPoints]) -> SurfaceContacts:
    numbers = [np.full(len(each.point_m), k) for k, each in enumerate(felt)]
    return SurfaceContacts(
        np.vstack([each.point_m for each in felt]),
        np.vstack([each.normal for each in felt]),
        np.concatenate([each.sigma_m for each in felt]),
        np.concatenate([each.normal_sigma for each in felt]),
        np.concatenate(numbers),
        np.vstack([each.free_m for each in felt]),
    )


class _Hand:
    """Makes touches, and reads them."""

    def __init__(self, bench: Bench, setting: HandSetting) -> None:
        self._bench, self._setting = bench, setting
        self._pose = PoseEstimate()
        self.guess_m = (0.1, 0.0)

    def touch(self, wanted: SurfaceTouch) -> TouchedPoints:
        bench, setting = self._bench, self._setting
        if wanted.kind == "search":
            step = self._search()
        else:
            let_go(bench)
            self._go_round(wanted)
            if wanted.kind == "fingertip":
                step = come_down(bench, wanted.away_m, pads=setting.pads).step
            else:
                approach(bench, most_m=wanted.away_m + _FARTHER_M)
                step = squeeze(bench, pads=setting.pads)[-1]
        return touched_points(step.sensed, surfaces_of(step, setting), setting.design)

    def _search(self) -> Step:
        felt = TOUCHES["squeeze"].make(self._bench, self._pose, self._setting)
        if felt is not None:
            self.guess_m = self._pose.middle_m or self.guess_m
            return felt.step
        return squeeze(self._bench, pads=self._setting.pads)[-1]

    def _go_round(self, wanted: SurfaceTouch) -> None:
        now = self._bench.target["turn"]
        way = (wanted.turn_rad - now + np.pi) % (2 * np.pi) - np.pi
        steps = max(1, int(np.ceil(abs(way) / _STEP_RAD)))
        for k in range(1, steps + 1):
            turn = now + way * k / steps
            move_round(self._bench, wanted.place_m, turn_rad=turn, raise_m=wanted.height_m, away_m=wanted.away_m)


def _above_table(mesh: SurfaceMesh, bench: Bench) -> NDArray[np.bool_]:
    """Which vertices do not lie on the table."""
    return np.asarray(mesh.vertices_m[:, 2] > bench.table_m + 1e-4)


def _next(surface: ImplicitSurface, mesh: SurfaceMesh, bench: Bench, made: list[SurfaceTouch]) -> SurfaceTouch:
    """The touch whose expected contacts would take most from the surface's variance."""
    seen = _above_table(mesh, bench)
    places, normals, area = mesh.vertices_m[seen], mesh.vertex_normals[seen], mesh.vertex_areas_m2[seen]
    tries = [touch for touch in _candidates(places, normals, bench) if not any(touch.like(each) for each in made)]
    expected = [_expected(touch, places, normals, bench) for touch in tries]
    where, back = np.unique(np.concatenate(expected), return_inverse=True)
    if not len(where):
        return made[-1]
    together = surface.covariance(places, places[where])
    noise = surface.floor_m**2
    taken = together**2 / (together[where, np.arange(len(where))] + noise)
    ends = np.cumsum([len(each) for each in expected])
    told = [
        float(area @ taken[:, back[end - len(each) : end]].max(axis=1)) if len(each) else -1.0
        for each, end in zip(expected, ends.tolist(), strict=True)
    ]
    return tries[int(np.argmax(told))]


def _candidates(places: Floats, normals: Floats, bench: Bench) -> Iterator[SurfaceTouch]:
    low, high = places.min(axis=0), places.max(axis=0)
    x, y, _ = ((low + high) / 2).tolist()
    away_m = CLEAR_M + bench.design.longer_m + float(np.hypot(*(high - low)[:2])) / 2
    sides = (2 * np.pi * np.arange(_SIDES) / _SIDES).tolist()
    heights = np.arange(bench.table_m + _LOWEST_M, high[2] + _ABOVE_TOP_M, _HEIGHT_STEP_M)
    for height in heights.tolist() or [bench.table_m + _LOWEST_M]:
        for turn in sides:
            yield SurfaceTouch("grip", turn, height, (x, y), away_m)
    if bench.design.tip is None:
        return
    top = places[(normals[:, 2] > _UP) & (places[:, 2] > (low[2] + high[2]) / 2), :2]
    away = -np.linalg.norm(top - top.mean(axis=0), axis=1) if len(top) else np.zeros(0)
    for k in range(min(_TIPS, len(top))):
        at = top[int(away.argmax())]
        for turn in sides[:: _SIDES // _TIP_SIDES]:
            beyond = float(np.hypot(at[0] - x, at[1] - y))
            yield SurfaceTouch("fingertip", turn, 0.0, (float(at[0]), float(at[1])), away_m + beyond)
        new = np.linalg.norm(top - at, axis=1)
        away = np.minimum(away, new) if k else new


def _expected(touch: SurfaceTouch, places: Floats, normals: Floats, bench: Bench) -> NDArray[np.int64]:
    """At which of the places a touch is expected to meet the surface."""
    ahead, design = touch.heading, bench.design
    if touch.kind == "fingertip":
        near = np.flatnonzero(np.linalg.norm(places[:, :2] - touch.place_m, axis=1) < _SECTION_M)
        return near[[int(places[near, 2].argmax())]] if len(near) else near
    aside = np.array([-ahead[1], ahead[0]])
    found = []
    for digit in design.digits.values():
        off = np.abs(places[:, 2] - touch.height_m - digit.height_m)
        section = np.flatnonzero((off < _SECTION_M) & (np.abs(normals[:, 2]) < _UP))
        side = digit.side * aside
        for way in (side, side + ahead, -ahead) if len(section) else ():
            found.append(section[int((places[section, :2] @ way).argmax())])
    return np.array(found, dtype=np.int64)
