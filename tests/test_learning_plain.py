"""The learner beside plain linear algebra, a plain search and fusing by hand."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.spatial.distance import cdist
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from varishold.learning import discriminant, sources
from varishold.learning.discriminant import Scaling, discriminants, distances, landmark_rows, learn_scaling
from varishold.learning.explanation import deciding_measures, nearest_landmark
from varishold.learning.sources import Learned, learn, view_name, with_class
from varishold.trust import SourceWeights, calibrate, choose_weights, fuse

METRIC = {1: "cityblock", 2: "sqeuclidean"}
WIDTHS, SHRINKAGES = (1.0, 2.0, 4.0, 8.0, 16.0), (0.05, 0.1, 0.2, 0.4)


def blobs(seed: int, each: int, n_classes: int = 3, n_measures: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Presses of some classes that overlap a little."""
    rng = np.random.default_rng(seed)
    codes = np.tile(np.arange(n_classes), each)
    middles = rng.normal(0, 0.9, (n_classes, n_measures))
    return middles[codes] + rng.normal(0, 1, (len(codes), n_measures)), codes


def apart_of(a: np.ndarray, b: np.ndarray, power: int) -> np.ndarray:
    return cdist(a, b, METRIC[power]) / a.shape[1]


class Plain:
    """A shrunk discriminant of a kernel: generalized eigenvectors of the scatter between classes and within."""

    def __init__(self, known, codes, n_classes, rows, power, width, shrinkage):
        self._landmarks, self._power, self._width = known[rows], power, width
        kernel = np.exp(-apart_of(known, known[rows], power) / width)
        values, vectors = np.linalg.eigh(kernel[rows])
        kept = values > 1e-9 * values.max()
        self._root = vectors[:, kept] / np.sqrt(values[kept])
        at = kernel @ self._root
        middles = np.array([at[codes == k].mean(axis=0) for k in range(n_classes)])
        off = at - middles[codes]
        within = off.T @ off / max(len(at) - n_classes, 1)
        even = np.trace(within) / len(within)
        within = (1 - shrinkage) * within + shrinkage * even * np.eye(len(within))
        spread = middles - middles.mean(axis=0)
        directions = eigh(spread.T @ spread, within)[1][:, ::-1]
        self._to = directions[:, : min(n_classes - 1, directions.shape[1])]
        self._middles = middles @ self._to

    def judge(self, asked):
        apart = apart_of(asked, self._landmarks, self._power)
        at = np.exp(-apart / self._width) @ self._root @ self._to
        squared = cdist(at, self._middles, "sqeuclidean")
        return -squared / 2, np.stack([squared.min(axis=1), apart.min(axis=1)], axis=1)


