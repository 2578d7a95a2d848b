"""Laws of covers, of sign tables in words, and of how many hyperplanes are drawn."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.exceptions import NotFittedError

from varishold.errors import InputError
from varishold.grasp import HyperplaneClassifier, MinimalTable, SignTable, ThresholdEncoder
from varishold.grasp import cover as covers
from varishold.grasp.cover import smallest_cover
from varishold.grasp.modes import vote

few = settings(max_examples=25)
seeds = st.integers(0, 2**32 - 1)


def drawn(seed: int, elements: int = 12, columns: int = 10) -> np.ndarray:
    rng = np.random.default_rng(seed)
    cover = rng.random((elements, columns)) < 0.3
    cover[np.arange(elements), rng.integers(columns, size=elements)] = True
    return cover


def smallest(cover: np.ndarray) -> int:
    """The size of the smallest cover, by trying all."""
    for size in range(1, cover.shape[1] + 1):
        if any(cover[:, list(some)].any(axis=1).all() for some in combinations(range(cover.shape[1]), size)):
            return size
    raise AssertionError


@few
@given(seeds)
@pytest.mark.parametrize("nodes", [0, 3, 20_000])
def test_search_and_integer_program_find_the_smallest_cover(
    monkeypatch_module: pytest.MonkeyPatch, nodes: int, seed: int
) -> None:
    cover, monkeypatch = drawn(seed), monkeypatch_module
    best = smallest(cover)
    monkeypatch.setattr(covers, "_NODES", nodes)
    for upper in (best, best + 1, 10):
        found, bound = smallest_cover(cover, upper=upper, lower=1, time_limit_s=10)
        assert bound == min(best, upper)
        if found is None:
            assert upper == best
        else:
            assert len(found) == len(set(found)) == best < upper
            assert cover[:, found].any(axis=1).all()
    # What is proved already is neither searched again nor bettered.
    assert smallest_cover(cover, upper=best, lower=best, time_limit_s=10) == (None, best)
    assert smallest_cover(cover, upper=10, lower=1, time_limit_s=0) == (None, 1)


@pytest.fixture(scope="module")
def monkeypatch_module() -> pytest.MonkeyPatch:  # type: ignore[misc]
    with pytest.MonkeyPatch.context() as patch:
        yield patch  # type: ignore[misc]


@few
@given(seeds)
def test_columns_that_others_contain_are_not_asked(seed: int) -> None:
    cover = drawn(seed)
    kept = set(covers._undominated(cover).tolist())
    for k in range(10):
        inside = [j for j in range(10) if j != k and (cover[:, k] <= cover[:, j]).all()]
        larger = [j for j in inside if (cover[:, k] != cover[:, j]).any()]
        assert (k in kept) == (not larger and all(j > k for j in inside))


def test_so_many_columns_are_not_reduced(monkeypatch: pytest.MonkeyPatch) -> None:
    cover = np.array([[1, 1], [0, 1]], dtype=np.bool_)
    monkeypatch.setattr(covers, "_REDUCTION_COLUMNS", 2)
    assert covers._undominated(cover).tolist() == [1]
    monkeypatch.setattr(covers, "_REDUCTION_COLUMNS", 1)
    assert covers._undominated(cover).tolist() == [0, 1]


# Tables in words

TABLE = SignTable(np.array([[0, 1], [1, 1], [1, 0]], dtype=bool), ("box", "ball", "box"), ("I", "II"), (1, 2, 5))


def test_a_sign_table_is_printed_with_grasps_across_or_where_they_are_many_down() -> None:
    assert str(TABLE).splitlines() == [
        "          v1    v2   v5",
        "pattern  box  ball  box",
        "I          0     1    1",
        "II         1     1    0",
    ]
    many = SignTable(np.tile(TABLE.signs, (30, 1)), TABLE.labels * 30, ("I", "II"), tuple(range(90)))
    lines = str(many).splitlines()
    assert len(lines) == 91
    assert lines[0].split() == ["pattern", "I", "II"]
    assert lines[3].split() == ["v2", "box", "1", "0"]
    assert TABLE.codes.tolist() == [0, 1, 0]
    assert TABLE.columns(["II"]).signs.tolist() == [[True], [True], [False]]
    assert TABLE.columns(["II", "I"]).hyperplanes == ("II", "I")
    for wrong in ({"labels": ("a",)}, {"hyperplanes": ("I",)}, {"grasps": (1,)}):
        with pytest.raises(InputError, match="a sign table of"):
            SignTable(
                **(
                    {"signs": TABLE.signs, "labels": TABLE.labels, "hyperplanes": ("I", "II"), "grasps": (1, 2, 5)}
                    | wrong
                )
            )


def test_a_minimal_table_is_a_formula() -> None:
    table = MinimalTable(
        ((1, None, 0), (None, 1, None), (0, 0, 0), (None, None, None)),
        ("a", "a", "b", "c"),
        ("I", "II", "III"),
        (1, 2, 3, 4),
    )
    assert table.formula("a") == "(s_I AND NOT s_III) OR s_II"
    assert table.formula("b") == "NOT s_I AND NOT s_II AND NOT s_III"
    assert table.formula("c") == "always"
    assert table.formula("d") == "never"
    assert table.terms("a") == [((0, 1), (2, 0)), ((1, 1),)]
    assert str(table).splitlines()[1].split() == ["v1", "a", "1", "*", "0"]


def test_every_bit_of_an_encoder_has_a_name() -> None:
    X = np.random.default_rng(0).normal(size=(40, 3))
    encoder = ThresholdEncoder().fit(X)
    names = encoder.get_feature_names_out(["thumb", "index", "palm"])
    assert len(names) == encoder.transform(X).shape[1] == encoder.bits_per_channel_.sum()
    bits = encoder.transform(X)
    for k, name in enumerate(names):
        channel, threshold = name.split(">=")
        column = ["thumb", "index", "palm"].index(channel)
        far = np.abs(X[:, column] - float(threshold)) > 1e-4
        np.testing.assert_array_equal(bits[far, k], X[far, column] >= float(threshold))


def test_as_many_hyperplanes_as_asked_are_drawn_and_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    monkeypatch.setattr(vote, "_FEW", 20)
    monkeypatch.setattr(vote, "_MANY", 45)
    monkeypatch.setattr(vote, "_A_CLASS", 10)
    monkeypatch.setattr(vote, "_BY_GRASPS", 30)
    for switches, classes, most in ((32, 3, 20), (33, 3, 45), (33, 6, 60)):
        y = np.arange(90) % classes
        prototypes = rng.random((classes, switches)) < 0.5
        X = prototypes[y] ^ (rng.random((90, switches)) < 0.1)
        found = HyperplaneClassifier("vote").fit(X, y).netlist_
        assert 0.6 * most < len(found.units) <= most
        assert len(HyperplaneClassifier("vote", max_hyperplanes=7).fit(X, y).netlist_.units) <= 7


def test_of_two_classes_the_larger_circuit_is_left_out() -> None:
    rng = np.random.default_rng(3)
    for seed in range(4):
        X = np.unique(rng.random((12, 6)) < 0.5, axis=0)
        y = np.array(["a", "b"])[rng.integers(2, size=len(X))]
        y[:2] = ["a", "b"]
        clf = HyperplaneClassifier("paper").fit(X, y)
        sizes = {label: sum(map(len, clf.minimal_table_.terms(label))) for label in ("a", "b")}
        left = [label for label in ("a", "b") if sizes[label] == min(sizes.values())]
        counts = [len(clf.minimal_table_.terms(label)) for label in left]
        assert len(clf.netlist_.terms) in counts, seed
        assert (clf.predict(X) == y).all()


@pytest.mark.parametrize("name", ["remarks_", "sign_table_", "reduced_table_", "minimal_table_"])
def test_who_has_learned_nothing_says_so(name: str) -> None:
    with pytest.raises(NotFittedError):
        getattr(HyperplaneClassifier(), name)
