"""Draw the table of contents of forms, docs/images/skin_contents.png: python docs/images/skin_contents.py."""

from __future__ import annotations

from pathlib import Path

from contents_figure import ContentsEntry, write_contents_figure

from varishold.skin import Skin, Taxels, press, reconstruct, sense
from varishold.solids import (
    Cone,
    ConeFrustum,
    Cylinder,
    Edge,
    Hip,
    LyingCylinder,
    Plane,
    Pose,
    Pyramid,
    PyramidFrustum,
    RectangularPillar,
    Ridge,
    Solid,
    Sphere,
    SquarePillar,
    Wedge,
)

SKIN = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)
NOISE, SEED = 0.01, 7
MM = 1e-3

FORMS: tuple[tuple[str, Solid, float, Pose], ...] = (
    ("cylinder", Cylinder(16 * MM, 6 * MM), 2 * MM, Pose()),
    ("square pillar", SquarePillar(15 * MM, 6 * MM), 2 * MM, Pose(yaw_rad=0.3)),
    ("rectangular pillar", RectangularPillar(21 * MM, 10 * MM, 6 * MM), 2 * MM, Pose(yaw_rad=0.5)),
    ("frustum of a cone", ConeFrustum(30 * MM, 8 * MM, 6 * MM), 2.5 * MM, Pose()),
    ("frustum of a pyramid", PyramidFrustum(28 * MM, 8 * MM, 6 * MM), 2.5 * MM, Pose(yaw_rad=0.3)),
    ("sphere", Sphere(44 * MM), 3 * MM, Pose()),
    ("cone", Cone(50 * MM, 8 * MM), 3.5 * MM, Pose()),
    ("pyramid", Pyramid(48 * MM, 8 * MM), 3.5 * MM, Pose(yaw_rad=0.3)),
    ("ridge", Ridge(20 * MM, 40 * MM, 8 * MM), 2.8 * MM, Pose(yaw_rad=0.5)),
    ("hip", Hip(50 * MM, 36 * MM, 8 * MM), 2.8 * MM, Pose(yaw_rad=0.5)),
    ("lying cylinder", LyingCylinder(36 * MM, 80 * MM), 2 * MM, Pose(yaw_rad=0.5)),
    ("wedge", Wedge(50 * MM, 8 * MM), 2.5 * MM, Pose(yaw_rad=-0.4)),
    ("edge", Edge(8 * MM), 1.5 * MM, Pose(x_m=2 * MM, yaw_rad=0.3)),
    ("plane", Plane(8 * MM), 1.5 * MM, Pose()),
)


def main() -> None:
    entries = []
    for seed, (name, solid, depth, pose) in enumerate(FORMS, start=SEED):
        pressed = press(solid, SKIN, depth=depth, pose=pose)
        frame = sense(pressed, Taxels(noise=NOISE), seed=seed)
        entries.append(ContentsEntry(name, pressed, frame, reconstruct(frame, SKIN, pitch=1e-3)))
    path = Path(__file__).with_name("skin_contents.png")
    note = "layer of 6 mm, Poisson's ratio .45; 32 x 32 taxels of 1 mm, 1 mm deep, 1 % noise"
    write_contents_figure(path, entries, note=note)
    print(path)


if __name__ == "__main__":
    main()
