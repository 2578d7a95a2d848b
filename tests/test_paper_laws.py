"""Laws of Table 5's bookkeeping on grasps that are known beforehand, and of what the other tables say as data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.hand import TABLE_5_OBJECTS
from varishold.hand.features import FEATURE_GROUPS, Features
from varishold.paper import experiments, paper_table, table5, trials
from varishold.paper.experiments import _restored_b
from varishold.paper.finger_length import finger_length_sweep
from varishold.paper.table5 import Table5, paper_percent, table_5
from varishold.paper.trials import Trial


def outcome(k: int, n: int, training: bool) -> tuple[bool, int]:
    """Whether object k is held in grasp n, and after how many attempts."""
    return training or n >= k % 4, 1 + (n % 2)


@pytest.fixture
def known_grasps(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Let every grasp feel what it is: round or not, but for object 3, whose switches lie."""
    calls: list[dict[str, Any]] = []

    def run_jobs(jobs: Sequence[Any], work: Any, *, processes: int | None = None) -> Iterator[Trial]:
        calls.append({"jobs": jobs, "work": work, "processes": processes})
        for job in jobs:
            k = TABLE_5_OBJECTS.index((job.name, job.size_m))
            block, n = divmod(job.seed - 1_000_000_000, 10_000)
            training = bool(block % 2)
            assert block // 2 % 10 == k
            round_ = job.name == "cylinder"
            felt = Features({"switch.a": round_ != (k == 3 and not training), "switch.b": True}, {})
            held, attempts = outcome(k, n, training)
            yield Trial({group: felt for group in work.groups if group != "surface" or n % 5}, held, attempts)

    monkeypatch.setattr(trials, "run_jobs", run_jobs)
    return calls


def test_every_grasp_is_counted_where_it_belongs(known_grasps: list[dict[str, Any]]) -> None:
    done = []
    made = table_5(
        grasps=7,
        repetitions=3,
        seed=4,
        groups=("contact", "surface"),
        mode="paper",
        finger_scale=0.9,
        search=False,
        processes=1,
        progress=lambda n, of: done.append((n, of)),
    )
    (call,) = known_grasps
    assert call["processes"] == 1
    setting = call["work"].setting
    assert (setting.design.finger_scale, setting.search, setting.pads is not None) == (0.9, False, True)
    jobs = call["jobs"]
    assert len(jobs) == 3 * (10 * 7 + 2 * 10)
    assert len({job.seed for job in jobs}) == len(jobs)
    assert done == [(n + 1, len(jobs)) for n in range(len(jobs))]
    held = np.array([sum(outcome(k, n, False)[0] for n in range(7)) for k in range(10)])
    first = np.array([sum(outcome(k, n, False) == (True, 1) for n in range(7)) for k in range(10)])
    np.testing.assert_array_equal(made.held, np.tile(held, (3, 1)))
    np.testing.assert_array_equal(made.first, np.tile(first, (3, 1)))
    right = np.where(np.arange(10) == 3, 0, held)
    np.testing.assert_array_equal(made.correct[0], np.tile(right, (3, 1)))
    # Who has felt no surface has named none.
    felt = np.array([sum(outcome(k, n, False)[0] for n in range(7) if n % 5) for k in range(10)])
    np.testing.assert_array_equal(made.correct[1], np.tile(np.where(np.arange(10) == 3, 0, felt), (3, 1)))
    assert (made.groups, made.grasps, made.seed, made.mode, made.finger_scale) == (
        ("contact", "surface"),
        7,
        4,
        "paper",
        0.9,
    )
    assert made.total == 21
    rows = list(made.to_dicts())
    for k, row in enumerate(rows[:10]):
        assert row["held_percent"] == pytest.approx(100 * held[k] / 7)
        assert row["first_attempt_percent"] == pytest.approx(100 * first[k] / 7)
        assert row["percent"]["contact"] == pytest.approx(100 * right[k] / 7)
        assert (row["solid"], row["size_m"]) == TABLE_5_OBJECTS[k]
        assert row["paper_percent"] == paper_percent()[k]
        low, high = row["interval_percent"]["contact"]
        assert 0 <= low <= row["percent"]["contact"] <= high <= 100
        assert high - low > 1
    mean = rows[10]
    assert mean["held_percent"] == pytest.approx(100 * held.sum() / 70)
    assert mean["first_attempt_percent"] == pytest.approx(100 * first.sum() / 70)
    assert mean["percent"]["contact"] == pytest.approx(100 * right.sum() / 70)
    assert mean["paper_percent"] == pytest.approx(75.0)
    assert (mean["grasps"], mean["repetitions"], mean["seed"]) == (210, 3, 4)
    assert mean["interval_percent"]["contact"] == pytest.approx([mean["percent"]["contact"]] * 2)
    lines = str(made).splitlines()
    assert lines[1].split()[:11] == ["paper", *(f"{p:.0f}" for p in paper_percent())]
    assert [cell.rstrip("*") for cell in lines[2].split()[1:12]] == [
        *(f"{100 * r / 7:.0f}" for r in right),
        f"{100 * right.sum() / 70:.1f}",
    ]
    assert lines[6].split()[:11] == ["held", *(f"{100 * h / 7:.0f}" for h in held)]
    assert lines[7].startswith(
        "percent right of 21 grasps an object, 3 training sets; mode paper, finger scale 0.9, seed 4"
    )


