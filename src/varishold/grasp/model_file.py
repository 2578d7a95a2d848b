"""A model's file: JSON, versioned.

It holds the encoder's thresholds and ranges, the training grasps with their groups, the hyperplanes, the netlist and
what it answers to training grasps; reading it computes nothing but checks and how sure answers are, and runs no code.
A checksum tells that a number or a name in it was changed; what older programs wrote has none, and they pass it over.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.circuit import Netlist
from varishold.errors import FormatError, InputError, require
from varishold.files import atomic_write, read_json
from varishold.grasp.classifier import HyperplaneClassifier
from varishold.grasp.encoder import MOST_LEVELS, ThresholdEncoder
from varishold.grasp.held_out import held_out_of
from varishold.grasp.hyperplanes import Hyperplanes
from varishold.grasp.model import GraspModel
from varishold.grasp.modes.learned import Learned, units_of
from varishold.grasp.separating import Selection
from varishold.grasp.training import training_grasps
from varishold.trust import Ranges

__all__ = ["read_model", "write_model"]

FORMAT, VERSION = "varishold grasp model", 3
_CHECKSUM = "checksum"
#: A larger file is none of ours: 10,000 grasps of 1,000 switches take about 30 MB.
_LARGEST_FILE = 1 << 30
# Training grasps, at most, that are answered when a file is read; very large circuits take a millisecond for one.
_ANSWERED = 1000


def write_model(model: GraspModel, path: str | os.PathLike[str]) -> None:
    """Write a model file, whole or not at all."""
    document = _document(model)
    with atomic_write(path, "w") as file:
        json.dump({**document, _CHECKSUM: _checksum(document)}, file, allow_nan=False, separators=(",", ":"))
        file.write("\n")


def _checksum(document: Mapping[str, Any]) -> str:
    """Return a digest of a model's document, however it is laid out and its numbers are written."""
    said = {name: value for name, value in document.items() if name != _CHECKSUM}
    plain = json.loads(json.dumps(said), parse_int=float)
    return hashlib.blake2b(json.dumps(plain, sort_keys=True).encode(), digest_size=16).hexdigest()


def _document(model: GraspModel) -> dict[str, Any]:
    clf = model.classifier
    encoder = None
    if model.encoder is not None:
        encoder = {
            "strategy": model.encoder.strategy,
            "levels": model.encoder.levels,
            "resolution": model.encoder.resolution_.tolist(),
            "thresholds": [row.tolist() for row in model.encoder.thresholds_],
            "ranges": np.column_stack([model.encoder.ranges_.low, model.encoder.ranges_.high]).tolist(),
        }
    return {
        "format": FORMAT,
        "version": VERSION,
        "columns": list(model.columns),
        "label": model.label,
        "encoder": encoder,
        "mode": clf.mode_,
        "classes": [str(label) for label in clf.classes_],
        "grasps": ["".join("01"[int(bit)] for bit in row) for row in clf._rows],
        "labels": clf._codes.tolist(),
        "groups": clf._groups.tolist(),
        "beyond": clf._beyond.tolist(),
        "hyperplanes": [
            {"weights": [[int(k), int(row[k])] for k in np.flatnonzero(row)], "pair": pair}
            for row, pair in zip(clf.hyperplanes_.weights, clf.hyperplanes_.pairs.tolist(), strict=True)
        ],
        "selection": None
        if clf.selection_ is None
        else {"columns": list(clf.selection_.columns), "lower_bound": clf.selection_.lower_bound},
        "notes": dict(clf.notes_),
        "netlist": clf.netlist_.to_dict(),
        "answers": clf._answers(_some(clf._rows)).tolist(),
    }


