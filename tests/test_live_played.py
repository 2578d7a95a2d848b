"""Files that are played: what goes round, odd shapes, a grid that is given to taxels in a row."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import varishold
from varishold.live import PadLayout, Sample, samples_of, source_at
from varishold.live.pad_watcher import grid_of
from varishold.live.sample_file import sample_file
from varishold.recording import Pad, Recording


@pytest.mark.parametrize("measured", [False, True])
def test_what_goes_round_goes_on_as_if_it_had_no_end(tmp_path: Path, measured: bool) -> None:
    frames, path = np.arange(40.0).reshape(10, 2, 2), tmp_path / ("a.mcap" if measured else "a.npz")
    if measured:
        with sample_file(path, dict) as file:
            for k, frame in enumerate(frames):
                file.add(Sample(5 + k / 50, 1e9 + k / 50, k, {"pad": frame}))
    else:
        varishold.write(Recording({"pad": Pad(frames)}, time_s=5 + np.arange(10) / 50), path)
    coming = samples_of(source_at(f"replay:{path}?speed=0&loop=1"))
    some = [next(coming) for _ in range(700)]
    coming.close()
    device_s = [one.device_time_s for one in some]
    assert device_s[0] == pytest.approx(5.0)
    assert np.diff(np.array(device_s, float)) == pytest.approx(0.02, abs=1e-6)
    assert np.diff([one.host_time_s for one in some]) == pytest.approx(0.02, abs=1e-5)
    assert [float(one.pads["pad"][1, 1]) for one in some] == [4.0 * (k % 10) + 3 for k in range(700)]


def test_a_file_of_one_frame_goes_round_at_its_rate(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.ones((1, 2, 2)))
    coming = samples_of(source_at(f"replay:{tmp_path}/a.npy?speed=0&loop=1&rate_hz=20"))
    some = [next(coming) for _ in range(5)]
    coming.close()
    assert np.diff([one.host_time_s for one in some]) == pytest.approx(0.05, abs=1e-5)
    assert [one.sequence for one in some] == list(range(5))


def test_values_of_more_dimensions_are_signals_unless_they_are_called_pressure(tmp_path: Path) -> None:
    one = Sample(None, 1e9, 0, {"field": np.ones((2, 2, 3))})
    with sample_file(tmp_path / "a.mcap", dict) as file:
        file.add(one)
        assert (file.tally.samples, file.tally.refused) == (1, 0)
    (played,) = samples_of(source_at(f"replay:{tmp_path}/a.mcap?speed=0"))
    assert played.pads["field"].size == 12
    with sample_file(tmp_path / "b.mcap", lambda: {"field": PadLayout((2, 2, 3))}) as file:
        file.add(one)
        assert (file.tally.samples, file.tally.refused) == (0, 1)
        assert "which is no frame" in file.tally.why


@pytest.mark.parametrize("shape", [(2, 3), (6,), (1, 6), (3, 2)])
def test_gaps_and_broken_taxels_are_written_and_played_in_every_shape(tmp_path: Path, shape: tuple[int, ...]) -> None:
    # A place beyond the frame is nobody's.
    layout = PadLayout(shape, gaps=(1, 5, 6, 99), broken=(0, 4, 6))
    with sample_file(tmp_path / "a.mcap", lambda: {"pad": layout}) as file:
        file.add(Sample(None, 1e9, 0, {"pad": np.arange(6.0).reshape(shape)}))
    source = source_at(f"replay:{tmp_path}/a.mcap?speed=0")
    (played,) = samples_of(source)
    pad = source.pads["pad"]
    assert (pad.gaps, pad.broken) == ((1, 5), (0, 4))
    assert played.pads["pad"].ravel().tolist() == list(range(6))
    assert grid_of(pad.shape) == grid_of(shape)


def test_taxels_in_a_row_are_given_their_grid_when_they_are_played(tmp_path: Path) -> None:
    with sample_file(tmp_path / "a.mcap", dict) as file:
        file.add(Sample(None, 1e9, 0, {"pad": np.arange(6.0), "other": np.arange(4.0)}))
    source = source_at(f"replay:{tmp_path}/a.mcap?speed=0&shape=2x3")
    (played,) = samples_of(source)
    assert played.pads["pad"].tolist() == [[0, 1, 2], [3, 4, 5]]
    assert played.pads["other"].size == 4
    assert source.pads["pad"].shape == (2, 3)
