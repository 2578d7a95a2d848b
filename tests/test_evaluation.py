"""Laws of evaluation: splits, intervals, scores, leaks, peers."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from sklearn.metrics import log_loss, recall_score

from varishold import Pad, Recording, TactileClassifier
from varishold.errors import InputError
from varishold.evaluation import Evaluation, evaluate, evaluate_model, evaluate_shipped, peers
from varishold.evaluation.features import FEATURES, feature_table, pooled_frames
from varishold.evaluation.figures import difference_figure, mean_figure, overstated_figure, share_figure
from varishold.evaluation.held_out import Felt, learn_some
from varishold.evaluation.leaks import (
    duplicated,
    find_leaks,
    interleaved,
    one_block_each,
    still_columns,
    untouched_taxels,
)
from varishold.evaluation.peers import LEARNERS, all_peers, answer_peers
from varishold.evaluation.running import felt_presses
from varishold.evaluation.scores import Answers, calibration_error, refusal_curve, reliability, score
from varishold.evaluation.shots import draw_shots
from varishold.evaluation.splits import Split, split_presses, usable_groups
from varishold.solids import Cone, Pose, RectangularPillar, SquarePillar, ideal_frame
from varishold.touch.course.presses import Press, as_presses
from varishold.trust import share_interval

SHAPE = (11, 12)
SOLIDS = {"cone": Cone(8.0, 4.0), "pillar": SquarePillar(5.0, 4.0), "bar": RectangularPillar(9.0, 3.0, 4.0)}


@pytest.fixture(scope="module", autouse=True)
def few_trees() -> Iterator[None]:
    """A peer's forest of a few trees answers in a tenth of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(peers, "_TREES", 6)
        yield


def frames(name: str, rng: np.random.Generator) -> np.ndarray:
    """A ramp of a solid near the middle, noise of one percent."""
    frame = ideal_frame(SOLIDS[name], SHAPE, 1.0, pose=Pose(*rng.uniform(-0.5, 0.5, 2)))
    ramp = np.array([0.0, 0.3, 0.7, 1.0, 0.9, 0.2])
    return 100 * rng.uniform(0.8, 1.2) * (ramp[:, None, None] * frame / 4 + rng.normal(0, 0.01, (6, *SHAPE)))


def felt(
    seed: int = 0, *, each: int = 4, sessions: Sequence[str] = ("mon", "tue", "wed")
) -> tuple[list[Press], np.ndarray, np.ndarray]:
    """Presses of three things in turn, session after session."""
    rng = np.random.default_rng(seed)
    labels = np.tile(list(SOLIDS), each * len(sessions))
    groups = np.repeat(list(sessions), each * len(SOLIDS))
    return as_presses([frames(name, rng) for name in labels]), labels, groups


@pytest.fixture(scope="module")
def found() -> Evaluation:
    return evaluate(*felt(), shots=(1, 2, 5, 50))


class TestSplits:
    def test_a_group_is_never_learned_from_when_it_is_held_out(self) -> None:
        _, labels, groups = felt()
        split = split_presses(labels, groups)
        held = []
        for train, test in split.parts():
            assert len(set(groups[test])) == 1
            assert not set(groups[train]) & set(groups[test])
            held += test.tolist()
        assert sorted(held) == list(range(len(labels)))
        assert split.kind == "groups"
        assert split.known.all()

    def test_many_groups_are_held_out_whole_several_at_a_time(self) -> None:
        labels, groups = np.tile(["a", "b"], 40), np.repeat([f"{k:02}" for k in range(40)], 2)
        split = split_presses(labels, groups)
        assert split.n_folds == 12
        for train, test in split.parts():
            assert not set(groups[train]) & set(groups[test])

    def test_without_groups_neighbours_are_held_out_together(self) -> None:
        labels = np.repeat(["a", "b"], 10)
        split = split_presses(labels, None)
        assert split.kind == "neighbours"
        for _, test in split.parts():
            for name in "ab":
                mine = test[labels[test] == name]
                assert (np.diff(mine) == 1).all()

    def test_a_thing_of_one_group_is_unknown_there(self) -> None:
        labels = np.array(["a", "b", "a", "b", "a", "b", "a", "b", "c", "c", "c"])
        groups = np.array(["1"] * 4 + ["2"] * 7)
        split = split_presses(labels, groups)
        assert split.known.tolist() == [True] * 8 + [False] * 3

    @pytest.mark.parametrize(
        ("labels", "groups", "told"),
        [
            ("aaaa", "1212", "there is one thing only, 'a'"),
            ("abab", "1111", "there is one group only, '1'"),
            ("aabb", "1122", "groups are the labels themselves"),
            ("aabbccdd", "11112222", "every thing was felt in one group only"),
        ],
    )
    def test_what_cannot_be_split_is_refused(self, labels: str, groups: str, told: str) -> None:
        with pytest.raises(InputError, match=told):
            split_presses(np.array(list(labels)), np.array(list(groups)))

    def test_a_thing_of_too_few_presses_is_refused(self) -> None:
        with pytest.raises(InputError, match="'b' has 1 press only: give each thing at least 3, one to be held out"):
            split_presses(np.array(list("aaab")), None)
        with pytest.raises(InputError, match="'a' has 2 presses only"):
            split_presses(np.array(list("aabbb")), None)
        assert split_presses(np.array(list("aaabbb")), None).n_folds == 3

    def test_groups_that_are_the_classes_are_not_handed_on(self) -> None:
        codes = np.array([0, 0, 1, 1])
        assert usable_groups(np.array(list("xxyy")), codes) is None
        assert usable_groups(np.array(list("xxxx")), codes) is None
        assert usable_groups(np.array(list("xyxy")), codes) is not None


