"""How a frozen dataclass is pickled and copied whose mappings are read-only: it is made anew from its fields."""

from __future__ import annotations

import dataclasses
from types import MappingProxyType
from typing import Any

__all__ = ["remade"]


def remade(value: Any) -> tuple[Any, ...]:
    """Return what `__reduce__` returns for such a dataclass.

    Examples
    --------
    >>> import pickle
    >>> import numpy as np
    >>> from varishold.recording import Pad, Recording
    >>> recording = Recording({"pad": Pad(np.ones((3, 2, 4)))}, unit="kPa")
    >>> pickle.loads(pickle.dumps(recording)).unit
    'kPa'
    """
    given = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.init}
    plain = {name: dict(each) if isinstance(each, MappingProxyType) else each for name, each in given.items()}
    return _made, (type(value), plain)


def _made(kind: type, given: dict[str, Any]) -> Any:
    return kind(**given)
