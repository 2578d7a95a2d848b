"""What is known of the elastic skin that covers the taxels, and the file that says it."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from varishold.errors import FormatError, InputError
from varishold.files import read_toml
from varishold.sensor.toml import checked_keys

__all__ = ["SKIN_KINDS", "Skin", "SkinKind", "read_skin", "skin_of_table"]

# Beyond these numbers overflow, and no skin is such.
_LARGEST = 1e100
_THINNEST_M, _THICKEST_M = 1e-9, 1e3


@dataclass(frozen=True)
class SkinKind:
    """What a kind of skin must be told.

    Parameters
    ----------
    has_floor : bool
        Its thickness is needed, and the taxels lie no deeper.
    needs_poisson : bool
        A file must say Poisson's ratio, on which much depends.
    may_be_incompressible : bool
        Poisson's ratio may be .5.
    """

    has_floor: bool = True
    needs_poisson: bool = False
    may_be_incompressible: bool = True


#: By the `kind` of a skin; what such a skin does under a load is its medium's, of the same name.
SKIN_KINDS: dict[str, SkinKind] = {
    "layer": SkinKind(needs_poisson=True),
    "half-space": SkinKind(has_floor=False),
    "winkler": SkinKind(may_be_incompressible=False),
}


@dataclass(frozen=True)
class Skin:
    """An elastic skin over a pad.

    Parameters
    ----------
    kind : str
        A key of `SKIN_KINDS`: "layer", "half-space" or "winkler".
        A layer bonded to a rigid floor, a body without a floor, or a bed of independent springs.
    thickness_m : float, optional
        Thickness in metres; needed by "layer" and "winkler". A "half-space" has none.
    poisson : float
        Poisson's ratio, in (-1, .5]; "winkler" takes less than .5 only, for its columns cannot bulge.
    sensing_depth_m : float
        How deep under the surface the taxels lie, metres; 0 reads the surface itself. A "winkler"
        skin spreads nothing, so that its depth changes no frame.
    youngs_modulus_pa : float, optional
        Young's modulus in pascal. Without it stresses are in units of the contact modulus
        E / (1 - poisson^2), and neither forces nor heights can be told.

    Raises
    ------
    InputError
        If a value is not within its range.

    Examples
    --------
    >>> Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3).contact_modulus
    1.0
    """

    kind: str
    thickness_m: float | None = None
    poisson: float = 0.45
    sensing_depth_m: float = 0.0
    youngs_modulus_pa: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.kind, str) or self.kind not in SKIN_KINDS:
            raise InputError(f"kind of a skin must be one of {', '.join(SKIN_KINDS)}, got {self.kind!r}")
        kind = SKIN_KINDS[self.kind]
        for field in fields(self)[1:]:
            value = getattr(self, field.name)
            if value is None:
                continue
            # Compared, not asked: a whole number may be too large for a float.
            if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < math.inf:
                raise InputError(f"{field.name} of a skin must be a finite number, got {value!r}")
            if abs(value) > _LARGEST:
                raise InputError(f"{field.name} of a skin must be at most {_LARGEST:g}, in SI units, got a larger one")
        if kind.has_floor and self.thickness_m is None:
            raise InputError(f"a skin of kind {self.kind!r} needs thickness_m, in metres")
        if not kind.has_floor and self.thickness_m is not None:
            raise InputError(f"a skin of kind {self.kind!r} has no thickness_m; leave it out, or use kind 'layer'")
        if self.thickness_m is not None and self.thickness_m <= 0:
            raise InputError(f"thickness_m of a skin must be positive, got {self.thickness_m!r}")
        if self.thickness_m is not None and not _THINNEST_M <= self.thickness_m <= _THICKEST_M:
            raise InputError(
                f"thickness_m of a skin must lie between {_THINNEST_M:g} and {_THICKEST_M:g} metres, "
                f"got {self.thickness_m!r}; for a body without a floor use kind 'half-space'"
            )
        if not -1 < self.poisson <= 0.5:
            raise InputError(f"poisson of a skin must lie in (-1, .5], got {self.poisson!r}")
        if self.poisson == 0.5 and not kind.may_be_incompressible:
            raise InputError(f"poisson of a {self.kind} skin must be below .5, or it could not yield, got .5")
        if self.sensing_depth_m < 0:
            raise InputError(f"sensing_depth_m of a skin must not be negative, got {self.sensing_depth_m!r}")
        if kind.has_floor and self.thickness_m is not None and self.sensing_depth_m > self.thickness_m:
            raise InputError(
                f"sensing_depth_m must not exceed thickness_m = {self.thickness_m!r}, got {self.sensing_depth_m!r}"
            )
        if self.youngs_modulus_pa is not None and self.youngs_modulus_pa <= 0:
            raise InputError(f"youngs_modulus_pa of a skin must be positive, got {self.youngs_modulus_pa!r}")

    @property
    def contact_modulus(self) -> float:
        """E / (1 - poisson^2) in pascal; 1 where the modulus is unknown."""
        if self.youngs_modulus_pa is None:
            return 1.0
        return self.youngs_modulus_pa / (1 - self.poisson**2)


def read_skin(path: str | os.PathLike[str]) -> Skin:
    """Read a skin from a TOML file with one table ``[skin]``.

    Parameters
    ----------
    path : str or path-like
        The file. Its keys are the fields of `Skin`; `kind` is needed, as is `poisson` for a layer.

    Returns
    -------
    Skin

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is not TOML, or has a missing, unknown or impossible entry.
    """
    content = read_toml(path)
    known = ", ".join(field.name for field in fields(Skin))
    if not isinstance(content.get("skin"), dict):
        raise FormatError(f"{path}: needs a table [skin] with the keys {known}")
    checked_keys(path, content, ("skin",), "file")
    return skin_of_table(path, content["skin"])


def skin_of_table(path: str | os.PathLike[str], table: Mapping[str, Any]) -> Skin:
    """Return the skin that a table ``[skin]`` of a file describes.

    Parameters
    ----------
    path : str or path-like
        The file, for messages.
    table : mapping
        The table's entries.

    Raises
    ------
    FormatError
        If an entry is missing, unknown or impossible.
    """
    checked_keys(path, table, tuple(field.name for field in fields(Skin)), "[skin]")
    if "kind" not in table:
        raise FormatError(f"{path}: [skin] needs kind, one of {', '.join(SKIN_KINDS)}")
    try:
        skin = Skin(**table)
    except InputError as error:
        raise FormatError(f"{path}: [skin] {error}") from error
    if SKIN_KINDS[skin.kind].needs_poisson and "poisson" not in table:
        raise FormatError(f"{path}: a {skin.kind} needs poisson in [skin]: its compliance depends strongly on it")
    return skin
