"""Who is handed what when the hand explores: the bench, its pose and setting, capsules along their phalanges, sizes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.exploration import TOUCHES, Felt, PoseEstimate, examples
from varishold.exploration.capsules import grip_contacts
from varishold.exploration.touches import Fingertip, Grasp, Regrasp, Squeeze, grip
from varishold.hand import HandSetting, PadSetting
from varishold.hand.bench import Sensed
from varishold.hand.coordinates import phalanges

SETTING = HandSetting(pads=PadSetting())


class Bench:
    """A bench that knows nothing but where its object was set up."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.time_s = 0.0
        self.circumstances = SimpleNamespace(forward_m=0.1, sideways_m=0.2, yaw_rad=0.3)


def test_every_touch_of_an_example_is_handed_its_bench_and_pose(monkeypatch: pytest.MonkeyPatch) -> None:
    benches: list[Bench] = []
    made: list[tuple[str, Bench, PoseEstimate]] = []
    stood: list[Bench] = []

    def set_up(name: str, size_m: float, *, seed: int, setting: HandSetting) -> tuple[Bench, None]:
        assert (name, size_m, seed) == ("ball", 0.05, 9)
        assert setting is SETTING
        benches.append(Bench(len(benches)))
        return benches[-1], None

    def stand(bench: Bench, setting: HandSetting, place: tuple[float, float, float]) -> None:
        assert setting is SETTING
        assert place == (0.1, 0.2, 0.3)
        stood.append(bench)

    def make(self: Any, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> Felt:
        assert isinstance(bench, Bench)
        assert isinstance(pose, PoseEstimate)
        assert isinstance(setting, HandSetting)
        made.append((self.name, bench, pose))
        return Felt(self, self.name)  # type: ignore[arg-type]

    monkeypatch.setattr(examples, "set_up", set_up)
    monkeypatch.setattr(examples, "stand_up_at", stand)
    for kind in (Grasp, Squeeze, Regrasp, Fingertip):
        monkeypatch.setattr(kind, "make", make)
    examples.touch_all("ball", 0.05, seed=9, setting=SETTING)
    # The touch beyond the middle has a bench and a pose of its own.
    first, second = benches
    assert stood == [first]
    assert [bench for _, bench, _ in made] == [first] * (len(made) - 2) + [second] * 2
    poses = [id(pose) for _, _, pose in made]
    assert len({poses[0], poses[1], poses[-1]}) == 3
    assert poses[1:-2] == [poses[1]] * (len(poses) - 3)
    assert poses[-2] == poses[-1]
    again = examples.touch_beyond("ball", 0.05, seed=9, setting=SETTING)
    assert again is not None
    assert (again.touch.name, made[-1][1]) == ("fingertip-beyond", benches[-1])


def sensed(on: tuple[str, ...], seed: int) -> Sensed:
    angles = np.random.default_rng(seed).uniform(0.1, 0.9, len(SETTING.design.joints))
    names = SETTING.layout.names
    return Sensed(np.array([name in on for name in names]), np.zeros(len(names)), angles, np.zeros(6))


@pytest.mark.parametrize("seed", range(3))
def test_capsules_lie_along_their_phalanges(seed: int) -> None:
    here = sensed((), seed)
    contacts, place = grip_contacts(here, SETTING.design, SETTING.layout), phalanges(here.angles_rad, SETTING.design)
    n = len(place.parts)
    np.testing.assert_array_equal(contacts.start_m[:n], place.start_m)
    far = (contacts.end_m - contacts.start_m)[:n] / place.length_m[:, None]
    np.testing.assert_allclose(far, place.along, atol=1e-12)
    # A digit is a chain: where one phalanx ends the next begins.
    for digit in SETTING.design.digits.values():
        rows = [place.parts.index(part) for part in digit.parts]
        np.testing.assert_allclose(contacts.end_m[rows[:-1]], contacts.start_m[rows[1:]], atol=1e-12)
    assert not contacts.touched.any()


@pytest.mark.parametrize("found", [None, 0.0625])
def test_a_pads_values_are_beside_the_size_of_the_grip(monkeypatch: pytest.MonkeyPatch, found: float | None) -> None:
    asked: list[tuple[str, float | None]] = []
    circle = None if found is None else SimpleNamespace(size_m=found)
    monkeypatch.setattr(grip, "fit_section", lambda contacts, section: circle if section == "circle" else 1 / 0)
    monkeypatch.setattr(grip, "grip_values", lambda contacts: {"grip": 1.0})
    monkeypatch.setattr(grip, "form_values", lambda contacts, surfaces: {"form": float(len(surfaces))})
    monkeypatch.setattr(grip, "grip_reasons", lambda contacts: ())
    monkeypatch.setattr(
        grip, "pad_values", lambda name, surface, *, size_m: asked.append((name, size_m)) or {f"{name}.x": 2.0}
    )
    surfaces = {"index.distal": "a surface", "thumb.distal": "another"}
    monkeypatch.setattr(grip, "surfaces_of", lambda step, setting, pads: surfaces)
    monkeypatch.setattr(Felt, "missing", lambda self, told, pads: ("missing",))
    on = SETTING.layout.names[:3]
    step: Any = SimpleNamespace(sensed=sensed(tuple(on), 0), pads=None)
    evidence, told = TOUCHES["squeeze"].evidence(Felt(TOUCHES["squeeze"], step), SETTING)
    assert told is surfaces
    assert asked == [("index.distal", found), ("thumb.distal", found)]
    assert evidence.touch == "squeeze"
    values = dict(evidence.values)
    assert (values["grip"], values["form"], values["index.distal.x"], values["thumb.distal.x"]) == (1.0, 2.0, 2.0, 2.0)
    few = "squeeze: fewer than three parts touch, so that no section can be fitted"
    assert evidence.remarks == (("missing", few) if found is None else ("missing",))
