"""What lies on a side: how a solid is laid down, set up before the hand, kept in a library by its pose, and told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.perceive_lying import KINDS
from varishold.cli.app import app
from varishold.errors import FormatError, InputError
from varishold.hand import OBJECTS
from varishold.hand.objects import STRANGERS, laid_to_grip, right_names
from varishold.perceive import Evidence, Library, Perceiver, read_library, shipped_library, write_library
from varishold.perceive.belief import Belief
from varishold.solids import Box, Cone, Cylinder, Sphere, SquarePillar, Torus, lay_down

HAVE_A_SIDE = (*KINDS, "half-cylinder", "l-block")


def extents(solid: Any) -> np.ndarray:
    ends = [(np.array(p.centre_m) - p.half_m, np.array(p.centre_m) + p.half_m) for p in solid.body()]
    low, high = np.min([a for a, _ in ends], axis=0), np.max([b for _, b in ends], axis=0)
    return np.asarray(high - low)


@pytest.mark.parametrize("name", HAVE_A_SIDE)
@settings(max_examples=8, deadline=None)
@given(size_m=st.floats(0.035, 0.125), roll_rad=st.floats(-np.pi, np.pi))
def test_what_is_laid_down_rests_on_a_side(name: str, size_m: float, roll_rad: float) -> None:
    upright = {**OBJECTS, **STRANGERS}[name].to_grip(size_m)
    lying = lay_down(upright, roll_rad)
    assert lying.top_m == pytest.approx(extents(lying)[2])
    # The middle of what it covers is the origin, and it lies on the table.
    ends = np.array([part.centre_m for part in lying.body()]), np.array([part.half_m for part in lying.body()])
    low, high = (ends[0] - ends[1]).min(axis=0), (ends[0] + ends[1]).max(axis=0)
    np.testing.assert_allclose(low, (*-high[:2], 0.0), atol=1e-12)
    corners = np.vstack([corners_of(part) for part in lying.body()])
    foot = corners[corners[:, 2] < 1e-6]
    # It stands on more than a point, and is no longer than it was tall and broad together.
    assert np.ptp(foot, axis=0).max() > 0.3 * size_m
    assert extents(lying).max() <= np.linalg.norm(extents(upright)) + 1e-9
    # It is the same body: nothing is farther apart than before.
    before = np.vstack([corners_of(part) for part in upright.body()])
    assert np.ptp(corners, axis=0).max() <= spread(before) * 1.01


def corners_of(part: Any) -> np.ndarray:
    if part.corners_m:
        return np.array(part.corners_m)
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    return np.asarray(signs * np.array(part.half_m) + np.array(part.centre_m))


def spread(points: np.ndarray) -> float:
    return float(np.linalg.norm(points[:, None] - points[None, :], axis=-1).max())


def test_a_box_lies_on_the_side_that_it_is_rolled_to() -> None:
    box = Box(0.09, 0.05, 0.12)
    np.testing.assert_allclose(extents(lay_down(box)), (0.12, 0.05, 0.09))
    np.testing.assert_allclose(extents(lay_down(box, np.pi / 2)), (0.12, 0.09, 0.05))
    assert [part.kind for part in lay_down(box).body()] == ["box"]


def test_a_lying_cylinder_is_as_high_as_it_is_thick_and_rolls() -> None:
    lying = lay_down(Cylinder(0.06, 0.1), 0.7)
    np.testing.assert_allclose(extents(lying), (0.1, 0.06, 0.06), rtol=2e-3)
    assert lying.rolls
    assert not lay_down(SquarePillar(0.06, 0.1)).rolls
    # A cone rests on a line of its mantle: its tip is down, its base leans.
    cone = lay_down(Cone(0.06, 0.12))
    tip = min((corner for part in cone.body() for corner in part.corners_m), key=lambda corner: corner[0])
    far = max((corner for part in cone.body() for corner in part.corners_m), key=lambda corner: corner[0])
    assert min(tip[2], far[2]) < 0.02
    assert cone.top_m < 0.06


@pytest.mark.parametrize("solid", [Sphere.to_grip(0.06), Torus.to_grip(0.06)])
def test_what_has_no_side_is_refused(solid: Any) -> None:
    with pytest.raises(InputError, match=f"a {solid.name} has no side that it would rest on|to lie on"):
        lay_down(solid)
    with pytest.raises(InputError, match="has no side"):
        laid_to_grip(solid.name, 0.06, seed=1)


def test_proportions_belong_to_the_seed_and_are_one_to_three() -> None:
    one, same, other = (laid_to_grip("box", 0.05, seed=seed) for seed in (3, 3, 4))
    assert one == same != other
    lengths = np.array([extents(laid_to_grip("box", 0.05, seed=seed)) for seed in range(40)]) / 0.05
    assert lengths.min() == pytest.approx(1.0)
    assert 2.5 < lengths.max() <= 3.0 + 1e-9
    longest = max(extents(laid_to_grip("cylinder", 0.12, seed=seed)).max() for seed in range(20))
    assert 0.12 <= longest <= 0.2 + 1e-9


def test_what_lies_alike_has_two_right_names() -> None:
    assert right_names("square-pillar", 0.05, seed=1, pose="lying") == ("square-pillar", "box")
    assert right_names("square-pillar", 0.05, seed=1, pose="upright") == ("square-pillar",)
    assert right_names("cone", 0.05, seed=1, pose="lying") == ("cone",)
    both = [right_names("box", 0.05, seed=seed, pose="lying") for seed in range(40)]
    assert {names[1:] for names in both} == {(), ("square-pillar",)}


def test_the_command_says_what_cannot_lie() -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
    result = CliRunner().invoke(app, ["perceive", "sphere", "--size-m", "0.06", "--lying"])
    assert result.exit_code == 1
    assert str(result.exception) == "a sphere has no side to lie on: it is as it stands"
    assert not result.output


def test_the_command_says_that_a_library_knows_nothing_that_lies(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
    write_library(shipped_library().only(["box", "cone"]), tmp_path / "two.npz")
    own = ["--library", str(tmp_path / "two.npz")]
    result = CliRunner().invoke(app, ["perceive", "box", "--size-m", "0.06", "--lying", "--most-touches", "1", *own])
    assert result.exit_code == 0
    assert "note: the library was felt of things that stand" in result.stderr + capsys.readouterr().err


def example(*values: float, seed: int = 0) -> list[Evidence]:
    return [Evidence("grip", {f"n{k}": value for k, value in enumerate(values)})]


def made(n: int = 20, **more: Any) -> Library:
    rng = np.random.default_rng(5)

    def rows(x: float, y: float) -> list[list[Evidence]]:
        return [example(x + a, y + b) for a, b in rng.normal(0, 0.1, (n, 2))]

    # Numbers farther than six units of what stands are told as six.
    standing, lying = {"can": (0.0, 0.0), "brick": (4.0, 0.0)}, {"can": (0.0, 1.0), "brick": (4.0, 1.0)}
    return Library.from_examples(
        {name: [*rows(*standing[name]), *rows(*lying[name])] for name in standing},
        poses={name: ["upright"] * n + ["lying"] * n for name in standing},
        **more,
    )


def test_a_library_judges_an_object_in_each_pose_by_itself(tmp_path: Path) -> None:
    library = made()
    assert library.objects == ("can", "brick")
    assert library.pose_of_kind == ("upright", "lying", "upright", "lying")
    assert library.counts.tolist() == [20, 20, 20, 20]
    assert library.object_of_kind.tolist() == [0, 0, 1, 1]
    # Before any touch objects are alike, and so are an object's poses.
    assert Belief.before(library).probability == pytest.approx({"can": 0.5, "brick": 0.5})
    for x, name in ((0.0, "can"), (4.0, "brick")):
        for y, pose in ((0.0, "upright"), (1.0, "lying")):
            perceiver = Perceiver(library)
            perceiver.feel(example(x, y)[0])
            answer = perceiver.answer()
            assert (answer.object, answer.pose) == (name, pose)
    # Between two poses nothing was ever felt.
    perceiver = Perceiver(library, most_touches=2)
    perceiver.feel(example(0.0, 0.5)[0])
    assert perceiver.belief.p_value < 0.1
    write_library(library, tmp_path / "kept.npz")
    back = read_library(tmp_path / "kept.npz")
    assert back.poses == library.poses
    np.testing.assert_array_equal(back.pose, library.pose)
    assert read_library(tmp_path / "kept.npz").only(["brick"]).pose_of_kind == ("upright", "lying")


def test_what_is_known_to_lie_is_compared_with_what_lay() -> None:
    library = made()
    lying = library.in_pose("lying")
    assert lying.objects == library.objects
    assert lying.pose_of_kind == ("lying", "lying")
    rows = np.tile(np.arange(40) >= 20, 2)
    for touch, model in lying.touches.items():
        np.testing.assert_array_equal(model.values, library.touches[touch].values[rows])
        np.testing.assert_array_equal(model.scores, library.touches[touch].scores[rows])
    with pytest.raises(InputError, match="the library knows nothing that was felt 'leaning'; it tells upright, lying"):
        library.in_pose("leaning")
    with pytest.raises(InputError, match="it tells no pose"):
        Library.from_examples({"can": [example(0.0), example(1.0)]}).in_pose("lying")
    # What feels as a standing brick does is no lying brick.
    perceiver = Perceiver(library, pose="lying", most_touches=2)
    perceiver.feel(example(4.0, 0.0)[0])
    assert perceiver.belief.atypical
    perceiver.forget(pose="upright")
    perceiver.feel(example(4.0, 0.0)[0])
    assert (perceiver.answer().object, perceiver.answer().pose) == ("brick", "upright")
    # Of the next one nothing else is said.
    perceiver.forget()
    assert perceiver.library.pose_of_kind == ("lying", "lying")
    assert len(Perceiver(library).library) == len(library)
    # A library that tells no such pose counts as it is.
    perceiver.forget(pose="leaning")
    assert len(perceiver.library) == len(library)


def test_what_never_lay_is_known_as_it_stood() -> None:
    rng = np.random.default_rng(3)
    rows = [example(*row) for row in rng.normal(0, 0.1, (6, 2))]
    poses = {"ball": ["upright"] * 6, "can": ["upright"] * 3 + ["lying"] * 3}
    library = Library.from_examples({"ball": rows, "can": rows, "cup": rows}, poses=poses)
    assert library.pose_of_kind == ("upright", "upright", "lying", None)
    assert library.in_pose("lying").pose_of_kind == ("upright", "lying", None)
    assert library.in_pose("lying").counts.tolist() == [6, 3, 6]


def test_the_shipped_library_of_what_lies_knows_the_same_objects() -> None:
    standing, lying = shipped_library(), shipped_library("lying")
    assert lying.objects == standing.objects
    assert set(standing.touches) - set(lying.touches) == {"regrasp-turned-45"}
    assert set(lying.seconds or {}) == set(lying.touches)
    balls = lying.objects.index("sphere")
    assert lying.pose_of_kind == tuple("upright" if k == balls else "lying" for k in range(10))
    assert Perceiver(pose="lying").library is lying
    assert Perceiver().library is Perceiver(pose="upright").library is standing
    with pytest.raises(InputError, match="pose must be one of upright, lying, got 'leaning'"):
        Perceiver(pose="leaning")


def test_the_metric_is_that_of_the_commonest_pose() -> None:
    rng = np.random.default_rng(7)
    standing = {
        name: [example(x + a, b) for a, b in rng.normal(0, 0.1, (12, 2))] for name, x in (("a", 0.0), ("b", 3.0))
    }
    lying = {name: [example(*row) for row in rng.normal(0, 9.0, (8, 2))] for name in standing}
    plain = Library.from_examples(standing)
    both = Library.from_examples(
        {name: [*lying[name], *standing[name]] for name in standing},
        poses={name: ["lying"] * 8 + ["upright"] * 12 for name in standing},
    )
    assert both.usual.tolist() == ([False] * 8 + [True] * 12) * 2
    one, other = plain.touches["grip"].metric, both.touches["grip"].metric
    np.testing.assert_array_equal(one.covariance, other.covariance)
    np.testing.assert_array_equal(one.scale, other.scale)
    # Where no pose is told all examples are usual; of two poses as common the first is.
    assert plain.usual.all()
    assert made().usual.tolist() == ([True] * 20 + [False] * 20) * 2


def test_an_object_counts_as_one_however_many_poses_it_has() -> None:
    rng = np.random.default_rng(1)
    rows = [example(*rng.normal(0, 1, 2)) for _ in range(30)]
    library = Library.from_examples(
        {"one": rows, "other": rows}, poses={"one": [("a", "b", "c")[k % 3] for k in range(30)]}
    )
    belief = Belief.before(library).after(Evidence("grip", {}))
    assert belief.probability == pytest.approx({"one": 0.5, "other": 0.5})
    assert library.pose_of_kind == ("a", "b", "c", None)


def test_one_object_more_is_of_no_pose() -> None:
    library = made()
    more = library.with_object("cup", [example(2.0, 0.5), example(2.1, 0.52)])
    assert more.pose_of_kind == (*library.pose_of_kind, None)
    for touch, model in library.touches.items():
        np.testing.assert_array_equal(more.touches[touch].scores[: len(library)], model.scores)
    perceiver = Perceiver(more)
    perceiver.feel(example(2.05, 0.51)[0])
    assert perceiver.answer().object == "cup"
    assert perceiver.answer().pose is None
    assert more.only(["cup", "can"]).pose_of_kind == (None, "upright", "lying")


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ({"tin": ["lying"]}, "poses are given of 'tin', which has no examples; known are can"),
        ({"can": ["lying"]}, "'can' has 2 examples, but 1 pose; give one each"),
        ({"can": "ab"}, "poses of 'can' must be words, one an example"),
        ({"can": ["lying", " "]}, "poses of 'can' must be words, one an example"),
    ],
)
def test_poses_that_do_not_fit_are_refused(poses: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Library.from_examples({"can": [example(0.0), example(1.0)]}, poses=poses)


def test_a_file_whose_poses_do_not_fit_is_refused(tmp_path: Path) -> None:
    library = made()
    for pose in (np.full(80, 2), np.full(80, -2), np.zeros(79, dtype=np.int64)):
        bad = replace(library, pose=pose)
        with np.errstate(all="ignore"):
            object.__setattr__(bad, "touches", library.touches)
            write_library(bad, tmp_path / "bad.npz")
        with pytest.raises(FormatError, match=r"bad\.npz"):
            read_library(tmp_path / "bad.npz")


def test_an_exploration_says_how_the_thing_was_set_up() -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
    from varishold.exploration import perceive
    from varishold.hand import HandSetting, PadSetting

    perceiver = Perceiver(most_touches=1)
    setting = HandSetting(pose="lying", search=True, pads=PadSetting())
    done = perceive("cylinder", 0.06, seed=3, perceiver=perceiver, setting=setting)
    assert perceiver.library is shipped_library("lying")
    assert done.perception is not None
    assert done.perception.pose in ("lying", None)


def test_the_hand_grips_what_lies() -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
    from varishold.hand import HandSetting, set_up

    setting = HandSetting(pose="lying", search=True)
    bench, _ = set_up("cylinder", 0.06, seed=3, setting=setting)
    assert bench.solid == laid_to_grip("cylinder", 0.06, seed=3)
    bench.advance(0.3)
    # It rests where it was laid.
    _, axes = bench.object_pose()
    assert axes[2, 2] > 0.999
    with pytest.raises(InputError, match="pose must be one of upright, lying, got 'leaning'"):
        HandSetting(pose="leaning")  # type: ignore[arg-type]
