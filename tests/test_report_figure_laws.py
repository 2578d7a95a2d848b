"""The figures that matplotlib draws: what stands in them is what was measured, at its place, in its unit, legibly."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="matplotlib is not installed; pip install -e '.[plots]'")

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text

from benchmarks import _bits_figure as bits_figure
from benchmarks import _reliability_figure as reliability
from docs.images import contents_figure, ring_figure
from varishold.errors import InputError
from varishold.report import figure_file, finger_length, press_figure
from varishold.report.colours import shade
from varishold.skin import Skin

MODULES = (bits_figure, contents_figure, finger_length, press_figure, reliability, ring_figure)


@pytest.fixture
def drawn(monkeypatch, tmp_path):
    """Return a function that draws and returns the figure that was about to be written, laid out."""

    def draw(write, *arguments, **named) -> Figure:
        kept = []
        for module in MODULES:
            monkeypatch.setattr(module, "save_figure", lambda figure, path, **how: kept.append((figure, how)))
        write(*arguments, **named)
        ((figure, how),) = kept
        figure.set_dpi(how.get("dpi", 110))
        FigureCanvasAgg(figure).draw()
        return figure

    return draw


def texts_of(figure):
    """Every text that is seen; of the ticks' labels those within the axes."""
    unseen = set()
    for axes in figure.axes:
        for axis, view in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if not (axes.axison and min(view) <= tick.get_loc() <= max(view)):
                    unseen |= {tick.label1, tick.label2}
    return [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip() and t not in unseen]


def legible(figure):
    """Every text stands within the figure, in print of a sensible size, and over no other."""
    box = figure.bbox
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts_of(figure)]
    assert all(6.5 <= text.get_fontsize() <= 13 for text in texts_of(figure))
    for words, here in boxes:
        assert min(here.x0 - box.x0, box.x1 - here.x1, here.y0 - box.y0, box.y1 - here.y1) > -1, words
    for k, (one, a) in enumerate(boxes):
        for other, b in boxes[k + 1 :]:
            over = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
            assert min(over) <= 2, (one, other)


def a_press(modulus=None, rows=12, cols=16):
    """A press of a blunt wedge, off the middle: every row and every column has a load of its own."""
    y, x = np.mgrid[:rows, :cols]
    height = np.maximum(3.0 - 0.5 * np.abs(x - 7) - 0.8 * np.abs(y - 7), -1.0)
    contact = height > 0
    gap = np.where(contact, 0.0, np.where(height > -1, 1e-4 * (1 - height), np.inf))
    return SimpleNamespace(
        skin=Skin("layer", 6e-3, 0.45, 1e-3, modulus),
        x_m=(np.arange(cols) + 0.5 - cols / 2) * 1e-3,
        y_m=(np.arange(rows) + 0.5 - rows / 2) * 2e-3,
        pressure=np.where(contact, 0.1 + height, 0.0),
        displacement_m=1e-4 * (1.5 + height),
        gap_m=gap,
        contact=contact,
        depth_m=5e-4,
        shape=(6, 8),
        pitch_m=(4e-3, 2e-3),
    )


def a_relief(rows=6, cols=8):
    y, x = np.mgrid[:rows, :cols]
    displacement = 1e-4 * np.maximum(3.0 - np.abs(x - 3) - np.abs(y - 4), 0.5)
    core = displacement > 1e-4
    return SimpleNamespace(
        displacement=displacement,
        core=core,
        height=np.where(core, displacement - 0.9e-4, 0.0),
        line=0.9e-4,
        pitch_m=(4e-3, 2e-3),
    )


def draw_press(drawn, relief=None, press=None, **named):
    press = press or a_press()
    frame = np.arange(48.0).reshape(6, 8) - 3.0
    return drawn(press_figure.write_press_figure, "press.png", press, frame, relief=relief, **named), frame


