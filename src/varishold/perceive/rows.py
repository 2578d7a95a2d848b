"""Evidence from any hand: from the rows of a grasp table and from the recordings of its pads.

What is missing is left out and said in a remark; the belief then is less sure and nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from varishold.errors import InputError, require, require_a
from varishold.frame.checks import as_names
from varishold.perceive.evidence import Evidence, pad_values
from varishold.perceive.name_evidence import names_in_words
from varishold.recording import GraspTable, Pad, Recording
from varishold.recording.grasp_table import listed
from varishold.recording.mended import without_faults
from varishold.skin import Skin
from varishold.touch.pads.surface import feel_surface

__all__ = ["evidence_of_recording", "evidence_of_row", "merge_evidence"]

# Columns that say which grasp it was and how it ended, not what was felt.
_NOT_FELT = frozenset({"object", "size_m", "seed", "step", "held", "attempt", "attempts", "outcome"})
# A pad that reads one value other than 0 in all of at least so many frames is broken.
_FEWEST_FRAMES = 8
_FEWEST_TAXELS = 3


def evidence_of_row(table: GraspTable, k: int, *, touch: str = "grasp", columns: str | Sequence[str] = "*") -> Evidence:
    """Return one row of a grasp table as evidence.

    Parameters
    ----------
    table : GraspTable
        ``switch.NAME``, ``angle_rad.NAME``, ``force_n.NAME`` and every other column of numbers keep their names. Text,
        and what says which grasp it was and how it ended (object, size, seed, step, held, attempts), is no evidence.
    k : int
        Number of the row, from 0.
    touch : str
        What was done.
    columns : str or sequence of str
        Globs of columns that count. Default: all.

    Returns
    -------
    Evidence
        NaN where a cell is empty, which its remarks say.

    Raises
    ------
    InputError
        If there is no such row, no column of numbers that was felt, or a value is infinite.

    Examples
    --------
    >>> import numpy as np
    >>> cells = {"object": np.array(["cone"]), "switch.v1": np.array([True]), "angle_rad.v": np.array([np.nan])}
    >>> evidence = evidence_of_row(GraspTable(cells), 0)
    >>> dict(evidence.values), evidence.remarks
    ({'switch.v1': 1.0, 'angle_rad.v': nan}, ('grasp: nothing is known of angle_rad.v',))
    """
    require_a(GraspTable, table, "table", "as read_grasp_table gives it")
    columns = columns if isinstance(columns, str) else as_names(columns, "columns")
    number = _index("row", k, len(table), table.source)
    felt = [name for name in table.names(columns) if name not in _NOT_FELT and table.cells[name].dtype.kind in "biuf"]
    if not felt:
        patterns = (columns,) if isinstance(columns, str) else tuple(columns)
        raise InputError(f"{table.source}: no column of numbers that was felt matches {listed(patterns)}")
    values = {name: float(table.cells[name][number]) for name in felt}
    for name, value in values.items():
        place = f"{table.where(number)}, column {name!r}"
        require(not np.isinf(value), f"{place} must be finite, got {value}")
        on_off = not name.startswith("switch.") or value in (0.0, 1.0) or np.isnan(value)
        require(on_off, f"{place} must be 0 or 1, got {value:g}")
    empty = [name for name, value in values.items() if np.isnan(value)]
    return Evidence(touch, values, (f"{touch}: nothing is known of {names_in_words(empty)}",) if empty else ())


def evidence_of_recording(
    recording: Recording,
    *,
    touch: str = "grasp",
    frame: int | None = None,
    skin: Skin | Mapping[str, Skin] | None = None,
    pitch_m: float | tuple[float, float] | None = None,
    size_m: float | None = None,
    pads: Sequence[str] | None = None,
) -> Evidence:
    """Return what the pads of a hand felt as evidence: the surface under each.

    Parameters
    ----------
    recording : Recording
        One touch.
    touch : str
        What was done.
    frame : int, optional
        The frame that is looked at. Default: that of the largest total. Readings that stand alone in time and place
        are replaced first, which is remarked.
    skin : Skin or mapping of str to Skin, optional
        Of all pads, or of each by its name. Without one, or where the recording's unit is no pressure, pressure itself
        is looked at, which says less.
    pitch_m : float or (float, float), optional
        Taxel spacing of pads that do not know their own. Metres.
    size_m : float, optional
        The gripped size, which curvatures are compared with. Metres.
    pads : sequence of str, optional
        The pads that count; one that the recording does not hold is remarked. Default: all that it holds.

    Returns
    -------
    Evidence
        A pad that nothing presses says so. One that is missing or broken, has fewer than 3 x 3 taxels or no known
        spacing is left out, which is remarked.

    Raises
    ------
    InputError
        If there is no such frame, or the spacing is impossible.
    """
    require_a(Recording, recording, "recording", "as read(path) gives it")
    _check_skin(skin)
    pads = None if pads is None else as_names(pads, "pads")
    given, recording = recording, without_faults(recording)
    if frame is None:
        frame = int(np.argmax(recording.totals()))
    number = _index("frame", frame, recording.n_frames, recording.source or "recording")
    values: dict[str, float] = {}
    remarks, reasons = [], []
    for name in recording.pads if pads is None else pads:
        pad = recording.pads.get(name)
        spacing = pitch_m if pad is None or pad.pitch_m is None else pad.pitch_m
        wrong = _wrong(pad, spacing)
        if pad is None or spacing is None or wrong:
            remarks.append(f"{touch}: pad {name} is left out: {wrong}")
            continue
        try:
            through, remark = _skin_of(name, skin, recording)
            surface = feel_surface(
                np.asarray(pad.frames[number], dtype=np.float64) * (recording.pascals_per_unit or 1.0),
                through,
                pitch_m=spacing,
                field=pad.field,
                valid=pad.valid,
            )
        except InputError as error:
            raise InputError(f"pad {name}: {error}") from error
        mended = pad.notes[len(given.pads[name].notes) :]
        remarks += [f"{touch}: pad {name}: {said}" for said in ((remark, *mended) if remark else mended)]
        values |= pad_values(name, surface, size_m=size_m)
        said = "nothing presses it" if surface is None else f"{surface.name} with probability {surface.probability:.2f}"
        reasons.append(f"pad {name}: {said}")
    return Evidence(touch, values, tuple(remarks), tuple(reasons))


def merge_evidence(*parts: Evidence) -> Evidence:
    """Return as one what several sensors said of the same touch.

    Raises
    ------
    InputError
        If there is none, they are of different touches, or give one name two different values.

    Examples
    --------
    >>> both = merge_evidence(Evidence("grasp", {"switch.v1": 1}), Evidence("grasp", {"angle_rad.v": 0.5}))
    >>> dict(both.values)
    {'switch.v1': 1.0, 'angle_rad.v': 0.5}
    """
    require(parts, "there is no evidence to merge")
    values: dict[str, float] = {}
    for part in parts:
        require_a(Evidence, part, "evidence to merge", "of one sensor")
        same = part.touch == parts[0].touch
        require(same, f"evidence of two touches cannot be merged: {parts[0].touch!r} and {part.touch!r}")
        for name, value in part.values.items():
            known = values.get(name, np.nan)
            agree = np.isnan(known) or np.isnan(value) or known == value
            require(agree, f"{name} of touch {part.touch!r} has two values, {known:g} and {value:g}")
            values[name] = value if np.isnan(known) else known
    remarks = dict.fromkeys(remark for part in parts for remark in part.remarks)
    reasons = dict.fromkeys(reason for part in parts for reason in part.reasons)
    failed = any(part.failed for part in parts)
    return Evidence(parts[0].touch, values, tuple(remarks), tuple(reasons), failed=failed)


def _check_skin(skin: object) -> None:
    for one in skin.values() if isinstance(skin, Mapping) else [skin]:
        if one is not None:
            require_a(Skin, one, "skin", "of all pads, or of each by its name")


def _index(what: str, k: int, n: int, source: str) -> int:
    there = f"{what}s are numbered 0 to {n - 1}" if n else f"it has no {what}s"
    whole = isinstance(k, (int, np.integer)) and not isinstance(k, bool)
    require(whole and 0 <= k < n, f"{source}: there is no {what} {k!r}: {there}")
    return int(k)


def _wrong(pad: Pad | None, spacing: float | tuple[float, float] | None) -> str:
    """Say why a pad cannot tell a surface; nothing where it can."""
    if pad is None:
        return "the recording does not hold it"
    if min(pad.shape) < _FEWEST_TAXELS:
        return f"its {pad.shape[0]} x {pad.shape[1]} taxels are too few to tell a surface"
    if spacing is None:
        return "its taxel spacing is unknown; give pitch_m"
    low, high = pad.extent.low[pad.usable], pad.extent.high[pad.usable]
    if pad.n_frames >= _FEWEST_FRAMES and (low == high).all() and (low != 0).any():
        return "none of its taxels works: their values never change"
    return ""


def _skin_of(name: str, skin: Skin | Mapping[str, Skin] | None, recording: Recording) -> tuple[Skin | None, str]:
    """Return the skin through which a pad is seen, and what stands in the way of it."""
    own = skin.get(name) if isinstance(skin, Mapping) else skin
    if own is not None and recording.pascals_per_unit is None:
        return None, f"its skin is of no use: {recording.unit!r} is no unit of pressure"
    return own, ""
