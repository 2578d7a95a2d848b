"""A collection of grasps: carried on, renewed, refused and spread, with made-up grasps."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.errors import InputError
from varishold.hand import HandDesign, HandSetting, Job, collect_grasps, run_jobs
from varishold.hand.layouts import PAPER_22
from varishold.recording import read_grasp_table

DESIGN = HandDesign()
collecting = importlib.import_module("varishold.hand.collect")


def _row(job: Job, number: int, held: bool) -> dict[str, Any]:
    row: dict[str, Any] = {"object": job.name, "size_m": job.size_m, "seed": job.seed, "step": number, "held": held}
    row |= {"attempts": 1, "finger_scale": 1.0, "searched": 0, "still": 0, "hand": "five-finger"}
    return row | {f"switch.{name}": held for name in PAPER_22.names} | {"angle_rad.x": 0.1, "force_n.y": 0.2}


class Made:
    """Stands for the grasps; some end early."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, early: Sequence[int] = ()) -> None:
        self.jobs: list[Job] = []

        def grasp(name: str, size_m: float, *, seed: int, setting: Any) -> Job:
            self.jobs.append(Job(name, size_m, seed))
            return self.jobs[-1]

        def rows(done: Job, setting: Any, *, steps: Sequence[int]) -> list[dict[str, Any]]:
            return [_row(done, 0, False)] if done.seed in early else [_row(done, step, True) for step in steps]

        monkeypatch.setattr(collecting, "grasp", grasp)
        monkeypatch.setattr(collecting, "grasp_rows", rows)


JOBS = [Job("cylinder", 0.08, seed) for seed in range(5)]


def test_a_collection_is_carried_on_and_keeps_what_was_not_asked_for_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = tmp_path / "t.csv"
    made = Made(monkeypatch, early=(1,))
    collect_grasps(JOBS[:3], path, steps=(2, 5), processes=1)
    assert made.jobs == JOBS[:3]
    made.jobs.clear()
    counts: list[tuple[int, int]] = []
    table = collect_grasps(
        [JOBS[4], JOBS[1], JOBS[4]], path, steps=(2, 5), processes=1, progress=lambda d, w: counts.append((d, w))
    )
    assert made.jobs == [JOBS[4]]
    # What is asked for comes first, what else is there after it.
    assert table.cells["seed"].tolist() == [4, 4, 1, 0, 0, 2, 2]
    assert counts == [(2, 2)]
    assert read_grasp_table(path).cells["seed"].tolist() == table.cells["seed"].tolist()
    made.jobs.clear()
    anew = collect_grasps(JOBS[:1], path, steps=(2, 5), processes=1, anew=True)
    assert made.jobs == JOBS[:1]
    assert len(anew) == 2
    path.write_text("")
    assert len(collect_grasps(JOBS[:1], path, processes=1)) == 1


def test_a_table_is_renewed_every_ten_seconds_and_when_a_run_is_stopped(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    Made(monkeypatch)
    now = [0.0]
    monkeypatch.setattr(collecting.time, "monotonic", lambda: now[0])
    path, lengths = tmp_path / "t.csv", []

    def progress(done: int, wanted: int) -> None:
        lengths.append(len(path.read_text().splitlines()) if path.exists() else 0)
        now[0] += 6.0

    collect_grasps(JOBS, path, processes=1, progress=progress)
    # Saved after the second and the fourth grasp.
    assert lengths == [0, 0, 3, 3, 5]

    def stop(done: int, wanted: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        collect_grasps(JOBS, tmp_path / "u.csv", processes=1, progress=stop)
    assert len(read_grasp_table(tmp_path / "u.csv")) == 1
    # Stopped before anything was made, it leaves nothing.
    monkeypatch.setattr(collecting, "grasp", stop)
    with pytest.raises(TypeError):
        collect_grasps(JOBS, tmp_path / "v.csv", processes=1)
    assert not (tmp_path / "v.csv").exists()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda t: t.replace("finger_scale", "scale"), "has no column 'finger_scale', so that it cannot be carried on"),
        (lambda t: t.replace("step", "stage"), "has no column 'step'"),
        (lambda t: t.replace("cylinder,0.08,1,", "cylinder,0.08,,"), "column 'seed' has an empty cell"),
        (lambda t: t.replace("cylinder,0.08,1,5", "cylinder,0.08,1,4"), r"holds steps \[4\] of cylinder, not \[5\]"),
    ],
)
def test_what_cannot_be_carried_on_is_told(
    change: Any, says: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    Made(monkeypatch)
    path = tmp_path / "t.csv"
    collect_grasps(JOBS[:3], path, processes=1)
    path.write_text(change(path.read_text()))
    with pytest.raises(InputError, match=says):
        collect_grasps(JOBS[:3], path, processes=1)


def test_a_seed_that_no_table_keeps_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="seed must be at most 9007199254740992 in a table, got 9007199254740993"):
        collect_grasps([JOBS[0], Job("cylinder", 0.08, 2**53 + 1)], tmp_path / "t.csv")


def test_lines_of_another_collection_are_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    Made(monkeypatch)
    path = tmp_path / "t.csv"
    collect_grasps(JOBS[:3], path, processes=1)
    with pytest.raises(InputError, match=r"t\.csv: was collected with another still than 1 \(line 2\)"):
        collect_grasps(JOBS[:3], path, setting=HandSetting(still=True), processes=1)
    scaled = replace(HandSetting(), design=DESIGN.scaled(1.1))
    with pytest.raises(InputError, match=r"another finger_scale than 1\.1 \(line 2\)"):
        collect_grasps(JOBS[:3], path, setting=scaled, processes=1)
    lines = path.read_text()
    path.write_text(lines.replace("five-finger", "five-finger@abc", 1))
    with pytest.raises(InputError, match=r"another hand than five-finger \(line 2\)"):
        collect_grasps(JOBS[:3], path, processes=1)
    path.write_text(lines)
    # An early end at whatever step is carried on: those of step 0 and of fewer steps are held by no hand.
    text = path.read_text().splitlines()
    head = text[0].split(",")
    cells = text[3].split(",")
    cells[head.index("step")], cells[head.index("held")] = "3", "0"
    path.write_text("\n".join([*text[:3], ",".join(cells)]) + "\n")
    assert len(collect_grasps(JOBS[:3], path, processes=1)) == 3


@pytest.mark.parametrize(
    ("count", "processes", "told"),
    [
        (3, 8, (1, 1)),
        (4, 8, (4, 1)),
        (100, 2, (2, 12)),
        (1000, 2, (2, 16)),
        (9, 1, (1, 2)),
    ],
)
def test_jobs_are_spread_in_pieces(
    count: int, processes: int, told: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Any] = []

    def spread(work: Any, jobs: Sequence[Job], *, processes: int, chunk: int) -> Any:
        seen.append((processes, chunk))
        return iter(map(work, jobs))

    monkeypatch.setattr(collecting, "spread", spread)
    jobs = [Job("cylinder", 0.08, seed) for seed in range(count)]
    assert list(run_jobs(jobs, lambda job: job.seed, processes=processes)) == list(range(count))
    assert seen == [told]
    assert list(run_jobs(jobs[:2], lambda job: job.seed)) == [0, 1]
    monkeypatch.setattr(collecting.os, "sched_getaffinity", lambda _: {0, 1, 2})
    list(run_jobs([Job("cone", 0.06, k) for k in range(20)], lambda job: job.seed))
    assert seen[-1] == (3, 1)
