"""Opening what a user names, and reading text from it in pieces of bounded size."""

from __future__ import annotations

import codecs
import io
import os
import stat
import sys
from collections.abc import Iterator
from functools import cache
from typing import BinaryIO

from varishold.errors import FormatError, InputError

__all__ = ["LARGEST_BYTES", "open_file", "read_bytes", "text_chunks"]

#: Most bytes that are taken into memory at once, from a file or unpacked from one. A million frames of 16 x 16
#: float64 are half of it; whoever has more stores NPY, which is mapped and not loaded.
LARGEST_BYTES = 1 << 32
# Longest line that is read, in characters: a frame of 1000 x 1000 numbers still fits.
_LONGEST_LINE = 1 << 24
# Never waiting for a pipe's writer, and bytes as they are; each has its flag where the system needs one.
_READING = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
# Bytes that are read at a time.
_BLOCK = 1 << 22
_MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))
# What a path may be that is no regular file, by the test that tells.
_KINDS = (
    (stat.S_ISDIR, "is a folder; name a file in it"),
    (stat.S_ISFIFO, "is a pipe; save what comes out of it to a file, or give it as standard input (-)"),
    (stat.S_ISSOCK, "is a socket; save what comes out of it to a file first"),
    (lambda mode: not stat.S_ISREG(mode), "is a device; save what comes out of it to a file first"),
)


def open_file(path: str | os.PathLike[str]) -> BinaryIO:
    """Open a file for reading bytes; what cannot be opened is told in one line.

    Parameters
    ----------
    path : str or path-like
        A regular file, or ``-`` for standard input. Pipes and devices are refused, because a reader that waits for
        one waits forever.

    Raises
    ------
    InputError
        If there is no such file, it is a folder or no regular file, or it may not be read.
    """
    if os.fspath(path) == "-":
        return io.BytesIO(_standard_input())
    try:
        # Before it is opened, which may do something to a device, and after, when nobody can change it any more.
        _check_regular(path, os.stat(path).st_mode)
        handle = os.open(path, _READING)
        try:
            _check_regular(path, os.fstat(handle).st_mode)
        except InputError:
            os.close(handle)
            raise
        return os.fdopen(handle, "rb")
    except FileNotFoundError as error:
        raise InputError(f"{path}: there is no such file") from error
    except OSError as error:
        raise _cannot_read(path, error) from error
    except (ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{str(path)!r}: is no file name: {error}") from error


def _check_regular(path: str | os.PathLike[str], mode: int) -> None:
    for is_kind, advice in _KINDS:
        if is_kind(mode):
            raise InputError(f"{path}: {advice}")


def _cannot_read(path: str | os.PathLike[str], error: OSError) -> InputError:
    return InputError(f"{path}: cannot be read: {(error.strerror or str(error)).lower()}")


@cache
def _standard_input() -> bytes:
    """All of standard input: a reader may have to begin again, which a pipe cannot."""
    if sys.stdin is None:
        raise InputError("-: standard input is closed")
    try:
        content = sys.stdin.buffer.read(LARGEST_BYTES + 1)
    except OSError as error:
        raise _cannot_read("-", error) from error
    if len(content) > LARGEST_BYTES:
        raise InputError(f"-: more than {LARGEST_BYTES} bytes on standard input; save them to a file")
    return content


def read_bytes(path: str | os.PathLike[str], *, most: int) -> bytes:
    """Return all bytes of a file that should hold at most `most`.

    Raises
    ------
    InputError
        As `open_file`.
    FormatError
        If it holds more.
    """
    with open_file(path) as file:
        try:
            content = file.read(most + 1)
        except OSError as error:
            raise _cannot_read(path, error) from error
    if len(content) > most:
        raise FormatError(f"{path}: is larger than {most >> 20} MiB; such a file is never so large")
    return content


def text_chunks(path: str | os.PathLike[str], *, block: int = _BLOCK) -> Iterator[tuple[int, list[str]]]:
    """Yield the lines of a text file in chunks, each with the number of its first line (from 1).

    UTF-8, or UTF-16 with a byte order mark; bytes that are neither become U+FFFD, which no number contains.
    Lines end in LF, CR LF or CR, and are given without their end.

    Parameters
    ----------
    path : str or path-like
        The file.
    block : int
        Bytes read at a time, which bounds the memory used.

    Raises
    ------
    InputError
        As `open_file`.
    FormatError
        If the file is no text, or a line has more than 2 ** 24 characters.
    """
    with open_file(path) as file:
        head = file.read(4)
        encoding, skipped = next(((e, len(m)) for m, e in _MARKS if head.startswith(m)), ("utf-8", 0))
        file.seek(skipped)
        decoder = codecs.getincrementaldecoder(encoding)(errors="replace")
        line, rest = 1, ""
        while True:
            try:
                data = file.read(block)
            except OSError as error:
                raise _cannot_read(path, error) from error
            text = rest + decoder.decode(data, final=not data)
            if "\0" in text:
                raise FormatError(f"{path}: is no text: a NUL byte stands in or after line {line}")
            # A CR at the end may be the first half of a CR LF.
            held = "\r" if data and text.endswith("\r") else ""
            text = text[: len(text) - len(held)].replace("\r\n", "\n").replace("\r", "\n")
            lines = text.split("\n")
            rest = lines.pop() + held
            if len(rest) > _LONGEST_LINE or any(len(each) > _LONGEST_LINE for each in lines):
                raise FormatError(f"{path}: line {line} or one after it is longer than {_LONGEST_LINE} characters")
            if lines:
                yield line, lines
                line += len(lines)
            if not data:
                if rest:
                    yield line, [rest]
                return