class TestFigures:
    def test_groups_give_wilsons_interval_of_so_many_presses_as_tell_as_much(self) -> None:
        rng = np.random.default_rng(0)
        right = rng.random((6, 30)) < rng.uniform(0.3, 0.9, (6, 1))
        figure = share_figure(right.ravel(), np.repeat(np.arange(6), 30))
        shares = right.mean(axis=1)
        share = shares.mean()
        # Independent presses that scatter as the groups' mean does, and no better known than by six groups.
        telling = share * (1 - share) / stats.sem(shares) ** 2 * (stats.norm.ppf(0.975) / stats.t.ppf(0.975, 5)) ** 2
        ends = [share_interval(share * telling, telling)[k] for k in (0, 1)]
        assert (figure.value, figure.low, figure.high) == pytest.approx((share, *ends))
        assert (figure.over, figure.n, figure.n_groups) == ("groups", 180, 6)

    @pytest.mark.parametrize("n_groups", [3, 5, 8])
    @pytest.mark.parametrize(("mean", "apart"), [(1.0, 0.0), (1.0, 1.0), (3.0, 0.0), (3.0, 1.0), (3.0, 2.0)])
    def test_intervals_over_groups_hold_the_share_of_groups_still_to_come(
        self, n_groups: int, mean: float, apart: float
    ) -> None:
        rng = np.random.default_rng(n_groups)

        def shares(n: int) -> np.ndarray:
            return 1 / (1 + np.exp(-rng.normal(mean, apart, n)))

        truth, groups = shares(200_000).mean(), np.repeat(np.arange(n_groups), 20)
        drawn = [share_figure(rng.random(len(groups)) < np.repeat(shares(n_groups), 20), groups) for _ in range(400)]
        # Student's held it in 78 to 84 % where groups are far apart and mostly good.
        assert np.mean([f.low <= truth <= f.high for f in drawn]) > 0.875

    def test_unequal_groups_give_the_interval_of_a_ratio(self) -> None:
        values, groups = np.array([1.0, 2, 3, 4, 8, 9]), np.array(list("aabccc"))
        figure = mean_figure(values, groups)
        mean = values.mean()
        left = np.array([(values[groups == g] - mean).sum() for g in "abc"])
        half = stats.t.ppf(0.975, 2) * np.sqrt(3 / 2 * (left**2).sum()) / 6
        assert (figure.low, figure.high) == pytest.approx((mean - half, mean + half))

    @pytest.mark.parametrize("n_right", [40, 36, 20])
    def test_an_interval_over_groups_is_never_narrower_than_wilsons(self, n_right: int) -> None:
        # Ten presses a group, as alike between groups as can be.
        right, groups = np.arange(40) < n_right, np.arange(40) % 4
        figure = share_figure(right, groups)
        want = stats.binomtest(n_right, 40).proportion_ci(method="wilson")
        assert figure.low is not None
        assert figure.high is not None
        assert figure.low <= want.low
        assert figure.high >= want.high - 1e-12
        fewer = 40 * (stats.norm.ppf(0.975) / stats.t.ppf(0.975, 3)) ** 2
        ends = share_interval(n_right / 40 * fewer, fewer)
        assert (figure.low, figure.high) == pytest.approx(ends)
        assert figure.over == "groups"

    def test_more_groups_tell_more(self) -> None:
        lows = [share_figure(np.ones(60), np.arange(60) % n).low for n in (3, 4, 6, 12)]
        assert lows == sorted(lows)
        assert lows[-1] < share_figure(np.ones(60)).low

    @pytest.mark.parametrize("groups", [None, np.repeat(["a", "b"], 10)])
    def test_fewer_than_three_groups_give_wilsons_and_say_so(self, groups: np.ndarray | None) -> None:
        figure = share_figure(np.arange(20) < 17, groups)
        want = stats.binomtest(17, 20).proportion_ci(method="wilson")
        assert (figure.low, figure.high) == pytest.approx((want.low, want.high))
        assert figure.over == "presses"
        assert share_interval(17, 20) == pytest.approx((want.low, want.high))

    def test_means_over_presses_are_students(self) -> None:
        values = np.array([0.1, 0.5, 0.2, 0.9])
        figure = mean_figure(values)
        want = stats.t.interval(0.95, 3, loc=values.mean(), scale=stats.sem(values))
        assert (figure.low, figure.high) == pytest.approx(want)
        assert mean_figure([0.5]).low is None

    def test_a_difference_is_paired(self) -> None:
        mine, other = np.array([1, 1, 0, 1, 0, 0]), np.array([1, 0, 0, 1, 1, 0])
        figure = difference_figure(mine, other, np.array(list("aabbcc")))
        assert figure.value == 0
        assert figure.high == pytest.approx(stats.t.ppf(0.975, 2) * np.sqrt(3 / 2 * (1 + 0 + 1)) / 6)

    @pytest.mark.parametrize("groups", [None, np.arange(24) % 3])
    def test_answers_that_do_not_differ_leave_a_difference_open(self, groups: np.ndarray | None) -> None:
        figure = difference_figure(np.ones(24), np.ones(24), groups)
        wilson = stats.binomtest(0, 24).proportion_ci(method="wilson")
        assert (figure.low, figure.high) == pytest.approx((-wilson.high, wilson.high))
        # One press more in every group: all groups agree, and three presses tell next to nothing.
        figure = difference_figure(np.ones(24), np.arange(24) >= 3, groups)
        assert figure.value == pytest.approx(1 / 8)
        assert figure.low is not None
        assert figure.low < 0

    @pytest.mark.parametrize("groups", [None, np.arange(60) % 3, np.arange(60) % 6])
    @pytest.mark.parametrize(("n", "better", "worse"), [(24, 0.02, 0.005), (60, 0.02, 0.005), (60, 0.15, 0.05)])
    def test_intervals_of_a_difference_hold_the_true_one(
        self, n: int, better: float, worse: float, groups: np.ndarray | None
    ) -> None:
        rng = np.random.default_rng(n)
        of = None if groups is None else groups[:n]
        held = []
        for _ in range(400):
            drawn = rng.choice(3, n, p=[better, worse, 1 - better - worse])
            figure = difference_figure(drawn != 1, drawn != 0, of)
            held.append(figure.low <= better - worse <= figure.high)
        # Student's held it in 47 % where one answer in forty differs.
        assert np.mean(held) > 0.92

    @pytest.mark.parametrize("groups", [None, np.arange(24) % 3])
    def test_right_answers_alone_do_not_say_that_too_little_was_promised(self, groups: np.ndarray | None) -> None:
        top = np.linspace(0.96, 0.999, 24)
        figure, share = overstated_figure(top, np.ones(24), groups), share_figure(np.ones(24), groups)
        assert figure.value == pytest.approx(top.mean() - 1)
        assert (figure.low, figure.high) == pytest.approx((top.mean() - 1, top.mean() - share.low), abs=1e-2)
        assert figure.high > 0.1

    @pytest.mark.parametrize("groups", [None, np.arange(40) % 4])
    @pytest.mark.parametrize("stated", [0.8, 0.97, 0.99])
    def test_probabilities_that_keep_their_word_are_seldom_said_not_to(
        self, stated: float, groups: np.ndarray | None
    ) -> None:
        rng = np.random.default_rng(0)
        held = []
        for _ in range(400):
            top = rng.beta(50 * stated, 50 * (1 - stated), 40)
            figure = overstated_figure(top, rng.random(40) < top, groups)
            held.append(figure.low <= 0 <= figure.high)
        assert np.mean(held) > 0.93


