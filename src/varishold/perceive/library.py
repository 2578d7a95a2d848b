"""What is known of objects: examples of how touches of them feel.

An object is its examples: adding one adds rows and changes nothing else. One row holds all touches of one object in one
place, so that size, pose and physics are shared between them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from varishold._name import NONE_OF_THESE
from varishold.errors import InputError, require
from varishold.frame.checks import as_names, as_positive, is_number
from varishold.perceive.evidence import Evidence
from varishold.perceive.examples import check_examples, learned_touch, log_sizes, named, object_name, with_examples
from varishold.perceive.poses import Kinds, kinds_of, poses_of, usual_of
from varishold.perceive.size_prior import size_priors
from varishold.perceive.touch_model import TouchModel, tempered

__all__ = ["LOG_SIZES", "NONE_OF_THESE", "REFUSED_AT", "Library"]

Floats = NDArray[np.float64]

#: The sizes that are told apart, 20 to 250 mm: 101 steps in logarithm. A size beyond its ends is told as the end.
LOG_SIZES: Floats = np.linspace(np.log(0.02), np.log(0.25), 101)

#: "None of these" at p-values of at most these, up to the third touch that was felt and from the fourth on: strangers
#: that feel much like something known are told by many touches, and what is felt so often is mostly what seemed strange
#: before. A known object falls below the first in fewer than one look of a hundred, and in about one sequence of fifty.
#: Chosen on known things and on things that are nearly such.
REFUSED_AT = (0.007, 0.012)

# From so many touches on the second of them counts.
_LATE = 4


@dataclass(frozen=True, eq=False)
class Library:
    """Objects by example.

    Parameters
    ----------
    objects : tuple of str
    owner : ndarray of shape (n,), int
        Which object each example is of.
    log_size : ndarray of shape (n,)
        Logarithm of each example's size in metres; NaN where it is unknown and may be any.
    touches : mapping of str to TouchModel
    hand : str or None
        The hand that felt the objects; None where that is not said.
    poses : tuple of str
        How objects were set up, as in "upright", "lying"; empty where that is not said.
    pose : ndarray of shape (n,), int, or None
        Which of `poses` each example was felt in, -1 where that is not said; None where it is said of none.
    wider : mapping of (str, str or None) to str, optional
        Of an object in a pose, or in any (None), another one that it is as well: a pillar that lies is a box.
    refused_at : (float, float), optional
        A thing is none of the objects at p-values of at most these, up to the third touch and from the fourth on.
    """

    objects: tuple[str, ...]
    owner: NDArray[np.int64]
    log_size: Floats
    touches: Mapping[str, TouchModel]
    hand: str | None = None
    poses: tuple[str, ...] = ()
    pose: NDArray[np.int64] | None = None
    refused_at: tuple[float, float] = REFUSED_AT
    wider: Mapping[tuple[str, str | None], str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "touches", dict(self.touches))
        object.__setattr__(self, "wider", dict(self.wider))

    @classmethod
    def from_examples(
        cls,
        examples: Mapping[str, Sequence[Sequence[Evidence]]],
        *,
        sizes_m: Mapping[str, Sequence[float]] | None = None,
        others: Sequence[Sequence[Evidence]] = (),
        costs: Mapping[str, float] | None = None,
        hand: str | None = None,
        poses: Mapping[str, Sequence[str]] | None = None,
    ) -> Self:
        """Make a library from examples of several objects, with a metric and kernels of its own.

        Where every object has 40 examples of a touch its metric is learned from them, which takes some seconds of a
        thousand. What a touch takes is the mean of what it took in the examples, and of other things.

        Parameters
        ----------
        examples : mapping of str to sequence of sequences of Evidence
            For each object, its examples: the touches of one sequence each.
        sizes_m : mapping of str to sequence of float, optional
            For objects whose size is known, the size of each example. Metres.
        others : sequence of sequences of Evidence, optional
            Touches of other things, which are not to be named: they make it easier to tell that a thing is none of
            these.
        costs : mapping of str to float, optional
            What each touch takes; default: 1 each.
        hand : str, optional
            The hand that felt them.
        poses : mapping of str to sequence of str, optional
            How each example of an object was set up, as in "upright", "lying". What is felt in one pose is compared
            with examples in that pose; each of an object's poses is as likely.

        Raises
        ------
        InputError
            If there is no object, one has no example, sizes are not positive or not one an example, poses are not one
            an example, or a touch costs nothing.
        """
        by_touch = costs is None or isinstance(costs, Mapping)
        require(by_touch, f"costs must be given by the touches' names, got {type(costs).__name__}")
        require(hand is None or isinstance(hand, str), f"hand must be the name of the one that felt, got {hand!r}")
        examples = named("examples", examples)
        require(examples, "a library needs at least one object")
        sizes_m = {} if sizes_m is None else named("sizes_m", sizes_m)
        poses = {} if poses is None else named("poses", poses)
        for name, rows in examples.items():
            check_examples(name, rows)
            require(rows, f"{name!r} has no example")
        check_examples("other things", others)
        known = ", ".join(examples)
        for name in sizes_m:
            require(name in examples, f"sizes are given of {name!r}, which has no examples; known are {known}")
        costs = {touch: as_positive(cost, f"the cost of touch {touch!r}") for touch, cost in (costs or {}).items()}
        owner = np.repeat(np.arange(len(examples)), [len(rows) for rows in examples.values()])
        pose_names, pose = poses_of(poses, {name: len(rows) for name, rows in examples.items()})
        log_size = np.concatenate([log_sizes(name, sizes_m.get(name), len(rows)) for name, rows in examples.items()])
        everything = [example for rows in examples.values() for example in rows]
        felt = dict.fromkeys(evidence.touch for row in everything for evidence in row if not evidence.failed)
        require(felt, "the examples hold no touch")
        kinds = kinds_of(owner, pose)
        touches = {
            touch: learned_touch(touch, everything, kinds, log_size, others=others, cost=costs.get(touch, 1.0))
            for touch in felt
        }
        return cls(tuple(examples), owner, log_size, touches, hand, pose_names, pose)

    def __len__(self) -> int:
        return len(self.owner)

    @cached_property
    def seconds(self) -> dict[str, float] | None:
        """How long each touch takes; None where that is not known of all touches."""
        told = {touch: model.seconds for touch, model in self.touches.items() if model.seconds is not None}
        return told if len(told) == len(self.touches) else None

    @property
    def kind(self) -> NDArray[np.int64]:
        """Which kind each example is of, shape (n,): an object in one pose is a kind, and is judged by itself."""
        return self._kinds.of_example

    @property
    def object_of_kind(self) -> NDArray[np.int64]:
        """Which object each kind is, shape (n_kinds,)."""
        return self._kinds.object

    @property
    def pose_of_kind(self) -> tuple[str | None, ...]:
        """The pose of each kind; None where that is not said."""
        return tuple(self.poses[k] if k >= 0 else None for k in self._kinds.pose.tolist())

    @cached_property
    def _kinds(self) -> Kinds:
        return kinds_of(self.owner, self.pose)

    @cached_property
    def usual(self) -> NDArray[np.bool_]:
        """Which examples are of their object's commonest pose, shape (n,): metrics are learned from those.

        :meta private:
        """
        return usual_of(self._kinds)

    @cached_property
    def members(self) -> Floats:
        """1 where an example is of a kind, else 0; shape (n_kinds, n).

        :meta private:
        """
        members: Floats = (self.kind[None, :] == np.arange(len(self.object_of_kind))[:, None]).astype(np.float64)
        return members

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """Number of examples of each kind.

        :meta private:
        """
        return np.bincount(self.kind, minlength=len(self.object_of_kind))

    @cached_property
    def log_prior(self) -> Floats:
        """Logarithm of the share of each example before any touch: objects are alike, and so are an object's poses.

        :meta private:
        """
        kinds = np.bincount(self.object_of_kind, minlength=len(self.objects))
        return np.asarray(-np.log(self.counts[self.kind]) - np.log(kinds[self.owner]))

    @cached_property
    def size_prior(self) -> Floats:
        """Probability of each of `LOG_SIZES` for each example, shape (n, n_sizes).

        :meta private:
        """
        return size_priors(LOG_SIZES, self.log_size, self.kind)

    def index(self, name: str) -> int:
        """Return the place of an object in `objects`.

        :meta private:

        Raises
        ------
        InputError
            If the library does not know it.
        """
        known = isinstance(name, str) and name in self.objects
        require(known, f"the library has no {name!r}; it knows {', '.join(self.objects)}")
        return self.objects.index(name)

    def refused_after(self, touches: int) -> float:
        """Return the p-value at which a thing is none of the objects after so many touches.

        :meta private:
        """
        return self.refused_at[touches >= _LATE]

    def with_object(
        self, name: str, examples: Sequence[Sequence[Evidence]], *, size_m: float | Sequence[float] | None = None
    ) -> Self:
        """Return a library that knows one object more; ten examples do.

        Parameters
        ----------
        name : str
        examples : sequence of sequences of Evidence
            Each one: the touches of one sequence (often a single grasp) at the object.
        size_m : float or sequence of float, optional
            Its size, or each example's. Metres. Default: unknown.

        Raises
        ------
        InputError
            If the name is taken, there is no example, an example holds no touch that the library knows, or the sizes
            are not positive or not one an example.
        """
        name = object_name(name)
        require(name not in self.objects, f"the library knows an object called {name!r} already; choose another name")
        check_examples(name, examples)
        require(examples, f"{name!r} needs at least one example, ten are usual")
        n = len(examples)
        log_size = log_sizes(name, size_m, n)
        owner = np.append(self.owner, np.full(n, len(self.objects)))
        pose = None if self.pose is None else np.append(self.pose, np.full(n, -1))
        kind = kinds_of(owner, pose).of_example
        touches = {
            touch: with_examples(model, touch, examples, kind=kind, log_size=log_size)
            for touch, model in self.touches.items()
        }
        unknown = [k for k in range(n) if not any(np.isfinite(m.values[len(self) + k]).any() for m in touches.values())]
        if unknown:
            raise InputError(f"example {unknown[0]} of {name!r} holds no touch that the library knows")
        return replace(
            self,
            objects=(*self.objects, name),
            owner=owner,
            log_size=np.concatenate([self.log_size, log_size]),
            touches=touches,
            pose=pose,
        )

    def with_wider(self, name: str, wider: str, *, pose: str | None = None) -> Self:
        """Return a library that knows that one of its objects is always another one too.

        Where it is likeliest and not sure, the answer is the other one, which is true of both.

        Parameters
        ----------
        name, wider : str
            As of a pillar, which is a box where it lies.
        pose : str, optional
            Where it is set up so; default: always.

        Raises
        ------
        InputError
            If the library does not know one of them, or the pose, or they are one.
        """
        for each in (name, wider):
            self.index(each)
        require(name != wider, f"{name!r} cannot be wider than itself")
        if pose is not None:
            self._check_pose(pose)
        return replace(self, wider={**self.wider, (name, pose): wider})

    def wider_than(self, name: str, pose: str | None) -> str | None:
        """Return what an object in a pose is as well; None where that is not known.

        :meta private:
        """
        return self.wider.get((name, pose), self.wider.get((name, None)))

    def with_seconds(self, seconds: Mapping[str, float]) -> Self:
        """Return a library that knows how long touches take.

        Parameters
        ----------
        seconds : mapping of str to float
            Of some touches of the library, or of all; the next touch is chosen by seconds where they are known of all.

        Raises
        ------
        InputError
            If the library does not know a touch, or one takes no time.
        """
        self._check_known(seconds)
        told = {touch: as_positive(taken, f"the seconds of touch {touch!r}") for touch, taken in seconds.items()}
        touches = {
            touch: replace(model, seconds=told[touch]) if touch in told else model
            for touch, model in self.touches.items()
        }
        return replace(self, touches=touches)

    def tempered(self, share: float, touches: Sequence[str] | None = None, *, own: float = 1.0) -> Self:
        """Return a library that is less sure, for objects that do not feel quite as its examples.

        Parameters
        ----------
        share : float
            The power that likelihoods are raised to, in (0, 1].
        touches : sequence of str, optional
            Only these; default: all.
        own : float
            How far the likelihood of a single example counts, in (0, 1]; the rest is that of its kind. At 1 every touch
            of an object must feel as those of one and the same example do; a real one is none of them.

        Raises
        ------
        InputError
            If the share, or how far an example counts, is out of its range, or the library does not know a touch.
        """
        for what, number in (("share", share), ("own", own)):
            require(is_number(number) and 0 < number <= 1, f"{what} must lie in (0, 1], got {number!r}")
        chosen = self.touches if touches is None else as_names(touches, "touches")
        self._check_known(chosen)
        return replace(
            self,
            touches={
                touch: replace(tempered(model, self.kind, share), own=model.own * own) if touch in chosen else model
                for touch, model in self.touches.items()
            },
        )

    def only(self, names: Sequence[str]) -> Self:
        """Return a library of some of the objects, in this order.

        Raises
        ------
        InputError
            If one of them is unknown or named twice, or none is named.
        """
        names = as_names(names, "names")
        index = [self.index(name) for name in names]
        require(index, f"an empty list names no object; the library knows {', '.join(self.objects)}")
        require(len(set(names)) == len(names), f"an object is named twice among {', '.join(names)}")
        new = np.zeros(len(self.objects), dtype=np.int64)
        new[index] = np.arange(len(index))
        kinds = [k for name in index for k in np.flatnonzero(self.object_of_kind == name).tolist()]
        some = self.of_examples(np.isin(self.owner, index), kinds)
        wider = {key: other for key, other in self.wider.items() if key[0] in names and other in names}
        return replace(some, objects=tuple(names), owner=new[some.owner], wider=wider)

    def in_pose(self, pose: str) -> Self:
        """Return a library of what was felt in one pose, for a thing that is known to be set up so.

        Of an object that never was felt in it everything stays, as of a ball, which lies as it stands; so do examples
        of which no pose is said.

        Raises
        ------
        InputError
            If nothing was felt in this pose.
        """
        self._check_pose(pose)
        fits = np.array([each in (pose, None) for each in self.pose_of_kind])
        never = np.isin(self.object_of_kind, self.object_of_kind[fits], invert=True)
        kinds = np.flatnonzero(fits | never)
        return self.of_examples(np.isin(self.kind, kinds), kinds.tolist())

    def of_examples(self, rows: NDArray[np.bool_], kinds: list[int]) -> Self:
        """Return a library of some of the examples, shape (n,), which are of these kinds; none is judged anew.

        :meta private:
        """
        return replace(
            self,
            owner=self.owner[rows],
            log_size=self.log_size[rows],
            touches={touch: model.of_examples(rows, kinds) for touch, model in self.touches.items()},
            pose=None if self.pose is None else self.pose[rows],
        )

    def _check_pose(self, pose: str) -> None:
        told = ", ".join(self.poses) or "no pose"
        known = isinstance(pose, str) and pose in self.poses
        require(known, f"the library knows nothing that was felt {pose!r}; it tells {told}")

    def _check_known(self, touches: Iterable[str]) -> None:
        known = ", ".join(self.touches)
        for touch in touches:
            require(touch in self.touches, f"the library knows no touch {touch!r}; it knows {known}")
