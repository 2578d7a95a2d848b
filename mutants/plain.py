"""Compiled functions without their compiler: a change in one runs at once, and what inlines it cannot be stale."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["compiled_modules", "plain_modules", "run_plainly"]


def compiled_modules(root: Path) -> dict[str, bool]:
    """Return the modules that hold compiled functions, and whether only the compiler can run them."""
    found = {}
    for path in (root / "src").rglob("*.py"):
        text = path.read_text("utf-8")
        if "import njit" in text:
            found[_name(path.relative_to(root / "src"))] = "numba.extending" in text
    return found


def plain_modules(root: Path, changed: Path) -> tuple[list[str], bool]:
    """Return the compiled modules that a changed file reaches, and whether one of them must be compiled again."""
    compiled = compiled_modules(root)
    imports = {name: _imported(root / "src" / (name.replace(".", "/") + ".py")) for name in compiled}
    reached = {_name(changed.relative_to("src"))}
    grown = True
    while grown:
        more = {name for name in compiled if name not in reached and imports[name] & reached}
        reached |= more
        grown = bool(more)
    found = reached & compiled.keys()
    return sorted(found), any(compiled[name] for name in found)


def run_plainly(modules: Iterable[str]) -> None:
    """Let the functions of these modules run as they are written; division by zero and overflow stay silent in them."""
    import numba

    chosen = frozenset(modules)
    compile_it = numba.njit
    quiet: list[bool] = []  # whether a compiled function has been entered; setting it for each costs too much

    def njit(*signature: Any, **options: Any) -> Any:
        def decorate(function: Callable[..., Any]) -> Any:
            if function.__module__ not in chosen:
                return compile_it(*signature, **options)(function)
            if getattr(function, "py_func", None) is not None:
                return function

            @wraps(function)
            def run(*arguments: Any, **named: Any) -> Any:
                if quiet:
                    return function(*arguments, **named)
                quiet.append(True)
                try:
                    with np.errstate(all="ignore"):
                        return function(*arguments, **named)
                finally:
                    quiet.pop()

            return run

        if len(signature) == 1 and callable(signature[0]) and hasattr(signature[0], "__code__"):
            function, signature = signature[0], ()
            return decorate(function)
        return decorate

    numba.njit = njit


def _imported(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found


def _name(path: Path) -> str:
    parts = list(path.with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
