"""Receptor channels, the variable threshold, and lateral inhibition."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from varishold.errors import InputError
from varishold.skin import (
    RECEPTORS,
    edge_map,
    lateral_inhibition,
    potential,
    pulse_rate,
    pulses,
    unit_output,
    varishold_sections,
)

STEP = 0.5e-3


def _step_response(channel: str) -> np.ndarray:
    """Times of the pulses, seconds from the onset, of a unit step held for two seconds."""
    stress = np.zeros((round(3.0 / STEP), 1))
    stress[round(0.5 / STEP) : round(2.5 / STEP)] = 1.0
    receptor = RECEPTORS[channel]
    fired = pulses(potential(stress, receptor, step_s=STEP), receptor, step_s=STEP)[:, 0]
    return np.flatnonzero(fired) * STEP - 0.5


def _rate(times: np.ndarray, start: float, end: float) -> float:
    return float(((times >= start) & (times < end)).sum() / (end - start))


def test_sa_holds_and_slows_down() -> None:
    times = _step_response("SA")
    rates = [_rate(times, *span) for span in ((0.05, 0.1), (0.1, 0.2), (0.2, 0.5), (1.5, 2.0))]
    assert rates == pytest.approx([80, 55, 36, 30], abs=6)
    assert _rate(times, 2.1, 2.5) == 0


@pytest.mark.parametrize("channel", ["RA", "PC"])
def test_ra_and_pc_answer_to_change_only(channel: str) -> None:
    times = _step_response(channel)
    assert _rate(times, 0.0, 0.1) > 0
    assert _rate(times, 2.0, 2.1) > 0
    assert _rate(times, 0.1, 2.0) == 0
    assert _rate(times, 2.1, 2.5) == 0


def test_channels_by_frequency() -> None:
    """SA answers to slow pressure, PC to fast vibration."""
    time = np.arange(0, 1, STEP)
    slow = 0.5 - 0.5 * np.cos(2 * np.pi * 2 * time)
    fast = 0.02 * (1 - np.cos(2 * np.pi * 200 * time))
    peak = {
        (name, kind): potential(stress, receptor, step_s=STEP).max()
        for name, receptor in RECEPTORS.items()
        for kind, stress in (("slow", slow), ("fast", fast))
    }
    assert peak["SA", "slow"] > peak["RA", "slow"] > peak["PC", "slow"]
    assert peak["PC", "fast"] > peak["SA", "fast"]


@settings(max_examples=25)
@given(stress=arrays(np.float64, (40, 3), elements=st.floats(0, 1)))
def test_units_are_independent_and_rest_between_pulses(stress: np.ndarray) -> None:
    receptor = RECEPTORS["SA"]
    together = pulses(potential(stress, receptor, step_s=STEP), receptor, step_s=STEP)
    for k in range(3):
        alone = pulses(potential(stress[:, k], receptor, step_s=STEP), receptor, step_s=STEP)
        assert np.array_equal(alone, together[:, k])
        times = np.flatnonzero(alone)
        assert (np.diff(times) * STEP >= receptor.refractory_s - 1e-12).all()


def test_output_functions() -> None:
    inner = np.array([[0.0], [0.2], [0.5]])
    assert unit_output(inner, 0.3, "step")[:, 0].tolist() == [0, 0, 1]
    assert unit_output(inner, 0.3, "amplitude")[:, 0] == pytest.approx([0, 0, 0.2])
    held = np.full((400, 2), 0.6)
    held[:, 1] = 0.2
    rate = unit_output(held, 0.3, "pulse rate", receptor=RECEPTORS["SA"], step_s=1e-3)
    assert rate[-1, 0] > 0
    assert rate[-1, 1] == 0


def test_pulse_rate_counts_over_its_window() -> None:
    fired = np.zeros((100, 1), dtype=bool)
    fired[::10] = True
    assert pulse_rate(fired, step_s=1e-3, window_s=0.05)[-1, 0] == pytest.approx(100.0)


FRAMES = arrays(np.float64, (6, 7), elements=st.floats(0, 50))


@settings(max_examples=50)
@given(frame=FRAMES, count=st.integers(1, 40), settle=st.booleans())
def test_sections_are_those_of_the_stress(frame: np.ndarray, count: int, settle: bool) -> None:
    """X_i = {V > theta_i}: leak, compression and waiting change nothing but the time it takes."""
    sections = varishold_sections(frame, count, settle=settle)
    slack = 1e-9 * max(frame.max(), 1e-9)
    if settle:
        # After five time constants a potential still lacks a little.
        slack += 0.01 * frame.max()
    assert (sections.fired <= (frame[None] > sections.thresholds[:, None, None] - slack)).all()
    assert (sections.fired >= (frame[None] > sections.thresholds[:, None, None] + slack)).all()
    # They nest, and say when each taxel first fired.
    assert (np.diff(sections.fired.astype(int), axis=0) >= 0).all()
    assert np.array_equal(sections.first, (~sections.fired).sum(axis=0))


@settings(max_examples=50)
@example(frame=np.array([[5e-324, 0.0], [0.0, 0.0]]), count=3)
@given(frame=FRAMES, count=st.integers(2, 60))
def test_the_rebuilt_stress_errs_by_a_step_at_most(frame: np.ndarray, count: int) -> None:
    sections = varishold_sections(frame, count, settle=False)
    largest = max(frame.max() / count, float(np.abs(np.diff(sections.thresholds)).max()))
    assert np.abs(sections.rebuilt() - np.maximum(frame, 0)).max() <= largest * (1 + 1e-6) + 1e-12


def test_bits() -> None:
    frame = np.zeros((16, 16))
    frame[4:12, 4:12] = 1.0
    sections = varishold_sections(frame, 8)
    assert sections.bits(coding="raster") == 8 * 256
    assert sections.bits() == (64 + 8) * 9
    assert sections.bits() < 12 * 256


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: varishold_sections([1.0], 4), "frame must have shape (rows, cols), got (1,)"),
        (lambda: varishold_sections(np.eye(3), [1, 2]), "thresholds must be one or more falling values"),
        (lambda: varishold_sections(np.eye(3), 0), "thresholds must be one or more falling values"),
        (lambda: varishold_sections(np.eye(3), 4, receptor=RECEPTORS["PC"]), "a PC receptor cannot hold"),
        (lambda: varishold_sections(np.eye(3), 4, full_scale=0.0), "full_scale must be positive"),
        (lambda: potential(np.eye(3), RECEPTORS["SA"], step_s=0), "step_s must be positive"),
        (lambda: potential(1.0, RECEPTORS["SA"], step_s=1e-3), "stress must be a history"),
        (lambda: unit_output(np.eye(3), 0.1, "volts"), "output must be one of step, amplitude, pulse rate"),  # type: ignore[arg-type]
        (lambda: unit_output(np.eye(3), 0.1, "pulse rate"), "the pulse rate needs receptor and step_s"),
        (lambda: lateral_inhibition(np.eye(3), pitch_m=0, depth_m=1e-3), "pitch_m must be one spacing in metres"),
        (lambda: lateral_inhibition(np.eye(3), pitch_m=1e-3, depth_m=-1), "depth_m must be finite and not"),
        (lambda: edge_map(np.ones(3), pitch_m=1e-3, depth_m=1e-3), "a frame must be numbers of shape (rows, cols)"),
        (
            lambda: edge_map(np.eye(3), pitch_m=1e-3, depth_m=1e-3, centre_m=2e-3, surround_m=1e-3),
            "the surround must be wider than the centre",
        ),
    ],
)
def test_what_is_wrong_is_told(make: Callable[[], object], says: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def _wave(k: float, n: int = 200, pitch: float = 1e-3) -> np.ndarray:
    x = np.arange(n) * pitch
    return np.broadcast_to(np.cos(k * x), (n, n))


def test_inhibition_undoes_a_blur_to_second_order() -> None:
    depth = 5e-3
    for k in (20.0, 50.0):
        wave = _wave(k)
        sharp = lateral_inhibition(wave, pitch_m=1e-3, depth_m=depth, centre_m=1.5e-3, surround_m=2.4e-3)
        gain = (sharp * wave)[50:150, 50:150].sum() / (wave * wave)[50:150, 50:150].sum()
        assert gain - 1 == pytest.approx((k * depth) ** 2 / 2 - (k * 1.5e-3) ** 2 / 2, rel=0.05)


def test_even_and_sloping_loads_have_no_edges() -> None:
    y, x = np.mgrid[0:40, 0:40]
    slope = 2.0 + 0.3 * x - 0.1 * y
    inner = (slice(12, -12), slice(12, -12))
    assert np.abs(edge_map(slope, pitch_m=1e-3, depth_m=2e-3)[inner]).max() < 1e-6
    assert lateral_inhibition(slope, pitch_m=1e-3, depth_m=2e-3)[inner] == pytest.approx(slope[inner])


def test_mach_bands_stand_on_both_sides_of_an_edge() -> None:
    frame = np.zeros((30, 30))
    frame[:, 15:] = 1.0
    edges = edge_map(frame, pitch_m=1e-3, depth_m=2e-3)[10]
    assert edges[15] > 0 > edges[14]
    assert int(np.argmax(edges)) == 15
    assert int(np.argmin(edges)) == 14
    assert lateral_inhibition(frame, pitch_m=1e-3, depth_m=2e-3)[10].max() > 1.0


def test_depth_zero_leaves_no_edges() -> None:
    assert not edge_map(np.eye(9), pitch_m=1e-3, depth_m=0.0).any()
