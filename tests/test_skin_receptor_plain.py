"""The receptor and the taxels beside plain loops over time and places."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.skin import (
    RECEPTORS,
    Receptor,
    Skin,
    Taxels,
    potential,
    press,
    pulse_rate,
    pulses,
    sense,
    taxel_stress,
    unit_output,
    varishold_sections,
)
from varishold.solids import Sphere

Floats = NDArray[np.float64]
seeds = st.integers(0, 2**31)


def _history(seed: int, n: int = 60) -> Floats:
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(0.02, 0.1, n)) * rng.choice([0.1, 1.0, 5.0]) + 0.3


def _potential_by_loop(stress: Floats, r: Receptor, step: float) -> Floats:
    """R1 to R4, step by step."""

    def lag(tau: float) -> float:
        return 1 - math.exp(-step / tau)

    before = rate_before = adapted = first = second = inner = 0.0
    out = []
    for s in stress:
        rate = (s - before) / step
        change = (rate - rate_before) / step
        adapted += (s - adapted) * lag(r.tau_a_s)
        pole = lag(1 / (2 * math.pi * r.velocity_poles_hz))
        first += (rate - first) * pole
        second += (first - second) * pole
        drive = {
            "SA": max(s - r.adaptation * adapted, 0.0) + r.rate_gain_s * max(rate, 0.0),
            "RA": r.velocity_gain_s * abs(second),
            "PC": r.acceleration_gain_s2 * abs(change),
        }[r.channel]
        inner += (drive / (1 + drive / r.ceiling) - inner) * lag(r.tau_m_s)
        out.append(inner)
        before, rate_before = s, rate
    return np.array(out)


@settings(max_examples=40)
@given(seeds, st.sampled_from(["SA", "RA", "PC"]), st.sampled_from([0.2e-3, 1e-3, 5e-3]), st.floats(0.5, 4))
def test_a_potential_leaks_and_integrates(seed: int, channel: str, step: float, scale: float) -> None:
    stress = _history(seed)
    made = potential(stress * scale, RECEPTORS[channel], step_s=step, full_scale=scale)
    np.testing.assert_allclose(made, _potential_by_loop(stress, RECEPTORS[channel], step), rtol=1e-9, atol=1e-12)
    assert potential([0.5], RECEPTORS[channel], step_s=step).shape == (1,)


def test_the_kinds_have_their_constants() -> None:
    """Depths of the endings, and constants: a definition, on which every figure of the receptor stands."""
    kinds = {name: (r.channel, r.depth_m, r.tau_m_s) for name, r in RECEPTORS.items()}
    assert kinds == {"SA": ("SA", 0.3e-3, 30e-3), "RA": ("RA", 1.6e-3, 8e-3), "PC": ("PC", 2.0e-3, 1.5e-3)}
    for r in RECEPTORS.values():
        assert (r.tau_a_s, r.adaptation, r.rate_gain_s, r.velocity_gain_s) == (1.7, 0.45, 0.02, 0.03)
        assert (r.acceleration_gain_s2, r.velocity_poles_hz, r.ceiling) == (4e-5, 60.0, 3.0)
        assert (r.threshold, r.rises, r.tau_h_s, r.refractory_s) == (0.1, (0.35, 0.08), (10e-3, 200e-3), 2e-3)


def _pulses_by_loop(inner: Floats, r: Receptor, step: float) -> list[bool]:
    """R5 and R6: the threshold that all earlier pulses have left behind, from their times alone."""
    rest = max(1, round(r.refractory_s / step))
    fired: list[int] = []
    for n, value in enumerate(inner):
        raised = sum(
            rise * math.exp(-(n - m) * step / tau) for m in fired for rise, tau in zip(r.rises, r.tau_h_s, strict=True)
        )
        if value > r.threshold + raised and (not fired or n - fired[-1] >= rest):
            fired.append(n)
    return [n in fired for n in range(len(inner))]


@settings(max_examples=40)
@given(seeds, st.sampled_from([0.3e-3, 0.5e-3, 1e-3, 4e-3]), st.floats(0.5, 6.0))
def test_pulses_raise_a_threshold_that_time_lowers(seed: int, step: float, size: float) -> None:
    inner = size * np.abs(_history(seed, 90))
    inner[:3] = 0.0
    for r in (RECEPTORS["SA"], replace(RECEPTORS["RA"], rises=(0.0, 0.0))):
        assert pulses(inner, r, step_s=step).tolist() == _pulses_by_loop(inner, r, step)
    assert pulses([5.0], RECEPTORS["SA"], step_s=step).tolist() == [True]
    assert pulses([RECEPTORS["SA"].threshold], RECEPTORS["SA"], step_s=step).tolist() == [False]


@settings(max_examples=30)
@given(seeds, st.integers(1, 12))
def test_a_rate_counts_the_pulses_of_its_window(seed: int, count: int) -> None:
    fired = np.random.default_rng(seed).random((20, 2)) < 0.3
    made = pulse_rate(fired, step_s=2e-3, window_s=count * 2e-3)
    told = [[fired[max(n - count + 1, 0) : n + 1, k].sum() / (count * 2e-3) for k in range(2)] for n in range(20)]
    np.testing.assert_allclose(made, told, atol=1e-9)
    assert pulse_rate(fired, step_s=2e-3, window_s=1e-4)[0, 0] == fired[0, 0] / 2e-3
    # A tenth of a second unless another is asked for.
    long = np.ones((300, 1))
    np.testing.assert_allclose(pulse_rate(long, step_s=1e-3)[:, 0], np.minimum(np.arange(300) + 1, 100) / 0.1)


def test_a_unit_s_pulses_are_those_above_its_own_threshold() -> None:
    inner = np.abs(_history(3, 200))[:, None] * np.array([1.0, 0.4])
    r = RECEPTORS["SA"]
    for threshold in (0.05, 0.4):
        own = replace(r, threshold=threshold)
        told = pulse_rate(pulses(inner, own, step_s=1e-3), step_s=1e-3)
        np.testing.assert_array_equal(unit_output(inner, threshold, "pulse rate", receptor=r, step_s=1e-3), told)
    each = np.array([0.05, 0.4])
    np.testing.assert_allclose(unit_output(inner, each, "amplitude"), np.maximum(inner - each, 0))
    np.testing.assert_array_equal(unit_output(inner, each, "step"), inner > each)
    np.testing.assert_array_equal(unit_output([0.3], 0.3, "step"), [0.0])
    for lacking in ({"receptor": r}, {"step_s": 1e-3}):
        with pytest.raises(InputError, match="the pulse rate needs receptor and step_s"):
            unit_output(inner, 0.1, "pulse rate", **lacking)  # type: ignore[arg-type]


def _sections_by_loop(frame: Floats, theta: Floats, scale: float, step: float, settle: bool) -> NDArray[np.bool_]:
    """R7: a potential that rises toward its end, and a threshold that stands for a step."""
    r = RECEPTORS["SA"]

    def end(stress: float) -> float:
        drive = max(stress, 0.0) / scale
        return drive / (1 + drive / r.ceiling)

    fired = np.zeros((len(theta), *frame.shape), dtype=bool)
    for k, level in enumerate(theta):
        waited = math.ceil(5 * r.tau_m_s / step) if settle else 0
        reached = 1 - math.exp(-(waited + k + 1) * step / r.tau_m_s)
        for at, stress in np.ndenumerate(frame):
            above = end(stress) * reached > end(level) * (1.0 if settle else reached)
            fired[(k, *at)] = above or (k > 0 and fired[(k - 1, *at)])
    return fired


@settings(max_examples=40)
@given(seeds, st.integers(1, 30), st.booleans(), st.sampled_from([0.5e-3, 1e-3, 20e-3]), st.booleans())
def test_sections_are_what_a_falling_threshold_meets(
    seed: int, count: int, settle: bool, step: float, own: bool
) -> None:
    rng = np.random.default_rng(seed)
    frame = rng.normal(1, 1.5, (4, 5))
    frame[0, 0] = 3.0
    full = None if own else 2.5
    scale = frame.max() if own else 2.5
    made = varishold_sections(frame, count, step_s=step, full_scale=full, settle=settle)
    theta = scale * (1 - (np.arange(count) + 0.5) / count)
    np.testing.assert_allclose(made.thresholds, theta)
    fired = _sections_by_loop(frame, theta, scale, step, settle)
    np.testing.assert_array_equal(made.fired, fired)
    told = [[next((k for k in range(count) if fired[k, i, j]), count) for j in range(5)] for i in range(4)]
    np.testing.assert_array_equal(made.first, told)
    # Named thresholds, one below nothing too.
    named = np.array([2.0, 0.7, 0.1, -0.5])
    made = varishold_sections(frame, named, step_s=step, full_scale=full, settle=settle)
    np.testing.assert_array_equal(made.fired, _sections_by_loop(frame, named, scale, step, settle))
    np.testing.assert_allclose(
        made.rebuilt(), sum(made.fired[k] * (named[k] - (named[k + 1] if k < 3 else 0.0)) for k in range(4)), atol=1e-12
    )
    first = int((made.first < 4).sum())
    assert made.bits() == (first + 4) * 5  # 20 addresses and an end mark take five bits
    assert made.bits(coding="raster") == 80


def test_an_idle_frame_fires_nowhere_and_what_is_wrong_is_told() -> None:
    for idle in (np.zeros((2, 3)), np.full((2, 3), -1.0), np.full((2, 3), 1e-310)):
        made = varishold_sections(idle, 4)
        assert not made.fired.any() or idle.max() > 0
        np.testing.assert_allclose(made.thresholds, [0.875, 0.625, 0.375, 0.125])
    tiny = float(np.finfo(float).tiny)
    np.testing.assert_allclose(varishold_sections(np.full((2, 2), tiny), 1).thresholds, [tiny / 2])
    for wrong in ([1.0, 1.0], [], [[2.0, 1.0]], [0.1, 0.2]):
        with pytest.raises(InputError, match="thresholds must be one or more falling values"):
            varishold_sections(np.eye(3), wrong)  # type: ignore[arg-type]
    for name, value in (("step_s", math.inf), ("step_s", -1e-3), ("full_scale", math.nan), ("full_scale", -1.0)):
        with pytest.raises(InputError, match=f"{name} must be positive and finite, got"):
            varishold_sections(np.eye(3), 3, **{name: value})  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"stress must be a history of shape \(n, ...\), got shape \(0,\)"):
        potential([], RECEPTORS["SA"], step_s=1e-3)


# Taxels


def test_what_lies_within_and_without_a_taxel_s_ranges() -> None:
    Taxels(crosstalk=0.2499, bits=1, dead=0.5, stuck=0.5)
    Taxels(bits=32, full_scale=1e-6)
    for wrong, says in (
        ({"crosstalk": 0.25}, "crosstalk of taxels must be below .25"),
        ({"bits": 33}, "bits of taxels must lie in 1 .. 32"),
        ({"dead": 0.5, "stuck": 0.51}, "must not exceed 1 together"),
        ({"noise": math.inf}, "noise of taxels must be finite"),
        ({"noise": 1e300}, "noise of taxels must be at most 1000, got 1e+300"),
        ({"gain_spread": 1001.0}, "gain_spread of taxels must be at most 1000, got 1001"),
        ({"hysteresis": 1e300}, "hysteresis of taxels must be at most 1000"),
        ({"stuck": math.nan}, "stuck of taxels must be finite"),
        ({"full_scale": -1.0}, "full_scale of taxels must be finite and not negative"),
    ):
        with pytest.raises(InputError) as caught:
            Taxels(**wrong)  # type: ignore[arg-type]
        assert says in str(caught.value)
    for shape in ((4,), (1, 2, 3, 4)):
        with pytest.raises(InputError, match="stress must have shape"):
            Taxels().read(np.zeros(shape))


def _read_by_hand(taxels: Taxels, stress: Floats, seed: int) -> Floats:
    """Gains, leak, loop, noise, stuck, dead, saturation, steps: in the order of a signal's way."""
    n, rows, cols = stress.shape
    pad = np.random.default_rng([seed, 0])
    gains = 1 + taxels.gain_spread * pad.standard_normal((rows, cols))
    fate = pad.permutation(rows * cols)
    level = pad.random((rows, cols))
    noise = np.random.default_rng([seed, 1]).standard_normal(stress.shape)
    dead, stuck = round(taxels.dead * rows * cols), round(taxels.stuck * rows * cols)
    scale = np.abs(stress).max() if taxels.full_scale is None else taxels.full_scale
    out = np.empty(stress.shape)
    for i in range(rows):
        for j in range(cols):
            highest = 0.0
            for k in range(n):
                around = [(i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)]
                leak = sum(stress[k][at] * gains[at] for at in around if 0 <= at[0] < rows and 0 <= at[1] < cols)
                value = (1 - 4 * taxels.crosstalk) * stress[k, i, j] * gains[i, j] + taxels.crosstalk * leak
                highest = max(highest, value)
                if highest > 0:
                    value += 4 * taxels.hysteresis * value * (highest - value) / highest
                value += taxels.noise * np.abs(stress[k]).max() * noise[k, i, j]
                fell = fate[i * cols + j]
                value = 0.0 if fell < dead else level[i, j] * scale if fell < dead + stuck else value
                value = value if taxels.full_scale is None else min(value, taxels.full_scale)
                if taxels.bits is not None:
                    step = scale / (2**taxels.bits - 1)
                    value = round(value / step) * step
                out[k, i, j] = value
    return out


