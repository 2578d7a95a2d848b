"""What the page may ask for: each request does one thing, and what cannot be asked for does nothing."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from varishold.live.requests import REQUESTS, asked


class Asked:
    """A session that notes what it is asked for."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []

    def __getattr__(self, name: str) -> Callable[..., str]:
        def note(*given: Any) -> str:
            self.calls.append((name, *given))
            return f"{name} is done"

        return note


@pytest.mark.parametrize(
    ("given", "call"),
    [
        ({"do": "zero"}, ("ask_zero",)),
        ({"do": "next"}, ("next_object",)),
        ({"do": "label", "label": "cone"}, ("set_label", "cone")),
        ({"do": "label", "label": None}, ("set_label", None)),
        ({"do": "label"}, ("set_label", None)),
        ({"do": "forget", "label": " cone"}, ("forget", "cone")),
        ({"do": "learn"}, ("learn",)),
        ({"do": "record", "on": True}, ("record", True)),
        ({"do": "record", "on": False}, ("record", False)),
        ({"do": "save"}, ("save",)),
        ({"do": "look", "track": "pad/1"}, ("look_at", "pad/1")),
        ({"do": "look", "track": "x" * 200}, ("look_at", "x" * 200)),
    ],
)
def test_what_is_asked_for_is_done(given: dict[str, Any], call: tuple[Any, ...]) -> None:
    session = Asked()
    answer = asked(session, json.dumps(given))  # type: ignore[arg-type]
    assert session.calls == [call]
    assert (answer["kind"], answer["ok"]) == ("answer", True)
    words = {
        "zero": "zero asked for",
        "next": "the next press is of another object",
        "forget": "presses of cone are forgotten",
        "learn": "learning",
        "look": "",
        "label": f"press: what comes now is kept as {call[-1]}" if call[-1] else "presses are not kept",
    }
    assert answer["words"] == words.get(given["do"], f"{call[0]} is done")


@pytest.mark.parametrize(
    "given",
    [
        *({"do": what} for what in ("forget", "record", "look", "fly", [])),
        *({"do": "look", "track": track} for track in ("x" * 201, 5)),
        *({"do": "record", "on": 1}, {}, [], 5),
    ],
)
def test_what_cannot_be_asked_for_does_nothing(given: Any) -> None:
    session = Asked()
    answer = asked(session, json.dumps(given))  # type: ignore[arg-type]
    assert (answer["ok"], session.calls) == (False, [])
    assert answer["words"]


def test_every_request_is_one_of_the_page() -> None:
    assert {"zero", "label", "forget", "learn", "record", "save", "next", "look"} == set(REQUESTS)
    told = asked(Asked(), '{"do": "fly"}')["words"]  # type: ignore[arg-type]
    assert told == f'a request is {{"do": ...}}, one of {", ".join(REQUESTS)}'
    assert asked(Asked(), "{")["words"] == "a request is JSON"  # type: ignore[arg-type]
