"""The model file: an NPZ of plain arrays and one JSON text; reading it runs no code."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.files import Archive, open_archive, parse_json, write_archive
from varishold.learning.classifier import NUMBERS, TOUCH, TactileClassifier
from varishold.learning.discriminant import Discriminant, Scaling
from varishold.learning.sources import Learned, Source, View, view_name
from varishold.touch.course.measures import MeasureSettings, measure_names
from varishold.trust import SourceWeights

__all__ = ["read_model", "write_model"]

FORMAT, VERSION = "varishold model", 2
# No sensor has more pads or longer sides, and no model more classes.
_MOST_PADS, _LONGEST_SIDE, _MOST_ROWS = 64, 4096, 100_000


def write_model(model: TactileClassifier, path: str | os.PathLike[str]) -> None:
    """Write what was learned, whole or not at all; the same model gives the same bytes.

    Raises
    ------
    InputError
        If it has learned nothing, its labels are neither text nor numbers, or the file cannot be written.
    """
    if not hasattr(model, "learned_"):
        raise InputError("this TactileClassifier has not learned anything yet; fit it first")
    if model.adapted_to_:
        raise InputError("this TactileClassifier was adapted to one session; write the one that it comes from")
    if model.classes_.dtype.kind not in "biufU":
        raise InputError(f"labels must be text or numbers to be written, got {model.classes_.dtype}")
    settings, learned = model.settings_, model.learned_
    about = {
        "format": FORMAT,
        "version": VERSION,
        "pads": [[name, *shape] for name, shape in settings.shapes.items()],
        "floor": settings.floor,
        "rise": settings.rise,
        "clock": settings.clock,
        "load": settings.load,
        "position": settings.position,
        "absolute": settings.absolute,
        "columns": list(model.columns_),
        "error": model.error,
        "loss": learned.loss,
        "remarks": list(model.remarks_),
        "sources": {
            name: {
                str(view.discriminant.power): {
                    "width": view.discriminant.width,
                    "shrinkage": view.discriminant.shrinkage,
                    "temperature": view.temperature,
                    "weight": learned.trust.weights[view_name(name, view.discriminant.power)],
                    "mixing": learned.trust.mixing[view_name(name, view.discriminant.power)],
                }
                for view in source.views
            }
            for name, source in learned.sources.items()
        },
    }
    arrays: dict[str, NDArray[Any]] = {
        "about": np.array(json.dumps(about, allow_nan=False, sort_keys=True)),
        "classes": model.classes_,
        "known": learned.known,
        "places": model.places_,
        "landmark_codes": learned.landmark_codes.astype(np.int32),
    }
    for name, source in learned.sources.items():
        arrays |= {
            f"{name}.shift": source.scaling.shift,
            f"{name}.scale": source.scaling.scale,
            f"{name}.landmarks": source.landmarks.astype(np.float32),
        }
        for view in source.views:
            of = view_name(name, view.discriminant.power)
            arrays |= {
                f"{of}.whiten": view.discriminant.whiten.astype(np.float32),
                f"{of}.means": view.discriminant.means.astype(np.float32),
                f"{of}.typical": view.typical,
            }
    write_archive(arrays, path, kind="model")


def read_model(path: str | os.PathLike[str]) -> TactileClassifier:
    """Read a model, trusting nothing in it.

    Raises
    ------
    FormatError
        In one line: what is wrong with the file.
    """
    name = os.fspath(path)
    with open_archive(path) as archive:
        if "about" not in archive.names:
            raise FormatError(f"{name}: is no model file, as write_model and the command learn make them")
        about = parse_json(archive.text("about"), where=f"{name}: about")
        if not isinstance(about, Mapping) or about.get("format") != FORMAT:
            raise FormatError(f"{name}: is no model file, as write_model and the command learn make them")
        version = about.get("version")
        if not isinstance(version, int) or isinstance(version, bool) or version < 1:
            raise FormatError(f"{name}: version must be a positive whole number, got {version!r}")
        if version < VERSION:
            raise FormatError(f"{name}: is of version {version}, which is read no more; learn the model again")
        if version > VERSION:
            raise FormatError(f"{name}: is of version {version}, this program reads up to {VERSION}; update varishold")
        try:
            return _model(about, archive)
        except FormatError:
            raise
        except (InputError, ValueError, TypeError, KeyError, OverflowError, AttributeError) as error:
            what = f"{error.args[0]!r} is missing" if isinstance(error, KeyError) else str(error)
            raise FormatError(f"{name}: {' '.join(what.split())}; learn the model again") from error


def _model(about: Mapping[str, Any], archive: Archive) -> TactileClassifier:
    settings = _settings(about)
    names = measure_names(settings)
    columns = tuple(_texts(about["columns"], "columns"))
    classes = archive.array("classes")
    n_classes = len(classes) if classes.ndim == 1 else 0
    if classes.dtype.kind not in "biufU" or n_classes < 2 or n_classes > _MOST_ROWS:
        raise InputError(f"classes must be two or more texts or numbers, got {classes.dtype} of shape {classes.shape}")
    if not (classes[1:] > classes[:-1]).all():
        raise InputError("classes must be different and in order")
    codes, places = archive.array("landmark_codes"), archive.array("places")
    n = len(codes) if codes.ndim == 1 else 0
    if not 0 < n <= _MOST_ROWS or codes.dtype.kind not in "iu" or places.shape != (n,) or places.dtype.kind != "U":
        raise InputError("landmark_codes and places must be one whole number and one text a landmark")
    if not np.array_equal(np.unique(codes), np.arange(n_classes)):
        raise InputError(f"landmark_codes must name each of {n_classes} classes")
    wanted = {TOUCH: len(names)} | ({NUMBERS: len(columns)} if columns else {})
    given = about["sources"]
    if not isinstance(given, Mapping) or set(given) != set(wanted):
        raise InputError(f"sources must be {', '.join(wanted)}")
    sources = {name: _source(archive, name, given[name], n, wanted[name], n_classes) for name in wanted}
    known = _numbers(archive, "known", (None,))
    if not known.size:
        raise InputError("known must hold at least one number")
    model = TactileClassifier(error=_number(about, "error", 0.0, 1.0))
    model._check_options()
    views = {view_name(name, int(power)): of for name in wanted for power, of in given[name].items()}
    trust = SourceWeights(
        {name: _number(of, "weight", 0.0) for name, of in views.items()},
        {name: _number(of, "mixing", 0.0, 1.0) for name, of in views.items()},
    )
    model.learned_ = Learned(sources, trust, known, _number(about, "loss", 0.0), codes.astype(np.intp))
    model.settings_, model.measure_names_, model.columns_ = settings, tuple(names), columns
    model.n_features_in_ = sum(rows * cols for rows, cols in settings.shapes.values())
    model.classes_, model.places_ = classes, places
    model.remarks_ = tuple(_texts(about["remarks"], "remarks"))
    return model


def _settings(about: Mapping[str, Any]) -> MeasureSettings:
    shapes: dict[str, tuple[int, int]] = {}
    pads = about["pads"]
    if not isinstance(pads, list) or not 0 < len(pads) <= _MOST_PADS:
        raise InputError(f"pads must be a list of 1 to {_MOST_PADS}")
    for name, *sides in pads:
        if not isinstance(name, str) or len(sides) != 2 or name in shapes:
            raise InputError("pads must be different names, each with rows and columns")
        if not all(type(side) is int and 0 < side <= _LONGEST_SIDE for side in sides):
            raise InputError(f"rows and columns of pads must lie between 1 and {_LONGEST_SIDE}, got {sides}")
        shapes[name] = (sides[0], sides[1])
    if about["clock"] not in ("seconds", "frames"):
        raise InputError(f"clock must be seconds or frames, got {about['clock']!r}")
    if not all(isinstance(about[key], bool) for key in ("position", "absolute")):
        raise InputError("position and absolute must be true or false")
    return MeasureSettings(
        shapes,
        _number(about, "floor", 0.0),
        _number(about, "rise", 1e-300),
        about["clock"],
        _number(about, "load", 1e-300),
        about["position"],
        about["absolute"],
    )


def _source(archive: Archive, name: str, given: Any, n: int, n_measures: int, n_classes: int) -> Source:
    if not isinstance(given, Mapping) or not given or not set(given) <= {"1", "2"}:
        raise InputError(f"sources: {name} must have views of the powers 1, 2 or both")
    return Source(
        Scaling(_numbers(archive, f"{name}.shift", (n_measures,)), _numbers(archive, f"{name}.scale", (n_measures,))),
        _numbers(archive, f"{name}.landmarks", (n, n_measures)),
        tuple(_view(archive, name, int(power), given[power], n, n_classes) for power in sorted(given)),
    )


def _view(archive: Archive, name: str, power: int, given: Any, n: int, n_classes: int) -> View:
    of = view_name(name, power)
    whiten = _numbers(archive, f"{of}.whiten", (n, None))
    discriminant = Discriminant(
        power,
        _number(given, "width", 1e-6),
        _number(given, "shrinkage", 0.0, 1.0),
        whiten,
        _numbers(archive, f"{of}.means", (n_classes, whiten.shape[1])),
    )
    typical = np.maximum(_numbers(archive, f"{of}.typical", (2,)), 1e-12)
    return View(discriminant, _number(given, "temperature", 1e-6), typical)


def _number(of: Mapping[str, Any], key: str, least: float, most: float = math.inf) -> float:
    value = of[key]
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"{key} must be a finite number, got {value!r}")
    if not least <= value <= most:
        raise InputError(f"{key} must lie between {least:g} and {most:g}, got {value:g}")
    return float(value)


def _numbers(archive: Archive, name: str, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    array = archive.array(name)
    fits = array.ndim == len(shape) and all(want in (None, got) for want, got in zip(shape, array.shape, strict=True))
    if array.dtype.kind != "f" or not fits:
        told = " x ".join("any" if side is None else str(side) for side in shape)
        raise InputError(f"{name} must be {told} numbers, got {array.dtype} of shape {array.shape}")
    with np.errstate(all="ignore"):
        numbers = array.astype(np.float64)
    if not np.isfinite(numbers).all() or np.abs(numbers).max(initial=0.0) > 1e100:
        raise InputError(f"{name} must be finite")
    return numbers


def _texts(document: Any, what: str) -> list[str]:
    if not isinstance(document, list) or not all(isinstance(item, str) for item in document):
        raise InputError(f"{what} must be a list of texts")
    return document
