"""A name that another thing has as well: where the narrower one is not sure, the answer is what is true of both."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from varishold.errors import FormatError, InputError
from varishold.files import open_archive, write_archive
from varishold.perceive import Evidence, Library, Perceiver, read_library, shipped_library, write_library

MIDDLES = {"pillar": -0.6, "box": 0.6, "ball": 9.0}


@cache
def library() -> Library:
    rng = np.random.default_rng(4)
    examples = {
        name: [[Evidence("grasp", {"a": middle + rng.normal(), "b": rng.normal()})] for _ in range(60)]
        for name, middle in MIDDLES.items()
    }
    poses = {name: ["lying", "upright"] * 30 for name in MIDDLES}
    return Library.from_examples(examples, sizes_m={"box": [0.05] * 60, "pillar": [0.09] * 60}, poses=poses)


def felt(of: Library, a: float, *, pose: str = "lying", refuse: bool = False) -> Perceiver:
    perceiver = Perceiver(of, pose=pose, most_touches=1, refuse=refuse)
    perceiver.feel(Evidence("grasp", {"a": a, "b": 0.0}))
    return perceiver


def test_what_is_perhaps_the_narrower_and_surely_one_of_both_has_the_wider_name() -> None:
    wide = library().with_wider("pillar", "box", pose="lying")
    plain, answer = felt(library(), -0.4).answer(), felt(wide, -0.4).answer()
    assert plain.object == "pillar"
    assert plain.probability < 0.9
    assert answer.object == "box"
    assert answer.probability == pytest.approx(plain.probability + plain.alternatives["box"], abs=1e-9)
    assert answer.alternatives["pillar"] == plain.probability
    # Its size is a box's, which all examples have in common.
    assert answer.size_m is not None
    assert plain.size_m is not None
    assert answer.size_m < 0.07 < plain.size_m
    last = answer.trace[-1]
    assert next(iter(last.probability)) == "pillar"
    assert f"box with probability {answer.probability:.2f}, perhaps a pillar ({plain.probability:.2f})" in last.why


def test_a_sure_narrower_name_a_likelier_wider_one_and_another_pose_stay() -> None:
    wide = library().with_wider("pillar", "box", pose="lying")
    for a, pose in ((-3.5, "lying"), (0.8, "lying"), (9.0, "lying"), (-0.4, "upright")):
        plain, answer = felt(library(), a, pose=pose).answer(), felt(wide, a, pose=pose).answer()
        assert (answer.object, answer.probability) == (plain.object, plain.probability)
    always = felt(library().with_wider("pillar", "box"), -0.4, pose="upright").answer()
    assert always.object == "box"


def test_what_is_outside_of_all_that_is_known_is_no_surer_under_a_wider_name() -> None:
    wide = library().with_wider("pillar", "box")
    perceiver = felt(wide, -0.4)
    perceiver.feel(Evidence("grasp", {"a": -0.4, "b": 40.0}))
    assert perceiver.belief.inside <= 1
    assert perceiver.answer().probability <= 0.9


def test_files_and_parts_of_a_library_keep_it(tmp_path: Path) -> None:
    wide = library().with_wider("pillar", "box", pose="lying").with_wider("box", "ball")
    write_library(wide, tmp_path / "wide.npz")
    assert wide.wider == {("pillar", "lying"): "box", ("box", None): "ball"}
    assert read_library(tmp_path / "wide.npz").wider == wide.wider
    assert wide.only(["box", "pillar"]).wider == {("pillar", "lying"): "box"}
    assert wide.in_pose("lying").wider == wide.wider
    assert library().wider == shipped_library().wider == {}


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda of: of.with_wider("egg", "box"), "the library has no 'egg'"),
        (lambda of: of.with_wider("box", "egg"), "the library has no 'egg'; it knows pillar, box, ball"),
        (lambda of: of.with_wider("box", "box"), "'box' cannot be wider than itself"),
        (lambda of: of.with_wider("pillar", "box", pose="tilted"), "felt 'tilted'; it tells lying, upright"),
    ],
)
def test_what_a_library_does_not_know_is_refused(make: Callable[[Library], Library], told: str) -> None:
    with pytest.raises(InputError, match=told):
        make(library())


@pytest.mark.parametrize("wider", ['[["egg", null, "box"]]', "[[1, 2]]", "3", '[["pillar", [], "box"]]', '{"a": 1}'])
def test_a_file_that_tells_it_wrongly_is_damaged(tmp_path: Path, wider: str) -> None:
    write_library(library().with_wider("pillar", "box"), tmp_path / "of.npz")
    with open_archive(tmp_path / "of.npz") as data:
        arrays = {name: data.array(name) for name in data.names if name != "head"}
        head = data.text("head").replace('[["pillar", null, "box"]]', wider)
    write_archive(arrays | {"head": np.array(head)}, tmp_path / "bad.npz", kind="library")
    with pytest.raises(FormatError, match="is no library, or it is damaged"):
        read_library(tmp_path / "bad.npz")


def test_a_pillar_that_lies_is_a_box_to_the_shipped_library() -> None:
    assert shipped_library("lying").wider == {("square-pillar", "lying"): "box"}
