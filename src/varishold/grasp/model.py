"""The model: what was learned from a grasp table, and its file.

A model file is JSON and versioned. It holds the encoder's thresholds and ranges, the training grasps with their groups,
the hyperplanes, the netlist and what it answers to training grasps; reading it computes nothing but checks and how sure
answers are, and runs no code.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.circuit import Netlist
from varishold.circuit.netlist import MAX_NAME_LENGTH
from varishold.errors import FormatError, InputError, require, require_a
from varishold.files import atomic_write, read_json
from varishold.grasp.answer import GraspAnswer, Readings, readings_of
from varishold.grasp.classifier import HyperplaneClassifier
from varishold.grasp.encoder import MOST_CUT, MOST_LEVELS, ThresholdEncoder, with_encoder
from varishold.grasp.held_out import held_out_of
from varishold.grasp.hyperplanes import Hyperplanes
from varishold.grasp.modes.learned import Learned, units_of
from varishold.grasp.separating import Selection
from varishold.grasp.training import training_grasps
from varishold.recording import GraspTable, iter_grasp_table
from varishold.trust import Ranges, held_out_beyond

__all__ = ["GraspModel", "fit_model", "read_model", "write_model"]

FORMAT, VERSION = "varishold grasp model", 3
#: A larger file is none of ours: 10,000 grasps of 1,000 switches take about 30 MB.
_LARGEST_FILE = 1 << 30
# Of a column or a label; a circuit says beside it how an input becomes a whole number.
_LONGEST_NAME = MAX_NAME_LENGTH - 100
# Training grasps, at most, that are answered when a file is read; very large circuits take a millisecond for one.
_ANSWERED = 1000


@dataclass(frozen=True, eq=False)
class GraspModel:
    """A classifier with the columns that it reads and the encoder before it.

    Parameters
    ----------
    columns : tuple of str
        Columns of the grasp table, in order.
    label : str
        Column that named the classes.
    encoder : ThresholdEncoder or None
        None: the columns are switches.
    classifier : HyperplaneClassifier
    """

    columns: tuple[str, ...]
    label: str
    encoder: ThresholdEncoder | None
    classifier: HyperplaneClassifier

    @property
    def netlist(self) -> Netlist:
        """The circuit from the columns (switches, or counts of them) to the class."""
        inner = self.classifier.netlist_
        if self.encoder is None:
            return replace(inner, channels=self.columns)
        return with_encoder(inner, self.encoder, self.columns)

    @property
    def counts(self) -> list[str]:
        """How a column becomes the circuit's whole count, where it is not one already."""
        if self.encoder is None:
            return []
        return [
            f"the circuit reads {name} as floor(value / {step!r})"
            for name, step in zip(self.columns, self.encoder.resolution_.tolist(), strict=True)
            if step != 1.0
        ]

    @property
    def inputs_in_words(self) -> tuple[str, ...]:
        """What each of the circuit's inputs is: a column, and how it becomes a whole count where it is not one."""
        if self.encoder is None:
            return self.columns
        return tuple(
            name if step == 1.0 else f"{name} in whole steps of {step!r}, rounded down"
            for name, step in zip(self.columns, self.encoder.resolution_.tolist(), strict=True)
        )

    def readings(self, table: GraspTable) -> Readings:
        """What the classifier sees of every row; empty cells are unknown."""
        missing = [name for name in self.columns if name not in table.cells]
        if missing:
            more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
            raise InputError(
                f"{table.source}: there is no column {missing[0]!r}{more}; the model reads {len(self.columns)} "
                "columns of these names"
            )
        return readings_of(_values(table, self.columns, self.encoder, unknown=True), self.encoder)

    @property
    def switch_names(self) -> tuple[str, ...]:
        """What each switch is called: its column, or a column and the threshold that cuts it."""
        names = tuple(name.removeprefix("switch.") for name in self.columns)
        return names if self.encoder is None else tuple(map(str, self.encoder.get_feature_names_out(names)))

    def answer_file(self, path: str | os.PathLike[str], *, why: bool = False) -> Iterator[Iterator[GraspAnswer]]:
        """Answer a grasp table of any length, some rows at a time: each item as `answer` returns it."""
        try:
            for block in iter_grasp_table(path, columns=[_literal(name) for name in self.columns]):
                yield self.answer(block, why=why)
        except FormatError:
            raise
        except InputError as error:
            if "no column matches" not in str(error):
                raise
            raise InputError(
                f"{os.fspath(path)}: has none of the model's {len(self.columns)} columns, {self.columns[0]!r} the first"
            ) from error

    def answer(self, table: GraspTable, *, why: bool = False) -> Iterator[GraspAnswer]:
        """Answer every row; `why` asks for the reasons, which take longer than the answer."""
        read = self.readings(table)
        labels, probabilities, p_values = self.classifier.judge(read.switches, beyond=read.beyond)
        outside = (tuple(compress(self.columns, row)) for row in read.outside)
        told = probabilities.max(axis=1).tolist(), p_values.tolist(), self.classifier.outside(p_values).tolist()
        names = self.switch_names if why else ()
        reasons = (tuple(self.classifier.explain(row).reasons(names)) if why else () for row in read.switches)
        return map(GraspAnswer, map(str, labels), *told, outside, reasons)


