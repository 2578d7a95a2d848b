"""Learn the shipped tables of touch: ``python -m training.surfaces`` (about an hour on two cores).

Clean frames and what drawn sensors read of them are kept in ``out/training``, so that a run that was interrupted goes
on where it stopped. Same seed and versions, same tables.
"""

from __future__ import annotations

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from training.chunks import CACHE
from training.faults import FAMILIES
from training.network import CLIP, Network, log_softmax, temperature, train
from training.readings import Readings, Task, Way, readings
from training.samples import Making
from training.scores import print_rows
from training.sizes import moved_to, size_spread
from varishold.files import atomic_write
from varishold.touch import KINDS, SIGNATURE_NAMES
from varishold.touch.decision import kind_logits, load_parameters
from varishold.touch.recognizer import table_for
from varishold.touch.relief import RELIEF_NAMES

#: Chunks of ideal faces, of presses, and of presses that the pad's border cuts.
Chunks = tuple[int, int, int]
SEED = 1971
STRANGER = [kind.key for kind in KINDS].index("stranger")
# Readings from which the scatter of kinds is taken.
MOST_NEAR = 60_000
# A reading of a worn face counts so much where logits are calibrated.
WORN = 0.5
# Chunks of each making whose sizes are looked at.
MOST_SIZED = 40
# Chunks of faces that are looked at as height maps: few are whole and hardly worn.
MOST_MAPS = 100
FOLDER = Path("src/varishold/touch/parameters")
# Columns that are kept in eleven bits, as weights are: sizes' intervals, what kinds look like on the mean, and how far
# from them they scatter.
COARSE = ("kind_means", "size_spread", "map_spread", "whiten", "means")


@dataclass(frozen=True)
class Recipe:
    """How one table is learned.

    Parameters
    ----------
    chunks : (int, int, int)
        Chunks of ideal faces, of presses and of such as the pad's border cuts; some more are held out to calibrate.
    hidden : tuple of int
        Units of the hidden layers.
    epochs : int
    decay : float
    way : {"whole", "early", "relief"}
    pads : str
        A key of `PADS`.
    strangers : float
        Share of the readings of strangers that is kept: on a few taxels nearly every form might be one.
    met : float
        How often strangers are met, over how often they were drawn so that they be well known.
    """

    chunks: Chunks
    hidden: tuple[int, ...]
    epochs: int
    decay: float
    pads: str
    way: Way = "whole"
    strangers: float = 1.0
    met: float = 1.0


RECIPES: dict[str, Recipe] = {
    "surfaces": Recipe((240, 400, 50), (256, 96, 64), 24, 0.1, "surfaces", met=0.5),
    "middle": Recipe((360, 600, 180), (256, 96, 64), 24, 0.1, "middle", met=0.5),
    "small": Recipe((240, 360, 0), (192, 96), 24, 0.15, "small", strangers=0.5, met=0.5),
    "early": Recipe((24, 24, 0), (128, 64), 20, 0.15, "wide", way="early"),
    "reliefs": Recipe((0, 36, 0), (96, 48), 20, 0.3, "wide", way="relief"),
}