def test_a_press_shows_pressure_taxels_and_displacement_over_the_pad(drawn):
    press = a_press()
    figure, frame = draw_press(drawn, press=press)
    panels = [axes for axes in figure.axes if axes.images and axes.get_title()]
    assert [axes.get_title() for axes in panels] == ["surface pressure", "taxels", "surface pressed down"]
    values = (press.pressure, np.maximum(frame, 0), 1e3 * press.displacement_m)
    for axes, shown in zip(panels, values, strict=True):
        (image,) = axes.images
        np.testing.assert_array_equal(image.get_array(), shown)
        # Eight columns of 2 mm, six rows of 4 mm, the first row at the top.
        assert image.get_extent() == pytest.approx([-8, 8, 12, -12])
        low, high = image.get_clim()
        assert low == 0
        assert high == pytest.approx(np.quantile(shown[shown > 0], 0.995))
        assert image.get_interpolation() == "nearest"
    assert [axes.images[0].get_cmap().name for axes in panels] == ["magma", "magma", "viridis"]
    assert figure.get_suptitle() == ""


@pytest.mark.parametrize(("modulus", "unit"), [(None, "contact modulus"), (1e5, "Pa")])
def test_a_press_says_its_units_and_its_title(drawn, modulus, unit):
    figure, _ = draw_press(drawn, press=a_press(modulus), title="a wedge", relief=a_relief())
    # Each map is followed by its scale; a scale has no title.
    assert [axes.get_ylabel() for axes in figure.axes if not axes.get_title()] == [unit, unit, "mm"]
    assert figure.get_suptitle() == "a wedge"
    legible(figure)
    wide, high = figure.get_size_inches()
    assert wide > 2.5 * high


def test_print_of_one_kind_is_of_one_size_and_lines_are_told_apart_by_their_width(drawn):
    figure, _ = draw_press(drawn, title="a wedge", relief=a_relief())
    (cut,) = [axes for axes in figure.axes if axes.get_legend()]
    ticks, names, titles = (
        {text.get_fontsize() for text in texts_of(figure) if text in kind}
        for kind in (
            [label for axes in figure.axes for label in (*axes.get_xticklabels(), *axes.get_yticklabels())]
            + cut.get_legend().get_texts(),
            [label for axes in figure.axes for label in (axes.xaxis.label, axes.yaxis.label)],
            [axes.title for axes in figure.axes],
        )
    )
    headline = {text.get_fontsize() for text in texts_of(figure) if text.get_text() == "a wedge"}
    # The smaller, the less there is to it: numbers and keys, names of axes, titles, the headline.
    assert [len(sizes) for sizes in (ticks, names, titles, headline)] == [1, 1, 1, 1]
    (one,), (two,), (three,), (four,) = ticks, names, titles, headline
    assert (two - one, three - two, four - three) == (1, 1, 2)
    frame = {
        spine.get_linewidth()
        for axes in figure.axes
        if axes.images and axes.get_title()
        for spine in axes.spines.values()
    }
    outline = {float(c.get_linewidth()[0]) for axes in figure.axes if axes.get_title() for c in axes.collections}
    body, skin, seen = (line.get_linewidth() for line in cut.lines)
    widths = [*frame, *outline, seen, skin, body]
    assert len(widths) == 5
    # From the thinnest on, none more than about twice the last.
    assert all(1 < b / a < 2.1 for a, b in pairwise(widths))
    assert body >= 2 * skin
    assert 0.5 < widths[0] < 1
    wide, high = figure.get_size_inches()
    assert 10 < wide < 13
    assert 3 < high < 4


def test_a_cut_is_a_little_wider_than_the_maps_and_their_scales_are_lower_than_they(drawn):
    figure, _ = draw_press(drawn)
    maps = [axes for axes in figure.axes if axes.images and axes.get_title()]
    (cut,) = [axes for axes in figure.axes if axes.get_legend()]
    *even, wider = cut.get_subplotspec().get_gridspec().get_width_ratios()
    assert len(set(even)) == 1
    assert 1.1 < wider / even[0] < 1.5
    for axes in maps:
        assert not len(axes.get_xticks())
        assert not len(axes.get_yticks())
    scales = [axes for axes in figure.axes if axes is not cut and axes not in maps]
    assert len(scales) == 3
    for scale in scales:
        assert scale.get_position().height < 0.85


