"""What a calibration refuses, or says it cannot know, of recordings that look like good ones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.test_calibration_laws import by_tips

from varishold.calibration import (
    KnownObject,
    calibrate_even,
    calibrate_objects,
    calibrate_scale,
    calibrate_unlabelled,
)
from varishold.calibration.imprint import Points
from varishold.calibration.readings import _pressed, presses_of
from varishold.cli.app import app
from varishold.errors import InputError
from varishold.recording import Pad, Recording, write
from varishold.sensor import Sensor

Floats = NDArray[np.float64]
SHAPE, PITCH_M = (10, 12), 2e-3


def recorded(frames: Floats, sigma: float = 2.0, *, most: float = np.inf, kind: Any = float, **of: Any) -> Recording:
    """Return presses of three frames between rests, in noise, readings ending at `most`."""
    quiet = np.zeros((6, *frames.shape[1:]))
    clean = np.concatenate([quiet, *(part for frame in frames for part in (frame[None].repeat(3, 0), quiet))])
    noisy = clean + np.random.default_rng(0).normal(0, sigma, clean.shape)
    values = np.minimum(noisy, most) if kind is float else np.clip(np.round(noisy), 0, most).astype(kind)
    return Recording({"pad": Pad(values, pitch_m=(PITCH_M, PITCH_M))}, source="r.npz", **of)


def even(seed: int, spread: float = 0.2) -> Floats:
    gains = np.exp(spread * np.random.default_rng(seed).standard_normal(SHAPE))
    return np.asarray(1000 * np.array([0.4, 0.7, 1.0])[:, None, None] * gains)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.05, 0.9), st.sampled_from([float, np.uint16]))
def test_gains_are_not_told_from_taxels_at_their_end(seed: int, share: float, kind: Any) -> None:
    frames = even(seed)
    most = float(np.round(np.quantile(frames[2], 1 - share)))
    with pytest.raises(InputError, match=rf"taxels read exactly {most:g} and none more: they are saturated"):
        calibrate_even([recorded(frames, most=most, kind=kind)])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.02, 0.2), st.sampled_from([10, 40, 200, 1000]))
def test_coarse_counts_are_not_taken_for_saturation(seed: int, spread: float, counts: int) -> None:
    frames = even(seed, spread) * counts / 1000
    found = calibrate_even([recorded(frames, 0.3, most=60000, kind=np.uint16)])
    assert found.presses >= 1


def test_what_never_changes_and_what_stands_alone_tells_no_gains() -> None:
    with pytest.raises(InputError, match="no reading ever changes"):
        calibrate_even([Recording({"pad": Pad(np.full((30, *SHAPE), 77.0))})])
    with pytest.raises(InputError, match="one taxel that works"):
        calibrate_even([recorded(even(0)[:, :1, :1])])


def test_a_press_that_is_not_even_is_told_with_its_file_and_its_number_there() -> None:
    half = even(0) * (np.arange(SHAPE[1]) < SHAPE[1] // 4)
    with pytest.raises(InputError, match=r"^second\.npz: press 0 is no even pressure"):
        calibrate_even([recorded(even(0)), replace(recorded(half), source="second.npz")])


def test_recordings_of_two_units_are_not_calibrated_together() -> None:
    pair = [recorded(even(0), unit="Pa"), recorded(even(0) / 1000, 0.002, unit="kPa")]
    with pytest.raises(InputError, match="readings are in kPa, in the recordings before in Pa"):
        calibrate_even(pair)


def test_presses_that_are_all_alike_tell_no_gains() -> None:
    y, x = np.indices(SHAPE)
    bump = 800 * np.maximum(1 - np.hypot(y - 5, x - 5) / 5, 0.0)
    with pytest.raises(InputError, match="the presses are all alike"):
        calibrate_unlabelled([recorded(np.repeat(bump[None] * even(0)[2] / 1000, 40, axis=0))])


def balls(n: int) -> Floats:
    """Return presses of a ball of 50 mm on springs, deepest 2 mm, each taxel feeling its middle alone."""
    rng = np.random.default_rng(1)
    y, x = (np.indices(SHAPE) - np.array([4.5, 5.5])[:, None, None]) * PITCH_M
    made = []
    for depth in rng.uniform(5e-4, 1e-3, n):
        cx, cy = rng.uniform(-3e-3, 3e-3, 2)
        gap = 0.025 - np.sqrt(0.025**2 - np.minimum((x - cx) ** 2 + (y - cy) ** 2, 0.0249**2))
        made.append(1e6 * np.maximum(depth - gap, 0.0))
    return np.array(made)


def test_a_dead_band_that_nothing_asks_for_is_not_told() -> None:
    found = calibrate_objects([recorded(balls(8))], [KnownObject("ball", 0.05)])
    assert found.sensor.dead_band == 0.0
    assert "dead_band" not in [finding.name for finding in found.findings]
    assert any(words.startswith("a dead band: without one") for words in found.unknown)


@pytest.mark.parametrize("size_m", [5e-5, 50.0])
def test_sizes_in_millimetres_are_refused(size_m: float) -> None:
    with pytest.raises(InputError, match=r"on a pad that is 0.024 m across, .* in metres"):
        calibrate_objects([recorded(balls(8))], [KnownObject("ball", size_m)])


@pytest.mark.parametrize(("option", "kind"), [("--force-n", "even"), ("--pressure-pa", "unlabelled")])
def test_an_option_of_another_kind_is_refused(option: str, kind: str, tmp_path: Path) -> None:
    write(recorded(even(0)), tmp_path / "r.npz")
    arguments = ["sensor", "calibrate", str(tmp_path / "r.npz"), "--kind", kind, option, "1,2,3"]
    done = CliRunner().invoke(app, [*arguments, "-o", str(tmp_path / "s.toml")])
    assert done.exit_code != 0
    assert not (tmp_path / "s.toml").exists()
    assert f"{option} goes with --kind" in str(done.exception) + done.output


def test_some_saturated_presses_of_anything_are_borne_and_most_are_not() -> None:
    rng = np.random.default_rng(2)
    y, x = np.indices(SHAPE)
    places = rng.uniform((2, 2), (7, 9), (40, 2))[:, :, None, None]
    heights = rng.uniform(300, 1000, 40)[:, None, None]
    bumps = heights * np.maximum(1 - np.hypot(y - places[:, 0], x - places[:, 1]) / 4, 0.0) * even(0)[2] / 1000
    assert calibrate_unlabelled([recorded(bumps, most=900.0)]).presses > 20
    with pytest.raises(InputError, match="saturated"):
        calibrate_unlabelled([recorded(bumps, most=200.0)])


def pressed(gains: np.ndarray, seed: int = 0) -> Recording:
    """Three presses of the whole pad through taxels of some gains."""
    rng = np.random.default_rng(seed)
    load = np.tile(np.concatenate([np.zeros(20), np.full(20, 100.0), np.zeros(10)]), 3)
    return Recording({"pad": Pad(load[:, None, None] * gains + rng.normal(0, 0.5, (150, *gains.shape)))})


def test_a_form_that_was_pressed_is_no_even_pressure() -> None:
    rows, cols = np.mgrid[:20, :20] - 9.5
    seat = np.exp(-(rows**2 / 60 + (np.abs(cols) - 5) ** 2 / 20)) + 0.15
    with pytest.raises(
        InputError, match=r"is not even: taxels beside each other read alike \(correlation 0\.9.*bag of"
    ):
        calibrate_even([pressed(seat)])
    slope = 1.0 + 0.3 * cols / 9.5
    assert any("may be those of a press that was not even" in note for note in calibrate_even([pressed(slope)]).notes)


@pytest.mark.parametrize("spread", [0.1, 0.3, 0.6])
def test_gains_that_are_the_taxels_own_are_told_without_a_word(spread: float) -> None:
    rng = np.random.default_rng(3)
    for gains in (
        np.exp(rng.normal(0, spread, (12, 14))),
        np.exp(rng.normal(0, spread, (12, 1))) * np.ones((12, 14)),
    ):
        found = calibrate_even([pressed(gains)])
        assert not any("not even" in note for note in found.notes)


def test_a_rest_that_moves_between_presses_is_told_in_one_line() -> None:
    rng = np.random.default_rng(0)
    load = np.repeat([20.0, 20.0, -5.0], 50) * (np.arange(150) % 50 > 30)
    frames = rng.normal(0, 0.5, (150, 6, 6)) + load[:, None, None]
    with pytest.raises(InputError, match="the rest moves"):
        calibrate_even([Recording({"pad": Pad(frames)})])


def test_a_rest_that_sways_is_told_in_one_line() -> None:
    load = 20 * (np.arange(60) % 50 > 30) + 3 * np.sin(0.3 * np.arange(60))
    frames = np.random.default_rng(0).normal(0, 0.5, (60, 6, 6)) + load[:, None, None]
    with pytest.raises(InputError, match=r"press \d: its readings lie below their rest on the mean: the rest sways"):
        calibrate_even([Recording({"pad": Pad(frames)})])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.22, 0.4), st.floats(0, 2 * np.pi))
def test_a_bag_that_leans_or_bulges_is_asked_about(seed: int, share: float, turn: float) -> None:
    """Its gains are wrong by what goes smoothly over the pad, however unequal its taxels are."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    slope = np.cos(turn) * (x - x.mean()) / np.std(x) + np.sin(turn) * (y - y.mean()) / np.std(y)
    found = calibrate_even([recorded(even(seed, 0.15) * (1 + share * slope / 2))])
    (told,) = (note for note in found.notes if "goes smoothly over the pad" in note or "read alike" in note)
    if "%" in told.split()[0]:
        assert float(told.split("%")[0]) / 100 == pytest.approx(share / 2, abs=0.06)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.02, 0.2))