class TestScores:
    P = np.array([[0.95, 0.05, 0.0], [0.2, 0.5, 0.3], [0.05, 0.05, 0.9], [0.6, 0.3, 0.1]])
    TRUTH = np.array([0, 1, 1, 2])

    def test_by_hand(self) -> None:
        refused = np.array([False, False, True, False])
        s = score(Answers(self.P, self.TRUTH, refused, None))
        assert s.right.value == 0.5
        assert s.macro_recall == pytest.approx(recall_score(self.TRUTH, self.P.argmax(1), average="macro"))
        assert s.log_loss.value == pytest.approx(log_loss(self.TRUTH, self.P, labels=[0, 1, 2]))
        assert s.sure.value == 0.25
        assert s.sure_right is not None
        assert s.sure_right.value == 1.0
        assert s.refused.value == 0.25
        assert s.kept_right is not None
        assert s.kept_right.value == pytest.approx(2 / 3)
        assert s.overstated.value == pytest.approx((0.95 + 0.5 + 0.9 + 0.6) / 4 - 0.5)
        assert s.confusion.tolist() == [[1, 0, 0], [0, 1, 1], [1, 0, 0]]

    def test_calibration_error_by_hand(self) -> None:
        top, right = np.array([0.91, 0.99, 0.55, 0.52, 0.58, 1.0]), np.array([1, 0, 1, 1, 0, 1], bool)
        high, low = abs((0.91 + 0.99 + 1.0) / 3 - 2 / 3), abs((0.55 + 0.52 + 0.58) / 3 - 2 / 3)
        assert calibration_error(top, right) == pytest.approx((3 * high + 3 * low) / 6)
        assert [one.n for one in reliability(top, right)] == [3, 3]

    def test_calibrated_answers_have_no_error(self) -> None:
        rng = np.random.default_rng(0)
        top = rng.random(200_000)
        assert calibration_error(top, rng.random(200_000) < top) < 0.01

    def test_the_curve_of_refusals_begins_with_all_and_ends_with_the_surest(self) -> None:
        top, right = np.array([0.9, 0.8, 0.7, 0.6]), np.array([True, True, False, False])
        curve = dict(refusal_curve(top, right))
        assert curve == {0.0: 0.5, 0.25: pytest.approx(1 / 3), 0.5: 0.0, 0.75: 0.0}


