"""The model file: an NPZ of plain arrays and one JSON text; reading it runs no code."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.files import Archive, open_archive, parse_json, write_archive
from varishold.learning.classifier import NUMBERS, TOUCH, TactileClassifier
from varishold.learning.discriminant import Discriminant, Scaling
from varishold.learning.entries import (
    checked_codes,
    classes_of,
    landmarks_of,
    number,
    numbers,
    pads_of,
    scale_of,
    texts,
)
from varishold.learning.portable import PortableClassifier
from varishold.learning.portable_file import PORTABLE, portable_entries, portable_model
from varishold.learning.press_classifier import PressClassifier
from varishold.learning.sources import Learned, Source, View, view_name
from varishold.touch.course.measures import MeasureSettings, measure_names, of_forms
from varishold.touch.course.one_sensor import SensorScale
from varishold.trust import SourceWeights

__all__ = ["read_model", "write_model"]

FORMAT, VERSION = "varishold model", 5
# Those of version 2 hold neither unit nor pitch and are read without. Those of other kinds than portable ones are read
# from the version on that measures what a press looks like, and judges what is strange by it.
_OLDEST, _OLDEST_TACTILE = 2, 5


def write_model(model: PressClassifier, path: str | os.PathLike[str]) -> None:
    """Write what was learned, whole or not at all; the same model gives the same bytes.

    Raises
    ------
    InputError
        If it has learned nothing, its labels are neither text nor numbers, or the file cannot be written.
    """
    kind = type(model).__name__
    if not hasattr(model, "learned_"):
        raise InputError(f"this {kind} has not learned anything yet; fit it first")
    if model.adapted_to_:
        raise InputError(f"this {kind} was adapted to one session; write the one that it comes from")
    if model.classes_.dtype.kind not in "biufU":
        raise InputError(f"labels must be text or numbers to be written, got {model.classes_.dtype}")
    if isinstance(model, PortableClassifier):
        about, arrays = portable_entries(model)
    elif isinstance(model, TactileClassifier):
        about, arrays = _entries(model)
    else:
        raise InputError(f"a {kind} cannot be written")
    about |= {
        "format": FORMAT,
        "version": VERSION,
        "pads": [[name, *shape] for name, shape in model.pads_.items()],
        "unit": model.scale_.unit,
        "pitch_m": {name: list(pitch) for name, pitch in model.scale_.pitch_m.items()},
        "error": model.error,
        "remarks": list(model.remarks_),
    }
    arrays |= {
        "about": np.array(json.dumps(about, allow_nan=False, sort_keys=True)),
        "classes": model.classes_,
        "places": model.places_,
        "landmark_codes": model.landmark_codes.astype(np.int32),
    }
    write_archive(arrays, path, kind="model")


def read_model(path: str | os.PathLike[str]) -> PressClassifier:
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
        if version < (_OLDEST if about.get("learner") == PORTABLE else _OLDEST_TACTILE):
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


def _entries(model: TactileClassifier) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return what a model file holds of this kind of model alone."""
    settings, learned = model.settings_, model.learned_
    about = {
        "floor": settings.floor,
        "rise": settings.rise,
        "clock": settings.clock,
        "load": settings.load,
        "least_load": settings.least_load,
        "filled": settings.filled,
        "position": settings.position,
        "absolute": settings.absolute,
        "columns": list(model.columns_),
        "presses": model.n_presses_,
        **_about_learned(learned),
    }
    arrays = _arrays_of(learned)
    if learned.forms is not None:
        about["forms"] = _about_learned(learned.forms)
        arrays["forms.landmark_codes"] = learned.forms.landmark_codes.astype(np.int32)
        arrays |= {f"forms.{name}": of for name, of in _arrays_of(learned.forms).items()}
    return about, arrays


