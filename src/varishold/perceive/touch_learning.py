"""How one touch is learned: its sizes, the kernel that examples are compared by, and the metric."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from varishold.perceive.evidence import SIZE_PREFIX
from varishold.perceive.left_out import metrics_without
from varishold.perceive.likelihood import log_mean, mean_by_kind, members_of_kinds, squares_from
from varishold.perceive.metric import Metric, fit_metric, shrinkage
from varishold.perceive.neighbourhood import folds_of, learn_map
from varishold.perceive.size_model import fit_size_model
from varishold.perceive.touch_model import TouchModel, conformities, squares_among, with_scores

__all__ = ["touch_model"]

Floats = NDArray[np.float64]

# Kernels that are tried: width in parts of the usual distance within an object, and how fast likelihood falls.
_WIDTHS = (0.7, 1.0, 1.4)
_FALLS = (5.0, 10.0, 20.0, 40.0, 80.0)

# Where every kind has so many examples the metric is learned: these kernels are then tried on examples that it was not
# learned from, in so many folds.
_LEARNED_WIDTHS = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0)
_LEARNED_FALLS = (5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0)
_FOLDS, _LEAST_OF_A_KIND = 4, 40
# It is learned from so many examples, and so many of other things, at most: what it takes grows with their square.
_MOST_LEARNED, _MOST_OTHERS = 4000, 2000
# A map that makes some direction count so many times less than another is no metric any more.
_MOST_UNEVEN = 1e4

# Examples by which the kernel is chosen at most.
_MOST_CHOOSERS = 600


def touch_model(
    names: tuple[str, ...],
    table: Floats,
    owner: NDArray[np.int64],
    log_size: Floats,
    *,
    others: Floats,
    failed: NDArray[np.bool_],
    cost: float,
    seconds: float | None = None,
    usual: NDArray[np.bool_] | None = None,
    object_of_kind: NDArray[np.int64] | None = None,
) -> TouchModel:
    """Learn metric, kernel and sizes of one touch from a table (n, d) of its numbers, NaN where it was not made.

    `owner` is the kind of each row, and several kinds may be one object. Where there are too few examples to learn the
    metric it is that of `usual` rows alone, if there are some: what lies any way scatters more, and would make what
    stands look alike.
    """
    is_size = np.array([name.startswith(SIZE_PREFIX) for name in names])
    shape_names = tuple(name for name, size in zip(names, is_size, strict=True) if not size)
    values, size_values = table[:, ~is_size], table[:, is_size]
    made: NDArray[np.bool_] = np.asarray(np.isfinite(values).any(axis=1), dtype=np.bool_)
    if usual is not None and (made & usual).any() and not _do_for_a_metric(owner[made], owner):
        made = made & usual
    metric = fit_metric(shape_names, values[made], owner[made], log_size[made])
    size_names = tuple(name for name, size in zip(names, is_size, strict=True) if size)
    size = None
    if size_names and np.isfinite(log_size).any():
        size = fit_size_model(size_names, size_values, log_size, owner)
    untold = np.array([])
    model = TouchModel(
        metric=metric,
        values=values,
        size=size,
        size_values=size_values,
        width=1.0,
        fall=40.0,
        others=others[:, ~is_size],
        scores=untold,
        failed=failed,
        power=untold,
        cost=cost,
        seconds=seconds,
    )
    judged = list(metrics_without(metric, values, owner, log_size, learned_from=made))
    of = np.arange(int(owner.max()) + 1) if object_of_kind is None else object_of_kind
    plain = _choose_kernel(model, owner, judged)
    learned = _with_learned_metric(plain, owner, of, log_size)
    return with_scores(learned, owner, judged if learned is plain else None)


def _choose_kernel(
    model: TouchModel, owner: NDArray[np.int64], judged: Sequence[tuple[NDArray[np.int64], Metric]]
) -> TouchModel:
    """Choose the kernel by the probability that examples give to their own object when they are left out.

    `judged`: examples, and the metric without them.
    """
    chosen = np.zeros(len(owner), dtype=np.bool_)
    chosen[np.random.default_rng(0).permutation(np.flatnonzero(model.made))[:_MOST_CHOOSERS]] = True
    lots = [(rows[chosen[rows]], metric) for rows, metric in judged]
    squares = [(rows, squares_among(replace(model, metric=metric), rows)) for rows, metric in lots if len(rows)]
    return _best_kernel(model, owner, squares, product(_WIDTHS, _FALLS))[0]


def _best_kernel(
    model: TouchModel,
    owner: NDArray[np.int64],
    judged: Sequence[tuple[NDArray[np.int64], Floats]],
    kernels: Iterable[tuple[float, float]],
) -> tuple[TouchModel, float]:
    """Return the model with the kernel under which examples are least surprised at their own object, and how much.

    `judged`: examples, and their squared distances from all.
    """
    d, rows = len(model.metric.names), np.concatenate([part for part, _ in judged])
    members = members_of_kinds(owner)
    least, best = np.inf, model
    for width, fall in kernels:
        tried = replace(model, width=width, fall=fall)
        p = np.exp(np.concatenate([mean_by_kind(tried.kernel(squares, d), members) for _, squares in judged]))
        right = p[np.arange(len(rows)), owner[rows]] / p.sum(axis=1)
        loss = float(-np.log(np.maximum(right, 1e-12)).mean())
        if loss < least:
            least, best = loss, tried
    return best, least


def _do_for_a_metric(kinds: NDArray[np.int64], owner: NDArray[np.int64]) -> bool:
    """Whether there are so many examples of each of the owner's kinds that a metric can be learned from them."""
    return bool(np.bincount(kinds, minlength=int(owner.max()) + 1).min() >= _LEAST_OF_A_KIND)


