"""Grasps outside of what was learned: how many answers are given with p > .9, had nothing been outside, and as it is.

Switches: generated grasps of three shapes, and 8 x 8 digits of five kinds cut at half scale. Numbers: the same digits
as they are, at four thresholds a number. Strangers are the three shapes and the five digits that were not learned;
sensors are changed when they are asked, never when they learn. Thirty (digits: twenty) grasps of each are learned.

Run: python -m benchmarks.grasp_outside [--seeds N]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.datasets import load_digits

from benchmarks._figures import share
from benchmarks.planar_grasps import SHAPES, planar_grasps
from varishold.grasp import GraspModel, fit_model
from varishold.recording import GraspTable

Floats = NDArray[np.float64]

_SHAPES_KNOWN, _DIGITS_KNOWN = 3, 5
_GRASPS, _DIGITS, _ASKED = 30, 20, 150
_SURE = 0.9


@dataclass(frozen=True)
class _Scene:
    """What is learned, what is asked of it, and who is asked besides."""

    known: tuple[Floats, NDArray[Any]]
    asked: tuple[Floats, NDArray[Any]]
    strangers: Floats
    changes: Mapping[str, Callable[[Floats], Floats]]
    encode: str | None = None


def _shapes(rng: np.random.Generator) -> _Scene:
    names = [SHAPES[k] for k in rng.permutation(len(SHAPES))]
    known, others = tuple(names[:_SHAPES_KNOWN]), tuple(names[_SHAPES_KNOWN:])
    stuck = rng.choice(22, 5, replace=False)

    def on(x: Floats) -> Floats:
        return np.where(np.isin(np.arange(22), stuck), 1.0, x)

    def missing(x: Floats) -> Floats:
        return np.where(np.isin(np.arange(22), stuck), np.nan, x)

    def wrong(x: Floats) -> Floats:
        return np.abs(x - (rng.random(x.shape) < 0.2))

    def drawn(names: tuple[str, ...], n: int) -> tuple[Floats, NDArray[Any]]:
        patterns, kind = planar_grasps(names, n, rng)
        return patterns.astype(np.float64), kind

    changes = {
        "five switches stuck": on,
        "the five unknown": missing,
        "every fifth reading wrong": wrong,
        "patterns by chance": lambda x: (rng.random(x.shape) < 0.5).astype(np.float64),
    }
    return _Scene(drawn(known, _GRASPS), drawn(known, _ASKED), drawn(others, _ASKED)[0], changes)


def _digits(rng: np.random.Generator, encode: str | None) -> _Scene:
    images, kind = load_digits(return_X_y=True)
    known = rng.permutation(10)[:_DIGITS_KNOWN]
    learned = np.concatenate([rng.choice(np.flatnonzero(kind == k), _DIGITS, replace=False) for k in known])
    asked = np.setdiff1d(np.flatnonzero(np.isin(kind, known)), learned)
    strange = np.flatnonzero(~np.isin(kind, known))
    dead = rng.choice(64, 12, replace=False)

    def moved(x: Floats) -> Floats:
        return np.asarray(np.roll(x.reshape(-1, 8, 8), 1, axis=2).reshape(-1, 64))

    if encode is None:
        images = (images >= 8).astype(float)
        changes = {"one taxel elsewhere": moved, "three of ten dead": lambda x: x * (rng.random(x.shape) < 0.7)}
    else:
        changes = {
            "one taxel elsewhere": moved,
            "gain 1.6": lambda x: 1.6 * x,
            "a rest of 4": lambda x: x + 4.0,
            "twelve taxels unknown": lambda x: np.where(np.isin(np.arange(64), dead), np.nan, x),
        }
    return _Scene((images[learned], kind[learned]), (images[asked], kind[asked]), images[strange], changes, encode)


SCENES: Mapping[str, Callable[[np.random.Generator], _Scene]] = {
    "shapes, 22 switches": _shapes,
    "digits, 64 switches": lambda rng: _digits(rng, None),
    "digits, 64 numbers": lambda rng: _digits(rng, "quantile"),
}


def _table(values: Floats, kind: NDArray[Any] | None = None) -> GraspTable:
    cells: dict[str, Any] = {} if kind is None else {"kind": np.array([str(k) for k in kind])}
    return GraspTable(cells | {f"switch.{k:02d}": column for k, column in enumerate(values.T)})


def _had_nothing_been_outside(model: GraspModel) -> GraspModel:
    """Return the model as it would be if known grasps were so strange that nothing is stranger."""
    blind = copy(model.classifier)
    held = blind._likelihood.held
    assert held is not None
    blind._likelihood = replace(blind._likelihood, held=replace(held, beyond=held.beyond + 1e100))
    return replace(model, classifier=blind)


def measure(scene: _Scene) -> dict[str, tuple[float, ...]]:
    """Return for each way of asking: shares with p > .9 before and after, of these right, and rejected."""
    model = fit_model(_table(*scene.known), label="kind", mode="vote", encode=scene.encode)
    blind = _had_nothing_been_outside(model)
    values, kind = scene.asked
    asked = {"as learned": values, "strangers": scene.strangers}
    asked |= {name: change(values) for name, change in scene.changes.items()}
    found = {}
    for name, given in asked.items():
        truth = np.array([str(k) for k in kind]) if len(given) == len(values) and name != "strangers" else None
        row: list[float] = []
        for one in (blind, model):
            answers = list(one.answer(_table(given)))
            sure = np.array([answer.probability > _SURE for answer in answers])
            right = (
                np.array([answer.object for answer in answers]) == truth if truth is not None else np.zeros(len(sure))
            )
            row += [float(sure.mean()), float(right[sure].mean()) if sure.any() else np.nan]
        rejected = float(np.mean([answer.rejected for answer in answers]))
        assert not any(answer.rejected and answer.probability > _SURE for answer in answers)
        found[name] = (*row, rejected, float(np.mean(right)))
    return found


def _means(rows: Sequence[tuple[float, ...]]) -> Floats:
    """Return the mean of each number over the rows that know it; NaN where none does."""
    known = np.isfinite(rows)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(known, rows, 0.0).sum(axis=0) / known.sum(axis=0))


def main(argv: Sequence[str] = ()) -> None:
    """Print shares of answers with p > .9, right ones among them, and rejected ones."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10, help="how many")
    seeds = parser.parse_args(list(argv)).seeds
    began = time.process_time()
    for title, draw in SCENES.items():
        rows: dict[str, list[tuple[float, ...]]] = {}
        for seed in range(seeds):
            for name, row in measure(draw(np.random.default_rng([1971, seed]))).items():
                rows.setdefault(name, []).append(row)
        print(f"{title}, {seeds} draws: share with p > .9 (right of these), had nothing been outside -> as it is")
        for name, many in rows.items():
            before, right_before, after, right_after, rejected, right = _means(many)
            of = f"{title}, {name}"
            line = f"  {name:27s}{share(f'{of}: p > .9 before', before):>7s} -> {share(f'{of}: p > .9', after):>7s}"
            if name != "strangers" and "chance" not in name:
                line += f"  ({share(f'{of}: right of these before', right_before)} -> "
                line += f"{share(f'{of}: right of these', right_after)})  right {share(f'{of}: right', right)}"
            print(f"{line}; rejected {share(f'{of}: rejected', rejected)}")
    print(f"CPU seconds: {time.process_time() - began:.0f}")


if __name__ == "__main__":
    main(sys.argv[1:])