class TestEvaluation:
    def test_its_fields(self, found: Evaluation) -> None:
        told = json.loads(json.dumps(found.to_dict(), allow_nan=False))
        assert set(told) == {
            *("tested", "presses", "things", "groups", "split", "right", "chance", "macro_recall", "log_loss"),
            *("calibration_error", "mean_p_minus_right", "sure", "sure_right", "known_refused", "kept_right", "error"),
            *("strangers", "unheard", "peers", "ahead_of_best_peer", "shots", "confusion", "reliability", "refusals"),
            *("leaks", "remarks", "seed"),
        }
        assert set(told["right"]) == {"value", "low", "high", "interval_over", "n_presses", "n_groups", "leaks"}
        assert told["things"] == sorted(SOLIDS)
        assert told["groups"] == ["mon", "tue", "wed"]
        assert told["right"]["interval_over"] == "groups"
        assert np.sum(told["confusion"]) == told["presses"] == 36
        assert np.trace(told["confusion"]) / 36 == pytest.approx(told["right"]["value"], abs=1e-6)
        assert [one["presses"] for one in told["shots"]] == [1, 2, 5]
        assert told["shots"][0]["right"] is None
        assert told["shots"][0]["peer"]["value"] > 1 / 3

    def test_easy_things_are_told_and_nothing_leaks(self, found: Evaluation) -> None:
        assert found.scores.right.value > 0.9
        assert found.leaks == ()
        assert found.strangers is not None
        assert found.strangers.things == tuple(sorted(SOLIDS))

    def test_the_best_peer_is_first_and_differences_are_paired(self, found: Evaluation) -> None:
        shares = [peer.right.value for peer in found.peers]
        assert shares == sorted(shares, reverse=True)
        assert len(shares) == 9
        for peer in found.peers:
            assert peer.ahead.value == pytest.approx(found.scores.right.value - peer.right.value)

    def test_the_same_seed_gives_the_same_and_the_work_that_was_told_is_done(self, found: Evaluation) -> None:
        told: list[dict[str, int]] = []
        again = evaluate(*felt(), shots=(1, 2, 5, 50), tick=lambda **what: told.append(what))
        assert again.to_dict() == found.to_dict()
        assert told[0]["total"] == sum(what.get("advance", 0) for what in told) == len(told) - 1

    def test_every_figure_names_the_leaks_that_spoil_it(self) -> None:
        presses, labels, _ = felt(each=2)
        told = evaluate(presses, labels, peers=False, shots=()).to_dict()
        spoilt = [leak["name"] for leak in told["leaks"]]
        assert spoilt == ["one session on both sides"]
        for name in ("right", "macro_recall", "log_loss", "calibration_error", "sure", "known_refused", "strangers"):
            assert told[name]["leaks"] == spoilt
        assert "no interval over groups" in told["remarks"][0]

    def test_held_out_answers_are_those_of_a_classifier_that_learned_the_rest(self) -> None:
        presses, labels, groups = felt(each=2)
        found = evaluate(presses, labels, groups, peers=False, strangers=False, shots=())
        right, refused = [], []
        for day in ("mon", "tue", "wed"):
            inside = groups != day
            mine, theirs = ([presses[k] for k in np.flatnonzero(of)] for of in (inside, ~inside))
            clf = TactileClassifier().fit(mine, labels[inside], groups[inside])
            right += (clf.predict(theirs) == labels[~inside]).tolist()
            refused += clf.refused(theirs).tolist()
        assert found.scores.right.value == pytest.approx(np.mean(right))
        assert found.scores.refused.value == pytest.approx(np.mean(refused))
        assert found.strangers is None

    def test_a_thing_of_one_group_is_a_stranger_and_no_error(self) -> None:
        presses, labels, groups = felt(each=3)
        keep = (labels != "bar") | (groups == "wed")
        some = [presses[k] for k in np.flatnonzero(keep)]
        found = evaluate(some, labels[keep], groups[keep], peers=False, shots=())
        assert found.unheard is not None
        assert found.unheard.things == ("bar",)
        assert found.unheard.refused.n == 3
        assert found.scores.confusion.sum() == keep.sum() - 3
        assert any("in one group only" in remark for remark in found.remarks)

    def test_arrays_are_taken_too(self) -> None:
        presses, labels, groups = felt(each=2)
        array = np.stack([press.pads["pad_0"][3] for press in presses])
        for X in (array, array.reshape(len(array), -1)):
            clf = TactileClassifier(shape=SHAPE)
            assert evaluate(X, labels, groups, classifier=clf, peers=False, shots=()).scores.right.value > 0.8

    def test_presses_of_different_pads_are_refused(self) -> None:
        presses, labels, groups = felt(each=2)
        cut = {"pads": {"pad_0": presses[-1].pads["pad_0"][:, :5]}, "fields": {"pad_0": np.ones((5, 12), bool)}}
        presses[-1] = replace(presses[-1], place="wed.npz, press 5", **cut)
        with pytest.raises(InputError, match=r"wed.npz, press 5: has the pads pad_0 5 x 12, those before it pad_0 11"):
            evaluate(presses, labels, groups)

    def test_presses_without_a_pad_or_an_angle_are_answered(self) -> None:
        presses, labels, groups = felt(each=2)
        some = []
        for k, press in enumerate(presses):
            pads = {"a": press.pads["pad_0"], "b": press.pads["pad_0"]}
            kept = {name: frames for name, frames in pads.items() if name == "a" or k % 4}
            angle = {"angle_rad.j": float(k % 3) if k % 5 else np.nan, "force_n.z": np.nan}
            some.append(replace(press, pads=kept, fields=dict.fromkeys(kept, press.fields["pad_0"]), columns=angle))
        found = evaluate(some, labels, groups, shots=(2,))
        assert found.scores.right.value > 0.8
        assert len(found.peers) == 9

    @pytest.mark.parametrize(
        ("change", "told"),
        [
            ({"y": ["a"]}, "y must be one a press, 18 of them"),
            ({"y": [" ", *["a"] * 17]}, "press 0 has no label"),
            ({"groups": ["a"] * 3}, "groups must be one a press"),
            ({"runs": [0]}, "runs must be one a press"),
            ({"shots": (0,)}, "shots must be whole numbers"),
            ({"seed": -1}, "seed must be a whole number from 0 to 4294967295, got -1"),
            ({"seed": 2**32}, "seed must be a whole number from 0 to 4294967295, got 4294967296"),
            ({"y": [*["none of these"] * 9, *["a"] * 9]}, "no thing can be called 'none of these', which is said of"),
            ({"X": []}, "no press to be tested on"),
        ],
    )
    def test_bad_input_is_told_in_one_line(self, change: dict[str, object], told: str) -> None:
        presses, labels, groups = felt(each=2)
        with pytest.raises(InputError, match=told):
            evaluate(**{"X": presses, "y": labels, "groups": groups, **change})


