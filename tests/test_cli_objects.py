"""``varishold objects`` and ``perceive MESH``: what they say, write and refuse, and that a stop loses nothing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
pytest.importorskip("trimesh", reason="trimesh is not installed; pip install -e '.[meshes]'")
pytest.importorskip("coacd", reason="coacd is not installed; pip install -e '.[meshes]'")
pytest.importorskip("networkx")

import trimesh

from varishold.exploration import feel_examples, kept_beside, mesh_to_grip
from varishold.files import KINDS
from varishold.perceive import Evidence, Library, library_file, read_library, shipped_library, write_library

pytestmark = pytest.mark.skipif(not library_file._SHIPPED.is_file(), reason="no library of objects is shipped")
ADD = ("--examples", "2", "--workers", "1")


@pytest.fixture
def brick(tmp_path: Path) -> Path:
    trimesh.creation.box((80, 50, 60)).export(tmp_path / "brick.stl")
    return tmp_path / "brick.stl"


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A library of two objects, which is quick to grow."""
    write_library(shipped_library().only(["sphere", "box"]), tmp_path / "small.npz")
    return tmp_path / "small.npz"


def test_a_mesh_is_added_listed_shown_and_perceived(run: Any, brick: Path, small: Path, tmp_path: Path) -> None:
    before = small.read_bytes()
    (tmp_path / "again.npz").write_bytes(before)
    status, said, told = run("objects", "add", brick, "--size-m", "0.08", "--library", "small.npz", *ADD, "--json")
    assert (status, told) == (0, "")
    line = json.loads(said)
    assert (line["object"], line["examples"] + line["missed"], line["parts"], line["objects"]) == ("brick", 2, 1, 3)
    assert line["size_m"] == pytest.approx(0.08)
    np.testing.assert_allclose(line["extents_m"], (0.08, 0.05, 0.06), atol=1e-6)
    assert not list(tmp_path.glob("*.felt"))
    assert KINDS["library"].recognizes(small)

    # The same after a stop, and by processes of their own.
    thing = mesh_to_grip(brick, size_m=0.08)
    feel_examples(thing, examples=1, processes=1, keep=kept_beside("again.npz", thing, seed=0))
    assert len(list(tmp_path.glob("again.npz.felt/*"))) == 1
    status, said, _ = run("objects", "add", brick, "--size-m", "0.08", "--library", "again.npz", *ADD)
    assert status == 0
    assert said.splitlines()[0].startswith("brick: 80 x 50 x 60 mm, 1 convex part, felt")
    assert said.splitlines()[1] == "again.npz: 3 objects"
    assert (tmp_path / "again.npz").read_bytes() == small.read_bytes()
    assert not list(tmp_path.glob("*.felt"))
    # What it felt of another size is told, and kept.
    other, thing = tmp_path / "other.npz", mesh_to_grip(brick, size_m=0.09)
    other.write_bytes(before)
    feel_examples(thing, examples=1, processes=1, keep=kept_beside(other, thing, seed=0))
    status, _, told = run("objects", "add", brick, "--size-m", "0.08", "--library", "other.npz", *ADD)
    assert status == 0
    kept = "varishold: note: other.npz.felt keeps what stopped calls with other options felt; remove it, or repeat them"
    assert kept in told.splitlines()
    assert kept_beside(other, thing, seed=0).is_file()

    status, said, _ = run("objects", "list", "--library", "small.npz", "--json")
    rows = [json.loads(line) for line in said.splitlines()]
    assert [row["object"] for row in rows] == ["sphere", "box", "brick"]
    assert rows[2]["sizes_m"] == pytest.approx([0.08, 0.08])
    assert "brick" in run("objects", "list", "--library", "small.npz")[1].splitlines()[2]
    status, said, _ = run("objects", "show", "brick", "--library", "small.npz", "--json")
    shown = json.loads(said)
    assert shown["examples"] == rows[2]["examples"]
    assert set(shown["touches"]) == set(shipped_library().touches)
    for touch in shown["touches"].values():
        assert 0 <= touch["made"] + touch["failed"] <= shown["examples"]
        assert touch["power"] is None or 0 <= touch["power"] <= 1
    assert "squeeze" in run("objects", "show", "brick", "--library", "small.npz")[1]

    # Known by now.
    status, _, told = run("objects", "add", brick, "--size-m", "0.08", "--library", "small.npz", *ADD)
    assert status == 1
    assert "knows an object called 'brick' already; give another name (--name)" in told

    status, said, _ = run(
        "perceive", brick, "--size-m", "0.08", "--library", "small.npz", "--most-touches", "1", "--json"
    )
    answer = json.loads(said.splitlines()[-1])
    assert status == 0
    assert (answer["true_object"], answer["true_size_m"]) == ("brick", pytest.approx(0.08))
    assert answer["right"] in (True, False)


