"""The belief, its p-value, sizes and scores, and what a touch is worth, against plain sums over every example."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.perceive import Belief, Evidence, Library, NameEvidence, expected_information
from varishold.perceive.size_model import fit_size_model
from varishold.perceive.touch_model import TouchModel

SEEDS = st.integers(0, 2**32 - 1)
FEW = settings(max_examples=12, deadline=None)
MIDDLES = {"ball": (0.0, 0.0, 0.0), "box": (1.2, 0.4, 0.0), "cone": (0.3, 1.2, 0.8)}
TOUCHES = ("grasp", "higher", "tip")
#: Sizes that are told apart: 20 to 250 mm.
SIZES = np.linspace(np.log(0.02), np.log(0.25), 101)
# Each size is the middle of a step, here in many equal parts.
PARTS = SIZES[:, None] + (SIZES[1] - SIZES[0]) * ((np.arange(200) + 0.5) / 200 - 0.5)


def touch(name: str, middle: tuple[float, ...], rng: np.random.Generator, size_m: float) -> Evidence:
    form = np.add(middle, rng.normal(0, 0.6, 3))
    values = {f"form.{k}": x for k, x in enumerate(form)} | {"size.circle": np.log(size_m) + rng.normal(0, 0.05)}
    return Evidence(name, values)


def example(middle: tuple[float, ...], rng: np.random.Generator, size_m: float, *, slips: float) -> list[Evidence]:
    made = [touch(name, middle, rng, size_m) for name in TOUCHES[:2]]
    if rng.random() < slips:
        return [*made, Evidence("tip", {}, failed=True)]
    return [*made, touch("tip", middle, rng, size_m)] if rng.random() < 0.8 else made


@cache
def library(*, sized: bool = True, others: int = 25, slips: bool = True) -> Library:
    rng = np.random.default_rng(7)
    sizes = {name: rng.uniform(0.04, 0.12, 14 + 3 * k).tolist() for k, name in enumerate(MIDDLES)}
    examples = {
        name: [example(middle, rng, s, slips=0.3 * k * slips) for s in sizes[name]]
        for k, (name, middle) in enumerate(MIDDLES.items())
    }
    strange = [[touch(name, (-1.0, 1.0, 1.0), rng, 0.07) for name in TOUCHES] for _ in range(others)]
    return Library.from_examples(examples, sizes_m=sizes if sized else None, others=strange)


def units(model: TouchModel, values: np.ndarray) -> np.ndarray:
    """Values in standard units, cut at six; what an example lacks counts as the mean."""
    return np.nan_to_num(np.clip((values - model.metric.shift) / model.metric.scale, -6, 6))


def log_kernels(model: TouchModel, one: np.ndarray, others: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(1 + distance^2 / (d width^2)) ^ (-fall / 2) of each other, by what is known; fewer fall as much slower."""
    off = (units(model, one) - units(model, others))[:, known]
    inverse = np.linalg.inv(model.metric.covariance[np.ix_(known, known)])
    square = ((off @ inverse) * off).sum(axis=1)
    power = model.fall * np.sqrt(known.sum() / len(known))
    return np.asarray(-power / 2 * np.log(1 + square / (known.sum() * model.width**2)))


def without(of: Library, model: TouchModel, i: int) -> TouchModel:
    """The model with the metric of all examples but one; as much is added to its scatter as where it was learned.

    Of more than eight examples of known size a rest is that from their curve over size, otherwise from their mean.
    """
    made = np.flatnonzero(model.made)
    kept, d = made[made != i], model.values.shape[1]
    shift, scale = np.nanmean(model.values[kept], axis=0), np.nanstd(model.values[kept], axis=0)
    metric = replace(model.metric, shift=shift, scale=scale)
    at = units(replace(model, metric=metric), model.values)

    def degree(rows: np.ndarray) -> int:
        return 2 if len(rows) > 8 and np.isfinite(of.log_size).all() else 0

    def free(rows: np.ndarray) -> int:
        return len(rows) - sum(1 + degree(rows[of.owner[rows] == k]) for k in np.unique(of.owner[rows]))

    off = []
    for k in np.unique(of.owner[kept]):
        mine = kept[of.owner[kept] == k]
        along = of.log_size[mine] if degree(mine) else np.zeros(len(mine))
        for column in at[mine].T:
            curve = np.polyfit(along, column, 2) if degree(mine) else [column.mean()]
            off.append(column - np.polyval(curve, along))
    rests = np.array([np.concatenate(off[j::d]) for j in range(d)])
    covariance = rests @ rests.T / free(kept) + 0.2 * (1 + d / free(made)) * np.eye(d)
    return replace(model, metric=replace(metric, covariance=covariance))


