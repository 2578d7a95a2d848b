"""The file of a model that a controller can hold: what is written is read again, bad files end in one line."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.pressed_things import recording

from varishold import Pad, Recording, TactileClassifier
from varishold.cli.decision_file import exported_decision
from varishold.errors import FormatError, InputError
from varishold.files import write_archive
from varishold.learning import PortableClassifier, labelled_presses, read_model, write_model
from varishold.touch.contact_network import NONE_OF_THESE, ContactNetwork
from varishold.touch.decision import Parameters
from varishold.touch.writers import Export, c99_files


def two_pads(seed: int) -> Recording:
    """Two pads, one of them with a gap, that press the same things in the same order."""
    given = recording(["disc", "bar"] * 12, seed)
    other = recording(["disc", "bar"] * 12, seed + 1, (9, 11))
    corner = np.add.outer(np.arange(9), np.arange(11)) > 1
    pads = {"thumb": given.pads["pad"], "palm": Pad(np.where(corner, other.pads["pad"].frames, 0.0), field=corner)}
    return Recording(pads, press=given.press, press_columns=_columns(given))


def _columns(given: Recording) -> dict[str, np.ndarray]:
    return {name: np.asarray(values) for name, values in given.presses.columns.items()}


KNOWN = labelled_presses([two_pads(0)], label="thing")
NEW = labelled_presses([two_pads(2)], label="thing")


@pytest.fixture(scope="module")
def model() -> PortableClassifier:
    return PortableClassifier(error=0.1).fit(KNOWN.presses, KNOWN.labels)


@pytest.fixture(scope="module")
def written(model: PortableClassifier, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.npz"
    write_model(model, path)
    return path


def test_a_model_survives_the_round_trip_bit_for_bit(model: PortableClassifier, written: Path, tmp_path: Path) -> None:
    again = read_model(written)
    assert isinstance(again, PortableClassifier)
    np.testing.assert_array_equal(again.predict_proba(NEW.presses), model.predict_proba(NEW.presses))
    np.testing.assert_array_equal(again.p_values(NEW.presses), model.p_values(NEW.presses))
    assert [a.to_dict() for a in again.explain(NEW.presses)] == [a.to_dict() for a in model.explain(NEW.presses)]
    assert (again.error, again.remarks_, dict(again.pads_)) == (0.1, model.remarks_, dict(model.pads_))
    for name, network in model.networks.items():
        for key, value in vars(network).items():
            np.testing.assert_array_equal(getattr(again.networks[name], key), value, err_msg=key)
    write_model(again, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == written.read_bytes()


def test_learning_twice_gives_the_same_bytes(written: Path, tmp_path: Path) -> None:
    write_model(PortableClassifier(error=0.1).fit(KNOWN.presses, KNOWN.labels), tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == written.read_bytes()
    assert written.stat().st_size < 200_000


def test_a_pad_that_nothing_touched_is_kept_and_has_no_network(tmp_path: Path) -> None:
    given = recording(["disc", "bar"] * 6, 5)
    pads = {"thumb": given.pads["pad"], "palm": Pad(np.zeros((given.n_frames, 6, 7)))}
    still = Recording(pads, press=given.press, press_columns=_columns(given))
    known = labelled_presses([still], label="thing")
    write_model(PortableClassifier().fit(known.presses, known.labels), tmp_path / "m.npz")
    again = read_model(tmp_path / "m.npz")
    assert dict(again.pads_) == {"thumb": (13, 15), "palm": (6, 7)}
    assert list(again.networks) == ["thumb"]
    assert again.score(known.presses, known.labels) > 0.9
    assert isinstance(exported_decision(tmp_path / "m.npz"), ContactNetwork)


def test_what_was_not_learned_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="this PortableClassifier has not learned anything yet"):
        write_model(PortableClassifier(), tmp_path / "m.npz")


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


@pytest.mark.parametrize(
    ("new", "message"),
    [
        ({"learner": "oracle"}, "learner must be tactile or portable, got 'oracle'"),
        ({"learner": "tactile"}, "'clock' is missing; learn the model again"),
        ({"version": 6}, "is of version 6, this program reads up to 5; update varishold"),
        ({"inputs": 12}, "the model has 12 inputs, this program's signature 173; learn the model again"),
        ({"temperature": 0.0}, "temperature must lie between"),
        ({"temperature": None}, "'temperature' is missing"),
        ({"shrinkage": 2}, "shrinkage must lie between 0 and 1, got 2"),
        ({"loss": -1.0}, "loss must lie between"),
        ({"error": 1.0}, "error must lie between 0 and 1"),
        ({"pads": [["thumb", 9, 9], ["palm", 9, 11]]}, "pad_0.field must be 9 x 9 truth values"),
        ({"pad_1__field": np.zeros((9, 11), bool)}, "pad_1.field must be 9 x 11 truth values, some of them true"),
        ({"pad_0__examples": np.zeros((2, 3, 3))}, "pad_0.examples must be any x 13 x 15 numbers"),
        ({"pad_0__examples": np.full((1, 13, 15), 1e30)}, "pad_0.examples must be finite, at most 1e+15"),
        ({"pad_0__directions": np.zeros((5, 1))}, "pad_0.directions must be 173 x any numbers"),
        ({"pad_0__directions": np.full((173, 1), np.nan)}, "pad_0.directions must be finite"),
        ({"pad_0__means": np.zeros((3, 1))}, "pad_0.means must be 2 x 1 numbers"),
        ({"pad_0__usual": np.zeros((2, 3))}, "pad_0.usual must be 2 x 173 numbers"),
        ({"pad_0__landmarks": np.zeros((3, 1))}, "pad_0.landmarks must be 24 x 1 numbers"),
        ({"pad_1__typical": np.zeros(2)}, "pad_1.typical must be 1 numbers"),
        ({"pad_1__scale": None}, "holds no array 'pad_1.scale'"),
        ({"pad_0__shift": None, "pad_1__shift": None}, "no pad has a network"),
        ({"known": np.empty(0)}, "known must hold at least one number"),
        ({"classes": np.array(["bar"])}, "classes must be two or more"),
        ({"classes": np.array([f"{k:03}" for k in range(256)])}, "landmark_codes must name each of 256 classes"),
        (
            {
                "classes": np.array([f"{k:03}" for k in range(256)]),
                "landmark_codes": np.arange(256),
                "places": np.full(256, "here"),
            },
            "a controller tells 255 things apart at most, got 256",
        ),
    ],
)
def test_a_hostile_model_is_told_in_one_line(written: Path, tmp_path: Path, new: dict[str, Any], message: str) -> None:
    with pytest.raises(FormatError) as told:
        read_model(changed(written, tmp_path / "bad.npz", **new))
    assert message in str(told.value)
    assert str(told.value).startswith(str(tmp_path / "bad.npz"))
    assert "\n" not in str(told.value)


def test_weights_beyond_single_precision_are_not_exported(written: Path, tmp_path: Path) -> None:
    far = changed(written, tmp_path / "far.npz", pad_0__means=np.array([[-1e12], [1e12]]))
    with pytest.raises(InputError, match="beyond a controller's single precision"):
        exported_decision(far, "thumb")
    flat = changed(written, tmp_path / "flat.npz", known=np.zeros(40))
    with pytest.raises(InputError, match="beyond a controller's single precision"):
        exported_decision(flat, "thumb")


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_damaged_model_is_refused_or_answers(written: Path, tmp_path_factory: Any, data: st.DataObject) -> None:
    content = bytearray(written.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("damaged") / "m.npz"
    path.write_bytes(content)
    with contextlib.suppress(InputError):
        again = read_model(path)
        assert np.isfinite(again.predict_proba(NEW.presses[:1])).all()
        for name in again.networks:
            c99_files(Export(parameters=exported_decision(path, name)))


def test_the_decision_of_a_file(written: Path, tmp_path: Path) -> None:
    assert exported_decision(None) is None
    network = exported_decision(written, "palm")
    assert isinstance(network, ContactNetwork)
    assert network.shape == (9, 11)
    assert network.names == ("bar", "disc", NONE_OF_THESE)
    shipped = Path(__file__).parents[1] / "src" / "varishold" / "touch" / "parameters" / "early.npz"
    assert isinstance(exported_decision(shipped), Parameters)
    write_model(TactileClassifier().fit(KNOWN.presses, KNOWN.labels), tmp_path / "large.npz")
    np.savez(tmp_path / "other.npz", pressure=np.zeros((1, 2, 2)))
    for path, pad, told in (
        (None, "palm", "only a model that learn --portable wrote has pads by name"),
        (shipped, "palm", "only a model that learn --portable wrote has pads by name"),
        (written, None, "model.npz: name one of its pads, thumb, palm$"),
        (written, "hand", "model.npz: name one of its pads, thumb, palm, got 'hand'"),
        (tmp_path / "large.npz", None, "large.npz: is too large for a controller: learn it again with --portable"),
        (tmp_path / "other.npz", None, "other.npz: is no model file"),
        (tmp_path / "none.npz", None, "none.npz"),
    ):
        with pytest.raises(InputError, match=told):
            exported_decision(path, pad)
