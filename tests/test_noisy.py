"""Laws of taxels that are far noisier than those beside them: they are not believed, and no others are."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording, recognize_recording
from varishold.frame.neighbours import median_around, whole_lines
from varishold.frame.noisy import noisy_taxels
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

Frames = NDArray[np.float64]
ALL = np.ones((12, 12), np.bool_)
ROW, COL = np.indices(ALL.shape) - 5.5
BALL = np.sqrt(np.maximum(1.0 - (ROW**2 + COL**2) / 20.0, 0.0))
COURSE = np.r_[np.zeros(20), np.linspace(0.1, 1.0, 8), np.ones(12), np.linspace(0.9, 0.1, 6), np.zeros(20)]
BAD = [(1, 9), (5, 6), (9, 2)]


def pressed(noise: Frames | float = 10.0, form: Frames = BALL, seed: int = 0) -> Frames:
    rng = np.random.default_rng(seed)
    frames: Frames = 300.0 + 1000.0 * COURSE[:, None, None] * form
    return frames + noise * rng.normal(0.0, 1.0, frames.shape)


def bad(times: float = 15.0) -> Frames:
    noise = np.full(ALL.shape, 10.0)
    noise[tuple(zip(*BAD, strict=True))] *= times
    return pressed(noise)


@pytest.mark.parametrize("kind", [np.float64, np.uint16])
def test_noisy_taxels_are_filled(kind: type) -> None:
    recording = Recording({"pad": Pad(np.rint(bad()).clip(0).astype(kind))})
    mended = without_faults(recording).pads["pad"]
    assert mended.valid is not None
    assert [(row, col) for row, col in np.argwhere(~mended.valid).tolist()] == BAD
    assert any("far noisier than those beside it" in note for note in mended.notes)
    stored = stored_without_faults(stored_of(recording)).pads["pad"]
    assert stored.valid is not None
    assert np.array_equal(stored.valid, mended.valid)
    answers = list(recognize_recording(recording, frames="press"))
    assert [answer.surface.name for answer in answers] == ["sphere"]


@pytest.mark.parametrize("noise", [0.0, 0.5, 10.0, 60.0])
@pytest.mark.parametrize("whole", [False, True])
def test_others_stay(noise: float, whole: bool) -> None:
    spot = 1.0 * ((np.abs(ROW) < 1) & (np.abs(COL) < 1))
    for seed in range(3):
        rng = np.random.default_rng(seed)
        uneven = noise * np.exp(0.5 * rng.normal(0.0, 1.0, ALL.shape))
        trembles = pressed(noise, seed=seed) + 100.0 * rng.normal(0.0, 1.0, (len(COURSE), 1, 1)) * spot
        moves = pressed(noise, np.zeros(ALL.shape), seed)
        moves[:, 4, 4] += 500.0 * (1.0 + np.sin(0.2 * np.arange(len(COURSE))))
        for frames in (pressed(noise, seed=seed), pressed(uneven, seed=seed), trembles, moves):
            given = np.rint(frames).clip(0).astype(np.uint16) if whole else frames
            assert noisy_taxels(given, ALL) is None
    many = np.full(ALL.shape, 10.0)
    many[::2, ::2] = 150.0
    assert noisy_taxels(pressed(many), ALL) is None


def test_the_median_of_what_is_around() -> None:
    values = np.arange(9.0).reshape(3, 3)
    usable = np.ones((3, 3), np.bool_)
    usable[0, 1] = False
    assert median_around(values, usable)[1, 1] == 5.0
    assert median_around(values, usable)[0, 0] == 3.5
    assert median_around(values, np.eye(3, dtype=np.bool_))[0, 2] == 4.0
    assert median_around(values[:1, :1], usable[:1, :1])[0, 0] == 0.0


@pytest.mark.parametrize("many", [1, 2, 3])
def test_lines_side_by_side_that_never_change_are_filled(many: int) -> None:
    frames = pressed()
    frames[:, 5 : 5 + many] = 100.0
    assert Pad(frames).broken.sum() == 12 * many
    (answer,) = recognize_recording(Recording({"pad": Pad(frames)}), frames="press")
    assert answer.surface.outline == "round"
    out = np.zeros(ALL.shape, np.bool_)
    out[5 : 5 + many] = True
    assert np.array_equal(whole_lines(out, ALL, side_by_side=3), out)
    assert whole_lines(out, ALL).any() == (many == 1)
    # At the border they may be where nothing ever pressed.
    assert not whole_lines(np.roll(out, -5, axis=0), ALL, side_by_side=3).any() or many == 1
