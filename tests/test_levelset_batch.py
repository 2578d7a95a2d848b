"""Many frames at once: the arrays say what each frame's contacts say, whatever the room and however many threads."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.levelset import ContactBatch, find_contacts, find_contacts_batch
from varishold.levelset.kernel import _FRAMES_A_CALL

ARRAYS = ("threshold", "area", "perimeter", "centroid", "covariance", "extent", "parts", "holes")


def frames_of(seed: int, n: int, rows: int, cols: int) -> np.ndarray:
    """Bumps on noise, none to several contacts a frame."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:rows, :cols]
    frames = rng.normal(0, 0.02, (n, rows, cols))
    for frame in frames:
        for _ in range(rng.integers(0, 4)):
            r, c = rng.uniform(0, rows), rng.uniform(0, cols)
            frame += rng.uniform(0.3, 1) * np.exp(-((y - r) ** 2 + (x - c) ** 2) / rng.uniform(1, 8))
    return frames


def assert_same(batch: ContactBatch, frames: np.ndarray, levels: int | np.ndarray, **options: object) -> None:
    row = 0
    for i, frame in enumerate(frames):
        contacts = find_contacts(frame, levels[i] if np.ndim(levels) == 2 else levels, **options)
        assert batch.n_found[i] == len(contacts) == len(batch[i])
        for number, contact in enumerate(contacts):
            for name in ARRAYS:
                np.testing.assert_array_equal(getattr(batch, name)[row], getattr(contact.profile, name), err_msg=name)
            assert (batch.frame[row], batch.number[row]) == (i, number)
            assert (batch.peak[row], batch.floor[row]) == (contact.peak, contact.floor)
            assert batch.n_taxels[row] == contact.n_taxels
            assert tuple(batch.borders[row].tolist()) == contact.borders
            assert tuple(batch.peak_taxel[row].tolist()) == contact.peak_taxel
            rows, cols = contact.window
            assert batch.box[row].tolist() == [rows.start, rows.stop - 1, cols.start, cols.stop - 1]
            assert batch.n_measured[row] == contact.profile.measured.sum()
            row += 1
        if contacts and not np.isnan(contacts[0].frame.sigma):
            assert batch.sigma[i] == contacts[0].sigma
    assert len(batch.peak) == row


@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(1, 9), st.sampled_from([None, 0.1]), st.booleans())
@settings(max_examples=40)
def test_the_arrays_are_those_of_each_frame(
    seed: int, rows: int, cols: int, floor: float | None, with_gaps: bool
) -> None:
    frames = frames_of(seed, 5, rows, cols)
    options = {"floor": floor, "pitch": (0.002, 0.001)}
    if with_gaps:
        rng = np.random.default_rng(seed)
        options |= {"field": rng.random((rows, cols)) < 0.8, "valid": rng.random((rows, cols)) < 0.95}
        options["valid"][0, 0] = options["field"][0, 0] = True
    own = np.random.default_rng(seed).uniform(0, 1, (5, 4))
    levels = (6, np.linspace(0.05, 0.9, 7), own)[seed % 3]
    assert_same(find_contacts_batch(frames, levels, **options), frames, levels, **options)


def test_room_grows_with_what_is_found() -> None:
    # A checkerboard has a contact on every other taxel: far more than is reckoned with.
    calm, board = np.zeros((_FRAMES_A_CALL + 3, 6, 6)), np.indices((6, 6)).sum(axis=0) % 2
    calm[[5, -1, -2]] = board
    batch = find_contacts_batch(np.concatenate([calm, np.tile(board, (200, 1, 1))]), 4, floor=0.1)
    assert batch.n_found.sum() == 203 * batch.n_found[5]
    assert np.flatnonzero(batch.n_found)[:3].tolist() == [5, len(calm) - 2, len(calm) - 1]
    np.testing.assert_array_equal(batch.area, np.tile(batch.area[: batch.n_found[5]], (203, 1)))


def test_each_frame_may_have_its_own_thresholds_in_any_order() -> None:
    frames = frames_of(3, _FRAMES_A_CALL + 5, 8, 8)
    levels = np.random.default_rng(3).uniform(0.05, 0.9, (len(frames), 3))
    batch = find_contacts_batch(frames, levels, floor=0.05)
    assert_same(batch, frames, levels, floor=0.05)
    np.testing.assert_array_equal(batch.threshold, -np.sort(-levels, axis=1)[batch.frame])
    np.testing.assert_array_equal(find_contacts_batch(frames, -np.sort(-levels), floor=0.05).area, batch.area)
    assert find_contacts_batch(frames[:2], [[1, 2], [3, 4]]).threshold.shape[1] == 2


@pytest.mark.parametrize("levels", [np.ones((4, 2)), np.ones((5, 0)), np.ones((5, 2), complex), np.ones((5, 1 << 17))])
def test_own_thresholds_are_one_row_a_frame(levels: np.ndarray) -> None:
    with pytest.raises(InputError, match=r"each frame's own levels must be thresholds of shape \(5, n_levels\)"):
        find_contacts_batch(np.ones((5, 3, 3)), levels)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_own_thresholds_are_finite(wrong: float) -> None:
    with pytest.raises(InputError, match="levels must be finite"):
        find_contacts_batch(np.ones((2, 3, 3)), [[0.5, 0.2], [0.5, wrong]])


def test_threads_do_not_disturb_each_other() -> None:
    many = [frames_of(seed, 60, 12 + seed, 10) for seed in range(6)]
    with ThreadPoolExecutor(4) as pool:
        at_once = list(pool.map(find_contacts_batch, many))
    for frames, batch in zip(many, at_once, strict=True):
        alone = find_contacts_batch(frames)
        np.testing.assert_array_equal(batch.rows.measures, alone.rows.measures)
        np.testing.assert_array_equal(batch.n_found, alone.n_found)


def test_a_slice_is_those_frames() -> None:
    batch = find_contacts_batch(frames_of(1, 6, 9, 9))
    assert [len(contacts) for contacts in batch[1:4]] == batch.n_found[1:4].tolist()
    assert len(batch[-1]) == batch.n_found[-1]
    with pytest.raises(IndexError):
        batch[6]


def test_no_frames_are_no_contacts() -> None:
    batch = find_contacts_batch(np.empty((0, 4, 5)), 3)
    assert len(batch) == 0
    assert batch.area.shape == (0, 3)
    assert batch.covariance.shape == (0, 3, 2, 2)
    assert batch.frame.shape == batch.number.shape == (0,)


def test_a_frame_that_cannot_be_measured_is_named() -> None:
    frames = np.ones((_FRAMES_A_CALL + 9, 3, 3))
    frames[_FRAMES_A_CALL + 4, 1, 2] = np.inf
    with pytest.raises(InputError, match=rf"^frame {_FRAMES_A_CALL + 4}: .*\(1, 2\)"):
        find_contacts_batch(frames)
    with pytest.raises(InputError, match=r"^frame 0: every taxel"):
        find_contacts_batch(frames[:2], valid=np.zeros((3, 3), np.bool_))
