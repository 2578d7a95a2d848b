"""Chunks of training data, kept between runs."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from varishold.files import atomic_write

__all__ = ["CACHE", "keep", "kept"]

Chunk = TypeVar("Chunk")

CACHE = Path("out/training")


def kept(kind: type[Chunk], name: str) -> Chunk | None:
    """Return a chunk, a dataclass of arrays, that was kept under a name; None where none was."""
    path = CACHE / f"{name}.npz"
    if not path.is_file():
        return None
    with np.load(path, allow_pickle=False) as arrays:
        return kind(**{field.name: arrays[field.name] for field in fields(kind)})  # type: ignore[arg-type]


def keep(chunk: Any, name: str) -> None:
    """Keep a chunk under a name."""
    CACHE.mkdir(parents=True, exist_ok=True)
    with atomic_write(CACHE / f"{name}.npz") as file:
        np.savez(file, **{field.name: getattr(chunk, field.name) for field in fields(chunk)})
