"""What stands in a model file, checked: pads, unit, pitch, numbers, arrays, texts, classes, landmarks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._name import plain_name, refuse_name_of_strangers
from varishold.errors import InputError
from varishold.files import Archive
from varishold.frame.checks import as_pitch
from varishold.touch.course.one_sensor import SensorScale

__all__ = ["checked_codes", "classes_of", "landmarks_of", "number", "numbers", "pads_of", "scale_of", "texts"]

# No sensor has more pads or longer sides, and no model more classes.
_MOST_PADS, _LONGEST_SIDE, _MOST_ROWS = 64, 4096, 100_000


def pads_of(pads: Any) -> dict[str, tuple[int, int]]:
    """Return the rows and columns of each pad by its name."""
    shapes: dict[str, tuple[int, int]] = {}
    if not isinstance(pads, list) or not 0 < len(pads) <= _MOST_PADS:
        raise InputError(f"pads must be a list of 1 to {_MOST_PADS}")
    for name, *sides in pads:
        if not isinstance(name, str) or len(sides) != 2 or name in shapes:
            raise InputError("pads must be different names, each with rows and columns")
        if not all(type(side) is int and 0 < side <= _LONGEST_SIDE for side in sides):
            raise InputError(f"rows and columns of pads must lie between 1 and {_LONGEST_SIDE}, got {sides}")
        shapes[name] = (sides[0], sides[1])
    return shapes


def scale_of(about: Mapping[str, Any], pads: Mapping[str, tuple[int, int]]) -> SensorScale:
    """Return the unit of what was learned, and how far taxels are apart."""
    unit, pitch_m = about["unit"], about["pitch_m"]
    if not isinstance(unit, str) or not unit.strip() or not unit.isprintable():
        raise InputError(f"unit must be printable text, got {unit!r}")
    if not isinstance(pitch_m, Mapping) or not pitch_m.keys() <= pads.keys():
        raise InputError("pitch_m must be a mapping of pads")
    return SensorScale(unit, {name: as_pitch(pitch) for name, pitch in pitch_m.items()})


def classes_of(archive: Archive) -> NDArray[Any]:
    """Return the classes, in order."""
    classes = archive.array("classes")
    n_classes = len(classes) if classes.ndim == 1 else 0
    if classes.dtype.kind not in "biufU" or n_classes < 2 or n_classes > _MOST_ROWS:
        raise InputError(f"classes must be two or more texts or numbers, got {classes.dtype} of shape {classes.shape}")
    if not (classes[1:] > classes[:-1]).all():
        raise InputError("classes must be different and in order")
    for name in classes.tolist() if classes.dtype.kind == "U" else ():
        if plain_name(name) is None:
            raise InputError(f"classes must be lines of printable text, got {name[:60]!r}")
        refuse_name_of_strangers(name)
    return classes


def landmarks_of(archive: Archive, n_classes: int) -> tuple[NDArray[np.intp], NDArray[np.str_]]:
    """Return the class of each landmark, and where it stands."""
    codes, places = archive.array("landmark_codes"), archive.array("places")
    if not _are_codes(codes) or places.shape != codes.shape or places.dtype.kind != "U":
        raise InputError("landmark_codes and places must be one whole number and one text a landmark")
    return checked_codes(codes, "landmark_codes", n_classes), places


def checked_codes(codes: NDArray[Any], name: str, n_classes: int) -> NDArray[np.intp]:
    """Return the class of each landmark, each class named."""
    if not _are_codes(codes):
        raise InputError(f"{name} must be one whole number a landmark")
    if not np.array_equal(np.unique(codes), np.arange(n_classes)):
        raise InputError(f"{name} must name each of {n_classes} classes")
    return codes.astype(np.intp)


def _are_codes(codes: NDArray[Any]) -> bool:
    return codes.ndim == 1 and 0 < len(codes) <= _MOST_ROWS and codes.dtype.kind in "iu"


def number(of: Mapping[str, Any], key: str, least: float, most: float = math.inf) -> float:
    """Return a finite number between two limits."""
    value = of[key]
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"{key} must be a finite number, got {value!r}")
    if not least <= value <= most:
        raise InputError(f"{key} must lie between {least:g} and {most:g}, got {value:g}")
    return float(value)


def numbers(
    archive: Archive, name: str, shape: tuple[int | None, ...], *, unknown: bool = False, most: float = 1e100
) -> NDArray[np.float64]:
    """Return an array of finite numbers, NaN only where some may be unknown; a side of None is of any length."""
    array = archive.array(name)
    fits = array.ndim == len(shape) and all(want in (None, got) for want, got in zip(shape, array.shape, strict=True))
    if array.dtype.kind != "f" or not fits:
        told = " x ".join("any" if side is None else str(side) for side in shape)
        raise InputError(f"{name} must be {told} numbers, got {array.dtype} of shape {array.shape}")
    with np.errstate(all="ignore"):
        found = array.astype(np.float64)
    given = found[~np.isnan(found)] if unknown else found
    if not np.isfinite(given).all() or np.abs(given).max(initial=0.0) > most:
        raise InputError(f"{name} must be finite, at most {most:g}")
    return found


def texts(document: Any, what: str) -> list[str]:
    """Return a list of texts."""
    if not isinstance(document, list) or not all(isinstance(item, str) for item in document):
        raise InputError(f"{what} must be a list of texts")
    return document
