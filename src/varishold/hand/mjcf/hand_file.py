"""A hand's file: an MJCF, and what in it are the palm, the digits, the switches and the pads."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from varishold._counted import counted
from varishold.errors import InputError
from varishold.files import read_toml
from varishold.hand.layouts import Layout, Switch
from varishold.hand.mjcf.body import listed
from varishold.hand.mjcf.hand import MjcfHand
from varishold.hand.mjcf.likely import check_likely
from varishold.hand.mjcf.measured import Measured
from varishold.hand.mjcf.pieces import MjcfDigit, MjcfPad
from varishold.hand.mjcf.said import Table, tables
from varishold.hand.mjcf.source import read_mjcf
from varishold.hand.model import require_mujoco

__all__ = ["SHIPPED_HANDS", "hand_files", "read_hand"]

_HANDS = Path(__file__).parent.parent / "hands"

#: Hands that come with the program, by the name that commands use.
SHIPPED_HANDS: dict[str, Path] = {"three-finger": _HANDS / "three-finger" / "hand.toml"}

_MOST_DIGITS, _MOST_JOINTS, _MOST_SWITCHES = 12, 12, 200
_FAR = 1e4
# An end of a range may be written with fewer digits, and lie beyond it by this part.
_ROUNDED = 1e-3
# A joint closes with so much where neither file says it (N m, N), and joints farther out with this part of the first.
_TORQUE_NM, _FORCE_N, _OUTWARD = 0.55, 15.0, (1.0, 0.6, 0.44)
# With what an opposed digit holds against all fingers, as a part of their torques together.
_AGAINST = 0.65


def read_hand(name: str | os.PathLike[str]) -> MjcfHand:
    """Read a hand.

    Parameters
    ----------
    name : str or path-like
        A file (TOML), or a key of `SHIPPED_HANDS`.

    Raises
    ------
    InputError
        If the file or its MJCF cannot be read, names what the MJCF has not, or says what no hand can be.
    MissingExtraError
        If MuJoCo is not installed.
    """
    mj = require_mujoco()
    path = SHIPPED_HANDS.get(os.fspath(name), Path(name))
    if not path.exists() and path.suffix.lower() != ".toml":
        known = ", ".join(SHIPPED_HANDS)
        raise InputError(f"{path}: is neither a file nor a hand that comes with the program ({known})")
    content = read_toml(path)
    top = Table(str(path), content)
    top.only("name", "mjcf", "library", "palm", "digits", "switches", "pads", "grip")
    source = read_mjcf(path.parent / top.text("mjcf"))
    called = top.text("name", path.parent.name if path.stem == "hand" else path.stem)
    palm = _palm(top, content)
    digits = tables(str(path), content, "digits")
    actuators = tuple(dict.fromkeys(name for table in digits for name in table.texts("actuators")))
    measured = Measured(mj, source, palm.content.get("body", ""), actuators)
    place = measured.place_palm(
        palm.numbers("out", 3, -1, 1) or (1.0, 0.0, 0.0),
        palm.numbers("up", 3, -1, 1) or (0.0, 0.0, 1.0),
        palm.numbers("origin_m", 3, -1, 1),
        palm,
    )
    joints = _joints(digits, measured)
    made = [_digit(table, measured, joints[k]) for k, table in enumerate(digits)]
    _check_digits(path, made)
    made = [digit for digit in made if not digit.opposed] + [digit for digit in made if digit.opposed]
    limbs, made = measured.parts(made, {table.text("name"): table for table in digits})
    height, breadth, middle = measured.palm_face()
    place = replace(place, middle_m=middle, size_m=(height, breadth))
    parts = (*(limb.name for limb in limbs), "palm")
    grip = Table(f"{path}: [grip]", content.get("grip", {}))
    pointer, supporter = _pointers(grip, made)
    library = path.parent / top.text("library") if "library" in content else None
    felt_by = {key: value for key, value in content.items() if key != "library"}
    digest = hashlib.sha256(
        repr((called, json.dumps(felt_by, sort_keys=True, default=str), source.xml, source.files)).encode()
    )
    driven = {name: [d.name for d in made if name in d.actuators] for name in actuators}
    if supporter is not None and any({pointer, supporter} <= set(names) for names in driven.values()):
        supporter = None
    pinch, whole = _gains(made, pointer)
    hand = MjcfHand(
        called,
        f"{called}@{digest.hexdigest()[:12]}",
        source,
        place,
        tuple(made),
        tuple(limbs),
        _pads(path, content, parts, limbs, (height, breadth)),
        measured.moving([joint for digit in made for joint in digit.joints]),
        _layout(path, content, called, parts, made, (height, breadth), middle),
        pointer,
        supporter,
        library=None if library is None else str(library),
        pinch_gain=grip.number("opposed_gain", pinch, 0.01, 100),
        grip_gain=grip.number("opposed_gain_all", whole, 0.01, 100),
        search_gain=grip.number("search_gain", 0.3, 0.01, 1),
        lift_rad=grip.number("lift_rad", 0.5, 0.05, 1.5),
        wrist_m=grip.number("wrist_m", 0.10, 0.01, 1),
        friction=grip.number("friction", 0.8, 0.05, 5),
        torsion_m=grip.number("torsion_m", 0.006, 1e-5, 0.1),
        palm_above_middle_m=grip.number("palm_above_middle_m", 0.005, -0.1, 0.1),
    )
    check_likely(hand)
    return _reached(grip, hand)


def hand_files(name: str | os.PathLike[str], *, library: bool = True) -> tuple[Path, ...]:
    """Return the files that a hand is read from: its own, its MJCF's, and its library.

    What cannot be read names none in its turn, which `read_hand` will tell.

    Parameters
    ----------
    name : str or path-like
        As of `read_hand`.
    library : bool
        Whether its library is among them.
    """
    path = SHIPPED_HANDS.get(os.fspath(name), Path(name))
    try:
        content = read_toml(path)
    except InputError:
        return (path,)
    keys = ("mjcf", "library") if library else ("mjcf",)
    named = {key: path.parent / content[key] for key in keys if isinstance(content.get(key), str)}
    files = [path, *named.values()]
    if "mjcf" in named:
        with suppress(InputError):
            files += read_mjcf(named["mjcf"]).read
    return tuple(files)


def _palm(top: Table, content: dict[str, Any]) -> Table:
    said = content.get("palm")
    if not isinstance(said, dict):
        raise InputError(f"{top.where}: [palm] is missing; it names the MJCF's body of the palm: body = ...")
    for key in ("grip",):
        if not isinstance(content.get(key, {}), dict):
            raise InputError(f"{top.where}: {key} must be a table, begun by [{key}]")
    table = Table(f"{top.where}: [palm]", said)
    table.only("body", "origin_m", "out", "up")
    table.text("body")
    return table


def _joints(digits: Any, measured: Measured) -> list[tuple[str, ...]]:
    """The joints of each digit, which must be there, once each."""
    seen: dict[str, str] = {}
    out = []
    for table in digits:
        table.only("name", "joints", "opposed", "open", "closed", "straight", "torque", "actuators", "parts")
        joints = table.texts("joints")
        if not 1 <= len(joints) <= _MOST_JOINTS:
            raise table.wrong("joints", f"must name 1 to {_MOST_JOINTS} joints, from the palm outward")
        for joint in joints:
            measured.require_joint(joint, table)
            if joint in seen:
                raise table.wrong("joints", f"names {joint!r}, which is one of {seen[joint]} already")
            seen[joint] = table.content.get("name", "another digit")
        for actuator in table.texts("actuators"):
            measured.require_actuator(actuator, table)
        out.append(joints)
    return out


def _digit(table: Table, measured: Measured, joints: tuple[str, ...]) -> MjcfDigit:
    name = table.text("name")
    if "." in name or name == "palm":
        raise table.wrong("name", f"must be another than 'palm' and hold no dot, got {name!r}")
    opposed, actuators = table.flag("opposed"), table.texts("actuators")
    if actuators:
        ranges = {name: measured.actuator_range(name) for name in actuators}
    else:
        ranges = {name: measured.joint_range(name) for name in joints}
    n = len(ranges)
    opened, closed = _within(table, "open", ranges), _within(table, "closed", ranges)
    slides = tuple(measured.slides(joint) for joint in joints)
    if actuators:
        if opened is None or closed is None:
            raise InputError(
                f"{table.where}: open and closed are needed with actuators: what each is told, {counted(n, 'number')}"
            )
        for key in ("straight", "torque"):
            if key in table.content:
                raise table.wrong(key, "says nothing of a digit with actuators; leave it out")
        straight: tuple[float, ...] = ()
        torque: tuple[float, ...] = (1.0,) * n
    else:
        if opened is None or closed is None:
            usual = measured.open_and_closed(joints, opposed, table)
            opened, closed = opened or usual[0], closed or usual[1]
        low, high = np.minimum(opened, closed), np.maximum(opened, closed)
        reached = dict(zip(joints, zip(low.tolist(), high.tolist(), strict=True), strict=True))
        straight = _within(table, "straight", reached) or tuple(np.clip(0.0, low, high).tolist())
        first = measured.torque(joints[0]) or (_FORCE_N if slides[0] else _TORQUE_NM)
        weaker = [first * _OUTWARD[min(k, 2)] for k in range(n)]
        own = [measured.torque(joint) for joint in joints]
        torque = table.numbers("torque", n, 0, 1e4) or tuple(
            min(each, weaker[k]) if each else (_FORCE_N if slides[k] else weaker[k]) for k, each in enumerate(own)
        )
        if all(a == b for a, b in zip(opened, closed, strict=True)):
            raise InputError(f"{table.where}: open and closed are the same, so that {name!r} cannot close")
        if not any(each > 0 and a != b for each, a, b in zip(torque, opened, closed, strict=True)):
            raise table.wrong("torque", f"must be positive for a joint of {name!r} that closes")
    return MjcfDigit(name, joints, (), opposed, opened, closed, straight, torque, slides, actuators)


def _within(table: Table, key: str, ranges: Mapping[str, tuple[float, float]]) -> tuple[float, ...] | None:
    """Return a number for each joint or actuator, in its range; None where they are not said."""
    values = table.numbers(key, len(ranges), -_FAR, _FAR)
    for value, (name, (low, high)) in zip(values or (), ranges.items(), strict=False):
        slack = _ROUNDED * max(high - low, abs(low), abs(high))
        if not low - slack <= value <= high + slack:
            raise table.wrong(key, f"must lie in [{low:g}, {high:g}], where {name!r} moves, got {value:g}")
    return values


def _check_digits(path: Path, digits: list[MjcfDigit]) -> None:
    names = [digit.name for digit in digits]
    if not 2 <= len(digits) <= _MOST_DIGITS:
        raise InputError(
            f"{path}: needs 2 to {_MOST_DIGITS} [[digits]], each with a name and its joints, got {len(digits)}"
        )
    twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
    if twice is not None:
        raise InputError(f"{path}: two digits are called {twice!r}; give each a name of its own")
    if not any(digit.opposed for digit in digits):
        raise InputError(
            f"{path}: no digit is opposed, and a hand grips between fingers and opposed digits; "
            "mark what closes toward the others with opposed = true"
        )
    if all(digit.opposed for digit in digits):
        raise InputError(f"{path}: every digit is opposed; leave opposed out for those that the others close toward")


def _gains(digits: Sequence[MjcfDigit], pointer: str) -> tuple[float, float]:
    """Gains of opposed digits that hold against the pointer, and against all fingers."""
    strength = {
        digit.name: max(
            each if not digit.actuators and a != b else 0.0
            for each, a, b in zip(digit.torque, digit.open, digit.closed, strict=True)
        )
        for digit in digits
    }
    fingers, thumbs = (
        sum(strength[digit.name] for digit in digits if digit.opposed == opposed) for opposed in (False, True)
    )
    if not strength[pointer] or not thumbs:
        return 1.0, 1.0
    return strength[pointer] / thumbs, max(strength[pointer], _AGAINST * fingers) / thumbs


def _pointers(grip: Table, digits: list[MjcfDigit]) -> tuple[str, str | None]:
    grip.only(
        "pointer",
        "supporter",
        "fingertip",
        "opposed_gain",
        "opposed_gain_all",
        "search_gain",
        "lift_rad",
        "wrist_m",
        "friction",
        "torsion_m",
        "palm_above_middle_m",
        "sizes_m",
    )
    fingers = [digit.name for digit in digits if not digit.opposed]
    pointer = grip.text("pointer", fingers[0])
    rest = [name for name in fingers if name != pointer]
    supporter = grip.text("supporter", rest[-1] if rest else pointer)
    for key, value in (("pointer", pointer), ("supporter", supporter)):
        if value not in fingers:
            raise grip.wrong(key, f"must be one of the fingers {', '.join(fingers)}, got {value!r}")
    return pointer, None if supporter == pointer else supporter


def _layout(
    path: Path,
    content: dict[str, Any],
    called: str,
    parts: tuple[str, ...],
    digits: list[MjcfDigit],
    palm_m: tuple[float, float],
    middle_m: tuple[float, float],
) -> Layout:
    switches = []
    said = tables(str(path), content, "switches")
    if not said:
        raise InputError(f"{path}: has no switch, and a hand feels with them; add [[switches]] with name and part")
    if len(said) > _MOST_SWITCHES:
        raise InputError(f"{path}: has {len(said)} switches; at most {_MOST_SWITCHES} are read")
    for table in said:
        table.only("name", "part", "on_n", "y_m", "z_m")
        part = table.text("part")
        if part not in parts:
            raise table.wrong("part", f"must be one of {listed(parts)}; got {part!r}")
        if part != "palm" and ("y_m" in table.content or "z_m" in table.content):
            raise table.wrong("part", f"{part!r} is felt as a whole; y_m and z_m are the place of a palm's button")
        on_n = table.number("on_n", None, 1e-4, 1e3) if "on_n" in table.content else None
        y_m, z_m = (
            table.number(key, middle_m[k], middle_m[k] - palm_m[1 - k], middle_m[k] + palm_m[1 - k])
            if part == "palm"
            else 0.0
            for k, key in enumerate(("y_m", "z_m"))
        )
        switches.append(Switch(table.text("name"), part, y_m, z_m, on_n))
        if switches[-1].name in [switch.name for switch in switches[:-1]]:
            raise table.wrong("name", f"{switches[-1].name!r} is another switch's already")
    for opposed, what in ((False, "a finger"), (True, "an opposed digit")):
        own = {part for digit in digits if digit.opposed == opposed for part in digit.parts}
        if not own & {switch.part for switch in switches}:
            raise InputError(
                f"{path}: no switch is on {what}, and the hand feels what it holds between its switches; "
                f"put one on {listed(sorted(own))}"
            )
    return Layout(called, tuple(switches))


def _pads(
    path: Path, content: dict[str, Any], parts: tuple[str, ...], limbs: Any, palm_m: tuple[float, float]
) -> tuple[MjcfPad, ...]:
    usual = {
        limb.name: (limb.capsule.length_m, 2 * (limb.capsule.radius_m + limb.capsule.half_breadth_m)) for limb in limbs
    }
    usual["palm"] = (palm_m[1], palm_m[0])
    if content.get("pads") == "all":
        return tuple(MjcfPad(part, _enough(usual[part])) for part in parts)
    pads: list[MjcfPad] = []
    for table in tables(str(path), content, "pads"):
        table.only("part", "size_m", "pitch_m")
        part = table.text("part")
        if part not in parts:
            raise table.wrong("part", f"must be one of {listed(parts)}; got {part!r}")
        if part in [pad.part for pad in pads]:
            raise table.wrong("part", f"{part!r} has a pad already; one pad a part")
        size = table.numbers("size_m", 2, 0.002, 0.3)
        pitch = table.number("pitch_m", None, 2e-4, 0.05) if "pitch_m" in table.content else None
        length, height = size or _enough(usual[part])
        if pitch is not None and max(length, height) / pitch > 256:
            raise table.wrong(
                "pitch_m", f"makes more than 256 taxels of {1e3 * max(length, height):.0f} mm; take a larger one"
            )
        pads.append(MjcfPad(part, (length, height), pitch))
    return tuple(sorted(pads, key=lambda pad: parts.index(pad.part)))


def _enough(size_m: tuple[float, float]) -> tuple[float, float]:
    return max(0.004, size_m[0]), max(0.004, size_m[1])


def _reached(grip: Table, hand: MjcfHand) -> MjcfHand:
    """Add what shows only when the whole hand can be placed: sizes, reach, and the tip that can come down."""
    from varishold.hand.mjcf.reach import reach_of

    reach = reach_of(hand)
    sizes = grip.numbers("sizes_m", 2, 0.005, 0.3) or reach.sizes_m
    if not sizes[0] < sizes[1]:
        raise grip.wrong("sizes_m", f"must be the least and the largest size that it grips, got {list(sizes)}")
    comes = grip.flag("fingertip", reach.comes_down)
    if comes and not reach.can_be_held:
        raise grip.wrong(
            "fingertip", f"cannot be true: the joints of {hand.pointer!r} are moved by actuators of its own"
        )
    return replace(
        hand,
        sizes_m=(sizes[0], sizes[1]),
        longer_m=reach.longer_m,
        tip=hand.digits[hand.pointer].parts[-1] if comes else None,
        tip_place_m=reach.tip_place_m,
    )
