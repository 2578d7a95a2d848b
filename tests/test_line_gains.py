"""Laws of rows and columns that read unlike: presses at many places show it, and nothing else is taken for it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from varishold import Pad, Recording, recognize_recording
from varishold.frame.gains import gains_words
from varishold.frame.line_gains import line_gains

Floats = NDArray[np.float64]
FORMS = ("cylinder", "square pillar", "sphere", "cone", "ridge")


def load(rng: np.random.Generator, side: int, form: str, *, turned: bool = True) -> Floats:
    n = 4
    y, x = (np.mgrid[: side * n, : side * n] + 0.5) / n - side / 2
    row, col = rng.uniform(-0.2, 0.2, 2) * side
    turn = rng.uniform(0, np.pi) if turned else 0.0
    u = (x - col) * np.cos(turn) + (y - row) * np.sin(turn)
    v = (y - row) * np.cos(turn) - (x - col) * np.sin(turn)
    size = rng.uniform(0.2, 0.33) * side
    made: Floats = {
        "cylinder": 1.0 * (np.hypot(u, v) < size),
        "square pillar": 1.0 * (np.maximum(abs(u), abs(v)) < 0.9 * size),
        "sphere": np.sqrt(np.maximum(0, 1 - (np.hypot(u, v) / size) ** 2)),
        "cone": np.maximum(0, 1 - np.hypot(u, v) / size),
        "ridge": np.maximum(0, 1 - abs(v) / size) * (abs(u) < 1.5 * size),
    }[form]
    smooth: Floats = gaussian_filter(made, 0.5 * n, mode="nearest").reshape(side, n, side, n).mean((1, 3))
    return smooth * rng.uniform(0.4, 1)


def loads(seed: int, side: int, n: int, **how: bool) -> list[Floats]:
    rng = np.random.default_rng(seed)
    made = [load(rng, side, FORMS[k % len(FORMS)], **how) for k in range(n)]
    return [each + rng.normal(0, 0.01, each.shape) for each in made]


def gains(seed: int, side: int, spread: float) -> Floats:
    rng = np.random.default_rng([seed, side])
    of_rows, of_columns = np.exp(spread * rng.normal(0, 1, (2, side)))
    made: Floats = of_rows[:, None] * of_columns
    return made


@pytest.mark.parametrize("side", [16, 32])
@pytest.mark.parametrize("spread", [0.1, 0.2])
def test_gains_of_lines_are_found_and_more_presses_tell_them_better(side: int, spread: float) -> None:
    left = {}
    for n in (6, 40):
        left[n] = []
        for seed in range(6):
            true = gains(seed, side, spread)
            found = line_gains([true * each for each in loads(seed, side, n)], np.ones((side, side), bool), 0.01)
            even = np.ones((side, side)) if found is None else found
            left[n].append(np.log(true / even).std() / np.log(true).std())
    assert np.mean(left[40]) < min(0.7, np.mean(left[6]))
    assert np.mean(left[6]) < 1.0


@pytest.mark.parametrize("side", [16, 32])
@pytest.mark.parametrize("turned", [True, False])
def test_what_presses_is_no_gain(side: int, turned: bool) -> None:
    works = np.ones((side, side), bool)
    found = [line_gains(loads(seed, side, n, turned=turned), works, 0.01) for n in (4, 12, 40) for seed in range(8)]
    assert sum(each is not None for each in found) <= 1
    assert all(np.log(each).std() < 0.1 for each in found if each is not None)


def test_one_thing_at_one_place_tells_nothing() -> None:
    rng = np.random.default_rng(0)
    true, ball = gains(0, 16, 0.2), load(rng, 16, "sphere")
    same = [true * ball * strong for strong in rng.uniform(0.5, 1, 12)]
    assert line_gains(same, np.ones((16, 16), bool), 0.01) is None
    assert line_gains([], np.ones((16, 16), bool), 0.01) is None
    assert line_gains(loads(0, 16, 3), np.ones((16, 16), bool), 0.01) is None
    assert line_gains([np.zeros((16, 16))] * 8, np.ones((16, 16), bool), 0.0) is None
    assert line_gains([each[:3] for each in loads(0, 16, 12)], np.ones((3, 16), bool), 0.01) is None


def test_rows_alone_are_told_alone_and_broken_taxels_are_passed_over() -> None:
    true = gains(1, 32, 0.15)[:, :1] * np.ones((32, 32))
    works = np.random.default_rng(0).random((32, 32)) > 0.03
    pressed = [np.where(works, true * each, 1e6) for each in loads(1, 32, 24)]
    found = line_gains(pressed, works, 0.01)
    assert found is not None
    assert np.ptp(found, axis=1).max() < 1e-9
    assert np.log(true / found).std() < 0.6 * np.log(true).std()
    assert "rows by" in gains_words(found)
    assert "columns" not in gains_words(found)


def test_names_are_those_of_even_lines_and_it_is_told() -> None:
    right = {}
    for kind, uneven in (("even", 1.0), ("uneven", gains(2, 32, 0.15))):
        up = np.linspace(0, 1, 6)[1:-1]
        course = np.concatenate([up, np.ones(4), up[::-1], np.zeros(6)])[:, None, None]
        pressed = loads(2, 32, 20)
        frames = np.concatenate([np.zeros((8, 32, 32)), *(course * (uneven * each) for each in pressed)])
        frames += np.random.default_rng(3).normal(0, 0.01, frames.shape)
        answers = list(recognize_recording(Recording({"pad": Pad(frames, pitch_m=1e-3)}), frames="press"))
        right[kind] = sum(each.surface.name == FORMS[k % len(FORMS)] for k, each in enumerate(answers[:20]))
        assert any("differ from line to line" in note for note in answers[0].frame_notes) == (kind == "uneven")
    assert right["uneven"] >= right["even"] - 2 >= 16
