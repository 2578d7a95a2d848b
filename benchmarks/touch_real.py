"""Names given to real contacts, nothing having been learned from them: Weiss pads and fingers on a touch screen.

Weiss pads (13 x 6 taxels): the peak frame of every grasp of the balls, cylinders and boxes, each finger's largest
contact. True is what such an object can be to a pad: a ball a sphere; a cylinder a lying cylinder, a ridge (or hip) or
an edge; a box a square or rectangular pillar, an edge or a plane. Printed is how often the 90 % answer set holds one of
these, its mean size, unknown, and names with p > .9 that are none of these. Then the same of all but each object's
first ten grasps, as they come and after `calibrate_unlabelled` on those ten.

CapContact: contacts of fingers, a few taxels each. They should be told to be too small for a form, not to be strange.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from benchmarks._figures import figure, share
from benchmarks._real_data import find_recording
from benchmarks.capcontact import THRESHOLD, single_contacts
from benchmarks.touch_distortions import SURE, Answer, answer_of, answer_to
from benchmarks.weiss_touch import SHAPES, first_grasps, peak_frames
from varishold.calibration import calibrate_unlabelled
from varishold.recording import Pad, Recording
from varishold.touch import find_contacts, recognize

TRUE = {
    "sphere": {"sphere"},
    "cylinder": {"lying cylinder", "ridge", "edge"},
    "box": {"square pillar", "rectangular pillar", "edge", "plane"},
}
BARS = "bars: set holds 75, size 4, unknown 40, wrong with p > .9 2"
#: A reason that holds one of these tells a contact too small for a form.
TOO_SMALL = ("too small", "too few taxels")


def weiss() -> None:
    """Print the figures of the Weiss pads."""
    path = find_recording("weiss_dsa36.npz")
    if path is None:
        return
    frames, label, mask = peak_frames(path)
    everything: list[tuple[Answer, set[str]]] = []
    for shape, names in SHAPES.items():
        answers = [
            (answer_of(frames[g, finger], field=mask[finger]), TRUE[shape])
            for g in np.flatnonzero(np.isin(label, names))
            for finger in (0, 1)
            if frames[g, finger].any()
        ]
        _print("Weiss", shape, answers)
        everything += answers
    _print("Weiss", "all", everything)
    print(f"    {BARS}")


def weiss_calibrated() -> None:
    """Print the figures of later grasps before and after the gains were found from the first ten of each."""
    path = find_recording("weiss_dsa36.npz")
    if path is None:
        return
    frames, label, mask = peak_frames(path)
    first = first_grasps(label)
    sensors = []
    for finger in (0, 1):
        pressed = frames[first, finger]
        pressed = pressed[pressed.any(axis=(1, 2))]
        # Each peak frame is a press of its own.
        apart = np.stack([pressed, np.zeros_like(pressed)], axis=1).reshape(-1, *pressed.shape[1:])
        still = np.zeros((8, *pressed.shape[1:]))
        pad = Pad(np.concatenate([still, apart]), field=mask[finger])
        sensors.append(calibrate_unlabelled([Recording({"finger": pad})]).sensor)
    for title, calibrated in (("later", False), ("after", True)):
        answers = [
            (answer_of(frames[g, k], field=mask[k], sensor=sensors[k] if calibrated else None), TRUE[shape])
            for shape, names in SHAPES.items()
            for g in np.flatnonzero(np.isin(label, names) & ~first)
            for k in (0, 1)
            if frames[g, k].any()
        ]
        _print("Weiss, gains", title, answers)


def _print(of: str, title: str, answers: list[tuple[Answer, set[str]]]) -> None:
    n = len(answers)
    named = Counter(answer.name for answer, _ in answers)
    counted = {
        "set holds": sum(not true.isdisjoint(answer.answer_set) for answer, true in answers),
        "unknown": named["unknown"],
        "right": sum(answer.name in true for answer, true in answers),
        "wrong with p > .9": sum(
            answer.name not in true and answer.name != "unknown" and answer.probability > SURE
            for answer, true in answers
        ),
    }
    shares = (f"{what} {share(f'{of}, {title}: {what}', k / n, '5.1f')}" for what, k in counted.items())
    size = figure(f"{of}, {title}: set size", sum(len(answer.answer_set) for answer, _ in answers) / n, ".2f", "names")
    most = ", ".join(f"{name} {k / n:.2f}" for name, k in named.most_common(4))
    print(f"    {title:9} {n:4} contacts: {', '.join(shares)}, set of {size}   {most}")


def fingers() -> None:
    """Print what is said of fingers on a touch screen."""
    path = find_recording("capcontact_fingers.npz")
    if path is None:
        return
    frames, truth = single_contacts(path)
    small, given, n = 0, Counter[str](), len(truth)
    for t in truth:
        contact = next(c for c in find_contacts(frames[t.frame], floor=THRESHOLD) if t.blob[c.peak_taxel])
        surface = recognize(contact)
        given[answer_to(contact).name] += 1
        small += any(words in reason for reason in surface.reasons for words in TOO_SMALL)
    print(
        f"    {n} fingers: told to be too small for a form {share('fingers: told to be too small', small / n)}; "
        + ", ".join(f"{name} {k / n:.2f}" for name, k in given.most_common(4))
    )
    share("fingers: unknown", given["unknown"] / n)


def main() -> None:
    """Print the figures."""
    print("  Weiss pads, peak frames, the sensor unknown:")
    weiss()
    print("  All but each object's first ten grasps, as they come and with gains found from those ten:")
    weiss_calibrated()
    print("  CapContact:")
    fingers()


if __name__ == "__main__":
    main()
