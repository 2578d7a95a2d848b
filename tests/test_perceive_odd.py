"""What a call of perceiving does not take is refused in one line, as a number for a name or a text for a number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from varishold import InputError, Pad, Recording
from varishold.perceive import (
    Belief,
    Evidence,
    GripContacts,
    ImplicitSurface,
    Library,
    NameEvidence,
    Perceiver,
    SizePrior,
    SourceWeights,
    SurfaceContacts,
    evidence_of_recording,
    evidence_of_row,
    fit_ball_size,
    fit_section,
    form_values,
    fuse,
    grip_values,
    merge_evidence,
    pad_values,
    switch_values,
    write_library,
    write_stl,
)
from varishold.recording import GraspTable

#: Things that are of no use anywhere; no name, no number and no list of either is among them.
NOTHING: tuple[Any, ...] = (object(), 1j, b"x", lambda: 0)
EXAMPLES = [[Evidence("grasp", {"a": 0.1 * k})] for k in range(3)]
LIBRARY = Library.from_examples(
    {"x": EXAMPLES, "y": EXAMPLES[::-1]}, sizes_m={"x": [0.05] * 3}, poses={"x": ["lying", "upright", "upright"]}
)
BELIEF = Belief.before(LIBRARY)
SAID = np.log([[0.9, 0.1], [0.2, 0.8]])
POINTS = 0.04 * np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
CONTACTS = SurfaceContacts(POINTS, POINTS)
GRIP = GripContacts(("a", "b"), np.zeros((2, 3)), np.ones((2, 3)), np.ones(2), np.ones(2, bool))
TABLE = GraspTable({"switch.a": np.array([True, False])})
RECORDING = Recording({"pad": Pad(np.ones((2, 4, 4)), pitch_m=0.002)})


def _made(**more: Any) -> Library:
    return Library.from_examples({"x": EXAMPLES, "y": EXAMPLES}, **more)


def _named(**more: Any) -> NameEvidence:
    return NameEvidence("camera", {"x": 1.0}, **more)


#: Each call with what it does not take, beside what is of no use anywhere.
CALLS: dict[str, tuple[Callable[[Any], object], tuple[Any, ...]]] = {
    "touch": (lambda odd: Evidence(odd, {}), (None, 5, True, "")),
    "values": (lambda odd: Evidence("grasp", odd), (None, 5, "a", [1.0])),
    "value": (lambda odd: Evidence("grasp", {"a": odd}), (None, "1", [1.0])),
    "name of a value": (lambda odd: Evidence("grasp", {odd: 1.0}), (None, 5, True)),
    "remarks": (lambda odd: Evidence("grasp", {}, remarks=odd), (None, 5, "odd", ("odd", 5))),
    "reasons": (lambda odd: Evidence("grasp", {}, reasons=odd), (None, True, "odd", (None,))),
    "failed": (lambda odd: Evidence("grasp", {}, failed=odd), (None, "yes", 1, [])),
    "switches": (switch_values, (None, 5, "a", [True])),
    "switch": (lambda odd: switch_values({"a": odd}), ("1", 5, 0.5, [True])),
    "name of a switch": (lambda odd: switch_values({odd: True}), (None, 5, True)),
    "size of a pad": (lambda odd: pad_values("pad", None, size_m=odd), (True, "0.05", [0.05])),
    "name of a pad": (lambda odd: pad_values(odd, None), (None, 5, True)),
    "surface of a pad": (lambda odd: pad_values("pad", odd), (True, "flat", 5)),
    "surfaces": (lambda odd: form_values(None, odd), (True, "flat", 5, [])),
    "grip": (grip_values, (True, "x", 5, [])),
    "ball": (fit_ball_size, (None, True, "x", 5)),
    "section": (lambda odd: fit_section(GRIP, odd), (None, 5, "x", [])),
    "grows": (lambda odd: fit_section(GRIP, "circle", grows=odd), (None, 1, "yes", [])),
    "parts": (lambda odd: GripContacts(odd, [], [], [], []), (None, 5, "ab", [5])),
    "rows": (lambda odd: evidence_of_row(odd, 0), (None, 5, "table.csv")),
    "columns": (lambda odd: evidence_of_row(TABLE, 0, columns=odd), (None, 5, [5])),
    "recording": (evidence_of_recording, (None, 5, "a.npz")),
    "pads": (lambda odd: evidence_of_recording(RECORDING, pads=odd), (5, "pad", [5])),
    "skin": (lambda odd: evidence_of_recording(RECORDING, skin=odd), (5, "skin.toml", {"pad": 5})),
    "merged": (lambda odd: merge_evidence(EXAMPLES[0][0], odd), (None, 5, "grasp")),
    "size": (lambda odd: SizePrior(odd, 0.01), (None, True, "0.05", 10**400)),
    "probability": (lambda odd: NameEvidence("camera", {"x": odd}), (None, True, "1")),
    "name of a probability": (lambda odd: NameEvidence("camera", {odd: 1.0}), (None, 5, True)),
    "weight": (lambda odd: _named(weight=odd), (None, True, "1")),
    "sizes": (lambda odd: _made(sizes_m=odd), (True, 5, "x", [0.05])),
    "size of each": (lambda odd: _made(sizes_m={"x": odd}), (True, "0.05", [0.05, "0.05", 0.05], [0.05, True, 0.05])),
    "costs": (lambda odd: _made(costs=odd), (True, 5, "grasp", [1.0])),
    "cost": (lambda odd: _made(costs={"grasp": odd}), (None, True, "1")),
    "poses": (lambda odd: _made(poses=odd), (True, 5, "lying", ["lying"])),
    "poses of an object": (lambda odd: _made(poses={"x": odd}), (None, True, 5, "lying", [5] * 3)),
    "hand": (lambda odd: _made(hand=odd), (True, 5, ["mine"])),
    "object": (lambda odd: LIBRARY.with_object(odd, EXAMPLES), (None, True, 5)),
    "only": (LIBRARY.only, (None, True, 5, "x", [5], [None])),
    "wider": (lambda odd: LIBRARY.with_wider("x", odd), (None, True, 5, ["y"])),
    "pose": (LIBRARY.in_pose, (None, True, 5, ["lying"])),
    "share": (LIBRARY.tempered, (None, True, "0.5", [0.5])),
    "own": (lambda odd: LIBRARY.tempered(0.5, own=odd), (None, True, "0.5")),
    "touches": (lambda odd: LIBRARY.tempered(0.5, odd), (True, 5, "grasp", [5])),
    "library": (Perceiver, (True, 5, "mine.npz")),
    "least": (lambda odd: Perceiver(LIBRARY, least_touches=odd), (None, True, "1", 1.0)),
    "refuse": (lambda odd: Perceiver(LIBRARY, refuse=odd), (None, 1, "yes")),
    "error": (lambda odd: Perceiver(LIBRARY, error=odd), (None, True, "0.1")),
    "strangers": (lambda odd: Perceiver(LIBRARY, strangers=odd), (None, False, "0.1")),
    "among": (lambda odd: Perceiver(LIBRARY).plan(odd), (True, 5, "grasp", [5])),
    "failed touch": (Perceiver(LIBRARY).failed, (None, True, 5, ["grasp"])),
    "believed": (Belief.before, (None, True, 5, "mine.npz")),
    "prior": (lambda odd: Belief.before(LIBRARY, odd), (True, 5, "x", {"x": 1.0})),
    "share of strangers": (lambda odd: Belief.before(LIBRARY, strangers=odd), (None, True, "0.1", 1.0)),
    "felt": (BELIEF.after, (None, True, 5, "grasp")),
    "whose size": (BELIEF.size, (True, 5, ["x"])),
    "written": (lambda odd: write_library(odd, "never.npz"), (None, 5, "x")),
    "weights": (lambda odd: fuse({"a": SAID}, odd), (True, 5, ["a"])),
    "log prior": (lambda odd: fuse({"a": SAID}, log_prior=odd), (True, "x", {}, [0, [1, 2]])),
    "source weights": (lambda odd: SourceWeights(odd, odd), (None, True, 5, "a", ["a"])),
    "sigma": (lambda odd: SurfaceContacts(POINTS, POINTS, sigma_m=odd), (None, True, "1", [1, [1, 2]])),
    "touch of a point": (lambda odd: SurfaceContacts(POINTS, POINTS, touch=odd), (True, "1", [1, [1, 2]])),
    "contacts": (ImplicitSurface, (None, True, 5, POINTS)),
    "table": (lambda odd: ImplicitSurface(CONTACTS, table_m=odd), (True, "0", [0.0])),
    "mesh": (lambda odd: write_stl("never.stl", odd), (None, 5, "x")),
}


@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_such_thing_is_refused_in_one_line(name: str) -> None:
    call, odd = CALLS[name]
    for each in (*odd, *NOTHING):
        with pytest.raises(InputError) as caught:
            call(each)
        assert "\n" not in str(caught.value)


def test_the_steps_and_the_least_known_place_of_a_surface() -> None:
    surface = ImplicitSurface(CONTACTS)
    for odd in (None, True, "9", [9], *NOTHING):
        with pytest.raises(InputError, match=r"steps of a surface's grid must lie in 8 \.\. 120"):
            surface.mesh(steps=odd)
    for odd in (True, 5, "mesh", POINTS):
        with pytest.raises(InputError, match="mesh must be a SurfaceMesh, as mesh"):
            surface.least_known(odd)  # type: ignore[arg-type]


def test_what_is_refused_leaves_all_as_it_was() -> None:
    perceiver = Perceiver(LIBRARY)
    perceiver.feel(EXAMPLES[0][0])
    before = perceiver.belief
    for odd in NOTHING:
        with pytest.raises(InputError, match="feel takes Evidence or NameEvidence"):
            perceiver.feel(odd)
        with pytest.raises(InputError, match="a touch has a name"):
            perceiver.failed(odd)
    assert perceiver.belief is before


def test_what_means_the_same_is_taken() -> None:
    assert switch_values({"a": np.bool_(True), "b": 0, "c": 1.0}) == {"switch.a": 1.0, "switch.b": 0.0, "switch.c": 1.0}
    assert Evidence("grasp", {"switch.a": True, "b": np.float32(0.5)}).values == {"switch.a": 1.0, "b": 0.5}
    assert LIBRARY.only(("y",)).objects == LIBRARY.only(name for name in ("y",)).objects == ("y",)
    made = _made(sizes_m={"x": [0.05, None, np.nan]}, costs={"grasp": np.float32(2)}, hand="mine")
    assert np.isnan(made.log_size[1:]).all()
    assert (made.touches["grasp"].cost, made.hand) == (2.0, "mine")
