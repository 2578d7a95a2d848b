"""``varishold demo``: the program at work, with nothing given."""

from __future__ import annotations

import tempfile
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from varishold.cli.browser import show_page
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Writes
from varishold.cli.options import refuse_given
from varishold.cli.printing import echo

if TYPE_CHECKING:
    from types import ModuleType

_INSTALLED = Path(__file__).parents[1] / "examples"
#: Where the examples are: in an installed package, or in a checkout.
EXAMPLES = _INSTALLED if _INSTALLED.is_dir() else Path(__file__).parents[3] / "examples"

_OBJECT, _SIZE_M, _SEED = "hexagonal-prism", 0.05, 5
_SKIN = "sim:sphere?seed=1"


class Demo(StrEnum):
    """What can be shown."""

    touch = "touch"
    live = "live"
    perceive = "perceive"
    learn = "learn"


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(demo)


def demo(
    what: Annotated[
        Demo,
        Argument(
            "touch: names of surfaces in a recording. live: a simulated skin in the browser. perceive: an object "
            "that a simulated hand touches. learn: five things learned from ten presses each.",
            metavar="[touch|live|perceive|learn]",
        ),
    ] = Demo.touch,
    report: Annotated[
        Path | None, Option("Write the page here. Default: a new temporary folder."), Writes("page")
    ] = None,
    no_open: Annotated[bool, Option("Do not open the page in a browser.")] = False,
) -> None:
    """Show what this program does: no file, no sensor and no settings are needed."""
    if what is Demo.live:
        from varishold.cli.live import live

        refuse_given("report", because="is a page that is written, and that of live is served: leave it out")
        _say("live", _SKIN, *(["--no-open"] if no_open else []))
        live(_SKIN, no_open=no_open)
        return
    page = Path(tempfile.mkdtemp(prefix="varishold-")) / f"{what}.html" if report is None else report
    {Demo.touch: _touch, Demo.perceive: _perceive, Demo.learn: _learn}[what](page)
    if not no_open and show_page(page.absolute().as_uri()):
        return
    echo(f"open it in a browser: {page}")


def _say(*words: object) -> None:
    """Print the command that does the same."""
    echo(" ".join(["$ varishold", *map(str, words)]))


def _touch(page: Path) -> None:
    from varishold.cli.touch import touch

    recording = str(EXAMPLES / "surfaces.npz")
    _say("touch", recording, "--frames", "press", "--report", page)
    touch([recording], frames="press", report=page)


def _perceive(page: Path) -> None:
    from varishold.cli.perceive import perceive

    _say("perceive", _OBJECT, "--size-m", _SIZE_M, "--seed", _SEED, "--report", page)
    perceive(_OBJECT, size_m=_SIZE_M, seed=_SEED, report=page)


def _learn(page: Path) -> None:
    from varishold.cli.evaluate import evaluate
    from varishold.cli.progress import progress_bar
    from varishold.recording import write

    things = _script("five_things")
    with tempfile.TemporaryDirectory(prefix="varishold-") as folder:
        days = [Path(folder, f"{name}.npz") for name in things.DAYS]
        with progress_bar("five things are pressed ten times each on three days", len(days)) as update:
            for seed, day in enumerate(days):
                write(things.day(day.stem, seed), day)
                update(advance=1)
        _say("evaluate", *days, "--label", "thing", "--group", "day", "--no-peers", "--shots", 0, "--report", page)
        evaluate([str(day) for day in days], label="thing", group="day", shots="0", peers=False, report=page)


def _script(name: str) -> ModuleType:
    """Return an example as a module."""
    from importlib.util import module_from_spec, spec_from_file_location

    spec = spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
