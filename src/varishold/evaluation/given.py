"""The evaluation of what was learned before: a model, or the shipped names of touch."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.evaluation.held_out import Felt
from varishold.evaluation.leaks import Leak
from varishold.evaluation.result import Evaluation
from varishold.evaluation.running import felt_presses, interval_remarks, stranger_score
from varishold.evaluation.scores import Answers, score
from varishold.learning import PressClassifier
from varishold.recording import Recording
from varishold.sensor import Sensor
from varishold.sensor.recordings import upright_recording
from varishold.touch import NAMES, Answer, recognize_recording

__all__ = ["evaluate_model", "evaluate_shipped"]

Floats = NDArray[np.float64]

UNKNOWN = "unknown"
# Presses that a model answers between two steps of a progress bar.
_AT_ONCE = 50


def evaluate_model(
    model: PressClassifier,
    X: Any,
    y: ArrayLike,
    groups: ArrayLike | None = None,
    *,
    seed: int = 0,
    tick: Callable[..., object] = lambda **_: None,
) -> Evaluation:
    """Tell what a model's answers are worth on labelled presses; nothing is learned.

    Parameters
    ----------
    model : PressClassifier
        One that has learned, or was read from its file.
    X, y
        Presses and their labels. What the model does not know is a stranger.
    groups : array_like of shape (n,), optional
        The session of each press.
    seed : int
        Kept in the result; nothing is drawn.
    tick : callable
        Called with ``total=`` once, then with ``advance=1`` as the work goes on.

    Raises
    ------
    InputError
        If the model knows none of the labels, or is of another sensor.
    """
    felt = felt_presses(X, y, groups, model.shape)
    things = np.asarray(model.classes_).astype(np.str_)
    truth = _places_of(felt, things)
    if (truth < 0).all():
        raise InputError(
            f"the model knows none of these labels: {_listed(felt.classes)}; it knows {_listed(things)}",
            parameter="label",
        )
    starts = range(0, len(truth), _AT_ONCE)
    tick(total=len(starts))
    judged = []
    for start in starts:
        judged.append(model.judge(list(felt.presses[start : start + _AT_ONCE])))
        tick(advance=1)
    probabilities, p = (np.concatenate(some) for some in zip(*judged, strict=True))
    return _result(
        "model",
        felt,
        things,
        truth,
        probabilities,
        p <= model.error,
        p_values=p,
        error=model.error,
        leaks=_learned_from(model, felt),
        seed=seed,
    )


def evaluate_shipped(
    recordings: Sequence[Recording],
    y: ArrayLike,
    groups: ArrayLike | None = None,
    *,
    sensors: Sequence[Sensor | None] | None = None,
    seed: int = 0,
    tick: Callable[..., object] = lambda **_: None,
) -> Evaluation:
    """Tell what the shipped names of touch are worth on labelled presses; nothing is learned.

    A press is answered by its strongest contact, its evidence pooled over the press.

    Parameters
    ----------
    recordings : sequence of Recording
    y : array_like of shape (n,)
        The label of each press of all recordings: a name of `varishold.touch.NAMES`, in any case and with hyphens,
        underscores or spaces; ``unknown`` for anything else.
    groups : array_like of shape (n,), optional
    sensors : sequence of Sensor or None, one a recording, optional
    seed : int
        Kept in the result; nothing is drawn.
    tick : callable
        Called with ``total=`` once, then with ``advance=1`` as the work goes on.

    Raises
    ------
    InputError
        Naming the labels that are no shipped name.
    """
    things = np.array([name for name in NAMES if name != UNKNOWN])
    labels = np.array([_plain(label) for label in np.asarray(y).astype(np.str_)])
    strange = sorted({str(given) for given, label in zip(np.asarray(y), labels, strict=True) if label not in NAMES})
    if strange:
        raise InputError(
            f"labels that are no shipped name: {_listed(np.array(strange))}; known are: {', '.join(NAMES)}",
            parameter="label",
        )
    if (labels == UNKNOWN).all():
        raise InputError(
            "every press is labelled unknown: give presses of something that has a name", parameter="label"
        )
    tick(total=len(labels))
    names = [*things.tolist(), UNKNOWN]
    told: list[Floats] = []
    for recording, sensor in zip(recordings, sensors or [None] * len(recordings), strict=True):
        for answer in _strongest(recording, sensor):
            row = np.zeros(len(names))
            if answer is None:
                row[-1] = 1.0
            else:
                row[:] = [answer.surface.names[name] for name in names]
            told.append(row)
            tick(advance=1)
    if len(told) != len(labels):
        raise InputError(f"y must be one label a press, {len(told)} of them, got {len(labels)}")
    probabilities = np.array(told)
    felt = Felt([], np.unique(labels, return_inverse=True)[1], np.unique(labels), _as_texts(groups))
    truth = _places_of(felt, things)
    said_unknown = probabilities.argmax(axis=1) == len(names) - 1
    return _result("shipped", felt, things, truth, probabilities, said_unknown, seed=seed)


def _strongest(recording: Recording, sensor: Sensor | None) -> Iterator[Answer | None]:
    """Yield the answer of each press's strongest contact, None where nothing was felt."""
    for span in upright_recording(recording, sensor).presses.spans:
        cut = _cut(recording, span)
        how = "press" if len(upright_recording(cut, sensor).presses) else "peak"
        answers = recognize_recording(cut, frames=how, sensor=sensor)
        yield max(answers, key=lambda answer: float(answer.surface.contact.values.sum()), default=None)


