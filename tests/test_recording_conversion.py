"""From one format to another and back: the same recording, or what was lost is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from varishold.cli.app import app
from varishold.errors import InputError
from varishold.recording import Pad, Recording, conversion, read, write
from varishold.recording.conversion import convert, losses

pytest.importorskip("mcap")
ROOT = Path(__file__).parents[1]
KINDS = (np.uint8, np.int16, np.uint16, np.int32, np.int64, np.float32, np.float64)


def said(*words: object, status: int = 0) -> str:
    done = CliRunner().invoke(app, list(map(str, words)), catch_exceptions=status != 0)
    assert done.exit_code == status, done.output
    return done.stdout if status == 0 else str(done.exception)


def whole() -> Recording:
    """A recording of which every part says something."""
    rng = np.random.default_rng(3)
    field, valid = np.ones((4, 5), bool), np.ones((4, 5), bool)
    field[0, 0] = valid[2, 2] = False
    return Recording(
        {
            "left": Pad(
                rng.integers(0, 99, (6, 4, 5)).astype(np.uint16), field=field, valid=valid, pitch_m=(0.002, 0.001)
            ),
            "right": Pad(rng.random((6, 3, 3)).astype(np.float32)),
        },
        time_s=np.array([0.1, 0.2, 0.35, 0.4, 0.5, 0.7]),
        unit="kPa",
        sensor="mat",
        press=np.array([-1, 0, 0, -1, 1, 1]),
        press_columns={"thing": np.array(["a", "bé"]), "angle_rad.one": np.array([0.5, np.nan])},
    )


def alone(frames: np.ndarray) -> Recording:
    return Recording({"pad": Pad(frames)})


def test_a_recording_goes_through_what_holds_all_of_it(tmp_path: Path) -> None:
    write(whole(), tmp_path / "a.npz")
    here = tmp_path / "a.npz"
    for name in ("b.mcap", "c.npz", "d.mcap"):
        assert convert(read(here), tmp_path / name) == ()
        here = tmp_path / name
        assert losses(whole(), read(here)) == losses(read(here), whole()) == ()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
@given(
    st.sampled_from(KINDS).flatmap(
        lambda kind: arrays.arrays(
            kind,
            st.tuples(st.integers(2, 5), st.integers(2, 6), st.integers(2, 6).filter(lambda n: n != 3)),
            elements=(
                st.integers(0, 120)
                if np.issubdtype(kind, np.integer)
                else st.floats(0, 1000, width=32 if kind == np.float32 else 64)
            ),
        )
    ),
    st.sampled_from([".npy", ".csv", ".npz", ".mcap"]),
)
def test_frames_alone_go_through_every_format_or_their_type_is_told(
    tmp_path: Path, frames: np.ndarray, ending: str
) -> None:
    lost = convert(alone(frames), tmp_path / f"b{ending}", lossy=True)
    back = read(tmp_path / f"b{ending}").pads["pad"].frames
    assert np.array_equal(back, frames)
    assert lost == (() if back.dtype == frames.dtype else (f"type {frames.dtype} of the values",))
    assert ending == ".csv" or not lost


@pytest.mark.parametrize("shape", [(16, 16), (4, 7), (1, 8), (8, 1), (1, 1)])
def test_one_frame_goes_through_csv_but_for_its_shape(tmp_path: Path, shape: tuple[int, int]) -> None:
    one, target = alone(np.random.default_rng(1).random((1, *shape))), tmp_path / "b.csv"
    with pytest.raises(
        InputError, match=r"b\.csv: would lose the shape of its one frame \(say \d+x\d+ when it is read"
    ):
        convert(one, target)
    assert list(tmp_path.iterdir()) == []
    assert len(convert(one, target, lossy=True)) == 1
    assert np.array_equal(read(target, shape=shape).pads["pad"].frames, one.pads["pad"].frames)


def test_what_cannot_be_read_again_is_told_of_the_file_that_was_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def damaged(path: Path, **_: object) -> Recording:
        raise InputError(f"{path}: holds nothing", parameter="shape")

    monkeypatch.setattr(conversion, "read", damaged)
    with pytest.raises(InputError) as caught:
        convert(alone(np.ones((2, 4, 4))), tmp_path / "b.csv", lossy=True)
    assert str(caught.value) == f"{tmp_path / 'b.csv'}: could not be read again: holds nothing"
    assert caught.value.parameter is None
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", [".npy", ".csv"])
def test_what_a_format_does_not_hold_is_refused_and_nothing_is_written(tmp_path: Path, ending: str) -> None:
    told = whole()
    one = Recording({"left": told.pads["left"]}, told.time_s, told.unit, told.sensor)
    target = tmp_path / f"b{ending}"
    with pytest.raises(
        InputError, match=r"would lose the pad's name left, .*pitch, field mask, .*time, unit, sensor; "
    ):
        convert(one, target)
    assert list(tmp_path.iterdir()) == []
    lost = convert(one, target, lossy=True)
    assert {"pitch", "field mask", "mask of broken taxels", "time", "unit", "sensor"} <= set(lost)
    assert np.array_equal(next(iter(read(target).pads.values())).frames, told.pads["left"].frames)
    with pytest.raises(InputError, match=r"holds one pad, the recording has 2 \(left, right\)"):
        convert(told, target, lossy=True)
    assert list(tmp_path.iterdir()) == [target]


def test_a_polarity_that_npz_does_not_hold_is_told(tmp_path: Path) -> None:
    down = Recording({"pad": Pad(np.full((2, 3, 4), -5), polarity="down")})
    with pytest.raises(InputError):
        convert(down, tmp_path / "b.npz")
    assert convert(down, tmp_path / "b.mcap") == ()
    assert list(tmp_path.iterdir()) == [tmp_path / "b.mcap"]


def test_the_command_says_that_it_is_the_same_or_what_was_lost(tmp_path: Path) -> None:
    example, there = ROOT / "examples" / "surfaces.npz", tmp_path / "b.mcap"
    assert said("convert", example, there) == f"{there}: 99 frames, read back and compared: the same\n"
    assert "would lose pitch, mask of broken taxels, time, unit, sensor; that must be asked for (--lossy)" in said(
        "convert", there, tmp_path / "c.npy", status=1
    )
    lines = said("convert", there, tmp_path / "c.npy", "--lossy").splitlines()
    assert lines[0] == "lost: pitch"
    assert lines[-1].endswith("c.npy: 99 frames, read back and compared: the rest is the same")
    assert "must end in .npz, .mcap, .lerobot, .mat, .h5, .hdf5, .parquet, .npy or .csv" in said(
        "convert", example, tmp_path / "c.what", status=1
    )


def test_an_output_is_never_an_input(tmp_path: Path) -> None:
    write(alone(np.ones((3, 4, 4), np.uint8)), tmp_path / "a.npz")
    before = (tmp_path / "a.npz").read_bytes()
    assert "a.npz" in said("convert", tmp_path / "a.npz", tmp_path / "a.npz", status=1)
    (tmp_path / "b.npz").write_bytes(b"somebody's")
    assert "b.npz" in said("convert", tmp_path / "a.npz", tmp_path / "b.npz", status=1)
    assert (tmp_path / "a.npz").read_bytes() == before
    assert (tmp_path / "b.npz").read_bytes() == b"somebody's"


@pytest.mark.parametrize("ending", ["npz", "mcap", "h5", "mat", "parquet"])
def test_what_was_converted_before_is_replaced_unasked(tmp_path: Path, ending: str) -> None:
    write(Recording({"pad": Pad(np.arange(60).reshape(5, 3, 4))}), tmp_path / "a.npz")
    (tmp_path / "b.npz").write_bytes((tmp_path / "a.npz").read_bytes())
    for _ in range(2):
        assert "the same" in said("convert", tmp_path / "b.npz", tmp_path / f"c.{ending}")


def test_what_cannot_be_written_is_told_by_the_name_that_was_given(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).normal(0, 1, (4, 3, 5))
    write(Recording({"left": Pad(frames), "right": Pad(frames)}), tmp_path / "a.npz")
    with pytest.raises(InputError) as told:
        convert(read(tmp_path / "a.npz"), tmp_path / "b.npy", lossy=True)
    assert str(told.value).startswith(f"{tmp_path / 'b.npy'}: holds one pad")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz"]
