"""Leaving the process where it stands when Ctrl-C is pressed.

What the program imports before it hears Ctrl-C stands here and above, and is little.
"""

from __future__ import annotations

import atexit
import os
import signal
from os import _exit

from varishold._lazy import TYPE_CHECKING

if TYPE_CHECKING:
    from typing import Any

__all__ = ["INTERRUPTED", "finish_undisturbed", "leave", "leave_at_once", "listen", "say_interrupted"]

#: The exit status after Ctrl-C.
INTERRUPTED = 130


def leave_at_once() -> None:
    """From now on Ctrl-C ends the process where it stands: while nothing has to be cleaned up."""
    listen(leave)


def finish_undisturbed() -> None:
    """When all is done, Ctrl-C changes nothing any more.

    The interpreter's last act would otherwise be to give the signal back to the system, which kills without a word.
    """
    # What is registered first is called last.
    atexit.register(listen, signal.SIG_IGN)


def listen(handler: Any) -> None:
    """Let a handler hear Ctrl-C, unless who runs us has said that it is to be ignored."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        try:
            signal.signal(signal.SIGINT, handler)
        except ValueError:
            # Only the main thread hears signals, and this is another.
            return


def leave(*_: Any) -> None:
    """End the process here and now, and say why."""
    say_interrupted()
    # By a name of its own: nobody's code that is scored can have taken this one away.
    _exit(INTERRUPTED)


def say_interrupted() -> None:
    """Write the one line that follows Ctrl-C."""
    try:
        os.write(2, b"varishold: interrupted\n")
    except OSError:
        # Nobody is there to read it.
        return
