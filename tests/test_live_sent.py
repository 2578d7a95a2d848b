"""What sources make of what is sent to them, without a wire: ports, brokers, nodes, files, simulated skins, pads."""

from __future__ import annotations

import errno
import struct
import sys
from collections import deque
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import websockets.sync.client
from tests.live_clock import Clock
from tests.test_live_framing import _sent as frames_sent

import varishold
from varishold.errors import InputError, LostSourceError
from varishold.frame.noise import ROUNDING
from varishold.learning.recognition import Recognition
from varishold.live import PadLayout, Sample, pace, samples_of, server, source_at, zenoh_types
from varishold.live.address import parse_address
from varishold.live.framing import framing_of
from varishold.live.pad_watcher import PadWatcher
from varishold.live.press_namer import NamedPress
from varishold.live.sample_file import sample_file
from varishold.live.server import PageServer
from varishold.live.session import Session
from varishold.live.simulated_skin import SimulatedSkin, SkinTraits
from varishold.live.sources import KINDS, lab_stream, mqtt_topic, serial_port, source_kind
from varishold.live.web_sockets import WebSocket
from varishold.live.words import named_line, named_words
from varishold.recording import Pad, Recording
from varishold.sensor import Sensor

# A serial port.


class Port:
    """A port that gives what a test puts, at most so much at once."""

    def __init__(self, clock: Clock) -> None:
        self._clock, self.timeout, self.came, self.sent = clock, 0.0, b"", []  # type: ignore[var-annotated]
        self.closed, self.fault = 0, None  # type: ignore[var-annotated]

    @property
    def in_waiting(self) -> int:
        return len(self.came)

    def read(self, size: int) -> bytes:
        if self.fault is not None:
            raise self.fault
        if not self.came:
            self._clock.sleep(self.timeout)
        taken, self.came = self.came[:size], self.came[size:]
        return taken

    def write(self, data: bytes) -> None:
        self.sent.append(data)

    def close(self) -> None:
        self.closed += 1
        if self.fault is not None:
            raise self.fault


def _opened(clock: Clock, text: str) -> tuple[Any, Port, list[Any]]:
    source, port, how = source_at(text), Port(clock), []  # type: ignore[var-annotated]
    source._serial = SimpleNamespace(Serial=lambda *given, **named: how.append((given, named)) or port)  # type: ignore[attr-defined]
    source.open()
    return source, port, how


def test_a_port_is_opened_for_this_program_alone_and_read_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch, serial_port)
    source, port, ((given, named),) = _opened(clock, "serial:/dev/x?preset=flexitac&shape=2x2&baud=9600")
    assert given == ("/dev/x", 9600)
    assert (named["exclusive"], named["timeout"]) == (True, 0)
    assert 0.5 <= named["write_timeout"] <= 2
    assert [data for data in port.sent if data] == []
    packets = [b"\xaa\x55" + bytes([k, 1, 2, 3]) for k in range(5)]
    port.came = b"".join(packets)
    before_s = clock.now_s
    assert [int(one.pads["pad"][0, 0]) for one in source.read(5.0)] == [0, 1, 2, 3, 4]
    # What is there is not waited for, and what is not there no longer than that.
    assert clock.now_s == before_s
    assert source.read(0.3) == []
    assert clock.now_s == pytest.approx(before_s + 0.3)
    # Whoever is flooded can still be stopped.
    port.came = packets[0] * 100_000
    assert 1 < len(source.read(0.1)) < 50_000
    source.close()
    source.close()
    assert port.closed == 1
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)


