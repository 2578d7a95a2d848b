"""Laws of sensors: parity with dense matrices and with least squares, ranges exact at both ends, words."""

from __future__ import annotations

import math
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from varishold.errors import FormatError, InputError
from varishold.recording import Pad, Recording
from varishold.recording.inspection import summarize
from varishold.recording.pad import far_apart
from varishold.sensor import Logarithmic, Power, Resampling, Sensor, Skin, read_skin, write_sensor
from varishold.sensor import spread as spreads
from varishold.sensor.checks import check_sensor
from varishold.sensor.file import map_files, read_sensor
from varishold.sensor.maps import map_text, read_map
from varishold.sensor.positions import resampling_of
from varishold.sensor.recordings import _upright
from varishold.sensor.spread import Spread
from varishold.sensor.words import sensor_name, undone_words

few = settings(max_examples=20)
seeds = st.integers(0, 2**32 - 1)

# Crosstalk and blur


def neighbours(field: np.ndarray) -> np.ndarray:
    """The Laplacian of a grid with gaps, taxel by taxel."""
    places = [tuple(p) for p in np.argwhere(field)]
    out = np.zeros((len(places), len(places)))
    for i, (r, c) in enumerate(places):
        for beside in ((r + 1, c), (r - 1, c), (r, c + 1), (r, c - 1)):
            if beside in places:
                out[i, i] += 1
                out[i, places.index(beside)] -= 1
    return out


@few
@given(seeds, st.integers(1, 5), st.integers(1, 6), st.floats(0, 0.2), st.floats(0, 1.5), st.booleans())
def test_spread_is_the_matrix_of_its_formula(
    seed: int, rows: int, cols: int, crosstalk: float, blur: float, gaps: bool
) -> None:
    rng = np.random.default_rng(seed)
    field = rng.random((rows, cols)) < 0.7 if gaps else np.ones((rows, cols), np.bool_)
    field[0, 0] = True
    laplacian = neighbours(field)
    matrix = (np.eye(len(laplacian)) - crosstalk * laplacian) @ expm(-0.5 * blur**2 * laplacian)
    spread = Spread((rows, cols), field, crosstalk, blur)
    frames = rng.normal(size=(2, rows, cols))
    mixed = spread.mix(frames)
    np.testing.assert_allclose(mixed[:, field], frames[:, field] @ matrix.T, atol=1e-9)
    np.testing.assert_array_equal(mixed[:, ~field], frames[:, ~field])
    shares = np.linalg.eigvalsh(matrix)
    undone = spread.undo(mixed)
    if np.abs(shares).min() >= 0.25:
        np.testing.assert_allclose(undone, frames, atol=1e-9)
    # By how much noise is raised: the mean square of the inverse's entries, row by row.
    columns = spread.undo(np.eye(rows * cols).reshape(-1, rows, cols)).reshape(rows * cols, -1)
    columns = columns[field.reshape(-1)][:, field.reshape(-1)]
    assert spread.loudness == pytest.approx(math.sqrt((columns**2).sum() / len(columns)), rel=1e-9)
    assert np.linalg.eigvalsh(columns).max() <= 4 + 1e-9


def test_a_pad_with_gaps_may_have_so_many_taxels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spreads, "LARGEST_WITH_GAPS", 8)
    field = np.ones((3, 3), np.bool_)
    Spread((3, 3), field, 0.1, 0.0)
    field[1, 1] = False
    Spread((3, 3), field, 0.1, 0.0)
    monkeypatch.setattr(spreads, "LARGEST_WITH_GAPS", 7)
    with pytest.raises(InputError, match="up to 7 taxels, got 8"):
        Spread((3, 3), field, 0.1, 0.0)


# Noise


