"""The frames of the yardstick: the same by the same seed, and apart from training."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from varishold.evaluation.yardstick import faults
from varishold.evaluation.yardstick.forms import KINDS, Change
from varishold.evaluation.yardstick.media import clean_frames
from varishold.evaluation.yardstick.rows import NOISE, ROWS, distorted

CLEAN = {medium: clean_frames(medium, 16, Change(), 2, 5) for medium in ("ideal", "cover")}
BY_NAME = {row.name: row for row in ROWS}


@pytest.mark.parametrize("medium", ["ideal", "cover"])
def test_the_same_seed_gives_the_same_frames(medium: str) -> None:
    frames, kinds = CLEAN[medium]
    again, named = clean_frames(medium, 16, Change(), 2, 5)
    assert np.array_equal(frames, again)
    assert np.array_equal(kinds, named)
    assert frames.shape == (2 * len(KINDS), 16, 16)
    assert np.array_equal(frames.max(axis=(1, 2)), np.ones(len(frames)))
    assert not np.array_equal(frames, clean_frames(medium, 16, Change(), 2, 6)[0])


def test_fewer_frames_are_the_first_of_more() -> None:
    frames, kinds = CLEAN["ideal"]
    fewer, named = clean_frames("ideal", 16, Change(), 1, 5)
    assert np.array_equal(frames[::2], fewer)
    assert np.array_equal(kinds[::2], named)


@pytest.mark.parametrize(
    ("medium", "name", "across", "down"),
    [
        ("ideal", "clean", 1.153327, 0.766319),
        ("ideal", "ghosts 15 %", 1.350317, 0.868662),
        ("cover", "memory of a quarter", 0.733877, 1.660264),
        ("cover", "bad mix", 1.719743, 1.908201),
    ],
)
def test_the_frames_of_version_one_stay_what_they_are(medium: str, name: str, across: float, down: float) -> None:
    """Each frame weighed by its number, its rows and its columns: other frames are another version."""
    read, _ = distorted(BY_NAME[name], *CLEAN[medium], medium, 5)
    weighed = np.einsum("kij,k->ij", read, np.cos(np.arange(len(read)))) / len(read)
    assert weighed.sum(axis=0) @ np.sin(np.arange(16)) == pytest.approx(across, abs=1e-3)
    assert weighed.sum(axis=1) @ np.sin(np.arange(16)) == pytest.approx(down, abs=1e-3)


@pytest.mark.parametrize(
    ("medium", "change", "across", "down"),
    [
        ("ideal", Change(rounding=0.25), 0.883632, 0.833398),
        ("ideal", Change(rounding=0.5), 1.004812, 1.257719),
        ("ideal", Change(tilt=5.0), 0.538829, 0.267097),
        ("ideal", Change(cut=0.3), 2.035918, 0.944297),
        ("cover", Change(rounding=0.5), 0.620662, 1.534740),
        ("cover", Change(tilt=10.0), 0.564871, 0.365726),
        ("cover", Change(cut=0.3), 2.025525, 2.095570),
    ],
)
def test_the_poses_of_version_one_stay_what_they_are(medium: str, change: Change, across: float, down: float) -> None:
    """Weighed likewise, before any fault."""
    frames, _ = clean_frames(medium, 16, change, 2, 5)
    weighed = np.einsum("kij,k->ij", frames, np.cos(np.arange(len(frames)))) / len(frames)
    assert weighed.sum(axis=0) @ np.sin(np.arange(16)) == pytest.approx(across, abs=1e-3)
    assert weighed.sum(axis=1) @ np.sin(np.arange(16)) == pytest.approx(down, abs=1e-3)


@pytest.mark.parametrize("row", [row for row in ROWS if row.change == Change()], ids=lambda row: row.name)
def test_every_row_is_drawn_anew_and_leaves_the_clean_frames_alone(row) -> None:
    clean, kinds = CLEAN["cover"]
    before = clean.copy()
    read, truths = distorted(row, clean, kinds, "cover", 5)
    assert np.array_equal(clean, before)
    assert np.array_equal(read, distorted(row, clean, kinds, "cover", 5)[0])
    assert np.isfinite(read).all()
    assert len(truths) == len(read) == 2 * len(KINDS)
    assert all(truth[0] == ("ridge" if kind == "hip" else kind) for truth, kind in zip(truths, kinds, strict=True))


def test_white_noise_is_what_is_said() -> None:
    clean, kinds = CLEAN["ideal"]
    read, _ = distorted(BY_NAME["clean"], clean, kinds, "ideal", 5)
    assert (read - clean).std() == pytest.approx(NOISE[16], rel=0.05)


def test_a_tilted_plane_is_an_edge_where_a_taxel_is_free() -> None:
    clean, kinds = np.full((2, 16, 16), 0.5), np.array(["plane", "plane"])
    clean[1, :, 0] = 0.0
    assert distorted(BY_NAME["tilt 5 degrees"], clean, kinds, "ideal", 5)[1] == [("plane", "edge"), ("edge",)]


def test_names_that_give_one_frame_are_both_right() -> None:
    clean, _ = CLEAN["ideal"]
    kinds = np.array(["cone", "frustum of a cone", "cylinder", "pyramid"])
    assert distorted(BY_NAME["saturated at half"], clean[:4], kinds, "ideal", 5)[1] == [
        ("cone", "frustum of a cone"),
        ("frustum of a cone", "cone"),
        ("cylinder",),
        ("pyramid", "frustum of a pyramid"),
    ]
    rounded = distorted(BY_NAME["rounded by half"], clean[2:3], kinds[2:3], "ideal", 5)[1]
    assert rounded == [("cylinder", "sphere")]


def test_faults_by_hand() -> None:
    rng = np.random.default_rng(0)
    frame = np.zeros((1, 3, 4))
    frame[0, 1, 1], frame[0, 1, 2] = 1.0, 0.5
    assert faults.saturated(frame, rng, 0.4).max() == 0.4
    assert faults.dead_zone(frame, rng, 0.5)[0, 1].tolist() == [0, 1, 0, 0]
    assert faults.counts(frame * 0.9, rng, 5)[0, 1].tolist() == [0, 0.8, 0.4, 0]
    assert faults.power(frame, rng, 2.0)[0, 1].tolist() == [0, 1, 0.25, 0]
    assert faults.logarithm(frame, rng, 1.0)[0, 1, 2] == pytest.approx(np.log2(1.5))
    product = np.outer(frame[0].sum(axis=1), frame[0].sum(axis=0)) / 1.5
    assert np.allclose(faults.ghosts(frame, rng, 0.15)[0], frame[0] + 0.15 * product)
    leaked = faults.crosstalk(frame, rng, 0.1)[0]
    assert leaked[0, 1] / leaked[1, 1] == pytest.approx(0.1 / 1.05)
    dead = faults.dead_line(frame, rng)[0]
    assert (dead.sum(axis=0) == 0).sum() + (dead.sum(axis=1) == 0).sum() > 4
    assert faults.stretch(np.repeat(frame, 2, axis=0), rng, 1.0) == pytest.approx(np.repeat(frame, 2, axis=0))
    ramp = faults.slope(np.zeros((1, 5, 5)), rng, 0.15)
    assert (ramp.min(), ramp.max()) == pytest.approx((0.0, 0.15))


def test_training_never_sees_the_yardstick() -> None:
    folder = Path(__file__).parents[1] / "training"
    files = sorted(folder.rglob("*.py"))
    assert files
    assert not [
        path.name for path in files if "yardstick" in path.read_text() or "touch_distortions" in path.read_text()
    ]
