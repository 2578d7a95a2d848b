"""``varishold record``: what a sensor says, kept as it came."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.printing import echo, print_json, tell
from varishold.cli.silence import Silence
from varishold.errors import InputError, LostSourceError

if TYPE_CHECKING:
    from threading import Event

    from varishold.live import Recorder, Stream
    from varishold.live.sample_file import Limits
    from varishold.live.stream import Change

# A source that is not there for so long, or says nothing, is given up where nothing has come yet. Seconds.
_PATIENCE_S = 10.0
# So often the program looks whether it is over. Seconds.
_LOOK_S = 0.1
# Samples that wait while this machine is busy with something else.
_KEPT = 4096


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(record)


def record(
    source: Annotated[
        str,
        Argument("Where the readings come from, as in sim:sphere or serial:/dev/ttyACM0?preset=flexitac."),
        Reads("source"),
    ],
    out: Annotated[
        Path,
        Option("The file: .mcap, or .npz, which is made at the end.", short="-o", metavar="FILE"),
        Writes("measurement"),
    ],
    seconds: Annotated[float | None, Option("End after so long; else at Ctrl-C or with the source.", min=0.0)] = None,
    frames: Annotated[int | None, Option("End after so many readings.", min=1)] = None,
    sensor: Annotated[
        str | None,
        Option(
            "Sensor file (TOML) or a preset's name, to be put into the file; else one that stands beside it.",
            metavar="SENSOR",
        ),
        Reads("sensor"),
    ] = None,
    label: Annotated[str | None, Option("What is felt, to be written beside the readings.")] = None,
    json: Annotated[bool, Option("Print what was written as JSON.")] = False,
    force: Annotated[bool, Option("Replace a file that is there.")] = False,
) -> None:
    """Write every reading of a source to a file that is whole whenever it ends."""
    from varishold.cli.inputs import files_beside
    from varishold.cli.interrupts import until_stopped
    from varishold.cli.recordings import sensor_beside
    from varishold.files import check_output
    from varishold.live import Recorder, source_at
    from varishold.live.address import parse_address, replayed_file
    from varishold.live.sample_file import Limits
    from varishold.live.stream import Stream
    from varishold.sensor import sensor_texts

    address, opened = parse_address(source), source_at(source)
    # MCAP is whole at any moment; another format is made of it when all has come.
    written = out if _ending(out) == ".mcap" else out.with_name(f"{out.name}.mcap")
    beside = map(str, files_beside([out]) if sensor is None else ())
    inputs = [*replayed_file(source), *beside]
    for path in (written, out):
        check_output(path, "measurement", inputs=inputs, force=force)
    known = sensor_beside(str(out), sensor)
    files, name = ({}, "") if known is None else (sensor_texts(known), known.name)
    limits = Limits(frames, seconds)
    with ExitStack() as stack:
        stop = stack.enter_context(until_stopped())
        stream = None if address.can_wait else stack.enter_context(Stream(opened, keep=_KEPT))
        recorder = stack.enter_context(Recorder(stream or opened, written, sensor=name, files=files, limits=limits))
        if label is not None:
            recorder.mark(label)
        _wait(recorder, stream, limits, stop)
    if not recorder.tally.samples:
        told = "" if stream is None else stream.words
        words = recorder.damage or f"nothing came{': ' * bool(told)}{told}"
        raise LostSourceError(f"{source}: {words}; {out} is not written")
    if written != out:
        _convert(written, out)
    _tell(recorder, out, json=json)


def _ending(path: Path) -> str:
    ending = path.suffix.lower()
    if ending not in (".mcap", ".npz"):
        raise InputError(f"{path}: its name must end in .mcap or .npz, which is how it is written")
    return ending


def _wait(recorder: Recorder, stream: Stream | None, limits: Limits, stop: Event) -> None:
    """Wait until it is over, and tell what there is to tell meanwhile."""
    from varishold.cli.progress import progress_bar
    from varishold.live.losses import Losses
    from varishold.live.since import since

    begun_s, losses = time.monotonic(), Losses()
    looked: Change | None = None
    silence, refusal_told = Silence(recorder.address), False
    with progress_bar("recorded", limits.samples) as show:
        while not recorder.wait(_LOOK_S) and not stop.is_set():
            show(completed=recorder.tally.samples)
            came = recorder.tally.samples + recorder.tally.refused
            silence.look(came, recorder, is_open=stream is None or stream.state == "open")
            if recorder.tally.refused and not refusal_told:
                refusal_told = True
                tell(f"{recorder.address}: {recorder.tally.why}; such readings are not written")
            if stream is None:
                continue
            for change in since(stream.changes, looked):
                looked = change
                if losses.is_news(change):
                    tell(f"{change.words}; trying again")
            # What is open may be silent for long, unless it was said how long all is to take.
            in_vain = not recorder.tally.samples and (stream.state != "open" or limits.seconds is not None)
            if in_vain and time.monotonic() - begun_s > _PATIENCE_S + (limits.seconds or 0.0):
                return


def _convert(written: Path, out: Path) -> None:
    """Make the file that was asked for of the one that was written."""
    from varishold.files import LARGEST_BYTES
    from varishold.recording import read, write

    try:
        recording = read(written)
        size = sum(pad.frames.nbytes for pad in recording.pads.values())
        if size > LARGEST_BYTES:
            raise InputError(f"{size} bytes of frames are more than an NPZ file is read with ({LARGEST_BYTES})")
        write(recording, out)
    except (InputError, MemoryError) as error:
        raise InputError(f"{out}: cannot be made: {error}; all that came is in {written}") from error
    written.unlink()


def _tell(recorder: Recorder, out: Path, *, json: bool) -> None:
    from varishold.live.lull import unused_words

    tally = recorder.tally
    if tally.odd_clock:
        tell(f"{out}: {tally.odd_clock}; the times were written as they came")
    if json:
        told = {"file": str(out), "frames": tally.samples, "seconds": tally.seconds, "rate_hz": tally.rate_hz}
        told |= {"lost": tally.lost, "missed": recorder.missed, "refused": tally.refused, "why": tally.why}
        told |= {"damaged": recorder.damaged, "overrun": recorder.overrun}
        print_json({**told, "odd_clock": tally.odd_clock})
        return
    rate = "" if tally.rate_hz is None else f", {tally.rate_hz:.4g} a second"
    words = [f"{out}: {counted(tally.samples, 'frame')} in {tally.seconds:.2f} s{rate}"]
    if tally.lost:
        words.append(f"{tally.lost} never came, by the sensor's own numbers")
    if recorder.overrun:
        words.append(f"{recorder.overrun} came faster than they could be read")
    if recorder.missed:
        words.append(f"{recorder.missed} came faster than they could be written")
    if tally.refused:
        words.append(f"{counted(tally.refused, 'was', 'were')} not written: {tally.why}")
    if recorder.damaged:
        words.append(unused_words(recorder.damaged, damage=recorder.damage))
    echo("; ".join(words if len(words) > 1 else [*words, "none lost"]))
