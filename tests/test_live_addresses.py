"""Addresses: what was written comes apart as it was put together, and each part is what it says or is refused."""

from __future__ import annotations

import math
import ssl
from typing import Any
from urllib.parse import quote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.live.address import Address, parse_address, replayed_file
from varishold.live.endpoint import Endpoint, endpoint_of, untrusted
from varishold.live.framed import framing_at

KINDS = st.text("abcXYZ", min_size=1, max_size=8)
PLACES = st.text("abc/:.-_ é", max_size=20)
OPTIONS = st.dictionaries(st.text("abc_", min_size=1, max_size=6), st.text("abc 1é&=?#%+", max_size=8), max_size=4)


@given(KINDS, PLACES, OPTIONS, st.booleans())
def test_what_was_put_together_comes_apart(kind: str, place: str, options: dict[str, str], slashes: bool) -> None:
    text = f"{kind}:{'//' if slashes else ''}{place}"
    text += "?" + "&".join(f"{name}={quote(value)}" for name, value in options.items()) if options else ""
    told = parse_address(text)
    place = place if slashes else place.removeprefix("//")
    assert told == Address(text, kind.lower(), place, options)
    assert replayed_file(text) == ([place] if kind.lower() == "replay" else [])


@pytest.mark.parametrize("text", ["", "serial", ":place", "a:b?x", "a:b?x=1&x=2", "a:b?x=1&&y=2"])
def test_what_is_no_address_is_told(text: str) -> None:
    with pytest.raises(InputError):
        parse_address(text)
    assert replayed_file(text) == []
    assert parse_address("a:b?x=").options == {"x": ""}
    assert parse_address("a:b?").options == {}
    assert replayed_file("REPLAY:a?b.npz=1") == ["a"]


def _with(**options: str) -> Address:
    return Address("a:b", "a", "b", options)


@given(st.floats(), st.floats(-100, 100), st.floats(0, 50))
def test_a_number_is_within_its_bounds_or_refused(value: float, least: float, more: float) -> None:
    address = _with(x=repr(value))
    assert address.number("y", 7.5, least=0, most=1) == 7.5
    if least <= value <= least + more:
        assert address.number("x", 0.0, least=least, most=least + more) == value
        if value == int(value):
            assert address.whole("x", 0, least=math.floor(least), most=math.ceil(least + more)) == int(value)
        else:
            with pytest.raises(InputError, match="x must be a whole number"):
                address.whole("x", 0, least=-1000, most=1000)
    else:
        with pytest.raises(InputError, match="x must be a number from"):
            address.number("x", 0.0, least=least, most=least + more)


@given(st.integers(-5, 12000), st.integers(-5, 12000), st.sampled_from(["x", "X"]), st.booleans())
def test_a_shape_is_two_whole_numbers_from_1_to_4096(rows: int, cols: int, sign: str, zeros: bool) -> None:
    text = f"{rows:03}{sign}{cols}" if zeros else f"{rows}{sign}{cols}"
    if 1 <= rows <= 4096 and 1 <= cols <= 4096:
        assert _with(shape=text).shape() == _with(size=text).shape("size") == (rows, cols)
    else:
        with pytest.raises(InputError, match="shape must be rows x columns, as in 16x16, got"):
            _with(shape=text).shape()


@pytest.mark.parametrize("text", ["", "4", "4x", "x4", "4x4x4", "4 x 4", "+4x4", "4.0x4", "٤x4", "00004x4", "4x²"])
def test_what_is_no_shape_is_told(text: str) -> None:
    with pytest.raises(InputError):
        _with(shape=text).shape()
    assert _with().shape() is None


def test_options_are_those_that_are_known() -> None:
    _with().only()
    _with(x="1").only("y", "x")
    with pytest.raises(InputError, match=r"^a:b: a has no option 'x'; known are y, z$"):
        _with(x="1").only("y", "z")
    with pytest.raises(InputError, match=r"^a:b: a has no option 'x'; it has none$"):
        _with(x="1").only()


HOSTS = st.sampled_from(["", "h", "a.b-c", "10.0.0.7", "[::1]", "[fe80::1%2]"])


@given(HOSTS, st.none() | st.integers(0, 70000), st.none() | st.text("ab/:?[]@#", max_size=8), st.booleans())
def test_an_endpoint_is_a_host_a_port_and_a_path(host: str, port: int | None, path: str | None, usual: bool) -> None:
    place = host + ("" if port is None else f":{port}") + ("" if path is None else f"/{path}")
    address = Address(f"x:{place}", "x", place, {})
    if port is not None and not 0 < port < 65536:
        with pytest.raises(InputError, match="must be as x://HOST:PORT/NAME, got"):
            endpoint_of(address, port=1000)
        return
    told = endpoint_of(address, port=1000, host="usual") if usual else endpoint_of(address, port=1000)
    plain = host.strip("[]") or ("usual" if usual else "")
    assert told == Endpoint(plain, port or 1000, path or "")
    assert told.host_and_port == f"{host or plain}:{port or 1000}"


@pytest.mark.parametrize("place", ["a b", "h:", "h:x", "::1", "[x]", "a@b", "h:1:2", "h /p", "h:123456"])
def test_what_is_no_endpoint_is_told(place: str) -> None:
    with pytest.raises(InputError, match="must be as x://HOST:PORT/NAME"):
        endpoint_of(Address(f"x:{place}", "x", place, {}), port=1000)


def test_a_certificate_that_is_not_trusted_is_told_and_nothing_else() -> None:
    error = ssl.SSLCertVerificationError()
    error.verify_message = "self-signed"
    told = untrusted("wss://h", error)
    assert isinstance(told, InputError)
    assert str(told).startswith("wss://h: its certificate is not trusted (self-signed); name a file")
    assert untrusted("wss://h", ssl.SSLError()) is untrusted("wss://h", OSError()) is None


def test_a_framing_is_named_once_and_takes_shape_and_pitch_from_the_address() -> None:
    def framing(default: str | None = None, **options: str) -> Any:
        return framing_at(Address("serial:x", "serial", "x", options), default)

    with pytest.raises(InputError, match=r"^serial:x: give preset or framing, not both$"):
        framing(preset="flexitac", framing="a.toml")
    with pytest.raises(InputError, match=r"^serial:x: say what it sends: \?preset= with one of anyskin"):
        framing()
    assert framing("flexitac").name == framing(preset="flexitac").name == framing("anyskin", framing="flexitac").name
    (pad,) = framing(preset="flexitac", shape="4x5", pitch_m="0.003").pads
    assert (pad.layout.shape, pad.layout.pitch_m) == ((4, 5), (0.003, 0.003))
    (pad,) = framing(preset="flexitac", shape="4x5").pads
    assert pad.layout.pitch_m == framing(preset="flexitac").pads[0].layout.pitch_m
    # Signals have no spacing.
    told = framing(preset="jq-glove", pitch_m="0.003").pads
    assert [pad.layout.pitch_m for pad in told] == [
        (0.003, 0.003) if pad.layout.kind == "pressure" else None for pad in told
    ]
    assert {pad.layout.kind for pad in told} == {"pressure", "signals"}
    with pytest.raises(InputError, match=r"^serial:x: shape cannot be given: this framing has the pads"):
        framing(preset="jq-glove", shape="4x5")
