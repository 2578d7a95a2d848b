"""A stream of a lab, without a network: what its description says, and the library that is told to be quiet."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.live_clock import Clock

from varishold.errors import InputError, LostSourceError
from varishold.live import PadLayout, source_at
from varishold.live.sources import lab_stream


@pytest.mark.parametrize("own", [False, True])
def test_a_configuration_of_ones_own_is_kept(own: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told: list[str] = []
    monkeypatch.setitem(sys.modules, "pylsl", SimpleNamespace(set_config_content=told.append))
    monkeypatch.setattr(lab_stream.Path, "home", lambda: tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("LSLAPICFG", raising=False)
    if own:
        monkeypatch.setenv("LSLAPICFG", str(tmp_path / "mine.cfg"))
    lab_stream._library.__wrapped__()
    assert len(told) == (0 if own else 1)
    told.clear()
    monkeypatch.delenv("LSLAPICFG", raising=False)
    (tmp_path / "lsl_api").mkdir()
    (tmp_path / "lsl_api" / "lsl_api.cfg").touch()
    lab_stream._library.__wrapped__()
    assert told == []


# What a stream says of itself.


class Element:
    """A part of a description: texts, and parts that follow each other."""

    def __init__(self, texts: dict[str, str], parts: list[Element] | None = None, after: list[Element] | None = None):
        self._texts, self._parts, self._after = texts, parts or [], after or []

    def child_value(self, name: str) -> str:
        return self._texts.get(name, "")

    def child(self, name: str) -> Element:
        first, *others = self._parts or [Element({})]
        return Element(first._texts, first._parts, others) if first._texts or first._parts else first

    def next_sibling(self, name: str) -> Element:
        return Element(self._after[0]._texts, [], self._after[1:]) if self._after else Element({})

    def empty(self) -> bool:
        return not self._texts and not self._parts


def _described(texts: dict[str, str], channels: list[dict[str, str]], **about: Any) -> Any:
    parts = [Element({}, [Element(channel) for channel in channels])] if channels else []
    usual = {"channel_count": 6, "channel_format": 1, "nominal_srate": 0.0, "source_id": "mine"}
    told = {key: lambda value=value: value for key, value in {**usual, **about}.items()}
    return SimpleNamespace(desc=lambda: Element(texts, parts), **told)


class Laboratory:
    """As much of the library as a source calls, and a stream behind it."""

    util = SimpleNamespace(LostError=ConnectionError, TimeoutError=TimeoutError)

    def __init__(self, *infos: Any, chunks: list[list[Any]] | None = None) -> None:
        self.infos, self.chunks = list(infos), chunks or []
        self.asked: list[Any] = []
        self.closed, self.late_s = 0, 0.0

    def resolve_byprop(self, what: str, name: str, *, minimum: int, timeout: float) -> list[Any]:
        self.asked.append((what, name, minimum))
        return self.infos

    def StreamInlet(self, info: Any, *, max_buflen: int, recover: bool) -> Laboratory:
        self.asked.append((info, max_buflen, recover))
        self.told = info
        return self

    def open_stream(self, timeout: float) -> None:
        if timeout < self.late_s:
            raise TimeoutError("too late")

    def info(self, timeout: float) -> Any:
        return self.told

    def close_stream(self) -> None:
        self.closed += 1

    def pull_sample(self, timeout: float) -> Any:
        if not self.chunks:
            raise ConnectionError("gone")
        return self.chunks[0].pop(0)

    def pull_chunk(self, timeout: float, max_samples: int) -> Any:
        taken = self.chunks.pop(0)[:max_samples]
        return [values for values, _ in taken], [at_s for _, at_s in taken]


def _opened(laboratory: Laboratory, address: str = "lsl:skin") -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lab_stream, "_library", lambda: laboratory)
        source: Any = source_at(address)
        source.open()
    return source


sizes = st.sampled_from(["", "1", "2", "3", "6", "2.0", "0", "-2", "nan", "inf", "many", "1048576"])
channels = st.lists(
    st.fixed_dictionaries({"label": st.sampled_from(["", "a", "b", "c"]), "unit": st.sampled_from(["", "uT", "mT"])})
    | st.builds(lambda k: {"label": f"s{k}", "unit": "uT"}, st.integers(0, 9)),
    max_size=7,
)


@given(sizes, sizes, sizes, channels, st.sampled_from(["", "?shape=3x2", "?shape=2x2"]))
@settings(max_examples=300)
def test_a_stream_is_what_its_description_says(
    rows: str, cols: str, pitch: str, listed: list[dict[str, str]], asked: str
) -> None:
    def number(text: str) -> float | None:
        try:
            value = float(text)
        except ValueError:
            return None
        return value if math.isfinite(value) and 0 < value < 2**20 else None

    info = _described({"rows": rows, "cols": cols, "pitch_m": pitch}, listed)
    shape = {"?shape=3x2": (3, 2), "?shape=2x2": (2, 2)}.get(asked)
    high, wide = number(rows), number(cols)
    if shape is None and high is not None and wide is not None:
        shape = int(high), int(wide)
    if shape is not None and shape[0] * shape[1] != 6:
        with pytest.raises(InputError, match=f"has 6 channels, which are no {shape[0]} x {shape[1]}; add") as told:
            _opened(Laboratory(info), f"lsl:skin{asked}")
        assert getattr(told.value, "parameter", None) == "shape"
        return
    labels, units = [each["label"] for each in listed], {each["unit"] for each in listed} - {""}
    unit = units.pop() if len(units) == 1 else "raw"
    layout = _opened(Laboratory(info), f"lsl:skin{asked}").pads["pad"]
    spacing = number(pitch)
    if shape is not None:
        assert layout == PadLayout(shape, unit=unit, pitch_m=None if spacing is None else (spacing, spacing))
    elif len(labels) == len(set(labels)) == 6 and "" not in labels:
        assert layout == PadLayout((6,), "signals", unit=unit, names=tuple(labels))
    else:
        assert layout == PadLayout((6,), unit=unit)


@pytest.mark.parametrize(
    ("number", "dtype"), [(1, "f4"), (2, "f8"), (3, None), (4, "i4"), (5, "i2"), (6, "i1"), (7, "i8"), (0, None)]
)
def test_readings_come_in_the_type_and_the_order_in_which_they_were_sent(
    number: int, dtype: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    info = _described({"rows": "2", "cols": "3"}, [], channel_format=number)
    frames = [[k, 1, 2, 3, 4, 5] for k in range(4)]
    times = [5.0, math.nan, 5.5, math.inf]
    chunks = [list(zip(frames, times, strict=True)), [([9] * 6, 7.0)], [(None, 0.0)]]
    laboratory = Laboratory(info, chunks=chunks)  # type: ignore[arg-type]
    clock = Clock(monkeypatch, lab_stream)
    if dtype is None:
        with pytest.raises(InputError, match="sends text; a stream of numbers is needed"):
            _opened(laboratory)
        return
    source = _opened(laboratory)
    monkeypatch.setattr(lab_stream, "_library", lambda: laboratory)
    samples = source.read(0.1)
    assert [one.pads["pad"].tolist() for one in samples] == [[six[:3], six[3:]] for six in frames]
    assert [one.device_time_s for one in samples] == [5.0, None, 5.5, None]
    assert {(one.host_time_s, one.sequence, one.pads["pad"].dtype) for one in samples} == {
        (clock.time(), None, np.dtype(dtype))
    }
    (alone,) = source.read(0.1)
    assert (alone.device_time_s, alone.pads["pad"].tolist()) == (7.0, [[9] * 3] * 2)
    # A stream that promises nothing may be silent.
    clock.sleep(60)
    assert source.read(0.1) == []
    laboratory.chunks.clear()
    with pytest.raises(LostSourceError, match="the stream has ended"):
        source.read(0.1)
    source.close()
    source.close()
    assert laboratory.closed == 1
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.1)


def test_the_stream_of_its_name_and_source_is_opened_and_not_brought_back_behind_our_back() -> None:
    first, second = (_described({}, [], source_id=name) for name in ("one", "two"))
    laboratory = Laboratory(first, second)
    _opened(laboratory)
    assert laboratory.asked[0] == ("name", "skin", 1)
    assert laboratory.asked[1][0] is first
    assert 1 <= laboratory.asked[1][1] <= 60
    assert laboratory.asked[1][2] is False
    _opened(laboratory, "lsl:skin?source=two")
    assert laboratory.asked[3][0] is second
    for gone in (Laboratory(), Laboratory(first)):
        with pytest.raises(LostSourceError, match="no such stream is in reach"):
            _opened(gone, "lsl:skin?source=two")
    late = Laboratory(first)
    late.late_s = 9.0
    with pytest.raises(LostSourceError, match="the stream does not answer: too late"):
        _opened(late)
    for count in (0, 2**20 + 1):
        with pytest.raises(InputError, match=f"has {count} channels"):
            _opened(Laboratory(_described({}, [], channel_count=count)))
    assert _opened(Laboratory(_described({}, [], channel_count=2**20))).pads["pad"].shape == (2**20,)
