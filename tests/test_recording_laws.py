"""Laws of recordings: units, totals, presses as a person would mark them, what is odd and said."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.recording import GraspTable, Pad, Recording, presses, select_frames

few = settings(max_examples=30)


def of_force(force: list[float], shape: tuple[int, int] = (4, 4), dtype: type = float) -> Recording:
    """Return a recording whose every taxel says the same at a time."""
    return Recording({"pad": Pad(np.tile(np.array(force, dtype)[:, None, None], (1, *shape)))})


@pytest.mark.parametrize(
    ("unit", "pascals"),
    [
        ("Pa", 1.0),
        ("kPa", 1000.0),
        ("hPa", 100.0),
        ("MPa", 1e6),
        ("bar", 1e5),
        ("mbar", 100.0),
        ("N/m²", 1.0),
        ("N/cm^2", 1.0 / 0.01**2),
        ("N / mm2", 1.0 / 0.001**2),
        ("psi", 0.45359237 * 9.80665 / 0.0254**2),
        ("g/cm2", 0.001 * 9.80665 / 0.01**2),
        ("kg/cm2", 9.80665 / 0.01**2),
        ("mmHg", 13595.1 * 9.80665 * 0.001),
        ("inHg", 13595.1 * 9.80665 * 0.0254),
        ("torr", 101325 / 760),
        ("atm", 101325.0),
    ],
)
def test_units_of_pressure_are_what_they_are_defined_as(unit: str, pascals: float) -> None:
    recording = Recording({"pad": Pad(np.array([[[0.0, 1.0]]]))}, unit=unit)
    assert recording.pascals_per_unit == pytest.approx(pascals, rel=1e-5)


@pytest.mark.parametrize("unit", ["raw", "", "V", "counts"])
def test_what_is_no_pressure_has_no_pascals(unit: str) -> None:
    recording = Recording({"pad": Pad(np.array([[[0.0, 1.0]]]))}, unit=unit)
    assert recording.pascals_per_unit is None
    assert recording.unit == (unit or "raw")


@few
@given(st.integers(0, 2**32 - 1))
def test_totals_add_up_what_works_on_all_pads(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frames = rng.integers(0, 100, (5, 3, 4)).astype(float)
    field, valid = rng.random((3, 4)) < 0.8, rng.random((3, 4)) < 0.8
    field[0, 0] = valid[0, 0] = True
    pad = Pad(frames, field=field, valid=valid)
    np.testing.assert_allclose(pad.totals(), frames[:, field & valid].sum(axis=1))
    np.testing.assert_array_equal(pad.usable, field & valid)
    other = Pad(frames[:, ::-1])
    both = Recording({"one": pad, "two": other})
    np.testing.assert_allclose(both.totals(), pad.totals() + frames.sum(axis=(1, 2)))
    assert both.n_frames == 5
    (peak,) = select_frames(both, "peak")
    assert list(peak) == [int(both.totals().argmax())]


def test_a_press_begins_at_a_fiftieth_and_ends_at_half_of_that() -> None:
    force = [0, 0, 0, 1.6, 2, 100, 1.6, 1.2, 0.8, 0, 0, 0]
    # 2 % of 100 begins it; it ends below 1, so that 1.6 and 1.2 belong to it, but only after it began.
    assert presses(of_force(force)) == [range(4, 8)]
    assert presses(of_force([0, 0, 0, 0, 1.9, 0, 0, 100, 0, 0, 0, 0])) == [range(7, 8)]
    assert presses(of_force([0, 0, 0, 100, 1.2, 100, 0, 0, 100, 0.8, 100, 0, 0])) == [
        range(3, 6),
        range(8, 9),
        range(10, 11),
    ]


def test_a_press_may_last_to_either_end() -> None:
    assert presses(of_force([0.0] * 30 + [9.0] * 3)) == [range(30, 33)]
    assert presses(of_force([9.0] * 3 + [0.0] * 30)) == [range(3)]
    assert presses(of_force([0.0] * 9)) == []


@pytest.mark.parametrize("rest", [0.0, 5.0])
def test_a_level_rest_is_no_load(rest: float) -> None:
    rng = np.random.default_rng(0)
    frames = rest + rng.normal(0, 0.01, (60, 8, 8))
    frames[20:30, 2:6, 2:6] += 3.0
    frames[40:45, 2:6, 2:6] += 1.0
    assert presses(Recording({"pad": Pad(frames)})) == [range(20, 30), range(40, 45)]


def test_noise_makes_no_press_and_a_weak_one_beside_a_strong_one_is_found() -> None:
    rng = np.random.default_rng(1)
    quiet = rng.normal(0, 1.0, (80, 10, 10))
    assert all(len(press) <= 1 for press in presses(Recording({"pad": Pad(quiet)})))
    quiet[30:40] += 2.0
    assert presses(Recording({"pad": Pad(quiet)})) == [range(30, 40)]


def test_frames_are_chosen_by_word_or_number() -> None:
    recording = of_force([0, 1, 5, 2])
    assert select_frames(recording, "all") == [range(k, k + 1) for k in range(4)]
    assert select_frames(recording, 3) == select_frames(recording, " 3 ") == [range(3, 4)]
    assert select_frames(recording, "peak") == [range(2, 3)]
    for wrong in ("-1", "1.0", "first", True, "²"):
        with pytest.raises(InputError, match="frames must be 'peak', 'all', 'press' or a frame's number"):
            select_frames(recording, wrong)
    for beyond in (4, "99999999999999999999999"):
        with pytest.raises(InputError, match="there is no frame"):
            select_frames(recording, beyond)
    with pytest.raises(InputError, match="no press found"):
        select_frames(of_force([0, 0, 0]), "press")


def told(frames: np.ndarray, **options: np.ndarray) -> str:
    return "\n".join(Pad(frames, **options).remarks)


def test_stuck_dead_and_saturated_taxels_are_told_and_counted() -> None:
    rng = np.random.default_rng(2)
    alive = rng.normal(10, 1, (9, 4, 5))
    assert told(alive) == ""
    stuck = alive.copy()
    stuck[:, 1, 2] = 7.0
    assert told(stuck) == "taxel (1, 2) never changes its value: stuck; mark it in valid"
    assert told(stuck[:7]) == ""  # too few frames to tell
    assert "stuck" in told(stuck[:8])
    stuck[:, 2] = 7.0
    assert told(stuck).startswith("each of 6 taxels ((1, 2), (2, 0), (2, 1), (2, 2) and 2 more) never changes")
    dead = alive.copy()
    dead[:, 0, 0] = 0.0
    assert "taxel (0, 0) is always 0 while nearly all others are not" in told(dead)
    some = alive.copy()
    some[:, [0, 1, 2, 3, 0], [0, 1, 2, 3, 4]] = 0.0  # five of twenty may never have been touched
    assert "always 0" not in told(some)
    dead[:, 0] = 0.0  # but no line beside others that live
    assert "each of 5 taxels ((0, 0), (0, 1), (0, 2), (0, 3) and 1 more) is always 0" in told(dead)
    marked = np.ones((4, 5), bool)
    marked[0] = False
    assert told(dead, valid=marked) == ""
    assert told(np.full((9, 2, 2), 3.0)) == "nothing changes: every value of every frame is 3"


@pytest.mark.parametrize(("highest", "full"), [(255, True), (254, False), (1023, True), (4095, True), (4096, False)])
def test_whole_numbers_saturate_at_a_converters_full_scale(highest: int, full: bool) -> None:
    frames = np.random.default_rng(3).integers(0, 200, (9, 4, 4)).astype(np.uint16)
    frames[3, 1, 1] = highest
    assert ("taxel (1, 1) reaches full scale" in told(frames)) == full


def test_real_numbers_saturate_where_several_taxels_reach_the_same() -> None:
    frames = np.random.default_rng(4).random((9, 4, 4))
    frames[3, 1, 1] = 2.0
    assert told(frames) == ""
    frames[5, 2, 2] = 2.0
    assert "each of 2 taxels ((1, 1), (2, 2)) reaches exactly the same highest value, 2" in told(frames)


def test_values_below_zero_are_noise_until_they_outweigh() -> None:
    rng = np.random.default_rng(5)
    Pad(rng.normal(0, 1, (9, 4, 4)))
    press = np.zeros((9, 4, 4))
    press[4, 1:3, 1:3] = 5.0
    with pytest.raises(InputError, match="pressure is mostly negative"):
        Pad(-press)
    Pad(-press, polarity="down")
    broken = press.copy()
    broken[:, 0, 0] = -50.0  # one taxel alone does not turn a sensor round
    Pad(broken)
    broken[:, 0, 1] = -50.0
    with pytest.raises(InputError, match="mostly negative"):
        Pad(broken)
    Pad(np.where(press > 0, press, -0.3))
    with pytest.raises(InputError, match="within 1e"):
        Pad(press * 1e101)


def test_time_that_goes_back_is_told() -> None:
    pad = Pad(np.random.default_rng(6).random((5, 2, 2)))
    assert Recording({"pad": pad}, time_s=np.arange(5.0)).remarks == ()
    assert Recording({"pad": pad}, time_s=np.array([0, 1, 1, 2, 3.0])).remarks == ()
    assert Recording({"pad": pad}, time_s=np.array([0, 2, 1, 2, 3.0])).remarks == ("time goes back at frame 2",)
    twice = Recording({"pad": pad}, time_s=np.array([4, 2, 3, 1, 0.0])).remarks
    assert twice == ("time goes back at frame 1 and 2 times more",)
    named = Recording({"thumb": Pad(np.ones((2, 2, 2)))}, notes=("read from far",)).remarks
    assert named == ("read from far", "pad thumb: nothing changes: every value of every frame is 1")


def test_cells_of_a_table_are_asked_for_by_globs() -> None:
    table = GraspTable(
        {
            "object": np.array(["a", "b", ""]),
            "switch.p": np.array([True, False, True]),
            "switch.q": np.array([False, False, True]),
            "size_m": np.array([0.5, 2.0, np.nan]),
        },
        source="rows.csv",
    )
    assert len(table) == 3
    assert table.names(("size*", "switch.q")) == ("switch.q", "size_m")
    np.testing.assert_array_equal(table.matrix("switch.*"), [[True, False], [False, False], [True, True]])
    assert table.matrix("switch.*").dtype == np.bool_
    assert table.labels("switch.p").tolist() == ["1", "0", "1"]
    with pytest.raises(InputError, match=r"rows\.csv: line 4, column 'size_m' is empty"):
        table.matrix("size_m")
    with pytest.raises(InputError, match=r"rows\.csv: line 4, column 'object' is empty"):
        table.labels("object")
    with pytest.raises(InputError, match="line 4, column 'size_m' is empty"):
        table.labels("size_m")
    with pytest.raises(InputError, match="line 2, column 'object' must be a number, got 'a'"):
        table.matrix(("object", "size_m"))
    with pytest.raises(InputError, match=r"no column matches 'x' or 'y'; its columns are object, switch.p"):
        table.names(("x", "y"))
    wide = GraspTable({f"c{k}": np.zeros(2) for k in range(14)})
    with pytest.raises(InputError, match="c11 and 2 more"):
        wide.names("z")
    with pytest.raises(InputError, match="of one length and one dimension"):
        GraspTable({"a": np.zeros(2), "b": np.zeros(3)})
    with pytest.raises(InputError, match="of one length and one dimension"):
        GraspTable({"a": np.zeros((2, 2))})
