"""How a source and its pads are, in figures and in words."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from varishold.frame import HealthReport
from varishold.live.health import StreamReport
from varishold.live.pad_watcher import PadWatcher
from varishold.live.stream import Stream
from varishold.live.watcher import Seen
from varishold.report.quantities import length, number, reading

__all__ = ["source_status"]

# Pads whose size is told, and remarks on taxels.
_MOST_PADS, _MOST_REMARKS = 6, 8
# A clock is called right that is off by less than so many millionths.
_RIGHT_PPM = 1.0


def source_status(stream: Stream, pads: Mapping[str, PadWatcher], newest: Seen | None) -> dict[str, Any]:
    """Return how a source is, as JSON holds it.

    Parameters
    ----------
    stream : Stream
    pads : mapping of str to PadWatcher
        Those that have been seen.
    newest : Seen or None
        The newest reading.
    """
    now_s = time.time()
    sent = stream.health.report(now_s)
    # Of a source that has said nothing yet, since it was opened.
    silent_s = sent.silent_s if sent.received else max(now_s - stream.changes[-1].host_time_s, 0.0)
    taxels = {name: pad.how_it_is() for name, pad in pads.items()}
    return {
        "address": stream.address,
        "state": stream.state,
        "words": stream.words,
        "rate_hz": round(sent.rate_hz, 1),
        "received": stream.received,
        "silent_s": round(silent_s, 2),
        "facts": [list(fact) for fact in (*_of_stream(sent, stream), *_of_pads(pads), *_of_noise(newest))],
        "remarks": [*sent.remarks, *_remarks({name: report.remarks for name, report in taxels.items()}), *_odd(newest)],
        "broken": {name: _broken(report) for name, report in taxels.items()},
        "zero": {name: pad.zero.state for name, pad in pads.items()},
        "health": {"stream": sent.to_dict(), "pads": {name: report.to_dict() for name, report in taxels.items()}},
    }


def _of_stream(sent: StreamReport, stream: Stream) -> Iterable[tuple[str, str]]:
    yield "jitter", f"{number(1e3 * sent.jitter_s, 2)}\u202fms"
    if sent.lost is not None:
        yield "lost on the way", str(sent.lost)
    if stream.overrun:
        yield "came too fast", str(stream.overrun)
    if stream.damaged:
        yield "damaged", str(stream.damaged)
    if sent.clock_ppm is not None and not sent.odd_clock:
        off = abs(sent.clock_ppm)
        how = "fast" if sent.clock_ppm > 0 else "slow"
        yield "sensor's clock", "right" if off < _RIGHT_PPM else f"{number(off, 2)}\u202fppm {how}"


def _of_pads(pads: Mapping[str, PadWatcher]) -> Iterable[tuple[str, str]]:
    for name, pad in list(pads.items())[:_MOST_PADS]:
        rows, cols = pad.shape
        pitch = "" if pad.pitch_m is None else f" at {length(pad.pitch_m[0], metres=True)}"
        yield "taxels" if len(pads) == 1 else name, f"{rows} × {cols}{pitch}"


def _of_noise(newest: Seen | None) -> Iterable[tuple[str, str]]:
    known = [] if newest is None else [pad for pad in newest.pads.values() if pad.sigma]
    if known and len({pad.unit for pad in known}) == 1:
        yield "noise σ", reading(max(pad.sigma or 0.0 for pad in known), known[0].unit)


def _remarks(of_pads: Mapping[str, Sequence[str]]) -> list[str]:
    """Return what is said of pads, and of which where there are several."""
    told = [(name, remark) for name, remarks in of_pads.items() for remark in remarks]
    return [remark if len(of_pads) == 1 else f"{name}: {remark}" for name, remark in told[:_MOST_REMARKS]]


def _odd(newest: Seen | None) -> list[str]:
    """Say what is odd about the readings."""
    return [] if newest is None else _remarks({name: pad.remarks for name, pad in newest.pads.items()})


def _broken(report: HealthReport) -> list[list[int]]:
    """Return the places of the taxels that tell nothing."""
    return [[bad.row, bad.col] for bad in report.bad if bad.word in ("dead", "stuck", "open line", "no number")]
