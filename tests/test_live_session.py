"""A session: things are taught and recognized there and then, and nobody waits for anybody."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.live_presses import Pressing, pressed
from tests.live_scripted import Scripted, sample, wait_until

from varishold import read
from varishold.errors import InputError
from varishold.learning import read_model
from varishold.live.sample import Sample
from varishold.live.session import Session
from varishold.live.teaching import MOST_LABELS, Teaching, checked_label


def _label(session: Session) -> object:
    named = session.named
    return named.recognition.label if named is not None and named.over and named.recognition is not None else None


def test_two_things_are_taught_and_recognized(tmp_path: Path) -> None:
    pressing = Pressing(folder=tmp_path)
    with pressing.session as session:
        with pytest.raises(InputError, match="nothing was learned yet"):
            session.save()
        for label in ("cone", "pillar"):
            session.set_label(label)
            for k in range(3):
                pressing.press(label, label, seed=k)
        session.set_label(None)
        assert session.status()["teaching"]["counts"] == [["cone", 6], ["pillar", 6]]
        session.learn()
        wait_until(lambda: session.status()["model"] == ["cone", "pillar"])
        for label in ("pillar", "cone"):
            pressing.press(label, seed=9)
            wait_until(lambda: any(event["kind"] == "named" for event in session.events.since(0)))
            wait_until(lambda: _label(session) == label)  # noqa: B023
        assert session.save().startswith("saved as ")
    (file,) = tmp_path.glob("varishold-*.npz")
    assert read_model(file).classes_.tolist() == ["cone", "pillar"]
    kinds = [event["kind"] for event in session.events.since(0)]
    assert kinds.count("kept") == 12
    assert kinds.count("named") == 2


def test_presses_without_a_label_are_not_kept() -> None:
    pressing = Pressing()
    with pressing.session as session:
        pressing.press("cone")
        assert session.status()["teaching"] == {"label": None, "counts": [], "words": ""}


def test_a_label_that_is_forgotten_counts_no_more() -> None:
    pressing = Pressing()
    with pressing.session as session:
        session.set_label("cone")
        assert session.status()["teaching"]["label"] == "cone"
        session.forget("cone")
        assert session.status()["teaching"]["label"] is None


@pytest.mark.parametrize("label", ["", "  ", "a\nb", "x" * 61, None, 5, [], "\x1b[2J"])
def test_what_is_no_label_is_refused(label: object) -> None:
    with pytest.raises(InputError, match="a label is a line of 1 to 60 characters"):
        checked_label(label)


@given(st.text(st.characters(categories=["L", "N", "P"]), min_size=1, max_size=60))
def test_any_line_is_a_label(label: str) -> None:
    assert checked_label(label) == label
    assert checked_label(f" {label[:58]} ") == label[:58]


def test_too_little_is_not_learned_from_and_too_many_labels_are_refused() -> None:
    teaching = Teaching(lambda model: None)
    with pytest.raises(InputError) as told:
        teaching.learn()
    assert str(told.value) == ("learning takes two labels or more with two presses or more of each; there are: none")
    for k in range(MOST_LABELS):
        teaching.set_label(f"thing {k}")
    with pytest.raises(InputError, match="64 labels already"):
        teaching.set_label("one more")
    teaching.forget("thing 3")
    teaching.set_label("one more")
    assert teaching.to_dict()["label"] == "one more"


def test_what_comes_is_recorded_with_labels_and_zeros(tmp_path: Path) -> None:
    pressing = Pressing(folder=tmp_path)
    with pressing.session as session:
        pressing.press("cone")
        session.set_label("cone")
        assert session.record(True).startswith("recording to ")
        with pytest.raises(InputError, match="is being written"):
            session.record(True)
        first = session.stream.received
        pressing.press("cone", seed=2)
        wait_until(lambda: session.status()["recording"]["frames"] == session.stream.received - first)
        assert session.record(False) == "the recording is ended"
        wait_until(lambda: any(event["kind"] == "recorded" for event in session.events.since(0)))
        assert session.status()["recording"] is None
        with pytest.raises(InputError, match="nothing is being written"):
            session.record(False)
    (file,) = tmp_path.glob("varishold-*.mcap")
    recording = read(file)
    assert recording.n_frames == session.stream.received - first
    assert [str(label) for label in recording.presses.columns.get("label", [])] in ([], ["cone"])


def test_a_session_that_ends_ends_its_recording(tmp_path: Path) -> None:
    pressing = Pressing(folder=tmp_path)
    with pressing.session as session:
        session.record(True)
        pressing.press("cone")
    (file,) = tmp_path.glob("varishold-*.mcap")
    assert read(file).n_frames == session.stream.received


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    pressing = Pressing(folder=tmp_path / "nowhere")
    with pressing.session as session:
        session.record(True)
        pressing.press("cone")
        wait_until(lambda: any("recording failed" in event["words"] for event in session.events.since(0)))
        assert session.status()["recording"] is None
    with Pressing().session as session, pytest.raises(InputError, match="no folder was given"):
        session.record(True)


def test_a_failure_of_whoever_looks_ends_the_watching_and_is_told() -> None:
    pressing = Pressing()

    def fail(seen: object) -> None:
        raise BrokenPipeError

    pressing.session = Session(pressing.source, on_seen=fail)
    with pressing.session as session:
        pressing.source.script.put(next(pressed()))
        assert session.wait_over(20)
        assert isinstance(session.failure, BrokenPipeError)


def test_silence_is_told() -> None:
    with Session(Scripted()) as session:
        time.sleep(0.05)
        first = session.status()["silent_s"]
        time.sleep(0.05)
        assert session.status()["silent_s"] > first


def test_the_status_tells_what_is_wrong_with_taxels_and_the_way_here() -> None:
    source = Scripted()
    with Session(source) as session:
        for number, sample in enumerate(pressed(*["cone"] * 10)):
            frame = sample.pads["pad"].copy()
            frame[5, 7] = 33.0
            # Every hundredth reading is lost.
            source.script.put(sample._replace(pads={"pad": frame}, sequence=number + number // 99))
            if number % 10 == 0:
                # Who is late leaves readings out.
                wait_until(lambda: session.newest is not None and session.newest.number >= number)  # noqa: B023
        wait_until(lambda: session.newest is not None and session.newest.number == number)
        status = session.status()
    assert status["broken"] == {"pad": [[5, 7]]}
    assert "taxel (5, 7) never changes its value: stuck" in status["remarks"]
    assert any("readings were lost on the way, 1.0 % of all" in line for line in status["remarks"])
    assert status["health"]["stream"]["lost"] == number // 99
    assert json.loads(json.dumps(status)) == status
    assert status["health"]["pads"]["pad"]["bad"][0]["word"] == "stuck"


def test_messages_of_no_use_are_said_as_long_as_they_come(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.live.lull._COUNTED_S", 0.1)
    monkeypatch.setattr("varishold.live.lull._SILENT_S", 0.4)
    source = Scripted()
    with Session(source) as session:
        for number in range(12):
            source.damaged, source.damage = number, "a line is too long"  # type: ignore[attr-defined]
            source.script.put(sample(number))
            time.sleep(0.03)
        wait_until(lambda: session.status()["words"].endswith("held no frame that could be used: a line is too long"))
        assert [event["words"] for event in session.events.since(0) if event["kind"] == "silent"]
        wait_until(lambda: session.status()["words"] == "")
        wait_until(lambda: session.events.since(0)[-1]["words"] == "no reading has come in 0 s; waiting")


def test_a_clock_that_stands_still_is_said_beside_what_is_done_about_it() -> None:
    source = Scripted()
    with Session(source) as session:
        for number in range(30):
            source.script.put(Sample(5.0, 1e9 + number / 100, number, sample(number).pads))
        wait_until(lambda: session.stream.received == 30)
        assert session.status()["words"] == (
            "the times of readings stand still; time_s is in seconds and rises; the time of arrival is taken"
        )
        assert "sensor's clock" not in [name for name, _ in session.status()["facts"]]
