"""What ``varishold measure`` asks: the measures of every contact's lowest section."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from varishold.corpus.ask import Looked
from varishold.corpus.columns import Column
from varishold.corpus.pads_seen import looked_at, seen_in
from varishold.levelset.table import measure
from varishold.recording import Recording
from varishold.touch.pad_frames import PadFrames, pad_frames

if TYPE_CHECKING:
    from varishold.sensor import Sensor

__all__ = ["AskMeasure"]

_ROW = (
    Column("frame", "whole", "number of the frame, from 0"),
    Column("time_s", "number", "time of that frame by the recording's clock"),
    Column("pad", "text", "name of the pad"),
    Column("contact", "whole", "number of the contact in its frame, 0 the largest"),
    Column("peak", "number", "highest value, in the recording's unit"),
    Column("threshold", "number", "at which the section is cut, in the recording's unit"),
    Column("n_taxels", "whole", "taxels of the contact"),
    Column("parts", "whole", "pieces of the section"),
    Column("holes", "whole", "in the section"),
    Column("euler_number", "whole", "parts less holes"),
    Column("orientation_rad", "number", "of the long axis, from +x toward +y"),
)
# Each with the power of a length in it.
_LENGTHS = {
    "area": (2, "of the section"),
    "perimeter": (1, "of the section"),
    "equivalent_diameter": (1, "of a circle of the same area"),
    "centroid_x": (1, "along the columns, from the pad's centre"),
    "centroid_y": (1, "along the rows, from the pad's centre"),
    "second_moment_xx": (2, "central, over the area"),
    "second_moment_xy": (2, "central, over the area"),
    "second_moment_yy": (2, "central, over the area"),
    "principal_axis_major": (1, "of the ellipse of the same second moments"),
    "principal_axis_minor": (1, "of the ellipse of the same second moments"),
    "feret_width_most": (1, "widest of sixteen directions"),
    "feret_width_least": (1, "narrowest of sixteen directions"),
}


@dataclass(frozen=True)
class AskMeasure:
    """How large is every contact, where, and of which shape?

    Recordings that start unloaded are zeroed, and broken taxels filled, as touch does it.

    Parameters
    ----------
    levels, floor
        As in `varishold.levelset.measure`.
    """

    title: ClassVar[str] = "measure"
    counted: ClassVar[str] = "contact"

    levels: int = 32
    floor: float | None = None

    @property
    def columns(self) -> tuple[Column, ...]:
        metres = [Column(f"{name}_m{n if n > 1 else ''}", "number", said) for name, (n, said) in _LENGTHS.items()]
        taxels = [Column(f"{name}_taxels", "number", f"{said}, in taxels") for name, (_, said) in _LENGTHS.items()]
        return (*_ROW, *metres, *taxels)

    def look(self, whole: Recording, sensor: Sensor | None) -> Looked:
        return looked_at(pad_frames(whole))

    def rows(
        self, block: Recording, first: int, groups: Sequence[range], looked: Looked, sensor: Sensor | None
    ) -> dict[str, Any]:
        table = measure(_zeroed(seen_in(block, looked), block), levels=self.levels, floor=self.floor)
        frame = table["frame"] + first
        nothing = [None] * len(frame)
        return {
            column.name: frame if column.name == "frame" else table.get(column.name, nothing) for column in self.columns
        }


def _zeroed(seen: Mapping[str, PadFrames], block: Recording) -> Recording:
    """Return a block without the rest of the whole, its broken taxels marked."""
    pads = {}
    for name, found in seen.items():
        pad, rest = found.pad, found.rest
        frames = pad.frames if rest is None else pad.frames - rest
        # Noise about zero may well be mostly negative.
        pads[name] = replace(pad, frames=frames, valid=found.valid, polarity="down")
    return replace(block, pads=pads)
