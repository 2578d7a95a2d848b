"""``varishold sources``: what can be watched, and what is in reach now."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from varishold.cli.command import Commands, Option
from varishold.cli.printing import echo

if TYPE_CHECKING:
    from varishold.live.framing import Framing


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(sources)


def sources(
    json: Annotated[bool, Option("Print one JSON object a kind, a source and a preset.")] = False,
) -> None:
    """List what can be watched: kinds of sources, those in reach now, and the framings of serial skins."""
    from varishold.cli.printing import print_json
    from varishold.live.framing import FRAMINGS, framing_of
    from varishold.live.reach import reachable_kinds

    kinds = reachable_kinds()
    framings = {name: framing_of(path) for name, path in FRAMINGS.items()}
    if json:
        for kind in kinds:
            missing = kind.missing or None
            print_json({"kind": list(kind.names), "title": kind.title, "example": kind.example, "missing": missing})
        for kind in kinds:
            for address, words in kind.found:
                print_json({"source": address, "notes": words})
        for name, framing in framings.items():
            print_json({"preset": name, **_entries(framing)})
        return
    echo("kinds, each with an example (docs/live.md):")
    for kind in kinds:
        echo(f"  {kind.example:42} {kind.title}")
    for kind in kinds:
        if kind.missing:
            echo(f"  {kind.names[0]}: {kind.missing}")
    reached = [source for kind in kinds for source in kind.found]
    echo("in reach now:" if reached else "in reach now: nothing that tells of itself")
    for address, words in reached:
        echo(f"  {address:42} {words}")
    echo("framings of serial skins, as in serial:PORT?preset=NAME:")
    for name, framing in framings.items():
        marked = " (third-party)" if framing.third_party else ""
        echo(f"  {name:16} {framing.baud:8d} baud  {_shapes(framing):20} {framing.name}{marked}: {framing.notes}")


def _entries(framing: Framing) -> dict[str, object]:
    return {
        "name": framing.name,
        "baud": framing.baud,
        "pads": {pad.name: list(pad.layout.shape) or None for pad in framing.pads},
        "third_party": framing.third_party,
        "notes": framing.notes,
    }


def _shapes(framing: Framing) -> str:
    shapes = [" x ".join(map(str, pad.layout.shape)) or "any" for pad in framing.pads]
    return " and ".join(shapes)
