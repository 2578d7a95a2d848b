"""The kernel's signature and decision against the same in plain numpy."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from itertools import pairwise

import numpy as np
import pytest
from tests.reference_signature import reference_logits, reference_signature

from varishold.levelset.contact import Contact
from varishold.skin.synthesis import _toeplitz
from varishold.touch import contact_signature, find_contacts, recognize
from varishold.touch.decision import Parameters, kind_logits, load_parameters
from varishold.touch.names import KINDS, NAMES
from varishold.touch.reasons import evidence
from varishold.touch.scale import LEVELS, MOST_SIDE, bridged, spanned
from varishold.touch.signature import SIGNATURE_GROUPS, SIGNATURE_NAMES

# The root of what is left of two nearly equal sums.
LOOSE = {"unevenness": 1e-6}


def faces(u: np.ndarray, v: np.ndarray, r: float) -> list[np.ndarray]:
    """Return faces of breadth r over coordinates: cone, sphere, pillar, ridge, edge, ring, plane."""
    away = np.hypot(u, v)
    return [
        np.maximum(r - away, 0),
        np.sqrt(np.maximum(r * r - away**2, 0)),
        5 * np.clip(r - np.maximum(np.abs(u), np.abs(v)), 0, 1),
        np.maximum(r - np.abs(u) - 0.3 * np.abs(v), 0),
        np.clip((r - u) / 2, 0, 3),
        7 * np.exp(-((away - r / 1.5) ** 2) / 3),
        np.full_like(u, 4.0),
    ]


def contacts_of(seed: int) -> list[Contact]:
    """Return the contacts of a drawn frame: pitch, gaps, noise, saturation, rounding, a second press by the seed."""
    rng = np.random.default_rng(seed)
    rows, cols = [(16, 16), (12, 20), (24, 18), (9, 9), (14, 150)][seed % 5]
    y, x = np.mgrid[:rows, :cols].astype(float)
    x, y = x - cols / 2 - rng.normal(0, 1.5), y - rows / 2 - rng.normal(0, 1.5)
    turn, r = rng.uniform(0, np.pi), rng.uniform(2, min(rows, cols) / 2)
    u, v = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    frame = faces(u, v, r)[seed % 7] * 10 ** rng.uniform(-2, 4)
    options: dict[str, object] = {}
    if seed % 3:
        frame = frame + rng.normal(0, 0.01 * frame.max(), frame.shape)
    if seed % 4 == 1:
        options["pitch"] = (0.002, 0.003)
    if seed % 5 == 0:
        frame = np.minimum(frame, 0.8 * frame.max())
    if seed % 6 == 2:
        frame = np.round(frame / frame.max() * 40)
    if seed % 7 == 3:
        options["field"] = rng.random(frame.shape) > 0.1
    if seed % 9 == 4:
        frame[:4, :4] += 0.6 * frame.max()
    return find_contacts(frame, [32, 8, 64][seed % 3], **options)


@pytest.mark.parametrize("seed", range(42))
def test_every_number_of_the_signature_is_that_of_the_reference(seed: int) -> None:
    for contact in contacts_of(seed):
        ours, theirs = contact_signature(contact), reference_signature(contact)
        for name, one, other in zip(SIGNATURE_NAMES, ours.tolist(), theirs.tolist(), strict=True):
            assert one == pytest.approx(other, rel=1e-9, abs=LOOSE.get(name, 1e-9)), name


@pytest.mark.parametrize("seed", range(14))
def test_names_and_log_odds_are_those_of_the_reference(seed: int) -> None:
    for contact in contacts_of(seed):
        if max(s.stop - s.start for s in contact.window) > MOST_SIDE:
            continue
        surface = recognize(contact)
        p = surface.parameters
        # A contact over small gaps is named as if there were none, and at levels of its own.
        seen = spanned(contact) if not contact.frame.even or contact.frame.n_levels < LEVELS else contact
        seen = bridged(seen) if seen.frame.has_gaps else seen
        white = np.clip((reference_signature(seen) - p.shift) * p.scale, -p.clip, p.clip)
        logits = reference_logits(white, p)
        assert kind_logits(surface.inputs, p) == pytest.approx(logits, abs=2e-3)
        if contact.frame.rest == (0, 0, 0) and surface.name != "plane":
            odds = np.exp(logits - logits.max())
            by_name = [sum(odds[k] for k, kind in enumerate(KINDS) if kind.name == name) for name in NAMES]
            assert surface.name == NAMES[int(np.argmax(by_name))]
            assert surface.probability == pytest.approx(max(by_name) / sum(by_name), abs=1e-3)


def test_a_decision_may_have_any_number_of_layers() -> None:
    rng = np.random.default_rng(0)
    shipped = load_parameters()
    n = len(SIGNATURE_NAMES)
    for widths in ((), (7,), (130, 3), (5, 64, 9, 31)):
        sizes = (n, *widths, len(KINDS))
        made: Parameters = dataclasses.replace(
            shipped,
            weights=tuple(rng.normal(0, 0.2, (a, b)).astype(np.float32) for a, b in pairwise(sizes)),
            biases=tuple(rng.normal(size=b).astype(np.float32) for b in sizes[1:]),
            whiten=rng.normal(0, 0.1, (sizes[-2], 6)).astype(np.float32),
            means=rng.normal(size=(4, 6)).astype(np.float32),
            farthest=0.5,
        )
        white = rng.normal(size=n)
        assert kind_logits(white, made) == pytest.approx(reference_logits(white, made), abs=1e-3)
        silent = dataclasses.replace(made, whiten=np.empty((0, 0), np.float32), means=np.empty((0, 0), np.float32))
        assert kind_logits(white, silent) == pytest.approx(reference_logits(white, silent), abs=1e-3)


@pytest.mark.parametrize("table", ["surfaces", "middle", "small", "early"])
def test_evidence_is_what_the_log_odds_lose_without_a_group(table: str) -> None:
    parameters = load_parameters(table)
    inputs = np.random.default_rng(1).normal(size=len(SIGNATURE_NAMES))
    kind, rival = 2, 5

    def odds(given: np.ndarray) -> float:
        logits = reference_logits(given, parameters)
        return float(logits[kind] - logits[rival])

    found = evidence(inputs, parameters, kind, rival)
    assert list(found.values()) == sorted(found.values(), reverse=True)
    for group, nats in found.items():
        other = np.where(np.array(SIGNATURE_GROUPS) == group, parameters.kind_means[rival], inputs)
        assert nats == pytest.approx(odds(inputs) - odds(other), abs=2e-3)


def test_a_signature_may_be_asked_by_many_threads_at_once() -> None:
    from concurrent.futures import ThreadPoolExecutor

    contacts = [contact for seed in range(12) for contact in contacts_of(seed)]
    one_by_one = [recognize(contact).kind_probability for contact in contacts]
    with ThreadPoolExecutor(4) as pool:
        for alone, beside in zip(one_by_one, pool.map(lambda c: recognize(c).kind_probability, contacts), strict=True):
            assert np.array_equal(alone, beside)


def test_an_answer_can_be_copied_and_sent_elsewhere() -> None:
    surface = recognize(contacts_of(0)[0])
    for other in (copy.deepcopy(surface), pickle.loads(pickle.dumps(surface))):
        assert other.reasons == surface.reasons
        assert np.array_equal(recognize(other.contact).kind_probability, surface.kind_probability)
        assert np.array_equal(
            kind_logits(other.inputs, other.parameters), kind_logits(surface.inputs, other.parameters)
        )


@pytest.mark.parametrize("n", [1, 2, 40])
def test_the_influence_of_cells_is_read_from_the_first_ones(n: int) -> None:
    rng = np.random.default_rng(n)
    kernel = rng.normal(size=(9, 7)).astype(np.float32)
    row, col = rng.integers(0, 9, n), rng.integers(0, 7, n)
    found = _toeplitz(kernel, row, col)
    whole = kernel[np.abs(row[:, None] - row), np.abs(col[:, None] - col)]
    assert np.array_equal(np.tril(found), np.tril(whole))
