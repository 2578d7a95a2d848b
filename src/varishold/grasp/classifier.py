"""The classifier of grasps: switch patterns in, an object's name out, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._counted import counted
from varishold.circuit import Netlist
from varishold.errors import InputError, require
from varishold.frame.checks import as_given, is_number
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.estimator import (
    BaseEstimator,
    ClassifierMixin,
    check_classification_targets,
    check_is_fitted,
    few_of_each_class,
    validate_data,
)
from varishold.grasp.explanation import Explanation, explain_pattern
from varishold.grasp.held_out import beyond_of
from varishold.grasp.hyperplanes import Hyperplanes
from varishold.grasp.likelihood import GraspLikelihood, learn_likelihood, nearest_pattern
from varishold.grasp.modes import MODES, Learned, ModeOptions
from varishold.grasp.modes.learned import class_names
from varishold.grasp.selection import choose_mode, remark_on_noise
from varishold.grasp.sign_table import MinimalTable, SignTable, minimal_table, reduced_table
from varishold.grasp.training import TrainingGrasps, training_grasps
from varishold.grasp.unknown import fill, judge
from varishold.grasp.variants import with_variants
from varishold.trust import least_error, widened

__all__ = ["HyperplaneClassifier"]

# No table of weights has more columns.
_MOST_HYPERPLANES = 1 << 31

Mode = Literal["auto", "paper", "robust", "vote"]


class HyperplaneClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """Classify on-off patterns by hyperplanes between training grasps and a small logic circuit.

    Parameters
    ----------
    mode : {"auto", "paper", "robust", "vote"}, default "auto"
        ``paper``: the fewest bisectors that separate all training grasps, as a two-level circuit.
        ``robust``: product terms over few bisectors that bear wrongly read switches. ``vote``: many small
        bisectors with integer weights. ``auto``: of the modes that are as good as ``vote`` in a
        cross-validation on 100 training grasps or more, the one with the smallest circuit.
    binarize : float or None, default None
        Values above it are on. None refuses anything but 0 and 1, and so the real numbers that scikit-learn's
        `check_estimator` tries: with a threshold it passes.
    max_hyperplanes : int or None, default None
        Most hyperplanes to use (``robust``, ``vote``); None leaves it to the mode.
    flip_rate : float, default 0.15
        How often ``robust`` expects a switch to read wrongly.
    variants : array-like of int of shape (n_variants, n_switches) or None, default None
        Every training grasp is also learned as it would read when switch k said what switch
        ``variants[m][k]`` says (-1: nothing, off): a tolerance of shifts, as `shift_variants` makes it.
    time_limit_s : float, default 10.0
        Seconds that the integer program of ``paper`` may take, its relaxation included; with 0 the set is greedy.
    error : float, default 0.05
        Share of grasps of known objects that are rejected, as if they were outside of what was learned.
    random_state : int, default 0
        Seed of everything that is drawn.

    Attributes
    ----------
    classes_ : ndarray of shape (n_classes,)
    mode_ : str
        The mode in use.
    hyperplanes_ : Hyperplanes
        Prints as Table 1.
    sign_table_, reduced_table_ : SignTable
        Print as Tables 2 and 3.
    minimal_table_ : MinimalTable
        Prints as Table 4.
    selection_ : Selection or None
        What is proved about the number of hyperplanes (``paper``).
    netlist_ : Netlist
        The circuit, over the switches x1 ... xr.
    grasps_ : TrainingGrasps
        What was learned from; names duplicates and contradictions.

    Examples
    --------
    >>> X = [[1, 1, 0, 0], [1, 1, 1, 0], [0, 0, 1, 1], [0, 1, 1, 1]]
    >>> clf = HyperplaneClassifier(mode="paper").fit(X, ["cylinder", "cylinder", "pillar", "pillar"])
    >>> print(clf.predict([[1, 1, 0, 1]])[0])
    cylinder
    """

    def __init__(
        self,
        mode: Mode = "auto",
        binarize: float | None = None,
        *,
        max_hyperplanes: int | None = None,
        flip_rate: float = 0.15,
        variants: ArrayLike | None = None,
        time_limit_s: float = 10.0,
        error: float = 0.05,
        random_state: int = 0,
    ) -> None:
        self.mode = mode
        self.binarize = binarize
        self.max_hyperplanes = max_hyperplanes
        self.flip_rate = flip_rate
        self.variants = variants
        self.time_limit_s = time_limit_s
        self.error = error
        self.random_state = random_state

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        # A switch tells one threshold only; scikit-learn's own checks measure lengths.
        tags.classifier_tags.poor_score = True
        return tags

    def fit(self, X: ArrayLike, y: ArrayLike, groups: ArrayLike | None = None) -> Self:
        """Learn from grasps.

        Parameters
        ----------
        X : array-like of shape (n_grasps, n_switches)
            0 and 1, or numbers if `binarize` is given.
        y : array-like of shape (n_grasps,)
            Class labels; at least two different ones.
        groups : array-like of shape (n_grasps,), optional
            The session of each grasp, or the piece of its object: probabilities and what is rejected are calibrated
            on grasps whose whole group is held out. Default: every grasp is held out alone.

        Raises
        ------
        InputError
            Naming the place where a value is no switch, or that there is one class only, or not one group a grasp.
        """
        X, y = validate_data(self, X, y, dtype=None, ensure_min_samples=1)
        X = np.asarray(X)
        with few_of_each_class():
            check_classification_targets(y)
        patterns, _ = self._switches(X)
        labels, codes = np.unique(y, return_inverse=True)
        require(len(labels) > 1, f"y must hold at least two classes to tell apart, got 1 class: {labels.tolist()[0]!r}")
        self._check_options()
        n = len(patterns)
        must = f"groups must be one a grasp, {n} of them"
        named = np.arange(n) if groups is None else as_given(groups, must)
        require(named.shape == (n,), f"{must}, got shape {named.shape}")
        try:
            _, together = np.unique(named, return_inverse=True)
        except TypeError as error:
            raise InputError(f"{must}, all names or all numbers: {error}") from None
        self._learn(patterns, labels, codes, together, np.zeros(n), keep=None)
        return self

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Answer the class of every grasp, shape (n_grasps,)."""
        patterns, _ = self._checked(X)
        return np.asarray(self.classes_[self._answers(patterns)])

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:
        """Probability of every class, shape (n_grasps, n_classes).

        The circuit decides; the training grasps say how surely: P(class) from the distances to them, under
        a rate of wrong switches learned from grasps that were held out. Where these would rather name another class,
        the circuit's answer gets as much as theirs. Outside of what was learned it is drawn towards an even share:
        no probability is above .9 there, and nowhere if no class was learned from two groups.
        """
        return self._judged(*self._checked(X))[1]

    def judge(
        self, X: ArrayLike, *, beyond: ArrayLike = 0.0
    ) -> tuple[NDArray[Any], NDArray[np.float64], NDArray[np.float64]]:
        """Answer grasps of which something may be unknown or beyond what was learned.

        Parameters
        ----------
        X : array-like of shape (n_grasps, n_switches)
            NaN where a switch is unknown. The circuit, which has no unknown inputs, is given what the switch read in
            the training grasp that is nearest by the others.
        beyond : array-like of shape (n_grasps,), default 0
            How far each grasp's readings lay beyond those learned before they were cut, in switches
            (`ThresholdEncoder.beyond`).

        Returns
        -------
        labels : ndarray of shape (n_grasps,)
            As `predict`.
        probabilities : ndarray of shape (n_grasps, n_classes), float64
            As `predict_proba`.
        p_values : ndarray of shape (n_grasps,), float64
            How rare it is that a grasp of something known is as strange: as unlikely under all classes alike, by the
            switches that are not unknown.
        """
        patterns, unknown = self._checked(X, finite="allow-nan")
        answers, probabilities, p_values = self._judged(patterns, unknown, beyond_of(beyond, len(patterns)))
        return np.asarray(self.classes_[answers]), probabilities, p_values

    def predict_or_reject(
        self, X: ArrayLike, *, min_probability: float = 0.0
    ) -> tuple[NDArray[Any], NDArray[np.bool_]]:
        """Answer, and say where the answer should not be used.

        Returns
        -------
        labels : ndarray of shape (n_grasps,)
            As `predict`.
        rejected : ndarray of shape (n_grasps,), bool
            True where the pattern looks like no object that was learned: its p-value is at most `error`, or, where
            there are too few training grasps for that, it is stranger than all of them; or where the answer's
            probability is below `min_probability`.
        """
        limit = min_probability
        require(is_number(limit) and np.isfinite(limit), f"min_probability must be a number, got {limit!r}")
        labels, probabilities, p_values = self.judge(X)
        return labels, self.outside(p_values) | (probabilities.max(axis=1) < min_probability)

    def outside(self, p_values: ArrayLike) -> NDArray[np.bool_]:
        """Tell which p-values are those of grasps outside of what was learned, shape (n_grasps,)."""
        check_is_fitted(self)
        return np.asarray(np.asarray(p_values) <= self._limit)

    @property
    def _limit(self) -> float:
        return least_error(self.error, self._likelihood.n_known)

    def explain(self, v: ArrayLike) -> Explanation:
        """Say why one grasp is answered as it is.

        Parameters
        ----------
        v : array-like of shape (n_switches,)

        Returns
        -------
        Explanation
            Prints as a few lines.
        """
        check_is_fitted(self)
        read = as_given(v, f"a grasp must be a row of {counted(self.n_features_in_, 'switch')}")
        patterns, _ = self._checked(read.reshape(1, -1), finite="allow-nan")
        (k,), (distance,) = nearest_pattern(patterns, self.grasps_.patterns)
        nearest = None
        if len(self.grasps_):
            label = self.grasps_.classes[self.grasps_.labels[k]]
            nearest = (int(self.grasps_.numbers[k]), label, int(distance))
        return explain_pattern(
            self._circuit,
            self.hyperplanes_,
            patterns[0],
            labels=self.grasps_.classes,
            nearest=nearest,
        )

    def add_class(self, X: ArrayLike, label: Any, *, beyond: ArrayLike = 0.0) -> Self:
        """Learn one more class (or more grasps of a known one), keeping the hyperplanes that there are.

        Parameters
        ----------
        X : array-like of shape (n_grasps, n_switches)
        label : object
            Its name, of the same kind as the others.
        beyond : array-like of shape (n_grasps,), default 0
            How far each grasp's readings lay beyond those learned before they were cut, in switches
            (`ThresholdEncoder.beyond`). That of the grasps that there are is kept.
        """
        patterns, _ = self._checked(X)
        alike = isinstance(label, str) if isinstance(self.classes_[0], str) else np.asarray(label).dtype.kind in "biuf"
        if np.ndim(label) or not alike or label != label:
            raise InputError(f"label must be one name, of the same kind as {str(self.classes_[0])!r}, got {label!r}")
        old_labels = self.classes_[self._codes]
        labels, codes = np.unique(np.concatenate([old_labels, np.full(len(patterns), label)]), return_inverse=True)
        rows = np.concatenate([self._rows, patterns])
        groups = np.append(self._groups, self._groups.max() + 1 + np.arange(len(patterns)))
        farther = np.concatenate([self._beyond, beyond_of(beyond, len(patterns))])
        self._learn(rows, labels, codes, groups, farther, keep=self.hyperplanes_)
        return self

    @property
    def sign_table_(self) -> SignTable:
        """Signs of all training grasps, but those that contradict what was learned, on the hyperplanes (Table 2)."""
        check_is_fitted(self)
        rows = np.flatnonzero(self.grasps_.owners >= 0)
        return SignTable(
            self.hyperplanes_.signs(self._rows[rows]),
            tuple(self.classes_[self._codes[rows]].tolist()),
            self.hyperplanes_.names,
            tuple((rows + 1).tolist()),
        )

    @property
    def reduced_table_(self) -> SignTable:
        """The sign table with equal rows merged (Table 3)."""
        return reduced_table(self.sign_table_)

    @property
    def minimal_table_(self) -> MinimalTable:
        """The reduced table with don't-cares (Table 4)."""
        return minimal_table(self.sign_table_)

    @property
    def remarks_(self) -> tuple[str, ...]:
        """What the user should know of the training grasps and of what was proved."""
        check_is_fitted(self)
        against = self.grasps_.contradictions
        remarks = [f"grasps {_listed(rows)} have equal patterns but different labels" for rows in against]
        if self.grasps_.duplicates:
            more = sum(len(rows) - 1 for rows in self.grasps_.duplicates)
            remarks.append(f"{counted(more, 'grasp repeats', 'grasps repeat')} the pattern and label of an earlier one")
        untold = [label for k, label in enumerate(self.grasps_.classes) if k not in self.grasps_.labels]
        remarks += [f"nothing tells {label}: all its grasps contradict others" for label in untold]
        if self.selection_ is not None and self.selection_.gap:
            remarks.append(str(self.selection_))
        if not self._likelihood.learned:
            of = "grasps of two groups" if len(np.unique(self._groups)) < len(self._groups) else "two grasps"
            remarks.append(f"no object has {of}, which tell how grasps of one differ: no answer has a p above .9")
        on_noise = remark_on_noise(self._circuit, self.grasps_, self._likelihood.flip_rate, self.mode_)
        return tuple(remarks if on_noise is None else [*remarks, on_noise])

    def _check_options(self) -> None:
        most, flips, error, seed = self.max_hyperplanes, self.flip_rate, self.error, self.random_state
        known = isinstance(self.mode, str) and self.mode in ("auto", *MODES)
        require(known, f"mode must be auto, {', '.join(MODES)}, got {self.mode!r}")
        few = is_number(flips) and 0 <= flips < 0.5
        require(few, f"flip_rate must be at least 0 and below 0.5, got {flips!r}")
        require(is_number(error) and 0 < error < 1, f"error must lie between 0 and 1, got {error!r}")
        counts = isinstance(most, int | np.integer) and 1 <= most <= _MOST_HYPERPLANES
        require(most is None or counts, f"max_hyperplanes must be positive or None, got {most!r}")
        seeds = isinstance(seed, int | np.integer) and seed >= 0
        cut, seconds = self.binarize, self.time_limit_s
        threshold = cut is None or (is_number(cut) and np.isfinite(cut))
        require(threshold, f"binarize must be a number, above which a switch is on, or None, got {cut!r}")
        require(is_number(seconds) and seconds >= 0, f"time_limit_s must be a number from 0 on, got {seconds!r}")
        require(seeds, f"random_state must be a whole number from 0 on, got {seed!r}")

    def _learn(
        self,
        rows: NDArray[np.bool_],
        classes: NDArray[Any],
        codes: NDArray[np.int64],
        groups: NDArray[np.int64],
        beyond: NDArray[np.float64],
        *,
        keep: Hyperplanes | None,
    ) -> None:
        """Learn from all grasps; where that is refused, what was learned before stays whole."""
        grasps = training_grasps(rows, codes.tolist())
        options = ModeOptions(
            keep=keep,
            max_hyperplanes=self.max_hyperplanes,
            flip_rate=self.flip_rate,
            time_limit_s=self.time_limit_s,
            seed=int(self.random_state),
        )
        taught, options = with_variants(grasps, options, self.variants)
        mode = self.mode if self.mode != "auto" else choose_mode(taught, options)
        learned = MODES[mode](taught, options)
        self._rows, self._codes, self._groups, self.classes_ = rows, codes, groups, classes
        self._adopt(grasps, mode, learned)
        self._know(beyond)

    def _adopt(self, grasps: TrainingGrasps, mode: str, learned: Learned) -> None:
        """Take over what was learned of rows, codes, groups and classes; a model file comes back the same way."""
        self.mode_ = mode
        self._class_of = np.array(grasps.classes, dtype=np.int64)
        self.grasps_ = replace(grasps, classes=tuple(self.classes_[k] for k in self._class_of))
        self.hyperplanes_ = learned.hyperplanes
        self.netlist_: Netlist = replace(learned.netlist, classes=tuple(class_names(self.grasps_.classes)))
        self.selection_ = learned.selection
        self.notes_: Mapping[str, str] = dict(learned.notes)
        self._circuit = CompiledCircuit(self.netlist_)

    def _know(self, beyond: NDArray[np.float64]) -> None:
        """Learn how sure answers are, from training grasps that are held out.

        `beyond` of shape (n_grasps,) is how far each lay beyond the others' readings, in switches, before it was cut.
        """
        self._beyond = beyond
        self._likelihood: GraspLikelihood = learn_likelihood(self.grasps_, self._groups, beyond)

    def _checked(
        self, X: ArrayLike, *, finite: bool | Literal["allow-nan"] = True
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return patterns for the circuit, and which of their switches are unknown."""
        check_is_fitted(self)
        patterns, unknown = self._switches(validate_data(self, X, dtype=None, reset=False, ensure_all_finite=finite))
        return fill(patterns, unknown, self._likelihood), unknown

    def _switches(self, X: NDArray[Any]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return which switches are on, and which are unknown."""
        if X.dtype == np.bool_:
            return np.asarray(X, dtype=np.bool_), np.zeros(X.shape, dtype=np.bool_)
        if X.dtype.kind not in "iuf":
            try:
                X = X.astype(np.float64)
            except (TypeError, ValueError) as error:
                raise type(error)(f"switches must be numbers 0 and 1, got dtype {X.dtype}: {error}") from error
        unknown = np.isnan(X)
        if self.binarize is not None:
            return np.asarray(self.binarize < X, dtype=np.bool_), unknown
        on = X == 1
        strange = ~(on | (X == 0) | unknown)
        if strange.any():
            row, column = np.argwhere(strange)[0]
            raise InputError(
                f"switches must be 0 or 1, got {X[row, column]} at (grasp, switch) = ({row}, {column}); "
                "put ThresholdEncoder before the classifier, or set binarize"
            )
        return np.asarray(on, dtype=np.bool_), unknown

    def _answers(self, patterns: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Indices into `classes_`."""
        return np.asarray(self._class_of[self._circuit.evaluate(patterns)], dtype=np.int64)

    def _judged(
        self, patterns: NDArray[np.bool_], unknown: NDArray[np.bool_], beyond: ArrayLike = 0.0
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Return answers (indices into `classes_`), probabilities and p-values."""
        answers, rows = self._answers(patterns), np.arange(len(patterns))
        mass = np.zeros((len(patterns), len(self.classes_)))
        mass[:, self._class_of], p_values = judge(patterns, unknown, beyond, self._likelihood)
        # A hair above the largest, so that the most probable class is the one answered.
        mass[rows, answers] = np.maximum(mass[rows, answers], mass.max(axis=1) * (1 + 1e-9))
        believed = p_values if self._likelihood.learned else np.minimum(p_values, self._limit)
        return answers, widened(mass / mass.sum(axis=1, keepdims=True), believed, self._limit), p_values


def _listed(rows: tuple[int, ...]) -> str:
    shown = ", ".join(map(str, rows[:6]))
    return shown if len(rows) <= 6 else f"{shown} and {len(rows) - 6} more"
