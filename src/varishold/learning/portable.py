"""The classifier of presses that a skin's own controller can hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.learning.discriminant import landmark_rows, single
from varishold.learning.pad_networks import LearnedPads, learn_pads, refusal_limit
from varishold.learning.press_classifier import PressClassifier, equal_rows
from varishold.learning.training import Training
from varishold.touch.contact_network import ContactNetwork, check_sides, frame_signature
from varishold.touch.course.presses import Press
from varishold.touch.signature import SIGNATURE_GROUPS, SIGNATURE_NAMES
from varishold.trust import conformal_p_value

__all__ = ["MOST_CLASSES", "PortableClassifier", "strongest_frames"]

Floats = NDArray[np.float64]

#: A controller counts names in a byte, one of them none of these.
MOST_CLASSES = 255
# Of each pad so many frames are kept for the tests of an export, and of all of them so many taxels.
_MOST_EXAMPLES, _MOST_TAXELS = 52, 100_000


class PortableClassifier(PressClassifier):
    """Learn from presses what a skin's own controller can hold: a small network for each pad.

    A press is judged by the signature of each pad's largest contact in the frame of its largest load, by one layer of
    weights: a linear discriminant, its shrinkage chosen and its probabilities calibrated on presses that were held out.
    What the pads say is multiplied. Where things lie on a pad, how hard they are pressed and how the press goes on in
    time are not looked at, so that `TactileClassifier` is right more often.

    Parameters
    ----------
    shape : (rows, cols) or (pads, rows, cols), optional
        What a flat frame holds; only for X of two dimensions. Default: the squarest grid.
    error : float, default 0.05
        Share of presses of known things that are refused as none of these.
    drift : float, default 0.1
        By what share the taxels' gains may drift until tomorrow, as for `TactileClassifier`.
    folds : int, default 5
        Folds of the cross-validation inside the training presses.

    Attributes
    ----------
    classes_ : ndarray of shape (n_classes,)
    fields_ : mapping of str to ndarray of shape (rows, cols), bool
        Where each pad has taxels.
    learned_ : LearnedPads
        What was learned of each pad, the calibration, and how strange known presses are.
    usual_ : mapping of str to ndarray of shape (n_classes, n_inputs), float64
        Of each pad the mean standardized signature of each class.
    landmarks_ : mapping of str to ndarray of shape (n_landmarks, r), float64
        Where training presses lie among the classes of each pad; NaN where they do not touch it.
    examples_ : mapping of str to ndarray of shape (n, rows, cols), float32
        Frames of each pad that were learned from.
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
    >>> clf = PortableClassifier().fit(np.array(frames), label)
    >>> print(*clf.predict(np.array(frames)[[0, 12]]), *clf.networks)
    cone pillar pad_0
    """

    # The signature of a contact is the same whatever its readings are multiplied by.
    _levels_count = False
    fields_: dict[str, NDArray[np.bool_]]
    learned_: LearnedPads
    usual_: dict[str, Floats]
    landmarks_: dict[str, Floats]
    landmark_codes_: NDArray[np.intp]
    examples_: dict[str, NDArray[np.float32]]

    def __init__(
        self, shape: tuple[int, ...] | None = None, *, error: float = 0.05, drift: float = 0.1, folds: int = 5
    ) -> None:
        self.shape = shape
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
        if len(self.classes_) > MOST_CLASSES:
            raise InputError(f"a controller tells {MOST_CLASSES} things apart at most, got {len(self.classes_)}")
        self.fields_ = {name: field for press in presses for name, field in press.fields.items()}
        # On one pad a thing may lie anywhere; several pads of a hand hold it between them.
        alone = max(len(press.pads) for press in presses) == 1
        frames = [*map(strongest_frames, [*presses, *training.copies(self.drift, elsewhere=alone, lighter=alone)])]
        signatures = {name: of for name, of in self._signatures(frames).items() if np.isfinite(of).any()}
        if not signatures:
            raise InputError("nothing touches in any press: there is nothing to learn")
        # Many small products: threads cost more than they bring, and their number may change the last digit.
        with threadpool_limits(1):
            self.learned_ = learn_pads(
                *(signatures, training.all_codes, len(self.classes_), training.all_folds),
                asked=training.asked,
                tick=tick,
            )
        self._keep(training, frames, {name: of[: len(presses)] for name, of in signatures.items()})
        self.remarks_ = (*self._remarks(training), *self._beyond_a_controller(presses))
        return self

    @property
    def loss_(self) -> float:
        return self.learned_.loss

    @property
    def pads_(self) -> Mapping[str, tuple[int, int]]:
        """The pads that were learned from: rows and columns by name."""
        return {name: (field.shape[0], field.shape[1]) for name, field in self.fields_.items()}

    @property
    def networks(self) -> dict[str, ContactNetwork]:
        """What a controller holds, by pad. (Several pads' probabilities are multiplied, class by class.)"""
        limit = refusal_limit(self.learned_.known, self.error)
        return {
            name: ContactNetwork.of(
                tuple(str(label) for label in self.classes_),
                self.fields_[name],
                (pad.scaling.shift, pad.scaling.scale),
                pad.directions,
                pad.means,
                temperature=self.learned_.temperature,
                farthest=limit * pad.typical,
                examples=self.examples_[name],
            )
            for name, pad in self.learned_.pads.items()
        }

    def _beyond_a_controller(self, presses: Sequence[Press]) -> list[str]:
        """Return what a reader should know of what a controller cannot hold."""
        remarks = []
        beside = sorted({name for press in presses for name in press.columns})
        if beside:
            remarks.append(f"{', '.join(beside)}: not learned, for a controller's pad tells forms alone")
        for name, shape in self.pads_.items():
            try:
                check_sides(shape)
            except InputError as error:
                remarks.append(f"{name} cannot be exported: {error}")
        return remarks

    def _keep(self, training: Training, frames: Sequence[Mapping[str, Floats]], signatures: dict[str, Floats]) -> None:
        """Keep what answers are explained by, and a few frames."""
        rows = landmark_rows(training.codes, len(SIGNATURE_NAMES))
        self.places_ = np.array([training.presses[k].place for k in rows])
        self.landmark_codes_ = training.codes[rows]
        pads = self.learned_.pads
        self.landmarks_ = {name: single(pads[name].coordinates(of[rows])) for name, of in signatures.items()}
        self.usual_ = {
            name: single(_means(pads[name].scaling.apply(of), training.codes, len(self.classes_)))
            for name, of in signatures.items()
        }
        self.examples_ = {}
        for name, (n_rows, n_cols) in self.pads_.items():
            there = [k for k, of in enumerate(frames[: len(training.codes)]) if name in of]
            most = max(min(_MOST_EXAMPLES, _MOST_TAXELS // (n_rows * n_cols)), 1)
            chosen = np.unique(np.linspace(0, len(there) - 1, most).round().astype(int))
            self.examples_[name] = np.array([frames[there[k]][name] for k in chosen], dtype=np.float32)

    def _signatures(self, frames: Sequence[Mapping[str, Floats]]) -> dict[str, Floats]:
        """Return the signature of each pad's largest contact, shape (n, n_inputs) each; NaN where there is none."""
        nothing = np.full(len(SIGNATURE_NAMES), np.nan)
        return {
            name: np.array([frame_signature(of[name], self.fields_[name]) if name in of else nothing for of in frames])
            for name in self.pads_
        }

    def _said(self, presses: Sequence[Press]) -> tuple[Floats, Floats, dict[str, Floats]]:
        signatures = self._signatures([strongest_frames(press) for press in presses])
        scores, strange = self.learned_.judge(signatures)
        scaled = scores / self.learned_.temperature
        shares = np.exp(scaled - scaled.max(axis=1, keepdims=True))
        return (
            shares / shares.sum(axis=1, keepdims=True),
            conformal_p_value(strange, self.learned_.known),
            {name: of for name, of in signatures.items() if name in self.learned_.pads},
        )

    def _reasons(
        self, said: Mapping[str, Floats], k: int, first: int, second: int
    ) -> tuple[list[tuple[str, float]], int]:
        nats = np.zeros(len(SIGNATURE_NAMES))
        apart = []
        for name, pad in self.learned_.pads.items():
            inputs = pad.scaling.apply(said[name][k : k + 1])[0]
            weight = pad.directions @ (pad.means[first] - pad.means[second]) / self.learned_.temperature
            nats += np.nan_to_num((inputs - self.usual_[name][second]) * weight)
            apart.append(((self.landmarks_[name] - inputs @ pad.directions) ** 2).sum(axis=1))
        groups = np.array(SIGNATURE_GROUPS)
        told = {group: float(nats[groups == group].sum()) for group in dict.fromkeys(SIGNATURE_GROUPS)}
        # A pad that one of two presses does not touch makes them unlike.
        unlike = np.nan_to_num(apart, nan=float(np.nanmax(apart)) if np.isfinite(apart).any() else 0.0)
        return sorted(told.items(), key=lambda one: -one[1]), int(np.argmin(unlike.sum(axis=0)))

    def _again(self, said: Mapping[str, Floats]) -> NDArray[np.bool_]:
        places = [
            equal_rows(pad.coordinates(said[name]), self.landmarks_[name]) for name, pad in self.learned_.pads.items()
        ]
        return np.asarray(np.any(places, axis=0))

    @property
    def landmark_codes(self) -> NDArray[np.intp]:
        """The class of each press of `places_`."""
        return self.landmark_codes_


def strongest_frames(press: Press) -> dict[str, Floats]:
    """Return each pad's frame at the press's largest load, shape (rows, cols) each."""
    load = np.sum([np.maximum(frames, 0.0).sum(axis=(1, 2)) for frames in press.pads.values()], axis=0)
    return {name: frames[int(np.argmax(load))] for name, frames in press.pads.items()}


def _means(scaled: Floats, codes: NDArray[np.intp], n_classes: int) -> Floats:
    """Return the mean of each class, of what is known; 0, the mean of all, where nothing is."""
    known = np.isfinite(scaled)
    counts = np.array([known[codes == k].sum(axis=0) for k in range(n_classes)])
    sums = np.array([np.nansum(scaled[codes == k], axis=0) for k in range(n_classes)])
    return np.asarray(sums / np.maximum(counts, 1))
