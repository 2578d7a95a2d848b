"""Opening a user's file, and reading text from it in pieces of bounded size."""

from __future__ import annotations

import codecs
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from varishold.errors import FormatError, InputError

__all__ = ["open_file", "text_chunks"]

#: Longest line that is read, in characters: a frame of 1000 x 1000 numbers still fits.
LONGEST_LINE = 1 << 24
# Bytes that are read at a time.
_BLOCK = 1 << 22
_MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))


def open_file(path: str | os.PathLike[str]) -> BinaryIO:
    """Open a file for reading bytes; what cannot be opened is told in one line.

    Parameters
    ----------
    path : str or path-like
        A regular file. Pipes and devices are refused, because a reader that waits for one waits forever.

    Raises
    ------
    InputError
        If there is no such file, it is a folder or no regular file, or it may not be read.
    """
    try:
        mode = os.stat(path).st_mode
        if stat.S_ISDIR(mode):
            raise InputError(f"{path}: is a folder; name a file in it")
        if not stat.S_ISREG(mode):
            raise InputError(f"{path}: is no regular file; save what comes out of it to a file first")
        return Path(path).open("rb")
    except FileNotFoundError as error:
        raise InputError(f"{path}: there is no such file") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {(error.strerror or str(error)).lower()}") from error
    except ValueError as error:
        raise InputError(f"{str(path)!r}: is no file name: {error}") from error


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
                raise InputError(f"{path}: cannot be read: {(error.strerror or str(error)).lower()}") from error
            text = rest + decoder.decode(data, final=not data)
            if "\0" in text:
                raise FormatError(f"{path}: is no text: a NUL byte stands in or after line {line}")
            # A CR at the end may be the first half of a CR LF.
            held = "\r" if data and text.endswith("\r") else ""
            text = text[: len(text) - len(held)].replace("\r\n", "\n").replace("\r", "\n")
            lines = text.split("\n")
            rest = lines.pop() + held
            if len(rest) > LONGEST_LINE or any(len(each) > LONGEST_LINE for each in lines):
                raise FormatError(f"{path}: a line after line {line} is longer than {LONGEST_LINE} characters")
            if lines:
                yield line, lines
                line += len(lines)
            if not data:
                if rest:
                    yield line, [rest]
                return
