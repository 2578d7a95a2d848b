"""The model: what was learned from a grasp table, and what it answers to another."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.circuit import Netlist
from varishold.circuit.netlist import MAX_NAME_LENGTH
from varishold.errors import FormatError, InputError, require, require_a
from varishold.grasp.answer import GraspAnswer, Readings, readings_of
from varishold.grasp.classifier import HyperplaneClassifier
from varishold.grasp.encoder import MOST_CUT, ThresholdEncoder, with_encoder
from varishold.recording import GraspTable, iter_grasp_table
from varishold.trust import held_out_beyond

__all__ = ["GraspModel", "fit_model"]

# Of a column or a label; a circuit says beside it how an input becomes a whole number.
_LONGEST_NAME = MAX_NAME_LENGTH - 100


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
                f"{table.source}: there is no column {missing[0]!r}{more}; the model reads "
                f"{counted(len(self.columns), 'column')} of these names"
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
                f"{os.fspath(path)}: has none of the model's {counted(len(self.columns), 'column')}, "
                f"{self.columns[0]!r} the first"
            ) from error

    def answer(self, table: GraspTable, *, why: bool = False) -> Iterator[GraspAnswer]:
        """Answer every row; `why` asks for the reasons, which take longer than the answer."""
        read = self.readings(table)
        labels, probabilities, p_values = self.classifier.judge(read.switches, beyond=read.beyond)
        outside = (tuple(compress(self.columns, row)) for row in read.outside)
        rejected = self.classifier.outside(p_values) | np.isnan(read.switches).all(axis=1)
        told = probabilities.max(axis=1).tolist(), p_values.tolist(), rejected.tolist()
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
