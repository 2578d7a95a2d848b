"""Names on oblong taxels: several of them beside each other are one that is nearly square."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.solids import Cone, Cylinder, Pyramid, Sphere, ideal_frame
from varishold.touch import find_contacts, recognize
from varishold.touch.scale import squared

SOLIDS = {
    "cone": Cone(18.0, 6.0), "cylinder": Cylinder(18.0, 6.0), "pyramid": Pyramid(16.0, 6.0), "sphere": Sphere(22.0)
}  # fmt: skip


def seen(name: str, rows: int, cols: int) -> np.ndarray:
    """A form on taxels each of which holds so many rows and columns of 48 x 48."""
    fine = ideal_frame(SOLIDS[name], (48, 48), 1.0)
    return np.asarray(fine.reshape(48 // rows, rows, 48 // cols, cols).mean(axis=(1, 3)))


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize(("rows", "cols"), [(2, 1), (1, 2), (3, 1), (1, 3)])
def test_a_form_on_oblong_taxels_is_named_as_on_square_ones(name: str, rows: int, cols: int) -> None:
    oblong = find_contacts(seen(name, rows, cols), pitch=(rows * 1e-3, cols * 1e-3))[0]
    side = max(rows, cols)
    square = find_contacts(seen(name, side, side), pitch=(side * 1e-3, side * 1e-3))[0]
    said, usual = recognize(oblong), recognize(square)
    assert said.name == usual.name
    assert said.probability == pytest.approx(usual.probability, abs=0.05)
    # What is measured is measured on the taxels as they are.
    assert said.contact is oblong


@pytest.mark.parametrize("pitch", [None, (1e-3, 1e-3), (1.7e-3, 1e-3)])
def test_contacts_on_nearly_square_taxels_stay_as_they_are(pitch: tuple[float, float] | None) -> None:
    contact = find_contacts(seen("cone", 1, 1), pitch=pitch)[0]
    assert squared(contact) is contact


def test_a_pad_with_few_lines_stays_as_it_is() -> None:
    frame = seen("cone", 4, 1)[:, 17:32]
    contact = find_contacts(frame, pitch=(4e-3, 1e-3))[0]
    assert squared(contact) is contact


def test_broken_taxels_and_gaps_stay_known() -> None:
    frame = seen("cone", 2, 1)
    valid, field = np.ones(frame.shape, bool), np.ones(frame.shape, bool)
    valid[10, 20], field[:, :2] = False, False
    contact = squared(find_contacts(frame, pitch=(2e-3, 1e-3), valid=valid, field=field)[0])
    assert contact.shape == (24, 24)
    assert np.argwhere(contact.frame.losses.repaired).tolist() == [[10, 10]]
    assert not contact.frame.field[:, 0].any()