@pytest.mark.parametrize(
    "values",
    [
        {"span": 50.0, "full_scale": 2.0, "crosstalk": 0.08},
        {"span": 50.0, "blur_taxels": 0.4},
        {"span": 3.0, "gains": np.linspace(0.3, 2.0, 144).reshape(12, 12)},
        {"span": 3.0, "gains": np.where(np.eye(12) > 0, np.nan, 1.5), "dead_band": 0.2},
        {"span": 3.0, "polarity": "down", "rest": 9.0, "crosstalk": 0.1, "gains": np.full((12, 12), 0.5)},
    ],
)
def test_noise_is_raised_as_much_as_is_said(values: dict[str, Any]) -> None:
    sensor = Sensor(**({"shape": (12, 12)} | values))
    noise = 0.01 * np.random.default_rng(0).standard_normal((400, 12, 12))
    raised = sensor.stress(sensor.rest + noise)
    if sensor.broken is not None:
        raised = raised[:, ~sensor.broken]
    assert sensor.least_stress(0.01) == pytest.approx(raised.std(), rel=0.02)


# What is broken, what is saturated


def test_what_no_taxel_is_is_not_broken() -> None:
    field = np.ones((4, 4), np.bool_)
    field[0] = False
    gains = np.ones((4, 4))
    gains[0, 0] = gains[1, 1] = np.nan
    valid = np.ones((4, 4), np.bool_)
    valid[0, 1] = valid[2, 2] = False
    for sensor, expected in (
        (Sensor(field=field, gains=gains), {(1, 1), (2, 2)}),
        (Sensor(field=field), {(2, 2)}),
        (Sensor(gains=gains), {(0, 0), (1, 1), (0, 1), (2, 2)}),
    ):
        undone = sensor.undo(np.arange(16.0).reshape(4, 4), valid=valid)
        assert {tuple(p) for p in np.argwhere(undone.broken).tolist()} == expected
    assert sensor.undo(np.zeros((4, 4)), valid=~np.isnan(gains)).broken.sum() == 2
    assert Sensor(field=field).broken is None
    with pytest.raises(InputError, match=r"valid must have the shape of a frame, \(4, 4\), got \(4,\)"):
        sensor.undo(np.zeros((4, 4)), valid=valid[0])


def test_whole_numbers_saturate_half_a_count_early() -> None:
    sensor = Sensor(span=10.0, saturation=0.95)
    readings = np.arange(11)[None]
    assert sensor.undo(readings).saturated.tolist() == [[reading >= 9 for reading in range(11)]]
    assert sensor.undo(readings.astype(float)).saturated.tolist() == [[reading >= 9.5 for reading in range(11)]]
    # Where the span is one unit no reading is a count.
    assert not Sensor(span=1.0, saturation=1.0).undo(np.array([[0, 0]])).saturated.any()
    assert not Sensor(span=10.0).undo(readings).saturated.any()


def test_the_dead_band_is_told_in_stress() -> None:
    assert Sensor(span=10.0, full_scale=4.0, dead_band=0.25).undo(np.ones((2, 2))).beneath == 1.0


def test_an_upright_sensor_differs_by_rest_and_polarity_alone() -> None:
    sensor = Sensor(span=10.0, polarity="down", rest=7.0, response=Logarithmic(3.0))
    raw = np.linspace(-3, 7, 12).reshape(3, 4)
    np.testing.assert_allclose(sensor.upright().stress(7.0 - raw), sensor.stress(raw))
    assert (sensor.upright().rest, sensor.upright().polarity) == (0.0, "up")


@pytest.mark.parametrize("values", [np.zeros(4), np.zeros((0, 4)), np.full((2, 2), "a"), np.zeros((2, 2), complex)])
def test_what_is_no_frame_is_refused(values: np.ndarray) -> None:
    for act in (Sensor().forward, Sensor().stress, Sensor().undo):
        with pytest.raises(InputError, match="must be numbers of shape"):
            act(values)


