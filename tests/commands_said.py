"""Commands whose rooms a test may replace: all are loaded first, and what a command prints is returned."""

from __future__ import annotations

from click.testing import CliRunner
from tests.loaded_rooms import load

from varishold.cli.app import app

__all__ = ["said"]

load("corpus", "evaluation", "learning", "live", "perceive", "report", "sensor", "skin", "touch")


def said(*words: object, status: int = 0) -> str:
    """Run a command; return what it prints, and raise what it does not expect."""
    done = CliRunner().invoke(app, list(map(str, words)))
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == status, done.output
    return done.stdout
