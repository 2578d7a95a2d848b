"""Laws of units and of the taxels' pitch in learning: converted where they can be, else refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from varishold import Pad, Recording, TactileClassifier
from varishold.cli.app import app
from varishold.errors import FormatError, InputError
from varishold.evaluation import evaluate
from varishold.files import write_archive
from varishold.learning import PortableClassifier, labelled_presses, read_model, write_model

KINDS = [TactileClassifier, PortableClassifier]
SHAPE = (9, 10)


def recording(
    seed: int, *, unit: str = "raw", pitch_m: Any = None, times: float = 1.0, each: int = 8, name: str = ""
) -> Recording:
    """Spots and bars pressed in turn, in readings of some thousand pascals times a factor."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(SHAPE) - np.array([4.0, 4.5])[:, None, None]
    forms = {"spot": np.exp(-(x * x + y * y) / 4), "bar": np.exp(-y * y / 3)}
    labels = np.tile(list(forms), each)
    ramp = np.concatenate([np.zeros(2), np.linspace(0, 1, 8), [0.5]])[:, None, None]
    frames = np.concatenate(
        [4096 * rng.uniform(0.9, 1.1) * ramp * forms[label] + rng.normal(0, 16, (11, *SHAPE)) for label in labels]
    )
    return Recording(
        {"pad": Pad(times * frames, pitch_m=pitch_m)},
        np.arange(len(frames)) / 100,
        unit=unit,
        source=name,
        press=np.repeat(np.arange(2 * each), 11),
        press_columns={"thing": labels},
    )


def learned(*recordings: Recording, kind: Any = TactileClassifier) -> Any:
    given = labelled_presses(recordings, label="thing")
    return kind(drift=0, folds=2).fit(given.presses, given.labels)


def presses(of: Recording) -> Any:
    return labelled_presses([of], label="thing").presses


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("unit", "times"), [("kPa", 2.0**-10), ("MPa", 2.0**-20), ("mbar", 2.0**-7), ("N/cm²", 0.25)])
def test_a_unit_of_pressure_is_taken_in_that_which_was_learned(kind: Any, unit: str, times: float) -> None:
    pa = recording(1, unit="Pa")
    model = learned(pa, kind=kind)
    factor = Recording({"pad": Pad(np.ones((1, 2, 2)))}, unit=unit).pascals_per_unit
    assert factor is not None
    other = presses(recording(2, unit=unit, times=1 / factor))
    np.testing.assert_allclose(model.predict_proba(other), model.predict_proba(presses(recording(2))), atol=1e-9)
    assert model.remarks_on(other) == (f"readings in {unit} are taken in Pa, that of the model",)
    both = learned(pa, recording(2, unit=unit, times=times), kind=kind)
    assert both.scale_.unit == "Pa"
    assert f"readings in {unit} are taken in Pa, that of the others" in both.remarks_


def test_presses_in_two_units_are_learned_as_in_one() -> None:
    pa, kpa = recording(1, unit="Pa"), recording(2, unit="kPa", times=1e-3)
    mixed, plain = learned(pa, kpa), learned(pa, recording(2, unit="Pa"))
    asked = presses(recording(3, unit="hPa", times=1e-2))
    np.testing.assert_allclose(mixed.predict_proba(asked), plain.predict_proba(asked), atol=1e-9)


@pytest.mark.parametrize("first", ["Pa", "counts"])
def test_units_that_have_nothing_to_do_with_each_other_are_not_learned_together(first: str) -> None:
    other = {"Pa": "counts", "counts": "Pa"}[first]
    a, b, c = (recording(k, unit=u, name=f"{k}.npz") for k, u in ((1, first), (2, other), (3, other)))
    with pytest.raises(InputError) as told:
        learned(a, b, c)
    assert str(told.value) == (
        f"2.npz, 3.npz: readings are in {other}, those of 1.npz in {first}, which are not converted; keep to "
        "recordings of one unit, or correct unit where it is wrong"
    )
    given = labelled_presses([a, b, c], label="thing")
    with pytest.raises(InputError, match="which are not converted"):
        evaluate(given.presses, given.labels, peers=False)
    with pytest.raises(InputError, match=rf"2\.npz: readings are in {other}, those of the model in {first}"):
        learned(a).predict(presses(b))