def mean(values: np.ndarray) -> float:
    return float(np.log(np.mean(np.exp(values))))


def fails(of: Library, model: TouchModel, i: int) -> float:
    """How likely an example fails: .9 where it did, .1 where it did not, its object's share where it was not tried."""
    if not model.failed.any():
        return 0.0
    tried = model.failed | model.made
    if tried[i]:
        return 0.9 if model.failed[i] else 0.1
    own = of.owner == of.owner[i]
    return float((model.failed[own].sum() + 0.1) / (tried[own].sum() + 0.2))


class Plain:
    """The belief as a table of every example with every size."""

    def __init__(self, of: Library) -> None:
        self.of, self.sized = of, 0
        self.log = np.zeros(len(of))
        self.table, self.kept = np.zeros((2, len(of.objects), len(SIZES)))
        self.touches: list[tuple[TouchModel, np.ndarray]] = []
        self.prior = np.ones((len(of), len(SIZES)))
        for row, size in zip(self.prior, of.log_size, strict=True):
            if np.isfinite(size):
                row[:] = np.exp(-(((SIZES - size) / 0.08) ** 2) / 2)
            row /= row.sum()
        for k in range(len(of.objects)):
            mine = np.flatnonzero((of.owner == k) & np.isfinite(of.log_size))
            # Beside fewer than forty counts one more, of a size that is usual.
            if 0 < len(mine) < 40:
                wide = np.sqrt(0.3**2 + np.var(of.log_size[mine]))
                usual = np.exp(-(((SIZES - np.mean(of.log_size[mine])) / wide) ** 2) / 2)
                self.prior[mine] = (len(mine) * self.prior[mine] + usual / usual.sum()) / (len(mine) + 1)

    def feel(self, evidence: Evidence) -> None:
        of, model = self.of, self.of.touches[evidence.touch]
        values = evidence.vector(model.metric.names)
        known = np.isfinite(values)
        told = log_kernels(model, values, model.values, known) if known.any() else np.zeros(len(of))
        for i in range(len(of)):
            mine = np.flatnonzero((of.owner == of.owner[i]) & model.made)
            said = told[i] if model.made[i] or not known.any() else mean(told[mine])
            p = fails(of, model, i)
            # Where no example ever failed, a failure says nothing.
            self.log[i] += said + (np.log(p if evidence.failed else 1 - p) if p else 0.0)
        if model.size is not None and np.isfinite(size := evidence.vector(model.size.names)).all():
            self.sized += 1
            for k, (line, scale) in enumerate(zip(model.size.line, model.size.scale, strict=True)):
                off = (PARTS - line[:-1] @ size - line[-1]) / scale
                # Student's t of three degrees of freedom, on the mean over each step.
                self.table[k] += np.log(((1 + off**2 / 3) ** -2 / scale).mean(axis=1))
        if known.any():
            self.touches.append((model, values))

    def hear(self, said: NameEvidence) -> None:
        for k, name in enumerate(self.of.objects):
            odds = said.probability.get(name, 1 / len(said.probability)) * len(said.probability)
            self.log[self.of.owner == k] += said.weight * np.log(0.99 * odds + 0.01)

    def move(self) -> None:
        for k in range(len(self.of.objects)):
            mine = self.of.owner == k
            self.kept[k] += np.log(np.exp(self.log[mine]) @ self.prior[mine]) - np.log(self.prior[mine].sum(axis=0))
        self.log[:] = 0

    def joint(self) -> np.ndarray:
        table = self.table / (1 + 0.6 * max(self.sized - 1, 0)) + self.kept
        out = np.array(
            [
                self.prior[i] * np.exp(self.log[i] + table[k] - table.max()) / (self.of.owner == k).sum()
                for i, k in enumerate(self.of.owner)
            ]
        )
        return out / out.sum()

    def probability(self) -> dict[str, float]:
        joint = self.joint()
        return {name: float(joint[self.of.owner == k].sum()) for k, name in enumerate(self.of.objects)}

    def size(self, name: str) -> list[float]:
        """Median and interval: the sum up to the half step above each size, joined by straight lines."""
        k = self.of.objects.index(name)
        # Every example counts alike here, as each object has its own number of them.
        share = self.joint()[self.of.owner == k].sum(axis=0)
        edges, total = SIZES + (SIZES[1] - SIZES[0]) / 2, np.cumsum(share) / share.sum()
        out = []
        for wanted in (0.5, 0.025, 0.975):
            above = int(np.flatnonzero(total >= wanted)[0])
            part = (wanted - total[above - 1]) / (total[above] - total[above - 1])
            out.append(float(np.exp(edges[above - 1] + part * (edges[above] - edges[above - 1]))))
        return out

    def score(self, model: TouchModel, k: int, values: np.ndarray, known: np.ndarray, *, but: int = -1) -> float:
        own = [j for j in np.flatnonzero((self.of.owner == k) & model.made) if j != but]
        out = mean(log_kernels(model, values, model.values[own], known))
        return out - (mean(log_kernels(model, values, model.others, known)) if len(model.others) else 0)

    def own_score(self, model: TouchModel, i: int, known: np.ndarray) -> float:
        """Of an example, by the metric without it: the whole of its numbers tell what that takes off, part a part."""
        k, values, every = self.of.owner[i], model.values[i], np.ones(3, bool)
        with_it = self.score(model, k, values, every, but=i)
        off = with_it - self.score(without(self.of, model, i), k, values, every, but=i)
        return self.score(model, k, values, known, but=i) - known.mean() * off

    def p_value(self, name: str) -> float:
        """Fisher's product over touches of the share of own examples that conform no better, ranked among theirs.

        An object of so few examples must be as strange without its strangest touch, and what made some of the touches
        counts as if the others had felt as usual to it.
        """
        k, felt = self.of.objects.index(name), []
        for model, values in self.touches:
            known = np.isfinite(values)
            mine = np.flatnonzero((self.of.owner == k) & model.made)
            scores = {i: self.own_score(model, i, known) for i in mine}
            one = self.score(model, k, values, known)
            share = (1 + sum(s <= one for s in scores.values())) / (1 + len(scores))
            own = {
                i: -np.log((1 + sum(s <= scores[i] + 1e-12 for s in scores.values())) / (1 + len(scores)))
                for i in scores
            }
            felt.append((-np.log(share), own))

        def ranked(some: list[tuple[float, dict[int, float]]]) -> tuple[float, int]:
            told = [[own[i] for _, own in some if i in own] for i in np.flatnonzero(self.of.owner == k)]
            usual = [sum(own) * len(some) / len(own) for own in told if own]
            total = sum(one for one, _ in some)
            return (1 + sum(x >= total - 1e-9 for x in usual)) / (1 + len(usual)), len(usual)

        if not felt:
            return 1.0
        strangest = max(range(len(felt)), key=lambda t: felt[t][0])
        asked = [felt, felt[:strangest] + felt[strangest + 1 :]] if len(felt) > 1 else [felt]
        return max(map(ranked, asked), key=lambda told: told[0] * (1 + told[1]))[0]


