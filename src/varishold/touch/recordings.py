"""The contacts of a recording, recognized: one answer a contact, in frames or in whole presses."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from varishold._counted import counted
from varishold.errors import InputError
from varishold.files import let_go
from varishold.frame.gains import gains_words
from varishold.levelset.contact import Contact, with_losses
from varishold.recording import Pad, Recording, pascals_per_unit
from varishold.recording.selection import frame_groups
from varishold.sensor.model import Sensor
from varishold.sensor.recordings import placed_by, upright_recording
from varishold.sensor.words import sensor_name, undone_words
from varishold.touch.answer import Answer
from varishold.touch.caution import ends_flat, unsure_of_plane, unsure_of_smoothed, unsure_of_top
from varishold.touch.pad_frames import PadFrames, pad_frames
from varishold.touch.pooling import EvidencePool
from varishold.touch.recognizer import has_hill, has_hollow, recognize
from varishold.touch.sensing import find_contacts
from varishold.touch.surface import Surface

if TYPE_CHECKING:
    from varishold.skin import Skin

__all__ = ["FEWEST_TAXELS", "Knowledge", "answers_of", "knowledge_of", "recognize_recording"]

#: Rows and columns that a pad needs for its skin to be seen through.
FEWEST_TAXELS = 3
# Of a mapped file no more frames or presses than these stay in memory.
_GROUPS_KEPT = 1024
# A press of so many frames shows what belongs to it in more than one.
_FEWEST_TOLD = 3
# Readings so many sigma below a known end may be at it; no more than that share of it is given up for that.
_NOISE_AT_END, _MOST_BELOW_END = 3.0, 0.1
# On so many taxels a rest that curves is taken off too (native/curved.c).
_MAY_CURVE = 64 * 64
_LIES = "what lies there from the first frame to the last is no part of a press: taken off"


def recognize_recording(
    recording: Recording,
    *,
    frames: str | int = "peak",
    levels: int = 32,
    skin: Skin | None = None,
    exact: bool = False,
    sensor: Sensor | None = None,
) -> Iterator[Answer]:
    """Recognize every contact of a recording.

    Parameters
    ----------
    recording : Recording
    frames : {"peak", "all", "press"} or int
        The frame of largest total, every frame, one answer a press (of those that the recording names, or its runs of
        loaded frames), or one frame.
    levels : int
        Thresholds a contact.
    skin : Skin, optional
        The pads' skin, where it is known: contacts are then recognized on the reconstructed surface too.
    exact : bool
        Whether to fit each form through the skin, which must be known.
    sensor : Sensor, optional
        What made the readings; it is undone first. Its cover is the skin where none is given.

    Yields
    ------
    Answer
        In the order of frames, or of the presses' numbers, then of pads and of falling area.

    Raises
    ------
    InputError
        If `frames` names none, a skin is given for a pad of fewer than 3 rows or columns or of
        unknown pitch, `exact` without a skin, or the sensor is not the recording's.
    """
    recording = upright_recording(recording, sensor)
    knows = knowledge_of(recording, levels=levels, skin=skin, exact=exact, sensor=sensor)
    yield from answers_of(recording, frame_groups(recording, frames), knows, pooled=frames == "press")


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What is known of a recording's pads before a frame of them is looked at, and what is asked.

    Parameters
    ----------
    levels : int
        Thresholds a contact.
    skin : Skin or None
    exact : bool
        Whether to fit forms through the skin.
    unit : str
        Of what is left when the sensor is undone.
    sensors : mapping of str to Sensor or None
        What is left of the sensor to be undone, by pad.
    sensor : Sensor or None
    frames : mapping of str to PadFrames
    """

    levels: int
    skin: Skin | None
    exact: bool
    unit: str
    sensors: Mapping[str, Sensor | None]
    sensor: Sensor | None
    frames: Mapping[str, PadFrames]


