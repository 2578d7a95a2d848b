"""A small network from signatures to kinds, trained with Adam on whitened inputs: numpy only."""

from __future__ import annotations

import itertools
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

#: Whitened inputs are cut here: what lies further out says no more.
CLIP = 5.0


@dataclass
class Network:
    """Weights and biases, first layer first, behind a shift and a scale of the inputs."""

    shift: Array
    scale: Array
    weights: list[Array]
    biases: list[Array]

    def hidden(self, x: NDArray[np.floating]) -> Array:
        """Return the last hidden layer (n, h) of signatures (n, inputs)."""
        h = np.clip((np.asarray(x, dtype=np.float32) - self.shift) * self.scale, -CLIP, CLIP)
        for w, b in zip(self.weights[:-1], self.biases[:-1], strict=True):
            h = np.maximum(h @ w + b, 0)
        return h

    def logits(self, x: NDArray[np.floating]) -> Array:
        """Return the logits (n, kinds) of signatures (n, inputs)."""
        return self.hidden(x) @ self.weights[-1] + self.biases[-1]


def log_softmax(z: NDArray[np.floating]) -> NDArray[np.floating]:
    z = z - z.max(axis=1, keepdims=True)
    return z - np.log(np.exp(z).sum(axis=1, keepdims=True))


def train(
    x: NDArray[np.floating],
    y: NDArray[np.integer],
    *,
    hidden: tuple[int, ...] = (96, 48),
    kinds: int,
    epochs: int = 40,
    batch: int = 512,
    rate: float = 2e-3,
    decay: float = 1e-2,
    seed: int = 0,
    smoothing: float = 0.0,
    sample_weight: NDArray[np.floating] | None = None,
    report: bool = True,
) -> Network:
    """Return a network trained by Adam with decoupled weight decay and a cosine schedule.

    `smoothing` is the share of certainty that the true kind gives up to all kinds.
    """
    rng = np.random.default_rng(seed)
    x = np.asarray(x, dtype=np.float32)
    shift = x.mean(axis=0)
    scale = 1.0 / np.maximum(x.std(axis=0), 1e-3)
    x = np.clip((x - shift) * scale, -CLIP, CLIP)
    sizes = (x.shape[1], *hidden, kinds)
    weights = [rng.normal(0, np.sqrt(2 / a), (a, b)).astype(np.float32) for a, b in itertools.pairwise(sizes)]
    biases = [np.zeros(b, dtype=np.float32) for b in sizes[1:]]
    parameters = [*weights, *biases]
    first = [np.zeros_like(p) for p in parameters]
    second = [np.zeros_like(p) for p in parameters]
    steps = epochs * (len(x) // batch)
    step = 0
    begun = time.monotonic()
    for epoch in range(epochs):
        order = rng.permutation(len(x))
        loss = 0.0
        for start in range(0, len(x) - batch + 1, batch):
            pick = order[start : start + batch]
            layers = [x[pick]]
            for w, b in zip(weights[:-1], biases[:-1], strict=True):
                layers.append(np.maximum(layers[-1] @ w + b, 0))
            logs = log_softmax(layers[-1] @ weights[-1] + biases[-1]).astype(np.float32)
            loss -= float(logs[np.arange(batch), y[pick]].mean())
            back = np.exp(logs)
            back[np.arange(batch), y[pick]] -= 1 - smoothing
            back -= smoothing / kinds
            back /= batch
            if sample_weight is not None:
                back *= sample_weight[pick, None]
            gradients: list[Array] = [np.empty(0, np.float32)] * len(parameters)
            for i in range(len(weights) - 1, -1, -1):
                gradients[i] = layers[i].T @ back
                gradients[len(weights) + i] = back.sum(axis=0)
                if i:
                    back = (back @ weights[i].T) * (layers[i] > 0)
            step += 1
            now = rate * 0.5 * (1 + np.cos(np.pi * step / steps))
            for i, (p, g) in enumerate(zip(parameters, gradients, strict=True)):
                first[i] += 0.1 * (g - first[i])
                second[i] += 0.001 * (g * g - second[i])
                move = (first[i] / (1 - 0.9**step)) / (np.sqrt(second[i] / (1 - 0.999**step)) + 1e-8)
                if i < len(weights):
                    move = move + decay * p
                p -= (now * move).astype(np.float32)
        if report and (epoch % 5 == 4 or epoch == epochs - 1):
            print(
                f"epoch {epoch + 1}: loss {loss / (len(x) // batch):.4f}, {time.monotonic() - begun:.0f} s",
                flush=True,
            )
    return Network(shift.astype(np.float32), scale.astype(np.float32), weights, biases)


def temperature(
    logits: NDArray[np.floating], y: NDArray[np.integer], weight: NDArray[np.floating] | None = None
) -> float:
    """Return the factor on the logits that makes held-out frames most probable (Guo et al. 2017)."""
    factors = np.linspace(0.4, 1.6, 121)
    losses = [-np.average(log_softmax(logits * t)[np.arange(len(y)), y], weights=weight) for t in factors]
    return float(factors[int(np.argmin(losses))])
