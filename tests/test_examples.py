"""The examples run, and are learned from."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
from tests.pressed_things import told

from varishold import read


def test_five_things_are_learned_on_two_days_and_told_on_a_third(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("five_things", Path("examples/five_things.py"))
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.PRESSES = 4
    example.main(tmp_path)
    days = [tmp_path / f"{day}.npz" for day in example.DAYS]
    truth = read(days[2]).presses.columns["thing"]
    assert told("learn", *days[:2], "--label", "thing", "--group", "day", "-o", tmp_path / "model.npz").exit_code == 0
    answered = told("recognize", tmp_path / "model.npz", days[2])
    assert answered.exit_code == 0
    names = [line.split()[1] for line in answered.stdout.splitlines() if line.lstrip()[0].isdigit()]
    assert np.mean(np.array(names) == truth) >= 0.9