def test_taxels_that_differ_each_for_itself_are_no_uneven_bag(seed: int, spread: float) -> None:
    shares = [
        float(note.split("%")[0]) / 100
        for note in calibrate_even([recorded(even(seed, spread))]).notes
        if "goes smoothly over the pad" in note
    ]
    # Of many drawn maps one or another leans by chance.
    assert all(share < 0.6 * spread for share in shares)


def test_a_broken_taxel_that_is_marked_by_nan_stops_no_calibration() -> None:
    whole = recorded(even(0))
    works = np.ones(SHAPE, np.bool_)
    works[3, 4] = False
    pad = Pad(np.where(works, whole.pads["pad"].frames, np.nan), valid=works, pitch_m=(PITCH_M, PITCH_M))
    found = calibrate_even([Recording({"pad": pad}, source="r.npz")]).sensor
    known = calibrate_even([Recording({"pad": Pad(whole.pads["pad"].frames, valid=works)})]).sensor
    assert found.gains is not None
    assert known.gains is not None
    assert np.allclose(found.gains[works], known.gains[works])
    assert np.isfinite(found.rest).all()


def test_a_rest_that_moves_is_told_however_high_it_is() -> None:
    still = recorded(even(0)).pads["pad"].frames
    drift = np.linspace(0, 150, len(still))[:, None, None]
    for rest in (0.0, 30000.0):
        with pytest.raises(InputError, match="the rest moves: 120 taxels"):
            calibrate_even([Recording({"pad": Pad(still + drift + rest)}, source="r.npz")])
        assert calibrate_even([Recording({"pad": Pad(still + rest)})]).presses == 3


