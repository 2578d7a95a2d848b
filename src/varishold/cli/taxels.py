"""Taxels of the simulated hand in a few words, and the library that knows them."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from varishold.cli.command import Option

if TYPE_CHECKING:
    from varishold.perceive import Library
    from varishold.skin import Taxels

__all__ = ["TaxelWords", "felt_by", "library_of", "taxels_of"]

TaxelWords = Annotated[
    str | None,
    Option(
        "What the pads' taxels are like, as in noise=.03,crosstalk=.08,gain-spread=.15,dead=.03. Default: noise=.01.",
        metavar="KIND=SHARE,...",
    ),
]

_USUAL = "noise=.01"
# The least and the most of each kind.
_KINDS = {
    "noise": (0.0, 1.0),
    "crosstalk": (0.0, 0.24),
    "gain-spread": (0.0, 1.0),
    "dead": (0.0, 1.0),
    "stuck": (0.0, 1.0),
    "bits": (1, 32),
}


def taxels_of(words: str | None) -> Taxels:
    """Return the taxels that words tell; noise that is not told is none."""
    from varishold.errors import InputError
    from varishold.skin import Taxels

    told: dict[str, Any] = {}
    for part in (_USUAL if words is None else words).split(","):
        name, _, value = (word.strip() for word in part.partition("="))
        name = name.replace("_", "-")
        if name not in _KINDS or name in told:
            what = "twice" if name in told else "which is no kind"
            raise InputError(
                f"taxels are told as KIND=SHARE between commas, of {', '.join(_KINDS)}; got {part.strip()!r}, {what}"
            )
        told[name] = _number(name, value)
    return Taxels(**{name.replace("-", "_"): value for name, value in told.items()})


def _number(name: str, value: str) -> float | int:
    """Return a share, or how many bits."""
    from varishold.errors import InputError

    least, most = _KINDS[name]
    with suppress(ValueError):
        number = float(value)
        if least <= number <= most and (name != "bits" or number == int(number)):
            return int(number) if name == "bits" else number
    what = "a whole number" if name == "bits" else "a number"
    raise InputError(f"{name} of taxels must be {what} in {least:g} .. {most:g}, got {value!r}")


def library_of(path: Path | None, words: str | None, pose: str = "upright", *, quiet: bool = False) -> Library | None:
    """Return the library of a file, or that shipped of a pose felt by the taxels that words tell; None: as shipped."""
    from varishold.perceive import read_library, shipped_library

    if path is not None or words is None:
        return None if path is None else read_library(path)
    taxels = taxels_of(words)
    if not quiet:
        click.echo("feels the library again by such taxels; 'varishold objects taxels' keeps it in a file", err=True)
    return felt_by(taxels, shipped_library(pose))


def felt_by(taxels: Taxels, known: Library, *, seed: int = 0) -> Library:
    """Return a library that knows the taxels, with a bar meanwhile."""
    from varishold.cli.progress import progress_bar
    from varishold.perceive import for_pads

    with progress_bar("touches") as update:
        return for_pads(known, taxels, seed=seed, progress=lambda done, of: update(completed=done, total=of))