def fit_model(
    table: GraspTable,
    *,
    label: str,
    group: str | None = None,
    columns: str | None = None,
    mode: str = "auto",
    encode: str | None = None,
    levels: int = 4,
    seed: int = 0,
) -> GraspModel:
    """Learn a model from a grasp table.

    Parameters
    ----------
    table : GraspTable
    label : str
        Column with the classes.
    group : str, optional
        Column with each grasp's session, or the piece of its object: what is held out together to tell how sure answers
        are.
    columns : str, optional
        Glob of the columns to read; ``switch.*`` where there are such, else every column but the label and the group.
    mode : {"auto", "paper", "robust", "vote"}
    encode : {"quantile", "even", "supervised"}, optional
        Cut the columns at thresholds; without it they must be switches.
    levels : int
        Thresholds a column.
    seed : int

    Raises
    ------
    InputError
        Naming line and column of what cannot be used.
    """
    require_a(GraspTable, table, "table", "as read_grasp_table(path) gives it")
    for name, column in (("label", label), ("group", group)):
        require(column is None or isinstance(column, str), f"{name} must be the name of a column, got {column!r}")
    labels = table.labels(label)
    groups = None if group is None else table.labels(group)
    names = _chosen_columns(table, columns, (label, group))
    _check_lengths(table, names, labels)
    encoder = None
    if encode is not None:
        _check_cuttable(table, names)
        encoder = ThresholdEncoder(encode, levels=levels).fit(table.matrix(names), labels)  # type: ignore[arg-type]
    values = _values(table, names, encoder)
    classifier = HyperplaneClassifier(mode, random_state=seed)  # type: ignore[arg-type]
    if len(np.unique(labels)) < 2:
        raise InputError(
            f"{table.source}: column {label!r} must name at least two classes, got only {str(labels[0])!r}"
        )
    classifier.fit(readings_of(values, encoder).switches, labels, groups)
    if encoder is not None:
        classifier._know(levels * held_out_beyond(values, classifier._groups).sum(axis=1))
    return GraspModel(names, label, encoder, classifier)


def _check_lengths(table: GraspTable, names: tuple[str, ...], labels: NDArray[np.str_]) -> None:
    """Refuse names that no circuit takes: it is written with them."""
    for name in names:
        if len(name) > _LONGEST_NAME:
            raise InputError(
                f"{table.source}: column {name[:40] + '...'!r} has a name of {len(name)} characters; "
                f"give it one of at most {_LONGEST_NAME}"
            )
    long = np.flatnonzero(np.char.str_len(labels) > _LONGEST_NAME)
    if long.size:
        raise InputError(
            f"{table.where(int(long[0]))}: its label has {len(labels[long[0]])} characters; give it at most "
            f"{_LONGEST_NAME}"
        )


def _check_cuttable(table: GraspTable, names: tuple[str, ...]) -> None:
    for name in names:
        values = table.numbers(name).astype(np.float64)
        far = np.flatnonzero(np.abs(values) > MOST_CUT)
        if far.size:
            raise InputError(
                f"{table.where(int(far[0]))}, column {name!r} must lie within {MOST_CUT:g} of zero to be cut, "
                f"got {values[far[0]]:g}"
            )


def _chosen_columns(table: GraspTable, columns: str | None, named: tuple[str | None, ...]) -> tuple[str, ...]:
    found = tuple(name for name in (table.columns if columns is None else table.names(columns)) if name not in named)
    switches = tuple(name for name in found if name.startswith("switch."))
    if not found:
        raise InputError(f"{table.source}: no column is left to learn from beside the label {named[0]!r}")
    return switches if switches and columns is None else found


def _values(
    table: GraspTable, names: tuple[str, ...], encoder: ThresholdEncoder | None, *, unknown: bool = False
) -> NDArray[np.float64]:
    values = np.column_stack([table.numbers(name, unknown=unknown).astype(np.float64) for name in names])
    strange = (values != 0) & (values != 1) & ~np.isnan(values)
    if encoder is None and strange.any():
        row, column = np.argwhere(strange)[0]
        raise InputError(
            f"{table.where(int(row))}, column {names[column]!r} must be 0 or 1, "
            f"got {values[row, column]:g}; choose columns of switches, or cut numbers at thresholds",
            parameter="encode",
        )
    return values


def _literal(name: str) -> str:
    """A glob that matches this column name only."""
    return "".join(f"[{c}]" if c in "*?[" else c for c in name)


def write_model(model: GraspModel, path: str | os.PathLike[str]) -> None:
    """Write a model file, whole or not at all."""
    with atomic_write(path, "w") as file:
        json.dump(_document(model), file, allow_nan=False, separators=(",", ":"))
        file.write("\n")


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
    classes = _texts(document["classes"], "classes")
    ordered = len(classes) > 1 and sorted(set(classes)) == classes
    require(ordered, "classes must be two or more different names in order")
    encoder = _encoder(document["encoder"], len(columns))
    width = len(columns) if encoder is None else int(encoder.bits_per_channel_.sum())
    rows = _grasps(document["grasps"], width)
    codes = _whole(document["labels"], "labels", 0, len(classes) - 1)
    require(len(codes) == len(rows) and len(rows), f"{len(rows)} grasps need as many labels, got {len(codes)}")
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
    require(fits, f"netlist does not fit the grasps: {len(netlist.channels)} switches, want {width}")
    clf._rows, clf._codes, clf._groups, clf.classes_ = rows, codes, groups, np.array(classes)
    clf._adopt(grasps, str(document["mode"]), Learned(planes, netlist, selection, notes))
    clf._know(beyond)
    together = clf.netlist_ == netlist and netlist.units == units_of(planes)
    # No fit makes a term that is always true.
    together = together and all(term.literals for term in netlist.terms)
    require(together, "netlist and hyperplanes do not belong together")
    _check_answers(clf, document["answers"])
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
        require(len(row) == width and not row.strip("01"), f"grasps[{k}] must be {width} characters 0 or 1")
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
