"""Laws of the ways to learn: what is drawn, chosen, covered, cut and compared, against plain counting."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize

from varishold.errors import FormatError, InputError
from varishold.grasp import HyperplaneClassifier, ThresholdEncoder, fit_model, read_model, shift_variants, write_model
from varishold.grasp.comparison import as_good, clearly_best, deal_folds, noisy_copies
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.cover import _by_integer_program, smallest_cover
from varishold.grasp.encoder import _resolution
from varishold.grasp.hyperplanes import Hyperplanes, roman
from varishold.grasp.likelihood import hamming, learn_likelihood
from varishold.grasp.modes import MODES, ModeOptions, vote
from varishold.grasp.modes.decoders import DECODERS, choose_decoder
from varishold.grasp.modes.paper import _widest_first, all_bisectors
from varishold.grasp.selection import choose_mode, remark_on_noise
from varishold.grasp.training import training_grasps
from varishold.grasp.variants import with_variants
from varishold.recording import GraspTable

seeds = st.integers(0, 2**31)
few = settings(max_examples=20)


def grasps_of(rng, n=40, switches=24, classes=3, noise=0.1):
    """Grasps that differ from their class's typical one in a few switches, as many of each class."""
    typical = rng.random((classes, switches)) < 0.5
    labels = np.arange(n) % classes
    return training_grasps(typical[labels] ^ (rng.random((n, switches)) < noise), labels.tolist())


# ---- thresholds


@few
@given(seeds, st.integers(1, 6))
def test_thresholds_lie_at_equal_shares_or_equal_steps(seed, levels):
    rng = np.random.default_rng(seed)
    x = np.rint(rng.exponential(40, 60)) * (rng.random(60) < 0.8)
    low, high = x.min(), x.max()
    even = ThresholdEncoder("even", levels=levels).fit(x[:, None]).thresholds_[0]
    expected = {np.ceil(low + (high - low) * k / (levels + 1)) for k in range(1, levels + 1)}
    assert set(even) == expected
    above = np.sort(x[x > low])
    shares = [np.interp(k / levels * (len(above) - 1), np.arange(len(above)), above) for k in range(levels)]
    assert set(ThresholdEncoder("quantile", levels=levels).fit(x[:, None]).thresholds_[0]) == set(np.ceil(shares))
    both = np.column_stack([x, 2 * x])
    shared = ThresholdEncoder("even", levels=levels, shared=True).fit(both)
    assert set(shared.thresholds_[0]) == {
        np.ceil(low + (2 * high - low) * k / (levels + 1)) for k in range(1, levels + 1)
    }
    assert shared.thresholds_[0] is shared.thresholds_[1] or (shared.thresholds_[0] == shared.thresholds_[1]).all()
    assert list(shared.resolution_) == [1.0, 1.0]


def test_four_thresholds_unless_said_otherwise_and_one_for_what_never_changes():
    x = np.column_stack([np.arange(100.0), np.full(100, 7.0)])
    for strategy in ("quantile", "even", "supervised"):
        encoder = ThresholdEncoder(strategy).fit(x, np.arange(100) // 20)
        assert [len(t) for t in encoder.thresholds_] == [4, 1]
        assert encoder.thresholds_[1].tolist() == [7.0]
        assert encoder.bits_per_channel_.tolist() == [4, 1]
    assert ThresholdEncoder().strategy == "quantile"
    # Five classes in a row part at four places.
    told = ThresholdEncoder("supervised").fit(x, np.arange(100) // 20).thresholds_[0]
    assert told.tolist() == [20, 40, 60, 80]
    assert ThresholdEncoder("even", levels=1).fit(x).thresholds_[0].tolist() == [50]
    for levels in (0, 1025):
        with pytest.raises(InputError, match=f"between 1 and 1024, got {levels}"):
            ThresholdEncoder(levels=levels).fit(x)
    assert len(ThresholdEncoder("even", levels=1024).fit(np.arange(5000.0)[:, None]).thresholds_[0]) == 1024
    with pytest.raises(InputError, match=r"got 2e\+30 in row 1, channel 0"):
        ThresholdEncoder().fit([[0.0], [2e30]])
    ThresholdEncoder().fit([[0.0], [1e30]])
    with pytest.raises(InputError, match="requires y"):
        ThresholdEncoder("supervised").fit(x)


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6))
def test_a_count_is_a_power_of_two_that_parts_the_range_into_65536_or_more(low, span):
    x = np.array([low, low + span, low + 0.37 * span, low + 0.51 * span])
    step = _resolution(x)
    if (x == np.trunc(x)).all():
        assert step == 1
        return
    assert np.log2(step) == int(np.log2(step))
    # At least so many counts, unless they would not fit the circuit's integers; and not twice as many.
    assert np.abs(x).max() / step <= 2**31 / 4
    if np.abs(x).max() < 1000 * np.ptp(x):
        # The range of numbers that were added up is off by their rounding.
        assert 2**16 * (1 - 1e-9) <= np.ptp(x) / step < 2**17
    assert _resolution(np.array([0.0, 2.0**31 - 1])) == 1.0
    assert _resolution(np.array([0.0, 2.0**31])) > 1.0
    assert _resolution(np.array([0.5, 0.5])) > 0


