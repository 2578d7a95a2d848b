"""Frames of on-off taxels: an outline is told, and a form is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from varishold import Pad, Recording, recognize_recording
from varishold.touch import find_contacts, recognize
from varishold.touch.caution import no_surer
from varishold.touch.names import KINDS, NAMES, OUTLINE_OF

Y, X = np.mgrid[-12:12, -12:12] + 0.5
OUTLINES = {
    "round": np.hypot(X, Y) < 7.0,
    "square": (np.abs(X) < 7.0) & (np.abs(Y) < 7.0),
    "oblong": (np.abs(X) < 9.0) & (np.abs(Y) < 4.0),
}


@pytest.mark.parametrize("outline", OUTLINES)
@pytest.mark.parametrize("dtype", [np.bool_, np.uint8, np.float64])
@pytest.mark.parametrize("value", [1, 200])
def test_an_outline_is_told_surely_and_a_pillar_is_not(outline: str, dtype: type, value: int) -> None:
    frame = (value * OUTLINES[outline]).astype(dtype)
    surface = recognize(find_contacts(frame)[0])
    assert surface.form == "pillar"
    assert surface.probability <= 0.55
    assert (surface.outline, surface.outline_probability > 0.9) == (outline, True)
    assert surface.kind_probability.sum() == pytest.approx(1.0)
    alike = {name for name in NAMES if OUTLINE_OF[name] == outline}
    assert len(set(surface.answer_set) & alike) >= 2
    assert any("on-off taxels" in reason for reason in surface.reasons)


@pytest.mark.parametrize("broad", [2, 3, 4])
@pytest.mark.parametrize("dtype", [np.bool_, np.float64])
def test_a_bar_that_leaves_the_pad_may_have_any_form_of_its_outline(broad: int, dtype: type) -> None:
    frame = (np.abs(X + 0.3 * Y) < broad).astype(dtype)
    surface = recognize(find_contacts(frame)[0])
    assert surface.outline == "oblong"
    assert surface.probability <= 0.55 + 1e-9
    assert len(surface.answer_set) >= 2
    assert any("on-off taxels" in reason for reason in surface.reasons)


@pytest.mark.parametrize("most", [0.55, 0.85])
@pytest.mark.parametrize("of_outline", [False, True])
def test_a_name_that_is_less_sure_stays_the_likeliest(most: float, of_outline: bool) -> None:
    surface = recognize(find_contacts(OUTLINES["round"] * 1.0)[0])
    rng = np.random.default_rng(0)
    for _ in range(300):
        kinds = rng.dirichlet(np.full(len(KINDS), 0.3))
        by_name = {name: sum(p for p, kind in zip(kinds, KINDS, strict=True) if kind.name == name) for name in NAMES}
        name = max(by_name, key=by_name.__getitem__)
        alike = np.array([OUTLINE_OF[kind.name] == OUTLINE_OF[name] for kind in KINDS]) if of_outline else None
        asked = replace(surface, name=name, probability=by_name[name], kind_probability=kinds)
        told = no_surer(asked, most, among=alike)
        assert next(iter(told.names)) == told.name == name
        assert told.answer_set[0] == name
        assert told.probability == pytest.approx(told.names[name])
        assert told.kind_probability.sum() == pytest.approx(1.0)
        assert told.probability <= max(by_name[name], most)
        if not of_outline:
            assert told.probability <= most + 1e-5


def test_a_press_of_them_is_no_surer() -> None:
    frames = np.array([OUTLINES["round"] * k for k in (0,) * 10 + (1,) * 12 + (0,) * 10], np.uint8)
    (answer,) = recognize_recording(Recording({"pad": Pad(frames)}), frames="press")
    assert answer.surface.name == "cylinder"
    assert answer.surface.probability < 0.7


@pytest.mark.parametrize("shape", [(1, 16), (2, 32), (24, 3)])
def test_a_narrow_pad_is_sure_of_no_form(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    along = np.arange(max(shape)) - max(shape) / 2 + 0.3
    cone, pillar = np.maximum(1 - np.abs(along) / 6, 0), (np.abs(along) < 5) * 1.0
    for form in (cone, pillar, np.sqrt(np.maximum(1 - along**2 / 40, 0))):
        frame = (form if shape[0] < shape[1] else form[:, None]) + rng.normal(0, 0.01, shape)
        surface = recognize(find_contacts(frame)[0])
        assert surface.probability <= 0.55 + 1e-9
        assert surface.kind_probability.sum() == pytest.approx(1.0)
        assert any("shows no form surely" in reason for reason in surface.reasons)


@pytest.mark.parametrize("tip", [(2, 1), (2, 2), (3, 2), (3, 3)])
def test_a_part_of_a_pad_that_stands_apart_is_sure_of_no_form_where_it_is_narrow(tip: tuple[int, int]) -> None:
    field = np.zeros((16, 16), np.bool_)
    field[6:, 2:12] = True
    field[: tip[0], 4 : 4 + tip[1]] = True
    rng = np.random.default_rng(0)
    frame = rng.normal(0, 0.01, field.shape)
    frame[: tip[0], 4 : 4 + tip[1]] += rng.uniform(0.5, 1.0, tip)
    surface = recognize(find_contacts(frame, field=field)[0])
    assert surface.probability <= 0.55 + 1e-9
    assert any(f"{min(tip)} taxel" in reason and "shows no form surely" in reason for reason in surface.reasons)


def test_a_broad_part_of_a_pad_is_as_sure_beside_a_narrow_one_as_without() -> None:
    whole = np.pad(OUTLINES["round"], ((6, 0), (0, 0)))
    frame = whole + np.random.default_rng(0).normal(0, 0.01, whole.shape)
    field = np.ones(whole.shape, np.bool_)
    field[2:4] = False
    surface = recognize(find_contacts(frame, field=field)[0])
    assert surface.name == "cylinder"
    assert surface.probability > 0.9


def test_a_pillar_under_taxels_that_have_noise_stays_sure() -> None:
    rng = np.random.default_rng(0)
    for frame in (
        OUTLINES["round"] + rng.normal(0, 0.01, X.shape),
        np.rint(50 * OUTLINES["round"] + rng.normal(0, 1, X.shape)),
    ):
        surface = recognize(find_contacts(frame)[0])
        assert surface.name == "cylinder"
        assert surface.probability > 0.9
        assert not any("on-off taxels" in reason for reason in surface.reasons)
