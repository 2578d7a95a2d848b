"""The command line: one file a command group; each command parses, calls and prints."""

from __future__ import annotations

import sys

from varishold.cli.leaving import finish_undisturbed, leave_at_once

__all__ = ["main"]


def main() -> None:
    """Run the program; bad input ends in one line on standard error and exit status 1."""
    leave_at_once()
    finish_undisturbed()
    # Imported here, where an interruption is heard.
    from varishold.cli.interrupts import interruptible

    with interruptible() as ended:
        from varishold.cli.app import run

        ended.status = run()
    sys.exit(ended.status)
