"""What things are called: one rule for labels, sessions and objects, wherever they come from."""

from __future__ import annotations

__all__ = ["NONE_OF_THESE", "plain_name"]

#: What strangers are called; no thing and no object can be called so.
NONE_OF_THESE = "none of these"


def plain_name(name: object) -> str | None:
    """Return a name as it is kept, without spaces at its ends; None where it is no text, empty or not printable.

    Examples
    --------
    >>> plain_name("ball "), plain_name("a\\nb"), plain_name(" ")
    ('ball', None, None)
    """
    kept = name.strip() if isinstance(name, str) else ""
    return str(kept) if kept and kept.isprintable() else None
