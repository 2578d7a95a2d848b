"""Tasks, and what they hold open: what was opened is closed, and what changed is not mixed."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.corpus_recordings import SHAPE, recording

from varishold.corpus import AskMeasure, AskTouch, opened, survey, tasks
from varishold.corpus.opened import Opened, Reading, open_recording, stamp_of
from varishold.corpus.survey import health_of
from varishold.corpus.tasks import BlockTask, CannotKeep, Job, Surveyed, SurveyTask, do, do_elsewhere
from varishold.errors import InputError
from varishold.recording import read, write
from varishold.recording.stored import stored_of
from varishold.sensor import Sensor, write_sensor


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], int]]:
    """Return what tells how many recordings are open; none is when the test ends with the thread's own."""
    count = [0]
    plain = opened.open_stored

    def counted(*what: Any, **how: Any) -> Any:
        stored = plain(*what, **how)
        count[0] += 1
        left = [1]

        def close() -> None:
            count[0] -= left[0]
            left[0] = 0
            stored.close()

        return replace(stored, close=close)

    monkeypatch.setattr(opened, "open_stored", counted)
    yield lambda: count[0]
    tasks._at_hand.close()
    assert count[0] == 0


def job_of(folder: Path, ask: Any = None, **how: Any) -> Job:
    (folder / "parts").mkdir(exist_ok=True)
    return Job(ask or AskTouch(), Reading(**how), str(folder / "parts"), "program")


def surveyed(job: Job, path: Path) -> Surveyed:
    found = do(SurveyTask(job, str(path)))
    assert isinstance(found, Surveyed)
    return found


# Opened


def test_a_stamp_is_the_names_sizes_and_times_of_all_files(tmp_path: Path) -> None:
    folder = tmp_path / "rec"
    folder.mkdir()
    for name, held in (("b", b"12"), ("a", b"1")):
        (folder / name).write_bytes(held)
        os.utime(folder / name, ns=(5, 10**18 + len(held)))
    a, b = (str(folder / "a"), 1, 10**18 + 1), (str(folder / "b"), 2, 10**18 + 2)
    assert stamp_of(str(folder)) == (a, b)
    assert stamp_of(str(folder / "b")) == (b,)
    with pytest.raises(InputError, match=r"none: there is no such file"):
        stamp_of(str(tmp_path / "none"))
    with pytest.raises(InputError, match="cannot be read"):
        stamp_of("a\0b")


