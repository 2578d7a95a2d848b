"""The model file: every field comes back, and every number has its limits."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from varishold.errors import FormatError, InputError
from varishold.files import write_archive
from varishold.learning import TactileClassifier, read_model, write_model
from varishold.learning.discriminant import Discriminant, Scaling
from varishold.learning.sources import Learned, Source, View
from varishold.touch.course.measures import MeasureSettings, measure_names
from varishold.trust import SourceWeights

N, K = 4, 2


def single(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.normal(0, 1, shape).astype(np.float32).astype(float)


def made(columns: tuple[str, ...] = ("angle_rad.a", "switch.b", "force_n.c")) -> TactileClassifier:
    """A model whose every number is another one."""
    rng = np.random.default_rng(0)
    model = TactileClassifier(error=0.125)
    shapes = {"thumb": (5, 6), "palm": (7, 3)}
    model.settings_ = MeasureSettings(shapes, 0.5, 0.25, "seconds", 40.0, True, False, 2.5, 0.125)
    model.measure_names_ = tuple(measure_names(model.settings_))
    model.columns_ = columns
    model.n_presses_ = 23
    model.n_features_in_ = 51
    model.classes_ = np.array(["bar", "cup"])
    model.places_ = np.array([f"f, press {k}" for k in range(N)])
    model.remarks_ = ("one", "two")
    sources, weights, mixing = {}, {}, {}
    for name, m in (("touch", len(model.measure_names_)), *((("numbers", len(columns)),) if columns else ())):
        views = []
        for power in (1, 2):
            weights[f"{name}.{power}"], mixing[f"{name}.{power}"] = rng.uniform(0, 5), rng.uniform(0, 0.9)
            one = Discriminant(power, rng.uniform(1, 8), rng.uniform(0, 1), single(rng, N, 1), single(rng, K, 1))
            views.append(View(one, rng.uniform(1, 9), rng.uniform(1, 2, 2)))
        scaling = Scaling(rng.normal(0, 1, m), rng.uniform(0, 1, m))
        sources[name] = Source(scaling, single(rng, N, m), tuple(views))
    trust = SourceWeights(weights, mixing)
    model.learned_ = Learned(sources, trust, rng.uniform(0, 3, 6), 0.75, np.array([1, 0, 0, 1]))
    return model


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.npz"
    write_model(made(), path)
    return path


@pytest.mark.parametrize("columns", [("angle_rad.a", "switch.b", "force_n.c"), ()])
def test_every_field_comes_back(tmp_path: Path, columns: tuple[str, ...]) -> None:
    model = made(columns)
    write_model(model, tmp_path / "m.npz")
    found = read_model(tmp_path / "m.npz")
    s = found.settings_
    assert dict(s.shapes) == {"thumb": (5, 6), "palm": (7, 3)}
    assert (s.floor, s.rise, s.clock, s.load, s.position, s.absolute) == (0.5, 0.25, "seconds", 40.0, True, False)
    assert (s.least_load, s.filled) == (2.5, 0.125)
    for name in ("error", "columns_", "n_features_in_", "remarks_", "measure_names_", "adapted_to_", "n_presses_"):
        assert getattr(found, name) == getattr(model, name)
    assert found.classes_.tolist() == ["bar", "cup"]
    assert found.places_.tolist() == model.places_.tolist()
    mine, theirs = found.learned_, model.learned_
    assert mine.trust == theirs.trust
    assert mine.loss == 0.75
    assert mine.drift == {}
    assert mine.known.tolist() == theirs.known.tolist()
    assert mine.landmark_codes.tolist() == [1, 0, 0, 1]
    assert mine.landmark_codes.dtype == np.intp
    assert list(mine.sources) == list(theirs.sources) == ["touch", "numbers"][: 1 + bool(columns)]
    for name, source in mine.sources.items():
        other = theirs.sources[name]
        np.testing.assert_array_equal(source.scaling.shift, other.scaling.shift)
        np.testing.assert_array_equal(source.scaling.scale, other.scaling.scale)
        np.testing.assert_array_equal(source.landmarks, other.landmarks)
        assert source.landmarks.dtype == np.float64
        for view, old in zip(source.views, other.views, strict=True):
            one, two = view.discriminant, old.discriminant
            assert (one.power, one.width, one.shrinkage) == (two.power, two.width, two.shrinkage)
            assert (view.temperature, view.typical.tolist()) == (old.temperature, old.typical.tolist())
            np.testing.assert_array_equal(one.whiten, two.whiten)
            np.testing.assert_array_equal(one.means, two.means)


def test_a_model_of_one_kernel_is_read(tmp_path: Path) -> None:
    model = made(())
    source = model.learned_.sources["touch"]
    model.learned_ = replace(model.learned_, sources={"touch": replace(source, views=source.views[1:])})
    write_model(model, tmp_path / "m.npz")
    assert [view.discriminant.power for view in read_model(tmp_path / "m.npz").learned_.sources["touch"].views] == [2]


def opened(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    with np.load(path) as data:
        arrays = dict(data)
    return arrays, json.loads(str(arrays.pop("about")))


def test_numbers_that_need_no_more_are_of_single_precision(written: Path) -> None:
    arrays, about = opened(written)
    for name, array in arrays.items():
        kind = name.rpartition(".")[2]
        wanted = {"landmarks": "float32", "whiten": "float32", "means": "float32", "landmark_codes": "int32"}
        assert array.dtype.kind == "U" or str(array.dtype) == wanted.get(kind, "float64"), name
    assert (about["format"], about["version"]) == ("varishold model", 5)
    assert about["pads"] == [["thumb", 5, 6], ["palm", 7, 3]]


def changed(written: Path, path: Path, key: str, value: Any, *, drop: bool = False) -> Path:
    """Write a model again, with one array or one entry changed or dropped; an entry's path has slashes."""
    arrays, about = opened(written)
    target: Any = arrays if key in arrays else about
    *outer, last = key.split("/")
    for part in outer:
        target = target[part]
    if drop:
        del target[last]
    else:
        target[last] = value
    write_archive({"about": np.array(json.dumps(about)), **arrays}, path, kind="model")
    return path


