"""What is shown of a frame is whole taxels, whatever their spacing; drawings stand in frames of their own size."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.evaluation_made import made
from tests.reading_svg import area_of, box_of, drawn, of_class, paths_of, picture_of

from varishold import Pad, Recording
from varishold.calibration.result import Curve
from varishold.perceive import GripContacts, fit_section
from varishold.report import SectionStack, draw_contact_card, grip_drawing, render_evaluation_report, stack_sections
from varishold.report.axonometry import _ground, view_of
from varishold.report.belief_chart import belief_chart, size_strip
from varishold.report.chord_plot import chord_plot
from varishold.report.outline_plot import outline_plot
from varishold.report.response_plot import response_plot
from varishold.report.section_stack import MOST_LEVELS
from varishold.report.share_chart import Point, Series, share_chart
from varishold.report.size_bars import size_bars
from varishold.report.taxel_image import thumbnail
from varishold.report.taxel_map import taxel_map
from varishold.sensor import Sensor
from varishold.touch import find_contacts, recognize_recording

# Ratios whose multiples, divided again, are whole numbers only nearly.
PITCHES = [(0.0037, 0.0023), (0.0098, 0.0099), (0.0011, 0.0049), (0.007, 0.003), (0.002, 0.002)]


def a_frame(row: int, col: int, high: int, wide: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    frame = np.zeros((52, 60))
    frame[row : row + high, col : col + wide] = 5.0 + np.arange(wide) + 0.5 * np.arange(high)[:, None]
    return frame


def stacks() -> list[tuple[SectionStack, slice, slice]]:
    """Contacts in many places, with the rows and columns of their window: a taxel more on each side."""
    rng = np.random.default_rng(0)
    made_ones = []
    for k in range(30):
        high, wide = rng.integers(4, 30, 2).tolist()
        row, col = int(rng.integers(0, 52 - high)), int(rng.integers(0, 60 - wide))
        contact = find_contacts(a_frame(row, col, high, wide), 5, pitch=PITCHES[k % len(PITCHES)])[0]
        rows, cols = slice(max(row - 1, 0), min(row + high + 1, 52)), slice(max(col - 1, 0), min(col + wide + 1, 60))
        made_ones.append((stack_sections(contact), rows, cols))
    return made_ones


STACKS = stacks()


def test_the_window_is_the_contact_and_a_taxel_around_it() -> None:
    for stack, rows, cols in STACKS:
        assert stack.taxels == (rows, cols)
        x, y = stack.step
        assert min(stack.step) == 1
        assert stack.window == pytest.approx(
            (cols.start * x, rows.start * y, (cols.stop - cols.start) * x, (rows.stop - rows.start) * y)
        )


def test_every_picture_of_the_window_shows_its_taxels_and_no_others() -> None:
    for stack, rows, cols in STACKS:
        shape = (rows.stop - rows.start, cols.stop - cols.start)
        pixels = picture_of(thumbnail(stack))
        assert pixels.shape[:2] == shape
        root = drawn(outline_plot(stack, unit_m=None, label=""))
        (image,) = root.iter("image")
        assert picture_of(image).shape[:2] == shape
        left, top, right, bottom = box_of(root, image)
        assert (right - left) / (bottom - top) == pytest.approx(
            shape[1] * stack.step[0] / (shape[0] * stack.step[1]), rel=0.01
        )
        grid = of_class(drawn(f"<svg>{_ground(stack, view_of(stack))}</svg>"), "grid")[0].get("d", "")
        every = max(1, round(max(shape) / 10))
        between = [k for span in (rows, cols) for k in range(span.start, span.stop + 1) if k % every == 0]
        assert grid.count("M") == len(between)


@pytest.mark.parametrize("pitch", PITCHES)
@pytest.mark.parametrize("place", [(11, 19), (20, 38), (3, 41)])
def test_the_surface_of_the_scene_begins_where_the_window_begins(
    pitch: tuple[float, float], place: tuple[int, int]
) -> None:
    frame = a_frame(*place, 9, 14)
    (answer,) = recognize_recording(Recording({"pad": Pad(frame[None], pitch_m=pitch)}, unit="Pa"))
    scene = json.loads(draw_contact_card(answer, anchor="c1", place="").scene)
    values = np.frombuffer(base64.b64decode(scene["values"]), np.uint8).reshape(scene["rows"], scene["cols"])
    row, col = place
    assert values.shape == (11, 16)
    inside = frame[row - 1 : row + 10, col - 1 : col + 15] > 0
    assert (values[~inside] == 0).all()
    assert (values[1:-1, 1:-1] > 0).all()
    assert values.max() == 255


@pytest.mark.parametrize("n", [MOST_LEVELS - 1, MOST_LEVELS, MOST_LEVELS + 1, 90])
def test_sections_are_chosen_from_the_first_to_the_last(n: int) -> None:
    contact = find_contacts(a_frame(8, 8, 20, 20), n)[0]
    stack = stack_sections(contact)
    there = np.flatnonzero(contact.profile.area > 0).tolist()
    assert len(stack) == min(len(there), 32)
    if len(there) <= 32:
        assert stack.level.tolist() == there
    else:
        assert (stack.level[0], stack.level[-1]) == (there[0], there[-1])


@pytest.mark.parametrize("pitch", [None, *PITCHES])
def test_a_section_that_covers_the_pad_is_the_pad(pitch: tuple[float, float] | None) -> None:
    frame = 5.0 + np.arange(60.0).reshape(6, 10) / 20
    stack = stack_sections(find_contacts(frame, 6, pitch=pitch)[0])
    wide, high = stack.size
    x, y = stack.step
    assert (wide, high) == pytest.approx((10 * x, 6 * y))
    (lowest,) = stack.outlines[-1]
    assert area_of(lowest) == pytest.approx(wide * high)
    assert len(lowest) == 4


# ---- the sizes of drawings


def a_grip() -> GripContacts:
    angle = np.linspace(-2.6, 2.6, 7)
    centre = np.array([0.045, 0.0]) + 0.038 * np.column_stack([np.cos(angle), np.sin(angle)])
    start = np.column_stack([centre, np.linspace(-0.02, 0.02, 7)])
    end = start + np.array([1e-3, 0, 0])
    return GripContacts(tuple("abcdefg"), start, end, np.full(7, 0.008), np.ones(7, bool), np.full(7, 0.001))


def a_chord() -> str:
    stack = STACKS[0][0]
    growth = np.sqrt(np.arange(1.0, len(stack) + 1))
    return str(
        chord_plot(
            stack, growth, np.ones(len(stack), bool), label="", tick=lambda v: f"{v:g}", theta=lambda v: f"{v:g}"
        )
    )


def charts() -> dict[str, str]:
    beliefs = [{"a": 0.6, "b": 0.4}]
    curve = Curve(np.array([0.5]), np.array([0.5]))
    return {
        "screen": str(taxel_map(np.ones((2, 3)), 0, 1, label="")),
        "grip": str(grip_drawing.grip_drawing(a_grip(), "cylinder")),
        "chord": a_chord(),
        "response": str(response_plot(Sensor().response, curve, 0.0, None)),
        "shares": str(share_chart([Series("ours", [Point(0.5, 0.5)])], x_ticks=[], x_name="", label="")),
        "belief": str(belief_chart(beliefs, ["grasp"])),
        "narrow": str(belief_chart(beliefs, ["grasp"], narrow=True)),
        "strip": str(size_strip(0.06, (0.05, 0.07), 0.06)),
        "bars": str(size_bars(np.ones(120, np.int64), label="")),
    }


def test_all_that_stands_on_a_card_is_as_wide_as_its_screen_and_a_chart_leaves_room_for_its_words() -> None:
    sizes = {name: drawn(svg).get("viewBox") for name, svg in charts().items()}
    assert sizes == {
        "screen": "0 0 360 300",
        "grip": "0 0 360 300",
        "chord": "0 0 360 230",
        "response": "0 0 360 260",
        "shares": "0 0 360 270",
        "belief": "0 0 940 230",
        "narrow": "0 0 400 240",
        "strip": "0 0 360 44",
        "bars": "0 0 120 26",
    }
    # Left, top, right and bottom of the axes.
    wanted = {
        "chord": (40, 8, 352, 192),
        "response": (40, 8, 350, 222),
        "shares": (46, 12, 346, 228),
        "belief": (44, 14, 730, 196),
        "narrow": (44, 14, 272, 206),
    }
    for name, axes in wanted.items():
        root = drawn(charts()[name])
        rules = [box_of(root, each) for each in (*of_class(root, "rule"), *of_class(root, "base"))]
        level = [box for box in rules if box[1] == box[3] and box[2] - box[0] > 100]
        found = (level[0][0], min(box[1] for box in level), level[0][2], max(box[1] for box in level))
        assert found == pytest.approx(axes, abs=0.06), name


def test_a_growth_is_drawn_at_several_heights_from_a_twentieth_on(monkeypatch: pytest.MonkeyPatch) -> None:
    contacts = a_grip()
    fit = fit_section(contacts, "circle")
    assert fit is not None
    for growth, outlines in ((0.0, 1), (0.0499, 1), (-0.0499, 1), (0.05, 3), (-0.05, 3), (0.3, 3)):
        monkeypatch.setattr(grip_drawing, "fit_section", lambda *_, growth=growth, **__: replace(fit, growth=growth))
        root = drawn(str(grip_drawing.grip_drawing(contacts, "cone")))
        assert len(of_class(root, "section")) == outlines
    # What would have no size any more at its top is drawn as a dot: four millimetres.
    monkeypatch.setattr(grip_drawing, "fit_section", lambda *_, **__: replace(fit, size_m=0.05, growth=-90.0))
    root = drawn(str(grip_drawing.grip_drawing(contacts, "cone")))
    boxes = [box_of(root, each) for each in of_class(root, "section")]
    bar = box_of(root, of_class(root, "bar")[0])
    widths = [(box[2] - box[0]) / (bar[2] - bar[0]) * 20 for box in boxes]
    assert min(widths) == pytest.approx(4, abs=0.3)


def test_what_a_belief_does_not_name_it_holds_for_nothing() -> None:
    beliefs = [{"a": 0.6, "b": 0.4}, {"b": 0.04, "c": 0.96}]
    root = drawn(str(belief_chart(beliefs, ["grasp", "regrasp"])))
    words = [t.text for t in root.iter("text") if "end" in t.get("class", "").split()]
    assert words == ["c 96\u202f%", "b 4\u202f%"]
    (c,) = [each for each in of_class(root, "line") if "k0" in each.get("class", "").split()]
    base = box_of(root, of_class(root, "base")[0])[1]
    ((_, before), (_, first), (_, last)) = paths_of(c.get("d"))[0]
    assert first == pytest.approx(base, abs=0.06)
    assert last < before < base
    # Whose chance was never one in twenty has no name there.
    few = drawn(str(belief_chart([{"a": 0.951, "b": 0.049}, {"a": 0.95, "b": 0.05}], ["x", "y"])))
    assert len(of_class(few, "end")) == 2
    none = drawn(str(belief_chart([{"a": 0.951, "b": 0.049}], ["x"])))
    assert len(of_class(none, "end")) == 1
    assert len(of_class(none, "rest")) == 1


def test_the_bar_under_a_pad_stands_midway_between_it_and_its_words() -> None:
    from varishold.report.pad_hand import tip_pad
    from varishold.touch import SURFACES

    posterior = np.full(len(SURFACES), 1 / len(SURFACES))
    surface = SimpleNamespace(name=SURFACES[0], probability=0.25, radius_m=None, posterior=lambda: posterior)
    root = drawn(str(tip_pad(np.ones((6, 6)), 0.002, surface)))  # type: ignore[arg-type]
    (image,) = root.iter("image")
    bars = [box_of(root, each) for each in root.iter("rect") if each.get("fill")]
    bottom = box_of(root, image)[3]
    text = next(root.iter("text"))
    above, below = bars[0][1] - bottom, float(text.get("y", 0)) - 9 - bars[0][3]
    assert above == pytest.approx(4)
    assert below == pytest.approx(5, abs=1)


def test_a_page_of_an_evaluation_draws_all_its_charts_alike() -> None:
    page = render_evaluation_report(made(3), title="t")
    assert page.count('class="growth shares" viewBox="0 0 360 270"') == 3
