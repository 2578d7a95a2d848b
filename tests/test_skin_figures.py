"""Every figure of the skin is drawn, whole, and the same for the same press."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks._bits_figure import BitsCurve, write_bits_figure
from docs.images.contents_figure import ContentsEntry, write_contents_figure
from docs.images.ring_figure import write_ring_figure
from varishold.errors import InputError
from varishold.report.press_figure import write_press_figure
from varishold.skin import PressedSolid, Relief, Skin, press, reconstruct, sense
from varishold.solids import Cone, Plane, Solid

LAYER = Skin("layer", 6e-3, 0.45, 1e-3)


def _seen(solid: Solid) -> tuple[PressedSolid, Relief]:
    pressed = press(solid, LAYER, depth=1e-3, shape=(12, 16), pitch_m=2e-3)
    return pressed, reconstruct(sense(pressed), LAYER, pitch=2e-3)


@pytest.mark.parametrize("solid", [Cone(40e-3, 6e-3), Plane(5e-3)], ids=["cone", "plane"])
def test_press_figure(solid: Solid, tmp_path: Path) -> None:
    pressed, relief = _seen(solid)
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    write_press_figure(one, pressed, sense(pressed), relief=relief, title="a press")
    write_press_figure(two, pressed, sense(pressed), relief=relief, title="a press")
    assert one.read_bytes().startswith(b"\x89PNG")
    assert one.read_bytes() == two.read_bytes()


def test_contents_figure(tmp_path: Path) -> None:
    pressed, relief = _seen(Cone(40e-3, 6e-3))
    entry = ContentsEntry("cone", pressed, sense(pressed), relief)
    write_contents_figure(tmp_path / "one.png", [entry] * 2, note="a note")
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")


def test_ring_and_bits_figures(tmp_path: Path) -> None:
    pressed, _ = _seen(Cone(40e-3, 6e-3))
    square = pressed.pressure[:, : pressed.pressure.shape[0]]
    write_ring_figure(tmp_path / "ring.png", [("one", square), ("two", square)], side_m=24e-3)
    curves = [BitsCurve("sections", [100, 200], [0.5, 0.9]), BitsCurve("all", [3072], [0.95])]
    write_bits_figure(tmp_path / "bits.png", curves, title="bits")
    for name in ("ring", "bits"):
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_a_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no folder"):
        write_bits_figure(tmp_path / "none" / "bits.png", [BitsCurve("all", [1], [1])])
