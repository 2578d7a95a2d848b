"""Laws of a rest that is not even: what its unevenness makes is no contact beside another, a weak contact is one."""

from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold import Pad, Recording, recognize_recording
from varishold.levelset import Contact
from varishold.touch import find_contacts, recognize

Frame = NDArray[np.float64]


def ball(shape: tuple[int, int], at: tuple[float, float] = (0.45, 0.55), reach: float = 0.3) -> Frame:
    row, col = np.indices(shape)
    away = np.hypot(row - at[0] * shape[0], col - at[1] * shape[1]) / (reach * min(shape))
    return np.asarray(np.maximum(1.0 - away**2, 0.0))


def is_at_second(contact: Contact) -> bool:
    """Tell whether a contact's peak lies around row and column 24, where tests press a second time."""
    row, col = contact.peak_taxel
    return abs(row - 24) <= 3 and abs(col - 24) <= 3


@given(seed=st.integers(0, 10_000), uneven=st.floats(0.01, 0.03), side=st.sampled_from([16, 24, 32]))
def test_rows_that_rest_unlike_are_no_contacts(seed: int, uneven: float, side: int) -> None:
    rng = np.random.default_rng(seed)
    frame = ball((side, side)) + rng.normal(0.0, uneven, (side, 1)) + rng.normal(0.0, 0.003, (side, side))
    # Two rows beside each other of which both rest high are as broad as a contact is.
    assert len(find_contacts(frame)) <= 2
    assert recognize(find_contacts(frame)[0]).name == "sphere"


def test_rows_and_columns_that_rest_unlike_are_hardly_ever_contacts() -> None:
    rng = np.random.default_rng(0)
    extra = 0
    for _ in range(50):
        frame = ball((32, 32)) + rng.normal(0.0, 0.03, (32, 1)) + rng.normal(0.0, 0.03, (1, 32))
        extra += len(find_contacts(frame + rng.normal(0.0, 0.003, frame.shape))) - 1
    assert extra <= 10


@pytest.mark.parametrize("quality", [95, 85, 75, 50])
def test_what_packing_a_picture_leaves_is_no_contact(quality: int) -> None:
    images = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    rng = np.random.default_rng(quality)
    picture = np.rint(30.0 + 150.0 * ball((240, 320)) + rng.normal(0.0, 1.5, (240, 320))).astype(np.uint8)
    packed = io.BytesIO()
    images.fromarray(picture).save(packed, "JPEG", quality=quality)
    frame = np.array(images.open(packed))
    (answer,) = recognize_recording(Recording({"pad": Pad(frame[None])}))
    assert answer.surface.name == "sphere"


@pytest.mark.parametrize("height", [0.16, 0.3, 0.9])
@pytest.mark.parametrize("uneven", [0.0, 0.01, 0.03])
def test_a_weak_contact_beside_another_is_found_on_an_uneven_rest(height: float, uneven: float) -> None:
    rng = np.random.default_rng(5)
    frame = ball((32, 32), (0.3, 0.3), 0.2) + height * ball((32, 32), (0.75, 0.75), 0.15)
    frame += rng.normal(0.0, uneven, (32, 1)) + rng.normal(0.0, 0.005, (32, 32))
    assert len([contact for contact in find_contacts(frame) if is_at_second(contact)]) == 1


def test_what_lies_below_a_rest_somewhere_hides_no_contact() -> None:
    frame = ball((32, 32), (0.3, 0.3), 0.2) + 0.2 * ball((32, 32), (0.75, 0.75), 0.15)
    frame[:, :8] -= 0.3
    frame += np.random.default_rng(1).normal(0.0, 0.01, frame.shape)
    assert any(is_at_second(contact) for contact in find_contacts(frame))


def test_with_a_floor_of_ones_own_all_that_is_above_it_is_found() -> None:
    rng = np.random.default_rng(2)
    frame = ball((32, 32)) + rng.normal(0.0, 0.03, (32, 1)) + rng.normal(0.0, 0.003, (32, 32))
    assert len(find_contacts(frame, floor=0.03)) > len(find_contacts(frame))
