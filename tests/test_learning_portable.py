"""Laws of the classifier that a controller can hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.utils.estimator_checks import parametrize_with_checks

from varishold import Pad, Recording
from varishold.errors import InputError
from varishold.learning import PortableClassifier, evidence_of_presses
from varishold.learning.pad_networks import refusal_limit
from varishold.learning.portable import strongest_frames
from varishold.solids import Cone, Pose, Sphere, SquarePillar, ideal_frame
from varishold.touch import find_contacts
from varishold.touch.contact_network import NONE_OF_THESE
from varishold.touch.course.presses import as_presses
from varishold.touch.recognizer import decided
from varishold.trust import conformal_p_value

SHAPE = (12, 14)
SOLIDS = {"cone": Cone(8.0, 4.0), "sphere": Sphere(9.0), "pillar": SquarePillar(6.0, 4.0)}


def press(name: str, rng: np.random.Generator, *, n_frames: int = 9) -> np.ndarray:
    """A ramp of a solid that lies anywhere near the middle, noise of one percent."""
    frame = ideal_frame(SOLIDS[name], SHAPE, 1.0, pose=Pose(*rng.uniform(-1, 1, 2)))
    ramp = np.concatenate([[0.0], np.sin(np.linspace(0.15, 0.5 * np.pi, n_frames - 2)), [0.3]])
    return 100 * rng.uniform(0.8, 1.2) * (ramp[:, None, None] * frame / 4 + rng.normal(0, 0.01, (n_frames, *SHAPE)))


def presses(seed: int, each: int = 8) -> tuple[list[np.ndarray], np.ndarray]:
    rng = np.random.default_rng(seed)
    labels = np.tile(list(SOLIDS), each)
    return [press(name, rng, n_frames=int(rng.integers(7, 12))) for name in labels], labels


def strange(seed: int, count: int) -> list[np.ndarray]:
    """A blot of a hand: two bars that cross, and a corner."""
    rng = np.random.default_rng(seed)
    blots = []
    for _ in range(count):
        frame = np.zeros(SHAPE)
        frame[5:7, 1:13] = frame[1:11, 6:8] = 60.0
        frame[8:11, 2:5] = 90.0
        blots.append(np.linspace(0, 1, 6)[:, None, None] * frame + rng.normal(0, 1, (6, *SHAPE)))
    return blots


@pytest.fixture(scope="module")
def fitted() -> PortableClassifier:
    return PortableClassifier().fit(*presses(0))


@parametrize_with_checks([PortableClassifier(folds=2)])
@pytest.mark.filterwarnings("ignore")
def test_scikit_learn_contract(estimator: Any, check: Any) -> None:
    check(estimator)


def test_presses_of_any_length_are_told(fitted: PortableClassifier) -> None:
    X, y = presses(1)
    assert fitted.score(X, y) > 0.95
    p = fitted.predict_proba(X)
    np.testing.assert_allclose(p.sum(axis=1), 1.0)
    assert p.shape == (len(X), 3)


def test_what_a_controller_holds_says_of_the_strongest_frame_what_the_classifier_says(
    fitted: PortableClassifier,
) -> None:
    X = presses(2)[0] + strange(3, 8)
    network = fitted.networks["pad_0"]
    assert network.names == ("cone", "pillar", "sphere", NONE_OF_THESE)
    plain, refused = fitted._said(as_presses(X))[0], fitted.refused(X)
    assert 0 < refused.sum() < len(X)
    for k, one in enumerate(as_presses(X)):
        contact = find_contacts(strongest_frames(one)["pad_0"])[0]
        said = decided(contact, network.kernel)
        assert said is not None
        answer, _, p = said
        if refused[k]:
            assert network.names[answer.name] == NONE_OF_THESE
        else:
            assert network.names[answer.name] == fitted.classes_[plain[k].argmax()]
            np.testing.assert_allclose(p[:3], plain[k], atol=1e-4)
            assert p[3] == 0


def test_neither_place_nor_load_nor_what_is_around_the_peak_changes_an_answer() -> None:
    X, y = presses(4, each=4)
    X = [np.pad(np.clip(np.round(frames), 3, None) - 3, ((0, 0), (4, 4), (4, 4))) for frames in X]
    clf = PortableClassifier().fit(X, y)
    plain = clf.predict_proba(X)
    for same in (
        [np.roll(frames, (3, -2), axis=(1, 2)) for frames in X],
        [4.0 * frames for frames in X],
        [np.concatenate([frames, 0.3 * frames[-2:-1], 0 * frames[:3]]) for frames in X],
        [frames[[0, int(frames.sum(axis=(1, 2)).argmax())]] for frames in X],
    ):
        np.testing.assert_allclose(clf.predict_proba(same), plain, atol=1e-6)


def test_names_of_classes_and_their_order_change_nothing() -> None:
    X, y = presses(5)
    new = {"cone": "z", "sphere": "a", "pillar": "m"}
    one = PortableClassifier().fit(X, y)
    other = PortableClassifier().fit(X, [new[name] for name in y])
    order = [list(other.classes_).index(new[name]) for name in one.classes_]
    np.testing.assert_allclose(other.predict_proba(X)[:, order], one.predict_proba(X), atol=1e-6)


def test_what_was_never_learned_is_refused_and_known_things_hardly_are(fitted: PortableClassifier) -> None:
    X, _ = presses(7, each=40)
    assert fitted.refused(X).mean() < 0.15
    assert fitted.refused(strange(8, 20)).mean() > 0.9
    assert fitted.predict_proba(strange(8, 20)).max() <= 0.9


def test_a_press_of_nothing_is_refused(fitted: PortableClassifier) -> None:
    assert fitted.refused([np.zeros((5, *SHAPE))]).tolist() == [True]
    (found,) = fitted.explain([np.zeros((5, *SHAPE))])
    assert np.isfinite([found.probability, found.p_value, *(nats for _, nats in found.measures)]).all()


def test_an_explanation_names_groups_of_numbers_and_the_nearest_press(fitted: PortableClassifier) -> None:
    X, y = presses(0)
    for k, found in enumerate(fitted.explain(X[:9])):
        assert found.label == y[k] == found.nearest_label
        assert found.nearest == f"press {k}"
        nats = [value for _, value in found.measures]
        assert nats == sorted(nats, reverse=True)
        assert nats[0] > 0


def test_several_pads_are_weighed_together_and_one_may_be_missing() -> None:
    X, y = presses(9, each=12)
    noise = np.random.default_rng(0).permutation(len(X))
    both = [
        Recording({"left": Pad(frames), "right": Pad(X[other][np.arange(len(frames)) % len(X[other])])})
        for frames, other in zip(X, noise, strict=True)
    ]
    clf = PortableClassifier().fit(both, y)
    assert set(clf.networks) == {"left", "right"}
    assert clf.score(both, y) > 0.9
    alone = [Recording({"left": Pad(frames)}) for frames in X]
    assert clf.score(alone, y) > 0.9
    dead = np.ones(SHAPE, bool)
    dead[3, 3] = False
    assert clf.score([Recording({"left": Pad(frames, valid=dead)}) for frames in X], y) > 0.9


def test_the_same_presses_teach_the_same(fitted: PortableClassifier) -> None:
    again = clone(fitted).fit(*presses(0))
    X, _ = presses(1, each=2)
    np.testing.assert_array_equal(again.predict_proba(X), fitted.predict_proba(X))


def test_whole_sessions_are_held_out() -> None:
    X, y = presses(6)
    session = np.repeat([0, 1, 2, 3], 6)
    assert not any("session" in remark for remark in PortableClassifier().fit(X, y, session).remarks_)
    assert any("no sessions are known" in remark for remark in PortableClassifier().fit(X, y).remarks_)


def test_a_limit_refuses_what_its_p_value_refuses() -> None:
    rng = np.random.default_rng(0)
    for n, error in ((19, 0.05), (40, 0.1), (7, 0.3), (100, 0.05)):
        known = rng.uniform(0, 1, n)
        limit = refusal_limit(known, error)
        asked = np.concatenate([rng.uniform(0, 1.2, 200), known])
        np.testing.assert_array_equal(asked > limit, conformal_p_value(asked, known) <= error)
    assert refusal_limit(rng.uniform(0, 1, 18), 0.05) == np.inf


def test_where_too_few_were_held_out_nothing_is_refused() -> None:
    X, y = presses(0, each=4)
    clf = PortableClassifier(error=0.001, drift=0.0).fit(X, y)
    (network,) = clf.networks.values()
    assert network.means.size == 0
    assert not clf.refused(strange(0, 3)).any()


def test_answers_are_evidence(fitted: PortableClassifier) -> None:
    X, _ = presses(1, each=1)
    assert len(evidence_of_presses(fitted, as_presses(X), source="skin")) == 3


@pytest.mark.parametrize(
    ("X", "y", "told"),
    [
        (
            list(np.random.default_rng(0).random((512, 3, 9, 9))),
            np.arange(512) // 2,
            "a controller tells 255 things apart at most, got 256",
        ),
        (presses(0)[0], np.where(presses(0)[1] == "cone", NONE_OF_THESE, "b"), "no thing can be called 'none of"),
        ([np.zeros((3, 9, 9))] * 8, np.arange(8) % 2, "nothing touches in any press"),
    ],
)
def test_what_a_controller_cannot_hold_is_told(X: list[np.ndarray], y: np.ndarray, told: str) -> None:
    with pytest.raises(InputError, match=told):
        PortableClassifier().fit(X, y)


def test_what_it_cannot_do_is_told(fitted: PortableClassifier) -> None:
    X, _ = presses(0)
    with pytest.raises(InputError, match="takes no class more: learn all of them together"):
        fitted.add("cube", X[:4])
    with pytest.raises(InputError, match="is adapted to no session"):
        fitted.adapt(X[:4])
    with pytest.raises(InputError, match="the model is of another sensor"):
        fitted.predict([np.ones((3, 9, 9))])


def test_what_cannot_be_exported_is_noted() -> None:
    X, y = presses(0)
    wide = [np.pad(frames, ((0, 0), (0, 0), (0, 36))) for frames in X]
    assert PortableClassifier().fit(wide, y).remarks_[-1] == (
        "pad_0 cannot be exported: a controller's pad has 4 to 48 rows and columns, got 12x50"
    )


def test_what_is_not_learned_is_noted() -> None:
    X, y = presses(0)
    columns = {"angle_rad.thumb": np.array([0.3]), "switch.a": np.array([1]), "day": np.array(["mon"])}
    given = [Recording({"pad": Pad(f)}, press=np.zeros(len(f), int), press_columns=columns) for f in X]
    (noted,) = [remark for remark in PortableClassifier().fit(given, y).remarks_ if "not learned" in remark]
    assert noted == "angle_rad.thumb, switch.a: not learned, for a controller's pad tells forms alone"
