"""What classifiers of presses have in common: what they take, how they hold out, how they answer."""

from __future__ import annotations

import math
import warnings
from abc import ABCMeta, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._name import plain_name
from varishold.errors import InputError
from varishold.grasp.estimator import (
    BaseEstimator,
    ClassifierMixin,
    check_classification_targets,
    check_is_fitted,
    validate_data,
)
from varishold.learning.recognition import Recognition
from varishold.touch.course.one_sensor import SensorScale, of_one_sensor, pads_in_words
from varishold.touch.course.presses import Press, as_presses, drifted, first_of_same, flat_presses, is_flat
from varishold.trust import first_without_name, group_folds, kept_together, same_partition, widened

__all__ = ["COPIES", "MOST_MEASURES", "PressClassifier", "Training", "copies_of", "copies_told", "equal_rows"]

Floats = NDArray[np.float64]

_LEAST_ALTERNATIVE = 0.01
#: An answer names so many measures.
MOST_MEASURES = 5
#: Copies of every press that have drifted, each in its own way.
COPIES = 5
# What is learned without place or load lies up to so many taxels elsewhere there, and is pressed so much less.
_ELSEWHERE, _LIGHTER = 2, 0.4
# Whose unit and pitch asked presses are taken in.
_LEARNED = "the model"
# From this share of the loss of guessing on, held-out presses tell nothing.
_GUESSED = 0.97


@dataclass(frozen=True, eq=False)
class Training:
    """Presses to learn from, and what is held out together.

    Parameters
    ----------
    presses : list of Press
    codes, fold : ndarray of shape (n_presses,), int
        The class of each, and the fold in which it is held out.
    sessions : bool
        Whether whole sessions are held out.
    grouped : bool
        Whether groups were given.
    n_copies : int
        So many times the presses are learned again as they might be on another day.
    remarks : tuple of str
        What is to be known of how the presses were taken.
    """

    presses: list[Press]
    codes: NDArray[np.intp]
    fold: NDArray[np.intp]
    sessions: bool
    grouped: bool
    n_copies: int
    remarks: tuple[str, ...] = ()

    @property
    def all_codes(self) -> NDArray[np.intp]:
        """The class of each press, and of each copy after them."""
        return np.tile(self.codes, 1 + self.n_copies)

    @property
    def all_folds(self) -> NDArray[np.intp]:
        """The fold of each press, and of each copy after them."""
        return np.tile(self.fold, 1 + self.n_copies)

    @property
    def asked(self) -> NDArray[np.bool_]:
        """Which of these settings are chosen on: where sessions are known they show how things drift, else copies."""
        of_copies = np.arange(len(self.all_codes)) >= len(self.codes)
        return np.asarray(of_copies != (self.sessions or self.n_copies == 0))

    def copies(self, drift: float, *, elsewhere: bool, lighter: bool) -> list[Press]:
        """Return the copies: gains have drifted, and things may lie elsewhere or be pressed less."""
        return copies_of(self.presses, self.n_copies, drift, elsewhere=elsewhere, lighter=lighter)


