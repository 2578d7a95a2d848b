"""What docs/live.md shows works as it stands."""

from __future__ import annotations

import json
import re
import tomllib
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from varishold import recognize_recording
from varishold.live import source_at
from varishold.live.address import parse_address
from varishold.live.framing import FRAMINGS, decoder_of, read_framing
from varishold.live.framing.checksums import CHECKSUMS, Checksum
from varishold.live.framing.file import _KEYS
from varishold.live.sources import KINDS, source_kind
from varishold.recording import Pad, Recording, read

DOCS = Path(__file__).parents[1] / "docs"
TEXT = (DOCS / "live.md").read_text(encoding="utf-8")
ADDRESSES = sorted(set(re.findall(rf"(?:{'|'.join(KINDS)}):[^\s`\"|,;)]+", TEXT)))


def test_the_framing_of_ten_lines(tmp_path: Path) -> None:
    block, of_text = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    assert len(block.splitlines()) <= 10
    (tmp_path / "palm.toml").write_text(block)
    frames = np.random.default_rng(0).integers(0, 4096, (5, 8, 8)).astype(np.uint16)
    sent = b""
    for number, frame in enumerate(frames):
        packet = b"\xa5\x5a" + number.to_bytes(2, "big") + frame.astype(">u2").tobytes()
        sent += packet + Checksum("crc16-modbus", endian="big").of(packet)
    readings = decoder_of(read_framing(tmp_path / "palm.toml")).feed(sent)
    assert [reading.sequence for reading in readings] == [0, 1, 2, 3, 4]
    assert np.array_equal([reading.pads["pad"] for reading in readings], frames)
    assert readings[0].pads["pad"].dtype == np.uint16
    # The same as text.
    (tmp_path / "text.toml").write_text(of_text)
    lines = [",".join(map(str, [20 * k, *frame.ravel()])) + "\n" for k, frame in enumerate(frames)]
    readings = decoder_of(read_framing(tmp_path / "text.toml")).feed("".join(lines).encode())
    assert np.array_equal([reading.pads["pad"] for reading in readings], frames)
    assert [reading.device_time_s for reading in readings] == pytest.approx([0.0, 0.02, 0.04, 0.06, 0.08])


def test_the_python_of_zero_and_health_runs(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", (DOCS / "zero.md").read_text(encoding="utf-8"), re.DOTALL):
        exec(compile(block, "docs/zero.md", "exec"), names)
    zero, health = capsys.readouterr().out.splitlines()
    assert zero.startswith("80.0 16 following something presses on each of 16 taxels ((4, 4),")
    assert health == "('taxel (3, 4) never changes its value: stuck',)"


def test_what_sends_without_a_sensor_sends_balls(monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[bytes] = []
    monkeypatch.setattr("time.sleep", lambda s: None)
    monkeypatch.setattr("socket.socket", lambda *kind: SimpleNamespace(sendto=lambda data, to: sent.append(data)))
    (block,) = (each for each in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL) if "sendto" in each)
    exec(compile(block, "send.py", "exec"), {})
    told = [json.loads(each) for each in sent]
    frames = np.array([each["pressure"] for each in told])
    assert frames.shape == (1000, 16, 16)
    assert [each["time_s"] for each in told] == [k / 50 for k in range(1000)]
    recording = Recording({"pad": Pad(frames[:400])}, time_s=np.arange(400) / 50)
    assert [answer.surface.name for answer in recognize_recording(recording, frames="press")] == ["sphere"] * 2


def test_the_python_runs(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mcap", reason="recording needs the extra live")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    for block in blocks:
        if "from varishold.live" in block:
            exec(compile(block, "docs/live.md", "exec"), {})
    stream, watched = capsys.readouterr().out.split("\n", 1)
    assert stream == "(16, 16) 0 ended"
    assert watched.startswith("touched ")
    samples, missed = watched.splitlines()[-1].split()
    assert (read("press.mcap").n_frames, missed) == (int(samples), "0")


@pytest.mark.parametrize("text", ADDRESSES)
def test_an_address_is_one(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text('dtype = "uint8"\nshape = [2, 2]\nhead = "AA"\n')
    (tmp_path / "palm.toml").write_text('dtype = "uint8"\nshape = [2, 2]\nhead = "AA"\n')
    np.save(tmp_path / "press.npz", np.ones((2, 2, 2)))
    (tmp_path / "press.npz").touch()
    address = parse_address(text)
    if re.search(r"\b(PORT|HOST|FILE|FORM|NAME|TOPIC|KEY)\b|^\.+$", address.place):
        pytest.skip("stands for any")
    for module in source_kind(address.kind).needs:
        if find_spec(module) is None:
            pytest.skip(f"needs {module}")
    source = source_at(text)
    assert source.address == text
    source.close()


def test_every_kind_preset_key_and_checksum_is_told() -> None:
    for name in (*FRAMINGS, *CHECKSUMS):
        assert name in TEXT or name.removesuffix("-text") in TEXT, name
    for name in KINDS:
        assert f"{name}:" in TEXT or name == "wss", name
    for key in set(_KEYS) - {"third_party", "notes"}:
        assert re.search(rf"\b{key}\b", TEXT), key


def test_every_preset_has_a_name_and_says_what_it_is() -> None:
    for path in FRAMINGS.values():
        content = tomllib.loads(path.read_text())
        assert content["name"]
        assert content["notes"]