def test_a_recording_is_opened_as_it_is_read(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", 59 - np.arange(60.0).reshape(3, 20))
    assert Reading() == Reading(None, None, None)
    one = open_recording(str(tmp_path / "a.npy"), Reading(shape=(4, 5), pitch_m=2e-3))
    (pad,) = one.whole().pads.values()
    assert (pad.frames.shape, pad.pitch_m) == ((3, 4, 5), (2e-3, 2e-3))
    assert (one.sensor, one.stamp) == (None, stamp_of(str(tmp_path / "a.npy")))
    one.close()
    write_sensor(Sensor(shape=(5, 4), span=1.0, polarity="down", rest=59.0), tmp_path / "mat.toml")
    two = open_recording(str(tmp_path / "a.npy"), Reading(str(tmp_path / "mat.toml")))
    (pad,) = two.whole().pads.values()
    assert two.sensor is not None
    assert pad.frames.shape == (3, 5, 4)
    # Upright: what fell rises.
    np.testing.assert_array_equal(np.diff(np.asarray(pad.frames).ravel()), 1.0)
    two.close()
    # What was said goes before what the sensor says, and here they do not agree.
    with pytest.raises(InputError, match=r"is for 5 x 4 taxels, pad 'pad' of .* has 2 x 10"):
        open_recording(str(tmp_path / "a.npy"), Reading(str(tmp_path / "mat.toml"), (2, 10)))


@pytest.mark.parametrize(("first", "last"), [(0, 40), (0, 1), (13, 29), (39, 40)])
def test_a_block_is_a_piece_of_the_whole(tmp_path: Path, first: int, last: int) -> None:
    made = recording(1, rest=-20.0, n_pads=2)
    one = Opened(stored_of(made), None, ())
    kept = one.kept(made)
    for each in (one, kept):
        block = each.block(first, last)
        for name, pad in block.pads.items():
            np.testing.assert_array_equal(pad.frames, made.pads[name].frames[first:last])
            assert pad.polarity == "down"
        assert block.time_s is not None
        assert made.time_s is not None
        np.testing.assert_array_equal(block.time_s, made.time_s[first:last])


def test_what_is_kept_lets_the_file_go(tmp_path: Path, closed: Callable[[], int]) -> None:
    write(recording(1), tmp_path / "a.npz")
    one = open_recording(str(tmp_path / "a.npz"), Reading())
    assert closed() == 1
    kept = one.kept(one.whole())
    assert closed() == 0
    assert kept.block(3, 5).n_frames == 2
    assert (kept.sensor, kept.stamp) == (one.sensor, one.stamp)


def test_what_cannot_be_turned_upright_is_closed(
    tmp_path: Path, closed: Callable[[], int], monkeypatch: pytest.MonkeyPatch
) -> None:
    def odd(*_: Any, **__: Any) -> Any:
        raise KeyboardInterrupt

    write(recording(1), tmp_path / "a.npz")
    monkeypatch.setattr(opened, "upright_stored", odd)
    with pytest.raises(KeyboardInterrupt):
        open_recording(str(tmp_path / "a.npz"), Reading())
    assert closed() == 0


def test_polarity_is_looked_at_unless_it_was_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[bool] = []
    plain = opened.upright_stored

    def noted(stored: Any, sensor: Any, *, checked: bool) -> Any:
        asked.append(checked)
        return plain(stored, sensor, checked=checked)

    monkeypatch.setattr(opened, "upright_stored", noted)
    write(recording(1), tmp_path / "a.npz")
    for checked in ({}, {"checked": True}, {"checked": False}):
        open_recording(str(tmp_path / "a.npz"), Reading(), **checked).close()
    assert asked == [False, True, False]


# Tasks


def test_a_survey_says_how_many_frames_and_blocks_there_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, closed: Callable[[], int]
) -> None:
    monkeypatch.setattr(survey, "_FRAMES", 15)
    write(recording(1, 40), tmp_path / "a.npz")
    job = job_of(tmp_path)
    found = surveyed(job, tmp_path / "a.npz")
    assert (found.n_frames, found.n_blocks, found.stamp) == (40, 3, stamp_of(str(tmp_path / "a.npz")))
    kept = survey.read_survey(job.survey_path(found.key))
    assert kept.health == health_of(read(tmp_path / "a.npz"))
    assert kept.frame_bytes == SHAPE[0] * SHAPE[1] * 8
    # Once it is there, nothing is looked at again.
    with monkeypatch.context() as patch:
        patch.setattr(AskTouch, "look", lambda *_: pytest.fail("it was looked at again"))
        assert surveyed(job, tmp_path / "a.npz") == found
    blocks = [do(BlockTask(job, str(tmp_path / "a.npz"), found.key, found.stamp, k)) for k in range(3)]
    assert blocks == [15, 15, 10]
    assert all(job.part_path(found.key, k).exists() for k in range(3))


def test_what_is_asked_otherwise_has_another_key(tmp_path: Path) -> None:
    for name in "ab":
        write(recording(1 if name == "a" else 2), tmp_path / f"{name}.npz")
    job = job_of(tmp_path)
    others = [
        job,
        replace(job, ask=AskMeasure()),
        replace(job, ask=AskTouch(levels=16)),
        replace(job, reading=Reading(pitch_m=0.5)),
        replace(job, program="another"),
    ]
    keys = [surveyed(each, tmp_path / "a.npz").key for each in others] + [surveyed(job, tmp_path / "b.npz").key]
    assert len(set(keys)) == 6
    (tmp_path / "c.npz").write_bytes((tmp_path / "a.npz").read_bytes())
    assert surveyed(job, tmp_path / "c.npz").key == keys[0]
    tasks._at_hand.close()