def test_a_port_that_goes_is_told_and_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    source, port, _ = _opened(Clock(monkeypatch, serial_port), "serial:/dev/x?preset=flexitac")
    port.fault = OSError(errno.EIO, "Input/output error")
    with pytest.raises(LostSourceError, match=r"the port is gone \(input/output error\)"):
        source.read(0.1)
    source.close()
    assert port.closed == 1


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOENT, "there is no such port; varishold sources lists"),
        (errno.EACCES, "the port may not be opened by you"),
        (errno.EAGAIN, "the port is in use by another program"),
        (errno.EBUSY, "the port is in use by another program"),
        (errno.EIO, r"the port cannot be opened \(broken\)"),
    ],
)
def test_why_a_port_cannot_be_opened_is_said(number: int, words: str) -> None:
    source: Any = source_at("serial:/dev/x?preset=flexitac")

    def refuse(*_: object, **__: object) -> None:
        raise OSError(number, "Broken")

    source._serial = SimpleNamespace(Serial=refuse)
    with pytest.raises(LostSourceError, match=words):
        source.open()


def test_a_skin_that_wants_to_be_asked_is_asked_at_once_for_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    source, port, _ = _opened(Clock(monkeypatch, serial_port), "serial:/dev/x?preset=weiss-wsg")
    request = framing_of("weiss-wsg").request
    assert [data for data in port.sent if data] == [request]
    (answer,) = frames_sent("weiss-wsg", [{"pad": np.arange(24, dtype="<u2").reshape(6, 4)}])
    for k in range(3):
        # An answer that is cut is put together.
        port.came = answer[:20]
        assert source.read(0.01) == []
        port.came = answer[20:]
        assert len(source.read(0.01)) == 1
        assert [data for data in port.sent if data] == [request] * (k + 2)


# A broker.


class Broker:
    """A broker that does what a test says, and a library that makes clients of it."""

    CallbackAPIVersion = SimpleNamespace(VERSION2=2)

    def __init__(self, clock: Clock, *, says: str = "welcome", after_s: float = 0.0) -> None:
        self._clock, self._says, self._at_s = clock, says, clock.now_s + after_s
        self.topics: list[str] = []
        self.waiting: deque[Any] = deque()
        self.on_connect: Any = None
        self.on_subscribe: Any = None
        self.on_message: Any = None

    def Client(self, version: int) -> Broker:
        return self

    def connect(self, host: str, port: int) -> None:
        assert (host, port) == ("localhost", 1883)

    def subscribe(self, topic: str) -> None:
        self.topics.append(topic)

    def unsubscribe(self, topic: str) -> None:
        """It is a question; nobody waits so long for the answer here."""

    def loop(self, timeout_s: float) -> Any:
        if self._says == "hangs up":
            return SimpleNamespace(name="MQTT_ERR_CONN_LOST")
        if self._says != "welcome" or self._clock.now_s < self._at_s:
            self._clock.sleep(max(timeout_s, 0.001))
        elif not self.topics:
            self.on_connect(self, None, None, SimpleNamespace(is_failure=False), None)
            self.on_subscribe(self, None, 1, [SimpleNamespace(is_failure=False)], None)
        elif self.waiting:
            self.on_message(self, None, self.waiting.popleft())
        else:
            self._clock.sleep(timeout_s)
        return 0

    def put(self, topic: str, payload: bytes, *, retain: bool = False) -> None:
        self.waiting.append(SimpleNamespace(topic=topic, payload=payload, retain=retain))


def _at_broker(monkeypatch: pytest.MonkeyPatch, text: str, **how: Any) -> tuple[Any, Broker, Clock]:
    clock = Clock(monkeypatch, mqtt_topic)
    broker = Broker(clock, **how)
    monkeypatch.setattr(mqtt_topic, "_library", lambda: broker)
    return source_at(text), broker, clock


def test_a_broker_may_take_most_of_a_second_to_welcome(monkeypatch: pytest.MonkeyPatch) -> None:
    source, broker, clock = _at_broker(monkeypatch, "mqtt:///skin", after_s=0.8)
    source.open()
    assert broker.topics == ["skin"]
    assert 0.5 <= broker.connect_timeout <= 1.5  # type: ignore[attr-defined]
    for says in ("nothing", "hangs up"):
        source, _, clock = _at_broker(monkeypatch, "mqtt:///skin", says=says)
        began_s = clock.now_s
        with pytest.raises(LostSourceError, match="what answers is no broker"):
            source.open()
        assert 0.9 <= clock.now_s - began_s <= 1.2 if says == "nothing" else clock.now_s == began_s


