"""Parquet: few rows of many taxels are held at a time, whichever column was read last."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from varishold import open as open_recording
from varishold.recording import Pad, Recording, read, write

pytest.importorskip("pyarrow")
from varishold.recording.formats import parquet, parquet_column


@pytest.mark.parametrize(
    ("row_bytes", "rows"), [(1, 4096), (512, 4096), (513, 4088), (1 << 20, 2), (1 << 22, 1), (0, 4096)]
)
def test_so_many_rows_are_taken_together(row_bytes: int, rows: int) -> None:
    assert parquet_column.rows_together(row_bytes, 1 << 21) == rows


def test_wide_rows_are_read_a_few_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pyarrow has one number of rows for all columns of a file: times must not set that of frames."""
    monkeypatch.setattr(parquet_column, "_TOGETHER", 1280)
    monkeypatch.setattr(parquet, "GROUP_BYTES", 12800)
    frames = np.arange(300 * 64, dtype=np.uint16).reshape(300, 8, 8)
    write(Recording({"pad": Pad(frames)}, time_s=np.arange(300) / 100), tmp_path / "a.parquet")
    taken = []
    numbers = parquet_column.ParquetColumn._numbers

    def told(self: Any, batch: Any, first: int) -> Any:
        taken.append((self.name, len(batch)))
        return numbers(self, batch, first)

    monkeypatch.setattr(parquet_column.ParquetColumn, "_numbers", told)
    with open_recording(tmp_path / "a.parquet") as opened:
        some = [opened.frames[k : k + 33].pads["pad"].frames for k in range(0, 300, 33)]
    assert np.array_equal(np.concatenate(some), frames)
    assert {name for name, _ in taken} == {"observation.tactile.pad", "timestamp"}
    assert max(many for _, many in taken) <= 10
    assert np.array_equal(read(tmp_path / "a.parquet").pads["pad"].frames, frames)