def knowledge_of(
    recording: Recording,
    *,
    levels: int = 32,
    skin: Skin | None = None,
    exact: bool = False,
    sensor: Sensor | None = None,
    frames: Mapping[str, PadFrames] | None = None,
) -> Knowledge:
    """Return what is known before frames are looked at.

    Parameters
    ----------
    recording : Recording
        Upright.
    levels, skin, exact, sensor
        As in `recognize_recording`.
    frames : mapping of str to PadFrames, optional
        What `pad_frames` told of the whole, where the recording is a block of one. Default: it is the whole.

    Raises
    ------
    InputError
        As `recognize_recording`.
    """
    skin = skin or (None if sensor is None else sensor.cover)
    if exact and skin is None:
        raise InputError("exact recognition fits forms through the skin and needs one; give skin")
    frames = frames or pad_frames(recording)
    sensors = {name: _sensor_of(pad, sensor, frames[name].sigma) for name, pad in recording.pads.items()}
    unit = recording.unit if sensor is None or sensor.unit.lower() == "raw" else sensor.unit
    if skin is not None:
        for name, pad in recording.pads.items():
            if pad.pitch_m is None:
                raise InputError(f"a skin is given but the pitch of pad {name!r} is unknown", parameter="pitch_m")
            if min(pad.shape) < FEWEST_TAXELS:
                raise InputError(
                    f"a skin is given but pad {name!r} has only {pad.shape[0]} x {pad.shape[1]} taxels; seeing through "
                    f"a skin takes {FEWEST_TAXELS} x {FEWEST_TAXELS} or more: leave the skin out"
                )
    return Knowledge(levels, skin, exact, unit, sensors, sensor, frames)


def answers_of(
    recording: Recording, groups: Iterable[range], knows: Knowledge, *, pooled: bool = False, first: int = 0
) -> Iterator[Answer]:
    """Recognize every contact in some groups of frames.

    Parameters
    ----------
    recording : Recording
        Upright; or a block of one.
    groups : iterable of range
        Frames by their numbers in the whole recording.
    knows : Knowledge
    pooled : bool
        Whether a group's evidence is pooled to one answer a contact; otherwise its first frame is recognized.
    first : int
        The number of the block's first frame in the whole recording.

    Yields
    ------
    Answer
    """
    for number, whole in enumerate(groups):
        group = range(whole.start - first, whole.stop - first)
        for name, pad in recording.pads.items():
            if number % _GROUPS_KEPT == 0:
                let_go(pad.frames)
            if pooled:
                found = _press(name, group, first, knows)
            else:
                contacts = _contacts(name, group.start, first, knows)
                seen = (_recognize(contact, contacts, knows) for contact in contacts)
                found = ((group.start, place, surface) for place, surface in enumerate(seen))
            for index, place, seen_as in found:
                surface = unsure_of_smoothed(seen_as) if knows.frames[name].blurs_forms else seen_as
                surface = unsure_of_plane(surface) if knows.frames[name].sways else surface
                answer = _answer(recording, name, index, first, place, surface, knows)
                if pooled and knows.frames[name].lies is not None:
                    answer = replace(answer, frame_notes=(*answer.frame_notes, _LIES))
                yield answer


def _sensor_of(pad: Pad, sensor: Sensor | None, sigma: float | None) -> Sensor | None:
    """Return what is left of the sensor to be undone on a pad that stands upright and has that noise."""
    left = None if sensor is None else sensor.upright()
    if left is not None and left.saturation is not None and left.span is not None and sigma:
        # Noise leaves half of what is saturated below the end.
        noise = min(_NOISE_AT_END * sigma / left.span, _MOST_BELOW_END * left.saturation)
        left = replace(left, saturation=left.saturation - noise)
    return placed_by(pad, left)


def _contacts(name: str, index: int, first: int, knows: Knowledge, *, of_press: bool = False) -> list[Contact]:
    """Return the contacts of a pad's frame, as far as the whole recording lets it be known; an error names it."""
    frames, sensor = knows.frames[name], knows.sensors[name]
    pad, saturated = frames.pad, frames.saturated(index)
    pitch = pad.pitch_m if pad.positions_m is None else None
    frame, sigma = frames.frame(index, of_press=of_press), frames.noise
    if sensor is not None:
        frame = frames.readings(index)
        sigma = None if frames.sigma is None else sensor.least_stress(frames.sigma)
    try:
        contacts = find_contacts(
            frame, knows.levels, pitch=pitch, valid=frames.valid, field=pad.field, sigma=sigma, sensor=sensor
        )
    except InputError as error:
        raise InputError(f"frame {first + index} of pad {name!r}: {error}") from error
    # A sensor that says where it saturates has told it.
    told = sensor is not None and sensor.tells_saturation
    return contacts if saturated is None or told else with_losses(contacts, saturated=saturated)


