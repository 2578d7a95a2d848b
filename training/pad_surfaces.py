"""Learn what surface presses a pad, from pressed solids and from grasps of the simulated hand.

``python -m training.pad_surfaces`` (ten minutes on one core) writes
``src/varishold/touch/pads/parameters.npz``: for pads with a known skin and for bare pressure, a network of one
layer that gives the surfaces' likelihoods, one for the curvatures and one for their spread.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from training.pad_grasps import grasped_pads
from training.pad_scenes import NOMINAL, LabelledPad, scenes
from varishold.files import atomic_write
from varishold.frame import frame_noise
from varishold.skin import Skin
from varishold.touch.pads.measures import MEASURES, measure_pad
from varishold.touch.pads.surface import LOG_SPREAD, SURFACES

__all__ = ["Examples", "examples", "main"]

Floats = NDArray[np.float64]

OUT = Path(__file__).parents[1] / "src" / "varishold" / "touch" / "pads" / "parameters.npz"

#: Grasps and scenes to learn from; what tests and benchmarks use begins at 6,000,000,000.
_GRASP_SEEDS = range(5_100_000_000, 5_100_000_450)
_SCENE_SEEDS, _BARE_SEEDS, _SCENES_A_SEED, _BARE_A_SEED = range(100, 110), range(200, 202), 800, 700
_CLIP, _BEND_M = 4.0, 0.02
_HIDDEN, _DECAY = 32, 16.0
_HELD_OUT = 0.2


@dataclass(frozen=True)
class Examples:
    """Measures of pads and the truth under them; a row a pad."""

    measures: Floats
    surface: NDArray[np.intp]
    curvature_1_m: Floats
    radius_m: Floats


def examples(pads: Iterable[LabelledPad], skin: Skin | None) -> Examples:
    """Measure pads as if their skin were `skin`; those on which nothing is felt are left out."""
    rows = []
    # Pads of one shape after each other: the skin's operators for a shape are kept for a while.
    for pad in sorted(pads, key=lambda pad: pad.frame.shape):
        sigma = float(frame_noise(pad.frame))
        if pad.frame.max() <= 4 * sigma:
            continue
        foot = measure_pad(pad.frame, skin, (pad.pitch_m, pad.pitch_m), sigma)
        rows.append((foot.measures, pad.surface, pad.curvature_1_m, pad.radius_m))
    measures, surface, curvature, radius = zip(*rows, strict=True)
    return Examples(np.array(measures), np.array(surface), np.array(curvature), np.array(radius))


def learn(*sources: Examples, seed: int = 0) -> dict[str, Floats]:
    """Return the tables of one way of looking, learned from several sources of pads."""
    data = Examples(
        *(np.concatenate([getattr(source, field.name) for source in sources]) for field in fields(Examples))
    )
    rng = np.random.default_rng(seed)
    shift, deviation = data.measures.mean(axis=0), data.measures.std(axis=0)
    scale = np.where(deviation > 1e-6, 1 / np.maximum(deviation, 1e-6), 0.0)
    white = np.clip((data.measures - shift) * scale, -_CLIP, _CLIP)
    held = rng.random(len(white)) < _HELD_OUT
    table: dict[str, Floats] = {
        "shift": shift,
        "scale": scale,
        "clip": np.array(_CLIP),
        "bend_m": np.array(_BEND_M),
    }
    weight = np.concatenate([_weights(source.surface, sources) for source in sources])
    layers = _classifier(white[~held], data.surface[~held], weight[~held], seed=seed)
    logits = _apply(white[held], layers)
    factor, offset = _calibration(logits, data.surface[held], weight[held])
    layers[2], layers[3] = layers[2] * factor, layers[3] * factor + offset
    _store(table, "surface", layers)

    target = np.column_stack([np.arcsinh(_BEND_M * data.curvature_1_m), -np.log(data.radius_m)])
    curved = data.surface == SURFACES.index("curved")
    bend, spread = [], []
    reach = 0.0
    for k in range(3):
        use = np.flatnonzero(curved if k == 2 else np.ones(len(white), dtype=bool))
        if k == 2:
            # All radii alike: what sizes are usual is for the belief to know, not for a pad.
            use = rng.choice(use, use.size, p=_even_radii(data.radius_m[use]))
        fit, rest = use[~held[use]], use[held[use]]
        # Fitted in two halves, so that each half's errors are those of a stranger.
        half = rng.random(len(white))[fit] < 0.5
        error = np.zeros(fit.size)
        for part in (half, ~half):
            strange = _regressor(white[fit[part]], target[fit[part], k], seed)
            error[~part] = np.abs(target[fit[~part], k] - strange.predict(white[fit[~part]]))
        bend.append(_regressor(white[fit], target[fit, k], seed))
        level = _regressor(white[fit], np.log(error + 0.01), seed, alpha=30.0)
        spread.append(level)
        scaled = np.abs(target[rest, k] - bend[k].predict(white[rest])) / np.exp(
            np.clip(level.predict(white[rest]), *LOG_SPREAD)
        )
        # One standard deviation holds 68 %.
        one = float(np.quantile(scaled, 0.683))
        level.intercepts_[1] = level.intercepts_[1] + np.log(one)
        reach = float(np.quantile(scaled, 0.95)) / one
    _store(table, "bend", _side_by_side(bend))
    _store(table, "spread", _side_by_side(spread))
    table["reach"] = np.array(reach)
    return table


def _even_radii(radius_m: Floats) -> Floats:
    """Chances of being drawn that make radii even in logarithm, as far as there are examples."""
    of = np.digitize(np.log(radius_m), np.log(np.geomspace(0.01, 0.07, 9)))
    chance: Floats = 1 / np.maximum(np.bincount(of), 0.06 * radius_m.size)[of]
    return chance / chance.sum()


def _weights(surface: NDArray[np.intp], sources: Sequence[Examples]) -> Floats:
    """Weights that make the surfaces alike, each source's share of a surface growing as the root of its number."""
    total = sum(np.sqrt(np.bincount(source.surface, minlength=len(SURFACES))) for source in sources)
    count = np.maximum(np.bincount(surface, minlength=len(SURFACES)), 1)
    weight: Floats = (1 / np.sqrt(count) / np.maximum(total, 1))[surface]
    return weight


