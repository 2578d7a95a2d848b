"""What the page asks for: one line of JSON each, judged before anything is done."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from varishold.errors import InputError
from varishold.live.session import Session
from varishold.live.teaching import checked_label

__all__ = ["REQUESTS", "asked"]

_LONGEST_KEY = 200


def _zero(session: Session, given: Mapping[str, Any]) -> str:
    session.ask_zero()
    return "zero asked for"


def _label(session: Session, given: Mapping[str, Any]) -> str:
    label = given.get("label")
    session.set_label(label)
    return "presses are not kept" if label is None else f"press: what comes now is kept as {label}"


def _forget(session: Session, given: Mapping[str, Any]) -> str:
    label = checked_label(given.get("label"))
    session.forget(label)
    return f"presses of {label} are forgotten"


def _learn(session: Session, given: Mapping[str, Any]) -> str:
    session.learn()
    return "learning"


def _record(session: Session, given: Mapping[str, Any]) -> str:
    if not isinstance(given.get("on"), bool):
        raise InputError('to record is {"do": "record", "on": true} or false')
    return session.record(given["on"])


def _next(session: Session, given: Mapping[str, Any]) -> str:
    session.next_object()
    return "the next press is of another object"


def _save(session: Session, given: Mapping[str, Any]) -> str:
    return session.save()


def _look(session: Session, given: Mapping[str, Any]) -> str:
    track = given.get("track")
    if not isinstance(track, str) or len(track) > _LONGEST_KEY:
        raise InputError(f"a contact's key is a text of up to {_LONGEST_KEY} characters")
    session.look_at(track)
    return ""


#: What can be asked for, by its name.
REQUESTS: Mapping[str, Callable[[Session, Mapping[str, Any]], str]] = MappingProxyType(
    {
        "zero": _zero,
        "label": _label,
        "forget": _forget,
        "learn": _learn,
        "record": _record,
        "save": _save,
        "next": _next,
        "look": _look,
    }
)


def asked(session: Session, message: str | bytes) -> dict[str, Any]:
    """Do what a message asks for; return what is answered: ``ok`` and ``words``.

    Nothing that a message can hold raises an error.
    """
    try:
        given = _parsed(message)
        return {"kind": "answer", "ok": True, "words": REQUESTS[given["do"]](session, given)}
    except InputError as error:
        return {"kind": "answer", "ok": False, "words": str(error)}


def _parsed(message: str | bytes) -> dict[str, Any]:
    try:
        given = json.loads(message)
    except (ValueError, RecursionError):
        raise InputError("a request is JSON") from None
    if not isinstance(given, dict) or given.get("do") not in list(REQUESTS):
        raise InputError(f'a request is {{"do": ...}}, one of {", ".join(REQUESTS)}')
    return given
