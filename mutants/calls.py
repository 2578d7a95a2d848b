"""Which functions of the package a test calls, in its threads and in the processes that it starts."""

from __future__ import annotations

import functools
import json
import os
import sys
import threading
from collections.abc import Iterable
from functools import wraps
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

__all__ = ["Calls"]

_lru_cache = functools.lru_cache


class Calls:
    """Notes the first line of every function of the tree that is called.

    Parameters
    ----------
    root : str
        The tree; what lies elsewhere is not noted.
    """

    def __init__(self, root: str) -> None:
        self._root = os.path.join(root, "src", "")
        self._seen: dict[int, CodeType] = {}
        self._already: set[tuple[str, int]] = set()

    def see_through_caches(self) -> None:
        """Let every function that is cached from now on count as called, with what it calls, on a hit as on a miss."""

        def cached(function: Any) -> Any:
            if not getattr(getattr(function, "__code__", None), "co_filename", "").startswith(self._root):
                return _lru_cache(maxsize=None)(function)
            known: dict[Any, dict[int, CodeType]] = {}
            plain = _lru_cache(maxsize=None)(function)

            @wraps(function)
            def call(*arguments: Any, **named: Any) -> Any:
                key = (arguments, tuple(sorted(named.items())))
                if key not in known:
                    outside, self._seen = self._seen, {}
                    try:
                        return plain(*arguments, **named)
                    finally:
                        known[key] = self._seen
                        self._seen = outside | self._seen
                self._seen |= known[key]
                return plain(*arguments, **named)

            call.cache_clear = plain.cache_clear
            call.cache_info = plain.cache_info
            return call

        functools.cache = cached
        functools.lru_cache = lambda maxsize=None, typed=False: cached(maxsize) if callable(maxsize) else cached

    def start(self, already: Iterable[tuple[str, int]] = ()) -> None:
        """Begin to note, with what was called already; threads that begin from now on are noted too."""
        self._already |= set(already)
        threading.settrace(self._note)
        sys.settrace(self._note)

    def take(self) -> list[tuple[str, int]]:
        """Stop, return what was called since the start as (file, line), and forget it."""
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]
        # A thread that still runs may note meanwhile.
        seen, self._seen = self._seen, {}
        found = {
            (code.co_filename[len(self._root) :], code.co_firstlineno)
            for code in list(seen.values())
            if code.co_filename.startswith(self._root) and code.co_filename.endswith(".py")
        }
        found |= self._already
        self._already = set()
        return sorted(found)

    def leave(self, folder: str) -> None:
        """Stop, and leave what was called in a file of the folder, for the process that started this one."""
        Path(folder, f"{os.getpid()}.json").write_text(json.dumps(self.take()))

    def _note(self, frame: FrameType, event: str, argument: Any) -> None:
        code = frame.f_code
        # By identity: two functions with equal code, in two files, are two.
        if id(code) not in self._seen:
            self._seen[id(code)] = code
