"""What docs/perceive.md shows on a table of grasps runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from varishold.recording import GraspTable, write_grasp_table

PAGE = Path(__file__).parents[1] / "docs" / "perceive.md"


def test_two_grasps_of_a_table_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    kind = np.repeat([0, 1], 100)
    typical = np.array([[1, 1, 1, 1, 0, 0, 0, 0], [0, 0, 0, 0, 1, 1, 1, 1]])
    switches = typical[kind] ^ (rng.random((200, 8)) < 0.05)
    cells = {"object": np.array(["cylinder", "square-pillar"])[kind]}
    write_grasp_table(GraspTable(cells | {f"switch.s{k}": switches[:, k] for k in range(8)}), tmp_path / "TABLE.csv")
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (block,) = (each for each in blocks if "TABLE.csv" in each)
    exec(compile(block, "docs/perceive.md", "exec"), {})
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith("cylinder")
    assert second.startswith("square-pillar")
