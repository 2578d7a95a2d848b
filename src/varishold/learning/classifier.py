"""The classifier of presses and grasps: recordings or frames in, a label out, how sure, and why."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.grasp.estimator import (
    BaseEstimator,
    ClassifierMixin,
    check_classification_targets,
    check_is_fitted,
    validate_data,
)
from varishold.learning.adaptation import estimate_drift
from varishold.learning.explanation import deciding_measures, nearest_landmark
from varishold.learning.recognition import Recognition
from varishold.learning.sources import Learned, learn, with_class
from varishold.touch.course.measures import MeasureSettings, learn_settings, measure_names, measure_presses
from varishold.touch.course.presses import (
    Press,
    as_presses,
    check_same_pads,
    drifted,
    flat_presses,
    is_flat,
    pads_in_words,
    values_of,
)
from varishold.trust import conformal_p_value, group_folds, kept_together, same_partition

__all__ = ["NUMBERS", "TOUCH", "TactileClassifier"]

Floats = NDArray[np.float64]

#: The sources: what the pads feel, and the angles, switches and forces beside them.
TOUCH, NUMBERS = "touch", "numbers"
_LEAST_ALTERNATIVE = 0.01
_MOST_MEASURES = 5
# Copies of every press that have drifted, each in its own way.
_COPIES = 5
# What is learned without place or load lies up to so many taxels elsewhere there, and is pressed so much less.
_ELSEWHERE, _LIGHTER = 2, 0.4


class TactileClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """Learn your own surfaces and objects from a few presses or grasps of each, and recognize them.

    A press is a `Recording`, an array of frames, or a pair (frames, time_s). It is measured by the shapes of its
    sections at shares of its own peak, pooled over the frames that hold most of the load, and by its course up to the
    largest load. A kernel discriminant learns from these; its settings are chosen, its probabilities calibrated, and
    what is refused as "none of these" is set, on presses that were held out: whole groups where `groups` are given,
    otherwise blocks of neighbours in time.

    Parameters
    ----------
    shape : (rows, cols) or (pads, rows, cols), optional
        What a flat frame holds; only for X of two dimensions. Default: the squarest grid.
    position : bool or None, default None
        Whether to learn where on the pads a thing is felt. None: with groups, what does better on groups held out;
        without, yes for the several pads of a hand, which hold a thing between them, and no for one pad, on which a
        thing may lie anywhere.
    absolute : bool or None, default None
        Whether to learn how hard it is pressed. None: as for `position`.
    error : float, default 0.05
        Share of presses of known things that are refused as none of these.
    drift : float, default 0.1
        By what share the taxels' gains may drift until tomorrow. Copies of the presses that have drifted so far, and
        lie elsewhere and are pressed less where place or load are not learned, are learned too; without sessions
        probabilities are calibrated on held-out copies. 0 learns no copies.
    folds : int, default 5
        Folds of the cross-validation inside the training presses.

    Attributes
    ----------
    classes_ : ndarray of shape (n_classes,)
    settings_ : MeasureSettings
        The pads, and what measuring them learned.
    learned_ : Learned
        What was learned from each source, the calibration, and how strange known presses are.
    measure_names_ : tuple of str
        Name of each number that touch is measured by.
    columns_ : tuple of str
        Angles, switches and forces that are learned beside touch.
    places_ : ndarray of shape (n_landmarks,), str
        Where the training presses stand that answers are compared with.
    remarks_ : tuple of str
        What a reader should know, in words.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.solids import Cone, SquarePillar, ideal_frame
    >>> rng = np.random.default_rng(0)
    >>> frames = [ideal_frame(s, (12, 12), 1.0) + rng.normal(0, 0.05, (12, 12))
    ...           for s in (Cone(8.0, 4.0), SquarePillar(6.0, 4.0)) for _ in range(10)]
    >>> label = np.repeat(["cone", "pillar"], 10)
    >>> clf = TactileClassifier().fit(np.array(frames), label)
    >>> print(*clf.predict(np.array(frames)[[0, 12]]))
    cone pillar
    """

    places_: NDArray[np.str_]
    #: From how many unlabelled presses of another session `adapt` has estimated its drift.
    adapted_to_: int = 0

    def __init__(
        self,
        shape: tuple[int, ...] | None = None,
        *,
        position: bool | None = None,
        absolute: bool | None = None,
        error: float = 0.05,
        drift: float = 0.1,
        folds: int = 5,
    ) -> None:
        self.shape = shape
        self.position = position
        self.absolute = absolute
        self.error = error
        self.drift = drift
        self.folds = folds

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.three_d_array = True
        # Shapes of sections say nothing of points in a plane, which scikit-learn's own checks would have learned.
        tags.classifier_tags.poor_score = True
        return tags

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
            Labels, in the order of recording; at least two different ones, each at least twice.
        groups : array_like of shape (n,), optional
            The session of each press, or whatever else is new tomorrow.
        tick : callable
            Called as the work goes on, for a progress bar.

        Raises
        ------
        InputError
            Saying what is wrong with which press or label, and what to do.
        """
        from threadpoolctl import threadpool_limits

        self._check_options()
        presses, labels = self._training(X, y)
        self.classes_, codes = np.unique(labels, return_inverse=True)
        if len(self.classes_) < 2:
            raise InputError(
                f"y must hold at least two classes to tell apart, got 1 class: {str(self.classes_[0])!r}; "
                "give presses of something else too"
            )
        named = None if groups is None else np.asarray(groups)
        if named is not None and same_partition(named, codes):
            raise InputError("groups are the labels themselves: nothing would be left to learn a held-out label from")
        fold = group_folds(labels, named, folds=self.folds)
        sessions = named is not None and kept_together(fold, named)
        all_codes, all_folds = (np.tile(of, 1 + self._copies()) for of in (codes, fold))
        # Where sessions are known they show how things drift; otherwise the copies do.
        asked = (np.arange(len(all_codes)) >= len(codes)) != (sessions or self._copies() == 0)
        self.columns_ = tuple(sorted({name for press in presses for name in press.columns}))
        best: tuple[MeasureSettings, Learned, NDArray[np.intp]] | None = None
        # Many small products: threads cost more than they bring, and their number may change the last digit.
        with threadpool_limits(1):
            for position, absolute in self._variants(presses, sessions):
                settings = learn_settings(presses, position=position, absolute=absolute)
                copies = self._drifted(presses, settings)
                measures = self._measures([*presses, *copies], settings)
                found, rows = learn(measures, all_codes, len(self.classes_), all_folds, asked=asked, tick=tick)
                if best is None or found.loss < best[1].loss:
                    best = settings, found, rows
        assert best is not None
        self.settings_, self.learned_, landmarks = best
        self.adapted_to_ = 0
        self.measure_names_ = tuple(measure_names(self.settings_))
        self.places_ = np.array([presses[k % len(presses)].place for k in landmarks])
        self.remarks_ = self._remarks(len(presses), sessions, named is not None)
        return self

    def predict(self, X: Any) -> NDArray[Any]:
        """Answer the likeliest class of every press, shape (n,)."""
        likeliest = self.predict_proba(X).argmax(axis=1)
        return np.asarray(self.classes_[likeliest])

    def predict_proba(self, X: Any) -> Floats:
        """Return the probability of each class of `classes_` for every press, shape (n, n_classes).

        Calibrated on held-out presses. Where a press is as strange as what is refused, drawn towards an even share.
        """
        return self.judge(X)[0]

    def p_values(self, X: Any) -> Floats:
        """Return how rare it is that a press of something known is as strange, shape (n,)."""
        return self.judge(X)[1]

    def judge(self, X: Any) -> tuple[Floats, Floats]:
        """Return `predict_proba` and `p_values` of presses that are measured once."""
        return self._judged(self._asked(X))[:2]

    def explain(self, X: Any) -> list[Recognition]:
        """Return every press's answer, how far it may be believed, which measures decided, and the nearest press."""
        presses = self._asked(X)
        probabilities, p_values, scaled = self._judged(presses)
        return [
            self._recognition(press, probabilities[k], float(p_values[k]), {n: s[k : k + 1] for n, s in scaled.items()})
            for k, press in enumerate(presses)
        ]

    def refused(self, X: Any) -> NDArray[np.bool_]:
        """Tell which presses look like none of the classes, shape (n,)."""
        return np.asarray(self.p_values(X) <= self.error)

    def add(self, label: Any, X: Any) -> Self:
        """Add a class from presses of it; settings and calibration stay, and nothing else is learned again.

        Parameters
        ----------
        label : object
            A label that is not known yet.
        X : sequence of presses
            At least two, as in `fit`.

        Raises
        ------
        InputError
            If the label is known, or there are too few presses.
        """
        presses = self._asked(X)
        if label in self.classes_.tolist():
            raise InputError(f"{label!r} is known already; choose another label, or learn everything again")
        if len(presses) < 2:
            raise InputError(f"{label!r} has one press only: give at least two")
        classes = np.append(self.classes_, np.array([label]))
        order = np.argsort(classes, kind="stable")
        place = int(np.flatnonzero(order == len(self.classes_))[0])
        measures = self._measures(presses, self.settings_)
        self.learned_, landmarks = with_class(self.learned_, self.learned_.scaled(measures), place)
        self.classes_ = classes[order]
        self.places_ = np.append(self.places_, [press.place for press in presses])[landmarks]
        return self

    def adapt(self, X: Any) -> Self:
        """Return a copy that answers for another session, whose drift is estimated from presses without labels.

        One shift of each measure, common to all things, is found: a hand that sits elsewhere, another load, an aged
        sensor. Presses that are like nothing known hardly count. Settings and calibration stay.

        Parameters
        ----------
        X : sequence of presses
            Of the new session, of several of the known things, as in `predict`; those to be answered may be among them.

        Raises
        ------
        InputError
            If too few presses are like anything known, or all are of one thing.
        """
        presses = self._asked(X)
        fresh = replace(self.learned_, drift={})
        drift = estimate_drift(fresh, self._measures(presses, self.settings_), self.error)
        adapted = copy(self)
        adapted.learned_ = replace(fresh, drift=drift)
        adapted.adapted_to_ = len(presses)
        return adapted

    def _check_options(self) -> None:
        if not 0 < self.error < 1:
            raise InputError(f"error must lie between 0 and 1, got {self.error!r}")
        if not 0 <= self.drift < 1:
            raise InputError(f"drift must be at least 0 and below 1, got {self.drift!r}")
        if isinstance(self.folds, bool) or not isinstance(self.folds, (int, np.integer)) or self.folds < 2:
            raise InputError(f"folds must be a whole number, at least 2, got {self.folds!r}")

    def _drifted(self, presses: Sequence[Press], settings: MeasureSettings) -> list[Press]:
        """Return copies of presses as they might be on another day."""
        elsewhere = 0 if settings.position else _ELSEWHERE
        lighter = 0.0 if settings.absolute else _LIGHTER
        return [
            drifted(press, self.drift, (copy, k), elsewhere=elsewhere, lighter=lighter)
            for copy in range(self._copies())
            for k, press in enumerate(presses)
        ]

    def _copies(self) -> int:
        return _COPIES if self.drift > 0 else 0

    def _training(self, X: Any, y: ArrayLike) -> tuple[list[Press], NDArray[Any]]:
        if is_flat(X):
            flat, labels = validate_data(self, X, y, dtype=np.float64, ensure_min_samples=1)
            check_classification_targets(labels)
            return flat_presses(flat, self.shape), np.asarray(labels)
        labels = np.asarray(y)
        if labels.dtype.kind == "O" and all(isinstance(label, str) for label in labels.ravel()):
            labels = labels.astype(np.str_)
        presses = as_presses(X)
        if labels.shape != (len(presses),):
            raise InputError(f"y must be one label a press, {len(presses)} of them, got shape {labels.shape}")
        if not presses:
            raise InputError("there is no press: give at least two of each class")
        check_classification_targets(labels)
        check_same_pads(presses)
        self.n_features_in_ = sum(rows * cols for rows, cols in presses[0].shapes.values())
        return presses, labels

    def _asked(self, X: Any) -> list[Press]:
        check_is_fitted(self)
        if is_flat(X):
            presses = flat_presses(validate_data(self, X, dtype=np.float64, reset=False), self.shape)
        else:
            presses = as_presses(X)
        if not presses:
            raise InputError("there is no press: give at least one")
        for press in presses:
            self._check_pads(press)
        return presses

    def _check_pads(self, press: Press) -> None:
        known = self.settings_.shapes
        for name, shape in press.shapes.items():
            if known.get(name) != shape:
                raise InputError(
                    f"{press.place}: has a pad {name!r} of {shape[0]} x {shape[1]} taxels; the model is of another "
                    f"sensor: {pads_in_words(known)}; learn from recordings of this one"
                )

    def _variants(self, presses: Sequence[Press], sessions: bool) -> list[tuple[bool, bool]]:
        """Return which (position, absolute) are to be tried."""
        several = max(len(press.pads) for press in presses) > 1
        undecided = (True, False) if sessions else (several,)
        ways = [undecided if given is None else (bool(given),) for given in (self.position, self.absolute)]
        return [(position, absolute) for position in ways[0] for absolute in ways[1]]

    def _measures(self, presses: Sequence[Press], settings: MeasureSettings) -> dict[str, Floats]:
        found = {TOUCH: measure_presses(presses, settings)}
        if self.columns_:
            found[NUMBERS] = values_of(presses, self.columns_)
        return found

    def _remarks(self, n_presses: int, sessions: bool, grouped: bool) -> tuple[str, ...]:
        remarks: list[str] = []
        if not sessions:
            why = "some thing was felt in one session only" if grouped else "no sessions are known"
            remarks.append(f"{why}: no session was held out, and on another day answers may be worse than they claim")
        if n_presses < 1 / self.error - 1:
            remarks.append(
                f"{n_presses} presses are too few to refuse anything at an error of {self.error:g}: "
                f"give {int(np.ceil(1 / self.error - 1))} or more"
            )
        return tuple(remarks)

    def _judged(self, presses: Sequence[Press]) -> tuple[Floats, Floats, dict[str, Floats]]:
        """Return probabilities, p-values, and the standardized measures of each source."""
        measures = self._measures(presses, self.settings_)
        scaled = self.learned_.scaled(measures)
        log_probabilities, strangeness = self.learned_.judge(scaled)
        p_values = conformal_p_value(strangeness, self.learned_.known)
        plain = np.exp(log_probabilities)
        believed = np.minimum(p_values / self.error, 1.0)[:, None] ** 2
        return believed * plain + (1 - believed) / len(self.classes_), p_values, scaled

    def _recognition(
        self, press: Press, probabilities: Floats, p_value: float, scaled: Mapping[str, Floats]
    ) -> Recognition:
        order = np.argsort(-probabilities, kind="stable")
        first, second = int(order[0]), int(order[1])
        near = nearest_landmark(self.learned_.sources[TOUCH], scaled[TOUCH])
        names = {TOUCH: self.measure_names_, NUMBERS: self.columns_}
        others = {
            self.classes_[k]: float(probabilities[k]) for k in order[1:] if probabilities[k] >= _LEAST_ALTERNATIVE
        }
        return Recognition(
            label=self.classes_[first],
            probability=float(probabilities[first]),
            alternatives=others,
            p_value=p_value,
            refused=p_value <= self.error,
            measures=tuple(deciding_measures(self.learned_, scaled, names, first, second)[:_MOST_MEASURES]),
            nearest=str(self.places_[near]),
            nearest_label=self.classes_[self.learned_.landmark_codes[near]],
            place=press.place,
            adapted_to=self.adapted_to_,
        )
