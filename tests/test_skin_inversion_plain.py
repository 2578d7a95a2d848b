"""The way back and the fit's forward model beside dense matrices, and the contact's border where it can be told."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage
from scipy.optimize import brentq, nnls
from scipy.special import ndtr

from varishold.errors import InputError
from varishold.skin import Skin, Taxels, press, reconstruct, sense
from varishold.skin import inversion as inversions
from varishold.skin import reconstruction as reconstructions
from varishold.skin.contact_mask import contact_mask, eroded
from varishold.skin.influence import influence_of
from varishold.skin.inversion import Inversion
from varishold.skin.media import Cells, medium_of
from varishold.skin.synthesis import CoarseFace, Synthesis
from varishold.skin.transmission import Transmission
from varishold.solids import Pose, Sphere, SquarePillar

Floats = NDArray[np.float64]
SKIN = Skin("layer", 6e-3, 0.45, 1e-3)
SPACING = (1e-3, 1.2e-3)


def _forward(skin: Skin, cells: Cells, per_taxel: int) -> Floats:
    """The matrix from pressures on cells to taxels."""
    t = Transmission(medium_of(skin), cells, skin.sensing_depth_m, per_taxel, np.float64)
    units = np.eye(cells.rows * cells.cols).reshape(-1, cells.rows, cells.cols)
    return t.forward(units).reshape(len(units), -1).T


def _frame(rows: int, cols: int) -> Floats:
    skin = Skin("layer", 6e-3, 0.45, 1e-3)
    pressed = press(Sphere(14e-3), skin, depth=0.8e-3, shape=(rows, cols), pitch_m=SPACING, pose=Pose(0.4e-3, -0.3e-3))
    frame = sense(pressed, Taxels(noise=0.01), seed=1)
    return frame / frame.max()


@pytest.mark.parametrize("transforms", [False, True])
@pytest.mark.parametrize(("penalty", "tolerance", "error"), [(0.01, 3e-6, 1e-3), (0.04, 3e-3, 0.03)])
def test_a_pressure_is_that_of_penalized_least_squares(
    transforms: bool, penalty: float, tolerance: float, error: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows, cols = 9, 10
    monkeypatch.setattr(inversions, "_TOLERANCE", tolerance)
    monkeypatch.setattr(inversions, "_MOST_ITERATIONS", 500)
    if transforms:
        monkeypatch.setattr(inversions, "_MATRIX_TAXELS", 0)
    inversion = Inversion(SKIN, rows, cols, SPACING, penalty, 2)
    assert inversion.shape == (18, 20)
    frame = _frame(rows, cols)
    matrix = _forward(SKIN, inversion.cells, 2)
    # A quarter of the penalty a cell, as four cells make a taxel; half of that along the pad's border.
    penalties = np.full((18, 20), penalty / 4)
    inside = np.zeros((18, 20), dtype=bool)
    inside[1:-1, 1:-1] = True
    penalties[~inside] /= 2
    stacked = np.vstack([matrix, np.diag(np.sqrt(penalties.ravel()))])
    told = nnls(stacked, np.concatenate([frame.ravel(), np.zeros(360)]))[0].reshape(18, 20)
    made, steps = inversion.pressure(frame.astype(np.float32), None)
    assert made.dtype == np.float64
    np.testing.assert_allclose(made, told, atol=error * told.max())
    assert 0 < steps <= {(False, 0.01): 13, (True, 0.01): 21, (False, 0.04): 2, (True, 0.04): 5}[transforms, penalty]
    # The gradient that is left is a share of the data's own.
    back = matrix.T @ frame.ravel()
    gradient = matrix.T @ (matrix @ made.ravel()) + penalties.ravel() * made.ravel() - back
    free = (made.ravel() > 0) | (gradient < 0)
    assert np.sqrt(np.mean(gradient[free] ** 2)) <= 1.1 * max(tolerance, 1e-5) * np.sqrt(np.mean(back**2))
    assert inversion.pressure(frame.astype(np.float32), told)[1] <= 1
    np.testing.assert_allclose(inversion.pressure(frame.astype(np.float32), made)[0], made, rtol=1e-5, atol=1e-6)
    # With a matrix what it does first is the inverse of what it solves.
    wave = np.random.default_rng(0).random((18, 20)).astype(np.float32)
    if not transforms:
        np.testing.assert_allclose(inversion._precondition(inversion._normal(wave)), wave, atol=2e-3)
    np.testing.assert_allclose(
        inversion._normal(wave).ravel(),
        matrix.T @ (matrix @ wave.ravel()) + penalties.ravel() * wave.ravel(),
        rtol=2e-4,
        atol=1e-5,
    )


def test_up_to_three_hundred_and_twenty_taxels_a_matrix_is_taken() -> None:
    assert Inversion(SKIN, 16, 20, SPACING, 0.01, 1)._matrix is not None
    assert Inversion(SKIN, 3, 107, SPACING, 0.01, 1)._matrix is None


@pytest.mark.parametrize(
    ("penalty", "spacing", "n"),
    [(0.01, (1e-3, 1e-3), 2), (0.08, (1e-3, 1e-3), 2), (0.01, (1e-3, 1.4e-3), 2), (0.04, (1.3e-3, 1e-3), 3)],
)
def test_noise_is_amplified_as_a_dense_inverse_amplifies_it(
    penalty: float, spacing: tuple[float, float], n: int
) -> None:
    taxels = 13 if n == 2 else 9
    side, inner = n * taxels, slice(n * (taxels // 2) - n, n * (taxels // 2) + 2 * n)
    inversion = Inversion(SKIN, taxels, taxels, spacing, penalty, n)
    matrix = _forward(SKIN, inversion.cells, n)
    kernel = medium_of(SKIN).influence(inversion.cells)
    i, j = (each.ravel() for each in np.indices((side, side)))
    influence = kernel[np.abs(np.subtract.outer(i, i)), np.abs(np.subtract.outer(j, j))]
    inverse = np.linalg.solve(matrix.T @ matrix + penalty / n**2 * np.eye(side * side), matrix.T)
    spread = np.sqrt(((influence @ inverse) ** 2).sum(axis=1)).reshape(side, side)[inner, inner].mean()
    assert inversion.noise_gain == pytest.approx(spread, rel=0.17)


def test_the_displacement_under_a_pressure_is_that_of_the_skin() -> None:
    inversion = Inversion(SKIN, 5, 6, SPACING, 0.01, 2)
    pressure = np.random.default_rng(0).random((10, 12))
    told = influence_of(medium_of(SKIN), inversion.cells, 10, 12).displacement(pressure)
    made = inversion.displacement(pressure)
    np.testing.assert_allclose(made, told, rtol=1e-4)
    assert made.dtype == np.float64


# The contact


def test_a_flat_face_ends_where_the_smoothed_pressure_is_a_third_of_that_beside_it() -> None:
    """Along a straight edge: smoothed by .28 taxels, over .35 of the highest within half a taxel."""
    n = 40
    frame = np.zeros((3 * n, 4 * n))
    frame[:, : 2 * n] = 1.0
    border = brentq(lambda x: ndtr(-x / (0.28 * n)) - 0.35 * ndtr(-(x - n / 2) / (0.28 * n)), -n, n)
    mask = contact_mask(frame, n)
    assert mask[n].sum() == pytest.approx(2 * n + border, abs=1.5)
    assert (mask == mask[n]).all()


def test_what_carries_little_is_no_contact() -> None:
    """A share of the peak for what hangs together, the heaviest piece, and a share of the load for its parts."""

    def stepped(level: float) -> NDArray[np.bool_]:
        frame = np.zeros((30, 90))
        frame[5:25, 5:30] = 1.0
        frame[5:25, 30:80] = level
        return contact_mask(frame, 2)[15]

    assert stepped(0.07)[50]
    assert not stepped(0.05)[50]
    # Apart from the heaviest piece nothing counts, however hard it presses.
    apart = np.zeros((30, 60))
    apart[5:25, 5:30] = 1.0
    apart[10:15, 45:50] = 3.0
    mask = contact_mask(apart, 2)
    assert mask[15, 15]
    assert not mask[:, 40:].any()

    def parted(share: float) -> NDArray[np.bool_]:
        # A valley too wide to be closed, deep beside its banks, but not so deep as to part the load.
        frame = np.zeros((30, 90))
        frame[5:25, 5:45] = 1.0
        frame[5:25, 45:49] = (0.2, 0.07, 0.07, 0.2)
        frame[5:25, 49 : 49 + round(40 * share / (1 - share))] = 1.0
        return contact_mask(frame, 2)

    assert parted(0.07)[15, 49:52].all()
    assert parted(0.048)[15, 49:51].all()
    assert not parted(0.024)[15, 47:].any()
    assert parted(0.024)[15, 20]


def test_a_contact_has_no_holes_and_goes_on_at_the_border() -> None:
    ring = np.zeros((30, 30))
    y, x = np.mgrid[:30, :30] - 14.5
    ring[np.hypot(x, y) < 12] = 1.0
    ring[np.hypot(x, y) < 6] = 0.0
    mask = contact_mask(ring, 2)
    assert mask[np.hypot(x, y) < 11].all()
    assert not mask[np.hypot(x, y) > 14].any()
    assert contact_mask(np.ones((6, 8)), 2).all()
    half = np.zeros((20, 20))
    half[:10] = 1.0
    assert contact_mask(half, 2)[:9].all()
    # A crack of two cells is closed, though it runs to the border; a gap of four is not.
    for crack, closed in (((0.2, 0.2), True), ((0.2, 0.07, 0.07, 0.2), False)):
        cracked = np.ones((20, 40))
        cracked[:, 20 : 20 + len(crack)] = crack
        assert contact_mask(cracked, 2)[:, 20 : 20 + len(crack)].all() == closed


def test_a_core_is_further_from_the_border_than_the_depth() -> None:
    cells = Cells(30, 40, 0.5e-3, 0.8e-3)
    rng = np.random.default_rng(0)
    mask = ndimage.gaussian_filter(rng.normal(size=(30, 40)), 4) > -0.05
    for depth in (0.75e-3, 1.05e-3, 1.65e-3):
        core = eroded(mask, depth, cells)
        off = np.argwhere(~mask) * (0.5e-3, 0.8e-3)
        told = [
            [bool(mask[i, j] and np.hypot(*(off - (i * 0.5e-3, j * 0.8e-3)).T).min() > depth) for j in range(40)]
            for i in range(30)
        ]
        # Along the field's border the contact goes on as it is there.
        inner = (slice(5, -5), slice(5, -5))
        np.testing.assert_array_equal(core[inner], np.array(told)[inner])
    top = np.zeros((30, 40), dtype=bool)
    top[:10] = True
    core = eroded(top, 1.2e-3, cells)
    assert core[:8].all()
    assert not core[8:].any()
    assert eroded(np.ones((4, 4), dtype=bool), 1.0, Cells(4, 4, 1e-3, 1e-3)).all()
    assert eroded(top, 0.0, cells) is top
    # A core of fewer than twelve cells is none.
    square = Cells(20, 20, 1e-3, 1e-3)
    for rows, cols, kept in ((5, 6, True), (5, 5, False)):
        small = np.zeros((20, 20), dtype=bool)
        small[4 : 4 + rows, 4 : 4 + cols] = True
        assert (eroded(small, 1e-3, square).sum() == (rows - 2) * (cols - 2)) == kept
        assert kept or eroded(small, 1e-3, square) is small


# The whole way


@pytest.mark.parametrize("modulus", [None, 2e5])
def test_a_relief_says_what_it_says(modulus: float | None) -> None:
    skin = Skin("layer", 6e-3, 0.45, 1e-3, youngs_modulus_pa=modulus)
    pose = Pose(0.7e-3, -0.4e-3, 0.2, 0.03, -0.02)
    pressed = press(SquarePillar(9e-3, 5e-3), skin, depth=1e-3, shape=(17, 15), pitch_m=(1e-3, 1.3e-3), pose=pose)
    frame = sense(pressed, Taxels(noise=0.005), seed=2)
    relief = reconstruct(frame, skin, pitch=(1e-3, 1.3e-3), noise=0.005 * frame.max())
    assert (relief.pitch_m, relief.per_taxel) == ((0.5e-3, 0.65e-3), 2)
    cells = Cells(34, 30, 0.5e-3, 0.65e-3)
    told = influence_of(medium_of(skin), cells, 34, 30).displacement(relief.pressure) / skin.contact_modulus
    np.testing.assert_allclose(relief.displacement, told, rtol=1e-3)
    np.testing.assert_array_equal(relief.mask, contact_mask(relief.pressure, 2))
    np.testing.assert_array_equal(relief.core, eroded(relief.mask, 1e-3, cells))
    y, x = np.mgrid[:34, :30] * np.array([0.5e-3, 0.65e-3])[:, None, None]

    def plane(at: NDArray[np.bool_]) -> Floats:
        known = np.column_stack([x[at], y[at], np.ones(at.sum())])
        return np.asarray(np.linalg.lstsq(known, relief.displacement[at], rcond=None)[0])

    slope = plane(relief.core)[:2]
    np.testing.assert_allclose(relief.tilt, slope, rtol=1e-4)

    def level(at: NDArray[np.bool_]) -> Floats:
        out: Floats = relief.displacement - slope[0] * (x - x[at].mean()) - slope[1] * (y - y[at].mean())
        return out

    near, nearer = (ndimage.binary_dilation(relief.mask, np.ones((3, 3)), iterations=k) for k in (2, 1))
    line = np.median(level(relief.mask)[near & ~nearer])
    assert relief.line == pytest.approx(line, rel=1e-4)
    height = np.where(relief.core, np.maximum(level(relief.core) - line, 0), 0)
    np.testing.assert_allclose(relief.height, height, atol=1e-4 * height.max())
    gain = Inversion(skin, 17, 15, (1e-3, 1.3e-3), _penalty(0.005), 2).noise_gain
    assert relief.noise == pytest.approx(0.005 * frame.max() * gain / skin.contact_modulus, rel=1e-6)
    if modulus is not None:
        assert relief.tilt == pytest.approx((0.03, -0.02), abs=0.008)


def _penalty(share: float) -> float:
    return 0.01 * 2.0 ** round(math.log2(min(max(share, 0.002), 0.15) / 0.015))


@pytest.mark.parametrize("share", [1e-5, 0.0015, 0.004, 0.012, 0.03, 0.1, 0.2, 0.9])
def test_a_penalty_follows_the_noise_in_doublings(share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    made = reconstructions.inversion_of

    def noted(*what: Any) -> Inversion:
        asked.append(what)
        return made(*what)

    monkeypatch.setattr(reconstructions, "inversion_of", noted)
    frame = 7.0 * _frame(9, 10)
    reconstruct(frame, SKIN, pitch=SPACING, noise=share * 7.0)
    assert asked == [(SKIN, 9, 10, SPACING, _penalty(share), 2)]


def test_a_face_that_fills_the_pad_has_no_free_skin_around_it() -> None:
    relief = reconstruct(np.ones((6, 7)), SKIN, pitch=1e-3)
    assert relief.mask.all()
    assert relief.line == 0.0


def test_only_a_start_of_the_same_pad_is_used() -> None:
    frame = _frame(9, 10)
    own = reconstruct(frame, SKIN, pitch=SPACING)
    other = reconstruct(_frame(10, 10), SKIN, pitch=SPACING)
    assert reconstruct(frame, SKIN, pitch=SPACING, start=other).iterations == own.iterations
    # Whatever the unit of the frames.
    assert (
        reconstruct(1e5 * frame, SKIN, pitch=SPACING, start=reconstruct(1e5 * frame, SKIN, pitch=SPACING)).iterations
        == 0
    )


@pytest.mark.parametrize(
    ("depth_m", "pitch", "says"),
    [
        (4e-3, 1e-3, None),
        (4.01e-3, 1e-3, "sensing depth 0.00401 m is more than 4 times the pitch, 0.001 m"),
        (4.01e-3, (1e-3, 1.2e-3), None),
        (0.125e-3, 1e-3, None),
        (0.12e-3, 1e-3, "a depth of 0.00012 m needs a pitch of 0.00096 m or less, got 0.001 m"),
        (0.12e-3, (0.5e-3, 1e-3), "too coarse for the sensing depth"),
        (0.0, 1e-3, None),
    ],
)
def test_taxels_lie_neither_too_deep_nor_too_near(depth_m: float, pitch: Any, says: str | None) -> None:
    skin, frame = Skin("layer", 8e-3, 0.45, depth_m), _frame(9, 10)
    if says is None:
        assert reconstruct(frame, skin, pitch=pitch).mask.any()
        return
    with pytest.raises(InputError) as caught:
        reconstruct(frame, skin, pitch=pitch)
    assert says in str(caught.value)


def test_what_holds_no_contact_is_told() -> None:
    frame = np.full((5, 5), -1.0)
    # Neither where nothing presses, nor where what presses is drowned by what pulls.
    for top in (1e-3, 2e-6, 0.5e-6, 1e-300, 0.0, -0.5):
        frame[2, 2] = top
        with pytest.raises(InputError, match="the frame holds no contact: its largest value"):
            reconstruct(frame, SKIN, pitch=1e-3)
    for shape in ((2, 5), (5, 2)):
        with pytest.raises(InputError, match=r"3 x 3 taxels or more, got an array of shape"):
            reconstruct(np.ones(shape), SKIN, pitch=1e-3)
    assert reconstruct(np.ones((3, 3)), SKIN, pitch=1e-3).pressure.shape == (6, 6)
    broken = np.ones((4, 5))
    broken[2, 3] = np.nan
    with pytest.raises(InputError, match=r"got nan at \(row, col\) = \(2, 3\)"):
        reconstruct(broken, SKIN, pitch=1e-3)


# The fit's forward model


@pytest.mark.parametrize("kind", ["layer", "half-space", "winkler"])
def test_a_synthetic_frame_and_its_gradients_are_those_of_a_dense_matrix(kind: str) -> None:
    """Cells that a wall crosses, hardly covered ones, and one that cannot carry: w, dw and dS as documented."""
    skin = Skin(kind, None if kind == "half-space" else 6e-3, 0.3, 1e-3)
    synthesis = Synthesis(skin, 5, 6, (1e-3, 1.2e-3), 2)
    x, y = synthesis.points_m
    medium, cells = medium_of(skin), synthesis.cells
    rng = np.random.default_rng(4)
    covered = np.where(np.abs(x) < 2.1e-3, np.where(np.abs(y) < 2e-3, 1.0, 0.4), 0.0)
    covered[rng.choice(np.flatnonzero(covered == 0.4), 6, replace=False)] = [0.002, 0.01, 0.03, 0.2, 0.7, 0.0029]
    wanted = 1.0 - (x**2 + y**2) / 2e-5
    change, turn = rng.normal(size=(2, 2, x.size)) * 0.3
    face = CoarseFace(wanted, covered, change, turn)
    kernel = medium.influence(cells)
    i, j = (each.ravel() for each in np.indices((cells.rows, cells.cols)))
    matrix = kernel[np.abs(np.subtract.outer(i, i)), np.abs(np.subtract.outer(j, j))]
    own = matrix[0, 0]

    def spring(share: Floats) -> Floats:
        alone = own * (1 / share - 1 if kind == "winkler" else 1 / np.sqrt(share) - 1)
        return alone + own * (1 - share) * (0.03 / share) ** 2

    use = np.flatnonzero(covered > 0.003)
    part = covered[use] < 1
    held = matrix[np.ix_(use, use)] + np.diag(np.where(part, spring(covered[use]), 0.0))
    root = np.linalg.cholesky(held)
    pressure = np.zeros(x.size)
    pressure[use] = nnls(root.T, np.linalg.solve(root, wanted[use]))[0]
    made = synthesis.frame(face)
    np.testing.assert_allclose(made.pressure, pressure, atol=2e-4 * pressure.max())
    np.testing.assert_array_equal(made.active, pressure > 0)
    forward = _forward(skin, cells, 2)
    np.testing.assert_allclose(made.frame.ravel(), forward @ pressure, atol=2e-4 * made.frame.max())
    # G_AA dp = dw - dS p.
    active = pressure[use] > 0
    slope = np.where(part, (spring(covered[use] + 1e-6 * part) - spring(covered[use] - 1e-6)) / 2e-6, 0.0)
    for k in range(2):
        right = (change[k, use] - slope * turn[k, use] * pressure[use])[active]
        moved = np.zeros(x.size)
        moved[use[active]] = np.linalg.solve(held[np.ix_(active, active)], right)
        told = (forward @ moved).reshape(5, 6)
        np.testing.assert_allclose(made.gradient[k], told, atol=2e-3 * np.abs(told).max())
    # Conjugate gradients come near, and from a start on cells that cannot carry too.
    for start in (None, made.pressure, np.ones(x.size)):
        fine = synthesis.pressure(face, start=start)
        np.testing.assert_allclose(fine, pressure, atol=0.03 * pressure.max())
    elsewhere = covered <= 0.003
    np.testing.assert_allclose(synthesis.frame(face, start=elsewhere).frame, made.frame, atol=1e-4 * made.frame.max())
    everywhere = synthesis.frame(face, start=np.ones(x.size, dtype=bool))
    np.testing.assert_allclose(everywhere.frame, made.frame, atol=1e-4 * made.frame.max())
    np.testing.assert_allclose(synthesis.sensed(pressure).ravel(), forward @ pressure, atol=1e-4 * made.frame.max())


def test_a_face_without_parameters_has_no_gradient() -> None:
    synthesis = Synthesis(SKIN, 4, 5, (1e-3, 1e-3), 1)
    x, y = synthesis.points_m
    none = np.zeros((0, 20))
    made = synthesis.frame(CoarseFace(1 - (x**2 + y**2) / 4e-6, np.full(20, 0.9), none, none))
    assert made.gradient.shape == (0, 4, 5)
    assert made.frame.max() > 0
