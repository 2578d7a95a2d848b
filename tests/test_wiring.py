"""Laws of taxels in another order than they stand: it is told, and what comes in its order is not doubted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.pressed_things import told

from varishold import Pad, Recording, write
from varishold.frame.wiring import wiring_words

Frames = NDArray[np.float64]
FORMS = ("ball", "box", "bar", "column")


def pressed(
    shape: tuple[int, int], seed: int, noise: float = 0.01, presses: int = 5, forms: tuple[str, ...] = FORMS
) -> Frames:
    rng = np.random.default_rng(seed)
    row, col = np.indices(shape)
    frames = []
    for _ in range(presses):
        across, along = (row - rng.uniform(0.25, 0.75) * shape[0]), (col - rng.uniform(0.25, 0.75) * shape[1])
        reach = rng.uniform(0.2, 0.4) * min(shape)
        form = rng.choice(forms)
        away = np.maximum(abs(across), abs(along)) if form == "box" else np.hypot(across, along)
        away = abs(across) if form == "bar" else abs(along) if form == "column" else away
        height = np.maximum(1.0 - (away / reach) ** 2, 0.0) if form != "box" else 1.0 * (away < reach)
        frames += [load * height for load in (0.0, 0.5, 1.0, 0.6)]
    return np.array(frames) + rng.normal(0.0, noise, (len(frames), *shape))


def every_other_first(n: int) -> list[int]:
    return [*range(0, n, 2), *range(1, n, 2)]


def reversed_rows(frames: Frames) -> Frames:
    made = frames.copy()
    made[:, 1::2] = made[:, 1::2, ::-1]
    return made


WRONG: dict[str, Callable[[Frames], Frames]] = {
    "every other row seems to come backwards": reversed_rows,
    "every other column seems to come backwards": lambda f: reversed_rows(f.swapaxes(1, 2)).swapaxes(1, 2),
    "rows seem to come every other one first": lambda f: f[:, every_other_first(f.shape[1])],
    "columns seem to come every other one first": lambda f: f[:, :, every_other_first(f.shape[2])],
    "rows of two halves seem to come by turns": lambda f: f[:, np.argsort(every_other_first(f.shape[1]))],
    "a shape of 12 x 18 would be smoother": lambda f: f.reshape(-1, f.shape[2], f.shape[1]),
}


@given(
    st.integers(0, 10_000),
    st.tuples(st.integers(4, 24), st.integers(4, 24)),
    st.sampled_from([FORMS, ("ball",), ("box",), ("bar",), ("column",)]),
    st.sampled_from([0.0, 0.01, 0.1, 1.0]),
    st.integers(1, 6),
)
def test_what_comes_in_its_order_is_not_doubted(
    seed: int, shape: tuple[int, int], forms: tuple[str, ...], noise: float, presses: int
) -> None:
    assert wiring_words(pressed(shape, seed, noise, presses, forms), np.ones(shape, np.bool_)) == ()


@pytest.mark.parametrize("what", WRONG)
def test_another_order_is_told(what: str) -> None:
    told_of = []
    for seed in range(20):
        frames = WRONG[what](pressed((12, 18), seed, forms=("ball", "box")))
        told_of += wiring_words(frames, np.ones(frames.shape[1:], np.bool_))
    # Nothing else is ever told, and most often that.
    assert all(words.startswith(what) for words in told_of)
    assert len(told_of) >= 8


def test_combs_noise_and_nothing_are_not_doubted() -> None:
    comb = np.tile(np.arange(16) % 2, (10, 16, 1)).astype(float)
    comb[0] = 0.0
    noise = np.random.default_rng(0).normal(0.0, 1.0, (30, 16, 16))
    for frames in (comb, comb.swapaxes(1, 2), noise, np.zeros((9, 16, 16)), comb[:1], comb[:, :3, :3]):
        words = wiring_words(frames, np.ones(frames.shape[1:], np.bool_))
        assert words == () or frames is comb or frames.base is comb


@pytest.mark.parametrize(("dtype", "scale"), [(np.float16, 6e4), (np.float32, 1e38)])
def test_sums_do_not_overflow_in_the_type_of_the_readings(dtype: type[np.floating], scale: float) -> None:
    frames = reversed_rows(pressed((12, 18), 3, forms=("ball",)))
    small = (scale / frames.max() * frames).astype(dtype)
    works = np.ones((12, 18), np.bool_)
    assert wiring_words(small, works) == wiring_words(small.astype(np.float64), works) != ()


def test_info_and_touch_tell_of_it(tmp_path: Path) -> None:
    file = str(tmp_path / "snake.npz")
    write(Recording({"palm": Pad(reversed_rows(100.0 + 1000.0 * pressed((12, 18), 3, forms=("ball",))))}), file)
    for command in ("info", "touch"):
        assert "palm: every other row seems to come backwards" in " ".join(told(command, file).output.split())
