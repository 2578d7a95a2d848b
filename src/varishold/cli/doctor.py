"""``varishold doctor``: what is installed, what is missing, and how to get it."""

from __future__ import annotations

import os
import platform
import re
import sys
from collections.abc import Iterator
from typing import Annotated

import click

from varishold import __version__
from varishold._lazy import to_install
from varishold.cli.command import Commands, Option
from varishold.cli.printing import echo, print_json
from varishold.errors import MissingKernelError

# What each extra is for.
_FOR = {
    "skin": "--skin, --exact, skin, sensor calibrate",
    "learn": "grasp fit, learn, recognize, evaluate",
    "plots": "figures as files",
    "sim": "hand, perceive",
    "meshes": "objects add, perceive MESH",
    "live": "serial ports, foxglove bridges, MCAP files",
    "zenoh": "zenoh sources (ROS 2)",
    "lsl": "Lab Streaming Layer sources",
    "mqtt": "MQTT sources",
    "files": "HDF5, MATLAB 7.3, Parquet, MCAP and PNG files, LeRobot and Zarr data sets, bags of ROS",
    "cluster": "corpora on many machines",
}


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(doctor)


def doctor(
    json: Annotated[bool, Option("Print one JSON object.")] = False,
) -> None:
    """Say what is installed, what is missing, and how to get it."""
    kernel, broken = _kernel()
    extras = list(_extras())
    if json:
        print_json(
            {
                "version": __version__,
                "python": platform.python_version(),
                "platform": platform.platform(),
                "kernel": kernel,
                "kernel_error": broken,
                "extras": dict(extras),
            }
        )
    else:
        echo(f"varishold {__version__}, Python {platform.python_version()}, {platform.platform()}")
        echo(f"kernel    {kernel if broken is None else f'does not work: {broken}'}")
        for name, packages in extras:
            echo(f"{name:<9} {_in_words(name, packages)}")
        if sys.stdout.encoding.lower() not in ("utf-8", "utf8"):
            echo(f"this terminal shows {sys.stdout.encoding}: signs that it lacks stand as their codes")
    if broken is not None:
        raise click.exceptions.Exit(1)


def _kernel() -> tuple[str | None, str | None]:
    """Return which kernel runs, and what is wrong with it."""
    try:
        from varishold.kernel.library import library

        path = str(library()._name)
        from varishold import find_contacts

        find_contacts([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    except MissingKernelError as error:
        return None, str(error)
    return os.path.basename(path), None


def _extras() -> Iterator[tuple[str, dict[str, str | None]]]:
    """Yield each extra, and the version of every package in it; None where it is not installed."""
    from importlib.metadata import requires

    wanted = requires("varishold") or ()
    for extra in _FOR:
        names = [
            match[0]
            for line in wanted
            if re.search(rf"extra == ['\"]{extra}['\"]", line)
            and (match := re.match(r"[A-Za-z0-9_.-]+", line))
            and match[0] != "varishold"
        ]
        yield extra, {name: _version(name) for name in names}


def _version(name: str) -> str | None:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _in_words(extra: str, packages: dict[str, str | None]) -> str:
    missing = [name for name, version in packages.items() if version is None]
    if missing:
        return f"lacks {', '.join(missing)} for {_FOR[extra]}; run: {to_install(extra)}"
    return ", ".join(f"{name} {version}" for name, version in packages.items())