def test_what_is_published_is_read_in_its_order_and_under_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    source, broker, clock = _at_broker(monkeypatch, "mqtt:///hand/+")
    source.open()
    broker.put("hand/left", b"[[9, 2], [3, 4]]", retain=True)
    for k in range(300):
        broker.put(f"hand/{('left', 'right/')[k % 2]}", b"[[%d, 2], [3, 4]]" % k)
    came = [source.read(0.05) for _ in range(10)]
    values = [int(pad[0, 0]) for each in came for one in each for pad in one.pads.values()]
    assert values == list(range(300))
    # Whoever is flooded can still be stopped.
    assert 10 <= max(map(len, came)) <= 65
    assert list(source.pads) == ["left", "right"]
    before_s = clock.now_s
    assert source.read(0.1) == []
    assert clock.now_s - before_s == pytest.approx(0.1, abs=0.01)
    broker._says = "hangs up"
    with pytest.raises(LostSourceError, match=r"the broker is gone \(MQTT_ERR_CONN_LOST\)"):
        source.read(0.1)


def test_how_a_web_socket_is_opened_and_the_page_served(monkeypatch: pytest.MonkeyPatch) -> None:
    told: dict[str, Any] = {}

    def nobody(*_: object, **named: Any) -> None:
        told.update(named)
        raise OSError("nobody")

    monkeypatch.setattr(websockets.sync.client, "connect", nobody)
    with pytest.raises(LostSourceError, match="nobody answers"):
        WebSocket("here", "ws://nowhere").open()
    # Opening and closing stay well within the second in which a lost source is told; nothing is compressed or
    # asked behind our back; a frame of 512 x 512 numbers as text is taken.
    assert 0.5 <= told["open_timeout"] <= 1.5
    assert 0.05 <= told["close_timeout"] <= 0.5
    assert (told["compression"], told["proxy"], told["ping_interval"]) == (None, None, None)
    assert 1 << 22 <= told["max_size"] <= 1 << 25
    assert 1 <= told["max_queue"] <= 64
    monkeypatch.setattr(server, "serve", nobody)
    with pytest.raises(InputError, match=r"cannot listen at 127\.0\.0\.1, port 8765: nobody"):
        PageServer(Session(SimpleNamespace(address="a:", pads={}))).__enter__()  # type: ignore[arg-type]
    # A browser that is silent is looked after within some seconds, and saying goodbye holds nobody up.
    assert 5 < told["ping_interval"] < 20
    assert 5 < told["ping_timeout"] < 20
    assert 0.2 < told["close_timeout"] < 1.0
    assert (told["compression"], told["subprotocols"], told["server_header"]) == (None, None, None)
    assert 1024 <= told["max_size"] <= 4096


# Nodes that tell definitions.


def _texts(question: bytes) -> tuple[list[str], int]:
    """Return the texts of a request in CDR, each aligned to four bytes, and the byte behind them."""
    body, at, found = question[4:], 0, []
    for _ in range(2):
        at += -at % 4
        (size,) = struct.unpack_from("<I", body, at)
        found.append(body[at + 4 : at + 4 + size - 1].decode())
        assert body[at + 4 + size - 1] == 0
        at += 4 + size
    assert len(body) == at + 1
    return found, body[at]


