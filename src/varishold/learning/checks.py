"""What classifiers of presses take: options, presses, labels and groups; what is wrong is refused in one line."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._name import plain_name, refuse_name_of_strangers
from varishold.errors import InputError
from varishold.frame.checks import is_number
from varishold.grasp.estimator import check_classification_targets
from varishold.trust import first_without_name

__all__ = [
    "check_options",
    "check_presses",
    "checked_groups",
    "checked_label",
    "checked_labels",
    "checked_targets",
    "plain_names",
]


def check_options(error: Any, drift: Any, folds: Any) -> None:
    """Refuse options that no classifier can learn with."""
    if not is_number(error) or not 0 < error < 1:
        raise InputError(f"error must lie between 0 and 1, got {error!r}")
    if not is_number(drift) or not 0 <= drift < 1:
        raise InputError(f"drift must be at least 0 and below 1, got {drift!r}")
    if isinstance(folds, bool) or not isinstance(folds, (int, np.integer)) or folds < 2:
        raise InputError(f"folds must be a whole number, at least 2, got {folds!r}")


def check_presses(X: Any) -> None:
    """Refuse what holds no press where frames are meant: nothing, or texts."""
    if X is None or isinstance(X, (str, bytes)):
        raise InputError(f"presses must be a sequence of recordings or frames, got {X!r:.60}")
    for k, one in enumerate(X if isinstance(X, (list, tuple)) else ()):
        if one is None or isinstance(one, (str, bytes)):
            raise InputError(f"press {k}: must be a recording or frames, got {one!r:.60}; read files first")


def checked_labels(y: ArrayLike) -> NDArray[Any]:
    """Return labels, refusing a press without one, and a label that is a number but not whole."""
    if y is None:
        raise InputError("y must be one label a press, got None")
    none = first_without_name(y)
    if none is not None:
        raise InputError(f"press {none} has no label: name what it is of, or leave it out")
    labels = np.asarray(y)
    if labels.dtype.kind == "S":
        raise InputError(f"labels must be texts or whole numbers, got bytes: {labels.ravel()[0]!r:.60}; decode them")
    if labels.dtype.kind == "f":
        broken = np.flatnonzero(labels.ravel() != np.rint(labels.ravel()))
        if broken.size:
            got = labels.ravel()[broken[0]]
            raise InputError(f"press {broken[0]}: its label must be a text or a whole number, got {got:g}")
    return _things(labels)


def checked_label(label: Any) -> Any:
    """Return the label of one class more, as it is kept, refusing what is neither a name nor a whole number."""
    whole = isinstance(label, (float, np.floating)) and float(label).is_integer()
    if whole or isinstance(label, (int, np.integer, np.bool_)):
        return label
    named = plain_name(label)
    if named is None:
        raise InputError(
            f"the new class has no name: give it a label, a whole number or a line of printable text, got {label!r:.60}"
        )
    refuse_name_of_strangers(named)
    return named


def checked_targets(labels: ArrayLike) -> NDArray[Any]:
    """Return labels that are classes, as scikit-learn has it."""
    with warnings.catch_warnings():
        # That there are nearly as many classes as presses: those with one are refused.
        warnings.simplefilter("ignore", UserWarning)
        check_classification_targets(labels)
    return _things(np.asarray(labels))


def checked_groups(groups: ArrayLike | None, n_presses: int) -> NDArray[Any] | None:
    """Return the session of each press, None where none is given, refusing presses of none."""
    if groups is None:
        return None
    given = np.asarray(groups)
    none = first_without_name(given)
    if none is not None:
        raise InputError(f"press {none} has no group: name its session, or leave the groups out")
    named = plain_names(given.astype(np.str_) if given.dtype.kind == "O" else given, "group")
    if named.shape != (n_presses,):
        raise InputError(f"groups must be one a press, {n_presses} of them, got {named.shape}")
    return named


def plain_names(names: NDArray[Any], what: str) -> NDArray[Any]:
    """Return the names of presses, "label" or "group", as they are kept; what is no text stays as it is."""
    texts = names.dtype.kind == "O" and all(isinstance(name, str) for name in names.ravel())
    given = names.astype(np.str_) if texts else names
    if given.dtype.kind != "U":
        return given
    different, of = np.unique(given, return_inverse=True)
    kept = [plain_name(str(name)) for name in different]
    if None in kept:
        wrong = kept.index(None)
        press = int(np.flatnonzero(of.ravel() == wrong)[0])
        got = str(different[wrong])[:60]
        raise InputError(f"press {press}: its {what} must be a line of printable text, got {got!r}")
    return np.array(kept, dtype=np.str_)[of].reshape(given.shape)


def _things(labels: NDArray[Any]) -> NDArray[Any]:
    """Return what things are called, as it is kept."""
    names = plain_names(labels, "label")
    for press, name in enumerate(names.ravel().tolist()):
        refuse_name_of_strangers(name, place=f"press {press}: ")
    return names
