"""Files that are played: what goes round, odd shapes, a grid that is given to taxels in a row."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.live_clock import Clock

import varishold
from varishold.errors import EndOfSourceError, InputError, LostSourceError
from varishold.live import PadLayout, Sample, pace, samples_of, source_at
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


def _file(folder: Path, times: list[float], *, measured: bool, device: bool = True) -> Path:
    """Write frames that tell their number, measured at these times."""
    frames = [np.full((2, 3), k, np.uint8) for k in range(len(times))]
    if not measured:
        path = folder / "a.npz"
        varishold.write(Recording({"pad": Pad(np.array(frames))}, time_s=np.array(times) if device else None), path)
        return path
    path = folder / "a.mcap"
    with sample_file(path, dict) as file:
        for k, (time_s, frame) in enumerate(zip(times, frames, strict=True)):
            file.add(Sample(50 + time_s if device else None, 1e9 + time_s, 3 * k, {"pad": frame}))
    return path


@given(
    st.lists(st.integers(-20, 100), max_size=12),
    st.booleans(),
    st.booleans(),
    st.sampled_from([0.5, 1.0, 4.0]),
)
@settings(max_examples=40)
def test_each_reading_comes_when_its_time_has_come_and_one_whose_time_goes_back_at_once(
    tmp_path_factory: pytest.TempPathFactory, steps: list[int], measured: bool, device: bool, speed: float
) -> None:
    times = (np.cumsum([0, *steps]) / 64).tolist()
    path = _file(tmp_path_factory.mktemp("played"), times, measured=measured, device=device)
    with pytest.MonkeyPatch.context() as patch:
        clock = Clock(patch, pace)
        source = source_at(f"replay:{path}?speed={speed}&rate_hz=32")
        began_s, samples = clock.time(), list(samples_of(source))
    timed = measured or device
    due = np.maximum.accumulate(times) if timed else np.arange(len(times)) / 32
    assert [int(one.pads["pad"][0, 0]) for one in samples] == list(range(len(times)))
    assert [one.host_time_s - began_s for one in samples] == pytest.approx(due / speed, abs=1e-3)
    ahead = 50 if measured else 0
    told = [None] * len(times) if not device else pytest.approx([ahead + time_s for time_s in times])
    assert [one.device_time_s for one in samples] == told
    assert [one.sequence for one in samples] == [3 * k if measured else k for k in range(len(times))]


@pytest.mark.parametrize(("measured", "turn_s"), [(True, 2.0), (False, 2.25)])
def test_from_the_last_to_the_first_it_takes_as_long_as_between_others(
    tmp_path: Path, measured: bool, turn_s: float
) -> None:
    """As the last step took, or the usual one."""
    path = _file(tmp_path, [0.0, 1.0, 1.5], measured=measured)
    source = source_at(f"replay:{path}?speed=0&loop=1")
    coming = samples_of(source)
    some = [next(coming) for _ in range(9)]
    coming.close()
    expected = [turn * turn_s + time_s for turn in range(3) for time_s in (0.0, 1.0, 1.5)]
    assert [one.host_time_s - some[0].host_time_s for one in some] == pytest.approx(expected, abs=1e-5)
    assert [(one.device_time_s or 0) - (some[0].device_time_s or 0) for one in some] == pytest.approx(expected)
    # Opened anew it begins with its first again.
    coming = samples_of(source)
    first = next(coming)
    coming.close()
    assert (first.device_time_s, int(first.pads["pad"][0, 0])) == (some[0].device_time_s, 0)


@pytest.mark.parametrize("measured", [True, False])
def test_the_end_of_a_file_is_told_and_what_is_closed_is_not_read(tmp_path: Path, measured: bool) -> None:
    path = _file(tmp_path, [0.0, 0.5], measured=measured)
    source = source_at(f"replay:{path}?speed=0")
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)
    assert dict(source.pads) == {}
    source.open()
    assert len(source.read(0.0)) == 2
    what = "2 readings" if measured else "2 frames"
    with pytest.raises(EndOfSourceError, match=f"^replay:{path}\\?speed=0: {what}, all of the file$"):
        source.read(0.0)
    source.close()
    source.close()
    if measured:
        with pytest.raises(LostSourceError, match="is not open"):
            source.read(0.0)
        # A file whose writer was killed says so at its end.
        with sample_file(tmp_path / "b.mcap", dict) as file:
            for k in range(2):
                file.add(Sample(None, 1e9, k, {"pad": np.ones((2, 3))}))
        content = (tmp_path / "b.mcap").read_bytes()
        path.write_bytes(content[: content.rfind(b"\x0f" + (4).to_bytes(8, "little"))])
        source.open()
        source.read(0.0)
        with pytest.raises(EndOfSourceError, match=r"2 readings, all of the file; the file has no end, "):
            source.read(0.0)
        source.close()


@pytest.mark.parametrize("measured", [True, False])
def test_what_an_address_says_of_a_file_goes_before_what_the_file_says(tmp_path: Path, measured: bool) -> None:
    layout = PadLayout((2, 3), pitch_m=(0.001, 0.002), unit="kPa", polarity="down")
    frame, path = np.arange(6.0).reshape(2, 3), tmp_path / ("a.mcap" if measured else "a.npz")
    if measured:
        with sample_file(path, lambda: {"pad": layout}) as file:
            file.add(Sample(None, 1e9, 0, {"pad": frame}))
    else:
        # What this format cannot say has to be said with the address.
        varishold.write(Recording({"pad": Pad(frame[None], pitch_m=layout.pitch_m)}, unit="kPa"), path)
    way = "" if measured else "&polarity=down"
    for options, told in (
        (way, layout),
        (f"{way}&pitch_m=0.005", replace(layout, pitch_m=(0.005, 0.005))),
        ("&polarity=down", layout),
        ("&polarity=up", layout if measured else replace(layout, polarity="up")),
    ):
        source = source_at(f"replay:{path}?speed=0{options}")
        (one,) = samples_of(source)
        assert source.pads["pad"] == told
        assert one.pads["pad"].tolist() == frame.tolist()
    with sample_file(tmp_path / "up.mcap", dict) as file:
        file.add(Sample(None, 1e9, 0, {"pad": frame}))
    source = source_at(f"replay:{tmp_path}/up.mcap?speed=0&polarity=down")
    list(samples_of(source))
    assert source.pads["pad"].polarity == "down"


def test_only_so_many_taxels_in_a_row_are_given_a_grid(tmp_path: Path) -> None:
    with sample_file(tmp_path / "a.mcap", dict) as file:
        pads = {"row": np.arange(6.0), "one row": np.arange(6.0)[None], "column": np.arange(6.0)[:, None]}
        file.add(Sample(None, 1e9, 0, {**pads, "grid": np.arange(6.0).reshape(3, 2), "more": np.arange(7.0)}))
    source = source_at(f"replay:{tmp_path}/a.mcap?speed=0&shape=2x3")
    (one,) = samples_of(source)
    assert {name: layout.shape for name, layout in source.pads.items()} == {
        name: values.shape for name, values in one.pads.items()
    }
    assert [one.pads[name].shape for name in ("row", "one row", "column", "grid")] == [(2, 3), (2, 3), (6, 1), (3, 2)]
    assert one.pads["more"].size == 7
    with pytest.raises(InputError, match="polarity must be up or down, got 'left'"):
        source_at(f"replay:{tmp_path}/a.mcap?polarity=left")
