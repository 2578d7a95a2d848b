"""Numbers in words are read back: as near as their digits are, in the unit that suits them, with none in excess."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.report.colours import shade
from varishold.report.photo import photo_data_uri
from varishold.report.quantities import angle, area, length, number, percent, prefixed, reading

# Steps of a tenth of a decade and what rounds up to the next one.
MAGNITUDES = [m * 10.0**e for e in range(-13, 13) for m in (1.0, 1.26, 2.5, 5.01, 9.9, 9.994, 9.996, 9.99999)]
PREFIXES = {"G": 9, "M": 6, "k": 3, "": 0, "m": -3, "µ": -6, "n": -9}


def value_of(text: str) -> float:
    return float(text.replace("−", "-"))


@pytest.mark.parametrize("digits", [2, 3, 4])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_number_is_told_to_its_digits_and_plainly_where_it_can_be(digits: int, sign: int) -> None:
    for size in MAGNITUDES:
        text = number(sign * size, digits)
        rounded = float(f"{size:.{digits - 1}e}")
        assert text.startswith("−") == (sign < 0)
        assert "-" not in text.replace("e-", "")
        if 1e-4 <= size < 1e6:
            assert "e" not in text
            # Before the point every digit is told, after it none that is 0 at the end.
            whole, _, part = text.removeprefix("−").partition(".")
            assert abs(value_of(text)) == pytest.approx(rounded if rounded < 10 ** (digits - 1) else round(size))
            assert not part.endswith("0")
            assert not text.endswith(".")
            assert len((whole + part).lstrip("0")) <= max(digits, len(whole))
        else:
            assert abs(value_of(text.replace("e−", "e-"))) == pytest.approx(rounded)
            assert "e" in text
    assert number(0.0, digits) == number(-0.0, digits) == "0"
    assert number(math.inf) == number(math.nan) == number(-math.inf) == "–"


@pytest.mark.parametrize("power", [1, 2])
def test_a_prefix_leaves_one_to_a_thousand(power: int) -> None:
    for size in MAGNITUDES:
        if not 1e-9**power <= size < 1e9**power:
            continue
        text, unit = prefixed(-size, "N", power).split("\u202f")
        factor = 10.0 ** (power * PREFIXES[unit.removesuffix("N")])
        assert abs(value_of(text)) * factor == pytest.approx(size, rel=0.0051)
        assert 0.9995 <= size / factor < 0.9995 * 1000**power * 1.0000001
        assert abs(value_of(text)) >= 1
    assert prefixed(0.0, "N") == "0\u202fN"
    assert prefixed(math.nan, "N") == "–\u202fN"
    assert prefixed(2e-12, "N") == "0.002\u202fnN"
    assert prefixed(3e12, "N") == "3000\u202fGN"
    assert prefixed(0.9995, "N") == "1\u202fN"
    assert prefixed(0.9994, "N") == "999\u202fmN"


@pytest.mark.parametrize(
    ("metres", "told"),
    [
        (0.99e-4, "99\u202fµm"),
        (1e-4, "0.1\u202fmm"),
        (0.5, "500\u202fmm"),
        (0.9985, "998\u202fmm"),
        (1.0, "1\u202fm"),
        (-0.012, "−12\u202fmm"),
        (-2.5, "−2.5\u202fm"),
        (0.0, "0\u202fm"),
    ],
)
def test_a_length_on_a_pad_is_told_in_millimetres(metres: float, told: str) -> None:
    assert length(metres, metres=True) == reading(metres, "m") == reading(metres, "Metres") == told


@pytest.mark.parametrize(
    ("square_metres", "told"),
    [
        (0.9e-8, "9000\u202fµm²"),
        (1e-8, "0.01\u202fmm²"),
        (9.9e-3, "9900\u202fmm²"),
        (1e-2, "10000\u202fmm²"),
        (1.5, "1.5\u202fm²"),
        (0.0, "0\u202fm²"),
    ],
)
def test_an_area_on_a_pad_is_told_in_square_millimetres(square_metres: float, told: str) -> None:
    assert area(square_metres, metres=True) == told


def test_taxels_are_counted_and_one_is_one() -> None:
    assert [length(n, metres=False) for n in (1, -1, 1.5, 0)] == [
        "1\u202ftaxel",
        "−1\u202ftaxel",
        "1.5\u202ftaxels",
        "0\u202ftaxels",
    ]
    assert area(12.25, metres=False) == "12.2\u202ftaxels"


@pytest.mark.parametrize(
    ("unit", "told"),
    [
        *(("Pa", "1.5\u202fkPa"), ("pascals", "1.5\u202fkPa"), ("raw", "1500"), ("", "1500")),
        *(("metre", "1.5\u202fkm"), ("mV", "1500\u202fmV"), ("counts", "1500\u202fcounts")),
    ],
)
def test_what_a_taxel_reads_is_told_in_its_unit(unit: str, told: str) -> None:
    assert reading(1500.0, unit) == told


def test_angles_are_told_to_a_tenth_of_a_degree() -> None:
    for degrees in np.linspace(-360, 360, 1441):
        text = angle(math.radians(degrees))
        assert text.endswith("°")
        assert value_of(text[:-1]) == pytest.approx(degrees, abs=0.0501)
        assert re.fullmatch(r"−?\d+(\.\d)?°", text)


def test_what_is_not_certain_is_never_told_as_certain() -> None:
    for share in (*np.linspace(0, 1, 2001).tolist(), 1e-9, 0.000999, 0.001, 0.999, 0.9991, 1 - 1e-9):
        text = percent(share)
        (told,) = re.findall(r"\d+\.?\d*", text)
        assert text.startswith(">") == (0.999 < share < 1)
        assert text.startswith("<") == (0 < share < 0.001)
        assert text.endswith("\u202f%")
        if text[0] in "<>":
            assert told == ("99.9" if share > 0.5 else "0.1")
        else:
            assert float(told) == pytest.approx(100 * share, abs=0.0501)
            assert (told in ("0", "100")) == (share in (0.0, 1.0))


# ---- colours


def test_the_scale_is_even_in_oklab_from_dark_blue_to_light_yellow() -> None:
    """Ottosson's way from linear light to Oklab, by the numbers that he gives for it."""
    to_lms = [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
    to_lab = [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
    t = np.linspace(0, 1, 41)
    srgb = shade(t) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    lab = np.cbrt(linear @ np.array(to_lms).T) @ np.array(to_lab).T
    # Where a screen cannot show so vivid a colour the nearest is taken, which is a little lighter.
    inside = (srgb > 0).all(axis=1)
    assert inside.sum() > 25
    assert lab[inside, 0] == pytest.approx(np.linspace(0.185, 0.95, 41)[inside], abs=0.003)
    assert lab[:, 0] == pytest.approx(np.linspace(0.185, 0.95, 41), abs=0.011)
    hue = np.degrees(np.arctan2(lab[:, 2], lab[:, 1])) % 360
    assert hue[inside] == pytest.approx((281 - 178 * t**1.15)[inside], abs=3.5)
    chroma = np.hypot(lab[:, 1], lab[:, 2])
    vivid = 0.035 + 0.08 * np.sin(np.pi * np.minimum(t, 0.62) ** 0.8) * (1 - 0.15 * t)
    assert chroma[inside] == pytest.approx(vivid[inside], abs=0.004)
    assert shade(-1.0).tolist() == shade(0.0).tolist()
    assert shade(2.0).tolist() == shade(1.0).tolist()


@pytest.mark.parametrize("shape", [(0, 3, 3), (3, 0, 3), (3, 3), (3, 3, 4), (1, 3, 3, 3)])
def test_what_is_no_picture_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="a picture must be uint8 of shape"):
        photo_data_uri(np.zeros(shape, np.uint8))
    with pytest.raises(InputError, match="got float64 of shape"):
        photo_data_uri(np.zeros((3, 3, 3)))  # type: ignore[arg-type]
    assert photo_data_uri(np.zeros((1, 1, 3), np.uint8)).startswith("data:image/png;base64,")