@given(st.integers(1, 4), st.integers(1, 5), st.integers(1, 2), st.booleans(), st.booleans())
@settings(max_examples=40)
def test_a_shifted_array_reads_its_neighbours(rows, cols, distance, diagonal, encoded):
    shape = (2, rows, cols)
    n = 2 * rows * cols
    bits = 1 + np.arange(n) % 3 if encoded else np.ones(n, int)
    starts = np.concatenate([[0], np.cumsum(bits)])
    found = shift_variants(shape, distance=distance, diagonal=diagonal, bits=bits if encoded else None)
    expected = []
    for down in range(-distance, distance + 1):
        for right in range(-distance, distance + 1):
            if (down, right) == (0, 0) or (down and right and not diagonal) or abs(down) >= rows or abs(right) >= cols:
                continue
            row = []
            for pad in range(2):
                for r in range(rows):
                    for c in range(cols):
                        to = pad * rows * cols + r * cols + c
                        inside = 0 <= r - down < rows and 0 <= c - right < cols
                        of = pad * rows * cols + (r - down) * cols + c - right
                        for rank in range(bits[to]):
                            row.append(int(starts[of] + min(rank, bits[of] - 1)) if inside else -1)
            expected.append(row)
    assert sorted(found.tolist()) == sorted(expected)
    assert found.shape == (len(expected), int(bits.sum()))


def test_axes_of_a_shift_may_be_any():
    along = shift_variants((3, 2), axes=(1, 0))
    plain = shift_variants((3, 2))
    assert sorted(along.tolist()) == sorted(plain.tolist())
    assert shift_variants((1, 1)).shape == (0, 1)


# ---- what vote draws and chooses


