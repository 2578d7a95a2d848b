"""Draw docs/images/sections.png, four solids under a falling threshold: python docs/images/sections.py."""

from __future__ import annotations

import runpy
from pathlib import Path

import matplotlib as mpl

EXAMPLE = Path(__file__).parents[2] / "examples" / "02_let_the_threshold_fall.py"


def main() -> None:
    """Run the example, and keep its figure."""
    mpl.use("Agg")
    from matplotlib import pyplot as plt

    plt.show = lambda: None
    runpy.run_path(str(EXAMPLE))
    path = Path(__file__).with_suffix(".png")
    plt.gcf().savefig(path, dpi=110, bbox_inches="tight")
    print(path)


if __name__ == "__main__":
    main()