def test_what_reads_high_unpressed_hides_no_end_of_the_others() -> None:
    frames = recorded(even(1), most=600.0, kind=np.uint16).pads["pad"].frames.copy()
    frames[2, 0, 0] = 65535
    frames[:, 5, 5] = 4095
    with pytest.raises(InputError, match="taxels read exactly 600 and none more: they are saturated"):
        calibrate_even([Recording({"pad": Pad(frames)})])


def test_taxels_that_all_end_alike_are_told_without_noise_too() -> None:
    top = recorded(np.full((3, *SHAPE), 255.0), 0.0, kind=np.uint8)
    with pytest.raises(InputError, match="120 of 120 taxels read exactly 255 and none more: they are saturated"):
        calibrate_even([top])
    # Taxels that are alike at every load are so without an end.
    alike = recorded(np.array([80.0, 160.0, 240.0])[:, None, None] * np.ones(SHAPE), 0.0, kind=np.uint8)
    assert np.array_equal(calibrate_even([alike]).sensor.gains, np.ones(SHAPE))


def test_what_noise_leaves_behind_a_press_is_no_press() -> None:
    """The two frames after a release whose load happens to rise are a part of the run, and none of its presses."""
    rng = np.random.default_rng(5)
    load = np.array([0, 0, 0, 40, 80, 100, 100, 80, 40, 0.9, 1.0, 0, 0, 0])
    frames = np.tile(load, 30)[:, None, None] * np.ones((8, 8)) + rng.normal(0, 1.5, (14 * 30, 8, 8))
    assert presses_of([Recording({"pad": Pad(frames)})], Sensor()).n == 30
    runs = [range(4), range(4, 6)]
    pad = Pad(np.concatenate([np.full((4, 8, 8), 50.0), np.full((2, 8, 8), 0.1)]))
    assert _pressed(pad, runs, np.zeros((8, 8)), 1.0) == runs[:1]
    assert _pressed(pad, runs, np.zeros((8, 8)), 0.001) == runs
    assert _pressed(pad, runs, None, 1.0) == runs
    assert _pressed(pad, runs, np.full((8, 8), 60.0), 1.0) == runs


