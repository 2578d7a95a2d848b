"""Readings that no sensor means, as of a wrong type of numbers: no error, no warning, and what follows is watched."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold.live import Sample
from varishold.live.watcher import Watcher
from varishold.sensor import Logarithmic, Sensor

Frame = NDArray[np.generic]
BENT = Sensor(polarity="down", rest=1000.0, span=900.0, saturation=0.9, crosstalk=0.05, response=Logarithmic(5.0))


def _one_without_number(rng: np.random.Generator, wrong: float) -> Frame:
    frame = rng.normal(100, 1, (8, 8))
    frame[3, 3] = wrong
    return frame


WILD: dict[str, Callable[[np.random.Generator], Frame]] = {
    "bytes as float32": lambda rng: np.frombuffer(rng.bytes(256), "<f4").reshape(8, 8),
    "bytes as float64": lambda rng: np.frombuffer(rng.bytes(512), "<f8").reshape(8, 8),
    "the largest": lambda rng: rng.uniform(-1, 1, (8, 8)) * 1.7e308,
    "the largest float32": lambda rng: (rng.uniform(-1, 1, (8, 8)) * 3.3e38).astype(np.float32),
    "the smallest": lambda rng: rng.normal(0, 1, (8, 8)) * 1e-310,
    "int64": lambda rng: rng.integers(-(2**63), 2**63 - 1, (8, 8)),
    "uint64": lambda rng: rng.integers(0, 2**64 - 1, (8, 8), dtype=np.uint64),
    "as large as may be": lambda rng: rng.uniform(-1, 1, (8, 8)) * 1e100,
    "one infinite": lambda rng: _one_without_number(rng, np.inf),
    "one nan": lambda rng: _one_without_number(rng, np.nan),
    "all nan": lambda rng: np.full((8, 8), np.nan),
}


@pytest.mark.parametrize("sensor", [None, BENT], ids=["bare", "bent"])
@pytest.mark.parametrize("kind", WILD)
def test_whatever_comes_is_watched_without_a_word_of_a_library(kind: str, sensor: Sensor | None) -> None:
    rng = np.random.default_rng(0)
    with warnings.catch_warnings(), Watcher(sensor=sensor) as watcher:
        warnings.simplefilter("error")
        for number in range(120):
            # Now and then, and from the middle on all the time.
            wild = WILD[kind](rng)
            frame = wild if number % 5 == 0 or number >= 60 else rng.normal(100, 1, (8, 8)).astype(wild.dtype)
            watcher.see(Sample(number / 50, 1e9, number, {"pad": frame}))
        for pad in watcher.pads.values():
            assert isinstance(pad.how_it_is().remarks, tuple)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e300])
def test_a_pad_that_goes_silent_is_told_though_a_taxel_has_no_number(wrong: float) -> None:
    rng = np.random.default_rng(1)
    with Watcher() as watcher:
        for number in range(100):
            frame = _one_without_number(rng, wrong) if number < 60 else np.zeros((8, 8))
            seen = watcher.see(Sample(number / 50, 1e9, number, {"pad": frame}))
        assert any("says nothing" in remark for remark in seen.pads["pad"].remarks)
        assert not seen.touched
