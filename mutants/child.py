"""One run of pytest in a process of its own, forked from one that has loaded the heavy libraries already."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import hypothesis
import pytest
from hypothesis.internal.conjecture import providers

from mutants.calls import Calls

__all__ = ["Outcome", "preload", "run"]

_HOOKS = Path(__file__).parent / "hooks"
_FAULT = 70
_STALLED_S = 120.0
# What is not changed and takes long to load; a run begins with what the tests need of it.
_HEAVY = ("contourpy", "cv2", "hypothesis", "jinja2", "matplotlib", "mujoco", "numpy", "rich", "scipy")
_HEAVY += ("click", "sklearn")


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Parameters
    ----------
    caught_by : str or None
        The first test that failed; "time", with the test that did not end, or how the run ended where none could
        fail; None where all passed.
    seconds : float
        Time on the processor, of the run and all that it started.
    tests : dict
        For each test its seconds on the processor and by the clock, whether it passed, and what it called as
        [file, line]; where calls were noted.
    modules : list of str
        What it loaded that takes long to load and is not changed.
    """

    caught_by: str | None
    seconds: float
    tests: dict[str, Any]
    modules: list[str]


def preload(modules: Sequence[str]) -> None:
    """Load modules, for all runs that follow."""
    for name in modules:
        with contextlib.suppress(ImportError):
            import_module(name)