def test_forms_alone_are_compared_where_levels_say_nothing() -> None:
    a, b = recording(1, unit="Pa"), recording(2, unit="counts", times=0.3)
    model = learned(a, kind=PortableClassifier)
    np.testing.assert_allclose(
        model.predict_proba(presses(b)), model.predict_proba(presses(recording(2, unit="Pa"))), atol=1e-9
    )
    assert model.remarks_on(presses(b)) == (
        "readings are in counts, those of the model in Pa: forms alone are compared",
    )


@pytest.mark.parametrize("kind", KINDS)
def test_taxels_of_another_pitch_are_refused_in_learning_and_in_asking(kind: Any) -> None:
    a, b = recording(1, pitch_m=1e-3, name="a.npz"), recording(2, pitch_m=(4e-3, 5e-3), name="b.npz")
    with pytest.raises(InputError) as told:
        learned(a, b, kind=kind)
    assert str(told.value) == (
        "b.npz: taxels of 'pad' are 4 x 5 mm apart, those of a.npz 1 mm; forms are measured in taxels: keep to "
        "recordings of one pitch, or correct pitch_m where it is wrong"
    )
    with pytest.raises(InputError, match=r"b\.npz: taxels of 'pad' are 4 x 5 mm apart, those of the model 1 mm"):
        learned(a, kind=kind).predict(presses(b))
    with pytest.raises(InputError, match="apart"):
        learned(a, kind=kind).add("new", presses(b)) if kind is TactileClassifier else learned(a, b, kind=kind)


@pytest.mark.parametrize(("pitch_m", "fits"), [(1.04e-3, True), (0.96e-3, True), (1.06e-3, False), (0.94e-3, False)])
def test_a_pitch_that_is_written_a_little_otherwise_is_the_same(pitch_m: float, fits: bool) -> None:
    model = learned(recording(1, pitch_m=1e-3))
    asked = presses(recording(2, pitch_m=(1e-3, pitch_m)))
    if fits:
        assert len(model.predict(asked)) == 16
    else:
        with pytest.raises(InputError, match="apart"):
            model.predict(asked)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_not_known_on_one_side_is_not_refused_but_told(kind: Any) -> None:
    told, silent = recording(1, unit="Pa", pitch_m=1e-3), recording(2)
    said = (
        "16 presses say no unit: taken in Pa, that of the {0}",
        "16 presses say no pitch: taxels are taken to be as ",
    )
    model = learned(told, kind=kind)
    assert len(model.predict(presses(silent))) == 16
    remarks = model.remarks_on(presses(silent))
    assert remarks[0] == said[0].format("model")
    assert remarks[1].startswith(said[1])
    both = learned(told, silent, kind=kind)
    assert said[0].format("others") in both.remarks_
    plain = learned(silent, kind=kind)
    assert len(plain.predict(presses(told))) == 16
    assert plain.remarks_on(presses(told)) == ("readings in Pa are taken as they are: no unit is known of the model",)
    assert plain.remarks_on(presses(silent)) == ()


@pytest.mark.parametrize("kind", KINDS)
def test_a_model_file_keeps_unit_and_pitch(kind: Any, tmp_path: Path) -> None:
    model = learned(recording(1, unit="kPa", pitch_m=(1e-3, 2e-3)), kind=kind)
    write_model(model, tmp_path / "m.npz")
    read = read_model(tmp_path / "m.npz")
    assert read.scale_ == model.scale_
    assert (read.scale_.unit, dict(read.scale_.pitch_m)) == ("kPa", {"pad": (1e-3, 2e-3)})
    with pytest.raises(InputError, match="those of the model 1 x 2 mm"):
        read.predict(presses(recording(2, pitch_m=1e-2)))


