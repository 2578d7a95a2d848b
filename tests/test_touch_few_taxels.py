"""Few taxels cannot exclude a form that has no name: a name that is sure is less so by what unknown has, and stays."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from varishold.levelset.contact import Contact
from varishold.solids import draw_contact, ideal_frame
from varishold.touch import NAMES, Surface, find_contacts, recognize
from varishold.touch.decision import NAME_OF, kind_logits, load_parameters
from varishold.touch.recognizer import contact_signature, table_for
from varishold.touch.scale import as_learned
from varishold.touch.writers import Export, c99_files
from varishold.touch.writers.vectors import SOLIDS, Vector

UNKNOWN = NAMES.index("unknown")
# Of these kinds the frame tells more than the table: planes, bars, and squares that lie across.
OF_THE_FRAME = ("edge", "plane", "rectangular pillar", "square pillar")
needs_compiler = pytest.mark.skipif(shutil.which("gcc") is None or shutil.which("make") is None, reason="needs C")


def drawn(side: int, count: int, breadth: tuple[float, float]) -> list[Contact]:
    """Return contacts of drawn solids on a pad, with noise of 1 %."""
    contacts = []
    for index in range(count):
        rng = np.random.default_rng([side, index])
        kind = SOLIDS[index % len(SOLIDS)]
        solid = draw_contact(rng, kind, field_m=(float(side), float(side)), size_m=breadth)
        clean = ideal_frame(solid.solid, (side, side), 1.0, depth_m=solid.depth_m, pose=solid.pose)
        if not clean.max() > 0:
            continue
        contacts += find_contacts(clean / clean.max() + rng.normal(0, 0.01, clean.shape))[:1]
    return contacts


def by_table(contact: Contact) -> np.ndarray:
    """Return the probability of every name by the learned table alone."""
    parameters = load_parameters(table_for(contact.shape))
    white = (contact_signature(as_learned(contact)) - parameters.shift) * parameters.scale
    logits = kind_logits(np.clip(white, -parameters.clip, parameters.clip), parameters)
    p = np.exp(logits - logits.max())
    return np.bincount(NAME_OF, weights=p / p.sum(), minlength=len(NAMES))


def said(surface: Surface) -> np.ndarray:
    """Return the probability of every name, in the order of `NAMES`."""
    return np.array([surface.names[name] for name in NAMES])


def usual(contact: Contact) -> bool:
    """Tell whether the table alone decides."""
    return not any(contact.borders) and NAMES[int(by_table(contact).argmax())] not in OF_THE_FRAME


SMALL = [contact for side in (6, 8, 12) for contact in drawn(side, 78, (2.5, 0.9 * side)) if usual(contact)]


def test_a_sure_name_gives_up_what_unknown_counts_more_and_no_other_does() -> None:
    changed = 0
    for contact in SMALL:
        before, after = by_table(contact), said(recognize(contact))
        best = int(before.argmax())
        assert after.sum() == pytest.approx(1.0)
        assert int(after.argmax()) == best
        times = min(max((48 / contact.n_taxels) ** 2, 1.0), 8.0)
        if best == UNKNOWN or before[best] <= 0.85 or times == 1.0:
            assert after == pytest.approx(before, abs=1e-9)
            continue
        named = np.arange(len(NAMES)) != UNKNOWN
        keep = max((1 - times * before[UNKNOWN]) / (1 - before[UNKNOWN]), 0.85 / before[best])
        assert after[named] == pytest.approx(keep * before[named], abs=1e-9)
        assert after[UNKNOWN] >= before[UNKNOWN] - 1e-12
        assert after[best] >= 0.85 - 1e-12
        changed += after[best] < before[best] - 1e-3
    assert changed >= 10


def test_many_taxels_are_named_by_the_table_alone() -> None:
    many = [contact for contact in drawn(24, 39, (10.0, 18.0)) if contact.n_taxels >= 48 and usual(contact)]
    assert len(many) >= 15
    for contact in many:
        assert said(recognize(contact)) == pytest.approx(by_table(contact), abs=1e-9)


def test_where_no_stranger_can_occur_few_taxels_are_as_sure_as_many() -> None:
    known = [name for name in NAMES if name != "unknown"]
    for contact in SMALL:
        p = by_table(contact)
        p[UNKNOWN] = 0.0
        assert said(recognize(contact, among=known)) == pytest.approx(p / p.sum(), abs=1e-9)


def towers(count: int) -> list[np.ndarray]:
    """Return frames of a square step on a larger one, which has no name, on 8 x 8 with noise of 1 %."""
    frames = []
    fine = (np.arange(48) + 0.5) / 6 - 4
    for index in range(count):
        rng = np.random.default_rng(index)
        half, turn = rng.uniform(2.2, 3.2), rng.uniform(0, np.pi / 2)
        x, y = fine[None, :] - rng.uniform(-0.4, 0.4), fine[:, None] - rng.uniform(-0.4, 0.4)
        u, v = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        off = np.maximum(abs(u), abs(v)) / half
        height = np.where(off < rng.uniform(0.35, 0.6), 1.0, rng.uniform(0.35, 0.65) * (off < 1))
        clean = height.reshape(8, 6, 8, 6).mean(axis=(1, 3))
        frames.append(clean + rng.normal(0, 0.01, clean.shape))
    return frames


TOWERS = [find_contacts(frame)[0] for frame in towers(60)]


def test_a_form_without_a_name_is_less_often_surely_named() -> None:
    sure, was = 0, 0
    for contact in TOWERS:
        before, surface = by_table(contact), recognize(contact)
        was += NAMES[int(before.argmax())] != "unknown" and before.max() > 0.9
        sure += surface.name != "unknown" and surface.probability > 0.9
    assert was >= 10
    assert sure < 0.75 * was


def test_a_reason_tells_a_form_without_a_name_that_is_not_excluded() -> None:
    told = 0
    for contact in (*SMALL, *TOWERS):
        surface = recognize(contact)
        says = any("cannot exclude a form that has no name" in reason for reason in surface.reasons)
        sure = surface.name != "unknown" and surface.probability >= 0.85
        assert says == (sure and surface.names["unknown"] >= 0.05 and contact.n_taxels < 48)
        told += says
    assert told >= 3


@needs_compiler
def test_the_exported_recognizer_is_as_unsure_on_few_taxels(tmp_path: Path) -> None:
    wanted = Export(shape=(8, 8), weights="float32")
    vectors = []
    for frame in towers(60):
        readings = frame.astype(np.float32)
        found = find_contacts(readings.astype(np.float64), wanted.levels)
        surface = recognize(found[0])
        vectors.append(Vector(readings, len(found), NAMES.index(surface.name), surface.probability))
    assert sum(by_table(contact).max() - recognize(contact).probability > 0.004 for contact in TOWERS) >= 10
    for name, text in c99_files(wanted, vectors).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    test = (tmp_path / "test.c").read_text(encoding="utf-8")
    # A probability that is not Python's is made to count as another name is.
    asked = test.replace(
        "name != vectors[i].name)",
        "name != vectors[i].name || (n > 0 && !(touches[0].answer.probability - vectors[i].probability < 0.002f && "
        "vectors[i].probability - touches[0].answer.probability < 0.002f)))",
    )
    assert asked != test
    (tmp_path / "test.c").write_text(asked, encoding="utf-8")
    done = subprocess.run(
        ["make", "-s", "test", "CFLAGS=-O0"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.stdout.splitlines()[-1] == f"{len(vectors)} of {len(vectors)} names as in Python", (
        done.stdout + done.stderr
    )