@few
@given(seeds)
def test_a_drawn_hyperplane_parts_two_enemies_on_an_odd_number_of_their_switches(seed):
    rng = np.random.default_rng(seed)
    grasps = grasps_of(rng, classes=4)
    planes = vote._draw(grasps, 200, rng)
    row_of = {int(number): k for k, number in enumerate(grasps.numbers)}
    widths = set()
    met = set()
    for weights, (first, second) in zip(planes.weights, planes.pairs.tolist(), strict=True):
        one, other = row_of[first], row_of[second]
        assert grasps.labels[one] != grasps.labels[other]
        met.add(frozenset((int(grasps.labels[one]), int(grasps.labels[other]))))
        differ = grasps.patterns[one] ^ grasps.patterns[other]
        used = weights != 0
        assert not (used & ~differ).any()
        width = int(used.sum())
        widths.add(width)
        assert width % 2 == 1
        assert width <= max(1, differ.sum() // 2)
        # The first lies on the positive side, wherever the two differ.
        assert ((weights[used] > 0) == grasps.patterns[one][used]).all()
    assert widths <= set(vote.WIDTHS)
    assert max(widths) >= 5
    assert len(met) == 6


def test_wide_differences_are_drawn_in_every_width():
    rng = np.random.default_rng(0)
    pattern = rng.random(40) < 0.5
    grasps = training_grasps(np.array([pattern, ~pattern]), [0, 1])
    counts = np.bincount((vote._draw(grasps, 200, rng).weights != 0).sum(axis=1), minlength=10)
    assert set(np.flatnonzero(counts)) == set(vote.WIDTHS)
    # Each width is drawn as often; only of the narrowest are there fewer than draws.
    assert counts[3] == counts[5] == counts[7] == counts[9] == 40


@settings(max_examples=8)
@given(seeds)
def test_hyperplanes_are_chosen_by_the_pairs_that_still_want_them(seed):
    rng = np.random.default_rng(seed)
    grasps = grasps_of(rng, 14, 16)
    candidates = vote._draw(grasps, 40, rng)
    wanted = 12
    chosen = vote._multicover(grasps, candidates, wanted, np.random.default_rng(seed))
    assert len(set(chosen.tolist())) == len(chosen) == min(wanted, len(candidates))
    if len(candidates) <= wanted:
        return
    signs = candidates.signs(grasps.patterns)
    # So few grasps have all their pairs judged.
    pairs = [(i, j) for i, j in combinations(range(len(grasps)), 2) if grasps.labels[i] != grasps.labels[j]]
    hunger = dict.fromkeys(pairs, 1.0)
    for step, best in enumerate(chosen.tolist()):
        worth = [sum(h for (i, j), h in hunger.items() if signs[i, k] != signs[j, k]) for k in range(len(candidates))]
        free = [w for k, w in enumerate(worth) if k not in chosen[:step]]
        assert worth[best] == pytest.approx(max(free), rel=1e-5)
        for i, j in pairs:
            if signs[i, best] != signs[j, best]:
                hunger[i, j] *= 0.9
    few_wanted = vote._multicover(grasps, candidates, len(candidates), rng)
    assert few_wanted.tolist() == list(range(len(candidates)))


def test_as_few_hyperplanes_are_taken_as_tell_as_well():
    rng = np.random.default_rng(3)
    easy = grasps_of(rng, 160, 24, 2, noise=0.06)
    learned = vote.learn_vote(easy, ModeOptions(decoder="least squares, ridge 0.1"))
    assert len(learned.hyperplanes) <= 150
    # Too few grasps tell nothing of what is as good.
    scarce = grasps_of(rng, 60, 24, 2, noise=0.1)
    many = vote.learn_vote(scarce, ModeOptions(decoder="least squares, ridge 0.1"))
    assert len(many.hyperplanes) > 150
    told = vote.learn_vote(easy, ModeOptions(max_hyperplanes=31))
    assert 0 < len(told.hyperplanes) <= 31
    assert told.notes["decoder"] in DECODERS
    for mode in (learned, many, told):
        weights = [abs(w) for score in mode.netlist.scores for _, w in score.weights]
        assert max(weights) == 30
        assert all(w % 2 == 0 for w in weights)


def test_kept_hyperplanes_stay_first():
    rng = np.random.default_rng(5)
    grasps = grasps_of(rng)
    keep = Hyperplanes(np.array([[1] + 23 * [0], 23 * [0] + [1]], dtype=np.int8))
    for name, learn in MODES.items():
        learned = learn(grasps, ModeOptions(keep=keep, max_hyperplanes=20))
        np.testing.assert_array_equal(learned.hyperplanes.weights[:2], keep.weights, err_msg=name)
        answers = CompiledCircuit(learned.netlist).evaluate(grasps.patterns)
        assert (answers == grasps.labels).mean() > 0.9


# ---- comparisons


@few
@given(seeds, st.integers(2, 5))
def test_folds_deal_each_classes_groups_evenly_and_whole(seed, count):
    rng = np.random.default_rng(seed)
    groups = rng.integers(0, 15, 40)
    labels = groups % 3
    folds = deal_folds(labels, groups, count, rng)
    for label in range(3):
        own = np.unique(groups[labels == label])
        fold_of = [set(folds[groups == g].tolist()) for g in own]
        assert all(len(fold) == 1 for fold in fold_of)
        sizes = np.bincount([fold.pop() for fold in fold_of], minlength=count)
        assert sizes.max() - sizes.min() <= 1


def test_copies_stand_together_and_read_wrongly_at_their_rate():
    rng = np.random.default_rng(0)
    patterns = rng.random((50, 30)) < 0.5
    copies = noisy_copies(patterns, 40, 0.07, rng)
    assert copies.shape == (2000, 30)
    wrong = copies.reshape(50, 40, 30) ^ patterns[:, None]
    assert wrong.mean() == pytest.approx(0.07, abs=0.004)
    np.testing.assert_array_equal(noisy_copies(patterns, 1, 0.0, rng), patterns)


def test_a_candidate_must_lead_by_two_standard_errors():
    right = np.zeros((3, 100))
    right[0, :50] = 1
    right[1, :54] = 1  # four more, standard deviation .196: two errors are 3.9
    assert clearly_best(right, 0) == 1
    right[1, 53] = 0  # three more: two errors are 3.4
    assert clearly_best(right, 0) == 0
    right[2, :70] = 1
    assert clearly_best(right, 0) == 2
    assert clearly_best(np.zeros((3, 0)), 1) == 1
    assert clearly_best(np.ones((3, 10)), 2) == 2


def test_what_is_worse_by_a_hundredth_and_a_standard_error_is_not_as_good():
    best = np.ones(400)
    for missed, good in ((0, True), (4, True), (6, True), (8, False), (40, False)):
        right = best.copy()
        right[:missed] = 0
        lead = right - best
        assert (lead.mean() - lead.std() / 20 >= -0.01) == as_good(right, best)
        assert as_good(right, best) == good or missed in (4, 6)


def test_a_mode_is_chosen_where_enough_grasps_tell():
    rng = np.random.default_rng(7)
    options = ModeOptions()
    clear = grasps_of(rng, 118, 20, 2, noise=0.12)
    assert 100 <= len(clear) <= 120
    assert choose_mode(clear, options) in ("paper", "robust")
    few_ = grasps_of(rng, 90, 20, 2, noise=0.05)
    assert choose_mode(few_, options) == "vote"
    # A hundred copies of ten grasps are ten grasps.
    copies = replace(options, groups=tuple(k % 10 for k in range(len(clear))))
    assert choose_mode(clear, copies) == "vote"
    lonely = replace(clear, labels=np.where(np.arange(len(clear)) == 0, 2, clear.labels), classes=(0, 1, 2))
    assert choose_mode(lonely, options) == "vote"


def test_a_circuit_that_bears_noise_badly_is_remarked_on():
    rng = np.random.default_rng(8)
    grasps = grasps_of(rng, 80, 16, 6, noise=0.1)
    likelihood = learn_likelihood(grasps)
    frail = CompiledCircuit(MODES["paper"](grasps, ModeOptions(time_limit_s=0.0)).netlist)
    told = remark_on_noise(frail, grasps, likelihood.flip_rate, "paper")
    assert told is not None
    shares = [int(number) / 100 for number in re.findall(r"(\d+)%", told)]
    right, rate, nearest = shares
    assert rate == pytest.approx(min(0.1, likelihood.flip_rate), abs=0.006)
    noisy = noisy_copies(grasps.patterns, 50, min(0.1, likelihood.flip_rate), rng)
    truth = np.repeat(grasps.labels, 50)
    assert right == pytest.approx((frail.evaluate(noisy) == truth).mean(), abs=0.08)
    assert nearest == pytest.approx(
        (grasps.labels[hamming(noisy, grasps.patterns).argmin(axis=1)] == truth).mean(), abs=0.06
    )
    assert nearest - right > 0.1
    assert "mode 'vote' does better" in told
    sturdy = CompiledCircuit(MODES["vote"](grasps, ModeOptions()).netlist)
    assert remark_on_noise(sturdy, grasps, likelihood.flip_rate, "vote") is None


@settings(max_examples=5)
@given(seeds)
def test_the_decoder_that_is_chosen_is_one_that_answers(seed):
    rng = np.random.default_rng(seed)
    labels = np.arange(30) % 3
    signs = np.where(rng.random((3, 20))[labels] < 0.5, -1.0, 1.0)
    weights, groups = np.ones(30, np.int64), np.arange(30)
    # All answer everything rightly: nothing is clearly better than the usual one.
    assert choose_decoder(signs, labels, weights, groups, 3, rng) == "least squares, ridge 0.1"


# ---- covers


def fewest(cover):
    for size in range(1, cover.shape[1] + 1):
        for columns in combinations(range(cover.shape[1]), size):
            if cover[:, columns].any(axis=1).all():
                return size
    raise AssertionError


@few
@given(seeds)
def test_a_smallest_cover_is_as_small_as_any(seed):
    rng = np.random.default_rng(seed)
    cover = rng.random((9, 8)) < 0.35
    cover[np.arange(9), rng.integers(0, 8, 9)] = True
    size = fewest(cover)
    columns, bound = smallest_cover(cover, upper=size + 2, lower=1, time_limit_s=5.0)
    assert len(columns) == bound == size
    assert cover[:, columns].any(axis=1).all()
    assert smallest_cover(cover, upper=size, lower=1, time_limit_s=5.0) == (None, size)
    assert smallest_cover(cover, upper=size + 2, lower=1, time_limit_s=0) == (None, 1)
    if size > 1:
        known = [int(k) for k in range(size + 2)]
        own = np.arange(cover.shape[1])
        found, proved = _by_integer_program(cover, own, known, size + 2, 1, 5.0)
        assert len(found) == proved == size
        assert cover[:, found].any(axis=1).all()
        # What is known to be smallest is not looked for, and no bound is lost.
        assert _by_integer_program(cover, own, None, size, size, 5.0) == (None, size)
        _, proved = _by_integer_program(cover, own, None, size, 1, 5.0)
        assert proved == size


@pytest.mark.parametrize(("taken_s", "left_s"), [(3.0, 2.0), (5.0, None)])
def test_the_relaxation_takes_of_the_time_of_the_integer_program(monkeypatch, taken_s, left_s):
    clock, limits = [0.0], []
    solve = optimize.linprog, optimize.milp

    def relaxed(*given, **options):
        limits.append(options["options"]["time_limit"])
        clock[0] += taken_s
        found = solve[0](*given, **options)
        found.fun = 1.0  # nothing is proved
        return found

    def program(*given, **options):
        limits.append(options["options"]["time_limit"])
        return solve[1](*given, **options)

    monkeypatch.setattr(optimize, "linprog", relaxed)
    monkeypatch.setattr(optimize, "milp", program)
    monkeypatch.setattr("varishold.grasp.cover.monotonic", lambda: clock[0])
    found = _by_integer_program(np.eye(3, dtype=np.bool_), np.arange(3), None, 4, 1, 5.0)
    assert limits == [5.0, *([] if left_s is None else [left_s])]
    assert found == ((None, 1) if left_s is None else ([0, 1, 2], 3))


# ---- the classifier


def test_a_switch_is_on_above_its_threshold():
    x = np.array([[0.5, 0.2], [0.51, 0.9], [0.2, 0.5], [0.9, 0.49]])
    classifier = HyperplaneClassifier("paper", binarize=0.5).fit(x, [0, 1, 0, 1])
    np.testing.assert_array_equal(classifier._rows, x > 0.5)
    assert classifier.predict([[0.5, 0.5]]).tolist() == classifier.predict([[0.0, 0.0]]).tolist()


def test_options_of_the_classifier_have_limits():
    x, y = [[0, 1], [1, 0]], [0, 1]
    for options, words in (
        ({"flip_rate": 0.5}, "flip_rate must be at least 0 and below 0.5"),
        ({"flip_rate": -0.01}, "flip_rate"),
        ({"max_hyperplanes": 0}, "max_hyperplanes must be positive"),
        ({"mode": "best"}, "mode must be auto"),
    ):
        with pytest.raises(InputError, match=words):
            HyperplaneClassifier(**options).fit(x, y)
    for options in ({"flip_rate": 0.0}, {"flip_rate": 0.49}, {"max_hyperplanes": 1}):
        assert HyperplaneClassifier(**options).fit(x, y).predict(x).tolist() == y


def test_remarks_tell_of_repeated_and_contradictory_grasps():
    x = np.array([[0, 0, 1], [0, 0, 1], [1, 1, 0], [1, 1, 0], [1, 1, 0], [0, 1, 0], [0, 1, 0], [1, 0, 0]])
    y = ["a", "a", "b", "b", "b", "a", "c", "c"]
    classifier = HyperplaneClassifier("vote").fit(x, y)
    assert classifier.remarks_[0] == "grasps 6, 7 have equal patterns but different labels"
    assert classifier.remarks_[1] == "3 grasps repeat the pattern and label of an earlier one"
    only = HyperplaneClassifier("vote").fit([[0, 1], [0, 1], [1, 0], [1, 1]], ["a", "b", "c", "d"])
    assert [r for r in only.remarks_ if r.startswith("nothing tells")] == [
        "nothing tells a: all its grasps contradict others",
        "nothing tells b: all its grasps contradict others",
    ]
    many = HyperplaneClassifier("vote").fit([[0, 1]] * 8 + [[1, 0]], [0, 1] * 4 + [0])
    assert many.remarks_[0] == "grasps 1, 2, 3, 4, 5, 6 and 2 more have equal patterns but different labels"


@few
@given(seeds)
def test_variants_are_learned_as_copies_of_their_grasp(seed):
    rng = np.random.default_rng(seed)
    grasps = grasps_of(rng, 12, 6, 2)
    maps = rng.integers(-1, 6, (3, 6))
    taught, options = with_variants(grasps, ModeOptions(), maps)
    copies = {}
    for way in [np.arange(6), *maps]:
        for k, pattern in enumerate(grasps.patterns):
            read = tuple(bool(pattern[s]) if s >= 0 else False for s in way)
            copies.setdefault(read, k)
    assert {tuple(map(bool, p)) for p in taught.patterns} == set(copies)
    for pattern, label, weight, number, group in zip(
        taught.patterns, taught.labels, taught.weights, taught.numbers, options.groups, strict=True
    ):
        k = copies[tuple(map(bool, pattern))]
        assert group == k
        assert (label, weight, number) == (grasps.labels[k], grasps.weights[k], grasps.numbers[k])
    assert with_variants(grasps, ModeOptions(), None) == (grasps, ModeOptions())
    for wrong in (np.full((1, 6), 6), np.full((1, 6), -2), np.zeros((1, 5), int), np.zeros((1, 6)), np.zeros(6, int)):
        with pytest.raises(InputError, match=r"variants must be integers from -1 to 5 of shape \(n_variants, 6\)"):
            with_variants(grasps, ModeOptions(), wrong)


@few
@given(seeds)
def test_the_answer_is_the_likeliest_class_and_the_odd_is_rejected(seed):
    rng = np.random.default_rng(seed)
    typical = rng.random((3, 20)) < 0.5
    y = np.arange(45) % 3
    x = typical[y] ^ (rng.random((45, 20)) < 0.05)
    classifier = HyperplaneClassifier("paper").fit(x, y)
    asked = rng.random((30, 20)) < 0.5
    p = classifier.predict_proba(asked)
    np.testing.assert_allclose(p.sum(axis=1), 1)
    np.testing.assert_array_equal(classifier.classes_[p.argmax(axis=1)], classifier.predict(asked))
    _, rejected = classifier.predict_or_reject(asked)
    _, _, p_values = classifier.judge(asked)
    np.testing.assert_array_equal(rejected, p_values <= 0.05)
    _, doubted = classifier.predict_or_reject(asked, min_probability=0.8)
    np.testing.assert_array_equal(doubted, rejected | (p.max(axis=1) < 0.8))


# ---- model files


@pytest.fixture(scope="module")
def document(tmp_path_factory):
    rng = np.random.default_rng(0)
    kind = np.arange(24) % 2
    table = GraspTable({"what": np.array(["a", "b"])[kind], **{f"f{k}": rng.normal(3 * kind, 1) for k in range(3)}})
    path = tmp_path_factory.mktemp("model") / "model.json"
    write_model(fit_model(table, label="what", mode="paper", encode="even", levels=2), path)
    return json.loads(path.read_text())


CHANGES = {
    "version": [(0, "version must be"), (True, "version must be"), (4, "is of version 4"), ("1", "version must be")],
    "format": [("other", "is no model file")],
    "classes": [(["a"], "two or more"), (["b", "a"], "in order"), (["a", "a"], "different"), ("ab", "list of texts")],
    "labels": [
        ([0], "24 grasps need as many labels, got 1"),
        ([2] * 24, "labels must be .* from 0 to 1"),
        ([-1] * 24, "labels"),
    ],
    "grasps": [
        (["01"] * 24, r"grasps\[0\] must be 6 characters"),
        (["01010x"] * 24, "characters 0 or 1"),
        ([], "grasps need"),
    ],
    "label": [(5, "label must be the name of a column")],
    "columns": [(["f0"], "encoder must have"), ([1, 2, 3], "columns must be a list of texts")],
    "mode": [("best", "mode must be")],
    "hyperplanes": [({}, "hyperplanes must be a list"), ([], "do not belong together")],
    "selection": [
        ({"columns": [-1], "lower_bound": 1}, "selection columns must be"),
        ({"columns": [0], "lower_bound": 2**31 + 1}, "lower bound"),
    ],
}


@pytest.mark.parametrize(("key", "value", "words"), [(key, *each) for key, some in CHANGES.items() for each in some])
def test_a_model_that_does_not_hold_together_is_refused(document, tmp_path, key, value, words):
    path = tmp_path / "model.json"
    path.write_text(json.dumps({**document, key: value}))
    with pytest.raises(FormatError, match=words):
        read_model(path)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"resolution": [0.0, 1.0, 1.0]}, "positive resolution"),
        ({"resolution": [1.0, 1.0]}, "for every column"),
        ({"thresholds": [[1.0]] * 2}, "for every column"),
        ({"thresholds": [[2.0, 1.0]] + [[1.0, 2.0]] * 2}, "rising finite"),
        ({"thresholds": [[1.0, 1.0]] + [[1.0, 2.0]] * 2}, "rising finite"),
        ({"thresholds": [[]] + [[1.0, 2.0]] * 2}, "rising finite"),
        ({"thresholds": [[1.0, 2.0**31]] * 3, "resolution": [1.0] * 3}, "32 signed bits"),
        ({"thresholds": [[-(2.0**31), 2.0]] * 3, "resolution": [1.0] * 3}, "32 signed bits"),
        ({"levels": 0}, "levels must lie between 1 and 1024"),
    ],
)
def test_an_encoder_that_cannot_be_is_refused(document, tmp_path, part, words):
    path = tmp_path / "model.json"
    path.write_text(json.dumps({**document, "encoder": {**document["encoder"], **part}}))
    with pytest.raises(FormatError, match=words):
        read_model(path)


