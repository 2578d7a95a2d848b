"""Commands made of functions: beside each parameter stands what the command line takes for it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin

import click

from varishold.cli.files import adds_force, force_said, guarded, signature_of

__all__ = ["Argument", "Command", "Commands", "Option"]


@dataclass(frozen=True)
class Argument:
    """Marks a parameter that is given by its place; `metavar` stands for it in help, else its name."""

    help: str
    metavar: str | None = None


@dataclass(frozen=True)
class Option:
    """Marks a parameter that is given by its name.

    It is called as the parameter is, unless `name` says otherwise, and `short`, as in ``-o``, too. What may be True,
    False or None has its ``--no-`` beside it. A number may be `min` to `max`.
    """

    help: str
    metavar: str | None = None
    name: str | None = None
    short: str | None = None
    min: float | None = None
    max: float | None = None


class Command(click.Command):
    """A command whose parameters and description are its function's, and whose files are checked before it begins."""

    def __init__(self, name: str, *, callback: Callable[..., None], **more: Any) -> None:
        more["short_help"] = (inspect.getdoc(callback) or "").partition("\n\n")[0]
        super().__init__(name, callback=guarded(callback), **more)
        self._function = callback

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return what the command takes; made when that is first asked, since of all commands one is run."""
        if not self.params:
            signature = signature_of(self._function)
            self.params = [_parameter(each) for each in signature.parameters.values()]
            if adds_force(signature):
                self.params.append(click.Option(["--force"], is_flag=True, help=force_said(signature)))
        return super().get_params(ctx)

    def _places(self, ctx: click.Context) -> Iterator[tuple[str, str]]:
        """Yield what is given by its place, and what is said of it."""
        parameters = signature_of(self._function).parameters.values()
        for parameter, made in zip(parameters, self.get_params(ctx), strict=False):
            if isinstance(made, click.Argument):
                usual = "" if made.required or parameter.default is None else f"  [default: {parameter.default}]"
                yield made.human_readable_name, _said(parameter).help + usual

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read what was given; an error says of which command it is."""
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            error.ctx = error.ctx or ctx
            raise

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what may be given."""
        if places := [*self._places(ctx)]:
            with formatter.section("Arguments"):
                formatter.write_dl(places)
        super().format_options(ctx, formatter)


class Commands(click.Group):
    """Commands, in the order in which they were added; a name may be two words, as in ``touch export``."""

    command_class = Command

    def subgroup(self, name: str, help: str) -> Commands:
        """Return a new group of commands in this one."""
        group = Commands(name, help=help)
        self.add_command(group)
        return group

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands' names."""
        return list(self.commands)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read what was given; where that is nothing, show what there is."""
        if not args and not ctx.resilient_parsing:
            click.echo(ctx.get_help())
            ctx.exit(2)
        return super().parse_args(ctx, args)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that is asked for, and what is given to it."""
        if (two := " ".join(args[:2])) in self.commands:
            args = [two, *args[2:]]
        return super().resolve_command(ctx, args)


class _IntRange(click.IntRange):
    """A whole number between two others."""

    name = "integer"


class _FloatRange(click.FloatRange):
    """A number between two others, which NaN is not."""

    name = "float"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number: float = super().convert(value, param, ctx)
        if number != number:
            self.fail(f"{value} is no number", param, ctx)
        return number


class _Path(click.Path):
    """A path; of nothing it would be the current folder."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "":
            self.fail("names nothing; '.' is the current folder", param, ctx)
        return super().convert(value, param, ctx)


_PATH = _Path(readable=False, path_type=Path)
# What has its place and is no word of a few is the name of a file, as a rule: a shell completes it as one.
_NAME = click.Path(readable=False)


def _said(parameter: inspect.Parameter) -> Option | Argument:
    (said,) = (mark for mark in parameter.annotation.__metadata__ if isinstance(mark, Option | Argument))
    return said


def _parameter(parameter: inspect.Parameter) -> click.Parameter:
    """Return what the command line takes for a parameter of a function."""
    said, hint = _said(parameter), get_args(parameter.annotation)[0]
    optional = NoneType in get_args(hint)
    if optional:
        (hint,) = set(get_args(hint)) - {NoneType}
    several = get_origin(hint) is list
    if several:
        (hint,) = get_args(hint)
    how: dict[str, Any] = {"metavar": said.metavar, "required": parameter.default is parameter.empty}
    if several:
        how["callback"] = lambda ctx, param, values: list(values) or None
    elif not how["required"]:
        default = parameter.default
        how["default"] = default.value if isinstance(default, StrEnum) else default
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        how["callback"] = lambda ctx, param, value: None if value is None else hint(value)
    if isinstance(said, Argument):
        kind = _NAME if hint is str else _type_of(hint, None, None)
        return click.Argument([parameter.name], type=kind, nargs=-1 if several else 1, **how)
    name = said.name or f"--{parameter.name.replace('_', '-')}"
    if hint is bool:
        name += f"/--no-{name[2:]}" if optional else ""
        return click.Option([parameter.name, name], is_flag=True, help=said.help, **how)
    names = [parameter.name, *([said.short] if said.short else []), name]
    return click.Option(names, type=_type_of(hint, said.min, said.max), multiple=several, help=said.help, **how)


def _type_of(hint: Any, least: Any, most: Any) -> Any:
    """Return click's type of a hint."""
    if get_origin(hint) is tuple:
        return get_args(hint)
    if issubclass(hint, StrEnum):
        return click.Choice([each.value for each in hint])
    if hint is Path:
        return _PATH
    if least is None and most is None:
        return hint
    return {int: _IntRange, float: _FloatRange}[hint](least, most)
