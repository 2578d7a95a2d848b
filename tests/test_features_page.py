"""The recipes of docs/features.md run as they stand, on arrays of every size that it names."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from varishold.levelset.table import MeasureTable

PAGE = Path(__file__).parents[1] / "docs" / "features.md"
CODE = "\n".join(re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL))


@pytest.mark.parametrize("shape", [(4, 4), (5, 9), (8, 8), (16, 16), (28, 50), (64, 64)], ids=str)
def test_the_recipes_run(shape: tuple[int, int], capsys: pytest.CaptureFixture[str]) -> None:
    assert "SHAPE = (16, 16)" in CODE
    names: dict[str, object] = {}
    code = CODE.replace("SHAPE = (16, 16)", f"SHAPE = {shape}").replace(
        "ExtraTreesClassifier(300", "ExtraTreesClassifier(30"
    )
    exec(compile(code, "features.md", "exec"), names)
    by_frame, by_press, *areas = capsys.readouterr().out.splitlines()
    assert float(by_frame) >= 0.9
    assert float(by_press) >= 0.9
    table = names["table"]
    assert isinstance(table, MeasureTable)
    assert all(np.isfinite(column).all() for column in table.values())
    assert areas
