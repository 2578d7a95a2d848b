"""Random frames by the kernel and by the plain reference of the tests: the same contacts, sections to rounding.

    python -m hostile.sections --number 10000 --seed 0

Frame k is drawn from the generator of (seed, k), so that ``--first K --number 1`` makes it again. Ends with status 1
where one differs.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tests.reference_sections import contacts_of, section_of

from varishold.levelset import Contact, find_contacts

__all__ = ["Case", "compare", "main", "random_frame"]

# Relative; of places and moments against the section's own size.
_CLOSE = 1e-9


@dataclass(frozen=True)
class Case:
    """A frame, the levels at which it is cut, its floor and its pitch."""

    frame: NDArray[np.float64]
    levels: NDArray[np.float64]
    floor: float
    pitch: tuple[float, float]


def random_frame(rng: np.random.Generator) -> Case:
    """Draw bumps with noise, or noise alone, at an even or odd scale."""
    rows, cols = rng.integers(1, 12, 2)
    y, x = np.mgrid[:rows, :cols]
    frame = rng.normal(0, rng.choice([0.003, 0.03, 1.0]), (rows, cols))
    for _ in range(rng.integers(0, 4)):
        away = np.hypot((x - rng.uniform(0, cols)) * rng.uniform(0.6, 1.6), y - rng.uniform(0, rows))
        frame += rng.uniform(0.3, 1.5) * np.maximum(1 - (away / rng.uniform(1, 6)) ** rng.choice([1, 2, 4]), 0)
    scale = 10.0 ** rng.integers(-6, 7)
    peak = max(float(frame.max()), 0.1)
    levels = np.sort(rng.uniform(0.05, 1.05, rng.integers(1, 7)) * peak)[::-1]
    pitch = (rng.uniform(0.2, 3.0), rng.uniform(0.2, 3.0))
    return Case(frame * scale, levels * scale, float(rng.uniform(0.02, 0.6) * peak * scale), pitch)


def compare(case: Case) -> list[str]:
    """Return in words what differs."""
    label, peaks = contacts_of(case.frame, case.floor)
    found = find_contacts(case.frame, case.levels, floor=case.floor, pitch=case.pitch)
    if len(found) != len(peaks):
        return [f"{len(found)} contacts, the reference has {len(peaks)}"]
    wrong = []
    if found and not np.array_equal(found[0].frame.label[1:-1, 1:-1], label):
        wrong.append("labels differ")
    for contact in found:
        if (contact.peak, contact.floor) != peaks[contact.index]:
            wrong.append(f"contact {contact.index} from {contact.peak} to {contact.floor}, not {peaks[contact.index]}")
        else:
            wrong += _sections(case, contact, label == contact.index)
    return wrong


def _sections(case: Case, contact: Contact, member: NDArray[np.bool_]) -> list[str]:
    profile, wrong = contact.profile, []
    for i, level in enumerate(profile.threshold.tolist()):
        if level < contact.floor:
            if profile.measured[i]:
                wrong.append(f"level {level} below the end is measured")
            continue
        told = section_of(case.frame, member, level, case.pitch)
        if (profile.parts[i], profile.holes[i]) != (told.parts, told.holes):
            counts = f"{profile.parts[i]}, {profile.holes[i]}"
            wrong.append(f"level {level}: {counts} parts and holes, not {told.parts}, {told.holes}")
        ours = [profile.area[i], profile.perimeter[i], *profile.extent[i]]
        theirs = [told.area, told.perimeter, *told.extent]
        if told.area > 0:
            size = float(np.max(told.extent))
            # A place has its own last digits, however small the section.
            if not np.allclose(profile.centroid[i], told.centroid, rtol=1e-14, atol=_CLOSE * size):
                wrong.append(f"level {level}: centroid {profile.centroid[i]}, not {told.centroid}")
            if not np.allclose(profile.covariance[i], told.covariance, rtol=0, atol=_CLOSE * size**2):
                wrong.append(
                    f"level {level}: covariance {profile.covariance[i].tolist()}, not {told.covariance.tolist()}"
                )
        if not np.allclose(ours, theirs, rtol=_CLOSE, atol=_CLOSE * max(theirs[0], 1e-300) ** 0.5):
            wrong.append(f"level {level}: {ours}, not {theirs}")
    return wrong


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--number", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    n_contacts = n_sections = n_wrong = 0
    for k in range(given.first, given.first + given.number):
        case = random_frame(np.random.default_rng((given.seed, k)))
        found = find_contacts(case.frame, case.levels, floor=case.floor)
        n_contacts += len(found)
        n_sections += len(found) * len(case.levels)
        for line in compare(case):
            n_wrong += 1
            print(f"frame {k}: {line}", flush=True)
    print(f"{given.number} frames, {n_contacts} contacts, {n_sections} sections: {n_wrong} differences")
    sys.exit(n_wrong > 0)


if __name__ == "__main__":
    main()