def _with_learned_metric(
    model: TouchModel, owner: NDArray[np.int64], object_of_kind: NDArray[np.int64], log_size: Floats
) -> TouchModel:
    """Learn the metric by which examples lie nearest to their own object, other things being one object more.

    An object that was felt in several poses need not feel alike in them, and they need not be told from each other. The
    metric is taken where examples that it was not learned from are named better by it. How much less they conform than
    those that it was learned from is kept as the model's optimism.
    """
    made, strange = _some(np.flatnonzero(model.made), _MOST_LEARNED), _some(np.arange(len(model.others)), _MOST_OTHERS)
    if not _do_for_a_metric(owner[made], owner):
        return model
    n, kernel = len(made), (model.width, model.fall)
    objects = object_of_kind[owner]
    kind = np.concatenate([objects[made], np.full(len(strange), objects.max() + 1)])
    fold = folds_of(np.concatenate([owner[made], np.full(len(strange), owner.max() + 1)]), _FOLDS)
    held_out, judged, plain = [], [], []
    # As much is added to the scatter of fewer examples as to that of all, or everything would lie nearer by it.
    added = shrinkage(len(model.metric.names), owner[made], log_size[made])
    for k in range(_FOLDS):
        own, rest = np.flatnonzero(fold[:n] == k), made[fold[:n] != k]
        metric = fit_metric(model.metric.names, model.values[rest], owner[rest], log_size[rest], shrink=added)
        white = _whitened(replace(model, metric=metric), made, strange)
        there = white @ learn_map(white[fold != k], kind[fold != k], *kernel).astype(np.float32)
        held_out.append((own, squares_from(there, own)))
        some = np.random.default_rng(k).permutation(len(own))[: _MOST_CHOOSERS // _FOLDS]
        judged.append((own[some], held_out[-1][1][some, :n]))
        plain.append((own[some], squares_from(white, own[some])[:, :n]))
    best, surprise = _best_kernel(model, objects[made], judged, product(_LEARNED_WIDTHS, _LEARNED_FALLS))
    if surprise >= _best_kernel(model, objects[made], plain, [kernel])[1]:
        return model
    map_ = learn_map(_whitened(model, made, strange), kind, *kernel)
    if not np.linalg.cond(map_) < _MOST_UNEVEN:
        return model
    learned = replace(best, metric=model.metric.mapped(map_))
    d, held, members = len(model.metric.names), np.full(len(owner), np.nan), members_of_kinds(owner[made])
    for own, squares in held_out:
        log_kernel = learned.kernel(squares, d)
        said = mean_by_kind(log_kernel[:, :n], members)[np.arange(len(own)), owner[made[own]]]
        held[made[own]] = said - log_mean(log_kernel[:, n:]) if len(strange) else said
    return replace(learned, optimism=np.nan_to_num(conformities(learned, owner, np.arange(len(owner))) - held))


def _whitened(model: TouchModel, rows: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.float32]:
    return np.concatenate([model.white[rows], model.white_others[others]])


def _some(rows: NDArray[np.int64], most: int) -> NDArray[np.int64]:
    """Return at most so many of some rows, drawn by chance and in their order."""
    return rows if len(rows) <= most else np.sort(np.random.default_rng(0).permutation(rows)[:most])
