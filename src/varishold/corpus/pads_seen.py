"""What a whole recording tells of its pads, from the look to the blocks: rest, noise, broken taxels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.corpus.ask import Looked
from varishold.frame.reading_end import ReadingEnd
from varishold.recording import Recording
from varishold.touch.pad_frames import PadFrames

__all__ = ["looked_at", "seen_in"]


def looked_at(seen: Mapping[str, PadFrames], groups: NDArray[np.int64] | None = None) -> Looked:
    """Return what is kept of the pads of a whole recording."""
    facts: list[dict[str, Any]] = []
    arrays: dict[str, NDArray[Any]] = {}
    for number, (name, pad) in enumerate(seen.items()):
        ends = {"full_scale": pad.full_scale, "ends_at": None if pad.ends_at is None else asdict(pad.ends_at)}
        told = {"notes": list(pad.notes), "smoothed": pad.smoothed, "sways": pad.sways}
        facts.append({"pad": name, "sigma": pad.sigma, **ends, **told})
        held = {"rest": pad.rest, "valid": pad.valid, "lies": pad.lies, "gains": pad.gains}
        arrays |= {f"{key}.{number}": array for key, array in held.items() if array is not None}
    return Looked(groups, {"pads": facts}, arrays)


def seen_in(block: Recording, looked: Looked) -> dict[str, PadFrames]:
    """Return the frames of each pad of a block, with what the whole recording told of them."""
    return {
        facts["pad"]: PadFrames(
            block.pads[facts["pad"]],
            looked.arrays.get(f"rest.{number}"),
            facts["sigma"],
            looked.arrays.get(f"valid.{number}"),
            facts["full_scale"],
            tuple(facts["notes"]),
            None if facts["ends_at"] is None else ReadingEnd(**facts["ends_at"]),
            looked.arrays.get(f"lies.{number}"),
            facts["smoothed"],
            looked.arrays.get(f"gains.{number}"),
            facts["sways"],
        )
        for number, facts in enumerate(looked.facts["pads"])
    }
