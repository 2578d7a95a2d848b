"""Messages of nodes over zenoh: by whose definition they are read, what stands beside them, how a source is opened."""

from __future__ import annotations

import atexit
import json
import struct
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from tests.test_live_nodes import Library, Waiting, _life, _token, _value

from varishold.errors import InputError, LostSourceError
from varishold.live import source_at
from varishold.live.sources import zenoh_topic

KIND = "std_msgs::msg::dds_::Int16MultiArray_"


def _source(monkeypatch: pytest.MonkeyPatch, text: str = "zenoh://router/skin", library: Any = None) -> Any:
    library = library or Library()
    monkeypatch.setattr(zenoh_topic, "_library", lambda: library)
    source: Any = source_at(text)
    source._news = Waiting()
    source._session = library
    return source


def _message(source: Any, values: Any, *, number: int = 0, time_ns: int = 0, told: bool = True) -> None:
    attachment = struct.pack("<qqB", number, time_ns, 16) + bytes(16)
    sample = SimpleNamespace(
        attachment=SimpleNamespace(to_bytes=lambda: attachment) if told else None,
        key_expr=f"0/skin/{KIND}/RIHS01_ab",
        payload=SimpleNamespace(to_bytes=lambda: json.dumps(values).encode()),
    )
    source._on_value(sample)


@pytest.mark.parametrize(
    ("given", "standard", "told", "read_by"),
    [
        # What was given goes first, and then nobody is asked.
        ("given", True, "told", "given"),
        ("", True, "told", ""),
        ("", False, "told", "told"),
        ("", False, "", None),
        ("bad", False, "told", None),
    ],
)
def test_a_message_is_read_by_the_text_that_is_given_or_standard_or_told(
    given: str, standard: bool, told: str, read_by: str | None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[tuple[Any, ...]] = []
    made: list[tuple[str, str, str]] = []

    def decoder(encoding: str, type_name: str, text: str) -> Any:
        made.append((encoding, type_name, text))
        if text == "bad" or (not text and not standard):
            raise InputError("no such type")
        return json.loads

    monkeypatch.setattr(zenoh_topic, "message_decoder", decoder)
    monkeypatch.setattr(zenoh_topic, "asked_definition", lambda *how: asked.append(how) or told)
    (tmp_path / "a.msg").write_text(given)
    source = _source(monkeypatch, f"zenoh://router/skin?msg={tmp_path}/a.msg" if given else "zenoh://router/skin")
    for k in range(3):
        _message(source, {"data": [k, 1]}, number=k, time_ns=(k + 1) * 10**9)
    if read_by is None:
        with pytest.raises(InputError, match="no such type; no node tells the definition: give it as") as error:
            source.read(0.0)
        assert str(error.value).startswith(source.address)
        assert getattr(error.value, "parameter", None) == "msg"
        return
    samples = source.read(0.0)
    assert [(one.sequence, one.device_time_s) for one in samples] == [(0, 1.0), (1, 2.0), (2, 3.0)]
    assert [one.pads["pad"].tolist() for one in samples] == [[k, 1] for k in range(3)]
    # It is made once.
    assert made[-1] == ("cdr", KIND, read_by)
    assert len(made) == (2 if told == read_by else 1)
    assert asked == ([(source._session, 0, "std_msgs/msg/Int16MultiArray", "RIHS01_ab")] if read_by == "told" else [])


def test_each_message_has_what_stands_beside_it_and_comes_when_it_came(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(zenoh_topic, "message_decoder", lambda encoding, type_name, text: json.loads)
    clock = iter([5e8, 6e8, 7e8, 8e8])
    monkeypatch.setattr(zenoh_topic, "time", SimpleNamespace(time=lambda: next(clock)))
    source = _source(monkeypatch)
    _message(source, {"data": [1, 2]}, number=7, time_ns=2_500_000_000)
    _message(source, {"data": [3, 4]}, told=False)
    _value(source, "skin", b"[5, 6]")
    _message(source, {"data": "nothing"})
    first, second, third = source.read(0.25)
    assert source._news.waits_s == [0.25]
    assert (first.sequence, first.device_time_s, first.host_time_s) == (7, 2.5, 5e8)
    assert (second.sequence, second.device_time_s, second.host_time_s) == (None, None, 6e8)
    assert (third.sequence, third.device_time_s, third.host_time_s) == (None, None, 7e8)
    assert third.pads["pad"].tolist() == [5, 6]
    assert source.damaged == 1
    # What was read is not read again.
    assert source.read(0.0) == []


class Refusing(Library):
    """A router that is not there, or hangs up when it is asked for something."""

    def __init__(self, what: str) -> None:
        super().__init__()
        self._what = what

    def open(self, config: Any) -> Library:
        if self._what == "open":
            raise self.ZError("unreachable")
        return self

    def declare_subscriber(self, key: str, call: Any, **how: Any) -> str:
        if self._what == "declare":
            raise self.ZError("gone")
        if self._what == "token" and key.startswith("@"):
            assert how["history"] is True
            call(SimpleNamespace(key_expr=_token("skin"), kind="put"))
        return super().declare_subscriber(key, call, **how)

    def close(self) -> None:
        super().close()
        if self._what == "close":
            raise self.ZError("already")


@pytest.mark.parametrize(("what", "why"), [("open", "unreachable"), ("declare", "gone")])
def test_a_router_that_does_not_answer_is_told_and_let_go(what: str, why: str, monkeypatch: pytest.MonkeyPatch) -> None:
    library = Refusing(what)
    source = _source(monkeypatch, library=library)
    source._session = None
    with pytest.raises(LostSourceError, match=f"^zenoh://router/skin: nobody answers: {why}$"):
        source.open()
    assert library.closed == (1 if what == "declare" else 0)
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)


def test_opened_anew_nothing_is_known_of_before(monkeypatch: pytest.MonkeyPatch) -> None:
    library = Refusing("token")
    source, left = _source(monkeypatch, library=library), []
    monkeypatch.setattr(atexit, "register", lambda call: left.append(call))
    monkeypatch.setattr(atexit, "unregister", lambda call: left and left.remove(call))
    _life(source, _token("other"))
    _value(source, "skin", b"[1, 2]")
    source.open()
    assert source.topics == {"/skin": "std_msgs/msg/Int16"}
    # The session that was open is closed, and whoever ends the program closes this one.
    assert (library.closed, left) == (1, [source.close])
    assert source.read(0.0) == []
    assert library.settings["mode"] == "client"
    library._what = "close"
    source.close()
    source.close()
    assert (library.closed, left) == (2, [])


def test_a_plain_key_is_read_where_nobody_says_that_he_publishes(monkeypatch: pytest.MonkeyPatch) -> None:
    class Sending(Library):
        def declare_subscriber(self, key: str, call: Any, **_: Any) -> str:
            if key == "arm/skin":
                _value(source, key, b"[[1, 2]]")
            return super().declare_subscriber(key, call)

    source = _source(monkeypatch, "zenoh:/arm/skin/", Sending())
    source.open()
    assert source.read(0.0)[0].pads["pad"].tolist() == [[1, 2]]
    # It has not left, for it never said that it was there.
    assert source.read(0.0) == []
    assert "mode" not in source._zenoh.settings
    for topic in ("a*", "a$b", "#", "a?b"):
        with pytest.raises(InputError, match=r"is no topic|name=value|option"):
            source_at(f"zenoh://router/{topic}")
