"""The simulated skin: what presses it, how it warms, creeps and flickers, and its clock."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.live_clock import Clock

from varishold.errors import LostSourceError
from varishold.live import PadLayout, pace, samples_of, source_at
from varishold.live.simulated_skin import Press, SimulatedSkin, SkinTraits
from varishold.solids import SOLIDS, draw_contact, ideal_frame


def readings(count: int, rate_hz: float = 100.0, *, seed: int = 0, **traits: Any) -> tuple[np.ndarray, list[Any]]:
    """Return frames of a simulated skin, the rest taken off, and the presses that they show."""
    plain = {"forms": ("sphere",), "noise": 0.0, "drift": 0.0, "creep": 0.0, "moves": 0.0}
    skin, frames, presses = SimulatedSkin(SkinTraits(**{**plain, **traits}), rate_hz=rate_hz, seed=seed), [], deque()
    for _ in range(count):
        frames.append(skin.next_frame().astype(float) - 200)
        if not presses or presses[-1] is not skin.press:
            presses.append(skin.press)
    return np.array(frames), list(presses)


def test_a_simulated_skin_shows_what_is_said_to_press_and_nothing_else() -> None:
    frames, presses = readings(3000)
    at = np.arange(3000) / 100
    total = frames.sum(axis=(1, 2))
    pressed = np.zeros(3000, np.bool_)
    ends_s = 0.0
    for press in presses:
        assert 0.6 <= press.start_s - ends_s <= 1.6
        assert 0.5 <= press.hold_s <= 2.5
        assert press.end_s == pytest.approx(press.start_s + press.hold_s + 0.3)
        ends_s = press.end_s
        inside = (at > press.start_s + 0.02) & (at < press.end_s - 0.02)
        held = (at > press.start_s + 0.16) & (at < press.end_s - 0.16)
        pressed |= (at >= press.start_s) & (at <= press.end_s)
        assert (total[inside] > 0).all()
        assert np.ptp(total[held]) == 0
        assert total[inside].max(initial=0) <= total[held].max(initial=np.inf)
        rises = total[(at > press.start_s) & (at < press.start_s + 0.15)]
        assert (np.diff(rises) >= 0).all()
    assert (frames[~pressed] == 0).all()
    # How high it stands: 1500 counts at an eighth of the pad's side.
    deep = max(press.drawn.depth_m for press in presses[:-1])
    assert frames.max() == pytest.approx(1500 * deep / (16 * 2e-3 / 8), rel=0.1)


def test_warmth_lifts_a_skin_taxel_by_taxel_and_load_creeps_up() -> None:
    rest = {"rest_s": (1e5, 1e5)}
    frames, _ = readings(1200, 1.0, drift=500.0, seed=3, **rest)
    mean = frames.mean(axis=(1, 2))
    assert mean[300] - mean[0] == pytest.approx(500 * (1 - math.exp(-1)), abs=0.3 * 500 * 2.1)
    assert mean[600:].mean() > 300
    # Each by its own share, a quarter more or less.
    share = frames[1000] / frames[1000].mean()
    assert 0.15 < share.std() < 0.35
    swings, _ = readings(4000, 1.0, drift=500.0, seed=3, **rest)
    late = swings[2000:].mean(axis=(1, 2))
    assert np.ptp(late[:1200]) == pytest.approx(0.6 * 500, rel=0.15)
    assert late[:600].mean() + late[600:1200].mean() == pytest.approx(2 * late[1200:].mean(), rel=0.15)
    # It swings in twenty minutes: the same comes back, and in between its opposite.
    slow = swings.mean(axis=(1, 2))
    assert slow[2600:2800] == pytest.approx(slow[1400:1600], abs=10)
    assert slow[2000:2200] + slow[2600:2800] == pytest.approx(np.full(200, 2 * slow[1600:2800].mean()), abs=15)
    pressed, (press, *_) = readings(4000, 100.0, creep=0.5, hold_s=(30.0, 30.0), rest_s=(1.0, 1.0))
    begins = round(100 * (press.start_s + 0.2))
    total = pressed.sum(axis=(1, 2))
    grown = [total[begins + 100 * k] / total[begins] for k in (0, 8, 24)]
    for ratio, time_s in zip(grown, (0.0, 8.0, 24.0), strict=True):
        assert ratio == pytest.approx(1 + 0.5 * (1 - math.exp(-time_s / 8)), abs=0.03)
    # It comes back as slowly.
    left = total[round(100 * press.end_s) + 5 + 100]
    assert 0.2 * total[begins] < left < 0.5 * total[begins]


def test_noise_is_as_strong_as_is_said_and_full_scale_is_the_end() -> None:
    frames, _ = readings(300, noise=7.0, rest_s=(1e5, 1e5))
    assert frames.std() == pytest.approx(7.0, rel=0.05)
    assert abs(frames.mean()) < 0.2
    high, _ = readings(400, creep=30.0, hold_s=(3.0, 3.0), rest_s=(0.1, 0.1))
    assert high.max() == 4095 - 200
    low, _ = readings(50, noise=400.0)
    assert low.min() == -200


@pytest.mark.parametrize("moves", [0.0, 0.5, 1.0])
def test_so_many_presses_move_and_all_ways(moves: float) -> None:
    skin = SimulatedSkin(SkinTraits(("sphere", "cone"), moves=moves), rate_hz=0.5, seed=4)
    presses = [skin._next_press(0.0) for _ in range(200)]
    far = np.array([math.hypot(*press.motion_m) for press in presses]) / 2e-3
    assert np.mean(far > 0) == pytest.approx(moves, abs=0.15)
    assert ((far == 0) | ((far > 1 - 1e-9) & (far < 3 + 1e-9))).all()
    assert {press.form for press in presses} == {"sphere", "cone"}
    # What presses is a third to six tenths of the pad wide, and deep in proportion: none is too small to be told.
    deep = np.array([press.drawn.depth_m for press in presses])
    assert deep.min() > 0.5 * 0.35 * 0.2 * 16 * 2e-3
    assert deep.max() < 0.6 * 0.35 * 16 * 2e-3 + 1e-9
    if moves == 0.5:
        wide = []
        for press in presses[:60]:
            face = ideal_frame(press.drawn.solid, (64, 64), 0.5e-3, depth_m=press.drawn.depth_m)
            wide.append(2 * math.sqrt(np.count_nonzero(face > 0) / math.pi) / 64)
        assert 0.3 < min(wide) < 0.4
        assert 0.53 < max(wide) < 0.63
    if moves:
        toward = np.array([press.motion_m for press in presses])[far > 0]
        assert (np.abs(np.mean(np.sign(toward), axis=0)) < 0.35).all()
    for press in presses[:20]:
        half = press.place_at(press.start_s + 0.15 + press.hold_s / 2)
        pose = press.drawn.pose
        assert half == pytest.approx((pose.x_m + press.motion_m[0] / 2, pose.y_m + press.motion_m[1] / 2))


def test_a_simulated_skin_has_a_clock_of_its_own_that_is_a_little_fast(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch, pace)
    source = source_at("sim:sphere?speed=2&rate_hz=20&duration_s=3.02&pads=3")
    assert list(source.pads) == ["pad1", "pad2", "pad3"]
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)
    began_s, samples = clock.time(), list(samples_of(source))
    assert [one.sequence for one in samples] == list(range(60))
    device_s = np.array([one.device_time_s for one in samples])
    assert device_s[0] == pytest.approx(12.0)
    assert np.diff(device_s) * 20 - 1 == pytest.approx(40e-6, abs=1e-6)
    # Each comes when it is due, at twice the skin's speed: the first when its time is over.
    host_s = np.array([one.host_time_s for one in samples]) - began_s
    assert host_s == pytest.approx(np.arange(1, 61) / 40, abs=1e-3)
    # Opened anew it begins anew.
    again = list(samples_of(source))
    assert all(np.array_equal(a.pads["pad2"], b.pads["pad2"]) for a, b in zip(samples, again, strict=True))


def test_a_skin_that_is_no_square_is_pressed_by_what_fits_its_shorter_side() -> None:
    skin, deep = SimulatedSkin(SkinTraits(("sphere", "cone"), shape=(8, 40)), rate_hz=0.5, seed=3), []
    for _ in range(200):
        deep.append(skin.press.drawn.depth_m)
        skin.next_frame()
    assert max(deep) < 0.6 * 0.35 * 8 * 2e-3 + 1e-9


def test_what_is_not_asked_for_is_the_usual() -> None:
    forms = tuple(SOLIDS)
    usual = SkinTraits(forms, (16, 16), 2e-3, 4.0, 58.0, 0.12, 0.3, (0.5, 2.5), (0.6, 1.6))
    plain: Any = source_at("sim:")
    assert plain._traits == source_at("sim:all")._traits == SkinTraits(forms) == usual  # type: ignore[attr-defined]
    assert (plain._timing.rate_hz, plain._timing.speed, plain._timing.duration_s) == (100.0, 1.0, math.inf)
    assert plain._seeds == {"pad": 0}
    told: Any = source_at(
        "sim:cone,hip?seed=7&pads=2&shape=5x9&pitch_m=0.003&noise=1&drift=-2&creep=0.5&moves=1&hold_s=3&rest_s=4"
        "&rate_hz=50&speed=2&duration_s=6"
    )
    assert told._traits == SkinTraits(("cone", "hip"), (5, 9), 3e-3, 1.0, -2.0, 0.5, 1.0, (3.0, 3.0), (4.0, 4.0))
    assert (told._timing.rate_hz, told._timing.speed, told._timing.duration_s) == (50.0, 2.0, 6.0)
    assert told._seeds == {"pad1": 7, "pad2": 8}
    assert told.pads["pad2"] == PadLayout((5, 9), pitch_m=(0.003, 0.003))


# The same by plain sums.


def pressed_by_hand(traits: SkinTraits, seed: int, count: int) -> list[Press]:
    """Return the first presses of a skin, drawn one number after the other."""
    rng, presses, ends_s = np.random.default_rng([seed, 1]), [], 0.0
    (rows, cols), pitch = traits.shape, traits.pitch_m
    short = min(rows, cols) * pitch
    for _ in range(count):
        form = traits.forms[int(rng.integers(len(traits.forms)))]
        size, slope = (0.35 * short, 0.6 * short), (0.2, 0.35)
        drawn = draw_contact(rng, form, field_m=(rows * pitch, cols * pitch), size_m=size, slope=slope)
        start_s = ends_s + rng.uniform(*traits.rest_s)
        hold_s = rng.uniform(*traits.hold_s)
        way, toward = rng.uniform(1, 3) * pitch, rng.uniform(-math.pi, math.pi)
        moves = rng.random() < traits.moves
        motion = (way * math.cos(toward), way * math.sin(toward)) if moves else (0.0, 0.0)
        presses.append(Press(form, drawn, start_s, hold_s, motion))
        ends_s = start_s + hold_s + 0.3
    return presses


def load_by_hand(traits: SkinTraits, press: Press, time_s: float) -> np.ndarray:
    """Return the counts of a press: it comes and goes in 0.15 s by half a cosine, and moves evenly while it is held."""
    since, left = time_s - press.start_s, press.start_s + press.hold_s + 0.3 - time_s
    if min(since, left) <= 0:
        return np.zeros(traits.shape)
    rise = 0.5 - 0.5 * math.cos(math.pi * min(since / 0.15, left / 0.15, 1.0))
    moved = min(max((since - 0.15) / press.hold_s, 0.0), 1.0)
    pose = press.drawn.pose
    at = replace(pose, x_m=pose.x_m + moved * press.motion_m[0], y_m=pose.y_m + moved * press.motion_m[1])
    depth_m = press.drawn.depth_m * rise
    above = ideal_frame(press.drawn.solid, traits.shape, traits.pitch_m, depth_m=depth_m, pose=at, per_taxel=4)
    return np.asarray(1500 * 8 / (min(traits.shape) * traits.pitch_m) * above)


@pytest.mark.parametrize(
    ("seed", "rate_hz", "traits"),
    [
        (0, 20.0, SkinTraits(("sphere", "cone"))),
        (3, 4.0, SkinTraits(("cone", "ridge", "hip"), (5, 9), 3e-3, noise=0.0, drift=900.0, creep=0.9, moves=0.5)),
        (8, 50.0, SkinTraits(("edge",), (12, 4), 1e-3, 40.0, -800.0, 0.0, 1.0, (0.2, 0.3), (0.0, 0.4))),
    ],
)
def test_a_frame_is_the_sum_of_load_creep_warmth_walk_and_noise(seed: int, rate_hz: float, traits: SkinTraits) -> None:
    skin = SimulatedSkin(traits, rate_hz=rate_hz, seed=seed)
    noise, pad = np.random.default_rng([seed, 0]), np.random.default_rng([seed, 2])
    share, phase = 1 + 0.25 * pad.standard_normal(traits.shape), pad.uniform(0, 2 * math.pi)
    crept, walk = np.zeros(traits.shape), np.zeros(traits.shape)
    step = math.exp(-1 / rate_hz / 600)
    presses, off = [], []
    for k in range(300):
        time_s = k / rate_hz
        assert skin.time_s == pytest.approx(time_s)
        frame = skin.next_frame()
        if not presses or presses[-1] is not skin.press:
            presses.append(skin.press)
        load = load_by_hand(traits, skin.press, time_s)
        crept += (load - crept) * (1 - math.exp(-1 / rate_hz / 8))
        walk = step * walk + 0.05 * traits.drift * math.sqrt(1 - step**2) * noise.standard_normal(traits.shape)
        warmth = 1 - math.exp(-time_s / 300) + 0.3 * math.sin(2 * math.pi * time_s / 1200 + phase)
        reading = 200 + load + traits.creep * crept + traits.drift * warmth * share + walk
        reading = reading + traits.noise * noise.standard_normal(traits.shape)
        off.append(frame - np.clip(np.rint(reading), 0, 4095))
    # A half may be rounded either way.
    assert np.abs(off).max() <= 1
    assert np.count_nonzero(off) <= 3
    assert len(presses) >= 5
    for press, expected in zip(presses, pressed_by_hand(traits, seed, len(presses)), strict=True):
        assert (press.form, press.drawn) == (expected.form, expected.drawn)
        assert (press.start_s, press.hold_s) == pytest.approx((expected.start_s, expected.hold_s))
        assert press.motion_m == pytest.approx(expected.motion_m)
