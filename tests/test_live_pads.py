"""A pad as its source and its sensor say it is: which way its readings go, its noise, its shape."""

from __future__ import annotations

import numpy as np
import pytest
from tests.live_scripted import Scripted, sample, wait_until

from varishold.frame.noise import ROUNDING
from varishold.live import (
    PadLayout,
)
from varishold.live.pad_watcher import PadWatcher
from varishold.live.session import Session
from varishold.sensor import Sensor


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
