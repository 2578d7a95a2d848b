"""What a file holds for a controller: a table of touch, or what own presses taught about a pad."""

from __future__ import annotations

import os

from varishold.errors import InputError
from varishold.files import open_archive
from varishold.learning.model_file import read_model
from varishold.learning.portable import PortableClassifier
from varishold.touch.decision import read_parameters
from varishold.touch.network import Decision

__all__ = ["exported_decision"]


def exported_decision(path: str | os.PathLike[str] | None, pad: str | None = None) -> Decision | None:
    """Return the decision that a file holds; None, which means the shipped one, where no file is named.

    Parameters
    ----------
    path : str or path-like, optional
        A table of touch, or a model that ``learn --portable`` wrote.
    pad : str, optional
        Which pad of a model; needed where it has several.

    Raises
    ------
    InputError
        If the file is neither, or it is not clear which pad is meant.
    """
    if path is None or _is_table(path):
        if pad is not None:
            raise InputError("only a model that learn --portable wrote has pads by name", parameter="pad")
        return None if path is None else read_parameters(path)
    model = read_model(path)
    if not isinstance(model, PortableClassifier):
        raise InputError(f"{path}: is too large for a controller: learn it again with --portable", parameter="model")
    networks = model.networks
    if pad is None and len(networks) == 1:
        (pad,) = networks
    if pad not in networks:
        got = "" if pad is None else f", got {pad!r}"
        raise InputError(f"{path}: name one of its pads, {', '.join(networks)}{got}", parameter="pad")
    return networks[pad]


def _is_table(path: str | os.PathLike[str]) -> bool:
    with open_archive(path) as archive:
        return "kinds" in archive.names
