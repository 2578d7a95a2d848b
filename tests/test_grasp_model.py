"""The encoder, the model file, and the commands as a person would run them."""

from __future__ import annotations

import copy
import json
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from varishold.circuit import evaluate
from varishold.cli import main
from varishold.errors import FormatError, InputError
from varishold.grasp import (
    HyperplaneClassifier,
    ThresholdEncoder,
    describe_tables,
    fit_model,
    read_model,
    with_encoder,
    write_model,
)
from varishold.grasp.model import GraspModel
from varishold.recording import GraspTable, write_grasp_table


def switch_table(n: int = 20, switches: int = 10, seed: int = 0) -> GraspTable:
    rng = np.random.default_rng(seed)
    prototypes = rng.random((2, switches)) < 0.5
    kind = np.arange(n) % 2
    X = prototypes[kind] ^ (rng.random((n, switches)) < 0.1)
    cells: dict[str, Any] = {"object": np.array(["cone", "cube"])[kind]}
    cells |= {f"switch.s{k}": X[:, k] for k in range(switches)}
    cells["angle_rad.thumb"] = rng.normal(kind, 1.0)
    return GraspTable(cells)


def number_table(seed: int = 0) -> GraspTable:
    rng = np.random.default_rng(seed)
    kind = np.arange(40) % 2
    cells: dict[str, Any] = {"what": np.array(["soft", "hard"])[kind]}
    cells |= {f"force_n.f{k}": rng.normal(2.0 * kind, 1.0) for k in range(4)}
    return GraspTable(cells)


def as_json(model: GraspModel, folder: Path) -> dict[str, Any]:
    write_model(model, folder / "model.json")
    document: dict[str, Any] = json.loads((folder / "model.json").read_text())
    return document


@settings(max_examples=40)
@given(st.integers(0, 10_000), st.sampled_from(["quantile", "even", "supervised"]), st.booleans(), st.booleans())
def test_bits_fill_like_a_thermometer_and_the_circuit_compares_alike(
    seed: int, strategy: str, shared: bool, whole: bool
) -> None:
    rng = np.random.default_rng(seed)
    X = rng.normal(rng.normal(0, 100), 10.0 ** rng.integers(-6, 6), (30, 3))
    if whole:
        X = np.rint(X)
    y = rng.integers(0, 2, 30)
    encoder = ThresholdEncoder(strategy, levels=5, shared=shared).fit(X, y)  # type: ignore[arg-type]
    bits = encoder.transform(X)
    ends = np.cumsum(encoder.bits_per_channel_)
    for start, end in zip(ends - encoder.bits_per_channel_, ends, strict=True):
        assert (np.diff(bits[:, start:end].astype(int), axis=1) <= 0).all()
    counts = np.floor(X / encoder.resolution_)
    whole_thresholds = np.concatenate([t / s for t, s in zip(encoder.thresholds_, encoder.resolution_, strict=True)])
    np.testing.assert_array_equal(whole_thresholds, np.rint(whole_thresholds))
    channels = np.repeat(np.arange(3), encoder.bits_per_channel_)
    np.testing.assert_array_equal(counts[:, channels] >= whole_thresholds, bits)


def test_the_model_s_netlist_takes_counts() -> None:
    table = number_table()
    model = fit_model(table, label="what", columns="force_n.*", encode="even", mode="robust")
    assert model.encoder is not None
    values = table.matrix("force_n.*")
    counts = np.floor(values / model.encoder.resolution_).astype(np.int64)
    answers = np.array(model.netlist.classes)[evaluate(model.netlist, counts)]
    assert answers.tolist() == [answer.object for answer in model.answer(table)]
    assert with_encoder(model.classifier.netlist_, model.encoder, model.columns) == model.netlist
    assert len(model.counts) == 4


