"""The belief: which object, of which size, in which of the known worlds, after every touch so far.

Every example of the library is a world: an object of some size and pose under some physics, with what each touch
of it felt like. A belief weighs the worlds; a world must explain all touches, so that size and pose are shared between
touches and summed out jointly. Multiplying touches as if each could be explained by another world would make
the belief surer than it may be.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.perceive.evidence import Evidence
from varishold.perceive.library import Library

__all__ = ["LOG_SIZES", "Belief"]

Floats = NDArray[np.float64]

#: The sizes that are told apart, 20 to 250 mm: 101 steps in logarithm. A size beyond its ends is told as the end.
LOG_SIZES: Floats = np.linspace(np.log(0.02), np.log(0.25), 101)

# A world stands for sizes that near its own, in logarithm.
_WORLD_SPREAD = 0.08

# Several grips at one object err alike in size: each counts the less for it, as if their errors went together so far.
_SIZES_ALIKE = 0.6

# What the least likely world keeps, so that a new touch can bring it back.
_FLOOR = -60.0

#: "None of these": a known object's touches are so odd in fewer than one look of a hundred, and in about one sequence
#: of fifty, which is looked at after each touch.
ODD_QUANTILE = 0.008


@dataclass(frozen=True, eq=False)
class Belief:
    """What is believed after some touches.

    Parameters
    ----------
    library : Library
    log_weight : ndarray of shape (n,)
        Of the library's examples: log-likelihood of all touches so far.
    size_table : ndarray of shape (n_objects, n_sizes)
        Log-likelihood of all touches' sizes.
    kept : ndarray of shape (n_objects, n_sizes)
        What the worlds of each size said before the object was moved last.
    fits : ndarray of shape (n_touches, n_objects)
        Log-likelihood of each touch under each object alone, less that under other things.
    touches : tuple of str
        What has been touched, in order.
    remarks : tuple of str
        What was odd.
    sized : int
        How many of the touches said something of size.
    known : tuple of ndarray, bool
        For each touch, which of its numbers were known.
    """

    library: Library
    log_weight: Floats
    size_table: Floats
    kept: Floats
    fits: Floats
    touches: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    sized: int = 0
    known: tuple[NDArray[np.bool_], ...] = ()

    @classmethod
    def before(cls, library: Library) -> Self:
        """Return the belief before any touch: every object alike."""
        n_objects = len(library.objects)
        return cls(
            library,
            np.zeros(len(library)),
            np.zeros((n_objects, len(LOG_SIZES))),
            np.zeros((n_objects, len(LOG_SIZES))),
            np.zeros((0, n_objects)),
        )

    def after(self, evidence: Evidence) -> Self:
        """Return the belief after one touch more.

        Raises
        ------
        InputError
            If the library does not know such a touch.
        """
        model = self.library.touches.get(evidence.touch)
        if model is None:
            raise InputError(
                f"the library knows no touch {evidence.touch!r}; it knows {', '.join(self.library.touches)}"
            )
        success = model.log_success(self.library.owner, failed=evidence.failed)
        if evidence.failed:
            return replace(
                self,
                log_weight=self.log_weight + success,
                fits=np.vstack([self.fits, np.full(len(self.library.objects), np.nan)]),
                known=(*self.known, np.zeros(len(model.metric.names), dtype=np.bool_)),
                touches=(*self.touches, evidence.touch),
                remarks=(*self.remarks, f"{evidence.touch}: tried, and nothing was held"),
            )
        values = evidence.vector(model.metric.names)
        known = np.isfinite(values)
        log_kernel = model.log_kernel(values)
        fits = _mean_by_object(log_kernel, self.library)
        # A world in which this touch was not made explains it as its object's others do on the whole.
        log_kernel = np.where(np.isnan(log_kernel), fits[self.library.owner], log_kernel) + success
        sizes, sized = self.size_table, self.sized
        if model.size is not None:
            told = model.size.log_likelihood(evidence.vector(model.size.names), LOG_SIZES)
            sizes, sized = sizes + told, sized + int(bool(told.any()))
        remarks = list(evidence.remarks)
        if not known.any():
            remarks.append(f"{evidence.touch}: nothing that the library knows was felt; the belief stays as it was")
        return replace(
            self,
            log_weight=self.log_weight + log_kernel,
            size_table=sizes,
            touches=(*self.touches, evidence.touch),
            fits=np.vstack([self.fits, fits - model.log_others(values) if known.any() else np.full_like(fits, np.nan)]),
            known=(*self.known, known),
            remarks=(*self.remarks, *remarks),
            sized=sized,
        )

    def in_new_place(self) -> Self:
        """Return the belief after the object was moved: object and size stay, its pose is unknown again."""
        prior = _size_prior(self.library)
        top = self.log_weight.max()
        told = self.library.members @ (np.exp(self.log_weight - top)[:, None] * prior)
        worlds = self.library.members @ prior
        # What the worlds of each size said on the whole stays as what is known of the size.
        said = np.log(np.maximum(told, 1e-300)) - np.log(np.maximum(worlds, 1e-300)) + top
        return replace(self, log_weight=np.zeros(len(self.library)), kept=self.kept + said)

    @cached_property
    def _worlds(self) -> tuple[Floats, Floats]:
        """Log-probability of each world, and each object's of each size (up to constants), both joint."""
        prior = _size_prior(self.library)
        table = self.size_table / (1 + _SIZES_ALIKE * max(self.sized - 1, 0)) + self.kept
        top = table.max(axis=1, keepdims=True)
        likelihood = np.exp(np.maximum(table - top, _FLOOR))
        owner = self.library.owner
        of_size = np.einsum("ns,ns->n", prior, likelihood[owner])
        log_world = self.log_weight + np.log(np.maximum(of_size, 1e-300)) + top[owner, 0]
        log_world = log_world - np.log(self.library.counts[owner])
        weight = np.exp(log_world - log_world.max())
        inner = np.exp(self.log_weight - self.log_weight.max())[:, None] * prior
        per_size = self.library.members @ inner
        return weight / weight.sum(), per_size * likelihood

    @property
    def worlds(self) -> Floats:
        """Probability of each example's world, shape (n,)."""
        return self._worlds[0]

    @cached_property
    def probability(self) -> dict[str, float]:
        """Probability of each object, were it one of the library's, largest first."""
        p = np.bincount(self.library.owner, weights=self.worlds, minlength=len(self.library.objects))
        order = np.argsort(-p, kind="stable")
        return {self.library.objects[k]: min(float(p[k]), 1.0) for k in order}

    @property
    def best(self) -> str:
        """The likeliest object of the library."""
        return next(iter(self.probability))

    def size(self, name: str | None = None) -> tuple[float, float, float] | None:
        """Return median and 95 % interval of the size, metres, of an object; default: the likeliest.

        Returns
        -------
        tuple of 3 floats, or None
            Median, lower and upper end; None where nothing tells its size.

        Raises
        ------
        InputError
            If the library has no such object.
        """
        if name is not None and name not in self.library.objects:
            raise InputError(f"the library has no {name!r}; it knows {', '.join(self.library.objects)}")
        k = self.library.objects.index(self.best if name is None else name)
        share = self._worlds[1][k]
        if not np.isfinite(self.library.log_size[self.library.owner == k]).any() or share.sum() <= 0:
            return None
        cumulative = np.cumsum(share) / share.sum()
        # Half a step back: a step's share lies about its middle.
        step = LOG_SIZES[1] - LOG_SIZES[0]
        low, middle, high = np.interp([0.025, 0.5, 0.975], cumulative, LOG_SIZES + step / 2)
        return float(np.exp(middle)), float(np.exp(low)), float(np.exp(high))

    @cached_property
    def oddness(self) -> float:
        """How rarely the likeliest object's own examples feel as odd as all touches together.

        For each touch: the share of the object's own examples that are as odd. The product of the shares, which
        Fisher combines so, is compared with the same product of each of those examples, so that it does not matter that
        touches in one world are odd together.
        """
        k = self.library.objects.index(self.best)
        told = [
            (self.library.touches[touch].surprises(k, self.library.owner, known), fit)
            for touch, fit, known in zip(self.touches, self.fits[:, k], self.known, strict=True)
            if np.isfinite(fit)
        ]
        told = [(own, fit) for own, fit in told if own.fits.size]
        if not told:
            return 1.0
        surprise = sum(own.of(fit) for own, fit in told)
        usual = np.sum([own.of_examples for own, _ in told], axis=0)
        usual = usual[np.isfinite(usual)]
        if not usual.size:
            return 1.0
        return float((1 + np.count_nonzero(usual >= surprise - 1e-9)) / (1 + usual.size))

    @property
    def odd(self) -> bool:
        """Whether the evidence is too odd for any object of the library."""
        examples = int(self.library.counts[self.library.objects.index(self.best)])
        return bool(self.oddness <= max(ODD_QUANTILE, 1.0 / (1 + examples)))


