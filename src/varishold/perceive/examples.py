"""Examples of objects as they are given: their names, touches and sizes are checked, and each touch is learned."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold._name import plain_name, refuse_name_of_strangers
from varishold.errors import InputError, require
from varishold.perceive.evidence import SIZE_PREFIX, Evidence
from varishold.perceive.poses import Kinds, usual_of
from varishold.perceive.size_range import LEAST_SIZE_M, MOST_SIZE_M
from varishold.perceive.touch_learning import touch_model
from varishold.perceive.touch_model import TouchModel, with_own_examples

__all__ = ["check_examples", "learned_touch", "log_sizes", "named", "object_name", "with_examples"]

Floats = NDArray[np.float64]
T = TypeVar("T")


def object_name(name: object) -> str:
    """Return the name of an object as it is kept."""
    kept = plain_name(name)
    if kept is None:
        raise InputError(f"an object needs a name, a line of printable text, got {name!r}")
    refuse_name_of_strangers(kept, "object")
    return kept


def named(what: str, of: Mapping[str, T]) -> dict[str, T]:
    """Return what is told of objects by their names as they are kept."""
    require(isinstance(of, Mapping), f"{what} must be given by the objects' names, got {type(of).__name__}")
    by_name = {object_name(name): told for name, told in of.items()}
    if len(by_name) < len(of):
        twice = next(name for name in by_name if sum(object_name(given) == name for given in of) > 1)
        raise InputError(f"two objects are called {twice!r}: their names differ by a space at the ends only")
    return by_name


def check_examples(name: str, examples: Sequence[Sequence[Evidence]]) -> None:
    """Refuse examples that are no lists of evidence."""
    if not isinstance(examples, Sequence):
        raise InputError(f"examples of {name!r} must be a list of lists of Evidence, got {repr(examples)[:40]}")
    for k, example in enumerate(examples):
        alone = isinstance(example, Evidence)
        require(not alone, f"example {k} of {name!r} must be a list of the evidence of its touches; put it in a list")
        if not isinstance(example, Sequence) or not all(isinstance(evidence, Evidence) for evidence in example):
            raise InputError(f"example {k} of {name!r} must be a list of Evidence, got {repr(example)[:40]}")


def log_sizes(name: str, size_m: float | Sequence[float] | None, n: int) -> Floats:
    """Return the logarithm of the size of each of n examples; NaN where it is unknown."""
    sizes = np.empty(0)
    with contextlib.suppress(TypeError, ValueError, OverflowError):
        given = np.asarray(np.nan if size_m is None else size_m, dtype=object)
        if not any(isinstance(size, str | bytes | bool | np.bool_) for size in given.flat):
            sizes = given.astype(np.float64)
    if not sizes.size:
        raise InputError(f"sizes of {name!r} must be numbers, metres; got {size_m!r}")
    fits = sizes.shape in ((), (n,))
    require(fits, f"{name!r} has {counted(n, 'example')}, but its sizes have shape {sizes.shape}; give one or {n}")
    bad = sizes[np.isinf(sizes) | (sizes <= 0)]
    if bad.size:
        raise InputError(f"a size of {name!r} must be positive and finite, got {bad.flat[0]:g} m")
    far = sizes[(sizes < LEAST_SIZE_M) | (sizes > MOST_SIZE_M)]
    if far.size:
        raise InputError(
            f"a size of {name!r} must lie in [{LEAST_SIZE_M:g}, {MOST_SIZE_M:g}] m, got {far.flat[0]:g}; "
            "is it in millimetres?"
        )
    return np.log(np.broadcast_to(sizes, (n,)))


def learned_touch(
    touch: str,
    examples: Sequence[Sequence[Evidence]],
    kinds: Kinds,
    log_size: Floats,
    *,
    others: Sequence[Sequence[Evidence]],
    cost: float,
) -> TouchModel:
    """Return what examples teach of one touch."""
    made = [_made(touch, example) for example in examples]
    names = tuple(dict.fromkeys(name for evidence in made for name in evidence.values))
    table = np.array([evidence.vector(names) for evidence in made])
    tells_shape = [not name.startswith(SIZE_PREFIX) for name in names]
    require(
        np.isfinite(table[:, tells_shape]).any(),
        f"touch {touch!r} needs examples with a number that tells shape; "
        f"names that begin with {SIZE_PREFIX!r} tell size alone",
    )
    beside = [evidence for row in others for evidence in row if evidence.touch == touch]
    strange = [evidence.vector(names) for evidence in beside]
    # What failed, or of which nothing is known, would count as a thing that feels usual in every way.
    strange = [row for row in strange if np.isfinite(row).any()]
    taken = [evidence.seconds for evidence in (*made, *beside) if evidence.seconds is not None]
    return touch_model(
        names,
        table,
        kinds.of_example,
        log_size,
        others=np.array(strange).reshape(-1, len(names)),
        failed=np.array([evidence.failed for evidence in made]),
        cost=cost,
        seconds=float(np.mean(taken)) if taken else None,
        usual=usual_of(kinds),
        object_of_kind=kinds.object,
    )


def with_examples(
    model: TouchModel,
    touch: str,
    examples: Sequence[Sequence[Evidence]],
    *,
    kind: NDArray[np.int64],
    log_size: Floats,
) -> TouchModel:
    """Return a model of one touch that knows examples of one object more; `kind` is of all examples."""
    made = [_made(touch, example) for example in examples]
    values = np.array([evidence.vector(model.metric.names) for evidence in made])
    size_values = np.array([evidence.vector(() if model.size is None else model.size.names) for evidence in made])
    wider = replace(
        model,
        values=np.concatenate([model.values, values]),
        failed=np.append(model.failed, [evidence.failed for evidence in made]),
        size_values=np.concatenate([model.size_values, size_values]),
        size=None if model.size is None else model.size.with_object(size_values, log_size),
    )
    return with_own_examples(wider, kind, np.arange(len(kind) - len(made), len(kind)))


def _made(touch: str, example: Sequence[Evidence]) -> Evidence:
    """Return the first evidence of a touch that succeeded, or one that says nothing but whether it failed."""
    made = [evidence for evidence in example if evidence.touch == touch]
    return next((e for e in made if not e.failed), Evidence(touch, {}, failed=bool(made)))