class PressClassifier(ClassifierMixin, BaseEstimator, metaclass=ABCMeta):  # type: ignore[misc]
    """A classifier of presses or grasps, as `TactileClassifier` describes it."""

    shape: tuple[int, ...] | None
    error: float
    drift: float
    folds: int
    classes_: NDArray[Any]
    places_: NDArray[np.str_]
    remarks_: tuple[str, ...]
    #: From how many unlabelled presses of another session its drift was estimated.
    adapted_to_: int = 0
    #: The unit of what was learned, and how far taxels are apart, as far as training presses said.
    scale_: SensorScale = SensorScale()
    # Whether it learns from how high readings are.
    _levels_count: ClassVar[bool] = True

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.three_d_array = True
        # Shapes of sections say nothing of points in a plane, which scikit-learn's own checks would have learned.
        tags.classifier_tags.poor_score = True
        return tags

    @abstractmethod
    def fit(
        self, X: Any, y: ArrayLike, groups: ArrayLike | None = None, *, tick: Callable[[], object] = lambda: None
    ) -> Self:
        """Learn from presses.

        Parameters
        ----------
        X : sequence of Recording, of frames or of (frames, time_s); or array_like
            One press each. Frames of one press: (n_frames, rows, cols), (n_frames, pads, rows, cols), or one frame
            (rows, cols). An array: (n, rows, cols), (n, n_frames, rows, cols), (n, n_frames, pads, rows, cols).
        y : array_like of shape (n,)
            Labels, in the order of recording; at least two different ones, each at least twice. A press that is a copy
            of another with the same label is not learned again.
        groups : array_like of shape (n,), optional
            The session of each press, or whatever else is new tomorrow.
        tick : callable
            Called as the work goes on, for a progress bar.

        Raises
        ------
        InputError
            Saying what is wrong with which press or label, and what to do.
        """

    @property
    @abstractmethod
    def pads_(self) -> Mapping[str, tuple[int, int]]:
        """The pads that were learned from: rows and columns by name."""

    @property
    @abstractmethod
    def loss_(self) -> float:
        """How surprising the true class of a held-out training press was on the mean, nats."""

    @property
    def chosen_(self) -> dict[str, Any]:
        """The parameters that cross-validation has chosen, as `set_params` takes them."""
        return {}

    @abstractmethod
    def _said(self, presses: Sequence[Press]) -> tuple[Floats, Floats, Any]:
        """Return plain probabilities, p-values, and what an explanation needs."""

    @abstractmethod
    def _reasons(self, said: Any, k: int, first: int, second: int) -> tuple[list[tuple[str, float]], int]:
        """Return what speaks for one class and against another, in nats, and which landmark is nearest to press k."""

    @abstractmethod
    def _again(self, said: Any) -> NDArray[np.bool_]:
        """Tell which presses are measured as one of `places_` was, to single precision."""

    def _outside(self, said: Any, k: int) -> tuple[str, ...]:
        """Return which measures of press k lie outside of all that was learned, where that is known."""
        return ()

    def _unlike(self, said: Any, k: int) -> bool:
        """Tell whether press k is felt unlike the one session that was learned, but for its form."""
        return False

    @property
    @abstractmethod
    def landmark_codes(self) -> NDArray[np.intp]:
        """The class of each press of `places_`."""

    def predict(self, X: Any) -> NDArray[Any]:
        """Answer the likeliest class of every press, shape (n,)."""
        likeliest = self.predict_proba(X).argmax(axis=1)
        return np.asarray(self.classes_[likeliest])

    def predict_proba(self, X: Any) -> Floats:
        """Return the probability of each class of `classes_` for every press, shape (n, n_classes).

        Calibrated on held-out presses. Where a press is as strange as what is refused, drawn towards an even share: no
        probability is above .9 there.
        """
        return self.judge(X)[0]

    def p_values(self, X: Any) -> Floats:
        """Return how rare it is that a press of something known is as strange, shape (n,)."""
        return self.judge(X)[1]

    def judge(self, X: Any) -> tuple[Floats, Floats]:
        """Return `predict_proba` and `p_values` of presses that are measured once."""
        return self._judged(self._asked(X))[:2]

    def refused(self, X: Any) -> NDArray[np.bool_]:
        """Tell which presses look like none of the classes, shape (n,)."""
        return np.asarray(self.p_values(X) <= self.error)

    def learned_from(self, X: Any) -> NDArray[np.bool_]:
        """Tell which presses it has learned from, of those that it keeps to compare with, shape (n,).

        Known again by what is measured of them, wherever they stand now. One that presses nothing is not.
        """
        presses = self._asked(X)
        felt = [any((frames > 0).any() for frames in press.pads.values()) for press in presses]
        return np.array(felt) & self._again(self._said(presses)[2])

    def explain(self, X: Any) -> list[Recognition]:
        """Return every press's answer, how far it may be believed, which measures decided, and the nearest press."""
        presses = self._asked(X)
        probabilities, p_values, said = self._judged(presses)
        return [
            self._recognition(press, k, probabilities[k], float(p_values[k]), said) for k, press in enumerate(presses)
        ]

    def remarks_on(self, X: Any) -> tuple[str, ...]:
        """Return what is to be known of how presses are taken: those in another unit, or without unit or pitch."""
        return () if is_flat(X) else self.scale_.remarks_on(as_presses(X), _LEARNED)

    def add(self, label: Any, X: Any) -> Self:
        """Add a class, where a classifier can."""
        raise InputError(f"a {type(self).__name__} takes no class more: learn all of them together")

    def adapt(self, X: Any) -> Self:
        """Return a copy for another session, where a classifier can make one."""
        raise InputError(f"a {type(self).__name__} is adapted to no session: learn presses of several sessions")

    def _judged(self, presses: Sequence[Press]) -> tuple[Floats, Floats, Any]:
        plain, p_values, said = self._said(presses)
        return widened(plain, p_values, self.error), p_values, said

    def _recognition(self, press: Press, k: int, probabilities: Floats, p_value: float, said: Any) -> Recognition:
        order = np.argsort(-probabilities, kind="stable")
        first, second = int(order[0]), int(order[1])
        reasons, near = self._reasons(said, k, first, second)
        others = {
            self.classes_[j]: float(probabilities[j]) for j in order[1:] if probabilities[j] >= _LEAST_ALTERNATIVE
        }
        return Recognition(
            label=self.classes_[first],
            probability=float(probabilities[first]),
            alternatives=others,
            p_value=p_value,
            refused=p_value <= self.error,
            measures=tuple(reasons[:MOST_MEASURES]),
            nearest=str(self.places_[near]),
            nearest_label=self.classes_[self.landmark_codes[near]],
            place=press.place,
            adapted_to=self.adapted_to_,
            outside=self._outside(said, k) if p_value <= self.error else (),
            unlike_session=self._unlike(said, k),
        )

    def _check_options(self) -> None:
        if not _is_number(self.error) or not 0 < self.error < 1:
            raise InputError(f"error must lie between 0 and 1, got {self.error!r}")
        if not _is_number(self.drift) or not 0 <= self.drift < 1:
            raise InputError(f"drift must be at least 0 and below 1, got {self.drift!r}")
        if isinstance(self.folds, bool) or not isinstance(self.folds, (int, np.integer)) or self.folds < 2:
            raise InputError(f"folds must be a whole number, at least 2, got {self.folds!r}")

    def _training(self, X: Any, y: ArrayLike, groups: ArrayLike | None) -> Training:
        """Return what there is to learn from, everything checked; sets `classes_`."""
        self._check_options()
        presses, labels, remarks = self._labelled(X, y)
        session: NDArray[Any] | None = None if groups is None else _known_groups(groups)
        if session is not None and session.shape != labels.shape:
            raise InputError(f"groups must be one a press, {len(labels)} of them, got {session.shape}")
        first = first_of_same(presses)
        # A copy that is named otherwise stays: which name is right is not known.
        kept = np.flatnonzero((first == np.arange(len(first))) | (labels[first] != labels))
        remarks += copies_told(len(presses) - len(kept), int((labels[first] != labels).sum()))
        presses, labels = [presses[k] for k in kept], labels[kept]
        named = None if session is None else session[kept]
        self.classes_, codes = np.unique(labels, return_inverse=True)
        if len(self.classes_) < 2:
            raise InputError(
                f"y must hold at least two classes to tell apart, got 1 class: {str(self.classes_[0])!r}; "
                "give presses of something else too"
            )
        if named is not None and same_partition(named, codes):
            raise InputError("groups are the labels themselves: nothing would be left to learn a held-out label from")
        counts = np.bincount(codes)
        if counts.min() < 2 and len(kept) < len(first):
            few = str(self.classes_[counts.argmin()])
            raise InputError(f"{few!r} has one press only, copies being one: give each class at least two that differ")
        fold = group_folds(labels, named, folds=self.folds)
        sessions = named is not None and kept_together(fold, named)
        return Training(presses, codes, fold, sessions, named is not None, COPIES if self.drift > 0 else 0, remarks)

    def _labelled(self, X: Any, y: ArrayLike) -> tuple[list[Press], NDArray[Any], tuple[str, ...]]:
        _check_presses(X)
        if is_flat(X):
            self.scale_ = SensorScale()
            flat, labels = validate_data(self, X, y, dtype=np.float64, ensure_min_samples=1)
            _check_targets(labels)
            return flat_presses(flat, self.shape), _plain_names(np.asarray(labels), "label"), ()
        if y is None:
            raise InputError("y must be one label a press, got None")
        _check_named(y)
        labels = _plain_names(np.asarray(y), "label")
        presses = as_presses(X)
        if labels.shape != (len(presses),):
            raise InputError(f"y must be one label a press, {len(presses)} of them, got shape {labels.shape}")
        if not presses:
            raise InputError("there is no press: give at least two of each class")
        _check_targets(labels)
        self.scale_ = SensorScale.of(presses)
        remarks = self.scale_.remarks_on(presses, "the others")
        presses = of_one_sensor(presses, levels_count=self._levels_count)
        self.n_features_in_ = sum(rows * cols for rows, cols in presses[0].shapes.values())
        return presses, labels, remarks

    def _asked(self, X: Any) -> list[Press]:
        check_is_fitted(self)
        _check_presses(X)
        if is_flat(X):
            presses = flat_presses(validate_data(self, X, dtype=np.float64, reset=False), self.shape)
        else:
            presses = as_presses(X)
        if not presses:
            raise InputError("there is no press: give at least one")
        known = self.pads_
        for press in presses:
            for name, shape in press.shapes.items():
                if known.get(name) != shape:
                    raise InputError(
                        f"{press.place}: has a pad {name!r} of {shape[0]} x {shape[1]} taxels; the model is of another "
                        f"sensor: {pads_in_words(known)}; learn from recordings of this one"
                    )
        return self.scale_.taken(presses, _LEARNED, levels_count=self._levels_count)

    def _remarks(self, training: Training) -> tuple[str, ...]:
        """Return what a reader should know of what was learned."""
        remarks = [*training.remarks]
        if not training.sessions:
            why = "some thing was felt in one session only" if training.grouped else "no sessions are known"
            remarks.append(f"{why}: no session was held out, and on another day answers may be worse than they claim")
        if self.loss_ > _GUESSED * math.log(len(self.classes_)):
            remarks.append(
                "held-out presses are told no better than by guessing: look whether labels stand beside the right "
                "presses, and whether these show what is pressed"
            )
        if len(training.presses) < 1 / self.error - 1:
            remarks.append(
                f"{len(training.presses)} presses are too few to refuse anything at an error of {self.error:g}: "
                f"give {int(np.ceil(1 / self.error - 1))} or more"
            )
        return tuple(remarks)


