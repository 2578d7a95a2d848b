"""Whatever a recording holds and whichever file holds it: its blocks are parts of the whole."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.test_recording_hdf5 import writable
from tests.test_recording_mcap import assert_same, recordings, same

from varishold import open as open_recording
from varishold.recording import Recording, read, write
from varishold.recording.blocks import Blocks
from varishold.recording.conversion import losses

ENDINGS = ("npz", "h5", "mat", "mcap", "parquet", "lerobot")


def part_of(whole: Any, part: Any, first: int, last: int) -> None:
    """Assert that a part holds what the whole holds of some frames."""
    assert (whole is None) == (part is None)
    if whole is not None:
        assert_same(whole[first:last], part)


@pytest.mark.parametrize("ending", ENDINGS)
@settings(deadline=None, max_examples=15)
@given(recordings(), st.integers(1, 4))
def test_blocks_of_any_file_are_parts_of_the_whole(
    tmp_path_factory: pytest.TempPathFactory, ending: str, recording: Recording, size: int
) -> None:
    assume(writable(recording))
    path = tmp_path_factory.mktemp("blocks") / f"a.{ending}"
    write(recording, path)
    held = read(path)
    if ending != "npz":
        same(recording, held)
        assert losses(recording, held) == losses(held, recording) == ()
    with open_recording(path) as opened:
        same(held, opened.whole)
        first = 0
        for block in opened.blocks(size):
            last = first + block.n_frames
            assert block.n_frames == min(size, recording.n_frames - first)
            assert (list(block.pads), block.unit, block.sensor) == (list(held.pads), held.unit, held.sensor)
            for name, pad in held.pads.items():
                other = block.pads[name]
                part_of(pad.frames, other.frames, first, last)
                assert (other.pitch_m, other.polarity) == (pad.pitch_m, pad.polarity)
                for key in ("field", "valid", "positions_m"):
                    assert_same(getattr(pad, key), getattr(other, key))
            part_of(held.time_s, block.time_s, first, last)
            part_of(held.press, block.press, first, last)
            for name, column in held.press_columns.items():
                assert_same(column, block.press_columns[name])
            for name, signals in held.signals.items():
                part_of(signals.values, block.signals[name].values, first, last)
                assert (block.signals[name].names, block.signals[name].unit) == (signals.names, signals.unit)
            said = [mark.label for mark in held.marks if mark.frame <= first][-1:]
            marks = [(0, label) for label in said]
            marks += [(mark.frame - first, mark.label) for mark in held.marks if first < mark.frame < last]
            whole = (first, last) == (0, held.n_frames)
            assert [tuple(mark) for mark in block.marks] == ([tuple(m) for m in held.marks] if whole else marks)
            first = last
        assert first == held.n_frames
    same(held, Blocks(held).whole)


@pytest.mark.parametrize("ending", ENDINGS)
def test_what_is_said_of_a_file_goes_before_what_it_says(tmp_path_factory: pytest.TempPathFactory, ending: str) -> None:
    from varishold.recording import Pad

    path = tmp_path_factory.mktemp("said") / f"a.{ending}"
    write(Recording({"x": Pad(np.arange(24).reshape(2, 3, 4), pitch_m=(0.1, 0.2))}), path)
    for act in (read, lambda path, **how: open_recording(path, **how).whole):
        pad = act(path, shape=(3, 4), pitch_m=0.5, polarity="down").pads["x"]
        assert (pad.pitch_m, pad.polarity) == ((0.5, 0.5), "down")
        pad = act(path).pads["x"]
        assert (pad.pitch_m, pad.polarity) == ((0.1, 0.2), "up")
        with pytest.raises(ValueError, match=r"has frames of 3 x 4, not 4 x 3; leave the shape out"):
            act(path, shape=(4, 3))
