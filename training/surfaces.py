"""Learn the shipped tables of touch: ``python -m training.surfaces`` (about a quarter of an hour on two cores).

Generated frames are kept in ``out/training``, so that a run that was interrupted goes on
where it stopped. Same seed and versions, same tables.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from training.frames import KEYS, SMALL_PADS, USUAL_PADS, draw_pad, ideal_face, noisy, taxel_mean
from training.network import CLIP, Network, log_softmax, temperature, train
from training.presses import SKIN_PADS, SMALL_SKIN_PADS, Presser
from varishold.errors import InputError
from varishold.files import atomic_write
from varishold.skin import Skin
from varishold.touch import KINDS, SIGNATURE_NAMES, find_contacts, recognize
from varishold.touch.decision import kind_logits, load_parameters
from varishold.touch.recognizer import contact_signature
from varishold.touch.relief import RELIEF_NAMES, relief_of, relief_signature

SEED, SMALL_SEED = 1971, 2971
#: Chunks of frames that each table is learned from; an eighth more is held out to calibrate it.
CHUNKS = {"surfaces": 40, "small": 112, "early": 40, "reliefs": 40}
CHUNK = 1000
CACHE = Path("out/training")
FOLDER = Path("src/varishold/touch/parameters")
SKINS = ("winkler", "layer", "half-space")
# Nameless pillars are rare among things that are touched; strangers must hold against every named kind.
_WEIGHT = {"triangular-pillar": 0.25, "hexagonal-pillar": 0.15, "elliptic-pillar": 0.25, "stranger": 1.5}
# Share of ideal frames; the rest are presses into random skins, for a skin that is not known may be any.
_IDEAL = 0.4
# Share of generated frames whose true size a size interval holds.
_COVERED = 0.9


@dataclass(frozen=True)
class Frames:
    """Generated frames: pixels one after the other, and of each its shape, kind, true size and skin."""

    pixels: NDArray[np.float32]
    shape: NDArray[np.int64]
    kind: NDArray[np.int64]
    size: NDArray[np.float32]
    #: Place in `SKINS` (-1: ideal), thickness, Poisson's ratio, sensing depth, pitch.
    skin: NDArray[np.float64]

    def __iter__(self) -> Iterator[NDArray[np.float64]]:
        start = 0
        for rows, cols in self.shape.tolist():
            yield self.pixels[start : start + rows * cols].reshape(rows, cols).astype(np.float64)
            start += rows * cols


def frames_of(seed: int, index: int) -> Frames:
    """Return one chunk of generated frames, kept in `CACHE`; the seeds of `SMALL_SEED` are of small pads."""
    path = CACHE / f"frames-{seed}-{index}.npz"
    small = seed >= SMALL_SEED
    if path.is_file():
        with np.load(path, allow_pickle=False) as kept:
            return Frames(**{field.name: kept[field.name] for field in fields(Frames)})
    rng = np.random.default_rng([seed, index])
    presser = Presser(rng, SMALL_SKIN_PADS if small else SKIN_PADS)
    keys = [kind.key for kind in KINDS]
    weight = np.array([_WEIGHT.get(key, 1.0) for key in KEYS])
    pixels, shapes, kinds, sizes, skins = [], [], [], [], []
    for _ in range(CHUNK):
        key = str(rng.choice(KEYS, p=weight / weight.sum()))
        if rng.random() < _IDEAL:
            pad = draw_pad(rng, SMALL_PADS if small else USUAL_PADS)
            face = ideal_face(rng, key, pad)
            frame, size, skin = taxel_mean(face.height, 6), face.size, (-1.0, 0.0, 0.0, 0.0, 1.0)
        else:
            pressed = presser.draw(key)
            pad, frame, size = pressed.pad, pressed.frame, pressed.size
            under = pressed.skin
            skin = (
                float(SKINS.index(under.kind)),
                under.thickness_m or 0.0,
                under.poisson,
                under.sensing_depth_m,
                pressed.pitch_m,
            )
        frame = noisy(rng, frame, pad.noise)
        pixels.append((frame / frame.max()).astype(np.float32).ravel())
        shapes.append(pad.shape)
        kinds.append(keys.index(key))
        sizes.append(size)
        skins.append(skin)
    made = Frames(
        np.concatenate(pixels), np.array(shapes), np.array(kinds), np.array(sizes, np.float32), np.array(skins)
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as file:
        np.savez(file, **{field.name: getattr(made, field.name) for field in fields(Frames)})
    return made


Signatures = tuple[NDArray[np.float32], NDArray[np.int64]]


def taxel_signatures(task: tuple[int, int]) -> Signatures:
    """Return the signatures and kinds of one chunk's largest contacts."""
    frames = frames_of(*task)
    x, kept = [], []
    for i, frame in enumerate(frames):
        contacts = find_contacts(frame)
        if contacts:
            x.append(contact_signature(contacts[0]))
            kept.append(i)
    return np.array(x, np.float32), frames.kind[kept]


