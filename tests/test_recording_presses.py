"""Presses of a recording: named by it, or found by their load."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold import Pad, Recording, read, write
from varishold.errors import FormatError, InputError
from varishold.recording import Signals, select_frames
from varishold.recording.blocks import Blocks

FRAMES = np.arange(7 * 6, dtype=np.uint8).reshape(7, 2, 3)
PRESS = np.array([-1, 1, 1, -1, 0, 0, 2])


def named() -> Recording:
    columns = {"label": np.array(["cup", "can", "cup"]), "angle_rad.thumb": np.array([0.1, 0.2, 0.3])}
    return Recording({"pad": Pad(FRAMES)}, press=PRESS, press_columns=columns)


def test_named_presses_are_a_table_in_the_order_of_their_numbers() -> None:
    table = named().presses
    assert table.frames == table.spans == (range(4, 6), range(1, 3), range(6, 7))
    assert len(table) == 3
    assert table.columns["label"].tolist() == ["cup", "can", "cup"]


def test_frames_are_chosen_by_the_presses_that_are_named() -> None:
    assert select_frames(named(), "press") == [range(4, 6), range(1, 3), range(6, 7)]
    force = np.tile(np.array([0, 0, 5, 9, 5, 0, 0, 0, 7, 8, 0])[:, None, None], (1, 4, 4))
    whole = Recording({"pad": Pad(force)}, press=np.zeros(11, int))
    assert select_frames(whole, "press") == [range(11)]
    none = Recording({"pad": Pad(force)}, press=np.full(11, -1))
    with pytest.raises(InputError, match="no press found"):
        select_frames(none, "press")


def test_without_names_they_are_runs_of_loaded_frames() -> None:
    force = np.array([0, 0, 5, 9, 5, 0, 0, 0, 7, 8, 0])
    table = Recording({"pad": Pad(np.tile(force[:, None, None], (1, 4, 4)))}).presses
    assert (table.frames, dict(table.columns)) == ((range(2, 5), range(8, 10)), {})
    assert table.spans == (range(5), range(5, 10))


def test_the_rest_of_a_run_is_eight_frames_before_it() -> None:
    force = np.zeros(40)
    force[12:15], force[30:33], force[36:38] = 7, 9, 9
    table = Recording({"pad": Pad(np.tile(force[:, None, None], (1, 4, 4)))}).presses
    assert table.frames == (range(12, 15), range(30, 33), range(36, 38))
    assert table.spans == (range(4, 15), range(22, 33), range(33, 38))


def test_they_are_written_and_read_and_cut_with_the_frames(tmp_path: Path) -> None:
    write(named(), tmp_path / "r.npz")
    again = read(tmp_path / "r.npz")
    assert again.notes == ()
    assert again.press is not None
    np.testing.assert_array_equal(again.press, PRESS)
    assert {name: of.tolist() for name, of in again.press_columns.items()} == {
        "label": ["cup", "can", "cup"],
        "angle_rad.thumb": [0.1, 0.2, 0.3],
    }
    block = Blocks(again).frames[3:6]
    assert block.presses.frames == (range(1, 3),)
    assert block.presses.columns["label"].tolist() == ["cup"]


@pytest.mark.parametrize(
    ("press", "columns", "message"),
    [
        (np.zeros(3, int), {}, r"press must be one whole number a frame, shape \(7,\), got int64 of shape \(3,\)"),
        (np.zeros(7), {}, r"press must be one whole number a frame, shape \(7,\), got float64"),
        (np.array([0, 0, 1, 1, 0, 0, 0]), {}, "press 0 must be in one piece: it ends and begins again"),
        (PRESS, {"label": np.array(["a"])}, r"press.label must be one text or number a press, 3 of them, got <U1"),
        (None, {"label": np.array(["a"])}, r"columns of presses \(label\) need press"),
    ],
)
def test_what_does_not_fit_is_told(press: np.ndarray | None, columns: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Recording({"pad": Pad(FRAMES)}, press=press, press_columns=columns)


def test_a_file_that_does_not_fit_is_told_by_its_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "r.npz", pressure=FRAMES, press=np.zeros(2, int))
    with pytest.raises(FormatError, match=r"r.npz: press must be one whole number a frame"):
        read(tmp_path / "r.npz")


def test_grasps_of_a_gripper_bring_labels_and_angles(tmp_path: Path) -> None:
    given = {
        "frames": np.ones((5, 2, 3, 2), "u2"),
        "texel_mask": np.ones((2, 3, 2), bool),
        "time_ms": np.arange(5),
        "start": np.array([0, 3, 5]),
        "label": np.array(["ball", "cube"]),
        "joint_angles_deg": np.array([[90.0, 0.0], [180.0, 45.0]]),
    }
    np.savez(tmp_path / "weiss.npz", **given)
    table = read(tmp_path / "weiss.npz").presses
    assert table.frames == (range(3), range(3, 5))
    assert table.columns["label"].tolist() == table.columns["object"].tolist() == ["ball", "cube"]
    np.testing.assert_allclose(table.columns["angle_rad.joint_0"], [np.pi / 2, np.pi])
    np.savez(tmp_path / "bad.npz", **(given | {"joint_angles_deg": np.zeros(3)}))
    with pytest.raises(FormatError, match=r"joint_angles_deg must be numbers of shape \(2 grasps, n_joints\)"):
        read(tmp_path / "bad.npz")
    np.savez(tmp_path / "back.npz", **(given | {"start": np.array([3, 0])}))
    with pytest.raises(FormatError, match="start must be the first frame of each grasp, rising"):
        read(tmp_path / "back.npz")


@pytest.mark.parametrize("marks", [((3, "late"),), ((1, "a"), (0, "b")), ((-1, "a"),), ((0.5, "a"),)])
def test_marks_are_at_frames_and_rise(marks: tuple[tuple[int, str], ...]) -> None:
    with pytest.raises(InputError, match="marks must be at frames 0 to 2, rising"):
        Recording({"pad": Pad(np.ones((3, 2, 2)))}, marks=marks)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("signals", "told"),
    [
        ({"pad": Signals(np.ones((3, 2)))}, "signals must have a name of their own"),
        ({"x": Signals(np.ones((2, 2)))}, "got 2 rows of 'x' beside 3 frames"),
    ],
)
def test_signals_stand_beside_the_frames(signals: dict[str, Signals], told: str) -> None:
    with pytest.raises(InputError, match=told):
        Recording({"pad": Pad(np.ones((3, 2, 2)))}, signals=signals)


def test_signals_have_a_name_each_or_none() -> None:
    with pytest.raises(InputError, match="got 1 name of 2"):
        Signals(np.ones((3, 2)), ("x",))
    with pytest.raises(InputError, match="signals must be numbers"):
        Signals(np.array([["a"]]))


def forces(*shares: float) -> np.ndarray:
    """Presses so strong, each up, held and down again, between pauses."""
    course = np.concatenate([np.linspace(0.1, 1, 6), np.ones(8), np.linspace(1, 0.1, 6)])
    return np.concatenate([np.zeros(20), *(np.concatenate([share * course, np.zeros(20)]) for share in shares)])


def pressed(total: np.ndarray, common: np.ndarray | float = 0.0, seed: int = 0) -> Recording:
    """A disc that presses a quarter of a pad so strongly, and what all taxels do alike."""
    y, x = np.mgrid[-8:8, -8:8] + 0.5
    frames = 100 * total[:, None, None] * (np.hypot(x, y) < 4.5) + np.broadcast_to(common, total.shape)[:, None, None]
    return Recording({"pad": Pad(frames + np.random.default_rng(seed).normal(0, 1.0, frames.shape))})


def mid_frames(n: int) -> list[int]:
    return [20 + 40 * k + 10 for k in range(n)]


@pytest.mark.parametrize("share", [0.05, 0.15])
def test_presses_stay_apart_where_something_of_the_last_one_stays(share: float) -> None:
    total = forces(1.0, 0.8, 1.0, 0.6)
    stays = np.zeros_like(total)
    for k in range(1, len(total)):
        stays[k] = stays[k - 1] + (0.3 if total[k] > stays[k - 1] else 0.01) * (total[k] - stays[k - 1])
    found = pressed(np.maximum(total, share * stays)).presses.frames
    assert len(found) == 4
    assert all(middle in run for run, middle in zip(found, mid_frames(4), strict=True))


@pytest.mark.parametrize("drift", [0.02, -0.02, 0.04, -0.04, 0.1, -0.1])
def test_presses_stay_apart_where_the_rest_drifts(drift: float) -> None:
    total = forces(1.0, 0.8, 1.0, 0.6)
    found = pressed(total, 20 + drift * np.arange(len(total))).presses.frames
    assert len(found) == 4
    assert all(middle in run for run, middle in zip(found, mid_frames(4), strict=True))
    if abs(drift) < 0.1:
        assert found[0].start > 15
        assert found[-1].stop < len(total) - 15


def test_hum_of_the_whole_pad_is_no_press() -> None:
    total = forces(1.0, 0.5)
    hum = 4 * np.sin(2.9 * np.arange(len(total)))
    found = pressed(total, hum).presses.frames
    assert len(found) == 2
    assert all(middle in run for run, middle in zip(found, mid_frames(2), strict=True))


@pytest.mark.parametrize("pause", [1, 2, 4])
@pytest.mark.parametrize("held", [1, 2, 24])
@pytest.mark.parametrize("ramp", [1, 2, 4, 20])
def test_presses_that_come_without_a_pause_are_found(ramp: int, held: int, pause: int) -> None:
    up = np.linspace(0, 1, ramp + 2)[1:-1] ** 2
    hold = 1 + 0.03 * np.sin(2.0 * np.arange(held))
    course = np.concatenate([up, hold, up[::-1], np.zeros(pause)])
    found = pressed(np.concatenate([np.zeros(1), np.tile(course, 9)])).presses.frames
    assert len(found) == 9
    assert all(1 + ramp + held // 2 + len(course) * k in run for k, run in enumerate(found))


@pytest.mark.parametrize("ramp", [3, 4, 5, 8])
def test_presses_without_a_pause_are_parted_at_one_frame_and_a_glitch_parts_none(ramp: int) -> None:
    up = np.sin(np.arange(1, ramp + 1) / (ramp + 1) * np.pi / 2) ** 2
    course = np.concatenate([up, np.ones(8), up[::-1]])
    strong = np.array([0.4, 1.0, 0.6, 0.3, 0.9, 0.9, 0.35, 0.8])
    total = np.concatenate([np.zeros(10), *(share * course for share in strong), np.zeros(10)])
    found = pressed(total).presses.frames
    assert len(found) == len(strong)
    assert all(10 + ramp + 4 + len(course) * k in run for k, run in enumerate(found))
    total[[10 + ramp + 3, 10 + ramp + 4 + 3 * len(course)]] *= 0.15
    assert len(pressed(total).presses.frames) == len(strong)


def test_a_press_that_wavers_is_one() -> None:
    total = forces(1.0)
    total[30], total[36:38] = 0.5, (0.2, 0.3)
    assert len(pressed(total).presses.frames) == 1


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(9, 80), st.sampled_from([0.0, 5.0, 30.0]))
def test_presses_follow_one_another_and_hold_the_strongest_frame(seed: int, n: int, rest: float) -> None:
    rng = np.random.default_rng(seed)
    total = np.maximum(5 * rng.normal(0, 1, n).cumsum(), 0)
    recording = pressed(total, rest, seed)
    found = recording.presses.frames
    assert all(run.start < run.stop for run in found)
    assert all(one.stop <= other.start for one, other in itertools.pairwise(found))
    if found:
        strongest = int(np.argmax(recording.totals()))
        assert any(strongest in run for run in found)


@pytest.mark.parametrize("forgets", [6, 20, 60])
@pytest.mark.parametrize("offset", [0.0, 50.0])
def test_presses_are_found_by_a_sensor_that_adapts_to_them(forgets: int, offset: float) -> None:
    y, x = np.mgrid[-8:8, -8:8] + 0.5
    cone = np.maximum(6.0 - np.hypot(x, y), 0.0)
    course = np.r_[np.zeros(20), np.linspace(2, 20, 6), np.full(25, 20.0), np.linspace(16, 0, 5), np.zeros(70)]
    force = np.tile(course, 3)
    adapted, rest = np.zeros_like(force), 0.0
    for k, each in enumerate(force):
        adapted[k] = each - rest
        rest += adapted[k] / forgets
    frames = offset + adapted[:, None, None] * cone + np.random.default_rng(0).normal(0, 0.3, (len(force), 16, 16))
    found = Recording({"pad": Pad(frames)}).presses.frames
    n = len(course)
    assert [run.start // n for run in found] == [0, 1, 2]
    assert all(18 <= run.start - k * n <= 24 and run.stop - k * n < 60 for k, run in enumerate(found))


def test_entries_of_no_press_and_numbers_that_are_text_are_told(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).normal(0, 1, (4, 2, 2))

    def told(press: list[int] | None, **columns: list[object]) -> tuple[str, ...]:
        named = {f"press.{name.replace('__', '.')}": np.array(column) for name, column in columns.items()}
        given = {} if press is None else {"press": np.array(press)}
        np.savez(tmp_path / "a.npz", pressure=frames, **given, **named)
        return read(tmp_path / "a.npz").remarks

    assert told([0, 0, 1, 1], label=["a", "b", "c"], day=["m", "m"]) == (
        "press.label has 3 entries, and presses are numbered to 1: the others are passed over",
    )
    for head in ("angle_rad__a", "switch__b", "force_n__c"):
        assert told([0, 0, -1, 1], **{head: ["1", "x"]}) == (
            f"press.{head.replace('__', '.')} is text, and not learned from: write numbers, nan where one is not known",
        )
        assert told([0, 0, -1, 1], **{head: [1.0, np.nan]}) == ()
    # A number that no frame has leaves a hole among the entries, which is none beyond the last.
    assert told([0, 0, 2, 2], label=["a", "b", "c"], angle=["x", "y", "z"]) == ()
    assert told([-1, -1, -1, -1], label=["a"]) == (
        "press.label has 1 entry, and no frame is of a press: the others are passed over",
    )
    assert told(None) == ()
