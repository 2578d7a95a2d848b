"""The command line: one file a command group; each command parses, calls and prints."""

from __future__ import annotations

import os
import sys

from varishold.cli.leaving import finish_undisturbed, leave_at_once

__all__ = ["main"]


def main() -> None:
    """Run the program; bad input ends in one line on standard error and exit status 1."""
    leave_at_once()
    finish_undisturbed()
    # No command uses joblib's processes; where these have no place for their locks joblib would tell so each time.
    os.environ.setdefault("JOBLIB_MULTIPROCESSING", "0")
    # Imported here, where an interruption is heard.
    from varishold.cli.interrupts import interruptible

    with interruptible() as ended:
        from varishold.cli.app import run

        ended.status = run()
    sys.exit(ended.status)
