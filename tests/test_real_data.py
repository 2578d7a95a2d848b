"""What is quoted of the real recordings; skipped where they are not here."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import varishold
from varishold.touch import SurfaceFeatures, contact_pose, find_contacts, recognize

_BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"

pytestmark = pytest.mark.real_data


def recording(name: str) -> Path:
    path = Path(os.environ.get("VARISHOLD_DATA", _BESIDE)) / name
    if not path.is_file():
        pytest.skip(f"{name} is not here; set VARISHOLD_DATA to the folder that holds the recordings")
    return path


@pytest.fixture(scope="module")
def grasps():
    with np.load(recording("weiss_dsa36.npz"), allow_pickle=False) as data:
        frames = data["frames"][data["start"][:-1] + data["peak"]].astype(float)
        return frames, data["label"], data["texel_mask"]


@pytest.fixture(scope="module")
def fingers():
    with np.load(recording("capcontact_fingers.npz"), allow_pickle=False) as data:
        return data["capacitance"].astype(float), data["contact_coverage_64ths"] / 64.0


def test_grasps_are_read_with_both_fingers_and_their_missing_corners():
    found = varishold.read(recording("weiss_dsa36.npz"))
    assert len(found.pads) == 2
    for pad in found.pads.values():
        assert pad.shape == (13, 6)
        assert (~pad.field).sum() == 10
        assert pad.pitch_m == pytest.approx((3.4e-3, 3.4e-3))


def test_fingers_are_read_with_their_pitch():
    (pad,) = varishold.read(recording("capcontact_fingers.npz")).pads.values()
    assert pad.shape == (41, 72)
    assert pad.n_frames == 1200
    assert pad.pitch_m == pytest.approx((4.79e-3, 4.79e-3))


def test_no_section_reaches_the_missing_corners(grasps):
    frames, _, mask = grasps
    for frame in frames[::40]:
        for finger in (0, 1):
            area = sum(c.profile.area[-1] for c in find_contacts(frame[finger], field=mask[finger], floor=0.0))
            assert 0 < area <= mask[finger].sum() + 1e-9


def test_every_grasp_is_measured(grasps):
    frames, _, mask = grasps
    inputs = SurfaceFeatures(field=mask, pairs=True).fit_transform(frames[::8])
    assert np.isfinite(inputs).all()


def test_shape_of_unseen_objects_from_nearest_neighbours(grasps):
    """One object of each shape held out at once: a quick form of the benchmark."""
    from sklearn.neighbors import KNeighborsClassifier
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    from benchmarks.weiss_touch import SHAPES

    frames, label, mask = grasps
    shape_of = {name: shape for shape, names in SHAPES.items() for name in names}
    known = np.isin(label, list(shape_of))
    frames, label = frames[known], label[known]
    shape = np.array([list(SHAPES).index(shape_of[name]) for name in label])
    held = np.isin(label, ["tennis_ball", "bottle_glass", "dice_large"])
    nearest = make_pipeline(
        SurfaceFeatures(field=mask, pairs=True), StandardScaler(), KNeighborsClassifier(1, metric="manhattan")
    )
    assert nearest.fit(frames[~held], shape[~held]).score(frames[held], shape[held]) > 0.86


def test_a_finger_is_placed_better_by_all_its_sections_than_by_the_weighted_centroid():
    from benchmarks.capcontact import poses, single_contacts, weighted_moments

    frames, truth = single_contacts(recording("capcontact_fingers.npz"))
    assert len(truth) == 2732
    plain = np.array([weighted_moments(np.where(t.blob, frames[t.frame], 0.0))[0] for t in truth])
    position = np.array([t.position for t in truth])
    off = np.hypot(*(plain - position).T)
    assert (np.median(off), np.percentile(off, 95)) == pytest.approx((0.374, 0.916), abs=1e-3)
    off = np.hypot(*(poses(frames, truth, 60.0)[:, :2] - position).T)
    assert np.median(off) <= 0.365
    assert np.percentile(off, 95) <= 0.88


def test_every_contact_gets_an_answer(grasps, fingers):
    (frames, _, mask), (screens, _) = grasps, fingers
    contacts = [c for frame in frames[::50] for c in find_contacts(frame[0], field=mask[0])]
    contacts += [c for screen in screens[::100] for c in find_contacts(screen, floor=60.0)]
    for contact in contacts:
        surface = recognize(contact)
        assert sum(surface.names.values()) == pytest.approx(1)
        assert np.isfinite(contact_pose(contact).position).all()
