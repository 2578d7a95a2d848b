"""``varishold live`` as a person and a program run it."""

from __future__ import annotations

import json
import signal
import subprocess
import sys

import pytest
from click.testing import CliRunner

from varishold.cli.app import app
from varishold.errors import InputError

PROGRAM = (sys.executable, "-c", "from varishold.cli import main; main()")


def test_json_lines_tell_frames_and_events_until_the_end() -> None:
    done = CliRunner().invoke(
        app, ["live", "sim:sphere?speed=0&duration_s=4&rest_s=2", "--json"], catch_exceptions=False
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    frames = [line for line in lines if line["line"] == "frame"]
    assert done.exit_code == 0
    assert [line["frame"] for line in frames] == list(range(400))
    events = [line for line in lines if line["line"] == "event"]
    assert events[0]["event"] == "touched"
    assert all(line["line"] in ("frame", "event", "zero", "source") for line in lines)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nothing:here"], "nothing:here: no source is called 'nothing'"),
        (["sim:sphere?colour=red"], "sim has no option 'colour'"),
        (["sim:sphere", "--sensor", "no-such"], "no-such"),
        (["sim:sphere", "--model", "no-such.npz"], "no-such.npz"),
    ],
)
def test_what_cannot_be_watched_is_told(words: list[str], told: str) -> None:
    with pytest.raises(InputError) as error:
        CliRunner().invoke(app, ["live", *words, "--json"], catch_exceptions=False)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_lines_come_at_once_and_an_interruption_ends_with_130() -> None:
    process = subprocess.Popen(
        [*PROGRAM, "live", "sim:sphere", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A shell's background job ignores Ctrl-C, and so would all that it starts.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout is not None
    lines = [json.loads(process.stdout.readline()) for _ in range(5)]
    process.send_signal(signal.SIGINT)
    rest, told = process.communicate(timeout=60)
    assert (process.returncode, told) == (130, "varishold: interrupted\n")
    assert [line["frame"] for line in lines if line["line"] == "frame"] == list(range(3))
    assert lines[0]["line"] == "source"
    assert all(json.loads(line) for line in rest.splitlines())


@pytest.mark.parametrize("wrong", [0, 1, 3])
def test_a_source_that_waits_is_opened_and_ends_in_lines_too(wrong: int) -> None:
    frames = [json.dumps({"pressure": [[1, 2], [3, k]], "time_s": k / 50}) for k in range(20)]
    done = subprocess.run(
        [*PROGRAM, "live", "stdin:", "--json"],
        input="\n".join([*frames, *wrong * ['{"pressure": [[1, 2], [3, "x"]]}']]) + "\n",
        capture_output=True,
        text=True,
        check=True,
    )
    said = [json.loads(line) for line in done.stdout.splitlines()]
    told = [(line["state"], line["words"]) for line in said if line["line"] == "source"]
    why = "a message is not understood: its fields are pressure[2]; name the one that holds the values as field"
    words = f"{wrong} message{'s' * (wrong > 1)} held no frame that could be used: {why}" if wrong else ""
    assert told == [("opening", ""), ("open", ""), ("ended", words)]
    assert sum(line["line"] == "frame" for line in said) == 20