VIEW = "sources/numbers/2"
LIMITS = [
    ("floor", 0.0, 1e300, "0 and inf"),
    ("rise", 1e-300, 1e300, "1e-300 and inf"),
    ("load", 1e-300, 1e300, "1e-300 and inf"),
    ("loss", 0.0, 1e300, "0 and inf"),
    (f"{VIEW}/width", 1e-6, 1e300, "1e-06 and inf"),
    (f"{VIEW}/temperature", 1e-6, 1e300, "1e-06 and inf"),
    (f"{VIEW}/shrinkage", 0.0, 1.0, "0 and 1"),
    (f"{VIEW}/weight", 0.0, 1e300, "0 and inf"),
    (f"{VIEW}/mixing", 0.0, 0.999, "0 and 1"),
    ("error", 1e-9, 0.999, "0 and 1"),
]


@pytest.mark.parametrize(("key", "least", "most", "between"), LIMITS)
def test_every_number_has_its_limits(
    written: Path, tmp_path: Path, key: str, least: float, most: float, between: str
) -> None:
    for value in (least, most):
        read_model(changed(written, tmp_path / "m.npz", key, value))
    name = key.rpartition("/")[2]
    wrong = [(-1.0, f"{name} must lie between {between}, got -1; learn the model again")]
    if most < 1e300:
        wrong.append((1.5, f"{name} must lie between {between}, got 1.5; learn the model again"))
    elif least > 0:
        wrong.append((least / 2, f"{name} must lie between {between}, got {least / 2:g}; learn the model again"))
    wrong += [(value, f"{name} must be a finite number, got {value!r}; ") for value in (True, "1", None, [1.0])]
    for value, message in wrong:
        with pytest.raises(FormatError) as told:
            read_model(changed(written, tmp_path / "m.npz", key, value))
        assert str(told.value).startswith(f"{tmp_path / 'm.npz'}: {message}")
    with pytest.raises(FormatError, match=f"{name!r} is missing; learn the model again"):
        read_model(changed(written, tmp_path / "m.npz", key, None, drop=True))


def test_in_a_file_of_before_no_taxel_was_filled(written: Path, tmp_path: Path) -> None:
    assert read_model(changed(written, tmp_path / "m.npz", "filled", None, drop=True)).settings_.filled == 0
    with pytest.raises(FormatError, match="filled must lie between 0 and 1, got 2; learn the model again"):
        read_model(changed(written, tmp_path / "m.npz", "filled", 2.0))


def test_of_a_file_of_before_the_least_load_is_not_known(written: Path, tmp_path: Path) -> None:
    assert read_model(changed(written, tmp_path / "m.npz", "least_load", None, drop=True)).settings_.least_load == 0
    with pytest.raises(FormatError, match="least_load must lie between 0 and inf, got -1; learn the model again"):
        read_model(changed(written, tmp_path / "m.npz", "least_load", -1.0))


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_no_number_is_without_end(written: Path, tmp_path: Path, value: float) -> None:
    with pytest.raises(FormatError):
        read_model(changed(written, tmp_path / "m.npz", "floor", value))


FLOATS = [
    ("known", (6,), "any"),
    ("touch.shift", (None,), "{m}"),
    ("touch.scale", (None,), "{m}"),
    ("touch.landmarks", (N, None), "4 x {m}"),
    ("numbers.shift", (3,), "3"),
    ("numbers.landmarks", (N, 3), "4 x 3"),
    ("numbers.1.whiten", (N, 1), "4 x any"),
    ("numbers.2.means", (K, 1), "2 x 1"),
    ("touch.2.typical", (2,), "2"),
]


