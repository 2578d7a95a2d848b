"""The kernel against a plain reference: the same contacts, and the same sections to rounding."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hostile.sections import compare, random_frame


@settings(max_examples=60)
@given(st.integers(0, 1 << 32))
def test_contacts_and_sections_are_those_of_the_reference(seed: int) -> None:
    assert compare(random_frame(np.random.default_rng(seed))) == []


@pytest.mark.parametrize("seed", range(4))
def test_a_difference_would_be_seen(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A reference that splits contacts otherwise is told from the kernel."""
    monkeypatch.setattr("tests.reference_sections.SPLIT_RATIO", 0.9)
    rng = np.random.default_rng(seed)
    assert any(compare(random_frame(rng)) for _ in range(200))