def changed(path: Path, **entries: Any) -> Path:
    with np.load(path) as data:
        arrays = dict(data)
    about = json.loads(str(arrays["about"]))
    for key, value in entries.items():
        if value is None:
            del about[key]
        else:
            about[key] = value
    write_archive(arrays | {"about": np.array(json.dumps(about))}, path.with_name("changed.npz"), kind="model")
    return path.with_name("changed.npz")


def test_a_portable_model_that_was_written_before_is_read_without_unit_and_pitch(tmp_path: Path) -> None:
    model = learned(recording(1), kind=PortableClassifier)
    write_model(model, tmp_path / "m.npz")
    old = read_model(changed(tmp_path / "m.npz", version=2, unit=None, pitch_m=None))
    asked = presses(recording(2, unit="psi", pitch_m=1e-2))
    np.testing.assert_array_equal(old.predict_proba(asked), read_model(tmp_path / "m.npz").predict_proba(asked))
    assert (old.scale_.unit, old.scale_.pitch_m) == ("raw", {})


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({"unit": None}, "'unit' is missing"),
        ({"pitch_m": None}, "'pitch_m' is missing"),
        ({"unit": 3}, "unit must be printable text, got 3"),
        ({"unit": "a\nb"}, "unit must be printable text"),
        ({"pitch_m": [1e-3, 1e-3]}, "pitch_m must be a mapping of pads"),
        ({"pitch_m": {"other": [1e-3, 1e-3]}}, "pitch_m must be a mapping of pads"),
        ({"pitch_m": {"pad": [1e-3, -1]}}, "pitch_m must be one spacing in metres"),
        ({"pitch_m": {"pad": "wide"}}, "pitch_m must be one spacing in metres"),
        ({"pitch_m": {"pad": None}}, "pitch_m must be"),
        ({"pitch_m": {"pad": {"rows": 1}}}, "pitch_m must be"),
    ],
)
def test_what_is_wrong_with_unit_or_pitch_in_a_file_is_told(
    tmp_path: Path, entries: dict[str, Any], words: str
) -> None:
    write_model(learned(recording(1)), tmp_path / "m.npz")
    with pytest.raises(FormatError) as told:
        read_model(changed(tmp_path / "m.npz", **entries))
    assert words in str(told.value)
    assert "\n" not in str(told.value)


def said_by(*words: str, status: int = 0) -> Result:
    done = CliRunner().invoke(app, list(words))
    assert done.exit_code == status, done.output
    return done


def test_commands_tell_how_presses_were_taken(tmp_path: Path) -> None:
    for name, seed, of in (
        ("pa", 1, {"unit": "Pa", "pitch_m": 1e-3}),
        ("kpa", 2, {"unit": "kPa", "pitch_m": 1e-3, "times": 1e-3}),
        ("wide", 3, {"unit": "Pa", "pitch_m": 4e-3}),
    ):
        made = recording(seed, **of)
        arrays = {"pressure": made.pads["pad"].frames, "time_s": made.time_s, "press": made.press}
        extra = {"press.thing": made.press_columns["thing"], "unit": of["unit"], "pitch_m": of["pitch_m"]}
        np.savez(tmp_path / f"{name}.npz", **arrays, **extra)  # type: ignore[arg-type]
    pa, kpa, wide, model = (str(tmp_path / f"{name}.npz") for name in ("pa", "kpa", "wide", "model"))
    said_by("learn", pa, "--label", "thing", "-o", model)
    found = said_by("recognize", model, kpa)
    assert f"note: {kpa}: readings in kPa are taken in Pa, that of the model" in found.stderr
    refused = said_by("recognize", model, wide, status=1)
    assert str(refused.exception).startswith(f"{wide}: taxels of 'pad' are 4 mm apart, those of the model 1 mm")
    refused = said_by("learn", pa, wide, "--label", "thing", "-o", str(tmp_path / "no.npz"), status=1)
    assert f"{wide}: taxels of 'pad' are 4 mm apart, those of {pa} 1 mm" in str(refused.exception)
    assert not (tmp_path / "no.npz").exists()