def test_the_library_begins_as_the_shipped_one_which_is_never_written(
    run: Any, brick: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("varishold.exploration.feel_examples", made_up)
    before = library_file._SHIPPED.read_bytes()
    status, said, _ = run("objects", "add", brick, "--name", "block", "--size-m", "0.08", "--library", "mine.npz", *ADD)
    assert status == 0, said
    known = shipped_library()
    grown = read_library(tmp_path / "mine.npz")
    assert grown.objects == (*known.objects, "block")
    assert len(grown) == len(known) + 2
    status, _, told = run("objects", "add", brick, "--size-m", "0.08", "--library", library_file._SHIPPED, "--force")
    assert status == 1
    assert "is the shipped library, which is never written" in told
    assert library_file._SHIPPED.read_bytes() == before


def made_up(thing: Any, *, examples: int, **how: Any) -> list[list[Evidence]]:
    """Examples without a simulation."""
    model = shipped_library().touches["grasp"]
    values = dict(zip(model.metric.names, model.metric.shift.tolist(), strict=True))
    for _ in range(examples):
        how["progress"]()
    return [[Evidence("grasp", values)] for _ in range(examples)]


@pytest.mark.parametrize(
    ("count", "alike", "notes"),
    [
        (20, {}, []),
        (19, {"box": 9}, []),
        (18, {}, ["one in 19 touches of it will be stranger than the 18 it was felt by, and refused"]),
        (
            20,
            {"box": 11, "sphere": 3},
            ["before it was added 11 of 20 were taken for box: each may be taken for the other now"],
        ),
    ],
)
def test_what_is_like_a_known_object_or_felt_too_rarely_is_told(
    run: Any, brick: Path, small: Path, monkeypatch: pytest.MonkeyPatch, count: int, alike: Any, notes: list[str]
) -> None:
    monkeypatch.setattr("varishold.exploration.feel_examples", made_up)
    monkeypatch.setattr("varishold.perceive.likeness.taken_for", lambda *_: alike)
    words = ("objects", "add", brick, "--size-m", "0.08", "--library", small, "--examples", str(count))
    told = run(*words)[2]
    assert told.splitlines() == [f"varishold: note: brick: {note}" for note in notes]
    line = json.loads(run(*words, "--name", "other", "--json")[1])
    assert (line["taken_for"], line["remarks"]) == (alike, notes)


def test_several_meshes_are_added_each_by_its_name(
    run: Any, brick: Path, small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("varishold.exploration.feel_examples", made_up)
    trimesh.creation.icosphere(radius=0.03).export(tmp_path / "ball.ply")
    words = ("objects", "add", brick, "ball.ply", "--library", "small.npz", "--size-m", "0.07", *ADD)
    for more, said in (
        (("--name", "one"), "2 meshes need as many names, got 1 (--name)"),
        (("--name", "one", "--name", "one"), "two meshes are called 'one'"),
        (("--name", "one", "--name", "box"), "knows an object called 'box' already"),
        (("--name", "one", "--name", "a\x1b[0m"), "printable characters"),
    ):
        status, _, told = run(*words, *more)
        assert status == 1
        assert said in told
        assert told.count("\n") == 1
    assert run(*words)[0] == 0
    assert read_library(small).objects == ("sphere", "box", "brick", "ball")


def test_bad_input_is_told_in_a_line_and_writes_nothing(run: Any, brick: Path, small: Path, tmp_path: Path) -> None:
    (tmp_path / "notes.npz").write_bytes(b"PK my own notes")
    np.savez(tmp_path / "other.npz", owner=np.zeros(3))
    trimesh.creation.box((0.08, 0.05, 0.06)).export(tmp_path / "small box.stl")
    for words, said in (
        ((brick, "--library", "new.npz"), "look like millimetres: give 0.08 (--size-m)"),
        ((brick, "--library", "new.npz", "--size-m", "0.5"), "must lie in [0.035, 0.125] m"),
        (("none.stl", "--library", "new.npz"), "there is no such file"),
        (("small.npz", "--library", "new.npz"), "is no mesh by its name"),
        (("small box.stl", "--library", "notes.npz"), "is no library of objects; name another file"),
        (("small box.stl", "--library", "other.npz"), "is no library of objects; name another file"),
        (("small box.stl", "--library", brick), "is no library of objects"),
        (("small box.stl", "--library", "small box.stl"), "is read by this very call"),
        (("small box.stl", "--library", "no/folder.npz"), "there is no folder"),
    ):
        status, out, told = run("objects", "add", *words)
        assert (status, out) == (1, ""), words
        assert said in told, words
        assert told.count("\n") == 1, told
    assert (tmp_path / "notes.npz").read_bytes() == b"PK my own notes"
    for words, said in (
        (("list", "--library", "notes.npz"), "notes.npz"),
        (("show", "mug", "--library", "small.npz"), "the library has no 'mug'; it knows sphere, box"),
        (("show", "mug", "--library", "none.npz"), "there is no such file"),
    ):
        status, _, told = run("objects", *words)
        assert status == 1
        assert said in told
    assert not (tmp_path / "new.npz").exists()


def test_perceive_says_what_a_mesh_and_a_name_need(run: Any, brick: Path) -> None:
    for words, status, said in (
        ((brick,), 1, "look like millimetres: give 0.08 (--size-m)"),
        (("cylinder",), 2, "--size-m"),
        (("cylinder", "--size-m", "0.07", "--name", "mug"), 1, "--name says what a mesh is"),
        (("none.stl", "--size-m", "0.07"), 1, "there is no such file"),
    ):
        got, _, told = run("perceive", *words)
        assert got == status, told
        assert said in told


def test_what_was_mended_is_told(run: Any, small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.exploration.feel_examples", made_up)
    box = trimesh.creation.box((0.08, 0.05, 0.06))
    box.update_faces(np.arange(len(box.faces)) != 3)
    box.export(tmp_path / "open.stl")
    status, _, told = run("objects", "add", "open.stl", "--library", "small.npz", *ADD)
    assert (status, told.splitlines()[0]) == (0, "note: open.stl: holes of the mesh were closed with 1 triangle")


def test_a_library_of_unknown_sizes_is_listed(run: Any, tmp_path: Path) -> None:
    made = Library.from_examples({"a": [[Evidence("grasp", {"x": 0.1 * k})] for k in range(4)]})
    write_library(made, tmp_path / "a.npz")
    assert run("objects", "list", "--library", "a.npz")[1] == "a      4 examples  size unknown\n"


@pytest.mark.parametrize(("words", "wanted"), [((), 30), (("--lumps", "0"), 0), (("--lumps", "70"), 70)])
def test_as_many_lumps_as_are_asked_for_are_felt(
    run: Any, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], wanted: int
) -> None:
    asked: list[dict[str, Any]] = []

    def felt(setting: Any, **options: Any) -> Library:
        asked.append(options)
        return shipped_library().only(["sphere", "box"])

    monkeypatch.setattr("varishold.exploration.hand_library.feel_library", felt)
    status, said, _ = run("objects", "feel", "--examples", "30", *words, "-o", "own.npz", "--json")
    assert (status, json.loads(said)["library"]) == (0, "own.npz")
    assert [(options["examples"], options["lumps"]) for options in asked] == [(30, wanted)]
