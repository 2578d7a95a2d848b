"""The classifier of presses and grasps: recordings or frames in, a label out, how sure, and why."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.learning.adaptation import estimate_drift
from varishold.learning.another_day import Judged, judge
from varishold.learning.checks import checked_label
from varishold.learning.explanation import deciding_measures, nearest_landmark, outside_measures
from varishold.learning.press_classifier import MOST_MEASURES, PressClassifier, equal_rows
from varishold.learning.sources import FORMS_SHARE, Learned, learn, with_class
from varishold.learning.training import COPIES, Training, copies_of, copies_told
from varishold.touch.course.borne import least_load
from varishold.touch.course.measures import (
    MeasureSettings,
    form_alone,
    learn_settings,
    measure_names,
    measure_presses,
    of_forms,
)
from varishold.touch.course.presses import Press, as_presses, is_flat, values_of, without_copies
from varishold.touch.course.unlike import bear_nothing, made_up, of_another_clock

__all__ = ["NUMBERS", "TOUCH", "TactileClassifier"]

Floats = NDArray[np.float64]

#: The sources: what the pads feel, and the angles, switches and forces beside them.
TOUCH, NUMBERS = "touch", "numbers"

# Above this probability a press is surely of a thing.
_SURE = 0.9
# Fewer presses than these, of all things together, are too few to be sure by: even where all were named rightly when
# they were held out, one answer in twenty may be wrong.
_FEWEST_SURE = 19
# What the times of a press are called among its measures.
_TIME = "time"

_BY_FORMS = (
    "what is refused is judged by forms alone, for where and how hard things are felt may change until another day; "
    "name sessions (groups) to have that learned"
)


class TactileClassifier(PressClassifier):
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
        lie elsewhere, and are pressed less and at another pace, where place or load are not learned, are learned too;
        without sessions probabilities are calibrated on held-out copies, and where place or load are learned, what is
        known of another day is learned of forms alone. 0 learns no copies.
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
    n_presses_ : int
        How many presses were learned. With fewer than 19 no probability is above .9.
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

    def fit(
        self, X: Any, y: ArrayLike, groups: ArrayLike | None = None, *, tick: Callable[[], object] = lambda: None
    ) -> Self:
        """Learn from presses, as `PressClassifier.fit` says."""
        from threadpoolctl import threadpool_limits

        training = self._training(X, y, groups)
        presses = training.presses
        self.n_presses_ = len(presses)
        self.columns_ = tuple(sorted({name for press in presses for name in press.columns}))
        best: tuple[MeasureSettings, Learned, NDArray[np.intp]] | None = None
        # Many small products: threads cost more than they bring, and their number may change the last digit.
        with threadpool_limits(1):
            for position, absolute in self._variants(training):
                settings = learn_settings(presses, position=position, absolute=absolute)
                copies = training.copies(self.drift, elsewhere=not position, lighter=not absolute)
                measures = self._measures([*presses, *copies], settings)
                of = training.all_codes, len(self.classes_), training.all_folds
                found, rows = learn(measures, *of, asked=training.asked, tick=tick)
                if best is None or found.loss < best[1].loss:
                    best = settings, found, rows
            assert best is not None
            self.settings_, found, landmarks = best
            forms = self._forms_learned(training, tick)
            self.learned_ = found if forms is None else replace(found, forms=forms)
        self.adapted_to_ = 0
        self.measure_names_ = tuple(measure_names(self.settings_))
        self.places_ = np.array([presses[k % len(presses)].place for k in landmarks])
        self.remarks_ = self._remarks(training)
        if self.n_presses_ < _FEWEST_SURE:
            self.remarks_ += (
                f"from {self.n_presses_} presses no answer has a p above .9: give {_FEWEST_SURE} or more",
            )
        if self.learned_.forms is not None:
            self.remarks_ += (_BY_FORMS,)
        return self

    @property
    def pads_(self) -> Mapping[str, tuple[int, int]]:
        """The pads that were learned from: rows and columns by name."""
        return self.settings_.shapes

    @property
    def loss_(self) -> float:
        return self.learned_.loss

    @property
    def chosen_(self) -> dict[str, Any]:
        """Whether place and load were learned, as `set_params` takes it."""
        return {"position": self.settings_.position, "absolute": self.settings_.absolute}

    def add(self, label: Any, X: Any) -> Self:
        """Add a class to this model, from presses of it, and return the model itself.

        Settings and calibration stay, and nothing else is learned again. `copy.deepcopy` before it keeps the model as
        it was.

        Parameters
        ----------
        label : object
            A label that is not known yet.
        X : sequence of presses
            At least two, as in `fit`.

        Raises
        ------
        InputError
            If the label is known or what strangers are called, or there are too few presses.
        """
        label = checked_label(label)
        asked = self._asked(X)
        presses = without_copies(asked)
        if label in self.classes_.tolist() or str(label) in map(str, self.classes_):
            raise InputError(f"{label!r} is known already; choose another label, or learn everything again")
        if len(presses) < 2:
            raise InputError(f"{label!r} has one press only: give at least two")
        known_already = self._known_already(label, presses)
        classes = np.append(self.classes_, np.array([label]))
        order = np.argsort(classes, kind="stable")
        place = int(np.flatnonzero(order == len(self.classes_))[0])
        measures = self._measures(presses, self.settings_)
        forms = self._forms_with(presses, measures, place)
        how = {"elsewhere": not self.settings_.position, "lighter": not self.settings_.absolute}
        both = [*presses, *copies_of(presses, COPIES if self.drift else 0, self.drift, **how)]
        added = self.learned_.scaled(self._measures(both, self.settings_))
        found, landmarks, named = with_class(self.learned_, added, place, n_presses=len(presses))
        self.learned_ = replace(found, forms=forms)
        faintest = min(self.settings_.least_load, least_load(presses, self.settings_.floor))
        self.settings_ = replace(self.settings_, least_load=faintest)
        self.n_presses_ += len(presses)
        self.classes_ = classes[order]
        self.places_ = np.append(self.places_, [press.place for press in both])[landmarks]
        self.remarks_ += copies_told(len(asked) - len(presses))
        self.remarks_ += known_already or _hardly_told(label, int((named != place).sum()), len(presses))
        return self

    def _known_already(self, label: Any, presses: list[Press]) -> tuple[str, ...]:
        """Return what is to be told of presses of a new class that were learned as another, or surely look like one."""
        named, p_values = self.judge(presses)
        sure = (named.max(axis=1) > _SURE) & (p_values > self.error)
        for known, words in ((self.learned_from(presses), "were learned already"), (sure, "are surely recognized")):
            if 2 * known.sum() > len(presses):
                names = ", ".join(dict.fromkeys(map(str, self.classes_[named[known].argmax(axis=1)])))
                return (
                    f"{known.sum()} of {len(presses)} presses of {label!r} {words}, as {names}: look at their label",
                )
        return ()

    def adapt(self, X: Any) -> Self:
        """Return a copy that answers for another session, whose drift is estimated from presses without labels.

        One shift of each measure, common to all things, is found: a hand that sits elsewhere, another load, an aged
        sensor. Presses that are like nothing known hardly count: by their forms, where these say what is refused.
        Settings and calibration stay.

        Parameters
        ----------
        X : sequence of presses
            Of the new session, as in `predict`: five or more that are like what is known, at least two of them of
            another thing than the rest. Those to be answered may be among them. Those that bear next to nothing, less
            than a tenth of the least load that was learned, and copies of others are left out: `adapted_to_` counts the
            rest.

        Raises
        ------
        InputError
            If too few presses are like anything known, all are of one thing, or no common shift explains them.
        """
        asked = self._asked(X)
        told = without_copies(asked)
        presses = [told[k] for k in np.flatnonzero(~bear_nothing(told, self.settings_))]
        if not presses:
            raise InputError(
                f"none of {len(asked)} new presses bears a tenth of the least load that was learned: nothing tells how "
                "things have drifted; give presses of known things"
            )
        fresh = replace(self.learned_, drift={})
        measures = self._measures(presses, self.settings_)
        drift = estimate_drift(fresh, measures, self._forms_asked(measures), self.error)
        adapted = copy(self)
        adapted.learned_ = replace(fresh, drift=drift)
        adapted.adapted_to_ = len(presses)
        return adapted

    def _check_options(self) -> None:
        super()._check_options()
        for name, given in (("position", self.position), ("absolute", self.absolute)):
            if not (given is None or isinstance(given, (bool, np.bool_))):
                raise InputError(f"{name} must be True, False or None, got {given!r}")

    def _variants(self, training: Training) -> list[tuple[bool, bool]]:
        """Return which (position, absolute) are to be tried."""
        several = max(len(press.pads) for press in training.presses) > 1
        undecided = (True, False) if training.sessions else (several,)
        ways = [undecided if given is None else (bool(given),) for given in (self.position, self.absolute)]
        return [(position, absolute) for position in ways[0] for absolute in ways[1]]

    def _measures(self, presses: Sequence[Press], settings: MeasureSettings) -> dict[str, Floats]:
        found = {TOUCH: measure_presses(presses, settings)}
        if self.columns_:
            found[NUMBERS] = values_of(presses, self.columns_)
        return found

    def _forms_learned(self, training: Training, tick: Callable[[], object]) -> Learned | None:
        """Return what is learned of forms alone, where one session is known and place or load are learned in it."""
        settings = self.settings_
        placed = settings.position or settings.absolute
        if training.sessions or not training.n_copies or not placed:
            return None
        presses = [*training.presses, *training.copies(self.drift, elsewhere=True, lighter=True)]
        measures = self._measures(presses, of_forms(settings))
        of = training.all_codes, len(self.classes_), training.all_folds
        return learn(measures, *of, asked=training.asked, share=FORMS_SHARE, tick=tick)[0]

    def _forms_with(self, presses: list[Press], measures: Mapping[str, Floats], place: int) -> Learned | None:
        """Return what was learned of forms, with a class more: its presses, and as another day may bring them."""
        forms = self.learned_.forms
        if forms is None:
            return None
        settings = of_forms(self.settings_)
        drawn = self._measures(copies_of(presses, COPIES, self.drift, elsewhere=True, lighter=True), settings)
        added = {name: np.concatenate([of, drawn[name]]) for name, of in self._forms(measures).items()}
        return replace(with_class(forms, forms.scaled(added), place, FORMS_SHARE)[0], known=forms.known)

    def _forms(self, measures: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return what is measured of forms alone."""
        return {**measures, TOUCH: form_alone(measures[TOUCH], self.settings_)}

    def _forms_asked(self, measures: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return what is measured of forms alone, where the model has learned these by themselves."""
        return {} if self.learned_.forms is None else self._forms(measures)

    def _said(self, presses: Sequence[Press]) -> tuple[Floats, Floats, Judged]:
        """Return plain probabilities, p-values, and what said so."""
        measures = self._measures(presses, self.settings_)
        silent = bear_nothing(presses, self.settings_)
        said = judge(self.learned_, measures, self._forms_asked(measures), self.error)
        if silent.any():
            said = self._silenced(said, measures, silent)
        touch = self.learned_.sources[TOUCH].scaling
        untimely = of_another_clock(measures[TOUCH], touch.shift, touch.scale, self.learned_.drift.get(TOUCH, 0.0))
        if untimely.any():
            # Among hundreds of measures of forms a few times hardly count, and may all the same decide between things.
            p_values = np.where(untimely, self._least_p_value, said.p_values)
            said = replace(said, p_values=p_values, untimely=untimely)
        return said.probabilities, said.p_values, said

    def _usual(self, presses: Sequence[Press], p_values: Floats) -> Floats:
        unsure = made_up(presses, self.settings_) | (self.n_presses_ < _FEWEST_SURE)
        return np.where(unsure, np.minimum(p_values, self.error), p_values)

    def remarks_on(self, X: Any) -> tuple[str, ...]:
        remarks = super().remarks_on(X)
        n_made_up = 0 if is_flat(X) else int(made_up(as_presses(X), self.settings_).sum())
        if not n_made_up:
            return remarks
        these = counted(n_made_up, "press stands", "presses stand")
        return (*remarks, f"{these} in part on broken taxels, where none usually did in learning: no p above .9 there")

    @property
    def _least_p_value(self) -> float:
        """That of a press that is stranger than all that is known."""
        return 1.0 / (1 + len((self.learned_.forms or self.learned_).known))

    def _silenced(self, said: Judged, measures: dict[str, Floats], silent: NDArray[np.bool_]) -> Judged:
        """Return what is said where touch tells nothing of some presses: they are stranger than all that is known."""
        heard = {name: of[silent] for name, of in measures.items()}
        heard[TOUCH] = np.full_like(heard[TOUCH], np.nan)
        probabilities, p_values = said.probabilities.copy(), said.p_values.copy()
        probabilities[silent] = judge(self.learned_, heard, self._forms_asked(heard), self.error).probabilities
        p_values[silent] = self._least_p_value
        return replace(said, probabilities=probabilities, p_values=p_values, silent=silent)

    def _reasons(self, said: Judged, k: int, first: int, second: int) -> tuple[list[tuple[str, float]], int]:
        scaled = {name: of[k : k + 1] for name, of in said.scaled.items()}
        near = nearest_landmark(self.learned_.sources[TOUCH], scaled[TOUCH])
        if said.silent is not None and said.silent[k]:
            scaled[TOUCH] = np.full_like(scaled[TOUCH], np.nan)
        return deciding_measures(self.learned_, scaled, self._names(self.settings_), first, second), near

    def _again(self, said: Judged) -> NDArray[np.bool_]:
        return equal_rows(said.scaled[TOUCH], self.learned_.sources[TOUCH].landmarks)

    def _outside(self, said: Judged, k: int) -> tuple[str, ...]:
        if said.silent is not None and said.silent[k]:
            return ("load",)
        learned, measures, settings = self.learned_, said.scaled, self.settings_
        if learned.forms is not None:
            learned, measures, settings = learned.forms, said.forms, of_forms(settings)
        scaled = {name: of[k : k + 1] for name, of in measures.items()}
        found = outside_measures(learned, scaled, self._names(settings), MOST_MEASURES)
        if said.untimely is not None and said.untimely[k]:
            found = (_TIME, *(kind for kind in found if kind != _TIME))[:MOST_MEASURES]
        return found

    def _unlike(self, said: Judged, k: int) -> bool:
        return bool(said.unlike[k])

    def _names(self, settings: MeasureSettings) -> dict[str, tuple[str, ...]]:
        of_touch = self.measure_names_ if settings is self.settings_ else tuple(measure_names(settings))
        return {TOUCH: of_touch, NUMBERS: self.columns_}

    @property
    def landmark_codes(self) -> NDArray[np.intp]:
        """The class of each press of `places_`."""
        return self.learned_.landmark_codes


def _hardly_told(label: Any, otherwise: int, n_presses: int) -> tuple[str, ...]:
    """Return what is to be told of a new class of whose presses, each held out, some are named otherwise."""
    if not otherwise:
        return ()
    return (
        f"{otherwise} of {n_presses} presses of {label!r}, each held out, are named otherwise: answers near it promise "
        "too much; press it more often, or learn everything again",
    )
