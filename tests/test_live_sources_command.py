"""`varishold sources`: what can be watched, what is in reach, what is missing."""

from __future__ import annotations

import json
from importlib.util import find_spec

import pytest
from click.testing import CliRunner

from varishold.cli.app import app
from varishold.live.framing import FRAMINGS
from varishold.live.sources import KINDS


def _run(*words: str) -> str:
    done = CliRunner().invoke(app, ["sources", *words])
    assert done.exit_code == 0, done.output
    return done.output


def test_it_lists_kinds_and_presets() -> None:
    lines = [json.loads(line) for line in _run("--json").splitlines()]
    kinds = [name for line in lines if "kind" in line for name in line["kind"]]
    assert kinds == list(KINDS)
    assert [line["preset"] for line in lines if "preset" in line] == list(FRAMINGS)
    for line in lines:
        if "kind" in line:
            assert line["example"].partition(":")[0] in KINDS
            assert line["title"]
    text = _run()
    for name in FRAMINGS:
        assert name in text


def test_what_is_in_reach_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("serial", reason="needs pyserial")
    from serial.tools.list_ports_common import ListPortInfo

    port = ListPortInfo("/dev/ttyACM7")
    port.description = "Velostat \x1b[31mmat"
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [port])
    assert "serial:/dev/ttyACM7" in _run()
    assert "\x1b" not in _run()
    found = [json.loads(line) for line in _run("--json").splitlines() if '"source"' in line]
    assert {"source": "serial:/dev/ttyACM7", "notes": port.description} in found


def test_what_is_missing_is_told_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "varishold.live.reach.find_spec", lambda module: None if module == "serial" else find_spec(module)
    )
    lines = [line for line in _run().splitlines() if "not installed" in line]
    assert lines == ["  serial: this needs serial, which is not installed; run: pip install -e '.[live]'"]
    kinds = [json.loads(line) for line in _run("--json").splitlines() if '"kind"' in line]
    assert "pip install" in next(line["missing"] for line in kinds if line["kind"] == ["serial"])


def test_a_library_that_cannot_be_used_is_told_and_the_others_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    from varishold.errors import InputError
    from varishold.live import sources

    def broken() -> list[tuple[str, str]]:
        raise InputError("the library cannot be loaded")

    plain = sources.source_kind("sim")
    kind = sources.SourceKind(plain.title, plain.example, plain.make, broken)
    monkeypatch.setattr("varishold.live.reach.KINDS", {"sim": "simulated"})
    monkeypatch.setattr("varishold.live.reach.source_kind", lambda name: kind)
    assert "  sim: the library cannot be loaded" in _run().splitlines()


def test_a_source_whose_library_is_missing_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    from varishold.errors import MissingExtraError
    from varishold.live import source_at

    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(MissingExtraError, match=r"this needs serial, .*\[live\]"):
        source_at("serial:/dev/x?preset=flexitac")
