"""What things are called: one rule for labels, sessions and objects, wherever they come from."""

from __future__ import annotations

from varishold.errors import InputError

__all__ = ["NONE_OF_THESE", "plain_name", "refuse_name_of_strangers"]

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


def refuse_name_of_strangers(kept: str, what: str = "thing", *, place: str = "", parameter: str | None = None) -> None:
    """Refuse to call something what strangers are called.

    Parameters
    ----------
    kept : str
        The name as it is kept.
    what : str
        What would be called so.
    place : str
        Opens the message, as in "press 3: ".
    parameter : str, optional
        The parameter that would mend it.

    Raises
    ------
    InputError
        If it is `NONE_OF_THESE`.

    Examples
    --------
    >>> refuse_name_of_strangers("ball")
    >>> refuse_name_of_strangers("none of these")
    Traceback (most recent call last):
    ...
    varishold.errors.InputError: no thing can be called 'none of these', which is said of strangers; choose another name
    """
    if kept == NONE_OF_THESE:
        message = f"{place}no {what} can be called {kept!r}, which is said of strangers; choose another name"
        raise InputError(message, parameter=parameter)
