"""The model file: what is written is read again bit for bit, and strangers' files end in one line."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold import Pad, Recording, TactileClassifier
from varishold.errors import FormatError, InputError
from varishold.files import write_archive
from varishold.learning import read_model, write_model

RNG = np.random.default_rng(0)
LABELS = np.tile(["ring", "bar"], 12)


def frames(label: str) -> np.ndarray:
    y, x = np.mgrid[-4:5, -4:5]
    form = np.abs(np.hypot(x, y) - 3) < 1 if label == "ring" else np.abs(x) < 2
    return 50 * np.array([0.0, 0.4, 0.9, 1.0])[:, None, None] * form + RNG.normal(0, 1, (4, 9, 9))


def grasp(label: str) -> Recording:
    angle = np.array([0.2 + 0.5 * (label == "bar") + RNG.normal(0, 0.2)])
    pads = {"left": Pad(frames(label)), "right": Pad(frames("bar"))}
    return Recording(pads, press=np.zeros(4, int), press_columns={"angle_rad.thumb": angle})


GRASPS = [grasp(label) for label in LABELS]


@pytest.fixture(scope="module")
def model() -> TactileClassifier:
    return TactileClassifier(error=0.1).fit(GRASPS, LABELS)


@pytest.fixture(scope="module")
def written(model: TactileClassifier, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.npz"
    write_model(model, path)
    return path


def test_a_model_survives_the_round_trip_bit_for_bit(model: TactileClassifier, written: Path, tmp_path: Path) -> None:
    again = read_model(written)
    np.testing.assert_array_equal(again.predict_proba(GRASPS), model.predict_proba(GRASPS))
    np.testing.assert_array_equal(again.p_values(GRASPS), model.p_values(GRASPS))
    assert [a.to_dict() for a in again.explain(GRASPS)] == [a.to_dict() for a in model.explain(GRASPS)]
    assert again.error == 0.1
    write_model(again, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == written.read_bytes()


def test_learning_twice_gives_the_same_bytes(written: Path, tmp_path: Path) -> None:
    write_model(TactileClassifier(error=0.1).fit(GRASPS, LABELS), tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == written.read_bytes()


def test_a_model_that_was_read_takes_a_class_more(written: Path) -> None:
    more = [Recording({"left": Pad(f), "right": Pad(f)}) for f in (frames("ring") for _ in range(6))]
    clf = read_model(written).add("two rings", more)
    assert clf.classes_.tolist() == ["bar", "ring", "two rings"]
    assert np.mean(clf.predict(more) == "two rings") > 0.8
    assert clf.score(GRASPS, LABELS) > 0.8


def test_numbers_are_labels_too(tmp_path: Path) -> None:
    y = np.tile([3, 1], 12)
    write_model(TactileClassifier().fit(GRASPS, y), tmp_path / "m.npz")
    found = read_model(tmp_path / "m.npz")
    assert found.classes_.tolist() == [1, 3]
    assert found.score(GRASPS, y) > 0.9


def test_what_was_not_learned_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has not learned anything yet"):
        write_model(TactileClassifier(), tmp_path / "m.npz")


def changed(written: Path, path: Path, **new: Any) -> Path:
    """Write the model with other arrays, or other entries of its text; None leaves one out."""
    with np.load(written) as data:
        arrays = dict(data)
    about = json.loads(str(arrays["about"]))
    for name, value in new.items():
        key = name.replace("__", ".")
        target = arrays if key in arrays else about
        if value is None:
            del target[key]
        else:
            target[key] = value
    arrays["about"] = np.array(json.dumps(about))
    write_archive(arrays, path, kind="model")
    return path


def changed_source(**new: Any) -> dict[str, Any]:
    """Return what a model says of its sources, something in it changed."""
    plain = {"width": 1.0, "shrinkage": 0.1, "temperature": 1.0, "weight": 1.0, "mixing": 0.01}
    return {"touch": {"1": plain | new}, "numbers": {"2": plain | new}}


@pytest.mark.parametrize(
    ("new", "message"),
    [
        ({"format": "other"}, "is no model file"),
        ({"version": 6}, "is of version 6, this program reads up to 5; update varishold"),
        ({"version": 1}, "is of version 1, which is read no more; learn the model again"),
        ({"version": "1"}, "version must be a positive whole number, got '1'"),
        ({"floor": None}, "'floor' is missing; learn the model again"),
        ({"rise": 0.0}, "rise must lie between 1e-300 and inf, got 0"),
        ({"clock": "days"}, "clock must be seconds or frames, got 'days'"),
        ({"position": 1}, "position and absolute must be true or false"),
        ({"pads": []}, "pads must be a list of 1 to 64"),
        ({"pads": [["left", 9, 10**9], ["right", 9, 9]]}, "rows and columns of pads must lie between 1 and 4096"),
        ({"pads": [["left", 9, 9]]}, "touch.shift must be 376 numbers"),
        ({"sources": changed_source(temperature=-1.0)}, "temperature must lie between"),
        ({"sources": changed_source(weight=-1.0)}, "weight must lie between"),
        (
            {"sources": changed_source(mixing=1.0)},
            "mixing weight of source 'touch.1' must be a number from 0 to below 1",
        ),
        ({"sources": {"touch": {"3": {}}, "numbers": {}}}, "sources: touch must have views of the powers 1, 2 or both"),
        ({"error": 1.0}, "error must lie between 0 and 1"),
        ({"columns": []}, "sources must be touch"),
        ({"sources": {}}, "sources must be touch, numbers"),
        ({"classes": np.array(["ring", "bar"])}, "classes must be different and in order"),
        ({"classes": np.array(["bar"])}, "classes must be two or more"),
        ({"landmark_codes": np.zeros(144, int)}, "landmark_codes must name each of 2 classes"),
        ({"places": np.array(["here"])}, "landmark_codes and places must be one whole number and one text a landmark"),
        ({"known": np.empty(0)}, "known must hold at least one number"),
        ({"known": np.array([np.nan])}, "known must be finite"),
        ({"touch__1__whiten": np.zeros((3, 3))}, "touch.1.whiten must be 144 x any numbers"),
        ({"touch__1__means": None}, "holds no array 'touch.1.means'"),
        ({"touch__landmarks": np.full((24, 3), 1.0)}, "touch.landmarks must be 144 x"),
    ],
)
def test_a_hostile_model_is_told_in_one_line(written: Path, tmp_path: Path, new: dict[str, Any], message: str) -> None:
    with pytest.raises(FormatError) as told:
        read_model(changed(written, tmp_path / "bad.npz", **new))
    assert message in str(told.value)
    assert str(told.value).startswith(str(tmp_path / "bad.npz"))


def test_other_files_are_no_models(tmp_path: Path) -> None:
    np.savez(tmp_path / "recording.npz", pressure=np.zeros((2, 3, 3)))
    (tmp_path / "text.npz").write_text("hello")
    for name in ("recording.npz", "text.npz"):
        with pytest.raises(FormatError, match=name):
            read_model(tmp_path / name)


@settings(max_examples=60)
@given(st.data())
def test_a_damaged_model_is_refused_or_answers(written: Path, tmp_path_factory: Any, data: st.DataObject) -> None:
    content = bytearray(written.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("damaged") / "m.npz"
    path.write_bytes(content)
    with contextlib.suppress(InputError):
        assert np.isfinite(read_model(path).predict_proba(GRASPS[:1])).all()
