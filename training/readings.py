"""Signatures of clean frames as many drawn sensors read them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from training.chunks import keep, kept
from training.faults import FAMILIES, ORDINARY, DrawnSensor, draw_sensor
from training.samples import SKINS, Clean, Making, clean_frames
from varishold.errors import InputError
from varishold.levelset.contact import Contact
from varishold.sensor import Skin
from varishold.touch import SIGNATURE_NAMES, contact_signature, find_contacts
from varishold.touch.relief import RELIEF_NAMES, relief_of, relief_signature

Array = NDArray[np.float64]
#: What is read: a whole contact, one whose threshold has fallen part of its way, or one with the relief under it.
Way = Literal["whole", "early", "relief"]

#: Sensors that read each clean frame.
SENSORS = {
    "whole": {"ideal": 4, "press": 8, "border": 8},
    "early": {"ideal": 2, "press": 3},
    "relief": {"ideal": 0, "press": 3},
}
_FAMILIES = list(FAMILIES)
# Share of the sensors with no fault of gains whose taxels are a little unequal all the same: few taxels average little.
_UNEVEN = {"small": 0.5, "middle": 0.3, "surfaces": 0.0, "wide": 0.0}
# A contact that holds less of what was pressed is something else: a part, a ghost, or what is left of the last press.
_OWN = 0.5


@dataclass(frozen=True)
class Task:
    """One chunk of readings.

    Parameters
    ----------
    making : {"ideal", "press", "border"}
    seed, index : int
        Which chunk of clean frames.
    way : {"whole", "early", "relief"}
    pads : str
        A key of `PADS`.
    without : str
        A family of faults that no sensor has.
    """

    making: Making
    seed: int
    index: int
    pads: str
    way: Way = "whole"
    without: str = ""


@dataclass(frozen=True)
class Readings:
    """Signatures of contacts, a row a reading, and what is true of each.

    Parameters
    ----------
    x : ndarray of shape (n, n_inputs), float32
    kind : ndarray of shape (n,), int64
        Place in `KINDS`.
    faults : ndarray of shape (n,), int64
        A bit for each of `FAMILIES` that the sensor has.
    wear, shape, size, skin : ndarray
        Of the clean frame, as in `Clean`.
    frame : ndarray of shape (n,), int64
        100 times the clean frame's number in its chunk, and the sensor's number.
    """

    x: NDArray[np.float32]
    kind: NDArray[np.int64]
    faults: NDArray[np.int64]
    wear: NDArray[np.float32]
    shape: NDArray[np.int64]
    size: NDArray[np.float32]
    frame: NDArray[np.int64]
    skin: NDArray[np.float64]

    @property
    def usual(self) -> NDArray[np.bool_]:
        """Where the sensor has one fault at most, or the mild ones that every array has; shape (n,)."""
        bits = 1 << np.arange(len(_FAMILIES))
        ordinary = sum(int(bits[_FAMILIES.index(family)]) for family in ORDINARY)
        several = (self.faults[:, None] & bits != 0).sum(axis=1) > 1
        return ~several | (self.faults == ordinary)

    @property
    def worn(self) -> NDArray[np.bool_]:
        """Where the pressed face is rounded, leans, is cut by the border or stretched; shape (n,)."""
        return np.asarray(np.nan_to_num(self.wear).any(axis=1))


def read_frames(
    clean: Clean, seed: tuple[int, ...], count: int, pads: str, without: str = ""
) -> Iterator[tuple[int, int, int, Array, DrawnSensor]]:
    """Yield (index, index of the last press, number, frame, sensor) as `count` drawn sensors read every clean frame."""
    small = pads == "small"
    frames = list(clean)
    alike: dict[tuple[int, ...], list[int]] = {}
    for i, frame in enumerate(frames):
        alike.setdefault(frame.shape, []).append(i)
    for i, frame in enumerate(frames):
        rng = np.random.default_rng([*seed, i])
        # Worn faces are hard enough: most of them meet a good sensor.
        plain = not np.nan_to_num(clean.wear[i]).any()
        chances = (0.16, 0.45, 0.18, 0.21) if plain else (0.42, 0.33, 0.12, 0.13)
        if small:
            # A few taxels tell little of a form even where they are good ones.
            chances = (0.24, 0.46, 0.17, 0.13) if plain else (0.50, 0.32, 0.10, 0.08)
        low, high = clean.noise[i].tolist()
        for k in range(count):
            sensor = draw_sensor(
                rng, (low, high), chances=chances, arrays=not small, uneven=_UNEVEN[pads], without=without
            )
            others = alike[frame.shape]
            last = others[int(rng.integers(len(others)))]
            read = sensor.read(rng, frame, frames[last])
            peak = float(np.abs(read).max())
            yield i, last, k, (read / peak if peak > 0 else read), sensor


def _believed(rng: np.random.Generator, row: NDArray[np.float64]) -> Skin:
    """Return the skin that a skin file might say lies over the taxels: half of them are a little wrong."""
    kind, thickness, poisson, sensing = SKINS[int(row[0])], float(row[1]), float(row[2]), float(row[3])
    if rng.random() < 0.5:
        thickness *= float(np.exp(rng.uniform(-0.35, 0.35)))
        poisson = min(poisson + float(rng.uniform(-0.02, 0.02)), 0.499)
        sensing *= float(np.exp(rng.uniform(-0.15, 0.15)))
    if kind != "half-space":
        sensing = min(sensing, 0.6 * thickness)
    return Skin(kind, thickness_m=None if kind == "half-space" else thickness, poisson=poisson, sensing_depth_m=sensing)


def _inputs(
    rng: np.random.Generator, way: Way, frame: Array, row: NDArray[np.float64], blur: dict[bytes, Skin]
) -> Iterator[tuple[Contact, NDArray[np.float64]]]:
    """Yield the contacts that a frame is read by, and their inputs: the largest, and the highest if it is another."""
    contacts = find_contacts(frame, pitch=float(row[4]) if way == "relief" else None)
    if not contacts:
        return
    contact = contacts[0]
    if way == "whole":
        highest = max(contacts, key=lambda c: c.peak)
        for one in (contact,) if highest is contact else (contact, highest):
            yield one, contact_signature(one)
    elif way == "early":
        floor = contact.peak - float(rng.uniform(0.1, 0.95)) * (contact.peak - contact.floor)
        floor = max(floor, 0.0)
        fallen = find_contacts(np.maximum(frame, floor), floor=floor)
        if fallen:
            yield fallen[0], contact_signature(fallen[0])
    else:
        skin = blur.setdefault(row.tobytes(), _believed(rng, row))
        with contextlib.suppress(InputError):
            relief = relief_of(contact, skin, among=contacts)
            yield contact, np.concatenate([contact_signature(contact), relief_signature(relief)])


def _rest_of(contact: Contact) -> float:
    first, by_col, by_row = contact.frame.rest
    rows, cols = contact.shape
    return first + by_col * (cols - 1) / 2 + by_row * (rows - 1) / 2


def _kind_of(
    rng: np.random.Generator, way: Way, contact: Contact, sensor: DrawnSensor, original: Array, kind: int, last: int
) -> int | None:
    """Return what a contact is to be called where `kind` was pressed after `last`; None where nobody can say."""
    mine = contact.frame.label[1:-1, 1:-1] == contact.index
    if float(original[mine].sum()) >= _OWN * float(original.sum()):
        return kind
    if way != "whole" or not sensor.memory:
        return None
    if _rest_of(contact) > contact.peak:
        # That so high a rest may be a plane that is pressed is weighed apart.
        return last
    # A fainter contact may be another object, or what is left of the last press: nobody can say which.
    return last if rng.random() < 0.5 else kind


def readings(task: Task) -> Readings:
    """Return the readings of one chunk, kept between runs."""
    label = f"read-{task.way}-{task.pads}-{task.making}-{task.seed}-{task.index}"
    if task.without:
        label += f"-without-{task.without.replace(' ', '-')}"
    known = kept(Readings, label)
    if known is not None:
        return known
    clean = clean_frames(task.making, task.seed, task.index, task.pads)
    originals = list(clean)
    rng = np.random.default_rng([task.seed, task.index, len(task.way)])
    blur: dict[bytes, Skin] = {}
    rows: list[tuple[Any, ...]] = []
    count = SENSORS[task.way][task.making]
    for i, last, k, frame, sensor in read_frames(clean, (task.seed, task.index, 7), count, task.pads, task.without):
        if task.way == "relief" and clean.skin[i][0] < 0:
            continue
        bits = sum(1 << _FAMILIES.index(family) for family in sensor.families)
        for contact, x in _inputs(rng, task.way, frame, clean.skin[i], blur):
            kinds = int(clean.kind[i]), int(clean.kind[last])
            kind = _kind_of(rng, task.way, contact, sensor, originals[i], *kinds)
            if kind is not None:
                rows.append((x, kind, bits, clean.wear[i], clean.shape[i], clean.size[i], 100 * i + k, clean.skin[i]))
    width = len(SIGNATURE_NAMES) + (len(RELIEF_NAMES) if task.way == "relief" else 0)
    x = np.array([row[0] for row in rows], np.float32).reshape(len(rows), width)
    made = Readings(x, *(np.array([row[j] for row in rows]) for j in range(1, 8)))
    keep(made, label)
    return made
