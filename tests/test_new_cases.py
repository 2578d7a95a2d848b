"""A new case is one file: a toy of each kind is added from outside, by one entry in a registry, and used end to end."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
import pyarrow.parquet
import pytest
from click.testing import CliRunner

import varishold
import varishold.report
from varishold.circuit import Hyperplane, Netlist, Score, Term, writers
from varishold.cli.app import app
from varishold.corpus import Column, run_corpus
from varishold.corpus.ask import Looked
from varishold.exploration import TOUCHES, Felt, PadSurfaces, PoseEstimate, Touch, perceive
from varishold.hand import Bench, HandSetting, grasp_object
from varishold.hand.actions import squeeze
from varishold.perceive import Evidence, Library, Perceiver
from varishold.recording import Pad, Recording, formats, write
from varishold.sensor import SKIN_KINDS, SkinKind
from varishold.skin import PressDraw, Skin, draw_press, press, read_skin, reconstruct
from varishold.skin.media import MEDIA, Winkler
from varishold.solids import SOLIDS, Chance, Drawn, Part, Raised, draw_contact, regular_polygon
from varishold.touch import find_contacts, recognize


@dataclass(frozen=True)
class Barrel(Raised):
    """An upright eight-sided pillar."""

    name: ClassVar[str] = "barrel"
    round: ClassVar[bool] = True

    breadth_m: float
    height_m: float

    @classmethod
    def of_size(cls, size_m: float) -> Self:
        return cls(size_m, 0.16)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        depth_m = chance.depth_m(chance.size_m)
        return cls(chance.size_m, 2 * depth_m).at_random(chance, depth_m, chance.size_m, chance.size_m)

    def true_size_m(self, contact_m: tuple[float, float]) -> tuple[float, float]:
        return self.breadth_m, self.breadth_m

    def rise(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        turns = 2 * np.pi * np.arange(8) / 8
        return (np.max([x * np.cos(t) + y * np.sin(t) for t in turns], axis=0) <= self.breadth_m / 2).astype(float)

    def body(self) -> tuple[Part, ...]:
        corners = regular_polygon(8, self.breadth_m / 2 / np.cos(np.pi / 8), turn_rad=np.pi / 8)
        return (Part.prism(corners, self.height_m),)


def test_a_new_solid_is_drawn_pressed_named_and_gripped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SOLIDS, "barrel", Barrel)
    drawn = draw_contact(np.random.default_rng(1), "barrel", field_m=(0.03, 0.03), size_m=(0.012, 0.012))
    assert drawn.true_size_m == (0.012, 0.012)
    draw = PressDraw(Skin("layer", 4e-3, 0.45, 1e-3), (16, 16), 2e-3, solids=("barrel",), size_taxels=(6, 10))
    pressed = draw_press(np.random.default_rng(2), draw)
    assert (pressed.solid, pressed.name) == ("barrel", "barrel")
    (contact,) = find_contacts(pressed.frame, pitch=2e-3)
    assert recognize(contact).form == "pillar"
    said = CliRunner().invoke(app, ["skin", "press", "barrel", "--size-m", "0.012", "--json"])
    assert said.exit_code == 0
    assert json.loads(said.output)["converged"] is True
    done = grasp_object("barrel", 0.08, seed=1)
    assert done.held
    assert done.name == "barrel"


@dataclass(frozen=True, kw_only=True)
class Hold(Touch):
    """All digits close, and only how many switches do counts."""

    begins: ClassVar[bool] = True
    done = "held it"

    def make(self, bench: Bench, pose: PoseEstimate, setting: HandSetting) -> Felt | None:
        *_, step = squeeze(bench)
        return Felt(self, step)

    def evidence(self, felt: Felt, setting: HandSetting) -> tuple[Evidence, PadSurfaces]:
        return Evidence(self.name, {"hold.closed": float(felt.step.sensed.switches.sum())}), {}

    def felt_in_words(self, felt: Felt, surfaces: PadSurfaces) -> str:
        return f"{int(felt.step.sensed.switches.sum())} switches closed"


def test_a_new_touch_is_made_judged_and_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(TOUCHES, "hold", Hold(name="hold"))
    rng = np.random.default_rng(0)
    library = Library.from_examples(
        {
            name: [[Evidence("hold", {"hold.closed": few + rng.normal()})] for _ in range(5)]
            for name, few in (("wide", 12.0), ("nothing", 0.0))
        }
    )
    perceiver = Perceiver(library, refuse=False)
    done = perceive("cylinder", 0.09, seed=2, perceiver=perceiver, setting=HandSetting(), order=("hold",))
    assert done.perception is not None
    assert done.perception.object == "wide"
    (touch,) = done.touches
    assert touch.evidence.values["hold.closed"] > 4
    page = tmp_path / "page.html"
    varishold.report.write_perceive_report(page, done, setting=HandSetting())
    assert "Held it." in page.read_text()
    assert f"{touch.felt.touch.felt_in_words(touch.felt, {})}." in page.read_text()


def test_a_new_format_is_read(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def read(path: Path, options: formats.Options) -> Recording:
        _, *rows = path.read_text().splitlines()
        frame = np.array([[float(word) for word in row.split(";")] for row in rows])
        return Recording({"pad": Pad(frame[None], pitch_m=options.pitch_m)})

    toy = formats.Format("a toy", (".toy",), lambda path, head: head.startswith(b"TOY"), read)
    monkeypatch.setattr(formats, "FORMATS", {"toy": toy, **formats.FORMATS})
    file = tmp_path / "one.toy"
    file.write_text("TOY\n0;1\n2;3\n")
    assert varishold.read(file).pads["pad"].frames.tolist() == [[[0, 1], [2, 3]]]


def test_a_new_back_end_is_written(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def words(netlist: Netlist, name: str) -> dict[str, str]:
        return {f"{name}.txt": " ".join(netlist.channels)}

    monkeypatch.setitem(writers.WRITERS, "words", words)
    netlist = Netlist(("palm", "tip"), (), (Hyperplane([(0, 1)], 0),), (Term([(0, 1)]),), (Score([], 1),), ("all",))
    (path,) = writers.export(netlist, "words", tmp_path, name="two")
    assert path.read_text() == "palm tip"


@dataclass(frozen=True)
class Foam(Winkler):
    """Springs twice as soft."""

    def compliance(self, k: np.ndarray) -> np.ndarray:
        return 2 * super().compliance(k)


def test_a_new_medium_is_read_pressed_and_seen_through(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(SKIN_KINDS, "foam", SkinKind(needs_poisson=True))
    monkeypatch.setitem(MEDIA, "foam", lambda skin: Foam(skin.thickness_m or 0.0, skin.poisson))
    (tmp_path / "foam.toml").write_text('[skin]\nkind = "foam"\nthickness_m = 0.004\npoisson = 0.3\n')
    soft = read_skin(tmp_path / "foam.toml")
    ball = SOLIDS["sphere"].of_size(0.02)
    pressed, stiffer = (
        press(ball, skin, depth=0.001, shape=(16, 16), pitch_m=0.001)
        for skin in (soft, Skin("winkler", thickness_m=0.004, poisson=0.3))
    )
    np.testing.assert_allclose(2 * pressed.pressure, stiffer.pressure, rtol=1e-6)
    frame = pressed.pressure.reshape(16, pressed.pressure.shape[0] // 16, 16, -1).mean(axis=(1, 3))
    assert reconstruct(frame, soft, pitch=0.001).displacement.max() == pytest.approx(0.001, rel=0.1)
    with pytest.raises(varishold.InputError, match="a skin of kind 'foam' needs thickness_m"):
        Skin("foam")


@dataclass(frozen=True)
class AskTotals:
    """What is each frame's share of the largest total?"""

    title: ClassVar[str] = "totals"
    columns: ClassVar[tuple[Column, ...]] = (Column("frame", "whole", "number"), Column("share", "number", "share"))

    def look(self, whole: Recording, sensor: object) -> Looked:
        return Looked(None, {"most": float(whole.totals().max())}, {})

    def rows(self, block: Recording, first: int, groups: object, looked: Looked, sensor: object) -> dict[str, Any]:
        frames = range(first, first + block.n_frames)
        return {"frame": list(frames), "share": (block.totals() / looked.facts["most"]).tolist()}


def test_a_question_to_a_corpus(tmp_path: Path) -> None:
    write(Recording({"pad": Pad(np.arange(1.0, 6.0)[:, None, None] * np.ones((2, 2)))}), tmp_path / "a.npz")
    run_corpus([str(tmp_path / "a.npz")], AskTotals(), tmp_path / "shares.parquet")
    table = pyarrow.parquet.read_table(tmp_path / "shares.parquet").to_pydict()
    assert table == {"file": [str(tmp_path / "a.npz")] * 5, "frame": [0, 1, 2, 3, 4], "share": [0.2, 0.4, 0.6, 0.8, 1]}
