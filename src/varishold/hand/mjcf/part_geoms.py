"""Which bodies and geoms of an MJCF a digit's parts are."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from varishold.errors import InputError
from varishold.hand.mjcf.body import colliding, listed
from varishold.hand.mjcf.pieces import MjcfDigit
from varishold.hand.mjcf.said import Table

__all__ = ["geoms_by_part", "welded"]


def welded(spec: Any, body: str, stop: Collection[str] = (), *, moving: bool = False) -> list[str]:
    """Bodies below one that move with it, none of `stop` and what is below it; or that move too."""
    out: list[str] = []
    for child in spec.body(body).bodies:
        if child.name in stop or (len(child.joints) and not moving):
            continue
        out += [child.name, *welded(spec, child.name, stop, moving=moving)]
    return out


def geoms_by_part(spec: Any, digit: MjcfDigit, table: Table) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Body and geoms of each part by its full name."""
    said = table.content.get("parts")
    if said is None:
        moved = list(dict.fromkeys(spec.joint(joint).parent.name for joint in digit.joints))
        every = {body: body for body in moved}
    elif isinstance(said, dict) and said:
        every = said
    else:
        raise table.wrong("parts", 'must name bodies, as in { proximal = "body_1", distal = "body_2" }')
    bodies = {value for value in every.values() if isinstance(value, str)}
    out: dict[str, tuple[str, tuple[str, ...]]] = {}
    for name, value in every.items():
        if isinstance(value, str):
            body, geoms = value, _colliding_below(spec, value, bodies, table, moving=said is not None)
        elif isinstance(value, list) and value and all(isinstance(each, str) for each in value):
            body, geoms = _body_of(spec, value, table), tuple(value)
        else:
            raise table.wrong("parts", f"{name!r} must be a body's name or a list of geoms' names")
        if not geoms:
            if said is None:
                continue
            raise table.wrong("parts", f"{name!r} has no geom that touches anything (contype and conaffinity are 0)")
        part = name if name.startswith(f"{digit.name}.") else f"{digit.name}.{name}"
        if part in out:
            raise table.wrong("parts", f"names {part!r} twice, with its digit's name before it and without")
        out[part] = (body, geoms)
    if not out:
        raise InputError(
            f"{table.where}: nothing that its joints move touches anything (contype and conaffinity are 0); "
            "name its parts, or give the bodies geoms that collide"
        )
    return out


def _colliding_below(spec: Any, body: str, stop: set[str], table: Table, *, moving: bool) -> tuple[str, ...]:
    """Geoms of a body and of those that `welded` finds below it."""
    if spec.body(body) is None or body == "world":
        names = [each.name for each in spec.bodies if each.name != "world"]
        raise table.wrong("parts", f"names {body!r}, and the MJCF has no such body; it has {listed(names)}")
    own = [body, *welded(spec, body, stop, moving=moving)]
    return tuple(geom.name for each in own for geom in spec.body(each).geoms if colliding(geom))


def _body_of(spec: Any, geoms: Sequence[str], table: Table) -> str:
    """Name of the body that the first of some geoms is of; all must be there."""
    missing = next((each for each in geoms if spec.geom(each) is None), None)
    if missing is not None:
        names = [each.name for each in spec.geoms]
        raise table.wrong("parts", f"names {missing!r}, and the MJCF has no such geom; it has {listed(names)}")
    return str(spec.geom(geoms[0]).parent.name)
