"""``varishold live``: watch a sensor while it is touched."""

from __future__ import annotations

import sys
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from varishold.cli.browser import show_page
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.options import refuse_given
from varishold.cli.printing import echo, print_json, tell
from varishold.cli.silence import Silence
from varishold.errors import InputError

if TYPE_CHECKING:
    from varishold.learning import PressClassifier
    from varishold.live.losses import Losses
    from varishold.live.stream import Change
    from varishold.live.watcher import Seen
    from varishold.perceive import Perceiver

_PORT = 8765
# So often the program looks whether it is over. Seconds.
_LOOK_S = 0.2


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(live)


def live(
    source: Annotated[
        str,
        Argument("Where the readings come from, as in sim:sphere or serial:/dev/ttyACM0?preset=flexitac."),
        Reads("source"),
    ],
    sensor: Annotated[
        str | None,
        Option("Sensor file (TOML) or a preset's name (varishold sensor list).", metavar="SENSOR"),
        Reads("sensor"),
    ] = None,
    model: Annotated[
        Path | None,
        Option("Learned model, or library of objects (NPZ): names each press.", metavar="MODEL"),
        Reads(),
    ] = None,
    levels: Annotated[int, Option("Thresholds a contact.", min=4, max=512)] = 32,
    port: Annotated[
        int | None, Option("Port of the page, 0 for one that is free; else 8765.", min=0, max=65535)
    ] = None,
    host: Annotated[
        str, Option("Where the page listens; 0.0.0.0 for the whole network, which sees and may zero all.")
    ] = "127.0.0.1",
    folder: Annotated[
        Path,
        Option("Where recordings and models of the page are written.", metavar="DIR"),
        Writes("recording", folder=True),
    ] = Path(),
    foxglove: Annotated[bool, Option("Serve Foxglove's app too: open a connection to ws://localhost:8765.")] = False,
    no_open: Annotated[bool, Option("Do not open the page in a browser.")] = False,
    json: Annotated[bool, Option("Print JSON Lines: frames, events, presses; no page unless --port is given.")] = False,
) -> None:
    """Say what touches a sensor while it touches: on a page, or as JSON Lines."""
    from varishold.cli.recordings import sensor_for
    from varishold.live.address import replayed_file
    from varishold.live.sources import source_at

    # A recording's sensor file stands beside it.
    beside = next(iter(replayed_file(source)), "")
    watched: dict[str, Any] = {
        "sensor": sensor_for(beside, sensor) if beside or sensor is not None else None,
        "model": _model(model),
        "levels": levels,
    }
    if json and port is None and not foxglove:
        refuse_given("host", "folder", because="is of the page, and with --json there is none without --port: give it")
        _print_lines(source, **watched)
        return
    if not folder.is_dir():
        # Who presses Record would be told, and has lost what came until then.
        raise InputError(f"{folder}: there is no such folder; make it first")
    from varishold.live.door import is_loopback
    from varishold.live.server import PageServer
    from varishold.live.session import Session

    with (
        Session(source_at(source), on_seen=_print_seen if json else None, folder=folder, **watched) as session,
        PageServer(session, host=host, port=_PORT if port is None else port, viewers=foxglove) as server,
    ):
        if not json:
            echo(f"{server.address}  (Ctrl-C ends)")
            if not is_loopback(host):
                echo("everybody on the network can look, and press its buttons")
            if foxglove:
                echo(f"{server.address.replace('http', 'ws').rstrip('/')}  for Foxglove's app")
            sys.stdout.flush()
            if not no_open:
                show_page(server.address)
        # The page of a source that has ended can still be looked at.
        stream = session.stream
        silence = Silence(stream.address)
        while not (session.wait_over(_LOOK_S) and (json or session.failure is not None)):
            silence.look(stream.received, stream, is_open=stream.state == "open")
            time.sleep(_LOOK_S)
        if session.failure is not None:
            raise session.failure


def _model(path: Path | None) -> PressClassifier | Perceiver | None:
    if path is None:
        return None
    from varishold.files.archive import open_archive

    with open_archive(path) as archive:
        is_library = "head" in archive.names
    if is_library:
        from varishold.perceive import Perceiver, read_library

        return Perceiver(read_library(path))
    from varishold.learning import read_model

    return read_model(path)


def _print_lines(source: str, **watched: Any) -> None:
    """Print lines until the source ends; every reading's where the source can wait."""
    from varishold.live.address import parse_address
    from varishold.live.losses import Losses
    from varishold.live.odd_clock import OddClock
    from varishold.live.watching import watch

    clock, told = OddClock(), False
    on_change = partial(_tell_change, source, Losses())
    for seen in watch(source, every=parse_address(source).can_wait, on_change=on_change, **watched):
        if seen.sample is not None:
            clock.look(seen.sample)
        if clock.words and not told:
            told = True
            tell(f"{source}: {clock.words}; the time of arrival is taken")
        _print_seen(seen)


def _print_seen(seen: Seen) -> None:
    from varishold.live.lines import lines_of

    for line in lines_of(seen):
        print_json(line)
    sys.stdout.flush()


def _tell_change(source: str, losses: Losses, change: Change) -> None:
    from varishold.live.lines import change_line

    print_json(change_line(change))
    sys.stdout.flush()
    if losses.is_news(change):
        tell(f"{change.words}; trying again")
    elif change.state not in ("lost", "ended") and change.words:
        tell(f"{source}: {change.words}")
