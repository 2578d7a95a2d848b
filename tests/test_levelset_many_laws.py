"""Many frames and whole recordings: whatever the room, the block and the number of pads, as contact by contact."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_levelset_batch import assert_same, frames_of

from varishold.errors import InputError
from varishold.frame.checks import MOST_LEVELS
from varishold.levelset import find_contacts, find_contacts_batch, kernel, measure
from varishold.levelset import table as table_module
from varishold.levelset.kernel import Rows

few = settings(max_examples=30, deadline=None)
seeds = st.integers(0, 2**32 - 1)


# Batches


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> int:
    """So few frames a call that every batch takes several calls, and room for few contacts to begin with."""
    monkeypatch.setattr(kernel, "_FRAMES_A_CALL", 3)
    return 3


@pytest.mark.parametrize("n", [0, 1, 2, 3, 4, 6, 7, 20])
@pytest.mark.parametrize("own", [False, True])
def test_any_number_of_frames_and_contacts_is_that_of_each(narrow: int, n: int, own: bool) -> None:
    rng = np.random.default_rng(n)
    frames = np.zeros((n, 6, 7))
    board = np.indices((6, 7)).sum(axis=0) % 2
    for i, frame in enumerate(frames):
        # None, few and very many contacts, the many ones late.
        frame += (0.0, board * 0.9, rng.random((6, 7)), 0.3)[(i * i + i // 3) % 4]
    levels: Any = rng.uniform(0.2, 0.9, (n, 4)) if own else 4
    batch = find_contacts_batch(frames, levels, floor=0.1)
    assert_same(batch, frames, levels, floor=0.1)
    assert batch.n_found.shape == batch.sigma.shape == (n,)
    for array in (batch.rows.places, batch.rows.values, batch.rows.measures, batch.rows.counts):
        assert len(array) == batch.n_found.sum()
    assert batch.measures.shape == (batch.n_found.sum(), 25 * 4)
    assert batch.counts.shape == (batch.n_found.sum(), 2, 4)


@pytest.mark.parametrize("wrong", [0, 2, 3, 5, 8])
def test_a_frame_that_cannot_be_taken_is_named_whichever_call_it_is_in(narrow: int, wrong: int) -> None:
    frames = np.random.default_rng(0).random((9, 4, 5))
    frames[wrong, 2, 1] = -np.inf
    frames[-1, 0, 0] = -np.inf
    with pytest.raises(InputError, match=rf"^frame {wrong}: .*got -inf at \(row, col\) = "):
        find_contacts_batch(frames, 3)
    with pytest.raises(InputError, match=rf"^frame {wrong}: "):
        find_contacts_batch(frames, np.ones((9, 2)))


def test_thresholds_in_any_order_cut_alike() -> None:
    frames = frames_of(5, 4, 9, 8)
    levels = [0.2, 0.7, 0.4, 0.5]
    wanted = find_contacts_batch(frames, sorted(levels, reverse=True), floor=0.1)
    for given_levels in (levels, sorted(levels), np.array(levels)):
        np.testing.assert_array_equal(find_contacts_batch(frames, given_levels, floor=0.1).measures, wanted.measures)
        for frame, contacts in zip(frames, wanted, strict=True):
            for one, other in zip(find_contacts(frame, given_levels, floor=0.1), contacts, strict=True):
                np.testing.assert_array_equal(one.profile.measures, other.profile.measures)
    # Not changed where they stand.
    given_levels = np.array(levels)
    find_contacts(frames[0], given_levels, floor=0.1)
    find_contacts_batch(frames, np.tile(given_levels, (4, 1)), floor=0.1)
    assert given_levels.tolist() == levels


@pytest.mark.parametrize(
    ("levels", "fine"),
    [
        (np.ones((2, 1)), True),
        (np.ones((2, 3), np.int16), True),
        (np.ones((2, 3), np.uint8), True),
        (np.ones((2, 3), np.float32), True),
        (np.ones((2, MOST_LEVELS)), True),
        (np.ones((2, MOST_LEVELS + 1)), False),
        (np.ones((2, 0)), False),
        (np.ones((1, 3)), False),
        (np.ones((3, 3)), False),
        (np.ones((2, 3), np.bool_), False),
        (np.full((2, 3), "1"), False),
    ],
)
def test_each_frames_own_thresholds_are_numbers_in_one_row_a_frame(levels: np.ndarray, fine: bool) -> None:
    frames = np.zeros((2, 2, 2))
    if fine:
        assert find_contacts_batch(frames, levels).threshold.shape == (0, levels.shape[1])
        return
    got = f"got {levels.dtype} of shape {levels.shape}"
    with pytest.raises(InputError) as caught:
        find_contacts_batch(frames, levels)
    assert str(caught.value).startswith("each frame's own levels must be thresholds of shape (2, n_levels), at most ")
    assert str(caught.value).endswith(got)


def test_room_that_grows_keeps_what_is_in_it() -> None:
    rows = Rows.empty(3, 2)
    for k, array in enumerate(rows):
        array[:] = k
    grown = kernel._grown(rows, 2, 5)
    assert [len(array) for array in grown] == [5, 5, 5, 5]
    assert [array.shape[1:] for array in grown] == [array.shape[1:] for array in rows]
    assert [array.dtype for array in grown] == [array.dtype for array in rows]
    for k, array in enumerate(grown.first(2)):
        assert len(array) == 2
        assert (array == k).all()


# Tables

UNITS = {"area": 2, "perimeter": 1, "equivalent_diameter": 1, "centroid_x": 1, "centroid_y": 1}
UNITS |= {f"second_moment_{of}": 2 for of in ("xx", "xy", "yy")}
UNITS |= dict.fromkeys(("principal_axis_major", "principal_axis_minor", "feret_width_most", "feret_width_least"), 1)
PLAIN = ["frame", "time_s", "pad", "contact", "peak", "threshold", "n_taxels", "parts", "holes", "euler_number"]


def recording_of(rng: np.random.Generator, numbers: dict[str, int], pitch: Any) -> SimpleNamespace:
    pads = {}
    for name, n in numbers.items():
        shape = tuple(rng.integers(4, 9, 2))
        frames = frames_of(int(rng.integers(1 << 30)), n, *shape).reshape(n, *shape)
        field = rng.random(shape) < 0.9
        valid = rng.random(shape) < 0.95
        valid[0, 0] = field[0, 0] = True
        pads[name] = SimpleNamespace(frames=frames, field=field, valid=valid, pitch_m=pitch.get(name))
    return SimpleNamespace(pads=pads, time_s=None)


def rows_of(recording: SimpleNamespace, known: bool, levels: int, floor: float) -> list[dict[str, Any]]:
    """Contact by contact, the plain way."""
    found = []
    for i in range(max(len(pad.frames) for pad in recording.pads.values())):
        for name, pad in recording.pads.items():
            if i >= len(pad.frames):
                continue
            options = {"field": pad.field, "valid": pad.valid, "pitch": pad.pitch_m if known else None}
            for number, contact in enumerate(find_contacts(pad.frames[i], levels, floor=floor, **options)):
                p, at = contact.profile, int(contact.profile.measured.sum()) - 1
                small, large = np.linalg.eigvalsh(p.covariance[at])
                values = {
                    "area": p.area[at],
                    "perimeter": p.perimeter[at],
                    "equivalent_diameter": np.sqrt(p.area[at] / np.pi) * 2,
                    "centroid_x": p.centroid[at, 0],
                    "centroid_y": p.centroid[at, 1],
                    "second_moment_xx": p.covariance[at, 0, 0],
                    "second_moment_xy": p.covariance[at, 0, 1],
                    "second_moment_yy": p.covariance[at, 1, 1],
                    "principal_axis_major": 4 * np.sqrt(max(large, 0.0)),
                    "principal_axis_minor": 4 * np.sqrt(max(small, 0.0)),
                    "feret_width_most": max(p.extent[at]),
                    "feret_width_least": min(p.extent[at]),
                }
                row = {
                    "frame": i,
                    "time_s": np.nan if recording.time_s is None else recording.time_s[i],
                    "pad": name,
                    "contact": number,
                    "peak": contact.peak,
                    "threshold": p.threshold[at],
                    "n_taxels": contact.n_taxels,
                    "parts": p.parts[at],
                    "holes": p.holes[at],
                    "euler_number": p.parts[at] - p.holes[at],
                }
                for key, value in values.items():
                    row[key + (("_m", "_m2")[UNITS[key] - 1] if known else "_taxels")] = value
                found.append(row)
    return found


@few
@given(seeds, st.integers(1, 4), st.booleans(), st.booleans())
def test_a_table_says_what_each_contact_says_in_order(seed: int, block: int, known: bool, timed: bool) -> None:
    rng = np.random.default_rng(seed)
    numbers = {"thumb": int(rng.integers(0, 6)), "a palm": int(rng.integers(1, 6)), "b": 2}
    pitch = {"thumb": (0.002, 0.001), "a palm": (0.003, 0.003), "b": (0.001, 0.004) if known else None}
    recording = recording_of(rng, numbers, pitch)
    if timed:
        recording.time_s = np.cumsum(rng.random(max(numbers.values()))).tolist()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(table_module, "_FRAMES_A_BLOCK", block)
        table = measure(recording, levels=5, floor=0.15)
    wanted = rows_of(recording, known, 5, 0.15)
    if wanted:
        assert set(table) == {*wanted[0], "orientation_rad"}
    assert list(table)[: len(PLAIN)] == PLAIN
    assert {len(column) for column in table.values()} == {len(wanted)}
    for name in wanted[0] if wanted else ():
        column = [row[name] for row in wanted]
        if name == "pad":
            assert table[name].tolist() == column
        else:
            np.testing.assert_allclose(table[name], column, rtol=1e-6, atol=1e-9, err_msg=name)
    unit = "_m2" if known else "_taxels"
    xx, xy, yy = (table[f"second_moment_{of}{unit}"] for of in ("xx", "xy", "yy"))
    along, across = table["orientation_rad"], table["orientation_rad"] + np.pi / 2
    turned = [xx * np.cos(t) ** 2 + 2 * xy * np.cos(t) * np.sin(t) + yy * np.sin(t) ** 2 for t in (along, across)]
    assert (turned[0] >= turned[1] - 1e-9).all()
    assert ((along >= -np.pi / 2) & (along < np.pi / 2)).all()


def test_a_table_is_of_thirty_two_levels_and_the_chosen_floor() -> None:
    frames = frames_of(2, 3, 12, 12)
    pad = SimpleNamespace(frames=frames, field=None, valid=None, pitch_m=None)
    table = measure(SimpleNamespace(pads={"pad": pad}, time_s=None))
    wanted = [contact.profile.threshold[-1] for contacts in find_contacts_batch(frames) for contact in contacts]
    assert len(wanted) > 2
    np.testing.assert_array_equal(table["threshold"], wanted)


def test_a_frame_that_cannot_be_measured_is_named_by_its_place_in_the_recording(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(table_module, "_FRAMES_A_BLOCK", 2)
    frames = np.ones((5, 3, 3))
    frames[3, 1, 2] = np.inf
    pad = SimpleNamespace(frames=frames, field=None, valid=None, pitch_m=None)
    with pytest.raises(InputError, match=r"^frame 3: .*\(row, col\) = \(1, 2\)"):
        measure(SimpleNamespace(pads={"pad": pad}, time_s=None))


def test_what_a_masked_recording_masks_is_broken() -> None:
    frames = frames_of(4, 3, 8, 8)
    masked = np.zeros((8, 8), np.bool_)
    masked[3, 3] = True
    tables = []
    for held, valid in ((np.ma.MaskedArray(frames, np.broadcast_to(masked, frames.shape)), None), (frames, ~masked)):
        pad = SimpleNamespace(frames=held, field=None, valid=valid, pitch_m=None)
        tables.append(measure(SimpleNamespace(pads={"pad": pad}, time_s=None), floor=0.1))
    for name in tables[0]:
        np.testing.assert_array_equal(tables[0][name], tables[1][name])


def test_a_written_table_is_the_table_and_only_texts_are_quoted(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    names = ["=a", "+b", "-c", "@d", "e=", "", " =f", "'g"]
    recording = recording_of(rng, dict.fromkeys(names, 2), {})
    recording.time_s = np.array([-0.25, 0.5])
    table = measure(recording, floor=0.1)
    table.write_csv(tmp_path / "table.csv")
    text = (tmp_path / "table.csv").read_text(encoding="utf-8")
    assert "\r" not in text
    assert text.endswith("\n")
    rows = list(csv.DictReader(text.splitlines()))
    assert len(rows) == len(table["pad"]) > 8
    for name, column in table.items():
        if name == "pad":
            wanted = [f"'{pad}" if pad and pad[0] in "=+-@" else pad for pad in column]
            assert [row[name] for row in rows] == wanted
        else:
            assert [float(row[name]) for row in rows] == column.tolist()


def test_a_data_frame_is_made_of_the_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=lambda columns: ("a frame", columns)))
    table = measure(recording_of(np.random.default_rng(0), {"pad": 2}, {}), floor=0.1)
    told, columns = table.to_pandas()
    assert told == "a frame"
    assert type(columns) is dict
    assert list(columns) == list(table)
