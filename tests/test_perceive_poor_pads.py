"""A library felt again by poorer taxels: what changes, by how much, what does not, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.perceive import Evidence, Library, for_pads, library_file, poor_pads, read_library, shipped_library
from varishold.perceive.poor_pads import _Changes, _touches
from varishold.perceive.touch_model import conformities
from varishold.skin import Taxels

pytestmark = pytest.mark.skipif(not library_file._SHIPPED.is_file(), reason="no library of objects is shipped")
POOR = Taxels(noise=0.03, crosstalk=0.08, gain_spread=0.15, dead=0.03)


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few touches are felt again, which is quick."""
    some = _touches()[::17]
    monkeypatch.setattr(poor_pads, "_touches", lambda: some)
    monkeypatch.setattr(poor_pads, "_PADS", 1)


@pytest.fixture(scope="module")
def small() -> Library:
    """Every fifth example of two objects, and two of their touches."""
    library = shipped_library().only(["sphere", "box"])
    keep = np.arange(0, len(library), 5)
    touches = {
        touch: replace(
            model,
            **{what: getattr(model, what)[keep] for what in ("values", "size_values", "scores", "failed", "optimism")},
            others=model.others[::5],
        )
        for touch, model in library.touches.items()
        if touch in ("grasp", "fingertip-middle")
    }
    return replace(library, owner=library.owner[keep], log_size=library.log_size[keep], touches=touches)


def test_every_example_changes_as_a_like_press_did() -> None:
    rng = np.random.default_rng(0)
    usual = np.column_stack([np.ones(200), np.repeat([0.0, 50.0], 100) + rng.normal(size=200)])
    # What lies near 0 is moved by 3, what lies near 50 by -7, and every tenth is not felt at all.
    poor = usual + np.column_stack([np.zeros(200), np.repeat([3.0, -7.0], 100)])
    lost = np.arange(200) % 10 == 0
    poor[lost] = 0.0
    changes = _Changes(("on", "curve"), usual, poor)
    values = np.column_stack([np.ones(300), np.repeat([0.0, 50.0], 150)])
    changed = changes.applied(values, np.random.default_rng(1))
    gone = changed[:, 0] == 0
    assert 0.02 < gone.mean() < 0.25
    assert not changed[gone].any()
    np.testing.assert_allclose(changed[~gone] - values[~gone], np.repeat([[0, 3], [0, -7]], 150, axis=0)[~gone])


def test_one_press_is_like_every_other() -> None:
    changes = _Changes(("curve",), np.array([[1.0]]), np.array([[1.5]]))
    np.testing.assert_allclose(changes.applied(np.array([[4.0], [5.0]]), np.random.default_rng(0)), [[4.5], [5.5]])


@pytest.mark.usefixtures("few")
def test_only_what_pads_say_is_changed_and_the_library_stays_as_it_was(small: Library) -> None:
    before = {touch: model.values.copy() for touch, model in small.touches.items()}
    seen: list[tuple[int, int]] = []
    poor = for_pads(small, POOR, progress=lambda done, of: seen.append((done, of)))
    n = len(poor_pads._touches())
    assert seen == [(k + 1, n) for k in range(n)]
    assert (poor.objects, poor.owner is small.owner) == (small.objects, True)
    for touch, model in poor.touches.items():
        old = small.touches[touch]
        np.testing.assert_array_equal(old.values, before[touch])
        assert (model.width, model.fall, model.cost) == (old.width, old.fall, old.cost)
        assert model.metric.names == old.metric.names
        for k, name in enumerate(model.metric.names):
            same = np.array_equal(model.values[:, k], old.values[:, k], equal_nan=True)
            touched = name.startswith("pad.") or name in ("form.pads_round", "form.least_round")
            pressed = touched and np.nanstd(old.values[:, k]) > 0
            assert same or touched, name
            assert not (same and pressed and not name.endswith(".on")), name
        np.testing.assert_array_equal(np.isnan(model.values), np.isnan(old.values))
        np.testing.assert_array_equal(model.size_values, old.size_values)
        np.testing.assert_array_equal(model.failed, old.failed)
        pads = [k for k, name in enumerate(model.metric.names) if name.endswith(".on")]
        for k in pads:
            # A pad on which nothing lies says nothing under any taxels.
            nothing = old.values[:, k] == 0
            own = [j for j, name in enumerate(model.metric.names) if name.startswith(model.metric.names[k][:-2])]
            np.testing.assert_array_equal(model.values[nothing][:, own], old.values[nothing][:, own])


@pytest.mark.usefixtures("few")
def test_poorer_taxels_scatter_more_and_the_same_seed_gives_the_same_library(small: Library) -> None:
    def scatter(library: Library) -> float:
        """How far the touches of one object lie apart, by the shipped library's own measure."""
        model = library.touches["grasp"]
        names = [k for k, name in enumerate(model.metric.names) if name.startswith("pad.")]
        units = small.touches["grasp"].metric.standardized(model.values)[:, names]
        return float(np.nanstd(units[library.owner == 1], axis=0).mean())

    usual, slightly, very = (
        scatter(for_pads(small, taxels)) for taxels in (Taxels(noise=0.01), Taxels(noise=0.05), replace(POOR, dead=0.1))
    )
    assert usual < slightly < very
    assert usual < 1.1 * scatter(small)
    first, again, other = (for_pads(small, POOR, seed=seed).touches["grasp"].values for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other, equal_nan=True)


