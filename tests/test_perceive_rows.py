"""Evidence from the rows and recordings of any hand, and the example that feeds a perceiver with real grasps."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.perceive import Evidence, Library, Perceiver, evidence_of_recording, evidence_of_row, merge_evidence
from varishold.recording import GraspTable, Pad, Recording
from varishold.skin import Skin

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "weiss_perceiver.py"
_BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"
SKIN = Skin("layer", thickness_m=4e-3, poisson=0.45, sensing_depth_m=1e-3, youngs_modulus_pa=1.5e5)

number = st.floats(-1e6, 1e6) | st.just(float("nan"))


def table(**more):
    cells = {
        "object": np.array(["cone", "cube"]),
        "size_m": np.array([0.05, 0.06]),
        "seed": np.array([1.0, 2.0]),
        "held": np.array([True, True]),
        "switch.v1": np.array([True, False]),
        "angle_rad.thumb": np.array([0.5, np.nan]),
        "force_n.tip": np.array([2.0, 3.0]),
        "note": np.array(["", "slow"]),
        "temperature": np.array([20.0, 21.0]),
    }
    return GraspTable(cells | {name.replace("__", "."): np.array(column) for name, column in more.items()})


def blob(rows=13, cols=6, at=(6.0, 2.5), width=2.0, height=1000.0):
    y, x = np.mgrid[:rows, :cols]
    return height * np.exp(-((y - at[0]) ** 2 + (x - at[1]) ** 2) / (2 * width**2))


def touched(**pads):
    return Recording({name: Pad(np.asarray(frames, float), pitch_m=3.4e-3) for name, frames in pads.items()}, unit="Pa")


ramp = np.array([0.0, 0.5, 1.0, 0.7])[:, None, None]


def test_a_row_holds_what_was_felt_and_not_what_was_grasped():
    evidence = evidence_of_row(table(), 0)
    assert dict(evidence.values) == {"switch.v1": 1.0, "angle_rad.thumb": 0.5, "force_n.tip": 2.0, "temperature": 20.0}
    assert evidence.touch == "grasp"
    assert evidence.remarks == ()


def test_an_empty_cell_is_unknown_and_remarked():
    evidence = evidence_of_row(table(), 1, touch="squeeze")
    assert np.isnan(evidence.values["angle_rad.thumb"])
    assert evidence.remarks == ("squeeze: nothing is known of angle_rad.thumb",)


def test_many_empty_cells_are_counted():
    more = {f"angle_rad__j{k}": [np.nan, 0.0] for k in range(6)}
    assert evidence_of_row(table(**more), 0).remarks == (
        "grasp: nothing is known of angle_rad.j0, angle_rad.j1, angle_rad.j2, angle_rad.j3 and 2 more",
    )


def test_columns_can_be_chosen():
    evidence = evidence_of_row(table(), 1, columns=["switch.*", "force_n.*", "object"])
    assert dict(evidence.values) == {"switch.v1": 0.0, "force_n.tip": 3.0}


@given(st.lists(st.tuples(number, number), min_size=1, max_size=5))
def test_every_number_of_a_row_is_finite_or_unknown(rows):
    cells = {"angle_rad.a": np.array([a for a, _ in rows]), "force_n.b": np.array([b for _, b in rows])}
    for k, row in enumerate(rows):
        evidence = evidence_of_row(GraspTable(cells), k)
        assert tuple(evidence.values) == ("angle_rad.a", "force_n.b")
        np.testing.assert_array_equal(list(evidence.values.values()), row)
        assert bool(evidence.remarks) == bool(np.isnan(row).any())


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: evidence_of_row(table(), 2), "table: there is no row 2: rows are numbered 0 to 1"),
        (lambda: evidence_of_row(table(), True), "table: there is no row True: rows are numbered 0 to 1"),
        (lambda: evidence_of_row(GraspTable({}), 0), "table: there is no row 0: it has no rows"),
        (
            lambda: evidence_of_row(table(), 0, columns="pressure.*"),
            "table: no column matches 'pressure.*'; its columns are object, size_m, seed, held, switch.v1, "
            "angle_rad.thumb, force_n.tip, note, temperature",
        ),
        (
            lambda: evidence_of_row(table(), 0, columns=["object", "seed"]),
            "table: no column of numbers that was felt matches 'object' or 'seed'",
        ),
        (
            lambda: evidence_of_row(table(force_n__tip=[1.0, np.inf]), 1),
            "table: line 3, column 'force_n.tip' must be finite, got inf",
        ),
        (
            lambda: evidence_of_row(table(switch__v2=[0.5, 1.0]), 0),
            "table: line 2, column 'switch.v2' must be 0 or 1, got 0.5",
        ),
        (
            lambda: evidence_of_recording(touched(a=ramp * blob()), frame=4),
            "recording: there is no frame 4: frames are numbered 0 to 3",
        ),
        (
            lambda: evidence_of_recording(Recording({"a": Pad(ramp * blob())}), pitch_m=3.4),
            "pad a: pitch_m must lie in [0.0001, 0.05] metres, got 3.4; is it in millimetres?",
        ),
        (lambda: merge_evidence(), "there is no evidence to merge"),
        (
            lambda: merge_evidence(Evidence("grasp", {"a": 1}), Evidence("tip", {"b": 1})),
            "evidence of two touches cannot be merged: 'grasp' and 'tip'",
        ),
        (
            lambda: merge_evidence(Evidence("grasp", {"a": 1}), Evidence("grasp", {"a": 2})),
            "a of touch 'grasp' has two values, 1 and 2",
        ),
    ],
)
def test_bad_input_is_told_in_one_line(make, message):
    with pytest.raises(InputError) as error:
        make()
    assert str(error.value) == message


def test_each_pad_says_its_surface_and_an_unpressed_one_that_nothing_presses_it():
    evidence = evidence_of_recording(touched(thumb=ramp * blob(), finger=ramp * 0 * blob()), skin=SKIN)
    assert evidence.values["pad.thumb.on"] == 1.0
    assert {evidence.values[name] for name in evidence.values if name.startswith("pad.finger.")} == {0.0}
    assert all(np.isfinite(value) for value in evidence.values.values())
    assert evidence.remarks == ()
    assert evidence.reasons[0].startswith("pad thumb: ")
    assert evidence.reasons[1] == "pad finger: nothing presses it"


def test_the_strongest_frame_is_looked_at_unless_another_is_asked_for():
    recording = touched(thumb=ramp * blob())
    assert evidence_of_recording(recording) == evidence_of_recording(recording, frame=2)
    assert evidence_of_recording(recording, frame=0).values["pad.thumb.on"] == 0.0


def test_a_spike_of_one_frame_does_not_choose_the_frame_and_is_remarked():
    rng = np.random.default_rng(0)
    course = np.array([0.0] * 8 + [0.25, 0.5, 0.75] + [1.0] * 5 + [0.0] * 8)[:, None, None]
    frames = course * blob() + rng.normal(0.0, 1.0, (len(course), 13, 6))
    spiked = frames.copy()
    spiked[4] = 4000.0
    evidence, clean = evidence_of_recording(touched(left=spiked)), evidence_of_recording(touched(left=frames))
    assert dict(evidence.values) == dict(clean.values)
    assert evidence.reasons == clean.reasons
    assert [said for said in evidence.remarks if said not in clean.remarks] == [
        "grasp: pad left: frame 4: all taxels show one and the same value, the pad said nothing; taken as before it"
    ]


def test_the_unit_of_a_recording_changes_nothing():
    in_pa = touched(thumb=ramp * blob())
    in_kpa = Recording({"thumb": Pad(ramp * blob() / 1000, pitch_m=3.4e-3)}, unit="kPa")
    felt = [evidence_of_recording(one, skin=SKIN).values for one in (in_pa, in_kpa)]
    assert felt[0] == pytest.approx(felt[1], rel=1e-6, abs=1e-9)


def test_a_skin_needs_a_unit_of_pressure():
    raw = Recording({"thumb": Pad(ramp * blob(), pitch_m=3.4e-3)})
    evidence = evidence_of_recording(raw, skin={"thumb": SKIN})
    assert evidence.remarks == ("grasp: pad thumb: its skin is of no use: 'raw' is no unit of pressure",)
    assert evidence.values == evidence_of_recording(raw).values


def test_pads_that_cannot_tell_are_left_out_and_remarked():
    many = np.concatenate([ramp, ramp])
    recording = Recording(
        {
            "good": Pad(many * blob(), pitch_m=3.4e-3),
            "stuck": Pad(np.full((8, 13, 6), 4095), pitch_m=3.4e-3),
            "narrow": Pad(many * blob(2, 6), pitch_m=3.4e-3),
            "strange": Pad(many * blob()),
        }
    )
    evidence = evidence_of_recording(recording, pads=("good", "stuck", "narrow", "strange", "lost"))
    assert {name.split(".")[1] for name in evidence.values} == {"good"}
    assert evidence.remarks == (
        "grasp: pad stuck is left out: none of its taxels works: their values never change",
        "grasp: pad narrow is left out: its 2 x 6 taxels are too few to tell a surface",
        "grasp: pad strange is left out: its taxel spacing is unknown; give pitch_m",
        "grasp: pad lost is left out: the recording does not hold it",
    )


def test_broken_taxels_are_filled():
    frames = ramp * blob()
    valid = np.ones((13, 6), bool)
    valid[5, 2] = False
    frames[:, ~valid] = np.nan
    evidence = evidence_of_recording(Recording({"thumb": Pad(frames, valid=valid, pitch_m=3.4e-3)}))
    assert all(np.isfinite(value) for value in evidence.values.values())


def test_merging_joins_what_is_known():
    row = evidence_of_row(table(), 1)
    pads = evidence_of_recording(touched(thumb=ramp * blob()))
    both = merge_evidence(row, pads, Evidence("grasp", {"angle_rad.thumb": 0.25}))
    assert set(both.values) == set(row.values) | set(pads.values)
    assert both.values["angle_rad.thumb"] == 0.25
    assert both.remarks == row.remarks
    assert both.reasons == pads.reasons
    assert dict(merge_evidence(row).values) == pytest.approx(dict(row.values), nan_ok=True)


def test_rows_of_a_hand_teach_and_feed_a_perceiver():
    rng = np.random.default_rng(5)
    names = np.repeat(["ball", "box", "pen"], 14)
    level = {"ball": (1, 0.3, 2.0), "box": (0, 0.9, 5.0), "pen": (0, 1.4, 1.0)}
    felt = np.array([level[name] for name in names]) + rng.normal(0, [0, 0.03, 0.2], (len(names), 3))
    rows = GraspTable(
        {"object": names, "switch.v1": felt[:, 0] > 0.5, "angle_rad.a": felt[:, 1], "force_n.b": felt[:, 2]}
    )
    place = np.arange(len(names)) % 14
    evidence = [evidence_of_row(rows, k) for k in range(len(rows))]
    known = {name: [[evidence[k]] for k in np.flatnonzero((names == name) & (place < 10))] for name in ("ball", "box")}
    library = Library.from_examples(known).with_object(
        "pen", [[evidence[k]] for k in np.flatnonzero((names == "pen") & (place < 10))]
    )
    for k in np.flatnonzero(place >= 10):
        perceiver = Perceiver(library, refuse=False)
        assert next(iter(perceiver.feel(evidence[k]).probability)) == names[k]


def example():
    spec = importlib.util.spec_from_file_location("weiss_perceiver", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_example_says_in_one_line_what_to_set(tmp_path):
    done = subprocess.run(
        [sys.executable, str(EXAMPLE), str(tmp_path)], capture_output=True, text=True, check=False, timeout=100
    )
    assert done.returncode == 1
    assert done.stderr == (
        f"{tmp_path / 'weiss_dsa36.npz'}: no such file; give the folder that holds weiss_dsa36.npz, "
        "or set VARISHOLD_DATA to it\n"
    )


def test_rows_need_no_simulator():
    code = "import sys, varishold.perceive.rows, varishold.perceive.perceiver; print('mujoco' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=100)
    assert done.stdout == "False\n"


@pytest.mark.real_data
def test_real_grasps_of_eight_objects_feed_a_perceiver():
    folder = Path(os.environ.get("VARISHOLD_DATA", _BESIDE))
    if not (folder / "weiss_dsa36.npz").is_file():
        pytest.skip("weiss_dsa36.npz is not here; set VARISHOLD_DATA to the folder that holds the recordings")
    said = []
    totals = example().main(folder, objects=8, draws=1, say=said.append)
    known, named, unknown = totals["known"], totals["never refusing"], totals["unknown"]
    assert known.sequences == named.sequences == unknown.sequences > 20
    assert named.refused == 0
    assert named.right > 0.7 * named.sequences
    assert known.touches <= 4 * known.sequences
    assert unknown.right == 0
    assert totals["drawn"].right > 0.6 * known.sequences
    assert totals["added"].right > 0.5 * known.sequences
    assert any(line.startswith("no simulator was imported") for line in said)
