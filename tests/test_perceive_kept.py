"""What a library's file keeps and refuses, what a library has seen, and the limits and defaults that docs state."""

from __future__ import annotations

import io
import json
import lzma
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import FormatError, InputError
from varishold.perceive import Evidence, Library, NameEvidence, library_file, read_library, write_library
from varishold.perceive.metric import Metric
from varishold.perceive.name_evidence import names_in_words
from varishold.perceive.seen import Beyond, Look, answers_look, range_look, seen_range

SEEDS = st.integers(0, 2**32 - 1)


@cache
def library() -> Library:
    rng = np.random.default_rng(4)
    sizes = rng.uniform(0.03, 0.2, 12).tolist()

    def example(k: int) -> list[Evidence]:
        size = {"size.circle": np.log(sizes[k]) + rng.normal(0, 0.05)} if k else {"size.circle": np.nan}
        grasp = Evidence("grasp", {"a": rng.normal(), "b": rng.normal() if k % 3 else np.nan} | size)
        return [grasp] if k % 4 == 1 else [grasp, Evidence("tip", {"a": rng.normal(2)})]

    examples = {name: [example(k) for k in range(12)] for name in ("ball", "box")}
    return Library.from_examples(examples, sizes_m={"ball": sizes, "box": sizes}, others=[example(2)] * 3)


