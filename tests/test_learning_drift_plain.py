"""Adaptation beside a plain expectation maximization, step by step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.learning.adaptation import _check_enough, _check_explained, _shift, estimate_drift
from varishold.learning.sources import Learned, learn
from varishold.trust import conformal_p_value

MIDDLES = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 1.0], [0.0, 3.0, -1.0]])


def drawn(seed: int, each: int, shift: float = 0.0) -> tuple[dict[str, np.ndarray], np.ndarray]:
    rng = np.random.default_rng(seed)
    codes = np.tile(np.arange(3), each)
    touch = MIDDLES[codes] + rng.normal(0, 0.5, (len(codes), 3)) + shift
    return {"touch": touch, "numbers": codes[:, None] + rng.normal(0, 0.3, (len(codes), 1)) - shift}, codes


@pytest.fixture(scope="module")
def learned() -> Learned:
    measures, codes = drawn(0, 10)
    return learn(measures, codes, 3, np.arange(30) // 10, asked=np.ones(30, bool))[0]


def shift_by_hand(scaled: np.ndarray, usual: np.ndarray, shares: np.ndarray, so_far: np.ndarray) -> np.ndarray:
    rows = [n for n in range(len(scaled)) if not np.isnan(scaled[n]).any()]
    whole = sum(shares[n, k] for n in rows for k in range(len(usual)))
    if whole < 5:
        return np.zeros(len(so_far))
    out = []
    for m in range(len(so_far)):
        off = [(shares[n, k], scaled[n, m] - usual[k, m]) for n in rows for k in range(len(usual))]
        left = sum(w * d for w, d in off) / whole
        variance = sum(w * (d - left) ** 2 for w, d in off) / whole
        shift = so_far[m] + left
        kept = max(1 - 4 * variance / whole / shift**2, 0) if shift else 0.0
        out.append(shift * kept)
    return np.array(out)


@pytest.mark.parametrize(("shift", "error"), [(0.0, 0.05), (0.4, 0.05), (0.4, 0.5)])
def test_drift_is_that_of_eight_plain_steps(learned: Learned, shift: float, error: float) -> None:
    measures, _ = drawn(1, 4, shift)
    measures["numbers"][3] = np.nan
    codes = learned.landmark_codes
    drift = {"touch": np.zeros(3), "numbers": np.zeros(1)}
    for _ in range(8):
        scaled = replace(learned, drift=drift).scaled(measures)
        said, strange = learned.judge(scaled)
        believed = np.array([min(p / error, 1) ** 2 for p in conformal_p_value(strange, learned.known)])
        shares = believed[:, None] * np.exp(said)
        drift = {
            name: shift_by_hand(
                scaled[name],
                np.array([source.landmarks[codes == k].mean(axis=0) for k in range(3)]),
                shares,
                drift[name],
            )
            for name, source in learned.sources.items()
        }
    found = estimate_drift(learned, measures, {}, error)
    assert list(found) == ["touch", "numbers"]
    for name, of in found.items():
        np.testing.assert_allclose(of, drift[name], atol=1e-8)
    assert (max(np.abs(of).max() for of in found.values()) > 0.1) == (shift > 0)


def test_forms_say_what_is_like_what_is_known_and_what_it_is_to_begin_with(learned: Learned) -> None:
    (trained, codes), (measures, _) = drawn(0, 10), drawn(1, 4, 2.5)
    forms = learn({"numbers": trained["numbers"]}, codes, 3, np.arange(30) // 10, asked=np.ones(30, bool))[0]
    with pytest.raises(InputError, match=r"only 0.3 of 12 new presses are like what is known"):
        estimate_drift(learned, measures, {}, 0.2)
    told = {"numbers": measures["numbers"] + 2.5}
    found = estimate_drift(replace(learned, forms=forms), measures, told, 0.2)
    scale = {name: source.scaling.scale for name, source in learned.sources.items()}
    np.testing.assert_allclose(found["touch"] / scale["touch"], 2.5, atol=0.5)
    np.testing.assert_allclose(found["numbers"] / scale["numbers"], -2.5, atol=0.5)
    # Strange forms do not count, and forms that nothing common brings together are told.
    with pytest.raises(InputError, match=r"only 0.3 of 12 new presses are like what is known"):
        estimate_drift(replace(learned, forms=forms), measures, {"numbers": told["numbers"] + 50.0}, 0.2)
    _check_explained(np.ones(8), np.full(8, 0.25))
    with pytest.raises(InputError, match=r"8.0 of 8 new presses have forms that are known, but no drift common to all"):
        _check_explained(np.ones(8), np.full(8, 0.2))


def test_a_shift_is_drawn_to_none_as_far_as_chance_may_have_made_it() -> None:
    rng = np.random.default_rng(2)
    usual = rng.normal(0, 1, (2, 3))
    scaled = np.repeat(usual, 5, axis=0) + rng.normal([0.02, 0.5, -2], 0.3, (10, 3))
    shares = np.repeat([[0.9, 0.1], [0.2, 0.8]], 5, axis=0)
    so_far = np.array([0.0, 0.1, -0.5])
    told = _shift(scaled, usual, shares, so_far)
    np.testing.assert_allclose(told, shift_by_hand(scaled, usual, shares, so_far))
    assert told[2] < -0.5
    # A press of which a source says nothing does not count for it.
    silent = scaled.copy()
    silent[[1, 6], 1] = np.nan
    np.testing.assert_allclose(_shift(silent, usual, shares, so_far), shift_by_hand(silent, usual, shares, so_far))
    # What stands still has no shift, and fewer presses than five tell none.
    assert _shift(np.ones((6, 2)), np.ones((1, 2)), np.ones((6, 1)), np.zeros(2)).tolist() == [0, 0]
    assert _shift(np.ones((4, 2)), np.zeros((1, 2)), np.ones((4, 1)), np.ones(2)).tolist() == [0, 0]
    assert _shift(np.ones((5, 2)), np.zeros((1, 2)), np.ones((5, 1)), np.ones(2)).tolist() == [2, 2]


def test_five_presses_of_two_things_are_enough() -> None:
    _check_enough(np.array([[1.0, 0, 0]] * 4 + [[0, 1.0, 0]] * 4))
    _check_enough(np.array([[0.5, 0.25, 0.25]] * 5))
    with pytest.raises(InputError) as told:
        _check_enough(np.array([[0.98, 0.0], [0.0, 0.98]] * 2 + [[0.5, 0.4]]))
    assert str(told.value) == (
        "only 4.8 of 5 new presses are like what is known, 5 are needed to tell how things have drifted; give more, or "
        "learn again"
    )
    _check_enough(np.array([[1.0, 0, 0]] * 6 + [[0, 0.8, 0]] * 2))
    for shares, but in (([[1.0, 0]] * 6, ""), ([[1.0, 0, 0]] * 6 + [[0, 1.0, 0]], " but for 1.0 of 7.0")):
        with pytest.raises(
            InputError, match=f"the new presses are all of one thing{but}: what has drifted is not told"
        ):
            _check_enough(np.array(shares))


def test_no_drift_leaves_fewer_presses_like_what_is_known_than_none_does(learned: Learned) -> None:
    left_alone = 0
    for seed in range(160, 240):
        # Each thing has changed by itself, and nothing in common.
        rng = np.random.default_rng(seed)
        codes = rng.choice(3, 60, p=rng.dirichlet(np.ones(3)))
        changed = MIDDLES + rng.normal(0, 0.8, (3, 3))
        touch = changed[codes] + rng.normal(0, 0.5, (60, 3))
        measures = {"touch": touch, "numbers": codes[:, None] + rng.normal(0, 0.3, (60, 1))}
        try:
            drift = estimate_drift(learned, measures, {}, 0.05)
        except InputError:
            continue
        before, after = (
            np.minimum(conformal_p_value(judging.judge(judging.scaled(measures))[1], learned.known) / 0.05, 1) ** 2
            for judging in (learned, replace(learned, drift=drift))
        )
        assert after.sum() >= min(before.sum(), 0.95 * 60)
        left_alone += not any(of.any() for of in drift.values())
    assert 5 < left_alone < 20