# Ranges


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("dead_band", 0.0, 0.9),
        ("crosstalk", 0.0, 0.2),
        ("blur_taxels", 0.0, 4.0),
        ("saturation", 1e-3, 2.0),
        ("span", 1e-12, 1e100),
        ("full_scale", 1e-12, 1e100),
        ("rest", -1e100, 1e100),
    ],
)
def test_a_range_is_what_it_says(name: str, least: float, most: float) -> None:
    others = {} if name in ("span", "full_scale") else {"span": 5.0}
    for value in (least, most, np.float32(1.0) if most >= 1 else 0.1):
        made = Sensor(**{name: value, **others})
        assert getattr(made, name) == value
        assert type(getattr(made, name)) is float
    for value in (np.nextafter(least, -np.inf), np.nextafter(most, np.inf), np.nan, True, "1", None, 1j):
        if value is None and name != "rest":
            continue
        with pytest.raises(InputError, match=f"{name} of a sensor must be a"):
            Sensor(**{name: value, **others})


def test_a_map_holds_what_a_number_may_be() -> None:
    assert Sensor(rest=np.array([[1e100, -1e100]])).shape == (1, 2)
    for wrong in (np.inf, -np.inf, np.nan, np.nextafter(1e100, np.inf)):
        with pytest.raises(InputError, match=r"rest of a sensor must be finite, got .* at \(row, col\) = \(1, 0\)"):
            Sensor(rest=np.array([[0.0, 0.0], [wrong, wrong]]))
    for wrong in ([[1.0], [1.0, 2.0]], [["a"]], [[]], [[None]]):
        with pytest.raises(InputError, match="rest of a sensor must be one number a taxel"):
            Sensor(rest=wrong)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"must have the sensor's shape, \(rows, cols\), got 1 x 1 x 1"):
        Sensor(rest=np.zeros((1, 1, 1)))
    assert Sensor(gains=np.array([[np.nan, 1.0]])).broken is not None
    for wrong in ([[np.nan, 0.0]], [[-1.0, 1.0]]):
        with pytest.raises(InputError, match="gains of a sensor must not be negative, and one at least"):
            Sensor(gains=np.array(wrong))
    for wrong in ([[0.0, 0.0]], [[2.0, 1.0]]):
        with pytest.raises(InputError, match="field of a sensor must be true or false"):
            Sensor(field=np.array(wrong))


def test_the_shape_is_that_of_whatever_map_is_there() -> None:
    for name in ("field", "gains", "rest"):
        assert Sensor(**{name: np.ones((2, 3))}).shape == (2, 3)
    with pytest.raises(InputError, match="gains of a sensor must have the sensor's shape, 2 x 3, got 3 x 2"):
        Sensor(field=np.ones((2, 3)), gains=np.ones((3, 2)))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="rest of a sensor must have the sensor's shape, 2 x 3, got 3 x 2"):
        Sensor(gains=np.ones((2, 3)), rest=np.ones((3, 2)))
    on_no_grid = np.array([[0, 0], [1, 0], [0, 1.0]])
    made = Sensor(positions_m=on_no_grid, gains=[1.0, 2.0, 3.0], rest=np.arange(3.0))  # type: ignore[arg-type]
    assert made.shape is None
    assert made.readings_shape == (1, 3)
    for array in (made.gains, made.rest, made.positions_m):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1  # type: ignore[index]


@pytest.mark.parametrize("shape", [(1 << 12, 1 << 12), (1, 1), [3, 4], (np.int64(2), 2.0)])
def test_a_shape_is_two_whole_numbers(shape: Any) -> None:
    assert check_sensor(Sensor(shape=shape))["shape"] == tuple(shape)


@pytest.mark.parametrize(
    "shape", [(1 << 12, (1 << 12) + 1), (0, 1), (1,), (1, 2, 3), (1.5, 2), 3, (True, 2), "ab", (np.inf, 2)]
)
def test_another_shape_is_refused(shape: Any) -> None:
    with pytest.raises(InputError, match=r"shape of a sensor must be \[rows, columns\]"):
        Sensor(shape=shape)


