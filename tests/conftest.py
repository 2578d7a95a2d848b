"""Settings for all tests: the same examples every time, and no deadline, for a busy machine makes no property false.

`pytest --hypothesis-profile=fresh` (`make laws`) draws new examples. `pytest --quick` (`make test QUICK=1`) leaves out
the tests that `slow.txt` lists, and tries few examples of the others; `pytest --list-slow` writes that list anew.
"""

from __future__ import annotations

import gc
import os
import shlex
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

SLOW = Path(__file__).with_name("slow.txt")
# Seconds of a test that is slow, and of what several tests share: the next of them would wait for it.
LONG_S, LONG_SHARED_S = 0.1, 1.0

settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("fresh", deadline=None, derandomize=False)
settings.register_profile("quick", deadline=None, derandomize=True, max_examples=10)
settings.load_profile("same")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--quick", action="store_true", help="without the tests that take long, few examples of the others"
    )
    parser.addoption("--list-slow", action="store_true", help="write down which tests take long")


def pytest_configure(config: pytest.Config) -> None:
    # Threads of several processes wait for each other, which takes four times as long; those who come have one each.
    if getattr(config.option, "numprocesses", None):
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if config.getoption("--quick"):
        settings.load_profile("quick")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    # What is collected stays to the end: no collection of garbage need look through it, now or again and again later.
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


def pytest_unconfigure() -> None:
    # Libraries that count their own objects at the very end find them gone.
    gc.unfreeze()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not config.getoption("--quick"):
        return
    slow = set(SLOW.read_text("utf-8").splitlines())
    left = [item for item in items if _name(item.nodeid) in slow]
    items[:] = [item for item in items if _name(item.nodeid) not in slow]
    config.hook.pytest_deselected(items=left)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    if not config.getoption("--list-slow"):
        return
    took: defaultdict[str, float] = defaultdict(float)
    shared = set()
    for reports in terminalreporter.stats.values():
        for report in reports:
            if isinstance(report, pytest.TestReport):
                took[_name(report.nodeid)] += report.duration
                if report.when == "setup" and report.duration > LONG_SHARED_S:
                    shared.add(_home(report.nodeid))
    slow = sorted(name for name, seconds in took.items() if seconds > LONG_S or _home(name) in shared)
    SLOW.write_text("".join(f"{name}\n" for name in slow), "utf-8")
    terminalreporter.write_line(f"{len(slow)} of {len(took)} tests take longer than {LONG_S} s: {SLOW}")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Callable[..., Any]:
    """Return what runs the program as a person does, in a folder of its own: status, output and errors."""
    from varishold.cli import main

    monkeypatch.chdir(tmp_path)

    def run_words(*words: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["varishold", *map(str, words)])
        with pytest.raises(SystemExit) as left:
            main()
        got = capsys.readouterr()
        return int(left.value.code or 0), got.out, got.err

    return run_words


@pytest.fixture(scope="session")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder for what is compiled, one for all processes that tests are spread over."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "compiled"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture
def compiled_once(compiled: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Let `make` compile each source once that several programs share."""
    from tests.compiled_once import words

    monkeypatch.setenv("CC", shlex.join(words(compiled, "cc")))
    return compiled


def _name(node: str) -> str:
    """Return a test's name without its parameters: all of its cases are one."""
    return node.partition("[")[0]


def _home(node: str) -> str:
    """Return the class or the file of a test."""
    return _name(node).rpartition("::")[0]
