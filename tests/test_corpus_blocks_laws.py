"""Blocks against a plain cutting: they hold every frame once, none is too large, and what was looked at comes back."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests.corpus_recordings import recording

from varishold.corpus import AskTouch, survey
from varishold.corpus.ask import Looked
from varishold.corpus.pads_seen import looked_at, seen_in
from varishold.corpus.survey import Survey, frame_bytes, health_of, read_survey
from varishold.errors import InputError
from varishold.files import write_archive
from varishold.recording import Pad, Recording
from varishold.recording.inspection import summarize
from varishold.touch.pad_frames import PadFrames, pad_frames


def survey_of(n_frames: int, size: int, groups: list[tuple[int, int]] | None = None, **how: Any) -> Survey:
    held = None if groups is None else np.array(groups, np.int64).reshape(-1, 2)
    return Survey(n_frames, size, Looked(held, how.get("facts", {}), how.get("arrays", {})), how.get("health", {}))


def blocks_of(made: Survey) -> list[tuple[int, int, list[tuple[int, int]]]]:
    blocks = [made.block(k) for k in range(made.n_blocks)]
    return [(each.first, each.last, [(g.start, g.stop) for g in each.groups]) for each in blocks]


@settings(max_examples=40)
@given(st.integers(1, 20_000), st.integers(0, 1 << 27))
@example(4096, 1)
@example(4097, 1)
@example(5000, 0)
@example(8192, (1 << 25) // 4096)
@example(8192, (1 << 25) // 4096 + 1)
@example(3, (1 << 25) + 1)
def test_blocks_without_groups_are_as_long_as_the_page_says(n_frames: int, size: int) -> None:
    # At most 4096 frames, and 32 MiB of them; a frame that is larger is a block.
    most = next(k for k in (min(4096, 32 * 2**20 // size) if size else 4096, 1) if k > 0)
    blocks = blocks_of(survey_of(n_frames, size))
    assert [first for first, *_ in blocks] == list(range(0, n_frames, most))
    assert [last for _, last, _ in blocks] == [*range(most, n_frames, most), n_frames]
    for first, last, groups in blocks[:3] + blocks[-1:]:
        assert groups == [(k, k + 1) for k in range(first, last)]


@st.composite
def stretches(draw: st.DrawFn) -> list[tuple[int, int]]:
    """Draw groups, most of them in the order of the frames."""
    groups, at = [], 0
    for _ in range(draw(st.integers(1, 12))):
        at = max(0, at + draw(st.sampled_from([0, 0, 1, 3, 9, -15])))
        groups.append((at, at + draw(st.integers(1, 8))))
        at = groups[-1][1]
    return groups


@given(stretches(), st.integers(1, 24))
def test_groups_are_cut_where_they_go_back_or_grow_too_long(groups: list[tuple[int, int]], most: int) -> None:
    expected: list[list[tuple[int, int]]] = []
    for group in groups:
        fits = expected and group[0] >= expected[-1][-1][1] and group[1] - expected[-1][0][0] <= most
        if fits:
            expected[-1].append(group)
        else:
            expected.append([group])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(survey, "_FRAMES", most)
        blocks = blocks_of(survey_of(200, 8, groups))
    assert blocks == [(held[0][0], held[-1][1], held) for held in expected]


@settings(max_examples=30)
@given(
    st.integers(1, 10**9),
    st.integers(0, 10**9),
    st.one_of(st.none(), stretches()),
    st.dictionaries(st.text(max_size=5), st.one_of(st.none(), st.floats(allow_nan=False), st.lists(st.text()))),
)
def test_a_survey_comes_back_as_it_was(
    tmp_path_factory: pytest.TempPathFactory, n: int, size: int, groups: Any, facts: dict[str, Any]
) -> None:
    path = tmp_path_factory.mktemp("s") / "a.survey.npz"
    arrays = {"rest.0": np.arange(6.0).reshape(2, 3), "valid.1": np.array([[True, False]])}
    made = survey_of(n, size, groups, facts=facts, arrays=arrays, health={"faults": ["odd", "µ"], "begin_s": None})
    made.write(path)
    back = read_survey(path)
    assert (back.n_frames, back.frame_bytes, back.health) == (n, size, made.health)
    assert back.looked.facts == facts
    assert (back.looked.groups is None) == (groups is None)
    if groups is not None and back.looked.groups is not None:
        assert back.looked.groups.tolist() == list(map(list, groups))
    assert set(back.looked.arrays) == set(arrays)
    for name, array in arrays.items():
        np.testing.assert_array_equal(back.looked.arrays[name], array)
        assert back.looked.arrays[name].dtype == array.dtype


@pytest.mark.parametrize("text", [b"[1, 2]", b"nothing", b"{}", b'{"n_frames": 1, "frame_bytes": 1, "facts": {}}'])
def test_what_is_no_survey_is_told_by_its_name(tmp_path: Path, text: bytes) -> None:
    write_archive({"told": np.frombuffer(text, np.uint8)}, tmp_path / "a.npz", kind="survey")
    with pytest.raises(InputError, match=r"a\.npz: "):
        read_survey(tmp_path / "a.npz")


def test_a_frame_s_bytes_are_those_of_all_pads() -> None:
    pads = {"a": Pad(np.zeros((3, 4, 5), np.uint16)), "b": Pad(np.zeros((3, 7, 2)))}
    assert frame_bytes(Recording(pads)) == 4 * 5 * 2 + 7 * 2 * 8


def test_health_is_what_the_summary_says_of_all_pads() -> None:
    made = recording(3, 60, n_pads=2)
    frames = np.array(made.pads["p1"].frames)
    frames[:, 2, 3] = 0.0
    valid = np.ones(frames.shape[1:], bool)
    valid[0, 0] = False
    time_s = 5.0 + np.r_[np.arange(30), np.arange(35, 65)] / 50
    odd = Recording({"p0": made.pads["p0"], "p1": Pad(frames, valid=valid)}, time_s, notes=("seen",))
    told, found = health_of(odd), summarize(odd)
    assert told["n_frames"] == 60
    assert told["begin_s"] == 5.0
    assert math.isclose(told["duration_s"], 64 / 50)
    assert told["n_lacking"] == 5
    assert told["n_taxels"] == 2 * 72
    assert told["n_broken"] == sum(pad.n_broken for pad in found.pads) == 2
    assert told["faults"] == list(found.faults) != []
    assert told["notes"] == list(found.notes)
    untimed = health_of(Recording(odd.pads))
    assert (untimed["begin_s"], untimed["duration_s"], untimed["n_lacking"]) == (None, None, 0)


@settings(max_examples=20)
@given(st.integers(0, 30), st.sampled_from([{}, {"rest": 40.0}, {"n_pads": 2, "rest": 90.0}, {"whole": True}]))
def test_a_block_knows_of_its_pads_what_the_whole_told(seed: int, how: dict[str, Any]) -> None:
    whole = recording(seed, **how)
    seen = pad_frames(whole)
    groups = np.array([[0, 3]], np.int64)
    looked = looked_at(seen, groups)
    assert looked.groups is groups
    assert looked_at(seen).groups is None
    block = Recording({name: Pad(pad.frames[5:9]) for name, pad in whole.pads.items()})
    again = seen_in(block, looked)
    assert list(again) == list(seen)
    for name, pad in seen.items():
        assert again[name].pad is block.pads[name]
        for held in ("rest", "valid"):
            np.testing.assert_array_equal(getattr(again[name], held), getattr(pad, held))
        assert (again[name].sigma, again[name].full_scale, again[name].notes) == (pad.sigma, pad.full_scale, pad.notes)


def test_pads_do_not_change_their_rests() -> None:
    pads = {name: Pad(np.zeros((2, 2, 2))) for name in "abc"}
    rests = {"a": None, "b": np.full((2, 2), 1.0), "c": np.full((2, 2), 2.0)}
    valid = {"a": np.array([[True, False], [True, True]]), "b": None, "c": np.eye(2, dtype=bool)}
    seen = {n: PadFrames(pads[n], rests[n], None, valid[n], 9.0, ("x",)) for n in pads}
    again = seen_in(Recording(pads), looked_at(seen))
    for name in pads:
        for now, then in ((again[name].rest, rests[name]), (again[name].valid, valid[name])):
            assert (now is None) == (then is None)
            assert now is None or then is None or np.array_equal(now, then)


@pytest.mark.parametrize("frames", ["all", "press", "peak", "7"])
def test_a_look_keeps_the_groups_that_are_asked_for(frames: str) -> None:
    looked = AskTouch(frames).look(recording(1, 60), None)
    if frames == "all":
        assert looked.groups is None
        return
    assert looked.groups is not None
    assert looked.groups.dtype == np.int64
    if frames == "7":
        assert looked.groups.tolist() == [[7, 8]]
    if frames == "peak":
        ((first, last),) = looked.groups.tolist()
        assert last == first + 1
    if frames == "press":
        # It is pressed every twenty frames, from the tenth on.
        assert [start // 10 for start, _ in looked.groups.tolist()] == [1, 3, 5]
