"""A small convolutional network in numpy, learned here and now: what many would try first on tactile images.

Three layers of 3 x 3 filters (16, 32, 64), each followed by a rectifier and the largest of every two by two values,
then one layer of 96 units and the names; some 50,000 weights for 16 x 16. It learns by Adam, in batches of 128, with a
cosine schedule and weight decay, from frames that are turned and mirrored at random.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

__all__ = ["ConvolutionalNetwork"]

Floats = NDArray[np.float32]

FILTERS = (16, 32, 64)
UNITS = 96
BATCH = 128
# Adam's usual means of gradients and of their squares.
FIRST, SECOND, LEAST = 0.9, 0.999, 1e-8


@dataclass
class _Layer:
    """Filters on every 3 x 3 patch, a rectifier, the largest of each 2 x 2."""

    weights: Floats
    bias: Floats

    def forward(self, x: Floats) -> Floats:
        """Return (n, side / 2, side / 2, filters) of (n, side, side, channels)."""
        n, side, _, channels = x.shape
        padded = np.pad(x, ((0, 0), (1, 1), (1, 1), (0, 0)))
        windows = sliding_window_view(padded, (3, 3), axis=(1, 2)).transpose(0, 1, 2, 4, 5, 3)
        self._patches = windows.reshape(n * side * side, 9 * channels)
        z = np.maximum(self._patches @ self.weights + self.bias, 0).reshape(n, side // 2, 2, side // 2, 2, -1)
        top = z.max(axis=(2, 4))
        self._chosen = (z == top[:, :, None, :, None]) & (z > 0)
        self._shape = x.shape
        return top

    def backward(self, back: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the gradients of what came in, of the weights and of the bias."""
        n, side, _, channels = self._shape
        z = (self._chosen * back[:, :, None, :, None]).reshape(n * side * side, -1).astype(np.float32)
        of_patches = (z @ self.weights.T).reshape(n, side, side, 3, 3, channels)
        of_padded = np.zeros((n, side + 2, side + 2, channels), np.float32)
        for i in range(3):
            for j in range(3):
                of_padded[:, i : i + side, j : j + side] += of_patches[:, :, :, i, j]
        return of_padded[:, 1:-1, 1:-1], self._patches.T @ z, z.sum(axis=0)


class ConvolutionalNetwork:
    """Learns names of square images, as scikit-learn's classifiers do.

    Parameters
    ----------
    epochs : int
    rate : float
        Of learning, at first.
    decay : float
        Share of the weights that a step at that rate takes away.
    random_state : int
    """

    def __init__(self, epochs: int = 30, rate: float = 2e-3, decay: float = 0.05, random_state: int = 0) -> None:
        self.epochs, self.rate, self.decay, self.random_state = epochs, rate, decay, random_state

    def fit(self, X: NDArray[np.floating], y: NDArray[np.str_]) -> Self:
        """Learn from images of shape (n, side * side) with a side of 16 or 32, and their names."""
        rng = np.random.default_rng(self.random_state)
        self.classes_, target = np.unique(y, return_inverse=True)
        images = self._images(X)
        side = images.shape[1] // 2 ** len(FILTERS)
        sizes = (1, *FILTERS)
        self._layers = [_Layer(_drawn(rng, 9 * a, b), np.zeros(b, np.float32)) for a, b in pairwise(sizes)]
        self._dense = [
            (_drawn(rng, a, b), np.zeros(b, np.float32))
            for a, b in ((side * side * FILTERS[-1], UNITS), (UNITS, len(self.classes_)))
        ]
        parameters = [p for layer in self._layers for p in (layer.weights, layer.bias)]
        parameters += [p for pair in self._dense for p in pair]
        moments = [(np.zeros_like(p), np.zeros_like(p)) for p in parameters]
        steps, step = self.epochs * (len(images) // BATCH), 0
        for _ in range(self.epochs):
            order = rng.permutation(len(images))
            for start in range(0, len(order) - BATCH + 1, BATCH):
                step += 1
                chosen = order[start : start + BATCH]
                gradients = self._gradients(_turned(rng, images[chosen]), target[chosen])
                rate = self.rate * 0.5 * (1 + np.cos(np.pi * step / steps))
                for p, g, (first, second) in zip(parameters, gradients, moments, strict=True):
                    first += (1 - FIRST) * (g - first)
                    second += (1 - SECOND) * (g * g - second)
                    move = first / (1 - FIRST**step) / (np.sqrt(second / (1 - SECOND**step)) + LEAST)
                    p -= (rate * (move + (self.decay * p if p.ndim > 1 else 0))).astype(np.float32)
        return self

    def predict_proba(self, X: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return the probability of every name, shape (n, n_names)."""
        images = self._images(X)
        parts = [self._forward(images[k : k + BATCH])[-1] for k in range(0, len(images), BATCH)]
        return _softmax(np.concatenate(parts).astype(np.float64))

    def _images(self, X: NDArray[np.floating]) -> Floats:
        side = round(np.sqrt(X.shape[1]))
        return X.reshape(-1, side, side, 1).astype(np.float32)

    def _forward(self, x: Floats) -> list[Floats]:
        for layer in self._layers:
            x = layer.forward(x)
        seen = [x.reshape(len(x), -1)]
        for k, (weights, bias) in enumerate(self._dense):
            z = seen[-1] @ weights + bias
            seen.append(np.maximum(z, 0) if k + 1 < len(self._dense) else z)
        return seen

    def _gradients(self, x: Floats, target: NDArray[np.intp]) -> list[Floats]:
        seen = self._forward(x)
        back = _softmax(seen[-1]).astype(np.float32)
        back[np.arange(len(x)), target] -= 1
        back /= len(x)
        gradients: list[Floats] = []
        for k in reversed(range(len(self._dense))):
            gradients = [seen[k].T @ back, back.sum(axis=0), *gradients]
            back = back @ self._dense[k][0].T
            if k:
                back *= seen[k] > 0
        side = x.shape[1] // 2 ** len(FILTERS)
        back = back.reshape(len(x), side, side, FILTERS[-1])
        for layer in reversed(self._layers):
            back, of_weights, of_bias = layer.backward(back)
            gradients = [of_weights, of_bias, *gradients]
        return gradients


def _drawn(rng: np.random.Generator, inputs: int, outputs: int) -> Floats:
    return rng.normal(0, np.sqrt(2 / inputs), (inputs, outputs)).astype(np.float32)


def _turned(rng: np.random.Generator, images: Floats) -> Floats:
    """Return images of which half are mirrored in rows, half in columns and half transposed."""
    made = images.copy()
    for axis in (1, 2):
        mirrored = rng.random(len(made)) < 0.5
        made[mirrored] = np.flip(made[mirrored], axis)
    across = rng.random(len(made)) < 0.5
    made[across] = made[across].transpose(0, 2, 1, 3)
    return made


def _softmax(z: NDArray[np.floating]) -> NDArray[np.floating]:
    e = np.exp(z - z.max(axis=1, keepdims=True))
    return e / e.sum(axis=1, keepdims=True)