@pytest.mark.usefixtures("few")
def test_examples_of_a_small_library_are_judged_by_the_scatter_of_the_others(small: Library) -> None:
    felt = small.touches["grasp"]
    rows = {name: np.flatnonzero(small.owner == k)[:12] for k, name in enumerate(small.objects)}
    own = Library.from_examples(
        {
            name: [[Evidence("grasp", dict(zip(felt.metric.names, felt.values[i], strict=True)))] for i in some]
            for name, some in rows.items()
        }
    )
    model = for_pads(own, Taxels(noise=0.05, dead=0.03)).touches["grasp"]
    made = np.flatnonzero(model.made)
    assert (model.scores[made] < conformities(model, own.kind, made) - 0.1).all()


@pytest.mark.parametrize(
    ("taxels", "seed", "said"),
    [
        (0.03, 0, r"taxels must be a varishold\.skin\.Taxels, got 0\.03"),
        (POOR, -1, "seed must be a whole number from 0 on, got -1"),
        (POOR, 0.5, r"seed must be a whole number from 0 on, got 0\.5"),
    ],
)
def test_what_is_no_taxels_or_no_seed_is_refused(small: Library, taxels: Any, seed: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        for_pads(small, taxels, seed=seed)


def test_a_library_without_pads_is_told() -> None:
    blind = Library.from_examples({"ball": [[Evidence("grasp", {"switch.thumb": 1.0})] * 1] * 3})
    with pytest.raises(InputError, match="no touch of the library knows a pad, so that taxels change nothing"):
        for_pads(blind, POOR)


@pytest.mark.usefixtures("few")
def test_a_touch_that_knows_no_pad_stays_as_it_is(small: Library) -> None:
    examples = {
        name: [
            [
                Evidence("grasp", dict(zip(small.touches["grasp"].metric.names, row, strict=True))),
                Evidence("look", {"seen": float(k)}),
            ]
            for k, row in enumerate(small.touches["grasp"].values[small.owner == owner][:12])
        ]
        for owner, name in enumerate(small.objects)
    }
    library = Library.from_examples(examples)
    poor = for_pads(library, POOR)
    assert poor.touches["look"] is library.touches["look"]
    assert poor.touches["grasp"] is not library.touches["grasp"]


@pytest.mark.usefixtures("few")
def test_the_command_writes_a_library_that_others_take(run: Any, small: Library, tmp_path: Path) -> None:
    library_file.write_library(small, tmp_path / "known.npz")
    words = "noise=.03, gain_spread=.15,dead=.03"
    status, said, told = run("objects", "taxels", words, "--library", "known.npz", "-o", "poor.npz", "--json")
    assert (status, told) == (0, "")
    assert json.loads(said) == {
        "library": "poor.npz",
        "objects": 2,
        "taxels": {"noise": 0.03, "gain-spread": 0.15, "dead": 0.03},
        "seed": 0,
    }
    poor = read_library(tmp_path / "poor.npz")
    assert poor.objects == ("sphere", "box")
    written = (tmp_path / "poor.npz").read_bytes()
    assert run("objects", "taxels", words, "--library", "known.npz", "-o", "poor.npz")[0] == 0
    assert (tmp_path / "poor.npz").read_bytes() == written
    assert run("objects", "taxels", words, "--library", "poor.npz", "-o", "poor.npz")[0] == 1


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("taxels", [Taxels(dead=1.0)])
def test_taxels_that_feel_nothing_are_refused(small: Library, taxels: Taxels) -> None:
    with pytest.raises(InputError, match=r"such taxels feel \d+ of \d+ presses: too few"):
        for_pads(small, taxels)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "got '', which is no kind"),
        ("loudness=3", "of noise, crosstalk, gain-spread, dead, stuck, bits; got 'loudness=3', which is no kind"),
        ("noise=.1,noise=.2", "got 'noise=.2', twice"),
        ("noise", "noise of taxels must be a number in 0 .. 1, got ''"),
        ("noise=loud", "noise of taxels must be a number in 0 .. 1, got 'loud'"),
        ("noise=1e308", "noise of taxels must be a number in 0 .. 1, got '1e308'"),
        ("dead=nan", "dead of taxels must be a number in 0 .. 1, got 'nan'"),
        ("gain-spread=-.1", "gain-spread of taxels must be a number in 0 .. 1, got '-.1'"),
        ("bits=3.5", "bits of taxels must be a whole number in 1 .. 32, got '3.5'"),
        ("bits=99999999999999999999999", "bits of taxels must be a whole number in 1 .. 32"),
        ("bits=inf", "bits of taxels must be a whole number in 1 .. 32"),
        ("crosstalk=.3", "crosstalk of taxels must be a number in 0 .. 0.24, got '.3'"),
        ("dead=.7,stuck=.6", "must not exceed 1 together"),
    ],
)
def test_words_that_tell_no_taxels_are_refused_in_one_line(run: Any, words: str, said: str) -> None:
    status, out, told = run("objects", "taxels", words, "-o", "poor.npz")
    assert (status, out, told.count("\n")) == (1, "", 1)
    assert said in told
