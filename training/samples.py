"""Labelled samples of touch: clean frames of drawn faces and presses, read by many drawn sensors."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from training.chunks import keep, kept
from training.faces import UNBOUNDED, WEIGHTS, Drawn, face_over, worn
from training.faults import blurred
from training.frames import PADS, Pad, draw_pad, taxel_mean
from training.presses import SKIN_PADS, draw_skin, draw_skin_pad, press_on
from varishold.errors import InputError
from varishold.skin import press, sense
from varishold.touch import KINDS

Array = NDArray[np.float64]
Making = Literal["ideal", "press", "border"]

#: Clean frames of a chunk.
CHUNK = {"ideal": 1000, "press": 250, "border": 250}
SKINS = ("winkler", "layer", "half-space")
#: Share of the ideal faces around which the cover hangs as a gel does, by table: fine arrays look at gels.
_SKIRTED = {"surfaces": 0.14}
_KEYS = [kind.key for kind in KINDS]


@dataclass(frozen=True)
class Clean:
    """Clean frames, their peak 1: pixels one after the other, and of each its shape, kind, wear, true size and skin."""

    pixels: NDArray[np.float32]
    shape: NDArray[np.int64]
    kind: NDArray[np.int64]
    #: Rounding over breadth, tilt over what the depth allows, curvature, share cut off, stretch.
    wear: NDArray[np.float32]
    #: Long and short side in taxels; NaN where there is none.
    size: NDArray[np.float32]
    #: Place in `SKINS` (-1: ideal), thickness, Poisson's ratio, sensing depth, pitch.
    skin: NDArray[np.float64]
    #: Range of white noise.
    noise: NDArray[np.float32]

    def __iter__(self) -> Iterator[Array]:
        start = 0
        for rows, cols in self.shape.tolist():
            yield self.pixels[start : start + rows * cols].reshape(rows, cols).astype(np.float64)
            start += rows * cols


def true_size(d: Drawn) -> tuple[float, float]:
    """Return the (long, short) lengths that recognition should report: a frustum's are its top's."""
    if d.key in ("stranger", "edge", "wedge", "plane") or d.key.startswith(("triangular", "hexagonal", "elliptic")):
        return np.nan, np.nan
    if d.key in ("cone-frustum", "pyramid-frustum"):
        return d.long * d.top, d.long * d.top
    return d.long, d.short


def wear_of(d: Drawn, shape: tuple[int, int]) -> tuple[float, float, float, float, float]:
    """Return how much a face is rounded, leans, bends, is cut off and is stretched."""
    reach = max(d.long if np.isfinite(d.long) else 0.0, 1.0)
    out = max(abs(d.x) + d.short / 2 - shape[1] / 2, abs(d.y) + d.short / 2 - shape[0] / 2, 0.0) / max(d.short, 1e-9)
    cut = 0.0 if d.key in ("edge", "wedge", "plane", "lying-cylinder", "stranger") else min(out, 1.0)
    return d.rounding / d.short, float(np.hypot(*d.tilt)) * reach / d.depth, max(d.curve), cut, abs(np.log(d.stretch))


def _beyond(rng: np.random.Generator, d: Drawn, shape: tuple[int, int]) -> int:
    """Return over how many taxels the skin goes on, pressed by the same body, beyond each border of the pad."""
    if d.key == "stranger" or rng.random() < 0.4:
        return 0
    x, y = abs(d.x) + d.long / 2, abs(d.y) + d.long / 2
    leaves = d.key in ("edge", "wedge", "plane") or x > shape[1] / 2 or y > shape[0] / 2
    return max(2, round(0.3 * min(shape))) if leaves else 0


def _pressed(
    rng: np.random.Generator, key: str, pads: str, state: dict[str, object], at_border: bool
) -> tuple[Array, Drawn, Pad, tuple[float, ...]]:
    """Press a face into a skin that several presses share, cut by the pad's border where that is wanted."""
    while True:
        if not state.get("left"):
            pad, pitch, per_taxel = draw_skin_pad(rng, SKIN_PADS[pads])
            state.update(pad=pad, pitch=pitch, per=per_taxel, skin=draw_skin(rng, pitch, pitch / per_taxel), left=20)
        state["left"] = int(state["left"]) - 1  # type: ignore[call-overload]
        pad, pitch, per_taxel, skin = state["pad"], state["pitch"], state["per"], state["skin"]
        under = (
            float(SKINS.index(skin.kind)), skin.thickness_m or 0.0, skin.poisson, skin.sensing_depth_m, pitch
        )  # fmt: skip
        try:
            if not at_border and key != "stranger" and rng.random() < 0.55:
                made = press_on(rng, key, pad, skin, pitch, per_taxel)
                d = Drawn(key, made.size[0], made.size[1], 1.0)
                return made.frame, d, pad, under
            shape = pad.shape
            face = face_over(
                rng,
                key,
                shape,
                pad.size,
                per_taxel=2 * per_taxel if max(shape) < 20 else per_taxel,
                plain=0.7 if at_border else 0.1,
                at_border=at_border,
            )
            breadth = min(face.drawn.short, pad.size[1]) * pitch
            deepest = 0.3 * breadth if skin.thickness_m is None else min(0.3 * breadth, 0.4 * skin.thickness_m)
            depth = float(np.exp(rng.uniform(*np.log((max(0.1 * deepest, 1e-5), deepest)))))
            beyond = _beyond(rng, face.drawn, shape)
            around = (shape[0] + 2 * beyond, shape[1] + 2 * beyond)
            height = face.height * 1.5 if key == "stranger" else np.maximum(face.over(around) + 1.5, 0.0)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                pressed = press(
                    height * depth, skin, depth=depth, shape=around, pitch_m=pitch, per_taxel=per_taxel, tolerance=1e-3
                )
                frame = sense(pressed)[beyond : beyond + shape[0], beyond : beyond + shape[1]]
            return frame, replace(face.drawn, key=face.key), pad, under
        except InputError:
            continue


