"""Which changes of a room its own tests catch."""

from __future__ import annotations

import ast
import hashlib
import json
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mutants import rooms
from mutants.changes import Change, changed, changes, sample
from mutants.child import Outcome, preload, run
from mutants.tree import with_text

__all__ = ["Room", "Verdict"]

_EQUIVALENTS = Path(__file__).with_name("equivalents.toml")


@dataclass(frozen=True)
class Verdict:
    """What became of a change.

    Parameters
    ----------
    file : str
    change : Change
    caught_by : str or None
        What caught it; None where nothing did.
    reason : str or None
        Why it changes nothing that matters, as the list of equivalents says.
    seconds : float
    """

    file: str
    change: Change
    caught_by: str | None
    reason: str | None
    seconds: float

    def __str__(self) -> str:
        end = f"same: {self.reason}" if self.reason else self.caught_by or "SLIPPED THROUGH"
        return f"{self.file}:{self.change.line}  {_short(self.change.was)}  ->  {_short(self.change.now)}  [{end}]"


class Room:
    """A room, its changes and its tests.

    Parameters
    ----------
    name : str
    tree : Path
        A copy of the checkout.
    out : Path
        Folder of what was found so far.
    """

    def __init__(self, name: str, tree: Path, out: Path) -> None:
        self.name, self._tree, self._out = name, tree, out
        self._texts = {str(p): (tree / p).read_text("utf-8") for p in rooms.sources(tree, name)}
        self._test_files = [str(p) for p in rooms.tests(tree, name)]
        self._equivalents = [
            e for e in tomllib.loads(_EQUIVALENTS.read_text("utf-8")).get("equivalent", []) if e["room"] == name
        ]
        self._tests: dict[str, Any] = {}
        self._holding: dict[str, bool] = {}

    def judge(self, number: int, seed: int, *, file: str = "") -> Iterator[Verdict]:
        """Judge a sample of the changes; what was judged before, and is as it was, is not judged again."""
        drawn = sample({f: changes(t) for f, t in self._texts.items() if file in f}, number, seed)
        kept = self._out / f"{self.name}-{seed}.jsonl"
        known = {}
        if kept.is_file():
            for line in kept.read_text("utf-8").splitlines():
                row = json.loads(line)
                known[row["place"]] = row
        tests = {f: _digest((self._tree / f).read_bytes()) for f in self._test_files}
        for age, (path, change) in enumerate(drawn):
            reason = self._reason(path, change)
            place = change.place(change.now, _digest(_scope_text(self._texts[path], change.scope)))
            row = known.get(place)
            if reason is not None:
                yield Verdict(path, change, None, reason, 0.0)
                continue
            if row is None or (row["caught_by"] is None and row["tests"] != tests):
                # What slipped through the tests as they were is shown to those that are new.
                new = [f for f, stamp in tests.items() if row is None or row["tests"].get(f) != stamp]
                caught, seconds = self._try(path, change, age, new)
                row = {
                    "place": place,
                    "tests": tests,
                    "file": path,
                    "scope": change.scope,
                    "was": change.was,
                    "now": change.now,
                    "caught_by": caught,
                    "seconds": seconds,
                }
                with kept.open("a", encoding="utf-8") as out:
                    out.write(json.dumps(row) + "\n")
            yield Verdict(path, change, row["caught_by"], None, row["seconds"])

    def _reason(self, path: str, change: Change) -> str | None:
        for entry in self._equivalents:
            if (
                path.endswith("/" + entry["file"])
                and change.was == entry["was"]
                and change.now == entry.get("now", change.now)
                and change.scope == entry.get("scope", change.scope)
            ):
                return str(entry["reason"])
        return None

    def _try(self, path: str, change: Change, age: int, tests: list[str]) -> tuple[str | None, float]:
        if not self._tests:
            self._tests = self._called()
        only = [name for name in self._order(path, change.scope) if name.split("::")[0] in tests]
        if not only:
            return None, 0.0
        total = 0.0
        while only:
            with with_text(self._tree / path, changed(self._texts[path], change), age):
                done = self._run(only)
                # A test may fail because the machine is busy: only what fails again has caught anything.
                again = self._run([done.caught_by]) if done.caught_by in only else done
            total += done.seconds + again.seconds
            if done.caught_by not in only or (again.caught_by is not None and self._holds(done.caught_by)):
                return done.caught_by, round(total, 2)
            only = only[only.index(done.caught_by) + 1 :]
        return None, round(total, 2)

    def _holds(self, name: str) -> bool:
        """Return whether a test passes where nothing is changed, run as it is with a change."""
        if name not in self._holding:
            self._holding[name] = self._run([name]).caught_by is None
            if not self._holding[name]:
                print(f"{name} fails without any change; it catches nothing", flush=True)
        return self._holding[name]

    def _run(self, only: list[str]) -> Outcome:
        files = list(dict.fromkeys(name.split("::")[0] for name in only))
        limit = 20 + 4 * sum(self._tests[name]["seconds"] for name in only)
        patience = 60 + 10 * max(self._tests[name]["clock_s"] for name in only)
        return run(self._tree, files, only=only, limit_s=limit, patience_s=patience)

    def _order(self, path: str, scope: str) -> list[str]:
        """Return the tests that run the changed lines, quick files first; all of the room for a module's own lines."""
        inner = path.removeprefix("src/")
        users = [name for name, told in self._tests.items() if any(file == inner for file, _ in told["scopes"])]
        hits = [name for name in users if [inner, scope] in self._tests[name]["scopes"]]
        if not hits:
            # It may have stood in another file when the calls were noted.
            hits = [name for name, told in self._tests.items() if any(scope == other for _, other in told["scopes"])]
        if not hits:
            # What is called by threads that Python did not begin is not noted: whoever uses the file may call it.
            hits = users
        if not scope or not hits:
            # A module's own values are read by tests that call nothing of it, too.
            hits = [*users, *(name for name in self._tests if name not in users)]
        cost: dict[str, float] = {}
        for name in hits:
            file = name.split("::")[0]
            cost[file] = cost.get(file, 0.3) + self._cost(name)
        return sorted(hits, key=lambda n: (n not in users, cost[n.split("::")[0]], n.split("::")[0], self._cost(n)))

    def _cost(self, name: str) -> float:
        told = self._tests[name]
        return max(float(told["seconds"]), float(told["clock_s"]))

    def _called(self) -> dict[str, Any]:
        """Return for each test that passes its seconds and the functions that it calls, as [file, scope].

        What a test calls is noted once, and again when the test's file changes.
        """
        cache = self._out / f"{self.name}-calls.json"
        known = json.loads(cache.read_text("utf-8")) if cache.is_file() else {}
        stamps = {f: _digest((self._tree / f).read_bytes()) for f in self._test_files}
        stale = [f for f in self._test_files if known.get(f, {}).get("stamp") != stamps[f]]
        if stale:
            done = run(self._tree, stale, note_calls=True)
            scopes = _Scopes(self._tree / "src")
            for f in stale:
                known[f] = {"stamp": stamps[f], "tests": {}}
            for name, told in done.tests.items():
                if not told["passed"]:
                    if told["why"] == "failed":
                        print(f"{name} fails without any change; it is left out", flush=True)
                    continue
                called = sorted({scopes.of(file, line) for file, line in told["calls"]})
                known[name.split("::")[0]]["tests"][name] = {
                    "seconds": told["seconds"],
                    "clock_s": told["clock_s"],
                    "scopes": called,
                }
            if not done.tests:
                raise SystemExit(f"the tests of {self.name} do not run: {done.caught_by}")
            known["modules"] = sorted({*known.get("modules", []), *done.modules})
            cache.write_text(json.dumps(known), "utf-8")
        preload(known["modules"])
        tests = {name: told for f in self._test_files for name, told in known[f]["tests"].items()}
        return json.loads(json.dumps(tests))  # type: ignore[no-any-return]


class _Scopes:
    """Finds the outermost function of a line."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._of: dict[str, list[tuple[int, int, str]]] = {}

    def of(self, file: str, line: int) -> tuple[str, str]:
        if file not in self._of:
            self._of[file] = list(_functions(ast.parse((self._root / file).read_text("utf-8"))))
        return file, next((name for first, last, name in self._of[file] if first <= line <= last), "")


def _functions(node: ast.AST, prefix: str = "") -> Iterator[tuple[int, int, str]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            first = min([child.lineno, *(d.lineno for d in child.decorator_list)])
            yield first, child.end_lineno or child.lineno, prefix + child.name
        elif isinstance(child, ast.ClassDef):
            yield from _functions(child, f"{prefix}{child.name}.")
        else:
            yield from _functions(child, prefix)


def _scope_text(source: str, scope: str) -> str:
    if not scope:
        return ""
    lines = source.splitlines()
    found = [lines[first - 1 : last] for first, last, name in _functions(ast.parse(source)) if name == scope]
    return "\n".join("\n".join(part) for part in found)


def _digest(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 90 else line[:87] + "..."