@pytest.mark.parametrize("mode", ["auto", "paper", "robust", "vote"])
def test_a_model_comes_back_from_its_file(mode: str, tmp_path: Path) -> None:
    table = switch_table()
    model = fit_model(table, label="object", mode=mode)
    assert model.columns == tuple(f"switch.s{k}" for k in range(10))
    write_model(model, tmp_path / "model.json")
    back = read_model(tmp_path / "model.json")
    assert back.netlist == model.netlist
    assert list(back.answer(table)) == list(model.answer(table))
    assert str(back.classifier.hyperplanes_) == str(model.classifier.hyperplanes_)
    assert str(back.classifier.explain([1] * 10)) == str(model.classifier.explain([1] * 10))
    assert describe_tables(back) == describe_tables(model)
    write_model(back, tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "model.json").read_bytes()


@pytest.mark.parametrize("encode", [None, "quantile"])
def test_an_answer_says_why_in_the_names_of_the_columns(encode: str | None) -> None:
    table, label = (switch_table(), "object") if encode is None else (number_table(), "what")
    model = fit_model(table, label=label, encode=encode)
    plain, told = list(model.answer(table)), list(model.answer(table, why=True))
    assert [replace(answer, why=()) for answer in told] == plain
    assert all("why" not in answer.to_dict() for answer in plain)
    first = model.classifier.explain(model.readings(table).switches[0])
    names = dict(zip((f"x{k + 1}" for k in range(len(model.switch_names))), model.switch_names, strict=True))
    # The same lines as in Python, but for the names.
    for line, numbered in zip(told[0].why, first.reasons(), strict=True):
        assert line == re.sub(r"\bx\d+\b", lambda x: names[x[0]], numbered)
    assert told[0].to_dict()["why"] == list(told[0].why)
    assert model.switch_names[0] == "s0" if encode is None else model.switch_names[0].startswith("force_n.f0>=")


@pytest.mark.parametrize("mode", ["paper", "robust", "vote"])
def test_a_model_comes_back_whose_grasps_contradict_each_other(mode: str, tmp_path: Path) -> None:
    clf = HyperplaneClassifier(mode).fit([[0, 1], [1, 0], [1, 0]], ["cone", "cube", "cube"])  # type: ignore[arg-type]
    planes = clf.hyperplanes_.weights
    clf.add_class([[0, 1]], "cube")
    np.testing.assert_array_equal(clf.hyperplanes_.weights, planes)
    write_model(GraspModel(("switch.a", "switch.b"), "object", None, clf), tmp_path / "model.json")
    back = read_model(tmp_path / "model.json").classifier
    assert back.predict([[1, 0], [0, 0]]).tolist() == clf.predict([[1, 0], [0, 0]]).tolist() == ["cube"] * 2
    assert back.remarks_ == clf.remarks_


def test_an_encoder_comes_back_too(tmp_path: Path) -> None:
    model = fit_model(number_table(), label="what", encode="quantile", levels=3)
    write_model(model, tmp_path / "model.json")
    back = read_model(tmp_path / "model.json")
    assert back.netlist == model.netlist
    assert list(back.answer(number_table(1))) == list(model.answer(number_table(1)))


def test_tables_are_printed_in_the_paper_s_form() -> None:
    text = describe_tables(fit_model(switch_table(), label="object", mode="paper"))
    for heading in ("Switches", "Hyperplanes", "Sign table", "Reduced sign table", "Circuit (mode paper)"):
        assert heading in text
    assert "cone = " in text
    wide = describe_tables(fit_model(switch_table(), label="object", mode="vote"))
    assert "too many to print" in wide