def test_the_contact_is_outlined_where_it_is_on_the_displacement_alone(drawn):
    press = a_press()
    figure, _ = draw_press(drawn, press=press)
    panels = [axes for axes in figure.axes if axes.images and axes.get_title()]
    lines = [
        np.concatenate([path.vertices for c in axes.collections for path in c.get_paths()] or [np.zeros((0, 2))])
        for axes in panels
    ]
    assert [len(points) > 0 for points in lines] == [False, False, True]
    row, col = np.nonzero(press.contact)
    # Half way between a cell inside and one outside; cells are 1 mm by 2 mm.
    (left, top), (right, bottom) = lines[2].min(axis=0), lines[2].max(axis=0)
    assert (left, right) == pytest.approx((1e3 * press.x_m[col.min()] - 0.5, 1e3 * press.x_m[col.max()] + 0.5))
    assert (top, bottom) == pytest.approx((1e3 * press.y_m[row.min()] - 1, 1e3 * press.y_m[row.max()] + 1))


def test_the_cut_goes_through_the_row_that_halves_the_load(drawn):
    press, relief = a_press(), a_relief()
    figure, _ = draw_press(drawn, press=press, relief=relief)
    (cut,) = [axes for axes in figure.axes if axes.get_legend()]
    assert [t.get_text() for t in cut.get_legend().get_texts()] == ["object", "skin", "seen through the skin"]
    assert (cut.get_xlabel(), cut.get_ylabel()) == ("x (mm)", "height (mm)")
    body, skin, seen = cut.lines
    load = press.pressure.sum(axis=1)
    row = next(k for k in range(len(load)) if load[: k + 1].sum() >= load[k + 1 :].sum())
    assert row == 7
    np.testing.assert_allclose(skin.get_xdata(), 1e3 * press.x_m)
    np.testing.assert_allclose(skin.get_ydata(), -1e3 * press.displacement_m[row])
    # In contact the body lies on the skin; outside it is higher than the skin by the gap, and ends where it ends.
    inside = press.contact[row]
    np.testing.assert_allclose(body.get_ydata()[inside], skin.get_ydata()[inside])
    known = np.isfinite(press.gap_m[row])
    np.testing.assert_allclose(
        (body.get_ydata() - skin.get_ydata())[known & (body.get_ydata() == body.get_ydata())],
        1e3 * press.gap_m[row][known & (body.get_ydata() == body.get_ydata())],
    )
    assert np.isnan(body.get_ydata()[~known]).all()
    # Eight cells of 2 mm about the middle; row 7 of 12 is row 3 of 6.
    np.testing.assert_allclose(seen.get_xdata(), [-7, -5, -3, -1, 1, 3, 5, 7])
    np.testing.assert_allclose(seen.get_ydata(), -1e3 * relief.displacement[3])
    figure, _ = draw_press(drawn, press=press)
    (cut,) = [axes for axes in figure.axes if axes.get_legend()]
    assert len(cut.lines) == 2


def test_what_rises_above_the_rest_by_more_than_the_depth_is_not_drawn(drawn):
    press = a_press()
    far = np.where(press.contact, 0.0, 1e-3)
    figure, _ = draw_press(drawn, press=SimpleNamespace(**{**vars(press), "gap_m": far}))
    (cut,) = [axes for axes in figure.axes if axes.get_legend()]
    body = cut.lines[0].get_ydata()
    np.testing.assert_array_equal(np.isnan(body), 1e3 * (press.displacement_m[7] - far[7]) < -1e3 * press.depth_m)


