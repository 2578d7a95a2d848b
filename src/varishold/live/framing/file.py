"""The framing file: a framing written down in TOML."""

from __future__ import annotations

import os
import re
from typing import Any, Literal, cast

from varishold.errors import FormatError, InputError
from varishold.files import read_toml
from varishold.frame import as_pitch
from varishold.live.framing.checksums import CHECKSUMS, Checksum
from varishold.live.framing.model import Escape, Framing, Number, Packet, PadValues, Whose
from varishold.live.framing.table import Entries
from varishold.live.sample import UNNAMED_PAD, PadLayout

__all__ = ["read_framing"]

_PAD = ("dtype", "endian", "shape", "order", "kind", "names", "unit", "polarity", "pitch_m")
_PACKET = ("head", "skip", "extra", "checksum", "tail")
_WHOLE = ("name", "notes", "third_party", "baud", "start", "request", "text", "escape", "time", "sequence", "whose")
_KEYS = (*_WHOLE, *_PAD, *_PACKET, "pads", "packets")
# A text has neither bytes nor packets.
_BINARY = ("endian", "head", "extra", "checksum", "tail", "escape", "packets", "pads", "whose")


def read_framing(path: str | os.PathLike[str]) -> Framing:
    """Read a framing file.

    Parameters
    ----------
    path : str or path-like
        A TOML file; its keys are those of `Framing`, `Packet` and `PadValues`, and stand in ``docs/live.md``.

    Returns
    -------
    Framing

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If an entry is unknown or impossible; the message names file, key and what would be right.
    """
    where = os.fspath(path)
    entries = Entries(where, read_toml(path), _KEYS)
    text = entries.choice("text", ("rows", "line")) if "text" in entries else None
    if text is not None and (stray := [key for key in _BINARY if key in entries]):
        raise FormatError(f"{where}: a text has no {', '.join(stray)}")
    endian = entries.choice("endian", ("little", "big"), "little")
    pads = _pads(entries, endian, in_text=text is not None)
    if text == "rows" and pads[0].layout.kind == "signals":
        raise FormatError(f'{where}: signals come in one line a frame: text = "line"')
    packets = () if text is not None else _packets(entries, pads, endian)
    try:
        return Framing(
            pads,
            packets,
            escape=_escape(entries) if "escape" in entries else None,
            text=cast(Literal["rows", "line"] | None, text),
            skip=entries.whole("skip", 0) if text is not None else 0,
            time=_number(entries, "time", endian, in_text=text is not None),
            sequence=_number(entries, "sequence", endian, in_text=text is not None),
            whose=_whose(entries) if "whose" in entries else None,
            baud=entries.whole("baud", 115200, least=50, most=100_000_000),
            start=entries.fixed("start"),
            request=entries.fixed("request"),
            name=entries.text("name"),
            notes=entries.text("notes"),
            third_party=entries.truth("third_party"),
            source=where,
        )
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{where}: {error}") from error


def _pads(entries: Entries, endian: str, *, in_text: bool) -> tuple[PadValues, ...]:
    listed = entries.raw("pads")
    if listed is None:
        return (_pad(entries, UNNAMED_PAD, endian, in_text=in_text),)
    if stray := [key for key in _PAD if key in entries and key != "endian"]:
        raise FormatError(f"{entries.path}: {', '.join(stray)} must stand in each of [[pads]]")
    made = []
    for number, table in enumerate(_tables(entries, "pads")):
        one = Entries(f"{entries.path}: pad {number}", table, ("name", *_PAD))
        name = one.text("name", UNNAMED_PAD)
        if not name.strip() or not name.isprintable():
            raise one.wrong("name", "printable text")
        made.append(_pad(one, name, one.choice("endian", ("little", "big"), endian), in_text=False))
    return tuple(made)


def _pad(entries: Entries, name: str, endian: str, *, in_text: bool) -> PadValues:
    dtype = entries.dtype("dtype", endian, "float64" if in_text else None)
    shape = entries.shape("shape")
    if shape is None and not in_text:
        raise entries.wrong("shape", "[rows, columns]")
    kind = cast(Literal["pressure", "signals"], entries.choice("kind", ("pressure", "signals"), "pressure"))
    names = entries.names("names")
    if shape is not None and len(names) not in (0, shape[1], shape[0] * shape[1]):
        raise entries.wrong("names", f"{shape[0] * shape[1]} names, or {shape[1]} for each of {shape[0]} rows")
    if names and kind == "pressure":
        raise entries.wrong("names", 'for signals only, kind = "signals"')
    polarity = cast(Literal["up", "down"], entries.choice("polarity", ("up", "down"), "up"))
    layout = PadLayout((), kind, _pitch(entries), entries.text("unit", "raw"), polarity)
    by_columns = entries.choice("order", ("rows", "columns"), "rows") == "columns"
    pad = PadValues(dtype, layout, name, by_columns, names)
    return pad if shape is None else pad.with_shape(shape)


