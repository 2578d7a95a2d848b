"""A pad as its source and its sensor say it is: which way its readings go, its noise, its shape."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from tests.live_scripted import Scripted, sample, wait_until

from varishold.errors import InputError
from varishold.frame.noise import ROUNDING
from varishold.live import PadLayout
from varishold.live.pad_watcher import PadWatcher, grid_of
from varishold.live.session import Session
from varishold.sensor import Logarithmic, Sensor
from varishold.touch import find_contacts


@pytest.mark.parametrize("whole", [False, True])
def test_whole_numbers_have_the_noise_of_rounding_at_least(whole: bool) -> None:
    pad = PadWatcher("pad", PadLayout((6, 6)), whole=whole)
    rng = np.random.default_rng(0)
    for k in range(300):
        pad.see(k / 100, 20 + (np.zeros((6, 6)) if whole else rng.normal(0, 1e-3, (6, 6))))
    noise = float(np.median(pad.zero.noise))
    assert noise >= ROUNDING if whole else noise < 0.1 * ROUNDING


def test_readings_stand_upright_whatever_way_they_go() -> None:
    raw = np.array([[10, 20, 30], [40, 50, 60]], np.uint8)

    def upright(layout: PadLayout, sensor: Sensor | None = None) -> list[list[float]]:
        return PadWatcher("pad", layout, sensor=sensor)._upright(raw).tolist()  # type: ignore[no-any-return]

    assert upright(PadLayout((2, 3))) == raw.tolist()
    assert upright(PadLayout((2, 3), polarity="down")) == (-raw.astype(float)).tolist()
    assert upright(PadLayout((2, 3)), Sensor(rest=5.0)) == (raw - 5.0).tolist()
    # A sensor that is known goes before what the source says.
    down = Sensor(polarity="down", rest=70.0, span=70.0)
    assert (
        upright(PadLayout((2, 3)), down) == upright(PadLayout((2, 3), polarity="down"), down) == (70.0 - raw).tolist()
    )


def test_a_pad_is_what_the_source_says_and_the_sensor_fills_in() -> None:
    layout = PadLayout((2, 3), gaps=(5,), broken=(0, 4), unit="kPa")
    bare = PadWatcher("pad", layout)
    assert np.flatnonzero(~bare.field).tolist() == [5]
    assert np.flatnonzero(~bare.sound).tolist() == [0, 4]
    assert (bare.shape, bare.unit, bare.pitch_m) == ((2, 3), "kPa", None)
    sensor = Sensor(pitch_m=(0.003, 0.003))
    given = PadWatcher("pad", layout, sensor=sensor)
    assert (given.unit, given.pitch_m) == ("kPa", (0.003, 0.003))
    told = PadWatcher("pad", PadLayout((2, 3), pitch_m=(0.001, 0.001)), sensor=sensor)
    assert told.pitch_m == (0.001, 0.001)
    # Signals have no sensor of pressure, and taxels on no grid stand in a row.
    signals = PadWatcher("field", PadLayout((6,), "signals", unit="T"), sensor=sensor)
    assert (signals.shape, signals.pitch_m, signals.unit) == ((1, 6), None, "T")


def test_noise_is_asked_for_seldom_and_is_that_of_the_usual_taxel() -> None:
    pad = PadWatcher("pad", PadLayout((2, 3), gaps=(5,)))
    asked: list[int] = []
    sigmas: list[float] = []

    class Zero:
        @property
        def noise(self) -> np.ndarray:
            asked.append(len(sigmas))
            return np.array([[1.0, 2.0, 3.0], [4.0, 90.0, 1e9]]) * (1 + len(sigmas))

    pad.zero = Zero()  # type: ignore[assignment]
    for _ in range(160):
        sigmas.append(pad._sigma())
    assert asked[0] == 0
    assert 8 <= len(asked) <= 12
    assert [sigmas[at] for at in asked] == [3.0 * (1 + at) for at in asked]


def test_pads_of_a_session_are_those_of_its_source() -> None:
    source = Scripted()
    source.pads = {"left": PadLayout((2, 3), unit="kPa")}
    source.script.put(sample(0)._replace(pads={"left": np.ones((2, 3))}))
    with Session(source) as its:
        wait_until(lambda: its.newest is not None)
        assert its.newest is not None
        assert its.newest.pads["left"].unit == "kPa"
        assert its.status()["zero"] == {"left": "starting"}


# What touches is what is found in the readings themselves.

SPOTS = np.array([[0.002 * (k % 7), 0.0023 * (k // 7)] for k in range(56)])
PITCH = (0.002, 0.003)


def _cases() -> dict[str, tuple[PadLayout, Sensor | None]]:
    gains = np.linspace(0.6, 1.4, 8 * 12).reshape(8, 12)
    down = Sensor(polarity="down", rest=900.0, span=800.0, shape=(8, 12), pitch_m=(0.004, 0.004), unit="kPa")
    return {
        "plain": (PadLayout((8, 12)), None),
        "unit and pitch": (PadLayout((8, 12), pitch_m=PITCH, unit="kPa"), None),
        "gaps": (PadLayout((8, 12), pitch_m=PITCH, gaps=(0, 11, 53)), None),
        "broken": (PadLayout((8, 12), broken=(41, 42, 95)), None),
        "downward": (PadLayout((8, 12), polarity="down"), None),
        "gains": (PadLayout((8, 12), pitch_m=PITCH, gaps=(3,)), Sensor(shape=(8, 12), gains=gains, span=500.0)),
        "dead band": (
            PadLayout((8, 12), broken=(7,)),
            Sensor(shape=(8, 12), span=500.0, dead_band=0.1, full_scale=5.0),
        ),
        "sensor downward": (PadLayout((8, 12), polarity="down"), down),
        "no grid": (PadLayout((56,), broken=(30,)), Sensor(positions_m=SPOTS, span=500.0)),
        "no grid and gaps": (PadLayout((56,), gaps=(0, 55)), Sensor(positions_m=SPOTS, span=500.0)),
    }


def _reading(layout: PadLayout, sensor: Sensor | None, k: int, rng: np.random.Generator) -> np.ndarray:
    rows, cols = grid_of(layout.shape)
    y, x = np.mgrid[:rows, :cols] if rows > 1 else (SPOTS[None, :, 1] / 0.0023, SPOTS[None, :, 0] / 0.002)
    up = 100 + rng.normal(0, 1, (rows, cols)) + 120 * (k >= 140) * np.exp(-((x - 3) ** 2 + (y - 4) ** 2) / 6)
    down = layout.polarity == "down" or (sensor is not None and sensor.polarity == "down")
    return np.asarray((1000 - up if down else up).reshape(layout.shape))


@pytest.mark.parametrize("name", _cases())
@pytest.mark.parametrize("nan", [False, True])
def test_what_touches_is_what_is_found_in_the_readings(name: str, nan: bool) -> None:
    layout, sensor = _cases()[name]
    pad, rng, kinds = PadWatcher("pad", layout, sensor=sensor, levels=12), np.random.default_rng(5), []
    shape = grid_of(layout.shape)
    field, sound = (np.array([k not in at for k in range(np.prod(shape))]) for at in (layout.gaps, layout.broken))
    field, sound = field.reshape(shape), sound.reshape(shape)
    upright = None if sensor is None else sensor.upright()
    free = held = 0
    for k in range(190):
        raw = _reading(layout, sensor, k, rng)
        if nan and k > 100:
            raw.ravel()[17 if k % 2 else 20] = (math.nan, math.inf)[k % 2]
        seen = pad.see(k / 100, raw)
        kinds += [event.kind for event in seen.events]
        assert seen.raw is raw
        assert seen.zeroed.shape == shape
        if pad.zero.state == "starting":
            assert (seen.tracks, seen.sigma) == ((), None)
            continue
        assert seen.sigma is not None
        works = sound & np.isfinite(raw.reshape(shape))
        zeroed = seen.zeroed
        valid = None if works.all() else works
        # Taxels on no grid have no field on the grid that is made of them.
        inside = None if len(layout.shape) == 1 or field.all() else field
        found = find_contacts(
            zeroed, 12, pitch=layout.pitch_m, valid=valid, field=inside, sigma=seen.sigma, sensor=upright
        )
        its = [track.contact for track in seen.tracks if track.state != "lost"]
        if not found:
            free += 1
            assert seen.tracks == () or its == []
            expected = zeroed if upright is None else upright.undo(zeroed).frame
            assert np.array_equal(seen.frame, expected, equal_nan=True)
            continue
        held += 1
        assert len(its) <= len(found)
        for contact, other in zip(its, found, strict=False):
            assert np.array_equal(contact.profile.threshold, other.profile.threshold)
            assert np.array_equal(contact.profile.area, other.profile.area, equal_nan=True)
            assert (contact.pitch, contact.window, contact.sigma) == (other.pitch, other.window, other.sigma)
        assert np.array_equal(seen.frame, found[0].frame.padded[1:-1, 1:-1], equal_nan=True)
    assert free >= 30
    assert held >= 45
    assert kinds[:1] == ["touched"]
    # The noise is that of the usual taxel, as the sensor lets it appear.
    noise = float(np.median(pad.zero.noise[field]))
    assert seen.sigma == pytest.approx(noise if upright is None else upright.least_stress(noise), rel=0.1)
    unit = layout.unit if sensor is None or sensor.unit == "raw" else sensor.unit
    assert (seen.unit, seen.layout, seen.name) == (unit, layout, "pad")
    assert (seen.sensor is None, seen.notes == ()) == (sensor is None, sensor is None)


def test_a_sensor_of_another_shape_is_told() -> None:
    with pytest.raises(InputError, match=r"^mat is for 8 x 12 taxels, pad 'left' has 12 x 8$"):
        PadWatcher("left", PadLayout((12, 8)), sensor=Sensor(name="mat", shape=(8, 12)))
    with pytest.raises(InputError, match=r"^the sensor is for 1 x 56 taxels, pad 'left' has 1 x 55$"):
        PadWatcher("left", PadLayout((55,)), sensor=Sensor(positions_m=SPOTS))


def test_of_signals_only_what_needs_no_comparison_is_told() -> None:
    pad, pressure = PadWatcher("a", PadLayout((5,), "signals")), PadWatcher("a", PadLayout((5,)))
    bad = tuple(SimpleNamespace(word=word) for word in ("stuck", "noisy", "impulses", "dead", "no number"))

    @dataclass(frozen=True)
    class Report:
        bad: tuple[object, ...]
        open_rows: tuple[int, ...]
        open_cols: tuple[int, ...]

    report = Report(bad, (1,), (2,))
    for each in (pad, pressure):
        each.health = SimpleNamespace(report=lambda: report)  # type: ignore[assignment]
    assert pressure.how_it_is() is report  # type: ignore[comparison-overlap]
    assert pad.how_it_is() == Report((bad[0], bad[2], bad[4]), (), ())  # type: ignore[comparison-overlap]


@pytest.mark.parametrize("reading", [1e7, 1e300, math.inf, math.nan])
def test_a_reading_that_stands_for_no_number_is_not_believed(reading: float) -> None:
    pad = PadWatcher("pad", PadLayout((12, 12)), sensor=Sensor(response=Logarithmic(5.0), span=700.0))
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:12, :12] - 5.5
    bump = 600 * np.maximum(1 - np.hypot(x, y) / 4, 0)
    kinds = []
    for k in range(150):
        frame = bump * (40 < k < 100) + rng.normal(0, 2, bump.shape)
        if k in (30, 60, 120):
            frame[5, 6] = reading
        seen = pad.see(k / 50, frame)
        kinds += [event.kind for event in seen.events]
        assert np.isfinite(seen.frame).all()
    assert kinds.count("touched") == kinds.count("released") == 1
