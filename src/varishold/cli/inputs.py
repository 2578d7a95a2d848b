"""The files that a command reads: those that its parameters name, and those that these name in their turn."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any

from varishold.errors import InputError

__all__ = ["READ", "files_beside", "inputs_of"]

_Name = str | os.PathLike[str]


def inputs_of(kinds: Mapping[str, str], given: Mapping[str, Any], outputs: Sequence[Path]) -> list[_Name]:
    """Return the files that a call reads.

    Parameters
    ----------
    kinds : mapping of str to str
        A key of `READ` by the name of each parameter that is read.
    given : mapping of str to object
        The values of the parameters.
    outputs : sequence of Path
        The files that the call writes: what an earlier call has made is read by none, where it lies in a folder.
    """
    read = {name: _read(kind, given[name], outputs) for name, kind in kinds.items()}
    inputs = [file for files in read.values() for file in files]
    if not any(read[name] for name, kind in kinds.items() if kind == "sensor"):
        inputs += files_beside(file for name, kind in kinds.items() if kind == "recordings" for file in read[name])
    return inputs


def files_beside(recordings: Iterable[_Name]) -> list[Path]:
    """Return the sensor files that stand beside recordings, and the files that these name."""
    from varishold.sensor import find_sensor_file, named_files

    found = dict.fromkeys(map(find_sensor_file, recordings))
    return [file for beside in found if beside is not None for file in (beside, *named_files(beside))]


def _read(kind: str, value: Any, outputs: Sequence[Path]) -> list[_Name]:
    files: list[_Name] = []
    for each in value if isinstance(value, list) else [value]:
        # What is no file is told when it is read.
        with suppress(InputError):
            files += () if each is None else READ[kind](each, outputs)
    return files


def _named(name: _Name, _: Sequence[Path]) -> Iterable[_Name]:
    return (name,)


def _sensor(name: str, _: Sequence[Path]) -> Iterable[_Name]:
    from varishold.sensor import named_files

    return (name, *named_files(name))


def _source(address: str, _: Sequence[Path]) -> Iterable[_Name]:
    from varishold.live.address import replayed_file

    return replayed_file(address)


def _hand(name: str, _: Sequence[Path]) -> Iterable[_Name]:
    from varishold.hand.mjcf import hand_files

    return hand_files(name)


def _feeling_hand(name: str, _: Sequence[Path]) -> Iterable[_Name]:
    from varishold.hand.mjcf import hand_files

    return hand_files(name, library=False)


def _recordings(name: str, outputs: Sequence[Path]) -> Iterable[_Name]:
    from varishold.cli.made import Others
    from varishold.cli.named import recordings_named
    from varishold.files import input_files

    def wanted(file: Path) -> bool:
        return not any(out.exists() and out.samefile(file) for out in outputs) or Others().is_recording(file)

    for file in recordings_named(name, wanted):
        yield file
        if os.path.isdir(file):
            yield from input_files([file])


def _tables(name: str, _: Sequence[Path]) -> Iterable[_Name]:
    from varishold.cli.named import table_files

    return table_files([name])


#: How the files are found that a parameter's value stands for, by its kind; the files that are written are told too.
READ: Mapping[str, Callable[[Any, Sequence[Path]], Iterable[_Name]]] = MappingProxyType(
    {
        "file": _named,
        # It may be no file at all.
        "word": _named,
        "sensor": _sensor,
        "source": _source,
        "hand": _hand,
        # One that feels for a library, which may be its own.
        "feeling hand": _feeling_hand,
        # Each is read with the sensor file that stands beside it, where no sensor is named.
        "recordings": _recordings,
        "bare recordings": _recordings,
        "tables": _tables,
    }
)
