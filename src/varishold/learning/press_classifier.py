"""What classifiers of presses have in common: what they take, how they hold out, how they answer."""

from __future__ import annotations

import math
from abc import ABCMeta, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.grasp.estimator import BaseEstimator, ClassifierMixin, check_is_fitted, validate_data
from varishold.learning.checks import check_options, check_presses, checked_groups, checked_labels, checked_targets
from varishold.learning.recognition import Recognition
from varishold.learning.training import COPIES, Training, deal_presses
from varishold.touch.course.one_sensor import SensorScale, of_one_sensor, pads_in_words
from varishold.touch.course.presses import Press, as_presses, flat_presses, is_flat
from varishold.trust import widened

__all__ = ["MOST_MEASURES", "PressClassifier", "equal_rows"]

Floats = NDArray[np.float64]

_LEAST_ALTERNATIVE = 0.01
#: An answer names so many measures.
MOST_MEASURES = 5
# Whose unit and pitch asked presses are taken in.
_LEARNED = "the model"
# What was pressed less than this share of what something else was is told.
_SELDOM = 0.25
# From this share of the loss of guessing on, held-out presses tell nothing.
_GUESSED = 0.97


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
        return widened(plain, self._usual(presses, p_values), self.error), p_values, said

    def _usual(self, presses: Sequence[Press], p_values: Floats) -> Floats:
        """Return by which p-values answers are believed: those of the presses."""
        return p_values

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
        check_options(self.error, self.drift, self.folds)

    def _training(self, X: Any, y: ArrayLike, groups: ArrayLike | None) -> Training:
        """Return what there is to learn from, everything checked; sets `classes_`."""
        self._check_options()
        presses, labels, remarks = self._labelled(X, y)
        self.classes_, training = deal_presses(
            presses, labels, checked_groups(groups, len(labels)), folds=self.folds, n_copies=COPIES if self.drift else 0
        )
        return replace(training, remarks=remarks + training.remarks)

    def _labelled(self, X: Any, y: ArrayLike) -> tuple[list[Press], NDArray[Any], tuple[str, ...]]:
        check_presses(X)
        if is_flat(X):
            self.scale_ = SensorScale()
            flat, named = validate_data(self, X, y, dtype=np.float64, ensure_min_samples=1)
            return flat_presses(flat, self.shape), checked_targets(named), ()
        labels = checked_labels(y)
        presses = as_presses(X)
        if labels.shape != (len(presses),):
            raise InputError(f"y must be one label a press, {len(presses)} of them, got shape {labels.shape}")
        if not presses:
            raise InputError("there is no press: give at least two of each class")
        self.scale_ = SensorScale.of(presses)
        remarks = self.scale_.remarks_on(presses, "the others")
        presses = of_one_sensor(presses, levels_count=self._levels_count)
        self.n_features_in_ = sum(rows * cols for rows, cols in presses[0].shapes.values())
        return presses, checked_targets(labels), remarks

    def _asked(self, X: Any) -> list[Press]:
        check_is_fitted(self)
        check_presses(X)
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
        if training.unheld:
            remarks.append(
                f"{training.unheld}: no session was held out, and on another day answers may be worse than they claim"
            )
        if self.loss_ > _GUESSED * math.log(len(self.classes_)):
            remarks.append(
                "held-out presses are told no better than by guessing: look whether labels stand beside the right "
                "presses, and whether these show what is pressed"
            )
        counts = np.bincount(training.codes)
        if counts.min() < _SELDOM * counts.max():
            seldom, often = (str(self.classes_[k]) for k in (counts.argmin(), counts.argmax()))
            remarks.append(
                f"{seldom!r} was pressed {counts.min()} times, {often!r} {counts.max()} times: "
                "what was pressed seldom is refused more often, and answers near it promise less; press it more often"
            )
        if len(training.presses) < 1 / self.error - 1:
            remarks.append(
                f"{counted(len(training.presses), 'press is', 'presses are')} too few "
                f"to refuse anything at an error of {self.error:g}: "
                f"give {int(np.ceil(1 / self.error - 1))} or more"
            )
        return tuple(remarks)


def equal_rows(rows: Floats, known: Floats) -> NDArray[np.bool_]:
    """Tell which rows are one of those known, to single precision, shape (n_rows,)."""
    near = 1e-5 * np.maximum(np.abs(known).max(axis=1, initial=0.0), 1.0)
    return np.array(
        [bool((np.abs(known - row).max(axis=1, initial=0.0) <= near).any()) for row in rows], dtype=np.bool_
    )
