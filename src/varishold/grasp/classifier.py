"""The classifier of grasps: switch patterns in, an object's name out, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.circuit import Netlist
from varishold.errors import InputError
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.estimator import (
    BaseEstimator,
    ClassifierMixin,
    check_classification_targets,
    check_is_fitted,
    validate_data,
)
from varishold.grasp.explanation import Explanation, explain_pattern
from varishold.grasp.hyperplanes import Hyperplanes
from varishold.grasp.likelihood import GraspLikelihood, learn_likelihood
from varishold.grasp.modes import MODES, Learned, ModeOptions
from varishold.grasp.modes.learned import class_names
from varishold.grasp.selection import choose_mode, remark_on_noise
from varishold.grasp.sign_table import MinimalTable, SignTable, minimal_table, reduced_table
from varishold.grasp.training import TrainingGrasps, training_grasps

__all__ = ["HyperplaneClassifier"]

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
        Values above it are on. None refuses anything but 0 and 1.
    max_hyperplanes : int or None, default None
        Most hyperplanes to use (``robust``, ``vote``); None leaves it to the mode.
    flip_rate : float, default 0.15
        How often ``robust`` expects a switch to read wrongly.
    variants : array-like of int of shape (n_variants, n_switches) or None, default None
        Every training grasp is also learned as it would read when switch k said what switch
        ``variants[m][k]`` says (-1: nothing, off): a tolerance of shifts, as `shift_variants` makes it.
    time_limit_s : float, default 10.0
        Seconds that the integer program of ``paper`` may take; with 0 the set is greedy.
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
        random_state: int = 0,
    ) -> None:
        self.mode = mode
        self.binarize = binarize
        self.max_hyperplanes = max_hyperplanes
        self.flip_rate = flip_rate
        self.variants = variants
        self.time_limit_s = time_limit_s
        self.random_state = random_state

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        # A switch tells one threshold only; scikit-learn's own checks measure lengths.
        tags.classifier_tags.poor_score = True
        return tags

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Learn from grasps.

        Parameters
        ----------
        X : array-like of shape (n_grasps, n_switches)
            0 and 1, or numbers if `binarize` is given.
        y : array-like of shape (n_grasps,)
            Class labels; at least two different ones.

        Raises
        ------
        InputError
            Naming the place where a value is no switch, or that there is one class only.
        """
        X, y = validate_data(self, X, y, dtype=None, ensure_min_samples=1)
        X = np.asarray(X)
        check_classification_targets(y)
        patterns = self._switches(X)
        labels, codes = np.unique(y, return_inverse=True)
        if len(labels) < 2:
            raise InputError(f"y must hold at least two classes to tell apart, got 1 class: {labels[0]!r}")
        self._check_options()
        self.classes_ = labels
        self._learn(patterns, np.asarray(codes, dtype=np.int64), keep=None)
        return self

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Answer the class of every grasp, shape (n_grasps,)."""
        answers = self._answers(self._checked(X))
        return np.asarray(self.classes_[answers])

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:
        """Probability of every class, shape (n_grasps, n_classes).

        The circuit decides; the training grasps say how surely: P(class) from the distances to them, under
        a rate of wrong switches learned from themselves. Where these would rather name another class, the
        circuit's answer gets as much as theirs.
        """
        patterns = self._checked(X)
        return self._posterior(patterns, self._answers(patterns))

    def predict_or_reject(
        self, X: ArrayLike, *, min_probability: float = 0.0
    ) -> tuple[NDArray[Any], NDArray[np.bool_]]:
        """Answer, and say where the answer should not be used.

        Returns
        -------
        labels : ndarray of shape (n_grasps,)
            As `predict`.
        rejected : ndarray of shape (n_grasps,), bool
            True where the pattern differs from every training grasp in more switches than 98 % of the
            training grasps differ from their nearest fellow of the same class, so that it looks like no
            object that was learned; or where the answer's probability is below `min_probability`.
        """
        patterns = self._checked(X)
        answers = self._answers(patterns)
        _, distance = self._likelihood.nearest(patterns)
        rejected = distance > self._likelihood.reach
        if min_probability > 0:
            sure = self._posterior(patterns, answers)[np.arange(len(answers)), answers]
            rejected = rejected | (sure < min_probability)
        return np.asarray(self.classes_[answers]), np.asarray(rejected, dtype=np.bool_)

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
        patterns = self._checked(np.asarray(v).reshape(1, -1))
        index, distance = self._likelihood.nearest(patterns)
        nearest = None
        if len(self.grasps_):
            k = int(index[0])
            label = self.classes_[self._class_of[int(self.grasps_.labels[k])]]
            nearest = (int(self.grasps_.numbers[k]), label, int(distance[0]))
        return explain_pattern(
            self._circuit,
            self.hyperplanes_,
            patterns[0],
            labels=[self.classes_[k] for k in self._class_of],
            nearest=nearest,
        )

    def add_class(self, X: ArrayLike, label: Any) -> Self:
        """Learn one more class (or more grasps of a known one), keeping the hyperplanes that there are.

        Parameters
        ----------
        X : array-like of shape (n_grasps, n_switches)
        label : object
            Its name, of the same kind as the others.
        """
        patterns = self._checked(X)
        old_labels = self.classes_[self._codes]
        labels, codes = np.unique(np.concatenate([old_labels, np.full(len(patterns), label)]), return_inverse=True)
        self.classes_ = labels
        rows = np.concatenate([self._rows, patterns])
        self._learn(rows, np.asarray(codes, dtype=np.int64), keep=self.hyperplanes_)
        return self

    @property
    def sign_table_(self) -> SignTable:
        """Signs of all training grasps, but contradictory ones, on the chosen hyperplanes (Table 2)."""
        check_is_fitted(self)
        left_out = {v for rows in self.grasps_.contradictions for v in rows}
        rows = [k for k in range(len(self._rows)) if k + 1 not in left_out]
        return SignTable(
            self.hyperplanes_.signs(self._rows[rows]),
            tuple(self.classes_[self._codes[rows]].tolist()),
            self.hyperplanes_.names,
            tuple(k + 1 for k in rows),
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
        remarks = []
        for rows in self.grasps_.contradictions:
            remarks.append(f"grasps {_listed(rows)} have equal patterns but different labels")
        if self.grasps_.duplicates:
            more = sum(len(rows) - 1 for rows in self.grasps_.duplicates)
            remarks.append(f"{more} grasps repeat the pattern and label of an earlier one")
        learned = {int(k) for k in self.grasps_.labels}
        for k, label in enumerate(self.grasps_.classes):
            if k not in learned:
                remarks.append(f"nothing tells {label}: all its grasps contradict others")
        if self.selection_ is not None and self.selection_.gap:
            remarks.append(str(self.selection_))
        if self._on_noise is not None:
            remarks.append(self._on_noise)
        return tuple(remarks)

    def _check_options(self) -> None:
        if self.mode not in ("auto", *MODES):
            raise InputError(f"mode must be auto, {', '.join(MODES)}, got {self.mode!r}")
        if not 0 <= self.flip_rate < 0.5:
            raise InputError(f"flip_rate must be at least 0 and below 0.5, got {self.flip_rate!r}")
        if self.max_hyperplanes is not None and self.max_hyperplanes < 1:
            raise InputError(f"max_hyperplanes must be positive or None, got {self.max_hyperplanes!r}")

    def _learn(self, rows: NDArray[np.bool_], codes: NDArray[np.int64], keep: Hyperplanes | None) -> None:
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
        self._adopt(rows, codes, grasps, mode, MODES[mode](taught, options))
        self._on_noise: str | None = remark_on_noise(self._circuit, self._likelihood, mode)

    def _adopt(
        self,
        rows: NDArray[np.bool_],
        codes: NDArray[np.int64],
        grasps: TrainingGrasps,
        mode: str,
        learned: Learned,
    ) -> None:
        """Take over what was learned; a model file comes back the same way."""
        self.mode_ = mode
        self._class_of = np.array(grasps.classes, dtype=np.int64)
        self.grasps_ = replace(grasps, classes=tuple(self.classes_[k] for k in self._class_of))
        self._rows, self._codes = rows, codes
        self.hyperplanes_ = learned.hyperplanes
        self.netlist_: Netlist = replace(learned.netlist, classes=tuple(class_names(self.grasps_.classes)))
        self.selection_ = learned.selection
        self.notes_: Mapping[str, str] = dict(learned.notes)
        self._circuit = CompiledCircuit(self.netlist_)
        self._on_noise = None
        self._likelihood: GraspLikelihood = learn_likelihood(
            grasps.patterns, grasps.labels, grasps.weights, grasps.n_classes
        )

    def _checked(self, X: ArrayLike) -> NDArray[np.bool_]:
        check_is_fitted(self)
        return self._switches(validate_data(self, X, dtype=None, reset=False))

    def _switches(self, X: NDArray[Any]) -> NDArray[np.bool_]:
        if X.dtype == np.bool_:
            return np.asarray(X, dtype=np.bool_)
        if X.dtype.kind not in "iuf":
            try:
                X = X.astype(np.float64)
            except (TypeError, ValueError) as error:
                raise type(error)(f"switches must be numbers 0 and 1, got dtype {X.dtype}: {error}") from error
        if self.binarize is not None:
            return np.asarray(self.binarize < X, dtype=np.bool_)
        on = X == 1
        strange = ~(on | (X == 0))
        if strange.any():
            row, column = np.argwhere(strange)[0]
            raise InputError(
                f"switches must be 0 or 1, got {X[row, column]} at (grasp, switch) = ({row}, {column}); "
                "put ThresholdEncoder before the classifier, or set binarize"
            )
        return np.asarray(on, dtype=np.bool_)

    def _answers(self, patterns: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Indices into `classes_`."""
        return np.asarray(self._class_of[self._circuit.evaluate(patterns)], dtype=np.int64)

    def _posterior(self, patterns: NDArray[np.bool_], answers: NDArray[np.int64]) -> NDArray[np.float64]:
        mass = np.zeros((len(patterns), len(self.classes_)))
        mass[:, self._class_of] = self._likelihood.posterior(patterns)
        rows = np.arange(len(patterns))
        # A hair above the largest, so that the most probable class is the one answered.
        mass[rows, answers] = np.maximum(mass[rows, answers], mass.max(axis=1) * (1 + 1e-9))
        return np.asarray(mass / mass.sum(axis=1, keepdims=True), dtype=np.float64)


