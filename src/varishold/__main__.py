"""``python -m varishold`` is the program ``varishold``."""

from __future__ import annotations

from varishold.cli import main

if __name__ == "__main__":
    main()
