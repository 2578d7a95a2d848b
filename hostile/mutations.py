"""Ways to spoil a file: bytes, numbers, members of archives, headers of arrays, parts of documents."""

from __future__ import annotations

import io
import json
import re
import struct
import warnings
import zipfile
import zlib
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import zstandard

__all__ = ["mutated"]

# How an MCAP file begins, and two kinds of its records.
_MCAP, _CHUNK, _DATA_END = b"\x89MCAP0\r\n", 6, 15
# Containers in which numbers stand as bytes.
_BINARY = (b"\x89HDF", b"MATLAB", b"PAR1", b"SQLite", b"#ROSBAG", b"II*\0", b"MM\0*")
_PNG = b"\x89PNG\r\n\x1a\n"
_NUMBER = re.compile(rb"-?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?")
_NASTY = (
    *(
        b"nan",
        b"inf",
        b"-inf",
        b"1e999",
        b"-1e-400",
        b"-0",
        b"-1",
        b"0",
        b"1_0",
        b"0x10",
        b"1.5.2",
        b"1,5",
        b"",
        b"True",
    ),
    *(
        b"9" * 19,
        b"9" * 400,
        b"9" * 5000,
        b"4294967296",
        b"-2147483649",
        b"\xd9\xa3",
        b'"',
        b"[]",
        b"{}",
        b"null",
        b"\\ud800",
    ),
    *(b" " * 3000, b";", b"\t", b"\0", b"\r", b"\x1b[2J", b"=1+1", b"#", b"'" * 3, b"[" * 200, b"1" + b"0" * 30),
)
_VALUES: tuple[Any, ...] = (
    *(None, True, -1, 0, 1, 2**31, 2**63, 10**400, 1.5, -1e308, 1e-320, "", "x", "\ud800", "\x1b[31m", [], {}, [[]]),
    *([0], [1, 2, 3], [[0, 1]], {"a": 1}, [None] * 5, "0" * 300, ["\x00"]),
)
_HEADERS = (
    (rb"\((\d+)", (b"(99999999999999", b"(-1", b"(0", b"(1", b"(" + b"9" * 500, b"((", b"(1e3")),
    (
        rb"'<?[a-zA-Z]\d*'",
        (b"'|O'", b"'<f8'", b"'<i8'", b"'<c16'", b"'<U9'", b"'|S3'", b"'|b1'", b"'>f4'", b"'<M8[s]'", b"'|V8'"),
    ),
    (rb"True|False", (b"True", b"False", b"None", b"1")),
    (rb"descr|shape|fortran_order", (b"desc", b"shape", b"descr", b"fortran")),
)


def mutated(rng: np.random.Generator, content: bytes, others: Sequence[bytes]) -> bytes:
    """Return a spoilt copy of a file's content; `others` are files to splice in."""
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        ways: list[Callable[[], bytes]] = [lambda c=content: _bytes(rng, c, others)] * 2  # type: ignore[misc]
        if content.startswith(b"PK"):
            ways += [lambda c=content: _members(rng, c, others)] * 4  # type: ignore[misc]
        elif content.startswith(b"\x93NUMPY"):
            ways += [lambda c=content: _header(rng, c)] * 3  # type: ignore[misc]
        elif content.startswith(_MCAP):
            ways += [lambda c=content: _chunk(rng, c, others)] * 4  # type: ignore[misc]
        elif content.startswith(_PNG):
            ways += [lambda c=content: _picture(rng, c, others)] * 4  # type: ignore[misc]
        elif not content.startswith(_BINARY):
            ways += [lambda c=content: _numbers(rng, c), lambda c=content: _lines(rng, c)] * 2  # type: ignore[misc]
        if content.lstrip()[:1] == b"{":
            ways += [lambda c=content: _document(rng, c)] * 4  # type: ignore[misc]
        content = ways[int(rng.integers(len(ways)))]()
    return content


def _place(rng: np.random.Generator, content: bytes) -> int:
    """A position; the ends, where headers and directories stand, are likelier."""
    n = len(content)
    if n and rng.random() < 0.4:
        near = int(rng.integers(min(n, 160)))
        return near if rng.random() < 0.5 else n - 1 - near
    return int(rng.integers(n)) if n else 0


def _bytes(rng: np.random.Generator, content: bytes, others: Sequence[bytes]) -> bytes:
    data, at = bytearray(content), _place(rng, content)
    end = min(len(data), at + int(2 ** rng.uniform(0, 10)))
    way = int(rng.integers(8))
    if way == 0 and data:
        for _ in range(int(rng.integers(1, 9))):
            data[_place(rng, content)] ^= 1 << int(rng.integers(8))
    elif way == 1 and data:
        data[at] = int(rng.integers(256))
    elif way == 2:
        del data[at:]
    elif way == 3:
        del data[at:end]
    elif way == 4:
        data[at:at] = data[at:end] * int(rng.choice([1, 2, 40]))
    elif way == 5:
        data[at:at] = rng.bytes(end - at)
    elif way == 6:
        other = others[int(rng.integers(len(others)))]
        data[at:] = other[_place(rng, other) :]
    else:
        data[at:end] = bytes([int(rng.choice([0, 32, 255, 10, 44]))]) * (end - at)
    return bytes(data)


def _numbers(rng: np.random.Generator, content: bytes) -> bytes:
    found = list(_NUMBER.finditer(content))
    if not found:
        return content
    for match in sorted(
        (found[k] for k in rng.integers(len(found), size=int(rng.choice([1, 1, 3])))), key=lambda m: -m.start()
    ):
        content = content[: match.start()] + _NASTY[int(rng.integers(len(_NASTY)))] + content[match.end() :]
    return content