def with_variants(
    grasps: TrainingGrasps, options: ModeOptions, variants: ArrayLike | None
) -> tuple[TrainingGrasps, ModeOptions]:
    """Add to the training grasps what each would read in every variant; copies remember their grasp."""
    if variants is None:
        return grasps, options
    maps = np.asarray(variants)
    r = grasps.n_switches
    if maps.ndim != 2 or maps.shape[1] != r or maps.dtype.kind not in "iu" or (maps < -1).any() or (maps >= r).any():
        raise InputError(
            f"variants must be integers from -1 to {r - 1} of shape (n_variants, {r}), "
            f"got shape {maps.shape} and dtype {maps.dtype}"
        )
    padded = np.column_stack([grasps.patterns, np.zeros(len(grasps), dtype=np.bool_)])
    patterns = np.concatenate([grasps.patterns, *(padded[:, row] for row in maps)])
    origin = np.tile(np.arange(len(grasps)), len(maps) + 1)
    distinct, first = np.unique(patterns, axis=0, return_index=True)
    owner = origin[first]
    taught = replace(
        grasps,
        patterns=distinct,
        labels=grasps.labels[owner],
        weights=grasps.weights[owner],
        numbers=grasps.numbers[owner],
    )
    return taught, replace(options, groups=tuple(owner.tolist()))


def _listed(rows: tuple[int, ...]) -> str:
    shown = ", ".join(map(str, rows[:6]))
    return shown if len(rows) <= 6 else f"{shown} and {len(rows) - 6} more"
