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

from varishold.errors import FormatError, InputError, reason_of

__all__ = [
    "LARGEST_BYTES",
    "PlainText",
    "encoding_notes",
    "encoding_of",
    "head_lines",
    "open_file",
    "read_bytes",
    "text_chunks",
]

#: Most bytes that are taken into memory at once, from a file or unpacked from one. A million frames of 16 x 16
#: float64 are half of it; whoever has more stores NPY, which is mapped and not loaded.
LARGEST_BYTES = 1 << 32
# Longest line that is read, in characters: a frame of 1000 x 1000 numbers still fits.
_LONGEST_LINE = 1 << 24
# Never waiting for a pipe's writer, and bytes as they are; each has its flag where the system needs one.
_READING = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
# Bytes that are read at a time.
_BLOCK = 1 << 22
# Each byte stays a character of its own: what differs in the file differs when it is read.
_CP1252 = "varishold.cp1252"
# The mark of UTF-32 begins with that of UTF-16.
_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_LONGEST_MARK = max(len(mark) for mark, _ in _MARKS)
# What a path may be that is no regular file, by the test that tells.
_KINDS = (
    (stat.S_ISDIR, "is a folder; name a file in it"),
    (
        stat.S_ISFIFO,
        "is a pipe; save what comes out of it to a file; recordings and tables are read as standard input (-) too",
    ),
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
    return InputError(f"{path}: cannot be read: {reason_of(error)}")


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

    UTF-8, or UTF-16 or UTF-32 with a byte order mark. Bytes that are no UTF-8 are read as cp1252, as spreadsheets on
    Windows save it, which `encoding_notes` tells. Lines end in LF, CR LF or CR, and are given without their end.

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
        encoding, skipped = encoding_of(file.read(_LONGEST_MARK))
        file.seek(skipped)
        decoder = codecs.getincrementaldecoder(encoding)(errors=_CP1252 if encoding == "utf-8" else "strict")
        line, rest = 1, ""
        while True:
            try:
                data = file.read(block)
            except OSError as error:
                raise _cannot_read(path, error) from error
            try:
                text = rest + decoder.decode(data, final=not data)
            except UnicodeDecodeError as error:
                raise _no_text(path, line, encoding, error) from None
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


class PlainText:
    """Makes UTF-8 whose lines end in LF of a text that comes in pieces, encoded and ended as `text_chunks` takes it.

    Bytes that are no UTF-8 stay as they are.

    Examples
    --------
    >>> plain, came = PlainText(), "1 2\\r\\n3".encode("utf-16")
    >>> b"".join(plain.feed(came[at : at + 1]) for at in range(len(came)))
    b'1 2\\n3'
    """

    def __init__(self) -> None:
        self._head: bytes | None = b""
        self._decoder: codecs.IncrementalDecoder | None = None
        self._after_cr = False

    def feed(self, data: bytes) -> bytes:
        """Return what the next bytes are; what a later one decides waits for it."""
        if self._head is not None:
            data = self._head + data
            if any(mark.startswith(data) and mark != data for mark, _ in _MARKS):
                self._head = data
                return b""
            self._head = None
            encoding, skipped = encoding_of(data)
            data = data[skipped:]
            if encoding != "utf-8":
                self._decoder = codecs.getincrementaldecoder(encoding)(errors="replace")
        if self._decoder is not None:
            data = self._decoder.decode(data).encode("utf-8", "replace")
        if data:
            # Of a CR LF the first half has ended the line.
            ended = self._after_cr and data.startswith(b"\n")
            self._after_cr = data.endswith(b"\r")
            data = data[ended:].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        return data


def head_lines(head: bytes) -> list[str]:
    """Return the lines of a file's first bytes as `text_chunks` reads them; what is no text is replaced.

    Examples
    --------
    >>> head_lines("a;b\\n1;2".encode("utf-16"))
    ['a;b', '1;2']
    """
    encoding, skipped = encoding_of(head)
    return head[skipped:].decode(encoding, "replace").splitlines()


def encoding_notes(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Return in words where a text is no UTF-8 and was read as cp1252 by `text_chunks`; empty where it is none."""
    with open_file(path) as file:
        encoding, skipped = encoding_of(file.read(_LONGEST_MARK))
        if encoding != "utf-8":
            return ()
        file.seek(skipped)
        decoder, line = codecs.getincrementaldecoder(encoding)(), 1
        while True:
            data = file.read(_BLOCK)
            try:
                decoder.decode(data, final=not data)
            except UnicodeDecodeError as error:
                place, byte = _place(line, error)
                return (
                    f"line {place} is no UTF-8 text (byte 0x{byte:02x}): read as cp1252, as Windows saves it; "
                    "where a name looks wrong, save the file as UTF-8",
                )
            line += _line_ends(data)
            if not data:
                return ()


def encoding_of(head: bytes) -> tuple[str, int]:
    """Return how a text is encoded, and how many bytes of it are the mark that says so."""
    return next(((name, len(mark)) for mark, name in _MARKS if head.startswith(mark)), ("utf-8", 0))


def _as_cp1252(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeDecodeError)
    try:
        return error.object[error.start : error.end].decode("cp1252"), error.end
    except UnicodeDecodeError:
        # The first error knows the place in the file.
        raise error from None


codecs.register_error(_CP1252, _as_cp1252)


def _no_text(path: str | os.PathLike[str], line: int, encoding: str, error: UnicodeDecodeError) -> FormatError:
    known = "UTF-8 and no cp1252" if encoding == "utf-8" else encoding[: len("utf-16")].upper()
    place, byte = _place(line, error)
    return FormatError(f"{path}: line {place} is no {known} text: byte 0x{byte:02x}; save it as UTF-8")


def _place(line: int, error: UnicodeDecodeError) -> tuple[int, int]:
    """Return the line of a byte that is none of its encoding, and that byte; `line` is the first that was decoded."""
    return line + _line_ends(error.object[: error.start]), error.object[error.start]


def _line_ends(data: bytes) -> int:
    return max(data.count(b"\n"), data.count(b"\r"))
