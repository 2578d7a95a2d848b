"""Laws of taxels that read unlike: many presses all over the pad show it, and nothing else is taken for it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.test_line_gains import FORMS, Floats, load, loads

from varishold import Pad, Recording, recognize_recording
from varishold.frame.gains import gains_of, gains_words
from varishold.frame.taxel_gains import taxel_gains


def often(pressed: list[Floats]) -> NDArray[np.bool_]:
    """Return the taxels that six presses and more press."""
    return np.asarray(sum(each > 0.3 * each.max() for each in pressed) >= 6)


def gains(seed: int, side: int, spread: float) -> Floats:
    return np.asarray(np.exp(spread * np.random.default_rng([seed, side]).normal(0, 1, (side, side))))


@pytest.mark.parametrize("side", [8, 16, 32])
@pytest.mark.parametrize("spread", [0.1, 0.2])
def test_gains_are_found_and_more_presses_tell_them_better(side: int, spread: float) -> None:
    works = np.ones((side, side), bool)
    left = {}
    for n in (16, 80):
        left[n] = []
        for seed in range(4):
            true, pressed = gains(seed, side, spread), loads(seed, side, n)
            found = taxel_gains([true * each for each in pressed], works, 0.01)
            unlike, where = np.log(true if found is None else true / found), often(loads(seed, side, 80))
            left[n].append(unlike[where].std() / np.log(true)[where].std())
    assert np.mean(left[80]) < min(0.7, np.mean(left[16]))
    assert np.mean(left[16]) <= 1.0


@pytest.mark.parametrize("side", [8, 16, 32])
@pytest.mark.parametrize("turned", [True, False])
def test_what_presses_is_no_gain(side: int, turned: bool) -> None:
    works = np.ones((side, side), bool)
    found = [taxel_gains(loads(seed, side, n, turned=turned), works, 0.01) for n in (12, 60) for seed in range(6)]
    assert sum(each is not None for each in found) <= 1
    assert all(np.log(each).std() < 0.05 for each in found if each is not None)


def test_how_strong_presses_are_and_the_unit_tell_nothing() -> None:
    true, works, rng = gains(0, 12, 0.15), np.ones((12, 12), bool), np.random.default_rng(1)
    pressed = [true * each for each in loads(0, 12, 30)]
    one = taxel_gains(pressed, works, 0.0)
    other = taxel_gains([rng.uniform(0.5, 2e6) * each for each in pressed], works, 0.0)
    assert one is not None
    assert other is not None
    np.testing.assert_allclose(one, other, rtol=1e-9)


def test_gains_turn_with_the_pad() -> None:
    true, works = gains(3, 12, 0.15), np.ones((12, 12), bool)
    pressed = [true * each for each in loads(3, 12, 30)]
    found = taxel_gains(pressed, works, 0.01)
    turned = taxel_gains([each.T[::-1] for each in pressed], works, 0.01)
    assert found is not None
    assert turned is not None
    np.testing.assert_allclose(turned, found.T[::-1], rtol=5e-3)


def test_too_little_tells_nothing() -> None:
    rng, works = np.random.default_rng(0), np.ones((16, 16), bool)
    true, ball = gains(0, 16, 0.2), load(rng, 16, "sphere")
    assert taxel_gains([true * ball * strong for strong in rng.uniform(0.5, 1, 30)], works, 0.01) is None
    assert taxel_gains([], works, 0.01) is None
    assert taxel_gains([true * each for each in loads(0, 16, 11)], works, 0.01) is None
    assert taxel_gains([np.zeros((16, 16))] * 20, works, 0.0) is None
    assert taxel_gains([each[:3] for each in loads(0, 16, 20)], works[:3], 0.01) is None
    assert taxel_gains(loads(0, 16, 20), np.zeros((16, 16), bool), 0.01) is None


def test_broken_taxels_are_passed_over_and_lines_and_taxels_are_told_together() -> None:
    works = np.random.default_rng(0).random((32, 32)) > 0.03
    own = gains(1, 32, 0.1)
    true = own * np.exp(0.15 * np.random.default_rng(5).normal(0, 1, (32, 1)))
    pressed = [np.where(works, true * each, 1e6) for each in loads(1, 32, 60)]
    found = gains_of(pressed, works, 0.01)
    assert found is not None
    where = works & often(loads(1, 32, 60))
    assert np.log(true / found)[where].std() < 0.5 * np.log(own)[where].std()
    assert "from taxel to taxel by" in gains_words(found)


def test_names_are_those_of_even_taxels_and_it_is_told() -> None:
    right = {}
    for kind, uneven in (("even", np.ones((16, 16))), ("uneven", gains(2, 16, 0.2))):
        up = np.linspace(0, 1, 6)[1:-1]
        course = np.concatenate([up, np.ones(4), up[::-1], np.zeros(6)])[:, None, None]
        frames = np.concatenate([np.zeros((8, 16, 16)), *(course * (uneven * each) for each in loads(2, 16, 40))])
        frames += np.random.default_rng(3).normal(0, 0.01, frames.shape)
        answers = list(recognize_recording(Recording({"pad": Pad(frames, pitch_m=1e-3)}), frames="press"))
        right[kind] = sum(each.surface.name == FORMS[k % len(FORMS)] for k, each in enumerate(answers[:40]))
        assert any("from taxel to taxel" in note for note in answers[0].frame_notes) == (kind == "uneven")
    assert right["uneven"] >= right["even"] - 3 >= 30
