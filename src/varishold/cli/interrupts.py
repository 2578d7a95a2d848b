"""Ctrl-C ends the program with one line and status 130, wherever it was."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from typing import Any

__all__ = ["Ended", "interruptible", "leave_at_once"]

_STATUS = 130
_LINE = b"varishold: interrupted\n"


class _Interrupted(BaseException):
    """Ctrl-C was pressed. Nobody knows it, so that no library makes something of its own of it."""


class Ended:
    """How the program ended; a plain class, for what is imported here is imported before Ctrl-C is heard."""

    status = 0


def leave_at_once() -> None:
    """From now on Ctrl-C ends the process where it stands: while nothing has to be cleaned up."""
    _listen(_leave)


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
            _leave()
        sys.__unraisablehook__(args)

    before, sys.unraisablehook = sys.unraisablehook, unraisable
    _listen(interrupt)
    try:
        yield ended
    except BaseException:
        if not pressed:
            raise
    finally:
        leave_at_once()
        sys.unraisablehook = before
        if pressed:
            os.write(2, _LINE)
            ended.status = _STATUS


def _listen(handler: Any) -> None:
    # Only the main thread hears signals; who runs us may have said that Ctrl-C is to be ignored.
    if current_thread() is main_thread() and signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, handler)


def _leave(*_: Any) -> None:
    os.write(2, _LINE)
    os._exit(_STATUS)