def told(seed: int) -> list[Evidence | NameEvidence | None]:
    """Some touches, one of them with a number missing, perhaps one that failed, an answer, and a move (None)."""
    rng = np.random.default_rng(seed)
    middle, size_m = list(MIDDLES.values())[rng.integers(3)], rng.uniform(0.05, 0.1)
    felt: list[Evidence | NameEvidence | None] = [touch(name, middle, rng, size_m) for name in TOUCHES]
    part = touch("higher", middle, rng, size_m)
    felt[1] = Evidence("higher", {name: x for name, x in part.values.items() if name != "form.1"})
    if rng.random() < 0.4:
        felt[2] = Evidence("tip", {}, failed=True)
    shares = rng.dirichlet(np.ones(3))
    felt.append(
        NameEvidence("camera", dict(zip(("ball", "box", "egg"), shares, strict=True)), weight=rng.uniform(0.2, 1))
    )
    felt = [felt[k] for k in rng.permutation(4)[: rng.integers(1, 5)]]
    if rng.random() < 0.5:
        felt.insert(int(rng.integers(len(felt) + 1)), None)
    return felt


def both(of: Library, felt: list[Evidence | NameEvidence | None]) -> tuple[Belief, Plain]:
    belief, plain = Belief.before(of), Plain(of)
    for one in felt:
        belief = belief.in_new_place() if one is None else belief.after(one)
        if one is None:
            plain.move()
        else:
            plain.hear(one) if isinstance(one, NameEvidence) else plain.feel(one)
    return belief, plain


@FEW
@given(SEEDS, st.booleans(), st.booleans())
def test_the_belief_is_the_sum_over_every_example_and_size(seed: int, sized: bool, slips: bool) -> None:
    belief, plain = both(library(sized=sized, slips=slips), told(seed))
    assert belief.probability == pytest.approx(plain.probability(), rel=1e-3, abs=1e-6)
    assert list(belief.probability.values()) == sorted(belief.probability.values(), reverse=True)
    np.testing.assert_allclose(belief.particles, plain.joint().sum(axis=1), rtol=1e-3, atol=1e-7)
    for name in MIDDLES:
        size = belief.size(name)
        assert (size is not None) == sized
        if size is not None:
            assert list(size) == pytest.approx(plain.size(name), rel=1e-3)