def test_pads_are_simulated_only_where_a_group_asks_for_them(known_grasps: list[dict[str, Any]]) -> None:
    for groups in (("contact",), ("contact+coordinates",), ("surface",), tuple(FEATURE_GROUPS)):
        made = table_5(grasps=2, repetitions=1, groups=groups)
        assert (known_grasps[-1]["work"].setting.pads is not None) == any("surface" in group for group in groups)
        assert known_grasps[-1]["work"].setting.search
        assert list(made.to_dicts())[10]["interval_percent"] == dict.fromkeys(groups)
    seeds = [{job.seed for job in call["jobs"]} for call in known_grasps]
    assert seeds[0] == seeds[1]
    table_5(grasps=2, repetitions=1, seed=1)
    assert not seeds[0] & {job.seed for job in known_grasps[-1]["jobs"]}


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"grasps": 0}, "grasps and repetitions must be at least 1, got 0 and 2"),
        ({"repetitions": 0}, "grasps and repetitions must be at least 1, got 20 and 0"),
        ({"seed": -1}, "seed must be a whole number from 0 on, got -1"),
        ({"groups": ("contact", "taste")}, "unknown feature group .*taste.*; known are contact"),
        ({"groups": ()}, "unknown feature group"),
    ],
)
def test_an_impossible_experiment_is_refused(values: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        table_5(**values)


def test_a_sweep_is_a_table_for_each_length(known_grasps: list[dict[str, Any]]) -> None:
    done: list[tuple[int, int]] = []
    made = finger_length_sweep(
        (0.8, 1.2), grasps=4, repetitions=1, groups=("contact",), progress=lambda *n: done.append(n)
    )
    wanted = 10 * 4 + 20
    assert done == [(n + 1, 2 * wanted) for n in range(2 * wanted)]
    assert [call["work"].setting.design.finger_scale for call in known_grasps] == [0.8, 1.2]
    assert made.finger_scales == (0.8, 1.2)
    held = sum(outcome(k, n, False)[0] for k in range(10) for n in range(4))
    for row, table in zip(made.to_dicts(), made.tables, strict=True):
        assert row["grasps"] == 40
        assert row["held_percent"] == pytest.approx(100 * held / 40)
        assert row["mean_percent"]["contact"] == table.mean("contact")[0]
        assert row["percent"]["contact"] == table.percent("contact").tolist()
    assert str(made).count("times the usual length") == 2
    assert str(made).index("digits 0.8 times") < str(made).index("digits 1.2 times")
    usual = finger_length_sweep(grasps=1, repetitions=1)
    assert usual.finger_scales == (0.8, 0.9, 1.0, 1.1, 1.2)
    assert usual.tables[0].groups == ("contact", "contact+coordinates")


def test_the_table_agrees_where_no_object_is_below_the_paper(monkeypatch: pytest.MonkeyPatch) -> None:
    held = np.full((2, 10), 20)
    for right, agrees in ((20, True), (10, False)):
        correct = np.stack([np.full((2, 10), right), np.zeros((2, 10), int)])
        ours = Table5(("contact", "surface"), correct, held, held, 20, 3, "auto", 1.0)
        monkeypatch.setattr(table5, "table_5", lambda seed, ours=ours: ours)
        shown = paper_table(5, seed=3)
        assert shown.agrees == agrees
        assert (shown.number, len(shown.rows)) == (5, 11)
        assert str(ours) in str(shown)


def test_a_real_grasp_feels_what_its_groups_ask_for() -> None:
    from varishold.hand import HandSetting
    from varishold.hand.collect import Job

    work = trials._Work(HandSetting(), ("contact", "surface"))
    trial = work(Job("cylinder", 0.07, 5))
    # Without pads nothing is known of surfaces.
    assert list(trial.features) == ["contact"]
    assert trial.attempts >= 1
    assert len(trial.features["contact"].on_off) == 22


# The other tables


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_rows_of_data_are_the_printed_table(number: int) -> None:
    table = paper_table(number)
    assert table.number == number
    assert {row["table"] for row in table.rows} == {number}
    assert table.scanned
    text = str(table)
    for note in table.notes:
        assert note[:30] in text
    if number == 1:
        assert [row["hyperplane"] for row in table.rows] == ["I", "II", "III"]
        for row in table.rows:
            coefficients = np.array(row["coefficients"])
            plus, minus = (coefficients == 0.5).sum(), (coefficients == -0.5).sum()
            assert row["b_computed"] == (plus - minus) / 4
            assert row["can_fire_as_printed"] == (plus / 2 > row["b_printed"])
        assert not table.agrees
    if number == 2:
        assert sum(row["restored"] for row in table.rows) == 5
        assert [row["v"] for row in table.rows if row["restored"]] == [7, 8, 9, 10, 11]
        assert table.agrees
        cylinders = [row["v"] for row in table.rows if row["I"] and not row["III"]]
        assert cylinders == [row["v"] for row in table.rows if row["pattern"] == 1]
        assert {row["II"] for row in table.rows} <= {0, 1}
    if number == 3:
        merged = {(row["I"], row["III"]): row["v"] for row in paper_table(2).rows[::-1]}
        assert {(row["I"], row["III"]): row["v"] for row in table.rows} == merged
        assert table.agrees
    if number == 4:
        row = table.rows[0]
        assert (row["v"], row["pattern"], row["I"], row["III"]) == (1, 2, "*", 1)
        assert table.agrees


@pytest.mark.parametrize(
    ("printed", "computed", "restored", "says"),
    [
        (0.5, 0.5, 0.5, "as printed"),
        (1.25, -1.25, -1.25, "its minus sign is lost; as printed it could never fire"),
        (1.25, -1.75, -1.25, r"one of the 6 coefficients -0\.5 really \+0\.5 \(n\+ = 4, n- = 5\)"),
        (1.0, 0.5, 0.5, "b printed 1, computed 0.5"),
        (1.25, -2.25, -2.25, "b printed 1.25, computed -2.25"),
    ],
)
def test_a_bias_is_restored_where_a_sign_was_lost(printed: float, computed: float, restored: float, says: str) -> None:
    import re

    got, words = _restored_b("II", printed, computed, 3, 6)
    assert got == restored
    assert words.startswith("II: ")
    assert re.search(says, words)


def test_only_equal_columns_can_be_the_lost_one() -> None:
    assert experiments.lost_columns() == [(place, (1, 0)) for place in range(7, 12)]


@pytest.mark.parametrize("repetitions", [1, 2, 5])
def test_the_spread_of_a_mean_is_printed_where_there_is_one(repetitions: int) -> None:
    rng = np.random.default_rng(repetitions)
    correct = rng.integers(5, 21, (1, repetitions, 10))
    held = np.full((repetitions, 10), 20)
    ours = Table5(("contact",), correct, held, held, 20, 0, "auto", 1.0)
    mean, low, high = ours.mean("contact")
    assert mean == pytest.approx(5 * correct.mean())
    cells = str(ours).splitlines()[2].split()
    if repetitions == 1:
        assert np.isnan(low)
        assert cells[-1] == f"{mean:.1f}"
    else:
        assert low < mean < high
        assert cells[-2:] == [f"{mean:.1f}", f"{low:.1f}-{high:.1f}"]
    spans = str(ours).splitlines()[3].split()[2:]
    assert spans == [f"{low:.0f}-{high:.0f}" for low, high in ours.interval("contact")]


def test_the_usual_experiment_is_the_papers(known_grasps: list[dict[str, Any]]) -> None:
    usual = table_5(groups=("contact",), repetitions=1)
    assert (usual.grasps, usual.seed, usual.mode, usual.finger_scale) == (20, 0, "auto", 1.0)
    setting = known_grasps[-1]["work"].setting
    assert (setting.search, setting.design.finger_scale) == (True, 1.0)
    assert known_grasps[-1]["processes"] is None
    swept = finger_length_sweep((1.0,), repetitions=1, groups=("contact",))
    assert swept.tables[0].grasps == 10


def test_a_sign_table_agrees_only_where_table_and_set_do(monkeypatch: pytest.MonkeyPatch) -> None:
    assert paper_table(2).agrees
    with monkeypatch.context() as changed:
        changed.setattr(experiments, "smallest_sets", lambda signs, codes, size: [(0, 1)])
        assert not paper_table(2).agrees
    patterns, signs = experiments.scanned_signs()
    other = signs.copy()
    other[0, 1] ^= True
    monkeypatch.setattr(experiments, "scanned_signs", lambda: (patterns, other))
    assert not paper_table(2).agrees