def test_a_model_comes_back_as_it_was(document, tmp_path):
    path = tmp_path / "model.json"
    path.write_text(json.dumps(document))
    model = read_model(path)
    write_model(model, tmp_path / "again.json")
    assert json.loads((tmp_path / "again.json").read_text()) == document
    assert model.classifier.selection_.lower_bound == document["selection"]["lower_bound"]
    weights = [[[int(k), int(row[k])] for k in np.flatnonzero(row)] for row in model.classifier.hyperplanes_.weights]
    assert weights == [plane["weights"] for plane in document["hyperplanes"]]
    for bad in ([[99, 1]], [[0, 2]], [[0.0, 1]], [[-1, 1]]):
        planes = [{**document["hyperplanes"][0], "weights": bad}, *document["hyperplanes"][1:]]
        path.write_text(json.dumps({**document, "hyperplanes": planes}))
        with pytest.raises(FormatError, match=r"hyperplanes\[0\] must weigh switches 0 to 5 by -1 or 1"):
            read_model(path)
    # Older programs write no checksum.
    for key in document.keys() - {"checksum"}:
        path.write_text(json.dumps({k: v for k, v in document.items() if k != key}))
        with pytest.raises(FormatError):
            read_model(path)


def test_a_fit_takes_four_thresholds_and_the_columns_that_are_there(tmp_path):
    rng = np.random.default_rng(1)
    kind = np.arange(30) % 2
    cells = {"what": np.array(["a", "b"])[kind], "f": rng.normal(kind, 1), "switch.s": kind.astype(bool)}
    model = fit_model(GraspTable(cells), label="what")
    assert model.columns == ("switch.s",)
    assert model.counts == []
    both = fit_model(GraspTable(cells), label="what", columns="*", encode="even")
    assert both.columns == ("f", "switch.s")
    assert len(both.encoder.thresholds_[0]) == 4
    assert len(both.counts) == 1
    assert "reads f as floor(value / " in both.counts[0]
    step = repr(float(both.encoder.resolution_[0]))
    assert both.inputs_in_words == (f"f in whole steps of {step}, rounded down", "switch.s")
    assert both.netlist.channels == both.columns
    assert model.inputs_in_words == model.columns
    with pytest.raises(InputError, match="line 2, column 'f' must be 0 or 1"):
        fit_model(GraspTable(cells), label="what", columns="f")
    one = {**cells, "what": np.array(["a"] * 30)}
    with pytest.raises(InputError, match="at least two classes, got only 'a'"):
        fit_model(GraspTable(one), label="what")
    with pytest.raises(InputError, match="no column is left"):
        fit_model(GraspTable({"what": cells["what"]}), label="what")
    with pytest.raises(InputError, match="there is no column 'f' and 1 more; the model reads 2 columns"):
        both.readings(GraspTable({"g": cells["f"]}))
    with pytest.raises(InputError, match=r"there is no column 'switch\.s'; the model reads 1 column of these names"):
        model.readings(GraspTable({"g": cells["f"]}))


