"""Pads, features, pictures and tables of the hand, each beside what it should say of a made-up grasp."""

from __future__ import annotations

import importlib
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.scripted_bench import ScriptedBench, angles_at

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.errors import InputError, NotConvergedError
from varishold.hand import HandDesign, PadSetting, Step
from varishold.hand import pads as padding
from varishold.hand.bench import Sensed
from varishold.hand.coordinates import contact_points, grip_circle
from varishold.hand.features import _curvature, _stiffness, features
from varishold.hand.layouts import PAPER_22
from varishold.hand.pads import PadFrames
from varishold.skin import Skin, Taxels

DESIGN = HandDesign()
collecting = importlib.import_module("varishold.hand.collect")


# Pads


class Pressed(ScriptedBench):
    """Every part that has a force is pressed by a flat surface, one that is bent, or none."""

    forces: dict[str, float]

    def object_forces_n(self) -> dict[str, float]:
        return dict.fromkeys(DESIGN.parts, 0.0) | self.forces


def test_pads_press_what_lies_before_them_with_the_force_that_they_bear(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Pressed()
    bench.forces = {"index.middle": 0.6, "thumb.distal": 0.09, "palm": 2.0, "ring.distal": 0.1, "little.middle": 0.5}
    setting = PadSetting(taxels=Taxels(noise=0.02), palm_pitch_m=0.006)
    told: dict[str, Any] = {}

    def surface(b: Any, part: str, shape: tuple[int, int], pitch_m: float) -> Any:
        return None if part == "little.middle" else (part, shape, pitch_m)

    def press(height: Any, skin: Skin, **how: Any) -> Any:
        if height[0] == "ring.distal":
            raise NotConvergedError("no depth found")
        told[height[0]] = (height, skin, how)
        return height

    def sense(pressed: Any, taxels: Taxels, *, seed: int) -> Any:
        assert taxels in (setting.taxels, PadSetting().taxels)
        return np.full(pressed[1], float(seed))

    monkeypatch.setattr(padding, "surface_before", surface)
    monkeypatch.setattr(padding, "press", press)
    monkeypatch.setattr(padding, "sense", sense)
    made = padding.press_pads(bench, setting=setting, seed=3)
    assert set(told) == {"index.middle", "palm"}
    parts = list(DESIGN.parts)
    for part, pitch, cells in (("index.middle", 0.002, 2), ("palm", 0.006, 6)):
        height, skin, how = told[part]
        shape = padding.pad_shape(part, DESIGN, setting)
        assert height == (part, shape, pitch)
        assert skin is setting.skin
        assert how == {
            "force": bench.forces[part],
            "shape": shape,
            "pitch_m": pitch,
            "per_taxel": cells,
            "tolerance": setting.tolerance,
        }
        assert (made.frames[part] == 3000 + parts.index(part)).all()
    for part in parts:
        assert made.frames[part].shape == padding.pad_shape(part, DESIGN, setting)
        assert made.pitch_m[part] == (0.006 if part == "palm" else 0.002)
        if part not in told:
            assert (made.frames[part] == 0).all()
    assert made.force_n == bench.object_forces_n()
    # Nothing asked for: the usual pads and seed.
    usual = padding.press_pads(bench)
    assert (usual.frames["index.middle"] == parts.index("index.middle")).all()
    assert usual.pitch_m["palm"] == 0.004


def test_a_solver_s_warning_that_it_stopped_short_is_not_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Pressed()
    bench.forces = {"palm": 1.0}
    flat = lambda *a: np.zeros((44, 42))  # noqa: E731
    monkeypatch.setattr(padding, "surface_before", flat)
    setting = PadSetting(tolerance=1e-9, taxels=Taxels())
    frame = padding.press_pads(bench, setting=setting).frames["palm"]
    assert frame.sum() * 0.004**2 == pytest.approx(1.0, rel=0.2)


def test_what_cannot_be_pads_is_told() -> None:
    for wrong, says in (
        ({"least_n": 0.0}, "least_n of the pads must be positive"),
        ({"tolerance": math.inf}, "tolerance of the pads must be positive"),
        ({"palm_pitch_m": -1.0}, "palm_pitch_m of the pads must be positive"),
        ({"cells_a_taxel": 0}, "cells_a_taxel of the pads must lie in 1 .. 16, got 0"),
        ({"cells_a_taxel": 17}, "cells_a_taxel of the pads must lie in 1 .. 16, got 17"),
        ({"skin": Skin("half-space")}, "the pads' skin needs youngs_modulus_pa"),
    ):
        with pytest.raises(InputError, match=says):
            PadSetting(**wrong)  # type: ignore[arg-type]
    usual = PadSetting(cells_a_taxel=16)
    assert (usual.phalanx_pitch_m, usual.palm_pitch_m, usual.least_n, usual.tolerance) == (0.002, 0.004, 0.1, 1e-3)
    assert PadSetting(cells_a_taxel=1).skin == Skin("layer", 4e-3, 0.45, 1e-3, 1.5e5)
    assert (usual.taxels, PadSetting().cells_a_taxel) == (Taxels(noise=0.01), 2)


# Features


def _curvature_by_hand(line: np.ndarray, pitch: float, stiffness: float) -> float:
    """The parabola through what stands above .4 of the peak beside it; through three columns where fewer do."""
    top = int(np.argmax(line))
    first = last = top
    while first > 0 and line[first - 1] > 0.4 * line[top]:
        first -= 1
    while last < len(line) - 1 and line[last + 1] > 0.4 * line[top]:
        last += 1
    if last - first < 2:
        first, last = max(top - 1, 0), min(top + 1, len(line) - 1)
    if last - first < 2:
        first = 0 if first == 0 else len(line) - 3
        last = first + 2
    x = np.arange(first, last + 1) * pitch
    a, _, _ = np.linalg.lstsq(np.stack([x * x, x, np.ones_like(x)], axis=1), line[first : last + 1], rcond=None)[0]
    return -2 * a / stiffness


@given(st.integers(0, 2**31), st.integers(3, 12))
@settings(max_examples=60)
def test_a_curvature_is_that_of_the_parabola_through_the_peak(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    frame = rng.random((4, n)) ** 3 + np.exp(-((np.arange(n) - rng.uniform(-1, n)) ** 2) / rng.uniform(0.5, 20))
    skin = PadSetting().skin
    line = 1e4 * frame.mean(axis=0)
    told = _curvature_by_hand(line, 0.002, _stiffness(skin))
    assert _curvature(1e4 * frame, 0.002, skin) == pytest.approx(told, rel=1e-6)
    assert _curvature(-frame, 0.002, skin) is None
    assert _curvature(0 * frame, 0.002, skin) is None


def test_a_stiffness_is_that_of_a_confined_layer() -> None:
    assert _stiffness(Skin("layer", 2e-3, 0.3, youngs_modulus_pa=1e5)) == pytest.approx(1e5 * 0.7 / (1.3 * 0.4) / 2e-3)
    # An incompressible one is taken for one that hardly yields; what is unknown, for the usual pad's.
    nearly = 0.5 / (1.5 * 0.02) / 1e-3
    assert _stiffness(Skin("layer", 1e-3, 0.5)) == pytest.approx(nearly)
    assert _stiffness(Skin("half-space", poisson=0.0)) == pytest.approx(1 / 0.004)


def _felt(closed: Sequence[str], angles: np.ndarray) -> Sensed:
    on = np.array([name in closed for name in PAPER_22.names])
    return Sensed(on, on.astype(float), angles, np.zeros(6))


def _step(sensed: Sensed, frames: dict[str, np.ndarray]) -> Step:
    force = {part: float(part in frames) for part in DESIGN.parts}
    every = {part: frames.get(part, np.zeros((8, 10))) for part in DESIGN.parts}
    return Step(5, "grip", sensed, True, True, PadFrames(every, dict.fromkeys(DESIGN.parts, 0.002), force))


def test_surfaces_are_told_by_their_extremes_in_decades() -> None:
    x = np.arange(10) - 4.5
    skin = PadSetting().skin
    unit = 0.5 * 0.002**2 * _stiffness(skin)
    frames = {
        "index.middle": 1e6 * np.ones((8, 1)) - 40 * unit * x**2 * np.ones((8, 1)),
        "thumb.distal": 1e6 * np.ones((8, 1)) + 5 * unit * x**2 * np.ones((8, 1)),
        "ring.middle": 1e6 * np.ones((8, 1)) - 12 * unit * x**2 * np.ones((8, 1)),
    }
    got = features(_step(_felt((), np.zeros(15)), frames), "surface", design=DESIGN, layout=PAPER_22).analog
    bends = np.array([40.0, -5.0, 12.0])
    assert got["surface.sharpest"] == pytest.approx(math.log10(41))
    assert got["surface.flattest"] == pytest.approx(-math.log10(6), rel=1e-6)
    assert got["surface.range"] == pytest.approx(45 / 40)
    assert got["surface.spread"] == pytest.approx(bends.std() / np.abs(bends).mean())
    # What is flat everywhere has no spread that noise could make: below half a metre's curve counts as half.
    faint = {
        "palm": 1e6 * np.ones((8, 1)) - 0.1 * unit * x**2 * np.ones((8, 1)),
        "thumb.distal": 1e6 * np.ones((8, 10)),
    }
    got = features(_step(_felt((), np.zeros(15)), faint), "surface", design=DESIGN, layout=PAPER_22).analog
    assert got["surface.range"] == pytest.approx(0.1 / 0.5, rel=1e-3)
    assert got["surface.spread"] == pytest.approx(0.05 / 0.5, rel=1e-3)
    none = features(_step(_felt((), np.zeros(15)), {}), "surface", design=DESIGN, layout=PAPER_22).analog
    assert set(none.values()) == {0.0}


def test_coordinates_go_by_pads_where_the_surface_is_felt_and_by_switches_where_contact_is() -> None:
    angles = angles_at(0.05, -0.03)
    pressed = np.zeros((8, 10))
    pressed[:, 8] = 1.0
    step = _step(_felt(("index_distal", "thumb_distal", "thumb_middle"), angles), {"index.distal": pressed})
    by_switch = features(step, "contact+coordinates", design=DESIGN, layout=PAPER_22)
    by_pad = features(step, "surface+coordinates", design=DESIGN, layout=PAPER_22)
    contacts = contact_points(step.sensed, DESIGN, PAPER_22)
    circle = grip_circle(contacts)
    assert circle is not None
    size = max(circle.diameter_m, 0.02)
    assert by_switch.analog["coordinate.thumb.distal.off"] == pytest.approx(abs(circle.off_m[-1]) / size)
    # One pad alone makes no circle.
    assert by_pad.analog["coordinate.off"] == 0
    assert not by_pad.on_off
    assert by_switch.on_off["switch.thumb_middle"]
    # A grip that has closed to nothing counts as two centimetres.
    near = contact_points(_felt(("index_distal", "thumb_distal"), angles_at(0.004, -0.004)), DESIGN, PAPER_22)
    small = grip_circle(near)
    assert small is not None
    tight = _step(_felt(("index_distal", "thumb_distal"), angles_at(0.004, -0.004)), {})
    told = features(tight, "contact+coordinates", design=DESIGN, layout=PAPER_22).analog
    beyond = np.maximum(np.abs(small.beside_m) - near.slack_m, 0).max() / max(small.diameter_m, 0.02)
    assert told["coordinate.beyond"] == pytest.approx(beyond)
