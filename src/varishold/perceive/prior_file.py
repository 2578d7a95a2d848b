"""What another sense said before anything was touched, in a file: a camera's guess, as JSON."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from varishold.errors import FormatError, InputError
from varishold.files.documents import read_json
from varishold.frame.checks import as_names
from varishold.perceive.name_evidence import NameEvidence, SizePrior

__all__ = ["read_prior"]

_KEYS = tuple(field.name for field in fields(NameEvidence))
_POSE_KEYS = tuple(field.name for field in fields(SizePrior))


def read_prior(path: str | os.PathLike[str], objects: Sequence[str] | None = None) -> NameEvidence:
    """Read what somebody says of an object's name: an object with the keys of `NameEvidence`.

    Parameters
    ----------
    path : str or path-like
        JSON, as in ``{"source": "camera", "probability": {"sphere": 0.7, "cone": 0.3}}``, and where the size was seen
        too, ``"pose": {"size_m": 0.08, "size_sigma_m": 0.01}``. Without a source it is the file's name.
    objects : sequence of str, optional
        What the library knows: the prior must name one of them.

    Raises
    ------
    FormatError
        If it is no such file, or names none of the objects, in one line.
    """
    said = read_json(path)
    if not isinstance(said, dict) or "probability" not in said:
        raise FormatError(f'{path}: must be {{"source": WHO, "probability": {{NAME: SHARE, ...}}}}')
    said.setdefault("source", Path(path).stem)
    unknown = [key for key in said if key not in _KEYS]
    if unknown:
        raise FormatError(f"{path}: has no key {ascii(unknown[0])[:60]}; known are {', '.join(_KEYS)}")
    pose = said.get("pose")
    if pose is not None and (not isinstance(pose, dict) or set(pose) != set(_POSE_KEYS)):
        got = ", ".join(ascii(key)[:60] for key in pose) if isinstance(pose, dict) else ascii(pose)[:60]
        raise FormatError(
            f"{path}: pose must be {{{', '.join(f'{key}: METRES' for key in _POSE_KEYS)}}}, got {got or 'nothing'}; "
            "a library keeps no turn and no place of its examples"
        )
    try:
        prior = NameEvidence(**said | ({} if pose is None else {"pose": SizePrior(**pose)}))
        if objects is not None:
            prior.check_common(as_names(objects, "objects"))
        return prior
    except InputError as error:
        raise FormatError(f"{path}: {error}") from None