def _classifier(white: Floats, surface: NDArray[np.intp], weight: Floats, *, seed: int) -> list[Floats]:
    """A layer of tanh units fitted by L-BFGS to the weighted log loss."""
    from scipy.optimize import minimize

    rng = np.random.default_rng(seed)
    n, k, h = white.shape[1], len(SURFACES), _HIDDEN
    shapes = ((n, h), (h,), (h, k), (k,))
    sizes = [int(np.prod(s)) for s in shapes]
    start = np.concatenate(
        [rng.normal(0, 1 / np.sqrt(n), sizes[0]), np.zeros(h), rng.normal(0, 0.1, sizes[2]), np.zeros(k)]
    )
    share = weight / weight.sum()
    decay = _DECAY / len(white)

    def unpack(flat: Floats) -> list[Floats]:
        parts = np.split(flat, np.cumsum(sizes)[:-1])
        return [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)]

    def loss(flat: Floats) -> tuple[float, Floats]:
        w1, b1, w2, b2 = unpack(flat)
        hidden = np.tanh(white @ w1 + b1)
        logs = _log_softmax(hidden @ w2 + b2)
        back = np.exp(logs)
        back[np.arange(len(surface)), surface] -= 1
        back *= share[:, None]
        inner = (back @ w2.T) * (1 - hidden**2)
        gradient = [white.T @ inner + decay * w1, inner.sum(axis=0), hidden.T @ back + decay * w2, back.sum(axis=0)]
        value = -float(share @ logs[np.arange(len(surface)), surface])
        value += decay / 2 * (float((w1**2).sum()) + float((w2**2).sum()))
        return value, np.concatenate([g.ravel() for g in gradient])

    found = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": 600})
    return unpack(found.x)