def read_model(path: str | os.PathLike[str]) -> GraspModel:
    """Read a model file, trusting nothing in it.

    Raises
    ------
    FormatError
        In one line: what is wrong with the file, and where.
    """
    name = os.fspath(path)
    document = read_json(path)
    if not isinstance(document, Mapping) or document.get("format") != FORMAT:
        raise FormatError(f"{name}: is no model file, as write_model and 'varishold grasp fit' make them")
    version = document.get("version")
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        raise FormatError(f"{name}: version must be a positive whole number, got {version!r}")
    if version > VERSION:
        raise FormatError(f"{name}: is of version {version}, this program reads up to {VERSION}; update varishold")
    try:
        # The first version knew neither groups nor ranges, the second no answers.
        unknown = {1: ("groups", "beyond", "answers"), 2: ("answers",)}.get(version, ())
        return _model({**dict.fromkeys(unknown), **document}, name)
    except FormatError:
        raise
    except (InputError, ValueError, TypeError, KeyError, IndexError, OverflowError, AttributeError) as error:
        what = f"{error.args[0]!r} is missing" if isinstance(error, KeyError) else str(error)
        raise FormatError(f"{name}: {' '.join(what.split())}; fit the model again") from error


def _model(document: Mapping[str, Any], name: str) -> GraspModel:
    columns = tuple(_texts(document["columns"], "columns"))
    require(len({*columns}) == len(columns), "columns must all differ")
    classes = _texts(document["classes"], "classes")
    ordered = len(classes) > 1 and sorted(set(classes)) == classes
    require(ordered, "classes must be two or more different names in order")
    encoder = _encoder(document["encoder"], len(columns))
    width = len(columns) if encoder is None else int(encoder.bits_per_channel_.sum())
    rows = _grasps(document["grasps"], width)
    codes = _whole(document["labels"], "labels", 0, len(classes) - 1)
    require(
        len(codes) == len(rows) and len(rows),
        f"{counted(len(rows), 'grasp needs', 'grasps need')} as many labels, got {len(codes)}",
    )
    planes = _hyperplanes(document["hyperplanes"], width)
    groups, beyond = held_out_of(document, len(rows))
    netlist = Netlist.from_dict(document["netlist"], where=f"{name}: netlist")
    require(isinstance(document["label"], str), "label must be the name of a column")
    clf = HyperplaneClassifier(str(document["mode"]))  # type: ignore[arg-type]
    clf._check_options()
    clf.n_features_in_ = width
    grasps = training_grasps(rows, codes.tolist())
    chosen = document["selection"]
    selection = None
    if chosen is not None:
        taken = _whole(chosen["columns"], "selection columns", 0, 2**31)
        bound = _whole([chosen["lower_bound"]], "lower bound", 0, 2**31)
        selection = Selection(tuple(taken.tolist()), int(bound[0]))
    notes = {str(k): str(v) for k, v in dict(document["notes"]).items()}
    fits = len(netlist.classes) == grasps.n_classes and len(netlist.channels) == width and not netlist.comparators
    require(fits, f"netlist does not fit the grasps: {counted(len(netlist.channels), 'switch')}, want {width}")
    clf._rows, clf._codes, clf._groups, clf.classes_ = rows, codes, groups, np.array(classes)
    clf._adopt(grasps, str(document["mode"]), Learned(planes, netlist, selection, notes))
    clf._know(beyond)
    together = clf.netlist_ == netlist and netlist.units == units_of(planes)
    # No fit makes a term that is always true.
    together = together and all(term.literals for term in netlist.terms)
    require(together, "netlist and hyperplanes do not belong together")
    _check_answers(clf, document["answers"])
    if document.get(_CHECKSUM) not in (None, _checksum(document)):
        raise FormatError(
            f"{name}: was changed after it was written, by its {_CHECKSUM}; fit the model again, or take the "
            f"{_CHECKSUM} out where that was meant"
        )
    return GraspModel(columns, str(document["label"]), encoder, clf)


def _check_answers(clf: HyperplaneClassifier, document: Any) -> None:
    """Refuse a netlist that answers other than the one that was written, or than its mode makes one."""
    found = clf._answers(_some(clf._rows))
    told = found if document is None else _whole(document, "answers", 0, len(clf.classes_) - 1)
    require(len(told) == len(found), f"answers must be those of {len(found)} training grasps, got {len(told)}")
    other = found != told
    if clf.mode_ == "paper":
        # Its tables part all grasps, but those that contradict others.
        other |= (_some(clf.grasps_.owners) >= 0) & (found != _some(clf._codes))
    if other.any():
        k = int(np.flatnonzero(other)[0])
        raise InputError(
            f"netlist answers {str(clf.classes_[found[k]])!r} to training grasp {k * _stride(len(clf._rows))} (counted "
            "from 0), another than was learned: its terms or scores are not those that belong to the tables"
        )