def _recognize(contact: Contact, contacts: list[Contact], knows: Knowledge) -> Surface:
    """Return what one look shows, no surer of a flat top than the sensor lets it be."""
    return unsure_of_top(_looked_at(contact, contacts, knows))


def _looked_at(contact: Contact, contacts: list[Contact], knows: Knowledge) -> Surface:
    if knows.skin is None:
        return recognize(contact)
    from varishold.touch.relief import relief_of

    relief = relief_of(contact, knows.skin, among=contacts)
    if not knows.exact:
        return recognize(contact, relief=relief)
    from varishold.touch.exact import recognize_exact

    return recognize_exact(contact, knows.skin, relief=relief, pascal=pascals_per_unit(knows.unit))


def _answer(
    recording: Recording, name: str, index: int, first: int, number: int, surface: Surface, knows: Knowledge
) -> Answer:
    time = None if recording.time_s is None else float(recording.time_s[index])
    return Answer(
        file=recording.source or None,
        frame=first + index,
        time_s=time,
        pad=name,
        contact=number,
        surface=surface,
        unit=knows.unit,
        pascals_per_unit=pascals_per_unit(knows.unit),
        pitch_m=surface.contact.pitch,
        sensor=None if knows.sensor is None else sensor_name(knows.sensor),
        frame_notes=_frame_notes(surface.contact, name, knows),
    )


def _frame_notes(contact: Contact, name: str, knows: Knowledge) -> tuple[str, ...]:
    """Return what was done to a contact's frame, in words."""
    on_pad, given = knows.sensors[name], knows.sensor
    notes = [*knows.frames[name].notes]
    if on_pad is None and (gains := knows.frames[name].gains) is not None:
        notes.append(gains_words(gains))
    if given is not None:
        notes += [f"sensor {sensor_name(given)}", *undone_words(given)]
    if on_pad is not None and on_pad.resampling is not None and (given is None or given.resampling is None):
        notes.append(str(on_pad.resampling))
    if any(contact.frame.rest):
        large = math.prod(contact.frame.shape) >= _MAY_CURVE
        notes.append(f"a sloping{', curved' * large} or offset rest taken off")
    if has_hollow(contact):
        notes.append("a hollow in a plane: where readings fall under pressure, a sensor file says polarity = 'down'")
    if has_hill(contact):
        notes.append(
            "a hill on a plane: where readings rest at an offset, begin unloaded or give a sensor file its rest"
        )
    state = contact.state
    if state.repaired:
        notes.append(f"{counted(state.repaired, 'broken taxel')} filled from the neighbours")
    if state.saturated:
        notes.append(f"{counted(state.saturated, 'taxel')} saturated: at least what is shown")
    if ends_flat(contact):
        notes.append("more than a third of it is saturated: a flat top may be the sensor's")
    return tuple(notes)


def _press(name: str, frames: range, first: int, knows: Knowledge) -> Iterator[tuple[int, int, Surface]]:
    """Yield the heaviest frame of a press, and for each contact of it its number and surface, pooled over the press."""
    seen = {i: _contacts(name, i, first, knows, of_press=True) for i in frames}
    heaviest = max(frames, key=lambda i: (sum(c.peak * c.n_taxels for c in seen[i]), -i))
    number = 0
    for place, contact in enumerate(seen[heaviest]):
        surface = _recognize(contact, seen[heaviest], knows)
        reach = math.sqrt(surface.area)
        pool = EvidencePool()
        for i in frames:
            same = contact if i == heaviest else _nearest(seen[i], surface.position, reach)
            if same is not None:
                pool.add(surface if i == heaviest else _recognize(same, seen[i], knows))
        # What stands beside the largest contact in one frame alone is no part of a press.
        if place == 0 or len(frames) < _FEWEST_TOLD or pool.looks > 1:
            yield heaviest, number, pool.answer(surface)
            number += 1


def _nearest(contacts: Iterable[Contact], position: tuple[float, float], reach: float) -> Contact | None:
    best, distance = None, reach
    for contact in contacts:
        x, y = contact.peak_position
        d = math.hypot(x - position[0], y - position[1])
        if d < distance:
            best, distance = contact, d
    return best
