"""The library of a hand: the ten objects, and shapes made by chance that are none of them, felt many times each."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from varishold.errors import InputError, require
from varishold.exploration.kept import Example, keeper, kept_examples
from varishold.exploration.object_examples import feel_once, seeds_of
from varishold.exploration.touches import Grip, touches_of
from varishold.files import spread
from varishold.files.crew import processors
from varishold.hand import OBJECTS, HandSetting
from varishold.perceive import Library

__all__ = ["EXAMPLE_TRUST", "GRIP_TRUST", "feel_library", "library_kept_beside"]

#: Likelihoods of grips are raised to this power: chosen for the built-in hand on design examples with other friction
#: and noise, so that boxes and pillars that cannot be told apart are not told apart for sure.
GRIP_TRUST = 0.65
#: How far the likelihood of a single example counts beside that of its kind; chosen on the same.
EXAMPLE_TRUST = 0.6

# Sizes are drawn down to this multiple of the least that a hand grips.
_LEAST = 8 / 7

# A thing that was never gripped is set up anew so often at most.
_MOST_TRIES = 4

_FORMAT = 2


@dataclass(frozen=True)
class _Job:
    name: str
    size_m: float
    seed: int


@dataclass(frozen=True)
class _Work:
    """What a process does with a job."""

    setting: HandSetting

    def __call__(self, job: _Job) -> Example:
        made: Example = []
        # What was missed is stood up elsewhere, as the exploring hand has it done.
        for tried in range(_MOST_TRIES):
            seed = job.seed if not tried else int(np.random.SeedSequence([job.seed, tried]).generate_state(1)[0])
            made = feel_once(job.name, job.size_m, seed=seed, setting=self.setting)
            if made:
                break
        return made


def feel_library(
    setting: HandSetting,
    *,
    examples: int,
    lumps: int | None = None,
    seed: int = 0,
    processes: int | None = None,
    keep: str | os.PathLike[str] | None = None,
    progress: Callable[[], None] | None = None,
) -> Library:
    """Let a hand feel the ten objects and lumps, each in a size, at a place and under physics drawn by chance.

    The same hand, numbers and seed give the same library, whatever the number of processes and however often it was
    stopped.

    Parameters
    ----------
    setting : HandSetting
        As of `example_setting`.
    examples : int
        How many times each object is set up.
    lumps : int, optional
        How many lumps are felt, once each: they say what other things feel like. Default: as many as `examples`.
    seed : int
        Of all that is drawn.
    processes : int, optional
        Default: one a processor. 1 works in this process.
    keep : path-like, optional
        A file in which what was felt is kept; see `library_kept_beside`.
    progress : callable, optional
        Called after each example, those that were kept included.

    Raises
    ------
    InputError
        If a number is out of its range, or the hand never got hold of one of the objects.
    MissingExtraError
        If MuJoCo is not installed.
    """
    require(examples >= 2, f"examples must be at least 2, got {examples!r}")
    require(seed >= 0, f"seed must be a whole number from 0 on, got {seed!r}")
    count = processors() if processes is None else processes
    require(count >= 1, f"processes must be at least 1, got {processes!r}")
    jobs = _jobs(setting.design.sizes_m, examples, examples if lumps is None else lumps, seed)
    felt = {} if keep is None else kept_examples(Path(keep))
    felt = {job.seed: felt[job.seed] for job in jobs if job.seed in felt}
    missing = [job for job in jobs if job.seed not in felt]
    for _ in felt:
        if progress is not None:
            progress()
    with keeper(keep, felt) as say:
        made = spread(_Work(setting), missing, processes=max(1, min(count, len(missing))))
        for job, example in zip(missing, made, strict=True):
            felt[job.seed] = example
            say(job.seed, example)
            if progress is not None:
                progress()
    held = [job for job in jobs if felt[job.seed]]
    never = [name for name in OBJECTS if not any(job.name == name for job in held)]
    if never:
        raise InputError(
            f"the hand never got hold of the {never[0]} in {examples} tries; give more examples, or see its strength, "
            "its switches and its sizes_m"
        )
    can = touches_of(setting.design)
    library = Library.from_examples(
        {name: [felt[job.seed] for job in held if job.name == name] for name in OBJECTS},
        sizes_m={name: [job.size_m for job in held if job.name == name] for name in OBJECTS},
        others=[felt[job.seed] for job in held if job.name not in OBJECTS],
        costs={touch.name: touch.cost for touch in can.values()},
        hand=setting.design.identity,
    )
    grips = [name for name, touch in can.items() if isinstance(touch, Grip) and name in library.touches]
    return library.tempered(GRIP_TRUST, grips, own=EXAMPLE_TRUST)


def library_kept_beside(path: str | os.PathLike[str], setting: HandSetting, *, seed: int) -> Path:
    """Return where what was felt for a library is kept: in a file named after all that it depends on."""
    digest = hashlib.sha256(repr((_FORMAT, seed, setting)).encode()).hexdigest()[:24]
    return Path(f"{os.fspath(path)}.felt", f"{digest}.jsonl")


def _jobs(sizes_m: tuple[float, float], examples: int, lumps: int, seed: int) -> list[_Job]:
    low, high = min(sizes_m[0] * _LEAST, sizes_m[1]), sizes_m[1]
    jobs = [_Job(name, 0.0, each) for name in OBJECTS for each in seeds_of(name, seed, examples)]
    jobs += [_Job(f"lump-{each % 10**9}", 0.0, each) for each in seeds_of("lump", seed, lumps)]
    drawn = (np.random.default_rng([job.seed, 11]).uniform(np.log(low), np.log(high)) for job in jobs)
    return [_Job(job.name, float(np.exp(log)), job.seed) for job, log in zip(jobs, drawn, strict=True)]
