"""Measures of a corpus: they are those of `measure` on the whole recording."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.corpus_recordings import recording

from varishold.cli.app import app
from varishold.corpus import AskMeasure, run_corpus, survey
from varishold.corpus.columns import FILE
from varishold.levelset import measure
from varishold.recording import Pad, Recording, read, write
from varishold.touch.pad_frames import pad_frames


def plain(value: Any) -> Any:
    return None if isinstance(value, float) and math.isnan(value) else value


def zeroed(recording: Recording) -> Recording:
    """Return a recording with its rest taken off as a whole, frame by frame."""
    pads = {
        name: Pad(np.stack([seen.frame(i) for i in range(recording.n_frames)]), pitch_m=seen.pad.pitch_m)
        for name, seen in pad_frames(recording).items()
    }
    return Recording(pads, recording.time_s)


@settings(max_examples=8)
@given(st.integers(0, 50), st.integers(1, 50), st.sampled_from([{}, {"whole": True, "rest": 100.0}, {"n_pads": 2}]))
def test_rows_are_those_of_the_whole_wherever_it_is_cut(
    tmp_path_factory: pytest.TempPathFactory, seed: int, cut: int, how: dict[str, Any]
) -> None:
    folder = tmp_path_factory.mktemp("cut")
    write(recording(seed, **how), folder / "a.npz")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(survey, "_FRAMES", cut)
        run_corpus([str(folder / "a.npz")], AskMeasure(16), folder / "a.parquet")
    got = pq.read_table(folder / "a.parquet").to_pydict()
    whole = measure(zeroed(read(folder / "a.npz")), levels=16)
    assert len(whole["frame"]) == len(got["frame"]) > 0
    assert set(whole) < set(got)
    for name, column in got.items():
        if name != "file":
            expected = [plain(cell) for cell in whole[name].tolist()] if name in whole else [None] * len(column)
            assert column == expected, name
    # A pad that rests at a hundred is no contact.
    assert max(got["n_taxels"]) < 60
    assert ("area_m2" in whole) == bool(seed % 2)


def test_a_floor_is_kept_to(tmp_path: Path) -> None:
    write(recording(1), tmp_path / "a.npz")
    done = CliRunner().invoke(
        app, ["measure", str(tmp_path / "a.npz"), "-o", str(tmp_path / "a.parquet"), "--floor", "90", "--workers", "1"]
    )
    assert done.exit_code == 0, done.output
    floors = np.array(pq.read_table(tmp_path / "a.parquet")["threshold"])
    assert floors.min() >= 90
    assert done.output == f"{tmp_path / 'a.parquet'}: {len(floors)} contacts in 40 frames of 1 recording\n"


def test_the_page_lists_every_column() -> None:
    page = (Path(__file__).parents[1] / "docs" / "corpora.md").read_text(encoding="utf-8")
    page = page[page.index("## The columns of measures") :]
    for column in (FILE, *AskMeasure().columns):
        assert f"| `{column.name}` | {column.said_as} | {column.meaning} |\n" in page