# ---- names, orders and limits


def test_roman_numerals_are_read_back():
    worth = {"I": 1, "V": 5, "X": 10, "L": 50, "C": 100, "D": 500, "M": 1000}
    for n in [*range(1, 130), 399, 400, 401, 444, 499, 500, 899, 900, 989, 1994, 3999]:
        signs = [worth[sign] for sign in roman(n)]
        assert sum(-a if a < b else a for a, b in zip(signs, [*signs[1:], 0], strict=True)) == n
        assert not any(4 * sign in roman(n) for sign in "IXC")


@few
@given(seeds)
def test_of_equally_good_hyperplanes_the_one_that_no_grasp_comes_near_is_first(seed):
    rng = np.random.default_rng(seed)
    grasps = grasps_of(rng, 12, 10, 2)
    planes = all_bisectors(grasps)
    kept = int(rng.integers(0, 3))
    order = _widest_first(planes.excess(grasps.patterns), kept)
    assert order[:kept].tolist() == list(range(kept))
    assert sorted(order.tolist()) == list(range(len(planes)))
    # A grasp is as near as the fewest switches that turn its sign over.
    nearest = []
    for k in order.tolist():
        weights, bias = planes.weights[k].astype(int), int(planes.biases[k])
        sums = grasps.patterns @ weights - bias
        nearest.append(min(s if s > 0 else 1 - s for s in sums.tolist()))
    assert all(a >= b for a, b in zip(nearest[kept:], nearest[kept + 1 :], strict=False))


