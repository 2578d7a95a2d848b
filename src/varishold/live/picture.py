"""One reading as the page draws it: a head of JSON and the numbers behind it, in one binary message."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.live.pad_watcher import SeenPad
from varishold.live.watcher import Seen
from varishold.report.quantities import percent
from varishold.touch.chords import USABLE_TAXELS
from varishold.touch.tracking.track import Track

__all__ = ["DRAWN_LEVELS", "picture_of", "track_key"]

#: Sections that are drawn of a contact, where there are not too many of all together.
DRAWN_LEVELS = 16
_MOST_LEVELS, _FEWEST_LEVELS = 192, 4
# A pad that nothing touches is drawn dark up to so many sigma.
_DARK_SIGMAS = 6.0
# Contacts that are drawn, of all pads.
_MOST_CONTACTS = 64


def picture_of(seen: Seen) -> bytes:
    """Return a reading as one message.

    Four bytes, little-endian, tell the length of the head, which is JSON; after it stand 32-bit floats, little-endian.
    ``at`` in the head counts them. Each pad has its frame there, each contact its curves (height, sqrt(area),
    perimeter and whether it is usable, of each drawn section) and its outlines' points (x, y) in taxels from the
    frame's upper left corner, whose numbers ``outlines`` tells section by section.

    Parameters
    ----------
    seen : Seen
        With all pads, those of earlier readings too.
    """
    numbers = _Numbers()
    shown = {name: [track for track in pad.tracks if track.state != "lost"] for name, pad in seen.pads.items()}
    levels = _MOST_LEVELS // max(sum(map(len, shown.values())), 1)
    levels = min(max(levels, _FEWEST_LEVELS), DRAWN_LEVELS)
    left, pads = _MOST_CONTACTS, []
    for name, pad in seen.pads.items():
        pads.append(_pad(pad, shown[name], numbers, left, levels))
        left -= len(pads[-1]["contacts"])
    head = {
        "number": seen.number,
        "time_s": seen.time_s,
        "host_time_s": None if seen.sample is None else seen.sample.host_time_s,
        "pads": pads,
    }
    text = json.dumps(head, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return len(text).to_bytes(4, "little") + text + numbers.message()


def track_key(track: Track) -> str:
    """Return what a track is called between server and page."""
    return f"{track.pad}/{track.number}"


class _Numbers:
    """Arrays, one after the other."""

    def __init__(self) -> None:
        self._parts: list[NDArray[np.float32]] = []
        self._count = 0

    def add(self, values: NDArray[Any]) -> int:
        """Take an array; return where it begins."""
        at = self._count
        self._parts.append(np.asarray(values, dtype="<f4").ravel())
        self._count += self._parts[-1].size
        return at

    def message(self) -> bytes:
        return b"".join(part.tobytes() for part in self._parts)


def _pad(pad: SeenPad, tracks: list[Track], numbers: _Numbers, most: int, levels: int) -> dict[str, Any]:
    contacts = [track.contact for track in tracks]
    rows, cols = pad.frame.shape
    pitch = contacts[0].pitch if contacts else pad.layout.pitch_m
    with np.errstate(over="ignore"):
        at = numbers.add(pad.frame)
    return {
        "name": pad.name,
        "kind": pad.layout.kind,
        "signals": list(pad.layout.names),
        "rows": rows,
        "cols": cols,
        "aspect": 1.0 if pitch is None else pitch[1] / pitch[0],
        "pitch_mm": None if pitch is None else 1e3 * pitch[1],
        "at": at,
        "floor": min(c.floor for c in contacts) if contacts else _DARK_SIGMAS * (pad.sigma or 0.0),
        "peak": max((c.peak for c in contacts), default=None),
        "contacts": [_contact(track, numbers, levels) for track in tracks[: max(most, 0)]],
    }


def _contact(track: Track, numbers: _Numbers, levels: int) -> dict[str, Any]:
    contact = track.contact
    profile = contact.profile
    shown = np.flatnonzero(profile.area > 0)
    if len(shown) > levels:
        shown = shown[np.round(np.linspace(0, len(shown) - 1, levels)).astype(int)]
    span = max(contact.peak - contact.floor, 1e-300)
    area = profile.area[shown]
    usable = area >= USABLE_TAXELS * contact.taxel_area
    unit = 1e3 if contact.pitch is not None else 1.0
    curves = [
        (profile.threshold[shown] - contact.floor) / span,
        unit * np.sqrt(area),
        unit * profile.perimeter[shown],
        usable,
    ]
    rows, cols = contact.shape
    corner = (cols / 2, rows / 2)
    outlines = contact.filled(profile.threshold[shown].tolist(), (1.0, 1.0))
    in_rows, in_cols = contact.window
    x, y = track.position_taxels
    answer = track.answer
    return {
        "track": track_key(track),
        "state": track.state,
        "name": None if answer is None else answer.name,
        "sure": None if answer is None else percent(answer.probability),
        "position": [x + cols / 2, y + rows / 2],
        "load": track.load,
        "peak": contact.peak,
        "floor": contact.floor,
        "window": [in_cols.start, in_rows.start, in_cols.stop, in_rows.stop],
        "levels": len(shown),
        "curves": numbers.add(np.array(curves)),
        "outlines": [[len(line) for line in lines] for lines in outlines.by_level()],
        "at": numbers.add(outlines.points + corner),
    }