@pytest.mark.parametrize(
    ("field", "values"),
    [
        ("thickness_m", {"thickness_m": value})
        for value in (0.0, -1.0, np.nextafter(1e-9, 0), np.nextafter(1e3, np.inf), np.nan, 10**400, True)
    ]
    + [("poisson", {"poisson": value}) for value in (-1, np.nextafter(0.5, 1), np.inf)]
    + [("sensing_depth_m", {"sensing_depth_m": value}) for value in (-1e-9, np.nextafter(6e-3, 1), 1e101)]
    + [("youngs_modulus_pa", {"youngs_modulus_pa": value}) for value in (0.0, -1.0, 1.1e100)]
    + [("kind", {"kind": "rubber"}), ("thickness_m", {"thickness_m": None})]
    + [("poisson", {"kind": "winkler", "poisson": 0.5})],
)
def test_an_impossible_skin_is_told(field: str, values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=field):
        Skin(**({"kind": "layer", "thickness_m": 6e-3, "poisson": 0.3} | values))


def test_the_ends_of_what_a_skin_may_be() -> None:
    for values in (
        {"thickness_m": 1e-9},
        {"thickness_m": 1e3},
        {"poisson": 0.5},
        {"poisson": np.nextafter(-1, 0)},
        {"sensing_depth_m": 6e-3},
        {"youngs_modulus_pa": 1e100},
    ):
        Skin(**({"kind": "layer", "thickness_m": 6e-3, "poisson": 0.3} | values))  # type: ignore[arg-type]
    # A half-space has no floor, at whatever depth its taxels lie.
    assert Skin("half-space", sensing_depth_m=1.0).contact_modulus == 1.0
    assert Skin("half-space", sensing_depth_m=1.0, poisson=0.5, youngs_modulus_pa=3.0).contact_modulus == 4.0
    with pytest.raises(InputError, match="kind 'half-space' has no thickness_m; leave it out, or use kind 'layer'"):
        Skin("half-space", thickness_m=1e-3)


def test_a_skin_file_says_what_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "skin.toml"
    for text, says in (
        ("", r"needs a table \[skin\] with the keys kind, thickness_m"),
        ("skin = 3", r"needs a table \[skin\]"),
        ("[skin]\nkind = 'layer'\nthickness_m = 1", "a layer needs poisson"),
        ("[skin]\nthickness_m = 1", "needs kind, one of layer, half-space, winkler"),
        ("[skin]\nkind = 'layer'\npoisson = 2\nthickness_m = 1", r"\[skin\] poisson of a skin must lie"),
        ("[skin]\nkind = 'layer'\nb = 1\na = 2", r"unknown key a, b in \[skin\]; known are kind, thickness_m"),
        ("[skin]\nkind = 'half-space'\n[more]\n", "unknown key more in file; known are skin"),
    ):
        path.write_text(text)
        with pytest.raises(FormatError, match=says) as told:
            read_skin(path)
        assert str(told.value).startswith(str(path))
    path.write_text("[skin]\nkind = 'winkler'\nthickness_m = 0.002\n")
    assert read_skin(path) == Skin("winkler", 2e-3)


# Taxels on no grid


def hexagonal(rows: int, cols: int, spacing: float = 2e-3) -> np.ndarray:
    r, c = np.divmod(np.arange(rows * cols), cols)
    return spacing * np.column_stack([c + 0.5 * (r % 2), math.sqrt(0.75) * r])


