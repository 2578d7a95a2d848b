"""Every error that the package raises on purpose.

::

    VarisholdError
    ├── InputError (ValueError)          a value that cannot be used, and where it stands
    │   └── FormatError                  a file that cannot be read as what it claims to be
    ├── MissingExtraError (ImportError)  an optional dependency that is not installed
    ├── MissingKernelError (ImportError) the compiled kernel is not there, or not this machine's
    ├── NotConvergedError (ArithmeticError)  a numerical method that stopped short of its tolerance
    ├── LostSourceError (ConnectionError)  a live source that is not there, or no more; it may come back
    └── EndOfSourceError (EOFError)      a live source that has no more

`Interrupted` is none of them: a command that is to end.

Each leaf also inherits the builtin that it replaces, so that code which knows nothing of this
package can catch it. A message says what was got, where, and what would be right, in one line.
"""

from __future__ import annotations

import errno

__all__ = [
    "FULL_DISK",
    "EndOfSourceError",
    "FormatError",
    "InputError",
    "Interrupted",
    "LostSourceError",
    "MissingExtraError",
    "MissingKernelError",
    "NotConvergedError",
    "VarisholdError",
    "reason_of",
    "require",
    "require_a",
]


#: Numbers of the system's errors where a disk, or a person's share of it, is full.
FULL_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)

# Longer messages lose their middle: where it is stands at the start, what is wrong at the end.
_LONGEST = 2000
_LINE_ENDS = r"\s*[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]\s*"


class VarisholdError(Exception):
    """Base class of every error that the package raises on purpose; its message is one line."""

    def __init__(self, message: str = "") -> None:
        import re

        line = re.sub(_LINE_ENDS, " ", message)
        half = _LONGEST // 2
        super().__init__(line if len(line) <= _LONGEST else f"{line[:half]} ... {line[-half:]}")


class InputError(VarisholdError, ValueError):
    """A value that cannot be used; the message names it, its place and what is allowed.

    Parameters
    ----------
    message : str
    parameter : str, optional
        The parameter that would mend it, by its name; a command tells its own option for it.
    """

    def __init__(self, message: str = "", *, parameter: str | None = None) -> None:
        super().__init__(message)
        self.parameter = parameter


def reason_of(error: BaseException) -> str:
    """Return why the system, or a library, refused: in the middle of a sentence, paths in it as they are.

    Examples
    --------
    >>> import errno
    >>> reason_of(OSError(errno.ENOSPC, "No space left on device"))
    'no space left on device'
    """
    told = getattr(error, "strerror", None) or str(error)
    # A word begins it, not an abbreviation, and no path.
    return told[:1].lower() + told[1:] if told[1:2].islower() else told


def require(law: object, message: str) -> None:
    """Raise `InputError` with this message where a law does not hold."""
    if not law:
        raise InputError(message)


def require_a(kind: type, value: object, name: str, how: str) -> None:
    """Raise `InputError` where something else was given for an object of this kind; `how` says where one comes from."""
    if not isinstance(value, kind):
        raise InputError(f"{name} must be a {kind.__name__}, {how}, got {type(value).__name__}")


class FormatError(InputError):
    """A file that cannot be read; the message names the file, the place and the remedy."""


class MissingExtraError(VarisholdError, ImportError):
    """An optional dependency is missing; the message names the command that installs it."""


class MissingKernelError(VarisholdError, ImportError):
    """The compiled kernel is missing or too old; the message names the command that builds it."""


class NotConvergedError(VarisholdError, ArithmeticError):
    """A numerical method stopped short of its tolerance; the message says by how much."""


class LostSourceError(VarisholdError, ConnectionError):
    """A live source is not there, or no more; it may come back."""


class EndOfSourceError(VarisholdError, EOFError):
    """A live source has no more."""


class Interrupted(BaseException):
    """Ctrl-C was pressed in a command. No library knows it, so that none makes something of its own of it."""