def _pitch(entries: Entries) -> tuple[float, float] | None:
    try:
        return None if "pitch_m" not in entries else as_pitch(entries.raw("pitch_m"))
    except InputError as error:
        raise FormatError(f"{entries.path}: {error}") from error


def _packets(entries: Entries, pads: tuple[PadValues, ...], endian: str) -> tuple[Packet, ...]:
    if "packets" not in entries:
        return (_packet(entries, sum(pad.count * pad.dtype.itemsize for pad in pads), endian),)
    if stray := [key for key in (*_PACKET, "escape") if key in entries]:
        raise FormatError(f"{entries.path}: {', '.join(stray)} cannot stand beside [[packets]]; write it in each")
    made = []
    for number, table in enumerate(_tables(entries, "packets")):
        one = Entries(f"{entries.path}: packet {number}", table, (*_PACKET, "bytes"))
        made.append(_packet(one, one.whole("bytes"), endian))
    return tuple(made)


def _packet(entries: Entries, values: int, endian: str) -> Packet:
    escaped = "escape" in entries
    return Packet(
        values,
        () if escaped else entries.pattern("head"),
        () if escaped else entries.pattern("tail"),
        entries.whole("skip", 0),
        entries.whole("extra", 0),
        _checksum(entries, endian) if "checksum" in entries else None,
    )


def _checksum(entries: Entries, endian: str) -> Checksum:
    given = entries.raw("checksum")
    table = {"kind": given} if isinstance(given, str) else given
    one = Entries(f"{entries.path}: checksum", table, ("kind", "from", "endian"))
    order = cast(Literal["little", "big"], one.choice("endian", ("little", "big"), endian))
    return Checksum(one.choice("kind", tuple(CHECKSUMS)), one.whole("from", 0, most=255), order)


def _escape(entries: Entries) -> Escape:
    ends = []
    for key in ("head", "tail"):
        fixed = entries.fixed(key)
        if len(fixed) > 1:
            raise entries.wrong(key, "one byte, where there is an escape")
        ends.append(fixed[0] if fixed else None)
    table = entries.raw("escape")
    pairs = {}
    for key, value in table.items() if isinstance(table, dict) else ():
        pair, meant = "".join(key.split()), "".join(value.split()) if isinstance(value, str) else ""
        if not re.fullmatch(r"[0-9A-Fa-f]{4}", pair) or not re.fullmatch(r"[0-9A-Fa-f]{2}", meant):
            raise FormatError(f'{entries.path}: escape must be as in "5C 01" = "5B", got {key!r} = {value!r}')
        pairs[bytes.fromhex(pair)] = bytes.fromhex(meant)[0]
    marks = {pair[0] for pair in pairs}
    if len(marks) != 1:
        raise FormatError(f'{entries.path}: [escape] needs pairs that begin with one byte, as in "5C 01" = "5B"')
    mark = marks.pop()
    if ends == [None, None]:
        raise FormatError(f"{entries.path}: [escape] needs a head or a tail of one byte")
    for byte in {byte for byte in (*ends, mark) if byte is not None}:
        if byte not in pairs.values():
            raise FormatError(f"{entries.path}: escape does not say how {byte:02X} itself is sent")
    if {pair[1] for pair in pairs} & set(ends):
        raise FormatError(f"{entries.path}: what escape sends must not be head or tail")
    return Escape(mark, {pair[1]: meant for pair, meant in pairs.items()}, ends[0], ends[1])


def _number(entries: Entries, key: str, endian: str, *, in_text: bool) -> Number | None:
    if key not in entries:
        return None
    known = ("at",) if in_text else ("at", "dtype", "endian")
    one = Entries(f"{entries.path}: {key}", entries.raw(key), (*known, "unit_s") if key == "time" else known)
    dtype = one.dtype("dtype", one.choice("endian", ("little", "big"), endian), "float64" if in_text else None)
    if key == "sequence" and dtype.kind == "f" and not in_text:
        raise one.wrong("dtype", "of whole numbers")
    return Number(one.whole("at"), dtype, one.number("unit_s", 1.0, least=1e-12, most=1e6))


def _whose(entries: Entries) -> Whose:
    table = entries.raw("whose")
    if not isinstance(table, dict):
        raise entries.wrong("whose", "a table")
    names = {}
    for key, value in table.items():
        if key == "at":
            continue
        if not re.fullmatch(r"[0-9A-Fa-f]{2}", key) or not isinstance(value, str) or not value.isprintable():
            raise FormatError(f'{entries.path}: whose must be as in "01" = "left", got {key!r} = {value!r}')
        names[int(key, 16)] = value
    if not names or len(set(names.values())) < len(names):
        raise FormatError(f'{entries.path}: whose needs names that differ, as in "01" = "left"')
    return Whose(Entries(f"{entries.path}: whose", {"at": table.get("at")}, ("at",)).whole("at"), names)


def _tables(entries: Entries, key: str) -> list[Any]:
    listed = entries.raw(key)
    if not isinstance(listed, list) or not 1 <= len(listed) <= 64:
        raise entries.wrong(key, f"tables [[{key}]], 1 to 64")
    return listed
