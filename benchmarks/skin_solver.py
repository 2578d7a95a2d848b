"""The contact solver: against Hertz and the flat punch, and how fast it is.

Speed: CPU milliseconds (median) to solve at 128 x 128 cells to a root mean square gap of 1e-5 of the depth,
every solid in three poses, sampling of the solid's face included; beside it, interleaved in the same
process, plain constrained conjugate gradients from a cold start (no preconditioner, no coarser grids, whole
field), with the largest difference of the two pressures' means.

Run: python -m benchmarks.skin_solver
"""

from __future__ import annotations

import time

import numpy as np

from benchmarks._figures import figure, share
from varishold.skin import PressedSolid, Skin, press
from varishold.skin.face import face_of_solid
from varishold.skin.influence import influence_of
from varishold.skin.media import Cells, medium_of
from varishold.skin.nonnegative import solve_nonnegative
from varishold.solids import SOLIDS, Cylinder, Pose, Solid, Sphere, solid_of_size

SKINS = {
    "layer 6 mm, nu .45": (Skin("layer", 6e-3, 0.45), 8.0),
    "layer 6 mm, nu .5": (Skin("layer", 6e-3, 0.5), 8.0),
    "half-space": (Skin("half-space"), 25.0),
    "winkler": (Skin("winkler", 6e-3, 0.3), 8.0),
}
POSES = (Pose(1e-3, -0.5e-3, 0.3), Pose(), Pose(0.3e-3, 0.2e-3, 0.7))
DEPTH = 1e-3
CELLS = Cells(128, 128, 0.25e-3, 0.25e-3)


def closed_forms() -> None:
    """Print Hertz's sphere and the flat punch at 256 x 256."""
    radius, depth, n = 10e-3, 0.15e-3, 256
    ball = press(Sphere(2 * radius), Skin("half-space"), depth=depth, shape=(n, n), pitch_m=5e-3 / n)
    side = ball.x_m[1] - ball.x_m[0]
    contact = np.sqrt(np.count_nonzero(ball.contact) * side**2 / np.pi)
    off = {
        "radius": (contact / np.sqrt(radius * depth) - 1, "within 1"),
        "peak pressure": (ball.pressure.max() / (2 / np.pi * np.sqrt(depth / radius)) - 1, "within .5"),
        "force": (ball.force_n / (4 / 3 * np.sqrt(radius) * depth**1.5) - 1, "within .5"),
    }
    said = (f"{name} {share(f'Hertz: {name}', value, '+.3f', bar=bar)}" for name, (value, bar) in off.items())
    print(f"Hertz, 256 x 256: {', '.join(said)}")
    radius, depth = 2.5e-3, 0.3e-3
    punch = press(Cylinder(2 * radius, 5e-3), Skin("half-space"), depth=depth, shape=(n, n), pitch_m=8e-3 / n)
    r = np.hypot(punch.x_m[None, :], punch.y_m[:, None])
    for part in (0.5, 0.8, 0.9):
        inside = r < part * radius
        exact = depth / (np.pi * np.sqrt(radius**2 - r[inside] ** 2))
        worst = np.abs(punch.pressure[inside] / exact - 1).max()
        of = f"flat punch: pressure within {part:g} of the radius"
        print(f"{of} off by at most {share(of, worst, '.3f', bar='<= 1')}")
    print(f"flat punch: force off by {share('flat punch: force', punch.force_n / (2 * radius * depth) - 1, '+.3f')}")


def plain(solid: Solid, skin: Skin, pose: Pose) -> tuple[float, int]:
    """Solve without preconditioner, coarser grids or boxes; return the mean pressure and the steps."""
    face = face_of_solid(solid, CELLS, pose, DEPTH)
    influence = influence_of(medium_of(skin), CELLS, 128, 128)
    wanted = np.where(np.isfinite(face.below_top_m), DEPTH - face.below_top_m, -100 * DEPTH)
    wanted = np.where(face.loaded > 0.5, np.maximum(wanted, -100 * DEPTH), -100 * DEPTH)
    start = np.where(wanted > 0, 1.0, 0.0) * DEPTH / influence.displacement(np.where(wanted > 0, 1.0, 0.0)).max()
    solved = solve_nonnegative(
        influence.displacement, lambda r: r, wanted, start, tolerance=1e-5 * DEPTH, max_iterations=2000
    )
    return float(solved.x.mean()), solved.iterations


def main() -> None:
    closed_forms()
    for title, (skin, limit) in SKINS.items():
        rows: list[tuple[float, str]] = []
        peers: list[float] = []
        apart: list[float] = []
        for name in SOLIDS:
            solid = solid_of_size(name, 14e-3)
            times: list[float] = []
            steps: list[int] = []
            pressed: PressedSolid | None = None
            for pose in POSES:
                pressed = press(solid, skin, depth=DEPTH, pose=pose)
                for _ in range(7):
                    began = time.process_time()
                    pressed = press(solid, skin, depth=DEPTH, pose=pose)
                    times.append(1e3 * (time.process_time() - began))
                steps.append(pressed.iterations)
                began = time.process_time()
                mean, plain_steps = plain(solid, skin, pose)
                peers.append(1e3 * (time.process_time() - began))
                apart.append(abs(mean / pressed.pressure.mean() - 1))
                if not pressed.converged or pressed.rms_gap > 1e-5:
                    print(f"{title}: {name} did not converge")
            rows.append(
                (
                    float(np.median(times)),
                    f"  {name:19s} {np.median(times):5.1f} ms, {max(steps):2d} steps; plain {plain_steps:4d} steps",
                )
            )
        middle = np.median([row[0] for row in rows])
        print(
            f"{title}: worst form {figure(f'{title}: worst form', max(rows)[0], '.1f', 'ms', bar=f'<= {limit:g}')}, "
            f"median {figure(f'{title}: median', middle, '.1f', 'ms')}; "
            f"plain {np.median(peers):.0f} ms; mean pressures agree to {np.median(apart):.2%} (median)"
        )
        for _, row in rows:
            print(row)


if __name__ == "__main__":
    main()