def _lines(rng: np.random.Generator, content: bytes) -> bytes:
    lines = content.split(b"\n")
    a, b = (int(k) for k in rng.integers(len(lines), size=2))
    way = int(rng.integers(5))
    if way == 0:
        del lines[a]
    elif way == 1:
        lines.insert(a, lines[b])
    elif way == 2:
        lines[a], lines[b] = lines[b], lines[a]
    elif way == 3:
        lines[a] = lines[a].replace(b",", bytes([int(rng.choice(list(b";\t .,|")))]))
    else:
        lines.insert(a, _NASTY[int(rng.integers(len(_NASTY)))])
    return b"\n".join(lines)


def _header(rng: np.random.Generator, content: bytes) -> bytes:
    pattern, values = _HEADERS[int(rng.integers(len(_HEADERS)))]
    value = values[int(rng.integers(len(values)))]
    head, rest = content[:128], content[128:]
    new = re.sub(pattern, lambda _: value, head, count=1)
    if rng.random() < 0.7:
        # The same length, padded or cut before the line's end, so that the header is still read.
        new = new[:127].rstrip(b"\n").ljust(127) + b"\n" if len(new) != len(head) else new
    return new + rest


def _members(rng: np.random.Generator, content: bytes, others: Sequence[bytes]) -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = [(info.filename, archive.read(info)) for info in archive.infolist()]
    except Exception:
        return _bytes(rng, content, others)
    if not members:
        return content
    k = int(rng.integers(len(members)))
    name, data = members[k]
    way = int(rng.integers(7))
    if way == 0:
        del members[k]
    elif way == 1:
        members.append((name, members[int(rng.integers(len(members)))][1]))
    elif way == 2:
        members[k] = (
            str(rng.choice(["pressure.npy", "x.npy", "pressure.\x1b.npy", "valid.npy", "head.npy", "../a.npy"])),
            data,
        )
    elif way == 3:
        members[k] = (name, _bytes(rng, data, others))
    elif way == 4:
        members[k] = (name, data + rng.bytes(int(rng.integers(1, 20))))
    elif way == 5:
        members[k] = (name, members[int(rng.integers(len(members)))][1])
    else:
        members[k] = (name, _header(rng, data))
    made = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        # bzip2, which no reader takes, is slow to write.
        method = int(rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2], p=[0.45, 0.5, 0.05]))
        with zipfile.ZipFile(made, "w", method) as archive:
            for member, held in members:
                archive.writestr(member, held)
    return made.getvalue()


def _chunk(rng: np.random.Generator, content: bytes, others: Sequence[bytes]) -> bytes:
    """Spoil what is in the chunks of an MCAP file, and leave them well packed and without checksums."""
    made, at = [_MCAP], len(_MCAP)
    while at + 9 <= len(content):
        kind, length = struct.unpack_from("<BQ", content, at)
        body = content[at + 9 : at + 9 + length]
        at += 9 + length
        if kind == _CHUNK and rng.random() < 0.7:
            try:
                start, packing = body[:16], struct.unpack_from("<I", body, 28)[0]
                inner = zstandard.decompress(body[40 + packing :], 1 << 24)
            except (struct.error, zstandard.ZstdError, MemoryError):
                return _bytes(rng, content, others)
            inner = _bytes(rng, inner, others)
            data = zstandard.compress(inner, 1)
            body = start + struct.pack("<QII", len(inner), 0, 4) + b"zstd" + struct.pack("<Q", len(data)) + data
        elif kind == _DATA_END:
            body = bytes(4)
        made.append(struct.pack("<BQ", kind, len(body)) + body)
    return b"".join(made) + content[at:]


def _picture(rng: np.random.Generator, content: bytes, others: Sequence[bytes]) -> bytes:
    """Spoil what is in the parts of a picture, and leave their checksums right."""
    made, at = [_PNG], len(_PNG)
    while at + 12 <= len(content):
        (length,) = struct.unpack_from(">I", content, at)
        name, body = content[at + 4 : at + 8], content[at + 8 : at + 8 + length]
        at += 12 + length
        if rng.random() < 0.5:
            if name == b"IDAT" and rng.random() < 0.5:
                try:
                    body = zlib.compress(_bytes(rng, zlib.decompress(body), others), 1)
                except zlib.error:
                    body = _bytes(rng, body, others)
            else:
                body = _bytes(rng, body, others)
        made.append(struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body)))
    return b"".join(made) + content[at:]


def _document(rng: np.random.Generator, content: bytes) -> bytes:
    try:
        document = json.loads(content)
    except (ValueError, RecursionError):
        return _numbers(rng, content)
    parent: Any = document
    for _ in range(int(rng.integers(0, 5))):
        inner = list(parent.values()) if isinstance(parent, dict) else list(parent)
        inner = [each for each in inner if isinstance(each, dict | list) and each]
        if not inner:
            break
        parent = inner[int(rng.integers(len(inner)))]
    keys = list(parent) if isinstance(parent, dict) else list(range(len(parent)))
    if not keys:
        return content
    key = keys[int(rng.integers(len(keys)))]
    way = int(rng.integers(4))
    if way == 0:
        del parent[key]
    elif way == 1:
        parent[key] = [parent[key]]
    elif way == 2 and isinstance(parent, list):
        parent.append(parent[key])
    else:
        parent[key] = _VALUES[int(rng.integers(len(_VALUES)))]
    return json.dumps(document).encode()
