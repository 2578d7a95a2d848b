"""Where the hand touches a stranger next, and what a touch says: plain sums beside the program's."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
pytest.importorskip("scipy", reason="SciPy is not installed; pip install -e '.[skin]'")

from varishold.errors import InputError
from varishold.exploration import SurfaceTouch, check_touches, explore_surface, shape
from varishold.exploration import touch as touch_room
from varishold.exploration.surface_contacts import TouchedPoints, touched_points
from varishold.exploration.touch import surfaces_of
from varishold.hand import HandDesign, HandSetting, PadSetting
from varishold.hand.palm_place import palm_place
from varishold.touch.pads.measures import MEASURES

TABLE_M = 0.01
DIGITS = {"one": SimpleNamespace(height_m=0.03, side=1.0), "other": SimpleNamespace(height_m=-0.02, side=-1.0)}
BENCH: Any = SimpleNamespace(table_m=TABLE_M, design=SimpleNamespace(digits=DIGITS, longer_m=0.0, tip="one"))


def told(n: int, at: float = 0.0) -> TouchedPoints:
    """So many points of a touch."""
    rows = at + np.arange(3.0 * n).reshape(n, 3)
    return TouchedPoints(rows, rows + 0.5, rows[:, 0] + 0.1, rows[:, 0] + 0.2, rows[:1] + 0.3)


def test_a_touch_is_like_another_that_would_feel_the_same() -> None:
    grip = SurfaceTouch("grip", 0.3, 0.05, (0.1, 0.0))
    assert grip.like(replace(grip, place_m=(0.2, 0.3), away_m=0.4))
    for sign in (-1, 1):
        assert grip.like(replace(grip, height_m=0.05 + sign * 0.0079))
        assert not grip.like(replace(grip, height_m=0.05 + sign * 0.0081))
        assert grip.like(replace(grip, turn_rad=0.3 + sign * 9e-7))
        assert not grip.like(replace(grip, turn_rad=0.3 + sign * 2e-6))
    tip = SurfaceTouch("fingertip", 0.3, 0.0, (0.0, 0.0))
    assert not tip.like(replace(tip, kind="grip"))
    assert tip.like(replace(tip, height_m=0.5))
    for x, y in ((0.0, 0.0), (0.1, -0.2)):
        there = replace(tip, place_m=(x, y))
        assert there.like(replace(tip, place_m=(x + 0.0056, y - 0.0056)))
        assert not there.like(replace(tip, place_m=(x + 0.0058, y - 0.0058)))
    assert not tip.like(replace(tip, turn_rad=-0.3))
    assert not tip.like(replace(tip, place_m=(0.008, 0.0)))
    low = SurfaceTouch("grip")
    assert not low.like(SurfaceTouch("grip", height_m=0.008))
    assert not low.like(SurfaceTouch("grip", turn_rad=1e-6))


def test_a_touch_looks_along_its_turn() -> None:
    for turn in (0.0, 0.4, 2.0, -1.0):
        np.testing.assert_allclose(
            SurfaceTouch("grip", turn).heading, [math.cos(turn), math.sin(turn)], rtol=0, atol=1e-15
        )
    assert SurfaceTouch("search").away_m == 0.15


def box(rng: np.random.Generator, tops: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box of 60 by 80 by 100 mm about (.13, .01), a shelf, slopes, and some places on its top."""
    corners = [[0.1, -0.03, 0.01], [0.16, 0.05, 0.01], [0.1, 0.05, 0.11], [0.16, -0.03, 0.11]]
    shelf = [[0.12, 0.0, 0.05], [0.12, 0.0, 0.06]]
    slope = [[0.13, 0.0, 0.1]]
    top = np.column_stack([rng.uniform(0.1, 0.16, tops), rng.uniform(-0.03, 0.05, tops), np.full(tops, 0.105)])
    places = np.vstack([corners, shelf, slope, top])
    up = np.array([0.0] * len(corners) + [1.0] * len(shelf) + [0.8] + [0.81] * tops)
    return places, np.column_stack([np.sqrt(1 - up**2), 0 * up, up])


