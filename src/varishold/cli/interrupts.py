"""Ctrl-C ends the program with one line and status 130, wherever it was."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from varishold.cli.leaving import INTERRUPTED, leave, leave_at_once, listen, say_interrupted

__all__ = ["Ended", "interruptible"]


class _Interrupted(BaseException):
    """Ctrl-C was pressed. Nobody knows it, so that no library makes something of its own of it."""


class Ended:
    """How the program ended."""

    status = 0


@contextmanager
def interruptible() -> Iterator[Ended]:
    """Let Ctrl-C unwind what runs inside, so that it can clean up; a second one ends the process where it stands."""
    ended = Ended()
    pressed = []

    def interrupt(*_: Any) -> None:
        pressed.append(True)
        leave_at_once()
        raise _Interrupted

    def unraisable(args: Any) -> None:
        # Where nothing can be raised, as in a destructor or a callback of compiled code, nothing needs unwinding.
        if args.exc_type is _Interrupted:
            leave()
        sys.__unraisablehook__(args)

    before, sys.unraisablehook = sys.unraisablehook, unraisable
    listen(interrupt)
    try:
        yield ended
    except BaseException:
        if not pressed:
            raise
    finally:
        leave_at_once()
        sys.unraisablehook = before
        if pressed:
            say_interrupted()
            ended.status = INTERRUPTED