@pytest.mark.parametrize(("rows", "cols"), [(4, 4), (4, 9), (5, 4), (8, 8), (12, 6)])
def test_a_grid_has_about_as_many_points_as_there_are_taxels(rows: int, cols: int) -> None:
    square = 2e-3 * np.stack(np.meshgrid(np.arange(cols), np.arange(rows)), axis=-1).reshape(-1, 2)
    on_square = resampling_of(square)
    assert on_square.shape == (rows, cols)
    assert on_square.pitch_m == pytest.approx((2e-3, 2e-3))
    assert on_square.field.all()
    np.testing.assert_allclose(on_square.origin_m, square.mean(axis=0))
    bent = resampling_of(hexagonal(rows, cols))
    assert bent.pitch_m[0] == bent.pitch_m[1] == pytest.approx(2e-3 * 0.75**0.25)
    assert bent.field.sum() == pytest.approx(rows * cols, rel=0.3)


@few
@given(seeds)
def test_a_point_is_the_plane_of_weighted_least_squares(seed: int) -> None:
    rng = np.random.default_rng(seed)
    spacing = 2e-3
    positions = hexagonal(5, 5, spacing) + rng.uniform(-2e-5, 2e-5, (25, 2))
    values = rng.normal(size=25)
    made = resampling_of(positions, (1.5e-3, 1.8e-3))
    apart = np.linalg.norm(positions[:, None] - positions, axis=2) + np.diag(np.full(25, np.inf))
    spacing = float(np.median(np.sort(apart, axis=1)[:, 2]))
    rows, cols = made.shape
    frame = made.frame(values)
    for r in range(rows):
        for c in range(cols):
            x = made.origin_m[0] + (c - (cols - 1) / 2) * 1.8e-3
            y = made.origin_m[1] + (r - (rows - 1) / 2) * 1.5e-3
            away = positions - (x, y)
            distance = np.linalg.norm(away, axis=1)
            assert made.field[r, c] == (distance.min() <= 0.75 * spacing)
            width = 0.5 * max(spacing, distance.min())
            root = np.where(distance <= 4 * width, np.exp(-0.25 * (distance / width) ** 2), 0.0)
            base = np.column_stack([np.ones(25), away / spacing])
            plane = np.linalg.lstsq(base * root[:, None], values * root, rcond=None)[0]
            if made.field[r, c]:
                assert frame[r, c] == pytest.approx(plane[0], abs=1e-4)
            else:
                assert frame[r, c] == 0
    nearness = dense(made, made.shares.nearness)
    np.testing.assert_allclose(nearness.sum(axis=1), 1.0)
    assert (nearness >= 0).all()
    np.testing.assert_allclose(made.share(np.ones(25, np.bool_)), 1.0)


def test_broken_taxels_on_no_grid_leave_an_even_stress_even() -> None:
    made = resampling_of(hexagonal(6, 6))
    readings = np.full(36, 5.0)
    readings[[0, 7, 14, 15]] = np.nan
    np.testing.assert_allclose(made.frame(readings)[made.field], 5.0)
    with pytest.raises(InputError, match="all 36 taxels are broken"):
        made.frame(np.full(36, np.nan))


def plain_resampling(positions: np.ndarray, points: np.ndarray, spacing: float, pitch: float) -> tuple[np.ndarray, ...]:
    """Return weights, nearness and field by looking from every point at every taxel."""
    weights, nearness = np.zeros((len(points), len(positions))), np.zeros((len(points), len(positions)))
    reached = np.zeros(len(points), np.bool_)
    for i, point in enumerate(points):
        away = positions - point
        distance = np.linalg.norm(away, axis=1)
        reached[i] = distance.min() <= 0.75 * max(spacing, pitch)
        width = 0.5 * max(spacing, distance.min())
        near = np.exp(-0.5 * (distance / width) ** 2) * (distance <= 4 * width)
        near /= near.sum()
        base = np.column_stack([np.ones(len(away)), away / max(spacing, distance.min())])
        normal = (base * near[:, None]).T @ base + np.diag([0, 1e-9, 1e-9])
        weights[i], nearness[i] = np.linalg.solve(normal, (base * near[:, None]).T)[0], near
    return weights, nearness, reached