def _some(of_grasps: NDArray[Any]) -> NDArray[Any]:
    return of_grasps[:: _stride(len(of_grasps))]


def _stride(n: int) -> int:
    return -(-n // _ANSWERED)


def _encoder(document: Any, channels: int) -> ThresholdEncoder | None:
    if document is None:
        return None
    encoder = ThresholdEncoder(document["strategy"], levels=int(document["levels"]))
    require(1 <= encoder.levels <= MOST_LEVELS, f"the encoder's levels must lie between 1 and {MOST_LEVELS}")
    resolution = np.array(document["resolution"], dtype=np.float64)
    thresholds = [np.array(row, dtype=np.float64) for row in document["thresholds"]]
    fits = resolution.shape == (channels,) and len(thresholds) == channels
    fits = fits and bool(np.isfinite(resolution).all()) and bool((resolution > 0).all())
    require(fits, "the encoder must have a positive resolution and thresholds for every column")
    for row, step in zip(thresholds, resolution.tolist(), strict=True):
        rising = row.ndim == 1 and len(row) and np.isfinite(row).all() and (np.diff(row) > 0).all()
        require(rising, "the encoder's thresholds of a column must be rising finite numbers")
        small = max(abs(row[0]), abs(row[-1])) < step * 2.0**31
        require(small, "the encoder's thresholds must fit 32 signed bits when counted in its resolution")
    encoder.resolution_, encoder.thresholds_, encoder.n_features_in_ = resolution, thresholds, channels
    ranges = np.array(document.get("ranges", [[np.inf, -np.inf]] * channels), dtype=np.float64)
    told = ranges.shape == (channels, 2) and not np.isnan(ranges).any()
    require(told, "the encoder's ranges must be the least and the largest number of every column")
    encoder.ranges_ = Ranges(*ranges.T)
    return encoder


def _grasps(document: Any, width: int) -> NDArray[np.bool_]:
    rows = _texts(document, "grasps")
    for k, row in enumerate(rows):
        require(len(row) == width and not row.strip("01"), f"grasps[{k}] must be {counted(width, 'character')} 0 or 1")
    return np.array([[bit == "1" for bit in row] for row in rows], dtype=np.bool_).reshape(len(rows), width)


def _hyperplanes(document: Any, width: int) -> Hyperplanes:
    require(isinstance(document, list), "hyperplanes must be a list")
    few = len(document) * width <= _LARGEST_FILE
    require(few, f"{len(document)} hyperplanes of {width} switches are more than any fit makes")
    weights = np.zeros((len(document), width), dtype=np.int8)
    pairs = np.empty((len(document), 2), dtype=np.int64)
    for k, plane in enumerate(document):
        for switch, weight in plane["weights"]:
            weighs = type(switch) is int and 0 <= switch < width and weight in (-1, 1)
            require(weighs, f"hyperplanes[{k}] must weigh switches 0 to {width - 1} by -1 or 1")
            weights[k, switch] = weight
        pairs[k] = _whole(plane["pair"], f"hyperplanes[{k}] pair", -1, 2**31)
    return Hyperplanes(weights, pairs=pairs)


def _texts(document: Any, what: str) -> list[str]:
    right = isinstance(document, list) and all(isinstance(item, str) for item in document)
    require(right, f"{what} must be a list of texts")
    return list(document)


def _whole(document: Any, what: str, low: int, high: int) -> NDArray[np.int64]:
    if not isinstance(document, list) or not all(type(n) is int and low <= n <= high for n in document):
        raise InputError(f"{what} must be a list of whole numbers from {low} to {high}")
    return np.array(document, dtype=np.int64)
