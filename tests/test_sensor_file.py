"""The sensor file: what is written comes back, what is wrong is told in one line, presets are sensors."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from varishold.errors import FormatError, InputError
from varishold.sensor import (
    PRESETS,
    Logarithmic,
    Sensor,
    Skin,
    Table,
    find_sensor_file,
    read_sensor,
    sensor_of,
    write_sensor,
)


def _same(one: Sensor, other: Sensor) -> None:
    for field in dataclasses.fields(Sensor):
        if field.name in ("source",):
            continue
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            assert np.array_equal(a, b, equal_nan=True), field.name
        else:
            assert a == b, field.name


@pytest.mark.parametrize(
    "sensor",
    [
        Sensor(),
        Sensor(
            name='a "mat"\n',
            shape=(3, 4),
            pitch_m=(1e-3, 2e-3),
            field=np.arange(12).reshape(3, 4) > 0,
            polarity="down",
            rest=np.arange(12.0).reshape(3, 4) / 3,
            span=200.0,
            full_scale=3e4,
            unit="Pa",
            response=Logarithmic(5.0),
            gains=np.where(np.arange(12) == 5, np.nan, 1 / 3).reshape(3, 4),
            dead_band=0.1,
            saturation=0.9,
            crosstalk=0.04,
            blur_taxels=0.5,
            cover=Skin("layer", 6e-3, 0.45, 1e-3),
            third_party=True,
            notes="élastique",
            calibration={"kind": "even", "presses": 3, "error": 0.01, "left": ["response"], "sure": True},
        ),
        Sensor(span=2.0, response=Table([0, 0.25, 1], [0, 0.5, 1]), rest=7.0),
        Sensor(positions_m=np.array([[0, 0], [1e-3, 0], [0.5e-3, 1e-3]]), gains=np.array([1.0, 2.0, 3.0])),
    ],
)
def test_what_is_written_comes_back(tmp_path: Path, sensor: Sensor) -> None:
    path = tmp_path / "mat.toml"
    written = write_sensor(sensor, path)
    assert written[-1] == path
    assert all(each.is_file() for each in written)
    back = read_sensor(path)
    assert back.source == str(path)
    _same(sensor, back)


@pytest.mark.parametrize("ending", ["npz", "npy", "csv"])
def test_a_gain_map_is_read_from_beside_the_file(tmp_path: Path, ending: str) -> None:
    gains = np.array([[1.0, 0.5], [2.0, 1.25]])
    path = tmp_path / f"gains.{ending}"
    if ending == "npz":
        np.savez(path, gains=gains, other=1)
    elif ending == "npy":
        np.save(path, gains)
    else:
        np.savetxt(path, gains, delimiter=";")
    (tmp_path / "sensor.toml").write_text(f'gain_map = "gains.{ending}"\n')
    assert np.array_equal(read_sensor(tmp_path / "sensor.toml").gains, gains)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("colour = 'red'", "unknown key colour in the file; known are name, shape"),
        ("name = 3", "name must be a text, got 3"),
        ("third_party = 1", "third_party must be true or false"),
        ("response = 'linear'", "response must be a table, [response]"),
        ("[response]\nkind = 'cubic'", "[response] needs kind, one of linear, power, logarithmic, table, got 'cubic'"),
        ("span = 1\n[response]\nkind = 'power'", "[response] of kind 'power' needs exponent"),
        ("span = 1\n[response]\nkind = 'power'\na = 2", "unknown key a in [response]; known are kind, exponent"),
        (
            "span = 1\n[response]\nkind = 'table'\nstresses = [0, 0.5, 1]\nreadings = [0, 0.7, 0.6]",
            "a response must rise: readings of its table go from 0.7 to 0.6",
        ),
        (
            "shape = [4, 4]\ngain_map = [[1, 2], [3, 4]]",
            "gains of a sensor must have the sensor's shape, 4 x 4, got 2 x 2",
        ),
        ("gain_map = [[1, 2], [3]]", "gain_map must be rows of numbers, equally many in each"),
        ("gain_map = 'none.csv'", "sensor.toml: gain_map: "),
        ("gain_map = 'none.csv'", "none.csv: there is no such file"),
        ("rest = 'sensor.toml'", "sensor.toml: rest: "),
        ("pitch_m = true", "pitch_m must be one spacing in metres"),
        ("pitch_m = ['1e-3', true]", "pitch_m must be one spacing in metres"),
        ("positions_m = [[0, 0], [1e200, 0], [0, 1]]", "must lie within 1000 m of its origin, got 1e+200 for taxel 1"),
        ("positions_m = [[0, 0], [1, 0], [0, 0]]", "must differ: taxels 0 and 2 stand at one place"),
        ("polarity = 'left'", "polarity of a sensor must be up or down"),
        ("[skin]\nkind = 'rubber'", "must be one of layer, half-space, winkler"),
        ("[skin\n", "not a TOML file"),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "sensor.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_sensor(path)
    message = str(caught.value)
    assert says in message
    assert message.startswith(str(tmp_path))
    assert "\n" not in message


def test_taxels_on_a_line_are_told_with_their_file(tmp_path: Path) -> None:
    path = tmp_path / "sensor.toml"
    path.write_text("positions_m = [[0, 0], [0.01, 0], [0.02, 0]]")
    with pytest.raises(InputError, match=r"sensor\.toml: positions_m of a sensor stand on one line"):
        _ = read_sensor(path).resampling


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("1,2\n3\n", "line 2 must have 2 numbers like line 1, got 1"),
        ("1,two\n", "line 1, column 2 must be a number, got 'two'"),
        ("\n", "there is no line of numbers"),
    ],
)
def test_a_damaged_map_is_told(tmp_path: Path, content: str, says: str) -> None:
    (tmp_path / "gains.csv").write_text(content)
    (tmp_path / "sensor.toml").write_text("gain_map = 'gains.csv'")
    with pytest.raises(FormatError, match=says):
        read_sensor(tmp_path / "sensor.toml")


@pytest.mark.parametrize("text", ["1;0,5\n2;nan\n", "1\t0.5\n2\tNaN\n", "# gains\n1, 0.5\n2, nan\n"])
def test_a_map_is_read_as_every_other_text(tmp_path: Path, text: str) -> None:
    (tmp_path / "gains.csv").write_text(text)
    (tmp_path / "sensor.toml").write_text("gain_map = 'gains.csv'")
    gains = read_sensor(tmp_path / "sensor.toml").gains
    assert np.array_equal(gains, [[1, 0.5], [2, np.nan]], equal_nan=True)


@pytest.mark.parametrize("key", ["pitch_m", "shape", "span", "rest", "gain_map", "field", "positions_m", "crosstalk"])
def test_an_integer_beyond_all_floats_is_no_number(tmp_path: Path, key: str) -> None:
    path = tmp_path / "sensor.toml"
    for value in ("9" * 400, f"[{'9' * 400}, 1]", f"[[{'9' * 400}, 1], [2, 3]]"):
        path.write_text(f"{key} = {value}")
        with pytest.raises(FormatError, match=re.escape(str(path))) as told:
            read_sensor(path)
        assert len(str(told.value)) < 2000


def test_the_nearest_sensor_file_is_found(tmp_path: Path) -> None:
    recording = tmp_path / "press.npz"
    assert find_sensor_file(recording) is None
    for name in ("sensor.toml", "press.sensor.toml", "press.npz.sensor.toml"):
        (tmp_path / name).write_text("")
        assert find_sensor_file(recording) == tmp_path / name


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_every_preset_is_a_sensor_with_a_name_and_a_note(name: str) -> None:
    sensor = sensor_of(name)
    assert sensor.name
    assert sensor.notes
    assert sensor.shape is not None


def test_what_is_neither_preset_nor_file_is_told() -> None:
    with pytest.raises(InputError, match=r"no preset; presets are capcontact, .*weiss-dsa"):
        sensor_of("no-such-sensor")
    with pytest.raises(InputError, match="there is no such file"):
        sensor_of("no-such.toml")


def test_a_sensor_file_inside_a_recording_is_the_sensor(tmp_path: Path) -> None:
    pytest.importorskip("mcap", reason="MCAP needs the extra live")
    from varishold.recording.mcap import TopicWriter
    from varishold.sensor import sensor_inside, sensor_texts

    gains = np.array([[1.0, 0.5], [2.0, 1 / 3]])
    sensor = Sensor(name="mat", shape=(2, 2), gains=gains, span=255.0)

    def recorded(texts: dict[str, str]) -> Path:
        path = tmp_path / "a.mcap"
        with path.open("wb") as file:
            writer = TopicWriter(file)
            for name, text in texts.items():
                writer.attach(name, text.encode())
            writer.reading({"pad": np.ones((2, 2))}, log_ns=1)
            writer.finish()
        return path

    path = recorded(sensor_texts(sensor))
    inside = sensor_inside(path)
    assert inside is not None
    assert (inside.name, inside.shape, inside.span, inside.source) == ("mat", (2, 2), 255.0, f"{path}: sensor.toml")
    np.testing.assert_array_equal(inside.gains, gains)
    assert sensor_inside(recorded({"notes.txt": "x"})) is None
    (tmp_path / "plain.csv").write_text("1,2\n")
    assert sensor_inside(tmp_path / "plain.csv") is None
    with pytest.raises(FormatError, match=r"^\S+/a\.mcap: sensor\.toml: .*colour"):
        sensor_inside(recorded({"sensor.toml": "colour = 1\n"}))
    for name in ("gains.csv", "../gains.csv", "/etc/passwd"):
        with pytest.raises(FormatError, match=r"names \w+(\.csv)?, which is not in the recording"):
            sensor_inside(recorded({"sensor.toml": f'gain_map = "{name}"\n', "../gains.csv": "1\n"}))


def test_an_empty_name_is_no_sensor() -> None:
    with pytest.raises(InputError, match=r"^'': is no sensor file \(TOML\) and no preset"):
        sensor_of("")