def early_signatures(task: tuple[int, int]) -> Signatures:
    """Return the signatures and kinds of one chunk's contacts when the threshold has fallen part of its way."""
    frames = frames_of(*task)
    rng = np.random.default_rng([*task, 2])
    x, kept = [], []
    for i, frame in enumerate(frames):
        contacts = find_contacts(frame)
        if not contacts:
            continue
        whole = contacts[0]
        fallen = find_contacts(frame, floor=whole.peak - float(rng.uniform(0.1, 0.95)) * (whole.peak - whole.floor))
        x.append(contact_signature(fallen[0]))
        kept.append(i)
    return np.array(x, np.float32), frames.kind[kept]


def relief_signatures(task: tuple[int, int]) -> Signatures:
    """Return the signatures, with those of their reliefs, of one chunk's presses into skins.

    Half of the skins that are looked through are a little wrong: a skin file is never quite right.
    """
    path = CACHE / f"reliefs-{task[0]}-{task[1]}.npz"
    if path.is_file():
        with np.load(path, allow_pickle=False) as made:
            return made["x"], made["y"]
    frames = frames_of(*task)
    rng = np.random.default_rng([*task, 1])
    x, kept = [], []
    blur: dict[bytes, Skin] = {}
    for i, (frame, row) in enumerate(zip(frames, frames.skin, strict=True)):
        if row[0] < 0:
            continue
        skin = blur.setdefault(row.tobytes(), _believed(rng, row))
        contacts = find_contacts(frame, pitch=float(row[4]))
        if not contacts:
            continue
        try:
            relief = relief_of(contacts[0], skin, among=contacts)
        except InputError:
            continue
        x.append(np.concatenate([contact_signature(contacts[0]), relief_signature(relief)]))
        kept.append(i)
    found = np.array(x, np.float32), frames.kind[kept]
    with atomic_write(path) as file:
        np.savez(file, x=found[0], y=found[1])
    return found


def _believed(rng: np.random.Generator, row: NDArray[np.float64]) -> Skin:
    """Return the skin that a skin file might say lies over the taxels."""
    kind, thickness, poisson, sensing = SKINS[int(row[0])], float(row[1]), float(row[2]), float(row[3])
    if rng.random() < 0.5:
        thickness *= float(np.exp(rng.uniform(-0.35, 0.35)))
        poisson = min(poisson + float(rng.uniform(-0.02, 0.02)), 0.499)
        sensing *= float(np.exp(rng.uniform(-0.15, 0.15)))
    if kind != "half-space":
        sensing = min(sensing, 0.6 * thickness)
    return Skin(kind, thickness_m=None if kind == "half-space" else thickness, poisson=poisson, sensing_depth_m=sensing)


def gather(make: Callable[[tuple[int, int]], Signatures], seed: int, chunks: int) -> Signatures:
    """Return the signatures of `chunks` chunks, made by all processors."""
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        parts = list(pool.map(make, [(seed, i) for i in range(chunks)]))
    return np.concatenate([x for x, _ in parts]), np.concatenate([y for _, y in parts])


def write_table(
    path: Path,
    names: tuple[str, ...],
    network: Network,
    factor: float,
    means: NDArray[np.floating],
    size_error: NDArray[np.floating],
    *,
    taxels_weight: float = 0.0,
) -> None:
    """Write a table, its logits scaled by `factor`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    columns: dict[str, NDArray[Any]] = {
        "inputs": np.array(names),
        "kinds": np.array([kind.key for kind in KINDS]),
        "shift": network.shift,
        "scale": network.scale,
        "clip": np.array(CLIP, np.float32),
        "kind_means": means.astype(np.float32),
        "size_error": size_error.astype(np.float32),
        "taxels_weight": np.array(taxels_weight),
    }
    last = len(network.weights)
    for i, (w, b) in enumerate(zip(network.weights, network.biases, strict=True), start=1):
        columns[f"weight_{i}"] = w * np.float32(factor) if i == last else w
        columns[f"bias_{i}"] = b * np.float32(factor) if i == last else b
    with atomic_write(path) as file:
        np.savez_compressed(file, **columns)
    load_parameters.cache_clear()


def size_errors(task: tuple[int, int]) -> list[tuple[int, float, float]]:
    """Return (kind, error of the long side, error of the short one) in taxels wherever the kind was right."""
    frames = frames_of(*task)
    errors = []
    for frame, kind, (long, short) in zip(frames, frames.kind.tolist(), frames.size.tolist(), strict=True):
        contacts = find_contacts(frame)
        if not contacts or not np.isfinite(long):
            continue
        surface = recognize(contacts[0])
        if KINDS[kind].name == surface.name:
            errors.append((kind, abs(surface.size[0] - long), abs(surface.size[1] - short)))
    return errors


def learn(x: NDArray[np.float32], y: NDArray[np.int64], held: Signatures) -> tuple[Network, float, NDArray[Any]]:
    """Return a network, the factor that calibrates its logits on held-out frames, and the kinds' mean inputs."""
    network = train(x, y, kinds=len(KINDS), hidden=(192, 64), decay=0.1, seed=SEED)
    logits = network.logits(held[0])
    factor = temperature(logits, held[1])
    report("held out", logits * factor, held[1])
    return network, factor, mean_inputs(network, x, y)


