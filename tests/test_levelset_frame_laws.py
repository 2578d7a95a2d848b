"""What a frame's contacts share: pieces of one array, what the kernel is handed, what the sensor lost."""

from __future__ import annotations

import ctypes
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.frame import frame_noise
from varishold.levelset import Contact, find_contacts, find_contacts_batch
from varishold.levelset.columns import N_COLUMNS, N_PLACES
from varishold.levelset.contact import with_losses
from varishold.levelset.contacts import in_each

few = settings(max_examples=40)
seeds = st.integers(0, 2**32 - 1)


def frame_of(seed: int, rows: int, cols: int, specks: int) -> np.ndarray:
    """Single taxels of different heights, none beside another: so many contacts at most."""
    rng = np.random.default_rng(seed)
    frame = np.zeros((rows, cols))
    places = np.argwhere((np.indices(frame.shape) % 2 == 0).all(axis=0))
    for row, col in rng.permutation(places)[:specks]:
        frame[row, col] = rng.uniform(0.5, 2.0)
    return frame


@few
@given(seeds, st.integers(1, 9), st.integers(1, 9), st.integers(1, 6), st.integers(1, 9), st.booleans())
def test_what_is_found_stands_in_one_piece_without_gaps(
    seed: int, rows: int, cols: int, specks: int, levels: int, pitched: bool
) -> None:
    pitch = (0.003, 0.002) if pitched else None
    contacts = find_contacts(frame_of(seed, rows, cols, specks), levels, floor=0.1, pitch=pitch)
    frame = contacts[0].frame
    n, room = frame.n_contacts, max(frame.n_contacts, 2)
    assert frame.values.shape == (n, 2)
    assert frame.measures.shape == (n, N_COLUMNS * levels)
    assert frame.counts.shape == (n, 2, levels)
    assert frame.places.shape == (n, N_PLACES)
    assert frame.room == room
    assert frame.found.size == room * (2 + N_COLUMNS * levels + 2 * levels + N_PLACES)
    starts = [piece.__array_interface__["data"][0] for piece in (frame.values, frame.measures, frame.counts)]
    starts.append(frame.places.__array_interface__["data"][0])
    sizes = [8 * room * k for k in (2, N_COLUMNS * levels, 2 * levels)]
    np.testing.assert_array_equal(np.diff(starts), sizes)
    size, start = (rows + 2) * (cols + 2), frame.padded.__array_interface__["data"][0]
    assert frame.padded.shape == frame.label.shape == (rows + 2, cols + 2)
    assert frame.label.__array_interface__["data"][0] == start + 8 * size
    assert frame.dead.__array_interface__["data"][0] == start + 12 * size
    assert frame.dead.shape == frame.field.shape == (rows, cols)
    of_taxels = -(-(12 * size + rows * cols) // 8)
    assert frame.taxels.size == of_taxels + (frame.found.size if n <= 2 else 2 * frame.found.size // n)
    if n <= 2:
        assert starts[0] == start + 8 * of_taxels


@few
@given(seeds, st.integers(1, 8), st.integers(1, 8), st.integers(1, 6), st.integers(1, 7), st.booleans())
def test_the_kernel_is_handed_what_the_contact_says(
    seed: int, rows: int, cols: int, specks: int, levels: int, chosen: bool
) -> None:
    frame = frame_of(seed, rows, cols, specks)
    options = {} if chosen else {"floor": 0.1, "pitch": (0.5, 0.25)}
    for contact in find_contacts(frame, levels, **options):
        profile, (row, col) = contact.profile, contact.peak_taxel
        *at, height, width, index, n_levels, row_pitch, col_pitch, peak, floor, sigma = struct.unpack(
            "@5P4i5d", contact.packed
        )
        assert (height, width, index, n_levels) == (rows + 2, cols + 2, contact.index, levels)
        assert (row_pitch, col_pitch) == contact.spacing
        assert (peak, floor, sigma) == (contact.peak, contact.floor, contact.sigma)

        def read(k: int, kind: type, n: int, at: list[int] = at) -> np.ndarray:
            return np.array((kind * n).from_address(at[k]))

        size = height * width
        padded = read(0, ctypes.c_double, size).reshape(height, width)
        np.testing.assert_array_equal(padded, np.pad(frame, 1, mode="edge"))
        label = read(1, ctypes.c_int32, size).reshape(height, width)
        np.testing.assert_array_equal(label[1:-1, 1:-1][contact.window] == index, contact.mask)
        assert label[row + 1, col + 1] == index
        (top, bottom), (left, right) = ((part.start + 1, part.stop) for part in contact.window)
        bits = sum(1 << k for k, reached in enumerate(contact.borders) if reached)
        place = [row + 1, col + 1, top, bottom, left, right, contact.n_taxels, bits, profile.measured.sum()]
        assert read(2, ctypes.c_int64, N_PLACES).tolist() == place
        np.testing.assert_array_equal(read(3, ctypes.c_double, N_COLUMNS * levels), profile.measures)
        np.testing.assert_array_equal(read(4, ctypes.c_int64, 2 * levels).reshape(2, levels), profile.counts)


@few
@given(seeds, st.integers(3, 9), st.integers(3, 9))
def test_a_frame_keeps_its_taxels_a_rim_around_them_and_whose_they_are(seed: int, rows: int, cols: int) -> None:
    rng = np.random.default_rng(seed)
    values = frame_of(seed, rows, cols, 4)
    field = rng.random(values.shape) < 0.8
    field[np.unravel_index(values.argmax(), values.shape)] = True
    contacts = find_contacts(np.where(field, values, np.nan), 3, floor=0.1)
    frame = contacts[0].frame
    np.testing.assert_array_equal(frame.field, field)
    np.testing.assert_array_equal(frame.padded[1:-1, 1:-1], np.where(field, values, -np.inf))
    np.testing.assert_array_equal(frame.label[1:-1, 1:-1] >= 0, field & (values > 0.1))
    assert not frame.dead.any()
    for contact in contacts:
        np.testing.assert_array_equal(contact.field, field)
        held = contact.values
        np.testing.assert_array_equal(held, np.where(field, values, 0.0)[contact.window])
        assert held.flags.c_contiguous
        held[:] = -1.0
        np.testing.assert_array_equal(frame.padded[1:-1, 1:-1] < 0, ~field)
        assert contact.mask.sum() == contact.n_taxels
        row, col = contact.peak_taxel
        assert values[row, col] == contact.peak
        assert contact.peak_position == (col - (cols - 1) / 2, row - (rows - 1) / 2)
        # The border of the field, which may lie inside.
        own, around = np.pad(frame.label[1:-1, 1:-1] == contact.index, 1), np.pad(field, 1)
        beside = [np.roll(around, step, axis) for axis, step in ((1, 1), (1, -1), (0, 1), (0, -1))]
        assert contact.borders == tuple((own & ~there).any() for there in beside)
        assert f"peak={contact.peak:.4g} at ({row}, {col})" in repr(contact)
        assert f"n_taxels={contact.n_taxels}, levels=3" in repr(contact)


def test_a_contact_at_every_border_says_so() -> None:
    (contact,) = find_contacts(np.ones((4, 5)), 2, floor=0.5)
    assert contact.borders == (True, True, True, True)
    for flip, side in ((np.s_[:, 1:], 0), (np.s_[:, :-1], 1), (np.s_[1:], 2), (np.s_[:-1], 3)):
        frame = np.zeros((4, 5))
        frame[flip] = 1.0
        (contact,) = find_contacts(frame, 2, floor=0.5)
        assert contact.borders == tuple(k != side for k in range(4))


def test_noise_that_was_not_asked_for_is_that_of_the_taxels_alone() -> None:
    rng = np.random.default_rng(1)
    frame = rng.normal(0.0, 0.1, (9, 11))
    frame[3:6, 4:7] += 3.0
    field = rng.random(frame.shape) < 0.8
    field[4, 5] = True
    contact = find_contacts(np.where(field, frame, np.nan), 3, floor=1.0)[0]
    assert np.isnan(contact.frame.sigma)
    assert contact.sigma == frame_noise(np.where(field, frame, 0.0), field)
    whole = find_contacts(frame, 3, floor=1.0)[0]
    assert whole.sigma == frame_noise(frame)
    told = find_contacts(frame, 3, sigma=0.25)[0]
    assert told.sigma == told.frame.sigma == frame_noise(frame)
    # Four times the noise, but no less than 2 % of the peak.
    assert told.floor == pytest.approx(1.0)


# What the sensor lost


def dome() -> np.ndarray:
    y, x = np.mgrid[-9:10, -11:12]
    return np.maximum(1 - np.hypot(x, y) / 7, 0.0)


def test_a_contact_counts_what_is_lost_of_its_own_taxels() -> None:
    two = np.hstack([dome(), 0.5 * dome()])
    contacts = find_contacts(two, 3, floor=0.05)
    assert [c.state.repaired for c in contacts] == [c.state.saturated for c in contacts] == [0, 0]
    assert [c.state.beneath for c in contacts] == [0.0, 0.0]
    everywhere = np.ones(two.shape, np.bool_)
    broken = np.zeros(two.shape, np.bool_)
    broken[9, 10:13] = broken[0, 0] = True
    told = with_losses(contacts, repaired=broken, saturated=everywhere, beneath=0.25)
    assert [c.index for c in told] == [c.index for c in contacts]
    assert [c.state.repaired for c in told] == [3, 0]
    assert [c.state.saturated for c in told] == [c.n_taxels for c in contacts]
    assert [(c.state.beneath, c.state.cut) for c in told] == [(0.25, c.borders) for c in contacts]
    # What was known before stays known, and the first contacts know no more than they did.
    more = with_losses(told, saturated=None)
    assert [(c.state.repaired, c.state.saturated, c.state.beneath) for c in more] == [(3, 0, 0.25), (0, 0, 0.25)]
    assert contacts[0].state.repaired == 0
    assert with_losses([], beneath=1.0) == []


def test_dead_taxels_and_those_told_broken_are_both_repaired() -> None:
    frame = dome()
    frame[8, 10] = 0.0
    valid = np.ones(frame.shape, np.bool_)
    valid[10, 12] = valid[8, 10] = False
    (dead,) = find_contacts(frame, 3)
    assert np.argwhere(dead.frame.dead).tolist() == [[8, 10]]
    assert dead.state.repaired == 1
    (told,) = find_contacts(frame, 3, valid=valid)
    assert told.state.repaired == 2
    (both,) = with_losses([dead], repaired=~valid)
    assert both.state.repaired == 2
    assert both.state.saturated == 0


# Frames of every make


@few
@given(seeds, st.sampled_from(["<f4", ">f8", "<i2", "u1", "bool", "longdouble"]), st.sampled_from("CFSR"))
def test_frames_of_any_type_and_order_are_those_of_doubles(seed: int, dtype: str, order: str) -> None:
    rng = np.random.default_rng(seed)
    given_frames = (10 * rng.random((4, 6, 7))).astype(dtype)
    if order == "F":
        given_frames = np.asfortranarray(given_frames)
    elif order == "S":
        given_frames = np.repeat(given_frames, 2, axis=2)[:, :, ::2]
    elif order == "R":
        given_frames.flags.writeable = False
    plain = np.ascontiguousarray(given_frames, np.float64)
    batch, wanted = (find_contacts_batch(frames, 4, floor=0.5) for frames in (given_frames, plain))
    np.testing.assert_array_equal(batch.rows.measures, wanted.rows.measures)
    np.testing.assert_array_equal(batch.n_found, wanted.n_found)
    for frame, contacts in zip(given_frames, wanted, strict=True):
        for one, other in zip(find_contacts(frame, 4, floor=0.5), contacts, strict=True):
            np.testing.assert_array_equal(one.profile.measures, other.profile.measures)
    assert len(find_contacts_batch(plain.tolist(), 4, floor=0.5).peak) == len(wanted.peak)


@pytest.mark.parametrize("also", [False, True])
def test_what_a_masked_array_masks_is_broken(also: bool) -> None:
    frames = np.random.default_rng(0).random((3, 6, 7))
    masked = np.zeros((6, 7), np.bool_)
    masked[2, 3] = masked[4, 0] = True
    valid = np.ones((6, 7), np.bool_)
    valid[1, 1] = not also
    options = {"valid": valid} if also else {}
    given_frames = np.ma.MaskedArray(frames, np.broadcast_to(masked, frames.shape))
    batch = find_contacts_batch(given_frames, 4, floor=0.1, **options)
    wanted = find_contacts_batch(frames, 4, floor=0.1, valid=valid & ~masked)
    np.testing.assert_array_equal(batch.rows.measures, wanted.rows.measures)
    for frame, contacts in zip(given_frames, wanted, strict=True):
        for one, other in zip(find_contacts(frame, 4, floor=0.1, **options), contacts, strict=True):
            np.testing.assert_array_equal(one.profile.measures, other.profile.measures)
            assert one.state == other.state


def test_frames_one_by_one_are_named_where_one_cannot_be_taken() -> None:
    frames = np.ones((4, 3, 3))
    assert [len(found) for found in in_each(frames, lambda frame: find_contacts(frame, 2))] == [1, 1, 1, 1]
    frames[2, 1, 0] = np.inf

    def find(frame: np.ndarray) -> list[Contact]:
        return find_contacts(frame, 2)

    with pytest.raises(InputError, match=r"^frame 2: .*\(1, 0\)"):
        in_each(frames, find)
