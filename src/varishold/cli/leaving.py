"""Leaving the process where it stands when Ctrl-C is pressed, or something else asks it to end.

What the program imports before it hears that stands here and above, and is little.
"""

from __future__ import annotations

import atexit
import os
import signal
from os import _exit

from varishold._lazy import TYPE_CHECKING

if TYPE_CHECKING:
    from typing import Any

__all__ = ["ENDING", "finish_undisturbed", "leave", "leave_at_once", "listen", "say_interrupted", "status_of"]

#: What asks a program to end, where the system knows it: Ctrl-C, ``kill``, and a terminal that is closed.
ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


def status_of(number: int) -> int:
    """Return the exit status after a signal, as shells have it: 130 after Ctrl-C."""
    return 128 + number


def leave_at_once() -> None:
    """From now on what asks the process to end ends it where it stands: while nothing has to be cleaned up."""
    listen(leave)


def finish_undisturbed() -> None:
    """When all is done, Ctrl-C changes nothing any more.

    The interpreter's last act would otherwise be to give the signal back to the system, which kills without a word.
    """
    # What is registered first is called last.
    atexit.register(listen, signal.SIG_IGN, (signal.SIGINT,))


def listen(handler: Any, numbers: tuple[int, ...] = ENDING) -> None:
    """Let a handler hear what asks to end, unless who runs us has said that it is to be ignored."""
    for number in numbers:
        if signal.getsignal(number) is not signal.SIG_IGN:
            try:
                signal.signal(number, handler)
            except ValueError:
                # Only the main thread hears signals, and this is another.
                return


def leave(number: int, *_: Any) -> None:
    """End the process here and now, and say why."""
    say_interrupted()
    # By a name of its own: nobody's code that is scored can have taken this one away.
    _exit(status_of(number))


def say_interrupted() -> None:
    """Write the one line that follows what asked to end."""
    try:
        os.write(2, b"varishold: interrupted\n")
    except OSError:
        # Nobody is there to read it.
        return