def _with_skirt(rng: np.random.Generator, height: Array, per_taxel: int) -> Array:
    """Return heights (peak about 1) with a skirt around them: a gel that comes up to the body, like a tent."""
    high = float(np.exp(rng.uniform(*np.log((0.03, 0.35))))) * float(height.max())
    breadth = np.sqrt(np.count_nonzero(height)) / per_taxel
    reach = float(np.exp(rng.uniform(*np.log((0.03, 0.4))))) * breadth
    away = ndimage.distance_transform_edt(height <= 0.0) / per_taxel
    return np.maximum(height, high * np.exp(-away / max(reach, 0.5)))


def clean_frames(making: Making, seed: int, index: int, pads: str) -> Clean:
    """Return one chunk of clean frames on the pads of a table, kept between runs."""
    label = f"clean-{pads}-{making}-{seed}-{index}"
    known = kept(Clean, label)
    if known is not None:
        return known
    rng = np.random.default_rng([seed, index, len(making), list(PADS).index(pads)])
    weight = np.array([0.0 if making == "border" and key in UNBOUNDED else w for key, w in WEIGHTS.items()])
    state: dict[str, object] = {}
    rows: list[
        tuple[
            Array, tuple[int, int], int, tuple[float, ...], tuple[float, float], tuple[float, ...], tuple[float, float]
        ]
    ] = []
    while len(rows) < CHUNK[making]:
        key = str(rng.choice(list(WEIGHTS), p=weight / weight.sum()))
        if making == "ideal":
            pad = draw_pad(rng, PADS[pads])
            per_taxel = max(3, min(10, 160 // max(pad.shape)))
            face = face_over(rng, key, pad.shape, pad.size, per_taxel=per_taxel)
            height = np.maximum(face.height, 0.0)
            skirted = pads in _SKIRTED and rng.random() < _SKIRTED[pads]
            frame = taxel_mean(_with_skirt(rng, height, per_taxel) if skirted else height, per_taxel)
            d, under = replace(face.drawn, key=face.key), (-1.0, 0.0, 0.0, 0.0, 1.0)
            if rng.random() < 0.35:
                # A thin cover spreads what presses on it.
                frame = blurred(frame, float(np.exp(rng.uniform(*np.log((0.25, 1.2))))))
        else:
            skirted = False
            frame, d, pad, under = _pressed(rng, key, pads, state, making == "border")
        peak = float(frame.max())
        if not peak > 0:
            continue
        # How far a skirt widens a contact is no matter of the table's.
        size = (np.nan, np.nan) if skirted else true_size(d)
        rows.append((frame / peak, pad.shape, _KEYS.index(d.key), wear_of(d, pad.shape), size, under, pad.noise))
    made = Clean(
        np.concatenate([row[0].astype(np.float32).ravel() for row in rows]),
        np.array([row[1] for row in rows]),
        np.array([row[2] for row in rows]),
        np.array([row[3] for row in rows], np.float32),
        np.array([row[4] for row in rows], np.float32),
        np.array([row[5] for row in rows]),
        np.array([row[6] for row in rows], np.float32),
    )
    keep(made, label)
    return made


__all__ = ["CHUNK", "SKINS", "Clean", "clean_frames", "worn"]
