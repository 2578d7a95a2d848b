"""Dates in a time column of CSV: ``2026-11-29T10:03:04.5``, as ISO 8601 and data frames write them."""

from __future__ import annotations

import re
from datetime import UTC, datetime

__all__ = ["date_at", "date_seconds"]

# A day and a time of day with seconds, perhaps beside another zone than UTC.
_DATE = re.compile(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(?:[.,](\d{1,9}))?(Z|[+-]\d\d(?::?\d\d)?)?")
# What stands before a cell, by the cell's number.
_BEFORE = tuple(re.compile(rf"\s*(?:[^,;\t ]*[,;\t ]\s*){{{k}}}\"?") for k in (0, 1))
_BEHIND = re.compile(r"\"?(?=\s*[,;\t]|\s*$|\s+[-+.\d])")
# What stands behind a date that has a comma in it, where the comma separates no cells.
_NO_COMMA = re.compile(r"\"|\s*[;\t]|\s+[-+.\d]")


def date_seconds(cell: str) -> float | None:
    """Return the seconds since 1970 in UTC of a date and time of day; None where it is none.

    Where no zone is said it is UTC.

    Examples
    --------
    >>> date_seconds("1970-01-01T00:01:00.25Z"), date_seconds("1970-01-01 02:00:00+02:00"), date_seconds("1970-01-01")
    (60.25, 0.0, None)
    >>> date_seconds("1970-01-01 00:00:07,125")
    7.125
    """
    found = _DATE.fullmatch(cell.strip().strip("\"'"))
    number = None if found is None else _number(found)
    return None if number is None else float(number)


def date_at(line: str, cell: int) -> tuple[int, str, int] | None:
    """Return where in a line of CSV its first or second cell begins and ends if it is a date, and its seconds as text.

    A comma in it is a decimal sign where the cell is in quotes, or something else separates.

    Parameters
    ----------
    line : str
    cell : {0, 1}

    Returns
    -------
    (int, str, int) or None
        Beginning, seconds without a decimal sign, end; quotes around the cell are within.
    """
    before = _BEFORE[cell].match(line)
    found = None if before is None else _DATE.match(line, before.end())
    if found is not None and "," in found[0] and not _NO_COMMA.match(line, found.end()):
        found = _DATE.match(line, found.start(), line.index(",", found.start()))
    behind = None if found is None else _BEHIND.match(line, found.end())
    number = None if found is None else _number(found)
    if before is None or behind is None or number is None:
        return None
    quoted = before[0].endswith('"')
    return before.end() - quoted, number, behind.end()


def _number(found: re.Match[str]) -> str | None:
    """Return seconds since 1970 as a text that no decimal sign is in."""
    day, time, fraction, zone = found.groups()
    try:
        when = datetime.fromisoformat(f"{day}T{time}{zone or ''}")
    except ValueError:
        return None
    whole = round((when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp())
    return f"{whole * 10**9 + int((fraction or '0').ljust(9, '0'))}e-9"