def dense(made: Resampling, shares: np.ndarray) -> np.ndarray:
    """Return shares with the zeros between them, shape (rows * cols, n_taxels)."""
    return np.stack([made.shares.sums(shares, one) for one in np.eye(made.shares.n_taxels)], axis=1)


@few
@given(seed=seeds, n=st.sampled_from([3, 8, 9, 40, 64, 65, 150]), hole=st.booleans())
def test_looking_near_points_alone_is_looking_at_all_taxels(seed: int, n: int, hole: bool) -> None:
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-1e-2, 1e-2, (n, 2))
    if hole:
        positions *= (0.01 + rng.uniform(0, 1e-3, (n, 1))) / np.linalg.norm(positions, axis=1, keepdims=True)
    apart = np.linalg.norm(positions[:, None] - positions, axis=2) + np.diag(np.full(n, np.inf))
    spacing = float(np.median(np.sort(apart, axis=1)[:, 2 if n >= 9 else 0]))
    neighbours = np.quantile((apart < 1.2 * spacing).sum(axis=1), 0.75)
    pitch = spacing * (0.75**0.25 if neighbours > 4 else 1.0)
    # Of a pair or two that stand close by chance the grid would be of millions of points.
    assume(spacing > 1e-4 and np.linalg.svd(positions - positions.mean(axis=0))[1][1] > spacing)
    made = resampling_of(positions)
    np.testing.assert_allclose(made.pitch_m, pitch, rtol=1e-12)
    rows, cols = made.shape
    x = made.origin_m[0] + (np.arange(cols) - (cols - 1) / 2) * made.pitch_m[1]
    y = made.origin_m[1] + (np.arange(rows) - (rows - 1) / 2) * made.pitch_m[0]
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    weights, nearness, reached = plain_resampling(positions, points, spacing, pitch)
    np.testing.assert_array_equal(made.field.ravel(), reached)
    np.testing.assert_allclose(dense(made, made.shares.nearness), nearness, atol=1e-12)
    # Where taxels nearly lie on a line, the plane is as steep as rounding lets it.
    np.testing.assert_allclose(dense(made, made.shares.weights), weights, atol=1e-5)
    values, broken = rng.normal(size=(2, n)), np.arange(n) == n // 2
    stands = np.zeros(len(points), np.bool_)
    stands[nearness.argmax(axis=0)] = True
    np.testing.assert_array_equal(made.stands.ravel(), stands)
    np.testing.assert_allclose(made.share(broken).ravel(), nearness @ broken, atol=1e-12)
    near = np.where(broken, 0.0, nearness)
    total = near.sum(axis=1)
    around = np.where(broken, 0.0, values) @ near.T / np.maximum(total, 1e-300)
    back = np.where(total > 0, around, 0.0) @ nearness / np.maximum(nearness.sum(axis=0), 1e-300)
    np.testing.assert_allclose(made.filled(values, broken), np.where(broken, back, values), atol=1e-12)


def test_thousands_of_taxels_take_memory_as_their_number() -> None:
    tracemalloc.start()
    try:
        peaks = []
        for side in (24, 48, 96):
            tracemalloc.reset_peak()
            made = resampling_of(hexagonal(side, side))
            peaks.append(tracemalloc.get_traced_memory()[1] / side**2)
            assert made.frame(np.ones(side**2))[made.field] == pytest.approx(1.0)
    finally:
        tracemalloc.stop()
    assert max(peaks) < 2 * min(peaks)