@pytest.mark.parametrize(("name", "shape", "words"), FLOATS)
def test_every_array_has_its_shape_and_is_finite(
    written: Path, tmp_path: Path, name: str, shape: tuple[int | None, ...], words: str
) -> None:
    arrays, _ = opened(written)
    m = len(made().measure_names_)
    plain = arrays[name]
    assert plain.shape == tuple(m if side is None else side for side in shape)
    words = words.format(m=m)
    for wrong in (plain.astype(int), plain[..., None], plain.ravel()[:1].reshape([1] * plain.ndim)[..., None][..., 0]):
        if wrong.shape == plain.shape[:1] or (name == "known" and wrong.dtype.kind == "f" and wrong.ndim == 1):
            continue
        with pytest.raises(FormatError) as told:
            read_model(changed(written, tmp_path / "m.npz", name, wrong))
        assert f": {name} must be {words} numbers, got {wrong.dtype} of shape {wrong.shape};" in str(told.value)
    for value in (np.nan, np.inf, -1e101):
        wrong = plain.astype(float)
        wrong.ravel()[-1] = value
        with pytest.raises(
            FormatError, match=f"{re.escape(name)} must be finite, at most 1e.100; learn the model again"
        ):
            read_model(changed(written, tmp_path / "m.npz", name, wrong))
    large = plain.astype(float)
    large.ravel()[-1] = 1e100
    read_model(changed(written, tmp_path / "m.npz", name, large))
    with pytest.raises(FormatError, match=re.escape(f"'{name}'")):
        read_model(changed(written, tmp_path / "m.npz", name, None, drop=True))


def test_a_typical_strangeness_is_above_zero(written: Path, tmp_path: Path) -> None:
    found = read_model(changed(written, tmp_path / "m.npz", "touch.1.typical", np.array([0.0, -3.0])))
    assert found.learned_.sources["touch"].views[0].typical.tolist() == [1e-12, 1e-12]


PADS = "pads must be different names, each with rows and columns"
WRONG = [
    ("version", 0, "version must be a positive whole number, got 0"),
    ("version", True, "version must be a positive whole number, got True"),
    ("version", 2.0, "version must be a positive whole number, got 2.0"),
    ("version", None, "version must be a positive whole number, got None"),
    ("version", 1, "is of version 1, which is read no more; learn the model again"),
    ("version", 4, "is of version 4, which is read no more; learn the model again"),
    ("version", 6, "is of version 6, this program reads up to 5; update varishold"),
    ("format", "x", "is no model file, as write_model and the command learn make them"),
    ("clock", "s", "clock must be seconds or frames, got 's'; learn the model again"),
    ("position", 0, "position and absolute must be true or false"),
    ("absolute", None, "position and absolute must be true or false"),
    ("columns", "abc", "columns must be a list of texts"),
    ("columns", [1], "columns must be a list of texts"),
    ("remarks", ["a", None], "remarks must be a list of texts"),
    ("remarks", {"a": 1}, "remarks must be a list of texts"),
    ("pads", {"a": 1}, "pads must be a list of 1 to 64"),
    ("pads", [], "pads must be a list of 1 to 64"),
    ("pads", [[str(k), 2, 2] for k in range(65)], "pads must be a list of 1 to 64"),
    ("pads", [["a", 2, 2], ["a", 2, 2]], PADS),
    ("pads", [[1, 2, 2]], PADS),
    ("pads", [["a", 2]], PADS),
    ("pads", [["a", 2, 2, 2]], PADS),
    ("pads", [["a", 0, 2]], "rows and columns of pads must lie between 1 and 4096, got [0, 2]"),
    ("pads", [["a", 2, 4097]], "rows and columns of pads must lie between 1 and 4096, got [2, 4097]"),
    ("pads", [["a", 2.0, 2]], "rows and columns of pads must lie between 1 and 4096, got [2.0, 2]"),
    ("pads", [["a", True, 2]], "rows and columns of pads must lie between 1 and 4096, got [True, 2]"),
    ("sources", [], "sources must be touch, numbers"),
    ("sources/touch", {}, "sources: touch must have views of the powers 1, 2 or both"),
    ("sources/numbers", {"1": {}, "3": {}}, "sources: numbers must have views of the powers 1, 2 or both"),
    ("sources/numbers", [], "sources: numbers must have views of the powers 1, 2 or both"),
    ("sources/more", {}, "sources must be touch, numbers"),
    ("classes", np.array(["cup", "bar"]), "classes must be different and in order"),
    ("classes", np.array(["cup", "cup"]), "classes must be different and in order"),
    ("classes", np.array(["bar", "cup\nball 1.00"]), "classes must be lines of printable text, got 'cup\\nball 1.00'"),
    ("classes", np.array(["", "cup"]), "classes must be lines of printable text, got ''"),
    (
        "classes",
        np.array(["bar", "none of these"]),
        "no thing can be called 'none of these'",
    ),
    ("classes", np.array(["cup"]), "classes must be two or more texts or numbers, got <U3 of shape (1,)"),
    ("classes", np.array([["a", "b"]]), "classes must be two or more texts or numbers, got <U1 of shape (1, 2)"),
    ("classes", np.array([1j, 2j]), "classes must be two or more texts or numbers, got complex128 of shape (2,)"),
    ("classes", np.arange(100_001), "classes must be two or more texts or numbers, got int64 of shape (100001,)"),
    ("classes", np.array([1, 2, 3]), "landmark_codes must name each of 3 classes"),
    ("landmark_codes", np.array([0, 1, 1, 2]), "landmark_codes must name each of 2 classes"),
    ("landmark_codes", np.array([1, 1, 1, 1]), "landmark_codes must name each of 2 classes"),
    ("landmark_codes", np.array([0.0, 1, 1, 0]), "landmark_codes and places must be one whole number and one text"),
    ("landmark_codes", np.array([[0, 1]]), "landmark_codes and places must be one whole number and one text"),
    ("landmark_codes", np.array([0, 1, 0]), "landmark_codes and places must be one whole number and one text"),
    ("places", np.arange(4), "landmark_codes and places must be one whole number and one text"),
    ("known", np.empty(0), "known must hold at least one number"),
    ("error", 1.0, "error must lie between 0 and 1, got 1.0"),
    ("error", 0, "error must lie between 0 and 1, got 0.0"),
]


