"""Names of a corpus: they are those of the command without blocks, wherever a recording is cut and whoever answers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.corpus_recordings import SHAPE, pressed_frames, recording

from varishold.corpus import AskTouch, run_corpus, survey
from varishold.corpus.columns import FILE
from varishold.corpus.opened import Reading
from varishold.corpus.touch_columns import SAID
from varishold.errors import InputError
from varishold.recording import Pad, Recording, read, write
from varishold.sensor import Sensor, Skin, read_sensor, write_sensor
from varishold.touch import recognize_recording


def flat(answer: dict[str, Any]) -> dict[str, Any]:
    """Return an answer as a row, by rules of the tests' own."""
    row = {
        key: value
        for key, value in answer.items()
        if key not in ("alternatives", "position_m", "position_taxels", "size_m", "size_taxels")
        and not key.endswith("_interval_m")
    }
    row["alternatives"] = [{"name": name, "probability": p} for name, p in answer["alternatives"].items()]
    for unit in ("m", "taxels"):
        place, size = answer[f"position_{unit}"] or (None, None), answer[f"size_{unit}"] or (None, None)
        row |= {f"position_x_{unit}": place[0], f"position_y_{unit}": place[1]}
        row |= {f"size_long_{unit}": size[0], f"size_short_{unit}": size[1]}
    nothing = (None, None)
    long, short = answer["size_interval_m"] or (nothing, nothing)
    radius, depth = answer["radius_interval_m"] or nothing, answer["depth_interval_m"] or nothing
    for name, (low, high) in {"size_long": long, "size_short": short, "radius": radius, "depth": depth}.items():
        row |= {f"{name}_low_m": low, f"{name}_high_m": high}
    return row


def plain_rows(path: Path, **how: Any) -> list[dict[str, Any]]:
    """Return the rows that the program gives without blocks."""
    known = how.get("sensor")
    given = {} if known is None else {"polarity": known.polarity}
    answers = recognize_recording(read(path, **given), **{"frames": "all", **how})
    return [flat(json.loads(json.dumps(answer.to_dict()))) for answer in answers]


def table_of(folder: Path, ask: AskTouch, *paths: Path, frames_a_block: int = 4096, **how: Any) -> Path:
    """Write a table of recordings that are cut into small blocks; return it."""
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(survey, "_FRAMES", frames_a_block)
        run_corpus([str(path) for path in paths], ask, folder / "names.parquet", **how)
    return folder / "names.parquet"