def _log_softmax(logits: Floats) -> Floats:
    shifted = logits - logits.max(axis=1, keepdims=True)
    out: Floats = shifted - np.log(np.exp(shifted).sum(axis=1, keepdims=True))
    return out


def _apply(white: Floats, layers: list[Floats]) -> Floats:
    w1, b1, w2, b2 = layers
    out: Floats = np.tanh(white @ w1 + b1) @ w2 + b2
    return out


def _calibration(logits: Floats, surface: NDArray[np.intp], weight: Floats) -> tuple[float, Floats]:
    """Factor on and offsets of the logits that make held-out surfaces most probable (Guo et al. 2017)."""
    from scipy.optimize import minimize

    share = weight / weight.sum()

    def loss(p: Floats) -> float:
        logs = _log_softmax(logits * np.exp(p[0]) + p[1:])
        return -float(share @ logs[np.arange(len(surface)), surface]) + 0.01 * float(p[1:] @ p[1:])

    found = minimize(loss, np.zeros(1 + len(SURFACES))).x
    return float(np.exp(found[0])), found[1:]


def _regressor(white: Floats, target: Floats, seed: int, *, alpha: float = 3.0):  # type: ignore[no-untyped-def]
    from sklearn.neural_network import MLPRegressor

    model = MLPRegressor(
        hidden_layer_sizes=(12,), activation="tanh", solver="lbfgs", alpha=alpha, max_iter=400, random_state=seed
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return model.fit(white, target)


def _side_by_side(models) -> list[Floats]:  # type: ignore[no-untyped-def]
    """One network of several that have nothing in common but their inputs."""
    width = models[0].coefs_[0].shape[1]
    second = np.zeros((width * len(models), len(models)))
    for k, model in enumerate(models):
        second[k * width : (k + 1) * width, k] = model.coefs_[1][:, 0]
    return [
        np.concatenate([m.coefs_[0] for m in models], axis=1),
        np.concatenate([m.intercepts_[0] for m in models]),
        second,
        np.concatenate([m.intercepts_[1] for m in models]),
    ]


def _store(table: dict[str, Floats], name: str, layers: list[Floats]) -> None:
    for key, value in zip(("weight_1", "bias_1", "weight_2", "bias_2"), layers, strict=True):
        table[f"{name}_{key}"] = value


def write_tables(tables: dict[str, dict[str, Floats]], path: Path = OUT) -> None:
    """Write the tables of all ways of looking in one file."""
    arrays: dict[str, NDArray[np.generic]] = {"measures": np.array(MEASURES), "surfaces": np.array(SURFACES)}
    for variant, table in tables.items():
        arrays |= {f"{variant}_{key}": value.astype(np.float32) for key, value in table.items()}
    with atomic_write(path) as file:
        np.savez_compressed(file, **arrays)


def main() -> None:
    begun = time.monotonic()
    grasped = [pad for _, _, pad in grasped_pads(_GRASP_SEEDS, finger_scale=(1.0, 1.2))]
    print(f"{len(grasped)} grasped pads, {time.monotonic() - begun:.0f} s", flush=True)
    drawn = [pad for seed in _SCENE_SEEDS for pad in scenes(seed, _SCENES_A_SEED)]
    print(f"{len(drawn)} drawn pads, {time.monotonic() - begun:.0f} s", flush=True)
    other = [pad for seed in _BARE_SEEDS for pad in scenes(seed, _BARE_A_SEED, skin=None)]
    print(f"{len(other)} drawn pads of any skin, {time.monotonic() - begun:.0f} s", flush=True)
    seen = learn(examples(grasped, NOMINAL), examples(drawn, NOMINAL))
    bare = learn(*(examples(pads, None) for pads in (grasped, drawn, other)))
    write_tables({"seen": seen, "bare": bare})
    print(f"{OUT}: written after {time.monotonic() - begun:.0f} s")


if __name__ == "__main__":
    main()
