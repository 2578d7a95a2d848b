"""The plain peers of the yardstick: their features, and what they learn from."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import yardstick_peers as peers
from benchmarks._convolutional import ConvolutionalNetwork
from varishold.evaluation.yardstick import SEED, read_answer
from varishold.evaluation.yardstick.forms import KINDS


def bump(side: int, x: float, y: float, wide: float) -> np.ndarray:
    """Return two bumps of which one is higher, so that no moment vanishes."""
    at = np.arange(side)
    one = np.exp(-((at[None, :] - x) ** 2) / 4 - (at[:, None] - y) ** 2 / (4 * wide))
    return one + 0.7 * np.exp(-((at[None, :] - x - 3) ** 2) / 3 - (at[:, None] - y - 1) ** 2 / 2)


@pytest.mark.parametrize("side", [16, 32])
@pytest.mark.parametrize("feature", [peers.raw, peers.moments, peers.hu, peers.hog, peers.middle])
def test_features_do_not_depend_on_how_hard_it_is_pressed(feature: peers.Feature, side: int) -> None:
    frames = np.array([bump(side, 7, 8, 1), bump(side, 5, 9, 2)])
    found = feature(frames)
    assert found.shape[0] == 2
    assert np.isfinite(found).all()
    assert np.allclose(found, feature(3 * frames))
    assert not np.allclose(found[0], found[1])


@pytest.mark.parametrize("feature", [peers.moments, peers.hu, peers.middle])
def test_what_is_felt_elsewhere_is_felt_alike(feature: peers.Feature) -> None:
    here, there = feature(np.array([bump(32, 14, 15, 2), bump(32, 16, 12, 2)]))
    assert np.allclose(here, there, atol=1e-3)


def test_a_quarter_turn_turns_the_gradients() -> None:
    """Along the columns and along the rows: the first and the middle direction."""
    ramp = np.tile(np.linspace(0.0, 1.0, 16), (16, 1))
    across, down = peers.hog(np.array([ramp, ramp.T])).reshape(2, -1, 9).sum(axis=1)
    assert across.argmax() == 0
    assert down.argmax() == 4


def test_peers_learn_by_other_seeds_and_answer_as_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "CLEAN_FRAMES", 2)
    monkeypatch.setattr(peers, "PEERS", ((peers.moments, "forest"),))
    assert all(peers.TRAINING_SEED + 100 * k != SEED for k in range(100))
    frames, names = peers.training_frames(16, False, peers.TRAINING_SEED)
    assert frames.shape == (4 * len(KINDS), 16, 16)
    assert set(names) == set(KINDS) - {"hip"}
    (peer,) = peers.peers(16, False, peers.TRAINING_SEED).values()
    told = [read_answer(answer) for answer in peer(frames)]
    assert np.mean([one.name == name for one, name in zip(told, names, strict=True)]) > 0.9


def test_the_convolutional_network_learns_and_its_gradients_are_those_of_its_loss() -> None:
    rng = np.random.default_rng(0)
    at = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)
    middles = rng.uniform(5, 11, (256, 1, 1, 2))
    wide = rng.integers(0, 2, 256)
    images = np.exp(-((at - middles) ** 2).sum(axis=-1) / np.where(wide, 12.0, 4.0)[:, None, None]).reshape(256, -1)
    names = np.array(["narrow", "wide"])[wide]
    network = ConvolutionalNetwork(epochs=12).fit(images[:192], names[:192])
    told = network.predict_proba(images[192:])
    assert np.allclose(told.sum(axis=1), 1)
    assert np.mean(network.classes_[told.argmax(axis=1)] == names[192:]) > 0.9
    x, target = images[:8].reshape(8, 16, 16, 1), wide[:8]
    parameters = [p for layer in network._layers for p in (layer.weights, layer.bias)]

    def loss() -> float:
        return float(-np.log(network.predict_proba(x.reshape(8, -1))[np.arange(8), target]).mean())

    for parameter, gradient in zip(parameters, network._gradients(x.astype(np.float32), target), strict=False):
        place = np.unravel_index(np.abs(gradient).argmax(), gradient.shape)
        was, step = parameter[place], 1e-2
        ends = []
        for sign in (1, -1):
            parameter[place] = was + sign * step
            ends.append(loss())
        parameter[place] = was
        assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(gradient[place], rel=0.05, abs=1e-4)
