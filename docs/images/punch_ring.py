"""Draw the ring of a flat punch, docs/images/punch_ring.png: python docs/images/punch_ring.py."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from ring_figure import write_ring_figure

from varishold.skin import Skin, press, taxel_stress
from varishold.solids import Cylinder

RADIUS, SIDE, CELLS = 6e-3, 20e-3, 160


def main() -> None:
    maps = []
    for share in (0.0, 0.1, 0.2, 0.4, 0.8):
        skin = Skin("half-space", sensing_depth_m=share * RADIUS)
        pressed = press(
            Cylinder(2 * RADIUS, 10e-3), skin, depth=1e-3, shape=(CELLS, CELLS), pitch_m=SIDE / CELLS, per_taxel=1
        )
        stress = taxel_stress(pressed)
        heading = "at the surface" if share == 0 else f"{share:g} radii deep"
        maps.append((heading, np.asarray(stress)))
        middle = stress[CELLS // 2 - 1 : CELLS // 2 + 1, CELLS // 2 - 1 : CELLS // 2 + 1].mean()
        print(f"{heading}: highest over central stress {stress.max() / middle:.2f}")
    maps.append(("pressed down (u)", pressed.displacement_m))
    path = Path(__file__).with_name("punch_ring.png")
    write_ring_figure(path, maps, side_m=SIDE)
    print(path)


if __name__ == "__main__":
    main()