def learn_reliefs(
    x: NDArray[np.float32], y: NDArray[np.int64], held: Signatures
) -> tuple[Network, float, NDArray[Any], float]:
    """Return as `learn` does, and the weight of the taxels' own table beside this one's."""
    network = train(x, y, kinds=len(KINDS), hidden=(96, 48), decay=0.3, epochs=30, seed=SEED)
    taxels = load_parameters("surfaces")
    n = len(SIGNATURE_NAMES)
    white = np.clip((held[0][:, :n] - taxels.shift) * taxels.scale, -taxels.clip, taxels.clip)
    alone = np.array([kind_logits(np.ascontiguousarray(row), taxels) for row in white])
    logits = network.logits(held[0])
    report("held out, taxels alone", alone, held[1])
    report("held out, reliefs alone", logits * temperature(logits, held[1]), held[1])
    weights = np.linspace(0.2, 1.0, 17)
    both = [(loss_of(a * logits + b * alone, held[1]), a, b) for a in weights for b in weights]
    _, factor, taxels_weight = min(both)
    report("held out, both", factor * logits + taxels_weight * alone, held[1])
    return network, float(factor), mean_inputs(network, x, y), float(taxels_weight)


def loss_of(logits: NDArray[np.floating], y: NDArray[np.int64]) -> float:
    """Return the mean negative log-probability of the true kinds."""
    return float(-log_softmax(logits)[np.arange(len(y)), y].mean())


def report(what: str, logits: NDArray[np.floating], y: NDArray[np.int64]) -> None:
    """Print how well logits tell the kinds."""
    print(f"{what}: right kind {np.mean(logits.argmax(1) == y):.4f}, loss {loss_of(logits, y):.4f}")


def mean_inputs(network: Network, x: NDArray[np.float32], y: NDArray[np.int64]) -> NDArray[np.floating]:
    """Return each kind's mean whitened input."""
    white = np.clip((x - network.shift) * network.scale, -CLIP, CLIP)
    return np.array([white[y == kind].mean(axis=0) for kind in range(len(KINDS))])


def main() -> None:
    """Generate, learn, calibrate, and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--chunks", type=int, help="chunks of 1000 frames to learn from, of each table")
    parser.add_argument("--table", choices=("surfaces", "small", "early", "reliefs", "all"), default="all")
    options = parser.parse_args()

    def signatures(
        table: str, make: Callable[[tuple[int, int]], Signatures], seed: int
    ) -> tuple[Signatures, Signatures]:
        chunks = options.chunks or CHUNKS[table]
        return gather(make, seed, chunks), gather(make, seed + 1, max(chunks // 8, 1))

    if options.table in ("surfaces", "all"):
        (x, y), held = signatures("surfaces", taxel_signatures, SEED)
        learned = learn(x, y, held)
        error = np.full((len(KINDS), 2), np.nan)
        write_table(FOLDER / "surfaces.npz", SIGNATURE_NAMES, *learned, error)
        with ProcessPoolExecutor(os.cpu_count()) as pool:
            parts = pool.map(size_errors, [(SEED + 1, i) for i in range(max(CHUNKS["surfaces"] // 8, 1))])
            errors = np.array([row for part in parts for row in part])
        for kind in range(len(KINDS)):
            of = errors[errors[:, 0] == kind, 1:]
            if len(of) >= 20:
                error[kind] = np.quantile(of, _COVERED, axis=0)
        write_table(FOLDER / "surfaces.npz", SIGNATURE_NAMES, *learned, error)
    error = load_parameters("surfaces").size_error
    if options.table in ("small", "all"):
        (x, y), held = signatures("small", taxel_signatures, SMALL_SEED)
        learned = learn(x, y, held)
        write_table(FOLDER / "small.npz", SIGNATURE_NAMES, *learned, error)
    if options.table in ("early", "all"):
        (x, y), held = signatures("early", early_signatures, SEED)
        learned = learn(x, y, held)
        write_table(FOLDER / "early.npz", SIGNATURE_NAMES, *learned, error)
    if options.table in ("reliefs", "all"):
        (x, y), held = signatures("reliefs", relief_signatures, SEED)
        *learned, weight = learn_reliefs(x, y, held)
        names = (*SIGNATURE_NAMES, *RELIEF_NAMES)
        write_table(FOLDER / "reliefs.npz", names, *learned, error, taxels_weight=weight)


if __name__ == "__main__":
    main()
