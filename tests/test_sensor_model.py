"""Laws of the one sensor model: its inverse is one, an even stress stays even, noise stays noise."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.sensor import Linear, Logarithmic, Power, Response, Sensor, Table

SHAPE = (7, 9)


def responses() -> st.SearchStrategy[Response]:
    tables = st.lists(st.floats(0.05, 1.0), min_size=1, max_size=6).map(
        lambda steps: Table(
            np.linspace(0, 1, len(steps) + 1).tolist(), [0.0, *(np.cumsum(steps) / sum(steps))[:-1], 1.0]
        )
    )
    return st.one_of(
        st.just(Linear()),
        st.floats(0.3, 3.0).map(Power),
        st.floats(0.01, 100.0).map(Logarithmic),
        tables,
    )


def sensors(*, dead_band: float = 0.4) -> st.SearchStrategy[Sensor]:
    def made(seed: int, gain: float, gaps: bool, **values: Any) -> Sensor:
        rng = np.random.default_rng(seed)
        field = rng.random(SHAPE) < 0.8 if gaps else None
        gains = np.clip(1 + gain * rng.standard_normal(SHAPE), 0.2, 3.0)
        rest = rng.normal(100.0, 5.0, SHAPE)
        return Sensor(field=field, gains=gains, rest=rest, **values)

    return st.builds(
        made,
        seed=st.integers(0, 2**32 - 1),
        gain=st.floats(0, 0.3),
        gaps=st.booleans(),
        polarity=st.sampled_from(["up", "down"]),
        span=st.floats(1.0, 1e4),
        full_scale=st.floats(1e-3, 1e6),
        response=responses(),
        dead_band=st.floats(0, dead_band),
        # Of every pattern more than a quarter is left: no more than that is undone exactly.
        crosstalk=st.floats(0, 0.06),
        blur_taxels=st.floats(0, 0.4),
    )


@given(sensor=sensors(dead_band=0.0), seed=st.integers(0, 2**32 - 1))
def test_undoing_gives_the_stress_back(sensor: Sensor, seed: int) -> None:
    stress = sensor.full_scale * np.random.default_rng(seed).random((3, *SHAPE))
    back = sensor.stress(sensor.forward(stress))
    assert np.allclose(back, stress, rtol=0, atol=1e-6 * sensor.full_scale)


@given(sensor=sensors(), seed=st.integers(0, 2**32 - 1))
def test_above_the_dead_band_all_but_the_band_comes_back(sensor: Sensor, seed: int) -> None:
    stress = sensor.full_scale * (1.0 + np.random.default_rng(seed).random(SHAPE))
    undone = sensor.undo(sensor.forward(stress))
    assert undone.beneath == pytest.approx(sensor.dead_band * sensor.full_scale)
    assert np.allclose(undone.frame + undone.beneath, stress, rtol=0, atol=1e-6 * sensor.full_scale)


@given(sensor=sensors(), readings=st.floats(0, 1))
def test_more_stress_reads_more_and_none_reads_rest(sensor: Sensor, readings: float) -> None:
    assert np.allclose(sensor.forward(np.zeros(SHAPE)), sensor.rest)
    low, high = (
        np.abs(sensor.forward(np.full(SHAPE, share * sensor.full_scale)) - sensor.rest) for share in (readings, 1.1)
    )
    assert (low <= high + 1e-9 * sensor.span).all()


@given(sensor=sensors(dead_band=0.0))
def test_an_even_stress_is_not_changed_by_crosstalk_and_blur(sensor: Sensor) -> None:
    even = np.full(SHAPE, 0.7 * sensor.full_scale)
    without = Sensor(
        polarity=sensor.polarity,
        rest=sensor.rest,
        span=sensor.span,
        full_scale=sensor.full_scale,
        response=sensor.response,
        gains=sensor.gains,
    )
    inside = np.ones(SHAPE, np.bool_) if sensor.field is None else sensor.field
    assert np.allclose(sensor.forward(even)[inside], without.forward(even)[inside], atol=1e-6 * sensor.span)


@given(crosstalk=st.floats(0, 0.2), blur=st.floats(0, 4), seed=st.integers(0, 2**32 - 1))
def test_undoing_never_raises_anything_more_than_four_times(crosstalk: float, blur: float, seed: int) -> None:
    sensor = Sensor(crosstalk=crosstalk, blur_taxels=blur)
    noise = np.random.default_rng(seed).standard_normal((12, 11))
    assert np.linalg.norm(sensor.stress(noise)) <= 4.0001 * np.linalg.norm(noise)
    assert 0 < sensor.least_stress(1.0) <= 4.0001


def test_crosstalk_is_a_share_to_each_of_four_neighbours() -> None:
    point = np.zeros((5, 5))
    point[2, 2] = 1.0
    read = Sensor(crosstalk=0.1).forward(point)
    expected = np.zeros((5, 5))
    expected[2, 2] = 0.6
    expected[[1, 3, 2, 2], [2, 2, 1, 3]] = 0.1
    assert np.allclose(read, expected)
    # The same on a pad with a gap far away, whose patterns are found numerically.
    field = np.ones((5, 5), np.bool_)
    field[0, 0] = False
    assert np.allclose(Sensor(crosstalk=0.1, field=field).forward(point), expected)


def test_blur_has_the_standard_deviation_that_it_says() -> None:
    point = np.zeros((41, 41))
    point[20, 20] = 1.0
    read = Sensor(blur_taxels=1.5).forward(point)
    y, x = np.mgrid[-20:21, -20:21]
    assert read.sum() == pytest.approx(1.0)
    assert (read * x**2).sum() == pytest.approx(1.5**2)
    assert (read * y**2).sum() == pytest.approx(1.5**2)


@pytest.mark.parametrize(
    ("response", "half"), [(Linear(), 0.5), (Power(2.0), 0.25), (Logarithmic(3.0), np.log(2.5) / np.log(4))]
)
def test_the_responses_are_the_formulas_of_the_docstring(response: Response, half: float) -> None:
    reading = Sensor(response=response, span=10.0, full_scale=4.0).forward(np.array([[0.0, 2.0, 4.0]]))
    assert np.allclose(reading, [[0.0, 10 * half, 10.0]])


@given(response=responses(), x=st.floats(-3, 3))
def test_a_response_is_odd_and_its_inverse_is_one(response: Response, x: float) -> None:
    at = np.array([x, -x])
    read = response.reading(at)
    assert read[0] == -read[1]
    assert np.allclose(response.stress(read), at, atol=1e-9)


def test_saturated_taxels_are_told_and_hold_the_least_they_can_have_felt() -> None:
    sensor = Sensor(span=255, saturation=0.8)
    undone = sensor.undo(sensor.forward(np.array([[10.0, 203.9, 204.0, 400.0]])))
    assert undone.saturated.tolist() == [[False, False, True, True]]
    assert np.allclose(undone.frame, [[10.0, 203.9, 204.0, 204.0]])


@pytest.mark.parametrize("polarity", ["up", "down"])
def test_a_reading_far_above_saturation_is_saturated_and_stands_for_a_number(polarity: Any) -> None:
    sensor = Sensor(response=Logarithmic(1e4), span=2.0, polarity=polarity)
    raw = (1.0 if polarity == "up" else -1.0) * np.array([[1.0, 200.0, 1.8]])
    assert sensor.beyond(raw).tolist() == [[False, True, False]]
    with pytest.raises(InputError, match="give the right span or saturation"):
        sensor.undo(raw)
    saturating = dataclasses.replace(sensor, saturation=0.9)
    assert not saturating.beyond(raw).any()
    undone = saturating.undo(raw)
    assert undone.saturated.tolist() == [[False, True, True]]
    assert undone.frame[0, 1] == undone.frame[0, 2]


def test_a_whole_number_next_to_saturation_is_saturated() -> None:
    sensor = Sensor(span=1023, saturation=0.7)
    undone = sensor.undo(np.array([[715, 716, 717]], np.uint16))
    assert undone.saturated.tolist() == [[False, True, True]]


def test_broken_taxels_are_told_and_filled_before_crosstalk_is_undone() -> None:
    gains = np.ones((9, 9))
    gains[4, 4], gains[0, 0] = 0.0, np.nan
    sensor = Sensor(gains=gains, crosstalk=0.05)
    y, x = np.mgrid[:9, :9]
    stress = 2.0 + 0.1 * x + 0.05 * y
    valid = np.ones((9, 9), np.bool_)
    valid[7, 2] = False
    undone = sensor.undo(sensor.forward(stress), valid=valid)
    assert np.argwhere(undone.broken).tolist() == [[0, 0], [4, 4], [7, 2]]
    assert np.abs(undone.frame - stress).max() < 0.2


def test_noise_stays_noise() -> None:
    noise = np.random.default_rng(0).normal(0, 0.01, (64, 64))
    sensor = Sensor(response=Logarithmic(5.0), span=1.0, dead_band=0.3)
    back = sensor.stress(noise)
    assert abs(back.mean()) < 0.001
    assert back.std() == pytest.approx(sensor.least_stress(0.01), rel=0.05)


def hexagonal(n: int = 6, pitch: float = 2e-3) -> NDArray[np.float64]:
    rows = [(pitch * (i + 0.5 * (j % 2)), pitch * j * np.sqrt(3) / 2) for j in range(n) for i in range(n)]
    return np.array(rows)


@given(
    seed=st.integers(0, 2**32 - 1),
    a=st.floats(-1, 1),
    b=st.floats(-1, 1),
)
def test_a_plane_over_taxels_on_no_grid_stays_a_plane(seed: int, a: float, b: float) -> None:
    rng = np.random.default_rng(seed)
    positions = hexagonal() + rng.uniform(-2e-4, 2e-4, (36, 2))
    sensor = Sensor(positions_m=positions)
    undone = sensor.undo(5.0 + 1e3 * (positions @ [a, b]))
    grid = sensor.resampling
    assert grid is not None
    rows, cols = grid.shape
    x = grid.origin_m[0] + (np.arange(cols) - (cols - 1) / 2) * grid.pitch_m[1]
    y = grid.origin_m[1] + (np.arange(rows) - (rows - 1) / 2) * grid.pitch_m[0]
    plane = 5.0 + 1e3 * (a * x + b * y[:, None])
    assert np.allclose(undone.frame[grid.field], plane[grid.field], atol=1e-4)
    assert grid.field.mean() > 0.8


def test_the_resampling_is_told_and_keeps_the_number_of_taxels() -> None:
    grid = Sensor(positions_m=hexagonal(), pitch_m=None).resampling
    assert grid is not None
    assert 25 <= np.count_nonzero(grid.field) <= 49
    assert re.fullmatch(r"36 taxels on no grid are resampled to \d x \d at 1\.86 mm", str(grid))


def test_a_broken_taxel_on_no_grid_is_filled_from_those_around() -> None:
    positions = hexagonal()
    gains = np.ones(36)
    gains[14] = 0.0
    sensor = Sensor(positions_m=positions, gains=gains)
    undone = sensor.undo(np.where(gains > 0, 3.0, 99.0))
    inside = sensor.resampling.field  # type: ignore[union-attr]
    assert np.allclose(undone.frame[inside], 3.0)
    assert undone.broken.any()
    raw = np.where(gains > 0, np.array([[[3.0]], [[0.0]], [[8.0]]]), 99.0)
    np.testing.assert_allclose(sensor.stress(raw), np.broadcast_to([[[3.0]], [[0.0]], [[8.0]]], raw.shape), atol=1e-12)
    whole = Sensor(positions_m=positions)
    np.testing.assert_allclose(whole.stress(raw, broken=gains[None] == 0), sensor.stress(raw), atol=1e-12)
    with pytest.raises(InputError, match="all 36 taxels are broken"):
        whole.stress(raw, broken=np.ones((1, 36), np.bool_))
    with pytest.raises(InputError, match=r"broken must have the shape of a frame, \(1, 36\), got \(36,\)"):
        whole.stress(raw, broken=gains == 0)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"shape": (16,)}, "shape of a sensor must be [rows, columns]"),
        (
            {"shape": (4, 4), "gains": np.ones((4, 5))},
            "gains of a sensor must have the sensor's shape, 4 x 4, got 4 x 5",
        ),
        ({"gains": -np.ones((2, 2))}, "gains of a sensor must not be negative"),
        ({"gains": np.full((2, 2), 1e-300)}, "one at least must be 0.02 or more: 1 is usual"),
        ({"gains": np.full((2, 2), np.inf)}, "gains of a sensor must be finite, got inf at (row, col) = (0, 0)"),
        ({"field": np.zeros((2, 2))}, "true for one at least"),
        ({"polarity": "sideways"}, "polarity of a sensor must be up or down, got 'sideways'"),
        ({"rest": np.nan}, "rest of a sensor must be a number"),
        ({"dead_band": 1.0}, "dead_band of a sensor must be a number from 0 to 0.9, got 1.0"),
        ({"crosstalk": 0.25}, "crosstalk of a sensor must be a number from 0 to 0.2"),
        ({"span": 0.0}, "span of a sensor must be a number from 1e-12"),
        ({"saturation": -1.0, "span": 1.0}, "saturation of a sensor must be a number from 0.001"),
        ({"response": Power(2.0)}, "a power response of a sensor is a share of full scale: give span"),
        ({"dead_band": 0.1}, "a dead band of a sensor is a share of full scale: give span"),
        ({"positions_m": [[0, 0], [1, 1]]}, "positions_m of a sensor must be finite (x, y) of three taxels or more"),
        ({"positions_m": [[0, 0], [1, 1], [1, 1]]}, "taxels 1 and 2 stand at one place"),
        ({"positions_m": hexagonal(), "shape": (6, 6)}, "taxels on no grid: leave shape out"),
        ({"positions_m": hexagonal(), "crosstalk": 0.1}, "no four neighbours: leave crosstalk out"),
    ],
)
def test_an_impossible_sensor_is_told_in_one_line(values: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError) as caught:
        Sensor(**values)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Table([0, 0.5, 1], [0, 0.6, 0.6]), "a response must rise: readings of its table go from 0.6 to 0.6"),
        (lambda: Table([0, 1], [0, 0.5, 1]), "as many readings as stresses, got 3 and 2"),
        (lambda: Table([0.1, 1], [0, 1]), "must go from 0 to 1 (shares of full scale), got 0.1 to 1"),
        (lambda: Table([0, "x"], [0, 1]), "two finite numbers or more"),  # type: ignore[list-item]
        (lambda: Logarithmic(-1.0), "a of a response must be a number from 1e-06"),
        (lambda: Power(0.0), "exponent of a response must be a number from 0.05 to 20, got 0.0"),
    ],
)
def test_an_impossible_response_is_told_in_one_line(make: Any, says: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_frame_of_another_shape_is_refused() -> None:
    with pytest.raises(InputError, match="shape of the sensor mat, 4 x 4, got 4 x 5"):
        Sensor(name="mat", shape=(4, 4)).undo(np.ones((4, 5)))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("far", [1.0, 30.0])
def test_taxels_of_which_one_stands_far_off_are_resampled(far: float) -> None:
    positions = [[0, 0], [0.002, 0], [0, 0.002], [0.002, far]]
    undone = Sensor(positions_m=np.array(positions)).undo(np.full(4, 7.0))
    assert undone.frame[undone.frame != 0] == pytest.approx(7.0)


def test_taxels_a_thousand_times_too_far_off_are_told() -> None:
    sensor = Sensor(positions_m=np.array([[0, 0], [0.002, 0], [0, 0.002], [0.002, 1e3]]))
    with pytest.raises(
        InputError, match=r"reach over 1000 m, and its taxels are 0\.002 m apart: all must be in metres"
    ):
        sensor.undo(np.ones(4))


@pytest.mark.parametrize("slope", [0.0, 0.37, 1.0, 1e3])
def test_taxels_on_a_slanted_line_are_told(slope: float) -> None:
    along = np.arange(12) * 1e-3
    sensor = Sensor(positions_m=np.column_stack([along, slope * along]))
    with pytest.raises(InputError, match="stand on one line"):
        sensor.undo(np.ones(12))


def test_taxels_without_order_make_a_coarser_grid() -> None:
    positions = np.random.default_rng(0).uniform(0, 0.03, (250, 2))
    resampling = Sensor(positions_m=positions).resampling
    assert resampling is not None
    assert resampling.field.mean() > 0.7
    assert 0.7 * 250 < resampling.stands.sum() <= 250