def spread(top: np.ndarray, most: int) -> list[np.ndarray]:
    """The one nearest the middle, and after it each time the one that is farthest from those before."""
    left = [np.array(p) for p in top.tolist()]
    chosen = [min(left, key=lambda p: float(math.dist(p, top.mean(axis=0))))]
    while len(chosen) < min(most, len(top)):
        chosen.append(max(left, key=lambda p: min(math.dist(p, q) for q in chosen)))
    return chosen


@pytest.mark.parametrize("tops", [0, 1, 2, 5, 9, 25])
def test_grips_and_fingertips_are_tried_from_all_sides(tops: int) -> None:
    places, normals = box(np.random.default_rng(tops), tops)
    tried = list(shape._candidates(places, normals, BENCH))
    grips = [touch for touch in tried if touch.kind == "grip"]
    # From 25 mm over the table, by 20 mm, up to 10 mm over the top at 110 mm.
    heights = [0.035, 0.055, 0.075, 0.095, 0.115]
    assert len(grips) == 12 * len(heights)
    for touch, (height, k) in zip(grips, [(h, k) for h in heights for k in range(12)], strict=True):
        assert touch.height_m == pytest.approx(height)
        assert touch.turn_rad == pytest.approx(k * math.pi / 6)
        assert touch.place_m == pytest.approx((0.13, 0.01))
        assert touch.away_m == pytest.approx(0.11 + 0.05)
    tips = [touch for touch in tried if touch.kind == "fingertip"]
    assert len(tips) == 4 * min(tops, 9)
    assert len(tips) + len(grips) == len(tried)
    expected = [(at, k) for at in spread(places[7:, :2], 9) for k in range(4)] if tops else []
    for touch, (at, k) in zip(tips, expected, strict=True):
        assert touch.place_m == pytest.approx(tuple(at))
        assert touch.turn_rad == pytest.approx(k * math.pi / 2)
        assert touch.height_m == 0.0
        assert touch.away_m == pytest.approx(0.16 + math.dist(at, (0.13, 0.01)))


def test_what_is_low_is_gripped_at_the_least_height() -> None:
    places = np.array([[0.1, 0.0, TABLE_M], [0.14, 0.03, TABLE_M + 0.014]])
    tried = list(shape._candidates(places, np.eye(3)[:2], BENCH))
    assert len(tried) == 12
    assert [touch.height_m for touch in tried] == pytest.approx([0.035] * 12)


