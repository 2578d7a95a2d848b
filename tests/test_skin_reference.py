"""The contact solver beside ContactMechanics, an independent one; skipped where that is not installed."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.skin import Skin, press
from varishold.solids import Cone, Pose, Pyramid, Solid, Sphere, pad_points

N, SIDE = 64, 16e-3


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("solid", "depth"), [(Sphere(30e-3), 0.6e-3), (Cone(24e-3, 4e-3), 1e-3), (Pyramid(24e-3, 4e-3), 1e-3)]
)
def test_a_half_space_beside_contact_mechanics(solid: Solid, depth: float) -> None:
    mechanics = pytest.importorskip("ContactMechanics", reason="ContactMechanics is not installed")
    topography = pytest.importorskip("SurfaceTopography")
    x, y = pad_points((N, N), SIDE / N)
    height = solid.placed(x, y, Pose())
    surface = topography.Topography(height - height.max(), (SIDE, SIDE))
    substrate = mechanics.FreeFFTElasticHalfSpace((N, N), 1.0, (SIDE, SIDE))
    system = mechanics.make_system(substrate=substrate, surface=surface)
    # Its penetration counts from the highest sample, ours from the solid's own top.
    system.minimize_proxy(offset=depth - (solid.top_m - height.max()), pentol=1e-9)
    theirs = np.asarray(system.force)[:N, :N] / (SIDE / N) ** 2
    # Height maps are taken at cell middles by both: the same discrete problem.
    ours = press(
        height,
        Skin("half-space"),
        depth=depth - (solid.top_m - height.max()),
        shape=(N, N),
        pitch_m=SIDE / N,
        per_taxel=1,
        tolerance=1e-7,
    )
    assert ours.force_n == pytest.approx(theirs.sum() * (SIDE / N) ** 2, rel=1e-4)
    assert np.abs(ours.pressure - theirs).max() < 1e-3 * theirs.max()
