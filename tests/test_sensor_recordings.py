"""Recordings through a sensor file: turned upright once, refused where the file and the readings contradict."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold.cli.recordings import read_recording
from varishold.errors import InputError
from varishold.recording import Pad, Recording, read, write
from varishold.sensor import Sensor, upright_recording


def press(n: int = 20, peak: float = 200.0) -> NDArray[np.float64]:
    """Return a press that comes and goes on a pad of 8 x 8."""
    y, x = np.mgrid[:8, :8]
    bump = np.maximum(1 - np.hypot(x - 3.5, y - 3.5) / 3, 0)
    course = peak * np.sin(np.linspace(0, np.pi, n))
    return np.asarray(course[:, None, None] * bump)


@pytest.mark.parametrize("kind", [np.uint8, np.float64])
def test_a_sensor_that_goes_down_is_turned(kind: Any) -> None:
    frames = press()
    raw = np.round(240 - frames).astype(kind)
    sensor = Sensor(name="finger", polarity="down", rest=240, pitch_m=2e-3)  # type: ignore[arg-type]
    turned = upright_recording(Recording({"pad": Pad(raw)}), sensor)
    pad = turned.pads["pad"]
    assert np.array_equal(pad.frames, 240.0 - raw)
    assert (pad.frames.dtype.kind == "i") == (kind is np.uint8)
    assert pad.pitch_m == (2e-3, 2e-3)
    assert turned.sensor == "finger"


def test_a_sensor_without_rest_changes_nothing() -> None:
    pad = Pad(press())
    turned = upright_recording(Recording({"pad": pad}), Sensor()).pads["pad"]
    assert np.shares_memory(turned.frames, pad.frames)


def test_a_recording_that_is_negative_is_read_with_a_sensor_that_goes_down(tmp_path: Path) -> None:
    np.savez(tmp_path / "down.npz", pressure=-press())
    with pytest.raises(InputError, match=r"mostly negative.*polarity = 'down'"):
        read(tmp_path / "down.npz")
    recording = read(tmp_path / "down.npz", polarity="down")
    turned = upright_recording(recording, Sensor(polarity="down"))
    assert np.array_equal(turned.pads["pad"].frames, press())


@pytest.mark.parametrize(
    ("raw", "sensor"),
    [
        (240 - press(), Sensor(polarity="up", rest=0.0)),
        (240 - press(), Sensor(polarity="up", rest=240.0)),
        (press(), Sensor(polarity="down", rest=255.0)),
        (press(), Sensor(polarity="down", rest=0.0)),
        (10 + press(), Sensor(polarity="down", rest=10.0)),
    ],
)
def test_a_contradictory_polarity_is_told_in_one_line(raw: NDArray[np.float64], sensor: Sensor) -> None:
    right = "down" if sensor.polarity == "up" else "up"
    with pytest.raises(InputError, match=f"go the other way under load; polarity = '{right}'") as caught:
        upright_recording(Recording({"pad": Pad(raw)}), sensor)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "raw",
    [
        press(),
        press() + np.random.default_rng(0).normal(0, 2, (20, 8, 8)),
        press()[8:],
        np.random.default_rng(0).normal(0, 2, (20, 8, 8)),
        np.full((5, 8, 8), 100.0),
        press()[10:11],
    ],
)
def test_no_polarity_is_doubted_without_reason(raw: NDArray[np.float64]) -> None:
    upright_recording(Recording({"pad": Pad(raw)}), Sensor())
    upright_recording(Recording({"pad": Pad(240 - raw)}), Sensor(polarity="down", rest=240.0))


def test_another_shape_is_told_in_one_line() -> None:
    with pytest.raises(InputError, match="is for 16 x 16 taxels, pad 'pad' of the recording has 8 x 8"):
        upright_recording(Recording({"pad": Pad(press())}), Sensor(shape=(16, 16)))


def test_taxels_without_gain_are_marked() -> None:
    gains = np.ones((8, 8))
    gains[2, 3] = np.nan
    valid = np.ones((8, 8), np.bool_)
    valid[0, 0] = False
    pad = upright_recording(Recording({"pad": Pad(press(), valid=valid)}), Sensor(gains=gains)).pads["pad"]
    assert pad.valid is not None
    assert np.argwhere(~pad.valid).tolist() == [[0, 0], [2, 3]]


def test_taxels_on_no_grid_are_read_and_written(tmp_path: Path) -> None:
    positions = np.array([[0.0, 0.0], [1e-3, 0.0], [0.5e-3, 0.9e-3], [1.5e-3, 0.9e-3]])
    frames = np.arange(12.0).reshape(3, 4)
    np.savez(
        tmp_path / "patch.npz",
        **{"pressure.tip": frames, "positions_m.tip": positions, "valid.tip": [True, True, False, True]},
    )
    pad = read(tmp_path / "patch.npz").pads["tip"]
    assert pad.shape == (1, 4)
    assert np.array_equal(pad.frames[:, 0], frames)
    assert np.array_equal(pad.positions_m, positions)  # type: ignore[arg-type]
    write(read(tmp_path / "patch.npz"), tmp_path / "again.npz")
    again = read(tmp_path / "again.npz").pads["tip"]
    assert np.array_equal(again.frames, pad.frames)
    assert np.array_equal(again.positions_m, positions)  # type: ignore[arg-type]
    assert np.array_equal(again.valid, pad.valid)  # type: ignore[arg-type]


def test_positions_that_do_not_fit_are_told() -> None:
    with pytest.raises(InputError, match=r"positions_m must be finite \(x, y\) of each of 4 taxels in one row"):
        Pad(np.ones((3, 1, 4)), positions_m=np.ones((3, 2)))


@pytest.mark.parametrize("ending", ["npz", "npy", "csv"])
def test_a_sensor_of_positions_tells_that_frames_are_rows_of_readings(tmp_path: Path, ending: str) -> None:
    rows = np.random.default_rng(0).integers(0, 200, (9, 12))
    file = tmp_path / f"skin.{ending}"
    if ending == "npz":
        np.savez(file, pressure=rows)
    elif ending == "npy":
        np.save(file, rows)
    else:
        np.savetxt(file, rows, delimiter=",", fmt="%d")
    positions = [[1e-3 * (k % 4) + 5e-4 * (k // 4 % 2), 1e-3 * (k // 4)] for k in range(12)]
    (pad,) = read_recording(str(file), Sensor(positions_m=np.array(positions))).pads.values()
    assert pad.shape == (1, 12)
    assert np.array_equal(pad.frames[:, 0], rows)
