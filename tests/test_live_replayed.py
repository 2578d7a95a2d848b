"""Recordings that are played: what was recorded comes, when it was measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import varishold
from varishold.errors import InputError
from varishold.live import Stream, samples_of, source_at
from varishold.recording import Pad, Recording


@pytest.fixture
def file(tmp_path: Path) -> Path:
    rng = np.random.default_rng(0)
    left = Pad(rng.integers(0, 4000, (30, 4, 5)).astype(np.uint16), pitch_m=2e-3)
    right = Pad(rng.normal(50, 1, (30, 3, 3)), pitch_m=(1e-3, 2e-3))
    time_s = 100 + np.cumsum(rng.uniform(0.005, 0.015, 30))
    varishold.write(Recording({"left": left, "right": right}, time_s=time_s, unit="kPa"), tmp_path / "two.npz")
    return tmp_path / "two.npz"


def test_what_was_recorded_comes(file: Path) -> None:
    recording = varishold.read(file)
    source = source_at(f"replay:{file}?speed=0")
    samples = list(samples_of(source))
    assert [sample.sequence for sample in samples] == list(range(30))
    assert [sample.device_time_s for sample in samples] == pytest.approx(recording.time_s)
    for name, pad in recording.pads.items():
        assert np.array_equal([sample.pads[name] for sample in samples], pad.frames)
        assert samples[0].pads[name].dtype == pad.frames.dtype
        layout = source.pads[name]
        assert (layout.shape, layout.pitch_m, layout.unit) == (pad.shape, pad.pitch_m, "kPa")
    steps = np.diff([sample.host_time_s for sample in samples])
    assert steps == pytest.approx(np.diff(recording.time_s), abs=1e-5)


def test_it_takes_the_time_that_it_took(file: Path) -> None:
    with Stream(source_at(f"replay:{file}?speed=2")) as stream:
        samples = list(stream.reader())
    time_s = varishold.read(file).time_s
    assert time_s is not None
    assert len(samples) == 30
    assert samples[-1].host_time_s - samples[0].host_time_s >= 0.95 * (time_s[-1] - time_s[0]) / 2 - 0.02


def test_it_can_go_round(file: Path) -> None:
    source = source_at(f"replay:{file}?speed=0&loop=1")
    coming = samples_of(source)
    samples = [next(coming) for _ in range(95)]
    coming.close()
    assert [sample.sequence for sample in samples] == list(range(95))
    assert np.diff([sample.device_time_s for sample in samples]).min() > 0
    assert np.array_equal(samples[5].pads["left"], samples[65].pads["left"])


def test_a_file_without_times_has_a_rate(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.arange(40, dtype=np.uint8).reshape(10, 4))
    source = source_at(f"replay:{tmp_path}/a.npy?speed=0&shape=2x2&rate_hz=50&pitch_m=0.004&polarity=down")
    samples = list(samples_of(source))
    assert [sample.device_time_s for sample in samples] == [None] * 10
    assert np.diff([sample.host_time_s for sample in samples]) == pytest.approx(0.02, abs=1e-5)
    assert (source.pads["pad"].pitch_m, source.pads["pad"].polarity) == ((0.004, 0.004), "down")


@pytest.mark.parametrize("times", [[0.0, 5.0, 1.0], [3.0, 3.0, 3.0], [1e9, -1e9, 0.0]])
def test_times_that_go_back_hold_nothing_up(tmp_path: Path, times: list[float]) -> None:
    pad = Pad(np.ones((3, 2, 2)))
    varishold.write(Recording({"pad": pad}, time_s=np.array(times)), tmp_path / "a.npz")
    samples = list(samples_of(source_at(f"replay:{tmp_path}/a.npz?speed=1000000")))
    assert [sample.device_time_s for sample in samples] == times


def test_a_recording_that_is_a_folder_is_played(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).integers(0, 9, (7, 3, 4)).astype(np.float32)
    varishold.write(Recording({"pad": Pad(frames)}, time_s=np.arange(7) / 50), tmp_path / "a.lerobot")
    samples = list(samples_of(source_at(f"replay:{tmp_path}/a.lerobot?speed=0")))
    assert np.array_equal([sample.pads["pad"] for sample in samples], frames)
    assert [sample.device_time_s for sample in samples] == pytest.approx(np.arange(7) / 50)
    # A folder that is none says so.
    with pytest.raises(InputError, match="is a folder; name a file in it"):
        list(samples_of(source_at(f"replay:{tmp_path}?speed=0")))


def test_what_cannot_be_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.npz").write_bytes(b"PK nothing")
    for text, words in (
        (f"replay:{tmp_path}/none.npz", "there is no file"),
        ("replay:", "there is no file ''"),
        (f"replay:{tmp_path}/a.npz?speed=-1", "speed must be a number from 0"),
        (f"replay:{tmp_path}/a.npz?loop=2", "loop must be a number from 0 to 1"),
        (f"replay:{tmp_path}/a.npz?polarity=left", "polarity must be up or down, got 'left'"),
        (f"replay:{tmp_path}/a.npz?start=3", "replay has no option 'start'"),
    ):
        with pytest.raises(InputError, match=words):
            source_at(text)
    with Stream(source_at(f"replay:{tmp_path}/a.npz")) as stream, pytest.raises(InputError, match=r"a\.npz"):
        list(stream.reader())


def test_where_a_recording_has_no_taxel_or_a_broken_one_nothing_is_felt(tmp_path: Path) -> None:
    from varishold.live import Watcher

    rng = np.random.default_rng(0)
    y, x = np.mgrid[:12, :12]
    frames = rng.normal(0, 1, (90, 12, 12))
    frames[60:] += 100 * np.maximum(1 - np.hypot(x - 4, y - 4) / 4, 0)
    field, valid = np.ones((12, 12), bool), np.ones((12, 12), bool)
    field[:, 9:] = False
    valid[4, 4] = False
    frames[:, ~field] = frames[:, ~valid] = np.nan
    varishold.write(
        Recording({"pad": Pad(frames, field=field, valid=valid)}, time_s=np.arange(90) / 100), tmp_path / "a.npz"
    )
    source = source_at(f"replay:{tmp_path / 'a.npz'}?speed=0")
    source.open()
    layout = source.pads["pad"]
    assert layout.broken == (52,)
    assert layout.gaps == tuple(np.flatnonzero(~field).tolist())
    with Watcher(source.pads) as watcher:
        seen = [watcher.see(sample).pads["pad"] for sample in samples_of(source)]
    told = [event.kind for pad in seen for event in pad.events]
    assert told == ["touched"]
    (track,) = seen[-1].tracks
    assert np.isfinite(track.position).all()
    assert np.hypot(track.position[0] + 1.5, track.position[1] + 1.5) < 0.5