def run(
    tree: Path,
    files: Sequence[str],
    *,
    only: Sequence[str] | None = None,
    note_calls: bool = False,
    limit_s: float = 1e6,
    patience_s: float = 1e6,
) -> Outcome:
    """Run tests of a tree.

    Parameters
    ----------
    tree : Path
    files : sequence of str
        Test files, in the order in which they are run.
    only : sequence of str, optional
        The tests to run, in order; default: all of the files, to the end even where one fails.
    note_calls : bool
        Whether to note what each test calls.
    limit_s : float
        Seconds on the processor, of any one process.
    patience_s : float
        Seconds by the clock, of any one test: one that waits for what never comes takes next to no time otherwise.
    """
    folder = Path(tempfile.mkdtemp(prefix="mutants-"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    child = os.fork()
    if child == 0:
        status = _FAULT
        try:
            _prepare(tree, folder, note_calls, limit_s)
            status = _pytest(tree, files, only, folder, note_calls)
        except Exception:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
    try:
        ended = _wait(child, folder / "running", patience_s)
    finally:
        with contextlib.suppress(OSError):
            os.killpg(child, signal.SIGKILL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    report = folder / "report.json"
    told = json.loads(report.read_text()) if report.is_file() else {}
    caught = told.get("failed")
    if ended == _FAULT:
        raise RuntimeError(f"pytest could not be started:\n{(folder / 'output').read_text('utf-8', 'replace')[-4000:]}")
    if caught is None and ended != 0:
        caught = "time" if ended in (-signal.SIGXCPU, -signal.SIGKILL) else f"status {ended}"
        running = folder / "running"
        caught += f": {running.read_text()}" if running.is_file() else ""
    shutil.rmtree(folder, ignore_errors=True)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Outcome(caught, round(seconds, 2), told.get("tests", {}), told.get("modules", []))


def _wait(child: int, running: Path, patience_s: float) -> int:
    """Return the child's exit status, or minus the signal that ended it.

    The time on the processor is limited by the system. A busy machine is no reason to end a child, but one whose
    processes have done nothing at all for so long waits for what never comes, as does one that has looked for it in
    one test (`running` was written as it began) for longer than is patient.
    """
    done, since = -1.0, time.monotonic()
    begun = time.time()
    while True:
        found, status = os.waitpid(child, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.01)
        with contextlib.suppress(OSError):
            begun = running.stat().st_mtime
        if time.time() - begun > patience_s:
            os.killpg(child, signal.SIGKILL)
        if time.monotonic() - since > _STALLED_S:
            now = _processor_time(child)
            if now <= done:
                os.killpg(child, signal.SIGKILL)
            done, since = now, time.monotonic()


def _processor_time(group: int) -> float:
    """Return the time on the processor of all processes of a group, in the system's ticks."""
    total = 0.0
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            told = path.read_text("utf-8", "replace").rpartition(")")[2].split()
            if int(told[2]) == group:
                total += sum(map(int, told[11:15]))
    return total


def _prepare(tree: Path, folder: Path, note_calls: bool, limit_s: float) -> None:
    os.setsid()
    seconds = int(min(limit_s, 1e6)) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    output = os.open(folder / "output", os.O_CREAT | os.O_WRONLY)
    os.dup2(output, 1)
    os.dup2(output, 2)
    os.chdir(tree)
    checkout = _HOOKS.parents[1]
    sys.path[:] = [str(tree / "src"), str(tree), *(p for p in sys.path if not _within(p, checkout))]
    os.environ["PYTHONPATH"] = os.pathsep.join(map(str, (tree / "mutants" / "hooks", tree / "src", tree)))
    os.environ["HYPOTHESIS_STORAGE_DIRECTORY"] = str(folder)
    if note_calls:
        os.environ |= {"MUTANTS_CALLS": str(folder), "MUTANTS_ROOT": str(tree)}


def _within(path: str, checkout: Path) -> bool:
    return Path(path or ".").resolve() in (checkout, checkout / "src")


def _pytest(tree: Path, files: Sequence[str], only: Sequence[str] | None, folder: Path, note_calls: bool) -> int:
    # A failure need not be shrunk or explained, and a busy machine is no failure.
    hypothesis.settings.register_profile(
        "mutants",
        database=None,
        deadline=None,
        derandomize=True,
        phases=(hypothesis.Phase.explicit, hypothesis.Phase.generate),
        suppress_health_check=[hypothesis.HealthCheck.too_slow],
    )
    # Examples are drawn from the constants of what is tested, too: a changed constant would draw others.
    known = providers.Constants()
    providers._get_local_constants = lambda: known
    calls = None
    if note_calls:
        calls = Calls(str(tree))
        calls.see_through_caches()
    watcher = _Watcher(only, calls, folder)
    options = [
        "-W",
        "ignore::pytest.PytestAssertRewriteWarning",
        "-p",
        "no:cacheprovider",
        "-p",
        "no:xdist",
        "--hypothesis-profile=mutants",
        "--tb=line",
        "-q",
    ] + ([] if only is None else ["-x"])
    # A source file with examples is loaded anew unless some test has imported it: its classes would then be two.
    collected = sorted(files, key=lambda file: file.startswith("src"))
    status = int(pytest.main([*options, *collected], plugins=[watcher]))
    if watcher.failed is None and status not in (0, 5) and only is not None:
        watcher.failed = "the tests cannot be loaded"
    loaded = [name for name in sys.modules if name.partition(".")[0] in _HEAVY and not name.endswith("__main__")]
    report = {"failed": watcher.failed, "tests": watcher.tests, "modules": loaded}
    (folder / "report.json").write_text(json.dumps(report))
    return 0


class _Watcher:
    """A plugin of pytest: chooses and orders the tests, and notes how they end and what they call."""

    def __init__(self, only: Sequence[str] | None, calls: Calls | None, folder: Path) -> None:
        self._order = None if only is None else {name: k for k, name in enumerate(only)}
        self._calls, self._folder = calls, folder
        self.failed: str | None = None
        self.tests: dict[str, Any] = {}
        self._of_files: dict[str, list[tuple[str, int]]] = {}
        self._of_fixtures: dict[int, list[tuple[str, int]]] = {}

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        order = self._order
        if order is not None:
            items[:] = sorted((item for item in items if item.nodeid in order), key=lambda item: order[item.nodeid])

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(self, collector: Any) -> Any:
        """Note what loading a test file calls: it belongs to each of its tests."""
        if self._calls is None or not isinstance(collector, pytest.File):
            return (yield)
        self._calls.start()
        try:
            return (yield)
        finally:
            self._of_files[collector.nodeid] = self._calls.take()

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Any:
        """Note what making a fixture calls: it belongs to each test that uses it."""
        if self._calls is None:
            return (yield)
        before = self._calls.take()
        self._calls.start()
        try:
            return (yield)
        finally:
            own = self._calls.take()
            self._of_fixtures[id(fixturedef)] = [*self._of_fixtures.get(id(fixturedef), []), *own]
            self._calls.start(before + own)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: Any) -> Any:
        told: dict[str, Any] = {"seconds": 0.0, "clock_s": 0.0, "passed": True}
        self.tests[item.nodeid] = told
        (self._folder / "running").write_text(item.nodeid)
        begun, at = time.process_time(), time.monotonic()
        if self._calls is not None:
            self._calls.start()
        done = yield
        told["seconds"] = round(time.process_time() - begun, 3)
        told["clock_s"] = round(time.monotonic() - at, 3)
        if self._calls is not None:
            called = [*self._calls.take(), *self._of_files.get(item.nodeid.split("::")[0], [])]
            for definitions in item._fixtureinfo.name2fixturedefs.values():
                called += [each for one in definitions for each in self._of_fixtures.get(id(one), [])]
            started = list(self._folder.glob("[0-9]*.json"))
            for path in started:
                called += map(tuple, json.loads(path.read_text()))
                path.unlink()
            told["calls"] = sorted(set(called))
            # Another process loads the package anew, which takes its time beside the test's own.
            told["seconds"] = round(told["seconds"] + 1.5 * len(started), 3)
        return done

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed and self.failed is None:
            self.failed = report.nodeid
        if report.failed or report.skipped:
            self.tests[report.nodeid]["passed"] = False
            self.tests[report.nodeid]["why"] = "failed" if report.failed else "skipped"