@pytest.mark.parametrize("name", ["a/msg/B", "a/msg/Bc", "a/msg/Bcd", "a/msg/Bcde"])
def test_a_definition_is_asked_of_all_nodes_and_the_first_good_answer_taken(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert _texts(zenoh_types._question(name, "RIHS01_0")) == ([name, "RIHS01_0"], 1)
    source = SimpleNamespace(type_name=name, encoding="msg", raw_file_contents="int16 a")
    inner = SimpleNamespace(type_name="x/msg/Y", encoding="msg", raw_file_contents="int8 b")
    idl = SimpleNamespace(type_name=name, encoding="idl", raw_file_contents="no")
    replies = {
        b"refused": SimpleNamespace(successful=False, type_sources=[source]),
        b"other": SimpleNamespace(successful=True, type_sources=[inner, idl]),
        b"good": SimpleNamespace(successful=True, type_sources=[inner, source, idl]),
    }
    monkeypatch.setattr(zenoh_types, "message_decoder", lambda *_: replies.__getitem__)

    class Payload(bytes):
        def to_bytes(self) -> bytes:
            return bytes(self)

    asked: list[tuple[str, Any]] = []

    def session(*contents: bytes | None) -> Any:
        answers = [SimpleNamespace(ok=None if c is None else SimpleNamespace(payload=Payload(c))) for c in contents]
        return SimpleNamespace(get=lambda key, **told: asked.append((key, told)) or answers)

    huge = bytes((1 << 20) + 1)
    told = zenoh_types.asked_definition(session(None, huge, b"refused", b"other", b"good"), 3, name, "RIHS01_0")
    assert told == f"int16 a\n{'=' * 80}\nMSG: x/msg/Y\nint8 b\n"
    key, how = asked[0]
    assert key == "3/**/get_type_description/*/*"
    assert 1 < how["timeout"] < 6
    assert (how["payload"], len(how["attachment"])) == (zenoh_types._question(name, "RIHS01_0"), 33)
    assert zenoh_types.asked_definition(session(b"refused", b"other"), 3, name, "RIHS01_0") == ""
    # Of many that know nothing not all are heard.
    assert zenoh_types.asked_definition(session(*[b"other"] * 200, b"good"), 3, name, "RIHS01_0") == ""


# Files and simulated skins.


@pytest.mark.parametrize("measured", [False, True])
def test_what_goes_round_goes_on_as_if_it_had_no_end(tmp_path: Path, measured: bool) -> None:
    frames, path = np.arange(40.0).reshape(10, 2, 2), tmp_path / ("a.mcap" if measured else "a.npz")
    if measured:
        with sample_file(path, dict) as file:
            for k, frame in enumerate(frames):
                file.add(Sample(5 + k / 50, 1e9 + k / 50, k, {"pad": frame}))
    else:
        varishold.write(Recording({"pad": Pad(frames)}, time_s=5 + np.arange(10) / 50), path)
    coming = samples_of(source_at(f"replay:{path}?speed=0&loop=1"))
    some = [next(coming) for _ in range(700)]
    coming.close()
    device_s = [one.device_time_s for one in some]
    assert device_s[0] == pytest.approx(5.0)
    assert np.diff(np.array(device_s, float)) == pytest.approx(0.02, abs=1e-6)
    assert np.diff([one.host_time_s for one in some]) == pytest.approx(0.02, abs=1e-5)
    assert [float(one.pads["pad"][1, 1]) for one in some] == [4.0 * (k % 10) + 3 for k in range(700)]


def test_a_file_of_one_frame_goes_round_at_its_rate(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.ones((1, 2, 2)))
    coming = samples_of(source_at(f"replay:{tmp_path}/a.npy?speed=0&loop=1&rate_hz=20"))
    some = [next(coming) for _ in range(5)]
    coming.close()
    assert np.diff([one.host_time_s for one in some]) == pytest.approx(0.05, abs=1e-5)
    assert [one.sequence for one in some] == list(range(5))


def test_a_simulated_skin_has_a_clock_of_its_own_that_is_a_little_fast(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch, pace)
    source = source_at("sim:sphere?speed=2&rate_hz=20&duration_s=3.02&pads=3")
    assert list(source.pads) == ["pad1", "pad2", "pad3"]
    with pytest.raises(LostSourceError, match="is not open"):
        source.read(0.0)
    began_s, samples = clock.time(), list(samples_of(source))
    assert [one.sequence for one in samples] == list(range(60))
    device_s = np.array([one.device_time_s for one in samples])
    assert device_s[0] == pytest.approx(12.0)
    assert np.diff(device_s) * 20 - 1 == pytest.approx(40e-6, abs=1e-6)
    # Each comes when it is due, at twice the skin's speed: the first when its time is over.
    host_s = np.array([one.host_time_s for one in samples]) - began_s
    assert host_s == pytest.approx(np.arange(1, 61) / 40, abs=1e-3)
    # Opened anew it begins anew.
    again = list(samples_of(source))
    assert all(np.array_equal(a.pads["pad2"], b.pads["pad2"]) for a, b in zip(samples, again, strict=True))


def test_a_skin_that_is_no_square_is_pressed_by_what_fits_its_shorter_side() -> None:
    skin, deep = SimulatedSkin(SkinTraits(("sphere", "cone"), shape=(8, 40)), rate_hz=0.5, seed=3), []
    for _ in range(200):
        deep.append(skin.press.drawn.depth_m)
        skin.next_frame()
    assert max(deep) < 0.6 * 0.35 * 8 * 2e-3 + 1e-9


def test_values_of_more_dimensions_are_signals_unless_they_are_called_pressure(tmp_path: Path) -> None:
    one = Sample(None, 1e9, 0, {"field": np.ones((2, 2, 3))})
    with sample_file(tmp_path / "a.mcap", dict) as file:
        file.add(one)
        assert (file.tally.samples, file.tally.refused) == (1, 0)
    (played,) = samples_of(source_at(f"replay:{tmp_path}/a.mcap?speed=0"))
    assert played.pads["field"].size == 12
    with sample_file(tmp_path / "b.mcap", lambda: {"field": PadLayout((2, 2, 3))}) as file:
        file.add(one)
        assert (file.tally.samples, file.tally.refused) == (0, 1)
        assert "which is no frame" in file.tally.why


def test_taxels_in_a_row_are_given_their_grid_when_they_are_played(tmp_path: Path) -> None:
    with sample_file(tmp_path / "a.mcap", dict) as file:
        file.add(Sample(None, 1e9, 0, {"pad": np.arange(6.0), "other": np.arange(4.0)}))
    source = source_at(f"replay:{tmp_path}/a.mcap?speed=0&shape=2x3")
    (played,) = samples_of(source)
    assert played.pads["pad"].tolist() == [[0, 1, 2], [3, 4, 5]]
    assert played.pads["other"].size == 4
    assert source.pads["pad"].shape == (2, 3)


def test_each_kind_of_source_has_a_title_and_an_example_of_its_own() -> None:
    for name in KINDS:
        kind = source_kind(name)
        assert parse_address(kind.example).kind in KINDS
        assert source_kind(parse_address(kind.example).kind) is kind
        assert ":" not in kind.title
        assert kind.title[:1].isalpha()


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


# Pads.


@pytest.mark.parametrize("whole", [False, True])
def test_whole_numbers_have_the_noise_of_rounding_at_least(whole: bool) -> None:
    pad = PadWatcher("pad", PadLayout((6, 6)), whole=whole)
    rng = np.random.default_rng(0)
    for k in range(300):
        pad.see(k / 100, 20 + (np.zeros((6, 6)) if whole else rng.normal(0, 1e-3, (6, 6))))
    noise = float(np.median(pad.zero.noise))
    assert noise >= ROUNDING if whole else noise < 0.1 * ROUNDING


def test_readings_stand_upright_whatever_way_they_go() -> None:
    raw = np.array([[10, 20, 30], [40, 50, 60]], np.uint8)

    def upright(layout: PadLayout, sensor: Sensor | None = None) -> list[list[float]]:
        return PadWatcher("pad", layout, sensor=sensor)._upright(raw).tolist()  # type: ignore[no-any-return]

    assert upright(PadLayout((2, 3))) == raw.tolist()
    assert upright(PadLayout((2, 3), polarity="down")) == (-raw.astype(float)).tolist()
    assert upright(PadLayout((2, 3)), Sensor(rest=5.0)) == (raw - 5.0).tolist()
    # A sensor that is known goes before what the source says.
    down = Sensor(polarity="down", rest=70.0, span=70.0)
    assert (
        upright(PadLayout((2, 3)), down) == upright(PadLayout((2, 3), polarity="down"), down) == (70.0 - raw).tolist()
    )


def test_a_pad_is_what_the_source_says_and_the_sensor_fills_in() -> None:
    layout = PadLayout((2, 3), gaps=(5,), broken=(0, 4), unit="kPa")
    bare = PadWatcher("pad", layout)
    assert np.flatnonzero(~bare.field).tolist() == [5]
    assert np.flatnonzero(~bare.sound).tolist() == [0, 4]
    assert (bare.shape, bare.unit, bare.pitch_m) == ((2, 3), "kPa", None)
    sensor = Sensor(pitch_m=(0.003, 0.003))
    given = PadWatcher("pad", layout, sensor=sensor)
    assert (given.unit, given.pitch_m) == ("kPa", (0.003, 0.003))
    told = PadWatcher("pad", PadLayout((2, 3), pitch_m=(0.001, 0.001)), sensor=sensor)
    assert told.pitch_m == (0.001, 0.001)
    # Signals have no sensor of pressure, and taxels on no grid stand in a row.
    signals = PadWatcher("field", PadLayout((6,), "signals", unit="T"), sensor=sensor)
    assert (signals.shape, signals.pitch_m, signals.unit) == ((1, 6), None, "T")


def test_noise_is_asked_for_seldom_and_is_that_of_the_usual_taxel() -> None:
    pad = PadWatcher("pad", PadLayout((2, 3), gaps=(5,)))
    asked: list[int] = []
    sigmas: list[float] = []

    class Zero:
        @property
        def noise(self) -> np.ndarray:
            asked.append(len(sigmas))
            return np.array([[1.0, 2.0, 3.0], [4.0, 90.0, 1e9]]) * (1 + len(sigmas))

    pad.zero = Zero()  # type: ignore[assignment]
    for _ in range(160):
        sigmas.append(pad._sigma())
    assert asked[0] == 0
    assert 8 <= len(asked) <= 12
    assert [sigmas[at] for at in asked] == [3.0 * (1 + at) for at in asked]


# Names.


@pytest.mark.parametrize("refused", [False, True])
def test_what_a_model_says_of_a_press_is_told_with_what_decided(refused: bool) -> None:
    measures = (("max_load", 3.26), ("area", -1.24), ("course", 0.5), ("more", 0.1))
    found = Recognition("cone", 0.9, {"pillar": 0.07}, 0.004, refused, measures, "a.npz: press 3", "cone", "press 7")
    words = named_words(NamedPress(7, 1.0, 2.0, True, found))
    assert (words["when"], words["name"]) == ("Press 7", "none of what was learned" if refused else "cone")
    assert [bar[0] for bar in words["bars"]] == ["cone", "pillar", "all others"]
    assert [bar[1] for bar in words["bars"]] == [0.9, 0.07, pytest.approx(0.03)]
    strange = ["Strange: of known things one in 250 is."] if refused else []
    decided = "Decided by max load +3.3, area -1.2, course +0.5 nats."
    assert words["lines"] == [*strange, decided, "Most like a.npz: press 3 (cone)."]
    line = named_line(NamedPress(7, 1.0, 2.0, True, found))
    assert line == ("press 7: none of what was learned" if refused else "press 7: cone, 90 %".replace(" %", line[-2:]))
    assert named_words(NamedPress(7, 1.0, 2.0, False, found))["when"] == "This press, so far"
    rare = Recognition("cone", 0.9, {}, 0.0, True, measures, "a", "cone", "b")
    assert named_words(NamedPress(0, 0.0, 0.0, True, rare))["lines"][0] == "Strange: of known things one in 1000 is."
    nothing = NamedPress(2, 0.0, 1.0, True, None, "too few frames")
    assert named_words(nothing) == {
        "when": "Press 2",
        "name": "not recognized",
        "bars": [],
        "lines": ["Too few frames."],
    }
    assert named_line(nothing) == "press 2: not recognized"
    assert nothing.to_dict() == {"press": 2, "start_s": 0.0, "end_s": 1.0, "refusal": "too few frames"}
