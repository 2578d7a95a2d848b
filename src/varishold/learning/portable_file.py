"""What a model file holds of a model that a controller can hold."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.files import Archive
from varishold.learning.discriminant import Scaling
from varishold.learning.entries import number, numbers
from varishold.learning.pad_networks import LEAST_TYPICAL, LearnedPads, PadDiscriminant
from varishold.learning.portable import MOST_CLASSES, PortableClassifier
from varishold.touch.signature import SIGNATURE_NAMES

__all__ = ["PORTABLE", "portable_entries", "portable_model"]

#: What a model file calls this kind of model.
PORTABLE = "portable"
_N_INPUTS = len(SIGNATURE_NAMES)
# A controller counts in single precision, which ends at 3e38.
_MOST = 1e15


def portable_entries(model: PortableClassifier) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return what stands in the file's text, and its arrays; pads go by their numbers."""
    learned = model.learned_
    arrays: dict[str, NDArray[Any]] = {"known": learned.known}
    for k, name in enumerate(model.pads_):
        arrays |= {f"pad_{k}.field": model.fields_[name], f"pad_{k}.examples": model.examples_[name]}
        if name not in learned.pads:
            continue
        pad = learned.pads[name]
        arrays |= {
            f"pad_{k}.shift": pad.scaling.shift,
            f"pad_{k}.scale": pad.scaling.scale,
            f"pad_{k}.directions": pad.directions.astype(np.float32),
            f"pad_{k}.means": pad.means.astype(np.float32),
            f"pad_{k}.typical": np.array([pad.typical]),
            f"pad_{k}.usual": model.usual_[name].astype(np.float32),
            f"pad_{k}.landmarks": model.landmarks_[name].astype(np.float32),
        }
    about: dict[str, Any] = {
        "learner": PORTABLE,
        "inputs": _N_INPUTS,
        "loss": learned.loss,
        "temperature": learned.temperature,
        "shrinkage": learned.shrinkage,
    }
    return about, arrays


def portable_model(
    about: Mapping[str, Any],
    archive: Archive,
    pads: Mapping[str, tuple[int, int]],
    n_classes: int,
    codes: NDArray[np.intp],
) -> PortableClassifier:
    """Return the model of a file's text and arrays.

    Raises
    ------
    InputError
        Saying what is wrong with them.
    """
    if about["inputs"] != _N_INPUTS:
        raise InputError(f"the model has {about['inputs']} inputs, this program's signature {_N_INPUTS}")
    if n_classes > MOST_CLASSES:
        raise InputError(f"a controller tells {MOST_CLASSES} things apart at most, got {n_classes}")
    model = PortableClassifier()
    model.fields_, model.examples_, model.usual_, model.landmarks_ = {}, {}, {}, {}
    learned: dict[str, PadDiscriminant] = {}
    read = partial(numbers, archive, most=_MOST)
    for k, (name, shape) in enumerate(pads.items()):
        at = f"pad_{k}."
        model.fields_[name] = _field(archive, at + "field", shape)
        model.examples_[name] = read(at + "examples", (None, *shape)).astype(np.float32)
        if at + "shift" not in archive.names:
            continue
        scaling = Scaling(read(at + "shift", (_N_INPUTS,)), read(at + "scale", (_N_INPUTS,)))
        directions = read(at + "directions", (_N_INPUTS, None))
        r = directions.shape[1]
        typical = max(float(read(at + "typical", (1,))[0]), LEAST_TYPICAL)
        learned[name] = PadDiscriminant(scaling, directions, read(at + "means", (n_classes, r)), typical)
        model.usual_[name] = read(at + "usual", (n_classes, _N_INPUTS))
        model.landmarks_[name] = read(at + "landmarks", (len(codes), r), unknown=True)
    if not learned:
        raise InputError("no pad has a network")
    known = numbers(archive, "known", (None,))
    if not known.size:
        raise InputError("known must hold at least one number")
    temperature, shrinkage = number(about, "temperature", 1e-6), number(about, "shrinkage", 0.0, 1.0)
    model.learned_ = LearnedPads(learned, temperature, shrinkage, known, number(about, "loss", 0.0))
    model.landmark_codes_ = codes
    return model


def _field(archive: Archive, name: str, shape: tuple[int, int]) -> NDArray[np.bool_]:
    field = archive.array(name)
    if field.dtype != np.bool_ or field.shape != shape or not field.any():
        raise InputError(f"{name} must be {shape[0]} x {shape[1]} truth values, some of them true")
    return field