def copies_of(presses: list[Press], n_copies: int, drift: float, *, elsewhere: bool, lighter: bool) -> list[Press]:
    """Return presses so many times as they might be on another day, each in its own way."""
    return [
        drifted(
            press,
            drift,
            (copy, k),
            elsewhere=_ELSEWHERE if elsewhere else 0,
            lighter=_LIGHTER if lighter else 0.0,
        )
        for copy in range(n_copies)
        for k, press in enumerate(presses)
    ]


def copies_told(n_copies: int, n_otherwise: int = 0) -> tuple[str, ...]:
    """Return remarks on presses that are there more than once, and on those that have another label then."""
    remarks = []
    if n_copies:
        what = "1 press is a copy" if n_copies == 1 else f"{n_copies} presses are copies"
        remarks.append(f"{what} of others, with identical frames: each is learned once; leave the copies out")
    if n_otherwise:
        what = "1 press is a copy" if n_otherwise == 1 else f"{n_otherwise} presses are copies"
        remarks.append(f"{what} of others that have another label: look which is right")
    return tuple(remarks)


def equal_rows(rows: Floats, known: Floats) -> NDArray[np.bool_]:
    """Tell which rows are one of those known, to single precision, shape (n_rows,)."""
    near = 1e-5 * np.maximum(np.abs(known).max(axis=1, initial=0.0), 1.0)
    return np.array(
        [bool((np.abs(known - row).max(axis=1, initial=0.0) <= near).any()) for row in rows], dtype=np.bool_
    )


