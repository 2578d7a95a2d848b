"""Names given to presses into elastic skins, the skin unknown or known."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from benchmarks._figures import share
from benchmarks._scores import Scores
from benchmarks.touch_ideal import TRUE_NAME
from varishold.errors import InputError
from varishold.skin import Skin, press, sense
from varishold.solids import SOLIDS, draw_contact
from varishold.touch import find_contacts, recognize
from varishold.touch.relief import relief_of

SEED = 30_000
FRAMES_PER_KIND = 150
LAYER = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)
HALF_SPACE = Skin("half-space", poisson=0.45, sensing_depth_m=1e-3)
#: Name, skin, taxels a side, pitch, noise, bars without and with a skin file.
SETTINGS = (
    ("layer 32 x 32", LAYER, 32, 1e-3, 0.01, 0.97, 0.985),
    ("layer 16 x 16", LAYER, 16, 2e-3, 0.02, 0.93, 0.94),
    ("half-space 32 x 32", HALF_SPACE, 32, 1e-3, 0.01, 0.94, 0.97),
)


def frames(skin: Skin, side: int, pitch: float, noise: float, seed: int, per_kind: int) -> list[tuple[str, np.ndarray]]:
    """Return named frames of random presses: sizes of 8 to 24 mm on a pad of 32 mm, .3 to 1.5 mm deep."""
    rng = np.random.default_rng([SEED, seed])
    made = []
    for key in SOLIDS:
        while len(made) < (list(SOLIDS).index(key) + 1) * per_kind:
            depth = float(rng.uniform(0.3e-3, 1.5e-3))
            field = side * pitch
            drawn = draw_contact(rng, key, field_m=(field, field), size_m=(field / 4, 0.75 * field), depth_m=depth)
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", RuntimeWarning)
                    pressed = press(
                        drawn.solid, skin, depth=drawn.depth_m, pose=drawn.pose, shape=(side, side), pitch_m=pitch
                    )
            except InputError:
                continue
            frame = sense(pressed)
            made.append((TRUE_NAME[key], frame + rng.normal(0, noise * frame.max(), frame.shape)))
    return made


def score_unknown(named: list[tuple[str, np.ndarray]]) -> Scores:
    """Score recognition from the taxels alone."""
    scores = Scores()
    for truth, frame in named:
        contacts = find_contacts(frame)
        if contacts:
            surface = recognize(contacts[0])
            scores.add(truth, surface.name, surface.probability)
        else:
            scores.add(truth, "unknown", 1.0)
    return scores


def score_known(named: list[tuple[str, np.ndarray]], skin: Skin, pitch: float) -> Scores:
    """Score recognition from the taxels and the surface seen through `skin`."""
    scores = Scores()
    for truth, frame in named:
        contacts = find_contacts(frame, pitch=pitch)
        if contacts:
            surface = recognize(contacts[0], relief=relief_of(contacts[0], skin, among=contacts))
            scores.add(truth, surface.name, surface.probability)
        else:
            scores.add(truth, "unknown", 1.0)
    return scores


def main() -> None:
    """Print the figures of every setting."""
    for seed, (name, skin, side, pitch, noise, bar, known_bar) in enumerate(SETTINGS):
        named = frames(skin, side, pitch, noise, seed, FRAMES_PER_KIND)
        of = f"{name}, noise {noise:.0%}"
        print(f"{of}, skin unknown:")
        score_unknown(named).report(f"{of}, skin unknown", bar=f">= {100 * bar:.1f}")
        print(f"{of}, skin file:")
        score_known(named, skin, pitch).report(f"{of}, skin file", bar=f">= {100 * known_bar:.1f}")
        if skin.thickness_m is not None:
            for factor in (0.7, 1.3):
                wrong = replace(skin, thickness_m=factor * skin.thickness_m)
                right = score_known(named, wrong, pitch).right
                what = f"{name}, thickness in the skin file {factor:.0%} of the true one: right name"
                print(f"{what} {share(what, right.mean(), '.2f')}")


if __name__ == "__main__":
    main()
