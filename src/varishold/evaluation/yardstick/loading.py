"""A user's own function, found by its name."""

from __future__ import annotations

import os
import re
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, NoReturn

from varishold.errors import InputError, Interrupted

__all__ = ["exits_raised", "load_function", "what_was_raised"]

# So many characters of what somebody's code says are told.
_MOST_SAID = 500
_DOTTED = r"[^\W\d]\w*(?:\.[^\W\d]\w*)*"


def load_function(name: str) -> Callable[..., Any]:
    """Import a module, which runs its code, and return the function of that name in it.

    Parameters
    ----------
    name : str
        As in ``package.module:function``.

    Raises
    ------
    InputError
        If the name has another form, the module cannot be imported, or holds no such function.
    """
    match = re.fullmatch(rf"({_DOTTED}):({_DOTTED})", name)
    if match is None or match[1].endswith(".py"):
        raise InputError(f"{name}: name a function as package.module:function, without .py", parameter="given")
    module, function = match[1], match[2]
    try:
        with exits_raised():
            value: Any = import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise InputError(f"{name}: importing {module} {what_was_raised(error)}", parameter="given") from error
        raise InputError(
            f"{name}: there is no module {error.name}, neither installed nor in this folder", parameter="given"
        ) from None
    except (KeyboardInterrupt, Interrupted):
        raise
    except BaseException as error:
        raise InputError(f"{name}: importing {module} {what_was_raised(error)}", parameter="given") from error
    for part in function.split("."):
        if not hasattr(value, part):
            raise InputError(f"{name}: module {module} has no {function}", parameter="given")
        value = getattr(value, part)
    if not callable(value):
        raise InputError(f"{name}: is no function but {type(value).__name__}", parameter="given")
    return value  # type: ignore[no-any-return]


@contextmanager
def exits_raised() -> Iterator[None]:
    """Let somebody's code that runs meanwhile raise SystemExit where it would end this process by os._exit, unseen.

    Processes that it starts end as they would.
    """
    leave, process = os._exit, os.getpid()

    def leave_or_raise(status: int) -> NoReturn:
        if os.getpid() != process:
            leave(status)
        raise SystemExit(f"it asked to end this process with status {status}")

    os._exit = leave_or_raise
    try:
        yield
    finally:
        os._exit = leave


def what_was_raised(error: BaseException) -> str:
    """Return an error of somebody's code in words, with the place that raised it."""
    # The first step is the call, and what imports a module, or leaves it, is no place to look at either.
    steps = [
        step
        for step in traceback.extract_tb(error.__traceback__)[1:]
        if "importlib" not in step.filename and step.filename != __file__
    ]
    place = f" ({steps[-1].filename}, line {steps[-1].lineno})" if steps else ""
    text = str(error)
    said = f": {text if len(text) <= _MOST_SAID else text[:_MOST_SAID] + ' ...'}" if text else ""
    return f"raised {type(error).__name__}{said}{place}"