@pytest.mark.parametrize("row", range(12))
def test_the_cut_shows_the_taxels_that_lie_over_its_row(drawn, row):
    press, relief = a_press(), a_relief()
    pressure = np.full_like(press.pressure, 1e-3)
    pressure[row] = 9.0
    figure, _ = draw_press(drawn, press=SimpleNamespace(**{**vars(press), "pressure": pressure}), relief=relief)
    (cut,) = [axes for axes in figure.axes if axes.get_legend()]
    _, skin, seen = cut.lines
    np.testing.assert_allclose(skin.get_ydata(), -1e3 * press.displacement_m[row])
    # Twelve rows of cells, six of taxels.
    np.testing.assert_allclose(seen.get_ydata(), -1e3 * relief.displacement[row // 2])


def test_what_rises_by_the_depth_itself_is_drawn(drawn):
    press = a_press()
    gap = press.displacement_m + press.depth_m
    gap[7, 0] = np.nextafter(gap[7, 0], 1)
    figure, _ = draw_press(drawn, press=SimpleNamespace(**{**vars(press), "gap_m": gap}))
    (cut,) = [axes for axes in figure.axes if axes.get_legend()]
    body = cut.lines[0].get_ydata()
    deep = press.displacement_m[7] - gap[7] < -press.depth_m
    assert (press.displacement_m[7] - gap[7] == -press.depth_m).any()
    np.testing.assert_array_equal(np.isnan(body), deep)


def test_nothing_pressed_has_a_scale_all_the_same(drawn):
    press = a_press()
    nothing = {name: np.zeros_like(press.pressure) for name in ("pressure", "displacement_m")}
    figure, _ = draw_press(drawn, press=SimpleNamespace(**{**vars(press), **nothing}))
    panels = [axes for axes in figure.axes if axes.images and axes.get_title()]
    assert panels[0].images[0].get_clim() == panels[2].images[0].get_clim() == (0, 1)


def contents(drawn, count, note=""):
    entries = [
        contents_figure.ContentsEntry(f"form {k}", a_press(), np.arange(48.0).reshape(6, 8) - 3, a_relief())
        for k in range(count)
    ]
    return drawn(contents_figure.write_contents_figure, "contents.png", entries, note=note)


def test_the_table_of_contents_has_a_column_a_form_seven_in_a_block(drawn):
    figure = contents(drawn, 9, note="1 % noise")
    shown = [axes for axes in figure.axes if axes.images]
    assert len(shown) == 4 * 9
    titles = [axes for axes in figure.axes if axes.get_title()]
    assert [axes.get_title() for axes in titles] == [f"form {k}" for k in range(9)]
    tops = [axes.get_window_extent() for axes in titles]
    assert all(a.x1 <= b.x0 for a, b in pairwise(tops[:7]))
    assert all(a.x1 <= b.x0 for a, b in pairwise(tops[7:]))
    # The second block lies under the whole first one, its columns under the first's.
    bottoms = [axes.get_window_extent().y0 for axes in shown[:28]]
    assert all(top.y1 < min(bottoms) for top in tops[7:])
    assert [top.x0 for top in tops[7:]] == pytest.approx([top.x0 for top in tops[:2]], abs=10)
    words = [text.get_text() for text in texts_of(figure)]
    rows = ["pressure on the skin", "what the taxels say", "seen through the skin", "the object"]
    assert [word for word in words if word in rows] == 2 * rows
    assert words.count("1 % noise") == 1
    legible(figure)
    wide, high = figure.get_size_inches()
    assert 0.6 * wide < high < 1.5 * wide
    # A row's label stands to the left of its pictures, at their height.
    for text in texts_of(figure):
        if text.get_text() in rows:
            here, beside = text.get_window_extent(), text.axes.get_window_extent()
            assert here.x1 <= beside.x0
            assert (here.y0 + here.y1) / 2 == pytest.approx((beside.y0 + beside.y1) / 2, abs=2)


def test_a_table_without_a_note_says_none(drawn):
    figure = contents(drawn, 7)
    assert len([axes for axes in figure.axes if axes.get_title()]) == 7
    assert len(texts_of(figure)) == 7 + 4


def test_the_table_shows_pressure_and_taxels_on_the_colour_scale(drawn):
    figure = contents(drawn, 1)
    pressure, taxels, seen, true = (axes.images[0].get_array() for axes in figure.axes if axes.images)
    press = a_press()
    inside = press.pressure[press.contact]
    top = np.quantile(inside, 0.97)
    np.testing.assert_allclose(pressure, shade(0.03 + 0.97 * np.minimum(press.pressure / top, 1)) / 255)
    frame = np.arange(48.0).reshape(6, 8) - 3
    np.testing.assert_allclose(taxels, shade(0.03 + 0.97 * np.maximum(frame, 0) / 44) / 255)
    assert seen.shape == (6, 8, 3)
    assert true.shape == (12, 16, 3)


def test_a_relief_is_lit_from_the_upper_left_and_grey_where_there_is_none(drawn):
    figure = contents(drawn, 1)
    *_, seen, true = (axes.images[0].get_array() for axes in figure.axes if axes.images)
    for picture, mask in ((seen, a_relief().core), (true, a_press().contact)):
        assert picture.min() >= 0
        assert picture.max() <= 1
        colourless = np.ptp(picture, axis=-1) < 1e-12
        np.testing.assert_array_equal(colourless, ~mask)
    # A cone: the flank to the upper left is the lightest, that to the lower right the darkest, at equal height.
    y, x = np.mgrid[-8:9, -8:9].astype(float)
    height = np.maximum(8.5 - np.hypot(x, y), 0.0)
    for scale, pitch in ((1.0, (1.0, 1.0)), (3.0, (1.0, 1.0)), (1.0, (1e-3, 1e-3))):
        lit = contents_figure._shaded(scale * height, height > 0, pitch, scale * 8.5)
        light = lit.sum(axis=-1)
        upper_left, lower_right, upper_right, lower_left = light[4, 4], light[12, 12], light[4, 12], light[12, 4]
        assert upper_left > upper_right > lower_right
        assert upper_left > lower_left > lower_right
        # The light comes a little more from above than from the left.
        assert upper_right > lower_left
    a = contents_figure._shaded(height, height > 0, (1.0, 1.0), 8.5)
    # Neither the unit of height nor that of length changes a relief.
    np.testing.assert_allclose(contents_figure._shaded(7 * height, height > 0, (1.0, 1.0), 59.5), a)
    np.testing.assert_allclose(contents_figure._shaded(height, height > 0, (2e-3, 2e-3), 8.5), a)
    # A picture twice as wide has cells twice as wide.
    wide = contents_figure._shaded(np.repeat(height, 2, axis=1), np.repeat(height > 0, 2, axis=1), (1.0, 0.5), 8.5)
    far = np.abs(wide[:, 0::2].sum(axis=-1) - a.sum(axis=-1))
    assert np.median(far[height > 0]) < 0.05


def test_flat_ground_and_flat_tops_are_one_colour_each():
    height = np.zeros((9, 9))
    flat = contents_figure._shaded(height + 1.0, np.ones((9, 9), bool), (1.0, 1.0), 1.0)
    assert np.ptp(flat.reshape(-1, 3), axis=0).max() == 0
    # Straight light on a level face leaves the scale's lightest nearly as it is.
    np.testing.assert_allclose(
        flat[0, 0], np.minimum(shade(0.95) / 255 * (0.45 + 0.75 * 0.58 / np.linalg.norm([0.55, 0.6, 0.58])), 1)
    )
    ground = contents_figure._shaded(height, np.zeros((9, 9), bool), (1.0, 1.0), 1.0)
    assert 0.7 < ground[0, 0, 0] < 0.93
    higher = contents_figure._shaded(np.array([[1.0, 1.0], [3.0, 3.0]]), np.ones((2, 2), bool), (1.0, 1.0), 3.0)
    assert higher[1].sum() > higher[0].sum()


def test_the_object_is_drawn_above_its_contact_line():
    press, relief = a_press(), a_relief()
    entry = contents_figure.ContentsEntry("form", press, np.ones((6, 8)), relief)
    # The relief found its line at .9 of 3, so the press has it at 30 % of its deepest place.
    assert contents_figure._true_line(entry) == pytest.approx(0.3 * press.displacement_m.max())
    nothing = SimpleNamespace(**{**vars(relief), "displacement": np.zeros((6, 8))})
    assert contents_figure._true_line(contents_figure.ContentsEntry("form", press, np.ones((6, 8)), nothing)) == 0
    true = contents_figure._panels(entry)[3]
    line = contents_figure._true_line(entry)
    height = np.where(press.contact, np.maximum(press.displacement_m - line, 0), 0)
    cells = (2e-3, 1e-3)
    np.testing.assert_allclose(true, contents_figure._shaded(height, press.contact, cells, height.max()))


def test_a_ring_is_outlined_at_its_share_and_cut_through_the_middle(drawn):
    y, x = np.mgrid[:20, :20] - 9.5
    stress = np.maximum(4 - np.abs(np.hypot(x, y) - 5), 0) * np.where(x > 0, 1.0, 0.5)
    maps = [("surface", stress), ("1 mm deep", stress[:, ::-1] * 7)]
    figure = drawn(ring_figure.write_ring_figure, "ring.png", maps, side_m=24e-3, share=0.7)
    above, below = figure.axes[:2], figure.axes[2:]
    assert [axes.get_title() for axes in above] == ["surface", "1 mm deep"]
    assert [axes.get_xlabel() for axes in below] == ["x (mm)", "x (mm)"]
    assert [axes.get_ylabel() for axes in below] == ["share of the peak", ""]
    for (_, values), panel, cut in zip(maps, above, below, strict=True):
        (image,) = panel.images
        assert image.get_extent() == pytest.approx([-12, 12, 12, -12])
        np.testing.assert_array_equal(image.get_array(), shade(0.03 + 0.97 * values / values.max()))
        points = np.concatenate([path.vertices for c in panel.collections for path in c.get_paths()])
        row, col = np.nonzero(values > 0.7 * values.max())
        at = (np.arange(20) + 0.5) * 1.2 - 12
        assert points[:, 0].min() == pytest.approx(at[col.min()] - 0.6)
        assert points[:, 0].max() == pytest.approx(at[col.max()] + 0.6)
        assert points[:, 1].min() == pytest.approx(at[row.min()] - 0.6)
        line, share = cut.lines
        np.testing.assert_allclose(line.get_xdata(), at)
        np.testing.assert_allclose(line.get_ydata(), values[10] / values.max())
        assert set(share.get_ydata()) == {0.7}
        low, high = cut.get_ylim()
        assert low == 0
        assert 1 < high < 1.2
        # What is outlined above is what stands over the line below, in one colour.
        assert to_hex(panel.collections[0].get_edgecolor()[0]) == to_hex(share.get_color())
    legible(figure)
    assert above[0].get_position().height > below[0].get_position().height
    wide, high = figure.get_size_inches()
    assert 0.5 * len(maps) * high < wide < 1.2 * len(maps) * high
    standard = drawn(ring_figure.write_ring_figure, "ring.png", maps, side_m=24e-3)
    assert set(standard.axes[2].lines[1].get_ydata()) == {0.8}


def test_bits_are_drawn_as_curves_and_a_single_one_as_a_mark(drawn):
    curves = [
        bits_figure.BitsCurve("sections", [100, 200, 400], [0.5, 0.8, 0.9]),
        bits_figure.BitsCurve("all", [3072], [0.95]),
    ]
    figure = drawn(bits_figure.write_bits_figure, "bits.png", curves, title="bits")
    (axes,) = figure.axes
    for curve, line in zip(curves, axes.lines, strict=True):
        assert list(line.get_xdata()) == curve.bits
        assert list(line.get_ydata()) == curve.right
        assert (line.get_linestyle() == "None") == (len(curve.bits) == 1)
        assert line.get_marker() != "None"
    assert len({line.get_color() for line in axes.lines}) == 2
    assert [t.get_text() for t in axes.get_legend().get_texts()] == ["sections", "all"]
    assert axes.get_xscale() == "log"
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) == (
        "bits a recognition",
        "share of right names",
        "bits",
    )
    assert not axes.get_legend().get_frame_on()
    legible(figure)
    assert drawn(bits_figure.write_bits_figure, "bits.png", curves).axes[0].get_title() == ""


def test_finger_lengths_are_drawn_with_a_line_a_group_and_what_was_held(drawn):
    rows = [
        {"finger_scale": s, "mean_percent": {"touch": 50 + 10 * s, "force": 60 + 20 * s}, "held_percent": 100 * s / 2}
        for s in (0.5, 1.0, 2.0)
    ]
    figure = drawn(finger_length.draw_finger_lengths, rows, "fingers.svg")
    (axes,) = figure.axes
    told = {line.get_label(): (list(line.get_xdata()), list(line.get_ydata())) for line in axes.lines}
    scales = [0.5, 1.0, 2.0]
    assert told == {"touch": (scales, [55, 60, 70]), "force": (scales, [70, 80, 100]), "held": (scales, [25, 50, 100])}
    assert [t.get_text() for t in axes.get_legend().get_texts()] == ["touch", "force", "held"]
    assert len({line.get_linestyle() for line in axes.lines}) == 2
    low, high = axes.get_ylim()
    assert low == 0
    assert 100 < high < 110
    legible(figure)
    wide, high = figure.get_size_inches()
    assert high < wide < 3 * high
    # The grid is faint.
    assert {0.15 < line.get_alpha() < 0.4 for line in (*axes.get_xgridlines(), *axes.get_ygridlines())} == {True}
    assert 5 < wide < 6
    with pytest.raises(InputError, match=r"must end in \.png, \.svg, \.pdf"):
        finger_length.draw_finger_lengths(rows, "fingers.txt")


def test_reliability_shows_shares_with_intervals_and_numbers(drawn):
    rows = [
        (0.3, 0.25, 0.1, 0.5, 12),
        (0.7, 0.75, 0.6, 0.8, 40),
        (0.994, 0.98, 0.9, 1.0, 70),
        (0.999, 1.0, 0.97, 1.0, 500),
    ]
    figure = drawn(reliability.draw_reliability, rows, "reliability.png")
    (axes,) = figure.axes
    diagonal, points = axes.lines[0], axes.lines[1]
    assert list(diagonal.get_xdata()) == list(diagonal.get_ydata()) == [0, 1]
    assert list(points.get_xdata()) == [row[0] for row in rows]
    assert list(points.get_ydata()) == [row[1] for row in rows]
    ends = [segment[:, 1] for c in axes.collections for segment in c.get_segments()]
    np.testing.assert_allclose(np.array(ends), [row[2:4] for row in rows])
    numbers = [t for t in axes.texts if isinstance(t, Annotation)]
    assert [t.get_text() for t in numbers] == ["12", "40", "70", "500"]
    assert [tuple(t.xy) for t in numbers] == [row[:2] for row in rows]
    assert axes.get_xlim()[0] < 0.3
    assert axes.get_xlim()[1] > 1
    assert axes.get_ylim()[0] == 0
    assert axes.get_ylim()[1] > 1
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("stated probability", "share right")
    legible(figure)
    # Each number stands near its own point, or where a line from it ends; none leaves the frame.
    leaders = {(line.get_xdata()[0], line.get_ydata()[0]): line for line in axes.lines[2:]}
    for text, row in zip(numbers, rows, strict=True):
        here = text.get_window_extent()
        line = leaders.get(row[:2])
        assert (line is None) == (row[0] < 0.9)
        x, y = axes.transData.transform(row[:2] if line is None else (line.get_xdata()[1], line.get_ydata()[1]))
        assert max(abs((here.x0 + here.x1) / 2 - x), abs((here.y0 + here.y1) / 2 - y)) < 50
        assert axes.get_window_extent().x1 >= here.x1
    wide, high = figure.get_size_inches()
    assert 0.8 < wide / high < 1.25


@pytest.mark.parametrize("name", ["a.png", "A.SVG", "b.pdf"])
def test_a_figure_is_of_the_kind_that_its_name_says_and_always_the_same_bytes(tmp_path, name):
    starts = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}
    kind = figure_file.figure_kind(tmp_path / name)
    assert kind == name[-3:].lower()
    files = []
    for _ in range(2):
        figure = figure_file.new_figure(2.0, 1.0, beside=tmp_path / name)
        figure.add_subplot().plot([0, 1], [0, 1])
        figure_file.save_figure(figure, tmp_path / name)
        files.append((tmp_path / name).read_bytes())
    assert files[0].startswith(starts[kind])
    if kind != "svg":  # names in it are drawn at random
        assert files[0] == files[1]
    assert b"Date" not in files[0]


def test_the_kind_of_a_figure_may_be_told_apart_from_its_name(tmp_path):
    figure = figure_file.new_figure(2.0, 1.0, beside=tmp_path / "picture")
    assert tuple(figure.get_size_inches()) == (2.0, 1.0)
    figure_file.save_figure(figure, tmp_path / "picture", kind="png", dpi=50)
    data = (tmp_path / "picture").read_bytes()
    # Width and height stand in a PNG's first chunk.
    assert (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")) == (100, 50)
    with pytest.raises(InputError, match="must end in"):
        figure_file.save_figure(figure, tmp_path / "picture")