def rows_of(table: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = pq.read_table(table).to_pylist()
    return rows


@settings(max_examples=12)
@given(
    st.integers(0, 50),
    st.integers(1, 25),
    st.sampled_from(["all", "press", "peak", "17"]),
    st.sampled_from([{}, {"whole": True, "rest": 100.0}, {"n_pads": 2}, {"rest": 40.0, "drift": 0.3}]),
)
def test_rows_are_those_of_the_whole_wherever_it_is_cut(
    tmp_path_factory: pytest.TempPathFactory, seed: int, cut: int, frames: str, how: dict[str, Any]
) -> None:
    folder = tmp_path_factory.mktemp("cut")
    write(recording(seed, **how), folder / "a.npz")
    rows = rows_of(table_of(folder, AskTouch(frames), folder / "a.npz", frames_a_block=cut))
    assert rows == plain_rows(folder / "a.npz", frames=frames)
    assert len(rows) > 0
    assert {row["file"] for row in rows} == {str(folder / "a.npz")}


def test_a_rest_that_may_drift_is_known_in_blocks_as_in_the_whole(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    drifts = 300.0 + 80.0 * np.sin(np.arange(200) / 33.0)[:, None, None] * rng.uniform(0.8, 1.2, (12, 12))
    write(Recording({"pad": Pad(drifts + rng.normal(0.0, 2.0, drifts.shape))}), tmp_path / "a.npz")
    rows = rows_of(table_of(tmp_path, AskTouch("press"), tmp_path / "a.npz", frames_a_block=50))
    assert rows == plain_rows(tmp_path / "a.npz", frames="press")
    assert any(row["name"] == "plane" for row in rows)


def test_the_same_rows_are_the_same_bytes_however_they_were_cut(tmp_path: Path) -> None:
    for seed in (1, 2):
        write(recording(seed), tmp_path / f"{seed}.npz")
    paths = tmp_path / "1.npz", tmp_path / "2.npz"
    tables = [table_of(tmp_path / str(cut), AskTouch(), *paths, frames_a_block=cut) for cut in (7, 16, 4096)]
    assert len({table.read_bytes() for table in tables}) == 1


@pytest.mark.parametrize("ending", ["npy", "mcap", "h5", "parquet", "mat"])
def test_every_container_gives_the_same_rows(tmp_path: Path, ending: str) -> None:
    made = recording(3, whole=True, rest=50.0)
    if ending == "npy":
        np.save(tmp_path / "a.npy", made.pads["pad"].frames)
    else:
        write(made, tmp_path / f"a.{ending}")
    path = tmp_path / f"a.{ending}"
    assert rows_of(table_of(tmp_path, AskTouch(), path, frames_a_block=9)) == plain_rows(path)


def test_a_recording_that_is_mapped_gives_the_same_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(recording(3, whole=True, rest=50.0), tmp_path / "a.h5")
    expected = plain_rows(tmp_path / "a.h5")
    monkeypatch.setattr("varishold.recording.stored._IN_MEMORY", 0)
    assert rows_of(table_of(tmp_path, AskTouch(), tmp_path / "a.h5", frames_a_block=9)) == expected


def test_frames_below_zero_are_no_matter_where_the_whole_is_not(tmp_path: Path) -> None:
    frames = pressed_frames(5, 60)
    # The rest falls so far that a block of the end is mostly negative.
    frames[45:] = -30 + np.random.default_rng(0).normal(0, 2, frames[45:].shape)
    with pytest.raises(InputError, match="mostly negative"):
        Pad(frames[45:])
    write(Recording({"pad": Pad(frames)}), tmp_path / "a.npz")
    assert rows_of(table_of(tmp_path, AskTouch(), tmp_path / "a.npz", frames_a_block=5)) == plain_rows(
        tmp_path / "a.npz"
    )


@pytest.mark.parametrize("named", [True, False])
def test_a_sensor_is_undone_in_blocks_as_in_the_whole(tmp_path: Path, named: bool) -> None:
    raw = np.rint(250 - pressed_frames(7, 40, height=100.0).clip(0, 200)).astype(np.uint8)
    np.save(tmp_path / "a.npy", raw)
    made = {"rest": 250, "span": 200, "full_scale": 2e5, "unit": "Pa", "pitch_m": 0.002}
    sensor = Sensor(polarity="down", gains=np.full(SHAPE, 1.1), **made)  # type: ignore[arg-type]
    write_sensor(sensor, tmp_path / ("mat.toml" if named else "a.sensor.toml"))
    known = read_sensor(tmp_path / ("mat.toml" if named else "a.sensor.toml"))
    reading = Reading(str(tmp_path / "mat.toml") if named else None)
    table = table_of(tmp_path, AskTouch(), tmp_path / "a.npy", frames_a_block=11, reading=reading)
    rows = rows_of(table)
    assert rows == plain_rows(tmp_path / "a.npy", sensor=known)
    assert rows[0]["force_n"] is not None


def test_a_skin_is_seen_through_in_blocks_as_in_the_whole(tmp_path: Path) -> None:
    write(recording(3, 24), tmp_path / "a.npz")
    skin = Skin("layer", 2e-3, 0.45, 1e-3)
    table = table_of(tmp_path, AskTouch(skin=skin, levels=16), tmp_path / "a.npz", frames_a_block=7)
    assert rows_of(table) == plain_rows(tmp_path / "a.npz", skin=skin, levels=16)


def test_presses_by_their_numbers_come_in_the_order_of_the_numbers(tmp_path: Path) -> None:
    held = recording(1, 60)
    press = np.full(60, -1)
    press[10:20], press[30:40], press[50:58] = 2, 0, 1
    write(Recording(held.pads, held.time_s, press=press), tmp_path / "a.npz")
    rows = rows_of(table_of(tmp_path, AskTouch("press"), tmp_path / "a.npz", frames_a_block=200))
    assert rows == plain_rows(tmp_path / "a.npz", frames="press")
    assert [row["frame"] // 20 for row in rows if row["contact"] == 0] == [1, 2, 0]


def test_every_key_of_an_answer_has_its_column() -> None:
    (answer, *_) = recognize_recording(recording(1), frames="peak")
    told = answer.to_dict()
    assert {said.key for said in SAID} == set(told) - {"file"}
    names = [said.column.name for said in SAID]
    assert len(set(names)) == len(names)
    assert set(flat(told)) - {"file"} == set(names)


def test_what_cannot_be_answered_is_told_before_the_first_block(tmp_path: Path) -> None:
    write(recording(2), tmp_path / "a.npz")
    with pytest.raises(InputError, match=r"a\.npz: there is no frame 99: frames are numbered 0 to 39"):
        table_of(tmp_path, AskTouch("99"), tmp_path / "a.npz")
    with pytest.raises(InputError, match="pitch of pad 'pad' is unknown"):
        table_of(tmp_path, AskTouch(skin=Skin("half-space")), tmp_path / "a.npz")
    assert not any(tmp_path.glob("*.parquet"))
    assert not any(tmp_path.glob(".*.parts"))


def test_the_page_lists_every_column() -> None:
    page = (Path(__file__).parents[1] / "docs" / "corpora.md").read_text(encoding="utf-8")
    for column in (FILE, *(said.column for said in SAID)):
        assert f"| `{column.name}` | {column.said_as} | {column.meaning} |\n" in page
