"""What a watcher makes of each reading: its number and time, the pads it knows, what is a press, what names it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from varishold.live import PadLayout, Sample
from varishold.live.watcher import Watcher


def _at(k: int, **pads: Any) -> Sample:
    return Sample(k / 100, 1e9 + k / 100, k, {name: np.asarray(values, float) for name, values in pads.items()})


def _noise(k: int, shape: tuple[int, ...] = (6, 8)) -> np.ndarray:
    return np.random.default_rng(k).normal(20, 1, shape)


def test_readings_are_numbered_in_their_order_or_as_is_said() -> None:
    watcher = Watcher()
    assert (watcher.now_s, watcher.meanwhile(), watcher.finish()) == (0.0, None, None)
    seen = [watcher.see(_at(0, pad=_noise(0))), watcher.see(_at(3, pad=_noise(1)), number=7)]
    seen.append(watcher.see(_at(5, pad=_noise(2))))
    assert [(one.number, one.time_s) for one in seen] == [(0, 0.0), (7, 0.03), (8, 0.05)]
    assert watcher.now_s == 0.05
    last = watcher.finish()
    assert last is not None
    assert (last.number, last.time_s, last.sample, last.ended) == (9, 0.05, None, None)
    assert (list(last.pads), last.pads["pad"].tracks, last.touched) == (["pad"], (), False)


def test_pads_are_as_their_source_says_where_that_fits() -> None:
    layouts = {"a": PadLayout((6, 8), unit="kPa"), "b": PadLayout((9, 9)), "c": PadLayout((5,), "signals")}
    watcher = Watcher(layouts)
    frames = {"a": _noise(0), "b": _noise(1), "c": _noise(2, (5,)), "d": _noise(3, (4, 4))}
    watcher.see(_at(0, **frames))
    told = {name: pad.layout for name, pad in watcher.pads.items()}
    assert told == {"a": layouts["a"], "b": PadLayout((6, 8)), "c": layouts["c"], "d": PadLayout((4, 4))}
    assert set(watcher.newest) == set(frames)
    # Only the newest of each is kept, and pads may come one by one.
    watcher.see(_at(1, a=_noise(9)))
    assert watcher.newest["a"].raw[0, 0] == _noise(9)[0, 0]
    assert watcher.newest["b"].raw[0, 0] == _noise(1)[0, 0]
    # Another shape is another pad: what was known of it is forgotten, of the others it is not.
    pads = dict(watcher.pads)
    watcher.see(_at(2, a=_noise(4, (3, 3))))
    assert watcher.pads["a"] is not pads["a"]
    assert watcher.pads["b"] is pads["b"]
    assert watcher.pads["a"].layout == PadLayout((3, 3))
    # What the source tells later is taken of pads that are new.
    watcher.layouts = {**layouts, "e": PadLayout((3, 3), unit="N")}
    watcher.see(_at(3, e=_noise(4, (3, 3))))
    assert watcher.pads["e"].layout.unit == "N"


def _heap(k: int) -> np.ndarray:
    return _noise(k) + 60 * (150 <= k < 200) * np.exp(-((np.mgrid[:6, :8][1] - 4) ** 2))


def _press(watcher: Watcher, **others: Any) -> list[Any]:
    return [watcher.see(_at(k, pad=_heap(k), **{n: v(k) for n, v in others.items()})) for k in range(260)]


def test_a_press_is_of_the_pads_that_feel_pressure() -> None:
    watcher = Watcher({"field": PadLayout((5,), "signals")})
    seen = _press(watcher, field=lambda k: _noise(k, (5,)), other=lambda k: _noise(k + 1000))
    (ended,) = [one.ended for one in seen if one.ended is not None]
    assert set(ended.press.pads) == {"pad", "other"}
    assert (ended.number, ended.press.fields["pad"].shape) == (0, (6, 8))
    assert 1.48 <= ended.start_s <= 1.55
    assert 1.95 <= ended.end_s <= 2.05
    assert not any(one.named for one in seen)


class Namer:
    """Names what it is asked for when a test says."""

    def __init__(self) -> None:
        self.idle, self.asked, self.named, self.waits, self.closed = True, [], [], [], 0  # type: ignore[var-annotated]

    def ask(self, kept: Any, *, over: bool) -> None:
        self.asked.append((kept.number, over))

    def done(self) -> list[Any]:
        named, self.named = self.named, []
        return named

    def finish(self, timeout_s: float) -> list[Any]:
        self.waits.append(timeout_s)
        return ["the last"]

    def close(self) -> None:
        self.closed += 1


@pytest.mark.parametrize("believes", [False, True])
def test_presses_are_named_while_they_last_and_objects_when_they_have_ended(believes: bool) -> None:
    watcher, namer = Watcher(), Namer()
    watcher._namer = namer  # type: ignore[assignment]
    watcher._believer = SimpleNamespace(next_object=lambda: None) if believes else None  # type: ignore[assignment]
    seen = _press(watcher)
    so_far = [over for _, over in namer.asked[:-1]]
    assert namer.asked[-1] == (0, True)
    assert so_far == ([] if believes else [False] * len(so_far))
    assert (len(so_far) >= 2) != believes
    assert all(one.named == () for one in seen)
    # Names come with the reading after, or between two.
    namer.named = ["a name"]
    assert watcher.see(_at(260, pad=_noise(1))).named == ("a name",)
    assert watcher.meanwhile() is None
    namer.named = ["another"]
    told = watcher.meanwhile()
    assert told is not None
    assert (told.number, told.named, dict(told.pads), told.sample, told.ended) == (261, ("another",), {}, None, None)
    last = watcher.finish()
    assert last is not None
    assert (last.named, namer.waits, namer.asked[-1]) == (("the last",), [10.0], (0, True))
    assert watcher.finish(0.5) is not None
    assert namer.waits == [10.0, 0.5]
    watcher.close()
    watcher.close()
    assert namer.closed == 1
    assert watcher.meanwhile() is None


def test_a_press_that_lasts_at_the_end_is_released_and_named() -> None:
    watcher, namer = Watcher(), Namer()
    watcher._namer = namer  # type: ignore[assignment]
    for k in range(190):
        watcher.see(_at(k, pad=_heap(k)))
    namer.asked.clear()
    last = watcher.finish()
    assert last is not None
    assert last.ended is not None
    assert [event.kind for event in last.pads["pad"].events] == ["released"]
    assert namer.asked == [(0, True)]
    # Nothing of it is told twice.
    again = watcher.finish()
    assert again is not None
    assert again.ended is None
    assert again.pads["pad"].events == ()
    assert namer.asked == [(0, True)]