def _known_groups(groups: ArrayLike) -> NDArray[Any]:
    """Return the session of each press, refusing presses of none."""
    named = np.asarray(groups)
    none = first_without_name(named)
    if none is not None:
        raise InputError(f"press {none} has no group: name its session, or leave the groups out")
    return _plain_names(named.astype(np.str_) if named.dtype.kind == "O" else named, "group")


def _plain_names(names: NDArray[Any], what: str) -> NDArray[Any]:
    """Return names as they are kept; what is no text stays as it is."""
    texts = names.dtype.kind == "O" and all(isinstance(name, str) for name in names.ravel())
    given = names.astype(np.str_) if texts else names
    if given.dtype.kind != "U":
        return given
    different, of = np.unique(given, return_inverse=True)
    kept = [plain_name(str(name)) for name in different]
    if None in kept:
        wrong = kept.index(None)
        press = int(np.flatnonzero(of.ravel() == wrong)[0])
        raise InputError(f"press {press}: its {what} must be a line of printable text, got {str(different[wrong])!r}")
    return np.array(kept, dtype=np.str_)[of].reshape(given.shape)


def _check_presses(X: Any) -> None:
    """Refuse what holds no press where frames are meant: nothing, or texts."""
    if X is None or isinstance(X, (str, bytes)):
        raise InputError(f"presses must be a sequence of recordings or frames, got {X!r:.60}")
    for k, one in enumerate(X if isinstance(X, (list, tuple)) else ()):
        if one is None or isinstance(one, (str, bytes)):
            raise InputError(f"press {k}: must be a recording or frames, got {one!r:.60}; read files first")


def _check_named(y: ArrayLike) -> None:
    """Refuse a press without a label, and a label that is a number but not whole."""
    none = first_without_name(y)
    if none is not None:
        raise InputError(f"press {none} has no label: name what it is of, or leave it out")
    labels = np.asarray(y)
    if labels.dtype.kind == "f":
        broken = np.flatnonzero(labels.ravel() != np.rint(labels.ravel()))
        if broken.size:
            got = labels.ravel()[broken[0]]
            raise InputError(f"press {broken[0]}: its label must be a text or a whole number, got {got:g}")


def _check_targets(labels: NDArray[Any]) -> None:
    with warnings.catch_warnings():
        # That there are nearly as many classes as presses: those with one are refused.
        warnings.simplefilter("ignore", UserWarning)
        check_classification_targets(labels)


def _is_number(value: object) -> bool:
    return isinstance(value, Real)
