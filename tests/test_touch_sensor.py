"""Touch through a sensor file: what it says is undone, named in every answer, and told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from varishold.cli.app import app
from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.sensor import Logarithmic, Sensor, Skin, write_sensor
from varishold.touch import find_contacts, recognize, recognize_recording


def cone(n: int = 24, radius: float = 9.0) -> NDArray[np.float64]:
    y, x = np.mgrid[:n, :n] - (n - 1) / 2
    return np.asarray(np.maximum(1 - np.hypot(x, y) / radius, 0.0))


def course(frame: NDArray[np.float64], noise: float = 0.0) -> NDArray[np.float64]:
    """Return a press with unloaded frames before and after."""
    load = np.concatenate([np.zeros(10), np.sin(np.linspace(0.1, np.pi - 0.1, 21)), np.zeros(10)])
    rng = np.random.default_rng(3)
    return load[:, None, None] * frame + rng.normal(0, noise, (load.size, *frame.shape))


MAT = Sensor(
    name="mat",
    shape=(24, 24),
    pitch_m=2e-3,  # type: ignore[arg-type]
    polarity="down",
    rest=1000.0,
    span=900.0,
    response=Logarithmic(8.0),
    gains=np.random.default_rng(1).normal(1.0, 0.2, (24, 24)).clip(0.3),
    crosstalk=0.03,
    saturation=1.5,
)


def test_contacts_of_readings_are_those_of_the_stress() -> None:
    stress = 900 * cone()
    (true,) = find_contacts(stress, 16, pitch=2e-3, floor=50.0)
    (read,) = find_contacts(MAT.forward(stress), 16, floor=50.0, sensor=MAT)
    assert np.allclose(read.profile.area, true.profile.area)
    assert read.pitch == (2e-3, 2e-3)
    assert recognize(read).name == recognize(true).name == "cone"
    assert read.state.saturated == read.state.repaired == 0


def test_the_default_floor_stands_clear_of_the_noise_of_readings() -> None:
    readings = MAT.forward(900 * cone()) + np.random.default_rng(0).normal(0, 4.0, (24, 24))
    (contact, *specks) = find_contacts(readings, sensor=MAT)
    assert contact.floor >= 2 * MAT.least_stress(4.0)
    assert len(specks) <= 2


def test_what_is_saturated_repaired_and_cut_is_in_the_state() -> None:
    gains = np.ones((24, 24))
    gains[12, 9] = 0.0
    sensor = Sensor(span=255, gains=gains, saturation=0.7, dead_band=0.1)
    readings = np.roll(sensor.forward(255 * cone()), -8, axis=1)
    (contact,) = find_contacts(readings[:, :20], floor=5.0, sensor=Sensor(span=255, saturation=0.7, dead_band=0.1))
    valid = np.ones((24, 20), np.bool_)
    valid[12, 6] = valid[0, 19] = False
    (state,) = [
        c.state
        for c in find_contacts(
            readings[:, :20], floor=5.0, valid=valid, sensor=Sensor(span=255, saturation=0.7, dead_band=0.1)
        )
    ]
    assert state.repaired == 1
    assert state.saturated > 10
    assert state.cut.left
    assert not state.cut.right
    assert state.beneath == pytest.approx(25.5)
    assert contact.peak == pytest.approx(0.7 * 0.9 * 255)


def test_a_gap_of_nan_is_no_taxel_with_a_sensor_as_without() -> None:
    frame = 900 * cone()
    frame[:3, :3] = np.nan
    readings = np.where(np.isnan(frame), np.nan, MAT.forward(np.nan_to_num(frame)))
    (contact,) = find_contacts(readings, floor=50.0, sensor=MAT)
    assert not contact.field[:3, :3].any()
    assert contact.field.sum() == 24 * 24 - 9


def test_taxels_on_no_grid_are_resampled_with_and_without_a_sensor() -> None:
    rng = np.random.default_rng(0)
    spots = np.array([(x + 0.5 * (row % 2), row * np.sqrt(3) / 2) for row in range(24) for x in range(20)]) * 1e-3
    spots += rng.normal(0, 2e-5, spots.shape)
    away = np.hypot(*(spots - spots.mean(axis=0)).T)
    readings = np.maximum(1 - away / 8e-3, 0.0)
    pad = Pad(course(readings[None], 0.002), positions_m=spots)
    for sensor in (None, Sensor(name="patch", positions_m=spots), Sensor(name="patch")):
        (answer,) = recognize_recording(Recording({"tip": pad}), sensor=sensor)
        assert answer.surface.name == "cone"
        assert answer.surface.contact.pitch is not None
        assert answer.to_dict()["area_m2"] == pytest.approx(np.pi * 8e-3**2, rel=0.15)
        assert sum("480 taxels on no grid are resampled to" in note for note in answer.frame_notes) == 1


def test_the_sensor_is_named_in_every_answer_and_gives_unit_and_cover() -> None:
    sensor = Sensor(
        name="mat",
        shape=(24, 24),
        pitch_m=2e-3,
        span=900.0,
        full_scale=2e4,
        unit="Pa",  # type: ignore[arg-type]
        cover=Skin("layer", 4e-3, 0.45, 1e-3),
        dead_band=0.1,
    )
    raw = Recording({"pad": Pad(sensor.forward(2e4 * course(cone())))})
    (answer,) = recognize_recording(raw, sensor=sensor)
    said = answer.to_dict()
    assert said["sensor"] == "mat"
    assert said["frame_notes"][0] == "sensor mat"
    assert answer.unit == "Pa"
    pressed = 2e4 * cone()
    inside = pressed - answer.surface.contact.state.beneath > answer.surface.contact.floor
    assert said["force_n"] == pytest.approx(pressed[inside].sum() * (2e-3) ** 2, rel=1e-6)
    with pytest.raises(InputError, match="is for 24 x 24 taxels"):
        next(recognize_recording(Recording({"pad": Pad(np.ones((3, 8, 8)))}), sensor=sensor))


def _touch(*words: str) -> list[dict[str, object]]:
    result = CliRunner().invoke(app, ["touch", *words, "--json"], catch_exceptions=False)
    assert result.exit_code == 0
    return [json.loads(line) for line in result.stdout.splitlines()]


def test_the_command_finds_a_sensor_file_and_takes_one(tmp_path: Path) -> None:
    readings = np.round(MAT.forward(900 * course(cone()))).astype(np.int16)
    np.savetxt(tmp_path / "press.csv", readings.reshape(len(readings), -1), fmt="%d", delimiter=",")
    press = str(tmp_path / "press.csv")
    refused = CliRunner().invoke(app, ["touch", press])
    assert isinstance(refused.exception, InputError)
    write_sensor(MAT, tmp_path / "other.toml")
    (answer,) = _touch(press, "--sensor", str(tmp_path / "other.toml"))
    assert answer["name"] == "cone"
    assert answer["sensor"] == f"mat ({tmp_path / 'other.toml'})"
    write_sensor(MAT, tmp_path / "press.sensor.toml")
    (found,) = _touch(press)
    assert found["name"] == "cone"
    assert found["sensor"] == f"mat ({tmp_path / 'press.sensor.toml'})"
    assert f"sensor {found['sensor']}" in found["frame_notes"]  # type: ignore[operator]
    page = tmp_path / "page.html"
    _touch(press, "--report", str(page))
    assert "press.sensor.toml" in page.read_text()


def test_a_skin_file_goes_before_the_cover_of_the_sensor_file(tmp_path: Path) -> None:
    cover = Skin("layer", 4e-3, 0.45, 1e-3)
    write_sensor(Sensor(name="mat", pitch_m=2e-3, cover=cover), tmp_path / "sensor.toml")  # type: ignore[arg-type]
    np.savez(tmp_path / "press.npz", pressure=course(cone(), 0.003))
    (with_cover,) = _touch(str(tmp_path / "press.npz"), "--exact")
    (tmp_path / "skin.toml").write_text('[skin]\nkind = "winkler"\nthickness_m = 1e-3\n')
    (with_skin,) = _touch(str(tmp_path / "press.npz"), "--exact", "--skin", str(tmp_path / "skin.toml"))
    assert with_cover["sensor"] == with_skin["sensor"]
    assert with_cover["reasons"] != with_skin["reasons"]


def test_a_preset_is_taken_by_name_and_another_shape_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "press.npz", pressure=course(cone()))
    result = CliRunner().invoke(app, ["touch", str(tmp_path / "press.npz"), "--sensor", "flexitac"])
    assert "24 x 24, not 12 x 32" in str(result.exception)
    assert "\n" not in str(result.exception)


@pytest.mark.parametrize("whole", [False, True])
def test_a_rest_that_drifted_since_the_sensor_was_calibrated_is_zeroed(whole: bool) -> None:
    rng = np.random.default_rng(3)
    force = np.r_[np.zeros(10), np.linspace(0.2, 1, 4), np.ones(6)][:, None, None]
    stress = 80.0 * force * cone() / cone().max()
    drift = rng.uniform(0, 40, cone().shape)
    readings = MAT.forward(stress) - drift + rng.normal(0, 1.0, stress.shape)
    readings = np.round(readings).astype(np.int32) if whole else readings
    pad = Pad(readings, pitch_m=0.002)
    (answer,) = recognize_recording(Recording({"pad": pad}), sensor=MAT)
    assert "zeroed on frames 0 to 9, before the first touch" in answer.frame_notes
    assert answer.surface.name == "cone"
    ideal = find_contacts(stress[-1], pitch=0.002)[0]
    assert answer.surface.contact.peak == pytest.approx(ideal.peak, rel=0.1)


@pytest.mark.parametrize("sensor", [Sensor(span=900.0), Sensor(response=Logarithmic(8.0), span=900.0)])
def test_a_broken_taxel_that_is_marked_by_nan_is_filled_and_told(sensor: Sensor) -> None:
    frame = sensor.forward(900 * cone())
    works = np.ones(frame.shape, bool)
    works[12, 12] = works[9, 11] = False
    holed = np.where(works, frame, np.nan)
    (filled,) = find_contacts(holed, valid=works, sensor=sensor)
    assert filled.state.repaired == 2
    assert not any(filled.state.cut)
    (absent,) = find_contacts(holed, sensor=sensor)
    assert absent.state.repaired == 0
    assert absent.n_taxels == filled.n_taxels - 2
    (answer,) = recognize_recording(Recording({"pad": Pad(holed[None], valid=works)}), sensor=sensor)
    assert "2 broken taxels filled from the neighbours" in answer.frame_notes


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int64])
def test_a_reading_beyond_all_stress_is_named(kind: type) -> None:
    sensor = Sensor(response=Logarithmic(5.0), span=900.0)
    frames = np.stack([900 * cone()] * 2).astype(kind)
    frames[1, 3, 4] = 10**7
    beyond = r"the reading at \(row, col\) = \(3, 4\) is 11111.1 times the span: behind a logarithmic response"
    with pytest.raises(InputError, match=beyond):
        find_contacts(frames[1], sensor=sensor)
    with pytest.raises(InputError, match="frame 1 of pad 'pad': the reading at"):
        list(recognize_recording(Recording({"pad": Pad(frames)}), frames="all", sensor=sensor))
    works = np.ones(frames[1].shape, bool)
    works[3, 4] = False
    (contact,) = find_contacts(frames[1], valid=works, sensor=sensor)
    assert recognize(contact).name == "cone"


@pytest.mark.parametrize("sensor", [None, Sensor(response=Logarithmic(5.0), span=1.0), Sensor(span=1.0)])
def test_a_frame_beyond_what_can_be_measured_is_refused_in_one_line(sensor: Sensor | None) -> None:
    with pytest.raises(InputError, match=r"a frame must be within \+-1e\+100, got 1e\+300 at \(row, col\) = \(0, 1\)"):
        find_contacts([[0.0, 1e300], [0.0, 0.0]], sensor=sensor)
    assert find_contacts(1e-310 * cone(), sensor=sensor) == []


@pytest.mark.parametrize(("polarity", "rest"), [("up", 500), ("down", 1023)])
def test_counts_of_which_stress_is_one_each_stay_whole(polarity: str, rest: int) -> None:
    counts = np.arange(0, 150).reshape(10, 15)
    sensor = Sensor(polarity=polarity, rest=rest, span=150, saturation=0.9)  # type: ignore[arg-type]
    raw = rest + counts if polarity == "up" else rest - counts
    assert np.array_equal(sensor.undo(raw).frame, np.minimum(counts, 135))