@FEW
@given(SEEDS, st.sampled_from([0, 25]))
def test_the_p_value_ranks_all_touches_among_those_of_the_examples(seed: int, others: int) -> None:
    felt = [one for one in told(seed) if not isinstance(one, NameEvidence)]
    belief, plain = both(library(others=others), felt)
    # Sums in single precision may tie or not with those of one example.
    n = min(int(count) for count in library().counts)
    assert belief.p_value == pytest.approx(plain.p_value(belief.best), abs=1.01 / n)


@pytest.mark.parametrize("others", [0, 25])
def test_p_values_agree_but_for_a_rare_tie(others: int) -> None:
    rng, same, n = np.random.default_rng(3), 0, 40
    for k in range(n):
        felt = [touch("grasp", list(MIDDLES.values())[k % 3], rng, 0.07), touch("higher", (1.0, 1.0, 1.0), rng, 0.07)]
        belief, plain = both(library(others=others), list(felt[: 1 + k % 2]))
        same += belief.p_value == pytest.approx(plain.p_value(belief.best))
    assert same >= 0.9 * n


@pytest.mark.parametrize("others", [0, 25])
@pytest.mark.parametrize("name", TOUCHES)
def test_scores_are_of_every_example_under_the_others_of_its_object(name: str, others: int) -> None:
    of = library(others=others)
    plain, model = Plain(of), of.touches[name]
    known = np.ones(3, bool)
    for i in range(len(of)):
        score = plain.own_score(model, i, known) if model.made[i] else np.nan
        assert model.scores[i] == pytest.approx(score, abs=1e-3, nan_ok=True)