@pytest.mark.parametrize("name", [name for name in DECODERS if not name.startswith("least")])
@few
@given(seeds)
def test_a_decoder_never_names_a_class_without_grasps(name, seed):
    rng = np.random.default_rng(seed)
    n = 24
    labels = np.array([0, 2, 3])[np.arange(n) % 3]
    typical = np.where(rng.random((4, 15)) < 0.5, -1.0, 1.0)
    signs = typical[labels] * np.where(rng.random((n, 15)) < 0.1, -1.0, 1.0)
    slopes, offsets = DECODERS[name](signs, labels, np.ones(n, np.int64), 5)
    asked = np.where(rng.random((200, 15)) < 0.5, -1.0, 1.0)
    scores = asked @ slopes.T + offsets
    assert set(scores.argmax(axis=1).tolist()) <= {0, 2, 3}
    assert slopes.shape == (5, 15)
    assert not slopes[[1, 4]].any()


def test_two_classes_are_parted_by_one_machine_in_either_order():
    rng = np.random.default_rng(0)
    signs = np.where(rng.random((20, 9)) < 0.5, -1.0, 1.0)
    labels = (signs[:, :5].sum(axis=1) > 0).astype(np.int64)
    for codes in (labels, 1 - labels, 2 * labels):
        slopes, offsets = DECODERS["one against one, cost 10"](signs, codes, np.ones(20, np.int64), 3)
        assert ((signs @ slopes.T + offsets).argmax(axis=1) == codes).all()