def test_a_recording_stays_open_for_its_blocks_and_no_longer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, closed: Callable[[], int]
) -> None:
    monkeypatch.setattr(survey, "_FRAMES", 20)
    job = job_of(tmp_path)
    for seed in (1, 2):
        write(recording(seed), tmp_path / f"{seed}.npz")
    one, two = (surveyed(job, tmp_path / f"{seed}.npz") for seed in (1, 2))
    opens: list[str] = []
    plain = tasks.open_recording

    reads: list[str] = []
    read_survey = tasks.read_survey
    monkeypatch.setattr(tasks, "read_survey", lambda path: reads.append(path.name) or read_survey(path))

    def noted(path: str, reading: Reading, **how: Any) -> Opened:
        assert how == {"checked": True}
        opens.append(Path(path).name)
        return plain(path, reading, **how)

    monkeypatch.setattr(tasks, "open_recording", noted)
    for found, name, number in ((two, 2, 0), (two, 2, 1), (one, 1, 0), (one, 1, 1), (two, 2, 0)):
        do(BlockTask(job, str(tmp_path / f"{name}.npz"), found.key, found.stamp, number))
        assert closed() <= 1
    assert opens == ["1.npz", "2.npz"]
    # What the look found is read once for the blocks that follow one another.
    assert reads == [f"{found.key}.survey.npz" for found in (two, one, two)]
    # Read otherwise, it is opened anew.
    other = replace(job, reading=Reading(pitch_m=0.25))
    do(BlockTask(other, str(tmp_path / "2.npz"), two.key, two.stamp, 0))
    assert opens[2:] == ["2.npz"]
    # Each thread has its own.

    def elsewhere() -> None:
        assert tasks._at_hand.opened(str(tmp_path / "2.npz"), Reading(), two.stamp).block(0, 3).n_frames == 3
        tasks._at_hand.close()

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert len(opens) == 4


def test_what_fails_amid_a_survey_is_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, closed: Callable[[], int]
) -> None:
    write(recording(1), tmp_path / "a.npz")
    job = job_of(tmp_path)
    with pytest.raises(InputError, match="there is no frame 99"):
        do(SurveyTask(replace(job, ask=AskTouch("99")), str(tmp_path / "a.npz")))
    assert closed() == 0
    monkeypatch.setattr(tasks, "stamp_of", lambda path: ())
    with pytest.raises(InputError, match=r"a\.npz: was changed while it was being read; run again"):
        do(SurveyTask(job, str(tmp_path / "a.npz")))
    assert closed() == 0


def test_what_cannot_be_kept_ends_the_run(tmp_path: Path) -> None:
    write(recording(1), tmp_path / "a.npz")
    job = job_of(tmp_path)
    found = surveyed(job, tmp_path / "a.npz")
    away = replace(job, folder=str(tmp_path / "none"))
    with pytest.raises(CannotKeep, match="none"):
        do(SurveyTask(away, str(tmp_path / "a.npz")))
    job.survey_path(found.key).rename(job.survey_path("other"))
    job.part_path("other", 0).mkdir()
    with pytest.raises(CannotKeep, match=r"other-000000\.parquet"):
        do(BlockTask(job, str(tmp_path / "a.npz"), "other", found.stamp, 0))
    tasks._at_hand.close()


def test_elsewhere_the_same_is_done_where_program_and_folder_are_the_same(tmp_path: Path) -> None:
    write(recording(1), tmp_path / "a.npz")
    job = replace(job_of(tmp_path), program=tasks.program_digest())
    assert do_elsewhere(SurveyTask(job, str(tmp_path / "a.npz"))) == do(SurveyTask(job, str(tmp_path / "a.npz")))
    tasks._at_hand.close()