@pytest.mark.parametrize("name", TOUCHES)
def test_the_power_is_the_share_of_the_likest_strangers_that_own_examples_seldom_conform_as_badly_as(name: str) -> None:
    of = library()
    model, known = of.touches[name], np.ones(3, bool)
    for k in range(len(of.objects)):
        odds = []
        for j, row in enumerate(model.others):
            rest = log_kernels(model, row, np.delete(model.others, j, axis=0), known)
            mine = log_kernels(model, row, model.values[(of.owner == k) & model.made], known)
            odds.append(mean(mine) - mean(rest))
        usual = [model.scores[i] for i in np.flatnonzero((of.owner == k) & model.made)]
        likest = sorted(odds)[-(len(odds) // 10) :]
        assert model.power[k] == pytest.approx(np.mean([x <= np.quantile(usual, 0.02) for x in likest]))
    assert np.isnan(library(others=0).touches[name].power).all()


@pytest.mark.parametrize("name", TOUCHES)
def test_the_kernel_is_the_one_that_names_examples_best_when_they_are_left_out(name: str) -> None:
    of = library()
    model, known = of.touches[name], np.ones(3, bool)
    made = np.flatnonzero(model.made)
    own = of.owner[made]
    # Of each object its examples, but for the one that is left out.
    counts = [(own == k) & ~np.eye(len(made), dtype=bool) for k in range(3)]
    alone = {i: without(of, model, i) for i in made}
    losses = {}
    for width in (0.7, 1.0, 1.4):
        for fall in (5.0, 10.0, 20.0, 40.0, 80.0):
            tried = {i: replace(by, width=width, fall=fall) for i, by in alone.items()}
            table = np.array([log_kernels(by, by.values[i], by.values[made], known) for i, by in tried.items()])
            p = np.array([np.mean(np.exp(table), axis=1, where=counted) for counted in counts])
            losses[width, fall] = np.mean(-np.log(p[own, np.arange(len(made))] / p.sum(axis=0)))
    assert (model.width, model.fall) == min(losses, key=lambda kernel: losses[kernel])


# What a touch is worth


def worth(of: Library, belief: Belief, name: str) -> float:
    """Expected loss of entropy: every example is felt in turn and explained by all others."""
    model, particles = of.touches[name], belief.particles
    known = np.ones(len(model.metric.names), bool)
    failing = np.array([fails(of, model, i) for i in range(len(of))])
    members = [of.owner == k for k in range(len(of.objects))]
    now = np.array([particles[mine].sum() for mine in members])
    failed = np.array([(particles * failing)[mine].sum() for mine in members])
    weight = np.where(model.made, particles * (1 - failing), 0.0)
    for mine, of_name in zip(members, now - failed, strict=True):
        weight[mine] *= of_name / weight[mine].sum()
    left = failed.sum() * entropy(failed / failed.sum()) if failed.sum() else 0.0
    for i in np.flatnonzero(weight):
        like = np.exp(log_kernels(model, model.values[i], model.values, known))
        after = np.zeros(len(members))
        for k, mine in enumerate(members):
            rest = np.where(mine & model.made, weight, 0.0)
            whole = rest.sum()
            rest[i] = 0.0
            # Of its own object the others stand for it too.
            after[k] = whole * (rest @ np.nan_to_num(like)) / rest.sum()
        left += weight[i] * entropy(after / after.sum())
    return entropy(now) - left


def entropy(p: np.ndarray) -> float:
    return float(-sum(x * np.log(x) for x in p if x > 0))


@cache
def forty_eight(apart: float) -> Library:
    """Three objects of sixteen examples each: as many as outcomes are imagined, so that each is imagined once."""
    rng = np.random.default_rng(5)
    return Library.from_examples(
        {
            name: [[Evidence("grasp", {"a": apart * k + rng.normal(), "b": rng.normal()})] for _ in range(16)]
            for k, name in enumerate(MIDDLES)
        }
    )


@pytest.mark.parametrize("apart", [0.5, 1.5, 3.0])
def test_where_every_example_is_imagined_once_the_worth_is_exact(apart: float) -> None:
    of = forty_eight(apart)
    belief = Belief.before(of)
    assert expected_information(belief, "grasp") == pytest.approx(worth(of, belief, "grasp"), rel=1e-4, abs=1e-6)


@FEW
@given(SEEDS, st.integers(0, 2))
def test_few_imagined_outcomes_tell_nearly_what_all_do(seed: int, n: int) -> None:
    of = library()
    rng = np.random.default_rng(seed)
    belief = Belief.before(of)
    for name in TOUCHES[:n]:
        belief = belief.after(touch(name, tuple(rng.uniform(0, 1, 3)), rng, 0.07))
    doubt = entropy(np.array(list(belief.probability.values())))
    for name in TOUCHES:
        # What was felt whole errs again as it did.
        told = 0.0 if name in belief.here and belief.here[name].whole else max(0.0, worth(of, belief, name))
        assert expected_information(belief, name) == pytest.approx(told, abs=0.12 * doubt)


# Sizes


def plain_line(x: np.ndarray, y: np.ndarray, ridge: float) -> tuple[np.ndarray, float]:
    """Slopes and offset, and the scale of what examples are off."""
    (n, m), weight = x.shape, np.ones(len(y))
    for _ in range(12):
        root = np.sqrt(weight)[:, None]
        # Slopes are drawn towards an even share each, the offset is free.
        rows = np.vstack([root * np.column_stack([x, np.ones(n)]), np.sqrt(ridge) * np.eye(m, m + 1)])
        aim = np.concatenate([root[:, 0] * y, np.full(m, np.sqrt(ridge) / m)])
        line = np.linalg.lstsq(rows, aim, rcond=None)[0]
        off = y - x @ line[:-1] - line[-1]
        scale = max(0.004, 1.2 * np.median(np.abs(off)) * (1 + 2 / n))
        weight = 4 / (3 + (off / scale) ** 2)
    return line, scale


@FEW
@given(SEEDS, st.integers(1, 3), st.integers(3, 30) | st.integers(38, 48))
def test_a_size_line_is_ridge_regression_with_the_weights_of_students_t(seed: int, m: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    y = rng.uniform(-3.2, -2.2, n)
    x = y[:, None] + rng.normal(0, 0.1, (n, m))
    x[0, 0] = np.nan
    model = fit_size_model(tuple(f"size.{k}" for k in range(m)), x, y, np.zeros(n, np.int64))
    known_x, known_y = x[1:], y[1:]
    line, scale = plain_line(known_x, known_y, 1e-3 if n > 40 else 0.1)
    if n <= 40:
        # Of few each is as far off as it is off the line of the others.
        off = []
        for k in range(n - 1):
            of_others, _ = plain_line(np.delete(known_x, k, axis=0), np.delete(known_y, k), 0.1)
            off.append(known_y[k] - known_x[k] @ of_others[:-1] - of_others[-1])
        scale = max(0.004, 1.2 * np.median(np.abs(off)) * (1 + 2 / (n - 1)))
    np.testing.assert_allclose(model.line[0], line, rtol=1e-5, atol=1e-6)
    assert model.scale[0] == pytest.approx(scale, rel=1e-5)
