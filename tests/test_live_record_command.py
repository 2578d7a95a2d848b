"""`varishold record` and `replay`: what they write and say, and what becomes of a file when they are stopped."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

pytest.importorskip("mcap", reason="recording needs the extra live")
from tests.live_scripted import wait_until

from hostile import recorder_kills
from varishold.cli.app import app
from varishold.errors import InputError, VarisholdError
from varishold.live import samples_of, source_at
from varishold.recording import read
from varishold.recording.mcap import gather

PROGRAM = (sys.executable, "-c", "from varishold.cli import main; main()")


def test_what_was_recorded_can_go_round(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    record("sim:sphere?speed=0", "-o", str(path), "--frames", "30")
    coming = samples_of(source_at(f"replay:{path}?speed=0&loop=1&pitch_m=0.005"))
    some = [next(coming) for _ in range(95)]
    coming.close()
    assert np.diff([each.device_time_s for each in some]).min() > 0
    assert np.array_equal(some[5].pads["pad"], some[65].pads["pad"])


def record(*words: str) -> str:
    done = CliRunner().invoke(app, ["record", *words], catch_exceptions=False)
    assert done.exit_code == 0
    return done.stdout


def test_the_command_records_and_says_what(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    told = record(
        "sim:sphere?speed=0&seed=1", "-o", str(path), "--frames", "150", "--label", "sphere", "--sensor", "weiss-dsa"
    )
    assert told == f"{path}: 150 frames in 1.49 s, 100 a second; none lost\n"
    recording = read(path)
    assert (recording.n_frames, recording.sensor) == (150, "Weiss DSA 9205")
    held = gather(path)
    assert [note.told for note in held.notes] == [{"label": "sphere"}]
    assert held.attachments["sensor.toml"].startswith(b"# A sensor file")
    as_json = json.loads(record("sim:sphere?speed=0", "-o", str(tmp_path / "b.mcap"), "--seconds", "0.5", "--json"))
    assert as_json == {
        "file": str(tmp_path / "b.mcap"),
        "frames": 50,
        "seconds": pytest.approx(0.49),
        "rate_hz": pytest.approx(100),
        "lost": 0,
        "missed": 0,
        "refused": 0,
        "why": "",
        "damaged": 0,
        "overrun": 0,
        "odd_clock": "",
    }


def test_messages_that_hold_no_frame_are_counted(tmp_path: Path) -> None:
    lines = [f"[[{k}, 2], [3, 4]]\n" for k in range(20)]
    lines[5], lines[9] = "garbage\n", "[[1, 2]\n"
    words = [*PROGRAM, "record", "stdin:", "-o", str(tmp_path / "a.mcap")]
    done = subprocess.run(words, input="".join(lines), capture_output=True, text=True, check=True)
    assert done.stdout.startswith(f"{tmp_path / 'a.mcap'}: 18 frames in ")
    assert done.stdout.endswith(
        "; 2 messages held no frame that could be used: a message: is not complete JSON: "
        "Expecting ',' delimiter at line 1, column 8\n"
    )


def test_npz_is_made_at_the_end(tmp_path: Path) -> None:
    record("sim:sphere?speed=0&seed=1", "-o", str(tmp_path / "a.mcap"), "--frames", "50")
    record("sim:sphere?speed=0&seed=1", "-o", str(tmp_path / "a.npz"), "--frames", "50")
    mcap, npz = read(tmp_path / "a.mcap"), read(tmp_path / "a.npz")
    np.testing.assert_array_equal(mcap.pads["pad"].frames, npz.pads["pad"].frames)
    assert npz.time_s is not None
    np.testing.assert_array_equal(mcap.time_s, npz.time_s)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a.mcap", "a.npz"]


@pytest.mark.parametrize(
    ("source", "file", "told"),
    [
        (
            "sim:sphere",
            "there.mcap",
            "is no file that may be replaced unasked; name another file, or replace it by force",
        ),
        ("sim:sphere", "a.csv", "its name must end in .mcap or .npz"),
        ("sim:sphere", "no/a.mcap", "there is no folder"),
        ("replay:{there}?speed=0", "there.mcap", "is read by this very call"),
        ("nothing:here", "a.mcap", "no source is called 'nothing'"),
        ("sim:sphere?speed=0&duration_s=0", "a.mcap", "nothing came"),
    ],
)
def test_what_cannot_be_recorded_is_told(tmp_path: Path, source: str, file: str, told: str) -> None:
    there = tmp_path / "there.mcap"
    record("sim:sphere?speed=0", "-o", str(there), "--frames", "5")
    content = there.read_bytes()
    words = ["record", source.format(there=there), "-o", str(tmp_path / file)]
    if "replay" in source:
        words.append("--force")
    with pytest.raises(VarisholdError) as error:
        CliRunner().invoke(app, words, catch_exceptions=False)
    assert told in str(error.value)
    assert "\n" not in str(error.value)
    assert there.read_bytes() == content
    assert [entry.name for entry in tmp_path.iterdir()] == ["there.mcap"]


@pytest.mark.parametrize("name", ["a\nb", "\u202eabc", "\ud800", "\0"])
def test_what_came_under_any_name_is_read_back(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.mcap"
    line = json.dumps({"pressure": {name: [[1, 2], [3, 4]]}}) + "\n"
    done = subprocess.run([*PROGRAM, "record", "stdin:", "-o", path], input=5 * line, text=True, capture_output=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert read(path).n_frames == 5


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_stopping_it_leaves_a_complete_file_and_a_line(tmp_path: Path, how: signal.Signals) -> None:
    path = tmp_path / "a.mcap"
    process = subprocess.Popen(
        [*PROGRAM, "record", "sim:sphere", "-o", str(path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A shell's background job ignores Ctrl-C, and so would all that it starts.
        preexec_fn=lambda: [signal.signal(each, signal.SIG_DFL) for each in (signal.SIGINT, signal.SIGHUP)],
    )
    wait_until(lambda: path.exists() and path.stat().st_size > 5000, 120)
    process.send_signal(how)
    out, told = process.communicate(timeout=60)
    assert (process.returncode, told) == (0, "")
    assert out.startswith(f"{path}: ")
    recording = read(path)
    assert not any("has no end" in remark for remark in recording.remarks)
    assert f"{recording.n_frames} frames" in out
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.mcap"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills as a Unix does")
def test_killed_at_any_moment_it_leaves_a_file_without_its_last_second_at_most() -> None:
    left = list(recorder_kills.kills(2, seed=3, rate_hz=200))
    assert all(each.readings for each in left)
    # How long ago the last reading is depends on how busy this machine is.
    assert [each.fault for each in left if "are missing" not in each.fault] in ([""] * 2, [""], [])


def told_by(*words: str) -> list[dict[str, object]]:
    done = CliRunner().invoke(app, [*words, "--json"], catch_exceptions=False)
    assert done.exit_code == 0
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    # Each is played as if now.
    return [{name: value for name, value in line.items() if name != "host_time_s"} for line in lines]


def test_replay_says_what_live_says_of_the_same_frames(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    record("sim:sphere?speed=0&rest_s=2&duration_s=4", "-o", str(path))
    played = told_by("replay", str(path), "--speed", "0")
    assert played == told_by("live", f"replay:{path}?speed=0")
    assert [line["frame"] for line in played if line["line"] == "frame"] == list(range(400))
    events = [line["event"] for line in played if line["line"] == "event"]
    assert events == [
        line["event"] for line in told_by("live", "sim:sphere?speed=0&rest_s=2&duration_s=4") if line["line"] == "event"
    ]


def test_replay_takes_what_the_file_leaves_unsaid(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join(",".join(f"{200 - k % 3}" for k in range(16)) for _ in range(5)) + "\n")
    (tmp_path / "sensor.toml").write_text('shape = [4, 4]\npolarity = "down"\nrest = 200\n')
    frames = [line for line in told_by("replay", str(path), "--speed", "0") if line["line"] == "frame"]
    assert len(frames) == 5
    with pytest.raises(InputError, match="there is no "):
        CliRunner().invoke(app, ["replay", str(tmp_path / "no.mcap")], catch_exceptions=False)