@settings(max_examples=40)
@given(
    seeds,
    st.builds(
        Taxels,
        noise=st.sampled_from([0.0, 0.05]),
        crosstalk=st.sampled_from([0.0, 0.07]),
        gain_spread=st.sampled_from([0.0, 0.1]),
        bits=st.sampled_from([None, 1, 5]),
        full_scale=st.sampled_from([None, 0.7, 5.0]),
        hysteresis=st.sampled_from([0.0, 0.2]),
        dead=st.sampled_from([0.0, 0.13]),
        stuck=st.sampled_from([0.0, 0.2]),
    ),
)
def test_taxels_read_as_each_departure_says(seed: int, taxels: Taxels) -> None:
    rng = np.random.default_rng(seed)
    stress = rng.random((4, 3, 5)) * rng.choice([1.0, 2.0], (4, 1, 1))
    np.testing.assert_allclose(taxels.read(stress, seed=seed), _read_by_hand(taxels, stress, seed), atol=1e-9)
    np.testing.assert_allclose(taxels.read(stress[0], seed=seed), _read_by_hand(taxels, stress[:1], seed)[0], atol=1e-9)


def test_a_frame_keeps_its_dimensions_and_an_idle_one_is_read() -> None:
    assert Taxels(bits=8).read(np.ones((3, 4))).shape == (3, 4)
    assert Taxels(bits=8).read(np.ones((1, 3, 4))).shape == (1, 3, 4)
    np.testing.assert_array_equal(Taxels(noise=0.1, hysteresis=0.1, bits=4).read(np.zeros((2, 3, 4))), 0.0)


def test_a_press_is_sensed_over_an_uneven_pad() -> None:
    skin = Skin("winkler", 6e-3, 0.3, 1e-3)
    pressed = press(Sphere(20e-3), skin, depth=1e-3, shape=(6, 10), pitch_m=(2e-3, 1.5e-3), per_taxel=3)
    told = pressed.pressure.reshape(6, 3, 10, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(taxel_stress(pressed)[1:-1, 1:-1], told[1:-1, 1:-1], rtol=2e-2, atol=2e-3 * told.max())
    taxels = Taxels(noise=0.1)
    np.testing.assert_array_equal(sense(pressed), taxel_stress(pressed))
    np.testing.assert_array_equal(sense(pressed, taxels, seed=3), taxels.read(taxel_stress(pressed), seed=3))
    assert not np.array_equal(sense(pressed, taxels), sense(pressed, taxels, seed=3))
