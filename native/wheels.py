"""A wheel for each platform, its kernel compiled here by the package ziglang.

    python -m native.wheels [PLATFORM ...] [-o FOLDER]

Needs the packages hatchling and ziglang; `make wheels` installs them beside the project.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

from native.build import HERE, PLATFORMS


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("platform", nargs="*", help=f"some of {', '.join(PLATFORMS)}; all where none is named")
    parser.add_argument("-o", "--output", type=Path, default=HERE.parent / "out" / "wheels")
    given = parser.parse_args()
    if unknown := [platform for platform in given.platform if platform not in PLATFORMS]:
        parser.error(f"there is no platform {unknown[0]!r}; choose among {', '.join(PLATFORMS)}")
    for platform in given.platform or PLATFORMS:
        subprocess.run(
            [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", given.output.resolve()],
            cwd=HERE.parent,
            env={**os.environ, "VARISHOLD_PLATFORM": platform},
            check=True,
        )


if __name__ == "__main__":
    main()
