"""Time of one touch without simulation: belief and choice of the next touch, and what turns a touch into evidence.

``OMP_NUM_THREADS=1 python -m benchmarks.perceive_speed`` (about 15 seconds) feels examples of the shipped library
again, in sequences of three touches drawn with a seed. Belief: update, probabilities, p_value and size. Times are of
this process alone, medians and 95 % quantiles in milliseconds.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks._figures import figure
from varishold.perceive import (
    Belief,
    Evidence,
    GripContacts,
    Library,
    Perceiver,
    form_values,
    grip_values,
    shipped_library,
)
from varishold.skin import Skin, Taxels, press, sense
from varishold.touch import feel_surface

Keep = Callable[[str], bool]
Times = dict[str, list[float]]

_SEED = 20_260_000
_MISSING = ("index.distal", "thumb.distal", "palm")
_PITCH_M, _SHAPE = 0.002, (8, 20)


def examples(library: Library, n: int, rng: np.random.Generator) -> list[list[Evidence]]:
    """Draw sequences of three touches of the same example from the library's own examples."""
    out = []
    for row in rng.permutation(len(library)):
        made = [touch for touch, model in library.touches.items() if model.made[row]]
        if len(made) < 3:
            continue
        touches = []
        for touch in [made[k] for k in rng.permutation(len(made))[:3]]:
            model = library.touches[touch]
            values = dict(zip(model.metric.names, model.values[row].tolist(), strict=True))
            if model.size is not None:
                values |= dict(zip(model.size.names, model.size_values[row].tolist(), strict=True))
            touches.append(Evidence(touch, values))
        out.append(touches)
        if len(out) == n:
            break
    return out


def _milliseconds(begun: float) -> float:
    return 1e3 * (time.process_time() - begun)


def time_touches(library: Library, sequences: list[list[Evidence]], keep: Keep) -> Times:
    """Return the time of every touch, of its parts, and of all that a perceiver does."""
    times: Times = {"belief": [], "next touch": [], "both": [], "perceiver, with reasons": []}
    for sequence in sequences:
        belief, perceiver = Belief.before(library), Perceiver(library, most_touches=9)
        for full in sequence:
            evidence = Evidence(full.touch, {name: value for name, value in full.values.items() if keep(name)})
            begun = time.process_time()
            belief = belief.after(evidence)
            _ = belief.probability, belief.p_value, belief.size()
            times["belief"].append(_milliseconds(begun))
            perceiver.feel(evidence)
            times["perceiver, with reasons"].append(_milliseconds(begun) - times["belief"][-1])
            begun = time.process_time()
            perceiver.next_touch()
            times["next touch"].append(_milliseconds(begun))
            times["both"].append(times["belief"][-1] + times["next touch"][-1])
    return times


def a_grip(rng: np.random.Generator, parts: int = 20) -> GripContacts:
    """Draw capsules laid round a cylinder, half of them touching, as the phalanges and buttons of a hand."""
    size_m = rng.uniform(0.05, 0.11)
    facing = 2 * np.pi * np.arange(parts) / parts + rng.uniform(-0.2, 0.2, parts)
    out = np.column_stack([np.cos(facing), np.sin(facing), 0 * facing])
    along = np.column_stack([-np.sin(facing), np.cos(facing), 0 * facing])
    touched = np.arange(parts) % 2 == 0
    off_m = size_m / 2 + 0.008 + np.where(touched, rng.normal(0, 5e-4, parts), rng.uniform(0.005, 0.02, parts))
    line = np.array([size_m / 2, 0, 0]) + off_m[:, None] * out + np.outer(rng.uniform(-0.03, 0.03, parts), [0, 0, 1])
    names = tuple(f"digit{k % 5}.{k // 5}" for k in range(parts))
    return GripContacts(names, line - 0.012 * along, line + 0.012 * along, np.full(parts, 0.008), touched)


def frames(n: int) -> list[NDArray[np.float64]]:
    """Return frames of a pad pressed on cylinders of several radii."""
    skin = Skin("layer", thickness_m=0.004, poisson=0.45, sensing_depth_m=0.001, youngs_modulus_pa=1.5e5)
    x_m = (np.arange(2 * _SHAPE[1]) + 0.5 - _SHAPE[1]) * _PITCH_M / 2
    out = []
    for k, radius_m in enumerate(np.geomspace(0.02, 0.06, n)):
        height_m = np.broadcast_to(-(x_m**2) / (2 * radius_m), (2 * _SHAPE[0], 2 * _SHAPE[1]))
        done = press(height_m, skin, force=4.0, shape=_SHAPE, pitch_m=_PITCH_M, per_taxel=2, tolerance=1e-3)
        out.append(sense(done, Taxels(noise=0.01), seed=k))
    return out


def time_evidence(rng: np.random.Generator, n: int) -> Times:
    """Return the time of fitting all sections to a grip, and of feeling the surface under one pad."""
    times: Times = {"a grip, all sections": [], "one pad's surface": []}
    skin = Skin("layer", thickness_m=0.004, poisson=0.45, sensing_depth_m=0.001, youngs_modulus_pa=1.5e5)
    pressed = frames(8)
    for k in range(n + 1):
        grip = a_grip(rng)
        begun = time.process_time()
        grip_values(grip)
        form_values(grip)
        times["a grip, all sections"].append(_milliseconds(begun))
        begun = time.process_time()
        feel_surface(pressed[k % len(pressed)], skin, pitch_m=_PITCH_M)
        times["one pad's surface"].append(_milliseconds(begun))
    return {what: taken[1:] for what, taken in times.items()}


def _print(title: str, times: Times) -> None:
    print(title)
    for what, taken in times.items():
        middle = figure(f"{title}: {what}", np.median(taken), "7.2f", "ms")
        print(f"  {what:<26} {middle} {np.quantile(taken, 0.95):7.2f}")


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sequences", type=int, default=60)
    options = parser.parse_args(list(argv))
    rng = np.random.default_rng(_SEED)
    library = shipped_library()
    sequences = examples(library, options.sequences, rng)
    conditions: dict[str, Keep] = {
        "all evidence known": lambda name: True,
        "three pads missing": lambda name: not name.startswith(tuple(f"pad.{pad}." for pad in _MISSING)),
        "no coordinates": lambda name: not name.startswith(("fit.", "size.", "form.grip", "tip.height")),
    }
    # What is made once for a library is made before.
    time_touches(library, sequences[:3], conditions["all evidence known"])
    print(
        f"{len(library)} examples of {len(library.objects)} objects, {len(library.touches)} touches; ms: median, 95 %"
    )
    for title, keep in conditions.items():
        _print(title, time_touches(library, sequences, keep))
    _print("to make evidence", time_evidence(rng, 100))


if __name__ == "__main__":
    main(sys.argv[1:])
