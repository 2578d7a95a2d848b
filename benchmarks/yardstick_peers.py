"""Plain peers on the public yardstick, beside the shipped names: what anybody would try first.

Each peer is made twice by the yardstick's own drawing: from clean frames, and from frames of every counted row, both by
another seed than the frames that are scored. The second knows the very faults and forms that it is asked for; the
shipped tables were learned from another generator. Features of a frame, divided by its peak:

- raw: the readings.
- moments: load, principal second moments, central moments of third and fourth order scaled by them, and the areas above
  a quarter, half and three quarters of the peak; what lies below a tenth of the peak is left out.
- hu: Hu's moments of the same readings and of the section at half of the peak, as signed logarithms (OpenCV).
- hog: histograms of oriented gradients, nine directions, four by four cells, each two by two made of length 1.
- middle: the readings, shifted so that their centroid is the middle, smoothed over a taxel.

Learners are scikit-learn's: logistic regression of standardized features, a forest of 200 trees, and for "middle" a
network of two hidden layers (256, 64), without convolutions. Settings are scikit-learn's defaults but for these.
A small convolutional network (`_convolutional`) learns the raw readings.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial

import cv2
import numpy as np
from scipy import ndimage
from sklearn.ensemble import RandomForestClassifier
from sklearn.linear_model import LogisticRegression
from sklearn.neural_network import MLPClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from benchmarks._convolutional import ConvolutionalNetwork
from benchmarks._figures import figure, share
from varishold.evaluation.yardstick import FRAMES, ROWS, SEED, SHAPES, YardstickScore, score_functions, shipped_names
from varishold.evaluation.yardstick.media import clean_frames
from varishold.evaluation.yardstick.rows import distorted
from varishold.evaluation.yardstick.scoring import SCORED_MEDIA

#: Frames are learned from by this seed, and in further rows by it and hundreds.
TRAINING_SEED = 5
#: Frames of each form on each medium that are learned from: clean ones, and in each counted row.
CLEAN_FRAMES, ROW_FRAMES = 160, 12
_OURS = "shipped names"
_DIRECTIONS = 9


def raw(frames: np.ndarray) -> np.ndarray:
    """Return the readings in shares of the peak."""
    return _scaled(frames).reshape(len(frames), -1)


def moments(frames: np.ndarray) -> np.ndarray:
    """Return load, moments and areas."""
    side = frames.shape[1]
    scaled = _scaled(frames)
    p = np.where(scaled > 0.1, scaled, 0.0)
    load = p.sum(axis=(1, 2))
    at = np.arange(side)
    x = at[None, None, :] - (p.sum(axis=1) @ at / load)[:, None, None]
    y = at[None, :, None] - (p.sum(axis=2) @ at / load)[:, None, None]
    central = {(i, j): (p * x**i * y**j).sum(axis=(1, 2)) / load for i in range(5) for j in range(5) if 2 <= i + j <= 4}
    mean, half = (central[2, 0] + central[0, 2]) / 2, (central[2, 0] - central[0, 2]) / 2
    apart = np.hypot(half, central[1, 1])
    size = np.sqrt(np.maximum(mean, 1e-6))
    shape = [value / size ** (i + j) for (i, j), value in central.items() if i + j > 2]
    areas = [(p > level).mean(axis=(1, 2)) for level in (0.25, 0.5, 0.75)]
    return np.column_stack([load / side**2, (mean + apart) / side**2, (mean - apart) / side**2, *shape, *areas])


def hu(frames: np.ndarray) -> np.ndarray:
    """Return Hu's moments of the readings and of the section at half of the peak."""
    found = []
    for frame in _scaled(frames):
        both = (np.where(frame > 0.1, frame, 0.0), (frame > 0.5).astype(float))
        found.append(np.concatenate([cv2.HuMoments(cv2.moments(one)).ravel() for one in both]))
    values = np.array(found)
    return np.sign(values) * np.log10(np.abs(values) + 1e-12)


def hog(frames: np.ndarray) -> np.ndarray:
    """Return histograms of oriented gradients."""
    down, across = np.gradient(_scaled(frames), axis=(1, 2))
    direction = np.minimum((np.mod(np.arctan2(down, across), np.pi) / np.pi * _DIRECTIONS).astype(int), _DIRECTIONS - 1)
    strength = np.hypot(down, across)
    n, cell = len(frames), frames.shape[1] // 4
    by_direction = np.where(direction[..., None] == np.arange(_DIRECTIONS), strength[..., None], 0.0)
    cells = by_direction.reshape(n, 4, cell, 4, cell, _DIRECTIONS).sum(axis=(2, 4))
    blocks = [cells[:, i : i + 2, j : j + 2].reshape(n, -1) for i in range(3) for j in range(3)]
    return np.concatenate([one / np.sqrt((one**2).sum(axis=1, keepdims=True) + 1e-4) for one in blocks], axis=1)