@pytest.mark.parametrize("factor", [1.0, 1e3])
def test_positions_in_millimetres_are_asked_about_and_a_skin_of_a_hundred_metres_is_refused(factor: float) -> None:
    patch, mat = factor * hexagonal(4, 3), factor * hexagonal(60, 60)
    asked = "taxels are 2 m apart: are positions_m in millimetres?"
    assert far_apart(None, patch) == ([asked] if factor > 1 else [])
    pad = Pad(np.arange(36.0).reshape(3, 1, 12) % 7, positions_m=patch)
    assert (asked in Recording({"pad": pad}).remarks) == (factor > 1)
    assert (asked in summarize(Recording({"pad": pad})).notes) == (factor > 1)
    assert Sensor(positions_m=patch).resampling is not None
    if factor > 1:
        with pytest.raises(
            InputError, match=r"^mat\.toml: positions_m of a sensor reach over 119 m, and no skin"
        ) as told:
            _ = Sensor(positions_m=mat, source="mat.toml").resampling
        assert str(told.value).endswith("are they in millimetres? give them in metres")
    else:
        assert Sensor(positions_m=mat).resampling is not None


@pytest.mark.parametrize("taxels", [1, 2])
def test_a_taxel_alone_is_not_far_from_another(taxels: int) -> None:
    assert len(far_apart(None, 5.0 * np.arange(2.0 * taxels).reshape(-1, 2))) == taxels - 1


def test_positions_on_a_line_and_endless_grids_are_refused() -> None:
    line = np.column_stack([np.arange(5.0), np.zeros(5)])
    for positions in (line, line[:, ::-1], line * (1, 0) + (0.4 * (line[:, :1] == 1)) * (0, 1)):
        with pytest.raises(InputError, match="stand on one line"):
            resampling_of(positions)
    with pytest.raises(InputError, match="would be 257 x 257 points; give a larger pitch_m"):
        resampling_of(np.array([[0, 0], [1, 0], [0, 1], [1, 1.0]]), (1 / 256, 1 / 256))
    for positions in (np.zeros((2, 2)), np.zeros((3, 3)), np.array([[0, 0], [1, 0], [np.nan, 1]])):
        with pytest.raises(InputError, match=r"positions_m of a sensor must be finite \(x, y\) of three taxels"):
            Sensor(positions_m=positions)
    with pytest.raises(InputError, match="taxels 0 and 2 stand at one place"):
        Sensor(positions_m=np.array([[0, 0], [1, 0], [0, 0], [0, 1.0]]))


def test_a_resampling_says_what_it_is() -> None:
    square = 1e-3 * np.stack(np.meshgrid(np.arange(3), np.arange(4)), axis=-1).reshape(-1, 2)
    assert str(resampling_of(square)) == "12 taxels on no grid are resampled to 4 x 3 at 1 mm"
    assert str(resampling_of(square, (1e-3, 2e-3))).endswith("to 4 x 2 at 1 x 2 mm")


# Recordings


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.uint16, np.int32, np.uint32, np.int64, np.float32])
@pytest.mark.parametrize("rest", [0, 7, 40.0, 2.5, np.array([[1, 2], [3, 4]])])
@pytest.mark.parametrize("polarity", ["up", "down"])
def test_readings_above_rest_are_exact_and_whole_where_they_were(kind: Any, rest: Any, polarity: Any) -> None:
    small = np.issubdtype(kind, np.integer) and np.dtype(kind).itemsize < 8
    frames = np.array([[[0, 50], [np.iinfo(kind).max if small else 1000, 50]]], dtype=kind)
    got = _upright(frames, Sensor(rest=rest, polarity=polarity))
    np.testing.assert_array_equal(got, (frames.astype(np.float64) - rest) * (1 if polarity == "up" else -1))
    as_they_are = polarity == "up" and not np.any(rest)
    assert (got is frames) == as_they_are
    assert np.issubdtype(got.dtype, np.integer) == (small and not np.any(np.asarray(rest) % 1)) or as_they_are


# Maps and words


