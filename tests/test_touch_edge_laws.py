"""Touch where there is little or nothing: empty reliefs, thresholds that are none, frames of a sensor, exports."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import FormatError, InputError
from varishold.sensor import Logarithmic, Power, Sensor, Table
from varishold.skin import Relief
from varishold.touch import find_contacts, find_contacts_batch, recognize, recognize_falling
from varishold.touch.exact.window import _widened
from varishold.touch.pads import surface as pad_surfaces
from varishold.touch.relief import RELIEF_NAMES, relief_of, relief_signature
from varishold.touch.signature import SIGNATURE_NAMES, contact_signature
from varishold.touch.writers import Export
from varishold.touch.writers import vectors as drawn
from varishold.touch.writers.c99 import _float, _sensor
from varishold.touch.writers.vectors import check_vectors


def relief(height: np.ndarray, pressure: np.ndarray) -> Relief:
    mask = height > 0
    return Relief(pressure, height, mask, mask, height, 0.0, (0.0, 0.0), 0.0, (5e-4, 5e-4), 2, 3)


def test_a_relief_s_signature_is_that_of_its_height_and_its_pressure() -> None:
    y, x = np.mgrid[:20, :24]
    height = np.maximum(6 - np.hypot(x - 12, y - 10), 0)
    pressure = np.maximum(40 - (x - 12) ** 2 - (y - 10) ** 2, 0.0)
    told = [contact_signature(find_contacts(height, floor=0.05 * height.max())[0])]
    told.append(contact_signature(find_contacts(pressure)[0]))
    made = relief_signature(relief(height, pressure))
    assert made.shape == (len(RELIEF_NAMES),)
    np.testing.assert_array_equal(made, np.concatenate(told))
    n = len(SIGNATURE_NAMES)
    flat = relief_signature(relief(np.zeros((20, 24)), pressure))
    assert not flat[:n].any()
    np.testing.assert_array_equal(flat[n:], told[1])
    assert not relief_signature(relief(np.zeros((9, 9)), np.zeros((9, 9)))).any()


def test_a_relief_of_one_contact_knows_nothing_of_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = np.zeros((16, 20))
    frame[3:9, 3:9], frame[5:10, 13:17] = 8.0, 5.0
    valid = np.ones((16, 20), bool)
    contacts = find_contacts(frame, pitch=(1e-3, 2e-3), valid=valid)
    seen: list[Any] = []
    monkeypatch.setattr("varishold.touch.relief.reconstruct", lambda given, skin, **how: seen.append((given, how)))
    relief_of(contacts[0], None)  # type: ignore[arg-type]
    relief_of(contacts[0], None, among=contacts)  # type: ignore[arg-type]
    np.testing.assert_array_equal(seen[0][0], frame)
    np.testing.assert_array_equal(seen[1][0], np.where(frame == 5.0, 0.0, frame))
    assert seen[0][1] == {"pitch": (1e-3, 2e-3), "noise": contacts[0].sigma}


def test_thresholds_that_do_not_fall_are_told() -> None:
    for wrong in ([3.0, np.nan], [np.inf, 1.0], [], [[2.0, 1.0]], [1.0, 1.0], [1.0, 2.0]):
        with pytest.raises(InputError, match="thresholds must be finite and fall"):
            list(recognize_falling([np.eye(4)] * 2, wrong))


def test_frames_of_a_sensor_are_each_undone() -> None:
    sensor = Sensor(polarity="down", rest=255, span=10, full_scale=6.0)
    y, x = np.mgrid[-8:9, -8:9]
    frames = np.stack([sensor.forward(np.maximum(k - np.hypot(x, y), 0.0)) for k in (4.0, 6.0)])
    both = find_contacts_batch(frames, 8, sensor=sensor, pitch=0.002)
    for frame, contacts in zip(frames, both, strict=True):
        (told,) = find_contacts(frame, 8, sensor=sensor, pitch=0.002)
        (made,) = contacts
        np.testing.assert_array_equal(made.profile.area, told.profile.area)
        assert made.pitch == (0.002, 0.002)
        assert len(made.profile) == 8


def test_where_a_sensor_has_no_taxel_there_is_none_unless_another_field_is_named() -> None:
    field = np.ones((10, 12), bool)
    field[:, :4] = False
    sensor = Sensor(shape=(10, 12), span=10, full_scale=5.0, field=field)
    frame = np.zeros((10, 12))
    frame[3:7, 2:9] = 6.0
    (own,) = find_contacts(frame, sensor=sensor)
    assert own.n_taxels == 4 * 5
    wider = field.copy()
    wider[:, 3] = True
    (named,) = find_contacts(frame, sensor=sensor, field=wider)
    assert named.n_taxels == 4 * 6


# Exports


SENSORS = {
    "plain": Sensor(span=50),
    "down": Sensor(polarity="down", rest=1023, span=1000, full_scale=500.0, dead_band=0.25, saturation=0.9),
    "power": Sensor(response=Power(0.7), span=4095, full_scale=3.0),
    "logarithmic": Sensor(shape=(4, 5), response=Logarithmic(20.0), rest=np.full((4, 5), 7.0), span=255),
    "table": Sensor(response=Table([0, 0.1, 0.4, 1], [0, 0.3, 0.7, 1]), span=100),
}


@pytest.mark.parametrize("name", SENSORS)
def test_an_exported_sensor_has_the_sensor_s_numbers(name: str) -> None:
    sensor = SENSORS[name]
    text = "\n".join(_sensor(sensor, 4, 5))
    (body,) = re.findall(r"struct vh_sensor sensor = \{(.*)\};", text, re.DOTALL)
    parts = [part.strip() for part in body.split(",")]
    number = lambda part: float(part.removesuffix("f"))  # noqa: E731
    rest_map = np.ndim(sensor.rest) > 0
    assert parts[0] == ("rest" if rest_map else "0")
    assert number(parts[1]) == (0.0 if rest_map else float(sensor.rest))
    # Where stress is proportional to the reading, both factors are one.
    scale = (1 - sensor.dead_band) * sensor.full_scale
    by_span, by_share = (scale, 1.0) if name in ("plain", "down") else (1.0, scale)
    assert number(parts[2]) == pytest.approx((-1 if name == "down" else 1) * by_span / sensor.span, rel=1e-6)
    assert parts[3] == ("INFINITY" if sensor.saturation is None else _float(by_span * sensor.saturation))
    assert number(parts[4]) == pytest.approx(by_share, rel=1e-6)
    assert number(parts[5]) == pytest.approx({"power": 0.7, "logarithmic": 20.0}.get(name, 0.0), rel=1e-6)
    kinds = {"power": "VH_POWER", "logarithmic": "VH_LOGARITHMIC", "table": "VH_TABLE"}
    assert parts[6] == kinds.get(name, "VH_LINEAR")
    assert parts[7] == ("4" if name == "table" else "0")
    assert parts[8:10] == (["points_reading", "points_stress"] if name == "table" else ["0", "0"])
    assert parts[10:] == ["0"] * 5


def test_vectors_count_the_touches_that_the_controller_can_tell() -> None:
    frame = np.zeros((16, 16), np.float32)
    frame[2:5, 2:5], frame[9:14, 2:7], frame[4:9, 10:14] = 6.0, 9.0, 8.0
    for most in (1, 2, 3, 5):
        assert drawn._expected(Export(contacts=most), frame).n_touches == min(most, 3)
    empty = drawn._expected(Export(), np.zeros((16, 16), np.float32))
    assert (empty.n_touches, empty.name, empty.probability) == (0, -1, 0.0)


def test_with_a_sensor_vectors_press_to_half_of_its_scale() -> None:
    sensor = Sensor(span=200.0, full_scale=40.0)
    plain = check_vectors(Export(), 4)
    sensed = check_vectors(Export(sensor=sensor), 4)
    for one, other in zip(plain[:-1], sensed[:-1], strict=True):
        assert one.readings.max() == pytest.approx(1.0, abs=0.03)
        np.testing.assert_allclose(other.readings, np.maximum(sensor.forward(20.0 * one.readings), 0), atol=1.5)
    assert not plain[-1].readings.any()


def test_what_just_can_be_exported_and_what_cannot() -> None:
    assert Export().rows_and_cols == (16, 16)
    assert Export(shape=(4, 48)).rows_and_cols == (4, 48)
    assert Export(sensor=Sensor(shape=(8, 9), span=1.0)).rows_and_cols == (8, 9)
    assert Export().pitch == (1.0, 1.0)
    assert Export(sensor=Sensor(span=1.0, pitch_m=(0.002, 0.003))).pitch == (0.002, 0.003)
    for good in ({"levels": 4}, {"levels": 512}, {"contacts": 1}, {"contacts": 64}):
        Export(**good)  # type: ignore[arg-type]
    for wrong, says in (
        ({"levels": 3}, "levels must be from 4 to 512, got 3"),
        ({"levels": 513}, "levels must be from 4 to 512, got 513"),
        ({"contacts": 0}, "contacts must be from 1 to 64, got 0"),
        ({"contacts": 65}, "contacts must be from 1 to 64, got 65"),
        ({"shape": (3, 9)}, "4 to 48 rows and columns, got 3x9"),
        ({"shape": (9, 49)}, "4 to 48 rows and columns, got 9x49"),
        ({"shape": (9, 9), "sensor": Sensor(shape=(8, 9), span=1.0)}, "shape must be the sensor's, 8x9, got 9x9"),
    ):
        with pytest.raises(InputError, match=says):
            Export(**wrong)  # type: ignore[arg-type]
    gaps = np.ones((8, 8), bool)
    gaps[0, 0] = False
    for spread in ({"crosstalk": 0.05}, {"blur_taxels": 0.5}):
        whole = Sensor(shape=(8, 8), span=1.0, **spread)  # type: ignore[arg-type]
        Export(sensor=whole)
        with pytest.raises(InputError, match="crosstalk and blur of a pad with gaps cannot be undone"):
            Export(sensor=replace(whole, field=gaps))
    Export(sensor=Sensor(shape=(8, 8), span=1.0, field=gaps))


# Pads


@pytest.mark.parametrize("changed", ["measures", "surfaces"])
def test_a_pad_s_table_that_was_made_for_others_is_told(changed: str, monkeypatch: pytest.MonkeyPatch) -> None:
    real = pad_surfaces.open_archive

    class Other:
        def __init__(self, path: Any) -> None:
            self._archive = real(path)

        def __enter__(self) -> Any:
            self._inner = self._archive.__enter__()
            return self

        def __exit__(self, *how: Any) -> Any:
            return self._archive.__exit__(*how)

        def array(self, name: str) -> np.ndarray:
            values = self._inner.array(name)
            return values[:-1] if name == changed else values

        @property
        def names(self) -> Any:
            return self._inner.names

    pad_surfaces._load.cache_clear()
    monkeypatch.setattr(pad_surfaces, "open_archive", Other)
    with pytest.raises(FormatError, match="made for other measures; make it again by"):
        pad_surfaces._load("plain")
    pad_surfaces._load.cache_clear()


# Windows and sections


@given(st.integers(4, 70), st.integers(1, 3), st.data())
@settings(max_examples=60)
def test_a_window_comes_in_steps_and_stays_on_the_pad(length: int, k: int, data: st.DataObject) -> None:
    """Two taxels around, in steps of four, as many as the pad has whole ones of; of means of k x k so many times k."""
    start = data.draw(st.integers(0, length - k))
    stop = data.draw(st.integers(start + 1, length))
    made = _widened(slice(start, stop), length, k)
    low, high = max(start - 2 * k, 0), min(stop + 2 * k, length)
    assert 0 <= made.start
    assert made.stop <= length
    size = made.stop - made.start
    assert size == min(-(-(high - low) // (4 * k)) * 4 * k, length // k * k)
    if size >= high - low:
        assert made.start <= low
        assert made.stop >= high
    assert made.start == low or made.stop == length


@pytest.mark.parametrize("key", ["cone", "pillar", "ring"])
def test_the_nearest_section_to_a_share_is_the_nearest_that_is_not_empty(key: str) -> None:
    y, x = np.mgrid[:24, :26]
    r = np.hypot(x - 12.5, y - 11.5)
    frame = {
        "cone": np.maximum(9.0 - r, 0.0),
        "pillar": 5.0 * (r < 7),
        "ring": np.maximum(3.0 - np.abs(r - 6), 0.0),
    }[key]
    surface = recognize(find_contacts(frame, 17)[0])
    threshold, contact = surface.profile.threshold, surface.contact
    first = next(k for k, area in enumerate(surface.areas) if area > 0)
    for share in np.linspace(-0.2, 1.2, 57):
        wanted = contact.peak - share * (contact.peak - contact.floor)
        away = np.abs(threshold - wanted)[first : surface.lowest + 1]
        found = surface.nearest(float(share))
        assert first <= found <= surface.lowest
        assert abs(threshold[found] - wanted) == pytest.approx(away.min(), abs=1e-12)
