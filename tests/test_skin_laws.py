"""Equations [9]-[13] hold on the surface that is seen through the skin, and not on its pressure."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold.levelset import Profile
from varishold.skin import PressedSolid, Skin, Taxels, press, reconstruct, sense
from varishold.solids import Drawn, draw_contact
from varishold.touch import find_contacts

LAYER = Skin("layer", 6e-3, 0.45, 1e-3)
SKINS = (
    LAYER,
    Skin("layer", 6e-3, 0.5, 1e-3),
    Skin("layer", 2e-3, 0.3, 1e-3),
    Skin("half-space", sensing_depth_m=1e-3),
    Skin("winkler", 6e-3, 0.3, 1e-3),
)
FORM = {
    "cylinder": "pillar",
    "square-pillar": "pillar",
    "rectangular-pillar": "pillar",
    "edge": "pillar",
    "plane": "plane",
    "sphere": "pyramidal",
    "cone": "pyramidal",
    "pyramid": "pyramidal",
    "ridge": "ridge",
    "hip": "ridge",
    "wedge": "ridge",
    "lying-cylinder": "ridge",
    "cone-frustum": "frustum",
    "pyramid-frustum": "frustum",
}


def _drawn(name: str, seed: int = 0) -> Drawn:
    rng = np.random.default_rng(seed)
    return draw_contact(rng, name, field_m=(32e-3, 32e-3), size_m=(15e-3, 18e-3), slope=(0.1, 0.14), aspect=(1.6, 1.8))


def _pressed(name: str, skin: Skin) -> PressedSolid:
    drawn = _drawn(name)
    return press(drawn.solid, skin, depth=drawn.depth_m, pose=drawn.pose)


def _profile(height: NDArray[np.float64], pitch: tuple[float, float]) -> Profile:
    contacts = find_contacts(height, levels=40, pitch=pitch)
    assert len(contacts) == 1
    return contacts[0].profile


def _check_law(form: str, profile: Profile, field_area: float) -> None:
    """The law of growth from X_1 to X~, with the lowest section X~ as the measure."""
    place = profile.threshold / profile.threshold[0]
    area = profile.area / profile.area[-1]
    assert (np.diff(profile.area) >= 0).all(), "sections nest"

    def at(share: float) -> int:
        return int(np.argmin(np.abs(place - share)))

    minor, major = profile.extent.min(axis=1), profile.extent.max(axis=1)
    if form == "plane":  # [13]
        assert profile.area[at(0.7)] > 0.97 * field_area
    elif form == "pillar":  # [9]
        assert area[at(0.7)] > 0.8
    elif form == "pyramidal":  # [10]: X_1 is a point
        assert area[0] < 0.1
        assert area[at(0.9)] < area[at(0.7)] < area[at(0.5)] < 0.75
    elif form == "ridge":  # [11]: X_1 is a segment
        assert minor[at(0.97)] < 0.45 * minor[-1]
        assert major[at(0.9)] > 0.3 * major[-1]
        assert area[at(0.9)] < area[at(0.7)] < area[at(0.5)] < 0.9
    else:  # [12]: X_1 is a small closed plane
        assert 0.03 < area[at(0.9)] < area[at(0.7)] < area[at(0.4)] < area[at(0.1)]
        assert area[at(0.9)] < 0.75


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: f"{skin.kind}-{skin.thickness_m}-{skin.poisson}")
@pytest.mark.parametrize("name", list(FORM))
def test_laws_hold_on_the_true_surface(name: str, skin: Skin) -> None:
    """Inside the contact the skin has the object's form, whatever the skin."""
    pressed = _pressed(name, skin)
    inside = np.where(pressed.contact, pressed.displacement_m, 0.0)
    # The contact line: where a flat face has none, its wall stands on the free skin around it.
    form = FORM[name]
    line = 0.0 if form in ("plane", "pillar") else float(pressed.displacement_m[pressed.contact].min())
    height = np.where(pressed.contact, np.maximum(inside - line, 0.0), 0.0)
    _check_law(form, _profile(height, (0.25e-3, 0.25e-3)), 32e-3**2)


@pytest.mark.parametrize("name", list(FORM))
def test_laws_hold_on_the_reconstructed_surface(name: str) -> None:
    frame = sense(_pressed(name, LAYER), Taxels(noise=0.01), seed=4)
    relief = reconstruct(frame, LAYER, pitch=1e-3)
    _check_law(FORM[name], _profile(relief.height, relief.pitch_m), 32e-3**2)


def test_laws_fail_on_pressure() -> None:
    """A flat punch on a half-space presses hardest at its rim: X_1 is a ring, and the sections grow."""
    pressed = _pressed("cylinder", Skin("half-space"))
    profile = find_contacts(pressed.pressure, levels=40, pitch=0.25e-3)[0].profile
    upper = profile.threshold > 0.5 * profile.threshold[0]
    assert profile.holes[upper].max() >= 1
    assert profile.area[upper].max() < 0.5 * profile.area[-1]
    # And so does the frustum at its shoulder.
    frustum = _pressed("cone-frustum", Skin("half-space"))
    assert find_contacts(frustum.pressure, levels=40, pitch=0.25e-3)[0].profile.holes.max() >= 1


@pytest.mark.parametrize("name", ["cylinder", "square-pillar", "rectangular-pillar", "plane", "ridge"])
@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: f"{skin.kind}-{skin.thickness_m}-{skin.poisson}")
def test_flat_punch_plane_and_ridge_are_one_contact_each(name: str, skin: Skin) -> None:
    for seed in range(3):
        drawn = _drawn(name, seed)
        pressed = press(drawn.solid, skin, depth=drawn.depth_m, pose=drawn.pose)
        frame = sense(pressed, Taxels(noise=0.01), seed=seed)
        assert len(find_contacts(frame, pitch=1e-3)) == 1
