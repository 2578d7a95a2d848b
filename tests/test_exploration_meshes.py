"""Things of a mesh in the hand: refused where the hand cannot hold them, felt as a solid is, and again after a stop."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")
pytest.importorskip("trimesh", reason="trimesh is not installed; pip install -e '.[meshes]'")
pytest.importorskip("coacd", reason="coacd is not installed; pip install -e '.[meshes]'")
pytest.importorskip("networkx")

import trimesh

from varishold.errors import InputError
from varishold.exploration import TOUCHES, PoseEstimate, feel_examples, kept_beside, mesh_to_grip, perceive
from varishold.exploration.object_examples import example_setting
from varishold.hand import HandSetting, set_up
from varishold.perceive import NONE_OF_THESE, Evidence, Library, Perceiver, library_file, read_library, write_library
from varishold.perceive.library import LOG_SIZES
from varishold.solids import MeshSolid, Part

BRICK = MeshSolid("brick", (Part.box(0.08, 0.05, 0.06),))
BLIND = HandSetting(pads=None)


def box_file(path: Path, *lengths: float) -> Path:
    trimesh.creation.box(lengths).export(path)
    return path


# What is refused


@pytest.mark.parametrize(
    ("lengths", "size_m", "said"),
    [
        ((80.0, 40.0, 60.0), None, r"is 80 m broad.*look like millimetres: give 0.08"),
        ((8.0, 4.0, 6.0), None, r"look like centimetres: give 0.08"),
        ((3.0, 2.0, 3.0), None, r"look like inches: give 0.0762|centimetres"),
        ((0.5, 0.2, 0.2), None, r"is 0.5 m broad, and the hand grips 0.035 to 0.125 m; give a size in"),
        ((0.01, 0.01, 0.02), None, r"is 0.01 m broad"),
        ((0.08, 0.04, 0.06), 0.3, r"must lie in \[0.035, 0.125\] m for the hand to grip it, got 0.3 m"),
        ((0.08, 0.04, 0.06), -1.0, r"got -1 m"),
        ((0.08, 0.04, 0.06), float("nan"), r"got nan m"),
        ((0.08, 0.004, 0.06), None, r"would be 0.004 m broad at its narrower side"),
        ((0.08, 0.04, 0.006), None, r"would be 0.006 m tall.*lay it down"),
        ((1.0, 1.0, 8.0), 0.08, r"would be 0.64 m tall"),
    ],
)
def test_what_the_hand_cannot_hold_is_refused(
    tmp_path: Path, lengths: tuple[float, float, float], size_m: float | None, said: str
) -> None:
    with pytest.raises(InputError, match=said) as raised:
        mesh_to_grip(box_file(tmp_path / "box.stl", *lengths), size_m=size_m)
    assert raised.value.parameter == "size_m"


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "a\x1b[31mb", "a\x00", "n" * 101])
def test_a_name_is_short_and_can_be_printed(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="printable characters") as raised:
        mesh_to_grip(box_file(tmp_path / "box.stl", 0.08, 0.04, 0.06), name=name)
    assert raised.value.parameter == "name"


def test_nothing_is_called_as_strangers_are(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="said of strangers; choose another name") as raised:
        mesh_to_grip(box_file(tmp_path / "box.stl", 0.08, 0.04, 0.06), name=f" {NONE_OF_THESE}")
    assert raised.value.parameter == "name"


def test_what_is_several_things_is_told(tmp_path: Path) -> None:
    for gap_m, things in ((0.02, 2), (0.0, 1), (-0.01, 1)):
        below, above = trimesh.creation.box((0.06, 0.06, 0.04)), trimesh.creation.box((0.05, 0.05, 0.04))
        above.apply_translation((0.0, 0.0, 0.04 + gap_m))
        path = tmp_path / f"{things}.stl"
        trimesh.util.concatenate([below, above]).export(path)
        said = [remark for remark in mesh_to_grip(path).remarks if "do not touch" in remark]
        assert said == [
            f"it is {things} things that do not touch, and is felt as one; leave out of the file what does not belong"
        ] * (things > 1)


def test_a_mesh_in_millimetres_is_scaled_and_stands_on_the_table(tmp_path: Path) -> None:
    thing = mesh_to_grip(box_file(tmp_path / "my brick.stl", 160.0, 100.0, 120.0), size_m=0.08)
    assert thing.called == "my brick"
    assert thing.size_m == pytest.approx(0.08)
    np.testing.assert_allclose(thing.extents_m, (0.08, 0.05, 0.06), atol=1e-8)
    (part,) = thing.parts
    np.testing.assert_allclose(part.centre_m, (0, 0, 0.03), atol=1e-8)


# What it feels like


@pytest.mark.parametrize(("seed", "most_rad"), [(1, 0.01), (2, 0.01)])
def test_a_mesh_of_a_box_feels_as_the_box(tmp_path: Path, seed: int, most_rad: float) -> None:
    clamped = replace(BLIND, clamped=True, still=True)
    mesh = mesh_to_grip(box_file(tmp_path / "brick.stl", 0.08, 0.05, 0.06))
    assert mesh.parts[0].kind == "hull"
    angles = []
    for thing in (BRICK, mesh):
        bench, _ = set_up(thing, thing.size_m, seed=seed, setting=clamped)
        felt = TOUCHES["squeeze"].make(bench, PoseEstimate(), clamped)
        assert felt is not None
        angles.append(felt.step.sensed.angles_rad)
    np.testing.assert_allclose(angles[0], angles[1], atol=most_rad)


# Examples


class Stopped(Exception):
    """Somebody pressed Ctrl-C."""


def same(one: list[list[Evidence]], other: list[list[Evidence]]) -> bool:
    return repr(one) == repr(other)


def drawn(feel: object, seed: int) -> list[Evidence]:
    """An example without a simulation."""
    rng = np.random.default_rng(seed)
    if rng.random() < 0.2:
        return []
    held = (rng.random(len(TOUCHES)) < 0.7).tolist()
    values = [{"size.circle": float(rng.normal()), "x": float("nan")} if made else {} for made in held]
    return [Evidence(t, v, failed=not made) for t, v, made in zip(TOUCHES, values, held, strict=True)]


def test_what_was_stopped_goes_on_and_gives_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.exploration.object_examples._Feel.__call__", drawn)
    blind = replace(BLIND, search=True)
    keep = tmp_path / "felt" / "brick.jsonl"
    count = iter(range(9))

    def stop() -> None:
        if next(count) == 3:
            raise Stopped

    with pytest.raises(Stopped):
        feel_examples(BRICK, examples=9, setting=blind, processes=1, keep=keep, progress=stop)
    kept = keep.read_text()
    assert kept.count("\n") == 4
    # Killed in the middle of a line.
    keep.write_text(kept + '{"seed": 17, "touches": [["gra')
    told: list[int] = []
    again = feel_examples(BRICK, examples=9, setting=blind, processes=1, keep=keep, progress=lambda: told.append(1))
    whole = feel_examples(BRICK, examples=9, setting=blind, processes=1)
    assert same(again, whole)
    assert len(told) == 9
    assert keep.read_text().startswith(kept)
    assert keep.read_text().count("\n") == 9
    # All is kept: nothing is felt again, and fewer are the first of more.
    fewer = feel_examples(BRICK, examples=3, setting=blind, processes=1, keep=keep)
    assert same(fewer, whole[: len(fewer)])


def test_what_is_kept_belongs_to_all_that_it_depends_on(tmp_path: Path) -> None:
    library = tmp_path / "mine.npz"
    here = kept_beside(library, BRICK, seed=0)
    assert here.parent == tmp_path / "mine.npz.felt"
    others = [
        kept_beside(library, replace(BRICK, called="block"), seed=0),
        kept_beside(library, MeshSolid("brick", (Part.box(0.08, 0.05, 0.07),)), seed=0),
        kept_beside(library, BRICK, seed=1),
        kept_beside(library, BRICK, seed=0, setting=replace(example_setting(), search=False)),
    ]
    assert len({here, *others}) == 5
    assert kept_beside(library, BRICK, seed=0, setting=example_setting()) == here


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"examples": 0}, "examples must be at least 1"),
        ({"seed": -1}, "seed must be a whole number from 0 on"),
        ({"processes": 0}, "processes must be at least 1"),
    ],
)
def test_numbers_out_of_range_are_refused(how: dict[str, int], said: str) -> None:
    with pytest.raises(InputError, match=said):
        feel_examples(BRICK, **how)  # type: ignore[arg-type]


def test_what_is_never_held_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.exploration.object_examples.touch_in_turn", lambda *what, **how: {})
    with pytest.raises(InputError, match="never got hold of 'brick' in 4 tries"):
        feel_examples(BRICK, examples=4, processes=1)


# The library that grows


@pytest.fixture(scope="module")
def few() -> Library:
    if not library_file._SHIPPED.is_file():
        pytest.skip("no library of objects is shipped")
    return library_file.shipped_library().only(["sphere", "box", "cone"])


def own_examples(library: Library, n: int) -> list[list[Evidence]]:
    """Examples that felt a little other than the last n of the library."""
    out: list[list[Evidence]] = []
    for row in range(len(library) - n, len(library)):
        example = []
        for touch, model in library.touches.items():
            if model.made[row]:
                names = model.metric.names
                values = dict(zip(names, (model.values[row] + 0.1 * model.metric.scale).tolist(), strict=True))
                sizes = (
                    () if model.size is None else zip(model.size.names, model.size_values[row].tolist(), strict=True)
                )
                example.append(Evidence(touch, values | dict(sizes)))
        out.append(example)
    return out


def test_a_library_that_grows_leaves_the_likelihoods_of_the_others_as_they_were(few: Library, tmp_path: Path) -> None:
    grown = few.with_object("mug", own_examples(few, 12), size_m=0.08)
    write_library(grown, tmp_path / "grown.npz")
    n = len(few)
    rng = np.random.default_rng(0)
    for library in (grown, read_library(tmp_path / "grown.npz")):
        assert library.objects == ("sphere", "box", "cone", "mug")
        np.testing.assert_array_equal(library.log_size[:n], few.log_size)
        for touch, model in few.touches.items():
            wider = library.touches[touch]
            for row in rng.integers(n, size=4):
                felt = model.values[row] + 0.3 * model.metric.scale * rng.normal(size=len(model.metric.names))
                np.testing.assert_array_equal(wider.log_kernel(felt)[:n], model.log_kernel(felt))
                assert wider.log_others(felt) == model.log_others(felt)
                felt[0] = np.nan
                np.testing.assert_allclose(wider.log_kernel(felt)[:n], model.log_kernel(felt), rtol=1e-6)
                if model.size is not None and wider.size is not None:
                    values = model.size_values[row]
                    np.testing.assert_array_equal(
                        wider.size.log_likelihood(values, LOG_SIZES)[:3], model.size.log_likelihood(values, LOG_SIZES)
                    )
            np.testing.assert_array_equal(wider.scores[:n], model.scores)
            np.testing.assert_array_equal(wider.failed[:n], model.failed)


def test_a_mesh_that_is_touched_is_called_as_it_is(few: Library) -> None:
    done = perceive(BRICK, BRICK.size_m, seed=2, perceiver=Perceiver(few, most_touches=1), setting=BLIND)
    assert (done.name, done.size_m) == ("brick", 0.08)
    assert done.perception is not None
    assert done.perception.object in (*few.objects, NONE_OF_THESE)
