"""The belief: which object, of which size, after every touch so far.

The posterior is held by weighted particles. Every example of the library is one: an object of some size and pose under
some physics, with what each touch of it felt like. A particle must explain all touches, so that size and pose are
shared between touches and summed out jointly. To multiply touches as if each could be explained by another example
would make the belief surer than it may be.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, require, require_a
from varishold.frame.checks import is_number
from varishold.perceive.conformity_look import conformity_look
from varishold.perceive.evidence import Evidence
from varishold.perceive.library import LOG_SIZES, Library
from varishold.perceive.likelihood import mean_by_every_kind
from varishold.perceive.name_evidence import NameEvidence
from varishold.perceive.number_words import number_in_words
from varishold.perceive.repeated import Repeated
from varishold.perceive.seen import Beyond, Look, SeenRange, answers_look, range_look
from varishold.perceive.touch_model import SIGNIFICANCE, TouchModel
from varishold.trust import known_share, weighed_p_value, widened

__all__ = ["STRANGERS", "Belief"]

Floats = NDArray[np.float64]

# Errors of size of several grips at one object are correlated so far: each counts the less for it.
_SIZE_CORRELATION = 0.6

# Log-likelihoods end so far below the largest, so that a new touch can bring a size back.
_FLOOR = -60.0

# A number lies outside of what is known where at most this share of the examples lies as far beyond all others.
_RANGE_ERROR = 0.008

# An object is named, rather than a wider one that it is as well, where it is so sure against that.
_SURE = 0.9

#: Before it is felt, a thing is taken for none of the library's so often.
STRANGERS = 0.1

# How strange a thing looks counts so much less than how strange it feels. Chosen on lumps and household things.
_WEIGHT_OF_SIGHT = 0.5


@dataclass(frozen=True, eq=False)
class Belief:
    """What is believed after some touches.

    Parameters
    ----------
    library : Library
    log_weight : ndarray of shape (n,)
        Of each particle, the library's examples: log-likelihood of all touches so far.
    size_table : ndarray of shape (n_kinds, n_sizes)
        Log-likelihood of all touches' sizes, by the library's kinds: an object in one pose is one.
    kept : ndarray of shape (n_kinds, n_sizes)
        What the particles of each size said before the object was moved last.
    scores : ndarray of shape (n_touches, n_kinds)
        Conformity of each touch with each kind: log-likelihood under it alone, less that under other things.
    touches : tuple of str
        What has been touched, in order.
    remarks : tuple of str
        What was odd.
    sized : int
        How many of the touches said something of size.
    known : tuple of ndarray, bool
        For each touch, which of its numbers were known.
    beyond : tuple of Beyond
        For each touch that was felt, the number that lies farthest beyond all examples.
    answers : tuple of NameEvidence
        What other recognizers have said of the name.
    seen : NameEvidence or None
        What another sense said before anything was touched, where it said how strange the thing is to it: it does not
        err with the touches.
    strangers : float
        How many of all things are none of the library's, as far as was known before any touch: a share.
    here : mapping of str to Repeated
        What each touch that was made since the object was moved last has said of the particles.
    """

    library: Library
    log_weight: Floats
    size_table: Floats
    kept: Floats
    scores: Floats
    touches: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    sized: int = 0
    known: tuple[NDArray[np.bool_], ...] = ()
    beyond: tuple[tuple[SeenRange, Beyond], ...] = ()
    answers: tuple[NameEvidence, ...] = ()
    seen: NameEvidence | None = None
    strangers: float = STRANGERS
    here: Mapping[str, Repeated] = field(default_factory=dict)

    @classmethod
    def before(cls, library: Library, prior: NameEvidence | None = None, *, strangers: float = STRANGERS) -> Self:
        """Return the belief before any touch: every object alike, or as another sense says.

        Raises
        ------
        InputError
            If the library knows none of the prior's names, or the share of strangers is none.
        """
        require_a(Library, library, "library", "made by from_examples or read_library")
        share = is_number(strangers) and 0 <= strangers < 1
        require(share, f"strangers must be a share of at least 0 and below 1, got {strangers!r}")
        n_kinds = len(library.object_of_kind)
        alike = cls(
            library,
            np.zeros(len(library)),
            np.zeros((n_kinds, len(LOG_SIZES))),
            np.zeros((n_kinds, len(LOG_SIZES))),
            np.zeros((0, n_kinds)),
            strangers=strangers,
        )
        if prior is None:
            return alike
        require_a(NameEvidence, prior, "prior", "what another sense says of the name")
        told = alike.after(prior)
        told = replace(told, remarks=(*told.remarks, *prior.silence(library.objects)))
        return replace(told, answers=(), seen=prior) if prior.p_value < 1 else told

    def after(self, evidence: Evidence | NameEvidence) -> Self:
        """Return the belief after one touch more, or after what another recognizer says of the name.

        Raises
        ------
        InputError
            If the library does not know such a touch, or none of the recognizer's names.
        """
        if isinstance(evidence, NameEvidence):
            return self._after_answer(evidence)
        require_a(Evidence, evidence, "evidence", "or a NameEvidence")
        model = self.library.touches.get(evidence.touch)
        if model is None:
            raise InputError(
                f"the library knows no touch {evidence.touch!r}; it knows {', '.join(self.library.touches)}"
            )
        success = model.log_success(self.library.kind, failed=evidence.failed)
        values = evidence.vector(model.metric.names)
        known = np.isfinite(values)
        log_kernel, means = self._explained(model, values)
        sizes, sized = self.size_table, self.sized
        if model.size is not None:
            told = model.size.log_likelihood_of_steps(evidence.vector(model.size.names), LOG_SIZES)
            sizes, sized = sizes + told, sized + int(bool(told.any()))
        remarks, felt = list(evidence.remarks), (model.seen, model.seen.beyond(values))
        if not known.any():
            nothing = "nothing that the library knows was felt; the belief stays as it was"
            remarks.append(f"{evidence.touch}: {'tried, and nothing was held' if evidence.failed else nothing}")
        if range_look([felt], _RANGE_ERROR).inside <= 1:
            what = number_in_words(felt[1].name)
            remarks.append(f"{evidence.touch}: {what} lies beyond all that the library's examples have shown")
        nothing_yet = Repeated(np.zeros(len(self.library)), np.zeros(len(values), dtype=np.int64))
        before = self.here.get(evidence.touch, nothing_yet)
        said = before.again(log_kernel + success, known)
        return replace(
            self,
            log_weight=self.log_weight + (said.log_weight - before.log_weight),
            here={**self.here, evidence.touch: said},
            size_table=sizes,
            touches=(*self.touches, evidence.touch),
            scores=np.vstack(
                [self.scores, means - model.log_others(values) if known.any() else np.full_like(means, np.nan)]
            ),
            known=(*self.known, known),
            beyond=(*self.beyond, felt) if known.any() else self.beyond,
            remarks=(*self.remarks, *remarks),
            sized=sized,
        )

    def _after_answer(self, evidence: NameEvidence) -> Self:
        """Return the belief after what another recognizer says of the name."""
        objects, pose = self.library.objects, None if evidence.refused else evidence.pose
        return replace(
            self,
            # It is known of the thing, wherever it is moved, and is no grip that errs as others do.
            kept=self.kept if pose is None else self.kept + pose.log_likelihood(LOG_SIZES),
            log_weight=self.log_weight + evidence.log_likelihood(objects)[self.library.owner],
            answers=(*self.answers, evidence),
            remarks=(*self.remarks, *evidence.remarks(objects)),
        )

    def _explained(self, model: TouchModel, values: Floats) -> tuple[Floats, Floats]:
        """Return how likely what a touch felt is under each example, and on the mean of each kind, in logarithm."""
        kind, members = self.library.kind, self.library.members
        log_kernel = model.log_kernel(values)
        means = mean_by_every_kind(log_kernel, members)
        # An example without this touch explains it as its kind's others do on the whole.
        log_kernel = np.where(np.isnan(log_kernel), means[kind], log_kernel)
        if model.own < 1:
            # Of each kind the mean stays.
            log_kernel = model.own * log_kernel
            log_kernel += (means - mean_by_every_kind(log_kernel, members))[kind]
        return log_kernel, means

    def in_new_place(self) -> Self:
        """Return the belief after the object was moved: object and size stay, its pose is unknown again."""
        prior = self.library.size_prior
        top = self.log_weight.max()
        told = self.library.members @ (np.exp(self.log_weight - top)[:, None] * prior)
        before = self.library.members @ prior
        # What the particles of each size said on the whole stays as what is known of the size.
        said = np.log(np.maximum(told, 1e-300)) - np.log(np.maximum(before, 1e-300)) + top
        return replace(self, log_weight=np.zeros(len(self.library)), kept=self.kept + said, here={})

    @cached_property
    def _joint(self) -> tuple[Floats, Floats]:
        """Probability of each particle, and of each object's sizes (up to constants), both joint."""
        prior = self.library.size_prior
        # Before any touch tells sizes the table is nothing, whatever it is divided by.
        table = self.size_table / (1 + _SIZE_CORRELATION * (self.sized - 1)) + self.kept
        top = table.max(axis=1, keepdims=True)
        likelihood = np.exp(np.maximum(table - top, _FLOOR))
        kind = self.library.kind
        of_size = np.einsum("ns,ns->n", prior, likelihood[kind])
        log_particle = self.log_weight + np.log(np.maximum(of_size, 1e-300)) + top[kind, 0] + self.library.log_prior
        weight = np.exp(log_particle - log_particle.max())
        # Each particle's share of its object's poses is in it; what is common to an object's kinds is left out.
        inner = np.exp(self.log_weight - self.log_weight.max() + self.library.log_prior)[:, None] * prior
        per_size = (self.library.members @ inner) * likelihood
        objects = self.library.object_of_kind
        most = np.full(len(self.library.objects), -np.inf)
        np.maximum.at(most, objects, top[:, 0])
        of_object = objects[None, :] == np.arange(len(self.library.objects))[:, None]
        return weight / weight.sum(), of_object @ (per_size * np.exp(top[:, 0] - most[objects])[:, None])

    @property
    def particles(self) -> Floats:
        """Probability of each example of the library, shape (n,)."""
        particles, _ = self._joint
        return particles

    @cached_property
    def probability(self) -> dict[str, float]:
        """Probability of each object, were it one of the library's, largest first."""
        p = np.bincount(self.library.owner, weights=self.particles, minlength=len(self.library.objects))
        order = np.argsort(-p, kind="stable")
        return {self.library.objects[k]: min(float(p[k]), 1.0) for k in order}

    @property
    def best(self) -> str:
        """The likeliest object of the library."""
        return next(iter(self.probability))

    @cached_property
    def best_kind(self) -> int:
        """The likeliest kind of the likeliest object: its pose, where the library tells poses.

        :meta private:
        """
        kinds = np.flatnonzero(self.library.object_of_kind == self.library.objects.index(self.best))
        shares = np.bincount(self.library.kind, weights=self.particles, minlength=len(self.library.counts))
        return int(kinds[np.argmax(shares[kinds])])

    @property
    def pose(self) -> str | None:
        """How the likeliest object likeliest lies; None where the library does not say."""
        return self.library.pose_of_kind[self.best_kind]

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
        k = self.library.index(self.best if name is None else name)
        _, by_object = self._joint
        share = by_object[k]
        if not np.isfinite(self.library.log_size[self.library.owner == k]).any() or share.sum() <= 0:
            return None
        cumulative = np.cumsum(share) / share.sum()
        # Half a step back: a step's share lies about its middle.
        step = LOG_SIZES[1] - LOG_SIZES[0]
        low, middle, high = np.interp([0.025, 0.5, 0.975], cumulative, LOG_SIZES + step / 2)
        return float(np.exp(middle)), float(np.exp(low)), float(np.exp(high))

    @cached_property
    def believed(self) -> dict[str, float]:
        """Probability of each object: none is above .9 where what was felt is outside of what the library knows."""
        (shares,) = widened([list(self.probability.values())], [self.inside], 1.0)
        return dict(zip(self.probability, shares.tolist(), strict=True))

    @property
    def said(self) -> tuple[str, float]:
        """The name that is given, and its probability: the likeliest object's, or a wider one where that is not sure.

        A share of things is taken to be none of the library's, and to be told from them as its touches tell.
        What is surely a box, and perhaps a pillar that lies, is a box: a pillar that lies is one.

        :meta private:
        """
        name, believed = self.best, self.believed
        wider = self.library.wider_than(name, self.pose)
        if wider is None or believed[name] >= _SURE * (believed[name] + believed[wider]):
            return name, self._one_of_these * believed[name]
        together = min(self.probability[name] + self.probability[wider], 1.0)
        ((share, _),) = widened([[together, 1.0 - together]], [self.inside], 1.0)
        return wider, self._one_of_these * float(share)

    @cached_property
    def _one_of_these(self) -> float:
        """Probability that the thing is an object of the library at all, by how its touches tell what is most like it.

        1 where nothing is known of other things.
        """
        k = self.best_kind
        felt = [touch for touch, score in zip(self.touches, self.scores[:, k], strict=True) if np.isfinite(score)]
        powers = [self.library.touches[touch].least_power(k) for touch in felt]
        if not np.isfinite(powers).any():
            return 1.0
        # What one touch does not tell the others seldom do: it is the same thing to all of them.
        return known_share(self.p_value_with_sight, float(np.nanmax(powers)), SIGNIFICANCE, self.strangers)

    @property
    def inside(self) -> float:
        """The smallest p-value in parts of its limit, of numbers beyond all examples too: 1 or less is outside."""
        return min(look.inside for look in (*self._looks, range_look(self.beyond, _RANGE_ERROR)))

    @property
    def p_value(self) -> float:
        """Conformal p-value of all touches for the likeliest object, or of other recognizers' answers if it is less."""
        return min(look.p_value for look in self._looks)

    @property
    def atypical(self) -> bool:
        """Whether no object of the library explains the touches."""
        return any(look.inside <= 1 for look in self._looks)

    @property
    def p_value_with_sight(self) -> float:
        """The p-value, weighed with how strange the thing looked to another sense before it was touched.

        :meta private:
        """
        return self._with_sight(self.p_value)

    @property
    def looks_usual(self) -> bool:
        """Whether what is atypical is so to touch alone, and not once it is weighed with how it looked.

        :meta private:
        """
        touches, *others = self._looks
        return all(look.inside > 1 for look in others) and self._with_sight(touches.p_value) > touches.limit

    def _with_sight(self, p_value: float) -> float:
        if self.seen is None:
            return p_value
        return weighed_p_value(p_value, self.seen.p_of_these(self.library.objects), _WEIGHT_OF_SIGHT)

    @cached_property
    def _looks(self) -> tuple[Look, ...]:
        touches, said = self._typicality(), answers_look(self.answers, self.library.objects)
        return (touches,) if said is None else (touches, said)

    def _typicality(self) -> Look:
        """Ask whether it is the likeliest object, in the pose in which it is likeliest."""
        k, size = self.best_kind, self.size()
        at = None if size is None else float(np.log(size[0]))
        library = self.library
        told = [
            (own, score)
            for touch, score, known in zip(self.touches, self.scores[:, k], self.known, strict=True)
            if np.isfinite(score)
            and np.isfinite(
                (own := library.touches[touch].calibration(k, library.kind, known, library.log_size)).scores
            ).any()
        ]
        return conformity_look(told, at, library.refused_after(len(self.beyond)), int(library.counts[k]))
