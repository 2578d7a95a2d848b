"""What touches take: the next is chosen by information a second, two ahead where one tells nothing; sizes as priors."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.perceive import (
    Belief,
    Evidence,
    Library,
    NameEvidence,
    Perceiver,
    SizePrior,
    read_library,
    shipped_library,
    write_library,
)
from varishold.perceive.library import LOG_SIZES
from varishold.perceive.next_touch import time_until_sure
from varishold.trust.fusion import MIXING


def crossed(n: int = 40) -> Library:
    """Ball and box, of which a tip and a rub say nothing alone and all together; a poke says a little."""
    rng = np.random.default_rng(0)
    rows: dict[str, list[list[Evidence]]] = {"ball": [], "box": []}
    for k, name in enumerate(rows):
        for j in range(n):
            one = j % 2
            rows[name].append(
                [
                    Evidence("tip", {"a": 10.0 * one + rng.normal(0, 0.3)}),
                    Evidence("rub", {"b": 10.0 * (one ^ k) + rng.normal(0, 0.3)}),
                    Evidence("poke", {"c": 1.6 * k + rng.normal()}),
                ]
            )
    of = Library.from_examples(rows)
    # Both sides of what is crossed lie within the scatter of an object: kernels that see them apart.
    sharp = {touch: replace(of.touches[touch], width=0.1, fall=20.0) for touch in ("tip", "rub")}
    return replace(of, touches=of.touches | sharp)


def test_a_pair_is_seen_of_which_each_alone_says_nothing() -> None:
    library = crossed()
    # By costs alone one touch is looked ahead.
    alone = Perceiver(library).plan()
    assert alone is not None
    assert (alone.seconds, alone.along_with) == (None, None)
    wanted = Perceiver(library.with_seconds({"tip": 5.0, "rub": 5.0, "poke": 5.0})).plan()
    assert wanted is not None
    assert {wanted.touch, wanted.along_with} == {"tip", "rub"}
    assert wanted.nats < 0.05
    assert wanted.seconds == 5.0


def test_the_time_until_sure_is_that_of_both_touches_where_both_are_needed() -> None:
    library = crossed()
    ahead = time_until_sure(Belief.before(library), {"tip": 3.0, "rub": 4.0}, 0.01)
    assert ahead["tip"] == (pytest.approx(7.0, rel=0.05), "rub")
    assert ahead["rub"] == (pytest.approx(7.0, rel=0.05), "tip")
    assert time_until_sure(Belief.before(library), {"tip": 3.0}, 0.01) == {"tip": (3.0, None)}


def telling() -> Library:
    rng = np.random.default_rng(1)
    rows = {
        name: [[Evidence(t, {t: 20.0 * k + rng.normal()}) for t in ("tip", "rub")] for _ in range(20)]
        for k, name in enumerate(("ball", "box"))
    }
    return Library.from_examples(rows)


@pytest.mark.parametrize(("tip", "wanted"), [(1.0, "tip"), (3.0, "rub")])
def test_of_touches_that_tell_as_much_the_quicker_is_wanted(tip: float, wanted: str) -> None:
    plan = Perceiver(telling().with_seconds({"tip": tip, "rub": 2.0})).plan()
    assert plan is not None
    assert (plan.touch, plan.along_with) == (wanted, None)


def test_with_equal_seconds_a_touch_that_tells_enough_is_chosen_as_by_equal_costs() -> None:
    plain = telling()
    assert Perceiver(plain).next_touch() == Perceiver(plain.with_seconds({"tip": 4.0, "rub": 4.0})).next_touch()
    # Seconds of one touch alone change nothing.
    assert Perceiver(plain.with_seconds({"tip": 0.01})).next_touch() == Perceiver(plain).next_touch()


def test_a_library_keeps_its_seconds_and_old_files_have_none(tmp_path: Path) -> None:
    write_library(telling(), tmp_path / "old.npz")
    assert read_library(tmp_path / "old.npz").seconds is None
    write_library(telling().with_seconds({"tip": 1.5, "rub": 2.5}), tmp_path / "new.npz")
    assert read_library(tmp_path / "new.npz").seconds == {"tip": 1.5, "rub": 2.5}
    shipped = shipped_library().seconds
    assert shipped is not None
    assert shipped["squeeze"] < shipped["grasp"] < shipped["fingertip-edge"]


@pytest.mark.parametrize("taken", [0.0, -1.0, float("nan"), float("inf"), "long"])
def test_seconds_are_positive_and_of_touches_that_are_known(taken: object) -> None:
    with pytest.raises(InputError, match="seconds of touch 'tip' must be positive"):
        telling().with_seconds({"tip": taken})  # type: ignore[dict-item]
    with pytest.raises(InputError, match="knows no touch 'smell'"):
        telling().with_seconds({"smell": 1.0})


def took(*seconds: float | None) -> list[list[Evidence]]:
    return [[Evidence("tip", {"a": 0.1 * k}, seconds=each)] for k, each in enumerate(seconds)]


def test_what_a_touch_takes_is_the_mean_of_what_it_took() -> None:
    examples = {"ball": took(1.0, 2.0), "box": took(None, 3.0)}
    assert Library.from_examples(examples).seconds == {"tip": 2.0}
    assert Library.from_examples(examples, others=took(6.0)).seconds == {"tip": 3.0}
    # What failed took time, and is none that the touch takes.
    failed = [Evidence("tip", {}, failed=True)]
    assert Library.from_examples({**examples, "cone": [failed]}).seconds == {"tip": 2.0}
    untold = {name: took(None, None) for name in examples}
    assert Library.from_examples(untold).seconds is None
    # An object more is felt by the same hand, and its touches take no other time.
    assert Library.from_examples(examples).with_object("cone", took(9.0, 9.0)).seconds == {"tip": 2.0}


@pytest.mark.parametrize("taken", [0, -1.0, float("nan"), float("inf"), "3", [3.0]])
def test_a_touch_takes_a_time(taken: object) -> None:
    with pytest.raises(InputError, match="seconds of touch 'tip' must be positive"):
        Evidence("tip", {"a": 1.0}, seconds=taken)  # type: ignore[arg-type]


def sized() -> Library:
    """Balls are small and boxes are large, and feel alike."""
    rng = np.random.default_rng(2)
    sizes = {"ball": [0.05] * 12, "box": [0.1] * 12}
    return Library.from_examples(
        {name: [[Evidence("tip", {"a": rng.normal()})] for _ in row] for name, row in sizes.items()}, sizes_m=sizes
    )


def test_a_size_that_was_seen_weighs_examples_of_such_a_size() -> None:
    even = {"ball": 0.5, "box": 0.5}
    belief = Belief.before(sized())
    small = belief.after(NameEvidence("camera", even, pose=SizePrior(0.05, 0.005)))
    assert small.probability["ball"] > 0.9
    assert small.size() is not None
    assert small.size()[0] == pytest.approx(0.05, rel=0.1)  # type: ignore[index]
    vague = belief.after(NameEvidence("camera", even, pose=SizePrior(0.05, 0.05)))
    assert 0.5 < vague.probability["ball"] < small.probability["ball"]
    assert belief.after(NameEvidence("camera", even)).probability["ball"] == pytest.approx(0.5)
    # It is of the thing, wherever that is moved.
    assert small.in_new_place().probability["ball"] > 0.9
    # Who takes the thing for none of its names says nothing of it.
    refused = NameEvidence("camera", even, p_value=0.01, pose=SizePrior(0.05, 0.005))
    assert belief.after(refused).probability["ball"] == pytest.approx(0.5)


@pytest.mark.parametrize("size_m", [0.004, 0.03, 0.0641, 0.0804, 0.0815, 0.247, 1.0])
def test_of_a_size_that_was_seen_one_in_a_hundred_is_about_nothing_however_sure_it_is(size_m: float) -> None:
    for sigma_m in (1e-300, 1e-9, 2e-4, 1e-3, 0.01, 0.1, 1e300):
        said = np.exp(SizePrior(size_m, sigma_m).log_likelihood(LOG_SIZES))
        assert said.mean() == pytest.approx(1.0)
        assert said.min() >= MIXING - 1e-12
        # None is likelier than what is nearest to it.
        assert said.max() == said[np.abs(np.exp(LOG_SIZES) - size_m).argmin()]


@pytest.mark.parametrize("between", [0.0, 0.25, 0.5, 0.75])
def test_the_surer_a_size_was_seen_the_more_it_says(between: float) -> None:
    """Wherever it lies between two of the sizes that are told apart, which are 2.6 % apart."""
    size_m = float(np.exp(LOG_SIZES[40] + between * (LOG_SIZES[41] - LOG_SIZES[40])))
    rng = np.random.default_rng(4)
    sizes = np.exp(rng.uniform(np.log(0.03), np.log(0.12), 300)).tolist()
    of = Library.from_examples(
        {"ball": [[Evidence("tip", {"a": rng.normal()})] for _ in sizes]}, sizes_m={"ball": sizes}
    )
    told = [
        Belief.before(of, NameEvidence("camera", {"ball": 1.0}, pose=SizePrior(size_m, sigma_m))).size()
        for sigma_m in (0.012, 0.004, 0.002, 5e-4, 1e-4, 1e-6)
    ]
    middle, low, high = np.array(told).T
    assert (np.abs(middle[1:] / size_m - 1) < 0.02).all()
    assert (low < size_m).all()
    assert (size_m < high).all()
    # Known more finely than steps tell it, it is told as finely as these.
    assert (np.diff(np.log(high / low)) < 0.005).all()
    assert np.log(high[-1] / low[-1]) < 0.08
