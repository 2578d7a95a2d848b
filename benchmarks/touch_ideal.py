"""Names given to ideal surfaces: accuracy, calibration, and what is called unknown.

The frames are drawn as training draws them: these figures are in-distribution. Ridge and hip count as one name. Faulty
sensors are another matter (`touch_distortions`), and so are strangers that training never draws, printed too.
"""

from __future__ import annotations

import numpy as np

from benchmarks._figures import share
from benchmarks._scores import Scores
from benchmarks._strange_frames import means, measured
from training.frames import taxel_mean
from training.strangers import stranger_face
from varishold.solids import SOLIDS, draw_contact, ideal_frame
from varishold.touch import find_contacts, recognize

SEED = 20_000
FRAMES_PER_KIND = 200
TRUE_NAME = {
    "cylinder": "cylinder",
    "square-pillar": "square pillar",
    "rectangular-pillar": "rectangular pillar",
    "cone-frustum": "frustum of a cone",
    "pyramid-frustum": "frustum of a pyramid",
    "sphere": "sphere",
    "cone": "cone",
    "pyramid": "pyramid",
    "ridge": "ridge",
    "hip": "hip",
    "lying-cylinder": "lying cylinder",
    "edge": "edge",
    "wedge": "edge",
    "plane": "plane",
}


def name_of(frame: np.ndarray, **options: object) -> tuple[str, float]:
    """Return the name and its probability of the largest contact; unknown where there is none."""
    contacts = find_contacts(frame, **options)
    if not contacts:
        return "unknown", 1.0
    surface = recognize(contacts[0])
    return surface.name, surface.probability


def known(side: int, size: tuple[float, float], noise: float) -> Scores:
    """Score generated frames of every solid on a pad of `side` x `side` taxels."""
    rng = np.random.default_rng([SEED, side])
    scores = Scores()
    for key in SOLIDS:
        for _ in range(FRAMES_PER_KIND):
            drawn = draw_contact(rng, key, field_m=(side, side), size_m=size)
            frame = ideal_frame(drawn.solid, (side, side), 1.0, depth_m=drawn.depth_m, pose=drawn.pose)
            frame = frame + rng.normal(0, noise * frame.max(), frame.shape)
            scores.add(TRUE_NAME[key], *name_of(frame))
    return scores


def strangers(side: int, size: tuple[float, float], noise: float) -> dict[str, float]:
    """Return the share called unknown of unions of parts, stars and rings as training draws them, and of noise."""
    rng = np.random.default_rng([SEED, side, 1])
    shares = {}
    for kind in ("union", "star", "ring", "noise"):
        unknown = 0
        for _ in range(FRAMES_PER_KIND):
            if kind == "noise":
                frame = rng.normal(0, 1, (side, side))
            else:
                frame = taxel_mean(stranger_face(rng, (side, side), size, kind=kind), 6)
                frame = frame + rng.normal(0, noise * frame.max(), frame.shape)
            unknown += name_of(frame)[0] == "unknown"
        shares[kind] = unknown / FRAMES_PER_KIND
    return shares


def main() -> None:
    """Print the figures of both pads."""
    for side, size, noise, bar in ((32, (8.0, 24.0), 0.01, 0.99), (16, (4.0, 12.0), 0.02, 0.95)):
        scores = known(side, size, noise)
        of = f"{side} x {side}"
        print(f"{of}, noise {noise:.0%}, sizes {size[0]:g}-{size[1]:g} taxels:")
        scores.report(of, bar=f">= {100 * bar:g}")
        print("  strangers of kinds that training draws (in-distribution), called unknown:")
        for kind, refused in strangers(side, size, noise).items():
            print(f"    {kind:22} {share(f'{of}: {kind}, drawn in training, called unknown', refused, bar='>= 90')}")
        never_drawn = measured(side)
        unknown, sure = means(never_drawn)
        unknown = share(f"{of}: kinds never drawn, called unknown", unknown)
        sure = share(f"{of}: kinds never drawn, named with p > .9", sure)
        print(f"  strangers of {len(never_drawn)} kinds never drawn, called unknown {unknown}, ", end="")
        print(f"named with p > .9 {sure} (each kind: touch_strangers)")


if __name__ == "__main__":
    main()
