"""What a command reads and writes: said beside each parameter, and checked before the command begins."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, get_type_hints

import typer
from typer.models import OptionInfo

from varishold.errors import InputError

__all__ = ["Reads", "Writes", "guarded", "with_option"]

# Kinds of what is read that name files, whatever they are.
_FILES = ("file", "recordings", "bare recordings", "tables")

# The parameters of the command that runs, by name.
_running: dict[str, Any] = {}


@dataclass(frozen=True)
class Reads:
    """Marks a parameter that names what is to be read; ``kind`` is a key of `varishold.cli.inputs.READ`."""

    kind: str = "file"


@dataclass(frozen=True)
class Writes:
    """Marks a parameter that names a file to be written; ``kind`` is a key of `varishold.files.KINDS`.

    A command with such a parameter gets the option ``--force``. A folder's files are checked by the command itself.
    A name that does not end as ``ending`` says is refused, lest a file is called what it is not.
    """

    kind: str
    folder: bool = False
    ending: str = ""


_FORCE = Annotated[bool, typer.Option("--force", help="Replace a file that this command did not make.")]


def guarded(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that checks its outputs first, and tells the option that would mend an error."""
    hints = get_type_hints(command, include_extras=True)
    marks = {
        name: mark
        for name, hint in hints.items()
        for mark in getattr(hint, "__metadata__", ())
        if isinstance(mark, Reads | Writes)
    }
    written = {name: mark for name, mark in marks.items() if isinstance(mark, Writes) and not mark.folder}
    signature = inspect.signature(command)
    adds = bool(written) and "force" not in signature.parameters

    @functools.wraps(command)
    def run(**given: Any) -> None:
        _running.update(hints)
        force = given.pop("force") if adds else given.get("force", False)
        try:
            _check_named(marks, given)
            if written:
                _check(written, marks, given, force)
            command(**given)
        except InputError as error:
            raise type(error)(with_option(error)) from error

    parameters = [each.replace(annotation=hints[each.name]) for each in signature.parameters.values()]
    if adds:
        hints["force"] = _FORCE
        parameters.append(inspect.Parameter("force", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=_FORCE))
    run.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    run.__annotations__ = hints
    return run


def _check_named(marks: dict[str, Reads | Writes], given: dict[str, Any]) -> None:
    """Refuse a recording without a name, as of a variable that is not set: it would be the current folder."""
    for name, mark in marks.items():
        value = given[name]
        names = value if isinstance(value, list) else [value]
        if isinstance(mark, Reads) and mark.kind in _FILES and "" in names:
            raise InputError(f"{name}: '' names no file; '.' is the current folder")


def _check(written: dict[str, Writes], marks: dict[str, Reads | Writes], given: dict[str, Any], force: bool) -> None:
    from varishold.cli.inputs import inputs_of
    from varishold.files import check_output

    paths = [given[name] for name in written if given[name] is not None]
    if not paths:
        return
    inputs = inputs_of({name: mark.kind for name, mark in marks.items() if isinstance(mark, Reads)}, given, paths)
    outputs: dict[str, str] = {}
    for name, mark in written.items():
        path = given[name]
        if path is None:
            continue
        if (other := outputs.setdefault(str(path.absolute()), name)) != name:
            raise InputError(f"{path}: is to be both {other} and {name}; name two files")
        check_output(path, mark.kind, inputs=inputs, force=force)
        device = path.exists() and not path.is_file()
        if not path.name.lower().endswith(mark.ending) and not device:
            raise InputError(f"{path}: its name must end in {mark.ending}, which is how it is written")


def with_option(error: InputError) -> str:
    """Return an error's message with the running command's option for the parameter that would mend it."""
    name = error.parameter
    for option in getattr(_running.get(name or ""), "__metadata__", ()):
        if name is not None and isinstance(option, OptionInfo):
            # Beside a type typer keeps the first of an option's names as its default.
            named = [each for each in (option.default, *(option.param_decls or ())) if str(each).startswith("--")]
            shown = next(iter(named), f"--{name.replace('_', '-')}")
            return f"{error} ({shown}{' ROWSxCOLS' if name == 'shape' else ''})"
    return str(error)