def _mean_by_object(log_kernel: Floats, library: Library) -> Floats:
    """Log of the mean likelihood over each object's examples that know it; shape (n_objects,)."""
    known = np.isfinite(log_kernel)
    top = log_kernel[known].max() if known.any() else 0.0
    mass = np.where(known, np.exp(np.maximum(np.nan_to_num(log_kernel - top), -700.0)), 0.0)
    n = len(library.objects)
    total = np.bincount(library.owner, weights=mass, minlength=n)
    count = np.bincount(library.owner, weights=known, minlength=n)
    # An object that never was touched so is neither likelier nor less likely than the others on the whole.
    mean = np.where(count > 0, total / np.maximum(count, 1), total.sum() / max(float(known.sum()), 1.0))
    out: Floats = np.log(np.maximum(mean, 1e-300)) + top
    return out


def _size_prior(library: Library) -> Floats:
    """Probability of each size in each example's world, shape (n, n_sizes)."""
    cached = library.__dict__.get("_size_prior")
    if cached is None:
        off = LOG_SIZES[None, :] - library.log_size[:, None]
        cached = np.where(np.isfinite(off), np.exp(-0.5 * (off / _WORLD_SPREAD) ** 2), 1.0)
        cached = cached / cached.sum(axis=1, keepdims=True)
        library.__dict__["_size_prior"] = cached
    out: Floats = cached
    return out
