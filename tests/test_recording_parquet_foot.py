"""A Parquet file whose foot says another number of rows than its groups hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from varishold.errors import FormatError
from varishold.recording import Pad, Recording, read, write
from varishold.recording.formats.parquet_column import opened_parquet

pytest.importorskip("pyarrow", reason="takes the extra files")


def test_rows_are_counted_alike_in_the_foot_and_in_its_groups(tmp_path: Path) -> None:
    from pyarrow import parquet

    path, spoilt = tmp_path / "a.parquet", tmp_path / "b.parquet"
    write(Recording({"pad": Pad(np.arange(99.0).reshape(11, 3, 3))}), path)
    file, binary = opened_parquet(path)
    assert file.metadata.num_rows == 11
    binary.close()
    whole = path.read_bytes()
    foot = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    told = []
    # Eleven is 22 in the foot, which counts signed numbers by turns.
    for at in (k for k in range(foot, len(whole)) if whole[k] == 22):
        spoilt.write_bytes(whole[:at] + bytes([6]) + whole[at + 1 :])
        try:
            facts = parquet.ParquetFile(spoilt).metadata
            said, held = facts.num_rows, sum(facts.row_group(k).num_rows for k in range(facts.num_row_groups))
        except (OSError, IndexError):
            continue
        if said != held:
            told.append((said, held))
            with pytest.raises(FormatError, match=f"b.parquet: says that it has {said} rows, its groups have {held}$"):
                read(spoilt)
    assert set(told) == {(3, 11), (11, 3)}
