"""What the page says of what touches, in the report's words."""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import partial
from typing import TYPE_CHECKING, Any

from varishold.frame.zero import Zeroing
from varishold.learning.recognition import Recognition
from varishold.live.pad_watcher import SeenPad
from varishold.live.picture import track_key
from varishold.live.press_namer import NamedPress
from varishold.live.watcher import Seen
from varishold.report.measures import measures
from varishold.report.quantities import length, number, percent, reading
from varishold.report.wording import Bar, likeliest_bars, sentence, sentences
from varishold.touch.chords import inequality
from varishold.touch.tracking.event import Event
from varishold.touch.tracking.track import Track

if TYPE_CHECKING:
    from varishold.live.press_believer import BelievedObject

__all__ = ["event_words", "named_line", "named_words", "words_of", "zeroing_words"]

# Contacts that are spoken of, the heaviest first.
_MOST_CONTACTS = 4
# Kinds of measures that are named of those that decided.
_MOST_MEASURES = 3
_TOWARD = ("right", "lower right", "bottom", "lower left", "left", "upper left", "top", "upper right")


def words_of(seen: Seen, also: Collection[str] = ()) -> dict[str, Any]:
    """Return, by the track's key, what is said of the heaviest contacts, and of those whose keys are given."""
    tracks = [(track, pad) for pad in seen.pads.values() for track in pad.tracks if track.state != "lost"]
    tracks.sort(key=lambda one: -one[0].load)
    chosen = [one for k, one in enumerate(tracks) if k < _MOST_CONTACTS or track_key(one[0]) in also]
    return {track_key(track): _contact_words(track, pad, seen) for track, pad in chosen}


def event_words(event: Event) -> str:
    """Return an event in a few words.

    Examples
    --------
    >>> event_words(Event("released", 1.0, 1.0, 1, "pad", (0.0, 0.0), None, 9.0, None, 1.0, None, duration_s=1.24))
    'released after 1.24\u202fs'
    """
    if event.kind == "released" and event.duration_s is not None:
        return f"released after {number(event.duration_s)}\u202fs"
    if event.direction_rad is None or event.kind == "touched":
        return str(event.kind)
    toward = f"toward the {_TOWARD[round(event.direction_rad / (math.pi / 4)) % 8]}"
    if event.kind == "tipped" or event.distance_taxels is None:
        return f"{event.kind} {toward}"
    if event.distance_m is not None:
        return f"{event.kind} {length(event.distance_m, metres=True)} {toward}"
    return f"{event.kind} {length(event.distance_taxels, metres=False)} {toward}"


def zeroing_words(zeroing: Zeroing) -> str:
    """Return what became of a zero, in a few words."""
    what = "zero taken" if zeroing.taken else "zero refused"
    return f"{what}: {zeroing.reason}" if zeroing.reason else what


def named_words(named: NamedPress) -> dict[str, Any]:
    """Return what a model says of a press, or a perceiver of an object."""
    when = f"Press {named.number}" if named.over else "This press, so far"
    found = named.recognition
    if found is None:
        return {"when": when, "name": "not recognized", "bars": [], "lines": [sentence(named.words)]}
    if not isinstance(found, Recognition):
        return _object_words(found, when)
    names = [(str(found.label), found.probability), *((str(name), p) for name, p in found.alternatives.items())]
    nats = ", ".join(f"{name.replace('_', ' ')} {nats:+.1f}" for name, nats in found.measures[:_MOST_MEASURES])
    like = f"Most like {found.nearest} ({found.nearest_label})."
    strange = [f"Strange: of known things one in {1 / max(found.p_value, 1e-3):.0f} is."] if found.refused else []
    unlike = ["Felt unlike the session that was learned."] if found.unlike_session else []
    return {
        "when": when,
        "name": "none of what was learned" if found.refused else str(found.label),
        "bars": _bars(likeliest_bars(names)),
        "lines": [*strange, *unlike, f"Decided by {nats} nats.", like],
    }


def named_line(named: NamedPress) -> str:
    """Return the same in a line."""
    said, found = named_words(named), named.recognition
    refused = found is None or (found.refused if isinstance(found, Recognition) else found.unknown)
    return (
        f"press {named.number}: {said['name']}{'' if found is None or refused else f', {percent(found.probability)}'}"
    )


def _object_words(found: BelievedObject, when: str) -> dict[str, Any]:
    answer, count = found.answer, "" if found.touches == 1 else f", {found.touches} presses of it"
    names = [(answer.object, answer.probability)] if not found.unknown else []
    size = [] if answer.size_m is None else [f"About {length(answer.size_m, metres=True)} wide."]
    return {
        "when": f"{when}{count}",
        "name": answer.object,
        "bars": _bars(likeliest_bars([*names, *answer.alternatives.items()])),
        "lines": [sentence(found.update.why), *size, *sentences(found.update.reasons), *sentences(answer.remarks)],
    }


def _contact_words(track: Track, pad: SeenPad, seen: Seen) -> dict[str, Any]:
    contact = track.contact
    theta = partial(reading, unit=pad.unit)
    ends = {"theta_top": theta(contact.peak), "theta_floor": theta(contact.floor)}
    told = inequality(contact.profile, taxel_area=contact.taxel_area, sigma=contact.sigma)
    growth = [
        _verdict("√area", told.bulge_sqrt_area, told.defect_sqrt_area),
        _verdict("Perimeter", told.bulge_perimeter, told.defect_perimeter),
    ]
    answer = pad.answer(track, number=seen.number, time_s=seen.time_s)
    common = {**ends, "growth": growth, "unit": "mm" if contact.pitch is not None else "taxels"}
    if answer is None:
        return {**common, "name": None}
    surface = answer.surface
    return {
        **common,
        "name": surface.name,
        "probability": percent(surface.probability),
        "outline": f"{surface.outline}, {percent(surface.outline_probability)}",
        "looks": track.looks,
        "held": list(surface.answer_set),
        "bars": _bars(likeliest_bars(surface.names.items())),
        "outline_bars": _bars(likeliest_bars(surface.outlines.items())),
        "reasons": list(sentences(surface.reasons)),
        "measures": [list(pair) for pair in measures(answer)],
    }


def _verdict(title: str, bulge: float, defect: float) -> dict[str, Any]:
    known = math.isfinite(bulge) and math.isfinite(defect)
    return {"title": title, "bulge": f"{bulge:.2f}" if known else None, "defect": f"{defect:.2f}" if known else None}


def _bars(of: tuple[Bar, ...]) -> list[list[Any]]:
    return [[bar.name, round(bar.share, 4), bar.text] for bar in of]