def test_presses_that_are_no_more_alike_with_their_pressures_are_told_other_causes() -> None:
    frames = np.minimum(even(2, 0.3), 500.0) + np.random.default_rng(1).normal(0, 3, (3, *SHAPE))
    with pytest.raises(InputError, match="in a line: then give the pressures"):
        calibrate_even([recorded(frames)])
    with pytest.raises(InputError, match="readings end below the strongest: then leave out what reaches it"):
        calibrate_even([recorded(frames)], pressure_pa=[400, 700, 1000])


def test_an_even_pressure_is_no_ball() -> None:
    flat = np.array([300, 600, 900, 400, 500, 800])[:, None, None] * np.ones(SHAPE)
    with pytest.raises(InputError, match=r"r\.npz: is not of a ball of 0\.012 m: .* cover the whole pad"):
        calibrate_objects([recorded(flat)], [KnownObject("ball", 0.012)])


def test_forces_of_other_presses_are_refused() -> None:
    recording, options = by_tips(3, 150)
    forces = options["force_n"]
    assert calibrate_scale([recording], force_n=forces).presses == 150
    # As many as there are, from the second one on.
    with pytest.raises(InputError, match=r"the forces are not those of the presses.*correlation -?0\.\d\d"):
        calibrate_scale([recording], force_n=np.roll(forces, -1))


def test_known_gains_are_kept_where_presses_of_anything_tell_none() -> None:
    rng = np.random.default_rng(2)
    y, x = np.indices(SHAPE)
    places = rng.uniform((0, 0), SHAPE, (80, 2))[:, :, None, None]
    bumps = 800 * np.exp(-((y - places[:, 0]) ** 2 + (x - places[:, 1]) ** 2) / 18)
    bumps[:, 4, 6] = 0.0
    known = Sensor(gains=1 + 0.01 * rng.standard_normal(SHAPE))
    found = calibrate_unlabelled([recorded(bumps)], sensor=known)
    assert any("were not applied" in note for note in found.notes)
    works = np.ones(SHAPE, np.bool_)
    works[4, 6] = False
    assert found.sensor.gains is not None
    assert known.gains is not None
    assert np.array_equal(found.sensor.gains, np.where(works, known.gains, 0.0))
    uneven = calibrate_unlabelled([recorded(bumps * even(3)[2] / 1000)], sensor=known)
    assert "the gains that were known are left: these take their place" in uneven.notes


def test_readings_that_end_under_a_ball_are_no_response_that_bends() -> None:
    ball, pad = KnownObject("ball", 0.02), Points((16, 16), (PITCH_M, PITCH_M))
    rng = np.random.default_rng(4)
    places = np.stack([*rng.uniform(-0.004, 0.004, (2, 10)), rng.uniform(5e-4, 3e-3, 10)], axis=1)
    faces = np.array([ball.stress(place, pad) for place in places])
    frames = 900 * faces / faces.max()
    found = calibrate_objects([recorded(frames)], [ball])
    assert "the response is linear, as far as these presses tell" in found.notes
    with pytest.raises(InputError, match="taxels read exactly 500 and none more: they are saturated"):
        calibrate_objects([recorded(frames, most=500.0)], [ball])
