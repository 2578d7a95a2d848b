"""What a command reads and writes: said beside each parameter, and checked before the command begins."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import click
from click.core import ParameterSource

from varishold.errors import FormatError, InputError

__all__ = ["Reads", "Writes", "adds_force", "force_said", "guarded", "signature_of", "with_option"]

# Kinds of what is read that name files, whatever they are.
_FILES = ("file", "recordings", "bare recordings", "tables", "hand", "feeling hand")


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


def adds_force(signature: inspect.Signature) -> bool:
    """Whether a command gets the option ``--force`` although it has no such parameter: it writes a file."""
    return bool(_written(_marks(signature))) and "force" not in signature.parameters


def force_said(signature: inspect.Signature) -> str:
    """Say what ``--force`` is for: to replace what was measured or felt long, or what is of another kind."""
    kept = any(mark.kind == "measurement" for mark in _written(_marks(signature)).values())
    return "Replace a file that is there." if kept else "Replace a file that this command did not make."


@functools.cache
def signature_of(command: Callable[..., None]) -> inspect.Signature:
    """Return what a command takes, with the marks of each parameter."""
    return inspect.signature(command, eval_str=True)


def guarded(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that checks its outputs first, and tells the option that would mend an error."""

    @functools.wraps(command)
    def run(**given: Any) -> None:
        signature = signature_of(command)
        marks = _marks(signature)
        force = given.pop("force") if adds_force(signature) else given.get("force", False)
        try:
            _check_named(marks, given)
            _check(marks, given, force)
            command(**given)
        except InputError as error:
            raise type(error)(with_option(error)) from error

    return run


def _marks(signature: inspect.Signature) -> dict[str, Reads | Writes]:
    return {
        name: mark
        for name, parameter in signature.parameters.items()
        for mark in parameter.annotation.__metadata__
        if isinstance(mark, Reads | Writes)
    }


def _written(marks: dict[str, Reads | Writes]) -> dict[str, Writes]:
    return {name: mark for name, mark in marks.items() if isinstance(mark, Writes) and not mark.folder}


def _check_named(marks: dict[str, Reads | Writes], given: dict[str, Any]) -> None:
    """Refuse a recording without a name, as of a variable that is not set: it would be the current folder."""
    for name, mark in marks.items():
        value = given[name]
        names = value if isinstance(value, list) else [value]
        if isinstance(mark, Reads) and mark.kind in _FILES and "" in names:
            raise InputError(f"{name}: '' names no file; '.' is the current folder")


def _check(marks: dict[str, Reads | Writes], given: dict[str, Any], force: bool) -> None:
    from varishold.cli.inputs import inputs_of
    from varishold.files import check_output

    for name, mark in marks.items():
        if isinstance(mark, Writes) and mark.folder and given[name].is_file():
            raise InputError(f"{given[name]}: cannot be made a folder: it is a file; name a folder")
    written = _written(marks)
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
    context = click.get_current_context(silent=True)
    if context is None or context.command.callback is None:
        return str(error)
    options = {each.name or "": each for each in context.command.get_params(context) if isinstance(each, click.Option)}
    words = str(error)
    for name, each in options.items():
        # Who typed an option looks for it; a key of a file keeps its name.
        typed = "_" in name and not isinstance(error, FormatError)
        if typed and context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            # A file may be called so, too.
            words = re.sub(rf"^(\S+: )?{name}(?= (must|of)\b)", rf"\g<1>{_long(each)}", words)
    option = options.get(error.parameter or "")
    if error.parameter == "shape" and option is None:
        marks = _marks(signature_of(context.command.callback))
        read = {mark.kind: context.params.get(name) for name, mark in marks.items() if isinstance(mark, Reads)}
        if "source" in read:
            return f"{words}{' (replay:FILE?shape=ROWSxCOLS)' if _is_file(read['source']) else ''}"
        if "sensor" in read:
            return f"{words}; in a sensor file: shape = [ROWS, COLUMNS] (--sensor)"
    if option is None or _long(option) in words:
        return words
    return f"{words} ({_long(option)}{' ROWSxCOLS' if option.name == 'shape' else ''})"


def _long(option: click.Option) -> str:
    """Return an option's name as it is typed in full."""
    return next(each for each in option.opts if each.startswith("--"))


def _is_file(source: str | None) -> bool:
    """Whether the address of a source is that of a file; any other source says itself what its address lacks."""
    from varishold.live.address import replayed_file

    return bool(replayed_file(source or ""))