def held_out(chunks: Chunks) -> Chunks:
    """Return how many chunks more are drawn that no weight is learned from."""
    ideal, pressed, border = (min(-(-n // 6), 24) for n in chunks)
    return ideal, pressed, min(border, 4)


def tasks_of(recipe: Recipe, seed: int, chunks: Chunks, without: str = "") -> list[Task]:
    """Return so many chunks of each making."""
    return [
        Task(making, seed, i, recipe.pads, recipe.way, without)
        for making, n in zip(get_args(Making), chunks, strict=True)
        for i in range(n)
    ]


def gather(recipe: Recipe, seed: int, chunks: Chunks, without: str = "") -> Readings:
    """Return the readings of so many chunks, made by all processors."""
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        parts = list(pool.map(readings, tasks_of(recipe, seed, chunks, without)))
    kind = np.concatenate([part.kind for part in parts])
    kept = (kind != STRANGER) | (np.random.default_rng(seed).random(len(kind)) < recipe.strangers)
    return Readings(
        **{f.name: np.concatenate([getattr(part, f.name) for part in parts])[kept] for f in fields(Readings)}
    )


def write_table(
    name: str, names: tuple[str, ...], network: Network, factor: float, more: dict[str, NDArray[Any]]
) -> None:
    """Write a table, its logits scaled by `factor`."""
    path = FOLDER / f"{name}.npz"
    columns: dict[str, NDArray[Any]] = {
        "inputs": np.array(names),
        "kinds": np.array([kind.key for kind in KINDS]),
        "shift": network.shift,
        "scale": network.scale,
        "clip": np.array(CLIP, np.float32),
        **{what: column.astype(np.float16) if what in COARSE else column for what, column in more.items()},
    }
    last = len(network.weights)
    for i, (w, b) in enumerate(zip(network.weights, network.biases, strict=True), start=1):
        # Eleven bits say as much as 24: the file is half as large.
        columns[f"weight_{i}"] = (w * np.float32(factor) if i == last else w).astype(np.float16)
        columns[f"bias_{i}"] = b * np.float32(factor) if i == last else b
    with atomic_write(path) as file:
        np.savez_compressed(file, **columns)
    load_parameters.cache_clear()


def network_of(recipe: Recipe, columns: dict[str, NDArray[Any]], *, first: int) -> Network:
    """Take a network out of a file's columns, whose first layer has this number."""
    layers = range(first, first + 1 + len(recipe.hidden))
    weights, biases = ([columns.pop(f"{what}_{i}").astype(np.float32) for i in layers] for what in ("weight", "bias"))
    return Network(columns.pop("shift"), columns.pop("scale"), weights, biases)


def trained(recipe: Recipe, made: Readings, label: str) -> Network:
    """Return the network of a recipe, kept in `CACHE`."""
    path = CACHE / f"network-{label}.npz"
    if path.is_file():
        with np.load(path, allow_pickle=False) as kept:
            return network_of(recipe, dict(kept), first=0)
    network = train(
        made.x, made.kind, kinds=len(KINDS), hidden=recipe.hidden, decay=recipe.decay, epochs=recipe.epochs, seed=SEED
    )
    layered = {f"weight_{i}": w for i, w in enumerate(network.weights)}
    layered |= {f"bias_{i}": b for i, b in enumerate(network.biases)}
    with atomic_write(path) as file:
        np.savez(file, shift=network.shift, scale=network.scale, **layered)
    return network


def calibrated(recipe: Recipe, network: Network, held: Readings) -> float:
    """Return the factor that calibrates a network's logits on held-out readings; strangers become as rare as met.

    Those of named things on usual sensors, worn ones for less: several faults at once, and worn faces, are drawn more
    often than they are met.
    """
    logits = network.logits(held.x)
    met = held.usual & (held.kind != STRANGER)
    factor = temperature(logits[met], held.kind[met], np.where(held.worn[met], WORN, 1.0))
    network.biases[-1][STRANGER] += np.float32(np.log(recipe.met) / factor)
    logits = network.logits(held.x)
    print(f"factor {factor:.2f}, loss {loss_of(logits * factor, held.kind):.4f}")
    print_rows(logits * factor, held)
    return factor


def calibrate_again(name: str, recipe: Recipe, held: Readings) -> None:
    """Calibrate a table that is there on held-out readings, and write it; nothing else of it is learned again."""
    with np.load(FOLDER / f"{name}.npz", allow_pickle=False) as read:
        columns = dict(read)
    network = network_of(recipe, columns, first=1)
    network.biases[-1][STRANGER] -= np.float32(np.log(recipe.met))
    factor = calibrated(recipe, network, held)
    if recipe.way == "relief":
        factor, weight = weigh_taxels(network, held)
        columns["taxels_weight"] = np.array(weight)
    names = tuple(columns.pop("inputs").tolist())
    for known in ("kinds", "clip"):
        del columns[known]
    write_table(name, names, network, factor, columns)


def weigh_taxels(network: Network, held: Readings) -> tuple[float, float]:
    """Return the factor of a table of reliefs and the weight of the taxels' own tables beside it."""
    n = len(SIGNATURE_NAMES)
    alone = []
    for x, shape in zip(held.x[:, :n], held.shape.tolist(), strict=True):
        taxels = load_parameters(table_for(tuple(shape)))
        white = np.clip((x - taxels.shift) * taxels.scale, -taxels.clip, taxels.clip)
        alone.append(kind_logits(np.ascontiguousarray(white), taxels))
    logits, beside = network.logits(held.x), np.array(alone)
    weights = np.linspace(0.2, 1.0, 17)
    _, factor, weight = min((loss_of(a * logits + b * beside, held.kind), a, b) for a in weights for b in weights)
    for what, z in (("taxels alone", beside), ("both", factor * logits + weight * beside)):
        print(f"{what}: right kind {np.mean(z.argmax(1) == held.kind):.4f}, loss {loss_of(z, held.kind):.4f}")
    return float(factor), float(weight)


def loss_of(logits: NDArray[np.floating], y: NDArray[np.int64]) -> float:
    """Return the mean negative log-probability of the true kinds."""
    return float(-log_softmax(logits)[np.arange(len(y)), y].mean())


def nearness(network: Network, made: Readings) -> dict[str, NDArray[Any]]:
    """Return what tells how far a contact lies from every kind that has a name, in their own scatter."""
    some = slice(0, None, max(1, len(made.x) // MOST_NEAR))
    hidden, kind = network.hidden(made.x[some]).astype(np.float64), made.kind[some]
    named = [k for k, entry in enumerate(KINDS) if entry.name != "unknown"]
    means = np.array([hidden[kind == k].mean(axis=0) for k in named])
    known = np.isin(kind, named)
    scatter = hidden[known] - means[np.searchsorted(named, kind[known])]
    covariance = np.cov(scatter.T)
    covariance += 1e-2 * np.trace(covariance) / len(covariance) * np.eye(len(covariance))
    whiten = np.linalg.cholesky(np.linalg.inv(covariance))
    turned, near = hidden[known] @ whiten, means @ whiten
    distance = np.sqrt(np.min([((turned - m) ** 2).sum(axis=1) for m in near], axis=0))
    return {
        "whiten": whiten.astype(np.float32),
        "means": near.astype(np.float32),
        "farthest": np.array(np.quantile(distance, 1 - 1e-3)),
    }


def mean_inputs(network: Network, made: Readings) -> NDArray[np.float32]:
    """Return each kind's mean whitened input."""
    white = np.clip((made.x - network.shift) * network.scale, -CLIP, CLIP)
    return np.array([white[made.kind == kind].mean(axis=0) for kind in range(len(KINDS))], np.float32)


def make(name: str, recipe: Recipe, chunks: Chunks, without: str) -> None:
    """Draw, read and learn one table, calibrate it and write it; without a fault it is only looked at."""
    made = gather(recipe, SEED, chunks, without)
    held = gather(recipe, SEED + 1, held_out(chunks))
    label = "-".join(map(str, (name, *chunks))) + (f"-without-{without.replace(' ', '-')}" if without else "")
    network = trained(recipe, made, label)
    factor = calibrated(recipe, network, held)
    if without:
        return
    names: tuple[str, ...] = SIGNATURE_NAMES
    columns: dict[str, NDArray[Any]] = {
        "kind_means": mean_inputs(network, made),
        "size_spread": np.zeros((len(KINDS), 2, 2, 1 + len(SIGNATURE_NAMES)), np.float32),
        "map_spread": np.zeros((len(KINDS), 2, 2, 1 + len(SIGNATURE_NAMES)), np.float32),
        "taxels_weight": np.array(0.0),
        **nearness(network, made),
    }
    if recipe.way == "whole":
        # Sizes are those of the names that the table itself gives.
        write_table(name, names, network, factor, columns)
        ideal, pressed, border = chunks
        columns["size_spread"], columns["map_spread"] = size_spread(
            tasks_of(recipe, SEED, (min(ideal, MOST_SIZED), min(pressed, MOST_SIZED), min(border, MOST_SIZED // 8))),
            tasks_of(recipe, SEED, (min(ideal, MOST_MAPS), 0, 0)),
        )
    else:
        surfaces = load_parameters("surfaces")
        columns["size_spread"] = moved_to(surfaces.size_spread, surfaces, network)
        columns["map_spread"] = moved_to(surfaces.map_spread, surfaces, network)
    if recipe.way == "relief":
        names = (*SIGNATURE_NAMES, *RELIEF_NAMES)
        factor, weight = weigh_taxels(network, held)
        columns["taxels_weight"] = np.array(weight)
    write_table(name, names, network, factor, columns)


def main() -> None:
    """Make the tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--chunks", type=int, help="learn from so many chunks of each making only, to try something")
    parser.add_argument("--table", choices=(*RECIPES, "all"), default="all")
    parser.add_argument(
        "--without", choices=tuple(FAMILIES), default="", help="leave a fault out, and look; writes nothing"
    )
    parser.add_argument("--calibrate", action="store_true", help="only calibrate the tables that are there again")
    options = parser.parse_args()
    for name, recipe in RECIPES.items():
        if options.table in (name, "all"):
            print(name, flush=True)
            most = options.chunks or max(recipe.chunks)
            ideal, pressed, border = (min(n, most) for n in recipe.chunks)
            if options.calibrate:
                calibrate_again(name, recipe, gather(recipe, SEED + 1, held_out((ideal, pressed, border))))
            else:
                make(name, recipe, (ideal, pressed, border), options.without)


if __name__ == "__main__":
    main()
