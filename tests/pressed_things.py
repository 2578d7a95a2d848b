"""Recordings of presses, and commands that are run as a person runs them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from varishold import Pad, Recording
from varishold.cli.app import app, run

FORMS = {
    "disc": lambda x, y: np.hypot(x, y) < 4,
    "bar": lambda x, y: np.abs(x) < 2,
    "ring": lambda x, y: abs(np.hypot(x, y) - 4) < 1.5,
}


def recording(
    names: Sequence[str], seed: int, shape: tuple[int, int] = (13, 15), *, days: Sequence[str] = ("mon", "tue")
) -> Recording:
    """Presses one after the other, on each day as many, with empty frames between them."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(shape) - (np.array(shape)[:, None, None] - 1) / 2
    frames, press = [], []
    for number, name in enumerate(names):
        form = FORMS[name](x - rng.normal(0, 0.5), y - rng.normal(0, 0.5)).astype(float)
        for share in (0.0, 0.3, 0.8, 1.0, 0.9, 0.2, 0.0):
            frames.append(60 * share * form + rng.normal(0, 1, shape))
            press.append(number)
    columns = {"thing": np.array(names), "day": np.array(days)[np.arange(len(names)) * len(days) // len(names)]}
    return Recording({"pad": Pad(np.array(frames))}, press=np.array(press), press_columns=columns)


def told(*arguments: str | Path) -> Result:
    """Run a command."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def failed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """Run a command that fails, and return the one line that it says."""
    monkeypatch.setattr("sys.argv", ["varishold", *(str(argument) for argument in arguments)])
    assert run() == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    return said