@given(st.integers(0, 2**31), st.integers(1, 5), st.sampled_from([1, 2]))
def test_distances_are_those_of_scipy_a_measure(seed: int, n_measures: int, power: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.normal(0, 2, (4, n_measures)), rng.normal(0, 2, (3, n_measures))
    np.testing.assert_allclose(distances(a, b, power), apart_of(a, b, power), atol=1e-12)


@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize("n_measures", [1, 7, 8, 9, 15, 16, 127, 128, 129, 136, 255, 256, 257, 264, 700, 1031])
def test_distances_are_numpy_s_means_to_the_bit(power: int, n_measures: int) -> None:
    rng = np.random.default_rng(n_measures)
    for n_landmarks in (1, 3, 4, 5, 8):
        a, b = rng.normal(0, 2, (3, n_measures)), rng.normal(0, 2, (n_landmarks, n_measures))
        a[1] = b[0]
        plain = [[np.mean(np.abs(other - one) ** power) for other in b] for one in a]
        for ones, others in ((a, b), (np.asfortranarray(a), b[:, ::1])):
            np.testing.assert_array_equal(distances(ones, others, power), plain)
    a[2] = np.nan
    assert np.isnan(distances(a, b, power)).all(axis=1).tolist() == [False, False, True]
    assert distances(a[:0], b, power).shape == (0, n_landmarks)
    a.flags.writeable = False
    assert distances(a, b, power)[1, 0] == 0


@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize("together", [1, 12, 13, 1000])
def test_distances_are_the_same_to_the_bit_however_many_are_worked_on_together(
    power: int, together: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(0, 2, (4, 6)), rng.normal(0, 2, (7, 6))
    plain = np.mean(np.abs(b[None] - a[:, None]) ** power, axis=2)
    monkeypatch.setattr(discriminant, "_TOGETHER", together)
    np.testing.assert_array_equal(distances(a, b, power), plain)


@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize("shrinkage", [0.05, 0.4, 1.0])
@pytest.mark.parametrize("n_classes", [2, 3, 4])
def test_a_discriminant_is_that_of_plain_linear_algebra(power: int, shrinkage: float, n_classes: int) -> None:
    known, codes = blobs(n_classes, 6, n_classes)
    asked, _ = blobs(9, 4)
    for rows in (np.arange(len(codes)), np.arange(1, len(codes), 2)):
        plain = Plain(known, codes, n_classes, rows, power, 1.5, shrinkage)
        ways = [0.7, shrinkage]
        found = discriminants(apart_of(known, known[rows], power), rows, codes, n_classes, power, 1.5, ways)
        assert [(one.power, one.width, one.shrinkage) for one in found] == [(power, 1.5, way) for way in ways]
        assert found[1].whiten.shape == (len(rows), n_classes - 1)
        assert found[1].means.shape == (n_classes, n_classes - 1)
        told = found[1].judge(apart_of(asked, known[rows], power))
        for mine, theirs in zip(told, plain.judge(asked), strict=True):
            np.testing.assert_allclose(mine, theirs, rtol=2e-3, atol=2e-3)


def test_hardly_shrunk_it_is_the_discriminant_of_scikit_learn() -> None:
    known, codes = blobs(4, 20)
    asked, _ = blobs(5, 5)
    # Few landmarks: fewer directions than presses, so that the scatter is whole.
    rows = np.arange(6)
    apart = apart_of(known, known[rows], 1)
    root = np.linalg.cholesky(np.linalg.inv(np.exp(-apart[rows])))
    peer = LinearDiscriminantAnalysis(solver="lsqr", priors=[1 / 3] * 3).fit(np.exp(-apart) @ root, codes)
    new = apart_of(asked, known[rows], 1)
    scores = discriminants(apart, rows, codes, 3, 1, 1.0, [0.0])[0].judge(new)[0]
    # scikit-learn divides the scatter by the number of presses, not by what is left of them.
    said = peer.decision_function(np.exp(-new) @ root) * 57 / 60
    np.testing.assert_allclose(scores - scores[:, :1], said - said[:, :1], rtol=1e-3, atol=1e-2)


def test_where_nothing_scatters_all_directions_are_even() -> None:
    apart = np.array([[0.0, 0.8], [0.8, 0.0]])
    (found,) = discriminants(apart, np.arange(2), np.arange(2), 2, 1, 2.0, [0.25])
    # By hand: the squared distance of two in the kernel's space, whitened by a scatter of 0.25.
    between = (2 - 2 * np.exp(-0.4)) / 0.25
    scores, strange = found.judge(apart)
    np.testing.assert_allclose(scores, [[0, -between / 2], [-between / 2, 0]], atol=1e-5)
    np.testing.assert_allclose(strange, 0.0, atol=1e-5)
    assert (strange >= 0).all()


def test_what_was_learned_is_of_single_precision() -> None:
    known, codes = blobs(6, 5)
    (found,) = discriminants(distances(known, known, 1), np.arange(15), codes, 3, 1, 2.0, [0.1])
    for of in (found.whiten, found.means, Scaling(np.zeros(4), np.full(4, 1 / 3)).apply(known)):
        np.testing.assert_array_equal(of, of.astype(np.float32))
        assert of.dtype == np.float64


def test_scaling_is_by_the_mean_and_spread_of_what_is_known() -> None:
    measures = np.array([[1.0, 5.0, np.nan, 3.0], [3.0, 5.0, np.nan, np.nan], [8.0, 5.0, np.nan, 4.0]])
    scaling = learn_scaling(measures)
    np.testing.assert_allclose(scaling.shift, [4, 5, 0, 3.5])
    np.testing.assert_allclose(scaling.scale, [1 / np.std([1, 3, 8]), 0, 0, 2])
    # A spread of rounding beside its mean is none; one that is small alone is one.
    fine = learn_scaling(np.array([[1e6, 1e-6], [1e6 + 1e-4, 3e-6]]))
    assert fine.scale[0] == 0
    assert fine.scale[1] == pytest.approx(1e6)
    np.testing.assert_allclose(scaling.apply(np.array([[4.0, 9.0, 1.0, 4.0]])), [[0, 0, 0, 1]])
    np.testing.assert_allclose(scaling.apply(np.array([[4.0, 9.0, 1.0, np.nan]])), [[0, 0, 0, 0]])
    assert np.isnan(scaling.apply(np.full((1, 4), np.nan))).all()
    one = Scaling(np.array([1.0]), np.array([2.0]))
    drift = np.array([0.5])
    assert one.apply(np.array([[3.0], [2.0], [9.0], [-9.0]]), drift).ravel().tolist() == [3.5, 1.5, 4.0, -4.0]
    assert one.apply(np.array([[2.0]])).tolist() == [[2.0]]


def test_landmarks_are_all_or_the_first_of_each_class() -> None:
    assert landmark_rows(np.arange(800) % 2, 100).tolist() == list(range(800))
    codes = np.arange(801) % 3
    rows = landmark_rows(codes, 375)
    assert rows.tolist() == list(range(798))  # 266 of each class
    assert landmark_rows(np.repeat([0, 1, 2], [500, 3, 298]), 1).tolist() == [
        *range(266),
        *range(500, 503),
        *range(503, 769),
    ]
    # With many measures fewer: 300 000 numbers in all.
    assert landmark_rows(codes, 1000).tolist() == list(range(300))
    assert landmark_rows(codes[:300], 1000).tolist() == list(range(300))
    assert landmark_rows(codes[:301], 1000).tolist() == list(range(300))
    # But one of each class at least.
    assert landmark_rows(np.array([2, 0, 1, 0, 1, 2]), 150_000).tolist() == [0, 1, 2]


def judged(measures, codes, n_classes, fold, asked, power):
    """Say what a plain search over all settings finds: the setting, held-out scores and strangeness."""
    found = {}
    for width in WIDTHS:
        for shrinkage in SHRINKAGES:
            said, strange = np.full((len(codes), n_classes), -np.inf), np.zeros((len(codes), 2))
            for k in sorted(set(fold.tolist())):
                train, test = np.flatnonzero(fold != k), np.flatnonzero(fold == k)
                there = sorted(set(codes[train].tolist()))
                inner = np.array([there.index(code) for code in codes[train]])
                scaling = learn_scaling(measures[train])
                known, new = (np.nan_to_num(scaling.apply(measures[of])) for of in (train, test))
                rows = landmark_rows(inner, measures.shape[1])
                apart = distances(known, known[rows], power)
                (one,) = discriminants(apart, rows, inner, len(there), power, width, [shrinkage])
                scores, strange[test] = one.judge(distances(new, known[rows], power))
                for j, code in enumerate(there):
                    said[test, code] = scores[:, j]
            said, strange, truth = said[asked], strange[asked], codes[asked]
            p = calibrate(said, truth).probabilities(said)[np.arange(len(truth)), truth]
            found[width, shrinkage] = float(-np.mean(np.log(p))), said, strange
    least = min(loss for loss, _, _ in found.values())
    best = max(setting for setting, (loss, _, _) in found.items() if loss <= least + 0.01)
    return best, *found[best][1:]


@pytest.mark.parametrize("case", ["plain", "asked", "lacking", "landmarks"])
def test_learning_is_a_plain_search(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    touch, codes = blobs(11, 8, n_measures=3)
    numbers = np.where(codes == 0, 0.2, 1.0)[:, None] + np.random.default_rng(1).normal(0, 0.3, (24, 1))
    fold, asked = np.arange(24) // 8, np.ones(24, bool)
    if case == "asked":
        asked = np.arange(24) % 4 != 1
        numbers[3] = np.nan
    if case == "lacking":
        # One fold holds all there is of a class: it knows nothing of it.
        fold = np.where(codes == 2, 0, 1 + np.arange(24) % 2)
    if case == "landmarks":
        monkeypatch.setattr(discriminant, "_MOST_NUMBERS", 30)
    measures = {"touch": touch, "numbers": numbers}
    ticks: list[int] = []
    learned, rows = learn(measures, codes, 3, fold, asked=asked, tick=lambda: ticks.append(1))
    # By the source with most measures, of both alike.
    np.testing.assert_array_equal(rows, landmark_rows(codes, 3))
    assert len(rows) == (9 if case == "landmarks" else 24)
    np.testing.assert_array_equal(learned.landmark_codes, codes[rows])
    assert len(ticks) == 2 * 2 * 3
    said, strange = {}, {}
    truth = codes[asked]
    assert list(learned.sources) == ["touch", "numbers"]
    for name, source in learned.sources.items():
        scaling = learn_scaling(measures[name])
        np.testing.assert_array_equal(source.scaling.shift, scaling.shift)
        np.testing.assert_array_equal(source.scaling.scale, scaling.scale)
        scaled = np.nan_to_num(scaling.apply(measures[name]))
        np.testing.assert_array_equal(source.landmarks, scaled[rows])
        assert [view.discriminant.power for view in source.views] == [1, 2]
        for view in source.views:
            one = view.discriminant
            setting, scores, odd = judged(measures[name], codes, 3, fold, asked, one.power)
            assert (one.width, one.shrinkage) == setting
            assert view.temperature == calibrate(scores, truth).temperature
            np.testing.assert_allclose(view.typical, np.quantile(odd, 0.9, axis=0), rtol=1e-6)
            apart = distances(scaled, scaled[rows], one.power)
            (again,) = discriminants(apart, rows, codes, 3, one.power, *setting[:1], setting[1:])
            np.testing.assert_array_equal(one.whiten, again.whiten)
            np.testing.assert_array_equal(one.means, again.means)
            scores = scores / view.temperature
            scores[np.isneginf(scores[np.arange(len(truth)), truth])] = np.nan
            said[f"{name}.{one.power}"] = scores
            strange.setdefault(name, []).append(odd / view.typical)
    trust = choose_weights(said, truth)
    # Scores of many settings at once and of one alone differ in the last bit by some versions of NumPy and SciPy.
    assert learned.trust.weights == pytest.approx(trust.weights, rel=1e-12)
    assert learned.trust.mixing == pytest.approx(trust.mixing, rel=1e-12)
    p = fuse(said, trust)[np.arange(len(truth)), truth]
    assert learned.loss == pytest.approx(-p.mean())
    np.testing.assert_allclose(learned.known, strangest(strange.values()), rtol=1e-6)
    assert learned.drift == {}


@pytest.fixture(scope="module")
def learned() -> Learned:
    touch, codes = blobs(21, 6, n_measures=5)
    numbers = np.random.default_rng(2).normal(codes[:, None], 0.5, (18, 2))
    return learn({"touch": touch, "numbers": numbers}, codes, 3, np.arange(18) // 6, asked=np.ones(18, bool))[0]


def asked_of(learned: Learned, seed: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    scaled = {"touch": rng.normal(0, 1, (4, 5)), "numbers": rng.normal(0, 1, (4, 2))}
    scaled["numbers"][2] = np.nan
    return scaled


def strangest(sources: Iterable[list[np.ndarray]]) -> np.ndarray:
    """How strange presses are to the source that they are strangest to, NaN where none speaks of them."""
    found = []
    for views in sources:
        from_class = sum(of[:, 0] for of in views) / len(views)
        found.append(np.maximum(from_class, np.max([of[:, 1] for of in views], axis=0) / 2))
    return np.nanmax(found, axis=0)


def test_views_of_all_sources_are_fused_by_their_temperatures(learned: Learned) -> None:
    assert view_name("touch", 2) == "touch.2"
    scaled = asked_of(learned, 0)
    said, strange = {}, []
    for name, source in learned.sources.items():
        strange.append([])
        for view in source.views:
            apart = apart_of(scaled[name], source.landmarks, view.discriminant.power)
            scores, odd = view.discriminant.judge(apart)
            said[f"{name}.{view.discriminant.power}"] = scores / view.temperature
            strange[-1].append(odd / view.typical)
    told, odd = learned.judge(scaled)
    np.testing.assert_allclose(told, fuse(said, learned.trust), atol=1e-9)
    np.testing.assert_allclose(odd, strangest(strange))
    np.testing.assert_allclose(np.exp(told).sum(axis=1), 1)
    # By hand, of one press: weights are powers, mixing is a share of an even answer.
    by_hand = np.zeros(3)
    for name, scores in said.items():
        p = np.exp(learned.trust.weights[name] * (scores[0] - scores[0].max()))
        share = learned.trust.mixing[name]
        by_hand += np.log((1 - share) * p / p.sum() + share / 3)
    np.testing.assert_allclose(np.exp(told[0]), np.exp(by_hand) / np.exp(by_hand).sum(), atol=1e-9)
    # A source that says nothing of a press is left out of it.
    alone = replace(learned, sources={"touch": learned.sources["touch"]})
    for mine, theirs in zip(learned.judge(scaled), alone.judge({"touch": scaled["touch"]}), strict=True):
        np.testing.assert_allclose(mine[2], theirs[2])


def test_drift_is_taken_from_the_standardized_measures_of_its_source(learned: Learned) -> None:
    touch, numbers = np.random.default_rng(3).normal(0, 1, (3, 5)), np.ones((3, 2))
    shift = np.array([0.5, 0, 0, -0.25, 0])
    plain = learned.scaled({"touch": touch, "numbers": numbers})
    drifted = replace(learned, drift={"touch": shift}).scaled({"touch": touch, "numbers": numbers})
    np.testing.assert_allclose(drifted["touch"], np.clip(plain["touch"] - shift, -4, 4), atol=1e-6)
    np.testing.assert_array_equal(drifted["numbers"], plain["numbers"])


@pytest.mark.parametrize(("place", "n_added"), [(0, 7), (2, 3), (3, 2)])
def test_with_a_class_more_is_learning_with_its_rows_by_the_old_settings(
    learned: Learned, place: int, n_added: int
) -> None:
    rng = np.random.default_rng(place)
    added = {"touch": rng.normal(3, 1, (n_added, 5)), "numbers": rng.normal(-2, 1, (n_added, 2))}
    added["numbers"][0] = np.nan
    found, rows, _ = with_class(learned, added, place)
    codes = np.concatenate([learned.landmark_codes, np.full(n_added, -1)])
    codes = np.array([place if code == -1 else code + 1 if code >= place else code for code in codes])
    np.testing.assert_array_equal(rows, np.arange(18 + n_added))
    np.testing.assert_array_equal(found.landmark_codes, codes)
    assert found.trust is learned.trust
    assert found.loss == learned.loss
    scaled = {name: np.concatenate([of.landmarks, np.nan_to_num(added[name])]) for name, of in learned.sources.items()}

    def views_of(keep: np.ndarray) -> Learned:
        sources = {}
        for name, source in learned.sources.items():
            known, views = scaled[name][keep], []
            for view in source.views:
                old = view.discriminant
                apart = distances(known, known, old.power)
                ways = (codes[keep], 4, old.power, old.width, [old.shrinkage])
                views.append(replace(view, discriminant=discriminants(apart, np.arange(len(known)), *ways)[0]))
            sources[name] = replace(source, landmarks=known, views=tuple(views))
        return replace(learned, sources=sources)

    whole = views_of(np.ones(len(codes), bool))
    for name, source in found.sources.items():
        np.testing.assert_array_equal(source.landmarks, scaled[name])
        assert source.scaling is learned.sources[name].scaling
        for mine, theirs in zip(source.views, whole.sources[name].views, strict=True):
            np.testing.assert_array_equal(mine.discriminant.whiten, theirs.discriminant.whiten)
            np.testing.assert_array_equal(mine.discriminant.means, theirs.discriminant.means)
            assert (mine.temperature, mine.typical.tolist()) == (theirs.temperature, theirs.typical.tolist())
    # How strange its presses are is told by blocks of neighbours that were held out, at most five.
    parts = np.array_split(np.arange(n_added), n_added) if n_added < 5 else [[0, 1], [2], [3, 4], [5], [6]]
    strange = []
    for part in parts:
        keep = ~np.isin(np.arange(len(codes)), 18 + np.array(part))
        strange += views_of(keep).judge({name: of[~keep] for name, of in scaled.items()})[1].tolist()
    np.testing.assert_allclose(found.known, np.concatenate([learned.known, strange]))


def test_a_class_more_keeps_as_many_landmarks_as_there_may_be(
    learned: Learned, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(discriminant, "_MOST_NUMBERS", 60)  # 12 of 5 measures
    rng = np.random.default_rng(0)
    added = {"touch": rng.normal(3, 1, (5, 5)), "numbers": rng.normal(-2, 1, (5, 2))}
    found, rows, _ = with_class(learned, added, 1)
    assert rows.tolist() == [*range(9), 18, 19, 20]
    assert found.landmark_codes.tolist() == [0, 2, 3] * 3 + [1] * 3
    assert all(len(source.landmarks) == 12 for source in found.sources.values())
    assert np.isfinite(found.known).all()
    np.testing.assert_array_equal(found.sources["numbers"].landmarks[9:], added["numbers"][:3])


def test_the_nearest_landmark_is_nearest_where_classes_lie_apart(learned: Learned) -> None:
    source = learned.sources["touch"]
    for k in (0, 7, 17):
        assert nearest_landmark(source, source.landmarks[k : k + 1]) == k
    for one in np.random.default_rng(4).normal(0, 1, (12, 1, 5)):
        far = 0.0
        for view in source.views:
            width, whiten = view.discriminant.width, view.discriminant.whiten
            at, there = (
                np.exp(-apart_of(of, source.landmarks, view.discriminant.power) / width) @ whiten
                for of in (one, source.landmarks)
            )
            far = far + cdist(at, there, "sqeuclidean")[0] / view.temperature
        assert nearest_landmark(source, one) == int(np.argmin(far))


@pytest.mark.parametrize("case", ["bounded", "small", "against"])
def test_a_reason_counts_what_the_odds_lose_without_it(learned: Learned, case: str) -> None:
    scaled = {name: of[:1] for name, of in asked_of(learned, 6).items()}
    names = {"touch": ("area_at_1", "area_at_2", "x_to_y_at_3", "flat", "x_to_z"), "numbers": ("angle", "at_home")}
    kinds = {
        "touch": {"area": [0, 1], "x": [2, 4], "flat": [3]},
        "numbers": {"angle": [0], "at_home": [1]},
    }
    trust = learned.trust
    if case == "small":
        # Hardly believed, hardly mixed: nothing is bounded.
        trust = SourceWeights(dict.fromkeys(trust.weights, 0.01), dict.fromkeys(trust.mixing, 0.0))
    else:
        trust = SourceWeights(
            {of: 0.7 + 0.2 * k for k, of in enumerate(trust.weights)}, dict.fromkeys(trust.mixing, 0.2)
        )
    learned = replace(learned, trust=trust)
    fused = learned.judge(scaled)[0][0]
    order = np.argsort(-fused)
    first, second = (int(order[k]) for k in ((2, 0) if case == "against" else (0, 1)))

    def odds(name: str, of: np.ndarray) -> float:
        said = learned.sources[name].judge(of)
        return sum(trust.weights[f"{name}.{p}"] * float(said[p][0][0, first] - said[p][0][0, second]) for p in (1, 2))

    expected = {}
    for name, source in learned.sources.items():
        usual = source.landmarks[learned.landmark_codes == second].mean(axis=0)
        for kind, which in kinds[name].items():
            other = scaled[name].copy()
            other[0, which] = usual[which]
            expected[kind] = odds(name, scaled[name]) - odds(name, other)
    plain, left = sum(odds(name, of) for name, of in scaled.items()), float(fused[first] - fused[second])
    assert (0 < left < 0.9 * plain) == (case == "bounded")
    share = left / plain if case == "bounded" else 1.0
    told = deciding_measures(learned, scaled, names, first, second)
    assert dict(told) == pytest.approx({kind: nats * share for kind, nats in expected.items()}, abs=1e-8)
    assert [nats for _, nats in told] == sorted((nats for _, nats in told), reverse=True)
    silent = scaled | {"numbers": np.full((1, 2), np.nan)}
    assert {name for name, _ in deciding_measures(learned, silent, names, 0, 1)} == {"area", "x", "flat"}


def test_strangeness_is_that_of_the_strangest_source_that_speaks() -> None:
    # Of each source the mean distance from classes, or half of the largest from training presses.
    views = [np.array([[1.0, 2.0], [5.0, 1.0]]), np.array([[2.0, 4.0], [3.0, 2.0]])]
    other = [np.array([[1.75, 0.5], [np.nan, np.nan]])]
    assert sources._strangeness([views]).tolist() == [2.0, 4.0]
    assert sources._strangeness([views, other]).tolist() == [2.0, 4.0]
    assert sources._strangeness([other, [0.1 * of for of in views]]).tolist() == [1.75, 0.4]