def middle(frames: np.ndarray) -> np.ndarray:
    """Return the smoothed readings with their centroid in the middle."""
    smooth = ndimage.gaussian_filter(_scaled(frames), (0, 0.7, 0.7))
    centre = (frames.shape[1] - 1) / 2
    shifted = []
    for frame in smooth:
        at = ndimage.center_of_mass(np.where(frame > 0.1 * frame.max(), frame, 0.0))
        shifted.append(ndimage.shift(frame, np.subtract(centre, at), order=1, mode="nearest"))
    return np.array(shifted).reshape(len(frames), -1)


def _scaled(frames: np.ndarray) -> np.ndarray:
    return frames / frames.max(axis=(1, 2), keepdims=True)


Feature = Callable[[np.ndarray], np.ndarray]
_LOGISTIC = "logistic regression"
_FOREST = "forest"
_NETWORK = "small network"
_CONVOLUTIONAL = "convolutional network"
LEARNERS: dict[str, Callable[[], object]] = {
    _LOGISTIC: lambda: make_pipeline(StandardScaler(), LogisticRegression(max_iter=300)),
    _FOREST: lambda: RandomForestClassifier(200, random_state=0),
    _NETWORK: lambda: make_pipeline(
        StandardScaler(), MLPClassifier((256, 64), early_stopping=True, max_iter=100, random_state=0)
    ),
    _CONVOLUTIONAL: ConvolutionalNetwork,
}
PEERS: tuple[tuple[Feature, str], ...] = (
    *((feature, learner) for feature in (raw, moments, hu, hog) for learner in (_LOGISTIC, _FOREST)),
    (middle, _NETWORK),
    (raw, _CONVOLUTIONAL),
)


def training_frames(side: int, every_row: bool, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return frames to learn from and the own name of each."""
    rows = [row for row in ROWS if row.counted] if every_row else [row for row in ROWS if row.name == "clean"]
    per_kind = ROW_FRAMES if every_row else CLEAN_FRAMES
    frames, names = [], []
    for number, row in enumerate(rows):
        # Other objects in each row.
        of_row = seed + 100 * number
        for medium in SCORED_MEDIA:
            drawn = clean_frames(medium, side, row.change, per_kind, of_row)
            read, truths = distorted(row, *drawn, medium, of_row)
            frames.append(read)
            names += [true[0] for true in truths]
    return np.concatenate(frames), np.array(names)


def answers(feature: Feature, model, frames: np.ndarray) -> list[dict[str, float]]:
    """Return a peer's answers to frames."""
    told = model.predict_proba(feature(frames))
    return [dict(zip(model.classes_.tolist(), p.tolist(), strict=True)) for p in np.minimum(told, 1.0)]


def peers(
    side: int, every_row: bool, seed: int, only: str = ""
) -> dict[str, Callable[[np.ndarray], list[dict[str, float]]]]:
    """Return the peers whose name holds a word, learned, by name."""
    frames, names = training_frames(side, every_row, seed)
    from_what = "every row" if every_row else "clean"
    made = {}
    for feature, learner in PEERS:
        name = f"{feature.__name__}, {learner}, from {from_what}"
        if only not in name:
            continue
        model = LEARNERS[learner]()
        with warnings.catch_warnings():
            # That a search stopped early is no news here.
            warnings.simplefilter("ignore", UserWarning)
            model.fit(feature(frames), names)  # type: ignore[attr-defined]
        made[name] = partial(answers, feature, model)
    return made


def main(argv: Sequence[str] = ()) -> None:
    """Print the scores."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=FRAMES, help="of each form on each medium in a row")
    parser.add_argument("--seed", type=int, default=SEED, help="of the frames that are scored")
    parser.add_argument("--side", type=int, choices=[side for side, _ in SHAPES], action="append")
    parser.add_argument("--only", default="", metavar="WORD", help="peers whose name holds this")
    asked = parser.parse_args(list(argv))
    for side in asked.side or [side for side, _ in SHAPES]:
        functions = {_OURS: lambda frames: [shipped_names(frame) for frame in frames]}
        functions |= peers(side, False, TRAINING_SEED, asked.only) | peers(side, True, TRAINING_SEED, asked.only)
        found = score_functions(functions, shapes=[(side, side)], frames=asked.frames, seed=asked.seed, batch=True)
        n = found[0].shapes[0].rows[0].frames
        print(f"\n{side} x {side}, {n} frames a row, seed {asked.seed}; peers learn by seed {TRAINING_SEED}")
        print(f"  {'':44} {'right':>7} {'clean':>7} {'sure and wrong':>15} {'calibration error':>18}")
        for one in found:
            _print(side, one)


def _print(side: int, one: YardstickScore) -> None:
    of = f"{side} x {side}, {one.tested}"
    (score,) = one.shapes
    clean = next(row.right for row in score.rows if row.name == "clean")
    said = (
        share(f"{of}: right", score.right.value, "5.1f"),
        share(f"{of}: right, clean", clean, "5.1f"),
        f"{share(f'{of}: wrong with p > .9', score.sure_wrong, '.1f'):>15}",
        f"{figure(f'{of}: calibration error', score.calibration_error, '.3f'):>18}",
    )
    print(f"  {one.tested:44} {' '.join(said)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
