"""Files of messages taken in blocks: whatever `read` says of all of them, the blocks say of their frames."""

from __future__ import annotations

import dataclasses
import errno
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_recording_mcap import recordings, same
from tests.test_recording_rosbags import FRAMES, bag1, bag2

from varishold import FormatError, InputError
from varishold import open as open_recording
from varishold.cli.app import app
from varishold.recording import Blocks, Pad, Recording, Signals, formats, read, stored, write
from varishold.recording.mcap import PadFacts, TopicWriter
from varishold.recording.mcap.topics import MARKS


def agree(path: Path, *, shape: tuple[int, int] | None = None) -> None:
    """Assert that a file says in any parts what it says at once."""
    whole = read(path, shape=shape)
    with open_recording(path, shape=shape) as opened:
        same(opened.whole, whole)
        assert opened.whole.notes == whole.notes
        blocks = Blocks(whole)
        n = whole.n_frames
        for first, last in {(0, 1), (n - 1, n), (n // 2, n), (n // 3, n // 3 + 1), (0, n), (n // 4, n // 2 + 1)}:
            same(opened.frames[first:last], blocks.frames[first:last])
        for size in (1, 7, 10**6):
            for mine, its in zip(opened.blocks(size), blocks.blocks(size), strict=True):
                same(mine, its)


def refusal(how: Callable[[Path], object], path: Path) -> str:
    """Return why a file is refused; empty where it is not."""
    try:
        how(path)
    except FormatError as error:
        return str(error)
    return ""


@settings(deadline=None)
@given(recordings())
def test_what_was_written_as_mcap(tmp_path_factory: pytest.TempPathFactory, recording: Recording) -> None:
    path = tmp_path_factory.mktemp("mcap") / "a.mcap"
    write(recording, path)
    agree(path)


@settings(deadline=None, max_examples=50)
@given(
    st.lists(
        st.tuples(st.sampled_from(["palm", "tip", "signals"]), st.integers(-2, 5), st.booleans(), st.booleans()),
        min_size=4,
        max_size=40,
    ),
    st.booleans(),
)
def test_pads_that_are_read_at_times_of_their_own(
    tmp_path_factory: pytest.TempPathFactory, said: list[tuple[str, int, bool, bool]], ended: bool
) -> None:
    """Clocks that go back, chunks that end anywhere, the sensor's time now and then, no end."""
    path, now = tmp_path_factory.mktemp("mcap") / "a.mcap", 100
    shapes = {"palm": (2, 3), "tip": (1, 2), "signals": (3,)}
    with path.open("wb") as file:
        writer = TopicWriter(file, "measurement")
        writer.describe(PadFacts("signals", kind="signals", names=("x", "y", "z")))
        for k, (name, step, timed, flushed) in enumerate(
            [*(("palm", 1, True, True),) * 2, ("tip", 1, True, False), *said]
        ):
            now = max(0, now + step)
            values = np.arange(np.prod(shapes[name]), dtype=np.float32).reshape(shapes[name]) + k
            writer.reading({name: values}, log_ns=now, device_ns=7 * k if timed else None, sequence=k)
            writer.tell(MARKS, {"label": f"thing {k // 3}"}, log_ns=now)
            if flushed:
                writer.flush()
        writer.flush()
        if ended:
            writer.finish()
    if (refused := refusal(read, path)) or refusal(open_recording, path):
        assert refusal(open_recording, path) == refused
    else:
        agree(path)


def test_bags_of_ros(tmp_path: Path) -> None:
    agree(bag1(tmp_path / "a.bag"))
    folder = bag2(tmp_path / "bag")
    agree(folder)
    agree(next(folder.glob("*.db3")))


def test_numbers_that_are_none_are_left_out_of_every_block(tmp_path: Path) -> None:
    frames = FRAMES.astype(np.float32)
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = TopicWriter(file)
        for k, frame in enumerate(frames):
            frame[1, 2] = np.nan if k == 33 else 1
            writer.reading({"pad": frame}, log_ns=k)
            writer.flush()
        writer.finish()
    agree(tmp_path / "a.mcap")
    with open_recording(tmp_path / "a.mcap") as opened:
        assert opened.frames[:5].pads["pad"].valid is not None


def test_frames_are_found_by_time_and_damage_before_the_first(tmp_path: Path) -> None:
    write(Recording({"pad": Pad(FRAMES)}, time_s=np.arange(40) / 10), tmp_path / "a.mcap")
    with open_recording(tmp_path / "a.mcap") as opened:
        assert [opened.frame_at(t) for t in (-1, 0, 0.05, 1.0, 3.9, 4)] == [0, 0, 1, 10, 39, 40]
    content = bytearray((tmp_path / "a.mcap").read_bytes())
    content[len(content) // 3] ^= 255
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(FormatError, match="is damaged at byte"):
        open_recording(tmp_path / "a.mcap")


def test_what_is_large_is_mapped_and_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frames = np.random.default_rng(0).integers(0, 99, (500, 6, 7)).astype(np.uint16)
    signals = {"shear": Signals(frames[:, 0].astype(np.float32))}
    made = Recording({"palm": Pad(frames), "tip": Pad(frames[:, :2] + 1)}, np.arange(500) / 7, signals=signals)
    for ending in ("mcap", "h5", "mat", "parquet"):
        write(made, tmp_path / f"a.{ending}")
    monkeypatch.setattr(stored, "_IN_MEMORY", 1000)
    monkeypatch.setattr(stored, "_TOGETHER", 10_000)
    monkeypatch.setattr(formats, "_LARGE", 0)
    for ending in ("mcap", "h5", "mat", "parquet"):
        again = read(tmp_path / f"a.{ending}")
        same(again, made)
        assert is_mapped(again.pads["palm"].frames)
    done = CliRunner().invoke(app, ["touch", str(tmp_path / "a.mcap"), "--json"])
    assert done.exit_code == 0, done.output
    monkeypatch.setattr(stored, "TemporaryFile", full)
    with pytest.raises(InputError, match=r"a.h5: \d+ bytes of temporary space are wanted in .*: no space left"):
        read(tmp_path / "a.h5")


def is_mapped(array: np.ndarray | None) -> bool:
    return isinstance(array, np.memmap) or (array is not None and is_mapped(array.base))


def full(**_: object) -> object:
    raise OSError(errno.ENOSPC, "No space left on device")


class Asked:
    """A column that remembers what it was asked for."""

    def __init__(self, frames: np.ndarray) -> None:
        self._frames, self.asked = frames, list[int]()
        self.shape, self.dtype = frames.shape, frames.dtype

    def __getitem__(self, wanted: slice, /) -> np.ndarray:
        self.asked.append(wanted.stop - wanted.start)
        return self._frames[wanted]


@pytest.mark.parametrize(("together", "at_once"), [(1, 1), (95, 1), (96, 1), (191, 1), (192, 2), (500, 5), (10**6, 11)])
def test_what_is_mapped_is_read_in_blocks_of_so_many_bytes_and_never_less_than_a_frame(
    monkeypatch: pytest.MonkeyPatch, together: int, at_once: int
) -> None:
    monkeypatch.setattr(stored, "_IN_MEMORY", 0)
    monkeypatch.setattr(stored, "_TOGETHER", together)
    frames = np.arange(11 * 12.0).reshape(11, 3, 4)
    held = stored.stored_of(Recording({"pad": Pad(frames)}))
    column = Asked(frames)
    pads = {"pad": dataclasses.replace(held.pads["pad"], frames=column)}
    whole = dataclasses.replace(held, pads=pads).whole()
    np.testing.assert_array_equal(whole.pads["pad"].frames, frames)
    assert column.asked == [at_once] * (11 // at_once) + ([11 % at_once] if 11 % at_once else [])