def damaged(document: dict[str, Any], name: str, value: Any) -> dict[str, Any]:
    return {**document, name: value}


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("format", "other", "is no model file, as write_model and 'varishold grasp fit' make them"),
        ("version", 4, "is of version 4, this program reads up to 3; update varishold"),
        ("version", "x", "version must be a positive whole number, got 'x'"),
        ("classes", ["one"], "classes must be two or more different names in order"),
        ("columns", "switch", "columns must be a list of texts"),
        ("columns", ["switch.a"] * 10, "columns must all differ"),
        ("grasps", ["01"], r"grasps\[0\] must be 10 characters 0 or 1"),
        ("labels", [7], "labels must be a list of whole numbers from 0 to 1"),
        ("labels", [0], "20 grasps need as many labels, got 1"),
        ("hyperplanes", [{"weights": [[99, 1]], "pair": [1, 2]}], "must weigh switches 0 to 9 by -1 or 1"),
        ("hyperplanes", {}, "hyperplanes must be a list"),
        ("hyperplanes", [], "netlist and hyperplanes do not belong together"),
        ("mode", "magic", "mode must be auto, paper, robust, vote, got 'magic'"),
        ("netlist", {}, "netlist"),
        ("netlist", None, "netlist"),
        ("encoder", {"strategy": "even"}, "'levels' is missing"),
        ("selection", [1], "fit the model again"),
        ("notes", 3, "fit the model again"),
        ("groups", [0], "groups must be a whole number from 0 on for each of 20 grasps"),
        ("groups", ["a"] * 20, "groups must be a whole number"),
        ("groups", [-1] * 20, "groups must be a whole number"),
        ("beyond", [-1.0] * 20, "beyond must be a number from 0 to 1e\\+100 for each of 20 grasps"),
        ("beyond", [1e308] * 20, "beyond must be a number from 0 to"),
        ("beyond", [[0.0]] * 20, "beyond must be a number"),
        ("beyond", ["x"] * 20, "fit the model again"),
        ("answers", [0], "answers must be those of 20 training grasps, got 1"),
        ("answers", [2] * 20, "answers must be a list of whole numbers from 0 to 1"),
        ("answers", [0] * 20, "netlist answers 'cube' to training grasp 1 .counted from 0., another than was learned"),
    ],
)
def test_a_damaged_model_file_is_told_in_one_line(field: str, value: Any, message: str, tmp_path: Path) -> None:
    document = as_json(fit_model(switch_table(), label="object", mode="paper"), tmp_path)
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(damaged(document, field, value)))
    with pytest.raises(FormatError, match=message) as caught:
        read_model(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def places_in(document: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return where the numbers, names and truths of a document stand."""
    if not isinstance(document, dict | list):
        return [path]
    items = document.items() if isinstance(document, dict) else enumerate(document)
    return [place for key, inner in items for place in places_in(inner, (*path, key))]


@pytest.fixture(scope="module")
def analog(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    model = fit_model(number_table(), label="what", encode="quantile", levels=3)
    return as_json(model, tmp_path_factory.mktemp("analog"))


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_no_number_and_no_name_of_a_file_can_be_another(
    tmp_path_factory: pytest.TempPathFactory, analog: dict[str, Any], data: st.DataObject
) -> None:
    path = tmp_path_factory.getbasetemp() / "changed.json"
    document = copy.deepcopy(analog)
    *outer, last = data.draw(st.sampled_from(places_in(document)))
    holder = document
    for key in outer:
        holder = holder[key]
    was = holder[last]
    holder[last] = was + "a" if isinstance(was, str) else (was or 0) + data.draw(st.sampled_from([1, -1, 0.5, 1e-9]))
    assume(holder[last] != was)
    path.write_text(json.dumps(document))
    with pytest.raises(FormatError):
        read_model(path)


def test_a_threshold_that_is_another_number_is_told(tmp_path: Path, analog: dict[str, Any]) -> None:
    path = tmp_path / "model.json"
    document = copy.deepcopy(analog)
    document["encoder"]["thresholds"][0][0] -= 0.25
    path.write_text(json.dumps(document))
    with pytest.raises(FormatError, match="was changed after it was written, by its checksum; fit the model again, or"):
        read_model(path)
    # On purpose; and as older programs wrote it.
    del document["checksum"]
    path.write_text(json.dumps(document))
    assert read_model(path).encoder is not None


def test_a_file_may_be_laid_out_anew(tmp_path: Path, analog: dict[str, Any]) -> None:
    path = tmp_path / "model.json"

    def whole(value: Any) -> Any:
        # As programs write numbers that tell no whole ones from others.
        if isinstance(value, dict):
            return {name: whole(inner) for name, inner in reversed(value.items())}
        if isinstance(value, list):
            return [whole(inner) for inner in value]
        return int(value) if isinstance(value, float) and value == int(value) else value

    path.write_text(json.dumps(whole(analog), indent=2))
    assert read_model(path).netlist == fit_model(number_table(), label="what", encode="quantile", levels=3).netlist


@pytest.mark.parametrize("mode", ["paper", "robust"])
def test_hyperplanes_units_and_terms_belong_together(mode: str, tmp_path: Path) -> None:
    document = as_json(fit_model(switch_table(), label="object", mode=mode), tmp_path)
    for change in (
        lambda d: d["hyperplanes"][0].update(weights=[]),
        lambda d: d["netlist"]["units"][0].update(weights=[]),
        lambda d: d["netlist"]["terms"].__setitem__(0, []),
    ):
        spoilt = copy.deepcopy(document)
        change(spoilt)
        (tmp_path / "bad.json").write_text(json.dumps(spoilt))
        with pytest.raises(FormatError, match="netlist and hyperplanes do not belong together"):
            read_model(tmp_path / "bad.json")


@pytest.mark.parametrize("mode", ["paper", "robust", "vote"])
@pytest.mark.parametrize("version", [1, 2, 3])
def test_a_netlist_answers_as_it_was_learned(mode: str, version: int, tmp_path: Path) -> None:
    document = as_json(fit_model(switch_table(), label="object", mode=mode), tmp_path)
    path = tmp_path / "bad.json"
    if version < 3:
        # An older file; its answers are known where its mode parts all grasps.
        document = {**document, "version": version}
        del document["answers"], document["checksum"]
    path.write_text(json.dumps(document))
    read_model(path)
    spoilt = [copy.deepcopy(document) for _ in range(2)]
    spoilt[0]["netlist"]["scores"].reverse()
    for term in spoilt[1]["netlist"]["terms"]:
        term[0][1] = 1 - term[0][1]
    for changed in spoilt if version == 3 or mode == "paper" else ():
        path.write_text(json.dumps(changed))
        with pytest.raises(FormatError, match=r"netlist answers '\w+' to training grasp \d+ .* not those that"):
            read_model(path)


def test_what_no_circuit_takes_is_refused_when_it_is_learned() -> None:
    cells = switch_table().cells
    long = "switch." + "x" * 5000
    with pytest.raises(
        InputError, match=r"t\.csv: column 'switch\.x+\.\.\.' has a name of 5007 characters; give it one"
    ):
        fit_model(GraspTable({**cells, long: cells["switch.s0"]}, "t.csv"), label="object")
    names = np.where(np.arange(20) == 3, "y" * 5000, cells["object"])
    with pytest.raises(InputError, match=r"t\.csv: line 5: its label has 5000 characters"):
        fit_model(GraspTable({**cells, "object": names}, "t.csv"), label="object")
    wild = np.where(np.arange(20) == 3, 1e308, 0.0)
    with pytest.raises(InputError, match=r"t\.csv: line 5, column 'n' must lie within 1e\+30 of zero to be cut"):
        fit_model(GraspTable({**cells, "n": wild}, "t.csv"), label="object", columns="n", encode="quantile")


def test_every_grasp_may_be_its_own_class() -> None:
    cells = {f"switch.s{k}": np.arange(24) >> k & 1 == 1 for k in range(5)}
    table = GraspTable({"object": np.array([f"o{k}" for k in range(24)]), **cells})
    assert len(fit_model(table, label="object").classifier.classes_) == 24


def test_every_missing_or_replaced_field_is_a_format_error(tmp_path: Path) -> None:
    document = as_json(fit_model(number_table(), label="what", mode="robust", encode="even"), tmp_path)
    path = tmp_path / "bad.json"
    for field in document:
        for value in (None, 0, -1, "x", [], {}, [[]], [None], {"a": 1}, 1e300, True):
            path.write_text(json.dumps(damaged(document, field, value)))
            message = ""
            try:
                read_model(path)
            except FormatError as error:
                message = str(error)
            assert "\n" not in message
        path.write_text(json.dumps({k: v for k, v in document.items() if k != field}))
        if field == "checksum":
            # Older programs write none.
            read_model(path)
            continue
        with pytest.raises(FormatError):
            read_model(path)


def test_truncated_and_foreign_files_are_format_errors(tmp_path: Path) -> None:
    document = as_json(fit_model(switch_table(), label="object"), tmp_path)
    text = json.dumps(document)
    path = tmp_path / "bad.json"
    for length in (0, 1, 40, len(text) // 2, len(text) - 1):
        path.write_text(text[:length])
        with pytest.raises(FormatError, match="is not complete JSON"):
            read_model(path)
    for content in (b"\xff\xfe\x00", b"\x80\x04K\x01.", b"[" * 100_000, b'{"format": NaN}', b"[]", b'"text"'):
        path.write_bytes(content)
        with pytest.raises(FormatError):
            read_model(path)
    with pytest.raises(InputError, match="no such file"):
        read_model(tmp_path / "absent.json")


def test_bad_tables_are_named() -> None:
    table = switch_table()
    with pytest.raises(InputError, match=r"no column 'name'"):
        fit_model(table, label="name")
    with pytest.raises(
        InputError, match=r"line 2, column 'angle_rad.thumb' must be 0 or 1, got .*cut numbers at thresholds"
    ):
        fit_model(table, label="object", columns="angle_rad.*")
    one = GraspTable({**table.cells, "object": np.array(["cone"] * 20)})
    with pytest.raises(InputError, match=r"column 'object' must name at least two classes, got only 'cone'"):
        fit_model(one, label="object")
    holes = GraspTable({**table.cells, "angle_rad.thumb": np.full(20, np.nan)})
    with pytest.raises(InputError, match=r"line 2, column 'angle_rad.thumb' is empty"):
        fit_model(holes, label="object", columns="angle_rad.*", encode="even")
    with pytest.raises(InputError, match="no column is left to learn from"):
        fit_model(GraspTable({"object": table.cells["object"]}), label="object")


@dataclass(frozen=True)
class Finished:
    """What a command left behind."""

    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Finished]:
    monkeypatch.chdir(tmp_path)

    def command(*words: str) -> Finished:
        monkeypatch.setattr(sys, "argv", ["varishold", "grasp", *words])
        status = 0
        try:
            main()
        except SystemExit as leaving:
            status = int(leaving.code or 0)
        return Finished(status, *capsys.readouterr())

    return command


def test_the_commands_from_table_to_source(tmp_path: Path, run: Callable[..., Finished]) -> None:
    write_grasp_table(switch_table(), tmp_path / "train.csv")
    write_grasp_table(switch_table(30, seed=0), tmp_path / "test.csv")
    fit = run("fit", "train.csv", "--label", "object", "--mode", "paper", "-o", "model.json")
    assert fit.returncode == 0, fit.stderr
    assert "20 grasps of 2 objects, 10 columns" in fit.stdout
    plain = run("predict", "model.json", "test.csv").stdout.splitlines()
    assert len(plain) == 30
    lines = [json.loads(line) for line in run("predict", "model.json", "test.csv", "--json").stdout.splitlines()]
    assert [line["row"] for line in lines] == list(range(30))
    assert [line["object"] + (" ?" if line["rejected"] else "") for line in lines] == plain
    assert "Sign table" in run("tables", "model.json").stdout
    exported = run("export", "model.json", "--to", "c", "-o", "source")
    assert exported.returncode == 0, exported.stderr
    assert (tmp_path / "source" / "model.c").is_file()
    for words in (
        ("fit", "train.csv", "--label", "name", "-o", "x.json"),
        ("fit", "absent.csv", "--label", "object", "-o", "x.json"),
        ("fit", "train.csv", "--label", "object", "-o", "no/such/folder/x.json"),
        ("predict", "train.csv", "test.csv"),
        ("predict", "model.json", "model.json"),
        ("tables", "absent.json"),
    ):
        bad = run(*words)
        assert (bad.returncode, bad.stderr.count("\n")) == (1, 1), bad.stderr
        assert "Traceback" not in bad.stderr
    assert run("fit", "train.csv").returncode == 2
    assert not (tmp_path / "x.json").exists()


def test_a_circuit_that_bears_noise_badly_is_told_by_its_mode(tmp_path: Path, run: Callable[..., Finished]) -> None:
    rng = np.random.default_rng(0)
    kind = np.repeat(np.arange(30), 4)
    switches = rng.random((30, 24))[kind] < 0.5
    switches ^= rng.random(switches.shape) < 0.05
    table = GraspTable({"object": kind.astype(np.str_), **{f"switch.v{k}": switches[:, k] for k in range(24)}})
    write_grasp_table(table, tmp_path / "t.csv")
    done = run("fit", "t.csv", "--label", "object", "--mode", "paper", "-o", "m.json")
    assert "note: mode 'paper' names " in done.stdout, done.stdout + done.stderr


def test_a_circuit_of_nothing_is_not_called_too_large(tmp_path: Path, run: Callable[..., Finished]) -> None:
    (tmp_path / "t.csv").write_text("object,switch.a\nx,1\ny,1\n")
    done = run("fit", "t.csv", "--label", "object", "-o", "m.json")
    assert "0 hyperplanes" in done.stdout
    assert "smaller circuit" not in done.stdout


@pytest.mark.parametrize("strategy", ["quantile", "even", "supervised"])
def test_encoder_refuses_values_whose_differences_overflow(strategy: Any) -> None:
    with pytest.raises(InputError, match=r"within 1e\+30 of zero, got 1e\+308 in row 0, channel 0"):
        ThresholdEncoder(strategy).fit([[1e308], [-1e308]], [0, 1])
    encoder = ThresholdEncoder(strategy).fit([[1e-320], [0.0]], [0, 1])
    assert (encoder.resolution_ > 0).all()


def test_label_may_be_a_switch_column() -> None:
    table = GraspTable({"switch.a": np.array(["x", "y"]), "switch.b": np.array([False, True])})
    assert fit_model(table, label="switch.a").columns == ("switch.b",)


def test_model_is_not_written_over_its_table(run: Callable[..., Finished], tmp_path: Path) -> None:
    path = tmp_path / "grasps.csv"
    write_grasp_table(switch_table(), path)
    before = path.read_bytes()
    finished = run("fit", str(path), "--label", "object", "-o", str(path))
    assert finished.returncode == 1
    assert "is read by this very call" in finished.stderr
    assert path.read_bytes() == before


def _too_many(document: dict[str, Any]) -> None:
    document.update(columns=[str(k) for k in range(20_000)], grasps=["0" * 20_000, "1" * 20_000], labels=[0, 1])
    document["hyperplanes"] = [{"weights": [], "pair": [0, 0]}] * 60_000


def _uncountable(document: dict[str, Any]) -> None:
    width = len(document["columns"])
    encoder = {"strategy": "even", "levels": 1, "resolution": [1.0] * width, "thresholds": [[1e300]] * width}
    document["encoder"] = encoder


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (_too_many, "more than any fit makes"),
        (_uncountable, "must fit 32 signed bits"),
        (lambda document: document.update(label={"a": 1}), "label must be the name of a column"),
    ],
)
def test_hostile_sizes_in_a_model_are_refused(tmp_path: Path, damage: Callable[[Any], None], message: str) -> None:
    path = tmp_path / "model.json"
    write_model(fit_model(switch_table(), label="object"), path)
    document = json.loads(path.read_text())
    damage(document)
    path.write_text(json.dumps(document))
    with pytest.raises(FormatError, match=message):
        read_model(path)


def test_an_encoder_of_too_many_levels_is_told_in_one_line(tmp_path: Path) -> None:
    document = as_json(fit_model(number_table(), label="what", encode="even"), tmp_path)
    path = tmp_path / "bad.json"
    for levels in (0, 1025, 10**400):
        path.write_text(json.dumps(damaged(document, "encoder", {**document["encoder"], "levels": levels})))
        with pytest.raises(FormatError, match="the encoder's levels must lie between 1 and 1024"):
            read_model(path)