def test_thresholds_up_to_32_bits_are_read(document, tmp_path):
    path = tmp_path / "model.json"
    for most, taken in ((2.0**31 - 1, True), (2.0**30, True), (2.0**31, False)):
        encoder = {**document["encoder"], "resolution": [1.0] * 3, "thresholds": [[1.0, most]] * 3}
        path.write_text(json.dumps({**document, "encoder": encoder, "checksum": None}))
        if taken:
            assert read_model(path).encoder.thresholds_[0][1] == most
        else:
            with pytest.raises(FormatError, match="32 signed bits"):
                read_model(path)


def test_of_very_many_grasps_some_are_compared():
    rng = np.random.default_rng(2)
    grasps = grasps_of(rng, 2300, 24, 2, noise=0.2)
    assert len(grasps) > 2000
    planes = vote._draw(grasps, 500, rng).take(range(250))
    signs = np.where(planes.signs(grasps.patterns), 1.0, -1.0)
    decode = DECODERS["least squares, ridge 0.1"]
    count = vote._fewest_as_good(grasps, planes, signs, np.arange(len(grasps)), decode, np.random.default_rng(0))
    assert count in (250, 125)
    assert count == vote._fewest_as_good(
        grasps, planes, signs, np.arange(len(grasps)), decode, np.random.default_rng(0)
    )


def test_a_vote_that_only_its_offsets_decide_is_a_circuit_too() -> None:
    X = [[1, 1, 1], [1, 0, 0], [0, 0, 0], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 1, 1]]
    clf = HyperplaneClassifier("vote", max_hyperplanes=1).fit([*X, [0, 0, 0]], list("abcaccacacb"))
    assert len(set(clf.predict(X))) == 1
