"""Sources that somebody else wrote: what is wrong with what they bring is said, and what they bring stays as it was."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from varishold.errors import EndOfSourceError, InputError
from varishold.live import PadLayout, Sample, Stream, samples_of, watch
from varishold.live.recorder import Recorder


class Own:
    """Brings what a test gives it, then ends."""

    address = "own"
    pads: Mapping[str, PadLayout] = {}

    def __init__(self, *brings: Any) -> None:
        self.brings = list(brings)

    def open(self) -> None:
        pass

    def read(self, timeout_s: float) -> Any:
        if not self.brings:
            raise EndOfSourceError("over")
        return self.brings.pop(0)

    def close(self) -> None:
        pass


GOOD = Sample(0.0, 1e9, 0, {"pad": np.ones((4, 4))})
WRONG = [
    (None, "own: read must return a list of Sample, got NoneType"),
    (GOOD, "own: read must return a list of Sample, got Sample"),
    ([GOOD.pads["pad"]], "own: read must return a list of Sample, got ndarray in it"),
    ([GOOD._replace(pads=[1])], "own: pads of a Sample must be a mapping of names to arrays, got list"),
    ([GOOD._replace(pads={"pad": [[1]]})], "own: pad 'pad' must be an array, got list"),
    ([GOOD._replace(host_time_s=None)], "own: host_time_s of a Sample must be seconds since 1970, got None"),
    ([GOOD._replace(device_time_s="1")], "own: device_time_s of a Sample must be seconds or None, got '1'"),
    ([GOOD._replace(sequence=1.5)], "own: sequence of a Sample must be a whole number or None, got 1.5"),
]


@pytest.mark.parametrize("every", [False, True])
@pytest.mark.parametrize(("brings", "words"), WRONG)
def test_what_a_source_brings_that_is_no_reading_is_said(brings: Any, words: str, every: bool) -> None:
    with pytest.raises(InputError) as told:
        list(watch(Own([GOOD], brings), every=every))
    assert str(told.value) == words


def test_a_recorder_says_it_too_and_keeps_what_came(tmp_path: Any) -> None:
    path = tmp_path / "a.mcap"
    with pytest.raises(InputError, match="must be an array, got list"), Recorder(Own([GOOD], *WRONG[4][:1]), path) as r:
        r.wait(10.0)
    assert path.exists()


@pytest.mark.parametrize(
    "values", [np.ones((2, 2, 2)), np.array(1.0), np.array([["1"]]), np.ones((2, 2), complex)], ids=lambda v: v.dtype
)
def test_what_is_no_pad_is_said(values: np.ndarray) -> None:
    with pytest.raises(InputError, match="pad 'pad' must be numbers of one or two dimensions, got"):
        list(watch(Own([GOOD._replace(pads={"pad": values})]), every=True))


@pytest.mark.parametrize(
    ("thing", "words"),
    [(Own, r"got the class Own; write Own\(\)"), ([1], "list lacks address"), (None, "NoneType lacks address")],
)
def test_what_is_no_source_is_said(thing: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        list(watch(thing))
    with pytest.raises(InputError, match=words):
        list(samples_of(thing))


def test_taxels_outside_the_pad_are_said() -> None:
    source = Own([GOOD])
    source.pads = {"pad": PadLayout((4, 4), gaps=(16,))}
    with pytest.raises(InputError, match="places of taxels must be 0 to 15, got 16 to 16"):
        list(watch(source, every=True))


class OneBuffer(Own):
    """Writes each reading into the same array, as drivers do."""

    def __init__(self, *, view: bool) -> None:
        super().__init__(*range(5))
        self.buffer, self.view = np.zeros((2, 3)), view

    def read(self, timeout_s: float) -> Any:
        self.buffer[:] = super().read(timeout_s)
        return [GOOD._replace(pads={"pad": self.buffer[:] if self.view else self.buffer})]


@pytest.mark.parametrize("view", [False, True])
def test_a_source_may_use_its_buffer_again(view: bool) -> None:
    assert [sample.pads["pad"][0, 0] for sample in [*samples_of(OneBuffer(view=view))]] == [0, 1, 2, 3, 4]
    with Stream(OneBuffer(view=view)) as stream:
        stream._thread.join()
        assert [sample.pads["pad"][0, 0] for sample in stream.reader()] == [0, 1, 2, 3, 4]
