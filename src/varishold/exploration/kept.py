"""What was felt, kept line by line, so that a call that was stopped goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from varishold.errors import InputError, reason_of
from varishold.files import atomic_write, open_file
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
        raise InputError(f"{path.parent}: cannot be made: {reason_of(error)}") from None
    # Half a line, which who was killed has left, is gone after this.
    with atomic_write(path, "w") as file:
        file.writelines(_line(seed, made) for seed, made in felt.items())
    with open(path, "a", encoding="utf-8") as file:
        yield lambda seed, made: _append(file, seed, made)


def _append(file: IO[str], seed: int, made: Example) -> None:
    file.write(_line(seed, made))
    file.flush()


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