def arrays(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as data:
        return {key: data[key] for key in data.files}


def test_the_shipped_file_means_what_it_meant() -> None:
    """Files that were written before are read the same: twentieths of a unit, eight-thousandths of a logarithm."""
    path = Path(library_file.__file__).with_name("objects.npz.xz")
    with lzma.open(path) as packed, np.load(io.BytesIO(packed.read())) as data:
        kept = {key: data[key] for key in data.files}
    of = library_file.shipped_library()
    for k, model in enumerate(of.touches.values()):
        stored = kept[f"{k}.units"].astype(float)
        np.testing.assert_allclose(
            model.values,
            np.where(stored == -128, np.nan, stored / 20) * kept[f"{k}.scale"] + kept[f"{k}.shift"],
        )
        logs = kept[f"{k}.logs"].astype(float)
        np.testing.assert_allclose(model.size_values, np.where(logs == -32768, np.nan, logs / 8000))
    np.testing.assert_array_equal(of.owner, kept["owner"])
    np.testing.assert_array_equal(of.log_size, kept["log_size"])


def test_what_is_written_is_what_was_meant_to_half_a_step(tmp_path: Path) -> None:
    path = tmp_path / "library.npz"
    write_library(library(), path)
    kept, back = arrays(path), read_library(path)
    for k, (name, model) in enumerate(library().touches.items()):
        units, logs = kept[f"{k}.units"], kept[f"{k}.logs"]
        assert (units.dtype, logs.dtype) == (np.int8, np.int16)
        np.testing.assert_array_equal(units == -128, np.isnan(model.values))
        np.testing.assert_array_equal(logs == -32768, np.isnan(model.size_values))
        off = model.metric.standardized(model.values) - units / 20
        assert np.nanmax(np.abs(off)) <= 0.025 * (1 + 1e-9)
        if model.size_values.size:
            assert np.nanmax(np.abs(model.size_values - logs / 8000)) <= 0.5 / 8000 * (1 + 1e-9)
        read = back.touches[name]
        np.testing.assert_allclose(read.scores, model.scores, rtol=1e-6)
        np.testing.assert_allclose(read.power, model.power, rtol=1e-6)
        np.testing.assert_array_equal(read.failed, model.failed)
        assert (read.width, read.fall, read.cost) == (model.width, model.fall, model.cost)
        # What was read is written and read as it is.
    write_library(back, tmp_path / "again.npz")
    again = read_library(tmp_path / "again.npz")
    for name, model in back.touches.items():
        np.testing.assert_allclose(again.touches[name].values, model.values, atol=1e-9)
        np.testing.assert_array_equal(again.touches[name].size_values, model.size_values)


def test_a_metric_is_kept_as_half_a_factor_in_half_precision(tmp_path: Path) -> None:
    """Whitened numbers move by a hundredth at most, and a second time by nothing."""
    write_library(library(), tmp_path / "x.npz")
    back = read_library(tmp_path / "x.npz")
    for k, (name, model) in enumerate(library().touches.items()):
        d = len(model.metric.names)
        lower = arrays(tmp_path / "x.npz")[f"{k}.lower"]
        assert (lower.dtype, lower.shape) == (np.float16, (d * (d + 1) // 2,))
        np.testing.assert_allclose(back.touches[name].metric.whitening, model.metric.whitening, atol=0.01)
    write_library(back, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "x.npz").read_bytes()


@pytest.mark.parametrize("least", [0.3, 1e-3])
def test_a_metric_that_half_precision_would_bend_is_kept_in_full(tmp_path: Path, least: float) -> None:
    of = library()
    model = of.touches["grasp"]
    lower = np.array([[1.0, 0.0], [0.7123, least]])
    metric = replace(model.metric, covariance=lower @ lower.T)
    write_library(replace(of, touches={"grasp": replace(model, metric=metric)}), tmp_path / "x.npz")
    assert arrays(tmp_path / "x.npz")["0.lower"].dtype == (np.float16 if least > 1e-2 else np.float32)
    read = read_library(tmp_path / "x.npz").touches["grasp"].metric
    np.testing.assert_allclose(read.whitening, metric.whitening, rtol=0.02, atol=1e-3)


def test_files_that_hold_whole_matrices_are_read_as_they_were(tmp_path: Path) -> None:
    of = library()

    def change(head: dict[str, Any], kept: dict[str, np.ndarray]) -> None:
        head["format"] = "varishold library 1"
        for k, model in enumerate(of.touches.values()):
            del kept[f"{k}.lower"]
            kept[f"{k}.covariance"] = np.triu(model.metric.covariance).astype(np.float32)

    read = read_library(changed(tmp_path / "old.npz", change))
    for name, model in of.touches.items():
        np.testing.assert_allclose(read.touches[name].metric.covariance, model.metric.covariance, rtol=1e-6, atol=1e-7)

    def wrong(head: dict[str, Any], kept: dict[str, np.ndarray]) -> None:
        change(head, kept)
        kept["0.covariance"] = kept["0.covariance"][:-1]

    with pytest.raises(FormatError, match="covariance of touch 0"):
        read_library(changed(tmp_path / "wrong.npz", wrong))


def test_sizes_farther_than_can_be_kept_are_kept_as_the_farthest(tmp_path: Path) -> None:
    of = library()
    model = of.touches["grasp"]
    far = model.size_values.copy()
    far[1], far[2], far[3], far[4] = 99.0, -99.0, 32767 / 8000, -32767 / 8000
    write_library(replace(of, touches={"grasp": replace(model, size_values=far)}), tmp_path / "far.npz")
    read = read_library(tmp_path / "far.npz").touches["grasp"].size_values[:, 0]
    np.testing.assert_allclose(read[1:5], np.array([1, -1, 1, -1]) * 32767 / 8000)


def changed(path: Path, change: Callable[[dict[str, Any], dict[str, np.ndarray]], None]) -> Path:
    write_library(library(), path)
    kept = arrays(path)
    head = json.loads(str(kept["head"]))
    change(head, kept)
    kept["head"] = np.array(json.dumps(head))
    np.savez(path, **kept)
    return path


@pytest.mark.parametrize(
    ("size_m", "fits"), [(0.00098, False), (0.00099001, True), (0.001, True), (2.0, True), (2.019, True), (2.03, False)]
)
def test_sizes_of_a_file_are_those_that_a_hand_holds(tmp_path: Path, size_m: float, fits: bool) -> None:
    def change(_: dict[str, Any], kept: dict[str, np.ndarray]) -> None:
        kept["log_size"][3] = np.log(size_m)

    path = changed(tmp_path / "sizes.npz", change)
    if fits:
        assert read_library(path).log_size[3] == pytest.approx(np.log(size_m))
    else:
        with pytest.raises(FormatError, match=r"sizes must lie in \[0.001, 2\] m"):
            read_library(path)


@pytest.mark.parametrize("size_m", [0.001, 2.0])
def test_the_smallest_and_largest_sizes_are_taken_and_survive_a_file(tmp_path: Path, size_m: float) -> None:
    rows = [[Evidence("grasp", {"a": float(k)})] for k in range(3)]
    of = Library.from_examples({"ball": rows}, sizes_m={"ball": [size_m] * 3})
    write_library(of, tmp_path / "x.npz")
    np.testing.assert_allclose(read_library(tmp_path / "x.npz").log_size, np.log(size_m))
    for wrong in (0.99 * 0.001, 1.01 * 2.0):
        with pytest.raises(InputError, match="in millimetres"):
            Library.from_examples({"ball": rows}, sizes_m={"ball": [wrong] * 3})


@pytest.mark.parametrize(
    ("key", "value"), [(k, v) for k in ("width", "fall", "cost") for v in (0.0, -1.0, float("inf"), float("nan"))]
)
def test_numbers_of_a_kernel_must_be_positive_and_finite(tmp_path: Path, key: str, value: float) -> None:
    path = changed(tmp_path / "x.npz", lambda head, _: head["0"].update({key: value}))
    with pytest.raises(FormatError):
        read_library(path)
    path = changed(tmp_path / "y.npz", lambda head, _: head["0"].update({key: 1e-3}))
    assert getattr(read_library(path).touches["grasp"], key) == 1e-3


@pytest.mark.parametrize("key", ["shift", "scale", "lower"])
def test_a_metric_of_a_file_must_be_finite_and_its_scale_positive(tmp_path: Path, key: str) -> None:
    for value in (np.nan, np.inf, 0.0) if key == "scale" else (np.nan, np.inf):

        def change(_: dict[str, Any], kept: dict[str, np.ndarray], value: float = value) -> None:
            kept[f"0.{key}"].flat[0] = value

        with pytest.raises(FormatError):
            read_library(changed(tmp_path / "x.npz", change))


# What was seen


@settings(max_examples=40)
@given(SEEDS, st.integers(2, 12), st.integers(1, 4))
def test_how_far_beyond_is_told_in_parts_of_the_range_of_the_others(seed: int, n: int, d: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(n, d)).round(1)
    values[rng.random((n, d)) < 0.1] = np.nan
    values[0] = np.nan
    metric = Metric(tuple(f"n{k}" for k in range(d)), rng.normal(size=d), rng.uniform(0.3, 2, d), np.eye(d))
    seen = seen_range(metric, values)

    def steps(x: np.ndarray) -> np.ndarray:
        return np.array(np.round(np.clip((x - metric.shift) / metric.scale, -6, 6) * 20))

    def beyond(x: np.ndarray, rows: list[np.ndarray]) -> list[float]:
        out = []
        for k, at in enumerate(steps(x)):
            known = [row for row in (steps(row)[k] for row in rows) if np.isfinite(row)]
            if not known or np.isnan(at):
                out.append(0.0)
                continue
            low, high = min(known), max(known)
            off = max(low - at, at - high, 0.0)
            out.append(off / (high - low) if high > low else float(off > 0))
        return out

    for i, row in enumerate(values):
        rest = [other for j, other in enumerate(values) if j != i]
        expected = max(beyond(row, rest)) if np.isfinite(row).any() else np.nan
        assert seen.known[i] == pytest.approx(expected, nan_ok=True)
    felt = rng.normal(0, 3, d)
    parts = beyond(felt, list(values))
    off = seen.beyond(felt)
    assert off.parts == pytest.approx(max(parts))
    assert off.name == metric.names[int(np.argmax(parts))]
    look = range_look([(seen, off)], 0.008)
    known = seen.known[np.isfinite(seen.known)]
    if off.parts == 0 or not known.size:
        assert look.p_value == 1.0
    else:
        assert look.p_value == (1 + sum(known >= off.parts - 1e-9)) / (1 + len(known))
    assert look.limit == max(0.008, 1 / (1 + max(len(known), 1)))
    assert look.inside == look.p_value / look.limit


def test_of_several_touches_the_farthest_of_each_example_counts() -> None:
    metric = Metric(("a",), np.zeros(1), np.ones(1), np.eye(1))
    one = seen_range(metric, np.array([[0.0], [1.0], [2.0], [np.nan]]))
    two = seen_range(metric, np.array([[np.nan], [0.0], [1.0], [4.0]]))
    assert one.known.tolist()[:3] == [1.0, 0.0, 1.0]
    assert two.known.tolist()[1:] == [1 / 3, 0.0, 3.0]
    for parts, share in ((0.5, 4 / 5), (1.0, 4 / 5), (1.1, 2 / 5), (3.0, 2 / 5), (3.1, 1 / 5)):
        look = range_look([(one, Beyond("a", parts)), (two, Beyond("a", 0.2))], 0.008)
        assert (look.p_value, look.limit) == (share, 1 / 5)
    # A touch that nobody knows, and none at all, say nothing.
    assert range_look([], 0.3) == Look(1.0, 0.5)
    nobody = seen_range(metric, np.full((3, 1), np.nan))
    assert range_look([(nobody, Beyond("a", 9.0))], 0.3) == Look(1.0, 0.5)
    assert range_look([(one, Beyond("a", 0.0))], 0.3) == Look(1.0, 0.3)


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(0.01, 1), st.floats(0.01, 1)), min_size=1, max_size=4))
def test_answers_are_looked_at_by_twice_their_mean_and_the_strictest_limit(told: list[tuple[float, float]]) -> None:
    answers = [NameEvidence(f"s{k}", {"ball": 1.0}, p_value=p, error=error) for k, (p, error) in enumerate(told)]
    look = answers_look(answers, ("ball", "box"))
    assert look is not None
    mean = np.mean([p for p, _ in told])
    assert look.p_value == pytest.approx(mean if len(told) == 1 else min(1, 2 * mean))
    assert look.limit == min(error for _, error in told)
    assert answers_look([], ("ball",)) is None