@pytest.mark.parametrize(("key", "value", "message"), WRONG)
def test_what_is_wrong_is_told(written: Path, tmp_path: Path, key: str, value: Any, message: str) -> None:
    with pytest.raises(FormatError) as told:
        read_model(changed(written, tmp_path / "m.npz", key, value))
    assert str(told.value).startswith(f"{tmp_path / 'm.npz'}: {message}")


def test_landmarks_are_not_without_number(written: Path, tmp_path: Path) -> None:
    arrays, about = opened(written)
    for n in (0, 100_001):
        arrays["landmark_codes"], arrays["places"] = np.arange(n) % 2, np.full(n, "p")
        write_archive({"about": np.array(json.dumps(about)), **arrays}, tmp_path / "m.npz", kind="model")
        with pytest.raises(FormatError, match="landmark_codes and places must be one whole number and one text"):
            read_model(tmp_path / "m.npz")


def test_sizes_at_their_limits_are_read(written: Path, tmp_path: Path) -> None:
    arrays, about = opened(written)
    about["pads"] = [["thumb", 4096, 1], ["palm", 1, 4096]]
    shapes = {name: (rows, cols) for name, rows, cols in about["pads"]}
    n = len(measure_names(MeasureSettings(shapes, 0, 1, "frames", 1, True, False)))
    for name in ("shift", "scale", "landmarks"):
        arrays[f"touch.{name}"] = arrays[f"touch.{name}"][..., :n]
    write_archive({"about": np.array(json.dumps(about)), **arrays}, tmp_path / "m.npz", kind="model")
    assert read_model(tmp_path / "m.npz").n_features_in_ == 8192
    with pytest.raises(FormatError, match=r"touch\.shift must be \d+ numbers"):
        read_model(changed(written, tmp_path / "m.npz", "pads", [[str(k), 2, 2] for k in range(64)]))


def test_texts_that_are_no_model_are_told(written: Path, tmp_path: Path) -> None:
    arrays, _ = opened(written)
    for about in ({}, {"about": np.array("[1]")}):
        write_archive({**about, **arrays}, tmp_path / "m.npz", kind="model")
        with pytest.raises(FormatError, match="is no model file, as write_model and the command learn make them"):
            read_model(tmp_path / "m.npz")


def test_what_cannot_be_written_is_told(tmp_path: Path) -> None:
    model = made()
    model.classes_ = np.array([object(), object()])
    with pytest.raises(InputError, match="labels must be text or numbers to be written, got object"):
        write_model(model, tmp_path / "m.npz")
    model = made()
    model.adapted_to_ = 5
    with pytest.raises(InputError, match="was adapted to one session; write the one that it comes from"):
        write_model(model, tmp_path / "m.npz")
    assert not (tmp_path / "m.npz").exists()
    for classes in ([False, True], [1, 2], [0.5, 1.5]):
        model = made()
        model.classes_ = np.array(classes)
        write_model(model, tmp_path / "n.npz")
        assert read_model(tmp_path / "n.npz").classes_.tolist() == classes
        (tmp_path / "n.npz").unlink()
