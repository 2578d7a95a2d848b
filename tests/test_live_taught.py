"""What is kept of what was felt: presses under their label, recordings begun at the page, files in time."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.live_clock import Clock
from tests.live_scripted import Scripted, sample, wait_until
from tests.test_live_names import kept_press

from varishold.errors import InputError
from varishold.live import Stream
from varishold.live.page_recorder import PageRecorder, free_path
from varishold.live.sample_file import Limits, SampleFile
from varishold.live.teaching import MOST_PRESSES, Teaching


def test_presses_are_kept_under_the_label_that_is_set_the_newest_of_them() -> None:
    teaching = Teaching(lambda model: None)
    assert teaching.take(kept_press(0)) is None
    teaching.set_label(" cone ")
    assert teaching.to_dict() == {"label": "cone", "counts": [["cone", 0]], "words": ""}
    counts = [teaching.take(kept_press(k)) for k in range(MOST_PRESSES + 3)]
    assert counts == [("cone", min(k + 1, MOST_PRESSES)) for k in range(MOST_PRESSES + 3)]
    assert teaching._presses["cone"] == [*range(3, MOST_PRESSES + 3)]
    teaching.set_label("pillar")
    assert teaching.take(kept_press(0)) == ("pillar", 1)
    teaching.forget("cone")
    assert teaching.to_dict() == {"label": "pillar", "counts": [["pillar", 1]], "words": ""}
    teaching.forget("pillar")
    assert teaching.to_dict() == {"label": None, "counts": [], "words": ""}
    assert teaching.take(kept_press(0)) is None
    teaching.set_label("ball")
    teaching.set_label(None)
    assert teaching.take(kept_press(0)) is None
    assert teaching.to_dict() == {"label": None, "counts": [["ball", 0]], "words": ""}


def test_what_is_forgotten_is_not_kept_under_and_only_the_newest_presses_are() -> None:
    teaching = Teaching(lambda model: None)
    kept: Any = SimpleNamespace(press="a press")
    assert teaching.take(kept) is None
    teaching.set_label(" cone ")
    assert [teaching.take(kept) for _ in range(3)] == [("cone", 1), ("cone", 2), ("cone", 3)]
    teaching.set_label("pillar")
    assert teaching.take(kept) == ("pillar", 1)
    with pytest.raises(InputError, match="there are: cone: 3, pillar: 1"):
        teaching.learn()
    # Another's presses may be forgotten while this label is set.
    teaching.forget("cone")
    assert teaching.to_dict() == {"label": "pillar", "counts": [["pillar", 1]], "words": ""}
    teaching.forget("pillar")
    teaching.forget("nothing of the kind")
    assert teaching.take(kept) is None
    assert teaching.to_dict() == {"label": None, "counts": [], "words": ""}
    teaching.set_label("ridge")
    assert [teaching.take(kept) for _ in range(205)][-1] == ("ridge", 200)


def test_a_page_records_once_at_a_time_and_says_what_became_of_it(tmp_path: Path) -> None:
    said: list[tuple[bool, str]] = []
    stream = Stream(Scripted(), keep=50)
    stream._put([sample(k) for k in range(5)])
    recorder = PageRecorder(stream, tmp_path, lambda well, words: said.append((well, words)))
    assert recorder.to_dict() is None
    recorder.mark("nobody hears")
    recorder.look()
    with pytest.raises(InputError, match="nothing is being written"):
        recorder.end()
    path = recorder.begin("cone")
    with pytest.raises(InputError, match="is being written; end it first"):
        recorder.begin(None)
    # Number 7 of the sensor's own never came.
    stream._put([sample(k) for k in (5, 6, 8)])
    wait_until(lambda: recorder.to_dict() == {"file": path.name, "frames": 3, "missed": 0})
    recorder.mark(None)
    recorder.zeroed({"pad": "pad"})
    recorder.close()
    assert said == [(True, f"{path}: 3 readings in 0.0\u202fs, 1 never came")]
    assert recorder.to_dict() is None
    recorder.begin(None)
    recorder.close()
    recorder.close()
    assert said[1:] == [(False, "recording ended: nothing came")]


def test_a_free_path_is_named_after_the_time_and_nobody_elses(tmp_path: Path) -> None:
    taken = [free_path(tmp_path, ".npz")]
    for _ in range(12):
        taken[-1].touch()
        taken.append(free_path(tmp_path, ".npz"))
    assert len(set(taken)) == 13
    assert not taken[-1].exists()
    assert all(path.parent == tmp_path and path.suffix == ".npz" for path in taken)


class Disk:
    """A file that counts how often something is handed to it."""

    shown = True

    def write(self, data: bytes) -> int:
        return len(data)

    def show(self) -> None:
        """It is there."""


def test_what_waits_is_handed_over_within_half_a_second_and_a_silent_source_ends_in_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from varishold.live import sample_file

    clock, flushed = Clock(monkeypatch, sample_file), []
    writer = SimpleNamespace(flush=lambda: flushed.append(clock.now_s), describe=lambda facts: None)
    writer.reading = lambda pads, **told: None
    monkeypatch.setattr(sample_file, "TopicWriter", lambda file, name: writer)
    file = SampleFile(Disk(), dict, "", Limits(seconds=3.0))  # type: ignore[arg-type]
    file.look()
    assert flushed == []
    began_s = clock.now_s
    file.add(sample(0))
    while not file.full:
        clock.sleep(0.05)
        file.look()
        assert clock.now_s < began_s + 10
    # It ends when the reading that would be too late must have come.
    assert 3.4 <= clock.now_s - began_s <= 3.9
    steps = np.diff([began_s, *flushed])
    assert 0.3 < steps.min() <= steps.max() <= 0.5
    # Without limits it never ends by itself.
    file = SampleFile(Disk(), dict, "", Limits())  # type: ignore[arg-type]
    file.add(sample(0))
    clock.sleep(1e6)
    file.look()
    assert not file.full