# Answers of others


def test_an_answer_is_refused_at_its_error_and_that_is_a_twentieth_where_nothing_is_said() -> None:
    objects = ("ball", "box")
    for error in (None, 0.05, 0.2):
        more = {} if error is None else {"error": error}
        limit = error or 0.05
        at = NameEvidence("camera", {"ball": 0.9, "box": 0.1}, p_value=limit, **more)
        above = NameEvidence("camera", {"ball": 0.9, "box": 0.1}, p_value=limit + 1e-6, **more)
        assert (at.refused, above.refused) == (True, False)
        assert not at.log_likelihood(objects).any()
        assert above.log_likelihood(objects).any()
        assert at.remarks(objects) == (f"camera: none of its names, p = {limit:.3f}",)
        assert above.remarks(objects) == ()
        for share, remarked in ((limit, True), (0.98 * limit, False)):
            said = NameEvidence("camera", {"ball": 1 - share, "egg": share}, **more)
            assert bool(said.remarks(objects)) == remarked
    plain = NameEvidence("camera", {"ball": 0.9, "box": 0.1})
    assert (plain.p_value, plain.weight, plain.refused) == (1.0, 1.0, False)
    assert plain.reasons == ("camera: ball 0.90, else box 0.10",)
    assert plain.touch == "camera"