class TestPeers:
    def test_they_are_asked_on_the_same_folds_and_learn_from_nothing_else(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        presses, labels, groups = felt(each=2)
        known = felt_presses(presses, labels, groups)
        split = split_presses(labels, known.groups)
        seen = []
        monkeypatch.setattr(
            peers,
            "_learn_and_answer",
            lambda settings, train, codes, test, *rest: (
                seen.append((train, test)) or (np.ones((len(test), 3)) / 3, np.arange(3))
            ),
        )
        answer_peers(all_peers()[:1], known, split, seed=0)
        raw = feature_table("raw frame", pooled_frames(presses, presses[0].shapes, 0.0), presses, (), 0.0)
        for (train, test), (rows, held) in zip(seen, split.parts(), strict=True):
            assert len(train) == len(rows)
            np.testing.assert_allclose(test, raw[held], atol=5.0)

    def test_features_by_hand(self) -> None:
        frame = np.zeros((1, 3, 4))
        frame[0, 1, 2] = frame[0, 1, 3] = 2.0
        press = Press({"pad": frame}, {"pad": np.ones((3, 4), bool)}, columns={"angle_rad.a": 0.5})
        pooled = pooled_frames([press], press.shapes, 0.0)
        tables = {kind: feature_table(kind, pooled, [press], ["angle_rad.a"], 0.0)[0] for kind in FEATURES}
        np.testing.assert_array_equal(tables["raw frame"], [*frame.ravel(), 0.5])
        np.testing.assert_array_equal(tables["on/off"], [*(frame.ravel() > 0), 0.5])
        load, share, x, y, xx, xy, yy = tables["moments"][:7]
        assert (load, share, x, y) == pytest.approx((np.log(4), 1.0, 1.0, 0.0))
        assert (xx, xy, yy) == pytest.approx((0.25, 0.0, 0.0))
        # Hu's first two of two equal taxels: eta_20 = 0.25 / 2, eta_02 = eta_11 = 0.
        np.testing.assert_allclose(tables["moments"][7:9], np.log1p(1e6 * np.array([0.125, 0.125**2])))

    def test_hus_invariants_do_not_turn(self) -> None:
        rng = np.random.default_rng(0)
        frame = rng.random((1, 7, 7))
        tables = []
        for turned in (frame, np.rot90(frame, axes=(1, 2))):
            press = Press({"pad": turned}, {"pad": np.ones((7, 7), bool)})
            tables.append(feature_table("moments", pooled_frames([press], press.shapes, 0.0), [press], (), 0.0)[0])
        np.testing.assert_allclose(tables[0][7:14], tables[1][7:14], atol=1e-6)

    def test_every_learner_has_settings(self) -> None:
        assert {len(settings) > 1 for settings in LEARNERS.values()} == {True}


class TestShots:
    def test_so_many_presses_of_each_thing_are_drawn_from_the_training_part(self) -> None:
        presses, labels, groups = felt()
        known = felt_presses(presses, labels, groups)
        split = split_presses(labels, known.groups)
        drawn = draw_shots(known, split, 5, seed=3)
        assert drawn is not None
        for rows, (train, _) in zip(drawn, split.parts(), strict=True):
            assert set(rows) <= set(train)
            assert np.bincount(known.codes[rows]).tolist() == [5, 5, 5]
        again = draw_shots(known, split, 5, seed=3)
        assert again is not None
        assert all((one == two).all() for one, two in zip(drawn, again, strict=True))
        assert draw_shots(known, split, 9, seed=3) is None

    def test_two_presses_of_two_sessions_that_are_the_things_are_learned_all_the_same(self) -> None:
        presses, labels, _groups = felt()
        known = felt_presses(
            presses, labels, np.where(labels == "cone", "mon", np.where(labels == "bar", "tue", "wed"))
        )
        learned = learn_some(TactileClassifier(), known, np.arange(12))
        assert len(learned.classes_) == 3


def _leaks(presses: list[Press], labels: np.ndarray, groups: np.ndarray | None, **runs: np.ndarray) -> list[str]:
    known = felt_presses(presses, labels, groups)
    split = split_presses(labels, known.groups)
    return [leak.name for leak in find_leaks(known, split, runs.get("runs", np.zeros(len(labels))), seed=0)]


class TestLeaks:
    def test_none_is_found_where_none_is(self) -> None:
        assert _leaks(*felt(each=5)) == []

    def test_a_session_on_both_sides_is_told(self) -> None:
        presses, labels, _ = felt()
        assert _leaks(presses, labels, None) == ["one session on both sides"]

    def test_groups_that_take_turns_are_told(self) -> None:
        groups, runs = np.array(list("abab")), np.zeros(4)
        assert interleaved(groups, runs) is not None
        assert interleaved(np.array(list("aabb")), runs) is None
        # Each in a recording of its own.
        assert interleaved(groups, np.arange(4)) is None
        assert interleaved(groups, np.array([0, 1, 0, 1])) is None

    def test_things_recorded_in_one_go_are_told(self) -> None:
        codes = np.array([0, 0, 1, 1, 2])
        assert one_block_each(codes, np.zeros(5)) is not None
        assert one_block_each(codes, np.array([0, 0, 1, 1, 2])) is not None
        assert one_block_each(codes, np.array([0, 1, 2, 2, 3])) is None
        assert one_block_each(codes[[0, 2, 1, 3, 4]], np.zeros(5)) is None

    def test_the_same_press_on_both_sides_is_told(self) -> None:
        presses, labels, groups = felt()
        split = split_presses(labels, groups)
        assert duplicated(presses, split) is None
        nothing = replace(presses[0], pads={"pad_0": np.zeros((3, *SHAPE))})
        assert duplicated([nothing] * len(presses), split) is None
        presses[3] = replace(presses[0], place="elsewhere")
        assert duplicated(presses, split) is None
        presses[-1] = presses[0]
        leak = duplicated(presses, split)
        assert leak is not None
        assert "1 press is there more than once" in leak.says

    def test_a_thing_of_copies_is_refused_by_its_name(self) -> None:
        presses, labels, _ = felt()
        first = next(press for press, label in zip(presses, labels, strict=True) if label == "pillar")
        copied = [first if label == "pillar" else press for press, label in zip(presses, labels, strict=True)]
        with pytest.raises(InputError, match="'pillar' has one press only, copies being one"):
            evaluate(copied, labels, peers=False, shots=())

    def test_taxels_that_nothing_touches_are_told_where_they_name_the_thing(self) -> None:
        presses, labels, groups = felt(each=5)
        corner = {"cone": -1.5, "pillar": 0.0, "bar": 1.5}
        spoilt = []
        for press, label in zip(presses, labels, strict=True):
            changed = press.pads["pad_0"].copy()
            for rows in (slice(2), slice(-2, None)):
                changed[1:, rows, :2] += corner[label]
                changed[1:, rows, -2:] += corner[label]
            spoilt.append(replace(press, pads={"pad_0": changed}))
        assert _leaks(spoilt, labels, groups) == ["untouched taxels"]

    def test_untouched_taxels_by_hand(self) -> None:
        pooled = np.zeros((2, 6, 7))
        pooled[0, 2, 2] = 10.0
        pooled[1, 5, 6] = 10.0
        away = untouched_taxels(pooled[:1], 1.0)
        assert (~away).sum() == 9
        assert not away[1:4, 1:4].any()
        narrow = untouched_taxels(pooled[:1, 2:3], 1.0)
        assert (~narrow).sum() == 1

    def test_joints_that_stand_still_are_told_where_they_name_the_thing(self) -> None:
        presses, labels, groups = felt(each=5)
        rng = np.random.default_rng(1)
        mark = {"cone": 1e-4, "pillar": 2e-4, "bar": 3e-4}

        def with_angles(still: Sequence[float]) -> list[Press]:
            return [
                replace(press, columns={"angle_rad.still": angle, "angle_rad.moves": rng.normal()})
                for press, angle in zip(presses, still, strict=True)
            ]

        assert _leaks(with_angles([mark[label] for label in labels]), labels, groups) == ["still joints"]
        assert _leaks(with_angles(rng.normal(0, 1e-4, len(labels)).tolist()), labels, groups) == []
        values = np.array([[0.0, 0.0], [1e-4, 1.0], [0.5, 0.0], [0.5001, 1.0]])
        assert still_columns(values, np.array([0, 0, 1, 1])).tolist() == [True, False]
        # A thing of one press says nothing of what moves.
        assert still_columns(values, np.array([0, 0, 1, 2])).tolist() == [True, False]


@pytest.fixture(scope="module")
def model() -> TactileClassifier:
    presses, labels, _ = felt(7)
    return TactileClassifier().fit(presses, labels)


class TestGiven:
    def test_a_model_is_tested_and_learns_nothing(self, model: TactileClassifier) -> None:
        presses, labels, groups = felt(8, each=2)
        before = model.learned_
        told: list[dict[str, int]] = []
        found = evaluate_model(model, presses, labels, groups, tick=lambda **what: told.append(what))
        assert told == [{"total": 1}, {"advance": 1}]
        assert model.learned_ is before
        assert found.groups == ("mon", "tue", "wed")
        assert found.remarks == ()
        assert found.error == model.error
        assert found.split == "none"
        assert found.scores.right.value == pytest.approx((model.predict(presses) == labels).mean())
        assert found.scores.refused.value == pytest.approx(model.refused(presses).mean())
        assert found.peers == ()
        assert found.strangers is None

    def test_labels_that_it_does_not_know_are_strangers(self, model: TactileClassifier) -> None:
        presses, labels, groups = felt(8, each=2)
        found = evaluate_model(model, presses, np.where(labels == "bar", "spoon", labels), groups)
        assert found.strangers is not None
        assert found.strangers.things == ("spoon",)
        assert found.strangers.refused.value == pytest.approx(model.refused(presses)[labels == "bar"].mean())
        known = np.quantile(model.p_values(presses)[labels != "bar"], model.error)
        want = (model.p_values(presses)[labels == "bar"] <= known).mean()
        assert found.strangers.refused_alike == pytest.approx(want)
        assert found.remarks == ("2 of the 3 things that it knows were tested",)
        assert found.strangers.refused.n == (labels == "bar").sum()
        assert found.scores.confusion.sum() == (labels != "bar").sum()
        with pytest.raises(InputError, match="the model knows none of these labels: fork; it knows bar, cone, pillar"):
            evaluate_model(model, presses, ["fork"] * len(presses))

    def test_presses_that_it_learned_from_are_told_whatever_they_are_called(self, model: TactileClassifier) -> None:
        presses, labels, _ = felt(7)
        named = [replace(press, place=f"mon.npz, press {k}") for k, press in enumerate(presses)]
        learned = TactileClassifier().fit(named, labels)
        assert [leak.name for leak in evaluate_model(learned, named, labels).leaks] == ["learned from these"]
        other = [replace(press, place=f"tue.npz, press {k}") for k, press in enumerate(presses)]
        assert [leak.name for leak in evaluate_model(learned, other, labels).leaks] == ["learned from these"]
        fresh, names, _ = felt(8)
        assert evaluate_model(learned, fresh, names).leaks == ()
        assert evaluate_model(model, fresh, names).leaks == ()

    def test_shipped_names_are_tested(self) -> None:
        rng = np.random.default_rng(0)
        solids = {"Square_pillar": SquarePillar(12.0, 8.0), "CONE": Cone(14.0, 8.0), "unknown": None}
        labels = np.tile(list(solids), 4)
        faces = [
            np.zeros((24, 24)) if solid is None else ideal_frame(solid, (24, 24), 1.0) for solid in solids.values()
        ]
        ramp = np.array([0.0, 0.0, 10.0, 10.0, 10.0])[:, None, None]
        values = np.concatenate([ramp * faces[k % 3] for k in range(len(labels))])
        values = values + rng.normal(0, 0.05, values.shape)
        press = np.repeat(np.arange(len(labels)), 5)
        recording = Recording({"pad": Pad(values)}, press=press)
        found = evaluate_shipped([recording], labels)
        assert found.things[-1] == "unknown"
        assert found.scores.right.n == 8
        assert found.scores.right.value == 1.0
        assert found.strangers is not None
        assert found.strangers.refused.value == 1.0

    def test_labels_that_are_no_shipped_name_are_listed(self) -> None:
        recording = Recording({"pad": Pad(np.ones((2, 8, 8)))}, press=np.array([0, 1]))
        with pytest.raises(InputError, match="no shipped name: cup, mug; known are: cylinder, square pillar"):
            evaluate_shipped([recording], ["mug", "cup"])


def test_a_split_names_what_it_is() -> None:
    split = Split("groups", np.array([0, 1]), np.ones(2, bool), np.array([0, 1]))
    assert split.n_folds == 2
    assert Felt([], np.zeros(0, np.intp), np.array(["a"]), None).groups is None