def ring(height_m: float, up: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Eight places round an upright middle line."""
    turn = np.arange(8) * math.pi / 4
    out = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    return 0.03 * out + [0.1, 0.0, height_m], math.sqrt(1 - up**2) * out + [0.0, 0.0, up]


def test_what_lies_at_the_bound_of_a_section_is_not_in_it() -> None:
    level: Any = SimpleNamespace(
        design=SimpleNamespace(digits={"one": SimpleNamespace(height_m=0.0, side=1.0)}, longer_m=0.0, tip="one")
    )
    places, normals = np.array([[0.0, 0.0, 0.006]]), np.array([[0.6, 0.0, 0.8]])
    grip, tip = SurfaceTouch("grip"), SurfaceTouch("fingertip")
    assert shape._expected(grip, places, np.eye(3)[:1], level).tolist() == []
    assert shape._expected(grip, 0.9 * places, normals, level).tolist() == []
    assert shape._expected(grip, 0.9 * places, np.eye(3)[:1], level).tolist() == [0, 0, 0]
    assert shape._expected(tip, places[:, [0, 2, 1]], normals, level).tolist() == []


@pytest.mark.parametrize("eighth", [0, 2, 3, 7])
def test_a_grip_meets_a_section_beside_before_and_nearest_the_palm(eighth: int) -> None:
    rings = [ring(0.12 + 0.0059), ring(0.07 - 0.0059, 0.79), ring(0.12), ring(0.12 + 0.007), ring(0.07, 0.81)]
    places, normals = np.vstack([p for p, _ in rings]), np.vstack([n for _, n in rings])
    # The upright ring at the finger's height counts no more than the first, which lies farther out.
    places[:8, :2] = 1.5 * (places[:8, :2] - [0.1, 0.0]) + [0.1, 0.0]
    touch = SurfaceTouch("grip", eighth * math.pi / 4, 0.09, (0.1, 0.0))
    finger = [(2 + eighth) % 8, (1 + eighth) % 8, (4 + eighth) % 8]
    thumb = [8 + (6 + eighth) % 8, 8 + (7 + eighth) % 8, 8 + (4 + eighth) % 8]
    assert shape._expected(touch, places, normals, BENCH).tolist() == finger + thumb
    assert shape._expected(replace(touch, height_m=0.3), places, normals, BENCH).tolist() == []
    assert shape._expected(touch, places[8:16], normals[8:16], BENCH).tolist() == [k - 8 for k in thumb]
    assert shape._expected(touch, places[24:32], normals[24:32], BENCH).tolist() == []
    assert shape._expected(touch, places[32:], normals[32:], BENCH).tolist() == []


def test_a_fingertip_meets_the_highest_place_under_it() -> None:
    places = np.array([[0.1, 0.0, 0.05], [0.104, 0.004, 0.09], [0.1, 0.0059, 0.1], [0.1, -0.0061, 0.12], [0.2, 0, 0.2]])
    touch = SurfaceTouch("fingertip", 0.0, 0.0, (0.1, 0.0))
    normals = np.tile([0.0, 0.0, 1.0], (5, 1))
    assert shape._expected(touch, places, normals, BENCH).tolist() == [2]
    assert shape._expected(touch, places[[0, 3]], normals[:2], BENCH).tolist() == [0]
    assert shape._expected(touch, places[3:], normals[:2], BENCH).tolist() == []


class KnownSurface:
    """A surface whose covariance is a formula."""

    floor_m = 0.4

    def covariance(self, places: np.ndarray, others: np.ndarray) -> np.ndarray:
        apart = np.linalg.norm(places[:, None] - others, axis=-1)
        return np.exp(-apart / 0.02) * np.outer(1 + 20 * places[:, 0] ** 2, 1 + 20 * others[:, 0] ** 2)


@pytest.mark.parametrize("seed", range(6))
def test_the_next_touch_takes_most_from_the_variance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places, normals = box(rng, 12)
    sides = np.column_stack([rng.uniform(0.1, 0.16, 60), rng.uniform(-0.03, 0.05, 60), rng.uniform(0.02, 0.1, 60)])
    below = np.column_stack([rng.uniform(0.1, 0.16, 20), rng.uniform(-0.03, 0.05, 20), np.full(20, TABLE_M + 1e-4)])
    vertices = np.vstack([places[2:], sides, below])
    outward = np.vstack([normals[2:], np.tile([1.0, 0.0, 0.0], (80, 1))])
    area = np.concatenate([rng.uniform(0.5, 2.0, len(vertices) - 20), np.full(20, 1e4)])
    mesh: Any = SimpleNamespace(vertices_m=vertices, vertex_normals=outward, vertex_areas_m2=area)
    surface: Any = KnownSurface()
    places, outward, area = vertices[:-20], outward[:-20], area[:-20]
    together = surface.covariance(places, places)

    def taken(touch: SurfaceTouch) -> float:
        met = shape._expected(touch, places, outward, BENCH).tolist()
        if not met:
            return -1.0
        rows = range(len(places))
        return sum(area[i] * max(together[i, j] ** 2 / (together[j, j] + 0.16) for j in met) for i in rows)

    made = [SurfaceTouch("search")]
    for _ in range(3):
        left = [
            touch for touch in shape._candidates(places, outward, BENCH) if not any(touch.like(one) for one in made)
        ]
        wanted = shape._next(surface, mesh, BENCH, made)
        assert wanted in left
        assert taken(wanted) == pytest.approx(max(map(taken, left)), rel=1e-9)
        made.append(wanted)


def test_where_no_touch_would_meet_anything_the_last_is_made_again() -> None:
    places = np.array([[0.1, 0.0, 0.02], [0.14, 0.03, 0.03]])
    # No face is steep enough for a grip, or flat enough for a fingertip.
    mesh: Any = SimpleNamespace(
        vertices_m=places, vertex_normals=np.tile([0.6, 0.0, 0.8], (2, 1)), vertex_areas_m2=np.ones(2)
    )
    made = [SurfaceTouch("search"), SurfaceTouch("grip", 0.1)]
    surface: Any = KnownSurface()
    assert shape._next(surface, mesh, BENCH, made) is made[-1]


def hand_at(turn: float) -> tuple[Any, Any]:
    bench: Any = SimpleNamespace(target={"turn": turn})
    setting = HandSetting(search=True, clamped=True, pads=PadSetting())
    return shape._Hand(bench, setting), bench


@pytest.mark.parametrize("now", [0.0, 1.0, -2.5, 5.0])
@pytest.mark.parametrize("way", [0.0, 0.79, -0.79, 0.81, -0.81, 1.7, -2.3, 3.1, -3.1])
def test_the_hand_goes_round_the_short_way_by_small_steps(
    monkeypatch: pytest.MonkeyPatch, now: float, way: float
) -> None:
    hand, bench = hand_at(now)
    stands: list[tuple[Any, ...]] = []
    monkeypatch.setattr(
        shape,
        "move_round",
        lambda b, at, *, turn_rad, raise_m, away_m: stands.append((b, at, turn_rad, raise_m, away_m)),
    )
    for more in (0.0, 2 * math.pi, -2 * math.pi):
        stands.clear()
        hand._go_round(SurfaceTouch("grip", now + way + more, 0.07, (0.1, 0.2), 0.33))
        assert len(stands) == max(1, math.ceil(abs(way) / 0.8))
        turns = np.array([now, *(each[2] for each in stands)])
        np.testing.assert_allclose(np.diff(turns), way / len(stands), atol=1e-12)
        for b, at, _, height, away in stands:
            assert b is bench
            assert (at, height, away) == ((0.1, 0.2), 0.07, 0.33)


def test_a_hand_touches_as_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    hand, bench = hand_at(0.0)
    pads = hand._setting.pads
    calls: list[Any] = []
    step = SimpleNamespace(sensed="sensed", pads=None)

    def noted(name: str, result: Any = None) -> Any:
        return lambda *words, **more: calls.append((name, words, more)) or result

    for name, result in (
        ("let_go", None),
        ("move_round", None),
        ("come_down", SimpleNamespace(step=step)),
        ("approach", True),
        ("squeeze", ("first", step)),
    ):
        monkeypatch.setattr(shape, name, noted(name, result))
    monkeypatch.setattr(shape, "touched_points", lambda *words: words)
    said = ("sensed", {}, hand._setting.design)
    assert hand.touch(SurfaceTouch("fingertip", 0.0, 0.0, (0.1, 0.0), 0.3)) == said
    assert [each[0] for each in calls] == ["let_go", "move_round", "come_down"]
    assert calls[-1][1:] == ((bench, 0.3), {"pads": pads})
    calls.clear()
    assert hand.touch(SurfaceTouch("grip", 0.0, 0.0, (0.1, 0.0), 0.3)) == said
    assert [each[0] for each in calls] == ["let_go", "move_round", "approach", "squeeze"]
    assert calls[-2][2]["most_m"] == pytest.approx(0.33)
    assert calls[-1][1:] == ((bench,), {"pads": pads})
    calls.clear()
    # The first touch finds the object, and says where its middle is; where it finds none, it closes where it is.
    assert hand.guess_m == (0.1, 0.0)
    monkeypatch.setitem(shape.TOUCHES, "squeeze", SimpleNamespace(make=lambda *_: None))
    assert hand.touch(SurfaceTouch("search")) == said
    assert [each[0] for each in calls] == ["squeeze"]
    assert hand.guess_m == (0.1, 0.0)
    calls.clear()

    def found(_: Any, pose: Any, setting: HandSetting) -> Any:
        assert setting is hand._setting
        pose.middle_m = (0.2, 0.3)
        return SimpleNamespace(step=step)

    monkeypatch.setitem(shape.TOUCHES, "squeeze", SimpleNamespace(make=found))
    assert hand.touch(SurfaceTouch("search")) == said
    assert calls == []
    assert hand.guess_m == (0.2, 0.3)
    # What was found without a middle leaves the guess as it was.
    monkeypatch.setitem(shape.TOUCHES, "squeeze", SimpleNamespace(make=lambda *_: SimpleNamespace(step=step)))
    hand._pose.middle_m = None
    assert hand.touch(SurfaceTouch("search")) == said
    assert calls == []
    assert hand.guess_m == (0.2, 0.3)


def test_a_pad_that_nothing_presses_has_no_surface(monkeypatch: pytest.MonkeyPatch) -> None:
    setting = HandSetting(pads=PadSetting())
    monkeypatch.setattr(touch_room, "feel_surface", lambda frame, skin, *, pitch_m: (frame.sum(), skin, pitch_m))
    frames = {"one": np.zeros((2, 2)), "other": np.eye(2)}
    step: Any = SimpleNamespace(pads=SimpleNamespace(frames=frames, pitch_m={"one": 0.1, "other": 0.2}))
    assert surfaces_of(step, setting) == {"one": None, "other": (2.0, setting.pads.skin, 0.2)}
    step.pads = None
    assert surfaces_of(step, setting) == {}


def test_contacts_are_those_of_all_touches_in_their_order() -> None:
    felt = [told(2), told(0), told(3, 1.0)]
    felt = [replace(each, point_m=0.01 * each.point_m, free_m=0.01 * each.free_m) for each in felt]
    all_of_them = shape._contacts(felt)
    assert np.asarray(all_of_them.touch).tolist() == [0, 0, 2, 2, 2]
    np.testing.assert_array_equal(all_of_them.point_m, np.vstack([felt[0].point_m, felt[2].point_m]))
    out = np.vstack([felt[0].normal, felt[2].normal])
    np.testing.assert_allclose(all_of_them.normal, out / np.linalg.norm(out, axis=1, keepdims=True))
    np.testing.assert_array_equal(np.asarray(all_of_them.sigma_m), [0.1, 3.1, 1.1, 4.1, 7.1])
    np.testing.assert_array_equal(np.asarray(all_of_them.normal_sigma), [0.2, 3.2, 1.2, 4.2, 7.2])
    np.testing.assert_array_equal(np.asarray(all_of_them.free_m), np.vstack([each.free_m for each in felt]))


def test_the_loop_turns_until_it_feels_something_then_goes_where_least_is_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answers = [told(0), told(3), told(1), told(2)]
    bench = SimpleNamespace(table_m=TABLE_M, object_pose=lambda: "pose")
    vertices = np.array([[0, 0, TABLE_M], [0, 0, TABLE_M + 1e-4], [0, 0, TABLE_M + 1.1e-4], [0, 0, 0.1]])
    mesh = SimpleNamespace(
        vertices_m=vertices,
        vertex_areas_m2=np.array([5.0, 7.0, 1.0, 3.0]),
        sigma_m=np.array([100.0, 100.0, 0.4, 0.8]),
    )
    grids: list[Any] = []

    class Surface:
        def __init__(self, contacts: Any, *, table_m: float) -> None:
            self.contacts = contacts
            assert table_m == TABLE_M

        def mesh(self, **more: Any) -> Any:
            grids.append(more)
            return mesh

    class Hand:
        guess_m = (0.2, 0.1)

        def __init__(self, given: Any, setting: HandSetting) -> None:
            assert given is bench
            assert setting.clamped
            assert setting.search
            assert setting.pads is not None

        def touch(self, wanted: SurfaceTouch) -> TouchedPoints:
            return answers[len(notes)]

    notes: list[Any] = []
    asked: list[Any] = []
    asked_for: list[int] = []
    best = SurfaceTouch("fingertip", 0.3)
    monkeypatch.setattr(
        shape, "set_up", lambda name, size, *, seed, setting: (asked.append((name, size, seed)) or bench, 0)
    )
    monkeypatch.setattr(shape, "_Hand", Hand)
    monkeypatch.setattr(shape, "_contacts", lambda felt: len(felt))
    monkeypatch.setattr(shape, "ImplicitSurface", Surface)
    monkeypatch.setattr(shape, "_next", lambda surface, m, b, made: asked_for.append(len(made)) or best)
    out: Any = explore_surface("ball", 0.06, seed=3, touches=4, on_touch=lambda *words: notes.append(words))
    assert asked == [("ball", 0.06, 3)]
    second = SurfaceTouch("grip", math.pi / 2, 0.0, (0.2, 0.1))
    third = replace(second, turn_rad=math.pi)
    assert out.touches == (SurfaceTouch("search"), second, third, best)
    assert out.felt == tuple(answers)
    assert np.isnan(out.history_m[:2]).all()
    # Of what stands above the table, by its area.
    assert out.history_m[2:] == pytest.approx([(0.4 + 3 * 0.8) / 4] * 2)
    assert [each[0] for each in notes] == [1, 2, 3, 4]
    assert [each[1:3] for each in notes] == list(zip(out.touches, out.felt, strict=True))
    assert [each[3] for each in notes] == pytest.approx(list(out.history_m), nan_ok=True)
    assert (out.name, out.size_m, out.seed, out.pose) == ("ball", 0.06, 3, "pose")
    assert out.surface.contacts == 4
    assert out.mesh is mesh
    assert grids == [{"steps": 20}, {"steps": 20}, {}]
    # After the last touch none is looked for.
    assert asked_for == [3]
    notes.clear()
    assert len(explore_surface("ball", 0.06, seed=3, touches=2).touches) == 2
    answers[0] = told(4)
    assert len(explore_surface("ball", 0.06, seed=3).touches) == 12


def test_what_no_surface_can_be_felt_with_is_refused() -> None:
    for touches in (-1, 1, 17):
        with pytest.raises(InputError, match=rf"touches must lie in 2 \.\. 16, got {touches}"):
            explore_surface("ball", 0.06, seed=1, touches=touches)
    assert [check_touches(touches) for touches in (2, 16)] == [2, 16]
    with pytest.raises(InputError, match="a surface is felt by pads"):
        explore_surface("ball", 0.06, seed=1, setting=HandSetting(clamped=True))
    with pytest.raises(InputError, match="the object must stay where it is"):
        explore_surface("ball", 0.06, seed=1, setting=HandSetting(pads=PadSetting()))


# What a touch says. The hand's fingers are straight, along x; the palm's frame is the table's.

DESIGN = HandDesign()
ALONG, SIDE, UP = np.eye(3)


def pad(
    along_m: float = 0.0,
    beside_m: float = 0.0,
    *,
    bend: tuple[float, float] = (0.0, 0.0),
    tip: float = 0.0,
    lean: float = 0.0,
) -> Any:
    """What a pad feels; the slopes that it sees are two thirds of those that are."""
    measures = dict.fromkeys(MEASURES, 0.0)
    measures["tilt_along_cols"] = math.asinh(5 * math.tan(tip) / 1.5)
    measures["tilt_along_rows"] = math.asinh(5 * math.tan(lean) / 1.5)
    return SimpleNamespace(centre_m=(along_m, beside_m), curvature_1_m=bend, measures=np.array(list(measures.values())))


def says(surfaces: dict[str, Any], carriage: np.ndarray | None = None) -> TouchedPoints:
    sensed: Any = SimpleNamespace(angles_rad=np.zeros(15), carriage=np.zeros(6) if carriage is None else carriage)
    return touched_points(sensed, surfaces, DESIGN)


# Of the index finger's first phalanx: where its middle line starts, half its length, and its radius.
START, HALF, RADIUS = np.array([-0.012, 0.052, 0.033]), 0.023, 0.008
POINT, BESIDE, EDGE_NORMAL, NORMAL = 0.0006, math.hypot(0.0006, 0.001), 0.35, 0.08


def on_bar(along_m: float, toward: np.ndarray) -> np.ndarray:
    return START + (HALF + along_m) * ALONG + RADIUS * toward


@pytest.mark.parametrize("bend", [0.0, 20.0, -20.0, 59.0, -59.0])
def test_a_finger_tells_a_point_and_two_beside_it_on_a_circle(bend: float) -> None:
    out = says({"index.proximal": pad(0.004, bend=(bend, 500.0))})
    at = on_bar(0.004, -SIDE)
    points, normals = [at], [SIDE]
    for step in (-0.006, 0.006):
        points.append(at + step * ALONG - bend * step**2 / 2 * SIDE)
        turned = SIDE + bend * step * ALONG
        normals.append(turned / np.linalg.norm(turned))
    np.testing.assert_allclose(out.point_m, points, rtol=0, atol=1e-12)
    np.testing.assert_allclose(out.normal, normals, rtol=0, atol=1e-12)
    np.testing.assert_allclose(out.sigma_m, [POINT, BESIDE, BESIDE])
    np.testing.assert_allclose(out.normal_sigma, [NORMAL, 2 * NORMAL, 2 * NORMAL])


@pytest.mark.parametrize("bend", [61.0, -61.0])
def test_an_edge_tells_one_point_whose_normal_is_unsure(bend: float) -> None:
    out = says({"index.proximal": pad(0.004, bend=(bend, 0.0), tip=0.3)})
    np.testing.assert_allclose(out.point_m, [on_bar(0.004, -SIDE)], atol=1e-12)
    np.testing.assert_allclose(out.normal, [SIDE], atol=1e-12)
    assert (out.sigma_m.tolist(), out.normal_sigma.tolist()) == ([POINT], [EDGE_NORMAL])


@pytest.mark.parametrize(
    ("along", "tip", "bend", "at", "turned", "sigma", "unsure"),
    [
        (0.0179, 0.3, 0.0, 0.0179, 0.0, POINT, NORMAL),
        (0.0181, 0.0, 0.0, 0.0181, 0.0, POINT, NORMAL),
        (0.0181, 0.07, 0.0, 0.0181, 0.07, POINT, NORMAL),
        (0.0181, 0.09, 0.0, HALF, 0.09, POINT, NORMAL + 0.35 * 0.09),
        (-0.019, 0.3, 0.0, -HALF, -0.3, POINT, NORMAL + 0.35 * 0.3),
        (0.0181, 0.59, 0.0, HALF, 0.59, POINT, NORMAL + 0.35 * 0.59),
        (0.0181, 0.61, 0.0, HALF, 0.61, 0.004, 0.6),
        (0.0181, 1.5, 0.0, HALF, 1.5, 0.004, NORMAL + 0.35 * 1.5),
        (0.0181, 0.3, 61.0, 0.0181, 0.0, 0.004, 0.6),
    ],
)
def test_the_end_of_a_bar_is_round(
    along: float, tip: float, bend: float, at: float, turned: float, sigma: float, unsure: float
) -> None:
    out = says({"index.proximal": pad(along, tip=tip, bend=(bend, 0.0))})
    toward = -math.cos(turned) * SIDE + math.sin(turned) * ALONG
    assert len(out.point_m) == (1 if abs(along) > 0.018 else 3)
    np.testing.assert_allclose(out.point_m[0], on_bar(at, toward), rtol=0, atol=1e-12)
    np.testing.assert_allclose(out.normal[0], -toward, rtol=0, atol=1e-12)
    assert out.sigma_m[0] == pytest.approx(sigma)
    assert out.normal_sigma[0] == pytest.approx(unsure)


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize(
    ("beside", "lean", "unsure"),
    [
        (0.0055, 0.3, NORMAL),
        (0.0057, 0.3, 0.35),
        (0.0057, 0.0, 0.35),
        (0.0057, 0.49, 0.35),
        (0.0057, 0.51, NORMAL),
        (0.001, 0.9, NORMAL),
    ],
)
def test_a_finger_leans_to_the_side_where_it_is_pressed(sign: int, beside: float, lean: float, unsure: float) -> None:
    out = says({"index.proximal": pad(0.002, sign * beside, lean=lean)})
    toward = -math.cos(lean) * SIDE + sign * math.sin(lean) * UP
    np.testing.assert_allclose(out.point_m[0], on_bar(0.002, toward), rtol=0, atol=1e-12)
    np.testing.assert_allclose(out.normal[0], -toward, rtol=0, atol=1e-12)
    assert out.normal_sigma[0] == pytest.approx(unsure)


def test_bounds_themselves_are_not_passed() -> None:
    at_end = says({"index.proximal": pad(0.046 / 2 - 0.005, tip=0.3)})
    edge = says({"index.proximal": pad(0.0, bend=(60.0, 0.0))})
    border = says({"index.proximal": pad(0.0, 0.7 * 0.008, lean=0.3)})
    assert [len(each.point_m) for each in (at_end, edge, border)] == [3, 3, 3]
    assert [each.normal_sigma[0] for each in (at_end, edge, border)] == [NORMAL] * 3
    # At 6 mm a thumb touches with one bar.
    assert len(says({"thumb.proximal": pad(0.0, 0.006)}).point_m) == 3


def test_a_vague_end_at_the_border_stays_vague() -> None:
    out = says({"index.proximal": pad(0.02, 0.0057, tip=0.7)})
    assert (out.sigma_m.tolist(), out.normal_sigma.tolist()) == ([0.004], [0.6])


@pytest.mark.parametrize("sign", [-1, 1])
def test_the_thumb_touches_with_one_bar_or_with_both(sign: int) -> None:
    start = np.array([-0.012 + 0.02, -0.052 + 0.009, 0.006])
    both = says({"thumb.proximal": pad(0.0, sign * 0.0059, lean=0.3)})
    np.testing.assert_allclose(both.point_m[[0, 3]], [start - 0.014 * UP, start + 0.014 * UP], atol=1e-12)
    np.testing.assert_allclose(both.normal, np.tile(-SIDE, (6, 1)), atol=1e-12)
    np.testing.assert_allclose(both.normal_sigma[[0, 3]], NORMAL)
    for beside, unsure in ((0.0061, NORMAL), (0.0202, NORMAL), (0.0204, 0.35)):
        one = says({"thumb.proximal": pad(0.0, sign * beside, lean=0.3)})
        toward = math.cos(0.3) * SIDE + sign * math.sin(0.3) * UP
        at = start - 0.009 * SIDE + sign * 0.014 * UP + 0.009 * toward
        assert len(one.point_m) == 3
        np.testing.assert_allclose(one.point_m[0], at, rtol=0, atol=1e-12)
        np.testing.assert_allclose(one.normal[0], -toward, rtol=0, atol=1e-12)
        assert one.normal_sigma[0] == pytest.approx(unsure)


@pytest.mark.parametrize("bends", [(0.0, 0.0), (30.0, -10.0), (80.0, -160.0)])
def test_the_palm_tells_a_point_and_four_about_it(bends: tuple[float, float]) -> None:
    out = says({"palm": pad(0.02, -0.01, bend=bends)})
    at = np.array([0.0, 0.02, -0.01])
    points, normals = [at], [-ALONG]
    for way, bend in zip((SIDE, UP), bends, strict=True):
        # 9 mm away, unless the normal turns by .4 before that.
        reach = 0.4 / abs(bend) if abs(bend) * 0.009 > 0.4 else 0.009
        for step in (-reach, reach):
            points.append(at + step * way + bend * step**2 / 2 * ALONG)
            turned = -ALONG + bend * step * way
            normals.append(turned / np.linalg.norm(turned))
    np.testing.assert_allclose(out.point_m, points, rtol=0, atol=1e-12)
    np.testing.assert_allclose(out.normal, normals, rtol=0, atol=1e-12)
    np.testing.assert_allclose(out.sigma_m, [0.0012] + 4 * [math.hypot(0.0012, 0.001)])
    np.testing.assert_allclose(out.normal_sigma, [2 * NORMAL] + 4 * [3 * NORMAL])


def test_a_hand_that_touches_nothing_tells_where_nothing_is() -> None:
    out = says(dict.fromkeys(("palm", "index.proximal")))
    assert out.point_m.shape == out.normal.shape == (0, 3)
    assert out.sigma_m.shape == out.normal_sigma.shape == (0,)
    assert out.free_m.shape == (45, 3)
    for part in (0.0, 0.5, 1.0):
        at = START + part * 2 * HALF * ALONG
        assert np.linalg.norm(out.free_m - at, axis=1).min() < 1e-12


def test_a_pad_without_pressure_hides_none_after_it() -> None:
    alone = says({"index.proximal": pad()})
    both = says({"palm": None, "index.proximal": pad()})
    np.testing.assert_array_equal(alone.point_m, both.point_m)


def test_a_moved_palm_tells_the_moved_surface() -> None:
    surfaces = {"palm": pad(0.02, 0.01, bend=(20.0, 5.0)), "middle.distal": pad(0.001, 0.003, lean=0.2)}
    carriage = np.array([0.1, -0.2, 0.05, 0.7, 0.2, 0.3])
    origin, axes = palm_place(carriage, DESIGN)
    here, there = says(surfaces), says(surfaces, carriage)
    np.testing.assert_allclose(there.point_m, origin + here.point_m @ axes.T, atol=1e-12)
    np.testing.assert_allclose(there.free_m, origin + here.free_m @ axes.T, atol=1e-12)
    np.testing.assert_allclose(there.normal, here.normal @ axes.T, atol=1e-12)
    np.testing.assert_array_equal(there.sigma_m, here.sigma_m)
    np.testing.assert_array_equal(there.normal_sigma, here.normal_sigma)
