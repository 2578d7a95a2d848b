"""Where the real recordings are, which are not part of the project."""

from __future__ import annotations

import os
from pathlib import Path

_BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"


def find_recording(name: str) -> Path | None:
    """Return the path of a real recording, or None after saying how to give it."""
    path = Path(os.environ.get("VARISHOLD_DATA", _BESIDE)) / name
    if path.is_file():
        return path
    print(f"  skipped: {name} is not here; set VARISHOLD_DATA to the folder that holds the recordings")
    return None