def test_a_map_is_read_however_its_numbers_are_parted(tmp_path: Path) -> None:
    values = np.array([[1.0, -2.5e-7, 3.0], [np.pi, 1e30, np.nan]])
    (tmp_path / "it.csv").write_text(map_text(values))
    np.testing.assert_array_equal(read_map(tmp_path / "it.csv", "gains"), values)
    for parting in (",", ";", "\t", ", "):
        lines = ["# a remark, with, commas", "", *(parting.join(map(str, row)) for row in values.tolist()), " "]
        (tmp_path / "it.txt").write_text("\n".join(lines))
        np.testing.assert_array_equal(read_map(tmp_path / "it.txt", "gains"), values)
    (tmp_path / "it.txt").write_text("1,2\n\n#\n3,x\n")
    with pytest.raises(FormatError, match="line 4, column 2 must be a number, got 'x'"):
        read_map(tmp_path / "it.txt", "gains")


def test_an_archive_holds_the_map_by_its_name_or_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "it.NPZ"
    one, two = np.eye(2), np.ones((2, 2))
    with path.open("wb") as file:
        np.savez(file, gains=one, other=two)
    np.testing.assert_array_equal(read_map(path, "gains"), one)
    with pytest.raises(FormatError, match="must hold an array 'rest', holds gains, other"):
        read_map(path, "rest")
    with path.open("wb") as file:
        np.savez(file, other=two)
    np.testing.assert_array_equal(read_map(path, "gains"), two)
    with path.open("wb") as file:
        np.savez(file)
    with pytest.raises(FormatError, match="holds nothing"):
        read_map(path, "gains")
    np.save(tmp_path / "it.npy", np.array([["a"]]))
    with pytest.raises(FormatError, match="a map must hold real numbers, got <U1"):
        read_map(tmp_path / "it.npy", "gains")


def test_the_maps_beside_a_sensor_file_are_told_beforehand(tmp_path: Path) -> None:
    sensor = Sensor(gains=np.ones((2, 2)), rest=np.ones((2, 2)), name='\x00\x7f\x9f"\\', notes="'''")
    written = write_sensor(sensor, tmp_path / "mat.toml")
    assert {*written} == {*map_files(tmp_path / "mat.toml"), tmp_path / "mat.toml"}
    back = read_sensor(tmp_path / "mat.toml")
    assert (back.name, back.notes) == (sensor.name, sensor.notes)
    # Nothing but what differs from a plain sensor stands in a file.
    assert write_sensor(Sensor(), tmp_path / "plain.toml") == (tmp_path / "plain.toml",)
    assert (tmp_path / "plain.toml").read_text() == "# A sensor file, written by varishold.\n"


def test_a_sensor_is_called_by_its_file_and_its_name() -> None:
    assert sensor_name(Sensor()) == "sensor"
    assert sensor_name(Sensor(name="mat")) == "mat"
    assert sensor_name(Sensor(source="a.toml")) == "a.toml"
    assert sensor_name(Sensor(name="mat", source="a.toml")) == "mat (a.toml)"


def test_what_is_undone_is_said_and_nothing_else() -> None:
    assert undone_words(Sensor()) == ()
    square = 1e-3 * np.stack(np.meshgrid(np.arange(3), np.arange(4)), axis=-1).reshape(-1, 2)
    for values, words in (
        ({"polarity": "down"}, "readings counted from rest, downward"),
        ({"rest": 3.0}, "readings counted from rest"),
        ({"rest": np.zeros((2, 2))}, "readings counted from rest"),
        ({"response": Power(0.5), "span": 1.0}, "a power response undone"),
        ({"gains": np.ones((2, 2))}, "unequal gains undone"),
        ({"crosstalk": 0.1}, "crosstalk and blur undone"),
        ({"blur_taxels": 0.1}, "crosstalk and blur undone"),
        ({"dead_band": 0.125, "span": 1.0}, "12 % of full scale is not felt"),
        ({"positions_m": square}, "12 taxels on no grid are resampled to 4 x 3 at 1 mm"),
    ):
        assert undone_words(Sensor(**values)) == (words,)  # type: ignore[arg-type]
