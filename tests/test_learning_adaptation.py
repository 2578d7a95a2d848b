"""Laws of adaptation: drift from presses that nobody has labelled."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.test_learning_classifier import SHAPE, SOLIDS
from tests.test_learning_commands import told

from varishold import Pad, Recording, TactileClassifier, write
from varishold.errors import InputError
from varishold.learning import write_model
from varishold.solids import Pose, ideal_frame


def press(name: str, rng: np.random.Generator, x: float = 0.0, load: float = 1.0) -> np.ndarray:
    """A ramp of a solid that lies at x, noise of one percent."""
    frame = ideal_frame(SOLIDS[name], SHAPE, 1.0, pose=Pose(x + rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3)))
    ramp = np.concatenate([[0.0], np.linspace(0.2, 1.0, 6)])
    return 100 * load * rng.uniform(0.9, 1.1) * (ramp[:, None, None] * frame / 4 + rng.normal(0, 0.005, (7, *SHAPE)))


def presses(seed: int, each: int = 8, **how: float) -> tuple[list[np.ndarray], np.ndarray]:
    rng = np.random.default_rng(seed)
    labels = np.tile(list(SOLIDS), each)
    return [press(name, rng, **how) for name in labels], labels


@pytest.fixture(scope="module")
def fitted() -> TactileClassifier:
    return TactileClassifier(position=True, absolute=True, drift=0.02).fit(*presses(0))


@pytest.mark.parametrize("x", [-0.8, 0.8, 1.5])
def test_a_hand_that_sits_elsewhere_is_made_up_for(fitted: TactileClassifier, x: float) -> None:
    adapted = fitted.adapt(presses(1, x=x)[0])
    scale = fitted.learned_.sources["touch"].scaling.scale
    names = np.array(adapted.measure_names_)
    for axis, truth in (("x", x), ("y", 0.0)):
        of = names == f"pad_0_{axis}_at_0.25_of_peak"
        moved = float((adapted.learned_.drift["touch"][of] / scale[of])[0])
        assert moved == pytest.approx(truth, abs=0.15)
    new, labels = presses(2, x=x)
    assert adapted.score(new, labels) > 0.95
    assert adapted.refused(new).mean() <= fitted.refused(new).mean()


@pytest.mark.parametrize("load", [1.0, 0.6])
@pytest.mark.parametrize("things", [2, 3])
@pytest.mark.parametrize("x", [1.5, 2.5])
def test_four_presses_of_each_of_two_things_are_enough_however_strange_their_place_and_load(
    fitted: TactileClassifier, x: float, things: int, load: float
) -> None:
    X, y = presses(10, each=4, x=x, load=load)
    adapted = fitted.adapt([one for one, name in zip(X, y, strict=True) if name in list(SOLIDS)[:things]])
    new, labels = presses(11, x=x, load=load)
    unlike = [sum(said.unlike_session for said in clf.explain(new)) for clf in (fitted, adapted)]
    assert adapted.score(new, labels) > 0.95
    assert unlike[1] <= unlike[0] / 2
    of = np.array(adapted.measure_names_) == "pad_0_x_at_0.25_of_peak"
    moved = adapted.learned_.drift["touch"][of] / fitted.learned_.sources["touch"].scaling.scale[of]
    assert moved.tolist() == pytest.approx([x], abs=0.15)


def test_where_nothing_has_drifted_hardly_anything_changes(fitted: TactileClassifier) -> None:
    X, _ = presses(3)
    adapted = fitted.adapt(X)
    assert np.abs(adapted.learned_.drift["touch"]).mean() < 0.15
    assert adapted.score(*presses(4)) > 0.95


def test_the_one_that_it_comes_from_stays_as_it_is(fitted: TactileClassifier) -> None:
    X, _ = presses(5, x=0.8)
    before = fitted.predict_proba(X)
    adapted = fitted.adapt(X)
    np.testing.assert_array_equal(fitted.predict_proba(X), before)
    assert fitted.adapted_to_ == 0
    assert adapted.adapted_to_ == len(X)
    # Adapting anew starts from what was learned, not from what was adapted.
    np.testing.assert_array_equal(adapted.adapt(X).predict_proba(X), adapted.predict_proba(X))


def test_strangers_among_them_hardly_count(fitted: TactileClassifier) -> None:
    X, _ = presses(6)
    rng = np.random.default_rng(6)
    strange = [100 * rng.uniform(0, 1, (7, 1, 1)) * rng.uniform(0, 1, SHAPE) for _ in range(8)]
    alone, among = fitted.adapt(X).learned_.drift["touch"], fitted.adapt([*X, *strange]).learned_.drift["touch"]
    assert np.abs(among - alone).mean() < 0.02


def faint(X: list[np.ndarray]) -> list[np.ndarray]:
    """Presses that bear less than a tenth of the least that was learned, and their noise."""
    return [0.02 * x for x in X]


def test_presses_that_bear_nothing_change_nothing_and_are_not_counted(fitted: TactileClassifier) -> None:
    X, _ = presses(6, x=0.8)
    among = fitted.adapt([*faint(X[:3]), *X, *faint(X[3:])])
    alone = fitted.adapt(X)
    assert among.adapted_to_ == alone.adapted_to_ == len(X)
    for name, drift in alone.learned_.drift.items():
        np.testing.assert_array_equal(among.learned_.drift[name], drift)
    with pytest.raises(InputError, match=f"none of {len(X)} new presses bears a tenth of the least load that was"):
        fitted.adapt(faint(X))
    with pytest.raises(InputError, match=r"only \d.\d of 2 new presses are like what is known"):
        fitted.adapt([*X[:2], *faint(X)])


def test_the_same_press_once_more_tells_no_more_of_drift(fitted: TactileClassifier) -> None:
    X, _ = presses(6, x=0.8)
    again, alone = fitted.adapt([*X, *X[:7]]), fitted.adapt(X)
    assert again.adapted_to_ == len(X)
    np.testing.assert_array_equal(again.learned_.drift["touch"], alone.learned_.drift["touch"])
    with pytest.raises(InputError, match=r"only \d.\d of 3 new presses are like what is known, 5 are needed"):
        fitted.adapt([*X[:3]] * 4)


def test_the_command_tells_how_many_are_copies(fitted: TactileClassifier, tmp_path: Path) -> None:
    X, _ = presses(9, each=3)
    write_model(fitted, tmp_path / "model.npz")
    for name, some in (("new", X), ("same", X[:2])):
        press = np.repeat(np.arange(len(some)), [len(x) for x in some])
        write(Recording({"pad_0": Pad(np.concatenate(some))}, press=press), tmp_path / f"{name}.npz")
    said = told("recognize", tmp_path / "model.npz", tmp_path / "new.npz", tmp_path / "same.npz", "--adapt").stdout
    assert f"was estimated from {len(X)} of these {len(X) + 2} presses; 2 copies of others left out" in said


@pytest.mark.parametrize(("n_faint", "told_of"), [(1, "1 that bears"), (3, "3 that bear")])
def test_the_command_tells_how_many_bear_nothing(
    fitted: TactileClassifier, tmp_path: Path, n_faint: int, told_of: str
) -> None:
    X, _ = presses(9, each=3)
    every = [*X, *faint(X[:n_faint])]
    write_model(fitted, tmp_path / "model.npz")
    press = np.repeat(np.arange(len(every)), [len(x) for x in every])
    write(Recording({"pad_0": Pad(np.concatenate(every))}, press=press), tmp_path / "new.npz")
    assert (
        f"note: drift since the model was learned was estimated from {len(X)} of these {len(every)} presses; {told_of} "
        "next to nothing left out" in told("recognize", tmp_path / "model.npz", tmp_path / "new.npz", "--adapt").stdout
    )


def test_presses_of_one_thing_or_of_nothing_known_tell_no_drift(fitted: TactileClassifier) -> None:
    X, y = presses(7)
    cones = [x for x, name in zip(X, y, strict=True) if name == "cone"]
    with pytest.raises(InputError, match="the new presses are all of one thing"):
        fitted.adapt(cones)
    with pytest.raises(InputError, match=r"only \d.\d of 2 new presses are like what is known, 5 are needed"):
        fitted.adapt(X[:2])


def test_an_answer_says_that_it_was_adapted(fitted: TactileClassifier, tmp_path: Path) -> None:
    X, _ = presses(8)
    adapted = fitted.adapt(X)
    assert adapted.explain(X[:1])[0].to_dict()["adapted_to"] == len(X)
    assert "adapted_to" not in fitted.explain(X[:1])[0].to_dict()
    with pytest.raises(InputError, match="was adapted to one session; write the one that it comes from"):
        write_model(adapted, tmp_path / "model.npz")


def test_the_command_adapts(fitted: TactileClassifier, tmp_path: Path) -> None:
    X, _ = presses(9, each=3)
    write_model(fitted, tmp_path / "model.npz")
    lengths = [len(x) for x in X]
    recording = Recording({"pad_0": Pad(np.concatenate(X))}, press=np.repeat(np.arange(len(X)), lengths))
    write(recording, tmp_path / "new.npz")
    printed = told("recognize", tmp_path / "model.npz", tmp_path / "new.npz", "--adapt")
    assert printed.exit_code == 0
    assert f"note: drift since the model was learned was estimated from these {len(X)} presses" in printed.stdout
    printed = told("recognize", tmp_path / "model.npz", tmp_path / "new.npz", "--adapt", "--json")
    assert printed.stdout.count(f'"adapted_to": {len(X)}') == len(X)