def _cut(recording: Recording, span: range) -> Recording:
    frames = slice(span.start, span.stop)
    pads = {name: replace(pad, frames=pad.frames[frames]) for name, pad in recording.pads.items()}
    time_s = None if recording.time_s is None else recording.time_s[frames]
    return replace(recording, pads=pads, time_s=time_s, press=None, press_columns={})


def _result(
    tested: Literal["model", "shipped"],
    felt: Felt,
    things: NDArray[np.str_],
    truth: NDArray[np.intp],
    probabilities: Floats,
    refused: NDArray[np.bool_],
    *,
    seed: int,
    p_values: Floats | None = None,
    error: float | None = None,
    leaks: tuple[Leak, ...] = (),
) -> Evaluation:
    known = truth >= 0
    groups = felt.groups
    strangers = None
    if not known.all():
        strangers = stranger_score(
            refused[~known],
            None if groups is None else groups[~known],
            None if p_values is None or error is None else (p_values[~known], p_values[known], error),
            tuple(np.unique(felt.classes[felt.codes[~known]]).tolist()),
        )
    scores = score(
        Answers(probabilities[known], truth[known], refused[known], None if groups is None else groups[known])
    )
    n_known = len(np.unique(truth[known]))
    remarks = interval_remarks(groups)
    if n_known < len(things):
        remarks.append(f"{n_known} of the {len(things)} things that it knows were tested")
    return Evaluation(
        tested=tested,
        n_presses=len(truth),
        things=tuple(things.tolist()) if tested == "model" else (*things.tolist(), UNKNOWN),
        groups=() if groups is None else tuple(np.unique(groups).tolist()),
        split="none",
        n_folds=0,
        error=error,
        scores=scores,
        strangers=strangers,
        unheard=None,
        peers=(),
        shots=(),
        leaks=leaks,
        remarks=tuple(remarks),
        seed=seed,
    )


def _learned_from(model: PressClassifier, felt: Felt) -> tuple[Leak, ...]:
    """Tell whether the model learned from some of these very presses, by their files' names and by what they are.

    Files are copied, converted, and called by other paths.
    """
    known = set(model.places_.tolist())
    named = np.array([", press " in press.place and press.place in known for press in felt.presses])
    same = int(np.count_nonzero(named | model.learned_from(list(felt.presses))))
    if not same:
        return ()
    return (
        Leak(
            "learned from these",
            f"the model learned from {same} of these very presses at least, which flatters; "
            "give recordings that it has not seen",
        ),
    )


def _places_of(felt: Felt, things: NDArray[np.str_]) -> NDArray[np.intp]:
    """Return where each press's label stands among the things that are known, -1 for a stranger's."""
    place = {name: k for k, name in enumerate(things.tolist())}
    return np.array([place.get(name, -1) for name in felt.classes.tolist()], dtype=np.intp)[felt.codes]


def _plain(label: str) -> str:
    return " ".join(label.lower().replace("-", " ").replace("_", " ").split())


def _as_texts(groups: ArrayLike | None) -> NDArray[np.str_] | None:
    return None if groups is None else np.asarray(groups).astype(np.str_)


def _listed(names: NDArray[np.str_], most: int = 12) -> str:
    told = [str(name) for name in names[:most]]
    return ", ".join(told) + (f" and {len(names) - most} more" if len(names) > most else "")
