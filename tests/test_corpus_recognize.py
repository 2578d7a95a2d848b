"""A table of presses: the rows are what a model says of each recording by itself, whoever answers in which pieces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from tests.pressed_things import recording

from varishold.corpus import AskRecognize, run_corpus, survey
from varishold.corpus.content import content_digest
from varishold.errors import InputError
from varishold.learning import TactileClassifier, read_model, write_model
from varishold.recording import Pad, Recording, read, write
from varishold.touch.course.presses import cut_presses

THINGS = ["disc", "bar", "ring"]


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "things.npz"
    learned = recording(THINGS * 6, 1)
    write_model(TactileClassifier().fit(cut_presses(learned), learned.presses.columns["thing"]), path)
    return path


def of_an_hour(seed: int) -> Recording:
    """Presses with a clock, a taxel that is stuck and one that is known to be broken."""
    made = recording(THINGS * 4, seed)
    frames = np.array(made.pads["pad"].frames)
    frames[:, 2, 3] = 40.0
    valid = np.ones(frames.shape[1:], np.bool_)
    valid[7, 7] = False
    return replace(made, pads={"pad": Pad(frames, valid=valid)}, time_s=np.arange(len(frames)) / 50)


@pytest.mark.parametrize(("cut", "workers"), [(4096, 1), (7, 1), (20, 1), (20, 2)])
def test_rows_are_what_the_model_says_of_each_recording(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cut: int, workers: int
) -> None:
    monkeypatch.setattr(survey, "_FRAMES", cut)
    files = [str(tmp_path / f"r{seed}.npz") for seed in (2, 3)]
    for seed, file in zip((2, 3), files, strict=True):
        write(of_an_hour(seed), file)
    found = run_corpus(files, AskRecognize.of_model(str(model)), tmp_path / "t.parquet", workers=workers)
    rows = pq.read_table(tmp_path / "t.parquet").to_pylist()
    learned = read_model(model)
    expected = [
        (file, k, answer) for file in files for k, answer in enumerate(learned.explain(cut_presses(read(file))))
    ]
    assert found.n_rows == len(rows) == len(expected) == 24
    for row, (file, number, answer) in zip(rows, expected, strict=True):
        told = answer.to_dict()
        assert (row["file"], row["press"]) == (file, number)
        for key in ("label", "probability", "p_value", "refused"):
            assert row[key] == told[key]
        shares = {each["name"]: each["probability"] for each in row["probabilities"]}
        assert shares == {told["label"]: told["probability"], **told["alternatives"]}
        assert [each.split()[0] for each in row["reasons"]] == [each["measure"] for each in told["reasons"]]
        assert (row["nearest"], row["nearest_label"]) == tuple(told["nearest"].values())
        assert (row["frame_first"], row["frame_last"]) == (7 * number, 7 * number + 6)
        assert row["time_s"] == pytest.approx(7 * number / 50)


def test_a_press_out_of_its_own_frames_is_the_one_out_of_all() -> None:
    from varishold.touch.course.presses import find_presses

    whole = of_an_hour(5)
    found, expected = find_presses(whole), cut_presses(whole)
    for number, (begin, stop) in enumerate(found.spans):
        first, last = max(begin - 3, 0), min(stop + 2, whole.n_frames)
        pads = {"pad": Pad(whole.pads["pad"].frames[first:last])}
        assert whole.time_s is not None
        own = found.cut(number, Recording(pads, whole.time_s[first:last]), first)
        np.testing.assert_array_equal(own.pads["pad"], expected[number].pads["pad"])
        assert own.time_s is not None
        np.testing.assert_array_equal(own.time_s, expected[number].time_s)


def test_the_command_writes_presses_and_says_so(model: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    write(of_an_hour(2), tmp_path / "a.npz")
    told = run("recognize", model, "a.npz", "-o", "t.parquet", "--workers", 1)
    assert told == (0, "t.parquet: 12 presses in 84 frames of 1 recording\n", "")
    for words, wrong in (
        (("-o", "u.parquet", "--adapt"), "--adapt needs all presses at once: leave out -o"),
        (("--workers", 2), "--workers is for tables: name one with -o, or leave it out"),
        (("-o", "a.npz"), "is read by this very call"),
    ):
        status, out, err = run("recognize", model, "a.npz", *words)
        assert (status, out, err.count("\n")) == (1, "", 1)
        assert wrong in err
    assert run("recognize", "a.npz", "a.npz", "-o", "u.parquet")[0] == 1
    assert not (tmp_path / "u.parquet").exists()


def test_a_model_that_was_changed_meanwhile_answers_nothing(model: Path, tmp_path: Path) -> None:
    write(of_an_hour(2), tmp_path / "a.npz")
    asked = AskRecognize(str(model), content_digest(str(tmp_path / "a.npz")))
    with pytest.raises(InputError, match="was changed while it was being asked; run again"):
        run_corpus([str(tmp_path / "a.npz")], asked, tmp_path / "t.parquet")


def test_the_columns_are_those_of_the_documents() -> None:
    page = (Path(__file__).parents[1] / "docs" / "corpora.md").read_text("utf-8")
    for column in AskRecognize("", "").columns:
        assert f"| `{column.name}` | {column.said_as} | {column.meaning} |" in page
