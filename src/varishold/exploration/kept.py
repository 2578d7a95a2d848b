"""What was felt, kept line by line, so that a call that was stopped goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import FileIO
from pathlib import Path

from varishold.errors import InputError, reason_of
from varishold.files import atomic_write, open_file
from varishold.files.writing import cannot_write
from varishold.perceive import Evidence

__all__ = ["Example", "keeper", "kept_examples"]

#: The evidence of every touch of a thing that was set up once.
Example = list[Evidence]


@contextmanager
def keeper(keep: str | os.PathLike[str] | None, felt: dict[int, Example]) -> Iterator[Callable[[int, Example], None]]:
    """Write down each example as soon as it was felt, after those that are known."""
    if keep is None:
        yield lambda seed, made: None
        return
    path = Path(keep)
    try:
        path.parent.mkdir(exist_ok=True)
    except OSError as error:
        why = "it is a file; move it away" if path.parent.is_file() else reason_of(error)
        raise InputError(f"{path.parent}: cannot be made a folder: {why}") from None
    # Half a line, which who was killed has left, is gone after this.
    with atomic_write(path, "w") as file:
        file.writelines(_line(seed, made) for seed, made in felt.items())
    # Without a buffer, of which closing would write the rest again where the disk is full.
    with open(path, "ab", buffering=0) as file:
        yield lambda seed, made: _append(file, path, seed, made)


def _append(file: FileIO, path: Path, seed: int, made: Example) -> None:
    try:
        file.write(_line(seed, made).encode())
    except OSError as error:
        raise cannot_write(path, error) from error


def _line(seed: int, made: Sequence[Evidence]) -> str:
    touches = [[each.touch, each.failed, each.seconds, dict(each.values)] for each in made]
    return json.dumps({"seed": seed, "touches": touches}) + "\n"


def kept_examples(path: Path) -> dict[int, Example]:
    """What an earlier call has kept, by seed; a line that is not whole is felt again."""
    felt: dict[int, Example] = {}
    if not path.exists():
        return felt
    with open_file(path) as file:
        for line in file:
            try:
                told = json.loads(line)
                felt[int(told["seed"])] = [
                    Evidence(touch, values, failed=failed, seconds=seconds)
                    for touch, failed, seconds, values in told["touches"]
                ]
            except (ValueError, LookupError, TypeError, OverflowError, RecursionError):
                continue
    return felt
