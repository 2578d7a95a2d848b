"""Plain arrays and words given where an object of the package is wanted: one line that says what to give."""

from __future__ import annotations

import builtins
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from varishold.errors import InputError, MissingExtraError
from varishold.perceive.library_file import read_packed_library
from varishold.recording import Recording
from varishold.skin import Skin, press, reconstruct
from varishold.touch import find_contacts, recognize

FRAME: Any = np.pad(np.ones((4, 4)), 3)
SKIN = Skin("half-space")


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