def _about_learned(learned: Learned) -> dict[str, Any]:
    return {
        "loss": learned.loss,
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


def _arrays_of(learned: Learned) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {"known": learned.known}
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
    return arrays


def _model(about: Mapping[str, Any], archive: Archive) -> PressClassifier:
    pads, classes = pads_of(about["pads"]), classes_of(archive)
    codes, places = landmarks_of(archive, len(classes))
    error = number(about, "error", 0.0, 1.0)
    learner = about.get("learner", "tactile")
    if learner not in ("tactile", PORTABLE):
        raise InputError(f"learner must be tactile or {PORTABLE}, got {learner!r}")
    model: PressClassifier
    if learner == PORTABLE:
        model = portable_model(about, archive, pads, len(classes), codes)
    else:
        model = _tactile(about, archive, pads, len(classes), codes)
    model.scale_ = scale_of(about, pads) if about["version"] > _OLDEST else SensorScale()
    model.error = error
    model._check_options()
    model.n_features_in_ = sum(rows * cols for rows, cols in pads.values())
    model.classes_, model.places_ = classes, places
    model.remarks_ = tuple(texts(about["remarks"], "remarks"))
    return model


def _tactile(
    about: Mapping[str, Any],
    archive: Archive,
    pads: Mapping[str, tuple[int, int]],
    n_classes: int,
    codes: NDArray[np.intp],
) -> TactileClassifier:
    settings = _settings(about, pads)
    names = measure_names(settings)
    columns = tuple(texts(about["columns"], "columns"))
    learned = _learned(about, archive, "", names, columns, n_classes, codes)
    if "forms" in about:
        of_form = archive.array("forms.landmark_codes")
        forms = _learned(
            about["forms"],
            archive,
            "forms.",
            measure_names(of_forms(settings)),
            columns,
            n_classes,
            checked_codes(of_form, "forms.landmark_codes", n_classes),
        )
        learned = replace(learned, forms=forms)
    model = TactileClassifier()
    model.learned_ = learned
    model.settings_, model.measure_names_, model.columns_ = settings, tuple(names), columns
    # Files of before do not say it.
    model.n_presses_ = int(number({"presses": len(learned.known), **about}, "presses", 1.0))
    return model


def _learned(
    about: Mapping[str, Any],
    archive: Archive,
    part: str,
    names: Sequence[str],
    columns: Sequence[str],
    n_classes: int,
    codes: NDArray[np.intp],
) -> Learned:
    """Return what stands in a part of the file."""
    wanted = {TOUCH: len(names)} | ({NUMBERS: len(columns)} if columns else {})
    given = about["sources"]
    if not isinstance(given, Mapping) or set(given) != set(wanted):
        raise InputError(f"sources must be {', '.join(wanted)}")
    sources = {name: _source(archive, part, name, given[name], len(codes), wanted[name], n_classes) for name in wanted}
    known = numbers(archive, f"{part}known", (None,))
    if not known.size:
        raise InputError(f"{part}known must hold at least one number")
    views = {view_name(name, int(power)): of for name in wanted for power, of in given[name].items()}
    trust = SourceWeights(
        {name: number(of, "weight", 0.0) for name, of in views.items()},
        {name: number(of, "mixing", 0.0, 1.0) for name, of in views.items()},
    )
    return Learned(sources, trust, known, number(about, "loss", 0.0), codes)


def _settings(about: Mapping[str, Any], pads: Mapping[str, tuple[int, int]]) -> MeasureSettings:
    if about["clock"] not in ("seconds", "frames"):
        raise InputError(f"clock must be seconds or frames, got {about['clock']!r}")
    if not all(isinstance(about[key], bool) for key in ("position", "absolute")):
        raise InputError("position and absolute must be true or false")
    return MeasureSettings(
        pads,
        number(about, "floor", 0.0),
        number(about, "rise", 1e-300),
        about["clock"],
        number(about, "load", 1e-300),
        about["position"],
        about["absolute"],
        number({"least_load": 0.0, **about}, "least_load", 0.0),
        number({"filled": 0.0, **about}, "filled", 0.0, 1.0),
    )


def _source(archive: Archive, part: str, name: str, given: Any, n: int, n_measures: int, n_classes: int) -> Source:
    if not isinstance(given, Mapping) or not given or not set(given) <= {"1", "2"}:
        raise InputError(f"sources: {name} must have views of the powers 1, 2 or both")
    name = part + name
    return Source(
        Scaling(numbers(archive, f"{name}.shift", (n_measures,)), numbers(archive, f"{name}.scale", (n_measures,))),
        numbers(archive, f"{name}.landmarks", (n, n_measures)),
        tuple(_view(archive, name, int(power), given[power], n, n_classes) for power in sorted(given)),
    )


def _view(archive: Archive, name: str, power: int, given: Any, n: int, n_classes: int) -> View:
    of = view_name(name, power)
    whiten = numbers(archive, f"{of}.whiten", (n, None))
    discriminant = Discriminant(
        power,
        number(given, "width", 1e-6),
        number(given, "shrinkage", 0.0, 1.0),
        whiten,
        numbers(archive, f"{of}.means", (n_classes, whiten.shape[1])),
    )
    typical = np.maximum(numbers(archive, f"{of}.typical", (2,)), 1e-12)
    return View(discriminant, number(given, "temperature", 1e-6), typical)
