"""Ctrl-C ends the program with one line and status 130, wherever it was; so does what else asks it to end."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, current_thread, main_thread
from typing import Any

from varishold.cli.leaving import ENDING, leave, leave_at_once, listen, say_interrupted, status_of
from varishold.errors import Interrupted

__all__ = ["Ended", "interruptible", "until_stopped"]


@contextmanager
def until_stopped() -> Iterator[Event]:
    """Let Ctrl-C, and what else asks a program to end, only set an event; the second time the process ends where it is.

    For what goes on until it is stopped, and has something to complete then.
    """
    wanted = Event()

    def stop(number: int, *_: Any) -> None:
        if wanted.is_set():
            leave(number)
        wanted.set()

    before = {}
    # What is ignored by who runs us stays so, as after nohup; only the main thread hears signals.
    for number in ENDING if current_thread() is main_thread() else ():
        if signal.getsignal(number) is not signal.SIG_IGN:
            before[number] = signal.signal(number, stop)
    try:
        yield wanted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Ended:
    """How the program ended."""

    status = 0


@contextmanager
def interruptible() -> Iterator[Ended]:
    """Let what asks to end unwind what runs inside, so that it can clean up; the second time the process ends there."""
    ended = Ended()
    heard: list[int] = []

    def interrupt(number: int, *_: Any) -> None:
        heard.append(number)
        leave_at_once()
        raise Interrupted

    def unraisable(args: Any) -> None:
        # Where nothing can be raised, as in a destructor or a callback of compiled code, nothing needs unwinding.
        if args.exc_type is Interrupted:
            leave(*heard)
        sys.__unraisablehook__(args)

    before, sys.unraisablehook = sys.unraisablehook, unraisable
    listen(interrupt)
    try:
        yield ended
    except BaseException:
        if not heard:
            raise
    finally:
        leave_at_once()
        sys.unraisablehook = before
        if heard:
            # It is said once.
            listen(lambda number, *_: os._exit(status_of(number)))
            say_interrupted()
            ended.status = status_of(heard[0])
