"""A table of measures: the field's names, the unit in each, one row a contact."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

from varishold.errors import MissingExtraError
from varishold.levelset import find_contacts, measure
from varishold.recording import Pad, Recording

PITCH = (0.002, 0.001)


def discs() -> np.ndarray:
    y, x = np.mgrid[0:30, 0:50]
    big, small = np.hypot(x - 14, y - 15) < 9, np.hypot(x - 38, y - 14) < 5
    ring = big & (np.hypot(x - 14, y - 15) > 3)
    return np.stack([1.0 * big + 0.8 * small, 1.0 * ring, 0.0 * big])


def test_every_contact_is_a_row_with_its_unit_in_the_names() -> None:
    frames = discs()
    table = measure(Recording({"pad": Pad(frames, pitch_m=PITCH)}, time_s=np.array([0.0, 0.5, 1.0])), floor=0.1)
    assert table["frame"].tolist() == [0, 0, 1]
    assert table["contact"].tolist() == [0, 1, 0]
    assert table["time_s"].tolist() == [0.0, 0.0, 0.5]
    assert table["euler_number"].tolist() == [1, 1, 0]
    assert not [name for name in table if name.endswith("_taxels") and name != "n_taxels"]
    (big, small), (ring,) = (find_contacts(frame, pitch=PITCH, floor=0.1) for frame in frames[:2])
    for row, contact in enumerate((big, small, ring)):
        profile = contact.profile
        assert table["area_m2"][row] == profile.area[-1]
        assert table["perimeter_m"][row] == profile.perimeter[-1]
        assert table["feret_width_most_m"][row] == profile.extent[-1].max()
        assert table["second_moment_xx_m2"][row] == profile.covariance[-1, 0, 0]
    assert table["equivalent_diameter_m"][0] == pytest.approx(np.sqrt(4 * table["area_m2"][0] / np.pi))


def test_a_disc_has_the_axes_and_widths_of_a_disc() -> None:
    y, x = np.mgrid[-12:13, -12:13]
    table = measure(Recording({"pad": Pad(np.maximum(10.0 - np.hypot(x, y), 0.0)[None])}), floor=0.5)
    for name in ("principal_axis_major", "principal_axis_minor", "feret_width_most", "feret_width_least"):
        assert table[f"{name}_taxels"][0] == pytest.approx(table["equivalent_diameter_taxels"][0], rel=0.02)
    assert np.isnan(table["time_s"]).all()


def test_lengths_are_in_taxels_unless_every_pitch_is_known() -> None:
    frames = discs()
    table = measure(Recording({"left": Pad(frames, pitch_m=PITCH), "right": Pad(frames)}), floor=0.1)
    assert set(table["pad"].tolist()) == {"left", "right"}
    assert table["area_taxels"][0] == find_contacts(frames[0], floor=0.1)[0].profile.area[-1]


def test_nothing_touched_is_an_empty_table() -> None:
    table = measure(Recording({"pad": Pad(np.zeros((2, 4, 4)))}))
    assert {len(column) for column in table.values()} == {0}


def test_a_table_is_written_as_csv_and_a_name_is_no_formula(tmp_path: Path) -> None:
    table = measure(Recording({"=1+1": Pad(discs(), pitch_m=PITCH)}), floor=0.1)
    table.write_csv(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", newline="") as file:
        head, *rows = list(csv.reader(file))
    assert head == list(table)
    assert len(rows) == 3
    assert rows[0][head.index("pad")] == "'=1+1"
    assert float(rows[0][head.index("area_m2")]) == table["area_m2"][0]


def test_a_missing_pandas_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match="pip install pandas"):
        measure(Recording({"pad": Pad(discs())}), floor=0.1).to_pandas()
