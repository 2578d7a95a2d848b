"""A grasp as rows of a grasp table, as plain values for a program that reads JSON, and its pads as a recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.hand.actions import Step
from varishold.hand.grasping import Grasp, HandSetting
from varishold.hand.layouts import Layout
from varishold.hand.model import CARRIAGE
from varishold.recording import GraspTable, Pad, Recording

__all__ = ["Row", "grasp_rows", "grasp_table", "grasp_to_dicts", "made_with", "pads_recording", "require_layout"]

Row = dict[str, Any]


def grasp_rows(done: Grasp, setting: HandSetting, *, steps: Sequence[int] = (5,)) -> list[Row]:
    """Return a grasp's rows for a grasp table.

    A grasp that ended before the last wanted step gets one row for its end, with `held` False.

    Parameters
    ----------
    done : Grasp
    setting : HandSetting
        The setting it was made with.
    steps : sequence of int
        The steps that get a row each.
    """
    wanted = [step for step in done.steps if step.number in steps]
    if not wanted or (done.end.number < max(steps) and done.end.number not in steps):
        wanted.append(done.end)
    rows = []
    for step in wanted:
        row: Row = {
            "object": done.name,
            "size_m": done.size_m,
            "seed": done.seed,
            "step": step.number,
            "held": step.held,
            "attempts": len(done.attempts),
            **made_with(setting),
        }
        sensed = step.sensed
        names = setting.layout.names
        row |= {f"switch.{name}": bool(on) for name, on in zip(names, sensed.switches, strict=True)}
        row |= {f"angle_rad.{name}": float(a) for name, a in zip(setting.design.joints, sensed.angles_rad, strict=True)}
        row |= {f"force_n.{name}": float(f) for name, f in zip(names, sensed.forces_n, strict=True)}
        rows.append(row)
    return rows


def made_with(setting: HandSetting) -> Row:
    """Return what the rows of a table say of how they were made; all of one table say the same."""
    return {
        "finger_scale": setting.design.finger_scale,
        "searched": int(setting.search),
        "still": int(setting.still),
        "hand": setting.design.identity,
    }


def grasp_table(rows: Sequence[Row], *, source: str = "table") -> GraspTable:
    """Make a grasp table of rows that all have the same columns."""
    cells: dict[str, NDArray[Any]] = {}
    for name, first in rows[0].items():
        kind = np.str_ if isinstance(first, str) else np.bool_ if isinstance(first, bool) else np.float64
        cells[name] = np.array([row[name] for row in rows], dtype=kind)
    return GraspTable(cells, source)


def require_layout(table: GraspTable, layout: Layout) -> None:
    """Check that a table's switches are those of a layout, in its order.

    Raises
    ------
    InputError
        If they are another hand's.
    """
    got = tuple(name.removeprefix("switch.") for name in table.columns if name.startswith("switch."))
    if got != layout.names:
        odd = [name for name in got if name not in layout.names] or list(got[:1]) or ["none"]
        raise InputError(
            f"{table.source}: has {counted(len(got), 'switch')} (among them {odd[0]}), "
            f"not the {len(layout.names)} of the "
            f"layout {layout.name}, in its order; choose the layout that the table was collected with"
        )


def grasp_to_dicts(done: Grasp, setting: HandSetting) -> Iterator[dict[str, Any]]:
    """Yield a grasp as plain values: one mapping a step of every attempt, and one of the whole at the end."""
    names = setting.layout.names
    for number, attempt in enumerate(done.attempts, start=1):
        for step in attempt.steps:
            sensed = step.sensed
            line: dict[str, Any] = {
                "attempt": number,
                "step": step.number,
                "action": step.name,
                "felt": step.felt,
                "held": step.held,
                "switches": {n: int(v) for n, v in zip(names, sensed.switches, strict=True)},
                "angles_rad": {n: float(v) for n, v in zip(setting.design.joints, sensed.angles_rad, strict=True)},
                "forces_n": {n: float(v) for n, v in zip(names, sensed.forces_n, strict=True)},
                "palm": {n: float(v) for n, v in zip(CARRIAGE, sensed.carriage, strict=True)},
            }
            if step.pads is not None:
                line["pad_forces_n"] = {n: float(v) for n, v in step.pads.force_n.items()}
            yield line
    last = done.attempts[-1]
    yield {
        "object": done.name,
        "size_m": done.size_m,
        "seed": done.seed,
        "held": done.held,
        "outcome": last.outcome,
        "attempts": len(done.attempts),
        "found": None if last.search is None else last.search.found,
        "touches": None if last.search is None else last.search.touches,
    }


def pads_recording(steps: Sequence[Step]) -> Recording:
    """Return the pads' frames of several steps as a recording, one frame a step.

    Parameters
    ----------
    steps : sequence of Step
        Only those whose pads were pressed count.

    Raises
    ------
    InputError
        If there is none.
    """
    pressed = [step.pads for step in steps if step.pads is not None]
    if not pressed:
        raise InputError("no step has pad frames; give the setting pads")
    pads = {
        part.replace(".", "_"): Pad(
            np.stack([frames.frames[part] for frames in pressed]),
            pitch_m=(pressed[0].pitch_m[part], pressed[0].pitch_m[part]),
        )
        for part in pressed[0].frames
    }
    return Recording(pads, unit="Pa", sensor="simulated hand")
