"""Laws of the exact fit: derivatives, faces worked out by hand, what a fit begins with, how fits become names."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_report_touch import surface_of

from varishold.levelset.contacts import find_contacts
from varishold.skin import Skin
from varishold.skin.synthesis import synthesis_of
from varishold.touch.exact import FITTED, recognition
from varishold.touch.exact import fit as fitting
from varishold.touch.exact.form import Grid, Start
from varishold.touch.exact.recognition import INDEPENDENT, MISFIT
from varishold.touch.exact.slopes import Slopes, parameters
from varishold.touch.exact.window import BORDER_SHARE, MODEL_SHARE, see
from varishold.touch.names import KINDS

LAYER = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)
FORMS = [form for forms in FITTED.values() for form in forms]
KEYS = [kind.key for kind in KINDS]


def cells(rows=15, cols=19, width=0.5, height=0.5):
    y, x = np.mgrid[:rows, :cols]
    return Grid(((x - (cols - 1) / 2) * width).ravel(), ((y - (rows - 1) / 2) * height).ravel(), width, height)


# ---- values that know their derivatives

EXPRESSIONS = {
    "sum": lambda a, b: a + b + 2.0 + a,
    "swapped sum": lambda a, b: 3.0 + a * b,
    "difference": lambda a, b: a - b * b - 1.5,
    "swapped difference": lambda a, b: 1.0 - a * b,
    "product": lambda a, b: a * b * 2.5,
    "swapped product": lambda a, b: 2.5 * (a * b),
    "quotient": lambda a, b: a / (b * b + 1.0),
    "by a number": lambda a, b: (a * b) / 4.0,
    "minus": lambda a, b: -a * b,
    "root": lambda a, b: (a * a + b * b + 0.5).sqrt(),
    "sine": lambda a, b: (a * b).sin(),
    "cosine": lambda a, b: (a * b).cos(),
    "magnitude": lambda a, b: (a - b).magnitude(0.7),
    "shoulder": lambda a, b: (a - b).above_zero(0.7),
    "greater": lambda a, b: a.greater(b * b, 0.7),
    "array": lambda a, b: np.array([1.0, 2.0, 3.0]) * a - b * np.array([0.5, 0.1, 0.2]),
}


@pytest.mark.parametrize("made", EXPRESSIONS.values(), ids=EXPRESSIONS)
@given(st.floats(-2, 2), st.floats(-2, 2))
@settings(max_examples=25)
def test_derivatives_are_those_of_the_value(made, a, b):
    q, step = np.array([a, b]), 1e-5
    got = made(*parameters(q))
    for k in range(2):
        up, down = (made(*parameters(q + sign * step * np.eye(2)[k])).value for sign in (1, -1))
        slope = np.broadcast_to(got.by[k], np.shape(got.value) or (1,))
        # A corner of the second derivative may lie within the step.
        np.testing.assert_allclose(slope, np.atleast_1d((up - down) / (2 * step)), atol=1e-4)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.1, 4))
def test_rounded_corners_are_means_over_a_width(x, y, width):
    at = x + width * ((np.arange(2000) + 0.5) / 2000 - 0.5)
    (value,) = parameters(np.array([x]))
    assert float(value.magnitude(width).value) == pytest.approx(np.abs(at).mean(), abs=1e-5 * width)
    assert float(value.above_zero(width).value) == pytest.approx(np.maximum(at, 0).mean(), abs=1e-5 * width)
    one, other = parameters(np.array([x, y]))
    assert float(one.greater(other, width).value) == pytest.approx(np.maximum(at, y).mean(), abs=1e-5 * width)


@given(st.floats(-3, 3), st.floats(0, 7), st.sampled_from([(0.5, 0.5), (1.0, 0.25), (0.3, 0.8)]))
def test_a_cell_is_covered_by_what_lies_inside_a_border(distance, turn, sides):
    width, height = sides
    grid = Grid(np.zeros(1), np.zeros(1), width, height)
    c, s = math.cos(turn), math.sin(turn)
    n = 120
    x, y = np.meshgrid(*(((np.arange(n) + 0.5) / n - 0.5) * side for side in sides))
    inside = np.mean(distance + c * x + s * y > 0)
    got = grid.covered(Slopes(np.array([distance]), np.ones((1, 1))), c, s)
    assert float(got.value[0]) == pytest.approx(inside, abs=0.012)
    assert 0 <= float(got.value[0]) <= 1 or abs(distance) > grid.across(c, s)
    assert grid.across(c, s) == pytest.approx(abs(c) * width + abs(s) * height)


# ---- faces

START = Start(x=0.35, y=-0.6, long=6.2, short=3.9, yaw=0.45, square_yaw=0.3, descent=0.7)


@pytest.mark.parametrize("form", FORMS, ids=lambda form: type(form).__name__)
@given(st.integers(0, 2**31))
@settings(max_examples=6)
def test_gradients_of_a_face_are_those_of_its_height_and_its_cover(form, seed):
    rng = np.random.default_rng(seed)
    grid = cells(width=0.5, height=0.7)
    q = form.start(START)
    q = q * rng.uniform(0.9, 1.1, len(q)) + rng.uniform(-0.05, 0.05, len(q))
    face = form.face(q, grid)
    for k in range(len(q)):
        step = 1e-5 * np.eye(len(q))[k]
        up, down = form.face(q + step, grid), form.face(q - step, grid)
        away = np.abs(face.d_wanted[k] - (up.wanted - down.wanted) / 2e-5)
        # A cell's corner is rounded over its width as seen across; that a turn changes this width is left out.
        flat = form.names[k] == "yaw"
        assert np.median(away) < 1e-6 + 0.02 * flat
        assert away.max() < 0.3, form.names[k]
        covered = (form.face(q, grid).covered > 1e-9) & (face.covered < 1 - 1e-9)
        by_cover = np.abs(face.d_covered[k] - (up.covered - down.covered) / 2e-5)
        assert by_cover[~covered & (up.covered == down.covered)].max(initial=0) < 1.5
        if covered.any():
            assert np.median(by_cover[covered]) < 0.25, form.names[k]


def turned(x, y, q):
    c, s = math.cos(q["yaw"]), math.sin(q["yaw"])
    dx, dy = x - q["x"], y - q["y"]
    return c * dx + s * dy, c * dy - s * dx


def height_of(name, x, y, q):
    """The height of a face at points, as a share of its depth, and whether it is there at all."""
    ones = np.ones_like(x)
    if name in ("Disc", "RoundTip", "Cap", "SteepCap", "RoundFrustum"):
        r = np.hypot(x - q["x"], y - q["y"]) / (q["diameter"] / 2)
        if name == "Disc":
            return ones, r < 1
        if name == "RoundTip":
            return 1 - r, ones
        if name == "Cap":
            return 1 - r * r, ones
        if name == "RoundFrustum":
            return np.minimum((1 - r) / (1 - q["top_share"]), 1.0), ones
        # On a sphere of radius 1 the contact line has the radius sqrt(steepness).
        out = r * math.sqrt(q["steepness"])
        line = math.sqrt(1 - q["steepness"])
        return (np.sqrt(np.maximum(1 - out * out, 0.01)) - line) / (1 - line), ones
    if name == "Border":
        return ones, math.cos(q["yaw"]) * x + math.sin(q["yaw"]) * y < q["offset"]
    if name == "Everywhere":
        return ones, ones
    if name.startswith("Endless"):
        v = (math.cos(q["yaw"]) * y - math.sin(q["yaw"]) * x - q["offset"]) / (q["breadth"] / 2)
        return (1 - abs(v) if name == "EndlessGable" else 1 - v * v), ones
    u, v = (abs(w) / (q["breadth"] / 2) for w in turned(x, y, q))
    if name == "Square":
        return ones, np.maximum(u, v) < 1
    if name == "SquareTip":
        return 1 - np.maximum(u, v), ones
    if name == "SquareFrustum":
        return np.minimum((1 - np.maximum(u, v)) / (1 - q["top_share"]), 1.0), ones
    half = q["length"] / q["breadth"]
    if name == "Rectangle":
        return ones, (u < half) & (v < 1)
    if name == "Gable":
        return 1 - v, u < half
    if name == "Arch":
        return 1 - v * v, u < half
    assert name == "Hipped"
    return 1 - np.maximum(v, u - half + 1), ones


@pytest.mark.parametrize("form", FORMS, ids=lambda form: type(form).__name__)
@given(st.integers(0, 2**31), st.sampled_from([(0.2, 0.2), (0.3, 0.15)]))
@settings(max_examples=6)
def test_a_face_is_the_solid_that_it_is_called(form, seed, cell):
    rng = np.random.default_rng(seed)
    width, height = cell
    grid = cells(41, 45, width, height)
    draw = {
        **dict.fromkeys(("x", "y", "offset"), rng.uniform(-1, 1)),
        "yaw": rng.uniform(-3, 3),
        "breadth": rng.uniform(2.5, 4),
        "length": rng.uniform(4.5, 7),
        "diameter": rng.uniform(3, 6),
        "top_share": rng.uniform(0.2, 0.7),
        "steepness": rng.uniform(0.05, 0.7),
    }
    q = np.array([draw[name] for name in form.names])
    face = form.face(q, grid)
    # Each cell is looked at in 8 x 8 places.
    n = 8
    at = (np.arange(n) + 0.5) / n - 0.5
    x = grid.x[:, None, None] + width * at[None, :, None] + 0 * at
    y = grid.y[:, None, None] + height * at[None, None, :] + 0 * at[:, None]
    told, there = height_of(type(form).__name__, x, y, draw)
    high = told.max(axis=(1, 2)) > -1
    off = np.abs(face.wanted - told.mean(axis=(1, 2)))
    # Crests, tips and shoulders are rounded off about as much as a cell sees of them.
    assert off[high].max() < 0.06
    assert np.median(off[high]) < 0.006
    share = np.broadcast_to(there, x.shape).mean(axis=(1, 2))
    wrong = np.abs(face.covered - share)
    assert wrong.max() < 0.35
    assert np.quantile(wrong, 0.99) < 0.07
    assert face.covered.sum() == pytest.approx(share.sum(), rel=0.004, abs=0.3)
    assert face.wanted.shape == face.covered.shape == grid.x.shape
    assert face.d_wanted.shape == face.d_covered.shape == (len(q), grid.x.size)


def test_a_fit_begins_with_the_contacts_own_measures():
    begun = {type(form).__name__: dict(zip(form.names, form.start(START).tolist(), strict=True)) for form in FORMS}
    area = START.long * START.short
    for name, q in begun.items():
        if "x" in q:
            assert (q["x"], q["y"]) == (START.x, START.y), name
        if "yaw" in q and name != "Border":
            assert q["yaw"] == (START.square_yaw if name.startswith("Square") else START.yaw), name
    # Flat faces have the area of the contact; what slopes would meet the free skin somewhat beyond it.
    assert math.pi * begun["Disc"]["diameter"] ** 2 / 4 == pytest.approx(area, rel=1e-3)
    assert begun["Square"]["breadth"] ** 2 == pytest.approx(area)
    assert (begun["Rectangle"]["length"], begun["Rectangle"]["breadth"]) == (START.long, START.short)
    for name in ("RoundTip", "Cap", "SteepCap", "RoundFrustum"):
        assert 1.05 < begun[name]["diameter"] / begun["Disc"]["diameter"] < 1.3
    for name in ("SquareTip", "SquareFrustum"):
        assert 1.05 < begun[name]["breadth"] / begun["Square"]["breadth"] < 1.3
    for name in ("Gable", "Arch", "Hipped", "EndlessArch", "EndlessGable"):
        assert 1.05 < begun[name]["breadth"] / START.short < 1.3
    assert begun["Gable"]["length"] == begun["Arch"]["length"] == START.long
    assert begun["Hipped"]["length"] / START.long == pytest.approx(begun["Hipped"]["breadth"] / START.short)
    for name in ("RoundFrustum", "SquareFrustum"):
        assert 0.2 < begun[name]["top_share"] < 0.7
    # The line through the middle along the yaw, and the border half a breadth downhill of the middle.
    offset = math.cos(START.yaw) * START.y - math.sin(START.yaw) * START.x
    assert begun["EndlessArch"]["offset"] == begun["EndlessGable"]["offset"] == pytest.approx(offset)
    edge = begun["Border"]
    assert edge["yaw"] == START.descent
    along = math.cos(START.descent - START.yaw)
    across = math.sin(START.descent - START.yaw)
    reach = 0.5 * math.hypot(START.long * along, START.short * across)
    middle = START.x * math.cos(START.descent) + START.y * math.sin(START.descent)
    assert edge["offset"] == pytest.approx(middle + reach)
    assert len(begun["Everywhere"]) == 0


@pytest.mark.parametrize(
    ("key", "q", "possible"),
    [
        # A window of 20 x 10: a side counts where its middle lies a quarter of a taxel within it.
        ("cylinder", [0, 0, 9.4], True),
        ("cylinder", [0, 0, 9.6], True),  # two of four ends are seen
        ("cylinder", [0, 0, 19.6], False),
        ("cylinder", [9, 4, 4.0], True),
        ("cylinder", [9, 4, 30.0], False),
        ("cylinder", [9.8, 4, 4.0], False),
        ("square-pillar", [0, 0, 0, 9.4], True),
        ("square-pillar", [0, 0, 0, 9.6], False),
        ("square-pillar", [0, 4, 0, 4.0], True),
        ("square-pillar", [9, 4, 0, 4.0], False),
        ("square-pillar", [0, 0, math.pi / 4, 9.6], True),
        ("rectangular-pillar", [0, 0, 0, 19.4, 4], True),
        ("rectangular-pillar", [0, 0, 0, 19.6, 4], False),
        ("rectangular-pillar", [0, 0, math.pi / 2, 9.6, 4], False),
        ("rectangular-pillar", [0, 0, math.pi / 2, 9.4, 4], True),
        ("rectangular-pillar", [1, 0, 0, 18.4, 4], True),
        ("rectangular-pillar", [-1, 0, 0, 18.4, 4], True),
        ("rectangular-pillar", [5, 0, 0, 18.4, 4], True),
        ("rectangular-pillar", [5, 3.5, 0, 18.4, 4], False),
        # Half a taxel beyond the border in the farthest corner.
        ("edge", [9.4, 0], True),
        ("edge", [9.6, 0], False),
        ("edge", [4.4, math.pi / 2], True),
        ("edge", [4.6, math.pi / 2], False),
        ("edge", [4.4, -math.pi / 2], True),
        ("edge", [15 / math.sqrt(2) - 0.6, math.pi / 4], True),
        ("edge", [15 / math.sqrt(2) - 0.4, math.pi / 4], False),
        ("plane", [], True),
        ("sphere", [50, 50, 3], True),
    ],
)
def test_a_form_is_possible_where_its_borders_are_seen(key, q, possible):
    assert FITTED[key][0].possible(np.array(q, float), 20.0, 10.0) is possible


# ---- what is seen


def relief_like(contact, mask=None, per_taxel=1):
    inside = np.zeros(contact.shape, bool)
    inside[contact.window] = contact.mask
    mask = inside if mask is None else mask
    return SimpleNamespace(mask=np.repeat(np.repeat(mask, per_taxel, 0), per_taxel, 1), per_taxel=per_taxel)


def block(rows, cols, top, left, high, wide, value=10.0):
    frame = np.zeros((rows, cols))
    frame[top : top + high, left : left + wide] = value
    return frame


def test_a_window_has_room_around_the_contact_and_comes_in_steps_of_four():
    frame = block(40, 50, 10, 20, 5, 7)
    (contact,) = find_contacts(frame, pitch=(1e-3, 2e-3))
    seen, start, centre = see(contact, relief_like(contact), LAYER)
    # Two taxels on every side make 9 x 11: 12 x 12, from (8, 18) on.
    assert seen.frame.shape == (12, 12)
    np.testing.assert_array_equal(seen.frame, frame[8:20, 18:30] / 10)
    assert centre == pytest.approx(((24 - 25) * 2e-3, (14 - 20) * 1e-3))
    assert seen.unit_m == pytest.approx(math.sqrt(2) * 1e-3)
    assert seen.count == 144
    np.testing.assert_allclose(1 / seen.weight, math.hypot(contact.sigma / 10, MODEL_SHARE))
    assert seen.grid.width / seen.grid.height == pytest.approx(2)
    assert seen.grid.x.size == seen.active.size == 144 * seen.synthesis.per_taxel**2
    # Cells cover the window; the finer grid has four times as many.
    assert np.ptp(seen.grid.x) + seen.grid.width == pytest.approx(12 * math.sqrt(2))
    assert np.ptp(seen.grid.y) + seen.grid.height == pytest.approx(12 / math.sqrt(2))
    assert seen.fine_grid.x.size == 4 * seen.grid.x.size
    assert seen.fine_grid.width == pytest.approx(seen.grid.width / 2)
    n = seen.synthesis.per_taxel
    assert n == min(4, max(1, int(math.sqrt(420 / 35))))
    cell = seen.active.reshape(12 * n, 12 * n)
    np.testing.assert_array_equal(cell[::n, ::n], frame[8:20, 18:30] > 0)
    assert cell.sum() == 35 * n * n
    # The middle of the block is (12, 23): one and a half taxels before that of the window, half a taxel left of it.
    assert (start.x, start.y) == pytest.approx((-0.5 * math.sqrt(2), -1.5 / math.sqrt(2)))


def test_near_the_border_of_the_pad_less_is_believed():
    (contact,) = find_contacts(block(20, 20, 6, 0, 8, 6), pitch=1e-3)
    seen, _, centre = see(contact, relief_like(contact), LAYER)
    assert seen.frame.shape == (12, 8)
    assert centre == pytest.approx(((4 - 10) * 1e-3, (10 - 10) * 1e-3))
    noise = contact.sigma / 10
    np.testing.assert_allclose(1 / seen.weight[:, :2], math.hypot(noise, BORDER_SHARE))
    np.testing.assert_allclose(1 / seen.weight[:, 2:], math.hypot(noise, MODEL_SHARE))
    (small,) = find_contacts(block(12, 12, 3, 3, 6, 6), pitch=1e-3)
    seen, _, _ = see(small, relief_like(small), LAYER)
    doubted = 1 / seen.weight > 0.1
    expected = np.ones((12, 12), bool)
    expected[1:-1, 1:-1] = False
    np.testing.assert_array_equal(doubted, expected)


def test_what_belongs_to_another_contact_or_is_no_taxel_does_not_count():
    frame = block(30, 30, 8, 8, 8, 8) + block(30, 30, 8, 18, 8, 6, 9.0)
    field = np.ones((30, 30), bool)
    field[9, 9] = False
    contact, _ = find_contacts(frame, pitch=1e-3, field=field)
    seen, _, _ = see(contact, relief_like(contact), LAYER)
    rows, cols = slice(6, 18), slice(6, 18)
    expected = field[rows, cols] & (frame[rows, cols] != 9.0)
    assert seen.frame.shape == (12, 12)
    np.testing.assert_array_equal(seen.weight > 0, expected)
    assert seen.count == expected.sum()
    np.testing.assert_array_equal(seen.frame[expected] > 0, frame[rows, cols][expected] > 0)
    assert not seen.frame[~expected].any()


def test_large_contacts_are_seen_through_means_of_taxels():
    rng = np.random.default_rng(1)
    frame = block(61, 64, 9, 12, 43, 37) * rng.uniform(0.9, 1.1, (61, 64))
    (contact,) = find_contacts(frame, pitch=(1e-3, 2e-3), floor=1.0)
    seen, _, centre = see(contact, relief_like(contact), LAYER)
    # 1591 taxels: means of 2 x 2, with four taxels around, in steps of eight: 56 rows from 4 (5 less one), 48 columns.
    assert seen.frame.shape == (28, 24)
    row = min(max(9 - 4, 0), 61 - 56)
    part = frame[row : row + 56, 8:56]
    np.testing.assert_allclose(seen.frame, part.reshape(28, 2, 24, 2).mean(axis=(1, 3)) / contact.peak)
    assert centre == pytest.approx(((32 - 32) * 2e-3, (row + 28 - 30.5) * 1e-3))
    assert seen.unit_m == pytest.approx(2 * math.sqrt(2) * 1e-3)
    assert seen.synthesis.per_taxel == 1
    inner = 1 / seen.weight[10, 10]
    # Noise is halved by a mean of four.
    assert inner == pytest.approx(math.hypot(contact.sigma / contact.peak / 2, MODEL_SHARE))


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.2, -0.9])
@pytest.mark.parametrize(("long", "short"), [(14.0, 7.0), (9.0, 9.0), (17.0, 4.0)])
def test_a_rectangle_begins_with_its_own_sides_and_direction(turn, long, short):
    y, x = np.mgrid[:32, :32] - 15.5
    u, v = x * math.cos(turn) + y * math.sin(turn), y * math.cos(turn) - x * math.sin(turn)
    sub = (np.abs(u) < long / 2) & (np.abs(v) < short / 2)
    (contact,) = find_contacts(10.0 * sub, pitch=1e-3)
    fine_y, fine_x = (np.mgrid[:128, :128] + 0.5) / 4 - 16
    fu = fine_x * math.cos(turn) + fine_y * math.sin(turn)
    fv = fine_y * math.cos(turn) - fine_x * math.sin(turn)
    relief = SimpleNamespace(mask=(np.abs(fu) < long / 2) & (np.abs(fv) < short / 2), per_taxel=4)
    _, start, (x, y) = see(contact, relief, LAYER)
    assert start.long * start.short == pytest.approx(long * short, rel=0.06)
    if long == short:
        off = (start.square_yaw - turn + math.pi / 4) % (math.pi / 2) - math.pi / 4
        assert abs(off) < 0.06
        assert start.long == pytest.approx(long, rel=0.08)
    else:
        assert (start.long, start.short) == pytest.approx((long, short), rel=0.08)
        assert abs((start.yaw - turn + math.pi / 2) % math.pi - math.pi / 2) < 0.05
    # To a cell of the relief, which has four to a taxel.
    assert (start.x + 1e3 * x, start.y + 1e3 * y) == pytest.approx((0, 0), abs=0.25)


@pytest.mark.parametrize(
    ("side", "direction"), [("left", 0.0), ("right", math.pi), ("top", math.pi / 2), ("bottom", -math.pi / 2)]
)
def test_an_edge_falls_away_from_the_side_that_it_covers(side, direction):
    frame = np.zeros((20, 20))
    frame[{"left": np.s_[:, :9], "right": np.s_[:, 11:], "top": np.s_[:9], "bottom": np.s_[11:]}[side]] = 10.0
    (contact,) = find_contacts(frame, pitch=1e-3)
    _, start, _ = see(contact, relief_like(contact), LAYER)
    assert abs((start.descent - direction + math.pi) % (2 * math.pi) - math.pi) < 1e-6
    # The border is where the block ends: 9 taxels from the pad's border.
    offset, _ = FITTED["edge"][0].start(start)
    window = {"left": 12, "right": 12, "top": 12, "bottom": 12}[side]
    assert offset == pytest.approx(9 - window / 2, abs=1.5)


def test_a_line_is_not_longer_than_can_be():
    (contact,) = find_contacts(block(20, 20, 9, 4, 1, 12), pitch=1e-3)
    mask = block(20, 20, 9, 4, 1, 12) > 0
    _, start, _ = see(contact, relief_like(contact, mask), LAYER)
    # No more than ten times as long as broad.
    assert start.long / start.short == pytest.approx(math.sqrt(1.98 / 0.02), rel=0.01)


# ---- the fit itself


def seen_of(rows=14, cols=12):
    """A window over the layer, its frame still to be given."""
    coarse, fine = (synthesis_of(LAYER, rows, cols, (1e-3, 1e-3), n) for n in (2, 4))
    grids = [Grid(*(1e3 * side for side in s.points_m), 1 / s.per_taxel, 1 / s.per_taxel) for s in (coarse, fine)]
    weight = np.full((rows, cols), 50.0)
    active = np.hypot(grids[0].x, grids[0].y) < 4
    return fitting.Seen(np.zeros((rows, cols)), weight, coarse, grids[0], fine, grids[1], active, rows * cols, 1e-3)


TRUE = {"x": 0.3, "y": -0.4, "offset": 0.6, "yaw": 0.35, "length": 8.0, "breadth": 4.6, "diameter": 6.0}
TRUE |= {"top_share": 0.5, "steepness": 0.3}


@pytest.mark.parametrize("form", [form for form in FORMS if form.names], ids=lambda form: type(form).__name__)
def test_a_fit_finds_the_face_that_made_the_frame(form):
    seen = seen_of()
    q = np.array([TRUE[name] for name in form.names])
    made = seen.synthesis.frame(form.face(q, seen.grid), start=seen.active).frame
    seen = replace(seen, frame=0.7 * made / made.max())
    off = np.array([{"yaw": 0.12, "top_share": 0.08, "steepness": 0.05}.get(name, 0.5) for name in form.names])
    found = fitting.fit_form(form, q + off, seen, most_steps=20)
    # The single number that the frame is multiplied by is found with the parameters.
    assert found.gain == pytest.approx(0.7 / made.max(), rel=0.02)
    # A residual of a hundredth of the peak in each taxel would count 0.25 each.
    assert found.chi2 < 0.02 * seen.count
    for name, value, true in zip(form.names, found.q, q, strict=True):
        assert value == pytest.approx(true, abs=0.12 if name not in ("yaw", "top_share", "steepness") else 0.08), name
    assert found.cost == pytest.approx(found.chi2 + len(q) * math.log(seen.count))
    assert 0 < found.steps <= 20
    assert found.active.any()
    # It begins where it is told to and steps no farther than it may.
    once = fitting.fit_form(form, q + off, seen, most_steps=1)
    for name, value, begun in zip(form.names, once.q, q + off, strict=True):
        assert abs(value - begun) <= fitting._LONGEST.get(name, fitting._LONGEST_LENGTH) + 1e-9
    assert once.chi2 <= fitting.fit_form(form, q + off, seen, most_steps=0).chi2
    # Where nothing of the pad is touched there is no fit.
    assert fitting.fit_form(form, q, replace(seen, weight=np.zeros_like(seen.weight))) is None


@pytest.mark.parametrize("key", ["cylinder", "cone-frustum", "ridge", "edge"])
def test_a_finer_grid_finds_what_was_made_on_it(key):
    seen = seen_of()
    form = FITTED[key][0]
    q = np.array([TRUE[name] for name in form.names])
    fine = seen.fine.sensed(seen.fine.pressure(form.face(q, seen.fine_grid), start=np.zeros(seen.fine_grid.x.size)))
    seen = replace(seen, frame=fine / fine.max())
    rough = fitting.fit_form(form, q + 0.3, seen)
    better = fitting.refine(rough, seen)
    assert better.chi2 < rough.chi2
    assert better.chi2 < 0.03 * seen.count
    assert better.steps > rough.steps
    assert better.gain * fine.max() == pytest.approx(1, rel=0.02)
    np.testing.assert_allclose(better.q, q, atol=0.12)
    assert better.cost == pytest.approx(better.chi2 + len(q) * math.log(seen.count))


def test_what_is_far_behind_is_given_up():
    seen = seen_of()
    form, wrong = FITTED["cylinder"][0], FITTED["ridge"][0]
    made = seen.synthesis.frame(form.face(np.array([0.3, -0.4, 6.0]), seen.grid), start=seen.active).frame
    seen = replace(seen, frame=made / made.max())
    start = np.array([2.0, 2.0, 1.0, 9.0, 3.0])
    patient = fitting.fit_form(wrong, start, seen)
    hasty = fitting.fit_form(wrong, start, seen, rival=1e-3)
    assert hasty.steps <= patient.steps
    assert hasty.steps == 3
    large = replace(seen, active=np.ones_like(seen.active))
    assert np.count_nonzero(large.active) > 600
    assert fitting.fit_form(wrong, start, large, rival=1e-3).steps == 1


def test_a_frame_is_compared_with_the_best_multiple_of_the_model():
    rng = np.random.default_rng(0)
    frame, model, weight = rng.uniform(0, 1, (3, 5, 6))
    seen = SimpleNamespace(frame=frame, weight=weight)
    tried = fitting._compared(np.zeros(2), None, model, seen)
    gains = np.linspace(0, 3, 3001)
    costs = [(((frame - g * model) * weight) ** 2).sum() for g in gains]
    assert tried.gain == pytest.approx(gains[int(np.argmin(costs))], abs=1e-3)
    assert tried.chi2 == pytest.approx(min(costs), rel=1e-5)
    np.testing.assert_allclose(tried.residual, (frame - tried.gain * model) * weight)
    # A gain is never negative, and nothing is nothing.
    upside = fitting._compared(np.zeros(2), None, -model, seen)
    assert upside.gain == 0
    assert upside.chi2 == pytest.approx(((frame * weight) ** 2).sum())
    assert fitting._compared(np.zeros(2), None, 0 * model, seen).gain == 0


# ---- from fits to names


def a_fit(key, chi2, q=None, extra=0.0):
    form = FITTED[key][0]
    q = np.arange(len(form.names), dtype=float) + 2 if q is None else np.array(q, float)
    return fitting.Fit(form, q, 1.0, chi2, chi2 + extra, 3, np.ones(1, bool))


def test_the_fits_share_what_the_table_gave_their_kinds():
    rng = np.random.default_rng(4)
    table = rng.dirichlet(np.ones(len(KINDS)))
    fits = {"sphere": a_fit("sphere", 90.0), "cone": a_fit("cone", 96.0), "edge": a_fit("edge", 300.0)}
    count = 100
    p = np.exp(recognition._logits(table, fits, count))
    index = [KEYS.index(key) for key in fits]
    rest = [k for k in range(len(KINDS)) if k not in index]
    assert p[index].sum() == pytest.approx(table[index].sum())
    np.testing.assert_allclose(p[rest], table[rest], rtol=1e-9)
    # Costs compete on top of what the table says: the marginal likelihood where the errors' size is not known.
    odds = table[index[0]] / table[index[1]] * (96 / 90) ** (INDEPENDENT / 2)
    assert p[index[0]] / p[index[1]] == pytest.approx(odds)
    # Where every form is as much worse, differences count as much less.
    worse = {key: a_fit(key, 3 * fit.chi2) for key, fit in fits.items()}
    np.testing.assert_allclose(np.exp(recognition._logits(table, worse, count)), p)
    # No fit is as good as perfect: the noise alone would be smaller errors than a skin ever lets be.
    perfect = {"sphere": a_fit("sphere", 0.0), "cone": a_fit("cone", 5.0)}
    p = np.exp(recognition._logits(table, perfect, count))
    odds = table[index[0]] / table[index[1]] * (1 + 5 / (recognition._LEAST_ERROR * count)) ** (INDEPENDENT / 2)
    assert p[index[0]] / p[index[1]] == pytest.approx(odds)
    np.testing.assert_allclose(np.exp(recognition._logits(table, {}, count)), table)


def test_what_fits_nothing_is_a_stranger():
    table = np.full(len(KINDS), 1 / len(KINDS))
    count, stranger = 50, KEYS.index("stranger")
    for beyond in (0.0, 3.0, 4000.0):
        fits = {"sphere": a_fit("sphere", MISFIT * count + beyond), "cone": a_fit("cone", MISFIT * count + beyond + 8)}
        p = np.exp(recognition._logits(table, fits, count))
        kept = math.exp(-beyond / recognition._BEYOND_MISFIT)
        mass = 2 / len(KINDS)
        assert p[[KEYS.index(key) for key in fits]].sum() == pytest.approx(mass * kept, abs=1e-9)
        assert p[stranger] == pytest.approx(1 / len(KINDS) + mass * (1 - kept))
        assert p.sum() == pytest.approx(1)


def test_the_likeliest_kinds_are_fitted_and_those_easily_taken_for_the_first():
    p = np.zeros(len(KINDS))
    for share, key in (
        (0.5, "cone"),
        (0.3, "ridge"),
        (0.1, "stranger"),
        (0.05, "plane"),
        (0.02, "edge"),
        (0.02, "sphere"),
        (0.01, "cylinder"),
    ):
        p[KEYS.index(key)] = share
    # What cannot be fitted does not count; of the rest three, and the cone's like.
    assert recognition._candidates(p, 100) == ["cone", "ridge", "plane", "sphere", "cylinder"]
    assert recognition._candidates(p, 600) == ["cone", "ridge", "plane", "sphere", "cylinder"]
    assert recognition._candidates(p, 601) == ["cone", "ridge", "plane", "sphere"]
    everything = np.full(len(KINDS), 1 / len(KINDS))
    assert len(recognition._candidates(everything, 1)) <= 6
    none = np.zeros(len(KINDS))
    none[KEYS.index("stranger")] = 1
    assert recognition._candidates(none, 1) == []


def bounded(key, q, shape=(12, 10)):
    seen = SimpleNamespace(synthesis=SimpleNamespace(shape=shape))
    form = FITTED[key][0]
    return dict(zip(form.names, fitting._bounded(form, np.array(q, float), seen).tolist(), strict=True))


def test_parameters_keep_within_what_can_be():
    assert bounded("cone-frustum", [1, 2, 0.1, 0.01]) == {"x": 1, "y": 2, "diameter": 1.0, "top_share": 0.15}
    assert bounded("cone-frustum", [1, 2, 99, 0.9]) == {"x": 1, "y": 2, "diameter": 36.0, "top_share": 0.8}
    assert bounded("cone-frustum", [-9, 2, 5, 0.5]) == {"x": -9, "y": 2, "diameter": 5, "top_share": 0.5}
    form = FITTED["sphere"][1]
    seen = SimpleNamespace(synthesis=SimpleNamespace(shape=(9, 9)))
    assert fitting._bounded(form, np.array([0, 0, 5, 0.0]), seen)[3] == 0.02
    assert fitting._bounded(form, np.array([0, 0, 5, 1.0]), seen)[3] == 0.8
    # A hip is at least as long as it is broad; a ridge need not be.
    assert bounded("hip", [0, 0, 0, 3, 5]) == {"x": 0, "y": 0, "yaw": 0, "length": 5, "breadth": 5}
    assert bounded("ridge", [0, 0, 0, 3, 5])["length"] == 3
    q = np.array([0.0, 0.0, 0.0, 3.0, 5.0])
    bounded("hip", q)
    assert q[3] == 3


def a_fitted(key, q, rest=(), depth=None, reach=2.0):
    """A surface that was called after its best fit."""
    (contact,) = find_contacts(np.pad(np.ones((6, 6)), 4), pitch=1e-3)
    base = surface_of(contact, key)
    fits = {key: a_fit(key, 120.0, q), **{other: a_fit(other, 150.0) for other in rest}}
    told = {name: getattr(base, name) for name in base.__dataclass_fields__}
    return recognition.FittedSurface(
        **told, fits=fits, count=100, centre=(0.01, -0.02), unit=2e-3, reach=reach, depth_m=depth
    )


@pytest.mark.parametrize("yaw", [0.3, -0.3, 1.6, 3.0, -3.0, 4.9, math.pi / 2])
def test_what_was_fitted_is_told_in_metres_from_the_pads_centre(yaw):
    told = a_fitted("rectangular-pillar", [1.5, -2.0, yaw, 8.0, 3.0]).fitted
    assert (told["x_m"], told["y_m"]) == pytest.approx((0.013, -0.024))
    assert (told["length_m"], told["breadth_m"]) == pytest.approx((0.016, 0.006))
    assert -math.pi / 2 <= told["yaw_rad"] < math.pi / 2
    assert math.sin(2 * (told["yaw_rad"] - yaw)) == pytest.approx(0, abs=1e-9)
    assert math.cos(2 * (told["yaw_rad"] - yaw)) == pytest.approx(1)
    assert a_fitted("cone-frustum", [0, 0, 8.0, 0.4]).fitted["top_share"] == 0.4


@pytest.mark.parametrize(
    ("key", "q", "size", "half"),
    [
        ("cylinder", [0, 0, 8.0], (0.016, 0.016), 0.3),
        ("cone-frustum", [0, 0, 8.0, 0.5], (0.008, 0.008), 0.3),
        ("pyramid-frustum", [0, 0, 0, 8.0, 0.25], (0.004, 0.004), 0.3),
        ("rectangular-pillar", [0, 0, 0, 3.0, 7.0], (0.014, 0.006), 0.3),
        ("ridge", [0, 0, 0, 9.0, 4.0], (0.018, 0.008), 0.5),
        ("hip", [0, 0, 0, 9.0, 4.0], (0.018, 0.008), 0.5),
        ("lying-cylinder", [0, 0, 0, 9.0, 4.0], (0.018, 0.008), 1.2),
    ],
)
def test_a_fitted_form_has_the_size_that_was_fitted(key, q, size, half):
    surface = a_fitted(key, q)
    assert surface.size == pytest.approx(size)
    for (low, high), side in zip(surface.size_interval, size, strict=True):
        assert (low, high) == pytest.approx((max(side - 2e-3 * half, 0), side + 2e-3 * half))
    # Called otherwise than it fits best, it has the size of its sections.
    other = replace(surface, name="cone", form="pyramidal", section="circle")
    assert other.size == replace(surface_of(surface.contact, "cone")).size
    nothing = replace(surface, fits={})
    assert nothing.size == surface_of(surface.contact, key).size
    assert nothing.reasons[0] == "no form could be fitted through the skin"
    assert a_fitted("wedge", [0, 0, 4.0]).size == surface_of(surface.contact, "wedge").size


def test_reasons_begin_with_the_fits():
    surface = a_fitted("cylinder", [1.0, 1.0, 8.0], rest=("cone",), depth=1.5e-3)
    assert surface.reasons[0] == "fitted through the skin as cylinder: chi^2 1.20 a taxel over 100 taxels"
    assert surface.reasons[1] == "its parameters: x_m 0.012, y_m -0.018, diameter_m 0.016, depth_m 0.0015"
    assert surface.reasons[2] == "next best cone: cost 150 against 120"
    alone = a_fitted("cylinder", [1.0, 1.0, 8.0])
    assert "depth_m" not in alone.reasons[1]
    assert not any("next best" in reason for reason in alone.reasons)
    three = a_fitted("cylinder", [1.0, 1.0, 8.0], rest=("cone", "sphere"))
    assert sum("next best" in reason for reason in three.reasons) == 1
    plane = a_fitted("plane", [])
    assert not any("parameters" in reason for reason in plane.reasons)
    assert plane.reasons[0].startswith("fitted through the skin as plane")
    bad = replace(alone, fits={"cylinder": a_fit("cylinder", 1201.0, [1.0, 1.0, 8.0])})
    assert bad.reasons[0].endswith("over 100 taxels, beyond 12: no known form")
    just = replace(alone, fits={"cylinder": a_fit("cylinder", 1200.0, [1.0, 1.0, 8.0])})
    assert just.reasons[0].endswith("over 100 taxels")


@pytest.mark.parametrize("key", ["sphere", "lying-cylinder"])
def test_a_radius_is_that_of_the_circle_through_the_top_and_where_the_contact_ends(key):
    q = [0, 0, 8.0] if key == "sphere" else [0, 0, 0.3, 9.0, 8.0]
    # A paraboloid that is 2 deep at half its breadth of 4 is .5 deep at 2: r = (4 + .25) / 1, in units of 2 mm.
    assert a_fitted(key, q, depth=4e-3).radius_m == pytest.approx(2e-3 * 4.25)
    # A contact as broad as the form, or said to be broader, ends with it.
    for reach in (4.0, 7.0):
        assert a_fitted(key, q, depth=4e-3, reach=reach).radius_m == pytest.approx(2e-3 * 5.0)
    assert a_fitted(key, q).radius_m is None
    assert replace(a_fitted(key, q, depth=4e-3), name="cone").radius_m is None
    assert a_fitted("cylinder", [0, 0, 8.0], depth=4e-3).radius_m is None


def test_a_cap_that_is_round_all_over_needs_no_contact_to_tell_its_radius():
    fitted = a_fitted("sphere", [0, 0, 8.0], depth=4e-3)
    steep = replace(next(iter(fitted.fits.values())), form=FITTED["sphere"][1], q=np.array([0, 0, 8.0, 0.5]))
    assert replace(fitted, fits={"sphere": steep}).radius_m == pytest.approx(2e-3 * 5.0)


@pytest.mark.parametrize("yaw", [0.0, 0.6, 2.0])
def test_the_reach_is_half_the_breadth_of_what_touches(yaw):
    y, x = (np.mgrid[:80, :80] - 39.5) / 4
    grid = Grid(x.ravel(), y.ravel(), 0.25, 0.25)
    seen = SimpleNamespace(grid=grid)
    c, s = math.cos(yaw), math.sin(yaw)
    bar = replace(
        a_fit("lying-cylinder", 1.0, [0, 0, yaw, 12.0, 6.0]),
        active=(abs(c * grid.y - s * grid.x) < 2) & (abs(c * grid.x + s * grid.y) < 6),
    )
    assert recognition._reach(bar, seen) == pytest.approx(2, abs=0.1)
    cap = replace(a_fit("sphere", 1.0, [0, 0, 6.0]), active=np.hypot(grid.x, grid.y) < 3)
    assert recognition._reach(cap, seen) == pytest.approx(3, abs=0.1)