@settings(max_examples=30)
@given(SEEDS, st.floats(0.05, 1), st.floats(0.051, 1))
def test_what_an_answer_says_is_its_share_against_the_prior(seed: int, weight: float, p_value: float) -> None:
    rng = np.random.default_rng(seed)
    names = ("ball", "box", "egg", "can")
    said, prior = (dict(zip(names, rng.dirichlet(np.ones(4)).tolist(), strict=True)) for _ in range(2))
    answer = NameEvidence("camera", said, prior, weight=weight, p_value=p_value)
    told = answer.log_likelihood(("box", "cone", "ball"))
    # A hundredth of all answers is about nothing.
    expected = [
        weight * np.log(0.99 * said[n] / prior[n] + 0.01) if n in said else 0.0 for n in ("box", "cone", "ball")
    ]
    np.testing.assert_allclose(told, expected, rtol=1e-9, atol=1e-12)
    share = (said["box"] + said["ball"]) / (prior["box"] + prior["ball"])
    assert answer.p_of_these(("box", "cone", "ball")) == pytest.approx(min(p_value, share))
    assert answer.p_of_these(("cone",)) == p_value
    with pytest.raises(InputError, match="none of which is an object of the library"):
        answer.log_likelihood(("cone",))


@pytest.mark.parametrize("what", ["p_value", "error", "weight"])
def test_p_values_errors_and_weights_are_above_nothing_and_at_most_one(what: str) -> None:
    assert getattr(NameEvidence("camera", {"ball": 1.0}, **{what: 1.0}), what) == 1.0
    assert getattr(NameEvidence("camera", {"ball": 1.0}, **{what: 1e-12}), what) == 1e-12
    for wrong in (0.0, -0.1, 1.0001, float("nan"), "1"):
        with pytest.raises(InputError, match=f"{what} of 'camera' must be a number above 0 and at most 1"):
            NameEvidence("camera", {"ball": 1.0}, **{what: wrong})
    NameEvidence("camera", {"ball": 1.0 + 9e-7, "box": 0.0})
    for shares in ({"ball": 1.0 + 2e-6}, {"ball": 1 - 2e-6}, {"ball": 1.1, "box": -0.1}):
        with pytest.raises(InputError, match="sum to 1"):
            NameEvidence("camera", shares)
    with pytest.raises(InputError, match="prior of 'camera' must be above 0"):
        NameEvidence("camera", {"ball": 0.5, "box": 0.5}, {"ball": 1.0, "box": 0.0})


def test_four_names_are_listed_and_the_rest_counted() -> None:
    assert names_in_words("abcd") == "a, b, c, d"
    assert names_in_words("abcdefg") == "a, b, c, d and 3 more"
