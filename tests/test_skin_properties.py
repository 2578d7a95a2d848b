"""The skin file: what it says is read, and what is wrong in it is told in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from varishold.errors import FormatError, InputError
from varishold.skin import Skin, read_skin


def _write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "skin.toml"
    path.write_text(text)
    return path


def test_a_file_gives_its_skin(tmp_path: Path) -> None:
    path = _write(
        tmp_path,
        '[skin]\nkind = "layer"\nthickness_m = 6e-3\npoisson = 0.45\nsensing_depth_m = 1e-3\nyoungs_modulus_pa = 3e5\n',
    )
    assert read_skin(path) == Skin("layer", 6e-3, 0.45, 1e-3, 3e5)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("kind = 'layer'", "needs a table [skin]"),
        ("[skin]\nkind = 'layer'\nthickness = 1.0", "unknown key thickness in [skin]; known are kind"),
        ("[skin]\nkind = 'half-space'\n[pad]\n", "unknown key pad in file"),
        ("[skin]\npoisson = 0.3", "needs kind, one of layer, half-space, winkler"),
        ("[skin]\nkind = 'rubber'", "must be one of layer, half-space, winkler, got 'rubber'"),
        ("[skin]\nkind = 'layer'\nthickness_m = 6e-3", "needs poisson"),
        ("[skin]\nkind = 'layer'\npoisson = 0.45", "needs thickness_m"),
        ("[skin]\nkind = 'layer'\npoisson = 0.45\nthickness_m = 0", "thickness_m of a skin must be positive"),
        ("[skin]\nkind = 'half-space'\npoisson = 0.51", "poisson of a skin must lie in (-1, .5], got 0.51"),
        ("[skin]\nkind = 'half-space'\nthickness_m = 0.01", "[skin] a skin of kind 'half-space' has no thickness_m"),
        ("[skin]\nkind = 'half-space'\npoisson = -1", "poisson of a skin must lie in (-1, .5], got -1"),
        ("[skin]\nkind = 'half-space'\npoisson = '.3'", "must be a finite number, got '.3'"),
        ("[skin]\nkind = 'half-space'\npoisson = nan", "must be a finite number, got nan"),
        ("[skin]\nkind = 'winkler'\nthickness_m = 1e-3\npoisson = 0.5", "must be below .5"),
        ("[skin]\nkind = 'half-space'\nsensing_depth_m = -1e-3", "sensing_depth_m of a skin must not be neg"),
        (
            "[skin]\nkind = 'layer'\npoisson = 0.3\nthickness_m = 1e-3\nsensing_depth_m = 2e-3",
            "must not exceed thickness_m",
        ),
        ("[skin]\nkind = 'half-space'\nyoungs_modulus_pa = 0", "youngs_modulus_pa of a skin must be positive"),
        ("[skin\n", "not a TOML file"),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, text: str, says: str) -> None:
    path = _write(tmp_path, text)
    with pytest.raises(FormatError) as caught:
        read_skin(path)
    message = str(caught.value)
    assert says in message
    assert message.startswith(str(path))
    assert "\n" not in message


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        read_skin(tmp_path / "none.toml")


def test_a_skin_without_modulus_speaks_in_units_of_it() -> None:
    assert Skin("half-space").contact_modulus == 1.0
    assert Skin("half-space", poisson=0.5, youngs_modulus_pa=3.0).contact_modulus == pytest.approx(4.0)


def test_a_wrong_skin_is_an_input_error() -> None:
    with pytest.raises(InputError, match="thickness_m"):
        Skin("layer", thickness_m=-1.0)
