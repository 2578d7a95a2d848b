"""The command line: one file a command group; each command parses, calls and prints."""

from varishold.cli.app import main

__all__ = ["main"]
