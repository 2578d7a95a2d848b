"""Plain arrays and words given where an object of the package is wanted: one line that says what to give."""

from __future__ import annotations

import builtins
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from varishold.calibration import calibrate_even, calibrate_unlabelled
from varishold.errors import InputError, MissingExtraError
from varishold.hand import grasp_object
from varishold.hand.objects import graspable
from varishold.learning import TactileClassifier
from varishold.perceive import Perceiver, shipped_library
from varishold.perceive.library_file import read_packed_library
from varishold.recording import Pad, Recording, read, write
from varishold.skin import Skin, press, reconstruct, sense
from varishold.solids import Sphere, ideal_frame
from varishold.touch import find_contacts, recognize

FRAME: Any = np.pad(np.ones((4, 4)), 3)
SKIN = Skin("half-space")
CONTACT = find_contacts(FRAME)[0]
BALL = Sphere(20e-3)
PAD = Pad(FRAME[None])
PRESSES, LABELS = np.stack([FRAME] * 4), ["cup", "cup", "box", "box"]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: Recording(FRAME[None]), r"pads must be by name, as \{\"pad\": Pad\(values\)\}, got ndarray"),
        (lambda: Recording({"left": FRAME[None]}), r"pad 'left' must be a Pad, as Pad\(values\) makes it, got ndarray"),
        (lambda: recognize(FRAME), r"recognize takes a contact, one of find_contacts\(frame\), got ndarray"),
        (lambda: recognize(None), "got NoneType"),  # type: ignore[arg-type]
        (
            lambda: find_contacts(FRAME, sensor="mat.toml"),
            r"sensor must be a Sensor, as read_sensor\(path\) .*, got str",
        ),  # type: ignore[arg-type]
        (lambda: reconstruct(FRAME, "skin.toml", pitch=1e-3), r"skin must be a Skin, as read_skin\(path\) .*, got str"),  # type: ignore[arg-type]
        (lambda: press(FRAME, None, depth=1e-3), "skin must be a Skin, .*, got NoneType"),  # type: ignore[arg-type]
        (lambda: press("sphere", SKIN, depth=1e-3), "a height map must be numbers of shape .*, got <U6"),  # type: ignore[arg-type]
        (lambda: recognize(CONTACT, relief=FRAME), "relief must be a Relief, as reconstruct gives it, got ndarray"),
        (lambda: ideal_frame("sphere", (8, 8), 1e-3), r"solid must be a Solid, as Sphere\(0\.02\) is, got str"),  # type: ignore[arg-type]
        (lambda: ideal_frame(BALL, 8, 1e-3), r"shape must be \(rows, cols\), two whole numbers from 1, got 8"),  # type: ignore[arg-type]
        (lambda: ideal_frame(BALL, (8, 8), "1 mm"), "pitch_m must be one spacing in metres or"),  # type: ignore[arg-type]
        (lambda: Sphere("20 mm"), "of a sphere must be positive and finite, got '20 mm'"),  # type: ignore[arg-type]
        (lambda: press(BALL, SKIN, depth="1 mm"), "depth must be positive and finite, got '1 mm'"),  # type: ignore[arg-type]
        (lambda: press(BALL, SKIN, depth=1e-3, per_taxel=1.5), "per_taxel must be a whole number from 1, got 1.5"),  # type: ignore[arg-type]
        (
            lambda: press(BALL, SKIN, depth=1e-3, per_taxel=10**6),
            "are more than 33,554,432 cells; give fewer per_taxel",
        ),
        (
            lambda: press(BALL, SKIN, depth=1e-3, max_iterations=0),
            "max_iterations must be a whole number from 1, got 0",
        ),
        (lambda: press(BALL, SKIN, depth=1e-3, tolerance=0.0), "tolerance must be positive and finite, got 0.0"),
        (
            lambda: reconstruct(FRAME, SKIN, pitch=1e-3, noise=math.nan),
            "noise must be finite and not negative, got nan",
        ),
        (
            lambda: find_contacts(FRAME, valid=[[True], [True, False]]),
            "valid must have the shape of a frame, .* lengths",
        ),
        (lambda: Recording({"pad": PAD}, press_columns=["cup"]), "press_columns must be by name, got list"),  # type: ignore[arg-type]
        (lambda: Recording({"pad": PAD}, signals=[1.0]), "signals must be by name, got list"),  # type: ignore[arg-type]
        (lambda: Recording({"pad": PAD}, marks="cup"), "marks must be pairs of a frame and a label, got 'cup'"),  # type: ignore[arg-type]
        (lambda: TactileClassifier(error="few").fit(PRESSES, LABELS), "error must lie between 0 and 1, got 'few'"),  # type: ignore[arg-type]
        (lambda: Perceiver(pose=["lying"]), "pose must be a word, got list"),  # type: ignore[arg-type]
        (lambda: shipped_library(["lying"]), "pose must be one of upright, lying, got"),  # type: ignore[arg-type]
        (lambda: sense(FRAME), r"press must be a PressedSolid, as press\(solid, skin\) gives it, got ndarray"),
        (lambda: calibrate_even(FRAME), "recordings must be a list of Recording, got ndarray"),
        (lambda: calibrate_even([FRAME]), "recordings must be a list of Recording, got ndarray in it"),  # type: ignore[list-item]
        (
            lambda: calibrate_unlabelled([Recording({"pad": PAD})], sensor="mat.toml"),
            r"sensor must be a Sensor, .*, got str",
        ),  # type: ignore[arg-type]
        (lambda: read(None), "path must be the name of a file, got None"),  # type: ignore[arg-type]
        (lambda: write(Recording({"pad": PAD}), None), "path must be the name of a file, got None"),  # type: ignore[arg-type]
        (lambda: write(PAD, "a.npz"), "recording must be a Recording, .*, got Pad"),  # type: ignore[arg-type]
        (lambda: graspable("cylinder", "8 cm"), "size of the cylinder must be one number of metres, got '8 cm'"),  # type: ignore[arg-type]
        (lambda: grasp_object(8, 0.08, seed=1), "name must be an object's name or a Solid, got int"),  # type: ignore[arg-type]
        (lambda: grasp_object("cylinder", 0.08, seed=1.5), "seed must be a whole number from 0 on, got 1.5"),  # type: ignore[arg-type]
    ],
)
def test_a_wrong_thing_is_told_in_a_line_that_says_what_to_give(call: Callable[[], object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        call()


def test_a_python_without_lzma_is_told_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = builtins.__import__

    def without(name: str, *more: Any, **others: Any) -> Any:
        if name == "lzma":
            raise ModuleNotFoundError("No module named '_lzma'")
        return usual(name, *more, **others)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingExtraError, match=r"objects\.npz\.xz: this Python was built without lzma"):
        read_packed_library("objects.npz.xz")
